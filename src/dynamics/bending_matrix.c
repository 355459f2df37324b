/* dynamics/bending_matrix.c - hinges, and the constant bending matrix of all of them. The energy of
 * woven cloth is in bending_couplings.c; that of springs, and the damping of both, is here.
 *
 * Curvature of a triangle from its three hinges, S = sum_e c_e t_e t_e^T / (2 A), with t_e the unit
 * conormal of edge e in the rest plane and c_e (cloth_model.h) about edge length times fold angle.
 * Energy per triangle B/2 A |S|^2, B the plate's bending rigidity [N m], which is
 *
 *     B / (8 A) sum_ij (t_i . t_j)^2 c_i . c_j :
 *
 * quadratic in the positions with constant coefficients, never negative, and zero only if every
 * hinge is flat. S is exact for every quadratic surface over a regular mesh, so a cylinder costs
 * B/2 kappa^2 per area in every direction and at every resolution. A Poisson ratio of zero is used.
 *
 * Based on: Bergou, Wardetzky, Harmon, Zorin, Grinspun, A quadratic bending model for inextensible
 * surfaces, 2006 (c linear in the positions under isometry); Grinspun, Gingold, Reisman, Zorin,
 * Computing discrete shape operators on general meshes, 2006 (S from the three edges). Departure:
 * the first paper sums the energies of single hinges. That sum depends on the direction: a cylinder
 * along the legs of a right-triangle mesh has three times its energy. The shape operator gives
 * every direction the same. */
#include "dynamics/bending_matrix.h"

#include "base/sort.h"
#include "dynamics/bending.h"
#include "dynamics/bending_couplings.h"

#include <math.h>
#include <string.h>

/* Triangles are slivers below this ratio of height to longest edge. Their hinges soften in
 * proportion, so that they do not make the matrix arbitrarily stiff. Meshes made for cloth have
 * none. */
static const double SLIVER_RATIO = 0.1;
/* [rad] Fold angles below this are rounding of a flat rest shape. */
static const double FLAT_ANGLE = 1e-7;

/* The rest value of c along the hinge normal (bending.c), unless the fold is only rounding. */
static double measure_curvature(const cloth_model_def *def, const cloth_hinge *hinge,
                                const cloth_hinge_rest *rest) {
    const double *const positions = def->rest_positions;
    vec3 const origin = vec3_load(positions, hinge->vertices[0]);
    vec3 const along = vec3_sub(vec3_load(positions, hinge->vertices[1]), origin);
    vec3 offsets[2]; /* of corners 2 and 3 */
    for (int side = 0; side < 2; side++)
        offsets[side] = vec3_sub(vec3_load(positions, hinge->vertices[2 + side]), origin);
    vec3 const across = vec3_sub(vec3_scale(offsets[0], rest->inv_double_areas[0]),
                                 vec3_scale(offsets[1], rest->inv_double_areas[1]));
    vec3 const normal = vec3_normalize(vec3_cross(along, across));
    double const value = vec3_dot(normal, bend_sum_corners(hinge, positions));
    return fabs(value) > FLAT_ANGLE * vec3_norm(along) ? value : 0.0;
}

/* [m] of the hinge's edge at rest: the mean of both triangles. */
static double measure_rest_edge(const cloth_model_def *def, const cloth_hinge *hinge) {
    double length = 0.0;
    for (int side = 0; side < 2; side++) {
        size_t const triangle = hinge->sides[side] / 3;
        length += 0.5 * vec3_norm(vec3_sub(cloth_get_rest(def, triangle, hinge->vertices[1]),
                                           cloth_get_rest(def, triangle, hinge->vertices[0])));
    }
    return length;
}

/* The same where lengths at rest are not those of rest_positions, from the fold alone: the edge's
 * length times the sum of both sides' outward unit conormals. */
