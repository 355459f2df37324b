/* Scenes of the folder scenes/ at work: the motion of cloths and obstacles from frame to frame, as
 * it is and three times as long, through the detector without separation. Against rational
 * arithmetic, nothing that touches is missed, and of the pairs that pass the filters under 5 % are
 * reported and do not touch. Small scenes, every second frame; with TULLE_TEST_LONG=1 whole ones,
 * every tenth. */
#include "scene/scene.h"
#include "support/alarm_count.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* [%] of the pairs that pass the filters */
static const double MOST_FALSE = 5.0;

/* LEAST_TOUCHING pairs a scene, so that there is something to find. */
enum { FACTOR_COUNT = 2, FRAME_STRIDE = 2, LONG_FRAME_STRIDE = 10, LEAST_TOUCHING = 100 };
static const double factors[FACTOR_COUNT] = {1.0, 3.0};

typedef struct scene_size {
    const char *name;
    uint32_t frame_count;
    size_t change_count;
    const char *changes[4];
} scene_size;

static const scene_size sizes[] = {
    {"sphere", 20, 2, {"cloth[0].mesh.resolution=[17, 17]", "obstacles[1].disappears=0.4"}},
    {"needles",
     20,
     2,
     {"cloth[0].mesh.resolution=[17, 17]",
      "obstacles[2].motion.keyframes=[{time: 0.2}, {time: 0.4, translate: [0, 0, -0.22]}]"}},
    {"layers",
     20,
     3,
     {"cloth[0].mesh.resolution=[13, 13]", "cloth[1].mesh.resolution=[13, 13]",
      "cloth[2].mesh.resolution=[11, 11]"}},
    {"ribbon", 40, 1, {"cloth[0].mesh.resolution=[121, 3]"}},
    {"net", 20, 2, {"cloth[0].mesh.cells=[6, 6]", "cloth[0].mesh.strand=3 cm"}},
};

/* A world at work and its surfaces, cloths first, for the detector. */
typedef struct scene_motion {
    tulle_scene *loaded;
    tulle_scene_world built;
    size_t body_count, vertex_count, triangle_count;
    tulle_mesh_view *meshes;
    tulle_detect_surface *surfaces;
    uint32_t *triangles;
    unsigned char *collides;
    double *states[2], *end; /* last frame and this one; the longer motion's end */
    alarm_counts counts[FACTOR_COUNT];
} scene_motion;

static bool is_long(void) {
    const char *const choice = getenv("TULLE_TEST_LONG");
    return choice && choice[0] == '1';
}

static void *allocate(size_t count, size_t size) {
    void *const block = calloc(count, size);
    assert_non_null(block);
    return block;
}

static void load(const scene_size *size, scene_motion *motion) {
    const char *const source = getenv("TULLE_SOURCE_DIR");
    char path[1024];
    snprintf(path, sizeof path, "%s/scenes/%s.yaml", source ? source : ".", size->name);
    tulle_scene_problems *const problems = allocate(1, sizeof *problems);
    tulle_scene_load(path, size->changes, is_long() ? 0 : size->change_count, &motion->loaded,
                     problems);
    if (!motion->loaded) scene_print_problems(problems, stderr);
    free(problems);
    assert_non_null(motion->loaded);
    tulle_error error = {0};
    if (tulle_scene_build_world(motion->loaded, 2, NULL, &motion->built, &error) != TULLE_OK)
        fail_msg("%s: %s", size->name, error.message);
}

static void make_surfaces(scene_motion *motion) {
    size_t const cloth_count = motion->built.cloth_count;
    motion->body_count = cloth_count + motion->built.obstacle_count;
    motion->meshes = allocate(motion->body_count, sizeof *motion->meshes);
    motion->surfaces = allocate(motion->body_count, sizeof *motion->surfaces);
    for (size_t i = 0; i < motion->body_count; i++) {
        bool const is_cloth = i < cloth_count;
        motion->meshes[i] = is_cloth
                                ? tulle_scene_get_cloth_mesh(motion->loaded, i)
                                : tulle_scene_get_obstacle_mesh(motion->loaded, i - cloth_count);
        tulle_detect_surface *const surface = &motion->surfaces[i];
        surface->is_obstacle = !is_cloth;
        surface->vertex_begin = (uint32_t)motion->vertex_count;
        surface->triangle_begin = (uint32_t)motion->triangle_count;
        motion->vertex_count += motion->meshes[i].vertex_count;
        motion->triangle_count += motion->meshes[i].triangle_count;
        surface->vertex_end = (uint32_t)motion->vertex_count;
        surface->triangle_end = (uint32_t)motion->triangle_count;
    }
    motion->triangles = allocate(3 * motion->triangle_count, sizeof *motion->triangles);
    for (size_t i = 0; i < motion->body_count; i++)
        for (size_t k = 0; k < 3 * motion->meshes[i].triangle_count; k++)
            motion->triangles[3 * (size_t)motion->surfaces[i].triangle_begin + k] =
                motion->surfaces[i].vertex_begin + motion->meshes[i].triangles[k];
    motion->collides = allocate(motion->body_count * motion->body_count, 1);
    for (int k = 0; k < 2; k++)
        motion->states[k] = allocate(3 * motion->vertex_count, sizeof **motion->states);
    motion->end = allocate(3 * motion->vertex_count, sizeof *motion->end);
}

static void store_state(scene_motion *motion, double *to) {
    const tulle_scene_world *const built = &motion->built;
    for (size_t i = 0; i < motion->body_count; i++) {
        size_t vertex_count;
        const double *const from =
            i < built->cloth_count
                ? tulle_cloth_get_positions(built->world, built->cloths[i], &vertex_count)
                : tulle_obstacle_get_positions(
                      built->world, built->obstacles[i - built->cloth_count], &vertex_count);
        memcpy(to + 3 * (size_t)motion->surfaces[i].vertex_begin, from,
               3 * vertex_count * sizeof *to);
    }
}

