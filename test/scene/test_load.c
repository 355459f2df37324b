/* Scenes made of objects: placement, copies, pins, motion, mesh sequences, names, hashes, and every
 * refusal that needs the meshes, with its place. */
#define _POSIX_C_SOURCE 200809L
#include "scene/scene_data.h"
#include "scene_text.h"

#include "tulle_io/cache.h"

#include <math.h>
#include <unistd.h>

#define TIME "time: {frames: 3}\n"
#define SHEET "cloth:\n  - mesh: {shape: rectangle, size: [2, 2], resolution: [3, 3]}\n"

static void assert_near(const double *found, double x, double y, double z) {
    const double wanted[3] = {x, y, z};
    for (int k = 0; k < 3; k++)
        if (!(fabs(found[k] - wanted[k]) < 1e-12)) {
            print_error("found %g %g %g, wanted %g %g %g\n", found[0], found[1], found[2], x, y, z);
            fail();
        }
}

static void get_bounds(tulle_mesh_view mesh, double low[3], double high[3]) {
    for (int k = 0; k < 3; k++) low[k] = (double)INFINITY, high[k] = -(double)INFINITY;
    for (size_t i = 0; i < 3 * mesh.vertex_count; i++) {
        low[i % 3] = fmin(low[i % 3], mesh.positions[i]);
        high[i % 3] = fmax(high[i % 3], mesh.positions[i]);
    }
}

static void test_placement_and_time(void **state) {
    (void)state;
    tulle_scene *loaded =
        load_good("time: {step: 10 ms, duration: 1 s, steps_per_frame: 3}\nseed: 5\n"
                  "cloth:\n"
                  "  - mesh: {shape: rectangle, size: [2, 4], resolution: [3, 3]}\n"
                  "    scale: [1, 0.5, 1]\n"
                  "    rotate: [90 deg, 0, 90 deg]\n"
                  "    translate: [0, 0, 7]\n"
                  "  - {mesh: {shape: disc}, name: round}\n");
    assert_true(tulle_scene_get_time_step(loaded) == 0.01);
    assert_int_equal(tulle_scene_get_frame_count(loaded), 34); /* 33.3, rounded up */
    assert_int_equal(tulle_scene_get_steps_per_frame(loaded), 3);
    assert_int_equal(tulle_scene_get_seed(loaded), 5);
    assert_int_equal(tulle_scene_get_cloth_count(loaded), 2);
    assert_int_equal(tulle_scene_get_obstacle_count(loaded), 0);
    assert_string_equal(tulle_scene_get_cloth_name(loaded, 0), "cloth0");
    assert_string_equal(tulle_scene_get_cloth_name(loaded, 1), "round");
    /* y of the sheet becomes z, then x becomes y. */
    double low[3], high[3];
    get_bounds(tulle_scene_get_cloth_mesh(loaded, 0), low, high);
    assert_near(low, 0, -1, 6);
    assert_near(high, 0, 1, 8);
    tulle_scene_destroy(loaded);
}

static void test_copies(void **state) {
    (void)state;
    tulle_scene *loaded = load_good(
        TIME SHEET "obstacles:\n"
                   "  - {name: a, mesh: {shape: box}, scale: 0.1, translate: [0, 0, 1],\n"
                   "     copies: {row: {count: 3, offset: [0, 2, 0]}}}\n"
                   "  - {name: b, mesh: {shape: box}, copies: {grid: {count: [2, 3], spacing: [1, "
                   "2]}}}\n"
                   "  - {name: c, mesh: {shape: box}, copies: {ring: {count: 4, radius: 2}},\n"
                   "     motion: {keyframes: [{time: 0}, {time: 1, translate: [1, 0, 0]}]}}\n"
                   "  - {name: d, mesh: {shape: cone},\n"
                   "     copies: {spiral: {count: 80, radius: 0.5, from: 10 deg, to: 80 deg}, "
                   "stagger: 50 ms,\n"
                   "              order: last-to-first},\n"
                   "     motion: {keyframes: [{time: 2}, {time: 3, translate: [0, 0, -1]}]}}\n");
    assert_int_equal(tulle_scene_get_obstacle_count(loaded), 3 + 6 + 4 + 80);
    assert_string_equal(tulle_scene_get_obstacle_name(loaded, 2), "a.002");
    double low[3], high[3];
    get_bounds(tulle_scene_get_obstacle_mesh(loaded, 2), low, high);
    assert_near((double[3]){(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2},
                0, 4, 1);
    get_bounds(tulle_scene_get_obstacle_mesh(loaded, 3), low, high);
    assert_near((double[3]){(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, 0}, -0.5, -2, 0);
    assert_false(tulle_scene_is_obstacle_moving(loaded, 0));
    assert_true(tulle_scene_is_obstacle_moving(loaded, 9));
    /* On a ring, a copy moves along its own axes: the second one, at +y, outwards. */
    assert_near(loaded->obstacles[10].motion.keys[1].translation, 0, 1, 0);
    assert_near(loaded->obstacles[10].motion.pivot, 0, 2, 0);
    /* On a spiral, even distances, all on the sphere, motion towards its centre, last one first. */
    const scene_obstacle *needles = loaded->obstacles + 13;
    double shortest = (double)INFINITY, longest = 0;
    for (int i = 0; i < 80; i++) {
        const double *p = needles[i].motion.pivot, *t = needles[i].motion.keys[1].translation;
        assert_true(fabs(sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]) - 0.5) < 1e-12);
        assert_near(t, -2 * p[0], -2 * p[1], -2 * p[2]);
        assert_true(fabs(needles[i].motion.keys[0].time - (2 + 0.05 * (79 - i))) < 1e-12);
        if (i == 0) continue;
        const double *q = needles[i - 1].motion.pivot;
        double distance = sqrt((p[0] - q[0]) * (p[0] - q[0]) + (p[1] - q[1]) * (p[1] - q[1]) +
                               (p[2] - q[2]) * (p[2] - q[2]));
        shortest = fmin(shortest, distance), longest = fmax(longest, distance);
    }
    assert_true(longest < 1.15 * shortest); /* even along the curve, chords a little less so */
    assert_true(fabs(acos(needles[0].motion.pivot[2] / 0.5) - 0.17453292519943295) < 1e-6);
    assert_true(fabs(acos(needles[79].motion.pivot[2] / 0.5) - 1.3962634015954636) < 1e-6);
    tulle_scene_destroy(loaded);
}

