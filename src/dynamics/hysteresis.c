/* dynamics/hysteresis.c - sliders of hysteresis: their constants, their plastic parts, and the
 * energy they hold. Forces are in hysteresis_forces.c. */
#include "dynamics/hysteresis.h"

#include "base/parallel.h"
#include "dynamics/bending.h"

#include <math.h>
#include <string.h>

/* K over the elastic stiffness. A loop then closes within 2/5 of the strain at which the elastic
 * law pulls as hard as the slider at most. */
static const double STIFFNESS_RATIO = 5.0;

enum { TRIANGLES_PER_CHUNK = 1024, HINGES_PER_CHUNK = 1024 };

/* ---- constants ---- */

bool hysteresis_begin(memory *heap, const cloth_model_def *def, const double *areas,
                      cloth_model *model) {
    bool has_bend = false, has_shear = false;
    for (size_t i = 0; i < def->material_count; i++) {
        const tulle_material *const m = &def->materials[i];
        has_bend |= m->bend_hysteresis_warp > 0.0 || m->bend_hysteresis_weft > 0.0;
        has_shear |= m->shear_hysteresis > 0.0;
    }
    if (def->membrane != TULLE_MEMBRANE_WOVEN || (!has_bend && !has_shear)) return true;
    cloth_sliders *const sliders = memory_allocate_zeroed(heap, 1, sizeof *sliders);
    if (!sliders) return false;
    model->sliders = sliders;
    sliders->fabric_count = def->material_count;
    sliders->triangle_count = model->triangle_count;
    sliders->hinge_count = model->hinge_count;
    sliders->vertex_count = model->vertex_count;
    sliders->has_bend = has_bend;
    sliders->has_shear = has_shear;
    sliders->fabrics = memory_allocate(heap, def->material_count * sizeof *sliders->fabrics);
    if (has_bend) {
        sliders->part_begin =
            memory_allocate_zeroed(heap, model->triangle_count + 1, sizeof(uint32_t));
        sliders->inv_double_areas = memory_allocate(heap, model->triangle_count * sizeof(double));
    }
    if (!sliders->fabrics || (has_bend && (!sliders->part_begin || !sliders->inv_double_areas)))
        return false;
    for (size_t t = 0; has_bend && t < model->triangle_count; t++)
        sliders->inv_double_areas[t] = 0.5 / areas[t];
    for (size_t i = 0; i < def->material_count; i++) {
        const tulle_material *const m = &def->materials[i];
        sliders->fabrics[i] =
            (slider_fabric){{{STIFFNESS_RATIO * m->bend_warp, 0.5 * m->bend_hysteresis_warp},
                             {STIFFNESS_RATIO * m->bend_weft, 0.5 * m->bend_hysteresis_weft},
                             {STIFFNESS_RATIO * m->shear.stiffness, 0.5 * m->shear_hysteresis}}};
    }
    return true;
}

/* The corners of a triangle's curvature; at most four for each of its hinges. */
enum { CORNERS_MAX = 4 * CURVATURE_PARTS };

static size_t list_corners(const cloth_model *model, size_t triangle,
                           curvature_corner corners[CORNERS_MAX]) {
    const cloth_sliders *const sliders = model->sliders;
    size_t count = 0;
    for (size_t k = sliders->part_begin[triangle]; k < sliders->part_begin[triangle + 1]; k++) {
        const curvature_part *const part = &sliders->parts[k];
        const cloth_hinge *const hinge = &model->hinges[part->hinge];
        for (int c = 0; c < 4; c++) {
            size_t place = 0;
            while (place < count && corners[place].vertex != hinge->vertices[c]) place++;
            if (place == count)
                corners[count++] =
                    (curvature_corner){hinge->vertices[c], (uint32_t)triangle, {0.0}};
            for (int yarn = 0; yarn < YARN_COUNT; yarn++)
                corners[place].weights[yarn] += part->weights[yarn] * hinge->weights[c];
        }
    }
    return count;
}

