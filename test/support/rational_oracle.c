/* test/support/rational_oracle.c - see rational_oracle.h. Not thread-safe: the rationals are
 * initialised once and kept. */
#include "support/rational_oracle.h"

#include <gmp.h>
#include <string.h>

enum { POINT_LIMIT = 32 };
typedef struct polygon {
    mpq_t points[POINT_LIMIT][3];
    int count;
} polygon;

static polygon current, clipped, saved;
static mpq_t corner[3][3], edge[3][3], triangle_normal[3], side_normal[3];
static mpq_t value[POINT_LIMIT], t, s;
static bool is_ready;

static void prepare(void) {
    if (is_ready) return;
    for (int i = 0; i < POINT_LIMIT; i++) {
        mpq_init(value[i]);
        for (int c = 0; c < 3; c++)
            mpq_inits(current.points[i][c], clipped.points[i][c], saved.points[i][c], NULL);
    }
    for (int c = 0; c < 3; c++) {
        mpq_inits(triangle_normal[c], side_normal[c], NULL);
        for (int i = 0; i < 3; i++) mpq_inits(corner[i][c], edge[i][c], NULL);
    }
    mpq_inits(t, s, NULL);
    is_ready = true;
}

/* Keeps the part of the polygon where sign * normal . (x - origin) >= 0. */
static void clip(mpq_t normal[3], mpq_t origin[3], int sign) {
    polygon *const in = &current, *const out = &clipped;
    for (int i = 0; i < in->count; i++) {
        mpq_set_ui(value[i], 0, 1);
        for (int c = 0; c < 3; c++) {
            mpq_sub(t, in->points[i][c], origin[c]);
            mpq_mul(t, t, normal[c]);
            mpq_add(value[i], value[i], t);
        }
        if (sign < 0) mpq_neg(value[i], value[i]);
    }
    out->count = 0;
    for (int i = 0; i < in->count; i++) {
        int const j = (i + 1) % in->count;
        int const here = mpq_sgn(value[i]), next = mpq_sgn(value[j]);
        if (here >= 0) {
            for (int c = 0; c < 3; c++) mpq_set(out->points[out->count][c], in->points[i][c]);
            out->count++;
        }
        if (here * next < 0) { /* x = p + (q - p) value_p / (value_p - value_q) */
            mpq_sub(s, value[i], value[j]);
            mpq_div(s, value[i], s);
            for (int c = 0; c < 3; c++) {
                mpq_sub(t, in->points[j][c], in->points[i][c]);
                mpq_mul(t, t, s);
                mpq_add(out->points[out->count][c], in->points[i][c], t);
            }
            out->count++;
        }
    }
    in->count = out->count;
    for (int i = 0; i < out->count; i++)
        for (int c = 0; c < 3; c++) mpq_swap(in->points[i][c], out->points[i][c]);
}

static void cross(mpq_t result[3], mpq_t a[3], mpq_t b[3]) {
    for (int c = 0; c < 3; c++) {
        int const d = (c + 1) % 3, e = (c + 2) % 3;
        mpq_mul(t, a[d], b[e]);
        mpq_mul(s, a[e], b[d]);
        mpq_sub(result[c], t, s);
    }
}

static bool is_zero(mpq_t a[3]) {
    return mpq_sgn(a[0]) == 0 && mpq_sgn(a[1]) == 0 && mpq_sgn(a[2]) == 0;
}

/* Clips by the hull of p and q: by the planes through the segment along each axis, and at its
 * ends. p = q leaves the point. */
static void clip_by_segment(mpq_t p[3], mpq_t q[3]) {
    mpq_t direction[3], axis[3], normal[3];
    for (int c = 0; c < 3; c++) {
        mpq_inits(direction[c], axis[c], normal[c], NULL);
        mpq_sub(direction[c], q[c], p[c]);
    }
    bool const is_point = is_zero(direction);
    for (int c = 0; c < 3; c++) {
        for (int d = 0; d < 3; d++) mpq_set_ui(axis[d], c == d, 1);
        if (is_point)
            for (int d = 0; d < 3; d++) mpq_set(normal[d], axis[d]);
        else
            cross(normal, direction, axis);
        clip(normal, p, 1);
        clip(normal, p, -1);
    }
    clip(direction, p, 1);
    clip(direction, q, -1);
    for (int c = 0; c < 3; c++) mpq_clears(direction[c], axis[c], normal[c], NULL);
}

