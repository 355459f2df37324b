/* Stages 8 and 9 on random violent displacements: whatever the motion, the state that comes out
 * is free of intersection by the exact judge, keeps the minimum gap, and nothing touched on the way
 * there, by rational arithmetic over all pairs of features. Resting, moving and turning obstacles.
 */
#include "base/hash.h"
#include "contact/pairs/pair_rules.h"
#include "contact/pairs/pair_scan.h"
#include "support/contact_world.h"
#include "support/exact_ccd.h"
#include "support/test_support.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TIME_STEP (1.0 / 90.0)

enum { EXACT_EVERY = 8 }; /* one case of so many is tested in rational arithmetic */

static double random_signed(uint64_t *state) { return 2.0 * random_uniform(state) - 1.0; }

static vec3 random_vector(uint64_t *state, double size) {
    vec3 const v = {random_signed(state), random_signed(state), random_signed(state)};
    return vec3_scale(v, size);
}

/* Obstacles with a motion are no static ones: the tests move them by themselves. */
static tulle_keyframe const stays[] = {{.rotation_vector = {0, 0, 0}},
                                       {.time = 1.0, .rotation_vector = {0, 0, 0}}};

/* Two crumpled sheets, one above the other, and an obstacle below and one above. */
static void make_violent_world(contact_world *world, uint64_t seed, int threads) {
    uint64_t random = seed;
    *world = contact_world_make();
    world->def.threads = threads;
    world->def.contact_distance = 2e-3;
    uint32_t const columns = 4 + (uint32_t)(random_next(&random) % 5);
    for (int i = 0; i < 2; i++) {
        contact_grid sheet = make_contact_grid(columns, 5, vec3_make(-0.05, -0.05, 0.004 * i),
                                               vec3_make(0.1, 0.0, 0.0), vec3_make(0.0, 0.1, 0.0));
        for (size_t k = 2; k < 3 * sheet.mesh.vertex_count; k += 3)
            sheet.positions[k] += 1e-3 * random_signed(&random);
        add_contact_surface(world, sheet.mesh, false);
        free_contact_grid(&sheet);
    }
    double const height[2] = {-0.004, 0.009};
    for (int i = 0; i < 2; i++) {
        contact_grid plate =
            make_contact_grid(4, 4, vec3_make(-0.07, -0.06, height[i]), vec3_make(0.15, 0.0, 0.001),
                              vec3_make(0.0, 0.15, 0.0));
        size_t const surface = add_contact_surface(world, plate.mesh, true);
        world->motions[surface] = (tulle_motion){.keys = stays, .key_count = 2};
        free_contact_grid(&plate);
    }
    start_contact_world(world);
    assert_int_equal(judge_contact_world(world), 0);
}

/* Brute force: boxes of all features against one another. */
static void get_path_box(const contact_world *world, const double *x1, const uint32_t *vertices,
                         int count, double half, double box[6]) {
    for (int axis = 0; axis < 3; axis++) {
        box[axis] = INFINITY;
        box[3 + axis] = -INFINITY;
        for (int k = 0; k < count; k++) {
            double const a = world->x0[3 * vertices[k] + (uint32_t)axis];
            double const b = x1[3 * vertices[k] + (uint32_t)axis];
            box[axis] = fmin(box[axis], fmin(a, b) - half);
            box[3 + axis] = fmax(box[3 + axis], fmax(a, b) + half);
        }
    }
}

static bool boxes_meet(const double a[6], const double b[6]) {
    for (int axis = 0; axis < 3; axis++)
        if (a[axis] > b[3 + axis] || b[axis] > a[3 + axis]) return false;
    return true;
}

static bool may_meet(const contact_world *world, uint32_t vertex, uint32_t other) {
    return !(world->surfaces[world->vertex_surface[vertex]].is_obstacle &&
             world->surfaces[world->vertex_surface[other]].is_obstacle);
}

static bool shares_vertex(const uint32_t *a, int a_count, const uint32_t *b, int b_count) {
    for (int i = 0; i < a_count; i++)
        for (int j = 0; j < b_count; j++)
            if (a[i] == b[j]) return true;
    return false;
}

