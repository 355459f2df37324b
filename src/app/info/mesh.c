/* app/info/mesh.c - what `tulle info` prints of a mesh file and of a point cache. */
#include "app/commands.h"
#include "app/info/info.h"

#include "app/cli/mesh_file.h"
#include "app/convert/names.h"
#include "base/error.h"
#include "base/float_height.h"

#include "tulle/mesh.h"
#include "tulle_io/cache.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double DEGREES_PER_RADIAN = 57.29577951308232;

static void print_bounds(const double minimum[3], const double maximum[3]) {
    for (int axis = 0; axis < 3; axis++) {
        printf("  %-16s %c  %.6g .. %.6g m\n", axis == 0 ? "bounds" : "", "xyz"[axis],
               minimum[axis], maximum[axis]);
    }
}

void info_print_bounds(const double *positions, size_t vertex_count) {
    double minimum[3] = {INFINITY, INFINITY, INFINITY};
    double maximum[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (size_t i = 0; i < 3 * vertex_count; i++) {
        minimum[i % 3] = fmin(minimum[i % 3], positions[i]);
        maximum[i % 3] = fmax(maximum[i % 3], positions[i]);
    }
    print_bounds(minimum, maximum);
}

static void print_counts(const tulle_mesh_info *info) {
    printf("  %-16s %zu (%zu used by no triangle)\n", "vertices", info->vertex_count,
           info->unreferenced_vertex_count);
    printf("  %-16s %zu (%zu degenerate)\n", "triangles", info->triangle_count,
           info->degenerate_triangle_count);
    printf("  %-16s %zu (%zu on the boundary in %zu loops, %zu with three or more triangles)\n",
           "edges", info->edge_count, info->boundary_edge_count, info->boundary_loop_count,
           info->nonmanifold_edge_count);
    printf("  %-16s %zu\n", "pieces", info->component_count);
    printf("  %-16s %ld\n", "V - E + F", info->euler_characteristic);
}

static void print_quality(const tulle_mesh_info *info) {
    printf("  %-16s %.6g m^2\n", "area", info->area);
    printf("  %-16s %.6g least, %.6g mean, %.6g greatest [m]\n", "edge length",
           info->edge_length_min, info->edge_length_mean, info->edge_length_max);
    printf("  %-16s %.4g deg\n", "smallest angle", info->angle_min * DEGREES_PER_RADIAN);
}

enum { LISTED_PARTS = 20 };

/* The names by which a scene can choose triangles, and how many each has. */
static void print_parts(const tulle_mesh_source *source, tulle_mesh_part_kind kind,
                        const char *label) {
    const char *names[LISTED_PARTS];
    size_t counts[LISTED_PARTS], listed = 0;
    bool has_more = false;
    for (size_t i = 0; i < source->part_count; i++) {
        const tulle_mesh_part *const part = &source->parts[i];
        size_t known = 0;
        if (part->kind != kind) continue;
        while (known < listed && strcmp(names[known], part->name) != 0) known++;
        has_more |= known == LISTED_PARTS;
        if (known == LISTED_PARTS) continue;
        if (known == listed) names[listed] = part->name, counts[listed++] = 0;
        counts[known] += part->count;
    }
    for (size_t i = 0; i < listed; i++)
        app_print_names(stdout, "  %-16s %s: %zu triangles\n", i == 0 ? label : "", names[i],
                        counts[i]);
    if (has_more) printf("  %-16s ...\n", "");
}

/* [m] Of a triangle over its longest edge. */
static double find_height(const double *positions, const uint32_t corners[3]) {
    double edges[3][3], longest = 0.0;
    for (size_t k = 0; k < 3; k++) {
        const double *const a = positions + 3 * (size_t)corners[k];
        const double *const b = positions + 3 * (size_t)corners[(k + 1) % 3];
        for (size_t axis = 0; axis < 3; axis++) edges[k][axis] = b[axis] - a[axis];
        longest = fmax(longest, hypot(hypot(edges[k][0], edges[k][1]), edges[k][2]));
    }
    const double *const u = edges[0], *const v = edges[1];
    double const across = hypot(hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2]),
                                u[0] * v[1] - u[1] * v[0]);
    return across / longest;
}

