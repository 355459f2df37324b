/* io/cache/pc2_read.c - reads PC2 and MDD point caches frame by frame. */
#define _POSIX_C_SOURCE 200809L
#include "io/cache/pc2.h"

#include "base/error.h"
#include "base/hash.h"
#include "base/memory.h"
#include "io/bytes.h"
#include "io/cache/pc2_format.h"
#include "io/file_data.h"

#include "tulle_io/cache.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

struct tulle_pc2 {
    memory heap;
    char *path;
    size_t path_size;
    unsigned char *frame; /* bytes of one frame */
    size_t frame_size;
    int file;
    bool is_mdd;
    tulle_pc2_info info;
};

uint64_t pc2_size(uint32_t vertex_count, uint32_t frame_count) {
    return PC2_HEADER_SIZE + (uint64_t)vertex_count * 12 * frame_count;
}

static tulle_status check_header(const char *path, const unsigned char *header, uint64_t file_size,
                                 bool may_be_cut, tulle_pc2_info *info, tulle_error *error) {
    if (memcmp(header, "POINTCACHE2", 12) != 0)
        return error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                            "byte 0: does not begin with \"POINTCACHE2\"; it is not a PC2 file");
    uint32_t const version = (uint32_t)bytes_load(header + 12, 4);
    uint32_t const vertex_count = (uint32_t)bytes_load(header + 16, 4);
    uint32_t const frame_count = (uint32_t)bytes_load(header + PC2_FRAME_COUNT_PLACE, 4);
    if (version != 1)
        return error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                            "byte 12: version %u; only version 1 is known", version);
    if (vertex_count < 1 || vertex_count > PC2_COUNT_LIMIT || frame_count > PC2_COUNT_LIMIT)
        return error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                            "byte 16: %u vertices and %u frames cannot be", vertex_count,
                            frame_count);
    double const start_frame = (double)bytes_to_float(bytes_load(header + 20, 4));
    double const frame_step = (double)bytes_to_float(bytes_load(header + 24, 4));
    if (!isfinite(start_frame) || !isfinite(frame_step))
        return error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                            "byte 20: frames that begin at %g with a step of %g cannot be",
                            start_frame, frame_step);
    uint64_t const there = (file_size - PC2_HEADER_SIZE) / 12 / vertex_count;
    if (there < frame_count && !may_be_cut)
        return error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                            "byte %llu: the file ends here, but %u frames of %u vertices take "
                            "%llu bytes for each frame; it is cut short",
                            (unsigned long long)file_size, frame_count, vertex_count,
                            (unsigned long long)vertex_count * 12);
    *info = (tulle_pc2_info){.vertex_count = vertex_count,
                             .frame_count = there < frame_count ? (uint32_t)there : frame_count,
                             .start_frame = start_frame,
                             .frame_step = frame_step};
    return TULLE_OK;
}

static tulle_status fail_irregular(const char *path, tulle_error *error) {
    return error_set_at(error, TULLE_ERROR_IO, path, 0, 0, "is not a regular file");
}

static tulle_status check_file(const char *path, int file, bool may_be_cut, tulle_pc2_info *info,
                               tulle_error *error) {
    struct stat facts;
    if (fstat(file, &facts) != 0) return file_fail(error, path, errno, "cannot be examined");
    if (!S_ISREG(facts.st_mode)) return fail_irregular(path, error);
    unsigned char header[PC2_HEADER_SIZE];
    ssize_t const count = file_read_at(file, header, sizeof header, 0);
    if (count < 0) return file_fail(error, path, errno, "cannot be read");
    if (count < PC2_HEADER_SIZE)
        return error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                            "byte %zd: the file ends within the header of %d bytes", count,
                            PC2_HEADER_SIZE);
    return check_header(path, header, (uint64_t)facts.st_size, may_be_cut, info, error);
}

/* ---- MDD ---- */

static bool ends_in_mdd(const char *path) {
    size_t const length = strlen(path);
    return length >= 4 && strcasecmp(path + length - 4, ".mdd") == 0;
}

/* [bytes] before the frames: both counts, then a time for each frame. */
static uint64_t measure_mdd_header(uint32_t frame_count) { return 8 + 4 * (uint64_t)frame_count; }

static uint64_t get_place(const tulle_pc2 *cache, uint32_t frame) {
    if (!cache->is_mdd) return pc2_size(cache->info.vertex_count, frame);
    return measure_mdd_header(cache->info.frame_count) +
           (uint64_t)cache->info.vertex_count * 12 * frame;
}

static float load_float(const tulle_pc2 *cache, const unsigned char *bytes) {
    return bytes_to_float(cache->is_mdd ? bytes_load_big_endian(bytes, 4) : bytes_load(bytes, 4));
}