static double *make_boxes(const contact_world *world, const double *x1, const uint32_t *features,
                          size_t count, int corners, double half) {
    double *const boxes = malloc(6 * count * sizeof(double));
    assert_non_null(boxes);
    for (size_t i = 0; i < count; i++)
        get_path_box(world, x1, features + (size_t)corners * i, corners, half, boxes + 6 * i);
    return boxes;
}

static tulle_status find_brute_pairs(contact_world *world, const double *x1, double margin,
                                     pair_list *pairs) {
    double *const triangles =
        make_boxes(world, x1, world->triangles, world->triangle_count, 3, 0.5 * margin);
    double *const edges =
        make_boxes(world, x1, world->topo->edges, world->topo->edge_count, 2, 0.5 * margin);
    pairs->vertex_triangle.count = pairs->edge_edge.count = 0;
    bool has_memory = true;
    for (uint32_t v = 0; v < world->vertex_count; v++) {
        double box[6];
        get_path_box(world, x1, &v, 1, 0.5 * margin, box);
        for (uint32_t t = 0; has_memory && t < world->triangle_count; t++) {
            const uint32_t *const corner = world->triangles + 3 * (size_t)t;
            if (!may_meet(world, v, corner[0]) || !boxes_meet(box, triangles + 6 * (size_t)t) ||
                shares_vertex(&v, 1, corner, 3))
                continue;
            has_memory = ARRAY_RESERVE(world->heap, &pairs->vertex_triangle, 1);
            if (has_memory)
                pairs->vertex_triangle.data[pairs->vertex_triangle.count++] = (feature_pair){v, t};
        }
    }
    for (uint32_t a = 0; a < world->topo->edge_count; a++) {
        const uint32_t *const first = world->topo->edges + 2 * (size_t)a;
        for (uint32_t b = a + 1; has_memory && b < world->topo->edge_count; b++) {
            const uint32_t *const second = world->topo->edges + 2 * (size_t)b;
            if (!may_meet(world, first[0], second[0]) ||
                !boxes_meet(edges + 6 * (size_t)a, edges + 6 * (size_t)b) ||
                shares_vertex(first, 2, second, 2))
                continue;
            has_memory = ARRAY_RESERVE(world->heap, &pairs->edge_edge, 1);
            if (has_memory) pairs->edge_edge.data[pairs->edge_edge.count++] = (feature_pair){a, b};
        }
    }
    free(triangles);
    free(edges);
    return has_memory ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
}

/* Candidates by brute force in place of the world's trees. */
typedef struct brute_force {
    contact_world *world;
    pair_list pairs;
    pair_source source;
} brute_force;

static tulle_status renew_by_brute_force(pair_source *source, const double *x1) {
    brute_force *const brute = source->context;
    memmove(brute->world->bounds, x1, 3 * brute->world->vertex_count * sizeof(double));
    source->near_pairs = NULL;
    return find_brute_pairs(brute->world, x1, source->margin, &brute->pairs);
}

static pair_source *find_by_brute_force(brute_force *brute, contact_world *world) {
    brute->world = world;
    brute->source = (pair_source){.pairs = &brute->pairs,
                                  .bounds = world->bounds,
                                  .margin = 1.5 * world->def.contact_distance,
                                  .renew = renew_by_brute_force,
                                  .context = brute};
    assert_int_equal(brute->source.renew(&brute->source, world->x1), TULLE_OK);
    return &brute->source;
}

/* How obstacles move in one case. */
typedef enum obstacle_motion { OBSTACLES_REST, OBSTACLES_MOVE, OBSTACLES_TURN } obstacle_motion;

static void move_affinely(contact_world *world, size_t surface, mat3 matrix, vec3 offset) {
    world->maps[surface] = (affine_map){matrix, offset};
    world->carriers[surface] = &world->maps[surface];
    for (uint32_t i = world->surfaces[surface].vertex_begin;
         i < world->surfaces[surface].vertex_end; i++) {
        vec3 const turned = mat3_multiply_vec3(&matrix, vec3_load(world->x0, i));
        vec3_store(world->targets, i, vec3_add(turned, offset));
    }
}

