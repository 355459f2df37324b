/* Tests of the pairs that start near find the same hits, at the same times, and the same smallest
 * gap as tests of all pairs, in whatever order; along short paths they look at few. */
#include "base/hash.h"
#include "contact/pairs/near_pairs.h"
#include "contact/pairs/path_test.h"
#include "support/contact_world.h"
#include "support/test_support.h"

#include <string.h>

#define TIME_STEP (1.0 / 90.0)

/* Each vertex by up to `way` [m] a component; obstacles by up to `obstacle_way`, together. */
static void move_by_chance(contact_world *world, double way, double obstacle_way,
                           uint64_t *random) {
    double const shift = obstacle_way * (2.0 * random_uniform(random) - 1.0);
    for (size_t i = 0; i < 3 * world->vertex_count; i++) {
        bool const is_cloth = i < 3 * world->cloth_vertex_count;
        double const step = is_cloth ? way * (2.0 * random_uniform(random) - 1.0) : shift;
        world->x1[i] = world->x0[i] + step;
    }
}

/* Most vertices hardly, every seventh one of cloth by up to `way` [m] a component. */
static void move_some_by_chance(contact_world *world, double way, uint64_t *random) {
    move_by_chance(world, 1e-5, 0.0, random);
    for (size_t i = 0; i < 3 * world->cloth_vertex_count; i++)
        if (i / 3 % 7 == 0) world->x1[i] += way * (2.0 * random_uniform(random) - 1.0);
}

static void make_three_layers(contact_world *world, uint64_t *random) {
    *world = contact_world_make();
    world->def.contact_distance = 3e-3;
    contact_grid sheets[2];
    double height = 0.0;
    for (int i = 0; i < 2; i++) {
        double const angle = 6.28 * random_uniform(random);
        height += 1e-4 + 2e-3 * random_uniform(random);
        vec3 const across = {0.1 * cos(angle), 0.1 * sin(angle), 2e-5};
        vec3 const along = {-0.12 * sin(angle), 0.12 * cos(angle), 0.0};
        sheets[i] = make_contact_grid(8, 9, vec3_make(0.0, 0.0, height), across, along);
        add_contact_surface(world, sheets[i].mesh, false);
    }
    contact_grid plate = make_contact_grid(5, 4, vec3_make(-0.3, -0.31, 0.0),
                                           vec3_make(0.6, 0.0, 0.0), vec3_make(0.0, 0.6, 0.0));
    add_contact_surface(world, plate.mesh, true);
    start_contact_world(world);
    world->inverse_mass[3] = 0.0;
    for (int i = 0; i < 2; i++) free_contact_grid(&sheets[i]);
    free_contact_grid(&plate);
}

static void check_equal_hits(const pair_events *a, const pair_events *b) {
    assert_int_equal(a->count, b->count);
    for (size_t i = 0; i < a->count; i++) {
        assert_int_equal(a->events[i].kind, b->events[i].kind);
        assert_int_equal(a->events[i].pair.first, b->events[i].pair.first);
        assert_int_equal(a->events[i].pair.second, b->events[i].pair.second);
        assert_true(a->events[i].time == b->events[i].time);
    }
}

static void check_equal_gaps(const smallest_gap *a, const smallest_gap *b) {
    assert_true(a->distance == b->distance);
    if (!isfinite(a->distance)) return;
    assert_int_equal(a->kind, b->kind);
    assert_int_equal(a->pair.first, b->pair.first);
    assert_int_equal(a->pair.second, b->pair.second);
}

static void shuffle_pairs(feature_pair *pairs, size_t count, uint64_t *random) {
    for (size_t i = count; i > 1; i--) {
        size_t const other = (size_t)(random_next(random) % i);
        feature_pair const swapped = pairs[i - 1];
        pairs[i - 1] = pairs[other];
        pairs[other] = swapped;
    }
}