static void test_pins(void **state) {
    (void)state;
    tulle_scene *loaded =
        load_good(TIME SHEET "    pins:\n"
                             "      - {nearest: [9, 9, 0]}\n"
                             "      - {box: {min: [0.5, -2, -1], max: [2, 2, 1]}, release: 2 s}\n"
                             "      - {line: {from: [-1, -1, 0], to: [-1, 0, 0]}, eased: true,\n"
                             "         keyframes: [{time: 0}, {time: 1, rotate: [0, 0, 90 deg]}]}\n"
                             "      - {vertices: [4, 4]}\n");
    const scene_cloth *cloth = &loaded->cloths[0];
    assert_int_equal(cloth->pin_count, 4);
    assert_int_equal(cloth->pins[0].vertex_count, 1);
    const double *corner = cloth->mesh.positions + 3 * cloth->pins[0].vertices[0];
    assert_near(corner, 1, 1, 0);
    assert_int_equal(cloth->pins[1].vertex_count, 2); /* one of the three is taken already */
    assert_true(cloth->pins[1].release_time == 2);
    assert_true(cloth->pins[0].release_time == (double)INFINITY);
    assert_int_equal(cloth->pins[2].vertex_count, 2);
    assert_int_equal(cloth->pins[2].motion.key_count, 2);
    assert_true(cloth->pins[2].motion.is_eased);
    assert_near(cloth->pins[2].motion.pivot, -1, -0.5, 0);
    assert_true(fabs(cloth->pins[2].motion.keys[1].rotation_vector[2] - acos(0.0)) < 1e-12);
    assert_int_equal(cloth->pins[3].vertex_count, 1);
    tulle_scene_destroy(loaded);
}

static const char square[] = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";

static void write_frames(void) {
    write_text_file("f_08.obj", square);
    write_text_file("f_09.obj", "v 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nf 1 2 3\nf 1 3 4\n");
    write_text_file("f_10.obj", "v 0 0 3\nv 1 0 3\nv 1 1 3\nv 0 1 3\nf 1 2 3\nf 1 3 4\n");
}

#define SEQUENCE(more)                                                                             \
    TIME SHEET "obstacles:\n"                                                                      \
               "  - translate: [5, 0, 0]\n"                                                        \
               "    scale: 2\n"                                                                    \
               "    motion: {sequence: {files: f_%02d.obj, first: 8, last: 10, interval: 1, "      \
               "start: 2}}\n" more

static void test_sequence_of_files(void **state) {
    (void)state;
    write_frames();
    tulle_scene *loaded = load_good(SEQUENCE("    copies: {row: {count: 2, offset: [0, 1, 0]}}\n"));
    assert_int_equal(tulle_scene_get_obstacle_count(loaded), 2);
    assert_true(tulle_scene_is_obstacle_moving(loaded, 1));
    scene_sequence *sequence = loaded->obstacles[1].sequence;
    assert_int_equal(sequence_get_frame_count(sequence), 3);
    double positions[12];
    tulle_error error;
    static const uint32_t order[] = {0, 1, 2, 1, 0, 2, 2, 0};
    static const double heights[] = {0, 2, 6};
    for (size_t i = 0; i < sizeof order / sizeof order[0]; i++) {
        assert_int_equal(sequence_read(sequence, order[i], positions, &error), TULLE_OK);
        assert_near(positions + 6, 7, 3, heights[order[i]]);
    }
    assert_near(tulle_scene_get_obstacle_mesh(loaded, 1).positions, 5, 1, 0);
    assert_int_equal(sequence_read(sequence, 3, positions, &error), TULLE_ERROR_INVALID_ARGUMENT);
    /* A file that vanishes or changes while the run goes on is an error, not a crash. */
    write_text_file("f_09.obj", "v 0 0 1\nv 1 0 1\nv 1 1 1\nf 1 2 3\n");
    assert_int_equal(sequence_read(sequence, 2, positions, &error), TULLE_OK);
    assert_int_equal(sequence_read(sequence, 0, positions, &error), TULLE_OK);
    assert_int_equal(sequence_read(sequence, 1, positions, &error), TULLE_ERROR_INVALID_MESH);
    assert_non_null(strstr(error.file, "f_09.obj"));
    tulle_scene_destroy(loaded);
}

