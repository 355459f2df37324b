/* render/strain.c - see strain.h.
 *
 * The edges at rest are written in an orthonormal frame of the triangle. F maps the plane to space;
 * C = F^T F is a symmetric 2 x 2 matrix whose eigenvalues are the squared stretches. */
#include "render/strain.h"

#include "math/vec3.h"

#include <string.h>

void render_get_stretches(const double rest[9], const double now[9], double stretches[2]) {
    vec3 const rest_a = vec3_sub(vec3_load(rest, 1), vec3_load(rest, 0));
    vec3 const rest_b = vec3_sub(vec3_load(rest, 2), vec3_load(rest, 0));
    vec3 const now_a = vec3_sub(vec3_load(now, 1), vec3_load(now, 0));
    vec3 const now_b = vec3_sub(vec3_load(now, 2), vec3_load(now, 0));
    double const length = vec3_norm(rest_a);
    double const height = vec3_norm(vec3_cross(rest_a, rest_b)) / length;
    if (!(length > 0.0) || !(height > 0.0)) {
        stretches[0] = stretches[1] = (double)NAN;
        return;
    }
    /* Columns of F: images of the unit vectors along rest_a and across it. */
    double const along = vec3_dot(rest_a, rest_b) / length;
    vec3 const first = vec3_scale(now_a, 1.0 / length);
    vec3 const second = vec3_scale(vec3_add_scaled(now_b, first, -along), 1.0 / height);
    double const c11 = vec3_norm2(first), c22 = vec3_norm2(second);
    double const c12 = vec3_dot(first, second);
    double const mean = 0.5 * (c11 + c22);
    double const radius = hypot(0.5 * (c11 - c22), c12);
    stretches[0] = sqrt(mean + radius);
    /* The product of both is the ratio of the areas: exact where mean - radius would cancel. */
    stretches[1] = stretches[0] > 0.0 ? vec3_norm(vec3_cross(first, second)) / stretches[0] : 0.0;
}

void render_get_vertex_strains(tulle_mesh_view rest, const double *now, double *strains,
                               double *areas) {
    memset(strains, 0, rest.vertex_count * sizeof *strains);
    memset(areas, 0, rest.vertex_count * sizeof *areas);
    for (size_t t = 0; t < rest.triangle_count; t++) {
        const uint32_t *const corners = rest.triangles + 3 * t;
        double rest_corners[9], now_corners[9], stretches[2];
        for (size_t k = 0; k < 3; k++) {
            vec3_store(rest_corners, k, vec3_load(rest.positions, corners[k]));
            vec3_store(now_corners, k, vec3_load(now, corners[k]));
        }
        render_get_stretches(rest_corners, now_corners, stretches);
        if (isnan(stretches[0])) continue;
        double const most = stretches[0] - 1.0, least = stretches[1] - 1.0;
        double const strain = fabs(most) >= fabs(least) ? most : least;
        vec3 const origin = vec3_load(rest_corners, 0);
        double const area = vec3_norm(vec3_cross(vec3_sub(vec3_load(rest_corners, 1), origin),
                                                 vec3_sub(vec3_load(rest_corners, 2), origin)));
        for (size_t k = 0; k < 3; k++) {
            strains[corners[k]] += area * strain;
            areas[corners[k]] += area;
        }
    }
    for (size_t i = 0; i < rest.vertex_count; i++)
        if (areas[i] > 0.0) strains[i] /= areas[i];
}
