/* dynamics/wind.h - the wind at a place, and its drag on one triangle. */
#ifndef TULLE_DYNAMICS_WIND_H
#define TULLE_DYNAMICS_WIND_H

#include "dynamics/cloth_model.h"

/* Remembers the lattice values around the last place asked for; zeroed before first use. */
typedef struct gust_cell {
    bool is_filled;
    int64_t corner[4]; /* x, y, z, time */
    double values[16][3];
} gust_cell;

/* Wind velocity [m/s] at a place and time: the mean plus gusts. A pure function of its arguments
 * but `cell`, which only saves time. */
vec3 wind_compute_velocity(const tulle_wind *wind, vec3 place, double time, gust_cell *cell);

typedef struct wind_response {
    vec3 force;  /* [N] on the whole triangle */
    double drag; /* [N s/m] the symmetric, positive part of -df/dw is drag n n^T */
    vec3 normal;
} wind_response;

/* Drag on a triangle with the given corners whose velocity relative to the air is w:
 * -k_f A |w| (n . w) n. */
static inline wind_response wind_evaluate(double drag_coefficient, const vec3 corners[3],
                                          vec3 relative_velocity) {
    vec3 const w = relative_velocity;
    vec3 const cross =
        vec3_cross(vec3_sub(corners[1], corners[0]), vec3_sub(corners[2], corners[0]));
    double const double_area = vec3_norm(cross), area = 0.5 * double_area;
    vec3 const n = double_area > 0.0 ? vec3_scale(cross, 1.0 / double_area) : (vec3){0.0, 0.0, 0.0};
    double const speed = vec3_norm(w), through = vec3_dot(n, w);
    if (!(speed > 0.0)) return (wind_response){.normal = n};
    double const scale = drag_coefficient * area;
    /* -df/dw = k A (|w| n n^T + (n . w) n w^T / |w|). The second term is not symmetric; of its w
     * only the part along n is kept, which leaves a positive semi-definite matrix that is exact for
     * changes of velocity along the normal. */
    return (wind_response){.force = vec3_scale(n, -scale * speed * through),
                           .drag = scale * (speed + through * through / speed),
                           .normal = n};
}

#endif
