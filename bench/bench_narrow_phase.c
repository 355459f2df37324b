/* Times the parts of the narrow phase on made-up pairs whose boxes over the motion meet, for
 * motions of several lengths: one pair at a time and eight at a time, for each vector width, in
 * processor time of the same run. Prints CSV: counts after each part, then the least time of the
 * rounds in nanoseconds for each pair that the part is given. Usage: bench_narrow_phase [rounds] */
#define _POSIX_C_SOURCE 200809L /* clock_gettime */
#include "base/hash.h"
#include "detect/impact/impact_pool.h"
#include "detect/impact/narrow_phase.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { PAIR_COUNT = PAIR_BATCH_SIZE, MOST_SURVIVORS = PAIR_COUNT + 8 };

/* Pairs of one kind, each with four records of its own: half a megabyte. */
typedef struct bench_pairs {
    feature_kind kind;
    _Alignas(64) vertex_record records[4 * PAIR_COUNT];
    moving_pair pairs[PAIR_COUNT];
    uint32_t numbers[4 * PAIR_COUNT], vertices[PAIR_COUNT], triangles[3 * PAIR_COUNT];
    pair_tables tables;
    pair_batch batch;
} bench_pairs;

typedef struct part_times {
    double coplanarity, start, rest; /* [s] */
    size_t after_coplanarity, after_start, tested, events;
} part_times;

