/* app/mend/input.c - see input.h. */
#include "app/mend/input.h"

#include "app/commands.h"
#include "app/convert/names.h"
#include "base/error.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static tulle_status fail_memory(tulle_error *error) {
    return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for the surfaces");
}

static tulle_status open_surface(mend_surface *surface, const char *path, const char *mesh_path,
                                 tulle_error *error) {
    source_options const options = {.path = path, .mesh_path = mesh_path};
    tulle_status const status = convert_source_open(&options, &surface->source, error);
    if (status != TULLE_OK) return status;
    const convert_source *const source = &surface->source;
    if (source->mesh.triangle_count == 0)
        return error_set_at(
            error, TULLE_ERROR_INVALID_ARGUMENT, path, 0, 0, "has no triangles%s",
            source->kind == SOURCE_CACHE
                ? "; give the mesh that the point cache moves by --mesh, of a body by --body-mesh"
                : "");
    if (source->needs_frames_named)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, path, 0, 0,
                            "there is no file of number %u; all frames are needed", source->gap);
    surface->is_still = frame_range_get_count(source->frames) == 1;
    return TULLE_OK;
}

/* The first surface that is opened, the cloth, chooses the unit where nothing else does. */
static tulle_status choose_axes(const mend_input_options *options, mend_input *input,
                                mend_surface *surface, tulle_error *error) {
    convert_format const format = convert_get_format(surface->source.path);
    bool const says =
        surface->source.kind == SOURCE_ANIMATION && format != CONVERT_NPZ && format != CONVERT_ABC;
    bool const is_free = surface == input->surfaces || !says;
    axes_frame from;
    tulle_status const status = convert_source_find_axes(
        &surface->source,
        is_free ? (axes_frame){options->from_up, options->from_unit} : (axes_frame){NULL, NULL},
        &from, error);
    if (status != TULLE_OK) return status;
    if (!input->unit) input->unit = options->unit ? options->unit : from.unit;
    surface->change = axes_change_make(from, (axes_frame){"z", input->unit});
    surface->back = axes_change_make((axes_frame){"z", input->unit}, from);
    surface->is_float = format == CONVERT_STL || (format >= CONVERT_PC2 && format != CONVERT_NPZ);
    return TULLE_OK;
}

static tulle_status open_bodies(const mend_input_options *options, mend_input *input,
                                tulle_error *error) {
    size_t mesh_count = 0;
    for (size_t i = 0; i < options->bodies->count; i++) {
        const char *const path = options->bodies->items[i];
        const char *mesh = NULL;
        if (convert_is_cache(convert_get_format(path)) && mesh_count < options->body_meshes->count)
            mesh = options->body_meshes->items[mesh_count++];
        mend_surface *const surface = &input->surfaces[input->surface_count++];
        tulle_status status = open_surface(surface, path, mesh, error);
        if (status == TULLE_OK) status = choose_axes(options, input, surface, error);
        if (status != TULLE_OK) return status;
        uint32_t const count = frame_range_get_count(surface->source.frames);
        if (count != 1 && count != input->frame_count)
            return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, path, 0, 0,
                                "has %u frames, but the cloth has %u; a body has as many, or one",
                                count, input->frame_count);
    }
    if (mesh_count == options->body_meshes->count) return TULLE_OK;
    return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                     "--body-mesh is given %zu times, but %zu bodies are point caches",
                     options->body_meshes->count, mesh_count);
}

/* A body goes without triangles that it has twice, that use a vertex twice, and, where it is still,
 * that have no area. Says so. */
static tulle_status leave_out(mend_input *input, size_t number, tulle_error *error) {
    mend_surface *const surface = &input->surfaces[number];
    tulle_mesh *const mesh = &surface->source.mesh;
    const char *const name = surface->source.path;
    tulle_mesh_duplicates twice;
    tulle_status status = tulle_mesh_drop_duplicates(mesh, NULL, &twice, error);
    if (status != TULLE_OK) return status;
    if (twice.count > 0)
        app_print_message(
            "mend",
            "%s: %zu triangles have the same corners as others and are left out, first triangle %u",
            name, twice.count, twice.dropped);
    uint8_t *const marks = calloc(mesh->triangle_count, 1);
    double *const positions = calloc(mesh->vertex_count, 3 * sizeof *positions);
    if (!marks || !positions) status = fail_memory(error);
    if (status == TULLE_OK) status = mend_input_read_surface(input, number, 0, positions, error);
    tulle_mesh_view const view = {positions, mesh->vertex_count, mesh->triangles,
                                  mesh->triangle_count};
    if (status == TULLE_OK) status = tulle_mesh_find_degenerate(view, marks, NULL, error);
    size_t count = 0, first = 0;
    for (size_t t = mesh->triangle_count; status == TULLE_OK && t-- > 0;) {
        const uint32_t *const corner = mesh->triangles + 3 * t;
        bool const is_line =
            corner[0] == corner[1] || corner[1] == corner[2] || corner[2] == corner[0];
        marks[t] = marks[t] && (surface->is_still || is_line);
        if (marks[t]) count++, first = t;
    }
    if (status == TULLE_OK && count > 0 && count == mesh->triangle_count)
        status = error_set_at(
            error, TULLE_ERROR_INVALID_MESH, name, 0, 0,
            "none of its %zu triangles has an area; a body needs one with an area", count);
    if (status == TULLE_OK) status = tulle_mesh_drop_marked(mesh, marks, NULL, error);
    free(marks);
    free(positions);
    if (status == TULLE_OK && count > 0)
        app_print_message("mend",
                          "%s: %zu triangles have no area and are left out, first triangle %zu",
                          name, count, first);
    return status;
}

