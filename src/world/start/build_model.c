/* world/start/build_model.c - the cloth's model with its system matrix and preconditioner, from
 * what the cloths are at rest, their materials and their pins: at the start, and when a host
 * changes materials or lets go of pins. */
#include "base/error.h"
#include "contact/response.h"
#include "world/start/start.h"

#include <math.h>
#include <string.h>

/* Cloth of fewer vertices is solved as fast in double precision (20 x 20; 45 x 45 slower). */
enum { SINGLE_VERTICES = 1000 };

/* What cloth is like at rest, by triangle and by cloth, in scratch. */
typedef struct rest_arrays {
    double *warps;       /* 3 a triangle */
    double *corners;     /* 9 a triangle; null where no cloth has any */
    double *factors;     /* on the stiffness, one a triangle; null where no cloth has any */
    bool *has_flat_rest; /* by cloth */
} rest_arrays;

/* False without memory. */
static bool list_rest(tulle_world *world, rest_arrays *rest) {
    size_t triangle_count = 0;
    bool has_corners = false, has_factors = false;
    for (size_t i = 0; i < world->model.cloths.count; i++) {
        triangle_count += world->model.cloths.data[i].mesh.triangle_count;
        has_corners |= world->model.cloths.data[i].rest_corners != NULL;
        has_factors |= world->model.cloths.data[i].factors != NULL;
    }
    *rest = (rest_arrays){.warps = ARENA_NEW(&world->work.scratch, double, 3 * triangle_count),
                          .has_flat_rest =
                              ARENA_NEW(&world->work.scratch, bool, world->model.cloths.count)};
    if (has_corners) rest->corners = ARENA_NEW(&world->work.scratch, double, 9 * triangle_count);
    if (has_factors) rest->factors = ARENA_NEW(&world->work.scratch, double, triangle_count);
    if (!rest->warps || !rest->has_flat_rest || (has_corners && !rest->corners) ||
        (has_factors && !rest->factors))
        return false;
    double *warp = rest->warps, *corner = rest->corners, *factor = rest->factors;
    for (size_t i = 0; i < world->model.cloths.count; i++) {
        const world_cloth *const cloth = &world->model.cloths.data[i];
        rest->has_flat_rest[i] = cloth->has_flat_rest;
        for (size_t t = 0; t < cloth->mesh.triangle_count; t++, warp += 3)
            memcpy(warp, cloth->warps ? cloth->warps + 3 * t : cloth->grain, 3 * sizeof *warp);
        for (size_t t = 0; has_factors && t < cloth->mesh.triangle_count; t++)
            *factor++ = cloth->factors ? cloth->factors[t] : 1.0;
        for (size_t k = 0; has_corners && k < 3 * cloth->mesh.triangle_count; k++, corner += 3)
            memcpy(corner,
                   cloth->rest_corners ? cloth->rest_corners + 3 * k
                                       : world->model.rest + 3 * ((size_t)cloth->vertex_begin +
                                                                  cloth->mesh.triangles[k]),
                   3 * sizeof *corner);
    }
    return true;
}

/* By vertex of cloth: the pin that holds it for ever, counted from 1 over all cloths. What another
 * pin holds too may move otherwise for a while. False without memory. */
static bool list_clamps(tulle_world *world, const double *releases, uint32_t **clamps) {
    uint32_t *const held =
        ARENA_NEW(&world->work.scratch, uint32_t, world->model.cloth_vertex_count);
    *clamps = held;
    if (!held) return false;
    memset(held, 0, world->model.cloth_vertex_count * sizeof *held);
    uint32_t const several = TULLE_NONE;
    uint32_t number = 0;
    for (size_t i = 0; i < world->model.cloths.count; i++) {
        const world_cloth *const cloth = &world->model.cloths.data[i];
        for (size_t p = 0; p < cloth->pin_count; p++) {
            const world_pin *const pin = &cloth->pins[p];
            double const release = releases ? releases[number] : pin->release_time;
            bool const is_for_ever = release == (double)INFINITY;
            number++;
            for (size_t k = 0; k < pin->vertex_count; k++) {
                uint32_t *const clamp = &held[cloth->vertex_begin + pin->vertices[k]];
                bool const is_first = *clamp == 0 || *clamp == number;
                *clamp = is_for_ever && is_first ? number : several;
            }
        }
    }
    for (size_t v = 0; v < world->model.cloth_vertex_count; v++)
        if (held[v] == several) held[v] = 0;
    return true;
}

static size_t find_edge(const tulle_world *world, uint32_t a, uint32_t b) {
    uint32_t const low = a < b ? a : b, high = a < b ? b : a;
    const uint32_t *const edges = world->model.topo.edges;
    size_t begin = 0, end = world->model.cloth_edge_count;
    while (begin < end) {
        size_t const middle = begin + (end - begin) / 2;
        const uint32_t *const ends = edges + 2 * middle;
        if (ends[0] < low || (ends[0] == low && ends[1] < high))
            begin = middle + 1;
        else
            end = middle;
    }
    bool const is_there = begin < world->model.cloth_edge_count && edges[2 * begin] == low &&
                          edges[2 * begin + 1] == high;
    return is_there ? begin : SIZE_MAX;
}