static double measure_kink(const cloth_model_def *def, const cloth_hinge *hinge) {
    const double *const positions = def->rest_positions;
    vec3 const origin = vec3_load(positions, hinge->vertices[0]);
    vec3 const along = vec3_sub(vec3_load(positions, hinge->vertices[1]), origin);
    double const inverse = 1.0 / vec3_norm2(along);
    vec3 conormals[2];
    for (int side = 0; side < 2; side++) {
        vec3 const offset = vec3_sub(vec3_load(positions, hinge->vertices[2 + side]), origin);
        double const foot = vec3_dot(offset, along) * inverse;
        conormals[side] = vec3_normalize(vec3_add_scaled(offset, along, -foot));
    }
    vec3 const sum = vec3_add(conormals[0], conormals[1]); /* inwards */
    vec3 const normal = vec3_normalize(vec3_cross(along, vec3_sub(conormals[0], conormals[1])));
    double const angle = -vec3_dot(normal, sum);
    return fabs(angle) > FLAT_ANGLE ? measure_rest_edge(def, hinge) * angle : 0.0;
}

/* Fills hinge geometry and its softening in (0, 1]. */
static double fill_hinge(const cloth_model_def *def, const double *areas, size_t edge,
                         cloth_hinge *hinge, cloth_hinge_rest *rest) {
    const topology *const surface = def->surface;
    double softening = 1.0;
    for (size_t k = 0; k < 2; k++) {
        size_t const triangle = surface->edge_triangles[2 * edge + k];
        const uint32_t *const corners = surface->triangles + 3 * triangle;
        double const area = areas[triangle];
        uint32_t side = (uint32_t)(3 * triangle);
        while (surface->triangle_edges[side] != edge) side++;
        hinge->vertices[k] = surface->edges[2 * edge + k];
        hinge->vertices[2 + k] = surface->edge_opposites[2 * edge + k];
        rest->inv_double_areas[k] = 0.5 / area;
        hinge->sides[k] = side;
        double longest2 = 0.0;
        for (int i = 0; i < 3; i++)
            longest2 = fmax(longest2,
                            vec3_norm2(vec3_sub(cloth_get_rest(def, triangle, corners[(i + 1) % 3]),
                                                cloth_get_rest(def, triangle, corners[i]))));
        softening = fmin(softening, 2.0 * area / longest2 / SLIVER_RATIO);
    }
    /* Weights: the outward conormal of each side, times the edge length. */
    for (int side = 0; side < 2; side++) {
        size_t const triangle = surface->edge_triangles[2 * edge + (size_t)side];
        vec3 const origin = cloth_get_rest(def, triangle, hinge->vertices[0]);
        vec3 const along = vec3_sub(cloth_get_rest(def, triangle, hinge->vertices[1]), origin);
        vec3 const offset =
            vec3_sub(cloth_get_rest(def, triangle, hinge->vertices[2 + side]), origin);
        double const foot = vec3_dot(offset, along) / vec3_norm2(along);
        double const slope = vec3_norm2(along) * rest->inv_double_areas[side];
        hinge->weights[2 + side] -= slope;
        hinge->weights[0] += slope * (1.0 - foot);
        hinge->weights[1] += slope * foot;
    }
    bool const is_flat =
        def->has_flat_rest &&
        def->has_flat_rest[def->vertex_materials ? def->vertex_materials[hinge->vertices[0]] : 0];
    if (def->edge_folds && !isnan(def->edge_folds[edge])) {
        /* Each conormal is turned by half the fold. Folds are seen from the front. */
        rest->curvature = 2.0 * sin(0.5 * def->edge_folds[edge]) * measure_rest_edge(def, hinge) *
                          bend_find_sign(surface, hinge);
        return softening;
    }
    rest->curvature = is_flat             ? 0.0
                      : def->rest_corners ? measure_kink(def, hinge)
                                          : measure_curvature(def, hinge, rest);
    return softening;
}

typedef struct coupling_builder {
    const cloth_model_def *def;
    const double *areas; /* by triangle */
    cloth_model *model;
    const uint32_t *edge_hinges; /* by edge; TULLE_NONE for borders */
    const double *softening;     /* by hinge */
} coupling_builder;

