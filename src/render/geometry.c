/* render/geometry.c - see geometry.h. */
#include "render/geometry.h"

#include "base/error.h"

static void compute_center(const render_frame_def *def, render_geometry *geometry) {
    vec3 low = vec3_make(INFINITY, INFINITY, INFINITY), high = vec3_neg(low);
    for (size_t s = 0; s < def->surface_count; s++) {
        tulle_mesh_view const mesh = def->surfaces[s].mesh;
        for (size_t v = 0; v < mesh.vertex_count; v++) {
            vec3 const point = vec3_load(mesh.positions, v);
            low = vec3_make(fmin(low.x, point.x), fmin(low.y, point.y), fmin(low.z, point.z));
            high = vec3_make(fmax(high.x, point.x), fmax(high.y, point.y), fmax(high.z, point.z));
        }
    }
    if (!(low.x <= high.x)) low = high = vec3_load(def->camera.target, 0);
    geometry->center = vec3_scale(vec3_add(low, high), 0.5);
    geometry->radius = 0.5 * vec3_norm(vec3_sub(high, low));
}

static bool allocate(const render_frame_def *def, render_geometry *geometry) {
    bool has_smooth = false;
    for (size_t s = 0; s < def->surface_count; s++) {
        geometry->vertex_count += def->surfaces[s].mesh.vertex_count;
        geometry->triangle_count += def->surfaces[s].mesh.triangle_count;
        has_smooth = has_smooth || def->surfaces[s].crease_angle > 0.0;
    }
    geometry->part_count = def->surface_count;
    memory *const heap = &geometry->heap;
    size_t const triangle_count = geometry->triangle_count;
    geometry->vertices = memory_allocate_zeroed(heap, 3 * geometry->vertex_count + 1, 4);
    geometry->triangles = memory_allocate_zeroed(heap, 3 * triangle_count, 4);
    geometry->part_index = memory_allocate_zeroed(heap, triangle_count, 4);
    geometry->reach = memory_allocate_zeroed(heap, triangle_count, 4);
    geometry->parts = memory_allocate_zeroed(heap, geometry->part_count, sizeof(render_part));
    if (has_smooth) geometry->corner_normals = memory_allocate_zeroed(heap, 9 * triangle_count, 4);
    return geometry->vertices && geometry->triangles && geometry->part_index && geometry->reach &&
           geometry->parts && (geometry->corner_normals || !has_smooth);
}

static void copy_part(render_geometry *geometry, uint32_t index) {
    const render_part *const part = &geometry->parts[index];
    tulle_mesh_view const mesh = part->surface->mesh;
    for (size_t v = 0; v < mesh.vertex_count; v++) {
        vec3 const point = vec3_sub(vec3_load(mesh.positions, v), geometry->center);
        float *const rounded = geometry->vertices + 3 * (part->first_vertex + v);
        rounded[0] = (float)point.x;
        rounded[1] = (float)point.y;
        rounded[2] = (float)point.z;
    }
    for (size_t i = 0; i < 3 * mesh.triangle_count; i++)
        geometry->triangles[3 * (size_t)part->first_triangle + i] =
            part->first_vertex + mesh.triangles[i];
    for (size_t t = 0; t < mesh.triangle_count; t++)
        geometry->part_index[part->first_triangle + t] = index;
}

static float measure_longest_edge(const render_geometry *geometry, const uint32_t *corners) {
    double longest = 0.0;
    for (int i = 0; i < 3; i++) {
        vec3 const edge = vec3_sub(render_geometry_get_vertex(geometry, corners[(i + 1) % 3]),
                                   render_geometry_get_vertex(geometry, corners[i]));
        longest = fmax(longest, vec3_norm(edge));
    }
    return (float)longest;
}

static bool measure_reach(render_geometry *geometry) {
    size_t const byte_count = geometry->vertex_count * sizeof(float);
    float *const around = memory_allocate_zeroed(&geometry->heap, geometry->vertex_count, 4);
    if (!around) return false;
    for (size_t t = 0; t < geometry->triangle_count; t++) {
        const uint32_t *const corners = geometry->triangles + 3 * t;
        float const longest = measure_longest_edge(geometry, corners);
        for (int i = 0; i < 3; i++) around[corners[i]] = fmaxf(around[corners[i]], longest);
    }
    for (size_t t = 0; t < geometry->triangle_count; t++) {
        const uint32_t *const corners = geometry->triangles + 3 * t;
        geometry->reach[t] =
            fmaxf(around[corners[0]], fmaxf(around[corners[1]], around[corners[2]]));
    }
    memory_release(&geometry->heap, around, byte_count);
    return true;
}

static bool fill(const render_frame_def *def, render_geometry *geometry) {
    uint32_t vertex = 0, triangle = 0;
    for (uint32_t s = 0; s < geometry->part_count; s++) {
        const render_surface *const surface = &def->surfaces[s];
        geometry->parts[s] = (render_part){surface, vertex, triangle, surface->crease_angle > 0.0};
        copy_part(geometry, s);
        if (geometry->parts[s].is_smooth &&
            !render_compute_corner_normals(&geometry->heap, surface->mesh, surface->crease_angle,
                                           geometry->corner_normals + 9 * (size_t)triangle))
            return false;
        vertex += (uint32_t)surface->mesh.vertex_count;
        triangle += (uint32_t)surface->mesh.triangle_count;
    }
    return measure_reach(geometry);
}

tulle_status render_geometry_build(const render_frame_def *def, render_geometry *geometry,
                                   tulle_error *error) {
    *geometry = (render_geometry){.heap = memory_default()};
    compute_center(def, geometry);
    if (allocate(def, geometry) && fill(def, geometry)) return TULLE_OK;
    size_t const triangle_count = geometry->triangle_count;
    render_geometry_destroy(geometry);
    return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory for a picture of %zu triangles",
                     triangle_count);
}

void render_geometry_destroy(render_geometry *geometry) {
    memory *const heap = &geometry->heap;
    size_t const triangle_count = geometry->triangle_count;
    memory_release(heap, geometry->vertices, 4 * (3 * geometry->vertex_count + 1));
    memory_release(heap, geometry->triangles, 12 * triangle_count);
    memory_release(heap, geometry->part_index, 4 * triangle_count);
    memory_release(heap, geometry->reach, 4 * triangle_count);
    memory_release(heap, geometry->corner_normals, 36 * triangle_count);
    memory_release(heap, geometry->parts, geometry->part_count * sizeof(render_part));
    *geometry = (render_geometry){0};
}
