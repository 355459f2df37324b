/* geom/cut_polygon.c - see cut_polygon.h. */
#include "geom/cut_polygon.h"

#include "base/error.h"
#include "geom/exact_predicates.h"
#include "math/vec3.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define NONE UINT32_MAX
/* Sine of the smallest angle of a fan that stays. Files of 6 digits place a corner on a straight
 * side within 1e-6 of its length. */
static const double SLIVER_SINE = 1e-5;
/* Height of a polygon over its length, from which on it is not flat: two cuts of it then lie apart
 * by about a hundredth of its size. */
static const double BENT_SHARE = 1e-2;

/* The polygon at hand. Sides and corners are counted alike: side i leads from corner i to the next
 * one that is left. Side k of a triangle leads from its corner k to the next. */
typedef struct polygon {
    uint32_t count;        /* corners */
    double *space, *plane; /* 3 and 2 coordinates of each */
    uint32_t *next, *previous;
    uint32_t *beyond; /* triangle beyond each side, or NONE */
    uint32_t triangle_count;
    uint32_t *triangles, *neighbours; /* 3 of each: corners; triangles beyond its sides, or NONE */
    unsigned char *is_convex;
} polygon;

enum { CORNER_BYTES = 5 * sizeof(double) + 9 * sizeof(uint32_t) + 1, ROOM_MIN = 64 /* corners */ };

static bool make_room(polygon_cutter *cutter, size_t count, polygon *made) {
    if (count * CORNER_BYTES > cutter->room_size) {
        size_t const size = (count > ROOM_MIN ? count : ROOM_MIN) * CORNER_BYTES;
        void *const room = memory_allocate(cutter->heap, size);
        if (!room) return false;
        memory_release(cutter->heap, cutter->room, cutter->room_size);
        cutter->room = room;
        cutter->room_size = size;
    }
    made->space = cutter->room;
    made->plane = made->space + 3 * count;
    made->next = (uint32_t *)(made->plane + 2 * count);
    made->previous = made->next + count;
    made->beyond = made->previous + count;
    made->triangles = made->beyond + count;
    made->neighbours = made->triangles + 3 * count;
    made->is_convex = (unsigned char *)(made->neighbours + 3 * count);
    made->count = (uint32_t)count;
    return true;
}

void polygon_cutter_destroy(polygon_cutter *cutter) {
    memory_release(cutter->heap, cutter->room, cutter->room_size);
    *cutter = (polygon_cutter){0};
}

/* The vertex of a corner, of a fan. */
static uint32_t get_vertex(const uint32_t *fan, uint32_t count, uint32_t corner) {
    if (corner == 0) return fan[0];
    return corner + 1 < count ? fan[3 * (corner - 1) + 1] : fan[3 * (count - 3) + 2];
}

/* Corners as seen from the first one, all within 1: by a power of two, which rounds nothing. False
 * where the numbers are too large. */
static bool load_corners(polygon *p, const double *positions, const uint32_t *fan) {
    double largest = 0.0;
    for (uint32_t i = 0; i < p->count; i++)
        for (size_t k = 0; k < 3; k++) {
            double const x = positions[3 * (size_t)get_vertex(fan, p->count, i) + k] -
                             positions[3 * (size_t)fan[0] + k];
            p->space[3 * i + k] = x;
            largest = isfinite(x) ? fmax(largest, fabs(x)) : (double)INFINITY;
        }
    int exponent = 0;
    (void)frexp(largest, &exponent);
    for (size_t i = 0; i < 3 * (size_t)p->count && isfinite(largest); i++)
        p->space[i] = ldexp(p->space[i], -exponent);
    return isfinite(largest);
}

/* Twice the mean normal times the area. */
static vec3 compute_normal(const polygon *p) {
    vec3 sum = vec3_make(0.0, 0.0, 0.0);
    for (uint32_t i = 1; i + 1 < p->count; i++)
        sum = vec3_add(sum, vec3_cross(vec3_load(p->space, i), vec3_load(p->space, i + 1)));
    return sum;
}

/* Sine of the smallest angle of a triangle of corners, which faces the shortest side. The order of
 * the corners makes no difference to the last bit. */
static double measure_triangle(const polygon *p, uint32_t a, uint32_t b, uint32_t c) {
    uint32_t const low = a < b ? (a < c ? a : c) : (b < c ? b : c);
    uint32_t const high = a > b ? (a > c ? a : c) : (b > c ? b : c);
    vec3 const x = vec3_load(p->space, low);
    vec3 const u = vec3_sub(vec3_load(p->space, a ^ b ^ c ^ low ^ high), x);
    vec3 const v = vec3_sub(vec3_load(p->space, high), x);
    double const uu = vec3_norm2(u), vv = vec3_norm2(v), ww = vec3_norm2(vec3_sub(v, u));
    double const shortest = fmin(uu, fmin(vv, ww));
    double const product = shortest == uu ? vv * ww : shortest == vv ? uu * ww : uu * vv;
    return product > 0.0 ? sqrt(vec3_norm2(vec3_cross(u, v)) / product) : 0.0;
}

