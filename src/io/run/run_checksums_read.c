/* io/run/run_checksums_read.c - reads checksums.csv and compares files with it, see
 * run_checksums.h.
 */
#define _POSIX_C_SOURCE 200809L
#include "io/run/run_checksums_format.h"

#include "base/error.h"
#include "base/sort.h"
#include "io/text/number.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

enum { CHUNK_SIZE = 1 << 13 /* [bytes] hashed at a time, on the stack; whole words */ };

/* ---- the lines ---- */

static bool take_number(const char *text, const char *end, uint64_t *value) {
    int64_t number = -1;
    bool const is_read = number_parse_integer(text, (size_t)(end - text), &number) == NUMBER_READ;
    *value = (uint64_t)number;
    return is_read && number >= 0;
}

/* Takes a line apart, from its first byte up to its chain. The name gets a zero behind. */
static bool parse_line(char *text, char *chain, checksum_line *line) {
    char *fields[6] = {text};
    size_t count = 1;
    for (char *at = text; at < chain && count < 6; at++)
        if (*at == ',') fields[count++] = at + 1;
    if (count < 6 || fields[5] != chain || fields[1] == text + 1) return false;
    uint64_t frame = 0;
    bool const has_frame = fields[2] > fields[1] + 1;
    *line = (checksum_line){.name = text, .frame = CHECKSUM_NO_FRAME};
    if (has_frame && (!take_number(fields[1], fields[2] - 1, &frame) || frame >= INT32_MAX))
        return false;
    if (has_frame) line->frame = (int64_t)frame;
    fields[1][-1] = '\0';
    /* A directory from a stranger leads to no files but its own. */
    const char *const base = strncmp(text, "vtp/", 4) == 0 ? text + 4 : text;
    if (*base == '\0' || *base == '.' || strchr(base, '/')) return false;
    line->name_hash = hash_bytes(HASH_SEED, text, strlen(text));
    return take_number(fields[2], fields[3] - 1, &line->sum.begin) &&
           take_number(fields[3], fields[4] - 1, &line->sum.end) &&
           line->sum.end > line->sum.begin &&
           json_parse_hash(fields[4], (size_t)(chain - 1 - fields[4]), &line->sum.hash);
}

/* By file, place and age. */
static int compare_lines(const void *a, const void *b) {
    const checksum_line *const one = a, *const other = b;
    if (one->name_hash != other->name_hash) return one->name_hash < other->name_hash ? -1 : 1;
    if (one->sum.begin != other->sum.begin) return one->sum.begin < other->sum.begin ? -1 : 1;
    return (one->number > other->number) - (one->number < other->number);
}

static tulle_status read_lines(checksums *sums, const char *path, bool is_to_mark,
                               tulle_error *error) {
    char *at = sums->text.bytes + sums->mark.size;
    const char *const end = sums->text.bytes + sums->text.byte_count;
    for (uint32_t number = 2; at < end; number++) {
        char *const line_end = memchr(at, '\n', (size_t)(end - at));
        if (!line_end && !is_to_mark) break; /* killed while it was written */
        checksum_line line;
        char expected[CHECKSUM_CHAIN_SIZE + 1];
        bool const is_long = line_end && line_end - at >= CHECKSUM_CHAIN_SIZE;
        char *const chain = is_long ? line_end + 1 - CHECKSUM_CHAIN_SIZE : at;
        sums->mark.chain = hash_bytes(sums->mark.chain, at, (size_t)(chain - at));
        (void)snprintf(expected, sizeof expected, "%016llx\n",
                       (unsigned long long)sums->mark.chain);
        if (!is_long || memcmp(chain, expected, CHECKSUM_CHAIN_SIZE) != 0 ||
            !parse_line(at, chain, &line))
            return error_set_at(error, TULLE_ERROR_PARSE, path, (int)number, 0,
                                "this line is not as the run wrote it");
        line.number = number;
        if (!ARRAY_RESERVE(sums->heap, &sums->lines, 1)) return file_fail_memory(error, path);
        sums->lines.data[sums->lines.count++] = line;
        if (line.frame >= 0 && strcmp(line.name, RUN_FILE_FRAMES) == 0)
            sums->frame_count = (uint32_t)line.frame + 1;
        at = line_end + 1;
        sums->mark.size = (uint64_t)(at - sums->text.bytes);
    }
    return TULLE_OK;
}

