/* Mesh sequences with times of their own: what every format says is where the obstacle is at every
 * step; what the keys interval, fps, speed, first, start and loop make of it, as the table in
 * docs/guide/formats.md has it; what has no times is refused without them. */
#define _POSIX_C_SOURCE 200809L
#include "scene/scene_data.h"
#include "scene_text.h"

#include "tulle_io/animation.h"

#include <math.h>
#include <pthread.h>

#define HEAD                                                                                       \
    "time: {frames: 20, step: 50 ms}\n"                                                            \
    "cloth:\n  - {mesh: {shape: rectangle, resolution: [2, 2]}, translate: [0, 0, "                \
    "9]}\nobstacles:\n"
enum { STEPS = 60 };

/* Frames at 0.5, 0.6 and 1.5 s; the triangle is at x = 0.5, 0.6 and 1.5 m. */
static const double times[] = {0.5, 0.6, 1.5};
static double places[] = {0.5, 0.6, 1.5};

static tulle_status read_place(void *context, size_t surface, uint32_t frame, double *values,
                               tulle_error *error) {
    (void)context;
    (void)surface;
    (void)error;
    const double x = places[frame], corners[9] = {x, 0, 0, x + 0.1, 0, 0, x, 0.1, 0};
    memcpy(values, corners, sizeof corners);
    return TULLE_OK;
}

static void write_walk(const char *name) {
    static const uint32_t corners[3] = {0, 1, 2};
    tulle_animation_surface const surface = {
        .name = "walker", .mesh = {NULL, 3, corners, 1}, .motion = TULLE_ANIMATION_DEFORMS};
    tulle_animation_def def = tulle_animation_def_default();
    def.surfaces = &surface;
    def.surface_count = 1;
    def.times = times;
    def.frame_count = 3;
    def.read = read_place;
    char path[128];
    tulle_error error = {0};
    write_text_file(name, "");
    snprintf(path, sizeof path, "%s/%s", folder_path, name);
    if (tulle_animation_write(path, &def, &error)) fail_msg("%s: %s", name, error.message);
}

static void write_usd(const char *name, const char *head) {
    char text[600];
    snprintf(text, sizeof text,
             "#usda 1.0\n(\n upAxis = \"Z\"\n metersPerUnit = 1\n %s\n)\n"
             "def Mesh \"b\"\n{\n int[] faceVertexCounts = [3]\n"
             " int[] faceVertexIndices = [0, 1, 2]\n"
             " point3f[] points = [(0, 0, 0), (0.1, 0, 0), (0, 0.1, 0)]\n"
             " double3 xformOp:translate.timeSamples = {\n"
             "  5: (0.5, 0, 0), 6: (0.6, 0, 0), 15: (1.5, 0, 0),\n }\n"
             " uniform token subdivisionScheme = \"none\"\n"
             " uniform token[] xformOpOrder = [\"xformOp:translate\"]\n}\n",
             head);
    write_text_file(name, text);
}

/* A PC2 file of frames at the places, counted in frames from `start` on by `step`. */
static void write_pc2(const char *name, float start, float step) {
    char bytes[32 + 3 * 36] = "POINTCACHE2";
    int32_t const counts[3] = {1, 3, 3};
    float const numbers[2] = {start, step};
    memcpy(bytes + 12, counts, 8);
    memcpy(bytes + 20, numbers, 8);
    memcpy(bytes + 28, counts + 2, 4);
    for (uint32_t frame = 0; frame < 3; frame++) {
        double values[9];
        read_place(NULL, 0, frame, values, NULL);
        for (size_t i = 0; i < 9; i++) {
            float const value = (float)values[i];
            memcpy(bytes + 32 + 36 * frame + 4 * i, &value, 4);
        }
    }
    write_file(name, bytes, sizeof bytes);
}

/* Between the points of a table of times and places by a line, still before and after. */
static double find_expected(const double (*table)[2], size_t count, double time) {
    if (time <= table[0][0]) return table[0][1];
    for (size_t i = 1; i < count; i++)
        if (time <= table[i][0])
            return table[i - 1][1] + (time - table[i - 1][0]) / (table[i][0] - table[i - 1][0]) *
                                         (table[i][1] - table[i - 1][1]);
    return table[count - 1][1];
}

