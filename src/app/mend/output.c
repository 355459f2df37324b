/* app/mend/output.c - see output.h. */
#include "app/mend/output.h"

#include "app/cli/interrupt.h"
#include "base/error.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const mend_surface *get_surface(const mend_output *output) {
    return &output->input->surfaces[output->surface];
}

static size_t count_vertices(const mend_output *output) {
    return get_surface(output)->vertex_end - get_surface(output)->vertex_begin;
}

tulle_status mend_output_name(const mend_output_options *options, mend_output *output,
                              tulle_error *error) {
    *output = (mend_output){.is_double = options->is_double};
    tulle_status const status = convert_target_open(options->path, NULL, &output->target, error);
    if (status != TULLE_OK) return status;
    if (options->is_double && output->target.format != CONVERT_NPZ)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, options->path, 0, 0,
                            "--double is for .npz");
    if (options->fps && !convert_is_animation(output->target.format))
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, options->path, 0, 0,
                            "--fps is for formats that have times: .mdd, .glb, .gltf, .usda, .npz "
                            "and .abc");
    return TULLE_OK;
}

bool mend_output_is_float(const mend_output *output) {
    return convert_target_is_float(&output->target) && !output->is_double;
}

/* ---- frames ---- */

static uint32_t get_index(const mend_output *output, uint32_t frame) {
    frame_range const frames = get_surface(output)->source.frames;
    return (frame - frames.first) / frames.step;
}

static tulle_status read_kept(const mend_output *output, uint32_t index, double *positions,
                              tulle_error *error) {
    return mend_store_read(output->store, index, get_surface(output)->vertex_begin,
                           count_vertices(output), positions, error);
}

static tulle_status read_frame(void *context, uint32_t frame, double *positions,
                               tulle_error *error) {
    const mend_output *const output = context;
    tulle_status const status = read_kept(output, get_index(output, frame), positions, error);
    if (status == TULLE_OK) axes_apply(&output->change, positions, count_vertices(output));
    return status;
}

tulle_status mend_output_measure(mend_output *output, uint32_t index, tulle_error *error) {
    double *const given = output->given;
    tulle_status status =
        mend_input_read_surface(output->input, output->surface, index, given, error);
    if (status == TULLE_OK) status = read_kept(output, index, output->positions, error);
    for (size_t v = 0; v < count_vertices(output) && status == TULLE_OK; v++) {
        double sum = 0.0;
        for (size_t k = 3 * v; k < 3 * v + 3; k++)
            sum += (output->positions[k] - given[k]) * (output->positions[k] - given[k]);
        given[v] = sqrt(sum);
    }
    return status;
}

static tulle_status read_departures(void *context, uint32_t frame, double *values,
                                    tulle_error *error) {
    mend_output *const output = context;
    tulle_status const status = mend_output_measure(output, get_index(output, frame), error);
    if (status == TULLE_OK) memcpy(values, output->given, count_vertices(output) * sizeof *values);
    return status;
}

/* ---- what is written ---- */

static tulle_status open_scene(mend_output *output, const char *fps, tulle_error *error) {
    mend_surface *const surface = &output->input->surfaces[output->surface];
    scene_options const options = {.fps = fps,
                                   .up = output->change.to.up,
                                   .meters_per_unit = axes_get_meters(output->change.to.unit),
                                   .is_double = output->is_double,
                                   .change = &output->change};
    tulle_status const status = convert_scene_open(
        &output->scene, &surface->source, &output->target, &options, surface->source.frames, error);
    if (status != TULLE_OK) return status;
    tulle_mesh_view const mesh = {NULL, count_vertices(output),
                                  output->input->local_triangles +
                                      3 * (size_t)surface->triangle_begin,
                                  surface->triangle_end - surface->triangle_begin};
    convert_scene_set_surface(&output->scene, mesh, surface->source.described.corner_uvs,
                              read_frame, output);
    if (output->has_departures && output->target.format == CONVERT_NPZ)
        convert_scene_add_array(&output->scene, "departure", read_departures);
    return TULLE_OK;
}

tulle_status mend_output_open(const mend_output_options *options, mend_input *input, size_t surface,
                              mend_output *output, tulle_error *error) {
    output->input = input;
    output->surface = surface;
    convert_format const format = output->target.format;
    bool const is_y_up = format == CONVERT_GLB || format == CONVERT_GLTF || format == CONVERT_ABC;
    const char *const up = options->up ? options->up : is_y_up ? "y" : "z";
    /* a body goes back into the unit that it came in */
    const char *const unit = surface == 0 ? input->unit : input->surfaces[surface].change.from.unit;
    output->change = axes_change_make((axes_frame){"z", input->unit}, (axes_frame){up, unit});
    frame_range const frames = get_surface(output)->source.frames;
    if (convert_target_is_one_mesh(&output->target) && frame_range_get_count(frames) > 1)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, output->target.path, 0, 0,
                            "is one mesh, but there are %u frames; name numbered files, as "
                            "frame_%%04d.obj, or another format",
                            frame_range_get_count(frames));
    tulle_status status = TULLE_OK;
    for (size_t i = 0; i < input->surface_count && status == TULLE_OK; i++)
        status = convert_target_check(&output->target, &input->surfaces[i].source, frames, error);
    if (status == TULLE_OK && convert_is_animation(format))
        status = open_scene(output, options->fps, error);
    if (status != TULLE_OK) return status;
    output->positions = calloc(count_vertices(output), 3 * sizeof(double));
    output->given = calloc(count_vertices(output), 3 * sizeof(double));
    return output->positions && output->given
               ? TULLE_OK
               : error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory");
}

static tulle_status write_frames(mend_output *output, tulle_error *error) {
    const mend_surface *const surface = get_surface(output);
    frame_range const frames = surface->source.frames;
    tulle_mesh_view const mesh = {output->positions, count_vertices(output),
                                  output->input->local_triangles +
                                      3 * (size_t)surface->triangle_begin,
                                  surface->triangle_end - surface->triangle_begin};
    tulle_status status = TULLE_OK;
    for (uint32_t i = 0; i < frame_range_get_count(frames) && status == TULLE_OK; i++) {
        uint32_t const frame = frame_range_get(frames, i);
        if (interrupt_is_pending()) return error_set(error, TULLE_ERROR_INTERRUPTED, "interrupted");
        if (convert_is_animation(output->target.format)) {
            status = convert_scene_write(&output->scene, (frame_range){frame, frame, 1}, error);
            continue;
        }
        status = read_frame(output, frame, output->positions, error);
        if (status == TULLE_OK) status = convert_target_write(&output->target, frame, mesh, error);
    }
    return status == TULLE_OK
               ? convert_target_finish(&output->target, &surface->source, frames, error)
               : status;
}

tulle_status mend_output_write(mend_output *output, tulle_error *error) {
    if (convert_is_animation(output->target.format) && !output->target.is_numbered)
        return convert_scene_write(&output->scene, get_surface(output)->source.frames, error);
    return write_frames(output, error);
}

void mend_output_close(mend_output *output) {
    convert_scene_close(&output->scene);
    convert_target_close(&output->target);
    free(output->positions);
    free(output->given);
    *output = (mend_output){0};
}
