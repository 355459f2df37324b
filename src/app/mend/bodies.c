/* app/mend/bodies.c - see bodies.h. */
#define _XOPEN_SOURCE 700
#include "app/mend/bodies.h"

#include "app/cli/interrupt.h"
#include "base/error.h"
#include "io/file_data.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { BLOCK_SIZE = 8192 /* [bytes] copied at once, on the stack */ };

/* ---- names ---- */

static const char *get_last_part(const char *path) {
    const char *const slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

static tulle_status join_path(const char *folder, const char *name, const char *ending,
                              char path[NUMBERED_PATH_SIZE], tulle_error *error) {
    int const length = snprintf(path, NUMBERED_PATH_SIZE, "%s/%s%s", folder, name, ending);
    if (length > 0 && length < NUMBERED_PATH_SIZE) return TULLE_OK;
    return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, folder, 0, 0, "the path is too long");
}

/* A run is no file: its body becomes an archive, which is exact. */
static tulle_status make_path(const mend_bodies *bodies, size_t surface,
                              char path[NUMBERED_PATH_SIZE], tulle_error *error) {
    const convert_source *const source = &bodies->input->surfaces[surface].source;
    bool const is_run = source->kind == SOURCE_RUN;
    return join_path(bodies->folder,
                     get_last_part(is_run ? convert_source_get_name(source) : source->path),
                     is_run ? ".npz" : "", path, error);
}

/* Of a file of numbered meshes: where it is, and where it goes. */
static tulle_status make_numbered_paths(const mend_bodies *bodies, size_t surface, uint32_t index,
                                        char paths[2][NUMBERED_PATH_SIZE], tulle_error *error) {
    const convert_source *const source = &bodies->input->surfaces[surface].source;
    if (!numbered_files_get_path(&source->files, frame_range_get(source->frames, index), paths[0]))
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, source->path, 0, 0,
                            "the path is too long");
    return join_path(bodies->folder, get_last_part(paths[0]), "", paths[1], error);
}

static tulle_status add_names(mend_bodies *bodies, size_t surface, mend_names *names,
                              tulle_error *error) {
    static const char *const role = "a body";
    const mend_input *const input = bodies->input;
    const convert_source *const source = &input->surfaces[surface].source;
    if (source->kind != SOURCE_FILES) {
        tulle_status const status = make_path(bodies, surface, bodies->paths[surface], error);
        return status == TULLE_OK
                   ? mend_names_add(names, input, bodies->paths[surface], role, error)
                   : status;
    }
    tulle_status status = TULLE_OK;
    for (uint32_t i = 0; i < frame_range_get_count(source->frames) && status == TULLE_OK; i++) {
        char paths[2][NUMBERED_PATH_SIZE];
        status = make_numbered_paths(bodies, surface, i, paths, error);
        if (status == TULLE_OK) status = mend_names_add(names, input, paths[1], role, error);
    }
    return status;
}

/* Prepares to write the body as an animation in the format that it came in. */
static tulle_status open_output(mend_bodies *bodies, size_t number, tulle_error *error) {
    mend_output *const output = &bodies->outputs[number];
    mend_output_options const options = {.path = bodies->paths[number],
                                         .up = bodies->input->surfaces[number].change.from.up,
                                         .is_double = convert_get_format(bodies->paths[number]) ==
                                                      CONVERT_NPZ};
    tulle_status const status = mend_output_name(&options, output, error);
    return status == TULLE_OK ? mend_output_open(&options, bodies->input, number, output, error)
                              : status;
}

/* Whether the body's file is copied, whatever happens: what has one frame is never held. */
static bool is_one_file(const mend_surface *surface) {
    return surface->source.kind == SOURCE_MESH ||
           (surface->is_still && surface->source.kind == SOURCE_CACHE);
}