/* The smallest distance at x1, of equal ones the first by (kind, first, second). */
static smallest_gap find_gap_one_by_one(const contact_world *world, double limit) {
    smallest_gap best = {.distance = (double)INFINITY};
    for (int kind = 0; kind < 2; kind++) {
        size_t const count =
            kind == 0 ? world->pairs->vertex_triangle.count : world->pairs->edge_edge.count;
        for (size_t i = 0; i < count; i++) {
            feature_pair const pair =
                kind == 0 ? world->pairs->vertex_triangle.data[i] : world->pairs->edge_edge.data[i];
            uint32_t vertices[4];
            vec3 points[4];
            feature_pair_vertices(world->topo, (feature_kind)kind, pair, vertices);
            for (int k = 0; k < 4; k++) points[k] = vec3_load(world->x1, vertices[k]);
            double const distance = sqrt(closest_of_pair((feature_kind)kind, points).distance2);
            bool const comes_first =
                (feature_kind)kind == best.kind &&
                (pair.first < best.pair.first ||
                 (pair.first == best.pair.first && pair.second < best.pair.second));
            if (!(distance < limit)) continue;
            if (distance < best.distance || (distance == best.distance && comes_first))
                best = (smallest_gap){distance, (feature_kind)kind, pair};
        }
    }
    return best;
}

/* Hits of x0 -> x1 with near pairs, and with all pairs in some order; returns how many. */
static size_t compare_tests(contact_world *world, const pair_source *source, uint64_t *random,
                            size_t *picked_count) {
    contact_scene const scene = get_contact_scene(world, TIME_STEP);
    pair_source all = *source;
    all.near_pairs = NULL;
    shuffle_pairs(world->pairs->vertex_triangle.data, world->pairs->vertex_triangle.count, random);
    shuffle_pairs(world->pairs->edge_edge.data, world->pairs->edge_edge.count, random);
    arena_mark const mark = arena_get_mark(world->scratch);
    pair_events hits, all_hits;
    smallest_gap gap, all_gap;
    pair_list picked;
    bool has_changed[512];
    assert_true(world->vertex_count <= 512);
    for (size_t i = 0; i < world->vertex_count; i++) has_changed[i] = i % 3 == 0;
    assert_int_equal(find_hits(&scene, source, world->x1, has_changed, &hits), TULLE_OK);
    assert_int_equal(find_hits(&scene, &all, world->x1, has_changed, &all_hits), TULLE_OK);
    check_equal_hits(&hits, &all_hits);
    assert_int_equal(find_hits(&scene, source, world->x1, NULL, &hits), TULLE_OK);
    assert_int_equal(find_hits(&scene, &all, world->x1, NULL, &all_hits), TULLE_OK);
    check_equal_hits(&hits, &all_hits);
    assert_int_equal(find_smallest_gap(&scene, source, world->x1, 3e-3, &gap), TULLE_OK);
    assert_int_equal(find_smallest_gap(&scene, &all, world->x1, 3e-3, &all_gap), TULLE_OK);
    smallest_gap const plain_gap = find_gap_one_by_one(world, 3e-3);
    check_equal_gaps(&gap, &plain_gap);
    check_equal_gaps(&all_gap, &plain_gap);
    assert_int_equal(pick_pairs(&scene, source, world->x1, world->settings.minimum_gap, &picked),
                     TULLE_OK);
    *picked_count = picked.vertex_triangle.count + picked.edge_edge.count;
    size_t const count = hits.count;
    arena_release(world->scratch, mark);
    return count;
}

static double find_smallest_start(const pair_source *source) {
    double smallest = (double)INFINITY;
    for (size_t i = 0; i < source->near_pairs->pairs.count; i++)
        smallest = fmin(smallest, source->near_pairs->pairs.data[i].distance);
    return smallest;
}

