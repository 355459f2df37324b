/* The kernels of impact tests on random pairs, most of them degenerate, for every vector width: the
 * same bits as pair_cannot_cross, prove_apart and time_of_impact; nothing that touches by
 * exact rational arithmetic is missed, bounds are safe; values that are not finite are never
 * separated. With TULLE_TEST_LONG=1 more pairs. */
#include "base/hash.h"
#include "detect/impact/impact_pool.h"
#include "detect/impact/narrow_phase.h"
#include "math/kernel_target.h"
#include "support/exact_ccd.h"
#include "support/query_families.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { PAIR_COUNT = 1009 }; /* odd, so that the last lanes of batches are empty */

/* Pairs of one kind, each with four records of its own. */
typedef struct lone_pairs {
    moving_pair pairs[PAIR_COUNT];
    double separations[PAIR_COUNT]; /* of the surface of the pair with itself */
    vertex_record records[4 * PAIR_COUNT];
    vertex_point points[4 * PAIR_COUNT]; /* in the coordinates of the records */
    double largest_point;
    uint32_t surfaces[4 * PAIR_COUNT];
    uint32_t numbers[6 * PAIR_COUNT]; /* 0, 1, 2 .. */
    uint32_t vertices[PAIR_COUNT], triangles[3 * PAIR_COUNT];
    double matrix[4]; /* two surfaces: without and with a separation */
    pair_tables tables;
    surface_set set;
} lone_pairs;

static void make_tables(lone_pairs *to) {
    for (uint32_t i = 0; i < 6 * PAIR_COUNT; i++) to->numbers[i] = i;
    for (uint32_t i = 0; i < PAIR_COUNT; i++) {
        to->vertices[i] = 4 * i;
        for (uint32_t k = 0; k < 3; k++) to->triangles[3 * i + k] = 4 * i + 1 + k;
        for (uint32_t k = 0; k < 4; k++) {
            vec3_store(to->records[4 * i + k].start, 0, to->pairs[i].start[k]);
            vec3_store(to->records[4 * i + k].end, 0, to->pairs[i].end[k]);
            to->surfaces[4 * i + k] = to->separations[i] > 0.0;
            for (int c = 0; c < 3; c++) {
                double const start = to->records[4 * i + k].start[c];
                double const end = to->records[4 * i + k].end[c];
                to->points[4 * i + k].start[c] = (float)start;
                to->points[4 * i + k].end[c] = (float)end;
                to->largest_point = fmax(to->largest_point, fmax(fabs(start), fabs(end)));
            }
        }
    }
    to->tables = (pair_tables){.vertex_features = to->numbers,
                               .edge_features = to->numbers,
                               .triangle_features = to->numbers,
                               .vertex_corners = to->vertices,
                               .edge_corners = to->numbers,
                               .triangle_corners = to->triangles,
                               .records = to->records};
    to->set = (surface_set){.surface_count = 2};
}

static void set_points(lone_pairs *to, bool has_points) {
    to->tables.points = has_points ? to->points : NULL;
    to->tables.point_scale = 1.0;
    to->tables.largest_point = to->largest_point;
}

/* Whether an axis or a diagonal keeps more than the separation at both ends. */
static bool has_direction(feature_kind kind, const moving_pair *pair, double separation) {
    static const double directions[7][3] = {{1, 0, 0},  {0, 1, 0},  {0, 0, 1},  {1, 1, 1},
                                            {1, 1, -1}, {1, -1, 1}, {1, -1, -1}};
    int const first_count = kind == FEATURE_VERTEX_TRIANGLE ? 1 : 2;
    for (int d = 0; d < 7; d++) {
        const double *const w = directions[d];
        double low = INFINITY, high = -INFINITY;
        for (int i = 0; i < first_count; i++)
            for (int j = first_count; j < 4; j++)
                for (int end = 0; end < 2; end++) {
                    const vec3 *const at = end ? pair->end : pair->start;
                    vec3 const gap = vec3_sub(at[i], at[j]);
                    double const along = w[0] * gap.x + w[1] * gap.y + w[2] * gap.z;
                    low = fmin(low, along);
                    high = fmax(high, along);
                }
        double const kept = separation * sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
        if (low > kept || high < -kept) return true;
    }
    return false;
}

