/* Pinches, ignored pairs, threads and lack of memory in the last stages. */
#include "base/hash.h"
#include "contact/pairs/pair_rules.h"
#include "support/contact_world.h"
#include "support/test_support.h"
#include "tulle/check.h"

#include <stdlib.h>
#include <string.h>

#define TIME_STEP (1.0 / 90.0)
#define CONTACT_DISTANCE 2e-3

/* [m] gap between the plates when they are closed. */
static double closed_gap;

/* Two plates 20 mm apart close within 0.4 s and open again. */
static void make_plate_motion(double sign, tulle_keyframe keys[3]) {
    for (int k = 0; k < 3; k++)
        keys[k] = (tulle_keyframe){
            .time = 0.4 * k,
            .translation = {0.0, 0.0, k == 1 ? sign * 0.5 * (0.02 - closed_gap) : 0.0},
            .rotation_vector = {0, 0, 0}};
}

static void make_press(contact_world *world) {
    *world = contact_world_make();
    world->def.contact_distance = CONTACT_DISTANCE;
    world->def.gravity[2] = -1.0;
    contact_grid sheet = make_contact_grid(7, 7, vec3_make(-0.05, -0.05, 0.0101),
                                           vec3_make(0.1, 0.0, 0.003), vec3_make(0.0, 0.1, 0.001));
    add_contact_surface(world, sheet.mesh, false);
    free_contact_grid(&sheet);
    for (int i = 0; i < 2; i++) {
        contact_grid plate =
            make_contact_grid(4, 4, vec3_make(-0.08, -0.08, 0.02 * i), vec3_make(0.15, 0.0, 0.0),
                              vec3_make(0.0, 0.16, 0.0));
        add_contact_surface(world, plate.mesh, true);
        free_contact_grid(&plate);
    }
    tulle_keyframe keys[2][3];
    for (int i = 0; i < 2; i++) {
        make_plate_motion(i == 0 ? 1.0 : -1.0, keys[i]);
        world->motions[1 + i] = (tulle_motion){.keys = keys[i], .key_count = 3};
    }
    start_contact_world(world);
}

static void closing_to_two_thicknesses_is_fine(void **state) {
    (void)state;
    closed_gap = 2.2 * CONTACT_DISTANCE;
    contact_world world;
    make_press(&world);
    for (int step = 0; step < 72; step++) {
        assert_int_equal(step_contact_world(&world, TIME_STEP), TULLE_OK);
        assert_int_equal(judge_contact_world(&world), 0);
        assert_true(world.report.smallest_gap >= world.settings.minimum_gap);
    }
    assert_int_equal(world.rescue_count, 0);
    contact_world_destroy(&world);
}

static void closing_to_nothing_names_the_pinch(void **state) {
    (void)state;
    closed_gap = 0.0;
    contact_world world;
    make_press(&world);
    tulle_status status = TULLE_OK;
    double gap = 0.0;
    for (int step = 0; status == TULLE_OK && step < 72; step++) {
        gap = vec3_load(world.x0, world.surfaces[2].vertex_begin).z -
              vec3_load(world.x0, world.surfaces[1].vertex_begin).z;
        status = step_contact_world(&world, TIME_STEP);
        assert_int_equal(judge_contact_world(&world), 0);
    }
    print_message("plates stopped at a gap of %.3g m\n", gap);
    assert_int_equal(status, TULLE_ERROR_PINCHED);
    assert_non_null(strstr(world.error.message, "'surface 0' is pinched near ("));
    assert_non_null(strstr(world.error.message, "between 'surface 1', 'surface 2'"));
    /* Cloth keeps the minimum gap to both plates, so they stop at twice as much. */
    assert_true(gap > 2.0 * world.settings.minimum_gap && gap < 2.0 * CONTACT_DISTANCE);
    contact_world_destroy(&world);
}

typedef struct intersections {
    uint64_t *keys;
    size_t count;
} intersections;

