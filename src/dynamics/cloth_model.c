/* dynamics/cloth_model.c - builds masses, springs or elements, and the pattern of the system;
 * hinges and the bending matrix are in bending_matrix.c.
 *
 * Based on: Van Gelder, Approximate simulation of elastic membranes by triangulated spring meshes,
 * 1998: the stiffness of an edge is the membrane's (force per width and strain) times the area of
 * its triangles over its length squared. A mesh of equilateral triangles has then exactly the given
 * Young's modulus (with a Poisson ratio of 1/3), at every resolution; others come near it. */
#include "dynamics/cloth_model.h"

#include "base/error.h"
#include "dynamics/bending_matrix.h"
#include "dynamics/hysteresis.h"
#include "dynamics/yarn_frame.h"

#include <math.h>
#include <string.h>

/* Spreads the triangles' mass and notes their rest areas. */
static tulle_status fill_triangles(const cloth_model_def *def, cloth_model *model, double *areas,
                                   tulle_error *error) {
    for (size_t t = 0; t < model->triangle_count; t++) {
        const uint32_t *const corners = model->surface->triangles + 3 * t;
        vec3 const a = cloth_get_rest(def, t, corners[0]);
        vec3 const b = vec3_sub(cloth_get_rest(def, t, corners[1]), a);
        vec3 const c = vec3_sub(cloth_get_rest(def, t, corners[2]), a);
        double const area = 0.5 * vec3_norm(vec3_cross(b, c));
        if (!(area > 0.0) || !isfinite(area))
            return error_set(error, TULLE_ERROR_INVALID_MESH,
                             "triangle %zu (vertices %u, %u, %u) has no area in the rest shape; "
                             "remove it or move its vertices apart",
                             t, corners[0], corners[1], corners[2]);
        for (int k = 0; k < 3; k++)
            model->masses[corners[k]] +=
                cloth_get_material(def, corners[k])->area_density * area / 3.0;
        areas[t] = area;
    }
    for (size_t v = 0; v < def->vertex_count; v++) {
        if (!(model->masses[v] > 0.0))
            return error_set(error, TULLE_ERROR_INVALID_MESH,
                             "cloth vertex %zu belongs to no triangle and would have no mass", v);
        model->air_damping[v] = cloth_get_material(def, (uint32_t)v)->air_damping;
    }
    return TULLE_OK;
}

/* [m] The length of an edge at rest; the mean of both triangles' where they differ. */
static double measure_edge(const cloth_model_def *def, size_t edge) {
    const uint32_t *const ends = def->surface->edges + 2 * edge;
    const uint32_t *const triangles = def->surface->edge_triangles + 2 * edge;
    double lengths[2];
    for (int side = 0; side < 2; side++) {
        size_t const triangle = triangles[side] == TULLE_NONE ? triangles[0] : triangles[side];
        lengths[side] = vec3_norm(vec3_sub(cloth_get_rest(def, triangle, ends[1]),
                                           cloth_get_rest(def, triangle, ends[0])));
    }
    return 0.5 * (lengths[0] + lengths[1]);
}

static tulle_status check_edges(const cloth_model_def *def, const cloth_model *model,
                                tulle_error *error) {
    for (size_t e = 0; e < model->edge_count; e++) {
        const uint32_t *const ends = def->surface->edges + 2 * e;
        if (!(measure_edge(def, e) > 0.0))
            return error_set(error, TULLE_ERROR_INVALID_MESH,
                             "cloth vertices %u and %u are at the same place in the rest shape",
                             ends[0], ends[1]);
    }
    return TULLE_OK;
}

static bool build_springs(memory *heap, const cloth_model_def *def, cloth_model *model,
                          const double *areas) {
    const topology *const surface = def->surface;
    const double *const factors = def->stiffness_factors;
    model->springs = memory_allocate_zeroed(heap, model->edge_count, sizeof *model->springs);
    if (!model->springs) return false;
    for (size_t e = 0; e < model->edge_count; e++) {
        cloth_spring *const spring = &model->springs[e];
        double area = 0.0;
        for (int k = 0; k < 2; k++) {
            uint32_t const triangle = surface->edge_triangles[2 * e + (size_t)k];
            spring->vertices[k] = surface->edges[2 * e + (size_t)k];
            if (triangle == TULLE_NONE) continue;
            area += areas[triangle] * (factors ? factors[triangle] : 1.0);
        }
        double const length = measure_edge(def, e);
        const tulle_material *const material = cloth_get_material(def, spring->vertices[0]);
        spring->rest_length = length;
        spring->stiffness = material->springs.stretch_stiffness * area / (length * length);
        spring->damping = spring->stiffness * material->stretch_damping;
        double const limit = material->springs.stiffening_strain * length;
        spring->stiffening = limit > 0.0 ? 1.0 / (limit * limit) : 0.0;
    }
    return true;
}