/* Whether the fan lies within the polygon: its triangles face along the normal, and go around the
 * first corner at most once. Slivers are borne where the polygon is too large to be cut. */
static bool has_good_fan(const polygon *p, vec3 normal) {
    double const least = p->count > POLYGON_CORNER_LIMIT ? 0.0 : SLIVER_SINE;
    vec3 const first = vec3_load(p->space, 1);
    bool is_past_half = false;
    for (uint32_t i = 1; i + 1 < p->count; i++) {
        vec3 const u = vec3_load(p->space, i), v = vec3_load(p->space, i + 1);
        if (!(vec3_dot(vec3_cross(u, v), normal) > 0.0) ||
            !(measure_triangle(p, 0, i, i + 1) > least))
            return false;
        bool const is_ahead = vec3_dot(vec3_cross(first, v), normal) > 0.0;
        if (is_ahead && is_past_half) return false;
        is_past_half = !is_ahead;
    }
    return true;
}

static bool is_bent(const polygon *p, vec3 normal) {
    double low = 0.0, high = 0.0, length = 0.0;
    for (uint32_t i = 1; i < p->count; i++) {
        vec3 const x = vec3_load(p->space, i);
        double const height = vec3_dot(x, normal);
        low = fmin(low, height);
        high = fmax(high, height);
        length = fmax(length, vec3_norm(x));
    }
    return high - low > BENT_SHARE * length;
}

/* ---- in the plane ---- */

/* Coordinates across the normal. From here on they are exact. */
static void project(polygon *p, vec3 normal) {
    double const x = fabs(normal.x), y = fabs(normal.y), z = fabs(normal.z);
    vec3 const axis = vec3_make(x <= y && x <= z, !(x <= y && x <= z) && y <= z,
                                !(x <= y && x <= z) && !(y <= z));
    vec3 const u = vec3_normalize(vec3_cross(axis, normal)), v = vec3_cross(normal, u);
    for (uint32_t i = 0; i < p->count; i++) {
        p->plane[2 * i] = vec3_dot(vec3_load(p->space, i), u);
        p->plane[2 * i + 1] = vec3_dot(vec3_load(p->space, i), v);
    }
}

static int get_turn(const polygon *p, uint32_t a, uint32_t b, uint32_t c) {
    return orient2d_sign(p->plane + 2 * (size_t)a, p->plane + 2 * (size_t)b,
                         p->plane + 2 * (size_t)c, NULL);
}

static bool is_same_place(const polygon *p, uint32_t a, uint32_t b) {
    return p->plane[2 * a] == p->plane[2 * b] && p->plane[2 * a + 1] == p->plane[2 * b + 1];
}

/* Whether two of the sides cross each other within both. */
static bool crosses_itself(const polygon *p) {
    const double *const x = p->plane;
    for (uint32_t a = 0; a < p->count; a++) {
        uint32_t const b = a + 1 < p->count ? a + 1 : 0;
        double low[2], high[2];
        for (size_t k = 0; k < 2; k++) {
            low[k] = fmin(x[2 * a + k], x[2 * b + k]);
            high[k] = fmax(x[2 * a + k], x[2 * b + k]);
        }
        for (uint32_t c = a + 2; c < p->count; c++) {
            uint32_t const d = c + 1 < p->count ? c + 1 : 0;
            bool is_near = true;
            for (size_t k = 0; k < 2 && is_near; k++)
                is_near = fmin(x[2 * c + k], x[2 * d + k]) < high[k] &&
                          fmax(x[2 * c + k], x[2 * d + k]) > low[k];
            if (is_near && get_turn(p, a, b, c) * get_turn(p, a, b, d) < 0 &&
                get_turn(p, c, d, a) * get_turn(p, c, d, b) < 0)
                return true;
        }
    }
    return false;
}

/* ---- ears ---- */

/* Whether the triangle at a corner may be cut off: it has area, and no other corner lies in it or
 * on its rim. Only corners that are not convex need a look. Those in the place of one of the three
 * belong to a bridge. */
static bool is_ear(const polygon *p, uint32_t b) {
    uint32_t const a = p->previous[b], c = p->next[b];
    if (!p->is_convex[b]) return false;
    const double *const x = p->plane;
    double low[2], high[2];
    for (size_t k = 0; k < 2; k++) {
        low[k] = fmin(x[2 * a + k], fmin(x[2 * b + k], x[2 * c + k]));
        high[k] = fmax(x[2 * a + k], fmax(x[2 * b + k], x[2 * c + k]));
    }
    for (uint32_t i = p->next[c]; i != a; i = p->next[i]) {
        const double *const q = x + 2 * (size_t)i;
        if (p->is_convex[i] || q[0] < low[0] || q[0] > high[0] || q[1] < low[1] || q[1] > high[1])
            continue;
        if (is_same_place(p, i, a) || is_same_place(p, i, b) || is_same_place(p, i, c)) continue;
        if (get_turn(p, a, b, i) >= 0 && get_turn(p, b, c, i) >= 0 && get_turn(p, c, a, i) >= 0)
            return false;
    }
    return true;
}

