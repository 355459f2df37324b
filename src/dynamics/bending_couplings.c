/* dynamics/bending_couplings.c - the bending energy of any triangle mesh, right in every direction.
 *
 * Morley's triangle has, beside the heights of its corners, the slope across each edge at its
 * middle, and a constant curvature
 *
 *     S = sum_e l_e / A  n_e n_e^T b_e,
 *
 * with n_e the outward normal of edge e in the rest plane and b_e how much steeper the surface is
 * there than the flat triangle. Both triangles of an edge share one slope, so their two b add up to
 * c_e / l_e, the hinge's kink (cloth_model.h). A constant moment then does no work on what bends
 * back and forth within the mesh. That makes the triangle right on every mesh.
 *
 * Here slopes are no unknowns. How the kink of an edge is split between its triangles is reckoned
 * from the kinks around: half and half, and then the least change, over the hinges of both
 * triangles, that makes it exact for all quadratic surfaces. So a cylinder has exactly the energy
 * B/2 kappa^2 per area in every direction, no shape within the mesh can have less than Morley's
 * triangle gives it, and zero energy means flat. On regular meshes half and half is exact, and
 * hinges are coupled within a triangle alone.
 *
 * On a border nothing holds the slope: b takes the value with the least energy, which is the
 * boundary condition of a free edge.
 *
 * A triangle that a clamp holds is rigid: its slopes are its own. So the kink of its border counts
 * whole in the triangle that is free, and cloth bends from the clamp's edge on.
 *
 * The energy per triangle is A/2 (B_1 S_11^2 + B_2 S_22^2 + 4 B_12 S_12^2), 1 along the warp, with
 * the b as vectors: c_e is linear in the positions, so is b, and the energy has constant
 * coefficients.
 *
 * Based on: Morley, The triangular equilibrium element in the solution of plate bending problems,
 * 1968; Onate, Zarate, Rotation-free triangular plate and shell elements, 2000 (slopes from the
 * triangles around: half and half); Bergou, Wardetzky, Harmon, Zorin, Grinspun, A quadratic bending
 * model for inextensible surfaces, 2006 (c). Departure: the split that is exact for quadratics.
 * Half and half alone is 1.5 times too stiff across the diagonals of alternating squares; curvature
 * of each triangle by itself, fitted to its three hinges, gives every cylinder its energy too, but
 * lets cloth bend back and forth, and is 0.75 times as stiff there. */
#include "dynamics/bending_couplings.h"

#include "dynamics/bending.h"
#include "dynamics/hysteresis.h"
#include "dynamics/yarn_frame.h"

#include <math.h>
#include <string.h>

/* The hinge of an edge and those of the other edges of both of its triangles. */
enum { PATCH_HINGES = 5, MONOMIALS = 3 };

/* How the kink of a hinge is split: of each hinge's kink, the part that counts in the triangle at
 * corner 2. In the other triangle count the rest of its own kink, and minus the others' parts. */
typedef struct kink_split {
    uint32_t hinges[PATCH_HINGES]; /* its own first; TULLE_NONE past the border */
    double parts[PATCH_HINGES];
} kink_split;

/* The root is rounded alike everywhere; hypot is not. */
static double get_length(double x, double y) { return sqrt(x * x + y * y); }

typedef struct plane_point {
    double x, y;
} plane_point;

/* Where the apex of one side lies seen from the edge: along it, and how far off. */
static plane_point locate_apex(const bending_shape *shape, const cloth_hinge *hinge, size_t side) {
    size_t const triangle = hinge->sides[side] / 3;
    vec3 const from = cloth_get_rest(shape->def, triangle, hinge->vertices[0]);
    vec3 const along = vec3_sub(cloth_get_rest(shape->def, triangle, hinge->vertices[1]), from);
    vec3 const offset =
        vec3_sub(cloth_get_rest(shape->def, triangle, hinge->vertices[2 + side]), from);
    double const length = vec3_norm(along);
    return (plane_point){vec3_dot(along, offset) / length,
                         vec3_norm(vec3_cross(along, offset)) / length};
}

/* [m] The mean of both triangles' lengths. */
static double measure_edge(const bending_shape *shape, const cloth_hinge *hinge) {
    double sum = 0.0;
    for (int side = 0; side < 2; side++) {
        size_t const triangle = hinge->sides[side] / 3;
        sum += vec3_norm(vec3_sub(cloth_get_rest(shape->def, triangle, hinge->vertices[1]),
                                  cloth_get_rest(shape->def, triangle, hinge->vertices[0])));
    }
    return 0.5 * sum;
}