/* A guess may go beyond the start by this share of a knee: there the slope has changed little. */
static const double GUESS_SHARE = 0.5;

static membrane_curve make_curve(const tulle_curve *curve) {
    bool const has_knee = curve->knee > 0.0;
    return (membrane_curve){.stiffness = curve->stiffness,
                            .inv_knee2 = has_knee ? 1.0 / (curve->knee * curve->knee) : 0.0,
                            .limit = curve->limit,
                            .guess_room = has_knee ? GUESS_SHARE * curve->knee : (double)INFINITY};
}

static bool build_elements(memory *heap, const cloth_model_def *def, cloth_model *model,
                           const double *areas) {
    const topology *const surface = def->surface;
    const double *const factors = def->stiffness_factors;
    size_t const triangles = model->triangle_count;
    model->fabric_count = def->material_count;
    model->elements = memory_allocate_zeroed(heap, triangles, sizeof *model->elements);
    model->fabrics = memory_allocate_zeroed(heap, model->fabric_count, sizeof *model->fabrics);
    model->edge_places = memory_allocate(heap, 2 * model->edge_count * sizeof(uint32_t));
    if (!model->elements || !model->fabrics || !model->edge_places) return false;
    for (size_t i = 0; i < model->fabric_count; i++) {
        const tulle_material *const m = &def->materials[i];
        double const mean_stiffness = sqrt(m->warp.stiffness * m->weft.stiffness);
        model->fabrics[i] = (membrane_fabric){.yarns = {make_curve(&m->warp), make_curve(&m->weft)},
                                              .shear = make_curve(&m->shear),
                                              .coupling = m->poisson * mean_stiffness,
                                              .damping = m->stretch_damping};
    }
    uint32_t const none = (uint32_t)cloth_count_places(model);
    for (size_t i = 0; i < 2 * model->edge_count; i++) model->edge_places[i] = none;
    for (size_t t = 0; t < triangles; t++) {
        const uint32_t *const corners = surface->triangles + 3 * t;
        membrane_element *const element = &model->elements[t];
        vec3 const origin = cloth_get_rest(def, t, corners[0]);
        vec3 const left = vec3_sub(cloth_get_rest(def, t, corners[1]), origin);
        vec3 const right = vec3_sub(cloth_get_rest(def, t, corners[2]), origin);
        yarn_frame const frame = yarn_frame_make(def, t);
        /* The inverse of the edges in the frame of the yarns. */
        double const u1 = vec3_dot(left, frame.warp), v1 = vec3_dot(left, frame.weft);
        double const u2 = vec3_dot(right, frame.warp), v2 = vec3_dot(right, frame.weft);
        double const inverse = 1.0 / (2.0 * areas[t]);
        *element = (membrane_element){
            .gradients = {{v2 * inverse, -u2 * inverse}, {-v1 * inverse, u1 * inverse}},
            .area = areas[t] * (factors ? factors[t] : 1.0),
            .corners = {corners[0], corners[1], corners[2]},
            .fabric = def->vertex_materials ? def->vertex_materials[corners[0]] : 0};
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t *const places =
                model->edge_places + 2 * (size_t)surface->triangle_edges[3 * t + k];
            places[places[0] != none] = (uint32_t)(3 * t) + k;
        }
    }
    return true;
}

