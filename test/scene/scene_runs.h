/* scene/scene_runs.h - runs scenes of the folder scenes/: no step holds an intersection, and one
 * thread gives the same last state as two. Small here, whole with TULLE_TEST_LONG=1. */
#ifndef TULLE_TEST_SCENE_RUNS_H
#define TULLE_TEST_SCENE_RUNS_H

#include "scene/scene.h"

#include "tulle/check.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdlib.h>

#include <cmocka.h>

typedef struct small_run {
    const char *name;
    unsigned long step_count;
    tulle_status ending; /* of the whole run; TULLE_OK where no step may fail */
    double rescue_share; /* of the contacts, at most; INFINITY where it does not matter */
    size_t change_count;
    const char *changes[9];
} small_run;

/* One run: the scene, its world, and room for the judge's bodies. */
typedef struct running {
    tulle_scene *loaded;
    tulle_scene_world built;
    tulle_check_body *bodies;
} running;

/* Pairs that intersect now. */
static size_t judge(const running *run) {
    const tulle_scene_world *built = &run->built;
    size_t count = 0, vertex_count;
    for (size_t i = 0; i < built->cloth_count; i++, count++) {
        run->bodies[count] = (tulle_check_body){tulle_scene_get_cloth_mesh(run->loaded, i), 0};
        run->bodies[count].mesh.positions =
            tulle_cloth_get_positions(built->world, built->cloths[i], &vertex_count);
    }
    for (size_t i = 0; i < built->obstacle_count; i++) {
        if (!tulle_obstacle_is_present(built->world, built->obstacles[i])) continue;
        int const is_obstacle = !tulle_scene_is_obstacle_dynamic(run->loaded, i);
        run->bodies[count] =
            (tulle_check_body){tulle_scene_get_obstacle_mesh(run->loaded, i), is_obstacle};
        run->bodies[count++].mesh.positions =
            tulle_obstacle_get_positions(built->world, built->obstacles[i], &vertex_count);
    }
    tulle_check_result result;
    tulle_error error = {0};
    if (tulle_check_intersections(run->bodies, count, 1, &result, &error) != TULLE_OK)
        fail_msg("%s", error.message);
    size_t pair_count = result.pair_count;
    tulle_check_result_destroy(&result);
    return pair_count;
}

static bool load(const small_run *wanted, bool is_whole, running *run) {
    const char *source = getenv("TULLE_SOURCE_DIR");
    char path[1024];
    if (snprintf(path, sizeof path, "%s/scenes/%s.yaml", source ? source : ".", wanted->name) < 0)
        return false;
    tulle_scene_problems *problems = calloc(1, sizeof *problems);
    assert_non_null(problems);
    tulle_scene_load(path, wanted->changes, is_whole ? 0 : wanted->change_count, &run->loaded,
                     problems);
    bool const is_missing = !run->loaded && problems->list[0].status == TULLE_ERROR_IO;
    if (!run->loaded && !is_missing) scene_print_problems(problems, stderr);
    free(problems);
    if (!is_missing) assert_non_null(run->loaded);
    return !is_missing;
}

/* Sums over the steps of a run. */
typedef struct run_sums {
    uint64_t contacts, rescues;
} run_sums;

static run_sums step_world(const small_run *wanted, const running *run, unsigned long step_count,
                           bool is_judged) {
    tulle_error error = {0};
    tulle_status status = TULLE_OK;
    double const time_step = tulle_scene_get_time_step(run->loaded);
    run_sums sums = {0, 0};
    for (unsigned long step = 0; status == TULLE_OK && step < step_count; step++) {
        tulle_step_report report;
        status = tulle_world_step(run->built.world, time_step, &report, &error);
        if (status == TULLE_OK) {
            sums.contacts += report.contacts;
            sums.rescues += report.rescue_impact_zones + report.rescue_component_scalings +
                            report.rescue_global_scalings;
        }
        size_t const pair_count = is_judged ? judge(run) : 0;
        if (pair_count > 0)
            fail_msg("%s, step %lu: %zu intersections", wanted->name, step, pair_count);
    }
    if (status != wanted->ending) fail_msg("%s: %d, %s", wanted->name, status, error.message);
    return sums;
}

/* Runs a scene on `threads` threads; gives the hash of its last state. False: files are missing. */
static bool run_scene(const small_run *wanted, int threads, bool is_judged, uint64_t *hash) {
    const char *choice = getenv("TULLE_TEST_LONG");
    bool is_whole = choice && choice[0] == '1';
    running run = {0};
    if (!load(wanted, is_whole, &run)) return false;
    tulle_error error = {0};
    tulle_status status = tulle_scene_build_world(run.loaded, threads, NULL, &run.built, &error);
    if (status != TULLE_OK) fail_msg("%s: %s", wanted->name, error.message);
    run.bodies = calloc(run.built.cloth_count + run.built.obstacle_count, sizeof(tulle_check_body));
    assert_non_null(run.bodies);
    unsigned long step_count = wanted->step_count;
    if (is_whole)
        step_count = (unsigned long)tulle_scene_get_frame_count(run.loaded) *
                     tulle_scene_get_steps_per_frame(run.loaded);
    run_sums const sums = step_world(wanted, &run, step_count, is_judged);
    if (sums.contacts == 0) fail_msg("%s: nothing touched", wanted->name);
    if ((double)sums.rescues > wanted->rescue_share * (double)sums.contacts)
        fail_msg("%s: %d rescues in %d contacts", wanted->name, (int)sums.rescues,
                 (int)sums.contacts);
    if (is_judged)
        print_message("%s: %d contacts, %d rescues\n", wanted->name, (int)sums.contacts,
                      (int)sums.rescues);
    *hash = tulle_world_get_state_hash(run.built.world);
    tulle_scene_destroy_world(&run.built);
    tulle_scene_destroy(run.loaded);
    free(run.bodies);
    return true;
}

/* Runs all of them; returns how many were there. */
static size_t run_scenes(const small_run *wanted, size_t count) {
    size_t run_count = 0;
    for (size_t i = 0; i < count; i++) {
        uint64_t two = 0, one = 1;
        if (!run_scene(&wanted[i], 2, true, &two) || !run_scene(&wanted[i], 1, false, &one)) {
            print_message("%s: skipped, its files are missing\n", wanted[i].name);
            continue;
        }
        print_message("%s: %016llx\n", wanted[i].name, (unsigned long long)two);
        if (one != two) fail_msg("%s: another state with one thread", wanted[i].name);
        run_count++;
    }
    return run_count;
}

#endif