tulle_status mend_bodies_open(mend_input *input, const char *folder, mend_names *names,
                              mend_bodies *bodies, tulle_error *error) {
    *bodies = (mend_bodies){.input = input, .folder = folder};
    if (input->surface_count == 1)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "--bodies-out writes bodies, but no --body is given");
    bodies->paths = calloc(input->surface_count, sizeof *bodies->paths);
    bodies->was_held = calloc(input->surface_count, sizeof *bodies->was_held);
    bodies->outputs = calloc(input->surface_count, sizeof *bodies->outputs);
    if (!bodies->paths || !bodies->was_held || !bodies->outputs)
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for the bodies");
    bodies->made_folder = mkdir(folder, 0777) == 0;
    if (!bodies->made_folder && errno != EEXIST)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, folder, 0, 0, "cannot be made: %s",
                            strerror(errno));
    tulle_status status = TULLE_OK;
    for (size_t i = 1; i < input->surface_count && status == TULLE_OK; i++)
        status = add_names(bodies, i, names, error);
    for (size_t i = 1; i < input->surface_count && status == TULLE_OK; i++)
        if (input->surfaces[i].source.kind != SOURCE_FILES && !is_one_file(&input->surfaces[i]))
            status = open_output(bodies, i, error);
    return status;
}

void mend_bodies_close(mend_bodies *bodies) {
    for (size_t i = 0; bodies->outputs && i < bodies->input->surface_count; i++)
        mend_output_close(&bodies->outputs[i]);
    if (bodies->made_folder) rmdir(bodies->folder); /* where it is not empty, it stays */
    free(bodies->paths);
    free(bodies->was_held);
    free(bodies->outputs);
    *bodies = (mend_bodies){0};
}

void mend_bodies_add(mend_bodies *bodies, const double *given, const double *met) {
    for (size_t i = 1; i < bodies->input->surface_count; i++) {
        const mend_surface *const surface = &bodies->input->surfaces[i];
        size_t const begin = 3 * (size_t)surface->vertex_begin;
        size_t const size = (3 * (size_t)surface->vertex_end - begin) * sizeof(double);
        if (memcmp(given + begin, met + begin, size) != 0) bodies->was_held[i] = true;
    }
}

/* ---- files ---- */

static tulle_status copy_bytes(const char *from, FILE *read, const char *to, FILE *written,
                               tulle_error *error) {
    char block[BLOCK_SIZE];
    size_t count;
    while ((count = fread(block, 1, sizeof block, read)) > 0)
        if (fwrite(block, 1, count, written) != count)
            return file_fail(error, to, errno ? errno : EIO, "cannot be written");
    return ferror(read) ? file_fail(error, from, EIO, "cannot be read") : TULLE_OK;
}

/* It appears whole or not at all. */
static tulle_status copy_file(const char *from, const char *to, tulle_error *error) {
    char temporary[NUMBERED_PATH_SIZE];
    int const length = snprintf(temporary, sizeof temporary, "%s.%ld.tmp", to, (long)getpid());
    if (length < 0 || (size_t)length >= sizeof temporary)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, to, 0, 0, "the path is too long");
    FILE *const read = fopen(from, "rb");
    if (!read) return file_fail(error, from, errno, "cannot be read");
    FILE *const written = fopen(temporary, "wb");
    tulle_status status = written ? copy_bytes(from, read, to, written, error)
                                  : file_fail(error, to, errno, "cannot be written");
    fclose(read);
    if (!written) return status;
    if (fclose(written) != 0 && status == TULLE_OK)
        status = file_fail(error, to, errno, "cannot be written");
    int const code = status == TULLE_OK ? file_rename(temporary, to) : 0;
    if (code != 0) status = file_fail(error, to, code, "cannot be written");
    if (status != TULLE_OK) unlink(temporary);
    return status;
}