/* Fills the couplings of the hinge of an edge through one of its triangles. */
static void add_couplings(const coupling_builder *build, size_t edge, size_t side) {
    const cloth_model_def *const def = build->def;
    const topology *const surface = def->surface;
    cloth_model *const model = build->model;
    size_t const triangle = surface->edge_triangles[2 * edge + side];
    cloth_patches *const patches = &model->patches[triangle / PATCH_LANES];
    size_t const lane = triangle % PATCH_LANES;
    const uint32_t *const corners = surface->triangles + 3 * triangle;
    const uint32_t *const edges = surface->triangle_edges + 3 * triangle;
    uint32_t const hinge = build->edge_hinges[edge];
    size_t const own = model->hinges[hinge].sides[side] % 3;
    size_t const self = HINGE_COUPLINGS * (size_t)hinge;
    size_t place = self + 1 + 2 * side;
    const tulle_material *const material = cloth_get_material(def, corners[0]);
    double const rigidity =
        def->membrane == TULLE_MEMBRANE_WOVEN
            ? (material->bend_warp + material->bend_weft + 2.0 * material->bend_twist) / 3.0
            : material->springs.bend_stiffness;
    double const stiffness = rigidity *
                             (def->stiffness_factors ? def->stiffness_factors[triangle] : 1.0) /
                             (4.0 * build->areas[triangle]);
    vec3 edges_of[3]; /* edge k joins corners k and k + 1 */
    for (size_t k = 0; k < 3; k++)
        edges_of[k] = vec3_sub(cloth_get_rest(def, triangle, corners[(k + 1) % 3]),
                               cloth_get_rest(def, triangle, corners[k]));
    for (size_t k = 0; k < 3; k++) {
        uint32_t const other = build->edge_hinges[edges[k]];
        size_t const at = k == own ? self : place++;
        model->triangle_hinges[3 * triangle + k] = other;
        if (other == TULLE_NONE) continue;
        double const dot = vec3_dot(edges_of[own], edges_of[k]);
        double const cosine2 =
            k == own ? 1.0 : dot * dot / (vec3_norm2(edges_of[own]) * vec3_norm2(edges_of[k]));
        double const value =
            stiffness * build->softening[hinge] * build->softening[other] * cosine2;
        model->side_couplings[at] += value;
        model->damping_couplings[at] += value * material->bend_damping;
        double *const numbers = k == own ? patches->own[k] : patches->cross[3 - own - k];
        numbers[lane] = value * material->bend_damping;
        model->has_bending |= value > 0.0;
        model->has_bend_damping |= value * material->bend_damping > 0.0;
    }
}

/* The weights of the hinge of edge k of a triangle, and the far corner. Cloth is manifold: a hinge
 * has no third triangle. */
static void fill_patch_hinge(cloth_model *model, size_t triangle, size_t k) {
    cloth_patches *const patches = &model->patches[triangle / PATCH_LANES];
    size_t const lane = triangle % PATCH_LANES;
    const uint32_t *const corners = model->surface->triangles + 3 * triangle;
    uint32_t const found = model->triangle_hinges[3 * triangle + k];
    patches->fars[k][lane] = corners[0];
    if (found == TULLE_NONE) return;
    const cloth_hinge *const hinge = &model->hinges[found];
    size_t const beyond = hinge->sides[0] == 3 * triangle + k ? 3 : 2;
    patches->fars[k][lane] = hinge->vertices[beyond];
    patches->weights[k][2][lane] = hinge->weights[beyond];
    for (size_t i = 0; i < 4; i++)
        for (size_t corner = 1; corner < 3 && i != beyond; corner++)
            if (hinge->vertices[i] == corners[corner])
                patches->weights[k][corner - 1][lane] = hinge->weights[i];
}

