/* contact/rows/hidden_rows.c - see hidden_rows.h.
 *
 * The normal cones of select_admissible know neighbours that share vertices. Where two boxes stand
 * flush, or each triangle has vertices of its own, the rim of the next triangle looks like a free
 * edge: what slides towards it at the contact distance is near it before it is above, with a normal
 * that leans against its way. But the plane of the row that carries it already keeps it away from
 * all that lies behind. */
#include "contact/rows/hidden_rows.h"

#include "contact/rows/normal_cones.h"

#include <math.h>

/* What is behind a plane may rise above it by this part of the distance that the plane keeps: far
 * over rounding, and hardly felt. */
static const double FLAT_SHARE = 0.1;
/* Part of that for a row of the step before: what hides it lets the cloth sink by as much, and the
 * share shrinks with the gap. */
static const double OLD_SHARE = 0.5;

/* Vertices of the row's side of cloth or of a free body, and those of a scripted obstacle. */
typedef struct row_sides {
    int moved_begin, moved_end, obstacle_begin, obstacle_end;
} row_sides;

static bool is_moved(const contact_scene *scene, uint32_t vertex) {
    return vertex < scene->cloth_vertex_count || find_body(scene, vertex) != TULLE_NONE;
}

/* False for rows between others. */
static bool find_sides(const contact_scene *scene, const contact_row *row, row_sides *sides) {
    bool const is_first = is_moved(scene, row->frame.vertices[0]);
    bool const is_second = is_moved(scene, row->frame.vertices[3]);
    int const middle = row->frame.kind == FEATURE_VERTEX_TRIANGLE ? 1 : 2;
    if (is_first == is_second) return false;
    *sides = is_first ? (row_sides){0, middle, middle, 4} : (row_sides){middle, 4, 0, middle};
    return true;
}

void find_near_plane(const contact_scene *scene, const double *ends, const contact_row *row,
                     near_plane *plane) {
    row_sides sides;
    plane->distance = 0.0;
    if (row->frame.kind != FEATURE_VERTEX_TRIANGLE || !find_sides(scene, row, &sides)) return;
    if (sides.moved_begin != 0) return;
    vec3 points[4];
    for (int k = 0; k < 4; k++) points[k] = vec3_load(scene->x0, row->frame.vertices[k]);
    closest_points const closest = closest_of_pair(FEATURE_VERTEX_TRIANGLE, points);
    double const distance = sqrt(closest.distance2);
    if (!(distance > 0.0)) return;
    vec3 const normal = vec3_scale(closest.difference, 1.0 / distance);
    if (vec3_norm(vec3_sub(row->frame.normal, normal)) > scene->settings.slope_tolerance) return;
    vec3 const point = vec3_sub(points[0], closest.difference);
    *plane = (near_plane){.distance = distance, .normal = normal, .point = point, .end = point};
    for (int k = 1; k < 4; k++)
        plane->end = vec3_add_scaled(plane->end,
                                     vec3_sub(vec3_load(ends, row->frame.vertices[k]), points[k]),
                                     -closest.weights[k]);
}

void note_near_plane(near_planes *planes, uint32_t vertex, size_t index) {
    double const distance = planes->of_rows[index].distance;
    uint32_t *const nearest = &planes->nearest[vertex];
    if (!(distance > 0.0)) return;
    if (*nearest == TULLE_NONE || planes->of_rows[*nearest].distance > distance)
        *nearest = (uint32_t)index;
}

static bool lies_behind(const near_plane *plane, vec3 from, vec3 point, double slope,
                        double share) {
    vec3 const to = vec3_sub(point, from);
    double const least = fmin(slope * vec3_norm(to), share * plane->distance);
    return vec3_dot(plane->normal, to) <= least;
}

/* Whether the obstacle's feature is behind the plane, where both are and where they go. */
static bool hides(const contact_scene *scene, const double *ends, const near_plane *plane,
                  const contact_row *row, const row_sides *sides) {
    double const share = row->law.is_old ? OLD_SHARE * FLAT_SHARE : FLAT_SHARE;
    double const slope = scene->settings.slope_tolerance;
    vec3 touched = {0.0, 0.0, 0.0};
    for (int k = sides->obstacle_begin; k < sides->obstacle_end; k++) {
        vec3 const start = vec3_load(scene->x0, row->frame.vertices[k]);
        vec3 const end = vec3_load(ends, row->frame.vertices[k]);
        if (!lies_behind(plane, plane->point, start, slope, share) ||
            !lies_behind(plane, plane->end, end, slope, share))
            return false;
        touched = vec3_add_scaled(touched, start, fabs(row->frame.weights[k]));
    }
    return lies_behind(plane, plane->point, touched, slope, share);
}

/* Whether what spans between two vertices stays as high over the planes as they do. */
static bool are_one_plane(const contact_scene *scene, const near_plane *a, const near_plane *b) {
    double const turn = vec3_norm(vec3_sub(b->normal, a->normal));
    double const sag = turn * vec3_norm(vec3_sub(b->point, a->point));
    return turn <= scene->settings.slope_tolerance && sag <= FLAT_SHARE * a->distance;
}

/* The planes of all vertices that the row pushes must agree: between two that do not, what spans
 * them may hang over an edge. */
bool row_is_hidden(const contact_scene *scene, const double *ends, const near_planes *planes,
                   const contact_row *row, size_t index) {
    const near_plane *first = NULL;
    row_sides sides;
    if (!find_sides(scene, row, &sides)) return false;
    for (int k = sides.moved_begin; k < sides.moved_end; k++) {
        if (fabs(row->frame.weights[k]) < RIM_WEIGHT) continue;
        uint32_t const nearest = planes->nearest[row->frame.vertices[k]];
        if (nearest == TULLE_NONE || nearest == index) return false;
        const near_plane *const plane = &planes->of_rows[nearest];
        if (!first) first = plane;
        if (!are_one_plane(scene, first, plane) || !hides(scene, ends, plane, row, &sides))
            return false;
    }
    return first != NULL;
}