static void write_cache(double last_height) {
    char path[128];
    snprintf(path, sizeof path, "%s/c.pc2", folder_path);
    write_text_file("c.pc2", "");
    tulle_pc2_writer *writer = NULL;
    tulle_error error;
    assert_int_equal(tulle_pc2_writer_open(path, 4, 0, &writer, &error), TULLE_OK);
    for (int frame = 0; frame < 3; frame++) {
        double z = frame == 2 ? last_height : frame;
        const double positions[12] = {0, 0, z, 1, 0, z, 1, 1, z, 0, 1, z};
        assert_int_equal(tulle_pc2_writer_append(writer, positions, &error), TULLE_OK);
    }
    assert_int_equal(tulle_pc2_writer_close(writer, &error), TULLE_OK);
}

static void test_sequence_of_cache(void **state) {
    (void)state;
    write_text_file("q.obj", square);
    write_cache(4);
    tulle_scene *loaded = load_good(TIME SHEET "obstacles:\n"
                                               "  - mesh: {file: q.obj}\n"
                                               "    motion: {sequence: {cache: c.pc2, first: 1, "
                                               "interval: 1}}\n");
    scene_sequence *sequence = loaded->obstacles[0].sequence;
    assert_int_equal(sequence_get_frame_count(sequence), 2);
    double positions[12];
    tulle_error error;
    assert_int_equal(sequence_read(sequence, 1, positions, &error), TULLE_OK);
    assert_near(positions + 6, 1, 1, 4);
    assert_near(tulle_scene_get_obstacle_mesh(loaded, 0).positions, 0, 0, 1);
    tulle_scene_destroy(loaded);
}

/* A refusal with its place: line 0 for places outside the scene file. */
typedef struct refusal {
    const char *text;
    tulle_status status;
    const char *file;
    int line, column;
    const char *message;
} refusal;