static void load(mpq_t point[3], const double *coordinates) {
    for (int c = 0; c < 3; c++) mpq_set_d(point[c], coordinates[c]);
}

/* Clips the current polygon by the hull of the three points. */
static void clip_by_triangle(const double *const points[3]) {
    for (int i = 0; i < 3; i++) load(corner[i], points[i]);
    for (int i = 0; i < 3; i++)
        for (int c = 0; c < 3; c++) mpq_sub(edge[i][c], corner[(i + 1) % 3][c], corner[i][c]);
    cross(triangle_normal, edge[0], edge[1]);
    if (!is_zero(triangle_normal)) {
        clip(triangle_normal, corner[0], 1);
        clip(triangle_normal, corner[0], -1);
        for (int i = 0; i < 3; i++) {
            cross(side_normal, triangle_normal, edge[i]);
            clip(side_normal, corner[i], 1);
        }
        return;
    }
    /* Collinear: the longest edge holds the third corner. */
    int longest = 0;
    mpq_t length[3];
    for (int i = 0; i < 3; i++) {
        mpq_init(length[i]);
        for (int c = 0; c < 3; c++) {
            mpq_mul(t, edge[i][c], edge[i][c]);
            mpq_add(length[i], length[i], t);
        }
        if (mpq_cmp(length[i], length[longest]) > 0) longest = i;
    }
    for (int i = 0; i < 3; i++) mpq_clear(length[i]);
    clip_by_segment(corner[longest], corner[(longest + 1) % 3]);
}

/* Whether the current polygon's point lies in the hull of the shared points (1 or 2). */
static bool is_in_hull(int point, const double *const *shared, int shared_count) {
    mpq_t ends[2][3];
    for (int c = 0; c < 3; c++) mpq_inits(ends[0][c], ends[1][c], NULL);
    load(ends[0], shared[0]);
    load(ends[1], shared[shared_count - 1]);
    polygon const before = current;
    for (int c = 0; c < 3; c++) mpq_set(saved.points[0][c], before.points[point][c]);
    current = saved; /* the rationals are handles: the two swap storage for a while */
    current.count = 1;
    clip_by_segment(ends[0], ends[1]);
    bool const is_inside = current.count > 0;
    saved = current;
    current = before;
    for (int c = 0; c < 3; c++) mpq_clears(ends[0][c], ends[1][c], NULL);
    return is_inside;
}

static void sort_three(uint32_t *v) {
    for (int pass = 0; pass < 2; pass++)
        for (int i = 0; i < 2; i++)
            if (v[i] > v[i + 1]) {
                uint32_t const swap = v[i];
                v[i] = v[i + 1];
                v[i + 1] = swap;
            }
}

static bool have_same_vertices(const check_triangle *a, const check_triangle *b) {
    uint32_t sorted_a[3], sorted_b[3];
    memcpy(sorted_a, a->vertices, sizeof sorted_a);
    memcpy(sorted_b, b->vertices, sizeof sorted_b);
    sort_three(sorted_a);
    sort_three(sorted_b);
    return memcmp(sorted_a, sorted_b, sizeof sorted_a) == 0;
}

/* The places of the different shared vertices. Returns how many. */
static int find_shared(const check_triangle *a, const check_triangle *b, const double **shared) {
    int count = 0;
    for (int i = 0; i < 3; i++) {
        bool is_repeated = false, is_shared = false;
        for (int j = 0; j < i; j++) is_repeated |= a->vertices[j] == a->vertices[i];
        for (int j = 0; j < 3; j++) is_shared |= b->vertices[j] == a->vertices[i];
        if (is_shared && !is_repeated) shared[count++] = a->corners[i];
    }
    return count;
}

bool oracle_triangles_intersect(const check_triangle *a, const check_triangle *b, bool can_share) {
    prepare();
    const double *shared[3];
    int shared_count = 0;
    if (can_share) {
        if (have_same_vertices(a, b)) return true;
        shared_count = find_shared(a, b, shared);
    }
    current.count = 3;
    for (int i = 0; i < 3; i++) load(current.points[i], a->corners[i]);
    clip_by_triangle((const double *const[]){b->corners[0], b->corners[1], b->corners[2]});
    if (shared_count == 0) return current.count > 0;
    for (int i = 0; i < current.count; i++)
        if (!is_in_hull(i, shared, shared_count)) return true;
    return false;
}