#define MESH_FILE "mesh: {file: t.obj}, "

/* Compares where the obstacle is at every step with a table of times and places. */
static void expect_motion(const char *obstacle, const double (*table)[2], size_t count,
                          const char *note) {
    char text[500];
    snprintf(text, sizeof text, HEAD "  - {%s}\n", obstacle);
    tulle_scene *const loaded = load_good(text);
    size_t const note_count = tulle_scene_get_note_count(loaded);
    if (note && (note_count != 1 || !strstr(tulle_scene_get_note(loaded, 0), note)))
        fail_msg("%s: notes: %s", obstacle, tulle_scene_get_note(loaded, 0));
    if (!note && note_count > 0)
        fail_msg("%s: a note: %s", obstacle, tulle_scene_get_note(loaded, 0));
    tulle_scene_world built;
    tulle_error error = {0};
    assert_int_equal(tulle_scene_build_world(loaded, 1, NULL, &built, &error), TULLE_OK);
    for (int step = 1; step <= STEPS; step++) {
        if (tulle_world_step(built.world, 0.05, NULL, &error) != TULLE_OK)
            fail_msg("%s: %s", obstacle, error.message);
        double const x = tulle_obstacle_get_positions(built.world, built.obstacles[0], NULL)[0];
        double const expected = find_expected(table, count, 0.05 * step);
        if (!(fabs(x - expected) < 1e-6))
            fail_msg("%s: at %g s at %.9g m, not %.9g m", obstacle, 0.05 * step, x, expected);
    }
    tulle_scene_destroy_world(&built);
    /* A run goes on from its own text. */
    char *const canonical = strdup(tulle_scene_get_canonical_text(loaded));
    assert_non_null(canonical);
    tulle_scene *const again = load_good(canonical);
    assert_true(tulle_scene_get_hash(again) == tulle_scene_get_hash(loaded));
    free(canonical);
    tulle_scene_destroy(again);
    tulle_scene_destroy(loaded);
}

#define EXPECT(obstacle, note, ...)                                                                \
    do {                                                                                           \
        static const double table[][2] = {__VA_ARGS__};                                            \
        expect_motion(obstacle, table, sizeof table / sizeof table[0], note);                      \
    } while (0)

#define PLAY(file, more) "motion: {sequence: {cache: " file more "}}"

static void write_files(void) {
    write_text_file("t.obj", "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nf 1 2 3\n");
    write_walk("w.gltf");
    write_walk("w.glb");
    write_walk("w.npz");
    write_walk("w.mdd");
    write_usd("w.usda", "timeCodesPerSecond = 10");
    write_usd("from5.usda", "timeCodesPerSecond = 10\n startTimeCode = 5");
    write_pc2("w.pc2", 0, 1);
    write_pc2("late.pc2", 5, 2);
}

/* x(t) = t between the first and the last time, without any key. */
static void test_formats(void **state) {
    (void)state;
    write_files();
#define AS_TOLD {0.5, 0.5}, {1.5, 1.5}
    EXPECT(PLAY("w.gltf", ""), NULL, AS_TOLD);
    EXPECT(PLAY("w.glb", ""), NULL, AS_TOLD);
    EXPECT(PLAY("w.npz", ""), NULL, AS_TOLD);
    EXPECT(PLAY("w.usda", ""), NULL, AS_TOLD);
    EXPECT(MESH_FILE PLAY("w.mdd", ""), NULL, AS_TOLD);
    /* The time line of USD begins at its startTimeCode. */
    EXPECT(PLAY("from5.usda", ""), NULL, {0, 0.5}, {1, 1.5});
    /* PC2 counts in frames: the first one is number 5, and of two frames one is there. */
    EXPECT(MESH_FILE PLAY("late.pc2", ", fps: 10"), NULL, {0.5, 0.5}, {0.7, 0.6}, {0.9, 1.5});
    EXPECT(MESH_FILE PLAY("w.pc2", ", fps: 10"), NULL, {0, 0.5}, {0.1, 0.6}, {0.2, 1.5});
}