static void near_pairs_find_what_all_pairs_find(void **state) {
    (void)state;
    size_t short_hits = 0, long_hits = 0;
    for (uint64_t seed = 1; seed <= 60; seed++) {
        uint64_t random = seed;
        contact_world world;
        make_three_layers(&world, &random);
        memcpy(world.x1, world.x0, 3 * world.vertex_count * sizeof(double));
        pair_source *const source = find_contact_pairs(&world, world.x1);
        contact_scene const scene = get_contact_scene(&world, TIME_STEP);
        assert_int_equal(gather_rows(&scene, world.store, world.x1, source, world.rows), TULLE_OK);
        assert_non_null(source->near_pairs);
        assert_true(find_smallest_start(source) ==
                    source->near_pairs->pairs.data[source->near_pairs->nearest].distance);
        size_t const pair_count =
            source->pairs->vertex_triangle.count + source->pairs->edge_edge.count;
        for (double way = 1e-6; way < 1e-2; way *= 1.7) {
            size_t picked_count;
            move_by_chance(&world, way, 2.0 * way, &random);
            size_t const hit_count = compare_tests(&world, source, &random, &picked_count);
            bool const is_short = picked_count < pair_count;
            *(is_short ? &short_hits : &long_hits) += hit_count;
            if (way < 1e-4) assert_true(picked_count < pair_count / 4);
        }
        contact_world_destroy(&world);
    }
    assert_true(short_hits > 100 && long_hits > 1000);
}

/* Where some vertices go far, all pairs of these are tested, and of the others the near ones. */
static void fast_vertices_are_tested_against_all(void **state) {
    (void)state;
    size_t hit_count = 0, partial_count = 0;
    for (uint64_t seed = 1; seed <= 30; seed++) {
        uint64_t random = seed;
        contact_world world;
        make_three_layers(&world, &random);
        move_some_by_chance(&world, 0.02, &random);
        pair_source *const source = find_contact_pairs(&world, world.x1);
        contact_scene const scene = get_contact_scene(&world, TIME_STEP);
        assert_int_equal(gather_rows(&scene, world.store, world.x0, source, world.rows), TULLE_OK);
        size_t const near_count = source->near_pairs->pairs.count;
        size_t const pair_count =
            source->pairs->vertex_triangle.count + source->pairs->edge_edge.count;
        for (double way = 1e-3; way < 2e-2; way *= 1.7) {
            size_t picked_count;
            move_some_by_chance(&world, way, &random);
            size_t const found = compare_tests(&world, source, &random, &picked_count);
            if (picked_count <= near_count || picked_count >= pair_count) continue;
            partial_count++;
            hit_count += found;
        }
        contact_world_destroy(&world);
    }
    assert_true(partial_count > 50 && hit_count > 1000);
}

/* Two level sheets, `height` [m] apart, one turned over the other. */
static void make_two_sheets(contact_world *world, double height, double angle) {
    *world = contact_world_make();
    world->def.contact_distance = 3e-3;
    contact_grid const lower = make_contact_grid(
        11, 11, vec3_make(-0.1, -0.1, 0.0), vec3_make(0.2, 0.0, 0.0), vec3_make(0.0, 0.2, 0.0));
    vec3 const across = {0.2 * cos(angle), 0.2 * sin(angle), 0.0};
    vec3 const along = {-across.y, across.x, 0.0};
    vec3 const origin = vec3_add(vec3_scale(vec3_add(across, along), -0.5), (vec3){0, 0, height});
    contact_grid upper = make_contact_grid(11, 11, origin, across, along),
                 sheets[2] = {lower, upper};
    for (int i = 0; i < 2; i++) add_contact_surface(world, sheets[i].mesh, false);
    start_contact_world(world);
    for (int i = 0; i < 2; i++) free_contact_grid(&sheets[i]);
}

/* Vertices within `radius` [m] of the middle go towards the other sheet by `way` [m], of which the
 * lower ones have `share`. */
static void close_sheets(contact_world *world, double radius, double way, double share) {
    memcpy(world->x1, world->x0, 3 * world->vertex_count * sizeof(double));
    for (size_t v = 0; v < world->vertex_count; v++) {
        if (!(hypot(world->x0[3 * v], world->x0[3 * v + 1]) < radius)) continue;
        world->x1[3 * v + 2] += world->vertex_surface[v] == 0 ? share * way : (share - 1.0) * way;
    }
}

/* What starts just beyond the largest separation distance and meets after the shortest ways that
 * lead there is found: vertices that go hardly further than half of it are fast. */
