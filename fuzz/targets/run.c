/* fuzz/targets/run.c - the reader of run directories, and going on with one.
 *
 * A whole run is made once. An input replaces some of its files: after the word FILE stands a
 * letter, which names the file, and then its contents up to the next FILE. With a capital letter
 * the hashes within the file are made right. */
#define _XOPEN_SOURCE 700
#include "support/fuzz.h"

#include "io/run/run_debug_format.h"
#include "io/run_support.h"

enum {
    FRAMES = 3,
    CHECKPOINT_HEADER = 96, /* [bytes] docs/guide/run_directory.md */
    CHECKPOINT_HASH = 88
};
static const char mark[] = "FILE";
enum { MARK_SIZE = sizeof mark - 1 };

typedef struct whole_file {
    char *bytes;
    size_t size;
} whole_file;
static whole_file whole[FILE_COUNT];

static const char *get_path(const char *folder, size_t file) {
    char name[128];
    snprintf(name, sizeof name, "%s/%s", folder, all_files[file]);
    return fuzz_path(name);
}

/* Hashes of a checkpoint or of the blocks of debug.bin, and the checksum at the end of run.json. */
static void make_hashes_right(const char *name, uint8_t *bytes, size_t size) {
    if (strncmp(name, "checkpoint", 10) == 0 && size >= CHECKPOINT_HEADER) {
        uint64_t const hash = hash_bytes(HASH_SEED, bytes, CHECKPOINT_HASH);
        uint64_t const all = hash_bytes(hash, bytes + CHECKPOINT_HEADER, size - CHECKPOINT_HEADER);
        memcpy(bytes + CHECKPOINT_HASH, &all, sizeof all);
    }
    enum { DIGITS = 16, SEAL_SIZE = sizeof ",\n  \"checksum\": \"\"\n}\n" - 1 + DIGITS };
    if (strcmp(name, RUN_FILE_RECORD) == 0 && size >= SEAL_SIZE) {
        char digits[DIGITS + 1];
        uint64_t const hash = hash_bytes(FILE_SUM_SEED, bytes, size - SEAL_SIZE);
        snprintf(digits, sizeof digits, "%016llx", (unsigned long long)hash);
        memcpy(bytes + size - 4 - DIGITS, digits, DIGITS);
    }
    size_t at = strcmp(name, RUN_FILE_DEBUG) == 0 ? DEBUG_HEAD_SIZE : size;
    while (at <= size && size - at >= DEBUG_HEADER_SIZE) {
        uint8_t *const block = bytes + at;
        uint64_t length;
        memcpy(&length, block + DEBUG_PLACE_SIZE, sizeof length);
        if (length < DEBUG_HEADER_SIZE || length > size - at) return;
        uint64_t hash =
            hash_bytes(HASH_SEED, block + DEBUG_HEADER_SIZE, (size_t)length - DEBUG_HEADER_SIZE);
        memcpy(block + DEBUG_PLACE_PAYLOAD_HASH, &hash, sizeof hash);
        hash = hash_bytes(HASH_SEED, block, DEBUG_PLACE_HEADER_HASH);
        memcpy(block + DEBUG_PLACE_HEADER_HASH, &hash, sizeof hash);
        at += (size_t)length;
    }
}

static void make_whole_run(void) {
    if (whole[0].bytes) return;
    make_bodies();
    run_whole(fuzz_path("whole"), FRAMES);
    for (size_t i = 0; i < FILE_COUNT; i++) {
        size_t size;
        whole[i].bytes = get_file(get_path("whole", i), &whole[i].size);
        /* The places above are those of the formats: what is right stays as it is. */
        char *const copy = get_file(get_path("whole", i), &size);
        make_hashes_right(all_files[i], (uint8_t *)copy, size);
        FUZZ_CHECK(memcmp(copy, whole[i].bytes, size) == 0);
        free(copy);
    }
    FUZZ_CHECK(mkdir(fuzz_path("run"), 0777) == 0);
}

static const uint8_t *find_mark(const uint8_t *at, const uint8_t *end) {
    while (end - at >= MARK_SIZE && memcmp(at, mark, MARK_SIZE) != 0) at++;
    return end - at >= MARK_SIZE ? at : end;
}

static void replace_files(const uint8_t *data, size_t size) {
    const uint8_t *const end = data + size;
    for (const uint8_t *at = find_mark(data, end); end - at > MARK_SIZE;) {
        int const letter = at[MARK_SIZE];
        const uint8_t *const begin = at + MARK_SIZE + 1;
        at = find_mark(begin, end);
        int const file = letter >= 'a' ? letter - 'a' : letter - 'A';
        if (file < 0 || file >= (int)FILE_COUNT) continue;
        size_t const length = (size_t)(at - begin);
        uint8_t *const bytes = malloc(length + 1);
        FUZZ_CHECK(bytes);
        memcpy(bytes, begin, length);
        if (letter < 'a') make_hashes_right(all_files[file], bytes, length);
        put_file(get_path("run", (size_t)file), bytes, length);
        free(bytes);
    }
}

