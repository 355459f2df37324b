/* What `tulle detect` does with damaged meshes: every truncation and every flipped bit of small
 * OBJ and PLY files, as START, as END and as both, and every allocation that fails. Either a clean
 * error or a whole answer, in little memory: also for coordinates that a flipped bit made as large
 * as doubles get. */
#define _XOPEN_SOURCE 700
#include "app/detect/passes.h"
#include "base/hash.h"
#include "io/failing_heap.h"
#include "io/io_support.h"

#include <math.h>

/* [bytes] Largest block for meshes of a few triangles: scratch of a fixed size, no more. */
static const size_t BLOCK_LIMIT = (size_t)1 << 25;

enum { VERTEX_COUNT = 7, TRIANGLE_COUNT = 3, SAMPLE_COUNT = 4, SAMPLE_MAX = 1024 };

/* Two triangles on an edge and one whose corner comes down through the first of them. */
static const double start_points[3 * VERTEX_COUNT] = {
    0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0.25, 0.25, 0.25, 0.5, 0.5, 0.25, 1, 0.25, 0.5, 1};
static const double end_points[3 * VERTEX_COUNT] = {
    0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0.25, 0.25, 0.25, -0.5, 0.5, 0.25, 1, 0.25, 0.5, 1};
static const uint32_t triangles[3 * TRIANGLE_COUNT] = {0, 1, 2, 1, 3, 2, 4, 5, 6};

typedef struct sample {
    char bytes[SAMPLE_MAX];
    size_t size;
} sample;

static void add_bytes(sample *to, const void *bytes, size_t size) {
    assert_true(to->size + size < SAMPLE_MAX);
    memcpy(to->bytes + to->size, bytes, size);
    to->size += size;
}

static void add_text(sample *to, const char *format, ...) __attribute__((format(printf, 2, 3)));

static void add_text(sample *to, const char *format, ...) {
    char text[256];
    va_list arguments;
    va_start(arguments, format);
    int const length = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    add_bytes(to, text, (size_t)length);
}

static void make_obj(sample *made, const double *points) {
    for (int i = 0; i < VERTEX_COUNT; i++)
        add_text(made, "v %g %g %g\n", points[3 * i], points[3 * i + 1], points[3 * i + 2]);
    for (int i = 0; i < TRIANGLE_COUNT; i++)
        add_text(made, "f %u %u %u\n", triangles[3 * i] + 1, triangles[3 * i + 1] + 1,
                 triangles[3 * i + 2] + 1);
}

/* Adds a value's bytes in the order of the file. The test runs on little-endian machines. */
static void add_value(sample *made, const void *value, size_t size, bool is_big_endian) {
    for (size_t i = 0; i < size; i++)
        add_bytes(made, (const char *)value + (is_big_endian ? size - 1 - i : i), 1);
}

static void make_ply(sample *made, const double *points, const char *order, bool is_float) {
    const char *const kind = is_float ? "float" : "double";
    bool const is_text = strcmp(order, "ascii") == 0;
    bool const is_big_endian = strcmp(order, "binary_big_endian") == 0;
    add_text(made, "ply\nformat %s 1.0\nelement vertex %d\nproperty %s x\nproperty %s y\n", order,
             VERTEX_COUNT, kind, kind);
    add_text(made, "property %s z\nelement face %d\nproperty list uchar int vertex_index\n", kind,
             TRIANGLE_COUNT);
    add_text(made, "end_header\n");
    for (int i = 0; i < 3 * VERTEX_COUNT; i++) {
        float const narrow = (float)points[i];
        if (is_text)
            add_text(made, "%g%c", points[i], i % 3 == 2 ? '\n' : ' ');
        else if (is_float)
            add_value(made, &narrow, 4, is_big_endian);
        else
            add_value(made, &points[i], 8, is_big_endian);
    }
    for (int i = 0; i < 3 * TRIANGLE_COUNT; i++) {
        if (is_text) {
            add_text(made, "%s%u%c", i % 3 ? "" : "3 ", triangles[i], i % 3 == 2 ? '\n' : ' ');
        } else {
            if (i % 3 == 0) add_bytes(made, "\3", 1);
            add_value(made, &triangles[i], 4, is_big_endian);
        }
    }
}

/* The kinds of files: name, and the two states. */
typedef struct sample_pair {
    const char *names[2];
    sample states[2];
} sample_pair;

