/* contact/rows/admissible_rows.c - see admissible_rows.h.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 3.5 (admissible feature pairs). Departure: the condition is an angle with a
 * tolerance instead of a sign, so that the edges inside a flat mesh neither stop a slider nor come
 * and go with rounding. */
#include "contact/rows/admissible_rows.h"

#include "contact/rows/normal_cones.h"

/* The inside of a triangle replaces a rim though it is further away by this part of the gap: as
 * large as the slope tolerance. */
static const double RIM_GAP_TOLERANCE = 0.02;

/* Inside a narrow fold both features hang on one vertex, and the fold is the narrower the nearer to
 * that vertex. The vertex does not speak against the pair: no other pair would hold the fold open.
 */
static bool joins_both_features(const topology *topo, uint32_t vertex, const uint32_t *others,
                                int other_count) {
    const adjacency *const around = &topo->vertex_neighbours;
    for (int k = 0; k < other_count; k++) {
        if (vertex == others[k]) return true;
        for (uint32_t i = around->begin[vertex]; i < around->begin[vertex + 1]; i++)
            if (around->items[i] == others[k]) return true;
    }
    return false;
}

bool is_on_rim(const double weights[4]) {
    for (int k = 0; k < 4; k++)
        if (fabs(weights[k]) < RIM_WEIGHT) return true;
    return false;
}

void test_admissible(const contact_scene *scene, const double *x1, const contact_row *row,
                     double time, const double slope_tolerances[2], bool is_within[2]) {
    const row_frame *const frame = &row->frame;
    const topology *const topo = scene->set->topo;
    bool const is_edge_row = frame->kind == FEATURE_EDGE_EDGE;
    bool const is_one_surface =
        scene->vertex_surface[frame->vertices[0]] == scene->vertex_surface[frame->vertices[3]];
    int const split = is_edge_row ? 2 : 1;
    for (int side = 0; side < 2 && (is_within[0] || is_within[1]); side++) {
        int const begin = side == 0 ? 0 : split, end = side == 0 ? split : 4;
        /* from the side's surface towards the other body, and vertices of the other feature, none
         * when it is of another surface */
        vec3 const outward = side == 0 ? vec3_neg(frame->normal) : frame->normal;
        const uint32_t *const others = frame->vertices + (side == 0 ? split : 0);
        int const other_count = is_one_surface ? 4 - (end - begin) : 0;

        /* the feature on this side, the point of contact on it, and its neighbours */
        rim_part part = is_edge_row ? RIM_EDGE : RIM_VERTEX;
        uint32_t feature = side == 0 ? frame->pair.first : frame->pair.second;
        if (!is_edge_row && side == 1) part = find_rim_part(topo, row, &feature);
        if (part == RIM_INSIDE) continue;
        bool const is_vertex = part == RIM_VERTEX;
        const adjacency *const around = &topo->vertex_neighbours;
        const uint32_t *const neighbours = is_vertex ? around->items + around->begin[feature]
                                                     : topo->edge_opposites + 2 * (size_t)feature;
        size_t const neighbour_count =
            is_vertex ? around->begin[feature + 1] - around->begin[feature] : 2;
        vec3 point = {0.0, 0.0, 0.0};
        if (is_vertex)
            point = vec3_lerp(vec3_load(scene->x0, feature), vec3_load(x1, feature), time);
        for (int k = begin; k < end && !is_vertex; k++) {
            uint32_t const v = frame->vertices[k];
            vec3 const at = vec3_lerp(vec3_load(scene->x0, v), vec3_load(x1, v), time);
            point = vec3_add_scaled(point, at, fabs(frame->weights[k]));
        }

        /* until both tolerances have failed */
        for (size_t i = 0; i < neighbour_count && (is_within[0] || is_within[1]); i++) {
            uint32_t const v = neighbours[i];
            if (v == TULLE_NONE) continue; /* an edge of a border has one opposite vertex */
            vec3 const at = vec3_lerp(vec3_load(scene->x0, v), vec3_load(x1, v), time);
            vec3 const to = vec3_sub(at, point);
            double const height = vec3_dot(outward, to);
            if (height <= 0.0) continue;
            double const length = vec3_norm(to);
            bool const is_behind[2] = {height <= slope_tolerances[0] * length,
                                       height <= slope_tolerances[1] * length};
            if ((is_behind[0] || !is_within[0]) && (is_behind[1] || !is_within[1])) continue;
            if (joins_both_features(topo, v, others, other_count)) continue;
            is_within[0] &= is_behind[0];
            is_within[1] &= is_behind[1];
        }
    }
}

