/* Queries and copies beside the life of a world: they change no state and no later step, follow
 * every change of the state, see what is present, and may be made by several threads. */
#include "tulle/query.h"

#include "support/failing_heap.h"
#include "support/paper_options.h"
#include "support/small_world.h"
#include "support/test_support.h"
#include "tulle/live.h"
#include "tulle/shapes.h"

#include <limits.h>
#include <math.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

static const double STEP = 1.0 / 64.0; /* [s] */
static tulle_error error;

#define FINE(call)                                                                                 \
    do {                                                                                           \
        if ((call) != TULLE_OK) fail_msg("%s: %s", #call, error.message);                          \
    } while (0)

enum { BALL, GUEST, OBSTACLES };

typedef struct scene {
    tulle_world *world;
    tulle_cloth_id cloth;
    tulle_obstacle_id obstacles[OBSTACLES];
} scene;

/* A sheet falls on a ball; a guest comes at 0.1 s and stays aside. */
static scene make_scene(tulle_detect_method method, int threads) {
    scene made;
    tulle_world_def def = tulle_world_def_default();
    change_paper(&def)->detection.method = method;
    def.threads = threads;
    FINE(tulle_world_create(&def, &made.world, &error));
    tulle_mesh sheet = small_sheet(0.4, 15, 0.125);
    made.cloth = small_add_cloth(made.world, &sheet);
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_SPHERE);
    shape.radius = 0.11;
    tulle_mesh const ball = small_shape(shape, 0.0, 0.0, 0.0);
    made.obstacles[BALL] = small_add_obstacle(made.world, &ball);
    tulle_obstacle_def guest = tulle_obstacle_def_default();
    guest.mesh = tulle_mesh_get_view(&ball);
    guest.appear_time = 0.1;
    guest.drive = TULLE_DRIVE_RIGID;
    FINE(tulle_world_add_obstacle(made.world, &guest, &made.obstacles[GUEST], &error));
    tulle_mesh rest[2] = {sheet, ball};
    for (int k = 0; k < 2; k++) tulle_mesh_destroy(&rest[k]);
    FINE(tulle_world_start(made.world, &error));
    return made;
}

/* The guest is 1 m aside from the first step on. */
static void step(const scene *made) {
    double const aside[3] = {1.0, 0.0, 0.0}, turn[4] = {1.0, 0.0, 0.0, 0.0};
    FINE(tulle_obstacle_set_next_transform(made->world, made->obstacles[GUEST], aside, turn,
                                           TULLE_TRAVEL_JUMP, &error));
    FINE(tulle_world_step(made->world, STEP, NULL, &error));
}

/* Height at which a ray from above meets the world at x; NaN where it meets nothing. */
static double measure_height(tulle_world *world, double x, tulle_object_id *object) {
    tulle_ray const ray = {.from = {x, 0.013, 2.0}, .to = {x, 0.013, -2.0}};
    tulle_hit hit;
    FINE(tulle_world_cast_ray(world, &ray, &hit, &error));
    if (object) *object = hit.object;
    return hit.object.kind == TULLE_OBJECT_NONE ? (double)NAN : hit.position[2];
}

/* Height of the cloth's triangles there, one by one. */
static double find_height(const scene *made, double x) {
    tulle_object_info const info =
        tulle_object_get_info(made->world, tulle_object_from_cloth(made->cloth));
    const double *const positions = tulle_cloth_get_positions(made->world, made->cloth, NULL);
    double best = -(double)INFINITY;
    for (size_t t = 0; t < info.triangle_count; t++) {
        const double *corner[3];
        for (size_t k = 0; k < 3; k++)
            corner[k] = positions + 3 * (size_t)info.triangles[3 * t + k];
        double weights[3], sum = 0.0;
        int positive = 0;
        for (int k = 0; k < 3; k++) {
            const double *const a = corner[(k + 1) % 3], *const b = corner[(k + 2) % 3];
            weights[k] = (a[0] - x) * (b[1] - 0.013) - (b[0] - x) * (a[1] - 0.013);
            positive += weights[k] > 0.0;
            sum += weights[k];
        }
        if (positive != 0 && positive != 3) continue;
        double height = 0.0;
        for (int k = 0; k < 3; k++) height += weights[k] / sum * corner[k][2];
        best = fmax(best, height);
    }
    return best;
}