/* x^2 / 2, y^2 / 2, x y */
static void add_monomials(plane_point p, double factor, double sums[MONOMIALS]) {
    sums[0] += 0.5 * factor * p.x * p.x;
    sums[1] += 0.5 * factor * p.y * p.y;
    sums[2] += factor * p.x * p.y;
}

/* One triangle of a hinge, unfolded into the plane. */
typedef struct flat_triangle {
    uint32_t vertices[3];
    plane_point points[3];
} flat_triangle;

static plane_point find_point(const flat_triangle *flat, uint32_t vertex) {
    for (int k = 0; k < 2; k++)
        if (flat->vertices[k] == vertex) return flat->points[k];
    return flat->points[2];
}

/* The kinks of another edge's hinge for the monomials, its far triangle unfolded into the plane. */
static void measure_kinks(const bending_shape *shape, const cloth_hinge *hinge,
                          const flat_triangle *flat, size_t near, double kinks[MONOMIALS]) {
    plane_point points[4];
    for (size_t k = 0; k < 2; k++) points[k] = find_point(flat, hinge->vertices[k]);
    plane_point const own = points[2 + near] = find_point(flat, hinge->vertices[2 + near]);
    plane_point const seen = locate_apex(shape, hinge, 1 - near);
    double const dx = points[1].x - points[0].x, dy = points[1].y - points[0].y;
    double const length = get_length(dx, dy);
    double const side = dx * (own.y - points[0].y) - dy * (own.x - points[0].x);
    double const off = side > 0.0 ? -seen.y : seen.y; /* away from the near triangle */
    points[3 - near] = (plane_point){points[0].x + (dx * seen.x - dy * off) / length,
                                     points[0].y + (dy * seen.x + dx * off) / length};
    for (int k = 0; k < 4; k++) add_monomials(points[k], hinge->weights[k] / length, kinks);
}

/* Eigenvectors of a symmetric 3x3 matrix as columns, by Jacobi's rotations; the eigenvalues are
 * left on the diagonal. */
static void diagonalise(double a[3][3], double vectors[3][3]) {
    enum { SWEEPS = 12 };
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) vectors[i][j] = i == j;
    for (int turn = 0; turn < 3 * SWEEPS; turn++) {
        int const p = turn % 3 == 2 ? 1 : 0, q = turn % 3 == 0 ? 1 : 2;
        if (a[p][q] == 0.0) continue;
        double const theta = 0.5 * (a[q][q] - a[p][p]) / a[p][q];
        double const t = copysign(1.0, theta) / (fabs(theta) + get_length(theta, 1.0));
        double const c = 1.0 / get_length(t, 1.0), s = t * c;
        for (int k = 0; k < 3; k++) {
            double const left = a[k][p], right = a[k][q];
            a[k][p] = c * left - s * right;
            a[k][q] = s * left + c * right;
        }
        for (int k = 0; k < 3; k++) {
            double const left = a[p][k], right = a[q][k], x = vectors[k][p], y = vectors[k][q];
            a[p][k] = c * left - s * right;
            a[q][k] = s * left + c * right;
            vectors[k][p] = c * x - s * y;
            vectors[k][q] = s * x + c * y;
        }
    }
}

/* Of another hinge's part a change counts this much more than of the own one's. */
static const double FAR_COST = 2.0;
/* What hinges tell worse than this share of what they tell best is left out. */
static const double LEAST_SHARE = 0.02;

/* The least change of parts whose kinks add up to `wanted`. */
static void add_least_change(double kinks[PATCH_HINGES][MONOMIALS], const double wanted[MONOMIALS],
                             double parts[PATCH_HINGES]) {
    double square[3][3] = {{0.0}}, vectors[3][3], most = 0.0, solution[MONOMIALS] = {0.0};
    for (int h = 1; h < PATCH_HINGES; h++)
        for (int m = 0; m < MONOMIALS; m++) kinks[h][m] /= FAR_COST;
    for (int h = 0; h < PATCH_HINGES; h++)
        for (int i = 0; i < MONOMIALS; i++)
            for (int j = 0; j < MONOMIALS; j++) square[i][j] += kinks[h][i] * kinks[h][j];
    diagonalise(square, vectors);
    for (int k = 0; k < MONOMIALS; k++) most = fmax(most, square[k][k]);
    for (int k = 0; k < MONOMIALS; k++) {
        if (!(square[k][k] > LEAST_SHARE * LEAST_SHARE * most)) continue;
        double along = 0.0;
        for (int m = 0; m < MONOMIALS; m++) along += vectors[m][k] * wanted[m];
        for (int m = 0; m < MONOMIALS; m++) solution[m] += vectors[m][k] * along / square[k][k];
    }
    for (int h = 0; h < PATCH_HINGES; h++) {
        double change = 0.0;
        for (int m = 0; m < MONOMIALS; m++) change += kinks[h][m] * solution[m];
        parts[h] += h == 0 ? change : change / FAR_COST;
    }
}

