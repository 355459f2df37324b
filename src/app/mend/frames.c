/* app/mend/frames.c - see frames.h. */
#include "app/mend/frames.h"

#include "app/cli/interrupt.h"
#include "base/error.h"
#include "base/timer.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

tulle_status mend_frames_open(mend_input *input, const mend_follow_options *options,
                              mend_frames *frames, tulle_error *error) {
    *frames = (mend_frames){.input = input, .options = options};
    frames->way = calloc(input->vertex_count, 3 * sizeof(double));
    frames->bodies = calloc(input->surface_count, sizeof *frames->bodies);
    if (!frames->way || !frames->bodies)
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for %zu vertices",
                         input->vertex_count);
    tulle_status const status = mend_even_open(input, &frames->even, error);
    return status == TULLE_OK
               ? mend_history_open(mend_get_cloth_count(input), &frames->history, error)
               : status;
}

void mend_frames_close(mend_frames *frames) {
    mend_history_close(&frames->history);
    mend_even_close(&frames->even);
    mend_follow_close(&frames->first);
    mend_follow_close(&frames->second);
    free(frames->way);
    free(frames->bodies);
    *frames = (mend_frames){0};
}

bool mend_frames_are_running(const mend_frames *frames) { return frames->even.count > 0; }

/* The cloth at `cloth` among the bodies at `bodies`, both in arrays of all vertices. */
static tulle_status judge(mend_frames *frames, const double *cloth, const double *bodies,
                          mend_pairs *pairs, tulle_error *error) {
    const mend_input *const input = frames->input;
    for (size_t i = 0; i < input->surface_count; i++) {
        const mend_surface *const surface = &input->surfaces[i];
        frames->bodies[i] =
            (tulle_check_body){{(i == 0 ? cloth : bodies) + 3 * (size_t)surface->vertex_begin,
                                surface->vertex_end - surface->vertex_begin,
                                input->local_triangles + 3 * (size_t)surface->triangle_begin,
                                surface->triangle_end - surface->triangle_begin},
                               i > 0};
    }
    tulle_check_result result;
    tulle_status const status = tulle_check_intersections(frames->bodies, input->surface_count,
                                                          frames->options->threads, &result, error);
    *pairs = (mend_pairs){0};
    for (size_t i = 0; i < result.pair_count && status == TULLE_OK; i++) {
        if (result.pairs[i].body_b == 0)
            pairs->own++;
        else
            pairs->bodies++;
    }
    tulle_check_result_destroy(&result);
    return status;
}

/* Names the file and the frame. */
static tulle_status name_frame(const mend_frames *frames, uint32_t frame, tulle_status status,
                               tulle_error *error) {
    if (status == TULLE_OK || status == TULLE_ERROR_OUT_OF_MEMORY ||
        status == TULLE_ERROR_INTERRUPTED || error->file[0])
        return status;
    char text[sizeof error->message];
    snprintf(text, sizeof text, "%s", error->message);
    return error_set_at(error, status, frames->input->surfaces[0].source.path, 0, 0, "frame %u: %s",
                        frame, text);
}

/* ---- the first pass ---- */

/* The first frame decides on which side of what the cloth is: rounding may not. Later frames follow
 * the one before. */
static tulle_status judge_first_rounding(mend_frames *frames, const double *given,
                                         tulle_error *error) {
    mend_input *const input = frames->input;
    double *const exact = frames->way; /* not needed yet */
    size_t const size = 3 * input->vertex_count * sizeof(double);
    memcpy(exact, given, size);
    mend_pairs pairs = {0};
    tulle_status status = mend_input_read_exact(input, 0, exact, error);
    if (status != TULLE_OK || memcmp(exact, given, size) == 0) return status;
    status = judge(frames, exact, exact, &pairs, error);
    if (status != TULLE_OK || pairs.own + pairs.bodies > 0) return status;
    return mend_follow_judge_rounding(&frames->first, exact, given, error);
}

static tulle_status follow_given(mend_frames *frames, tulle_error *error) {
    double const start = timer_now();
    mend_input *const input = frames->input;
    mend_follow *const follow = &frames->first;
    uint32_t const index = frames->even.count;
    double *const given = mend_even_get_next(&frames->even);
    mend_row *const row = &frames->rows[index % EVEN_FRAMES];
    *row = (mend_row){.frame = mend_input_get_number(input, index)};
    tulle_status status = mend_input_read(input, index, given, error);
    if (status == TULLE_OK) status = judge(frames, given, given, &row->before, error);
    if (status != TULLE_OK) return status;
    status = index == 0 ? mend_follow_open(input, frames->options, given, follow, error)
                        : mend_follow_step(follow, given, false, &row->outcome, error);
    if (status == TULLE_OK && index == 0) status = judge_first_rounding(frames, given, error);
    if (status != TULLE_OK) return name_frame(frames, row->frame, status, error);
    mend_even_add(&frames->even, follow->now);
    frames->is_given[index % EVEN_FRAMES] =
        memcmp(follow->now, given, 3 * input->vertex_count * sizeof(double)) == 0;
    row->seconds = timer_now() - start;
    return TULLE_OK;
}

/* ---- the second pass ---- */

static tulle_status follow_even(mend_frames *frames, mend_row *row, tulle_error *error) {
    double const start = timer_now();
    mend_follow *const follow = &frames->second;
    uint32_t const index = frames->done;
    size_t const slot = index % EVEN_FRAMES;
    const double *const given = mend_even_get_given(&frames->even, index);
    mend_outcome outcome = {0};
    *row = frames->rows[slot];
    bool const is_given = mend_even_make(&frames->even, index, frames->first.near, frames->way);
    frames->is_given[slot] = frames->is_given[slot] && is_given;
    bool const is_clear = index > 0 && frames->is_given[slot] &&
                          frames->is_given[(index - 1) % EVEN_FRAMES] && !row->outcome.crosses;
    tulle_status status =
        index == 0 ? mend_follow_open(frames->input, frames->options, frames->way, follow, error)
                   : mend_follow_step(follow, frames->way, is_clear, &outcome, error);
    if (status != TULLE_OK) return name_frame(frames, row->frame, status, error);
    outcome.moves += row->outcome.moves;
    row->outcome = outcome;
    frames->done++;
    mend_history_add(&frames->history, given, follow->now, row);
    row->after = row->before;
    if (row->away_count > 0 || (frames->judges_met && outcome.lag > 0.0))
        status = judge(frames, follow->now, frames->judges_met ? follow->now : given, &row->after,
                       error);
    row->seconds += timer_now() - start;
    return status;
}

tulle_status mend_frames_make(mend_frames *frames, mend_row *row, tulle_error *error) {
    uint32_t const count = frames->input->frame_count;
    while (frames->even.count < count && frames->even.count <= frames->done + EVEN_REACH) {
        if (interrupt_is_pending()) return error_set(error, TULLE_ERROR_INTERRUPTED, "interrupted");
        tulle_status const status = follow_given(frames, error);
        if (status != TULLE_OK) return status;
    }
    if (interrupt_is_pending()) return error_set(error, TULLE_ERROR_INTERRUPTED, "interrupted");
    return follow_even(frames, row, error);
}