#define NOTHING_MOVES "nothing moves: the scene needs a cloth, or an obstacle that is dynamic"
static const refusal refusals[] = {
    {TIME "cloth:\n  - mesh: {shape: rectangle, resolution: [1000000, 1000000]}\n",
     TULLE_ERROR_LIMIT, "s.yaml", 3, 5, "cloth[0].mesh: "},
    {TIME "cloth:\n  - mesh: {shape: rectangle, size: [1, 2, 3]}\n", TULLE_ERROR_PARSE, "s.yaml", 3,
     36, "cloth[0].mesh.size: is a list of 3, must be a list of 2 for shape rectangle"},
    {TIME SHEET "obstacles:\n  - mesh: {shape: sphere, resolution: [24, 12]}\n", TULLE_ERROR_PARSE,
     "s.yaml", 5, 39,
     "obstacles[0].mesh.resolution: is [24, 12]; shape sphere has one resolution, as in [24]"},
    {TIME SHEET "obstacles:\n  - mesh: {shape: box, resolution: [4, 9]}\n", TULLE_ERROR_PARSE,
     "s.yaml", 5, 36,
     "obstacles[0].mesh.resolution: is [4, 9]; shape box has one resolution, as in [4]"},
    {TIME "cloth:\n  - mesh: {file: none.obj}\n", TULLE_ERROR_IO, "none.obj", 0, 0,
     "read for cloth[0].mesh, "},
    {TIME "cloth:\n  - mesh: {file: bad.obj}\n", TULLE_ERROR_PARSE, "bad.obj", 3, -1,
     "read for cloth[0].mesh, "},
    {TIME "cloth:\n  - mesh: {file: book.obj}\n", TULLE_ERROR_INVALID_MESH, "book.obj", 6, 0,
     "read for cloth[0].mesh, "},
    {TIME "cloth:\n  - mesh: {shape: disc}\n    material: {preset: coton}\n", TULLE_ERROR_PARSE,
     "s.yaml", 4, 24,
     "cloth[0].material.preset: is 'coton', must be one of " PRESET_NAMES
     "; did you mean 'cotton'?"},
    {TIME SHEET "    pins: [{box: {min: [5, 5, 5], max: [6, 6, 6]}}]\n",
     TULLE_ERROR_INVALID_ARGUMENT, "s.yaml", 4, 12,
     "cloth[0].pins[0]: pins no vertex; the cloth begins within [-1, "
     "-1, "
     "0] and [1, 1, 0]"},
    {TIME SHEET "    pins: [{vertices: [3, 9]}]\n", TULLE_ERROR_INVALID_ARGUMENT, "s.yaml", 4, 23,
     "cloth[0].pins[0].vertices: names vertex 9, must be below 9, the cloth's number of vertices"},
    {TIME SHEET "    pins: [{vertices: [3], keyframes: [{time: 1}, {time: 1}]}]\n",
     TULLE_ERROR_INVALID_ARGUMENT, "s.yaml", 4, 58,
     "cloth[0].pins[0].keyframes[1].time: is 1 s, must be later than the keyframe before, 1 s"},
    {TIME SHEET "  - {mesh: {shape: disc}, name: cloth0}\n", TULLE_ERROR_INVALID_ARGUMENT, "s.yaml",
     4, 33, "cloth[1].name: 'cloth0' is the name of an object before; names must differ"},
    {TIME SHEET "contact:\n  pairs: [{between: [cloth0, flor], friction: 0.3}]\nobstacles:\n  - "
                "{mesh: {shape: box}, name: floor}\n",
     TULLE_ERROR_INVALID_ARGUMENT, "s.yaml", 5, 30,
     "contact.pairs[0].between: no cloth or obstacle is called 'flor'; did you mean 'floor'?"},
    {TIME SHEET "contact:\n  pairs: [{between: [cloth0, cloth0], friction: 0.3}]\n",
     TULLE_ERROR_INVALID_ARGUMENT, "s.yaml", 5, 30,
     "contact.pairs[0].between: names 'cloth0' twice; friction of a cloth on itself is "
     "contact.friction, or by its material contact.materials"},
    {TIME SHEET "contact:\n  materials: [{between: [cotton, wod], friction: 0.3}]\nobstacles:\n  - "
                "{mesh: {shape: box}, material: wood}\n",
     TULLE_ERROR_INVALID_ARGUMENT, "s.yaml", 5, 34,
     "contact.materials[0].between: no cloth, obstacle or preset has the material 'wod'; "
     "there are cotton, wood, " AFTER_COTTON "; did you mean 'wood'?"},
    {TIME SHEET "    material: {name: felt}\ncontact:\n  materials:\n    - {between: [silk, felt], "
                "friction: 0.3}\n    - {between: [felt, silk], friction: 0.4}\n",
     TULLE_ERROR_INVALID_ARGUMENT, "s.yaml", 8, 17,
     "contact.materials[1].between: a law of 'felt' and 'silk' is given before, in line 7; keep "
     "one"},
    {TIME SHEET
     "contact:\n  materials: [{between: [silk, silk], friction: 0.3, dynamic_friction: 0.4}]\n",
     TULLE_ERROR_INVALID_ARGUMENT, "s.yaml", 5, 72,
     "contact.materials[0].dynamic_friction: is 0.4, must be at most friction, 0.3"},
    {TIME SHEET "contact:\n  materials: [{between: [silk, silk]}]\n", TULLE_ERROR_PARSE, "s.yaml",
     5, 15,
     "contact.materials[0]: the key 'friction' is missing: Coulomb coefficient of contacts that do "
     "not slide"},
    {TIME SHEET "contact:\n  pairs: [{between: [a, b], friction: 0.3}]\nobstacles:\n  - {mesh: "
                "{shape: box}, name: a}\n  - {mesh: {shape: box}, name: b}\n",
     TULLE_ERROR_INVALID_ARGUMENT, "s.yaml", 5, 22,
     "contact.pairs[0].between: 'a' and 'b' are both obstacles, which do not touch; one must be a "
     "cloth or dynamic"},
    {TIME SHEET "contact:\n  pairs:\n    - {between: [cloth0, a], friction: 0.3}\n    - {between: "
                "[a, cloth0], friction: 0.4}\nobstacles:\n  - {mesh: {shape: box}, name: a}\n",
     TULLE_ERROR_INVALID_ARGUMENT, "s.yaml", 7, 17,
     "contact.pairs[1].between: a law of 'a' and 'cloth0' is given before, in line 6; keep one"},
    {TIME SHEET
     "contact:\n  pairs: [{between: [cloth0, a], friction: 0.3, dynamic_friction: 0.4}]\n"
     "obstacles:\n  - {mesh: {shape: box}, name: a}\n",
     TULLE_ERROR_INVALID_ARGUMENT, "s.yaml", 5, 67,
     "contact.pairs[0].dynamic_friction: is 0.4, must be at most friction, 0.3"},
    {TIME SHEET "contact: {friction: 0.2, dynamic_friction: 0.4}\n", TULLE_ERROR_INVALID_ARGUMENT,
     "s.yaml", 4, 44, "contact.dynamic_friction: is 0.4, must be at most friction, 0.2"},
    {TIME SHEET "    material: {dynamic_friction: 0.7}\n", TULLE_ERROR_INVALID_ARGUMENT, "s.yaml",
     4, 34, "cloth[0].material.dynamic_friction: is 0.7, must be at most friction, 0.4"},
    {TIME SHEET "obstacles:\n  - {mesh: {shape: box}, dynamic_friction: 0.5}\n",
     TULLE_ERROR_INVALID_ARGUMENT, "s.yaml", 5, 44,
     "obstacles[0].dynamic_friction: is 0.5, must be at most friction, 0.3"},
    {TIME SHEET "contact:\n  pairs: [{between: [cloth0], friction: 0.3}]\n", TULLE_ERROR_PARSE,
     "s.yaml", 5, 21, "contact.pairs[0].between: is a list of 1, must be a list of 2, each a name"},
    {TIME SHEET "obstacles:\n  - friction: 0.3\n", TULLE_ERROR_PARSE, "s.yaml", 5, 5,
     "obstacles[0]: the key 'mesh' is missing: file or shape, unless motion.sequence.files or an "
     "animation gives the mesh"},
    {TIME SHEET "obstacles:\n  - {mesh: {shape: box}, appears: 2 s, disappears: 1 s}\n",
     TULLE_ERROR_INVALID_ARGUMENT, "s.yaml", 5, 52,
     "obstacles[0].disappears: must be later than appears"},
    {TIME SHEET "obstacles:\n  - {mesh: {shape: box}, copies: {grid: {count: [4096, 4096, 4096], "
                "spacing: [1, 1, 1]}}}\n",
     TULLE_ERROR_LIMIT, "s.yaml", 5, 5,
     "obstacles[0]: brings the scene to more than 4096 obstacles with all copies"},
    {TIME, TULLE_ERROR_PARSE, "s.yaml", 1, 1, NOTHING_MOVES},
    {TIME "cloth: []\nobstacles:\n  - {mesh: {shape: box}, dynamic: false}\n", TULLE_ERROR_PARSE,
     "s.yaml", 2, 8, NOTHING_MOVES},
    {"time: {duration: 1000 s, step: 1 us}\n" SHEET, TULLE_ERROR_PARSE, "s.yaml", 1, 32,
     "time.step: '1 us' has an unknown unit; allowed here: s, ms, min"},
    {"time: {duration: 100000 s, step: 1e-6}\n" SHEET, TULLE_ERROR_LIMIT, "s.yaml", 1, 18,
     "time.duration: takes 100000000000 frames, at most 10000000 are allowed; make it shorter, or "
     "step or steps_per_frame larger"},
    {TIME SHEET "obstacles:\n  - {motion: {sequence: {files: f_%02d.obj, interval: 1}}}\n",
     TULLE_ERROR_PARSE, "s.yaml", 5, 15,
     "obstacles[0].motion.sequence: the key 'last' is missing: number of the last file"},
    {TIME SHEET "obstacles:\n  - {motion: {sequence: {files: f_%s.obj, last: 2, interval: 1}}}\n",
     TULLE_ERROR_PARSE, "s.yaml", 5, 33,
     "obstacles[0].motion.sequence.files: is 'f_%s.obj', must hold one number as %d or %03d, as in "
     "body_%02d.obj"},
    {TIME SHEET
     "obstacles:\n  - {motion: {sequence: {files: g_%d.obj, first: 1, last: 2, interval: 1}}}\n",
     TULLE_ERROR_INVALID_MESH, "g_2.obj", 0, 0, "has 3 vertices, must have 4"},
    {TIME SHEET
     "obstacles:\n  - {motion: {sequence: {files: h_%d.obj, first: 1, last: 2, interval: 1}}}\n",
     TULLE_ERROR_INVALID_MESH, "h_2.obj", 0, 0, "its triangles differ"},
    {TIME SHEET
     "obstacles:\n  - {motion: {sequence: {files: f_%02d.obj, first: 9, last: 8, interval: 1}}}\n",
     TULLE_ERROR_INVALID_ARGUMENT, "s.yaml", 5, 61, "obstacles[0].motion.sequence.last: is 8"},
    {TIME SHEET
     "obstacles:\n  - {motion: {sequence: {files: f_%02d.obj, first: 9, last: 11, interval: 1}}}\n",
     TULLE_ERROR_IO, "f_11.obj", 0, 0, "read for obstacles[0].motion.sequence, "},
    {TIME SHEET "obstacles:\n  - {mesh: {file: q.obj}, motion: {sequence: {cache: c.pc2, last: 3, "
                "interval: 1}}}\n",
     TULLE_ERROR_INVALID_ARGUMENT, "s.yaml", 5, 67,
     "obstacles[0].motion.sequence.last: is 3, must be below 3, the number of frames in the cache"},
    {TIME SHEET "obstacles:\n  - {mesh: {file: book.obj}, motion: {sequence: {cache: c.pc2, "
                "interval: 1}}}\n",
     TULLE_ERROR_INVALID_MESH, "c.pc2", 0, 0, "has 4 vertices, must have 5 as the obstacle's mesh"},
    {TIME SHEET
     "obstacles:\n  - {mesh: {shape: box}, motion: {keyframes: [{time: 2}, {time: -1}]}}\n",
     TULLE_ERROR_INVALID_ARGUMENT, "s.yaml", 5, 65,
     "obstacles[0].motion.keyframes[1].time: is -1 s, must be later than the keyframe before, 2 s"},
};