static void ask_all(const scene *made) {
    static tulle_found_triangle found[64];
    static tulle_contact contacts[16];
    double values[3 * 225];
    size_t count;
    tulle_hit hit;
    (void)measure_height(made->world, 0.05, NULL);
    FINE(tulle_world_find_closest_point(made->world, (double[]){0.3, 0.1, 0.0}, 2.0, 0, &hit,
                                        &error));
    tulle_found few = {found, 64, 0};
    FINE(tulle_world_find_box_overlaps(made->world, (double[]){-1, -1, -1}, (double[]){1, 1, 1}, 0,
                                       &few, &error));
    assert_true(few.count > 64);
    tulle_object_id const cloth = tulle_object_from_cloth(made->cloth);
    FINE(tulle_object_copy_contacts(made->world, cloth, contacts, 16, &count, &error));
    tulle_target const target = {values, sizeof values, 0, TULLE_NUMBER_DOUBLE};
    for (int k = 0; k < TULLE_VALUES_STRAINS; k++)
        FINE(tulle_object_copy_values(made->world, cloth, (tulle_values)k, &target, &error));
}

static void queries_change_nothing(void **state) {
    (void)state;
    static const tulle_detect_method methods[] = {TULLE_DETECT_PATCHES, TULLE_DETECT_BVOX,
                                                  TULLE_DETECT_PAPER};
    for (int m = 0; m < 3; m++) {
        scene const quiet = make_scene(methods[m], 1), asked = make_scene(methods[m], 2);
        for (int i = 0; i < 16; i++) {
            step(&quiet);
            step(&asked);
            uint64_t const hash = tulle_world_get_state_hash(asked.world);
            assert_true(hash == tulle_world_get_state_hash(quiet.world));
            ask_all(&asked);
            assert_true(hash == tulle_world_get_state_hash(asked.world));
        }
        tulle_world_destroy(quiet.world);
        tulle_world_destroy(asked.world);
    }
}

/* After steps, a loaded state, a step that fails and a jump, rays meet what is there. */
static void queries_follow_the_state(void **state) {
    (void)state;
    scene const made = make_scene(tulle_paper_options_default().detection.method, 2);
    void *saved = NULL;
    size_t byte_count = 0;
    double saved_height = 0.0, last = 1.0;
    for (int i = 0; i < 12; i++) {
        double const height = measure_height(made.world, 0.13, NULL);
        assert_true(fabs(height - find_height(&made, 0.13)) < 1e-12 && height < last);
        last = height;
        if (i == 4) {
            FINE(tulle_world_save_state(made.world, &saved, &byte_count, &error));
            saved_height = height;
        }
        tulle_object_id object;
        double const aside = measure_height(made.world, 1.0, &object);
        bool const is_there = tulle_obstacle_is_present(made.world, made.obstacles[GUEST]);
        assert_true(is_there ? fabs(aside - 0.11) < 0.002 : isnan(aside));
        assert_int_equal(object.kind, is_there ? TULLE_OBJECT_OBSTACLE : TULLE_OBJECT_NONE);
        step(&made);
    }
    assert_true(tulle_obstacle_is_present(made.world, made.obstacles[GUEST]));
    double const before = measure_height(made.world, 0.13, NULL);
    FINE(tulle_world_load_state(made.world, saved, byte_count, &error));
    tulle_hit hit; /* across, so that boxes of the lower state would miss it */
    tulle_ray const across = {.from = {0.13, -2.0, saved_height + 1e-5},
                              .to = {0.13, 2.0, saved_height - 1e-5}};
    FINE(tulle_world_cast_ray(made.world, &across, &hit, &error));
    assert_int_equal(hit.object.kind, TULLE_OBJECT_CLOTH);
    FINE(tulle_world_find_closest_point(made.world, (double[]){0.13, 0.013, saved_height}, 1e-9, 0,
                                        &hit, &error));
    assert_int_equal(hit.object.kind, TULLE_OBJECT_CLOTH);
    assert_true(measure_height(made.world, 0.13, NULL) == saved_height && saved_height > before);
    assert_true(isnan(measure_height(made.world, 1.0, NULL)));
    /* a guest that is refused has never been there */
    for (int i = 0; i < 6; i++) step(&made);
    double const on_ball[3] = {0.0, 0.0, 0.1}, turn[4] = {1.0, 0.0, 0.0, 0.0};
    double const kept = measure_height(made.world, 0.05, NULL);
    FINE(tulle_obstacle_set_next_transform(made.world, made.obstacles[GUEST], on_ball, turn,
                                           TULLE_TRAVEL_JUMP, &error));
    assert_int_equal(tulle_world_step(made.world, STEP, NULL, &error),
                     TULLE_ERROR_INTERSECTING_START);
    assert_true(measure_height(made.world, 0.05, NULL) == kept);
    assert_true(fabs(measure_height(made.world, 1.0, NULL) - 0.11) < 0.002);
    tulle_world_free_state(made.world, saved, byte_count);
    tulle_world_destroy(made.world);
}