/* share: part of the pairs that have the separation. */
static void make_lone_pairs(lone_pairs *to, query_family family, feature_kind kind,
                            double separation, double share, uint64_t *seed) {
    memset(to, 0, sizeof *to);
    for (int i = 0; i < PAIR_COUNT; i++) {
        to->pairs[i] = make_query(family, kind, seed);
        to->separations[i] = random_uniform(seed) < share ? separation : 0.0;
    }
    to->matrix[3] = separation;
    make_tables(to);
}

static void run_narrow_phase(lone_pairs *of, narrow_phase *narrow, feature_kind kind,
                             size_t batch_size) {
    narrow_phase_input const input = {
        .set = &of->set, .separations = of->matrix, .vertex_surface = of->surfaces, .threads = 1};
    tulle_status status;
    do {
        assert_int_equal(narrow_phase_start(narrow, &input), TULLE_OK);
        pair_batch batch = {.kind = kind};
        for (uint32_t i = 0; i < PAIR_COUNT; i++) {
            bool const is_edge_edge = kind == FEATURE_EDGE_EDGE;
            bool const swaps = is_edge_edge && i % 2;
            batch.first[batch.count] = is_edge_edge ? 2 * i + swaps : i;
            batch.second[batch.count++] = is_edge_edge ? 2 * i + !swaps : i;
            if (batch.count < batch_size && i + 1 < PAIR_COUNT) continue;
            consume_pairs(narrow, &of->tables, &batch, 0);
            batch.count = 0;
        }
        narrow_phase_flush(narrow, &of->tables, 0);
    } while (!narrow_phase_finish(narrow, &status));
}

static uint64_t make_key(feature_kind kind, uint64_t i) {
    return kind == FEATURE_EDGE_EDGE ? (2 * i) << 32 | (2 * i + 1) : i << 32 | i;
}

/* Walks pairs and events beside each other. Where there are points, pairs that a direction keeps
 * apart may be left out. Returns the number of pairs that were shown apart by any filter. */
static size_t check_against_single_tests(const lone_pairs *of, const narrow_phase *narrow,
                                         feature_kind kind) {
    size_t at = 0, event_count, filtered_count = 0;
    const raw_event *const events = narrow_phase_get_events(narrow, &event_count);
    for (size_t i = 0; i < PAIR_COUNT; i++) {
        const moving_pair *const pair = &of->pairs[i];
        double const separation = of->separations[i];
        if ((separation == 0.0 && pair_cannot_cross(kind, pair)) ||
            prove_apart(kind, pair, separation) == APART_BY_DIRECTION) {
            filtered_count++;
            continue;
        }
        toi_result const result = time_of_impact(kind, pair, separation);
        if (result.state == TOI_SEPARATED) continue;
        if (at == event_count || events[at].key != make_key(kind, i)) {
            assert_non_null(of->tables.points);
            assert_true(has_direction(kind, pair, separation));
            continue;
        }
        const raw_event *const event = &events[at++];
        assert_int_equal(event->kind, kind);
        assert_int_equal(event->state, result.state);
        assert_memory_equal(&event->time, &result.lower_bound, sizeof(double));
    }
    assert_int_equal(at, event_count);
    narrow_phase_counts const counts = narrow_phase_get_counts(narrow);
    if (of->tables.points)
        assert_true(counts.filtered_count >= filtered_count);
    else
        assert_int_equal(counts.filtered_count, filtered_count);
    assert_int_equal(counts.candidate_count, PAIR_COUNT);
    return (size_t)counts.filtered_count;
}

static void check_targets(lone_pairs *of, narrow_phase *narrow, feature_kind kind) {
    static const size_t batch_sizes[] = {PAIR_BATCH_SIZE, 333, 13};
    kernel_target const widest = kernel_target_get();
    size_t filtered[2] = {0, 0}; /* without points, with them */
    for (int target = 0; target < KERNEL_TARGET_COUNT; target++) {
        if (!kernel_target_force((kernel_target)target)) continue;
        for (int has_points = 0; has_points < 2; has_points++) {
            set_points(of, has_points == 1);
            run_narrow_phase(of, narrow, kind, batch_sizes[target]);
            size_t const count = check_against_single_tests(of, narrow, kind);
            if (target > 0) assert_int_equal(count, filtered[has_points]);
            filtered[has_points] = count;
        }
    }
    set_points(of, true);
    assert_true(kernel_target_force(widest));
}