/* The format has no mark of its own, so the size must be the one that the counts say. */
static tulle_status check_mdd(const char *path, int file, tulle_pc2_info *info,
                              tulle_error *error) {
    struct stat facts;
    if (fstat(file, &facts) != 0) return file_fail(error, path, errno, "cannot be examined");
    if (!S_ISREG(facts.st_mode)) return fail_irregular(path, error);
    unsigned char header[8];
    ssize_t const count = file_read_at(file, header, sizeof header, 0);
    if (count < 0) return file_fail(error, path, errno, "cannot be read");
    if (count < (ssize_t)sizeof header)
        return error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                            "byte %zd: the file ends within the header of %zu bytes", count,
                            sizeof header);
    uint32_t const frame_count = (uint32_t)bytes_load_big_endian(header, 4);
    uint32_t const vertex_count = (uint32_t)bytes_load_big_endian(header + 4, 4);
    if (vertex_count < 1 || vertex_count > PC2_COUNT_LIMIT || frame_count > PC2_COUNT_LIMIT)
        return error_set_at(
            error, TULLE_ERROR_PARSE, path, 0, 0,
            "byte 0: %u frames and %u vertices are impossible; it is not an MDD file", frame_count,
            vertex_count);
    *info = (tulle_pc2_info){
        .vertex_count = vertex_count, .frame_count = frame_count, .frame_step = 1.0};
    /* Counts below 2^31 can overflow 64 bits as sizes, so the rest is divided. */
    uint64_t const size = (uint64_t)facts.st_size, head = measure_mdd_header(frame_count);
    uint64_t const frame_size = (uint64_t)vertex_count * 12;
    if (size >= head && (size - head) % frame_size == 0 &&
        (size - head) / frame_size == frame_count)
        return TULLE_OK;
    return error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                        "byte %llu: the file ends here, but %u frames of %u vertices take %llu "
                        "bytes each behind a header of %llu; it is cut short or no MDD file",
                        (unsigned long long)size, frame_count, vertex_count,
                        (unsigned long long)frame_size, (unsigned long long)head);
}

tulle_status tulle_pc2_get_time(const tulle_pc2 *cache, uint32_t frame, double *time,
                                tulle_error *error) {
    if (!cache || !time || frame >= cache->info.frame_count)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, cache ? cache->path : NULL, 0, 0,
                            "there is no frame %u; the cache has %u", frame,
                            cache ? cache->info.frame_count : 0);
    *time = (double)NAN;
    if (!cache->is_mdd) return TULLE_OK;
    unsigned char bytes[4];
    uint64_t const place = measure_mdd_header(frame);
    ssize_t const count = file_read_at(cache->file, bytes, sizeof bytes, place);
    if (count < 0) return file_fail(error, cache->path, errno, "cannot be read");
    if (count == sizeof bytes) *time = (double)load_float(cache, bytes);
    if (isfinite(*time)) return TULLE_OK;
    return error_set_at(error, TULLE_ERROR_PARSE, cache->path, 0, 0,
                        "byte %llu: the time of frame %u is cut or not finite",
                        (unsigned long long)place, frame);
}

/* ---- both ---- */

/* What a file should be. */
typedef enum cache_kind { CACHE_PC2, CACHE_PC2_MAYBE_CUT, CACHE_MDD } cache_kind;

static tulle_status open_file(const char *path, int flags, cache_kind kind, int *file,
                              tulle_pc2_info *info, tulle_error *error) {
    *file = open(path, flags | O_CLOEXEC | O_NONBLOCK);
    if (*file < 0 && errno == ENXIO) return fail_irregular(path, error); /* a socket */
    if (*file < 0) return file_fail(error, path, errno, "cannot be opened");
    tulle_status const status =
        kind == CACHE_MDD ? check_mdd(path, *file, info, error)
                          : check_file(path, *file, kind == CACHE_PC2_MAYBE_CUT, info, error);
    if (status) {
        close(*file);
        *file = -1;
    }
    return status;
}

tulle_status pc2_open_file(const char *path, int flags, bool may_be_cut, int *file,
                           tulle_pc2_info *info, tulle_error *error) {
    return open_file(path, flags, may_be_cut ? CACHE_PC2_MAYBE_CUT : CACHE_PC2, file, info, error);
}

/* The cache of a file that `made` holds open; closes it when memory is short. */
static tulle_status make_cache(const char *path, tulle_pc2 *made, tulle_pc2 **cache,
                               tulle_pc2_info *info, tulle_error *error) {
    memory heap = memory_default();
    made->path_size = strlen(path) + 1;
    made->frame_size = (size_t)made->info.vertex_count * 12;
    /* A header without frames may claim any number of vertices. */
    if (made->info.frame_count == 0) made->frame_size = 0;
    made->path = memory_allocate(&heap, made->path_size);
    made->frame = memory_allocate(&heap, made->frame_size);
    tulle_pc2 *const result = memory_allocate(&heap, sizeof *result);
    made->heap = heap;
    if (!result || !made->path || !made->frame) {
        close(made->file);
        memory_release(&heap, made->path, made->path_size);
        memory_release(&heap, made->frame, made->frame_size);
        memory_release(&heap, result, sizeof *result);
        return file_fail(error, path, ENOMEM, "cannot be opened");
    }
    memcpy(made->path, path, made->path_size);
    *result = *made;
    if (info) *info = made->info;
    *cache = result;
    return TULLE_OK;
}