/* What a row touches, if it is kept and touches a rim; part RIM_INSIDE for the others. */
typedef struct rim_label {
    rim_part part;
    uint32_t feature;
    bool is_kept;
} rim_label;

/* Whether another row makes row i, of a vertex and a rim, needless. Rows are those of vertices. */
static bool is_redundant(contact_row *const *rows, const rim_label *labels, size_t count,
                         size_t i) {
    uint32_t const vertex = rows[i]->frame.pair.first, touched = labels[i].feature;
    if (labels[i].part == RIM_INSIDE) return false;
    /* Another row of the vertex touches the same, or the vertex is nearer to the inside of a
     * triangle next to it. Frames of later times tilt a little, which shortens the gap by as much.
     */
    double const own = rows[i]->frame.gap, gap = own + RIM_GAP_TOLERANCE * fabs(own);
    size_t first = i;
    while (first > 0 && rows[first - 1]->frame.pair.first == vertex) first--;
    for (size_t j = first; j < count && rows[j]->frame.pair.first == vertex; j++) {
        bool const is_same = labels[j].part == labels[i].part && labels[j].feature == touched;
        if (is_same && j < i) return true;
        if (!labels[j].is_kept || labels[j].part != RIM_INSIDE || !(rows[j]->frame.gap <= gap))
            continue;
        for (int k = 1; k < 4; k++)
            for (int l = 1; l < 4; l++)
                if (rows[i]->frame.vertices[k] == rows[j]->frame.vertices[l]) return true;
    }
    /* Two vertices are nearest to each other: the row of the smaller one stays. Its rows are looked
     * up by bisection. */
    if (labels[i].part != RIM_VERTEX || touched >= vertex) return false;
    size_t low = 0, high = count;
    while (low < high) {
        size_t const middle = low + (high - low) / 2;
        if (rows[middle]->frame.pair.first < touched)
            low = middle + 1;
        else
            high = middle;
    }
    for (; low < count && rows[low]->frame.pair.first == touched; low++)
        if (labels[low].part == RIM_VERTEX && labels[low].feature == vertex) return true;
    return false;
}

tulle_status thin_rim_rows(const contact_scene *scene, contact_row *const *rows, uint8_t *choices,
                           size_t count) {
    size_t vertex_row_count = 0;
    while (vertex_row_count < count &&
           rows[vertex_row_count]->frame.kind == FEATURE_VERTEX_TRIANGLE)
        vertex_row_count++;
    arena_mark const mark = arena_get_mark(scene->scratch);
    rim_label *const labels = ARENA_NEW(scene->scratch, rim_label, vertex_row_count);
    for (size_t i = 0; i < vertex_row_count && labels; i++) {
        labels[i] = (rim_label){.part = RIM_INSIDE, .is_kept = choices[i] == ROW_KEPT};
        if (labels[i].is_kept)
            labels[i].part = find_rim_part(scene->set->topo, rows[i], &labels[i].feature);
    }
    for (size_t i = 0; i < vertex_row_count && labels; i++)
        if (is_redundant(rows, labels, vertex_row_count, i)) choices[i] = ROW_DROPPED;
    arena_release(scene->scratch, mark);
    return labels ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
}
