/* dynamics/cloth_model.c - builds masses, springs and triangles of the cloth; hinges and the
 * bending matrix are in bending_matrix.c.
 *
 * Based on: Van Gelder, Approximate simulation of elastic membranes by triangulated spring meshes,
 * 1998: the stiffness of an edge is the membrane's (force per width and strain) times the area of
 * its triangles over its length squared. A mesh of equilateral triangles has then exactly the given
 * Young's modulus (with a Poisson ratio of 1/3), at every resolution; others come near it. */
#include "dynamics/cloth_model.h"

#include "base/error.h"
#include "dynamics/bending_matrix.h"

#include <math.h>
#include <string.h>

static const tulle_material *get_material(const cloth_model_def *def, uint32_t vertex) {
    return &def->materials[def->vertex_materials ? def->vertex_materials[vertex] : 0];
}

static double measure_area(const double *positions, const uint32_t *corners) {
    vec3 const a = vec3_load(positions, corners[0]);
    vec3 const b = vec3_sub(vec3_load(positions, corners[1]), a);
    vec3 const c = vec3_sub(vec3_load(positions, corners[2]), a);
    return 0.5 * vec3_norm(vec3_cross(b, c));
}

/* Triangles, edges and their adjacency come first in the topology, because cloth vertices do. */
static void count_parts(const cloth_model_def *def, cloth_model *model) {
    const topology *const surface = def->surface;
    size_t const limit = def->vertex_count;
    model->vertex_count = limit;
    model->surface = surface;
    while (model->triangle_count < surface->triangle_count &&
           surface->triangles[3 * model->triangle_count] < limit)
        model->triangle_count++;
    while (model->spring_count < surface->edge_count &&
           surface->edges[2 * model->spring_count] < limit)
        model->spring_count++;
    for (size_t e = 0; e < model->spring_count; e++)
        if (surface->edge_triangles[2 * e + 1] != TULLE_NONE) model->hinge_count++;
}

/* Spreads the triangles' mass and notes their rest areas. */
static tulle_status fill_triangles(const cloth_model_def *def, cloth_model *model, double *areas,
                                   tulle_error *error) {
    for (size_t t = 0; t < model->triangle_count; t++) {
        const uint32_t *const corners = cloth_get_corners(model, t);
        double const area = measure_area(def->rest_positions, corners);
        if (!(area > 0.0) || !isfinite(area))
            return error_set(error, TULLE_ERROR_INVALID_MESH,
                             "triangle %zu (vertices %u, %u, %u) has no area in the rest shape; "
                             "remove it or move its vertices apart",
                             t, corners[0], corners[1], corners[2]);
        for (int k = 0; k < 3; k++)
            model->masses[corners[k]] += get_material(def, corners[k])->area_density * area / 3.0;
        areas[t] = area;
    }
    for (size_t v = 0; v < def->vertex_count; v++) {
        if (!(model->masses[v] > 0.0))
            return error_set(error, TULLE_ERROR_INVALID_MESH,
                             "cloth vertex %zu belongs to no triangle and would have no mass", v);
        model->air_damping[v] = get_material(def, (uint32_t)v)->air_damping;
    }
    return TULLE_OK;
}

static tulle_status fill_springs(const cloth_model_def *def, cloth_model *model,
                                 const double *areas, tulle_error *error) {
    const topology *const surface = def->surface;
    for (size_t e = 0; e < model->spring_count; e++) {
        cloth_spring *const spring = &model->springs[e];
        double area = 0.0;
        for (int k = 0; k < 2; k++) {
            uint32_t const triangle = surface->edge_triangles[2 * e + (size_t)k];
            spring->vertices[k] = surface->edges[2 * e + (size_t)k];
            if (triangle != TULLE_NONE) area += areas[triangle];
        }
        double const length =
            vec3_norm(vec3_sub(vec3_load(def->rest_positions, spring->vertices[1]),
                               vec3_load(def->rest_positions, spring->vertices[0])));
        if (!(length > 0.0))
            return error_set(error, TULLE_ERROR_INVALID_MESH,
                             "cloth vertices %u and %u are at the same place in the rest shape",
                             spring->vertices[0], spring->vertices[1]);
        const tulle_material *const material = get_material(def, spring->vertices[0]);
        spring->rest_length = length;
        spring->stiffness = material->stretch_stiffness * area / (length * length);
        spring->damping = spring->stiffness * material->stretch_damping;
        double const limit = material->stiffening_strain * length;
        spring->stiffening = limit > 0.0 ? 1.0 / (limit * limit) : 0.0;
    }
    return TULLE_OK;
}

/* Blocks: the vertex itself and its neighbours, ascending. */
static void fill_block_pattern(const topology *surface, cloth_model *model) {
    uint32_t position = 0;
    for (uint32_t v = 0; v < model->vertex_count; v++) {
        bool has_diagonal = false;
        model->block_begin[v] = position;
        uint32_t const end = surface->vertex_edges.begin[v + 1];
        for (uint32_t k = surface->vertex_edges.begin[v]; k < end; k++) {
            uint32_t const edge = surface->vertex_edges.items[k];
            const uint32_t *const ends = surface->edges + 2 * (size_t)edge;
            uint32_t const other = ends[0] == v ? ends[1] : ends[0];
            if (other > v && !has_diagonal) {
                has_diagonal = true;
                model->block_columns[position++] = v;
            }
            model->block_columns[position++] = other;
        }
        if (has_diagonal) continue;
        model->block_columns[position++] = v;
    }
    model->block_begin[model->vertex_count] = position;
}