static bool is_as_wanted(const refusal *wanted, const tulle_scene_problems *problems) {
    const tulle_error *error = &problems->list[0];
    size_t length = strlen(error->file), ending = strlen(wanted->file);
    return problems->total_count == 1 && error->status == wanted->status &&
           error->line == wanted->line && (wanted->column < 0 || error->column == wanted->column) &&
           length > ending && strcmp(error->file + length - ending, wanted->file) == 0 &&
           strstr(error->message, wanted->message);
}

/* Obstacles keep one of two triangles with the same corners; the scene says so, and what it did not
 * understand in the file. Cloth is refused. */
static void test_notes(void **state) {
    (void)state;
    write_text_file("two.obj", "o x\nv 0 0 0\nv 1 0 0\nv 1 1 0\nseam 1 2\nf 1 2 3\nf 3 2 1\n");
    write_text_file("t_1.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\nf 3 2 1\n");
    write_text_file("t_2.obj", "v 0 0 0\nv 1 0 0\nv 1 2 0\nf 1 2 3\nf 3 2 1\n");
    tulle_scene *loaded =
        load_good(TIME SHEET "obstacles:\n  - {mesh: {file: two.obj}, translate: [0, 0, -1]}\n"
                             "  - {mesh: {file: two.obj}, translate: [0, 0, -2]}\n"
                             "  - {motion: {sequence: {files: t_%d.obj, first: 1, last: 2, "
                             "interval: 0.01}}, translate: [0, 0, -3]}\n");
    for (size_t i = 0; i < 3; i++)
        assert_int_equal(tulle_scene_get_obstacle_mesh(loaded, i).triangle_count, 1);
    static const char *const notes[] = {
        "two.obj: passed over: 1 'o' (line 1), 1 'seam' (line 5)",
        "two.obj:7: triangle 1 has the same corners as triangle 0 (line 6) and is dropped",
        "t_1.obj:5: triangle 1 has the same corners as triangle 0 (line 4) and is dropped"};
    assert_int_equal(tulle_scene_get_note_count(loaded), 3);
    for (size_t i = 0; i < 3; i++)
        if (!strstr(tulle_scene_get_note(loaded, i), notes[i]))
            fail_msg("%s", tulle_scene_get_note(loaded, i));
    tulle_scene_destroy(loaded);
    loaded = load_good(TIME SHEET);
    assert_int_equal(tulle_scene_get_note_count(loaded), 0);
    tulle_scene_destroy(loaded);
    tulle_scene_problems *problems = calloc(1, sizeof *problems);
    assert_non_null(problems);
    assert_null(load_text(TIME "cloth:\n  - mesh: {file: two.obj}\n", problems));
    assert_int_equal(problems->list[0].line, 7);
    assert_non_null(strstr(problems->list[0].message, "triangle 1 (line 7) has the same three "
                                                      "vertices as triangle 0 (line 6)"));
    assert_non_null(strstr(problems->list[0].message, "remove duplicate triangles"));
    free(problems);
}

