/* scene/choose_vertices.c - the vertices of a cloth that a pin or a region names: in a box, along a
 * line, nearest to a point, by their numbers. */
#include "scene/scene_data.h"

#include <math.h>

static bool is_in_box(const box_keys *box, const double *p) {
    for (int k = 0; k < 3; k++)
        if (p[k] < box->min.value[k] || p[k] > box->max.value[k]) return false;
    return true;
}

static double distance_to_segment(const double a[3], const double b[3], const double p[3]) {
    double along = 0, length = 0, squared = 0;
    for (int k = 0; k < 3; k++) {
        along += (p[k] - a[k]) * (b[k] - a[k]);
        length += (b[k] - a[k]) * (b[k] - a[k]);
    }
    double t = length > 0 ? fmin(fmax(along / length, 0), 1) : 0;
    for (int k = 0; k < 3; k++) {
        double d = p[k] - a[k] - t * (b[k] - a[k]);
        squared += d * d;
    }
    return sqrt(squared);
}

static size_t find_nearest(const tulle_mesh *mesh, const double point[3]) {
    size_t nearest = 0;
    double smallest = INFINITY;
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        double distance = distance_to_segment(point, point, mesh->positions + 3 * v);
        if (distance < smallest) smallest = distance, nearest = v;
    }
    return nearest;
}

static bool mark_numbers(const scene_work *work, const tulle_mesh *mesh,
                         const vertex_choice *choice, unsigned char mark, unsigned char *marks) {
    const schema_indices *const numbers = choice->vertices;
    for (size_t i = 0; i < numbers->count; i++) {
        if (numbers->value[i] < mesh->vertex_count) {
            marks[numbers->value[i]] |= mark;
            continue;
        }
        const schema_head *const head = choice->keys;
        problem_add(work->problems, TULLE_ERROR_INVALID_ARGUMENT,
                    schema_place(choice->keys, "vertices"),
                    "%s.vertices: names vertex %u, must be below %zu, the cloth's number of "
                    "vertices",
                    head->path, (unsigned)numbers->value[i], mesh->vertex_count);
        return false;
    }
    return true;
}

bool choose_vertices(const scene_work *work, const tulle_mesh *mesh, const vertex_choice *choice,
                     unsigned char mark, unsigned char *marks) {
    if (schema_is_given(choice->map, choice->keys, "vertices"))
        return mark_numbers(work, mesh, choice, mark, marks);
    if (choice->nearest && schema_is_given(choice->map, choice->keys, "nearest")) {
        marks[find_nearest(mesh, choice->nearest->value)] |= mark;
        return true;
    }
    bool const is_box = schema_is_given(choice->map, choice->keys, "box");
    const line_keys *const line = choice->line;
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        const double *const p = mesh->positions + 3 * v;
        bool const is_in =
            is_box ? is_in_box(choice->box, p)
                   : distance_to_segment(line->from.value, line->to.value, p) <= line->radius;
        if (is_in) marks[v] |= mark;
    }
    return true;
}

bool refuse_empty_choice(const scene_work *work, const tulle_mesh *mesh, const schema_head *head,
                         const char *problem) {
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (size_t i = 0; i < 3 * mesh->vertex_count; i++) {
        low[i % 3] = fmin(low[i % 3], mesh->positions[i]);
        high[i % 3] = fmax(high[i % 3], mesh->positions[i]);
    }
    problem_add(work->problems, TULLE_ERROR_INVALID_ARGUMENT, head->place,
                "%s: %s; the cloth begins within [%g, %g, %g] and [%g, %g, %g]", head->path,
                problem, low[0], low[1], low[2], high[0], high[1], high[2]);
    return false;
}