/* The contacts of an object are those of all that name it. */
static void objects_have_their_contacts(void **state) {
    (void)state;
    scene const made = make_scene(tulle_paper_options_default().detection.method, 1);
    for (int i = 0; i < 16; i++) step(&made);
    const tulle_contact *all;
    size_t all_count, seen = 0;
    FINE(tulle_world_get_contacts(made.world, &all, &all_count, &error));
    assert_true(all_count > 8);
    for (uint32_t number = 0; number < 3; number++) {
        tulle_object_id const object = tulle_world_get_object(made.world, number);
        size_t count, again, at = 0;
        tulle_contact *const own = calloc(all_count, sizeof *own);
        assert_non_null(own);
        FINE(tulle_object_copy_contacts(made.world, object, own, all_count, &count, &error));
        for (size_t i = 0; i < all_count; i++) {
            if (all[i].object_a != number && all[i].object_b != number) continue;
            assert_true(at < count && memcmp(&own[at++], &all[i], sizeof *own) == 0);
        }
        assert_int_equal(at, count);
        FINE(tulle_object_copy_contacts(made.world, object, own, count / 2, &again, &error));
        assert_int_equal(again, count);
        FINE(tulle_object_copy_contacts(made.world, object, NULL, 0, &again, &error));
        assert_int_equal(again, count);
        seen += count;
        free(own);
    }
    assert_true(seen >= all_count);
    assert_int_equal(tulle_world_get_object(made.world, 3).kind, TULLE_OBJECT_NONE);
    tulle_world_destroy(made.world);
}

/* ---- threads ---- */

enum { THREADS = 4, RAYS = 400 };

typedef struct caster {
    tulle_world *world;
    double heights[RAYS], gaps[RAYS];
    size_t counts[RAYS];
} caster;

static void *cast(void *context) {
    caster *const self = context;
    tulle_error unused;
    for (int i = 0; i < RAYS; i++) {
        double const x = -0.2 + 0.001 * i;
        tulle_ray const ray = {.from = {x, 0.01, 2.0}, .to = {x, 0.013, -2.0}};
        tulle_hit hit;
        (void)tulle_world_cast_ray(self->world, &ray, &hit, &unused);
        self->heights[i] = hit.position[2];
        (void)tulle_world_find_closest_point(self->world, (double[]){x, 0.2, 0.3}, 1.0, 0, &hit,
                                             &unused);
        self->gaps[i] = hit.distance;
        tulle_found none = {NULL, 0, 0};
        (void)tulle_world_find_box_overlaps(self->world, (double[]){x, -0.1, -1.0},
                                            (double[]){x + 0.01, 0.1, 1.0}, 0, &none, &unused);
        self->counts[i] = none.count;
    }
    return NULL;
}

