/* geom/shapes_sphere.c - the geodesic sphere and the tetrahedral spike.
 *
 * Each of the icosahedron's 20 faces is cut into n^2 triangles and its points are pushed out to the
 * sphere: 10 n^2 + 2 vertices, all triangles of like size. Vertices are numbered corners first,
 * then those on edges, then those inside faces, so that faces share them without a search. */
#include "geom/shapes.h"

enum { CORNER_COUNT = 12, EDGE_COUNT = 30, FACE_COUNT = 20 };

/* Golden ratio: the corners are the cyclic permutations of (0, 1, phi) with all signs. */
static const double PHI = 1.618033988749895;

static const uint8_t faces[FACE_COUNT][3] = {
    {0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};

static vec3 get_corner(size_t k) {
    double const a = k & 1 ? 1.0 : -1.0, b = (k & 2) ? -PHI : PHI;
    switch (k / 4) {
    case 0: return vec3_make(a, b, 0.0);
    case 1: return vec3_make(0.0, a, b);
    default: return vec3_make(b, 0.0, a);
    }
}

typedef struct geodesic {
    size_t n;                                  /* cuts of an edge */
    uint8_t edges[CORNER_COUNT][CORNER_COUNT]; /* edge number of two corners */
} geodesic;

static geodesic make_geodesic(size_t n) {
    geodesic result = {.n = n};
    uint8_t count = 0;
    for (int f = 0; f < FACE_COUNT; f++) {
        for (int k = 0; k < 3; k++) {
            int const a = faces[f][k], b = faces[f][(k + 1) % 3];
            if (a < b) result.edges[a][b] = result.edges[b][a] = count++;
        }
    }
    return result;
}

/* Vertex of face f at cuts[1] steps towards its second and cuts[2] towards its third corner. */
static size_t get_vertex(const geodesic *g, size_t f, const size_t cuts[3]) {
    size_t const n = g->n;
    for (int k = 0; k < 3; k++) {
        if (cuts[k] == n) return faces[f][k];
        if (cuts[k] != 0) continue;
        int const second = (k + 1) % 3, third = (k + 2) % 3;
        if (cuts[second] == n || cuts[third] == n) continue;
        uint8_t const a = faces[f][second], b = faces[f][third];
        size_t const along = a < b ? cuts[third] : cuts[second];
        return CORNER_COUNT + g->edges[a][b] * (n - 1) + along - 1;
    }
    /* Inside: rows of n - 2, n - 3 ... vertices. */
    size_t const row = cuts[2] - 1;
    size_t const before = row * (n - 2) - row * (row - (row > 0)) / 2;
    return CORNER_COUNT + EDGE_COUNT * (n - 1) + f * ((n - 1) * (n - 2) / 2) + before + cuts[1] - 1;
}

static void place_vertex(const geodesic *g, size_t f, const size_t cuts[3], double radius,
                         tulle_mesh *mesh) {
    vec3 sum = {0.0, 0.0, 0.0};
    for (int k = 0; k < 3; k++)
        sum = vec3_add_scaled(sum, get_corner(faces[f][k]), (double)cuts[k]);
    vec3_store(mesh->positions, get_vertex(g, f, cuts), vec3_scale(vec3_normalize(sum), radius));
}

static void write_face(shape_writer *writer, const geodesic *g, size_t f, double radius) {
    size_t const n = g->n;
    for (size_t j = 0; j <= n; j++) {
        for (size_t i = 0; i + j <= n; i++) {
            size_t const here[3] = {n - i - j, i, j};
            place_vertex(g, f, here, radius, writer->mesh);
            if (i + j == n) continue;
            size_t const right[3] = {n - i - j - 1, i + 1, j}, up[3] = {n - i - j - 1, i, j + 1};
            size_t const a = get_vertex(g, f, here), b = get_vertex(g, f, right),
                         c = get_vertex(g, f, up);
            shape_write_triangle(writer, a, b, c);
            if (i + j + 1 == n) continue;
            size_t const across[3] = {n - i - j - 2, i + 1, j + 1};
            shape_write_triangle(writer, b, get_vertex(g, f, across), c);
        }
    }
}

tulle_status shape_make_sphere(const tulle_shape_def *def, tulle_mesh *mesh, tulle_error *error) {
    double const cuts = def->resolution[0];
    shape_writer writer;
    tulle_status const status = shape_writer_start(&writer, 10.0 * cuts * cuts + 2.0,
                                                   FACE_COUNT * cuts * cuts, mesh, error);
    if (status != TULLE_OK) return status;
    geodesic const g = make_geodesic(def->resolution[0]);
    for (size_t f = 0; f < FACE_COUNT; f++) write_face(&writer, &g, f, def->radius);
    return TULLE_OK;
}

tulle_status shape_make_tetrahedron(const tulle_shape_def *def, tulle_mesh *mesh,
                                    tulle_error *error) {
    static const uint32_t sides[4][3] = {{0, 1, 3}, {1, 2, 3}, {2, 0, 3}, {0, 2, 1}};
    double const half = 0.5 * def->radius, side = half * sqrt(3.0);
    shape_writer writer;
    tulle_status const status = shape_writer_start(&writer, 4.0, 4.0, mesh, error);
    if (status != TULLE_OK) return status;
    shape_write_vertex(&writer, def->radius, 0.0, 0.0);
    shape_write_vertex(&writer, -half, side, 0.0);
    shape_write_vertex(&writer, -half, -side, 0.0);
    shape_write_vertex(&writer, 0.0, 0.0, def->height);
    for (int k = 0; k < 4; k++)
        shape_write_triangle(&writer, sides[k][0], sides[k][1], sides[k][2]);
    return TULLE_OK;
}