/* What damping needs beside the couplings. False: no memory. */
static bool fill_patches(memory *heap, const double *areas, cloth_model *model) {
    size_t const triangles = model->triangle_count, vertices = model->vertex_count;
    const uint32_t *const around = model->surface->vertex_triangles.begin;
    adjacency *const uses = &model->vertex_fars;
    *uses = (adjacency){.count = vertices};
    for (size_t i = 0; i < 3 * triangles; i++)
        uses->item_count += model->triangle_hinges[i] != TULLE_NONE;
    uses->begin = memory_allocate_zeroed(heap, vertices + 1, sizeof(uint32_t));
    uses->items = memory_allocate(heap, uses->item_count * sizeof(uint32_t));
    if (!uses->begin || !uses->items) return false;
    for (size_t t = 0; t < triangles; t++) {
        cloth_patches *const patches = &model->patches[t / PATCH_LANES];
        size_t const lane = t % PATCH_LANES;
        const uint32_t *const corners = model->surface->triangles + 3 * t;
        double most = 0.0, strength = 0.0;
        for (size_t k = 0; k < 3; k++) {
            fill_patch_hinge(model, t, k);
            strength += patches->own[k][lane];
            most = fmax(most, around[corners[k] + 1] - around[corners[k]]);
        }
        patches->rest_double_areas[lane] = 2.0 * areas[t];
        for (size_t k = 0; k < 3; k++)
            patches->turning_rates[k][lane] = strength * most / model->masses[corners[k]];
    }
    /* As above, filling moves each begin to its end. */
    for (int pass = 0; pass < 2; pass++) {
        for (size_t i = 0; i < 3 * triangles; i++) {
            if (model->triangle_hinges[i] == TULLE_NONE) continue;
            size_t const t = i / 3;
            uint32_t const far = model->patches[t / PATCH_LANES].fars[i % 3][t % PATCH_LANES];
            if (pass == 0)
                uses->begin[far + 1]++;
            else
                uses->items[uses->begin[far]++] = (uint32_t)i;
        }
        for (size_t v = 0; v < vertices && pass == 0; v++) uses->begin[v + 1] += uses->begin[v];
    }
    for (size_t v = vertices; v > 0; v--) uses->begin[v] = uses->begin[v - 1];
    uses->begin[0] = 0;
    return true;
}

void bending_release_patches(memory *heap, cloth_model *model) {
    adjacency *const uses = &model->vertex_fars;
    memory_release(heap, model->patches, cloth_count_patches(model) * sizeof *model->patches);
    memory_release(heap, uses->begin, (uses->count + 1) * sizeof(uint32_t));
    memory_release(heap, uses->items, uses->item_count * sizeof(uint32_t));
    model->patches = NULL;
    *uses = (adjacency){0};
}

void bending_release_hinges(memory *heap, cloth_model *model) {
    size_t const hinges = model->hinge_count;
    adjacency *const uses = &model->vertex_hinges;
    memory_release(heap, model->hinges, hinges * sizeof *model->hinges);
    memory_release(heap, model->triangle_hinges, 3 * model->triangle_count * sizeof(uint32_t));
    memory_release(heap, uses->begin, (uses->count + 1) * sizeof(uint32_t));
    memory_release(heap, uses->items, uses->item_count * sizeof(uint32_t));
    model->hinges = NULL;
    model->triangle_hinges = NULL;
    *uses = (adjacency){0};
}

