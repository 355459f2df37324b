/* Memory that runs out anywhere: small scenes are loaded, built, started, stepped, asked and saved,
 * while each place of the code that asks for memory fails once (support/struck_calls.h); where a
 * scene has files, also each that calls the system. The call tells of it, and leaves all as it was:
 * called again it does what it does in a world that never was struck, to the last bit. */
#define _POSIX_C_SOURCE 200809L
#include "scene/scene_data.h"
#include "scene_text.h"
#include "support/struck_calls.h"

#include "tulle/check.h"
#include "tulle/paper.h"
#include "tulle/threads.h"
#include "tulle_io/cache.h"

#include <stdbool.h>

enum { STEPS_MAX = 16, TRIANGLES_MAX = 1 << 12 /* of a cloth */ };

/* A scene as text, and how many steps of it are taken. */
typedef struct small_case {
    const char *name, *text;
    int step_count;
} small_case;

#define TIME "time: {step: 1/90 s, frames: 9}\n"
#define SHEET(n) "  - mesh: {shape: rectangle, size: [0.3, 0.3], resolution: [" n "]}\n"
#define SPHERE "  - {name: ball, mesh: {shape: sphere, radius: 0.2, resolution: [6]}}\n"
static const small_case cases[] = {
    {"cloth with all keys",
     TIME
     "title: all\nseed: 7\nwind: {velocity: [1, 0, 0], gust_strength: 2, drag: 0.5}\n"
     "cloth:\n" SHEET(
         "9, 9") "    name: sheet\n    rotate: [0, 0, 30 deg]\n"
                 "    translate: [0, 0, 0.2062]\n    velocity: [0, 0, -1]\n    grain: [1, 2, 0]\n"
                 "    material: {preset: silk, name: mine, friction_across: 0.5, "
                 "stiffening_strain: 0.05}\n"
                 "    color: [1, 0, 0]\n"
                 "    pins:\n      - {nearest: [1, 1, 0], release: 0.02}\n"
                 "      - {vertices: [3, 5-6], eased: true,\n"
                 "         keyframes: [{time: 0}, {time: 0.1, translate: [0, 0, 0.01], rotate: [0, "
                 "0, 0.1]}]}\n"
                 "      - {line: {from: [0, 0, 0.2062], to: [0, 0, 1], radius: 1 mm}}\n"
                 "      - {box: {min: [-1, -1, -1], max: [-0.15, 1, 1]}}\n"
                 "obstacles:\n" SPHERE
                 "  - {name: pole, mesh: {shape: needle}, translate: [0, 0, -3], material: wood,\n"
                 "     copies: {ring: {count: 3, radius: 1}, stagger: 0.01},\n"
                 "     motion: {keyframes: [{time: 0}, {time: 1, translate: [0, 0, 0.1]}]}}\n"
                 "contact:\n  pairs: [{between: [sheet, ball], friction: 0.3, restitution: 0.5}]\n"
                 "  materials: [{between: [mine, wood], friction: 0.1}]\n"
                 "render: {camera: {orbit: [10 deg, 20 deg]}}\n",
     4},
    {"many particles",
     TIME "cloth:\n" SHEET("33, 33") "    translate: [0, 0, 0.2062]\nobstacles:\n" SPHERE, 2},
    {"voxel trees, bdf2",
     TIME
     "cloth:\n" SHEET("9, 9") "    translate: [0, 0, 0.2062]\nobstacles:\n" SPHERE
                              "contact: {method: bvox}\nsolver: {integrator: bdf2, rounds: 3}\n",
     4},
    {"refitted trees, crank-nicolson",
     TIME
     "cloth:\n" SHEET("9, 9") "    translate: [0, 0, 0.2062]\nobstacles:\n" SPHERE
                              "contact: {method: refit}\nsolver: {integrator: crank-nicolson}\n",
     4},
    {"as in the paper",
     TIME "cloth:\n" SHEET(
         "9, 9") "    translate: [0, 0, 0.2062]\nobstacles:\n" SPHERE
                 "contact: {method: paper, response: paper, motion_space: cone, cone: paper}\n",
     4},
    {"response paper, polyhedral",
     TIME "cloth:\n" SHEET("9, 9") "    translate: [0, 0, 0.2062]\n" SHEET(
         "5, 5") "    translate: [0, 0, 0.22]\n    velocity: [0, 0, -2]\n"
                 "membrane: springs\nobstacles:\n" SPHERE "contact: {response: paper}\n",
     6},
    {"layers that hit each other",
     TIME "cloth:\n" SHEET("9, 9") "    translate: [0, 0, 0.2062]\n    material: {restitution: "
                                   "0.5}\n" SHEET(
                                       "7, 6") "    translate: [0.01, 0.02, 0.245]\n    velocity: "
                                               "[0, 0, -4]\n    rotate: [0.1, 0.1, 0.3]\n"
                                               "obstacles:\n" SPHERE
                                               "contact: {patches: grow, impact_rounds: 1}\n",
     6},
    {"bodies",
     TIME "cloth:\n" SHEET(
         "7, 7") "    pins: [{vertices: [0, 6, 42, 48]}]\n"
                 "obstacles:\n  - {name: box, mesh: {shape: box, size: [0.1, 0.1, 0.05]}, "
                 "translate: [0, 0, 0.031],\n"
                 "     dynamic: {mass: 0.1, velocity: [0, 0, -3]}, copies: {row: {count: 3, "
                 "offset: [0, 0, 0.06]}}}\n"
                 "  - {mesh: {shape: plane, size: [1, 1]}, translate: [0, 0, -0.02]}\n",
     6},
    {"bodies that sleep",
     TIME "obstacles:\n  - {name: box, mesh: {shape: box, size: [0.1, 0.1, 0.05]}, translate: [0, "
          "0, 0.026],\n"
          "     dynamic: {density: 500, sleep_speed: 100, sleep_time: 0.001}, copies: {row: "
          "{count: 2, offset: [0, 0, 0.06]}}}\n"
          "  - {mesh: {shape: plane, size: [1, 1]}}\n"
          "  - {mesh: {shape: sphere, radius: 0.02, resolution: [5]}, translate: [0, 0, 0.16], "
          "appears: 0.03, dynamic: {velocity: [0, 0, -2]}}\n",
     6},
    {"cloth that sleeps",
     TIME "cloth:\n" SHEET("7, 7") "    translate: [0, 0, 0.011]\n" SHEET(
         "5, 5") "    translate: [0, 0, 0.05]\nobstacles:\n"
                 "  - {mesh: {shape: plane, size: [1, 1]}}\n"
                 "solver: {sleep_speed: 100, sleep_time: 0.001}\n",
     6},
    {"plates that close, and wait",
     TIME "cloth:\n" SHEET(
         "7, 7") "    translate: [0, 0, 0.03]\n"
                 "obstacles:\n  - {mesh: {shape: box, size: [0.4, 0.4, 0.02]}, translate: [0, 0, "
                 "0.01]}\n"
                 "  - {mesh: {shape: box, size: [0.4, 0.4, 0.02]}, translate: [0, 0, 0.05],\n"
                 "     motion: {keyframes: [{time: 0}, {time: 0.05, translate: [0, 0, -0.03]}, "
                 "{time: 0.06, translate: [0, 0, -0.03]}, {time: 0.08}]}}\n"
                 "contact: {delta_c: 2 mm, on_pinch: slow}\n",
     9},
    {"a start that is untangled",
     TIME "cloth:\n" SHEET("7, 7") "    translate: [0, 0, 0.19]\n" SHEET(
         "6, 6") "    translate: [0.05, 0, 0.19]\n    rotate: [0, 0.2, 0]\n"
                 "obstacles:\n" SPHERE "contact: {start_intersections: untangle}\n",
     1},
    {"a start that intersects",
     TIME "cloth:\n" SHEET(
         "7, 7") "    translate: [0, 0, 0.19]\n"
                 "obstacles:\n" SPHERE "  - {mesh: {shape: sphere, radius: 0.05, resolution: [5]}, "
                 "translate: [0.1, 0.1, 0.19], appears: 0.015, disappears: 0.03}\n"
                 "contact: {start_intersections: ignore}\n",
     4},
    {"obstacles that change shape",
     TIME "cloth:\n  - mesh: {shape: net, size: [0.4107, 0.4107], cells: [2, 2], "
          "strand_resolution: 1}\n    translate: [0, 0, 0.02]\n"
          "obstacles:\n  - {motion: {sequence: {files: f_%02d.obj, first: 8, last: 10, interval: "
          "0.02}}}\n"
          "  - {mesh: {file: f_08.obj}, translate: [0, 0, -1], motion: {sequence: {cache: f.pc2, "
          "interval: 0.02}}}\n",
     4},
    {"parts, places and loops",
     TIME
     "cloth:\n  - mesh: {file: f_08.obj}\n    scale: [-1, 1, 1]\n"
     "    place: {up: z, size: 30 cm, center: true, on_top_of: lift}\n"
     "    translate: [0, 0, 0.02]\n"
     "    regions: [{near: {to: lift, within: 30 cm}, shrink: 0.98}, {material: Blue Wool}]\n"
     "    rest: {creases: [{group: both, angle: 0.1}]}\n"
     "    pins: [{group: one, release: 0.01}]\n"
     "    attach: [{sphere: {center: [0.15, 0.15, 0.03], radius: 5 cm}, to: lift, stiffness: 1}]\n"
     "obstacles:\n  - name: lift\n    place: {height: 1 cm, on: ground}\n    rotate: [0.01, 0, "
     "0]\n    motion: {sequence: {files: f_%02d.obj, first: 8, last: 10, fps: 50, speed: 2, "
     "loop: repeat}}\n",
     4},
    {"a material file",
     TIME "cloth:\n" SHEET("5, 5") "    material: {file: m.yaml, friction: 0.1}\n", 1},
};