/* Whether one clamp holds all of a triangle. */
static bool is_clamped(const cloth_model_def *def, size_t triangle) {
    if (!def->vertex_clamps) return false;
    const uint32_t *const corners = def->surface->triangles + 3 * triangle;
    uint32_t const clamp = def->vertex_clamps[corners[0]];
    return clamp != 0 && def->vertex_clamps[corners[1]] == clamp &&
           def->vertex_clamps[corners[2]] == clamp;
}

/* Parts smaller than this are rounding. */
static const double LEAST_PART = 1e-9;

static kink_split split_kink(const bending_shape *shape, const cloth_model *model, uint32_t index) {
    const cloth_hinge *const hinge = &model->hinges[index];
    double const length = measure_edge(shape, hinge), half = 0.5 * length;
    kink_split split = {{index, TULLE_NONE, TULLE_NONE, TULLE_NONE, TULLE_NONE}, {0.5}};
    bool const is_rigid[2] = {is_clamped(shape->def, hinge->sides[0] / 3),
                              is_clamped(shape->def, hinge->sides[1] / 3)};
    if (is_rigid[0] || is_rigid[1]) {
        split.parts[0] = is_rigid[0] ? 0.0 : 1.0;
        return split;
    }
    double kinks[PATCH_HINGES][MONOMIALS] = {{0.0}}, wanted[MONOMIALS] = {0.0};
    size_t count = 1;
    for (size_t side = 0; side < 2; side++) {
        /* The edge lies along x, its middle at the origin, the triangle at corner 2 above it. */
        uint32_t const apex = hinge->vertices[2 + side], place = hinge->sides[side];
        plane_point const seen = locate_apex(shape, hinge, side);
        flat_triangle const flat = {
            {hinge->vertices[0], hinge->vertices[1], apex},
            {{-half, 0.0}, {half, 0.0}, {seen.x - half, side == 0 ? seen.y : -seen.y}}};
        double own[MONOMIALS] = {0.0}; /* this triangle's share of the kink, exactly */
        double const across = 1.0 / seen.y, part = seen.x / length;
        add_monomials(flat.points[0], (1.0 - part) * across, own);
        add_monomials(flat.points[1], part * across, own);
        add_monomials(flat.points[2], -across, own);
        for (int m = 0; m < MONOMIALS; m++) {
            kinks[0][m] += own[m];
            wanted[m] += side == 0 ? 0.5 * own[m] : -0.5 * own[m];
        }
        for (uint32_t k = place - place % 3; k < place - place % 3 + 3; k++) {
            uint32_t const other = model->triangle_hinges[k];
            if (k == place || other == TULLE_NONE) continue;
            size_t const near = model->hinges[other].sides[0] == k ? 0 : 1;
            if (is_clamped(shape->def, model->hinges[other].sides[1 - near] / 3)) continue;
            split.hinges[count] = other;
            measure_kinks(shape, &model->hinges[other], &flat, near, kinks[count++]);
        }
    }
    add_least_change(kinks, wanted, split.parts);
    for (size_t h = 1; h < PATCH_HINGES; h++)
        if (fabs(split.parts[h]) < LEAST_PART) split.hinges[h] = TULLE_NONE, split.parts[h] = 0.0;
    return split;
}

/* The part of the kink of the split's hinge number `h` in the triangle on a side. */
static double get_part(const kink_split *split, size_t h, size_t side) {
    double const part = split->parts[h];
    return side == 0 ? part : h == 0 ? 1.0 - part : -part;
}

/* ---- triangles ---- */

/* Energy 1/2 sum_ij m_ij b_i b_j of the edges of a triangle [N m]. */
typedef struct edge_matrix {
    double m[3][3];
} edge_matrix;