/* Keys of the intersecting pairs of a world of one cloth and one obstacle, ascending. */
static intersections find_intersections(const contact_world *world) {
    tulle_check_body bodies[2];
    uint32_t *const local = calloc(3 * world->triangle_count, sizeof(uint32_t));
    for (size_t s = 0; s < 2; s++) {
        const surface_range *const range = &world->surfaces[s];
        for (size_t i = 3 * (size_t)range->triangle_begin; i < 3 * (size_t)range->triangle_end; i++)
            local[i] = world->triangles[i] - range->vertex_begin;
        bodies[s] = (tulle_check_body){.mesh = {world->x0 + 3 * (size_t)range->vertex_begin,
                                                range->vertex_end - range->vertex_begin,
                                                local + 3 * (size_t)range->triangle_begin,
                                                range->triangle_end - range->triangle_begin},
                                       .is_obstacle = range->is_obstacle};
    }
    tulle_check_result result;
    assert_int_equal(tulle_check_intersections(bodies, 2, 1, &result, NULL), TULLE_OK);
    intersections found = {calloc(result.pair_count + 1, sizeof(uint64_t)), result.pair_count};
    for (size_t i = 0; i < result.pair_count; i++) {
        const tulle_check_pair *const pair = &result.pairs[i];
        found.keys[i] =
            ignored_pair_key(pair->triangle_a + world->surfaces[pair->body_a].triangle_begin,
                             pair->triangle_b + world->surfaces[pair->body_b].triangle_begin);
    }
    for (size_t i = 1; i < found.count; i++)
        for (size_t j = i; j > 0 && found.keys[j] < found.keys[j - 1]; j--) {
            uint64_t const key = found.keys[j];
            found.keys[j] = found.keys[j - 1];
            found.keys[j - 1] = key;
        }
    tulle_check_result_destroy(&result);
    free(local);
    return found;
}

static bool is_among(const intersections *all, uint64_t key) {
    for (size_t i = 0; i < all->count; i++)
        if (all->keys[i] == key) return true;
    return false;
}

/* A sheet that starts half through a plate: pairs that intersect may go on, no other begins. */
static void ignored_pairs_only_become_fewer(void **state) {
    (void)state;
    contact_world world = contact_world_make();
    world.def.contact_distance = CONTACT_DISTANCE;
    contact_grid sheet = make_contact_grid(9, 8, vec3_make(-0.05, -0.05, -0.02),
                                           vec3_make(0.1, 0.0, 0.04), vec3_make(0.0, 0.1, 0.002));
    contact_grid plate = make_contact_grid(6, 7, vec3_make(-0.2, -0.21, 0.0),
                                           vec3_make(0.41, 0.0, 0.0), vec3_make(0.01, 0.4, 0.0));
    add_contact_surface(&world, sheet.mesh, false);
    add_contact_surface(&world, plate.mesh, true);
    world.def.start_intersections = TULLE_START_IGNORE;
    start_contact_world(&world);
    intersections const first = find_intersections(&world);
    assert_true(first.count > 10);
    for (int step = 0; step < 60; step++) {
        tulle_status const status = step_contact_world(&world, TIME_STEP);
        assert_int_equal(status, TULLE_OK);
        intersections const now = find_intersections(&world);
        for (size_t i = 0; i < now.count; i++) assert_true(is_among(&first, now.keys[i]));
        free(now.keys);
    }
    free(first.keys);
    free_contact_grid(&sheet);
    free_contact_grid(&plate);
    contact_world_destroy(&world);
}

/* A crowded scene: the press, half closed, and a random motion that needs every kind of rescue. */
static tulle_status run_crowded_step(contact_world *world, uint64_t seed) {
    uint64_t random = seed;
    memcpy(world->targets, world->x0, 3 * world->vertex_count * sizeof(double));
    for (size_t i = 3 * world->cloth_vertex_count; i < 3 * world->vertex_count; i++)
        world->targets[i] += i % 3 == 2 ? (i % 2 ? -0.004 : 0.004) : 0.0;
    for (size_t i = 0; i < 3 * world->cloth_vertex_count; i++)
        world->u[i] = 2.0 * (2.0 * random_uniform(&random) - 1.0);
    contact_scene const scene = get_contact_scene(world, TIME_STEP);
    prescribe_motion(&scene, world->u);
    propose_paths(&scene, world->u, world->x1);
    pair_source *const source = find_contact_pairs(world, world->x1);
    tulle_status status = gather_rows(&scene, world->store, world->x1, source, world->rows);
    if (status == TULLE_OK)
        status = resolve_impacts(&scene, source, world->rows, world->u, world->x1, &world->impacts);
    if (status == TULLE_OK)
        status = commit_safely(&scene, source, world->impacts.is_clean, world->u, world->x1,
                               &world->commit);
    return status;
}

