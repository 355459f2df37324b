/* scenes.c - the scenes of the folder scenes/, an experiment each, some frames at a small size or
 * whole: rescues per contact, the exact judge, smallest gaps, and what the contact stages cost
 * beside the solve. The one that is missing, the pinch that must fail, is a test of its own.
 *
 * Scenes are read from $TULLE_SOURCE_DIR/scenes, else from ./scenes. */
#include "validation/validation.h"

#include "scene/scene.h"
#include "tulle/check.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Stages of tulle_stage_name: solve_motion; resolve_impacts and those after it. */
enum { SOLVE_STAGE = 6, FIRST_CONTACT_STAGE = 7, CHANGES_MAX = 3, BODIES_MAX = 256 };

/* A scene as quick runs have it. */
typedef struct small_scene {
    const char *name;
    unsigned steps; /* 0: only whole */
    size_t change_count;
    const char *changes[CHANGES_MAX];
} small_scene;

static const small_scene SMALL_SCENES[] = {
    {"needles",
     90,
     2,
     {"cloth[0].mesh.resolution=[17, 17]",
      "obstacles[2].motion.keyframes=[{time: 0.4}, {time: 0.7, translate: [0, 0, -0.22]}]"}},
    {"sphere", 90, 2, {"cloth[0].mesh.resolution=[17, 17]", "obstacles[1].disappears=0.7"}},
    {"spikes", 70, 1, {"cloth[0].mesh.resolution=[17, 17]"}},
    {"layers",
     60,
     3,
     {"cloth[0].mesh.resolution=[11, 11]", "cloth[1].mesh.resolution=[11, 11]",
      "cloth[2].mesh.resolution=[9, 9]"}},
    {"ribbon", 60, 1, {"cloth[0].mesh.resolution=[121, 3]"}},
    {"net", 30, 2, {"cloth[0].mesh.cells=[6, 6]", "cloth[0].mesh.strand=3 cm"}},
    {"pinch", 225, 1, {"cloth[0].mesh.resolution=[13, 13]"}},
    {"ball", 90, 1, {"cloth[0].mesh.resolution=[13, 13]"}},
    {"boxes", 120, 1, {"cloth[0].mesh.resolution=[11, 11]"}},
    {"rings", 120, 1, {"cloth[0].mesh.resolution=[48, 9]"}},
    {"hammock", 90, 1, {"cloth[0].mesh.resolution=[19, 11]"}},
    {"chain", 30, 1, {"cloth[0].mesh.resolution=[24, 3]"}},
};
enum { SMALL_SCENE_COUNT = sizeof SMALL_SCENES / sizeof *SMALL_SCENES };

typedef struct scene_record {
    uint64_t contacts, rescues, crossing;
    double gap_share; /* least of minimum gaps */
    double solve_seconds, contact_seconds, largest_stretch;
} scene_record;

typedef struct open_scene {
    tulle_scene *loaded;
    tulle_scene_world built;
} open_scene;

static void close_scene(void *object) {
    open_scene *const opened = object;
    tulle_scene_destroy_world(&opened->built);
    tulle_scene_destroy(opened->loaded);
}