static tulle_status write_numbered(const mend_bodies *bodies, size_t number,
                                   const mend_store *store, double *positions[2],
                                   tulle_error *error) {
    const mend_surface *const surface = &bodies->input->surfaces[number];
    size_t const count = surface->vertex_end - surface->vertex_begin;
    tulle_mesh_view mesh = tulle_mesh_get_view(&surface->source.mesh);
    bool const is_vtp = convert_get_format(surface->source.path) == CONVERT_VTP;
    tulle_status status = TULLE_OK;
    mesh.positions = positions[1];
    for (uint32_t i = 0; i < frame_range_get_count(surface->source.frames) && status == TULLE_OK;
         i++) {
        char paths[2][NUMBERED_PATH_SIZE];
        if (interrupt_is_pending()) return error_set(error, TULLE_ERROR_INTERRUPTED, "interrupted");
        status = make_numbered_paths(bodies, number, i, paths, error);
        if (status == TULLE_OK)
            status = mend_input_read_surface(bodies->input, number, i, positions[0], error);
        if (status == TULLE_OK)
            status = mend_store_read(store, i, surface->vertex_begin, count, positions[1], error);
        if (status != TULLE_OK) return status;
        bool const is_given = memcmp(positions[0], positions[1], 3 * count * sizeof(double)) == 0;
        axes_apply(&surface->back, positions[1], count);
        status = is_given ? copy_file(paths[0], paths[1], error)
                 : is_vtp ? tulle_vtp_write(paths[1], mesh, NULL, error)
                          : tulle_mesh_write(paths[1], mesh, error);
    }
    return status;
}

static tulle_status write_files(mend_bodies *bodies, size_t number, const mend_store *store,
                                tulle_error *error) {
    const mend_surface *const surface = &bodies->input->surfaces[number];
    size_t const count = surface->vertex_end - surface->vertex_begin;
    double *const room = calloc(count, 6 * sizeof(double));
    if (!room) return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory");
    double *positions[2] = {room, room + 3 * count};
    tulle_status const status = write_numbered(bodies, number, store, positions, error);
    free(room);
    return status;
}

/* More than one file, whose names are inside. */
static bool is_several(const convert_source *source) {
    return source->kind == SOURCE_RUN || convert_get_format(source->path) == CONVERT_GLTF;
}

static bool is_rounded(const mend_bodies *bodies, size_t number) {
    const mend_surface *const surface = &bodies->input->surfaces[number];
    return surface->is_float && surface->source.kind != SOURCE_RUN &&
           (bodies->was_held[number] || is_several(&surface->source));
}

tulle_status mend_bodies_judge_rounding(const mend_bodies *bodies, const mend_store *store,
                                        mend_follow *follow, tulle_error *error) {
    const mend_input *const input = bodies->input;
    size_t const size = 3 * input->vertex_count;
    bool rounds = false;
    for (size_t i = 1; i < input->surface_count; i++) rounds = rounds || is_rounded(bodies, i);
    if (!rounds) return TULLE_OK;
    double *const exact = calloc(2 * size, sizeof *exact);
    if (!exact) return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory");
    double *const rounded = exact + size;
    tulle_status status = mend_follow_let_all_move(follow, error);
    for (uint32_t i = 0; i < input->frame_count && status == TULLE_OK; i++) {
        status = interrupt_is_pending()
                     ? error_set(error, TULLE_ERROR_INTERRUPTED, "interrupted")
                     : mend_store_read(store, i, 0, input->vertex_count, exact, error);
        if (status != TULLE_OK) break;
        memcpy(rounded, exact, size * sizeof *exact);
        for (size_t k = 1; k < input->surface_count; k++)
            if (is_rounded(bodies, k))
                mend_input_round_body(input, k,
                                      rounded + 3 * (size_t)input->surfaces[k].vertex_begin);
        if (memcmp(exact, rounded, size * sizeof *exact) == 0) continue;
        tulle_error found = {0};
        status = mend_follow_judge_rounding(follow, exact, rounded, &found);
        if (status != TULLE_OK)
            error_set_at(error, status, bodies->folder, 0, 0, "frame %u: %.500s",
                         mend_input_get_number(input, i), found.message);
    }
    free(exact);
    return status;
}

tulle_status mend_bodies_write(mend_bodies *bodies, const mend_store *store, tulle_error *error) {
    tulle_status status = TULLE_OK;
    for (size_t i = 1; i < bodies->input->surface_count && status == TULLE_OK; i++) {
        const convert_source *const source = &bodies->input->surfaces[i].source;
        bodies->outputs[i].store = store;
        if (source->kind == SOURCE_FILES)
            status = write_files(bodies, i, store, error);
        else if (bodies->was_held[i] || is_several(source))
            status = mend_output_write(&bodies->outputs[i], error);
        else
            status = copy_file(source->path, bodies->paths[i], error);
    }
    return status;
}
