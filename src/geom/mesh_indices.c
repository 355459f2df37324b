/* geom/mesh_indices.c - see mesh_indices.h. */
#include "geom/mesh_indices.h"

#include "base/error.h"

tulle_status mesh_check_indices(tulle_mesh_view mesh, tulle_error *error) {
    if ((mesh.vertex_count > 0 && !mesh.positions) || (mesh.triangle_count > 0 && !mesh.triangles))
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "the mesh view has a count but a null array");
    if (mesh.vertex_count > MESH_COUNT_MAX || mesh.triangle_count > MESH_COUNT_MAX)
        return error_set(error, TULLE_ERROR_LIMIT,
                         "the mesh has %zu vertices and %zu triangles; the limit is %zu of each",
                         mesh.vertex_count, mesh.triangle_count, MESH_COUNT_MAX);
    size_t count = 0, first = 0;
    uint32_t index = 0;
    for (size_t t = 0; t < mesh.triangle_count; t++) {
        for (int k = 0; k < 3; k++) {
            if (mesh.triangles[3 * t + (size_t)k] < mesh.vertex_count) continue;
            if (count == 0) {
                first = t;
                index = mesh.triangles[3 * t + (size_t)k];
            }
            count++;
            break;
        }
    }
    if (count == 0) return TULLE_OK;
    return error_set(
        error, TULLE_ERROR_INVALID_MESH,
        "triangle %zu (counted from 0) names vertex %lu, but the mesh has %zu vertices "
        "(0 to %zu); %zu triangle%s like this; correct the indices",
        first, (unsigned long)index, mesh.vertex_count,
        mesh.vertex_count > 0 ? mesh.vertex_count - 1 : 0, count, count == 1 ? " is" : "s are");
}