/* Leaves out an edge of the border: its b has the least energy. */
static void release_edge(edge_matrix *matrix, int edge) {
    double const own = matrix->m[edge][edge];
    double column[3];
    for (int i = 0; i < 3; i++) column[i] = matrix->m[i][edge];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            bool const is_left_out = i == edge || j == edge;
            double const rest = own > 0.0 ? matrix->m[i][j] - column[i] * column[j] / own : 0.0;
            matrix->m[i][j] = is_left_out ? 0.0 : rest;
        }
}

/* l n n^T of each edge: 11, 22, 12, and the softening of its hinge. The normal is the edge turned
 * by a right angle. */
typedef struct edge_strains {
    double strains[3][3], softening[3];
} edge_strains;

static edge_strains measure_edges(const bending_shape *shape, const cloth_model *model,
                                  size_t triangle) {
    const cloth_model_def *const def = shape->def;
    const uint32_t *const corners = def->surface->triangles + 3 * triangle;
    yarn_frame const frame = yarn_frame_make(def, triangle);
    edge_strains edges = {.softening = {1.0, 1.0, 1.0}};
    for (int k = 0; k < 3; k++) {
        vec3 const edge = vec3_sub(cloth_get_rest(def, triangle, corners[(k + 1) % 3]),
                                   cloth_get_rest(def, triangle, corners[k]));
        double const u = vec3_dot(edge, frame.weft), v = -vec3_dot(edge, frame.warp);
        double const length = vec3_norm(edge);
        uint32_t const hinge = model->triangle_hinges[3 * triangle + (size_t)k];
        edges.strains[k][0] = u * u / length, edges.strains[k][1] = v * v / length,
        edges.strains[k][2] = u * v / length;
        if (hinge != TULLE_NONE) edges.softening[k] = shape->softening[hinge];
    }
    return edges;
}

/* The matrix of a triangle. `curvatures`, unless null: what b of each edge adds to the curvature
 * along warp and weft [1/m]. */
static edge_matrix measure_triangle(const bending_shape *shape, const cloth_model *model,
                                    size_t triangle, double (*curvatures)[3]) {
    const cloth_model_def *const def = shape->def;
    double const area = shape->areas[triangle];
    const tulle_material *const material =
        cloth_get_material(def, def->surface->triangles[3 * triangle]);
    double const factor = def->stiffness_factors ? def->stiffness_factors[triangle] : 1.0;
    double const rigidities[3] = {factor * material->bend_warp, factor * material->bend_weft,
                                  factor * material->bend_twist};
    edge_strains const edges = measure_edges(shape, model, triangle);
    const double(*const strains)[3] = edges.strains;
    edge_matrix matrix;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            matrix.m[i][j] = edges.softening[i] * edges.softening[j] *
                             (rigidities[0] * strains[i][0] * strains[j][0] +
                              rigidities[1] * strains[i][1] * strains[j][1] +
                              4.0 * rigidities[2] * strains[i][2] * strains[j][2]) /
                             area;
    for (int yarn = 0; curvatures && yarn < YARN_COUNT; yarn++)
        for (int i = 0; i < 3; i++)
            curvatures[yarn][i] = edges.softening[i] * strains[i][yarn] / area;
    for (int k = 0; k < 3; k++) {
        if (model->triangle_hinges[3 * triangle + (size_t)k] != TULLE_NONE) continue;
        double const own = matrix.m[k][k];
        for (int yarn = 0; curvatures && yarn < YARN_COUNT; yarn++) {
            double const released = curvatures[yarn][k];
            for (int i = 0; own > 0.0 && i < 3; i++)
                curvatures[yarn][i] -= released * matrix.m[k][i] / own;
            curvatures[yarn][k] = 0.0;
        }
        release_edge(&matrix, k);
    }
    return matrix;
}

/* ---- couplings ---- */

typedef struct coupling_row {
    ARRAY(uint32_t) hinges;
    ARRAY(double) values;
} coupling_row;

typedef struct coupling_work {
    memory *heap;
    const bending_shape *shape;
    const cloth_model *model;
    const kink_split *splits;    /* by hinge */
    const edge_matrix *matrices; /* by triangle */
    const double *lengths;       /* [m] of the hinges' edges */
    uint32_t *places;            /* by hinge: its place in the row; TULLE_NONE before and after */
    coupling_row row;
} coupling_work;