static bool build_corners(memory *heap, const cloth_model *model) {
    cloth_sliders *const sliders = model->sliders;
    curvature_corner corners[CORNERS_MAX];
    sliders->corner_begin =
        memory_allocate_zeroed(heap, sliders->triangle_count + 1, sizeof(uint32_t));
    sliders->place_begin =
        memory_allocate_zeroed(heap, sliders->triangle_count + 1, sizeof(size_t));
    if (!sliders->corner_begin || !sliders->place_begin) return false;
    for (int pass = 0; pass < 2; pass++) { /* counts; fills */
        size_t sum = 0, place_sum = 0;
        for (size_t t = 0; t < sliders->triangle_count; t++) {
            size_t const count = list_corners(model, t, corners);
            if (pass == 1 && count > 0)
                memcpy(sliders->corners + sum, corners, count * sizeof *corners);
            sum += count;
            place_sum += count * count;
            sliders->corner_begin[t + 1] = (uint32_t)sum;
            sliders->place_begin[t + 1] = place_sum;
        }
        if (pass == 1) break;
        sliders->corners = memory_allocate(heap, sum * sizeof *sliders->corners);
        sliders->places = memory_allocate(heap, place_sum * sizeof *sliders->places);
        if (!sliders->corners || !sliders->places) return false;
    }
    return true;
}

/* Where a column stands among ascending ones; TULLE_NONE if it does not. */
static uint32_t find_column(const uint32_t *columns, uint32_t begin, uint32_t end,
                            uint32_t column) {
    uint32_t const last = end;
    while (begin < end) {
        uint32_t const middle = begin + (end - begin) / 2;
        if (columns[middle] < column)
            begin = middle + 1;
        else
            end = middle;
    }
    return begin < last && columns[begin] == column ? begin : TULLE_NONE;
}

/* All pairs of corners are in the pattern: the bending energy of the same triangle couples them. */
static void find_places(const cloth_model *model) {
    const cloth_sliders *const sliders = model->sliders;
    uint32_t *place = sliders->places;
    for (size_t t = 0; t < sliders->triangle_count; t++)
        for (size_t i = sliders->corner_begin[t]; i < sliders->corner_begin[t + 1]; i++)
            for (size_t j = sliders->corner_begin[t]; j < sliders->corner_begin[t + 1]; j++) {
                uint32_t const row = sliders->corners[i].vertex;
                uint32_t const column = sliders->corners[j].vertex;
                *place = find_column(model->block_columns, model->block_begin[row],
                                     model->block_begin[row + 1], column);
                if (*place == TULLE_NONE)
                    *place = PLACE_IS_SCALAR |
                             find_column(model->scalar_columns, model->scalar_begin[row],
                                         model->scalar_begin[row + 1], column);
                place++;
            }
}

/* Lists, by key, the items that have it. begin has key_count + 1 zeros; filling moves each begin to
 * its end. */
#define LIST_BY_KEY(begin, list, items, count, key_count, key)                                     \
    do {                                                                                           \
        for (size_t k = 0; k < (count); k++) (begin)[(items)[k].key + 1]++;                        \
        for (size_t k = 0; k < (key_count); k++) (begin)[k + 1] += (begin)[k];                     \
        for (size_t k = 0; k < (count); k++) (list)[(begin)[(items)[k].key]++] = (uint32_t)k;      \
        for (size_t k = (key_count); k > 0; k--) (begin)[k] = (begin)[k - 1];                      \
        (begin)[0] = 0;                                                                            \
    } while (0)

bool hysteresis_finish(memory *heap, cloth_model *model) {
    cloth_sliders *const sliders = model->sliders;
    if (!sliders || !sliders->has_bend) return true;
    if (!build_corners(heap, model)) return false;
    find_places(model);
    size_t const parts = sliders->part_begin[sliders->triangle_count];
    size_t const corners = sliders->corner_begin[sliders->triangle_count];
    size_t const hinges = sliders->hinge_count, vertices = sliders->vertex_count;
    sliders->hinge_begin = memory_allocate_zeroed(heap, hinges + 1, sizeof(uint32_t));
    sliders->hinge_parts = memory_allocate(heap, parts * sizeof(uint32_t));
    sliders->vertex_begin = memory_allocate_zeroed(heap, vertices + 1, sizeof(uint32_t));
    sliders->vertex_corners = memory_allocate(heap, corners * sizeof(uint32_t));
    if (!sliders->hinge_begin || !sliders->hinge_parts || !sliders->vertex_begin ||
        !sliders->vertex_corners)
        return false;
    LIST_BY_KEY(sliders->hinge_begin, sliders->hinge_parts, sliders->parts, parts, hinges, hinge);
    LIST_BY_KEY(sliders->vertex_begin, sliders->vertex_corners, sliders->corners, corners, vertices,
                vertex);
    return true;
}