static void threads_ask_side_by_side(void **state) {
    (void)state;
    scene const made = make_scene(tulle_paper_options_default().detection.method, 1);
    for (int i = 0; i < 8; i++) step(&made);
    FINE(tulle_world_update_queries(made.world, &error));
    static caster casters[THREADS + 1];
    pthread_t threads[THREADS];
    for (int k = 0; k <= THREADS; k++) casters[k].world = made.world;
    for (int k = 0; k < THREADS; k++)
        assert_int_equal(pthread_create(&threads[k], NULL, cast, &casters[k]), 0);
    for (int k = 0; k < THREADS; k++) assert_int_equal(pthread_join(threads[k], NULL), 0);
    (void)cast(&casters[THREADS]);
    for (int k = 0; k < THREADS; k++)
        assert_memory_equal(&casters[k], &casters[THREADS], sizeof casters[k]);
    tulle_world_destroy(made.world);
}

/* ---- memory ---- */

/* A start and queries of a world whose allocation number `left` fails, the trees made in the end.
 * TULLE_OK where none was left to fail. */
static tulle_status ask_in_need(tulle_detect_method method, int *left) {
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    change_paper(&def)->detection.method = method;
    memory const heap = failing_heap_make(left);
    def.allocator = heap.allocator;
    int const given = *left;
    *left = INT_MAX;
    tulle_world *world;
    FINE(tulle_world_create(&def, &world, &error));
    tulle_mesh sheet = small_sheet(0.4, 4, 0.125);
    tulle_object_id const cloth = tulle_object_from_cloth(small_add_cloth(world, &sheet));
    tulle_shape_def const shape = tulle_shape_def_default(TULLE_SHAPE_SPHERE);
    tulle_mesh ball = small_shape(shape, 0.0, 0.0, -2.0);
    (void)small_add_obstacle(world, &ball);
    FINE(tulle_object_set_filter(world, cloth, 2, 2, &error));
    *left = given;
    tulle_status status = tulle_world_start(world, &error);
    bool const has_failed = status != TULLE_OK;
    for (int i = 0; i < 2 && !has_failed; i++) {
        tulle_ray const ray = {.from = {0.01, 0.02, 1.0}, .to = {0.01, 0.02, -1.0}};
        tulle_hit hit;
        uint64_t const hash = tulle_world_get_state_hash(world);
        status = tulle_world_cast_ray(world, &ray, &hit, &error);
        assert_int_equal(hit.object.kind, status ? TULLE_OBJECT_NONE : TULLE_OBJECT_CLOTH);
        assert_true(tulle_world_get_state_hash(world) == hash);
        if (status != TULLE_OK) break;
    }
    if (status != TULLE_OK) {
        assert_int_equal(status, TULLE_ERROR_OUT_OF_MEMORY);
        assert_int_equal(error.status, status);
        /* with memory all goes well */
        *left = INT_MAX;
        FINE(tulle_world_start(world, &error));
        FINE(tulle_world_update_queries(world, &error));
        assert_true(measure_height(world, 0.05, NULL) == 0.125);
    }
    tulle_world_destroy(world);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&ball);
    return status;
}

static void short_memory_is_told(void **state) {
    (void)state;
    static const tulle_detect_method methods[] = {TULLE_DETECT_PATCHES, TULLE_DETECT_BVOX};
    for (int m = 0; m < 2; m++) {
        tulle_status status = TULLE_ERROR_OUT_OF_MEMORY;
        for (int k = 0; status != TULLE_OK; k++) {
            int left = k;
            status = ask_in_need(methods[m], &left);
            assert_true(k < 4000);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(queries_change_nothing),      cmocka_unit_test(queries_follow_the_state),
        cmocka_unit_test(objects_have_their_contacts), cmocka_unit_test(threads_ask_side_by_side),
        cmocka_unit_test(short_memory_is_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
