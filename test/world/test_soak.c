/* A live scene that runs on and on: no state crosses, memory does not grow, a step does not get
 * dearer, and a saved state goes on to the same bits, in this world and in another. A few seconds
 * of it here; `make soak MINUTES=120` runs it for hours and prints what it measures. */
#define _POSIX_C_SOURCE 200809L
#include "base/timer.h"
#include "support/soak_scene.h"

#include <inttypes.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include <cmocka.h>

enum {
    QUICK_CYCLES = 2,
    JUDGED_EVERY = 16,          /* steps */
    SAVED_EVERY = 50,           /* cycles; each in the quick form */
    STEPS_AFTER_LOAD = 4,       /* with which states are compared */
    MOST_CYCLES_A_MINUTE = 400, /* for which there are keyframes; then the run is over */
    LEAST_CYCLES_JUDGED = 40    /* fewer say nothing about drift */
};
/* Buffers grow when a step has more contacts than any before, ever more seldom. No block of memory
 * may come that is not given back. */
static const double MOST_HELD_GROWTH = 0.05;
enum { MOST_NEW_BLOCKS = 4, MOST_NEW_RESIDENT = 1 << 20 };
/* What a step does may differ from quarter to quarter by chance alone: by four standard errors, and
 * this share, since cycles follow from one another and are no independent draws. */
static const double MOST_DRIFT = 0.03;
/* Of the time of the fastest cycles, which other programs on the machine disturb least. */
static const double MOST_SLOWER = 0.1, FASTEST_SHARE = 0.05;

/* The world's heap, counted. */
typedef struct counted_heap {
    size_t bytes_held, blocks_held;
} counted_heap;

static void *count_allocate(void *context, size_t byte_count) {
    counted_heap *const heap = context;
    heap->bytes_held += byte_count;
    heap->blocks_held++;
    return malloc(byte_count);
}

static void count_release(void *context, void *pointer, size_t byte_count) {
    counted_heap *const heap = context;
    if (!pointer) return;
    heap->bytes_held -= byte_count;
    heap->blocks_held--;
    free(pointer);
}

/* What is measured of each cycle: means over its steps, then memory at its end. */
typedef enum figure {
    CONTACTS,
    TESTED_PAIRS,
    BOX_PAIRS,
    ITERATIONS,
    SEARCHES,
    SUBSTEPS,
    COUNT_FIGURES, /* all before are counts, which the machine does not disturb */
    MILLISECONDS = COUNT_FIGURES,
    HELD,
    BLOCKS,
    RESIDENT,
    FIGURE_COUNT
} figure;
static const char *const figure_names[FIGURE_COUNT] = {
    "contacts", "tested pairs", "box pairs", "iterations", "searches",
    "substeps", "milliseconds", "held",      "blocks",     "resident"};

typedef struct cycle {
    double figures[FIGURE_COUNT];
} cycle;

typedef struct soak {
    soak_scene scene;
    counted_heap heap, other_heap;
    tulle_world *world;
    cycle *cycles;
    size_t cycle_count, cycle_limit;
    uint64_t judged, saved, largest_substeps, rescues, pinched;
} soak;

static double get_minutes(void) {
    const char *const minutes = getenv("TULLE_SOAK_MINUTES");
    return minutes ? strtod(minutes, NULL) : 0.0;
}

/* [bytes] 0 where the system does not tell. */
static double measure_resident(void) {
    FILE *const file = fopen("/proc/self/statm", "r");
    unsigned long all = 0, resident = 0;
    if (!file) return 0.0;
    if (fscanf(file, "%lu %lu", &all, &resident) != 2) resident = 0;
    fclose(file);
    return (double)resident * (double)sysconf(_SC_PAGESIZE);
}