/* Where cloth lies too far from the origin for floats: how near it must be. */
static void print_reach(tulle_mesh_view mesh) {
    double extent = 0.0, lowest = (double)INFINITY;
    for (size_t i = 0; i < 3 * mesh.vertex_count; i++)
        extent = fmax(extent, fabs(mesh.positions[i]));
    for (size_t t = 0; t < mesh.triangle_count; t++)
        lowest = fmin(lowest, find_height(mesh.positions, mesh.triangles + 3 * t));
    if (lowest < LEAST_HEIGHT * extent)
        printf("  %-16s within %.3g m of the origin only, and it reaches %.3g m: floats hold its "
               "lowest triangle, of %.3g m, no further out; move it there by 'place' or "
               "'translate'\n",
               "", lowest / LEAST_HEIGHT, extent, lowest);
}

void info_print_use(tulle_mesh_view mesh, tulle_mesh_role role, const tulle_mesh_source *source,
                    const char *label) {
    tulle_mesh_lines const lines = {source->vertex_lines, source->triangle_lines};
    tulle_error reason = {0};
    tulle_status const status = tulle_mesh_validate_lines(mesh, role, lines, &reason);
    app_print_names(stdout, "  %-16s %s\n", label,
                    status == TULLE_OK ? "can be used" : reason.message);
    if (status == TULLE_OK && role == TULLE_MESH_ROLE_CLOTH) print_reach(mesh);
}

/* Whether a repair makes cloth of a mesh, or joins the pieces that cloth would fall into. */
static void print_remedy(const char *path, tulle_mesh_view mesh) {
    tulle_mesh copy = {0};
    tulle_mesh_repairs repairs;
    tulle_error reason = {0};
    bool const is_cloth = tulle_mesh_validate(mesh, TULLE_MESH_ROLE_CLOTH, NULL) == TULLE_OK;
    if (tulle_mesh_create(mesh.vertex_count, mesh.triangle_count, &copy, NULL) != TULLE_OK) return;
    if (mesh.vertex_count > 0)
        memcpy(copy.positions, mesh.positions, 3 * mesh.vertex_count * sizeof(double));
    if (mesh.triangle_count > 0)
        memcpy(copy.triangles, mesh.triangles, 3 * mesh.triangle_count * sizeof(uint32_t));
    tulle_status status = tulle_mesh_repair(&copy, 0.0, &repairs, &reason);
    if (status == TULLE_OK)
        status = tulle_mesh_validate(tulle_mesh_get_view(&copy), TULLE_MESH_ROLE_CLOTH, &reason);
    tulle_mesh_destroy(&copy);
    size_t const joined = is_cloth && status == TULLE_OK ? repairs.counts[TULLE_REPAIR_JOINED] : 0;
    if (joined > 0) {
        printf("  %-16s but %zu boundary vertices are in the place of others, and nothing joins "
               "them: it comes apart there;\n",
               "", joined);
        app_print_names(stdout, "  %-16s 'tulle convert %s OUT.ply --repair' joins them\n", "",
                        path);
    }
    if (is_cloth) return;
    if (status == TULLE_OK)
        app_print_names(stdout, "  %-16s 'tulle convert %s OUT.ply --repair' makes it cloth\n", "",
                        path);
    else if (mesh.triangle_count > 0)
        app_print_names(stdout, "  %-16s and 'tulle convert --repair' does not help: %s\n", "",
                        reason.message);
}

tulle_status info_print_use_as_obstacle(tulle_mesh *mesh, const tulle_mesh_source *source,
                                        bool deforms, tulle_error *error) {
    uint32_t *const lines = source->triangle_lines;
    tulle_mesh_duplicates twice;
    tulle_status status = tulle_mesh_drop_duplicates(mesh, lines, &twice, error);
    if (status != TULLE_OK) return status;
    size_t count = 0, first = 0;
    uint8_t *const marks = malloc(mesh->triangle_count + 1);
    if (!marks) return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory for the triangles");
    status = tulle_mesh_find_degenerate(tulle_mesh_get_view(mesh), marks, &count, error);
    bool const leaves_some = status == TULLE_OK && count < mesh->triangle_count;
    while (count > 0 && !marks[first]) first++;
    uint32_t const line = count > 0 && lines ? lines[first] : 0;
    if (leaves_some) status = tulle_mesh_drop_marked(mesh, marks, lines, error);
    free(marks);
    if (status != TULLE_OK) return status;
    info_print_use(tulle_mesh_get_view(mesh), TULLE_MESH_ROLE_OBSTACLE, source, "as obstacle");
    if (twice.count > 0) {
        printf("  %-16s dropped there: %zu triangles with the same corners as others; triangle %u",
               "", twice.count, twice.dropped);
        if (twice.dropped_line > 0) printf(" (line %u)", twice.dropped_line);
        printf(" is triangle %u", twice.original);
        if (twice.original_line > 0) printf(" (line %u)", twice.original_line);
        puts(" again");
    }
    if (leaves_some && count > 0) {
        printf("  %-16s left out there: %zu triangles without area%s, first triangle %zu", "",
               count, deforms ? " in this frame, unless they have one in others" : "", first);
        if (line > 0) printf(" (line %u)", line);
        putchar('\n');
    }
    return TULLE_OK;
}

