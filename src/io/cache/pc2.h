/* io/cache/pc2.h - the PC2 writer without a flush a frame, for runs with many caches that flush all
 * of them at once before a checkpoint. */
#ifndef TULLE_IO_CACHE_PC2_H
#define TULLE_IO_CACHE_PC2_H

#include "tulle_io/cache.h"

/* As tulle_pc2_writer_append, but nothing is flushed to disk: a killed process loses nothing, a
 * power failure may lose frames since the last pc2_writer_sync. */
tulle_status pc2_writer_append_unflushed(tulle_pc2_writer *writer, const double *positions,
                                         tulle_error *error);
/* As tulle_pc2_writer_open; a new file is not flushed either, and links are not followed. */
tulle_status pc2_writer_open_unflushed(const char *path, uint32_t vertex_count,
                                       uint32_t resume_frame_count, tulle_pc2_writer **writer,
                                       tulle_error *error);
/* Releases the writer without flushing; null is fine. */
void pc2_writer_release(tulle_pc2_writer *writer);
tulle_status pc2_writer_sync(tulle_pc2_writer *writer, tulle_error *error);
/* Drops all frames from frame_count on. */
tulle_status pc2_writer_truncate(tulle_pc2_writer *writer, uint32_t frame_count,
                                 tulle_error *error);

#endif