static mat3 make_turn(double angle) {
    return (mat3){{cos(angle), 0.0, sin(angle), 0.0, 1.0, 0.0, -sin(angle), 0.0, cos(angle)}};
}

/* Random velocities of all sizes, obstacles as said; fills targets, u and x1. */
static void make_violent_motion(contact_world *world, uint64_t *random, obstacle_motion motion) {
    double const size = pow(10.0, -3.0 + 3.0 * random_uniform(random));
    memcpy(world->targets, world->x0, 3 * world->vertex_count * sizeof(double));
    for (size_t s = 2; s < 4; s++) {
        world->carriers[s] = NULL;
        if (motion == OBSTACLES_REST) continue;
        double const angle = motion == OBSTACLES_TURN ? 0.1 * random_signed(random) : 0.0;
        double const closing = (s == 2 ? 1.0 : -1.0) * 0.003 * random_uniform(random);
        vec3 const offset = vec3_add(random_vector(random, 2e-3), vec3_make(0.0, 0.0, closing));
        move_affinely(world, s, make_turn(angle), offset);
    }
    vec3 const common = random_vector(random, 0.05 / TIME_STEP);
    for (size_t i = 0; i < world->vertex_count; i++)
        vec3_store(world->u, i, vec3_add(common, random_vector(random, size / TIME_STEP)));
    contact_scene const scene = get_contact_scene(world, TIME_STEP);
    prescribe_motion(&scene, world->u);
    propose_paths(&scene, world->u, world->x1);
}

static void assert_velocities_match(const contact_world *world, const commit_report *report) {
    double const time = report->fraction * TIME_STEP;
    for (size_t i = 0; i < 3 * world->cloth_vertex_count; i++)
        assert_true(fabs(world->x0[i] + time * world->u[i] - world->x1[i]) < 1e-12);
}

static void accept_paths(contact_world *world) {
    memcpy(world->x0, world->x1, 3 * world->vertex_count * sizeof(double));
}

typedef struct violence_counts {
    uint64_t zones, components, global, blocked, clean, exact_tests;
    double smallest_gap;
} violence_counts;

static tulle_status run_last_stages(contact_world *world, pair_source *source) {
    contact_scene const scene = get_contact_scene(world, TIME_STEP);
    world->rows->rows.count = 0;
    tulle_status const status =
        resolve_impacts(&scene, source, world->rows, world->u, world->x1, &world->impacts);
    if (status != TULLE_OK) return status;
    return commit_safely(&scene, source, world->impacts.is_clean, world->u, world->x1,
                         &world->commit);
}

static bool boxes_of_paths_meet(const moving_pair *paths, int first_count) {
    for (int axis = 0; axis < 3; axis++) {
        double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
        for (int k = 0; k < 4; k++) {
            int const side = k < first_count ? 0 : 1;
            double start[3], end[3];
            vec3_store(start, 0, paths->start[k]);
            vec3_store(end, 0, paths->end[k]);
            low[side] = fmin(low[side], fmin(start[axis], end[axis]));
            high[side] = fmax(high[side], fmax(start[axis], end[axis]));
        }
        if (low[0] > high[1] || low[1] > high[0]) return false;
    }
    return true;
}

/* Fails when the pair may touch and does, at any time of x0 -> x1. */
static void assert_never_touches(const contact_world *world, feature_kind kind, uint32_t first,
                                 uint32_t second, violence_counts *counts) {
    int const first_count = kind == FEATURE_VERTEX_TRIANGLE ? 1 : 2;
    uint32_t v[4];
    feature_pair_vertices(world->topo, kind, (feature_pair){first, second}, v);
    for (int i = 0; i < first_count; i++)
        for (int k = first_count; k < 4; k++)
            if (v[i] == v[k]) return;
    if (v[0] >= world->cloth_vertex_count && v[3] >= world->cloth_vertex_count) return;
    moving_pair paths;
    load_points(world->x0, v, paths.start);
    load_points(world->x1, v, paths.end);
    if (!boxes_of_paths_meet(&paths, first_count)) return;
    counts->exact_tests++;
    if (exact_pair_touches(kind, &paths, 1.0))
        fail_msg("pair %u, %u of kind %d touches on its way", first, second, (int)kind);
}

