/* contact/hidden_rows.c - see hidden_rows.h.
 *
 * The normal cones of select_admissible know neighbours that share vertices. Where two boxes stand
 * flush, or each triangle has vertices of its own, the rim of the next triangle looks like a free
 * edge: what slides towards it at the contact distance is near it before it is above, with a normal
 * that leans against its way. But the plane of the row that carries it already keeps it away from
 * all that lies behind. */
#include "contact/hidden_rows.h"

#include "contact/normal_cones.h"

#include <math.h>

/* What is behind a plane may rise above it by this part of the distance that the plane keeps: far
 * over rounding, and hardly felt. */
static const double FLAT_SHARE = 0.1;

/* The plane of the nearest obstacle to a vertex of cloth or of a free body. */
typedef struct near_plane {
    double distance; /* [m] of the vertex from it; 0: there is none */
    size_t row;      /* that keeps the vertex above it */
    vec3 normal;     /* unit, towards the vertex */
    vec3 point;      /* [m] nearest to the vertex now ... */
    vec3 end;        /* [m] ... and where the obstacle takes it */
} near_plane;

/* The row's side of cloth or of a free body, where the other one is a scripted obstacle. */
typedef struct row_sides {
    int moved_begin, moved_end, obstacle_begin, obstacle_end;
} row_sides;

static bool is_moved(const contact_scene *scene, uint32_t vertex) {
    return vertex < scene->cloth_vertex_count || find_body(scene, vertex) != TULLE_NONE;
}

/* False for other rows. */
static bool find_sides(const contact_scene *scene, const contact_row *row, row_sides *sides) {
    bool const is_first = is_moved(scene, row->vertices[0]);
    bool const is_second = is_moved(scene, row->vertices[3]);
    int const middle = row->kind == FEATURE_VERTEX_TRIANGLE ? 1 : 2;
    if (is_first == is_second) return false;
    *sides = is_first ? (row_sides){0, middle, middle, 4} : (row_sides){middle, 4, 0, middle};
    return true;
}

static void find_near_planes(const contact_scene *scene, const double *ends,
                             const chosen_rows *chosen, near_plane *planes) {
    for (size_t i = 0; i < chosen->count; i++) {
        const pair_event *const event = &chosen->events[i];
        const contact_row *const row = &chosen->rows[i];
        if (event->kind != FEATURE_VERTEX_TRIANGLE) break;
        row_sides sides;
        if (!chosen->is_kept[i] || event->time > 0.0 || !find_sides(scene, row, &sides)) continue;
        if (sides.moved_begin != 0) continue;
        vec3 points[4];
        for (int k = 0; k < 4; k++) points[k] = vec3_load(scene->x0, row->vertices[k]);
        closest_points const closest = closest_of_pair(FEATURE_VERTEX_TRIANGLE, points);
        double const distance = sqrt(closest.distance2);
        near_plane *const plane = &planes[row->vertices[0]];
        if (!(distance > 0.0) || (plane->distance > 0.0 && plane->distance <= distance)) continue;
        plane->distance = distance;
        plane->row = i;
        plane->normal = vec3_scale(closest.difference, 1.0 / distance);
        plane->point = plane->end = vec3_sub(points[0], closest.difference);
        for (int k = 1; k < 4; k++)
            plane->end =
                vec3_add_scaled(plane->end, vec3_sub(vec3_load(ends, row->vertices[k]), points[k]),
                                -closest.weights[k]);
    }
}

static bool lies_behind(const contact_scene *scene, const near_plane *plane, vec3 from,
                        vec3 point) {
    vec3 const to = vec3_sub(point, from);
    double const slope = scene->settings.slope_tolerance * vec3_norm(to);
    return vec3_dot(plane->normal, to) <= fmin(slope, FLAT_SHARE * plane->distance);
}

/* Whether the obstacle's feature is behind the plane, where both are and where they go. */
static bool hides(const contact_scene *scene, const double *ends, const near_plane *plane,
                  const contact_row *row, const row_sides *sides) {
    vec3 touched = {0.0, 0.0, 0.0};
    for (int k = sides->obstacle_begin; k < sides->obstacle_end; k++) {
        vec3 const start = vec3_load(scene->x0, row->vertices[k]);
        if (!lies_behind(scene, plane, plane->point, start) ||
            !lies_behind(scene, plane, plane->end, vec3_load(ends, row->vertices[k])))
            return false;
        touched = vec3_add_scaled(touched, start, fabs(row->weights[k]));
    }
    return lies_behind(scene, plane, plane->point, touched);
}

/* Whether what spans between two vertices stays as high over the planes as they do. */
static bool are_one_plane(const contact_scene *scene, const near_plane *a, const near_plane *b) {
    double const turn = vec3_norm(vec3_sub(b->normal, a->normal));
    double const sag = turn * vec3_norm(vec3_sub(b->point, a->point));
    return turn <= scene->settings.slope_tolerance && sag <= FLAT_SHARE * a->distance;
}

/* The planes of all vertices that the row pushes must agree: between two that do not, what spans
 * them may hang over an edge. */
static bool is_hidden_row(const contact_scene *scene, const double *ends, const near_plane *planes,
                          const contact_row *rows, size_t i) {
    const contact_row *const row = &rows[i];
    const near_plane *first = NULL;
    row_sides sides;
    if (!find_sides(scene, row, &sides)) return false;
    for (int k = sides.moved_begin; k < sides.moved_end; k++) {
        if (fabs(row->weights[k]) < RIM_WEIGHT) continue;
        const near_plane *const plane = &planes[row->vertices[k]];
        if (!first) first = plane;
        if (!(plane->distance > 0.0) || plane->row == i || !are_one_plane(scene, first, plane) ||
            !hides(scene, ends, plane, row, &sides))
            return false;
    }
    return first != NULL;
}

tulle_status mark_hidden_rows(const contact_scene *scene, const double *ends,
                              const chosen_rows *chosen, bool *is_hidden) {
    arena_mark const mark = arena_get_mark(scene->scratch);
    near_plane *const planes = ARENA_NEW_ZEROED(scene->scratch, near_plane, scene->vertex_count);
    if (!planes) return TULLE_ERROR_OUT_OF_MEMORY;
    find_near_planes(scene, ends, chosen, planes);
    for (size_t i = 0; i < chosen->count; i++)
        if (chosen->is_kept[i]) is_hidden[i] = is_hidden_row(scene, ends, planes, chosen->rows, i);
    arena_release(scene->scratch, mark);
    return TULLE_OK;
}