static void kernels_match_single_tests(void **state) {
    (void)state;
    memory heap = memory_default();
    narrow_phase *narrow;
    assert_int_equal(narrow_phase_create(&heap, &narrow), TULLE_OK);
    static lone_pairs soup;
    uint64_t seed = 41;
    int const rounds = getenv("TULLE_TEST_LONG") ? 200 : 4;
    for (int round = 0; round < rounds; round++)
        for (int family = 0; family < QUERY_FAMILY_COUNT; family++)
            for (int kind = 0; kind < 2; kind++) {
                double const separation = pow(10.0, -1.0 - 8.0 * random_uniform(&seed));
                double const share = round % 4 == 0 ? 0.0 : round % 4 == 1 ? 1.0 : 0.5;
                make_lone_pairs(&soup, (query_family)family, (feature_kind)kind, separation, share,
                                &seed);
                check_targets(&soup, narrow, (feature_kind)kind);
            }
    narrow_phase_destroy(narrow);
    assert_int_equal(heap.bytes_held, 0);
}

/* Pairs that directions leave out have one that keeps them apart, and all targets leave out the
 * same. Where coordinates are too large for floats, or far larger than the pairs, none is. */
static void directions_are_proofs(void **state) {
    (void)state;
    static lone_pairs soup;
    static uint32_t first[PAIR_COUNT + 16], second[PAIR_COUNT + 16];
    static uint32_t kept_first[KERNEL_TARGET_COUNT][PAIR_COUNT + 16];
    static uint32_t kept_second[KERNEL_TARGET_COUNT][PAIR_COUNT + 16];
    kernel_target const widest = kernel_target_get();
    uint64_t seed = 44;
    size_t left_out = 0;
    for (int family = 0; family < QUERY_FAMILY_COUNT; family++)
        for (int kind = 0; kind < 2; kind++) {
            make_lone_pairs(&soup, (query_family)family, (feature_kind)kind, 0.0, 0.0, &seed);
            set_points(&soup, true);
            bool const is_edge_edge = kind == FEATURE_EDGE_EDGE;
            for (uint32_t i = 0; i < PAIR_COUNT; i++) {
                first[i] = is_edge_edge ? 2 * i : i;
                second[i] = is_edge_edge ? 2 * i + 1 : i;
            }
            slot_pairs const pairs = {(feature_kind)kind, PAIR_COUNT, first, second, NULL};
            float const limit = (float)(0x1.0p-17 * soup.largest_point);
            size_t counts[KERNEL_TARGET_COUNT] = {0}, last = 0;
            for (int target = 0; target < KERNEL_TARGET_COUNT; target++) {
                if (!kernel_target_force((kernel_target)target)) continue;
                counts[target] = TULLE_PICK_KERNEL(filter_directions)(
                    &soup.tables, &pairs, limit, kept_first[target], kept_second[target]);
                assert_int_equal(counts[target], counts[0]);
                assert_memory_equal(kept_first[target], kept_first[0],
                                    counts[0] * sizeof **kept_first);
                assert_memory_equal(kept_second[target], kept_second[0],
                                    counts[0] * sizeof **kept_second);
            }
            for (uint32_t i = 0; i < PAIR_COUNT; i++) {
                bool const is_kept = last < counts[0] && kept_first[0][last] == first[i];
                if (is_kept) assert_int_equal(kept_second[0][last], second[i]);
                last += is_kept;
                left_out += !is_kept;
                if (!is_kept) assert_true(has_direction((feature_kind)kind, &soup.pairs[i], 0.0));
            }
            assert_int_equal(last, counts[0]);
            assert_int_equal(TULLE_PICK_KERNEL(filter_directions)(&soup.tables, &pairs, INFINITY,
                                                                  kept_first[0], kept_second[0]),
                             PAIR_COUNT);
        }
    assert_true(kernel_target_force(widest));
    printf("%zu pairs left out by directions\n", left_out);
    assert_true(left_out > PAIR_COUNT);
}