static tulle_status join_surfaces(mend_input *input, tulle_error *error) {
    for (size_t i = 0; i < input->surface_count; i++) {
        mend_surface *const surface = &input->surfaces[i];
        const tulle_mesh *const mesh = &surface->source.mesh;
        if (input->vertex_count + mesh->vertex_count > INT32_MAX ||
            input->triangle_count + mesh->triangle_count > INT32_MAX)
            return error_set(error, TULLE_ERROR_LIMIT, "2^31 vertices or triangles are too many");
        surface->vertex_begin = (uint32_t)input->vertex_count;
        surface->triangle_begin = (uint32_t)input->triangle_count;
        input->vertex_count += mesh->vertex_count;
        input->triangle_count += mesh->triangle_count;
        surface->vertex_end = (uint32_t)input->vertex_count;
        surface->triangle_end = (uint32_t)input->triangle_count;
    }
    input->triangles = calloc(3 * input->triangle_count, sizeof *input->triangles);
    input->local_triangles = calloc(3 * input->triangle_count, sizeof *input->triangles);
    if (!input->triangles || !input->local_triangles) return fail_memory(error);
    for (size_t i = 0; i < input->surface_count; i++) {
        const mend_surface *const surface = &input->surfaces[i];
        size_t const begin = 3 * (size_t)surface->triangle_begin;
        for (size_t k = begin; k < 3 * (size_t)surface->triangle_end; k++) {
            input->local_triangles[k] = surface->source.mesh.triangles[k - begin];
            input->triangles[k] = input->local_triangles[k] + surface->vertex_begin;
        }
    }
    return TULLE_OK;
}

tulle_status mend_input_open(const mend_input_options *options, mend_input *input,
                             tulle_error *error) {
    *input = (mend_input){0};
    input->surfaces = calloc(1 + options->bodies->count, sizeof *input->surfaces);
    if (!input->surfaces) return fail_memory(error);
    input->surface_count = 1;
    tulle_status status =
        open_surface(&input->surfaces[0], options->path, options->mesh_path, error);
    if (status == TULLE_OK) status = choose_axes(options, input, &input->surfaces[0], error);
    if (status != TULLE_OK) return status;
    input->frame_count = frame_range_get_count(input->surfaces[0].source.frames);
    status = open_bodies(options, input, error);
    for (size_t i = 1; i < input->surface_count && status == TULLE_OK; i++)
        status = leave_out(input, i, error);
    return status == TULLE_OK ? join_surfaces(input, error) : status;
}

void mend_input_close(mend_input *input) {
    for (size_t i = 0; i < input->surface_count; i++)
        convert_source_close(&input->surfaces[i].source);
    free(input->surfaces);
    free(input->triangles);
    free(input->local_triangles);
    *input = (mend_input){0};
}

bool mend_input_reads(const mend_input *input, const char *path) {
    for (size_t i = 0; i < input->surface_count; i++)
        if (convert_source_reads(&input->surfaces[i].source, path)) return true;
    return false;
}

uint32_t mend_input_get_number(const mend_input *input, uint32_t index) {
    return frame_range_get(input->surfaces[0].source.frames, index);
}

static tulle_status read_surface(mend_input *input, size_t surface, uint32_t index, bool rounds,
                                 double *positions, tulle_error *error) {
    mend_surface *const read = &input->surfaces[surface];
    convert_source *const source = &read->source;
    uint32_t const frame = frame_range_get(source->frames, read->is_still ? 0 : index);
    tulle_status const status = convert_source_read(source, frame, positions, error);
    if (status != TULLE_OK) return status;
    axes_apply(&read->change, positions, source->mesh.vertex_count);
    for (size_t k = 0; k < 3 * source->mesh.vertex_count; k++) {
        if (surface == 0 && rounds) positions[k] = (double)(float)positions[k];
        if (!isfinite(positions[k]))
            return error_set_at(
                error, TULLE_ERROR_INVALID_MESH, source->path, 0, 0,
                "frame %u: vertex %zu is farther away than can be held in this unit", frame, k / 3);
    }
    return TULLE_OK;
}

tulle_status mend_input_read_surface(mend_input *input, size_t surface, uint32_t index,
                                     double *positions, tulle_error *error) {
    return read_surface(input, surface, index, input->is_float, positions, error);
}

tulle_status mend_input_read_exact(mend_input *input, uint32_t index, double *positions,
                                   tulle_error *error) {
    return read_surface(input, 0, index, false, positions, error);
}

tulle_status mend_input_read(mend_input *input, uint32_t index, double *positions,
                             tulle_error *error) {
    tulle_status status = TULLE_OK;
    for (size_t i = 0; i < input->surface_count && status == TULLE_OK; i++)
        status = mend_input_read_surface(
            input, i, index, positions + 3 * (size_t)input->surfaces[i].vertex_begin, error);
    return status;
}

void mend_input_round_body(const mend_input *input, size_t surface, double *positions) {
    const mend_surface *const body = &input->surfaces[surface];
    size_t const count = body->vertex_end - body->vertex_begin;
    if (!body->is_float) return;
    axes_apply(&body->back, positions, count);
    for (size_t i = 0; i < 3 * count; i++) positions[i] = (double)(float)positions[i];
    axes_apply(&body->change, positions, count);
}
