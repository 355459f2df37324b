/* app/detect/frames.c - see frames.h. */
#include "app/detect/frames.h"

#include "app/cli/mesh_file.h"
#include "app/convert/names.h"
#include "base/error.h"

#include "tulle/check.h"

#include <inttypes.h>
#include <stdbool.h>

static tulle_status read_frame(const char *path, tulle_mesh *mesh, tulle_error *error) {
    convert_format const format = convert_get_format(path);
    if (format == CONVERT_STL)
        return error_set_at(error, TULLE_ERROR_UNSUPPORTED, path, 0, 0,
                            "STL files hold no vertices that could be followed from one state to "
                            "the next; export both as OBJ or PLY");
    if (format != CONVERT_OBJ && format != CONVERT_PLY && format != CONVERT_VTP)
        return error_set_at(error, TULLE_ERROR_UNSUPPORTED, path, 0, 0,
                            "its format is not known; the name should end in .obj, .ply or .vtp");
    mesh_file_notes notes = {.command = "detect"};
    tulle_status const status = mesh_file_read_noted(path, &notes, mesh, error);
    if (status != TULLE_OK || mesh->triangle_count > 0) return status;
    tulle_mesh_destroy(mesh);
    return error_set_at(error, TULLE_ERROR_INVALID_MESH, path, 0, 0,
                        "the file holds no triangles, so there is nothing that could collide");
}

/* Whether both have the same triangles; else says where they differ first. */
static tulle_status compare(const detect_frames *frames, const char *start_path,
                            const char *end_path, tulle_error *error) {
    const tulle_mesh *const start = &frames->start, *const end = &frames->end;
    if (start->vertex_count != end->vertex_count)
        return error_set_at(error, TULLE_ERROR_INVALID_MESH, end_path, 0, 0,
                            "has %zu vertices, but %s has %zu; both should be states of the same "
                            "mesh",
                            end->vertex_count, start_path, start->vertex_count);
    if (start->triangle_count != end->triangle_count)
        return error_set_at(error, TULLE_ERROR_INVALID_MESH, end_path, 0, 0,
                            "has %zu triangles, but %s has %zu; both should be states of the same "
                            "mesh",
                            end->triangle_count, start_path, start->triangle_count);
    for (size_t i = 0; i < 3 * start->triangle_count; i++) {
        if (start->triangles[i] == end->triangles[i]) continue;
        const uint32_t *const a = start->triangles + i / 3 * 3, *const b =
                                                                    end->triangles + i / 3 * 3;
        return error_set_at(error, TULLE_ERROR_INVALID_MESH, end_path, 0, 0,
                            "triangle %zu has vertices %" PRIu32 ", %" PRIu32 ", %" PRIu32
                            ", but in %s %" PRIu32 ", %" PRIu32 ", %" PRIu32
                            " (counted from 0); both should be states of the same mesh",
                            i / 3, b[0], b[1], b[2], start_path, a[0], a[1], a[2]);
    }
    return TULLE_OK;
}

tulle_status detect_frames_read(const char *start_path, const char *end_path, detect_frames *frames,
                                tulle_error *error) {
    *frames = (detect_frames){0};
    tulle_status status = read_frame(start_path, &frames->start, error);
    if (status == TULLE_OK) status = read_frame(end_path, &frames->end, error);
    if (status == TULLE_OK) status = compare(frames, start_path, end_path, error);
    if (status != TULLE_OK) detect_frames_destroy(frames);
    return status;
}

tulle_status detect_frames_count_crossings(const detect_frames *frames, int threads,
                                           uint64_t *count, tulle_error *error) {
    tulle_check_body const body = {.mesh = tulle_mesh_get_view(&frames->start)};
    tulle_check_result result;
    tulle_status const status = tulle_check_intersections(&body, 1, threads, &result, error);
    if (status == TULLE_OK) {
        *count = result.pair_count;
        tulle_check_result_destroy(&result);
    } else if (status == TULLE_ERROR_LIMIT) {
        *count = DETECT_CROSSINGS_MAX + 1;
        if (error) *error = (tulle_error){0};
        return TULLE_OK;
    }
    return status;
}

void detect_frames_destroy(detect_frames *frames) {
    tulle_mesh_destroy(&frames->start);
    tulle_mesh_destroy(&frames->end);
}