static bool add_coupling(coupling_work *work, uint32_t hinge, double value) {
    uint32_t *const place = &work->places[hinge];
    if (*place != TULLE_NONE) {
        work->row.values.data[*place] += value;
        return true;
    }
    if (!ARRAY_RESERVE(work->heap, &work->row.hinges, 1) ||
        !ARRAY_RESERVE(work->heap, &work->row.values, 1))
        return false;
    *place = (uint32_t)work->row.hinges.count;
    work->row.hinges.data[work->row.hinges.count++] = hinge;
    work->row.values.data[work->row.values.count++] = value;
    return true;
}

/* Adds what one triangle says to the row of a hinge. */
static bool add_triangle(coupling_work *work, uint32_t hinge, size_t triangle) {
    const edge_matrix *const matrix = &work->matrices[triangle];
    const uint32_t *const edges = work->model->triangle_hinges + 3 * triangle;
    for (size_t i = 0; i < 3; i++) {
        if (edges[i] == TULLE_NONE) continue;
        const kink_split *const split = &work->splits[edges[i]];
        size_t const side = work->model->hinges[edges[i]].sides[0] == 3 * triangle + i ? 0 : 1;
        for (size_t h = 0; h < PATCH_HINGES; h++) {
            if (split->hinges[h] != hinge) continue;
            double const own = get_part(split, h, side) / work->lengths[hinge];
            for (size_t j = 0; j < 3; j++) {
                if (edges[j] == TULLE_NONE) continue;
                const kink_split *const far = &work->splits[edges[j]];
                size_t const far_side =
                    work->model->hinges[edges[j]].sides[0] == 3 * triangle + j ? 0 : 1;
                for (size_t g = 0; g < PATCH_HINGES; g++) {
                    if (far->hinges[g] == TULLE_NONE) continue;
                    double const part = get_part(far, g, far_side) / work->lengths[far->hinges[g]];
                    if (!add_coupling(work, far->hinges[g], own * matrix->m[i][j] * part))
                        return false;
                }
            }
        }
    }
    return true;
}

/* The triangles whose slopes the kink of a hinge may count in: its own, and those beyond their
 * other edges. */
static size_t list_triangles(const cloth_model *model, uint32_t hinge, size_t triangles[6]) {
    size_t count = 0;
    for (int side = 0; side < 2; side++) {
        uint32_t const place = model->hinges[hinge].sides[side];
        size_t const own = place / 3;
        size_t candidates[3] = {own, own, own};
        for (size_t k = 0, n = 1; k < 3; k++) {
            uint32_t const other = model->triangle_hinges[3 * own + k];
            if (3 * own + k == place || other == TULLE_NONE) continue;
            const uint32_t *const sides = model->hinges[other].sides;
            candidates[n++] = (sides[0] / 3 == own ? sides[1] : sides[0]) / 3;
        }
        for (int i = 0; i < 3; i++) {
            bool is_known = false;
            for (size_t j = 0; j < count; j++) is_known |= triangles[j] == candidates[i];
            if (!is_known) triangles[count++] = candidates[i];
        }
    }
    return count;
}

static bool build_rows(coupling_work *work, cloth_model *model) {
    ARRAY(uint32_t) hinges = {0};
    ARRAY(double) values = {0};
    bool ok = true;
    for (uint32_t h = 0; ok && h < model->hinge_count; h++) {
        size_t triangles[6];
        size_t const count = list_triangles(model, h, triangles);
        work->row.hinges.count = work->row.values.count = 0;
        for (size_t i = 0; ok && i < count; i++) ok = add_triangle(work, h, triangles[i]);
        size_t const row_count = work->row.hinges.count;
        for (size_t i = 0; i < row_count; i++) work->places[work->row.hinges.data[i]] = TULLE_NONE;
        ok = ok && ARRAY_RESERVE(work->heap, &hinges, row_count) &&
             ARRAY_RESERVE(work->heap, &values, row_count);
        for (size_t i = 0; ok && i < row_count; i++) {
            hinges.data[hinges.count++] = work->row.hinges.data[i];
            values.data[values.count++] = work->row.values.data[i];
        }
        model->coupling_begin[h + 1] = (uint32_t)hinges.count;
    }
    if (ok) {
        model->coupling_hinges = memory_allocate(work->heap, hinges.count * sizeof(uint32_t));
        model->couplings = memory_allocate(work->heap, hinges.count * sizeof(double));
        ok = model->coupling_hinges && model->couplings;
    }
    if (ok && hinges.count > 0) {
        memcpy(model->coupling_hinges, hinges.data, hinges.count * sizeof(uint32_t));
        memcpy(model->couplings, values.data, values.count * sizeof(double));
    }
    ARRAY_FREE(work->heap, &hinges);
    ARRAY_FREE(work->heap, &values);
    return ok;
}

