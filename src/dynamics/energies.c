/* dynamics/energies.c - energies of a state and the largest stretch. Each chunk leaves its own
 * sums; they are added in chunk order. */
#include "base/parallel.h"
#include "dynamics/bending.h"
#include "dynamics/compute_forces.h"
#include "dynamics/hysteresis.h"
#include "dynamics/spring.h"

#include <math.h>

enum { ITEMS_PER_CHUNK = 1024 };

typedef struct energy_task {
    const cloth_model *model;
    const double *positions, *velocities;
    vec3 gravity;
    vec3 *deviations;       /* by hinge */
    double *first, *second; /* by chunk: two sums of the pass */
    size_t *counts;         /* by chunk: overstretched elements */
} energy_task;

/* first: kinetic, second: gravity */
static void measure_vertices(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)worker;
    energy_task *const task = context;
    double kinetic = 0.0, height = 0.0;
    for (size_t v = begin; v < end; v++) {
        double const mass = task->model->masses[v];
        kinetic += 0.5 * mass * vec3_norm2(vec3_load(task->velocities, v));
        height -= mass * vec3_dot(task->gravity, vec3_load(task->positions, v));
    }
    task->first[chunk] = kinetic;
    task->second[chunk] = height;
}

/* first: stretch energy, second: the largest stretch of the chunk */
static void measure_springs(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)worker;
    energy_task *const task = context;
    double energy = 0.0, largest = 0.0;
    for (size_t s = begin; s < end; s++) {
        const cloth_spring *const spring = &task->model->springs[s];
        double const length = vec3_norm(spring_get_difference(spring, task->positions));
        energy += spring_compute_law(spring, length - spring->rest_length).energy;
        largest = fmax(largest, length / spring->rest_length);
    }
    task->first[chunk] = energy;
    task->second[chunk] = largest;
}

/* first: stretch energy, second: the largest stretch of a yarn of the chunk */
static void measure_elements(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)worker;
    energy_task *const task = context;
    membrane_motion const motion = {.elements = task->model->elements,
                                    .fabrics = task->model->fabrics,
                                    .vertex_count = task->model->vertex_count,
                                    .positions = task->positions};
    membrane_energy const sum = TULLE_PICK_KERNEL(sum_membrane_energy)(&motion, begin, end);
    task->first[chunk] = sum.energy;
    task->second[chunk] = sum.max_stretch;
    task->counts[chunk] = sum.overstretched;
}

/* first: bending energy of the rows of these vertices. With rows that sum to zero,
 * x K x / 2 = -1/4 sum_ij K_ij |x_i - x_j|^2. */
static void measure_bending_rows(void *context, size_t begin, size_t end, size_t chunk,
                                 int worker) {
    (void)worker;
    energy_task *const task = context;
    const cloth_model *const model = task->model;
    double energy = 0.0;
    for (size_t v = begin; v < end; v++) {
        vec3 const here = vec3_load(task->positions, v);
        for (size_t k = model->scalar_begin[v]; k < model->scalar_begin[v + 1]; k++) {
            vec3 const there = vec3_load(task->positions, model->scalar_columns[k]);
            energy -= 0.25 * model->bend_scalars[k] * vec3_norm2(vec3_sub(there, here));
        }
        for (size_t k = model->block_begin[v]; k < model->block_begin[v + 1]; k++) {
            vec3 const there = vec3_load(task->positions, model->block_columns[k]);
            energy -= 0.25 * model->bend_blocks[k] * vec3_norm2(vec3_sub(there, here));
        }
    }
    task->first[chunk] = energy;
}

/* first: bending energy of the rows of these hinges */
static void couple_hinges(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)worker;
    energy_task *const task = context;
    double energy = 0.0;
    for (size_t h = begin; h < end; h++) {
        vec3 const moment = bend_compute_moment(task->model, h, task->deviations);
        energy += 0.5 * vec3_dot(moment, task->deviations[h]);
    }
    task->first[chunk] = energy;
}

tulle_status compute_energies(const cloth_model *model, const double *positions,
                              const double *velocities, energy_options options, arena *scratch,
                              cloth_energies *energies) {
    arena_mark const mark = arena_get_mark(scratch);
    size_t const vertices = model->vertex_count,
                 springs = model->elements ? model->triangle_count : model->edge_count;
    size_t const hinges = model->hinge_count;
    size_t const vertex_chunks = parallel_chunk_count(vertices, ITEMS_PER_CHUNK);
    size_t const spring_chunks = parallel_chunk_count(springs, ITEMS_PER_CHUNK);
    size_t const hinge_chunks = parallel_chunk_count(hinges, ITEMS_PER_CHUNK);
    size_t const most = spring_chunks > hinge_chunks ? spring_chunks : hinge_chunks;
    size_t const sums = most > vertex_chunks ? most : vertex_chunks;
    energy_task task = {.model = model,
                        .positions = positions,
                        .velocities = velocities,
                        .gravity = options.gravity,
                        .first = ARENA_NEW(scratch, double, sums),
                        .second = ARENA_NEW(scratch, double, sums),
                        .counts = ARENA_NEW_ZEROED(scratch, size_t, sums)};
    bool const needs_hinges = !options.is_elastic_known && !model->bends_by_matrix;
    if (needs_hinges) task.deviations = ARENA_NEW(scratch, vec3, hinges);
    bool const has_memory =
        task.first && task.second && task.counts && (!needs_hinges || task.deviations);
    if (has_memory) {
        parallel_for(vertices, ITEMS_PER_CHUNK, options.threads, measure_vertices, &task);
        energies->kinetic = parallel_sum(task.first, vertex_chunks);
        energies->gravity = parallel_sum(task.second, vertex_chunks);
    }
    if (has_memory && !options.is_elastic_known) {
        energies->elastic = (elastic_energies){0};
        parallel_for(springs, ITEMS_PER_CHUNK, options.threads,
                     model->elements ? measure_elements : measure_springs, &task);
        energies->elastic.stretch = parallel_sum(task.first, spring_chunks);
        for (size_t i = 0; i < spring_chunks; i++) {
            energies->elastic.max_stretch = fmax(energies->elastic.max_stretch, task.second[i]);
            energies->elastic.overstretched += task.counts[i];
        }
        if (model->bends_by_matrix) {
            parallel_for(vertices, ITEMS_PER_CHUNK, options.threads, measure_bending_rows, &task);
        } else {
            deviation_task hinge_task = {model, positions, task.deviations};
            parallel_for(hinges, ITEMS_PER_CHUNK, options.threads, bend_compute_deviations,
                         &hinge_task);
            parallel_for(hinges, ITEMS_PER_CHUNK, options.threads, couple_hinges, &task);
        }
        size_t const chunks = model->bends_by_matrix ? vertex_chunks : hinge_chunks;
        energies->elastic.bend = parallel_sum(task.first, chunks);
    }
    tulle_status status = has_memory ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
    if (has_memory && !options.is_elastic_known && model->sliders && options.plastic) {
        double held[2];
        status = hysteresis_measure(model, (slider_state){positions, options.threads, scratch},
                                    options.plastic, held);
        if (status == TULLE_OK) {
            energies->elastic.bend += held[0];
            energies->elastic.stretch += held[1];
        }
    }
    arena_release(scratch, mark);
    return status;
}