/* Pairs of triangles that cross. Rigid bodies meet obstacles too, so they count as cloth. */
static size_t judge(validation_run *run, const open_scene *opened) {
    static tulle_check_body bodies[BODIES_MAX];
    const tulle_scene_world *const built = &opened->built;
    size_t count = 0;
    if (built->cloth_count + built->obstacle_count > BODIES_MAX)
        validate_give_up(run, "too many bodies to judge");
    for (size_t i = 0; i < built->cloth_count; i++) {
        bodies[count] = (tulle_check_body){tulle_scene_get_cloth_mesh(opened->loaded, i), 0};
        bodies[count++].mesh.positions =
            tulle_cloth_get_positions(built->world, built->cloths[i], NULL);
    }
    for (size_t i = 0; i < built->obstacle_count; i++) {
        if (!tulle_obstacle_is_present(built->world, built->obstacles[i])) continue;
        bodies[count] = (tulle_check_body){tulle_scene_get_obstacle_mesh(opened->loaded, i),
                                           !tulle_scene_is_obstacle_dynamic(opened->loaded, i)};
        bodies[count++].mesh.positions =
            tulle_obstacle_get_positions(built->world, built->obstacles[i], NULL);
    }
    tulle_check_result result = {0};
    tulle_error error = {0};
    if (tulle_check_intersections(bodies, count, 1, &result, &error) != TULLE_OK)
        validate_give_up(run, "judge: %s", error.message);
    size_t const crossing = result.pair_count;
    validate_count_judgement(run, crossing);
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

static scene_record run_steps(validation_run *run, const open_scene *opened, unsigned long steps) {
    scene_record record = {.gap_share = (double)INFINITY};
    tulle_world *const world = opened->built.world;
    double const time_step = tulle_scene_get_time_step(opened->loaded);
    unsigned long const steps_per_frame = tulle_scene_get_steps_per_frame(opened->loaded);
    validate_plan(run, (long)steps);
    for (unsigned long i = 0; i < steps; i++) {
        tulle_step_report report;
        tulle_error error = {0};
        if (tulle_world_step(world, time_step, &report, &error) != TULLE_OK)
            validate_give_up(run, "step at %g s: %s", tulle_world_get_time(world), error.message);
        double minimum_gap;
        tulle_world_get_distances(world, NULL, NULL, &minimum_gap);
        record.gap_share = fmin(record.gap_share, report.smallest_gap / minimum_gap);
        add_report(&record, &report);
        validate_count_step(run, &report, minimum_gap);
        if ((i + 1) % steps_per_frame == 0) record.crossing += judge(run, opened);
    }
    return record;
}

/* Loads, with the changes of a quick run if there are some, and builds; false with a message. */
static bool open_world(validation_run *run, const small_scene *small, open_scene *opened,
                       tulle_error *error) {
    const validation_options *const options = validate_options(run);
    const char *const source = getenv("TULLE_SOURCE_DIR");
    char path[1024], response[64], space[64];
    snprintf(path, sizeof path, "%s/scenes/%s.yaml", source ? source : ".", validate_subject(run));
    snprintf(response, sizeof response, "contact.response=%s", options->response);
    snprintf(space, sizeof space, "contact.motion_space=%s", options->motion_space);
    const char *changes[CHANGES_MAX + 2];
    size_t count = 0;
    for (size_t i = 0; small && i < small->change_count; i++) changes[count++] = small->changes[i];
    changes[count++] = response;
    if (options->response[0] == 'p') changes[count++] = space;
    tulle_scene_problems *const problems = validate_allocate(run, sizeof *problems);
    tulle_scene_load(path, changes, count, &opened->loaded, problems);
    *error = problems->list[0];
    return opened->loaded && tulle_scene_build_world(opened->loaded, options->threads, NULL,
                                                     &opened->built, error) == TULLE_OK;
}

static void report_scene(validation_run *run, const scene_record *record) {
    validate_row(run, "rescues a contact",
                 record->contacts > 0 ? (double)record->rescues / (double)record->contacts : 0.0,
                 "", at_most(1e-3), "one in 1,000");
    validate_row(run, "pairs of triangles that cross, every frame", (double)record->crossing, "",
                 equals(0.0), "exact judge");
    validate_row(run, "smallest gap over the minimum gap", fmin(record->gap_share, 1e3), "",
                 at_least(1.0), "at most 1000 is told");
    /* times of short runs on a busy machine are told, not judged */
    expectation const most = validate_options(run)->is_quick ? nothing() : at_most(1.0);
    validate_row(run, "stages 8 to 10 over the solve, time",
                 record->contact_seconds / record->solve_seconds, "", most, "");
    validate_row(run, "time of the solve", record->solve_seconds, "s", nothing(), "");
    validate_row(run, "contacts, summed over steps", (double)record->contacts, "", nothing(), "");
    validate_row(run, "largest stretch of an edge", record->largest_stretch, "", nothing(), "");
}

static const small_scene *find_small(const char *name) {
    for (int i = 0; i < SMALL_SCENE_COUNT; i++)
        if (strcmp(SMALL_SCENES[i].name, name) == 0) return &SMALL_SCENES[i];
    return NULL;
}

/* Without the files of its meshes a scene is skipped, if it is one that has some. */
static void run_whole(validation_run *run, bool has_files) {
    bool const is_quick = validate_options(run)->is_quick;
    const small_scene *const small = is_quick ? find_small(validate_subject(run)) : NULL;
    open_scene *const opened = validate_allocate(run, sizeof *opened);
    validate_own(run, opened, close_scene);
    tulle_error error = {0};
    if (!open_world(run, small, opened, &error)) {
        if (!has_files) validate_give_up(run, "%s", error.message);
        validate_skip(run, "the whole", error.message);
        return;
    }
    unsigned long const whole = (unsigned long)tulle_scene_get_frame_count(opened->loaded) *
                                tulle_scene_get_steps_per_frame(opened->loaded);
    scene_record const record = run_steps(run, opened, small ? small->steps : whole);
    report_scene(run, &record);
}

static void run_scene(validation_run *run) { run_whole(run, false); }
/* Of meshes that are not in the repository. */
static void run_scene_of_files(validation_run *run) { run_whole(run, true); }

const experiment scenes_experiments[] = {
    {"scenes.needles", "a sheet on eighty needles that leave one by one", run_scene, false},
    {"scenes.spikes", "a sheet falls on seven spikes", run_scene, false},
    {"scenes.sphere", "a sheet drapes over a sphere, which then is gone", run_scene, false},
    {"scenes.layers", "three sheets slide off a tilted box", run_scene, false},
    {"scenes.ribbon", "a ribbon piles up on itself", run_scene, false},
    {"scenes.net", "a net over nails with heads", run_scene, false},
    {"scenes.pinch", "a sheet between plates that close", run_scene, false},
    {"scenes.table", "a tablecloth on a table", run_scene_of_files, true},
    {"scenes.spot", "a sheet over a cow, cones, pyramids and a blade", run_scene_of_files, true},
    {"scenes.body", "a sheet over a dancing body", run_scene_of_files, true},
    {"scenes.ball", "a ball thrown into a sheet", run_scene, false},
    {"scenes.boxes", "boxes on a sheet", run_scene, false},
    {"scenes.rings", "rings over a cape and on a rod", run_scene, false},
    {"scenes.hammock", "boxes of 0.2 to 2 kg in a hammock", run_scene, false},
    {"scenes.chain", "twenty rings of a chain and a loop of cloth", run_scene, false},
    {0},
};