/* Everything that the reader gives of one body. */
static void read_body(tulle_run_reader *reader, const tulle_run_info *info, size_t body) {
    tulle_error error = {0};
    tulle_mesh_view mesh;
    tulle_status status = tulle_run_reader_get_mesh(reader, body, &mesh, &error);
    if (status) {
        fuzz_check_error(status, &error);
        return;
    }
    fuzz_check_mesh(mesh);
    FUZZ_CHECK(mesh.vertex_count == info->bodies[body].vertex_count);
    FUZZ_CHECK(mesh.triangle_count == info->bodies[body].triangle_count);
    double *const positions = malloc(3 * mesh.vertex_count * sizeof *positions);
    FUZZ_CHECK(positions);
    for (uint32_t frame = 0; frame < info->frame_count; frame++) {
        status = tulle_run_reader_read_positions(reader, frame, body, positions, &error);
        if (status) fuzz_check_error(status, &error);
        (void)tulle_run_reader_is_present(reader, frame, body);
    }
    free(positions);
}

static void read_run(const char *directory) {
    tulle_run_reader *reader = NULL;
    tulle_error error = {0};
    tulle_status status = tulle_run_reader_open(directory, &reader, &error);
    if (status) {
        fuzz_check_error(status, &error);
        FUZZ_CHECK(!reader && strncmp(error.file, directory, strlen(directory)) == 0);
        return;
    }
    const tulle_run_info *const info = tulle_run_reader_get_info(reader);
    for (size_t i = 0; i < info->body_count; i++) read_body(reader, info, i);
    for (uint32_t frame = 0; frame < info->frame_count; frame++) {
        double time;
        uint64_t step, hash;
        status = tulle_run_reader_get_frame(reader, frame, &time, &step, &hash);
        FUZZ_CHECK(status == TULLE_OK && isfinite(time));
        const tulle_run_debug *debug = NULL;
        status = tulle_run_reader_read_debug(reader, frame, &debug, &error);
        if (status) fuzz_check_error(status, &error);
        for (size_t i = 0; !status && debug && i < debug->contact_count; i++)
            FUZZ_CHECK(debug->contacts[i].object_a < info->body_count &&
                       debug->contacts[i].object_b < info->body_count);
    }
    const tulle_step_report *reports;
    size_t count;
    status = tulle_run_reader_get_reports(reader, &reports, &count, &error);
    if (status) fuzz_check_error(status, &error);
    if (info->outcome) {
        char text[2048];
        bool const has_body =
            info->outcome->has_stretch_place && info->outcome->stretch_body < info->body_count;
        tulle_run_outcome_describe(
            info->outcome, has_body ? info->bodies[info->outcome->stretch_body].name : "body", NULL,
            text, sizeof text);
    }
    tulle_run_reader_close(reader);
}

/* What a writer goes on from can be read, to the frames that it names. */
static void resume(const char *directory) {
    tulle_run_def const def = make_def(directory, FRAMES + 1);
    tulle_run_writer *writer = NULL;
    tulle_run_checkpoint checkpoint = {0};
    tulle_run_reader *reader = NULL;
    tulle_error error = {0};
    tulle_status const status = tulle_run_resume(&def, &writer, &checkpoint, &error);
    if (status) {
        fuzz_check_error(status, &error);
        FUZZ_CHECK(!writer);
        return;
    }
    uint32_t const frame_count = tulle_run_get_frame_count(writer);
    FUZZ_CHECK(!checkpoint.bytes || checkpoint.frame_count == frame_count);
    tulle_run_free_checkpoint(&checkpoint);
    FUZZ_CHECK_OK(tulle_run_close(writer, TULLE_RUN_INTERRUPTED, NULL, &error), &error);
    FUZZ_CHECK_OK(tulle_run_reader_open(directory, &reader, &error), &error);
    FUZZ_CHECK(tulle_run_reader_get_info(reader)->frame_count == frame_count);
    tulle_run_reader_close(reader);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    make_whole_run();
    for (size_t i = 0; i < FILE_COUNT; i++)
        put_file(get_path("run", i), whole[i].bytes, whole[i].size);
    replace_files(data, size);
    read_run(fuzz_path("run"));
    resume(fuzz_path("run"));
    return 0;
}

void fuzz_make_seeds(void) {
    make_whole_run();
    for (size_t i = 0; i < FILE_COUNT; i++) {
        size_t const size = MARK_SIZE + 1 + whole[i].size;
        char *const seed = malloc(size + 1);
        FUZZ_CHECK(seed);
        snprintf(seed, size + 1, "%s%c", mark, (char)('A' + (int)i));
        memcpy(seed + MARK_SIZE + 1, whole[i].bytes, whole[i].size);
        fuzz_put_seed(all_files[i], seed, size);
        free(seed);
    }
}
