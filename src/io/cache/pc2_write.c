/* io/cache/pc2_write.c - writes PC2 point caches frame by frame. The file is opened for each frame
 * alone, so a run may have more caches than a process may have open files. Data go in first, then
 * the count in the header: at any moment the file is a whole cache of that many frames, perhaps
 * with bytes behind them that the next frame overwrites. */
#define _POSIX_C_SOURCE 200809L
#include "io/cache/pc2.h"

#include "base/error.h"
#include "base/hash.h"
#include "base/memory.h"
#include "io/bytes.h"
#include "io/cache/pc2_format.h"
#include "io/file_data.h"
#include "io/output_file.h"
#include "io/unflushed.h"

#include "tulle_io/cache.h"
#include "tulle_io/mesh_files.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <string.h>
#include <unistd.h>

struct tulle_pc2_writer {
    memory heap;
    char *path;
    size_t path_size;
    unsigned char *frame;
    size_t frame_size;
    uint32_t vertex_count, frame_count;
    int open_flags;
    int defers_flush;
};

void pc2_encode_header(unsigned char header[PC2_HEADER_SIZE], uint32_t vertex_count,
                       uint32_t frame_count) {
    memcpy(header, "POINTCACHE2", 12);
    bytes_store(header + 12, 4, 1);
    bytes_store(header + 16, 4, vertex_count);
    bytes_store_float(header + 20, 0.0f);
    bytes_store_float(header + 24, 1.0f);
    bytes_store(header + PC2_FRAME_COUNT_PLACE, 4, frame_count);
}

static tulle_status write_empty(const char *path, uint32_t vertex_count, int is_of_run,
                                tulle_error *error) {
    unsigned char header[PC2_HEADER_SIZE];
    pc2_encode_header(header, vertex_count, 0);
    output_file *output = NULL;
    tulle_status const status =
        is_of_run ? output_open_unflushed(path, &output, error) : output_open(path, &output, error);
    if (status) return status;
    output_write(output, header, sizeof header);
    return output_commit(output, error);
}

/* 0 or an errno. */
static int store_frame_count(int file, uint32_t frame_count) {
    unsigned char bytes[4];
    bytes_store(bytes, sizeof bytes, frame_count);
    return file_write_at(file, bytes, sizeof bytes, PC2_FRAME_COUNT_PLACE);
}

static tulle_status check_same_points(const tulle_pc2_writer *writer, const tulle_pc2_info *info,
                                      uint32_t frame_count, tulle_error *error) {
    if (info->vertex_count != writer->vertex_count)
        return error_set_at(error, TULLE_ERROR_PARSE, writer->path, 0, 0,
                            "holds %u vertices, not %u; it belongs to another mesh",
                            info->vertex_count, writer->vertex_count);
    if (info->frame_count < frame_count)
        return error_set_at(error, TULLE_ERROR_PARSE, writer->path, 0, 0,
                            "holds %u frames, but %u are to be kept", info->frame_count,
                            frame_count);
    return TULLE_OK;
}

tulle_status pc2_writer_truncate(tulle_pc2_writer *writer, uint32_t frame_count,
                                 tulle_error *error) {
    int file = -1;
    tulle_pc2_info info;
    tulle_status status =
        pc2_open_file(writer->path, writer->open_flags, true, &file, &info, error);
    if (status) return status;
    status = check_same_points(writer, &info, frame_count, error);
    if (!status) {
        int code = store_frame_count(file, frame_count);
        off_t const size = (off_t)pc2_size(writer->vertex_count, frame_count);
        if (!code && ftruncate(file, size) != 0) code = errno;
        if (!code && fsync(file) != 0) code = errno;
        if (code) status = file_fail(error, writer->path, code, "cannot be cut back");
    }
    close(file);
    if (!status) writer->frame_count = frame_count;
    return status;
}

static void destroy(tulle_pc2_writer *writer) {
    memory heap = writer->heap;
    memory_release(&heap, writer->path, writer->path_size);
    memory_release(&heap, writer->frame, writer->frame_size);
    memory_release(&heap, writer, sizeof *writer);
}

static tulle_pc2_writer *make_writer(const char *path, uint32_t vertex_count) {
    memory heap = memory_default();
    tulle_pc2_writer *const writer = memory_allocate_zeroed(&heap, 1, sizeof *writer);
    if (!writer) return NULL;
    writer->path_size = strlen(path) + 1;
    writer->path = memory_allocate(&heap, writer->path_size);
    writer->frame_size = (size_t)vertex_count * 12;
    writer->frame = memory_allocate(&heap, writer->frame_size);
    writer->vertex_count = vertex_count;
    writer->heap = heap;
    if (!writer->path || !writer->frame) {
        destroy(writer);
        return NULL;
    }
    memcpy(writer->path, path, writer->path_size);
    return writer;
}