tulle_status info_print_mesh(const char *path, tulle_error *error) {
    tulle_mesh mesh = {0};
    tulle_mesh_source source;
    tulle_status status = mesh_file_read(path, &mesh, &source, error);
    if (status != TULLE_OK) return status;
    tulle_mesh_view const view = tulle_mesh_get_view(&mesh);
    tulle_mesh_info info;
    status = tulle_mesh_get_info(view, &info, error);
    if (status == TULLE_OK) {
        app_print_names(stdout, "%s: triangle mesh\n", path);
        print_counts(&info);
        print_bounds(info.bounds_min, info.bounds_max);
        print_quality(&info);
        if (source.note[0]) app_print_names(stdout, "  %-16s %s\n", "file", source.note);
        print_parts(&source, TULLE_MESH_PART_GROUP, "groups");
        print_parts(&source, TULLE_MESH_PART_MATERIAL, "materials");
        info_print_use(view, TULLE_MESH_ROLE_CLOTH, &source, "as cloth");
        print_remedy(path, view);
        status = info_print_use_as_obstacle(&mesh, &source, false, error);
    } else if (error->file[0] == '\0') {
        snprintf(error->file, sizeof error->file, "%s", path);
    }
    tulle_mesh_source_destroy(&source);
    tulle_mesh_destroy(&mesh);
    return status;
}

/* Reads a frame and prints the box about its points. */
static tulle_status print_frame_bounds(tulle_pc2 *cache, uint32_t frame, uint32_t vertex_count,
                                       tulle_error *error) {
    double *const positions = calloc((size_t)vertex_count + 1, 3 * sizeof *positions);
    if (!positions)
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY,
                         "not enough memory for a frame of the cache");
    tulle_status const status = tulle_pc2_read_frame(cache, frame, positions, error);
    if (status == TULLE_OK) {
        printf("  frame %u\n", frame);
        info_print_bounds(positions, vertex_count);
    }
    free(positions);
    return status;
}

tulle_status info_print_cache(const char *path, tulle_error *error) {
    tulle_pc2 *cache = NULL;
    tulle_pc2_info info;
    tulle_status status = tulle_pc2_open(path, &cache, &info, error);
    if (status != TULLE_OK) return status;
    double ends[2] = {(double)NAN, (double)NAN};
    if (info.frame_count > 0) status = tulle_pc2_get_time(cache, 0, &ends[0], error);
    if (info.frame_count > 0 && status == TULLE_OK)
        status = tulle_pc2_get_time(cache, info.frame_count - 1, &ends[1], error);
    bool const has_times = convert_get_format(path) == CONVERT_MDD;
    app_print_names(stdout, "%s: point cache (%s)\n", path, has_times ? "MDD" : "PC2");
    printf("  %-16s %u\n", "vertices", info.vertex_count);
    if (has_times)
        printf("  %-16s %u, from %.6g s to %.6g s\n", "frames", info.frame_count,
               info.frame_count > 0 ? ends[0] : 0.0, info.frame_count > 0 ? ends[1] : 0.0);
    else
        printf("  %-16s %u, first %.6g, one every %.6g\n", "frames", info.frame_count,
               info.start_frame, info.frame_step);
    if (info.frame_count > 0 && status == TULLE_OK)
        status = print_frame_bounds(cache, 0, info.vertex_count, error);
    if (info.frame_count > 1 && status == TULLE_OK)
        status = print_frame_bounds(cache, info.frame_count - 1, info.vertex_count, error);
    tulle_pc2_close(cache);
    return status;
}
