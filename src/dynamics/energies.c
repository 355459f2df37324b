/* dynamics/energies.c - energies of a state and the largest stretch. Each chunk leaves its own
 * sums; they are added in chunk order. */
#include "base/parallel.h"
#include "dynamics/bend.h"
#include "dynamics/compute_forces.h"
#include "dynamics/spring.h"

#include <math.h>

enum { ITEMS_PER_CHUNK = 1024 };

typedef struct energy_task {
    const cloth_model *model;
    const double *positions, *velocities;
    vec3 gravity;
    vec3 *deviations;       /* by hinge */
    double *first, *second; /* by chunk: two sums of the pass */
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
        double const length = vec3_norm(vec3_sub(vec3_load(task->positions, spring->vertices[1]),
                                                 vec3_load(task->positions, spring->vertices[0])));
        energy += spring_measure_energy(spring, task->positions);
        largest = fmax(largest, length / spring->rest_length);
    }
    task->first[chunk] = energy;
    task->second[chunk] = largest;
}

static void measure_hinges(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk, (void)worker;
    energy_task *const task = context;
    for (size_t h = begin; h < end; h++) {
        task->deviations[h] = bend_get_deviation(task->model, h, task->positions);
    }
}

/* first: bending energy of the rows of these hinges */
static void couple_hinges(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)worker;
    energy_task *const task = context;
    const cloth_model *const model = task->model;
    double energy = 0.0;
    for (size_t h = begin; h < end; h++) {
        vec3 const moment = bend_get_moment(model, h, task->deviations);
        energy += 0.5 * vec3_dot(moment, task->deviations[h]);
    }
    task->first[chunk] = energy;
}

static double sum_chunks(const double *values, size_t count) {
    double sum = 0.0;
    for (size_t i = 0; i < count; i++) sum += values[i];
    return sum;
}

/* Room for the sums of `count` items at most. */
static bool allocate_sums(energy_task *task, size_t count, arena *scratch) {
    size_t const chunks = parallel_chunk_count(count, ITEMS_PER_CHUNK);
    task->first = ARENA_NEW(scratch, double, chunks);
    task->second = ARENA_NEW(scratch, double, chunks);
    return task->first && task->second;
}

tulle_status compute_motion_energies(const cloth_model *model, const double *positions,
                                     const double *velocities, energy_options options,
                                     arena *scratch, cloth_energies *energies) {
    arena_mark const mark = arena_get_mark(scratch);
    size_t const count = model->vertex_count, chunks = parallel_chunk_count(count, ITEMS_PER_CHUNK);
    energy_task task = {.model = model,
                        .positions = positions,
                        .velocities = velocities,
                        .gravity = options.gravity};
    bool const has_memory = allocate_sums(&task, count, scratch);
    if (has_memory) {
        parallel_for(count, ITEMS_PER_CHUNK, options.threads, measure_vertices, &task);
        energies->kinetic = sum_chunks(task.first, chunks);
        energies->gravity = sum_chunks(task.second, chunks);
    }
    arena_release(scratch, mark);
    return has_memory ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
}

static void measure_elastic(energy_task *task, int threads, elastic_energies *energies) {
    const cloth_model *const model = task->model;
    *energies = (elastic_energies){0};
    parallel_for(model->spring_count, ITEMS_PER_CHUNK, threads, measure_springs, task);
    size_t const count = parallel_chunk_count(model->spring_count, ITEMS_PER_CHUNK);
    energies->stretch = sum_chunks(task->first, count);
    for (size_t i = 0; i < count; i++)
        energies->max_stretch = fmax(energies->max_stretch, task->second[i]);
    parallel_for(model->hinge_count, ITEMS_PER_CHUNK, threads, measure_hinges, task);
    parallel_for(model->hinge_count, ITEMS_PER_CHUNK, threads, couple_hinges, task);
    energies->bend =
        sum_chunks(task->first, parallel_chunk_count(model->hinge_count, ITEMS_PER_CHUNK));
}

tulle_status compute_elastic_energies(const cloth_model *model, const double *positions,
                                      int threads, arena *scratch, elastic_energies *energies) {
    arena_mark const mark = arena_get_mark(scratch);
    size_t const most =
        model->spring_count > model->hinge_count ? model->spring_count : model->hinge_count;
    energy_task task = {.model = model,
                        .positions = positions,
                        .deviations = ARENA_NEW(scratch, vec3, model->hinge_count)};
    bool const has_memory = task.deviations && allocate_sums(&task, most, scratch);
    if (has_memory) measure_elastic(&task, threads, energies);
    arena_release(scratch, mark);
    return has_memory ? TULLE_OK : TULLE_ERROR_OUT_OF_MEMORY;
}

tulle_status compute_energies(const cloth_model *model, const double *positions,
                              const double *velocities, energy_options options, arena *scratch,
                              cloth_energies *energies) {
    tulle_status const status =
        compute_motion_energies(model, positions, velocities, options, scratch, energies);
    if (status != TULLE_OK) return status;
    return compute_elastic_energies(model, positions, options.threads, scratch, &energies->elastic);
}
