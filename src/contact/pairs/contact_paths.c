/* contact/pairs/contact_paths.c - paths and the contract of pair_source, see contact_paths.h. */
#include "contact/pairs/contact_paths.h"

#include "contact/pairs/body_paths.h"
#include "detect/impact/time_of_impact.h"

void propose_paths(const contact_scene *scene, const double *u, double *x1) {
    for (size_t vertex = 0; vertex < scene->vertex_count; vertex++) {
        if (is_slot(scene, vertex)) continue;
        bool const is_free = scene->inverse_mass[vertex] > 0.0;
        for (size_t i = 3 * vertex; i < 3 * vertex + 3; i++)
            x1[i] = is_free ? scene->x0[i] + scene->time_step * u[i] : scene->targets[i];
    }
    place_bodies(scene, u, 1.0, x1);
}

void prescribe_motion(const contact_scene *scene, double *u) {
    for (size_t vertex = 0; vertex < scene->vertex_count; vertex++) {
        if (scene->inverse_mass[vertex] > 0.0 || is_slot(scene, vertex)) continue;
        for (size_t i = 3 * vertex; i < 3 * vertex + 3; i++)
            u[i] = (scene->targets[i] - scene->x0[i]) / scene->time_step;
    }
}

bool paths_stay_in_bounds(const contact_scene *scene, const pair_source *source, const double *x1) {
    /* A triangle's path box, widened by half of what a test may call a hit, then lies in the box
     * that was searched. A millionth less covers the rounding of these sums. */
    double const hit = HIT_RESERVE * scene->settings.minimum_gap;
    double const reach = 0.5 * (source->margin - hit) * (1.0 - 1e-6);
    if (!(reach >= 0.0)) return false;
    const double *const first = source->is_straight ? source->bounds : scene->x0;
    size_t const cloth_count = scene->cloth_vertex_count;
    size_t const begins[2] = {0, get_solved_count(scene)}; /* without slots: their bodies' vertices
                                                              count */
    size_t const ends[2] = {cloth_count, scene->vertex_count};
    for (int part = 0; part < 2; part++)
        for (size_t v = begins[part]; v < ends[part]; v++) {
            bool is_inside = true;
            for (size_t i = 3 * v; i < 3 * v + 3; i++) {
                double const a = first[i], b = source->bounds[i];
                double const low = a < b ? a : b, high = a < b ? b : a;
                is_inside &= x1[i] >= low - reach && x1[i] <= high + reach;
            }
            if (!is_inside) return false;
        }
    return true;
}

tulle_status ensure_pairs_cover(const contact_scene *scene, pair_source *source, const double *x1) {
    if (paths_stay_in_bounds(scene, source, x1))
        return source->adapt ? source->adapt(source, x1) : TULLE_OK;
    if (stop_is_wanted(scene->stop, 0)) return TULLE_ERROR_INTERRUPTED;
    source->renew_count++;
    return source->renew(source, x1);
}