/* All pairs of features, found without any tree, in rational arithmetic. */
static void assert_paths_are_free(const contact_world *world, violence_counts *counts) {
    const topology *const topo = world->topo;
    for (uint32_t v = 0; v < topo->vertex_count; v++)
        for (uint32_t t = 0; t < topo->triangle_count; t++)
            assert_never_touches(world, FEATURE_VERTEX_TRIANGLE, v, t, counts);
    for (uint32_t a = 0; a < topo->edge_count; a++)
        for (uint32_t b = a + 1; b < topo->edge_count; b++)
            assert_never_touches(world, FEATURE_EDGE_EDGE, a, b, counts);
}

static void run_violent_case(uint64_t seed, obstacle_motion motion, violence_counts *counts) {
    contact_world world;
    make_violent_world(&world, seed, 1);
    world.settings.impact_rounds = (int)(seed % 3);
    uint64_t random = seed + 77;
    for (int step = 0; step < 3; step++) {
        make_violent_motion(&world, &random, motion);
        brute_force brute = {0};
        pair_source *const source = seed % 4 == 0 ? find_by_brute_force(&brute, &world)
                                                  : find_contact_pairs(&world, world.x1);
        assert_int_equal(run_last_stages(&world, source), TULLE_OK);
        counts->zones += world.commit.impact_zones;
        counts->components += world.commit.component_scalings;
        counts->global += world.commit.global_scalings;
        counts->blocked += world.commit.outcome == COMMIT_BLOCKED;
        counts->clean += world.impacts.is_clean;
        counts->smallest_gap = fmin(counts->smallest_gap, world.commit.smallest_gap);
        assert_true(world.commit.smallest_gap >= world.settings.minimum_gap);
        if (world.commit.outcome != COMMIT_BLOCKED) assert_velocities_match(&world, &world.commit);
        if (seed % EXACT_EVERY == 0) assert_paths_are_free(&world, counts);
        ARRAY_FREE(world.heap, &brute.pairs.vertex_triangle);
        ARRAY_FREE(world.heap, &brute.pairs.edge_edge);
        accept_paths(&world);
        assert_int_equal(judge_contact_world(&world), 0);
    }
    contact_world_destroy(&world);
}

static void run_violent_cases(obstacle_motion motion, uint64_t first_seed) {
    int const case_count = getenv("TULLE_TEST_LONG") ? 3000 : 25;
    violence_counts counts = {.smallest_gap = INFINITY};
    for (int i = 0; i < case_count; i++)
        run_violent_case(first_seed + (uint64_t)i, motion, &counts);
    print_message("%d steps: %llu clean after impacts, %llu zones, %llu components, %llu global, "
                  "%llu blocked, smallest gap %.3g m\n",
                  3 * case_count, (unsigned long long)counts.clean,
                  (unsigned long long)counts.zones, (unsigned long long)counts.components,
                  (unsigned long long)counts.global, (unsigned long long)counts.blocked,
                  counts.smallest_gap);
    assert_true(counts.zones > 0 && counts.components > 0 && counts.exact_tests > 1000);
    assert_true(counts.smallest_gap >= default_contact_settings.minimum_gap);
}

static void violence_over_resting_obstacles(void **state) {
    (void)state;
    run_violent_cases(OBSTACLES_REST, 1000);
}

static void violence_over_moving_obstacles(void **state) {
    (void)state;
    run_violent_cases(OBSTACLES_MOVE, 50000);
}

static void violence_over_turning_obstacles(void **state) {
    (void)state;
    run_violent_cases(OBSTACLES_TURN, 90000);
}

/* ---- impacts foreseen ---- */

/* What foresee_impacts makes of paths x1, from pairs that were found for `predicted`.
 * `is_straight`: it must take these for a source that left some out. Returns the rows' events,
 * count of them. */