/* Tells a triangle and the one beyond its side `side` of each other. */
static void join(polygon *p, uint32_t triangle, uint32_t side, uint32_t other) {
    p->neighbours[3 * triangle + side] = other;
    /* What lies beyond a side that is left was cut there, so it is the last of its sides. */
    if (other != NONE) p->neighbours[3 * other + 2] = triangle;
}

static void cut_corner(polygon *p, uint32_t b) {
    uint32_t const a = p->previous[b], c = p->next[b], made = p->triangle_count++;
    uint32_t *const corners = p->triangles + 3 * made;
    corners[0] = a, corners[1] = b, corners[2] = c;
    p->neighbours[3 * made + 2] = NONE;
    join(p, made, 0, p->beyond[a]);
    join(p, made, 1, p->beyond[b]);
    if (p->next[c] == a) join(p, made, 2, p->beyond[c]); /* the last one */
    p->beyond[a] = made;
    p->next[a] = c;
    p->previous[c] = a;
    p->is_convex[a] = get_turn(p, p->previous[a], a, c) > 0;
    p->is_convex[c] = get_turn(p, a, c, p->next[c]) > 0;
}

/* False where no ear is left before the end: the polygon touches itself. The rest is cut as it
 * comes. */
static bool cut_ears(polygon *p) {
    uint32_t const count = p->count;
    for (uint32_t i = 0; i < count; i++) {
        p->next[i] = i + 1 < count ? i + 1 : 0;
        p->previous[i] = i > 0 ? i - 1 : count - 1;
        p->beyond[i] = NONE;
    }
    for (uint32_t i = 0; i < count; i++)
        p->is_convex[i] = get_turn(p, p->previous[i], i, p->next[i]) > 0;
    p->triangle_count = 0;
    uint32_t left = count, at = 0, misses = 0;
    bool is_good = true;
    while (left > 2) {
        uint32_t const next = p->next[at], before = p->previous[at];
        /* A side without length goes with its corner. */
        bool const is_cut = left == 3 || !is_good || is_same_place(p, at, next) || is_ear(p, at);
        bool const has_short_side = is_same_place(p, at, next) || is_same_place(p, next, before) ||
                                    is_same_place(p, before, at);
        if (left == 3 && !p->is_convex[at] && !has_short_side) is_good = false;
        if (is_cut) cut_corner(p, at);
        if (is_cut) left--;
        misses = is_cut ? 0 : misses + 1;
        if (misses > left) is_good = false;
        at = next;
    }
    return is_good;
}

/* ---- diagonals ---- */

static double measure_pair(const polygon *p, const uint32_t one[3], const uint32_t other[3]) {
    return fmin(measure_triangle(p, one[0], one[1], one[2]),
                measure_triangle(p, other[0], other[1], other[2]));
}

/* Replaces the side that two triangles share by the other diagonal, if that makes their smallest
 * angle larger. */
static bool exchange_diagonal(polygon *p, uint32_t t, uint32_t side) {
    uint32_t *const neighbours = p->neighbours, u = neighbours[3 * t + side];
    if (u == NONE) return false;
    uint32_t *const one = p->triangles + 3 * t, *const other = p->triangles + 3 * u;
    uint32_t back = 0;
    while (neighbours[3 * u + back] != t) back++;
    uint32_t const next = (side + 1) % 3, last = (side + 2) % 3;
    uint32_t const back_next = (back + 1) % 3, back_last = (back + 2) % 3;
    uint32_t const a = one[side], b = one[next], c = one[last], d = other[back_last];
    if (get_turn(p, a, d, c) <= 0 || get_turn(p, d, b, c) <= 0) return false;
    uint32_t const made[2][3] = {{a, d, c}, {d, b, c}};
    if (!(measure_pair(p, made[0], made[1]) > measure_pair(p, one, other))) return false;
    uint32_t const beyond_ad = neighbours[3 * u + back_next],
                   beyond_db = neighbours[3 * u + back_last], beyond_bc = neighbours[3 * t + next],
                   beyond_ca = neighbours[3 * t + last];
    memcpy(one, made[0], sizeof made[0]);
    memcpy(other, made[1], sizeof made[1]);
    memcpy(neighbours + 3 * t, (uint32_t[3]){beyond_ad, u, beyond_ca}, sizeof made[0]);
    memcpy(neighbours + 3 * u, (uint32_t[3]){beyond_db, beyond_bc, t}, sizeof made[0]);
    for (uint32_t k = 0; k < 3; k++) {
        if (beyond_ad != NONE && neighbours[3 * beyond_ad + k] == u)
            neighbours[3 * beyond_ad + k] = t;
        if (beyond_bc != NONE && neighbours[3 * beyond_bc + k] == t)
            neighbours[3 * beyond_bc + k] = u;
    }
    return true;
}