static void sort_lines(checksums *sums) {
    size_t kept = 0;
    sort_in_place(sums->lines.data, sums->lines.count, sizeof *sums->lines.data, compare_lines);
    for (size_t i = 0; i < sums->lines.count; i++) {
        const checksum_line *const line = &sums->lines.data[i];
        bool const is_replaced = i + 1 < sums->lines.count &&
                                 line[1].name_hash == line->name_hash &&
                                 line[1].sum.begin == line->sum.begin;
        if (!is_replaced) sums->lines.data[kept++] = *line;
    }
    sums->lines.count = kept;
}

tulle_status checksums_read(checksums *sums, memory *heap, const char *directory,
                            const checksum_mark *mark, tulle_error *error) {
    char path[RUN_PATH_SIZE];
    run_join(path, directory, RUN_FILE_CHECKSUMS);
    *sums = (checksums){.heap = heap, .mark = checksums_get_first_mark()};
    tulle_status status = file_load(heap, path, 0, &sums->text, error);
    if (status) return status;
    size_t const size = sums->text.byte_count;
    if (mark && mark->size > size)
        return error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                            "byte %zu: the file ends here, but the run wrote %llu bytes", size,
                            (unsigned long long)mark->size);
    size_t const wanted = mark ? (size_t)mark->size : size;
    if (wanted >= sums->mark.size &&
        memcmp(sums->text.bytes, CHECKSUMS_HEADING, (size_t)sums->mark.size) == 0) {
        file_data const whole = sums->text;
        sums->text.byte_count = wanted;
        status = read_lines(sums, path, mark != NULL, error);
        sums->text = whole;
    } else if (wanted > 0) { /* empty: killed while it was made */
        status = error_set_at(error, TULLE_ERROR_PARSE, path, 1, 0,
                              "this line is not as the run wrote it");
    }
    if (!status && mark && mark->chain != sums->mark.chain)
        status = error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                              "its lines are not those that the run wrote");
    if (!status) sort_lines(sums);
    return status;
}

void checksums_release(checksums *sums) {
    if (!sums->heap) return;
    ARRAY_FREE(sums->heap, &sums->lines);
    file_release(sums->heap, &sums->text);
}

/* The first line that is not before that piece. */
static size_t find_place(const checksums *sums, const char *name, uint64_t begin) {
    checksum_line const wanted = {.name_hash = hash_bytes(HASH_SEED, name, strlen(name)),
                                  .sum.begin = begin};
    size_t first = 0, last = sums->lines.count;
    while (first < last) {
        size_t const middle = first + (last - first) / 2;
        if (compare_lines(&sums->lines.data[middle], &wanted) < 0)
            first = middle + 1;
        else
            last = middle;
    }
    return first;
}

static bool is_of_file(const checksums *sums, size_t line, const char *name) {
    return line < sums->lines.count && strcmp(sums->lines.data[line].name, name) == 0;
}

const checksum_line *checksums_find(const checksums *sums, const char *name, uint64_t begin) {
    size_t const place = find_place(sums, name, begin);
    bool const is_found =
        is_of_file(sums, place, name) && sums->lines.data[place].sum.begin == begin;
    return is_found ? &sums->lines.data[place] : NULL;
}

uint64_t checksums_get_end(const checksums *sums, const char *name) {
    uint64_t end = 0;
    for (size_t i = find_place(sums, name, 0); is_of_file(sums, i, name); i++)
        end = sums->lines.data[i].sum.end;
    return end;
}

/* ---- the files ---- */

/* "frame 7: ", or nothing. */
static const char *name_frame(int64_t frame, char text[32]) {
    text[0] = '\0';
    if (frame >= 0) (void)snprintf(text, 32, "frame %lld: ", (long long)frame);
    return text;
}

tulle_status checksum_fail(const char *path, int64_t frame, const file_sum *sum,
                           tulle_error *error) {
    char text[32];
    return error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                        "%sdamaged: its bytes %llu to %llu are not those that the run wrote",
                        name_frame(frame, text), (unsigned long long)sum->begin,
                        (unsigned long long)sum->end - 1);
}