bool bending_build_hinges(memory *heap, const cloth_model_def *def, const double *areas,
                          cloth_model *model) {
    size_t const hinges = model->hinge_count, triangles = model->triangle_count;
    size_t const vertices = model->vertex_count, use_count = 4 * hinges;
    size_t const couplings = HINGE_COUPLINGS * hinges;
    uint32_t *const edge_hinges = memory_allocate(heap, model->edge_count * sizeof(uint32_t));
    double *const softening = memory_allocate(heap, hinges * sizeof(double));
    model->hinge_rests = memory_allocate_zeroed(heap, hinges, sizeof *model->hinge_rests);
    model->triangle_hinges = memory_allocate_zeroed(heap, 3 * triangles, sizeof(uint32_t));
    model->side_couplings = memory_allocate_zeroed(heap, couplings, sizeof(double));
    model->damping_couplings = memory_allocate_zeroed(heap, couplings, sizeof(double));
    model->patches =
        memory_allocate_zeroed(heap, cloth_count_patches(model), sizeof *model->patches);
    adjacency *const uses = &model->vertex_hinges;
    *uses = (adjacency){.count = vertices, .item_count = use_count};
    uses->begin = memory_allocate_zeroed(heap, vertices + 1, sizeof(uint32_t));
    uses->items = memory_allocate(heap, use_count * sizeof(uint32_t));
    bool ok = edge_hinges && softening && model->hinge_rests && model->triangle_hinges &&
              model->side_couplings && model->damping_couplings && model->patches && uses->begin &&
              uses->items;
    if (ok) {
        uint32_t hinge = 0;
        for (size_t edge = 0; edge < model->edge_count; edge++) {
            edge_hinges[edge] = TULLE_NONE;
            if (def->surface->edge_triangles[2 * edge + 1] == TULLE_NONE) continue;
            cloth_hinge_rest *const rest = &model->hinge_rests[hinge];
            softening[hinge] = fill_hinge(def, areas, edge, &model->hinges[hinge], rest);
            model->has_curved_rest |= rest->curvature != 0.0;
            edge_hinges[edge] = hinge++;
        }
        if (!model->has_curved_rest) {
            memory_release(heap, model->hinge_rests, hinges * sizeof *model->hinge_rests);
            model->hinge_rests = NULL;
        }
        coupling_builder const build = {def, areas, model, edge_hinges, softening};
        for (size_t k = 0; k < 3 * triangles; k++) model->triangle_hinges[k] = TULLE_NONE;
        for (size_t edge = 0; edge < model->edge_count; edge++)
            for (size_t side = 0; side < 2 && edge_hinges[edge] != TULLE_NONE; side++)
                add_couplings(&build, edge, side);

        bending_shape const shape = {def, areas, softening};
        ok = def->membrane != TULLE_MEMBRANE_WOVEN || bending_build_couplings(heap, &shape, model);
    }
    if (ok && model->has_bend_damping)
        ok = fill_patches(heap, areas, model);
    else
        bending_release_patches(heap, model);
    if (ok) {
        /* The hinges of each vertex, as 4 * hinge + corner. Filling moves each begin to its end. */
        for (size_t use = 0; use < use_count; use++)
            uses->begin[model->hinges[use / 4].vertices[use % 4] + 1]++;
        for (size_t v = 0; v < vertices; v++) uses->begin[v + 1] += uses->begin[v];
        for (size_t use = 0; use < use_count; use++)
            uses->items[uses->begin[model->hinges[use / 4].vertices[use % 4]]++] = (uint32_t)use;
        for (size_t v = vertices; v > 0; v--) uses->begin[v] = uses->begin[v - 1];
        uses->begin[0] = 0;
    }
    memory_release(heap, edge_hinges, model->edge_count * sizeof(uint32_t));
    memory_release(heap, softening, hinges * sizeof(double));
    return ok;
}

/* An entry of one row. */
typedef struct row_entry {
    uint32_t column;
    double stiffness, damping;
} row_entry;

static int compare_entries(const void *a, const void *b) {
    const row_entry *const left = a, *const right = b;
    return (left->column > right->column) - (left->column < right->column);
}

typedef ARRAY(row_entry) entry_array;

/* Adds a hinge's weights times `weight` and a coupling to a row. */
static bool add_products(memory *heap, const cloth_hinge *hinge, double weight, row_entry coupling,
                         uint32_t *places, entry_array *row) {
    if (!ARRAY_RESERVE(heap, row, 4)) return false;
    for (int k = 0; k < 4; k++) {
        double const product = weight * hinge->weights[k];
        uint32_t *const place = &places[hinge->vertices[k]];
        if (*place == TULLE_NONE) {
            *place = (uint32_t)row->count;
            row->data[row->count++] = (row_entry){hinge->vertices[k], product * coupling.stiffness,
                                                  product * coupling.damping};
        } else {
            row->data[*place].stiffness += product * coupling.stiffness;
            row->data[*place].damping += product * coupling.damping;
        }
    }
    return true;
}

/* Row `vertex` of K^T C K, K the hinge weights and C the couplings, sorted. Products of one column
 * are added in the order in which they arrive. `places` is TULLE_NONE for each vertex, before and
 * after. */
static bool collect_row(memory *heap, const cloth_model *model, uint32_t vertex, uint32_t *places,
                        entry_array *row) {
    const adjacency *const uses = &model->vertex_hinges;
    row->count = 0;
    for (uint32_t u = uses->begin[vertex]; u < uses->begin[vertex + 1]; u++) {
        uint32_t const hinge = uses->items[u] / 4;
        double const weight = model->hinges[hinge].weights[uses->items[u] % 4];
        uint32_t hinges[HINGE_COUPLINGS];
        size_t sides[HINGE_COUPLINGS];
        size_t const count = bend_list_sides(model, hinge, hinges, sides);
        for (size_t k = 0; k < count; k++) {
            double const stiffness = model->couplings ? 0.0 : model->side_couplings[sides[k]];
            row_entry const both = {0, stiffness, model->damping_couplings[sides[k]]};
            if (!add_products(heap, &model->hinges[hinges[k]], weight, both, places, row))
                return false;
        }
        if (!model->couplings) continue;
        for (size_t k = model->coupling_begin[hinge]; k < model->coupling_begin[hinge + 1]; k++)
            if (!add_products(heap, &model->hinges[model->coupling_hinges[k]], weight,
                              (row_entry){.stiffness = model->couplings[k]}, places, row))
                return false;
    }
    for (size_t i = 0; i < row->count; i++) places[row->data[i].column] = TULLE_NONE;
    sort_in_place(row->data, row->count, sizeof *row->data, compare_entries);
    return true;
}