tulle_status tulle_pc2_open(const char *path, tulle_pc2 **cache, tulle_pc2_info *info,
                            tulle_error *error) {
    if (!path || !cache)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "path and cache may not be null");
    *cache = NULL;
    tulle_pc2 made = {.file = -1, .is_mdd = ends_in_mdd(path)};
    tulle_status const status = open_file(path, O_RDONLY, made.is_mdd ? CACHE_MDD : CACHE_PC2,
                                          &made.file, &made.info, error);
    return status ? status : make_cache(path, &made, cache, info, error);
}

tulle_status pc2_open(const char *path, tulle_pc2 **cache, tulle_pc2_info *info,
                      tulle_error *error) {
    *cache = NULL;
    tulle_pc2 made = {.file = -1};
    tulle_status const status = pc2_open_file(path, O_RDONLY, true, &made.file, &made.info, error);
    return status ? status : make_cache(path, &made, cache, info, error);
}

tulle_status tulle_pc2_read_frame(tulle_pc2 *cache, uint32_t frame, double *positions,
                                  tulle_error *error) {
    if (!cache || !positions || frame >= cache->info.frame_count)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, cache ? cache->path : NULL, 0, 0,
                            "there is no frame %u; the cache has %u", frame,
                            cache ? cache->info.frame_count : 0);
    uint64_t const offset = get_place(cache, frame);
    ssize_t const count = file_read_at(cache->file, cache->frame, cache->frame_size, offset);
    if (count < 0) return file_fail(error, cache->path, errno, "cannot be read");
    if ((size_t)count < cache->frame_size)
        return error_set_at(error, TULLE_ERROR_PARSE, cache->path, 0, 0,
                            "byte %llu: the file became shorter; frame %u is cut",
                            (unsigned long long)offset + (unsigned long long)count, frame);
    size_t const value_count = 3 * (size_t)cache->info.vertex_count;
    for (size_t i = 0; i < value_count; i++) {
        positions[i] = (double)load_float(cache, cache->frame + 4 * i);
        if (!isfinite(positions[i]))
            return error_set_at(error, TULLE_ERROR_PARSE, cache->path, 0, 0,
                                "byte %llu: coordinate %c of vertex %zu in frame %u is not finite",
                                (unsigned long long)offset + 4 * i, "xyz"[i % 3], i / 3, frame);
    }
    return TULLE_OK;
}

file_sum pc2_get_sum(const tulle_pc2 *cache, uint32_t frame) {
    return (file_sum){.begin = pc2_size(cache->info.vertex_count, frame),
                      .end = pc2_size(cache->info.vertex_count, frame + 1),
                      .hash = hash_bytes(FILE_SUM_SEED, cache->frame, cache->frame_size)};
}

tulle_status pc2_check_header(const char *path, uint32_t vertex_count, uint32_t frame_count,
                              bool is_exact, tulle_error *error) {
    int file = -1;
    tulle_pc2_info info;
    tulle_status const status = pc2_open_file(path, O_RDONLY, !is_exact, &file, &info, error);
    if (status) return status;
    unsigned char header[PC2_HEADER_SIZE] = {0}, expected[PC2_HEADER_SIZE];
    ssize_t const count = file_read_at(file, header, sizeof header, 0);
    int const code = errno;
    close(file);
    if (count < 0) return file_fail(error, path, code, "cannot be read");
    uint32_t const counted = (uint32_t)bytes_load(header + PC2_FRAME_COUNT_PLACE, 4);
    if (counted < frame_count || (is_exact && counted > frame_count))
        return error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                            "byte %d: the header counts %u frames, not %u", PC2_FRAME_COUNT_PLACE,
                            counted, frame_count);
    if (info.frame_count < frame_count)
        return error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0, "holds %u whole frames, not %u",
                            info.frame_count, frame_count);
    pc2_encode_header(expected, vertex_count, counted);
    if (count == PC2_HEADER_SIZE && memcmp(header, expected, sizeof header) == 0) return TULLE_OK;
    return error_set_at(error, TULLE_ERROR_PARSE, path, 0, 0,
                        "byte 0: the header does not fit %u vertices", vertex_count);
}

bool pc2_is_cut(const char *path, tulle_error *cut) {
    int file = -1;
    tulle_pc2_info info;
    if (pc2_open_file(path, O_RDONLY, false, &file, &info, cut))
        return cut->status == TULLE_ERROR_PARSE;
    close(file);
    return false;
}

void tulle_pc2_close(tulle_pc2 *cache) {
    if (!cache) return;
    memory heap = cache->heap;
    close(cache->file);
    memory_release(&heap, cache->path, cache->path_size);
    memory_release(&heap, cache->frame, cache->frame_size);
    memory_release(&heap, cache, sizeof *cache);
}