static double cpu_now(void) {
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static vec3 random_vector(uint64_t *seed) {
    double const x = random_uniform(seed) - 0.5, y = random_uniform(seed) - 0.5;
    return vec3_make(x, y, random_uniform(seed) - 0.5);
}

static bool boxes_meet(feature_kind kind, const moving_pair *pair) {
    int const split = kind == FEATURE_EDGE_EDGE ? 2 : 1;
    for (int axis = 0; axis < 3; axis++) {
        double low[2] = {1e9, 1e9}, high[2] = {-1e9, -1e9};
        for (int k = 0; k < 8; k++) {
            const vec3 *const p = k < 4 ? &pair->start[k] : &pair->end[k - 4];
            double const x = axis == 0 ? p->x : axis == 1 ? p->y : p->z;
            int const side = k % 4 >= split;
            low[side] = x < low[side] ? x : low[side];
            high[side] = x > high[side] ? x : high[side];
        }
        if (low[0] > high[1] || low[1] > high[0]) return false;
    }
    return true;
}

/* Edges of length about 1, moving by `motion`. */
static moving_pair make_pair(feature_kind kind, double motion, uint64_t *seed) {
    moving_pair pair;
    int const split = kind == FEATURE_EDGE_EDGE ? 2 : 1;
    do {
        vec3 const moves[2] = {random_vector(seed), random_vector(seed)};
        vec3 const place = vec3_scale(random_vector(seed), 3.0);
        for (int k = 0; k < 4; k++) {
            vec3 const own = vec3_scale(random_vector(seed), 0.3 * motion);
            pair.start[k] = random_vector(seed);
            if (k >= split) pair.start[k] = vec3_add(pair.start[k], place);
            pair.end[k] =
                vec3_add_scaled(vec3_add(pair.start[k], own), moves[k >= split], 1.5 * motion);
        }
    } while (!boxes_meet(kind, &pair));
    return pair;
}

static void make_pairs(bench_pairs *to, feature_kind kind, double motion) {
    uint64_t seed = 51;
    to->kind = to->batch.kind = kind;
    to->batch.count = PAIR_COUNT;
    for (uint32_t i = 0; i < 4 * PAIR_COUNT; i++) to->numbers[i] = i;
    for (uint32_t i = 0; i < PAIR_COUNT; i++) {
        to->pairs[i] = make_pair(kind, motion, &seed);
        to->vertices[i] = 4 * i;
        for (uint32_t k = 0; k < 3; k++) to->triangles[3 * i + k] = 4 * i + 1 + k;
        for (uint32_t k = 0; k < 4; k++) {
            vec3_store(to->records[4 * i + k].start, 0, to->pairs[i].start[k]);
            vec3_store(to->records[4 * i + k].end, 0, to->pairs[i].end[k]);
        }
        to->batch.first[i] = kind == FEATURE_EDGE_EDGE ? 2 * i : i;
        to->batch.second[i] = kind == FEATURE_EDGE_EDGE ? 2 * i + 1 : i;
    }
    to->tables = (pair_tables){.vertex_features = to->numbers,
                               .edge_features = to->numbers,
                               .triangle_features = to->numbers,
                               .vertex_corners = to->vertices,
                               .edge_corners = to->numbers,
                               .triangle_corners = to->triangles,
                               .records = to->records};
}

static part_times time_single_tests(const bench_pairs *of) {
    static const moving_pair *crossing[PAIR_COUNT], *near[PAIR_COUNT];
    part_times part = {0};
    double const began = cpu_now();
    for (size_t i = 0; i < PAIR_COUNT; i++) {
        crossing[part.after_coplanarity] = &of->pairs[i];
        part.after_coplanarity += !pair_cannot_cross(of->kind, &of->pairs[i]);
    }
    double const filtered = cpu_now();
    for (size_t i = 0; i < part.after_coplanarity; i++) {
        near[part.after_start] = crossing[i];
        part.after_start += prove_apart(of->kind, crossing[i], 0.0) != APART_BY_DIRECTION;
    }
    double const apart = cpu_now();
    part.tested = part.after_start;
    for (size_t i = 0; i < part.after_start; i++)
        part.events += time_of_impact(of->kind, near[i], 0.0).state != TOI_SEPARATED;
    part.coplanarity = filtered - began;
    part.start = apart - filtered;
    part.rest = cpu_now() - apart;
    return part;
}

static part_times time_kernels(const bench_pairs *of) {
    static uint32_t first[MOST_SURVIVORS], second[MOST_SURVIVORS], odd[IMPACT_POOL_SIZE];
    static impact_result results[IMPACT_POOL_SIZE];
    static impact_pool pool;
    part_times part = {0};
    pool.count = pool.filtered_count = 0;
    slot_pairs const pairs = {of->kind, PAIR_COUNT, of->batch.first, of->batch.second, NULL};
    double const began = cpu_now();
    part.after_coplanarity =
        TULLE_PICK_KERNEL(filter_coplanarity)(&of->tables, &pairs, first, second, NULL);
    part.coplanarity = cpu_now() - began;
    double latest = 2.0;
    for (size_t i = 0; i < part.after_coplanarity || pool.count > 0;) {
        size_t const rest = part.after_coplanarity - i, room = IMPACT_POOL_SIZE - pool.count;
        slot_pairs const next = {of->kind, rest < room ? rest : room, first + i, second + i, NULL};
        size_t const before = pool.count;
        double const start = cpu_now();
        TULLE_PICK_KERNEL(begin_impacts)(&of->tables, &next, &pool, odd);
        double const apart = cpu_now();
        i += next.count;
        part.after_start += pool.count - before;
        part.events += TULLE_PICK_KERNEL(advance_impacts)(
            &pool, of->kind, i == part.after_coplanarity, false, &latest, results);
        part.start += apart - start;
        part.rest += cpu_now() - apart;
    }
    part.tested = part.after_start - pool.filtered_count;
    return part;
}

static void keep_least(part_times *least, part_times part, bool is_first) {
    double const coplanarity = least->coplanarity, start = least->start, rest = least->rest;
    *least = part;
    if (is_first) return;
    least->coplanarity = coplanarity < part.coplanarity ? coplanarity : part.coplanarity;
    least->start = start < part.start ? start : part.start;
    least->rest = rest < part.rest ? rest : part.rest;
}

/* Nanoseconds a pair; 0 without pairs. */
static double per_pair(double seconds, size_t count) {
    return count > 0 ? 1e9 * seconds / (double)count : 0.0;
}

static void run_case(const bench_pairs *of, double motion, const char *name, int rounds,
                     double *total) {
    part_times least = {0};
    for (int round = 0; round < rounds; round++)
        keep_least(&least, strcmp(name, "single") ? time_kernels(of) : time_single_tests(of),
                   round == 0);
    double const sum = least.coplanarity + least.start + least.rest;
    if (*total == 0.0) *total = sum;
    printf("%s,%.2f,%s,%d,%zu,%zu,%zu,%zu,%.1f,%.1f,%.1f,%.1f,%.2f\n",
           of->kind == FEATURE_EDGE_EDGE ? "edge_edge" : "vertex_triangle", motion, name,
           PAIR_COUNT, least.after_coplanarity, least.after_start, least.tested, least.events,
           per_pair(least.coplanarity, PAIR_COUNT), per_pair(least.start, least.after_coplanarity),
           per_pair(least.rest, least.after_start), per_pair(sum, PAIR_COUNT), *total / sum);
}

int main(int argument_count, char **arguments) {
    static const char *const target_names[KERNEL_TARGET_COUNT] = {"base", "avx2", "avx512"};
    static const double motions[] = {0.07, 0.3, 1.4, 2.8};
    int const rounds = argument_count > 1 ? atoi(arguments[1]) : 51;
    bench_pairs *const pairs = aligned_alloc(64, (sizeof *pairs + 63) / 64 * 64);
    if (!pairs) return 4;
    printf("kind,motion,how,pairs,after_coplanarity,after_start,tested,events,coplanarity_ns,"
           "start_ns,rest_ns,all_ns,speedup\n");
    for (int kind = 0; kind < 2; kind++)
        for (size_t i = 0; i < sizeof motions / sizeof motions[0]; i++) {
            double total = 0.0;
            make_pairs(pairs, (feature_kind)kind, motions[i]);
            run_case(pairs, motions[i], "single", rounds, &total);
            for (int target = 0; target < KERNEL_TARGET_COUNT; target++)
                if (kernel_target_force((kernel_target)target))
                    run_case(pairs, motions[i], target_names[target], rounds, &total);
        }
    free(pairs);
    return 0;
}
