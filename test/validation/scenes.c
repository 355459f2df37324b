/* scenes.c - the scenes of the folder scenes/, some frames at a small size or whole: rescues per
 * contact, the exact judge, smallest gaps, and what the contact stages cost beside the solve.
 *
 * Scenes are read from $TULLE_SOURCE_DIR/scenes, else from ./scenes. Without the scene layer, which
 * needs libyaml, they are left out. */
#include "validation/validation.h"

#ifdef TULLE_HAS_SCENES
#include "scene/scene.h"
#include "tulle/check.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* Stages of tulle_stage_name. */
enum { SOLVE_STAGE = 2, FIRST_CONTACT_STAGE = 8, CHANGES_MAX = 3, BODIES_MAX = 256 };
enum { JUDGE_EVERY = 3 };

typedef struct small_scene {
    const char *name;
    unsigned steps; /* of quick runs; 0: left out of them */
    size_t change_count;
    const char *changes[CHANGES_MAX]; /* of quick runs */
    bool needs_files;                 /* meshes that are not in the repository */
} small_scene;

/* Those of the scenes that keep going; the pinch that must fail is a test of its own. */
static const small_scene SCENES[] = {
    {"needles",
     90,
     2,
     {"cloth[0].mesh.resolution=[17, 17]",
      "obstacles[2].motion.keyframes=[{time: 0.4}, {time: 0.7, translate: [0, 0, -0.22]}]"},
     false},
    {"sphere", 90, 2, {"cloth[0].mesh.resolution=[17, 17]", "obstacles[1].disappears=0.7"}, false},
    {"spikes", 70, 1, {"cloth[0].mesh.resolution=[17, 17]"}, false},
    {"layers",
     60,
     3,
     {"cloth[0].mesh.resolution=[11, 11]", "cloth[1].mesh.resolution=[11, 11]",
      "cloth[2].mesh.resolution=[9, 9]"},
     false},
    {"ribbon", 60, 1, {"cloth[0].mesh.resolution=[121, 3]"}, false},
    {"net", 30, 2, {"cloth[0].mesh.cells=[6, 6]", "cloth[0].mesh.strand=3 cm"}, false},
    {"pinch", 225, 1, {"cloth[0].mesh.resolution=[13, 13]"}, false},
    {"body", 0, 0, {NULL}, true},
    {"table", 0, 0, {NULL}, true},
    {"spot", 0, 0, {NULL}, true},
};
enum { SCENE_COUNT = sizeof SCENES / sizeof *SCENES };

typedef struct scene_record {
    uint64_t contacts, rescues, judged, crossing;
    double gap_share; /* least of minimum gaps */
    double solve_seconds, contact_seconds, largest_stretch;
} scene_record;

typedef struct open_scene {
    scene *loaded;
    scene_world built;
} open_scene;

static size_t judge(const open_scene *opened, tulle_check_body bodies[BODIES_MAX]) {
    const scene_world *const built = &opened->built;
    size_t count = 0;
    for (size_t i = 0; i < built->cloth_count && count < BODIES_MAX; i++) {
        bodies[count] = (tulle_check_body){scene_get_cloth_mesh(opened->loaded, i), 0};
        bodies[count++].mesh.positions =
            tulle_cloth_get_positions(built->world, built->cloths[i], NULL);
    }
    for (size_t i = 0; i < built->obstacle_count && count < BODIES_MAX; i++) {
        if (!tulle_obstacle_is_present(built->world, built->obstacles[i])) continue;
        bodies[count] = (tulle_check_body){scene_get_obstacle_mesh(opened->loaded, i), 1};
        bodies[count++].mesh.positions =
            tulle_obstacle_get_positions(built->world, built->obstacles[i], NULL);
    }
    tulle_check_result result = {0};
    if (tulle_check_intersections(bodies, count, 1, &result, NULL) != TULLE_OK) return SIZE_MAX;
    size_t const crossing = result.pair_count;
    tulle_check_result_destroy(&result);
    return crossing;
}

static void add_report(scene_record *record, const tulle_step_report *report) {
    record->contacts += report->contacts;
    record->rescues += report->rescue_impact_zones + report->rescue_component_scalings +
                       report->rescue_global_scalings;
    record->solve_seconds += report->stage_seconds[SOLVE_STAGE];
    for (int i = FIRST_CONTACT_STAGE; i < TULLE_STAGE_COUNT; i++)
        record->contact_seconds += report->stage_seconds[i];
    record->largest_stretch = fmax(record->largest_stretch, report->max_stretch);
}

