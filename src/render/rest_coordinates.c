/* render/rest_coordinates.c - see rest_coordinates.h.
 *
 * Triangles are laid out breadth first over shared edges. The first one of a piece is laid in the
 * plane. Each other one is placed by the lengths of its edges, on the far side of the edge over
 * which it was reached. In a flat piece every vertex lands where it lies in the piece's plane. In
 * another piece a vertex keeps the place that it got first. */
#include "render/rest_coordinates.h"

#include "base/arena.h"
#include "base/error.h"
#include "math/vec3.h"

#include <stdlib.h>
#include <string.h>

/* An edge of a triangle, by its vertices in ascending order; corner: 3 * triangle + the corner that
 * is opposite. */
typedef struct half_edge {
    uint32_t low, high, corner;
} half_edge;

typedef struct unfolding {
    tulle_mesh_view mesh;
    uint32_t *opposite; /* of each corner: the corner across the edge opposite to it; or NONE */
    uint32_t *queue;    /* of triangles */
    uint32_t *pieces;
    bool *is_placed;     /* of each vertex */
    double *coordinates; /* may be null: pieces only */
} unfolding;

static int compare_edges(const void *left, const void *right) {
    const half_edge *const a = left, *const b = right;
    if (a->low != b->low) return a->low < b->low ? -1 : 1;
    if (a->high != b->high) return a->high < b->high ? -1 : 1;
    return a->corner < b->corner ? -1 : a->corner > b->corner;
}

/* Pairs each edge with the next one of the same vertices. Cloth has two at most; three or more are
 * paired two by two. */
static void pair_edges(const unfolding *self, half_edge *edges) {
    size_t const count = 3 * self->mesh.triangle_count;
    for (size_t i = 0; i < count; i++) {
        const uint32_t *const corners = self->mesh.triangles + 3 * (i / 3);
        uint32_t const a = corners[(i + 1) % 3], b = corners[(i + 2) % 3];
        edges[i] = (half_edge){a < b ? a : b, a < b ? b : a, (uint32_t)i};
        self->opposite[i] = TULLE_NONE;
    }
    qsort(edges, count, sizeof *edges, compare_edges);
    for (size_t i = 0; i + 1 < count; i++) {
        if (edges[i].low != edges[i + 1].low || edges[i].high != edges[i + 1].high) continue;
        self->opposite[edges[i].corner] = edges[i + 1].corner;
        self->opposite[edges[i + 1].corner] = edges[i].corner;
        i++;
    }
}

static void place(const unfolding *self, uint32_t vertex, double x, double y) {
    if (!self->coordinates || self->is_placed[vertex]) return;
    self->is_placed[vertex] = true;
    self->coordinates[2 * vertex] = x;
    self->coordinates[2 * vertex + 1] = y;
}

/* Places the vertex at corner `corner` of a triangle whose other two vertices are placed. It lies
 * on the left of the edge from the next corner to the one after it. Its place is measured from the
 * middle of that edge by true lengths, so the error of an edge that could not be laid out with its
 * true length does not grow. */
static void place_corner(const unfolding *self, uint32_t corner) {
    if (!self->coordinates) return;
    const uint32_t *const corners = self->mesh.triangles + 3 * (size_t)(corner / 3);
    uint32_t const top = corners[corner % 3];
    uint32_t const from = corners[(corner + 1) % 3], to = corners[(corner + 2) % 3];
    vec3 const origin = vec3_load(self->mesh.positions, from);
    vec3 const edge = vec3_sub(vec3_load(self->mesh.positions, to), origin);
    vec3 const side = vec3_sub(vec3_load(self->mesh.positions, top), origin);
    double const length = vec3_norm(edge);
    const double *const a = self->coordinates + 2 * (size_t)from;
    const double *const b = self->coordinates + 2 * (size_t)to;
    double const flat_x = b[0] - a[0], flat_y = b[1] - a[1];
    double const flat_length = sqrt(flat_x * flat_x + flat_y * flat_y);
    double const middle_x = 0.5 * (a[0] + b[0]), middle_y = 0.5 * (a[1] + b[1]);
    if (!(length > 0.0) || !(flat_length > 0.0)) {
        place(self, top, middle_x, middle_y);
        return;
    }
    double const along = vec3_dot(side, edge) / length - 0.5 * length;
    double const across = vec3_norm(vec3_cross(edge, side)) / length;
    double const x = flat_x / flat_length, y = flat_y / flat_length;
    place(self, top, middle_x + along * x - across * y, middle_y + along * y + across * x);
}

/* Lays out the piece of a triangle and gives it its number; gives how many triangles it has, which
 * then stand in the queue. */
static size_t unfold_piece(const unfolding *self, uint32_t first, uint32_t piece) {
    const uint32_t *const corners = self->mesh.triangles + 3 * (size_t)first;
    vec3 const edge = vec3_sub(vec3_load(self->mesh.positions, corners[1]),
                               vec3_load(self->mesh.positions, corners[0]));
    place(self, corners[0], 0.0, 0.0);
    place(self, corners[1], vec3_norm(edge), 0.0);
    place_corner(self, 3 * first + 2);
    size_t count = 0;
    self->queue[count++] = first;
    self->pieces[first] = piece;
    for (size_t next = 0; next < count; next++) {
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t const across = self->opposite[3 * self->queue[next] + k];
            if (across == TULLE_NONE || self->pieces[across / 3] != TULLE_NONE) continue;
            place_corner(self, across);
            self->pieces[across / 3] = piece;
            self->queue[count++] = across / 3;
        }
    }
    return count;
}

