/* contact/solve/missed_friction.c - what friction on obstacles missed in the last round goes to the
 * cloths that it acts on, see end_round.h.
 *
 * A round knows friction only as the round before left it. What it misses on obstacles has the same
 * direction in every step of a cloth that slides, so without more rounds the cloth slides too fast.
 * As a change of the cloth's momentum it costs nothing: with the mass M of the cloth, and K of the
 * rows that hold it, all of it goes by  (M + sum K)^-1 missed.  Cloth that slides on a plane gets
 * all that is missing. Cloth that sticks, or lies around a body, hardly moves, as it should: a push
 * on it is borne by what holds it.
 *
 * Between cloths, and between cloth and bodies, nothing is given: both sides would have to answer
 * for momentum to be kept. Nor is anything given to cloth in several pieces, which move apart.
 * There rounds go on until little is missing. What lies on another cloth is held by it as if that
 * stood still. */
#include "contact/rows/row_motion.h"
#include "contact/solve/end_round.h"
#include "contact/solve/hard_rows.h"

#include <math.h>

/* x of A x = b for a symmetric positive matrix, by its factors L D L^T: A's numbers may differ by
 * ten powers of ten, which cofactors would not bear. */
static vec3 solve_positive(const mat3 *a, vec3 b) {
    double const d0 = a->m[0], l10 = a->m[1] / d0, l20 = a->m[2] / d0;
    double const d1 = a->m[4] - l10 * a->m[1];
    double const l21 = (a->m[5] - l20 * a->m[1]) / d1;
    double const d2 = a->m[8] - l20 * a->m[2] - l21 * l21 * d1;
    double const y1 = b.y - l10 * b.x;
    double const z = (b.z - l20 * b.x - l21 * y1) / d2;
    double const y = y1 / d1 - l21 * z;
    return vec3_make(b.x / d0 - l10 * y - l20 * z, y, z);
}

/* Adds the penalties of a row to what holds the cloths that it touches. */
static void add_hold(const contact_scene *scene, const contact_row *row, friction_sums *sums) {
    mat3 const pull = get_pull(row);
    const uint32_t *const vertices = row->frame.vertices;
    for (int k = 0; k < 4; k++) {
        if (vertices[k] >= scene->cloth_vertex_count) continue;
        uint32_t const surface = scene->vertex_surface[vertices[k]];
        double weight = 0.0; /* of all vertices on this surface; the first of them adds it */
        bool is_first = true;
        for (int i = 0; i < 4; i++) {
            if (vertices[i] >= scene->cloth_vertex_count) continue;
            if (scene->vertex_surface[vertices[i]] != surface) continue;
            is_first &= i >= k;
            weight += row->frame.weights[i];
        }
        if (is_first) mat3_add_scaled(&sums[surface].held_by, &pull, weight * weight);
    }
}

void give_missed_friction(const contact_scene *scene, const row_list *list, friction_sums *sums,
                          double *u) {
    for (size_t s = 0; s < scene->set->surface_count; s++) sums[s].held_by = mat3_identity(0.0);
    for (size_t i = 0; i < list->rows.count; i++) {
        const contact_row *const row = &list->rows.data[i];
        if (row->solve.is_in_matrix && get_normal_impulse(row) > 0.0) add_hold(scene, row, sums);
    }
    for (size_t s = 0; s < scene->set->surface_count; s++) {
        const surface_range *const range = &scene->set->surfaces[s];
        if (!(vec3_norm2(sums[s].missed) > 0.0)) continue;
        double mass = 0.0;
        for (uint32_t v = range->vertex_begin; v < range->vertex_end; v++)
            mass += 1.0 / scene->inverse_mass[v];
        if (!isfinite(mass)) continue;
        mat3 const inertia = mat3_identity(mass);
        mat3_add_scaled(&sums[s].held_by, &inertia, 1.0);
        vec3 const gain = solve_positive(&sums[s].held_by, sums[s].missed);
        if (!isfinite(vec3_norm(gain))) continue; /* beyond rounding: what holds it, holds it */
        for (uint32_t v = range->vertex_begin; v < range->vertex_end; v++)
            vec3_store(u, v, vec3_add(vec3_load(u, v), gain));
    }
}