/* Components are shortened in so many rounds at most; then the whole scene is. */
static void rounds_of_components_are_limited(void **state) {
    (void)state;
    uint64_t components[2] = {0, 0}, whole[2] = {0, 0};
    for (int i = 0; i < 2; i++)
        for (uint64_t seed = 1; seed < 9; seed++) {
            contact_world world;
            make_press(&world);
            world.settings.impact_rounds = 0;
            if (i == 0) world.settings.component_rounds = 0;
            assert_int_equal(run_crowded_step(&world, seed), TULLE_OK);
            components[i] += world.commit.component_scalings;
            whole[i] += world.commit.global_scalings;
            contact_world_destroy(&world);
        }
    print_message("without rounds %d components and %d times all, else %d and %d\n",
                  (int)components[0], (int)whole[0], (int)components[1], (int)whole[1]);
    assert_true(components[0] == 0 && components[1] > 0);
    assert_true(whole[0] > whole[1]);
}

static void threads_change_no_bit(void **state) {
    (void)state;
    for (uint64_t seed = 1; seed < 4; seed++) {
        uint64_t hashes[3];
        for (int i = 0; i < 3; i++) {
            contact_world world;
            make_press(&world);
            world.def.threads = 1 + i;
            assert_int_equal(run_crowded_step(&world, seed), TULLE_OK);
            size_t const size = 3 * world.vertex_count * sizeof(double);
            hashes[i] = hash_bytes(hash_bytes(HASH_SEED, world.x1, size), world.u, size);
            contact_world_destroy(&world);
        }
        assert_true(hashes[0] == hashes[1] && hashes[0] == hashes[2]);
    }
}

static long allocations_left;
static void *allocate_some(void *context, size_t byte_count) {
    (void)context;
    return allocations_left-- > 0 ? malloc(byte_count) : NULL;
}
static void release_any(void *context, void *pointer, size_t byte_count) {
    (void)context, (void)byte_count;
    free(pointer);
}

/* Every allocation of the stages fails once: an error comes back, x0 and the store are as they were
 * and nothing leaks. */
static void lack_of_memory_is_an_error(void **state) {
    (void)state;
    int failures = 0;
    for (long k = 0;; k++) {
        contact_world world;
        make_press(&world);
        size_t const size = 3 * world.vertex_count * sizeof(double);
        for (size_t i = 0; i < world.vertex_count; i++)
            memcpy(world.x1 + 3 * i, world.x0 + 3 * i, 3 * sizeof(double));
        find_contact_pairs(&world, world.x1); /* the broad phase has its memory */
        uint64_t const before = hash_bytes(HASH_SEED, world.x0, size);
        arena_destroy(world.scratch);
        world.heap->allocator.allocate = allocate_some;
        world.heap->allocator.release = release_any;
        allocations_left = k;
        pair_list const kept = *world.pairs;
        contact_scene const scene = get_contact_scene(&world, TIME_STEP);
        pair_source source = {.pairs = &kept, .bounds = world.x1, .margin = 1.0};
        uint64_t random = 5;
        for (size_t i = 0; i < 3 * world.cloth_vertex_count; i++)
            world.u[i] = 2.0 * (2.0 * random_uniform(&random) - 1.0);
        memcpy(world.targets, world.x0, size);
        prescribe_motion(&scene, world.u);
        propose_paths(&scene, world.u, world.x1);
        tulle_status status = gather_rows(&scene, world.store, world.x1, &source, world.rows);
        if (status == TULLE_OK)
            status =
                resolve_impacts(&scene, &source, world.rows, world.u, world.x1, &world.impacts);
        if (status == TULLE_OK)
            status = commit_safely(&scene, &source, world.impacts.is_clean, world.u, world.x1,
                                   &world.commit);
        if (status == TULLE_OK)
            status = store_contacts(world.store, world.heap, world.rows, NULL, 0, TIME_STEP);
        assert_true(status == TULLE_OK || status == TULLE_ERROR_OUT_OF_MEMORY);
        assert_true(hash_bytes(HASH_SEED, world.x0, size) == before);
        failures += status != TULLE_OK;
        contact_world_destroy(&world);
        if (status == TULLE_OK) break;
    }
    print_message("%d failing allocations\n", failures);
    assert_true(failures > 3);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(closing_to_two_thicknesses_is_fine),
        cmocka_unit_test(closing_to_nothing_names_the_pinch),
        cmocka_unit_test(ignored_pairs_only_become_fewer),
        cmocka_unit_test(rounds_of_components_are_limited),
        cmocka_unit_test(threads_change_no_bit),
        cmocka_unit_test(lack_of_memory_is_an_error),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