void hysteresis_destroy(memory *heap, cloth_model *model) {
    cloth_sliders *const sliders = model->sliders;
    if (!sliders) return;
    size_t const triangles = sliders->triangle_count;
    size_t const parts = sliders->part_begin ? sliders->part_begin[triangles] : 0;
    size_t const corners = sliders->corner_begin ? sliders->corner_begin[triangles] : 0;
    size_t const places = sliders->place_begin ? sliders->place_begin[triangles] : 0;
    size_t const hinges = sliders->hinge_count, vertices = sliders->vertex_count;
    memory_release(heap, sliders->fabrics, sliders->fabric_count * sizeof *sliders->fabrics);
    memory_release(heap, sliders->parts, parts * sizeof *sliders->parts);
    memory_release(heap, sliders->part_begin, (triangles + 1) * sizeof(uint32_t));
    memory_release(heap, sliders->inv_double_areas, triangles * sizeof(double));
    memory_release(heap, sliders->hinge_begin, (hinges + 1) * sizeof(uint32_t));
    memory_release(heap, sliders->hinge_parts, parts * sizeof(uint32_t));
    memory_release(heap, sliders->corners, corners * sizeof *sliders->corners);
    memory_release(heap, sliders->corner_begin, (triangles + 1) * sizeof(uint32_t));
    memory_release(heap, sliders->vertex_begin, (vertices + 1) * sizeof(uint32_t));
    memory_release(heap, sliders->vertex_corners, corners * sizeof(uint32_t));
    memory_release(heap, sliders->places, places * sizeof(uint32_t));
    memory_release(heap, sliders->place_begin, (triangles + 1) * sizeof(size_t));
    memory_release(heap, sliders, sizeof *sliders);
    model->sliders = NULL;
}

/* ---- strains ---- */

hinge_kink hysteresis_measure_kink(const cloth_model *model, size_t index,
                                   const double *positions) {
    const cloth_hinge *const hinge = &model->hinges[index];
    double const inverses[2] = {model->sliders->inv_double_areas[hinge->sides[0] / 3],
                                model->sliders->inv_double_areas[hinge->sides[1] / 3]};
    hinge_frame const frame = bend_compute_frame(hinge, inverses, positions);
    hinge_kink kink = {0};
    if (vec3_norm2(frame.normal) == 0.0) return kink;
    vec3 const c = bend_sum_corners(hinge, positions);
    double const sign = bend_find_sign(model->surface, hinge);
    kink.normal = vec3_scale(frame.normal, sign);
    kink.value = vec3_dot(kink.normal, c);
    /* (dn/dx)^T c */
    vec3 const tangential = vec3_scale(vec3_reject(c, kink.normal), sign / frame.length);
    bend_turn_normal(hinge, inverses, &frame, tangential, kink.turning);
    return kink;
}

typedef struct slider_task {
    const cloth_model *model;
    const double *positions; /* null: the rest shape */
    double *kinks;           /* by hinge */
    double *plastic;         /* that follow; null: none do */
    const double *kept;      /* of energies */
    double *sums[2];         /* by chunk: bending, shear */
} slider_task;

static void measure_kinks(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const slider_task *const task = context;
    const cloth_model *const model = task->model;
    for (size_t h = begin; h < end; h++) {
        if (task->positions)
            task->kinks[h] = hysteresis_measure_kink(model, h, task->positions).value;
        else
            task->kinks[h] = model->hinge_rests
                                 ? bend_find_sign(model->surface, &model->hinges[h]) *
                                       model->hinge_rests[h].curvature
                                 : 0.0;
    }
}

/* Strains of the sliders of a triangle. */
static void measure_strains(const slider_task *task, size_t triangle, double strains[]) {
    const cloth_sliders *const sliders = task->model->sliders;
    strains[YARN_WARP] = strains[YARN_WEFT] = strains[SLIDER_SHEAR] = 0.0;
    if (sliders->has_bend) hysteresis_sum_curvature(sliders, triangle, task->kinks, strains);
    if (!sliders->has_shear || !task->positions) return;
    yarn_pair const yarns =
        hysteresis_measure_yarns(&task->model->elements[triangle], task->positions);
    strains[SLIDER_SHEAR] = vec3_dot(yarns.along[YARN_WARP], yarns.along[YARN_WEFT]);
}

