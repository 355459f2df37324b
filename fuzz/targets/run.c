/* fuzz/targets/run.c - the reader of run directories, and going on with one.
 *
 * A whole run is made once. An input replaces some of its files: after the word FILE stands a
 * letter, which names the file, and then its contents up to the next FILE. With a capital letter
 * the hashes within the file are made right. After FILE! checksums.csv is made true of all files as
 * they then are. */
#define _XOPEN_SOURCE 700
#include "support/fuzz.h"

#include "io/run/run_debug_format.h"
#include "io/run_support.h"

enum {
    FRAMES = 3,
    CHECKPOINT_HEADER = 96, /* [bytes] src/io/run/FORMAT.md */
    CHECKPOINT_SUMS_SIZE = 72,
    CHECKPOINT_CHAIN = 80,
    CHECKPOINT_HASH = 88,
    DIGITS = 16 /* of a hash in a text */
};
static const char mark[] = "FILE";
enum { MARK_SIZE = sizeof mark - 1, MAKES_SUMS_RIGHT = '!' };

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

static void put_hash(char *to, uint64_t hash) {
    char digits[DIGITS + 1];
    snprintf(digits, sizeof digits, "%016llx", (unsigned long long)hash);
    memcpy(to, digits, DIGITS);
}

/* Hashes of a checkpoint or of the blocks of debug.bin, and the checksum at the end of run.json. */
static void make_hashes_right(const char *name, uint8_t *bytes, size_t size) {
    if (strncmp(name, "checkpoint", 10) == 0 && size >= CHECKPOINT_HEADER) {
        uint64_t const hash = hash_bytes(HASH_SEED, bytes, CHECKPOINT_HASH);
        uint64_t const all = hash_bytes(hash, bytes + CHECKPOINT_HEADER, size - CHECKPOINT_HEADER);
        memcpy(bytes + CHECKPOINT_HASH, &all, sizeof all);
    }
    enum { SEAL_SIZE = sizeof ",\n  \"checksum\": \"\"\n}\n" - 1 + DIGITS };
    if (strcmp(name, RUN_FILE_RECORD) == 0 && size >= SEAL_SIZE)
        put_hash((char *)bytes + size - 4 - DIGITS,
                 hash_bytes(FILE_SUM_SEED, bytes, size - SEAL_SIZE));
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

/* What the line `file,frame,begin,end,hash,chain` says of the hash of its piece is made true, where
 * the piece is there; then its chain, which goes on from `chain`. Returns the new chain. */
static uint64_t make_line_right(char *line, size_t length, uint64_t chain,
                                const whole_file *files) {
    enum { TAIL = 2 * DIGITS + 2 }; /* hash, comma, chain and the line's end */
    const char *const name_end = memchr(line, ',', length);
    if (length <= TAIL || !name_end || name_end >= line + length - TAIL) return chain;
    unsigned long long begin = 0, end = 0;
    const char *const frame_end = strchr(name_end + 1, ',');
    bool const has_piece = frame_end && sscanf(frame_end, ",%llu,%llu,", &begin, &end) == 2;
    for (size_t i = 0; has_piece && i < FILE_COUNT; i++)
        if (strlen(all_files[i]) == (size_t)(name_end - line) &&
            memcmp(all_files[i], line, strlen(all_files[i])) == 0 && begin <= end &&
            end <= files[i].size)
            put_hash(line + length - TAIL,
                     hash_bytes(FILE_SUM_SEED, files[i].bytes + begin, (size_t)(end - begin)));
    chain = hash_bytes(chain, line, length - DIGITS - 1);
    put_hash(line + length - DIGITS - 1, chain);
    return chain;
}

/* The place of a file in all_files. */
static size_t find_file(const char *name) {
    size_t i = 0;
    while (strcmp(all_files[i], name) != 0) i++;
    return i;
}

/* Makes checksums.csv true of all files in `files`, and what run.json and the checkpoints say of
 * its chain. */
static void make_sums_right(whole_file *files) {
    static const char *const checkpoints[] = {"checkpoint.bin", "checkpoint.previous.bin"};
    static const char key[] = "\"chain\": \"";
    const whole_file *const sums = &files[find_file("checksums.csv")];
    const whole_file *const record = &files[find_file(RUN_FILE_RECORD)];
    uint64_t chain = HASH_SEED;
    for (size_t begin = 0, end; begin < sums->size; begin = end) {
        const char *const line_end = memchr(sums->bytes + begin, '\n', sums->size - begin);
        end = line_end ? (size_t)(line_end - sums->bytes) + 1 : sums->size;
        chain = begin == 0 ? hash_bytes(chain, sums->bytes, end)
                           : make_line_right(sums->bytes + begin, end - begin, chain, files);
        for (size_t k = 0; k < 2; k++) {
            const whole_file *const checkpoint = &files[find_file(checkpoints[k])];
            uint64_t size;
            if (checkpoint->size < CHECKPOINT_HEADER) continue;
            memcpy(&size, checkpoint->bytes + CHECKPOINT_SUMS_SIZE, sizeof size);
            if (size == end) memcpy(checkpoint->bytes + CHECKPOINT_CHAIN, &chain, sizeof chain);
        }
    }
    for (size_t k = 0; k < 2; k++) {
        const whole_file *const checkpoint = &files[find_file(checkpoints[k])];
        make_hashes_right(checkpoints[k], (uint8_t *)checkpoint->bytes, checkpoint->size);
    }
    char *const place = strstr(record->bytes, key);
    if (place && (size_t)(record->bytes + record->size - place) > sizeof key + DIGITS)
        put_hash(place + sizeof key - 1, chain);
    make_hashes_right(RUN_FILE_RECORD, (uint8_t *)record->bytes, record->size);
}

/* The same of the files in a folder. */
static void make_folder_right(const char *folder) {
    whole_file files[FILE_COUNT];
    for (size_t i = 0; i < FILE_COUNT; i++)
        files[i].bytes = get_file(get_path(folder, i), &files[i].size);
    make_sums_right(files);
    for (size_t i = 0; i < FILE_COUNT; i++) {
        put_file(get_path(folder, i), files[i].bytes, files[i].size);
        free(files[i].bytes);
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
    make_folder_right("whole");
    for (size_t i = 0; i < FILE_COUNT; i++) {
        size_t size;
        char *const same = get_file(get_path("whole", i), &size);
        FUZZ_CHECK(size == whole[i].size && memcmp(same, whole[i].bytes, size) == 0);
        free(same);
    }
    FUZZ_CHECK(mkdir(fuzz_path("run"), 0777) == 0);
}

static const uint8_t *find_mark(const uint8_t *at, const uint8_t *end) {
    while (end - at >= MARK_SIZE && memcmp(at, mark, MARK_SIZE) != 0) at++;
    return end - at >= MARK_SIZE ? at : end;
}

static void replace_files(const uint8_t *data, size_t size) {
    const uint8_t *const end = data + size;
    bool is_made_right = false;
    for (const uint8_t *at = find_mark(data, end); end - at > MARK_SIZE;) {
        int const letter = at[MARK_SIZE];
        is_made_right |= letter == MAKES_SUMS_RIGHT;
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
    if (is_made_right) make_folder_right("run");
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
        const tulle_run_lag *lags = NULL;
        size_t lag_count = 0;
        if (tulle_run_reader_get_lags(reader, frame, &lags, &lag_count) == TULLE_OK)
            for (size_t k = 0; k < lag_count; k++)
                FUZZ_CHECK(lags[k].lag > 0.0 && lags[k].body < info->body_count);
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
        char head[32];
        int const length = snprintf(head, sizeof head, "%s%c%s%c", mark, MAKES_SUMS_RIGHT, mark,
                                    (char)('A' + (int)i));
        size_t const size = (size_t)length + whole[i].size;
        char *const seed = malloc(size);
        FUZZ_CHECK(seed);
        memcpy(seed, head, (size_t)length);
        memcpy(seed + length, whole[i].bytes, whole[i].size);
        fuzz_put_seed(all_files[i], seed, size);
        free(seed);
    }
}