/* Each of these files by itself would be cut in another way. All have the cut of the first one, or
 * of the mesh that goes before them. */
static void test_polygons_of_sequences(void **state) {
    (void)state;
    write_text_file("p_0.obj", "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 1 0.6 0\nv 0 2 0\nf 2 3 4 5 1\n");
    write_text_file("p_1.obj",
                    "v 0 0 0\nv 2 0 0\nv 1.4 1.5 0\nv 1.5 1.3 0\nv 0 2 0\nf 2 3 4 5 1\n");
    write_text_file("p_2.obj", "v 0 0 0\nv 2 0 0\nv 0.8 1 0\nv 2 2 0\nv 0 2 0\nf 2 3 4 5 1\n");
    tulle_scene *loaded = load_good(
        TIME SHEET "obstacles:\n  - {motion: {sequence: {files: p_%d.obj, last: 2, interval: 1}}, "
                   "translate: [0, 0, -3]}\n"
                   "  - {mesh: {file: p_2.obj}, motion: {sequence: {files: p_%d.obj, last: 1, "
                   "interval: 1}}, translate: [0, 0, -4]}\n"
                   "  - {mesh: {file: p_2.obj}, translate: [0, 0, -5]}\n");
    tulle_mesh_view const of_files = tulle_scene_get_obstacle_mesh(loaded, 0),
                          of_mesh = tulle_scene_get_obstacle_mesh(loaded, 1),
                          alone = tulle_scene_get_obstacle_mesh(loaded, 2);
    assert_true(of_files.triangle_count == 3 && of_mesh.triangle_count == 3);
    assert_memory_equal(of_mesh.triangles, alone.triangles, 9 * sizeof(uint32_t));
    assert_memory_not_equal(of_mesh.triangles, of_files.triangles, 9 * sizeof(uint32_t));
    tulle_scene_destroy(loaded);
}

/* Obstacles go without triangles that have no area: in a file, and in all frames of a sequence. One
 * that has an area in some frame guards there, and stays. */