/* A scene, its world, and what the calls below give. */
typedef struct running {
    const small_case *scene;
    strike kind;
    tulle_scene *loaded;
    tulle_scene_world built;
    tulle_scene_problems *problems;
    void *saved;
    size_t saved_size;
} running;

static tulle_status load(void *context, tulle_error *error) {
    running *const run = context;
    char path[128];
    snprintf(path, sizeof path, "%s/s.yaml", folder_path);
    const char *const overrides[] = {"time.duration=", "render.exposure=2", "contact.xi=auto"};
    tulle_status const status = tulle_scene_load(path, overrides, 3, &run->loaded, run->problems);
    assert_int_equal(status == TULLE_OK, run->loaded != NULL);
    assert_int_equal(status == TULLE_OK, run->problems->total_count == 0);
    *error = run->problems->list[0];
    return status;
}

static tulle_status build(void *context, tulle_error *error) {
    running *const run = context;
    tulle_status const status = tulle_scene_build_world(run->loaded, 1, NULL, &run->built, error);
    assert_int_equal(status == TULLE_OK, run->built.world != NULL);
    return status;
}

static tulle_status start(void *context, tulle_error *error) {
    running *const run = context;
    return tulle_world_start(run->built.world, error);
}

static tulle_status step(void *context, tulle_error *error) {
    running *const run = context;
    return tulle_world_step(run->built.world, tulle_scene_get_time_step(run->loaded), NULL, error);
}