static tulle_status open_writer(const char *path, uint32_t vertex_count,
                                uint32_t resume_frame_count, int is_of_run,
                                tulle_pc2_writer **result, tulle_error *error) {
    if (!path || !result || vertex_count < 1 || vertex_count > PC2_COUNT_LIMIT)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "a point cache needs a path and 1 to %u vertices, not %u", PC2_COUNT_LIMIT,
                         vertex_count);
    *result = NULL;
    tulle_pc2_writer *const writer = make_writer(path, vertex_count);
    if (!writer) return file_fail(error, path, ENOMEM, "cannot be written");
    writer->open_flags = O_RDWR | O_CLOEXEC | (is_of_run ? O_NOFOLLOW : 0);
    tulle_status const status = resume_frame_count > 0
                                    ? pc2_writer_truncate(writer, resume_frame_count, error)
                                    : write_empty(path, vertex_count, is_of_run, error);
    if (status)
        destroy(writer);
    else
        *result = writer;
    return status;
}

tulle_status tulle_pc2_writer_open(const char *path, uint32_t vertex_count,
                                   uint32_t resume_frame_count, tulle_pc2_writer **writer,
                                   tulle_error *error) {
    return open_writer(path, vertex_count, resume_frame_count, 0, writer, error);
}

tulle_status pc2_writer_open_unflushed(const char *path, uint32_t vertex_count,
                                       uint32_t resume_frame_count, tulle_pc2_writer **writer,
                                       tulle_error *error) {
    return open_writer(path, vertex_count, resume_frame_count, 1, writer, error);
}

void pc2_writer_release(tulle_pc2_writer *writer) {
    if (writer) destroy(writer);
}

/* Rounds to float, to nearest. */
static tulle_status round_frame(tulle_pc2_writer *writer, const double *positions,
                                tulle_error *error) {
    size_t const value_count = 3 * (size_t)writer->vertex_count;
    for (size_t i = 0; i < value_count; i++) {
        float const value = (float)positions[i];
        if (!isfinite(value))
            return error_set_at(
                error, TULLE_ERROR_INVALID_ARGUMENT, writer->path, 0, 0,
                "coordinate %c of vertex %zu is not a finite number that float can hold",
                "xyz"[i % 3], i / 3);
        bytes_store_float(writer->frame + 4 * i, value);
    }
    return TULLE_OK;
}

/* Data, flush, count, flush; 0 or an errno. */
static int write_frame(const tulle_pc2_writer *writer, int file, int is_flushed) {
    uint64_t const offset = pc2_size(writer->vertex_count, writer->frame_count);
    int code = file_write_at(file, writer->frame, writer->frame_size, offset);
    if (!code && is_flushed && fdatasync(file) != 0) code = errno;
    if (!code) code = store_frame_count(file, writer->frame_count + 1);
    if (!code && is_flushed && fdatasync(file) != 0) code = errno;
    if (code) {
        /* Back to the frames before; both are best efforts on a disk that fails. */
        if (store_frame_count(file, writer->frame_count) != 0 ||
            ftruncate(file, (off_t)offset) != 0)
            return code;
    }
    return code;
}

static tulle_status append(tulle_pc2_writer *writer, const double *positions, int is_flushed,
                           tulle_error *error) {
    if (!writer || !positions)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "writer and positions may not be null");
    if (writer->frame_count == PC2_COUNT_LIMIT)
        return error_set_at(error, TULLE_ERROR_LIMIT, writer->path, 0, 0,
                            "holds as many frames as its format can count");
    tulle_status const status = round_frame(writer, positions, error);
    if (status) return status;
    int const file = open(writer->path, writer->open_flags);
    int code = file < 0 ? errno : write_frame(writer, file, is_flushed);
    if (file >= 0 && close(file) != 0 && !code) code = errno;
    if (code) return file_fail(error, writer->path, code, "cannot be written");
    writer->frame_count++;
    return TULLE_OK;
}

tulle_status tulle_pc2_writer_append(tulle_pc2_writer *writer, const double *positions,
                                     tulle_error *error) {
    return append(writer, positions, !writer || !writer->defers_flush, error);
}

void tulle_pc2_writer_defer_flush(tulle_pc2_writer *writer) {
    if (writer) writer->defers_flush = 1;
}

tulle_status pc2_writer_append_unflushed(tulle_pc2_writer *writer, const double *positions,
                                         file_sum *sum, tulle_error *error) {
    tulle_status const status = append(writer, positions, 0, error);
    if (status) return status;
    *sum = (file_sum){.begin = pc2_size(writer->vertex_count, writer->frame_count - 1),
                      .end = pc2_size(writer->vertex_count, writer->frame_count),
                      .hash = hash_bytes(FILE_SUM_SEED, writer->frame, writer->frame_size)};
    return TULLE_OK;
}

tulle_status pc2_writer_sync(tulle_pc2_writer *writer, tulle_error *error) {
    int const file = open(writer->path, writer->open_flags);
    int code = file < 0 ? errno : 0;
    if (!code && fsync(file) != 0) code = errno;
    if (file >= 0 && close(file) != 0 && !code) code = errno;
    return code ? file_fail(error, writer->path, code, "cannot be written") : TULLE_OK;
}

tulle_status tulle_pc2_writer_close(tulle_pc2_writer *writer, tulle_error *error) {
    if (!writer) return TULLE_OK;
    tulle_status const status = pc2_writer_sync(writer, error);
    destroy(writer);
    return status;
}