tulle_status cloth_model_build(memory *heap, const cloth_model_def *def, cloth_model *model,
                               tulle_error *error) {
    const topology *const surface = def->surface;
    size_t const vertices = def->vertex_count;
    cloth_model result = {.vertex_count = vertices, .surface = surface};

    /* The cloth's triangles and edges come first in the topology, because its vertices do. */
    while (result.triangle_count < surface->triangle_count &&
           surface->triangles[3 * result.triangle_count] < vertices)
        result.triangle_count++;
    while (result.edge_count < surface->edge_count &&
           surface->edges[2 * result.edge_count] < vertices)
        result.edge_count++;
    for (size_t e = 0; e < result.edge_count; e++)
        if (surface->edge_triangles[2 * e + 1] != TULLE_NONE) result.hinge_count++;
    result.block_count = vertices + 2 * result.edge_count;

    result.masses = memory_allocate_zeroed(heap, vertices, sizeof(double));
    result.air_damping = memory_allocate_zeroed(heap, vertices, sizeof(double));
    result.hinges = memory_allocate_zeroed(heap, result.hinge_count, sizeof *result.hinges);
    result.block_begin = memory_allocate_zeroed(heap, vertices + 1, sizeof(uint32_t));
    result.block_columns = memory_allocate_zeroed(heap, result.block_count, sizeof(uint32_t));
    result.vertex_corners = memory_allocate(heap, 3 * result.triangle_count * sizeof(uint32_t));
    double *const areas = memory_allocate_zeroed(heap, result.triangle_count, sizeof(double));
    tulle_status status = TULLE_OK;
    if (!result.masses || !result.air_damping || !result.hinges || !result.block_begin ||
        !result.block_columns || !result.vertex_corners || !areas)
        status = error_set(error, TULLE_ERROR_OUT_OF_MEMORY,
                           "no memory for the model of %zu cloth vertices", vertices);

    if (status == TULLE_OK) status = fill_triangles(def, &result, areas, error);
    if (status == TULLE_OK) status = check_edges(def, &result, error);
    if (status == TULLE_OK) {
        bool const is_woven = def->membrane == TULLE_MEMBRANE_WOVEN;
        if (!(is_woven ? build_elements : build_springs)(heap, def, &result, areas))
            status =
                error_set(error, TULLE_ERROR_OUT_OF_MEMORY,
                          "no memory for the membrane of %zu triangles", result.triangle_count);
    }
    if (status == TULLE_OK) {
        for (uint32_t v = 0; v < vertices; v++) {
            const adjacency *const around = &surface->vertex_triangles;
            for (uint32_t k = around->begin[v]; k < around->begin[v + 1]; k++) {
                uint32_t corner = 3 * around->items[k];
                while (surface->triangles[corner] != v) corner++;
                result.vertex_corners[k] = corner;
            }
        }
        /* Blocks: the vertex itself and its neighbours, ascending. */
        uint32_t position = 0;
        for (uint32_t v = 0; v < vertices; v++) {
            const adjacency *const around = &surface->vertex_neighbours;
            uint32_t k = around->begin[v];
            uint32_t const end = around->begin[v + 1];
            result.block_begin[v] = position;
            while (k < end && around->items[k] < v)
                result.block_columns[position++] = around->items[k++];
            result.block_columns[position++] = v;
            while (k < end) result.block_columns[position++] = around->items[k++];
        }
        result.block_begin[vertices] = position;

        if (!hysteresis_begin(heap, def, areas, &result) ||
            !bending_build_hinges(heap, def, areas, &result) ||
            !bending_build_matrix(heap, &result) || !hysteresis_finish(heap, &result))
            status =
                error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory for the cloth's bending");
        else if (result.bends_by_matrix && !result.sliders)
            bending_release_hinges(heap, &result);
    }
    memory_release(heap, areas, result.triangle_count * sizeof(double));
    if (status == TULLE_OK)
        *model = result;
    else
        cloth_model_destroy(heap, &result);
    return status;
}

void cloth_model_destroy(memory *heap, cloth_model *model) {
    size_t const vertices = model->vertex_count, triangles = model->triangle_count;
    size_t const hinges = model->hinge_count, couplings = HINGE_COUPLINGS * hinges;
    hysteresis_destroy(heap, model);
    memory_release(heap, model->masses, vertices * sizeof(double));
    memory_release(heap, model->air_damping, vertices * sizeof(double));
    memory_release(heap, model->springs, model->edge_count * sizeof *model->springs);
    memory_release(heap, model->elements, triangles * sizeof *model->elements);
    memory_release(heap, model->fabrics, model->fabric_count * sizeof *model->fabrics);
    memory_release(heap, model->edge_places, 2 * model->edge_count * sizeof(uint32_t));
    memory_release(heap, model->hinge_rests, hinges * sizeof *model->hinge_rests);
    bending_release_hinges(heap, model);
    memory_release(heap, model->side_couplings, couplings * sizeof(double));
    if (model->coupling_begin) {
        size_t const count = model->coupling_begin[hinges];
        memory_release(heap, model->coupling_hinges, count * sizeof(uint32_t));
        memory_release(heap, model->couplings, count * sizeof(double));
        memory_release(heap, model->coupling_begin, (hinges + 1) * sizeof(uint32_t));
    }
    memory_release(heap, model->damping_couplings, couplings * sizeof(double));
    bending_release_patches(heap, model);
    memory_release(heap, model->vertex_corners, 3 * triangles * sizeof(uint32_t));
    memory_release(heap, model->block_begin, (vertices + 1) * sizeof(uint32_t));
    memory_release(heap, model->block_columns, model->block_count * sizeof(uint32_t));
    memory_release(heap, model->scalar_begin, (vertices + 1) * sizeof(uint32_t));
    memory_release(heap, model->scalar_columns, model->scalar_count * sizeof(uint32_t));
    memory_release(heap, model->bend_blocks, model->block_count * sizeof(double));
    memory_release(heap, model->bend_block_damping, model->block_count * sizeof(double));
    memory_release(heap, model->bend_scalars, model->scalar_count * sizeof(double));
    memory_release(heap, model->bend_scalar_damping, model->scalar_count * sizeof(double));
    *model = (cloth_model){0};
}