static pair_event *foresee(contact_world *world, const double *predicted, const double *x1,
                           bool is_straight, size_t *count) {
    contact_scene const scene = get_contact_scene(world, TIME_STEP);
    memcpy(world->x1, predicted, 3 * world->vertex_count * sizeof(double));
    brute_force brute = {0};
    pair_source *const source = find_by_brute_force(&brute, world);
    source->is_straight = is_straight;
    world->rows->rows.count = 0;
    impact_report report;
    assert_int_equal(foresee_impacts(&scene, source, world->rows, predicted, x1, &report),
                     TULLE_OK);
    if (!is_straight) assert_int_equal(source->renew_count, 0);
    *count = world->rows->rows.count;
    assert_int_equal(report.impact_count, *count);
    pair_event *const events = calloc(*count + 1, sizeof *events);
    assert_non_null(events);
    for (size_t i = 0; i < *count; i++) {
        const row_frame *const frame = &world->rows->rows.data[i].frame;
        events[i] = (pair_event){frame->kind, frame->pair, 0.0, frame->gap};
    }
    ARRAY_FREE(world->heap, &brute.pairs.vertex_triangle);
    ARRAY_FREE(world->heap, &brute.pairs.edge_edge);
    return events;
}

/* Whether the boxes of a pair's predicted paths meet, as the search for them sees it. */
static bool is_expected(const contact_world *world, const double *predicted,
                        const pair_event *event) {
    int const first_count = event->kind == FEATURE_VERTEX_TRIANGLE ? 1 : 2;
    uint32_t v[4];
    feature_pair_vertices(world->topo, event->kind, event->pair, v);
    double const half = 0.75 * world->def.contact_distance;
    double boxes[2][6];
    get_path_box(world, predicted, v, first_count, half, boxes[0]);
    get_path_box(world, predicted, v + first_count, 4 - first_count, half, boxes[1]);
    return boxes_meet(boxes[0], boxes[1]);
}

/* Rough paths may leave all that was predicted. A source that finds all pairs anew gives the same
 * rows as one that does not. */
static void impacts_foreseen_with_and_without_search(void **state) {
    (void)state;
    size_t foreseen = 0, left_out = 0;
    for (uint64_t seed = 0; seed < 40; seed++) {
        contact_world world;
        make_violent_world(&world, 300 + seed, 1);
        uint64_t random = seed + 5;
        size_t const size = 3 * world.vertex_count * sizeof(double);
        double *const predicted = malloc(size), *const rough = malloc(size);
        assert_true(predicted && rough);
        make_violent_motion(&world, &random, OBSTACLES_REST);
        memcpy(predicted, world.x1, size);
        make_violent_motion(&world, &random, OBSTACLES_REST);
        for (size_t i = 0; i < 3 * world.vertex_count; i++)
            rough[i] = seed % 2 ? world.x1[i] : 0.5 * (world.x1[i] + predicted[i]);
        size_t count, straight_count, all_count;
        pair_event *const events = foresee(&world, predicted, rough, false, &count);
        pair_event *const others = foresee(&world, predicted, rough, true, &straight_count);
        assert_int_equal(count, straight_count);
        for (size_t i = 0; i < count; i++) {
            assert_true(is_expected(&world, predicted, &events[i]));
            assert_int_equal(events[i].kind, others[i].kind);
            assert_memory_equal(&events[i].pair, &others[i].pair, sizeof(feature_pair));
            assert_true(events[i].distance == others[i].distance);
        }
        pair_event *const all = foresee(&world, rough, rough, false, &all_count);
        foreseen += count;
        left_out += all_count > count ? all_count - count : 0;
        free(events), free(others), free(all), free(predicted), free(rough);
        contact_world_destroy(&world);
    }
    assert_true(foreseen > 1000 && left_out > 100);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(impacts_foreseen_with_and_without_search),
        cmocka_unit_test(violence_over_resting_obstacles),
        cmocka_unit_test(violence_over_moving_obstacles),
        cmocka_unit_test(violence_over_turning_obstacles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