/* The turn that brings the borders of a piece along the axes: the mean direction of border edges
 * up to quarter turns, by their lengths. Borders that go all ways say nothing; then the image of x
 * in the first triangle decides, or of y where x stands upright on it. */
static double compute_turn(const unfolding *self, size_t count) {
    double const least_agreement = 0.5; /* of borders: 1 right-angled, 0 round */
    double sum_cos = 0.0, sum_sin = 0.0, total = 0.0;
    for (size_t i = 0; i < count; i++) {
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t const triangle = self->queue[i];
            if (self->opposite[3 * triangle + k] != TULLE_NONE) continue;
            const uint32_t *const corners = self->mesh.triangles + 3 * (size_t)triangle;
            const double *const a = self->coordinates + 2 * (size_t)corners[(k + 1) % 3];
            const double *const b = self->coordinates + 2 * (size_t)corners[(k + 2) % 3];
            double const length = hypot(b[0] - a[0], b[1] - a[1]);
            double const angle = 4.0 * atan2(b[1] - a[1], b[0] - a[0]);
            sum_cos += length * cos(angle);
            sum_sin += length * sin(angle);
            total += length;
        }
    }
    if (total > 0.0 && hypot(sum_cos, sum_sin) > least_agreement * total)
        return -0.25 * atan2(sum_sin, sum_cos);
    /* The first triangle: its first edge lies along the first axis. */
    const uint32_t *const corners = self->mesh.triangles + 3 * (size_t)self->queue[0];
    vec3 const origin = vec3_load(self->mesh.positions, corners[0]);
    vec3 const edge = vec3_normalize(vec3_sub(vec3_load(self->mesh.positions, corners[1]), origin));
    vec3 const side = vec3_sub(vec3_load(self->mesh.positions, corners[2]), origin);
    vec3 const across = vec3_normalize(vec3_cross(vec3_cross(edge, side), edge));
    if (hypot(edge.x, across.x) > 0.1) return -atan2(across.x, edge.x);
    return -atan2(across.y, edge.y);
}

/* Each vertex of the piece once: the flags of the placed ones are taken back as they are turned. */
static void turn_piece(const unfolding *self, size_t count) {
    double const turn = compute_turn(self, count);
    double const cosine = cos(turn), sine = sin(turn);
    for (size_t i = 0; i < 3 * count; i++) {
        uint32_t const vertex = self->mesh.triangles[3 * (size_t)self->queue[i / 3] + i % 3];
        if (!self->is_placed[vertex]) continue;
        self->is_placed[vertex] = false;
        double *const at = self->coordinates + 2 * (size_t)vertex;
        double const x = at[0], y = at[1];
        at[0] = cosine * x - sine * y;
        at[1] = sine * x + cosine * y;
    }
}

static tulle_status run(memory *heap, unfolding *self, size_t *piece_count, tulle_error *error) {
    size_t const triangle_count = self->mesh.triangle_count;
    arena scratch = arena_make(heap);
    half_edge *const edges = ARENA_NEW(&scratch, half_edge, 3 * triangle_count + 1);
    self->opposite = ARENA_NEW(&scratch, uint32_t, 3 * triangle_count + 1);
    self->queue = ARENA_NEW(&scratch, uint32_t, triangle_count + 1);
    self->is_placed = ARENA_NEW_ZEROED(&scratch, bool, self->mesh.vertex_count + 1);
    if (!self->pieces) self->pieces = ARENA_NEW(&scratch, uint32_t, triangle_count + 1);
    bool const has_memory =
        edges && self->opposite && self->queue && self->is_placed && self->pieces;
    if (has_memory) {
        pair_edges(self, edges);
        for (size_t i = 0; i < triangle_count; i++) self->pieces[i] = TULLE_NONE;
        *piece_count = 0;
        for (size_t i = 0; i < triangle_count; i++) {
            if (self->pieces[i] != TULLE_NONE) continue;
            size_t const count = unfold_piece(self, (uint32_t)i, (uint32_t)(*piece_count)++);
            if (self->coordinates) turn_piece(self, count);
        }
    }
    arena_destroy(&scratch);
    return has_memory
               ? TULLE_OK
               : error_set(error, TULLE_ERROR_OUT_OF_MEMORY,
                           "out of memory for the rest shape of %zu triangles", triangle_count);
}

tulle_status render_find_pieces(memory *heap, tulle_mesh_view mesh, uint32_t *pieces,
                                size_t *piece_count, tulle_error *error) {
    unfolding self = {.mesh = mesh, .pieces = pieces};
    return run(heap, &self, piece_count, error);
}

tulle_status render_make_rest_coordinates(memory *heap, tulle_mesh_view rest, double *coordinates,
                                          tulle_error *error) {
    unfolding self = {.mesh = rest, .coordinates = coordinates};
    size_t piece_count;
    memset(coordinates, 0, 2 * rest.vertex_count * sizeof *coordinates);
    return run(heap, &self, &piece_count, error);
}