static tulle_status check_piece(int file, const char *path, const checksum_line *line,
                                tulle_error *error) {
    unsigned char chunk[CHUNK_SIZE];
    char frame[32];
    uint64_t hash = FILE_SUM_SEED;
    for (uint64_t at = line->sum.begin; at < line->sum.end; at += CHUNK_SIZE) {
        uint64_t const left = line->sum.end - at;
        size_t const wanted = left < CHUNK_SIZE ? (size_t)left : CHUNK_SIZE;
        ssize_t const got = file_read_at(file, chunk, wanted, at);
        if (got < 0) return file_fail(error, path, errno, "cannot be read");
        if ((size_t)got < wanted)
            return error_set_at(
                error, TULLE_ERROR_PARSE, path, 0, 0,
                "%sdamaged: the file ends at byte %llu, but the run wrote bytes %llu to %llu",
                name_frame(line->frame, frame), (unsigned long long)at + (size_t)got,
                (unsigned long long)line->sum.begin, (unsigned long long)line->sum.end - 1);
        hash = hash_bytes(hash, chunk, wanted);
    }
    return hash == line->sum.hash ? TULLE_OK : checksum_fail(path, line->frame, &line->sum, error);
}

/* Compares the file of the line `first` and goes to that of the next file; *frame: of the damage.
 */
/* Meshes, the scene and VTP frames appear whole. All other files grow, and what a kill has left
 * behind their lines is cut off. */
static bool is_written_at_once(const char *name) {
    static const char *const ends[] = {".obj", ".yaml", ".vtp"};
    const char *const end = strrchr(name, '.');
    for (size_t i = 0; end && i < sizeof ends / sizeof *ends; i++)
        if (strcmp(end, ends[i]) == 0) return true;
    return false;
}

static tulle_status check_lines(const checksums *sums, const char *directory, uint32_t frame_limit,
                                size_t *first, int64_t *frame, tulle_error *error) {
    const char *const name = sums->lines.data[*first].name;
    char path[RUN_PATH_SIZE];
    run_join(path, directory, name);
    int file = -1;
    struct stat facts;
    tulle_status status = TULLE_OK;
    *frame = CHECKSUM_NO_FRAME;
    for (; is_of_file(sums, *first, name); ++*first) {
        const checksum_line *const line = &sums->lines.data[*first];
        if (status || line->frame >= (int64_t)frame_limit) continue;
        if (file < 0) {
            file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
            if (file < 0)
                status = errno == ENOENT
                             ? error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                                            "damaged: cannot be opened: it is missing")
                             : file_fail(error, path, errno, "damaged: cannot be opened");
            if (!status && fstat(file, &facts) != 0)
                status = file_fail(error, path, errno, "cannot be examined");
            if (!status && !S_ISREG(facts.st_mode))
                status = error_set_at(error, TULLE_ERROR_IO, path, 0, 0,
                                      "damaged: is not a regular file");
        }
        if (!status) status = check_piece(file, path, line, error);
        if (status) *frame = line->frame;
    }
    uint64_t const end = sums->lines.data[*first - 1].sum.end;
    bool const must_end = sums->is_complete || is_written_at_once(name);
    if (!status && file >= 0 && must_end && (uint64_t)facts.st_size > end)
        status = error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                              "damaged: the file has %lld bytes, but the run wrote %llu",
                              (long long)facts.st_size, (unsigned long long)end);
    if (file >= 0) close(file);
    return status;
}

tulle_status checksums_check_file(const checksums *sums, const char *directory, const char *name,
                                  uint32_t frame_limit, tulle_error *error) {
    size_t first = find_place(sums, name, 0);
    int64_t frame;
    return is_of_file(sums, first, name)
               ? check_lines(sums, directory, frame_limit, &first, &frame, error)
               : TULLE_OK;
}

void checksums_check_files(const checksums *sums, const char *directory, uint32_t frame_limit,
                           checksum_handler *handler, void *context) {
    for (size_t i = 0; i < sums->lines.count;) {
        tulle_error error = {0};
        const char *const name = sums->lines.data[i].name;
        int64_t frame;
        if (check_lines(sums, directory, frame_limit, &i, &frame, &error))
            handler(context, name, frame, &error);
    }
}