/* Runs an open scene; the message of `error` is empty when all went well. */
static scene_record run_steps(const open_scene *opened, unsigned long steps, tulle_error *error) {
    static tulle_check_body bodies[BODIES_MAX];
    scene_record record = {.gap_share = (double)INFINITY};
    tulle_world *const world = opened->built.world;
    for (unsigned long i = 0; i < steps; i++) {
        tulle_step_report report;
        if (tulle_world_step(world, scene_get_time_step(opened->loaded), &report, error) !=
            TULLE_OK)
            return record;
        double minimum_gap;
        tulle_world_get_distances(world, NULL, NULL, &minimum_gap);
        record.gap_share = fmin(record.gap_share, report.smallest_gap / minimum_gap);
        add_report(&record, &report);
        if ((i + 1) % JUDGE_EVERY == 0) {
            record.crossing += judge(opened, bodies);
            record.judged++;
        }
    }
    return record;
}

/* Loads with the changes of a quick run or whole; false with a message when it cannot. */
static bool open(const small_scene *wanted, const validation_options *options, open_scene *opened,
                 tulle_error *error) {
    const char *const source = getenv("TULLE_SOURCE_DIR");
    char path[1024], response[64], space[64];
    snprintf(path, sizeof path, "%s/scenes/%s.yaml", source ? source : ".", wanted->name);
    snprintf(response, sizeof response, "contact.response=%s", options->response);
    snprintf(space, sizeof space, "contact.motion_space=%s", options->motion_space);
    bool const is_paper = options->response[0] == 'p';
    const char *changes[CHANGES_MAX + 2];
    size_t count = 0;
    for (size_t i = 0; options->is_quick && i < wanted->change_count; i++)
        changes[count++] = wanted->changes[i];
    changes[count++] = response;
    if (is_paper) changes[count++] = space;
    scene_problems *const problems = calloc(1, sizeof *problems);
    if (!problems) return false;
    scene_load(path, changes, count, &opened->loaded, problems);
    *error = problems->list[0];
    free(problems);
    return opened->loaded && scene_build_world(opened->loaded, options->threads, NULL,
                                               &opened->built, error) == TULLE_OK;
}

static void report_scene(validation_run *run, const char *name, const scene_record *record) {
    char what[120];
    snprintf(what, sizeof what, "%s: rescues a contact", name);
    validate_row(run, what,
                 record->contacts > 0 ? (double)record->rescues / (double)record->contacts : 0.0,
                 "", at_most(1e-3), "one in 1,000");
    snprintf(what, sizeof what, "%s: pairs of triangles that cross, every 3rd state", name);
    validate_row(run, what, (double)record->crossing, "", equals(0.0), "exact judge");
    snprintf(what, sizeof what, "%s: smallest gap over the minimum gap", name);
    validate_row(run, what, fmin(record->gap_share, 1e3), "", at_least(1.0),
                 "at most 1000 is told");
    snprintf(what, sizeof what, "%s: stages 9 to 12 over the solve, time", name);
    /* times of short runs on a busy machine are told, not judged */
    expectation const most = validate_options(run)->is_quick ? nothing() : at_most(1.0);
    validate_row(run, what, record->contact_seconds / record->solve_seconds, "", most, "");
    snprintf(what, sizeof what, "%s: largest stretch of an edge", name);
    validate_row(run, what, record->largest_stretch, "", nothing(), "");
}

static void run_scene(validation_run *run, const small_scene *wanted) {
    const validation_options *const options = validate_options(run);
    open_scene opened = {0};
    tulle_error error = {0};
    bool const is_open = open(wanted, options, &opened, &error);
    scene_record record = {0};
    if (is_open) {
        unsigned long const steps = options->is_quick
                                        ? wanted->steps
                                        : (unsigned long)scene_get_frame_count(opened.loaded) *
                                              scene_get_steps_per_frame(opened.loaded);
        record = run_steps(&opened, steps, &error);
    }
    scene_destroy_world(&opened.built);
    scene_destroy(opened.loaded);
    if (!is_open && wanted->needs_files) {
        validate_skip(run, wanted->name, error.message);
        return;
    }
    if (error.message[0]) validate_give_up(run, "%s: %s", wanted->name, error.message);
    report_scene(run, wanted->name, &record);
}

static void run_scenes(validation_run *run) {
    bool const is_quick = validate_options(run)->is_quick;
    for (int i = 0; i < SCENE_COUNT; i++)
        if (!is_quick || SCENES[i].steps > 0) run_scene(run, &SCENES[i]);
}

#else

static void run_scenes(validation_run *run) {
    validate_skip(run, "all", "built without the scene layer");
}

#endif

const experiment scenes_experiments[] = {
    {"scenes.all", "rescues, gaps, the judge and costs over all scenes", run_scenes, false},
    {0},
};