static double now_processor(void) {
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static tulle_step_report advance(tulle_world *world) {
    tulle_step_report report;
    tulle_error error = {0};
    soak_scene_push(world);
    if (tulle_world_step(world, SOAK_STEP, &report, &error) != TULLE_OK)
        fail_msg("after %.6f s: %s", tulle_world_get_time(world), error.message);
    return report;
}

static void run_cycle(soak *own) {
    cycle *const sums = &own->cycles[own->cycle_count++];
    *sums = (cycle){0};
    for (int i = 0; i < SOAK_STEPS_PER_CYCLE; i++) {
        double const start = now_processor();
        tulle_step_report const report = advance(own->world);
        sums->figures[MILLISECONDS] += 1e3 * (now_processor() - start);
        sums->figures[CONTACTS] += (double)report.contacts;
        sums->figures[TESTED_PAIRS] += (double)report.tested_pairs;
        sums->figures[BOX_PAIRS] += (double)report.box_pairs;
        sums->figures[ITERATIONS] += report.cg_iterations;
        sums->figures[SEARCHES] += report.pair_searches;
        sums->figures[SUBSTEPS] += report.substeps;
        if (report.substeps > own->largest_substeps) own->largest_substeps = report.substeps;
        own->rescues += report.rescue_impact_zones + report.rescue_component_scalings +
                        report.rescue_global_scalings;
        own->pinched += report.pinched != 0;
        if (i % JUDGED_EVERY != 0) continue;
        own->judged++;
        size_t const crossings = soak_scene_judge(&own->scene, own->world);
        if (crossings > 0)
            fail_msg("%zu pairs cross after %.6f s", crossings, tulle_world_get_time(own->world));
    }
    for (int k = 0; k < HELD; k++) sums->figures[k] /= SOAK_STEPS_PER_CYCLE;
    sums->figures[HELD] = (double)own->heap.bytes_held;
    sums->figures[BLOCKS] = (double)own->heap.blocks_held;
    sums->figures[RESIDENT] = measure_resident();
}

static uint64_t run_on(tulle_world *world) {
    for (int i = 0; i < STEPS_AFTER_LOAD; i++) (void)advance(world);
    return tulle_world_get_state_hash(world);
}

static void load(tulle_world *world, const void *bytes, size_t byte_count, uint64_t hash) {
    tulle_error error = {0};
    if (tulle_world_load_state(world, bytes, byte_count, &error) != TULLE_OK)
        fail_msg("%s", error.message);
    assert_true(tulle_world_get_state_hash(world) == hash);
}

/* A saved state goes on to the same bits in a new world, and again in the one that saved it. */
static void save_and_load(soak *own) {
    void *bytes = NULL;
    size_t byte_count = 0;
    tulle_error error = {0};
    uint64_t const hash = tulle_world_get_state_hash(own->world);
    if (tulle_world_save_state(own->world, &bytes, &byte_count, &error) != TULLE_OK)
        fail_msg("%s", error.message);
    uint64_t const later = run_on(own->world);
    assert_true(later != hash);
    tulle_allocator const allocator = {count_allocate, count_release, &own->other_heap, 0};
    tulle_world *const other = soak_scene_build(&own->scene, &allocator);
    load(other, bytes, byte_count, hash);
    assert_true(run_on(other) == later);
    tulle_world_destroy(other);
    assert_int_equal(own->other_heap.bytes_held, 0);
    load(own->world, bytes, byte_count, hash);
    assert_true(run_on(own->world) == later);
    load(own->world, bytes, byte_count, hash);
    tulle_world_free_state(own->world, bytes, byte_count);
    own->saved++;
}

/* Mean of a figure over cycles [begin, end), and the square of its standard error. */
static double measure_mean(const soak *own, figure which, size_t begin, size_t end,
                           double *variance) {
    double sum = 0.0, squares = 0.0, count = (double)(end - begin);
    for (size_t i = begin; i < end; i++) sum += own->cycles[i].figures[which];
    for (size_t i = begin; i < end; i++)
        squares += pow(own->cycles[i].figures[which] - sum / count, 2.0);
    *variance = squares / count / (count - 1.0);
    return sum / count;
}

static int compare_doubles(const void *first, const void *second) {
    const double *const a = first, *const b = second;
    return *a < *b ? -1 : *a > *b;
}

/* The time below which FASTEST_SHARE of the cycles lie. */
static double measure_fast(const soak *own, size_t begin, size_t end) {
    double *const times = malloc((end - begin) * sizeof *times);
    assert_non_null(times);
    for (size_t i = begin; i < end; i++) times[i - begin] = own->cycles[i].figures[MILLISECONDS];
    qsort(times, end - begin, sizeof *times, compare_doubles);
    double const fast = times[(size_t)(FASTEST_SHARE * (double)(end - begin))];
    free(times);
    return fast;
}

/* Growth of memory since the end of the first quarter. */
static bool check_memory(const soak *own) {
    const cycle *const early = &own->cycles[own->cycle_count / 4];
    const cycle *const late = &own->cycles[own->cycle_count - 1];
    double growth[FIGURE_COUNT] = {0};
    for (int k = HELD; k < FIGURE_COUNT; k++) {
        growth[k] = late->figures[k] - early->figures[k];
        print_message("%-13s %12.0f, then %12.0f\n", figure_names[k], early->figures[k],
                      late->figures[k]);
    }
    return growth[HELD] <= MOST_HELD_GROWTH * early->figures[HELD] &&
           growth[BLOCKS] <= MOST_NEW_BLOCKS &&
           growth[RESIDENT] <= fmax(growth[HELD], 0.0) + MOST_NEW_RESIDENT;
}

/* The second quarter beside the last one. */
static bool check_drift(const soak *own) {
    size_t const quarter = own->cycle_count / 4, last = own->cycle_count - quarter;
    bool is_fine = true;
    for (figure k = 0; k < HELD; k++) {
        double variances[2];
        double const early = measure_mean(own, k, quarter, 2 * quarter, &variances[0]);
        double const late = measure_mean(own, k, last, own->cycle_count, &variances[1]);
        double const most = MOST_DRIFT * early + 4.0 * sqrt(variances[0] + variances[1]);
        print_message("%-13s %12.3f, then %12.3f: %+.2f %%, of %.2f %% allowed\n", figure_names[k],
                      early, late, 100.0 * (late / early - 1.0), 100.0 * most / early);
        is_fine &= k >= COUNT_FIGURES || fabs(late - early) <= most;
    }
    double const early = measure_fast(own, quarter, 2 * quarter);
    double const late = measure_fast(own, last, own->cycle_count);
    print_message("%-13s %12.3f, then %12.3f: %+.2f %%, of %.2f %% allowed\n", "fast cycles", early,
                  late, 100.0 * (late / early - 1.0), 100.0 * MOST_SLOWER);
    return is_fine && late <= (1.0 + MOST_SLOWER) * early;
}

static void print_progress(const soak *own, double seconds) {
    const cycle *const last = &own->cycles[own->cycle_count - 1];
    print_message("%7.1f min, %8.0f s of the scene, %" PRIu64 " states judged, %" PRIu64 " saved:",
                  seconds / 60.0, tulle_world_get_time(own->world), own->judged, own->saved);
    for (int k = 0; k < FIGURE_COUNT; k++)
        print_message(" %s %.6g", figure_names[k], last->figures[k]);
    print_message("\n");
    fflush(stdout);
}

static void a_live_scene_runs_on(void **state) {
    (void)state;
    double const minutes = get_minutes(), begin = timer_now();
    bool const is_long = minutes > 0.0;
    soak own = {.cycle_limit =
                    is_long ? 1 + (size_t)(MOST_CYCLES_A_MINUTE * minutes) : QUICK_CYCLES};
    /* every cycle runs a few steps on when its state is saved */
    own.scene = soak_scene_make(own.cycle_limit + 1);
    own.cycles = malloc(own.cycle_limit * sizeof *own.cycles);
    assert_non_null(own.cycles);
    /* touched now, so that its pages do not count as growth later */
    memset(own.cycles, 0xff, own.cycle_limit * sizeof *own.cycles);
    tulle_allocator const allocator = {count_allocate, count_release, &own.heap, 0};
    own.world = soak_scene_build(&own.scene, &allocator);
    for (double next = 60.0; own.cycle_count < own.cycle_limit;) {
        run_cycle(&own);
        if (!is_long || own.cycle_count % SAVED_EVERY == 0) save_and_load(&own);
        double const passed = timer_now() - begin;
        if (is_long && passed > 60.0 * minutes) break;
        if (is_long && passed > next) print_progress(&own, passed), next += 60.0;
    }
    print_progress(&own, timer_now() - begin);
    print_message("at most %" PRIu64 " substeps a step, %" PRIu64 " rescues, %" PRIu64
                  " pinched steps, no crossing\n",
                  own.largest_substeps, own.rescues, own.pinched);
    assert_true(own.cycles[own.cycle_count - 1].figures[CONTACTS] > 10.0);
    if (own.cycle_count >= LEAST_CYCLES_JUDGED) {
        bool const is_small = check_memory(&own), is_steady = check_drift(&own);
        assert_true(is_small);
        assert_true(is_steady);
    }
    tulle_world_destroy(own.world);
    assert_int_equal(own.heap.bytes_held, 0);
    assert_int_equal(own.heap.blocks_held, 0);
    soak_scene_destroy(&own.scene);
    free(own.cycles);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_live_scene_runs_on)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