static const slider_law *get_laws(const cloth_model *model, size_t triangle) {
    return model->sliders->fabrics[model->elements[triangle].fabric].laws;
}

/* Plastic parts follow; at rest they are the strains. */
static void follow_strains(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    const slider_task *const task = context;
    for (size_t t = begin; t < end; t++) {
        const slider_law *const laws = get_laws(task->model, t);
        double *const plastic = task->plastic + SLIDER_COUNT * t, strains[SLIDER_COUNT];
        measure_strains(task, t, strains);
        for (int k = 0; k < SLIDER_COUNT; k++) {
            if (!task->positions) plastic[k] = laws[k].most > 0.0 ? strains[k] : 0.0;
            if (!(laws[k].most > 0.0)) continue;
            double const room = laws[k].most / laws[k].stiffness;
            if (strains[k] - plastic[k] > room) plastic[k] = strains[k] - room;
            if (strains[k] - plastic[k] < -room) plastic[k] = strains[k] + room;
        }
    }
}

static void sum_energies(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)worker;
    const slider_task *const task = context;
    double sums[2] = {0.0, 0.0};
    for (size_t t = begin; t < end; t++) {
        const slider_law *const laws = get_laws(task->model, t);
        double strains[SLIDER_COUNT];
        measure_strains(task, t, strains);
        for (int k = 0; k < SLIDER_COUNT; k++) {
            if (!(laws[k].most > 0.0)) continue;
            double const room = laws[k].most / laws[k].stiffness;
            double const strain = fabs(strains[k] - task->kept[SLIDER_COUNT * t + (size_t)k]);
            double const stored = fmin(strain, room);
            sums[k == SLIDER_SHEAR] +=
                task->model->elements[t].area *
                (0.5 * laws[k].stiffness * stored * stored + laws[k].most * (strain - stored));
        }
    }
    task->sums[0][chunk] = sums[0];
    task->sums[1][chunk] = sums[1];
}

/* Gives a task its kinks. False: no memory. */
static bool make_kinks(slider_task *task, const slider_state *state) {
    if (!task->model->sliders->has_bend) return true;
    size_t const hinges = task->model->hinge_count;
    task->kinks = ARENA_NEW(state->scratch, double, hinges);
    if (!task->kinks) return false;
    parallel_for(hinges, HINGES_PER_CHUNK, state->threads, measure_kinks, task);
    return true;
}

tulle_status hysteresis_follow(const cloth_model *model, slider_state state, double *plastic) {
    arena_mark const mark = arena_get_mark(state.scratch);
    slider_task task = {.model = model, .positions = state.positions, .plastic = plastic};
    bool const ok = make_kinks(&task, &state);
    if (ok)
        parallel_for(model->triangle_count, TRIANGLES_PER_CHUNK, state.threads, follow_strains,
                     &task);
    arena_release(state.scratch, mark);
    return ok ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
}

tulle_status hysteresis_start(const cloth_model *model, slider_state state, double *plastic) {
    slider_state rest = state;
    rest.positions = NULL;
    tulle_status const status = hysteresis_follow(model, rest, plastic);
    return status == TULLE_OK ? hysteresis_follow(model, state, plastic) : status;
}

tulle_status hysteresis_measure(const cloth_model *model, slider_state state, const double *plastic,
                                double energies[2]) {
    size_t const chunks = parallel_chunk_count(model->triangle_count, TRIANGLES_PER_CHUNK);
    arena_mark const mark = arena_get_mark(state.scratch);
    slider_task task = {.model = model, .positions = state.positions, .kept = plastic};
    for (int i = 0; i < 2; i++) task.sums[i] = ARENA_NEW(state.scratch, double, chunks);
    bool const ok = task.sums[0] && task.sums[1] && make_kinks(&task, &state);
    if (ok)
        parallel_for(model->triangle_count, TRIANGLES_PER_CHUNK, state.threads, sum_energies,
                     &task);
    for (int i = 0; ok && i < 2; i++) energies[i] = parallel_sum(task.sums[i], chunks);
    arena_release(state.scratch, mark);
    return ok ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
}