static tulle_status step_as_batch(void *context, tulle_error *error) {
    running *const run = context;
    double const time_step = tulle_scene_get_time_step(run->loaded);
    tulle_world_batch const batch = {.worlds = &run->built.world, .count = 1, .threads = 1};
    return tulle_worlds_step(&batch, time_step, error);
}

static tulle_status get_contacts(void *context, tulle_error *error) {
    running *const run = context;
    const tulle_contact *contacts = NULL;
    size_t count = 0;
    return tulle_world_get_contacts(run->built.world, &contacts, &count, error);
}

static tulle_status get_patches(void *context, tulle_error *error) {
    running *const run = context;
    tulle_status status = TULLE_OK;
    for (size_t i = 0; status == TULLE_OK && i < 2 * run->built.cloth_count; i++) {
        tulle_patch_options const options = {.time_step = 0.01, .is_in_use = i % 2};
        uint32_t labels[TRIANGLES_MAX];
        size_t count = 0;
        assert_true(tulle_scene_get_cloth_mesh(run->loaded, i / 2).triangle_count <= TRIANGLES_MAX);
        status = tulle_cloth_get_patches(run->built.world, run->built.cloths[i / 2], &options,
                                         labels, &count, error);
    }
    return status;
}

static tulle_status save(void *context, tulle_error *error) {
    running *const run = context;
    return tulle_world_save_state(run->built.world, &run->saved, &run->saved_size, error);
}

