/* dynamics/kernels/wind_kernel.c - the drag of the wind on eight triangles at a time, as
 * wind_evaluate says. */
#include "dynamics/wind_kernel.h"
#include "math/vertex_lanes.h"

SIMD_INLINE void store_rows(vec3x8 a, size_t count, vec3 *to) {
    lanes4 rows[DOUBLE_LANES];
    lanes4_turn_back(a.x, a.y, a.z, a.z, rows);
    for (size_t k = 0; k < count; k++) lanes4_store3(&to[k].x, rows[k]);
}

void TULLE_KERNEL(fill_triangle_wind)(void *context, size_t begin, size_t end, size_t chunk,
                                      int worker) {
    (void)chunk, (void)worker;
    const assembly *const work = context;
    size_t const vertices = work->model->vertex_count;
    lane_source const positions = lane_source_make(work->state->positions, vertices);
    lane_source const velocities = lane_source_make(work->state->velocities, vertices);
    lane_source const starts = lane_source_make(work->start_velocities, vertices);
    const vec3 *const air = work->terms.air_velocities;
    double8 const zero = double8_fill(0.0), one = double8_fill(1.0);
    double8 const third = double8_fill(1.0 / 3.0);
    for (; begin < end; begin += DOUBLE_LANES) {
        size_t const count = end - begin < DOUBLE_LANES ? end - begin : DOUBLE_LANES;
        lanes4 edges[2][DOUBLE_LANES], relatives[DOUBLE_LANES], sums[DOUBLE_LANES];
        for (size_t k = 0; k < DOUBLE_LANES; k++) {
            const uint32_t *const corners =
                work->model->surface->triangles + 3 * (begin + (k < count ? k : count - 1));
            lanes4 const origin = lanes4_get(&positions, corners[0]);
            lanes4 relative = {0.0, 0.0, 0.0, 0.0}, sum = relative;
            for (int i = 0; i < 3; i++) {
                relative += lanes4_get(&velocities, corners[i]) - lanes4_load(&air[corners[i]].x);
                sum += lanes4_get(&starts, corners[i]);
            }
            for (int i = 0; i < 2; i++)
                edges[i][k] = lanes4_get(&positions, corners[1 + i]) - origin;
            relatives[k] = relative;
            sums[k] = sum;
        }
        vec3x8 const cross = vec3x8_cross(lanes4_turn3(edges[0]), lanes4_turn3(edges[1]));
        vec3x8 const w = vec3x8_scale(lanes4_turn3(relatives), third);
        double8 const double_area = double8_sqrt(vec3x8_dot(cross, cross));
        bool8 const has_area = double8_greater(double_area, zero);
        double8 const inverse =
            double8_select(has_area, one / double8_select(has_area, double_area, one), zero);
        vec3x8 const n = vec3x8_scale(cross, inverse);
        double8 const speed = double8_sqrt(vec3x8_dot(w, w)), through = vec3x8_dot(n, w);
        bool8 const is_moving = double8_greater(speed, zero);
        double8 const scale =
            double8_fill(work->surroundings->wind.drag_coefficient) * (0.5 * double_area);
        double8 const pull = double8_select(is_moving, -scale * speed * through, zero);
        double8 const rate = through * through / double8_select(is_moving, speed, one);
        double8 const drag = double8_select(is_moving, scale * (speed + rate), zero);
        vec3x8 const force = vec3x8_scale(vec3x8_scale(n, pull), third);
        vec3x8 const g = vec3x8_scale(n, third * double8_sqrt(drag));
        vec3x8 const source = vec3x8_add_scaled(force, g, vec3x8_dot(g, lanes4_turn3(sums)));
        store_rows(force, count, work->triangle_forces + begin);
        store_rows(g, count, work->terms.triangle_drags + begin);
        store_rows(source, count, work->terms.triangle_sources + begin);
    }
}