/* ---- curvatures ---- */

/* The curvature of a triangle along warp and weft, by the hinges whose kinks count in it. Returns
 * how many do. */
static size_t list_curvature(const coupling_work *work, size_t triangle,
                             curvature_part parts[CURVATURE_PARTS]) {
    const cloth_model *const model = work->model;
    const uint32_t *const edges = model->triangle_hinges + 3 * triangle;
    double curvatures[YARN_COUNT][3];
    size_t count = 0;
    measure_triangle(work->shape, model, triangle, curvatures);
    for (size_t i = 0; i < 3; i++) {
        if (edges[i] == TULLE_NONE) continue;
        const kink_split *const split = &work->splits[edges[i]];
        size_t const side = model->hinges[edges[i]].sides[0] == 3 * triangle + i ? 0 : 1;
        for (size_t h = 0; h < PATCH_HINGES; h++) {
            double const part = get_part(split, h, side);
            if (split->hinges[h] == TULLE_NONE || part == 0.0) continue;
            size_t place = 0;
            while (place < count && parts[place].hinge != split->hinges[h]) place++;
            if (place == count)
                parts[count++] = (curvature_part){split->hinges[h], (uint32_t)triangle, {0.0}};
            for (int yarn = 0; yarn < YARN_COUNT; yarn++)
                parts[place].weights[yarn] +=
                    curvatures[yarn][i] * part / work->lengths[split->hinges[h]];
        }
    }
    return count;
}

static bool build_curvatures(const coupling_work *work, cloth_model *model) {
    if (!model->sliders || !model->sliders->has_bend) return true;
    cloth_sliders *const sliders = model->sliders;
    curvature_part parts[CURVATURE_PARTS];
    for (int pass = 0; pass < 2; pass++) { /* counts; fills */
        size_t sum = 0;
        for (size_t t = 0; t < model->triangle_count; t++) {
            bool const has_any = hysteresis_bends(sliders, model->elements[t].fabric);
            size_t const count = has_any ? list_curvature(work, t, parts) : 0;
            if (pass == 1 && count > 0) memcpy(sliders->parts + sum, parts, count * sizeof *parts);
            sum += count;
            sliders->part_begin[t + 1] = (uint32_t)sum;
        }
        if (pass == 1) break;
        sliders->parts = memory_allocate(work->heap, sum * sizeof *sliders->parts);
        if (!sliders->parts) return false;
    }
    return true;
}

bool bending_build_couplings(memory *heap, const bending_shape *shape, cloth_model *model) {
    size_t const hinges = model->hinge_count, triangles = model->triangle_count;
    kink_split *const splits = memory_allocate(heap, hinges * sizeof *splits);
    edge_matrix *const matrices = memory_allocate(heap, triangles * sizeof *matrices);
    double *const lengths = memory_allocate(heap, hinges * sizeof *lengths);
    uint32_t *const places = memory_allocate(heap, hinges * sizeof *places);
    model->coupling_begin = memory_allocate_zeroed(heap, hinges + 1, sizeof(uint32_t));
    bool ok = splits && matrices && lengths && places && model->coupling_begin;
    if (ok) {
        for (uint32_t h = 0; h < hinges; h++) {
            splits[h] = split_kink(shape, model, h);
            lengths[h] = measure_edge(shape, &model->hinges[h]);
            places[h] = TULLE_NONE;
        }
        for (size_t t = 0; t < triangles; t++)
            matrices[t] = measure_triangle(shape, model, t, NULL);
        coupling_work work = {.heap = heap,
                              .shape = shape,
                              .model = model,
                              .splits = splits,
                              .matrices = matrices,
                              .lengths = lengths,
                              .places = places};
        ok = build_rows(&work, model) && build_curvatures(&work, model);
        ARRAY_FREE(heap, &work.row.hinges);
        ARRAY_FREE(heap, &work.row.values);
    }
    memory_release(heap, splits, hinges * sizeof *splits);
    memory_release(heap, matrices, triangles * sizeof *matrices);
    memory_release(heap, lengths, hinges * sizeof *lengths);
    memory_release(heap, places, hinges * sizeof *places);
    return ok;
}
