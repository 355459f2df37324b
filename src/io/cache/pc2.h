/* io/cache/pc2.h - the PC2 writer without a flush a frame, for runs with many caches that flush all
 * of them at once before a checkpoint. */
#ifndef TULLE_IO_CACHE_PC2_H
#define TULLE_IO_CACHE_PC2_H

#include "tulle_io/cache.h"

#include "io/output_file.h"

/* As tulle_pc2_writer_append, but nothing is flushed to disk: a killed process loses nothing, a
 * power failure may lose frames since the last pc2_writer_sync. *sum: what was appended. */
tulle_status pc2_writer_append_unflushed(tulle_pc2_writer *writer, const double *positions,
                                         file_sum *sum, tulle_error *error);
/* As tulle_pc2_writer_open; a new file is not flushed either, and links are not followed. */
tulle_status pc2_writer_open_unflushed(const char *path, uint32_t vertex_count,
                                       uint32_t resume_frame_count, tulle_pc2_writer **writer,
                                       tulle_error *error);
/* Releases the writer without flushing; null is fine. */
void pc2_writer_release(tulle_pc2_writer *writer);
tulle_status pc2_writer_sync(tulle_pc2_writer *writer, tulle_error *error);
/* As tulle_pc2_open, but a power failure may have kept the count of a frame and lost its bytes;
 * such frames are not counted. */
tulle_status pc2_open(const char *path, tulle_pc2 **cache, tulle_pc2_info *info,
                      tulle_error *error);
/* What tulle_pc2_read_frame read last, which was `frame`. */
file_sum pc2_get_sum(const tulle_pc2 *cache, uint32_t frame);
/* Checks all bytes of the header: it should be that of a writer for so many vertices that has
 * appended frame_count frames, or more unless is_exact; frames behind them may be cut off. Errors:
 * TULLE_ERROR_IO, TULLE_ERROR_PARSE.
 */
tulle_status pc2_check_header(const char *path, uint32_t vertex_count, uint32_t frame_count,
                              bool is_exact, tulle_error *error);
/* Whether the header counts frames that the file does not hold, in a file that pc2_check_header has
 * found sound but for that; `cut`, not null, says so. False too where the file cannot be read. */
bool pc2_is_cut(const char *path, tulle_error *cut);
/* Drops all frames from frame_count on. */
tulle_status pc2_writer_truncate(tulle_pc2_writer *writer, uint32_t frame_count,
                                 tulle_error *error);

#endif
