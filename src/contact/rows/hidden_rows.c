/* contact/rows/hidden_rows.c - see hidden_rows.h.
 *
 * The test of admissible rows knows only neighbours that share vertices. Where two boxes stand
 * flush, or each triangle has vertices of its own, the rim of the next triangle looks like a free
 * edge. Cloth that slides towards that rim at the contact distance is near the rim before it is
 * above it. The normal of such a row leans against the motion and would stop it. But the plane of
 * the row that carries the vertex already keeps it away from everything behind the plane. */
#include "contact/rows/hidden_rows.h"

#include "contact/rows/normal_cones.h"

#include <math.h>

/* A feature behind a plane may rise above it by this part of the vertex's distance: far more than
 * rounding, and hardly visible. */
static const double FLAT_SHARE = 0.1;
/* Part of that for a row of the step before. Hiding it lets the cloth sink by as much, and a
 * smaller gap then allows less. */
static const double OLD_SHARE = 0.5;

/* Vertices of the row's side of cloth or of a free body, and those of a scripted obstacle. */
typedef struct row_sides {
    int moved_begin, moved_end, obstacle_begin, obstacle_end;
} row_sides;

/* False for rows between two sides that move, or two that do not. */
static bool find_sides(const contact_scene *scene, const row_frame *frame, row_sides *sides) {
    bool is_moved[2]; /* of each side: of cloth or of a free body */
    for (int side = 0; side < 2; side++) {
        uint32_t const vertex = frame->vertices[3 * side];
        is_moved[side] =
            vertex < scene->cloth_vertex_count || find_body(scene, vertex) != TULLE_NONE;
    }
    int const middle = frame->kind == FEATURE_VERTEX_TRIANGLE ? 1 : 2;
    if (is_moved[0] == is_moved[1]) return false;
    *sides = is_moved[0] ? (row_sides){0, middle, middle, 4} : (row_sides){middle, 4, 0, middle};
    return true;
}

void make_near_plane(const contact_scene *scene, const double *ends, const contact_row *row,
                     near_plane *plane) {
    const row_frame *const frame = &row->frame;
    row_sides sides;
    plane->distance = 0.0;
    if (frame->kind != FEATURE_VERTEX_TRIANGLE || !find_sides(scene, frame, &sides)) return;
    if (sides.moved_begin != 0) return;
    vec3 points[4];
    for (int k = 0; k < 4; k++) points[k] = vec3_load(scene->x0, frame->vertices[k]);
    closest_points const closest = closest_of_pair(FEATURE_VERTEX_TRIANGLE, points);
    double const distance = sqrt(closest.distance2);
    if (!(distance > 0.0)) return;
    vec3 const normal = vec3_scale(closest.difference, 1.0 / distance);
    if (vec3_norm(vec3_sub(frame->normal, normal)) > scene->settings.slope_tolerance) return;
    vec3 const point = vec3_sub(points[0], closest.difference);
    *plane = (near_plane){.distance = distance, .normal = normal, .point = point, .end = point};
    for (int k = 1; k < 4; k++)
        plane->end =
            vec3_add_scaled(plane->end, vec3_sub(vec3_load(ends, frame->vertices[k]), points[k]),
                            -closest.weights[k]);
}

static bool lies_behind(const near_plane *plane, vec3 from, vec3 point, double slope,
                        double share) {
    vec3 const to = vec3_sub(point, from);
    double const least = fmin(slope * vec3_norm(to), share * plane->distance);
    return vec3_dot(plane->normal, to) <= least;
}

/* The planes of all vertices that the row pushes must be one plane. Then what spans two vertices is
 * as high over it as they are. Between two different planes it may hang over an edge. */
bool row_is_hidden(const contact_scene *scene, const double *ends, const near_planes *planes,
                   const contact_row *row, size_t index) {
    double const share = row->law.is_old ? OLD_SHARE * FLAT_SHARE : FLAT_SHARE;
    double const slope = scene->settings.slope_tolerance;
    const near_plane *first = NULL;
    row_sides sides;
    if (!planes->of_rows || !find_sides(scene, &row->frame, &sides)) return false;
    for (int k = sides.moved_begin; k < sides.moved_end; k++) {
        if (fabs(row->frame.weights[k]) < RIM_WEIGHT) continue;
        uint32_t const nearest = planes->nearest[row->frame.vertices[k]];
        if (nearest == TULLE_NONE || nearest == index) return false;
        const near_plane *const plane = &planes->of_rows[nearest];
        if (!first) first = plane;
        double const turn = vec3_norm(vec3_sub(plane->normal, first->normal));
        double const sag = turn * vec3_norm(vec3_sub(plane->point, first->point));
        if (!(turn <= slope && sag <= FLAT_SHARE * first->distance)) return false;
        /* the obstacle's feature must be behind the plane, at the start and at the predicted end */
        vec3 touched = {0.0, 0.0, 0.0};
        for (int j = sides.obstacle_begin; j < sides.obstacle_end; j++) {
            vec3 const start = vec3_load(scene->x0, row->frame.vertices[j]);
            vec3 const end = vec3_load(ends, row->frame.vertices[j]);
            if (!lies_behind(plane, plane->point, start, slope, share) ||
                !lies_behind(plane, plane->end, end, slope, share))
                return false;
            touched = vec3_add_scaled(touched, start, fabs(row->frame.weights[j]));
        }
        if (!lies_behind(plane, plane->point, touched, slope, share)) return false;
    }
    return first != NULL;
}