/* By edge of cloth: the fold [rad] that a crease gives it; NaN: none does. Null without creases. */
static tulle_status list_folds(tulle_world *world, double **folds, tulle_error *error) {
    size_t count = 0;
    *folds = NULL;
    for (size_t i = 0; i < world->model.cloths.count; i++)
        count += world->model.cloths.data[i].crease_count;
    if (count == 0) return TULLE_OK;
    double *const by_edge = ARENA_NEW(&world->work.scratch, double, world->model.cloth_edge_count);
    if (!by_edge) return TULLE_ERROR_OUT_OF_MEMORY;
    for (size_t e = 0; e < world->model.cloth_edge_count; e++) by_edge[e] = (double)NAN;
    for (size_t i = 0; i < world->model.cloths.count; i++) {
        const world_cloth *const cloth = &world->model.cloths.data[i];
        for (size_t k = 0; k < cloth->crease_count; k++) {
            const tulle_crease *const crease = &cloth->creases[k];
            size_t const edge = find_edge(world, cloth->vertex_begin + crease->vertices[0],
                                          cloth->vertex_begin + crease->vertices[1]);
            if (edge == SIZE_MAX)
                return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                                 "'%s': crease %zu lies between vertices %u and %u, which no edge "
                                 "joins",
                                 cloth->name, k, crease->vertices[0], crease->vertices[1]);
            by_edge[edge] = crease->angle;
        }
    }
    *folds = by_edge;
    return TULLE_OK;
}

/* [kg] and so on: the model's def in scratch, from materials and pins as they are or as `settings`
 * has them. */
static tulle_status make_def(tulle_world *world, cloth_settings settings, cloth_model_def *def,
                             tulle_error *error) {
    size_t const cloth_count = world->model.cloths.count;
    tulle_material *const materials = ARENA_NEW(&world->work.scratch, tulle_material, cloth_count);
    rest_arrays rest;
    uint32_t *clamps;
    if (!materials || !list_rest(world, &rest) || !list_clamps(world, settings.releases, &clamps))
        return TULLE_ERROR_OUT_OF_MEMORY;
    double *folds;
    tulle_status const status = list_folds(world, &folds, error);
    if (status != TULLE_OK) return status;
    for (size_t i = 0; i < cloth_count; i++) {
        materials[i] =
            settings.materials ? settings.materials[i] : world->model.cloths.data[i].material;
        if (contact_responses[world->model.paper.response]->has_linear_springs) {
            materials[i].springs.stiffening_strain = 0.0;
            materials[i].warp.knee = materials[i].weft.knee = materials[i].shear.knee = 0.0;
        }
    }
    *def = (cloth_model_def){.vertex_count = world->model.cloth_vertex_count,
                             .surface = &world->model.topo,
                             .rest_positions = world->model.rest,
                             .materials = materials,
                             .material_count = cloth_count,
                             .vertex_materials = world->model.vertex_surface,
                             .membrane = world->model.def.membrane,
                             .rest_corners = rest.corners,
                             .has_flat_rest = rest.has_flat_rest,
                             .edge_folds = folds,
                             .vertex_clamps = clamps,
                             .warps = rest.warps,
                             .stiffness_factors = rest.factors};
    return TULLE_OK;
}

tulle_status world_build_machinery(tulle_world *world, cloth_settings settings,
                                   cloth_machinery *made, tulle_error *error) {
    arena_mark const mark = arena_get_mark(&world->work.scratch);
    memory *const heap = &world->heap;
    cloth_model_def def;
    *made = (cloth_machinery){0};
    tulle_status status = make_def(world, settings, &def, error);
    cloth_model *const model =
        status == TULLE_OK ? memory_allocate_zeroed(heap, 1, sizeof *model) : NULL;
    if (status == TULLE_OK && !model) status = TULLE_ERROR_OUT_OF_MEMORY;
    if (status == TULLE_OK) status = cloth_model_build(heap, &def, model, error);
    arena_release(&world->work.scratch, mark);
    if (status != TULLE_OK) {
        memory_release(heap, model, sizeof *model);
        return status;
    }
    made->model = model;
    bool const has_forces = contact_responses[world->model.paper.response]->needs_forces;
    status = linear_system_build(heap, model, has_forces, &made->system);
    if (status == TULLE_OK && world->model.cloth_vertex_count >= SINGLE_VERTICES) {
        made->aggregates =
            nested_aggregates_build(heap, &made->system.matrix, &world->work.scratch);
        if (!made->aggregates) status = TULLE_ERROR_OUT_OF_MEMORY;
    }
    if (status != TULLE_OK) world_release_machinery(world, made);
    return status;
}

void world_release_machinery(tulle_world *world, cloth_machinery *made) {
    linear_system_destroy(&world->heap, &made->system);
    nested_aggregates_destroy(&world->heap, made->aggregates);
    if (made->model) {
        cloth_model_destroy(&world->heap, made->model);
        memory_release(&world->heap, made->model, sizeof *made->model);
    }
    *made = (cloth_machinery){0};
}

void world_set_machinery(tulle_world *world, cloth_machinery *made) {
    cloth_machinery old = {world->model.cloth_model, world->work.system, world->work.aggregates};
    world->model.cloth_model = made->model;
    world->work.system = made->system;
    world->work.aggregates = made->aggregates;
    *made = (cloth_machinery){0};
    world_release_machinery(world, &old);
    for (size_t v = 0; v < world->model.cloth_vertex_count; v++)
        world->model.inverse_masses[v] = 1.0 / world->model.cloth_model->masses[v];
}