/* Entries of all rows: those of blocks to the blocks, the others to the scalars. The first of two
 * walks only counts the scalars, for which there is no room yet. */
static bool walk_rows(memory *heap, cloth_model *model, uint32_t *places, entry_array *row) {
    size_t count = 0;
    for (uint32_t v = 0; model->has_bending && v < model->vertex_count; v++) {
        if (!collect_row(heap, model, v, places, row)) return false;
        uint32_t block = model->block_begin[v];
        uint32_t const block_end = model->block_begin[v + 1];
        for (size_t i = 0; i < row->count; i++) {
            const row_entry *const entry = &row->data[i];
            while (block < block_end && model->block_columns[block] < entry->column) block++;
            if (block < block_end && model->block_columns[block] == entry->column) {
                model->bend_blocks[block] = entry->stiffness;
                model->bend_block_damping[block] = entry->damping;
                continue;
            }
            if (model->scalar_columns) {
                model->scalar_columns[count] = entry->column;
                model->bend_scalars[count] = entry->stiffness;
                model->bend_scalar_damping[count] = entry->damping;
            }
            count++;
        }
        model->scalar_begin[v + 1] = (uint32_t)count;
    }
    model->scalar_count = count;
    return true;
}

bool bending_build_matrix(memory *heap, cloth_model *model) {
    model->scalar_begin = memory_allocate_zeroed(heap, model->vertex_count + 1, sizeof(uint32_t));
    model->bend_blocks = memory_allocate_zeroed(heap, model->block_count, sizeof(double));
    model->bend_block_damping = memory_allocate_zeroed(heap, model->block_count, sizeof(double));
    uint32_t *const places = memory_allocate(heap, model->vertex_count * sizeof(uint32_t));
    entry_array row = {0};
    bool ok = model->scalar_begin && model->bend_blocks && model->bend_block_damping && places;
    if (places) memset(places, 0xff, model->vertex_count * sizeof(uint32_t));
    ok = ok && walk_rows(heap, model, places, &row);
    model->scalar_columns = memory_allocate(heap, model->scalar_count * sizeof(uint32_t));
    model->bend_scalars = memory_allocate(heap, model->scalar_count * sizeof(double));
    model->bend_scalar_damping = memory_allocate(heap, model->scalar_count * sizeof(double));
    ok = ok && model->scalar_columns && model->bend_scalars && model->bend_scalar_damping &&
         walk_rows(heap, model, places, &row);
    /* The matrix holds the couplings of the damping and, where all is flat at rest, the others. */
    memory_release(heap, model->damping_couplings,
                   HINGE_COUPLINGS * model->hinge_count * sizeof(double));
    model->damping_couplings = NULL;
    model->bends_by_matrix = !model->has_curved_rest;
    if (ok && model->couplings && model->bends_by_matrix) {
        size_t const count = model->coupling_begin[model->hinge_count];
        memory_release(heap, model->coupling_begin, (model->hinge_count + 1) * sizeof(uint32_t));
        memory_release(heap, model->coupling_hinges, count * sizeof(uint32_t));
        memory_release(heap, model->couplings, count * sizeof(double));
        model->coupling_begin = model->coupling_hinges = NULL;
        model->couplings = NULL;
    }
    if (ok && (model->couplings || model->bends_by_matrix)) {
        memory_release(heap, model->side_couplings,
                       HINGE_COUPLINGS * model->hinge_count * sizeof(double));
        model->side_couplings = NULL;
    }
    memory_release(heap, places, model->vertex_count * sizeof(uint32_t));
    ARRAY_FREE(heap, &row);
    return ok;
}
