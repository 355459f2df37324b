/* detect/patches/certificate.c - see certificate.h. Both tests project along the axis by the same
 * planar map, so they speak of the same exact direction zeta. */
#include "detect/patches/certificate.h"

#include "detect/patches/planar_contour.h"

static const double RIGHT_ANGLE = 1.5707963267948966; /* [rad] */

/* Rounding of zeta . n and |n| over the product of the lengths of two edges, generously: zeta
 * differs from the axis by some 1e-15, the rest are a few units of 2^-53. */
static const double CONE_ROUNDING = 1e-14;

bool triangle_faces_axis(const vec3 start[3], const vec3 end[3], vec3 axis, double max_angle,
                         double reach) {
    planar_map const map = planar_map_make(axis, start[0]);
    planar_path corners[3];
    double size = 0.0;
    for (int k = 0; k < 3; k++) corners[k] = project_path(&map, start[k], end[k], &size);
    double const planar_reach = compute_planar_reach(reach, size);
    if (!(planar_reach > 0.0) ||
        compute_turn_sign(&corners[0], &corners[1], &corners[2], planar_reach) != 1)
        return false;
    if (max_angle >= RIGHT_ANGLE) return true;

    /* axis . n >= cos(max_angle) |n| for the three coefficients of the normal, hence for all times:
     * the vectors that satisfy it are a convex cone. */
    vec3 const u0 = vec3_sub(start[1], start[0]), v0 = vec3_sub(start[2], start[0]);
    vec3 const u1 = vec3_sub(end[1], end[0]), v1 = vec3_sub(end[2], end[0]);
    vec3 const normals[3] = {
        vec3_cross(u0, v0),
        vec3_scale(vec3_add(vec3_cross(u0, v1), vec3_cross(u1, v0)), 0.5),
        vec3_cross(u1, v1),
    };
    double const longest_u = sqrt(fmax(vec3_norm2(u0), vec3_norm2(u1)));
    double const longest_v = sqrt(fmax(vec3_norm2(v0), vec3_norm2(v1)));
    double const error = CONE_ROUNDING * longest_u * longest_v, cosine = cos(max_angle);
    for (int k = 0; k < 3; k++) {
        double const along = vec3_dot(axis, normals[k]);
        if (!(along >= cosine * vec3_norm(normals[k]) + error)) return false;
    }
    return true;
}

contour_proof prove_contour(const contour *boundary, size_t max_tests, void *scratch) {
    size_t const count = boundary->vertex_count;
    if (count < 3) return CONTOUR_UNPROVEN;
    planar_path *const points = scratch;
    planar_map const map =
        planar_map_make(boundary->axis, vec3_load(boundary->x0, boundary->vertices[0]));
    double size = 0.0;
    for (size_t i = 0; i < count; i++) {
        uint32_t const vertex = boundary->vertices[i];
        points[i] = project_path(&map, vec3_load(boundary->x0, vertex),
                                 vec3_load(boundary->x1, vertex), &size);
    }
    double const reach = compute_planar_reach(boundary->reach, size);
    if (!(reach > 0.0)) return CONTOUR_UNPROVEN;
    return prove_planar_contour(points, count, reach, max_tests, points + count);
}
