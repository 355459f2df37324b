/* debug.bin: what is written comes back, damage is noticed and never passed on, the kind of record
 * stays that of the run. */
#define _DEFAULT_SOURCE /* mkdtemp */
#include "io/run_support.h"

enum { HEAD_SIZE = 16, HEADER_SIZE = 40 };

static tulle_run_reader *open_reader(const char *directory) {
    tulle_run_reader *reader = NULL;
    tulle_error error = {0};
    if (tulle_run_reader_open(directory, &reader, &error))
        fail_msg("%s: %s", error.file, error.message);
    return reader;
}

/* The state that frame `frame` was made of. */
static uint64_t find_state(uint32_t frame) {
    uint64_t state = 42;
    for (uint32_t i = 0; i < frame * STEPS_PER_FRAME; i++) state = hash_mix(state + 1);
    return state;
}

static void frames_can_be_read_in_any_order(void **state) {
    (void)state;
    const char *const directory = test_path("order");
    run_whole(directory, FRAME_COUNT);
    tulle_run_reader *const reader = open_reader(directory);
    const tulle_run_info *const info = tulle_run_reader_get_info(reader);
    size_t size;
    free(get_file(test_path("order/debug.bin"), &size));
    assert_int_equal(info->has_debug, 1);
    assert_int_equal(info->debug_byte_count, size);
    static const uint32_t order[] = {12, 3, 0, 7, 7, 1, 11, 3};
    tulle_error error = {0};
    for (size_t i = 0; i < sizeof order / sizeof order[0]; i++) {
        const tulle_run_debug *debug = NULL;
        assert_int_equal(tulle_run_reader_read_debug(reader, order[i], &debug, &error), TULLE_OK);
        assert_debug(debug, find_state(order[i]), order[i] * STEPS_PER_FRAME);
    }
    const tulle_run_debug *debug = (const tulle_run_debug *)&size;
    assert_int_equal(tulle_run_reader_read_debug(reader, FRAME_COUNT + 1, &debug, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_null(debug);
    assert_int_equal(tulle_run_reader_read_debug(NULL, 0, &debug, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_int_equal(tulle_run_reader_read_debug(reader, 0, NULL, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    tulle_run_reader_close(reader);
}

static void a_plain_run_has_none(void **state) {
    (void)state;
    const char *const directory = test_path("plain");
    run_whole(directory, 2);
    records_debug = 0;
    tulle_error error = {0};
    assert_int_equal(resume_run(directory, 3, &error), TULLE_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "keeps debug records"));
    assert_sound(directory);
    /* replaced by a plain run, which ignores what frames explain */
    tulle_run_def const def = make_def(directory, 2);
    tulle_run_writer *writer = NULL;
    tulle_run_checkpoint none = {0};
    assert_int_equal(tulle_run_create(&def, TULLE_RUN_REPLACE, &writer, &error), TULLE_OK);
    assert_int_equal(go_on(writer, &none, 2, &error), TULLE_OK);
    assert_int_equal(tulle_run_close(writer, TULLE_RUN_FINISHED, NULL, &error), TULLE_OK);
    assert_int_equal(count_files(directory), FILE_COUNT - 1);
    assert_int_equal(resume_run(directory, 3, &error), TULLE_OK);
    tulle_run_reader *const reader = open_reader(directory);
    const tulle_run_debug *debug = NULL;
    assert_int_equal(tulle_run_reader_get_info(reader)->has_debug, 0);
    assert_int_equal(tulle_run_reader_get_info(reader)->debug_byte_count, 0);
    assert_int_equal(tulle_run_reader_read_debug(reader, 0, &debug, &error),
                     TULLE_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "--record debug"));
    tulle_run_reader_close(reader);
    records_debug = 1;
    assert_int_equal(resume_run(directory, 4, &error), TULLE_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "keeps no debug records"));
}

/* Velocities without contacts and patches; the run is cut, goes on, and knows what it keeps. */
static void velocities_may_be_kept_alone(void **state) {
    (void)state;
    const char *const directory = test_path("velocities");
    records_debug = 2;
    run_whole(directory, 4);
    tulle_error error = {0};
    assert_int_equal(resume_run(directory, FRAME_COUNT, &error), TULLE_OK);
    assert_sound(directory);
    tulle_run_reader *const reader = open_reader(directory);
    assert_int_equal(tulle_run_reader_get_info(reader)->has_debug, 0);
    assert_int_equal(tulle_run_reader_get_info(reader)->has_velocities, 1);
    for (uint32_t frame = 0; frame <= FRAME_COUNT; frame++) {
        const tulle_run_debug *debug = NULL;
        assert_int_equal(tulle_run_reader_read_debug(reader, frame, &debug, &error), TULLE_OK);
        assert_debug(debug, find_state(frame), frame * STEPS_PER_FRAME);
    }
    tulle_run_reader_close(reader);
    records_debug = 1;
    assert_int_equal(resume_run(directory, 4, &error), TULLE_ERROR_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "keeps velocities alone"));
    /* what run.json says goes before what the blocks say */
    size_t size;
    char *const text = get_file(test_path("velocities/run.json"), &size);
    char *const key = strstr(text, "\"velocities\"");
    assert_non_null(key);
    memcpy(key, "\"debug\"     ", strlen("\"velocities\""));
    seal_record(text);
    put_file(test_path("velocities/run.json"), text, size);
    free(text);
    tulle_run_reader *const wrong = open_reader(directory);
    const tulle_run_debug *debug = NULL;
    assert_int_equal(tulle_run_reader_read_debug(wrong, 1, &debug, &error), TULLE_ERROR_PARSE);
    assert_non_null(strstr(error.message, "something else than run.json says"));
    tulle_run_reader_close(wrong);
}

/* A run.json that says nothing of records. */
static void a_run_without_the_key_is_plain(void **state) {
    (void)state;
    const char *const directory = test_path("old");
    records_debug = 0;
    run_whole(directory, 2);
    size_t size;
    char *const text = get_file(test_path("old/run.json"), &size);
    char *const key = strstr(text, "  \"record\": \"plain\",\n");
    assert_non_null(key);
    memset(key, ' ', strlen("  \"record\": \"plain\","));
    seal_record(text);
    put_file(test_path("old/run.json"), text, size);
    free(text);
    tulle_run_reader *const reader = open_reader(directory);
    assert_int_equal(tulle_run_reader_get_info(reader)->has_debug, 0);
    tulle_run_reader_close(reader);
    tulle_error error = {0};
    assert_int_equal(resume_run(directory, 3, &error), TULLE_OK);
    records_debug = 1;
}

/* Reads all frames; those that can be read are what was written. Returns how many. */
static uint32_t count_sound_frames(tulle_run_reader *reader, uint32_t frame_count) {
    uint32_t sound = 0;
    for (uint32_t frame = 0; frame < frame_count; frame++) {
        const tulle_run_debug *debug = NULL;
        tulle_error error = {0};
        tulle_status const status = tulle_run_reader_read_debug(reader, frame, &debug, &error);
        if (!status) {
            assert_debug(debug, find_state(frame), frame * STEPS_PER_FRAME);
            sound++;
            continue;
        }
        assert_null(debug);
        assert_int_equal(status, TULLE_ERROR_PARSE);
        assert_non_null(strstr(error.file, "debug.bin"));
        assert_non_null(strstr(error.message, "byte "));
    }
    return sound;
}

static void every_cut_and_flipped_bit_is_noticed(void **state) {
    (void)state;
    const char *const directory = test_path("bits");
    run_whole(directory, 4);
    size_t size;
    char *const bytes = get_file(test_path("bits/debug.bin"), &size);
    tulle_run_reader *reader = open_reader(directory);
    assert_int_equal(count_sound_frames(reader, 5), 5);
    tulle_run_reader_close(reader);
    uint32_t last = 0;
    for (size_t cut = 0; cut < size; cut += 11) {
        put_file(test_path("bits/debug.bin"), bytes, cut);
        reader = open_reader(directory);
        uint32_t const sound = count_sound_frames(reader, 5);
        tulle_run_reader_close(reader);
        assert_true(sound >= last && sound < 5); /* frames before the cut stay */
        last = sound;
    }
    assert_int_equal(last, 4);
    for (size_t bit = 0; bit < 8 * size; bit += bit < 8 * 64 ? 1 : 37) {
        bytes[bit / 8] ^= (char)(1 << bit % 8);
        put_file(test_path("bits/debug.bin"), bytes, size);
        bytes[bit / 8] ^= (char)(1 << bit % 8);
        reader = open_reader(directory);
        if (count_sound_frames(reader, 5) == 5) fail_msg("bit %zu flipped is not noticed", bit);
        tulle_run_reader_close(reader);
    }
    free(bytes);
    remove(test_path("bits/debug.bin"));
    reader = open_reader(directory);
    const tulle_run_debug *debug;
    assert_int_equal(tulle_run_reader_read_debug(reader, 0, &debug, NULL), TULLE_ERROR_IO);
    assert_int_equal(tulle_run_reader_get_info(reader)->frame_count, 5);
    tulle_run_reader_close(reader);
}

/* Bytes changed with the hashes made right again: as by a hostile hand. */
static void forged_blocks_do_no_harm(void **state) {
    (void)state;
    const char *const directory = test_path("forged");
    run_whole(directory, 0);
    size_t size;
    unsigned char *const bytes = (unsigned char *)get_file(test_path("forged/debug.bin"), &size);
    unsigned char *const forged = malloc(size);
    unsigned char *const header = forged + HEAD_SIZE;
    uint64_t seed = 3;
    int refused = 0;
    int const rounds = 4000;
    for (int round = 0; round < rounds; round++) {
        memcpy(forged, bytes, size);
        size_t const place =
            round % 4 ? HEADER_SIZE + random_next(&seed) % (size - HEAD_SIZE - HEADER_SIZE)
                      : 24 + random_next(&seed) % 8;
        header[place] = (unsigned char)(round % 3 ? random_next(&seed) : 0xff);
        uint64_t hash = hash_bytes(HASH_SEED, header + HEADER_SIZE, size - HEAD_SIZE - HEADER_SIZE);
        memcpy(header + 16, &hash, sizeof hash);
        hash = hash_bytes(HASH_SEED, header, 32);
        memcpy(header + 32, &hash, sizeof hash);
        put_file(test_path("forged/debug.bin"), (const char *)forged, size);
        tulle_run_reader *const reader = open_reader(directory);
        const tulle_run_debug *debug = NULL;
        tulle_status const status = tulle_run_reader_read_debug(reader, 0, &debug, NULL);
        assert_true(status == TULLE_OK || status == TULLE_ERROR_PARSE);
        refused += status != TULLE_OK;
        for (size_t i = 0; debug && i < debug->contact_count; i++) {
            const tulle_contact *const contact = &debug->contacts[i];
            assert_true(contact->object_a < BODY_COUNT && contact->object_b < BODY_COUNT);
            assert_true(contact->state <= TULLE_CONTACT_SLIP && isfinite(contact->gap));
            for (int k = 0; k < 4; k++) assert_true(contact->vertices[k] < CLOTH_VERTICES);
        }
        tulle_run_reader_close(reader);
    }
    print_message("%d of %d forged blocks are refused\n", refused, rounds);
    assert_true(refused > rounds / 20);
    free(bytes);
    free(forged);
}

static void assert_bytes(const char *path, const char *expected, size_t expected_size) {
    size_t size;
    char *const bytes = get_file(path, &size);
    assert_int_equal(size, expected_size);
    assert_memory_equal(bytes, expected, size);
    free(bytes);
}

static void a_run_resumes_before_its_damaged_records(void **state) {
    (void)state;
    const char *const directory = test_path("short");
    run_whole(directory, 5);
    size_t size;
    char *const bytes = get_file(test_path("short/debug.bin"), &size);
    /* the last frame is torn: the checkpoint before does without it */
    put_file(test_path("short/debug.bin"), bytes, size - 1);
    tulle_error error = {0};
    if (resume_run(directory, 5, &error)) fail_msg("%s: %s", error.file, error.message);
    assert_bytes(test_path("short/debug.bin"), bytes, size);
    assert_sound(directory);
    put_file(test_path("short/debug.bin"), bytes, HEAD_SIZE);
    assert_int_equal(resume_run(directory, 5, &error), TULLE_ERROR_PARSE);
    assert_non_null(strstr(error.file, "debug.bin"));
    assert_non_null(strstr(error.message, "frame 0: "));
    /* what is behind the checkpoint is cut off */
    char *const longer = calloc(1, size + 100);
    memcpy(longer, bytes, size);
    put_file(test_path("short/debug.bin"), longer, size + 100);
    if (resume_run(directory, 5, &error)) fail_msg("%s: %s", error.file, error.message);
    assert_bytes(test_path("short/debug.bin"), bytes, size);
    free(bytes);
    free(longer);
}

static void wrong_records_are_refused(void **state) {
    (void)state;
    tulle_run_def const def = make_def(test_path("wrong"), 2);
    tulle_run_writer *writer = NULL;
    tulle_error error = {0};
    assert_int_equal(tulle_run_create(&def, TULLE_RUN_REFUSE, &writer, &error), TULLE_OK);
    debug_source source;
    for (int fault = 0; fault < 8; fault++) {
        find_debug(19, &source);
        assert_true(source.debug.contact_count > 3);
        if (fault == 0) source.debug.velocities = NULL;
        if (fault == 1) source.velocity_pointers[2] = NULL;
        if (fault == 2) source.label_pointers[1] = NULL;
        if (fault == 3) source.labels[1][5] = source.patch_counts[1] + 1;
        if (fault == 4) source.contacts[3].object_b = BODY_COUNT;
        if (fault == 5) source.contacts[3].vertices[0] = CLOTH_VERTICES;
        if (fault == 6) source.contacts[3].state = (tulle_contact_state)3;
        if (fault == 7) source.debug.contacts = NULL;
        const double *const positions[BODY_COUNT] = {cloth_positions, cloth_positions,
                                                     box_positions, NULL};
        tulle_run_frame const frame = {.positions = positions, .debug = &source.debug};
        assert_int_equal(tulle_run_write_frame(writer, &frame, &error),
                         TULLE_ERROR_INVALID_ARGUMENT);
        assert_int_equal(tulle_run_get_frame_count(writer), 0);
    }
    tulle_run_checkpoint none = {0};
    assert_int_equal(go_on(writer, &none, 2, &error), TULLE_OK);
    assert_int_equal(tulle_run_close(writer, TULLE_RUN_FINISHED, NULL, &error), TULLE_OK);
    assert_int_equal(assert_sound(test_path("wrong")), 3);
}

static int begin_tests(void **state) {
    make_bodies();
    return make_test_folder(state);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(frames_can_be_read_in_any_order),
        cmocka_unit_test(a_plain_run_has_none),
        cmocka_unit_test(velocities_may_be_kept_alone),
        cmocka_unit_test(a_run_without_the_key_is_plain),
        cmocka_unit_test(every_cut_and_flipped_bit_is_noticed),
        cmocka_unit_test(forged_blocks_do_no_harm),
        cmocka_unit_test(a_run_resumes_before_its_damaged_records),
        cmocka_unit_test(wrong_records_are_refused),
    };
    return cmocka_run_group_tests(tests, begin_tests, remove_test_folder);
}