/* Obstacles that are gone meet nothing. */
static void set_collides(scene_motion *motion) {
    const tulle_scene_world *const built = &motion->built;
    size_t const count = motion->body_count;
    for (size_t i = 0; i < count; i++) {
        bool const is_present =
            i < built->cloth_count ||
            tulle_obstacle_is_present(built->world, built->obstacles[i - built->cloth_count]);
        for (size_t k = 0; k < count; k++) {
            unsigned char *const row = &motion->collides[i * count + k];
            unsigned char *const column = &motion->collides[k * count + i];
            if (k <= i) *row = *column = is_present && (k == i || motion->collides[k * count + k]);
        }
    }
}

static tulle_detect_def make_def(const scene_motion *motion) {
    tulle_detect_def def = tulle_detect_def_default();
    def.triangles = motion->triangles;
    def.triangle_count = motion->triangle_count;
    def.vertex_count = motion->vertex_count;
    def.surfaces = motion->surfaces;
    def.surface_count = motion->body_count;
    def.collides = motion->collides;
    def.threads = 2;
    return def;
}

static void count_motion(scene_motion *motion, int factor, double separation,
                         alarm_counts *counts) {
    const double *const start = motion->states[0], *const last = motion->states[1];
    for (size_t i = 0; i < 3 * motion->vertex_count; i++)
        motion->end[i] =
            factors[factor] == 1.0 ? last[i] : start[i] + factors[factor] * (last[i] - start[i]);
    tulle_detect_def def = make_def(motion);
    def.minimum_separation = separation;
    tulle_error error = {0};
    if (alarm_count_add(&def, start, motion->end, counts, &error) != TULLE_OK)
        fail_msg("%s", error.message);
}

static void advance_frame(scene_motion *motion) {
    uint32_t const step_count = tulle_scene_get_steps_per_frame(motion->loaded);
    memcpy(motion->states[0], motion->states[1],
           3 * motion->vertex_count * sizeof *motion->states[0]);
    for (uint32_t i = 0; i < step_count; i++) {
        tulle_step_report report;
        tulle_error error = {0};
        if (tulle_world_step(motion->built.world, tulle_scene_get_time_step(motion->loaded),
                             &report, &error) != TULLE_OK)
            fail_msg("%s", error.message);
    }
    store_state(motion, motion->states[1]);
    set_collides(motion);
}

static void start_motion(const scene_size *size, scene_motion *motion) {
    load(size, motion);
    make_surfaces(motion);
    store_state(motion, motion->states[1]);
}

static void end_motion(scene_motion *motion) {
    tulle_scene_destroy_world(&motion->built);
    tulle_scene_destroy(motion->loaded);
    free(motion->meshes);
    free(motion->surfaces);
    free(motion->triangles);
    free(motion->collides);
    for (int k = 0; k < 2; k++) free(motion->states[k]);
    free(motion->end);
}

static void print_counts(const char *name, double factor, const alarm_counts *counts) {
    print_message("%-8s x %.0f: %8llu candidates, %6llu tested, %6llu events, %6llu touch, "
                  "%llu missed, %llu false alarms, %.2f %%\n",
                  name, factor, (unsigned long long)counts->candidates,
                  (unsigned long long)counts->tested, (unsigned long long)counts->events,
                  (unsigned long long)counts->touching, (unsigned long long)counts->missed,
                  (unsigned long long)counts->false_alarms, alarm_count_share(counts));
}

static void check_scene(const scene_size *size) {
    scene_motion motion = {0};
    start_motion(size, &motion);
    uint32_t const frame_count =
        is_long() ? tulle_scene_get_frame_count(motion.loaded) : size->frame_count;
    uint32_t const stride = is_long() ? LONG_FRAME_STRIDE : FRAME_STRIDE;
    for (uint32_t frame = 1; frame <= frame_count; frame++) {
        advance_frame(&motion);
        if (frame % stride != 0) continue;
        for (int k = 0; k < FACTOR_COUNT; k++) count_motion(&motion, k, 0.0, &motion.counts[k]);
    }
    alarm_counts sum = {0};
    for (int k = 0; k < FACTOR_COUNT; k++) {
        const alarm_counts *const counts = &motion.counts[k];
        print_counts(size->name, factors[k], counts);
        assert_int_equal(counts->missed, 0);
        assert_int_equal(counts->touching + counts->false_alarms, counts->events);
        sum.tested += counts->tested;
        sum.touching += counts->touching;
        sum.false_alarms += counts->false_alarms;
    }
    assert_true(sum.touching >= LEAST_TOUCHING);
    assert_true(alarm_count_share(&sum) < MOST_FALSE);
    end_motion(&motion);
}

static void false_alarms_are_few(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) check_scene(&sizes[i]);
}

/* What comes within a separation and does not touch is counted as false: the count can fail. */
static void near_misses_are_counted(void **state) {
    (void)state;
    scene_motion motion = {0};
    alarm_counts counts = {0};
    start_motion(&sizes[2], &motion);
    for (int frame = 0; frame < 13; frame++) advance_frame(&motion);
    count_motion(&motion, 1, 0.01, &counts);
    print_counts("1 cm", factors[1], &counts);
    assert_true(alarm_count_share(&counts) > MOST_FALSE);
    assert_int_equal(counts.missed, 0);
    end_motion(&motion);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(false_alarms_are_few),
        cmocka_unit_test(near_misses_are_counted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