static sample_pair samples[SAMPLE_COUNT] = {
    {.names = {"a0.obj", "a1.obj"}},
    {.names = {"b0.ply", "b1.ply"}},
    {.names = {"c0.ply", "c1.ply"}},
    {.names = {"d0.ply", "d1.ply"}},
};

static int make_samples(void **state) {
    if (make_test_folder(state)) return -1;
    for (int end = 0; end < 2; end++) {
        const double *const points = end ? end_points : start_points;
        make_obj(&samples[0].states[end], points);
        make_ply(&samples[1].states[end], points, "ascii", true);
        make_ply(&samples[2].states[end], points, "binary_little_endian", true);
        make_ply(&samples[3].states[end], points, "binary_big_endian", false);
    }
    return 0;
}

static void judge_events(const detect_passes *passes) {
    for (size_t i = 0; i < passes->result.event_count; i++) {
        const tulle_detect_event *const event = &passes->result.events[i];
        assert_true(event->time >= 0.0 && event->time <= 1.0);
        assert_true(event->kind == TULLE_DETECT_VERTEX_FACE ||
                    event->kind == TULLE_DETECT_EDGE_EDGE);
        for (int corner = 0; corner < 4; corner++)
            assert_true(event->vertices[corner] < passes->def.vertex_count);
    }
    assert_int_equal(detect_count_kind(passes, TULLE_DETECT_VERTEX_FACE) +
                         detect_count_kind(passes, TULLE_DETECT_EDGE_EDGE),
                     passes->result.event_count);
}

/* Reads the two files and searches; the status of whichever failed, and the number of events. */
static tulle_status search(const char *const names[2], tulle_detect_method method,
                           size_t *event_count) {
    detect_frames frames;
    tulle_error error = {0};
    *event_count = 0;
    tulle_status status =
        detect_frames_read(test_path(names[0]), test_path(names[1]), &frames, &error);
    if (status == TULLE_OK) {
        detect_passes passes = {.def = tulle_detect_def_default(), .repeat_count = 1};
        uint64_t crossing_count = 0;
        passes.def.method = method;
        passes.def.threads = 1;
        status = detect_frames_count_crossings(&frames, 1, &crossing_count, &error);
        if (status == TULLE_OK) status = detect_passes_run(&passes, &frames, &error);
        if (status == TULLE_OK) {
            judge_events(&passes);
            *event_count = passes.result.event_count;
        }
        detect_passes_destroy(&passes);
        detect_frames_destroy(&frames);
    }
    assert_int_equal(error.status, status);
    if (status != TULLE_OK) assert_true(error.message[0] != '\0');
    return status;
}

/* Puts files in place of START (1), END (2) or both (3), and searches by one of the methods. */
static void try_damaged(const sample_pair *whole, const sample damaged[2], int which) {
    static int turn;
    for (int end = 0; end < 2; end++) {
        const sample *const used = which & (1 << end) ? &damaged[end] : &whole->states[end];
        put_file(test_path(whole->names[end]), used->bytes, used->size);
    }
    size_t event_count;
    watch_heap(-1);
    tulle_status const status =
        search(whole->names, (tulle_detect_method)(turn++ % 4), &event_count);
    unwatch_heap();
    assert_true(heap_largest <= BLOCK_LIMIT);
    if (status != TULLE_OK && status != TULLE_ERROR_PARSE && status != TULLE_ERROR_LIMIT &&
        status != TULLE_ERROR_UNSUPPORTED && status != TULLE_ERROR_INVALID_MESH)
        fail_msg("%s gave status %d", whole->names[0], status);
}

static void whole_files_are_searched(void **state) {
    (void)state;
    for (int i = 0; i < SAMPLE_COUNT; i++) {
        for (int end = 0; end < 2; end++)
            put_file(test_path(samples[i].names[end]), samples[i].states[end].bytes,
                     samples[i].states[end].size);
        for (int method = 0; method < 4; method++) {
            size_t event_count;
            assert_int_equal(search(samples[i].names, (tulle_detect_method)method, &event_count),
                             TULLE_OK);
            assert_int_equal(event_count, 1);
        }
    }
}

static void every_truncation(void **state) {
    (void)state;
    for (int i = 0; i < SAMPLE_COUNT; i++) {
        sample damaged[2] = {samples[i].states[0], samples[i].states[1]};
        for (size_t size = 0; size < samples[i].states[0].size; size++) {
            damaged[0].size = size;
            damaged[1].size = size < samples[i].states[1].size ? size : samples[i].states[1].size;
            for (int which = 1; which <= 3; which++) try_damaged(&samples[i], damaged, which);
        }
    }
}