static void shortest_ways_to_a_hit_are_tested(void **state) {
    (void)state;
    static const double shares[] = {0.5, 0.500001, 0.0, 1.0, 0.3};
    for (int turn = 1; turn <= 8; turn++) {
        contact_world world;
        contact_settings const settings = default_contact_settings;
        double const height = 4.5e-3 * (1.0 + 1e-5), way = height - settings.minimum_gap;
        make_two_sheets(&world, height, 0.19 * turn);
        close_sheets(&world, 0.06, 4.0 * height, 0.5);
        pair_source *const source = find_contact_pairs(&world, world.x1);
        contact_scene const scene = get_contact_scene(&world, TIME_STEP);
        assert_true(scene.largest_separation < height);
        assert_int_equal(gather_rows(&scene, world.store, world.x0, source, world.rows), TULLE_OK);
        assert_int_equal(source->near_pairs->pairs.count, 0);
        uint64_t random = (uint64_t)turn;
        for (size_t i = 0; i < sizeof shares / sizeof shares[0]; i++) {
            size_t picked_count;
            close_sheets(&world, 0.06, way * (1.0 + 1e-5), shares[i]);
            assert_true(compare_tests(&world, source, &random, &picked_count) > 100);
            close_sheets(&world, 0.01, 4.0 * height, shares[i]); /* one vertex of each */
            assert_true(compare_tests(&world, source, &random, &picked_count) > 10);
            assert_true(picked_count <
                        source->pairs->vertex_triangle.count + source->pairs->edge_edge.count);
        }
        contact_world_destroy(&world);
    }
}

/* Pairs that were found anew have no near pairs until stage 5 notes them. */
static void renewed_pairs_have_none(void **state) {
    (void)state;
    uint64_t random = 7;
    contact_world world;
    make_three_layers(&world, &random);
    memcpy(world.x1, world.x0, 3 * world.vertex_count * sizeof(double));
    pair_source *const source = find_contact_pairs(&world, world.x1);
    assert_null(source->near_pairs);
    contact_scene const scene = get_contact_scene(&world, TIME_STEP);
    assert_int_equal(gather_rows(&scene, world.store, world.x1, source, world.rows), TULLE_OK);
    assert_non_null(source->near_pairs);
    assert_int_equal(ensure_pairs_cover(&scene, source, world.x1), TULLE_OK);
    assert_non_null(source->near_pairs);
    move_by_chance(&world, 0.1, 0.0, &random);
    assert_int_equal(ensure_pairs_cover(&scene, source, world.x1), TULLE_OK);
    assert_null(source->near_pairs);
    contact_world_destroy(&world);
}

/* Where pairs that straight paths keep apart were left out, what stops on its way is not covered,
 * though it stays in the box of its path; what ends nearly where the pairs were found is. */
static void pairs_of_straight_paths_cover_their_ends(void **state) {
    (void)state;
    uint64_t random = 8;
    contact_world world;
    make_three_layers(&world, &random);
    size_t const count = 3 * world.vertex_count;
    for (size_t i = 0; i < count; i++) world.x1[i] = world.x0[i] + 0.05;
    pair_source *const source = find_contact_pairs(&world, world.x1);
    contact_scene const scene = get_contact_scene(&world, TIME_STEP);
    double const reach = 0.5 * (source->margin - scene.settings.minimum_gap);
    for (int is_straight = 0; is_straight < 2; is_straight++) {
        source->is_straight = is_straight;
        for (size_t i = 0; i < count; i++) world.x1[i] = world.x0[i] + 0.05 - 0.99 * reach;
        assert_true(paths_stay_in_bounds(&scene, source, world.x1));
        world.x1[4] -= 0.02 * reach;
        assert_int_equal(paths_stay_in_bounds(&scene, source, world.x1), !is_straight);
        memcpy(world.x1, world.x0, count * sizeof(double));
        assert_int_equal(paths_stay_in_bounds(&scene, source, world.x1), !is_straight);
        for (size_t i = 0; i < count; i++) world.x1[i] = world.x0[i] + 0.05 + 1.01 * reach;
        assert_false(paths_stay_in_bounds(&scene, source, world.x1));
    }
    contact_world_destroy(&world);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(near_pairs_find_what_all_pairs_find),
        cmocka_unit_test(fast_vertices_are_tested_against_all),
        cmocka_unit_test(shortest_ways_to_a_hit_are_tested),
        cmocka_unit_test(renewed_pairs_have_none),
        cmocka_unit_test(pairs_of_straight_paths_cover_their_ends),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
