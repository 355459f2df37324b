/* fuzz/targets/scene.c - scene files: reading one; the canonical text leads to the same scene; the
 * world is built and, where it is small, started and stepped. */
#include "support/mesh_file.h"

#include "scene/scene_data.h"
#include "tulle_io/mesh_files.h"
#include "tulle_io/scene.h"

#include <stdlib.h>
#include <string.h>

enum {
    RESOLUTION_MAX = 40, /* inputs that ask for more would measure the generators' speed */
    COPIES_MAX = 60,
    STEPPED_VERTICES_MAX = 300,
    QUESTIONS_MAX = 2000 /* until a start or step is asked to stop */
};

static tulle_scene_problems problems;

/* Files that a scene may name. */
static void put_files(void) {
    static bool are_there;
    static const char *const names[] = {"mesh.obj", "frame_0.obj", "frame_1.obj"};
    if (are_there) return;
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        tulle_mesh mesh = fuzz_make_mesh(0);
        FUZZ_CHECK(tulle_mesh_write(fuzz_path(names[i]), tulle_mesh_get_view(&mesh), NULL) ==
                   TULLE_OK);
        tulle_mesh_destroy(&mesh);
    }
    static const char named[] =
        "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\no sheet\ng left all\n"
        "usemtl wool\nf 1 2 5 4\ng right all\nusemtl silk\nf 2 3 6 5\n";
    fuzz_put_file("named.obj", named, strlen(named));
    are_there = true;
}

static bool is_small_mesh(const mesh_keys *keys) {
    for (size_t i = 0; i < keys->resolution.count; i++)
        if (keys->resolution.value[i] > RESOLUTION_MAX) return false;
    for (size_t i = 0; i < keys->cells.count; i++)
        if (keys->cells.value[i] > RESOLUTION_MAX / 2) return false;
    return keys->strand_resolution <= 4;
}

/* Whether the scene can be made in little time, as far as its keys tell. */
static bool is_small(const char *path) {
    tulle_scene scene = {.heap = memory_default(), .path = path};
    scene.storage = arena_make(&scene.heap);
    const scene_work work = {&scene, &problems};
    memset(&problems, 0, sizeof problems);
    bool is_good = read_scene_keys(&work, NULL, 0);
    size_t copies = 0;
    for (size_t i = 0; is_good && i < scene.keys.cloth.count; i++)
        is_good = is_small_mesh(&((const cloth_keys *)scene.keys.cloth.items)[i].mesh);
    for (size_t i = 0; is_good && i < scene.keys.obstacles.count; i++) {
        const obstacle_keys *const keys = &((const obstacle_keys *)scene.keys.obstacles.items)[i];
        copies += count_copies(keys);
        is_good = is_small_mesh(&keys->mesh) && copies <= COPIES_MAX;
    }
    /* Keys that are wrong are told by the load. */
    bool const has_problems = problems.total_count > 0;
    arena_destroy(&scene.storage);
    return is_good || has_problems;
}

static int stop_after_a_while(void *context) { return ++*(int *)context > QUESTIONS_MAX; }

static void run(tulle_scene *scene) {
    tulle_scene_world built;
    tulle_error error = {0};
    tulle_status status = tulle_scene_build_world(scene, 1, NULL, &built, &error);
    if (status) {
        fuzz_check_error(status, &error);
        FUZZ_CHECK(!built.world);
        return;
    }
    size_t vertex_count = 0;
    for (size_t i = 0; i < built.cloth_count; i++)
        vertex_count += tulle_scene_get_cloth_mesh(scene, i).vertex_count;
    for (size_t i = 0; i < built.obstacle_count; i++)
        vertex_count += tulle_scene_get_obstacle_mesh(scene, i).vertex_count;
    if (vertex_count <= STEPPED_VERTICES_MAX) {
        int questions = 0;
        tulle_world_set_stop_request(built.world, stop_after_a_while, &questions);
        status = tulle_world_step(built.world, tulle_scene_get_time_step(scene), NULL, &error);
        if (status) fuzz_check_error(status, &error);
    }
    tulle_scene_destroy_world(&built);
}