/* The scene ends at 1 s. */
static void what_comes_too_late_is_told(void **state) {
    (void)state;
    write_files();
    EXPECT(PLAY("w.npz", ", start: 0.995"),
           "w.npz: its second frame comes at 1.095 s, and the scene ends at 1 s", {0.995, 0.5},
           {1.995, 1.5});
    EXPECT(PLAY("w.npz", ", speed: 0.01"), "its second frame comes at 60 s", {50, 0.5}, {60, 0.6});
    EXPECT("mesh: {shape: box}, motion: {keyframes: [{time: 1 s}, {time: 2 s, translate: [1, 0, "
           "0]}]}",
           "motion.keyframes[0]: motion begins at 1 s, and the scene ends at 1 s", {1, -0.5},
           {2, 0.5});
}

/* The obstacle's own triangles stand before those of the animation. */
static void other_triangles_are_told(void **state) {
    (void)state;
    write_files();
    write_text_file("turned.obj", "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nf 1 3 2\n");
    EXPECT(MESH_FILE PLAY("w.npz", ""), NULL, AS_TOLD);
    EXPECT("mesh: {file: turned.obj}, " PLAY("w.npz", ""),
           "w.npz: its 1 triangles are not used: the obstacle has the key 'mesh', with 1", AS_TOLD);
    EXPECT("mesh: {file: turned.obj}, " PLAY("w.mdd", ""), NULL, AS_TOLD); /* has none */
}

/* What overrules what. */
static void test_keys(void **state) {
    (void)state;
    write_files();
    EXPECT(PLAY("w.npz", ", interval: 0.2"), NULL, {0, 0.5}, {0.2, 0.6}, {0.4, 1.5});
    EXPECT(PLAY("w.npz", ", interval: 0.2, speed: 2"), NULL, {0, 0.5}, {0.1, 0.6}, {0.2, 1.5});
    EXPECT(PLAY("w.npz", ", interval: 0.2, start: 0.3"), NULL, {0.3, 0.5}, {0.5, 0.6}, {0.7, 1.5});
    EXPECT(PLAY("w.npz", ", fps: 10"),
           "fps 10 is not used: the file's own times hold, and frame 2 is 1 s after the first",
           AS_TOLD);
    EXPECT(PLAY("w.npz", ", last: 1, fps: 10"), NULL, {0.5, 0.5}, {0.6, 0.6});
    EXPECT(PLAY("w.npz", ", speed: 2"), NULL, {0.25, 0.5}, {0.75, 1.5});
    EXPECT(PLAY("w.npz", ", start: 0.2"), NULL, {0.2, 0.5}, {1.2, 1.5});
    EXPECT(PLAY("w.npz", ", start: 0.2, speed: 2"), NULL, {0.2, 0.5}, {0.7, 1.5});
    EXPECT(PLAY("w.npz", ", first: 1"), NULL, {0, 0.6}, {0.9, 1.5});
    EXPECT(PLAY("w.npz", ", first: 1, start: 0.2"), NULL, {0.2, 0.6}, {1.1, 1.5});
    EXPECT(PLAY("w.npz", ", start: -0.25"), NULL, {-0.25, 0.5}, {0.75, 1.5});
    EXPECT(MESH_FILE PLAY("late.pc2", ", fps: 10, start: 0.1"), NULL, {0.1, 0.5}, {0.3, 0.6},
           {0.5, 1.5});
    EXPECT(MESH_FILE PLAY("late.pc2", ", interval: 0.1"), NULL, {0, 0.5}, {0.1, 0.6}, {0.2, 1.5});
    EXPECT(PLAY("w.npz", ", start: 0, loop: pingpong"), NULL, {0, 0.5}, {1, 1.5}, {2, 0.5},
           {3, 1.5});
    EXPECT(PLAY("w.npz", ", loop: pingpong, speed: 2"), NULL, {0.25, 0.5}, {0.75, 1.5}, {1.25, 0.5},
           {1.75, 1.5}, {2.25, 0.5}, {2.75, 1.5}, {3.25, 0.5});
    /* Copies come one after the other. */
    EXPECT(
        "copies: {row: {count: 2, offset: [0, 1, 0]}, stagger: 0.2, order: last-to-first}, " PLAY(
            "w.npz", ""),
        NULL, {0.7, 0.5}, {1.7, 1.5});
    /* The way back takes the mean of the intervals; a last frame that is the first takes none. */
    double const last = places[2];
    places[2] = 0.45;
    write_walk("round.npz");
    EXPECT(PLAY("round.npz", ", start: 0, loop: repeat"), NULL, {0, 0.5}, {0.1, 0.6}, {1, 0.45},
           {1.5, 0.5}, {1.6, 0.6}, {2.5, 0.45}, {3, 0.5});
    places[2] = 0.5;
    write_walk("closed.npz");
    EXPECT(PLAY("closed.npz", ", start: 0, loop: repeat"), NULL, {0, 0.5}, {0.1, 0.6}, {1, 0.5},
           {1.1, 0.6}, {2, 0.5}, {2.1, 0.6}, {3, 0.5});
    places[2] = last;
}

