/* io/run/run_transforms.h - bodies.csv of a run: where its rigid bodies are, a line for each body
 * and frame. Frames go in before their line of frames.csv; every frame has as many lines as the run
 * has rigid bodies, so whole lines count whole frames. */
#ifndef TULLE_IO_RUN_RUN_TRANSFORMS_H
#define TULLE_IO_RUN_RUN_TRANSFORMS_H

#include "io/run/run_log.h"

/* Rigid bodies of the run; without any it has no such file, and the others do nothing. */
size_t transforms_count_bodies(const run_record *record);

tulle_status transforms_create(run_log *log, const run_record *record, const char *directory,
                               tulle_error *error);
/* transforms: one for each rigid body, in the order of the record's bodies. On failure the file is
 * as before. */
tulle_status transforms_append(run_log *log, const run_record *record, uint32_t frame,
                               const tulle_transform *transforms, tulle_error *error);

#endif