/* Of the pairs that touch none is missed; no bound reaches the touch. */
static void nothing_that_touches_is_missed(void **state) {
    (void)state;
    memory heap = memory_default();
    narrow_phase *narrow;
    assert_int_equal(narrow_phase_create(&heap, &narrow), TULLE_OK);
    static lone_pairs soup;
    uint64_t seed = 42;
    int touching = 0, false_alarms = 0, passed = 0;
    for (int family = 0; family < QUERY_FAMILY_COUNT; family++)
        for (int kind = 0; kind < 2; kind++) {
            make_lone_pairs(&soup, (query_family)family, (feature_kind)kind, 0.0, 0.0, &seed);
            set_points(&soup, true);
            run_narrow_phase(&soup, narrow, (feature_kind)kind, 100);
            size_t event_count;
            const raw_event *event = narrow_phase_get_events(narrow, &event_count);
            const raw_event *const end = event + event_count;
            passed += (int)narrow_phase_get_counts(narrow).tested_count;
            for (size_t i = 0; i < PAIR_COUNT; i++) {
                bool const touches = exact_pair_touches((feature_kind)kind, &soup.pairs[i], 1.0);
                bool const is_event = event < end && event->key == make_key((feature_kind)kind, i);
                assert_true(is_event || !touches);
                if (touches && event->time > 0.0)
                    assert_false(
                        exact_pair_touches((feature_kind)kind, &soup.pairs[i], event->time));
                touching += touches;
                false_alarms += is_event && !touches;
                event += is_event;
            }
        }
    print_message("%d pairs, %d passed the filters, %d touch, %d false alarms\n",
                  2 * PAIR_COUNT * QUERY_FAMILY_COUNT, passed, touching, false_alarms);
    assert_true(touching > 1000);
    narrow_phase_destroy(narrow);
}

static void separations_are_kept(void **state) {
    (void)state;
    memory heap = memory_default();
    narrow_phase *narrow;
    assert_int_equal(narrow_phase_create(&heap, &narrow), TULLE_OK);
    static lone_pairs soup;
    uint64_t seed = 43;
    for (int family = 0; family < QUERY_FAMILY_COUNT; family++)
        for (int kind = 0; kind < 2; kind++) {
            double const separation = pow(10.0, -1.0 - 6.0 * random_uniform(&seed));
            make_lone_pairs(&soup, (query_family)family, (feature_kind)kind, separation, 1.0,
                            &seed);
            run_narrow_phase(&soup, narrow, (feature_kind)kind, 500);
            size_t event_count;
            const raw_event *event = narrow_phase_get_events(narrow, &event_count);
            const raw_event *const end = event + event_count;
            for (size_t i = 0; i < PAIR_COUNT; i++) {
                bool const is_event = event < end && event->key == make_key((feature_kind)kind, i);
                double const bound = is_event ? event->time : 1.0;
                for (int k = 0; k < 4 && bound > 0.0; k++)
                    assert_true(exact_pair_is_farther(
                        (feature_kind)kind, &soup.pairs[i],
                        k == 0 ? bound : bound * random_uniform(&seed), separation));
                event += is_event;
            }
        }
    narrow_phase_destroy(narrow);
}

static void values_that_are_not_finite_are_events(void **state) {
    (void)state;
    memory heap = memory_default();
    narrow_phase *narrow;
    assert_int_equal(narrow_phase_create(&heap, &narrow), TULLE_OK);
    static lone_pairs soup;
    uint64_t seed = 44;
    const double bad[] = {(double)NAN, (double)INFINITY, -(double)INFINITY};
    for (int variant = 0; variant < 4; variant++) {
        feature_kind const kind = (feature_kind)(variant % 2);
        make_lone_pairs(&soup, QUERY_SLOW, kind, 1e-3, variant / 2, &seed);
        for (int i = 0; i < PAIR_COUNT; i += 3) {
            vec3 *const point = i % 2 ? &soup.pairs[i].start[i % 4] : &soup.pairs[i].end[i % 4];
            double *const component[3] = {&point->x, &point->y, &point->z};
            *component[i / 3 % 3] = bad[i / 9 % 3];
        }
        make_tables(&soup);
        check_targets(&soup, narrow, kind);
        size_t event_count, found = 0;
        const raw_event *const events = narrow_phase_get_events(narrow, &event_count);
        for (size_t i = 0; i < event_count; i++) {
            if ((events[i].key & UINT32_MAX) / (kind == FEATURE_EDGE_EDGE ? 2 : 1) % 3) continue;
            found++;
            assert_int_equal(events[i].state, TOI_TOUCHING_AT_START);
        }
        assert_int_equal(found, (PAIR_COUNT + 2) / 3);
    }
    narrow_phase_destroy(narrow);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(kernels_match_single_tests),
        cmocka_unit_test(directions_are_proofs),
        cmocka_unit_test(nothing_that_touches_is_missed),
        cmocka_unit_test(separations_are_kept),
        cmocka_unit_test(values_that_are_not_finite_are_events),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