static void test_triangles_without_area(void **state) {
    (void)state;
    write_text_file("flat.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0.5 0 0\nv 0.5 4e-10 0\nf 1 2 3\n"
                                "f 1 4 2\nf 1 1 3\nf 1 5 2\n");
    write_text_file("w_0.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0.5 0 0\nf 1 2 3\nf 1 4 2\nf 1 1 3\n");
    write_text_file("w_1.obj",
                    "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0.5 -1 0\nf 1 2 3\nf 1 4 2\nf 1 1 3\n");
    tulle_scene *loaded =
        load_good(TIME SHEET
                  "obstacles:\n  - {mesh: {file: flat.obj}, translate: [0, 0, -1]}\n"
                  "  - {motion: {sequence: {files: w_%d.obj, last: 1, interval: 0.01}}, translate: "
                  "[0, 0, -3]}\n"
                  "  - {mesh: {file: w_0.obj}, motion: {sequence: {files: w_%d.obj, last: 0, "
                  "interval: 0.01}}, translate: [0, 0, -4]}\n");
    static const size_t counts[] = {1, 2, 1};
    for (size_t i = 0; i < 3; i++)
        assert_int_equal(tulle_scene_get_obstacle_mesh(loaded, i).triangle_count, counts[i]);
    static const char *const notes[] = {
        "flat.obj:7: triangle 1 has no area (its height is under 1e-9 of its longest edge) and is "
        "left out, and 2 more",
        "w_%d.obj: triangle 2 has no area in any frame (its height is under 1e-9 of its longest "
        "edge) and is left out",
        "w_%d.obj: triangle 1 has no area in any frame (its height is under 1e-9 of its longest "
        "edge) and is left out, and 1 more"};
    assert_int_equal(tulle_scene_get_note_count(loaded), 3);
    for (size_t i = 0; i < 3; i++)
        if (!strstr(tulle_scene_get_note(loaded, i), notes[i]))
            fail_msg("%s", tulle_scene_get_note(loaded, i));
    tulle_scene_destroy(loaded);
    write_text_file("line.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    tulle_scene_problems *problems = calloc(1, sizeof *problems);
    assert_non_null(problems);
    assert_null(load_text(TIME SHEET "obstacles: [{mesh: {file: line.obj}}]\n", problems));
    assert_non_null(strstr(problems->list[0].message, "none of its 1 triangles has an area"));
    free(problems);
}

static void test_refusals(void **state) {
    (void)state;
    write_frames();
    write_text_file("q.obj", square);
    write_cache(4);
    write_text_file("bad.obj", "v 0 0 0\nv 1 0 0\nv x 1 0\n");
    /* Three triangles at one edge. */
    write_text_file("book.obj", "v 0 0 0\nv 0 0 1\nv 1 0 0\nv 0 1 0\nv -1 0 0\nf 1 2 3\nf 1 2 4\n"
                                "f 1 2 5\n");
    write_text_file("g_1.obj", square);
    write_text_file("g_2.obj", "v 0 0 1\nv 1 0 1\nv 1 1 1\nf 1 2 3\n");
    write_text_file("h_1.obj", square);
    write_text_file("h_2.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 4\nf 2 3 4\n");
    tulle_scene_problems *problems = calloc(1, sizeof *problems);
    assert_non_null(problems);
    size_t wrong_count = 0;
    for (size_t i = 0; i < sizeof refusals / sizeof refusals[0]; i++) {
        tulle_scene *loaded = load_text(refusals[i].text, problems);
        bool is_good = !loaded && is_as_wanted(&refusals[i], problems);
        if (!is_good) {
            print_error("for:\n%s\nwanted %s:%d:%d: %s\nfound %zu problems:\n", refusals[i].text,
                        refusals[i].file, refusals[i].line, refusals[i].column, refusals[i].message,
                        problems->total_count);
            scene_print_problems(problems, stderr);
        }
        wrong_count += !is_good;
        tulle_scene_destroy(loaded);
    }
    assert_int_equal(wrong_count, 0);
    free(problems);
}

/* A pair given twice on the command line has no line to point at. */
static void test_doubled_pair_of_an_override(void **state) {
    (void)state;
    write_text_file("pair.yaml", TIME SHEET "obstacles:\n  - {mesh: {shape: box}, name: a}\n");
    char path[128];
    snprintf(path, sizeof path, "%s/pair.yaml", folder_path);
    const char *const pairs = "contact.pairs=[{between: [cloth0, a], friction: 0.3}, "
                              "{between: [a, cloth0], friction: 0.4}]";
    tulle_scene_problems *problems = calloc(1, sizeof *problems);
    assert_non_null(problems);
    tulle_scene *loaded = NULL;
    assert_int_not_equal(tulle_scene_load(path, &pairs, 1, &loaded, problems), TULLE_OK);
    assert_non_null(strstr(problems->list[0].message, "is given before, by --set contact.pairs="));
    free(problems);
}

static void test_unreadable_files(void **state) {
    (void)state;
    tulle_scene_problems *problems = calloc(1, sizeof *problems);
    assert_non_null(problems);
    tulle_scene *loaded = (tulle_scene *)1;
    assert_int_equal(tulle_scene_load("/nonexistent/s.yaml", NULL, 0, &loaded, problems),
                     TULLE_ERROR_IO);
    assert_null(loaded);
    assert_string_equal(problems->list[0].file, "/nonexistent/s.yaml");
    assert_non_null(strstr(problems->list[0].message, "No such file"));
    assert_int_equal(tulle_scene_load("/tmp", NULL, 0, &loaded, problems), TULLE_ERROR_IO);
    assert_int_equal(tulle_scene_load("/dev/zero", NULL, 0, &loaded, problems), TULLE_ERROR_IO);
    assert_non_null(strstr(problems->list[0].message, "is not a regular file"));
    char large[] = "/tmp/tulle-scene-XXXXXX";
    int const file = mkstemp(large);
    assert_true(file >= 0 && ftruncate(file, 5 << 20) == 0);
    assert_int_equal(tulle_scene_load(large, NULL, 0, &loaded, problems), TULLE_ERROR_LIMIT);
    close(file);
    unlink(large);
    free(problems);
}

static void test_hash_and_canonical_text(void **state) {
    (void)state;
    tulle_scene *first = load_good("time: {frames: 3, step: 1/90}\n" SHEET);
    tulle_scene *longer =
        load_good("# the same, run longer\ntime: {frames: 9, step: 1/90 s}\n" SHEET);
    tulle_scene *other = load_good(TIME SHEET "    translate: [0, 0, 1 um]\n");
    assert_true(tulle_scene_get_hash(first) == tulle_scene_get_hash(longer));
    assert_true(tulle_scene_get_hash(first) != tulle_scene_get_hash(other));
    tulle_scene *again = load_good(tulle_scene_get_canonical_text(first));
    assert_true(tulle_scene_get_hash(first) == tulle_scene_get_hash(again));
    assert_string_equal(tulle_scene_get_canonical_text(first),
                        tulle_scene_get_canonical_text(again));
    assert_non_null(strstr(tulle_scene_get_canonical_text(first), "gravity: [0, 0, -9.81"));
    tulle_scene_destroy(first);
    tulle_scene_destroy(longer);
    tulle_scene_destroy(other);
    tulle_scene_destroy(again);
}

static void test_sequence_contents_count_in_the_hash(void **state) {
    (void)state;
    write_frames();
    tulle_scene *first = load_good(SEQUENCE(""));
    write_text_file("f_10.obj", "v 0 0 3\nv 1 0 3\nv 1 1 3\nv 0 1 4\nf 1 2 3\nf 1 3 4\n");
    tulle_scene *other = load_good(SEQUENCE(""));
    assert_true(tulle_scene_get_hash(first) != tulle_scene_get_hash(other));
    assert_string_equal(tulle_scene_get_canonical_text(first),
                        tulle_scene_get_canonical_text(other));
    tulle_scene_destroy(first);
    tulle_scene_destroy(other);
}

/* Between keys about different axes a turn goes the shorter way: told from half a turn on. */
/* Panels that meet with doubled vertices are two pieces of cloth; an OBJ file is told as others. */
static void seams_of_cloth_are_noted(void **state) {
    (void)state;
    write_text_file("panels.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 1 0 0\nv 2 0 0\nv 2 1 0\n"
                                  "v 1 1 0\nf 1 2 3 4\nf 5 6 7 8\n");
    tulle_scene *const loaded = load_good(
        TIME "contact: {start_intersections: untangle}\ncloth:\n  - mesh: {file: panels.obj}\n");
    assert_int_equal(tulle_scene_get_note_count(loaded), 1);
    const char *const note = tulle_scene_get_note(loaded, 0);
    if (!strstr(note, "panels.obj: 2 vertices are in the place of others") ||
        !strstr(note, "panels.obj OUT.ply --repair'"))
        fail_msg("%s", note);
    tulle_scene_world built = {0};
    tulle_scene_destroy(loaded);
    tulle_scene *const refused = load_good(TIME "cloth:\n  - mesh: {file: panels.obj}\n");
    tulle_error error = {0};
    assert_int_equal(tulle_scene_build_world(refused, 1, NULL, &built, &error), TULLE_OK);
    assert_int_equal(tulle_world_start(built.world, &error), TULLE_ERROR_INTERSECTING_START);
    if (!strstr(error.message, "join vertices that are in one place"))
        fail_msg("%s", error.message);
    tulle_scene_destroy_world(&built);
    tulle_scene_destroy(refused);
}

static void long_ways_between_axes_are_noted(void **state) {
    (void)state;
    static const struct {
        const char *keys, *note; /* null: none */
    } cases[] = {
        {"{time: 0}, {time: 1, rotate: {axis: [0, 0, 1], angle: 720 deg}}", NULL},
        {"{time: 0, rotate: {axis: [0, 0, 1], angle: -300 deg}}, "
         "{time: 1, rotate: {axis: [0, 0, 1], angle: 300 deg}}",
         NULL},
        {"{time: 0, rotate: {axis: [1, 0, 0], angle: 100 deg}}, "
         "{time: 1, rotate: {axis: [0, 1, 0], angle: 100 deg}}",
         NULL},
        {"{time: 0, rotate: {axis: [1, 0, 0], angle: 150 deg}}, "
         "{time: 1, rotate: {axis: [0, 1, 0], angle: 150 deg}}",
         "s.yaml:5: obstacles[0].motion.keyframes[1].rotate: is about another axis than the "
         "keyframe before and goes by 212.132 deg from there; the turn goes the shorter way"},
        {"{time: 0, rotate: [10 deg, 20 deg, 0]}, {time: 1, rotate: [10 deg, 20 deg, 179 deg]}",
         NULL},
        {"{time: 0, rotate: [10 deg, 20 deg, 0]}, {time: 1, rotate: [10 deg, 20 deg, 200 deg]}",
         "goes by 200 deg from there; the turn goes the shorter way"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char text[1000];
        snprintf(text, sizeof text,
                 TIME SHEET "obstacles:\n  - {mesh: {shape: box}, translate: [0, 0, -3], motion: "
                            "{keyframes: [%s]}}\n",
                 cases[i].keys);
        tulle_scene *const loaded = load_good(text);
        size_t const count = tulle_scene_get_note_count(loaded);
        const char *const note = tulle_scene_get_note(loaded, 0);
        if (count != (cases[i].note != NULL) || (note && !strstr(note, cases[i].note)))
            fail_msg("case %zu has %zu notes, the first: %s", i, count, note ? note : "none");
        tulle_scene_destroy(loaded);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(seams_of_cloth_are_noted),
        cmocka_unit_test(long_ways_between_axes_are_noted),
        cmocka_unit_test(test_placement_and_time),
        cmocka_unit_test(test_copies),
        cmocka_unit_test(test_pins),
        cmocka_unit_test(test_sequence_of_files),
        cmocka_unit_test(test_sequence_of_cache),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_notes),
        cmocka_unit_test(test_triangles_without_area),
        cmocka_unit_test(test_polygons_of_sequences),
        cmocka_unit_test(test_doubled_pair_of_an_override),
        cmocka_unit_test(test_unreadable_files),
        cmocka_unit_test(test_hash_and_canonical_text),
        cmocka_unit_test(test_sequence_contents_count_in_the_hash),
    };
    return cmocka_run_group_tests(tests, NULL, remove_folder);
}
