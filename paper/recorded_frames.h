/* recorded_frames.h - consecutive recorded frames of a run as the two states between which the
 * detector looks. Functions end the program with a message when something goes wrong. */
#ifndef PAPER_RECORDED_FRAMES_H
#define PAPER_RECORDED_FRAMES_H

#include <tulle/tulle.h>
#include <tulle_io/tulle_io.h>

#include <stdbool.h>

typedef struct recorded_frames {
    tulle_run_reader *reader;
    const tulle_run_info *info;
    size_t *bodies; /* in the run, of each surface */
    tulle_detect_surface *surfaces;
    size_t surface_count, vertex_count, triangle_count;
    uint32_t *triangles;
    double *rest, *start, *end; /* [m] 3 * vertex_count */
    uint32_t frame;             /* at `end`; 0: none is read yet */
} recorded_frames;

/* Ends the program with a message unless the status is fine. */
void require(tulle_status status, const tulle_error *error);
/* malloc that ends the program without memory. */
void *require_memory(size_t bytes);

/* Cloths, and with obstacles also those that are there from the first frame to the last. */
void recorded_frames_open(const char *directory, bool has_obstacles, recorded_frames *frames);
/* start: the frame before `frame`; end: `frame`, from 1 on. */
void recorded_frames_read(recorded_frames *frames, uint32_t frame);
/* A def of the frames: `distance` [m] is the separation. */
tulle_detect_def recorded_frames_get_def(const recorded_frames *frames, double distance,
                                         int threads);
void recorded_frames_close(recorded_frames *frames);

/* The paper's rules for patches, which prove nothing, at an angle [degrees]; or ours. */
tulle_detect_def use_paper_rules(tulle_detect_def def, double angle);
tulle_detect_def use_proof(tulle_detect_def def, double angle);

#endif