/* Lists the uses of each vertex: item stride * i + k where vertices[stride * i + k] is the vertex.
 */
static bool build_uses(memory *heap, size_t vertex_count, size_t use_count,
                       const uint32_t *(*get)(const cloth_model *, size_t),
                       const cloth_model *model, adjacency *uses) {
    *uses = (adjacency){.count = vertex_count, .item_count = use_count};
    uses->begin = memory_allocate_zeroed(heap, vertex_count + 1, sizeof(uint32_t));
    uses->items = memory_allocate(heap, use_count * sizeof(uint32_t));
    if (!uses->begin || !uses->items) return false;
    for (size_t use = 0; use < use_count; use++) uses->begin[*get(model, use) + 1]++;
    for (size_t v = 0; v < vertex_count; v++) uses->begin[v + 1] += uses->begin[v];
    for (size_t use = 0; use < use_count; use++)
        uses->items[uses->begin[*get(model, use)]++] = (uint32_t)use;
    for (size_t v = vertex_count; v > 0; v--) uses->begin[v] = uses->begin[v - 1];
    uses->begin[0] = 0;
    return true;
}

static const uint32_t *get_hinge_use(const cloth_model *model, size_t use) {
    return &model->hinges[use / 4].vertices[use % 4];
}

static bool allocate_model(memory *heap, cloth_model *model) {
    size_t const vertices = model->vertex_count;
    model->block_count = vertices + 2 * model->spring_count;
    model->masses = memory_allocate_zeroed(heap, vertices, sizeof(double));
    model->air_damping = memory_allocate_zeroed(heap, vertices, sizeof(double));
    model->springs = memory_allocate_zeroed(heap, model->spring_count, sizeof *model->springs);
    model->hinges = memory_allocate_zeroed(heap, model->hinge_count, sizeof *model->hinges);
    model->block_begin = memory_allocate_zeroed(heap, vertices + 1, sizeof(uint32_t));
    model->block_columns = memory_allocate_zeroed(heap, model->block_count, sizeof(uint32_t));
    return model->masses && model->air_damping && model->springs && model->hinges &&
           model->block_begin && model->block_columns;
}

/* Everything, given room for the triangles' numbers and areas. */
static tulle_status build_parts(memory *heap, const cloth_model_def *def, cloth_model *model,
                                double *areas, tulle_error *error) {
    tulle_status status = fill_triangles(def, model, areas, error);
    if (status == TULLE_OK) status = fill_springs(def, model, areas, error);
    if (status != TULLE_OK) return status;
    fill_block_pattern(def->surface, model);
    bending_input const input = {def->surface, def->rest_positions, def->materials,
                                 def->vertex_materials, areas};
    if (!bending_build_hinges(heap, &input, model) ||
        !build_uses(heap, model->vertex_count, 4 * model->hinge_count, get_hinge_use, model,
                    &model->vertex_hinges) ||
        !bending_build_matrix(heap, model))
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory for the cloth's bending");
    return TULLE_OK;
}

tulle_status cloth_model_build(memory *heap, const cloth_model_def *def, cloth_model *model,
                               tulle_error *error) {
    cloth_model result = {0};
    count_parts(def, &result);
    double *const areas = memory_allocate_zeroed(heap, result.triangle_count, sizeof(double));
    tulle_status status;
    if (allocate_model(heap, &result) && areas)
        status = build_parts(heap, def, &result, areas, error);
    else
        status = error_set(error, TULLE_ERROR_OUT_OF_MEMORY,
                           "no memory for the model of %zu cloth vertices", def->vertex_count);
    memory_release(heap, areas, result.triangle_count * sizeof(double));
    if (status != TULLE_OK)
        cloth_model_destroy(heap, &result);
    else
        *model = result;
    return status;
}

static void destroy_uses(memory *heap, adjacency *uses) {
    memory_release(heap, uses->begin, (uses->count + 1) * sizeof(uint32_t));
    memory_release(heap, uses->items, uses->item_count * sizeof(uint32_t));
}

void cloth_model_destroy(memory *heap, cloth_model *model) {
    size_t const vertices = model->vertex_count;
    memory_release(heap, model->masses, vertices * sizeof(double));
    memory_release(heap, model->air_damping, vertices * sizeof(double));
    memory_release(heap, model->springs, model->spring_count * sizeof *model->springs);
    memory_release(heap, model->hinges, model->hinge_count * sizeof *model->hinges);
    memory_release(heap, model->block_begin, (vertices + 1) * sizeof(uint32_t));
    memory_release(heap, model->block_columns, model->block_count * sizeof(uint32_t));
    destroy_uses(heap, &model->vertex_hinges);
    bending_destroy(heap, model);
    *model = (cloth_model){0};
}