/* Reads frames from the last to the first, so that few are those that are kept. */
static void *read_backwards(void *context) {
    scene_sequence *const sequence = context;
    for (int round = 0; round < 200; round++)
        for (uint32_t frame = 31; frame-- > 0;) {
            double positions[9], x = fmin(fmax(0.05 * frame, 0.5), 1.5);
            tulle_error error = {0};
            if (sequence_read(sequence, frame, positions, &error) != TULLE_OK ||
                !(fabs(positions[0] - x) < 1e-6))
                return sequence;
        }
    return NULL;
}

/* Two worlds at once read the same frames: one of what is kept, the other of the file. */
static void test_two_readers(void **state) {
    (void)state;
    write_files();
    tulle_scene *const loaded = load_good(HEAD "  - {" PLAY("w.npz", "") "}\n");
    scene_sequence *const sequence = loaded->obstacles[0].sequence;
    pthread_t other;
    void *failure = NULL;
    assert_int_equal(pthread_create(&other, NULL, read_backwards, sequence), 0);
    assert_null(read_backwards(sequence));
    assert_int_equal(pthread_join(other, &failure), 0);
    assert_null(failure);
    double positions[9];
    tulle_error error = {0};
    assert_int_equal(sequence_get_frame_count(sequence), 31);
    assert_int_equal(sequence_read(sequence, 31, positions, &error), TULLE_ERROR_INVALID_ARGUMENT);
    tulle_scene_destroy(loaded);
}

static void refuse(const char *obstacle, const char *words) {
    char text[500];
    tulle_scene_problems *const problems = calloc(1, sizeof *problems);
    assert_non_null(problems);
    snprintf(text, sizeof text, HEAD "  - {%s}\n", obstacle);
    if (load_text(text, problems)) fail_msg("%s is taken", obstacle);
    if (problems->list[0].line != 5 || !strstr(problems->list[0].message, words))
        fail_msg("%s: line %d: %s", obstacle, problems->list[0].line, problems->list[0].message);
    free(problems);
}

static void test_problems_have_a_place(void **state) {
    (void)state;
    write_files();
    refuse(
        MESH_FILE PLAY("w.pc2", ""),
        "obstacles[0].motion.sequence: needs one of the keys interval, fps: a PC2 file counts in "
        "frames");
    write_pc2("still.pc2", 0, 0);
    refuse(MESH_FILE PLAY("still.pc2", ", fps: 24"),
           "'still.pc2' says that its frames are 0 frames apart");
    /* All times of this MDD file are 0: it plays by fps, and is refused without. */
    char bytes[8 + 12 + 3 * 36] = {0};
    bytes[3] = bytes[7] = 3;
    write_file("equal.mdd", bytes, sizeof bytes);
    refuse(MESH_FILE PLAY("equal.mdd", ""),
           "the times of 'equal.mdd' do not rise: frame 1 is at 0 s");
    refuse(PLAY("w.npz", ", fps: 10, interval: 1"), "may have only one of the keys interval, fps");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_formats),
        cmocka_unit_test(test_keys),
        cmocka_unit_test(what_comes_too_late_is_told),
        cmocka_unit_test(other_triangles_are_told),
        cmocka_unit_test(test_two_readers),
        cmocka_unit_test(test_problems_have_a_place),
    };
    return cmocka_run_group_tests(tests, NULL, remove_folder);
}
