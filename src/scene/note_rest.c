/* scene/note_rest.c - what is allowed in a rest shape and is seldom meant: triangles of quite
 * another size than at the start, needles, and patterns that fold over. */
#include "scene/rest_shape.h"

#include <math.h>
#include <stdlib.h>

/* A triangle may be so many times longer at rest than at the start, or shorter, without a note. */
static const double ODD_LENGTH_RATIO = 2.0;
/* A triangle is a needle where its height is this part of its longest side, and was none before. */
static const double NEEDLE_HEIGHT = 0.01;

static double measure_height_ratio(edge_pair edges) {
    vec3 const third = vec3_sub(edges.second, edges.first);
    double const first = vec3_norm2(edges.first), second = vec3_norm2(edges.second);
    return measure_double_area(edges) / fmax(fmax(first, second), vec3_norm2(third));
}

static void note_odd_triangles(const rest_work *work, const rest_keys *keys) {
    size_t odd_count = 0, needle_count = 0, oddest = 0, needle = 0;
    double most = 0.0, odd_ratio = 1.0;
    for (size_t t = 0; t < work->cloth->mesh.triangle_count; t++) {
        edge_pair const start = get_start(work, t), rest = get_rest(work, t);
        double const ratio = sqrt(measure_double_area(rest) / measure_double_area(start));
        double const size = fmax(ratio, 1.0 / ratio);
        if (size > ODD_LENGTH_RATIO) odd_count++;
        if (size > most) most = size, oddest = t, odd_ratio = ratio;
        if (measure_height_ratio(rest) >= NEEDLE_HEIGHT ||
            measure_height_ratio(start) < NEEDLE_HEIGHT)
            continue;
        if (needle_count++ == 0) needle = t;
    }
    const char *const path = keys->head.path;
    const char *const odd_name = odd_count > 0 ? name_triangle(work, oddest) : NULL;
    const char *const needle_name = needle_count > 0 ? name_triangle(work, needle) : NULL;
    if (odd_name)
        note_add(work->scene,
                 "%s: %zu of %zu triangles are more than %g times as long at rest as at the start, "
                 "or as short; most of all %s, %.3g times as long",
                 path, odd_count, work->cloth->mesh.triangle_count, ODD_LENGTH_RATIO, odd_name,
                 odd_ratio);
    if (needle_name)
        note_add(work->scene, "%s: %zu triangles are needles at rest and none at the start, as %s",
                 path, needle_count, needle_name);
}

/* ---- patterns that fold over ---- */

/* A side of a triangle; `place` is 3 * triangle + its first corner. */
typedef struct triangle_side {
    uint32_t low, high, place;
} triangle_side;

static int compare_sides(const void *left, const void *right) {
    const triangle_side *const a = left, *const b = right;
    if (a->low != b->low) return a->low < b->low ? -1 : 1;
    if (a->high != b->high) return a->high < b->high ? -1 : 1;
    return (a->place > b->place) - (a->place < b->place);
}

static size_t get_next_corner(size_t place) { return place % 3 == 2 ? place - 2 : place + 1; }

static bool has_same_uv(const rest_work *work, size_t a, size_t b) {
    const double *const uv = work->corner_uvs;
    return uv[2 * a] == uv[2 * b] && uv[2 * a + 1] == uv[2 * b + 1];
}

/* Both sides are one line of the pattern, and both triangles lie to the same hand of it. */
static bool is_folded(const rest_work *work, const triangle_side *a, const triangle_side *b) {
    if (a->low != b->low || a->high != b->high) return false;
    size_t const a_end = get_next_corner(a->place), b_end = get_next_corner(b->place);
    if (!has_same_uv(work, a->place, b_end) || !has_same_uv(work, a_end, b->place)) return false;
    edge_pair const first = get_texture(work, a->place / 3);
    edge_pair const second = get_texture(work, b->place / 3);
    return vec3_cross(first.first, first.second).z * vec3_cross(second.first, second.second).z <
           0.0;
}

static bool note_folds(const rest_work *work, const rest_keys *keys) {
    const tulle_mesh *const mesh = &work->cloth->mesh;
    size_t const count = 3 * mesh->triangle_count;
    memory *const heap = &work->scene->scene->heap;
    triangle_side *const sides = memory_allocate(heap, count * sizeof *sides);
    if (!sides) {
        problem_add_memory(work->scene->problems, work->scene->scene->path);
        return false;
    }
    for (size_t i = 0; i < count; i++) {
        uint32_t const a = mesh->triangles[i], b = mesh->triangles[get_next_corner(i)];
        sides[i] = (triangle_side){a < b ? a : b, a < b ? b : a, (uint32_t)i};
    }
    qsort(sides, count, sizeof *sides, compare_sides);
    size_t fold_count = 0, first = 0;
    for (size_t i = 0; i + 1 < count; i++)
        if (is_folded(work, &sides[i], &sides[i + 1]) && fold_count++ == 0) first = i;
    if (fold_count > 0) {
        const char *const one = name_triangle(work, sides[first].place / 3);
        const char *const other = name_triangle(work, sides[first + 1].place / 3);
        if (one && other)
            note_add(work->scene,
                     "%s: the pattern folds over at %zu edges, as between %s and %s; that is meant "
                     "where mirrored halves share texture coordinates",
                     keys->head.path, fold_count, one, other);
    }
    memory_release(heap, sides, count * sizeof *sides);
    return true;
}

bool note_odd_rest(const rest_work *work, const rest_keys *keys) {
    note_odd_triangles(work, keys);
    return !schema_is_given(&rest_map, keys, "uv") || note_folds(work, keys);
}
