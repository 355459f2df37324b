/* app/mend/output.c - see output.h. */
#define _XOPEN_SOURCE 700
#include "app/mend/output.h"

#include "app/cli/interrupt.h"
#include "base/error.h"
#include "io/file_data.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static size_t get_frame_size(const mend_output *output) {
    return 3 * mend_get_cloth_count(output->input) * sizeof(double);
}

static frame_range get_frames(const mend_output *output) {
    return output->input->surfaces[0].source.frames;
}

tulle_status mend_output_name(const mend_output_options *options, mend_output *output,
                              tulle_error *error) {
    *output = (mend_output){.store = -1, .is_double = options->is_double};
    tulle_status const status = convert_target_open(options->path, NULL, &output->target, error);
    if (status != TULLE_OK) return status;
    if (options->is_double && output->target.format != CONVERT_NPZ)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, options->path, 0, 0,
                            "--double is for .npz");
    if (options->fps && !convert_is_animation(output->target.format))
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, options->path, 0, 0,
                            "--fps is for formats that have times: .mdd, .glb, .gltf, .usda and "
                            ".npz");
    return TULLE_OK;
}

bool mend_output_is_float(const mend_output *output) {
    return convert_target_is_float(&output->target) && !output->is_double;
}

/* An open file beside OUT that has no name any more, so that nothing is left whatever happens. */
static tulle_status make_store(mend_output *output, tulle_error *error) {
    char path[NUMBERED_PATH_SIZE];
    const char *const target = output->target.path, *const slash = strrchr(target, '/');
    int const folder = slash ? (int)(slash - target) + 1 : 0;
    int const length = snprintf(path, sizeof path, "%.*s.tulle-mend.XXXXXX", folder, target);
    if (length < 0 || (size_t)length >= sizeof path)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, target, 0, 0,
                            "the path is too long");
    output->store = mkstemp(path);
    if (output->store < 0) return file_fail(error, path, errno, "cannot be written");
    unlink(path);
    return TULLE_OK;
}

/* ---- frames that are kept ---- */

tulle_status mend_output_keep(mend_output *output, uint32_t index, const double *positions,
                              tulle_error *error) {
    size_t const size = get_frame_size(output);
    for (size_t done = 0; done < size;) {
        ssize_t const count = pwrite(output->store, (const char *)positions + done, size - done,
                                     (off_t)(index * (uint64_t)size + done));
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0)
            return file_fail(error, output->target.path, count < 0 ? errno : EIO,
                             "the frames cannot be kept beside it");
        done += (size_t)count;
    }
    return TULLE_OK;
}

tulle_status mend_output_read(const mend_output *output, uint32_t index, double *positions,
                              tulle_error *error) {
    size_t const size = get_frame_size(output);
    ssize_t const count = file_read_at(output->store, positions, size, index * (uint64_t)size);
    return count == (ssize_t)size ? TULLE_OK
                                  : file_fail(error, output->target.path, count < 0 ? errno : EIO,
                                              "the frames that were kept cannot be read");
}

/* ---- OUT ---- */

static tulle_status read_frame(void *context, uint32_t frame, double *positions,
                               tulle_error *error) {
    const mend_output *const output = context;
    frame_range const frames = get_frames(output);
    tulle_status const status =
        mend_output_read(output, (frame - frames.first) / frames.step, positions, error);
    if (status == TULLE_OK)
        axes_apply(&output->change, positions, mend_get_cloth_count(output->input));
    return status;
}

static tulle_status open_scene(mend_output *output, const char *fps, tulle_error *error) {
    const mend_surface *const cloth = &output->input->surfaces[0];
    scene_options const options = {.fps = fps,
                                   .up = output->change.to.up,
                                   .meters_per_unit = 1.0,
                                   .is_double = output->is_double,
                                   .change = &output->change};
    tulle_status const status =
        convert_scene_open(&output->scene, &output->input->surfaces[0].source, &output->target,
                           &options, get_frames(output), error);
    if (status != TULLE_OK) return status;
    tulle_mesh_view const mesh = {NULL, cloth->vertex_end, output->input->local_triangles,
                                  cloth->triangle_end};
    convert_scene_set_surface(&output->scene, mesh, cloth->source.described.corner_uvs, read_frame,
                              output);
    return TULLE_OK;
}

tulle_status mend_output_open(const mend_output_options *options, mend_input *input,
                              mend_output *output, tulle_error *error) {
    output->input = input;
    convert_format const format = output->target.format;
    bool const is_y_up = format == CONVERT_GLB || format == CONVERT_GLTF;
    output->change =
        axes_change_make((axes_frame){"z", "m"}, (axes_frame){is_y_up ? "y" : "z", "m"});
    tulle_status status = TULLE_OK;
    for (size_t i = 0; i < input->surface_count && status == TULLE_OK; i++)
        status = convert_target_check(&output->target, &input->surfaces[i].source,
                                      get_frames(output), error);
    if (status == TULLE_OK && convert_is_animation(format))
        status = open_scene(output, options->fps, error);
    if (status != TULLE_OK) return status;
    output->positions = malloc(get_frame_size(output));
    if (!output->positions) return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory");
    return make_store(output, error);
}

static tulle_status write_frames(mend_output *output, tulle_error *error) {
    const mend_surface *const cloth = &output->input->surfaces[0];
    frame_range const frames = get_frames(output);
    bool const is_animation = convert_is_animation(output->target.format);
    tulle_status status = TULLE_OK;
    for (uint32_t i = 0; i < output->input->frame_count && status == TULLE_OK; i++) {
        uint32_t const frame = frame_range_get(frames, i);
        if (interrupt_is_pending()) return error_set(error, TULLE_ERROR_INTERRUPTED, "interrupted");
        if (is_animation) {
            status = convert_scene_write(&output->scene, (frame_range){frame, frame, 1}, error);
            continue;
        }
        status = read_frame(output, frame, output->positions, error);
        tulle_mesh_view const mesh = {output->positions, cloth->vertex_end,
                                      output->input->local_triangles, cloth->triangle_end};
        if (status == TULLE_OK) status = convert_target_write(&output->target, frame, mesh, error);
    }
    return status == TULLE_OK
               ? convert_target_finish(&output->target, &cloth->source, frames, error)
               : status;
}

tulle_status mend_output_write(mend_output *output, tulle_error *error) {
    if (convert_is_animation(output->target.format) && !output->target.is_numbered)
        return convert_scene_write(&output->scene, get_frames(output), error);
    return write_frames(output, error);
}

void mend_output_close(mend_output *output) {
    convert_scene_close(&output->scene);
    convert_target_close(&output->target);
    free(output->positions);
    if (output->store >= 0) close(output->store);
    *output = (mend_output){.store = -1};
}