static void every_flipped_bit(void **state) {
    (void)state;
    for (int i = 0; i < SAMPLE_COUNT; i++) {
        sample damaged[2] = {samples[i].states[0], samples[i].states[1]};
        size_t const size = damaged[0].size < damaged[1].size ? damaged[0].size : damaged[1].size;
        for (size_t bit = 0; bit < 8 * size; bit++) {
            for (int end = 0; end < 2; end++) damaged[end].bytes[bit / 8] ^= (char)(1 << bit % 8);
            try_damaged(&samples[i], damaged, 1 + (int)(bit % 3));
            for (int end = 0; end < 2; end++) damaged[end].bytes[bit / 8] ^= (char)(1 << bit % 8);
        }
    }
}

/* Overwrites, removes or repeats a stretch of the file, or puts a word into it that is hard on
 * readers. */
static void damage(sample *of, uint64_t *seed) {
    static const char *const words[] = {"-1",
                                        "1e308",
                                        "-1e308",
                                        "4e-324",
                                        "nan",
                                        "4294967295",
                                        "0",
                                        "2147483648",
                                        "\n",
                                        "\r",
                                        " ",
                                        "\\\n",
                                        "\x7f\xef\xff\xff",
                                        "\xff\xff\x7f\x7f",
                                        "\x7f\x7f\xff\xff"};
    size_t const at = (size_t)(random_uniform(seed) * (double)of->size);
    size_t length = 1 + (size_t)(random_uniform(seed) * 24.0);
    if (length > of->size - at) length = of->size - at;
    const char *const word = words[(size_t)(random_uniform(seed) * 15.0)];
    switch ((int)(random_uniform(seed) * 4.0)) {
    case 0:
        for (size_t i = 0; i < length; i++) of->bytes[at + i] = (char)random_next(seed);
        break;
    case 1:
        memmove(of->bytes + at, of->bytes + at + length, of->size - at - length);
        of->size -= length;
        break;
    case 2:
        if (of->size + length > SAMPLE_MAX) break;
        memmove(of->bytes + at + length, of->bytes + at, of->size - at);
        of->size += length;
        break;
    default:
        for (size_t i = 0; word[i] && at + i < of->size; i++) of->bytes[at + i] = word[i];
    }
}

/* Several kinds of damage at once; as many rounds as TULLE_TEST_LONG asks for. */
static void random_damage(void **state) {
    (void)state;
    int const rounds = getenv("TULLE_TEST_LONG") ? 300000 : 4000;
    uint64_t seed = 11;
    for (int round = 0; round < rounds; round++) {
        const sample_pair *const whole = &samples[round % SAMPLE_COUNT];
        sample damaged[2] = {whole->states[0], whole->states[1]};
        for (int end = 0; end < 2; end++)
            for (double more = 0.0; more < 0.6 && damaged[end].size > 1;
                 more = random_uniform(&seed))
                damage(&damaged[end], &seed);
        try_damaged(whole, damaged, 1 + (int)(random_uniform(&seed) * 3.0));
    }
}

static void every_failing_allocation(void **state) {
    (void)state;
    if (!HAS_OWN_HEAP) skip();
    for (int method = 0; method < 4; method++) {
        const sample_pair *const pair = &samples[method];
        for (int end = 0; end < 2; end++)
            put_file(test_path(pair->names[end]), pair->states[end].bytes, pair->states[end].size);
        tulle_status status = TULLE_ERROR_OUT_OF_MEMORY;
        long fail = 0;
        size_t event_count = 0;
        for (bool has_failed = true; has_failed; fail++) {
            watch_heap(fail);
            status = search(pair->names, (tulle_detect_method)method, &event_count);
            has_failed = unwatch_heap();
            if (has_failed && status != TULLE_OK)
                assert_int_equal(status, TULLE_ERROR_OUT_OF_MEMORY);
        }
        assert_true(fail > 10);
        assert_int_equal(status, TULLE_OK);
        assert_int_equal(event_count, 1);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(whole_files_are_searched), cmocka_unit_test(every_truncation),
        cmocka_unit_test(every_flipped_bit),        cmocka_unit_test(random_damage),
        cmocka_unit_test(every_failing_allocation),
    };
    return cmocka_run_group_tests(tests, make_samples, remove_test_folder);
}