static tulle_status load_saved(void *context, tulle_error *error) {
    running *const run = context;
    return tulle_world_load_state(run->built.world, run->saved, run->saved_size, error);
}

static uint64_t get_hash(const running *run) {
    return run->built.world ? tulle_world_get_state_hash(run->built.world) : 0;
}

/* Calls until it goes well. */
static void survive(running *run, const char *name, struck_call call) {
    char title[128];
    snprintf(title, sizeof title, "%s: %s", run->scene->name, name);
    for (;;) {
        uint64_t const hash = get_hash(run);
        bool is_struck;
        if (call_struck(title, run->kind, call, run, &is_struck) == TULLE_OK) return;
        if (get_hash(run) != hash) fail_msg("%s: the state has changed", title);
    }
}

/* Runs a scene; gives the hash after each step. */
static void run_case(const small_case *scene, strike kind, uint64_t hashes[STEPS_MAX]) {
    tulle_scene_problems problems;
    running run = {.scene = scene, .kind = kind, .problems = &problems};
    survive(&run, "load", load);
    survive(&run, "build", build);
    survive(&run, "start", start);
    for (int i = 0; i < scene->step_count; i++) {
        survive(&run, "step", i % 2 == 0 ? step : step_as_batch);
        hashes[i] = get_hash(&run);
        survive(&run, "get contacts", get_contacts);
        survive(&run, "get patches", get_patches);
        survive(&run, "save", save);
        survive(&run, "load what was saved", load_saved);
        tulle_world_free_state(run.built.world, run.saved, run.saved_size);
    }
    tulle_scene_destroy_world(&run.built);
    tulle_scene_destroy(run.loaded);
}

/* A material; three frames of a square that rises, as files and as a cache. */
static void write_files(void) {
    char path[128];
    write_text_file("m.yaml", "preset: wool\nwarp: {stiffness: 4 kN/m}\n");
    write_text_file("f.pc2", "");
    snprintf(path, sizeof path, "%s/f.pc2", folder_path);
    tulle_pc2_writer *writer = NULL;
    assert_int_equal(tulle_pc2_writer_open(path, 4, 0, &writer, NULL), TULLE_OK);
    for (int frame = 0; frame < 3; frame++) {
        double const z = 0.004 * frame;
        char text[200], name[16];
        snprintf(
            text, sizeof text,
            "v -1 -1 %g\nv 1 -1 %g\nv 1 1 %g\nv -1 1 %g\ng one both\nusemtl Blue Wool\nf 1 2 3\n"
            "g both\nf 1 3 4\n",
            z, z, z, z);
        snprintf(name, sizeof name, "f_%02d.obj", 8 + frame);
        write_text_file(name, text);
        double const positions[] = {-1, -1, z, 1, -1, z, 1, 1, z, -1, 1, z};
        assert_int_equal(tulle_pc2_writer_append(writer, positions, NULL), TULLE_OK);
    }
    assert_int_equal(tulle_pc2_writer_close(writer, NULL), TULLE_OK);
}

static void every_strike_is_survived(void **state) {
    (void)state;
    write_files();
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        uint64_t expected[STEPS_MAX], hashes[STEPS_MAX];
        tulle_scene_destroy(load_good(cases[i].text));
        run_case(&cases[i], STRIKE_NOTHING, expected);
        size_t const before = count_struck_places();
        bool const has_files = strstr(cases[i].text, "file:") != NULL;
        for (int kind = 0; kind < (has_files ? STRIKE_COUNT : 1); kind++) {
            run_case(&cases[i], (strike)kind, hashes);
            for (int k = 0; k < cases[i].step_count; k++)
                if (hashes[k] != expected[k])
                    fail_msg("%s: step %d went elsewhere", cases[i].name, k);
        }
        print_message("%s: %zu places struck\n", cases[i].name, count_struck_places() - before);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_strike_is_survived)};
    return cmocka_run_group_tests(tests, NULL, remove_folder);
}