/* The canonical text loads to the same scene. */
static void check_canonical(const tulle_scene *scene) {
    const char *const text = tulle_scene_get_canonical_text(scene);
    const char *const path = fuzz_put_file("canonical.yaml", text, strlen(text));
    tulle_scene *again = NULL;
    tulle_status const status = tulle_scene_load(path, NULL, 0, &again, &problems);
    FUZZ_CHECK_OK(status, &problems.list[0]);
    FUZZ_CHECK(strcmp(tulle_scene_get_canonical_text(again), text) == 0);
    FUZZ_CHECK(tulle_scene_get_hash(again) == tulle_scene_get_hash(scene));
    tulle_scene_destroy(again);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    put_files();
    const char *const path = fuzz_put_file("scene.yaml", data, size);
    if (!is_small(path)) return 0;
    tulle_scene *scene = NULL;
    tulle_status const status = tulle_scene_load(path, NULL, 0, &scene, &problems);
    if (status) {
        FUZZ_CHECK(!scene && problems.count > 0 && problems.total_count >= problems.count);
        FUZZ_CHECK(problems.list[0].status == status);
        for (size_t i = 0; i < problems.count; i++)
            fuzz_check_error(problems.list[i].status, &problems.list[i]);
        return 0;
    }
    check_canonical(scene);
    run(scene);
    tulle_scene_destroy(scene);
    return 0;
}

void fuzz_make_seeds(void) {
    fuzz_put_text_seed(
        "cloth", "time: {step: 1/90 s, frames: 2, steps_per_frame: 2}\nseed: 3\n"
                 "cloth:\n  - name: sheet\n    mesh: {shape: rectangle, size: [1, 50 cm], "
                 "resolution: [5, 4]}\n    translate: [0, 0, 0.4]\n    material: {preset: silk}\n"
                 "    pins:\n      - vertices: [0, 2-3]\n        release: 0.5 s\n"
                 "obstacles:\n  - mesh: {shape: sphere, radius: 30 cm, resolution: 3}\n"
                 "    translate: [0, 0, 0]\n");
    fuzz_put_text_seed("copies",
                       "time: {duration: 0.1}\nwind: {velocity: [1, 0, 0], gusts: 1}\n"
                       "obstacles:\n  - mesh: {shape: box, size: [0.1, 0.1, 0.1], resolution: 2}\n"
                       "    dynamic: {density: 300}\n    copies: {grid: {count: [2, 2], "
                       "spacing: [0.3, 0.3]}}\n    translate: [0, 0, 1]\n"
                       "  - mesh: {file: mesh.obj}\n    rotate: {axis: [0, 0, 1], angle: 30 deg}\n"
                       "    motion: {keyframes: [{time: 0}, {time: 1, translate: [0, 0, 0.1]}]}\n");
    fuzz_put_text_seed("names",
                       "time: {frames: 1}\ncloth:\n  - mesh: {file: named.obj}\n"
                       "    place: {up: y, size: 1 m, center: true, on_top_of: it}\n"
                       "    scale: [-1, 1, 1]\n    translate: [0, 0, 5 cm]\n"
                       "    pins: [{group: left}, {sphere: {center: [0, 0, 1], radius: 1}}]\n"
                       "    regions: [{material: wool, shrink: 0.9}]\n"
                       "    rest: {creases: [{group: all, angle: 1}]}\n"
                       "    attach: [{near: {to: it, within: 2}, to: it}]\nobstacles:\n"
                       "  - name: it\n    place: {height: 50 cm, on: ground}\n"
                       "    motion: {sequence: {files: frame_%d.obj, first: 0, last: 1, "
                       "fps: 24, speed: 2, loop: pingpong}}\n");
    fuzz_put_text_seed("sequence",
                       "time: {frames: 1}\ncloth: [{mesh: {file: mesh.obj}, "
                       "translate: [0, 0, 1]}]\nobstacles:\n  - motion: {sequence: "
                       "{files: frame_%d.obj, first: 0, last: 1, interval: 0.1}}\n"
                       "contact: {response: paper, method: paper, on_pinch: slow}\n"
                       "solver: {integrator: bdf2}\nrender: {camera: {position: [1, 1, 1]}}\n");
}