/* Each exchange makes the sorted list of angles larger, so there is an end to it. */
static void exchange_diagonals(polygon *p) {
    bool has_changed = true;
    for (uint32_t pass = 0; has_changed && pass < p->count; pass++) {
        has_changed = false;
        for (uint32_t t = 0; t < p->triangle_count; t++)
            for (uint32_t side = 0; side < 3; side++) has_changed |= exchange_diagonal(p, t, side);
    }
}

/* ---- the whole ---- */

static void note(size_t *count, uint64_t *first, uint64_t number) {
    if ((*count)++ == 0) *first = number;
}

/* Whether the polygon was cut; false where it crosses itself, has no area or has a good fan. */
static bool cut(polygon_cutter *cutter, polygon *p, bool *is_too_large) {
    vec3 const sum = compute_normal(p);
    double const length = vec3_norm(sum);
    if (!(length > 0.0)) {
        note(&cutter->crossed_count, &cutter->first_crossed, cutter->number);
        return false;
    }
    vec3 const normal = vec3_scale(sum, 1.0 / length);
    bool const is_fan = has_good_fan(p, normal);
    *is_too_large = !is_fan && p->count > POLYGON_CORNER_LIMIT;
    if (*is_too_large) return false;
    bool is_crossed = false;
    if (!is_fan) {
        project(p, normal);
        is_crossed = crosses_itself(p);
        if (!is_crossed && !cut_ears(p))
            note(&cutter->crossed_count, &cutter->first_crossed, cutter->number);
        if (!is_crossed) exchange_diagonals(p);
    }
    if (is_crossed)
        note(&cutter->crossed_count, &cutter->first_crossed, cutter->number);
    else if (is_bent(p, normal))
        note(&cutter->bent_count, &cutter->first_bent, cutter->number);
    return !is_fan && !is_crossed;
}

tulle_status polygon_cut(polygon_cutter *cutter, const double *positions, uint32_t *triangles,
                         size_t triangle_count, tulle_error *error) {
    polygon p = {0};
    cutter->corners = NULL;
    if (triangle_count < 2) return TULLE_OK;
    size_t const count = triangle_count + 2;
    if (count > UINT32_MAX / 4 || !make_room(cutter, count, &p))
        return error_set_at(error, TULLE_ERROR_OUT_OF_MEMORY, cutter->path, 0, 0,
                            "out of memory for a polygon of %zu corners", count);
    if (!load_corners(&p, positions, triangles)) return TULLE_OK;
    bool is_too_large = false;
    bool const is_cut = cut(cutter, &p, &is_too_large);
    if (is_too_large)
        return error_set_at(
            error, TULLE_ERROR_LIMIT, cutter->path, 0, 0,
            "%s %llu: the polygon has %zu corners and is not convex; at most %d can "
            "be cut: make triangles of it in the program that it comes from",
            cutter->place, (unsigned long long)cutter->number, count, POLYGON_CORNER_LIMIT);
    if (!is_cut) return TULLE_OK;
    for (size_t i = 0; i < 3 * triangle_count; i++) /* the links have had their use */
        p.neighbours[i] = get_vertex(triangles, p.count, p.triangles[i]);
    memcpy(triangles, p.neighbours, 3 * triangle_count * sizeof *triangles);
    cutter->corners = p.triangles;
    return TULLE_OK;
}

void polygon_cutter_describe(const polygon_cutter *cutter, char *text, size_t size) {
    const struct {
        size_t count;
        uint64_t first;
        const char *one, *many;
    } kinds[] = {{cutter->bent_count, cutter->first_bent, "is not flat", "are not flat"},
                 {cutter->crossed_count, cutter->first_crossed, "crosses itself or has no area",
                  "cross themselves or have no area"}};
    size_t length = 0;
    if (size > 0) text[0] = '\0';
    for (size_t i = 0; i < 2 && length < size; i++) {
        if (kinds[i].count == 0) continue;
        bool const is_one = kinds[i].count == 1;
        length += (size_t)snprintf(
            text + length, size - length, "%s%zu %s %s (%s%s %llu)", length > 0 ? ", " : "",
            kinds[i].count, is_one ? "polygon" : "polygons", is_one ? kinds[i].one : kinds[i].many,
            is_one ? "" : "the first in ", cutter->place, (unsigned long long)kinds[i].first);
    }
}
