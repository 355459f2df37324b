/* detect/patches/kept_patches_check.c - whether patches hold over a step; see kept_patches_parts.h.
 *
 * A task checks several small patches, or a share of a large one. The vertices of large patches are
 * projected first; then come their contours and runs of their triangles. Tasks are the same for any
 * number of threads, and so is the result of each. */
#include "detect/patches/kept_patches_parts.h"

#include "base/parallel.h"
#include "detect/patches/patch_kernel.h"
#include "detect/patches/planar_contour.h"

enum {
    LARGE_PATCH = 6144, /* triangles; some 50 microseconds */
    CHECK_CHUNK = 4096, /* vertices or triangles of a large patch a task */
    GROUP_SIZE = 4096,  /* triangles of small patches a task */
    CONTOUR_TESTS = 64  /* at most, of pairs of boxes or edges, a boundary edge */
};

double project_patch(kept_patches *patches, const kept_patch *patch, const patch_step *step,
                     size_t begin, size_t end) {
    planar_map const map = planar_map_make(
        patch->axis, vec3_load(step->x0, patches->vertices.data[patch->vertex_begin]));
    return TULLE_PICK_KERNEL(project_paths)(
        &map, patches->vertices.data + patch->vertex_begin + begin, end - begin, step->x0, step->x1,
        patches->points.data + patch->vertex_begin + begin);
}

bool patch_faces_axis(const kept_patches *patches, const kept_patch *patch, const patch_step *step,
                      double max_angle, size_t begin, size_t end) {
    const uint32_t *const triangles = patches->triangles.data + patch->triangle_begin;
    for (size_t i = begin; i < end; i++) {
        const uint32_t *const corners = patches->topo->triangles + 3 * (size_t)triangles[i];
        vec3 start[3], finish[3];
        for (int k = 0; k < 3; k++) {
            start[k] = vec3_load(step->x0, corners[k]);
            finish[k] = vec3_load(step->x1, corners[k]);
        }
        if (!triangle_faces_axis(start, finish, patch->axis, max_angle, 0.0)) return false;
    }
    return true;
}

/* Whether triangles begin .. end - 1 of a projected patch turn to the left. */
static bool all_turn_left(const kept_patches *patches, const kept_patch *patch, size_t begin,
                          size_t end, double reach) {
    return TULLE_PICK_KERNEL(patch_turns_left)(
        patches->points.data + patch->vertex_begin,
        patches->corners.data + 3 * ((size_t)patch->triangle_begin + begin), end - begin, reach);
}

/* Whether the boundary of a projected patch stays simple. */
static patch_verdict check_contour(const kept_patches *patches, const kept_patch *patch,
                                   double reach, void *scratch) {
    const planar_path *const points = patches->points.data + patch->vertex_begin;
    const uint32_t *const loop = patches->loops.data + patch->loop_begin;
    planar_path *const around = scratch;
    for (size_t i = 0; i < patch->loop_count; i++) around[i] = points[loop[i]];
    contour_proof const proof =
        prove_planar_contour(around, patch->loop_count, reach,
                             CONTOUR_TESTS * (size_t)patch->loop_count, around + patch->loop_count);
    return proof == CONTOUR_STAR    ? PATCH_HOLDS_BY_STAR
           : proof == CONTOUR_SWEPT ? PATCH_HOLDS_BY_SWEEP
                                    : PATCH_CROSSED;
}

patch_verdict check_patch(kept_patches *patches, const kept_patch *patch, const patch_step *step,
                          const patch_rules *rules, void *scratch) {
    if (!rules->has_certificate) {
        bool const holds =
            patch_faces_axis(patches, patch, step, rules->max_angle, 0, patch->triangle_count);
        return holds ? PATCH_HOLDS_BY_CONE : PATCH_TURNED;
    }
    double const size = project_patch(patches, patch, step, 0, patch->vertex_count);
    double const reach = compute_planar_reach(rules->reach, size);
    if (!(reach > 0.0) || !all_turn_left(patches, patch, 0, patch->triangle_count, reach))
        return PATCH_TURNED;
    return check_contour(patches, patch, reach, scratch);
}

/* ---- tasks ---- */

tulle_status prepare_checks(kept_patches *patches, int threads) {
    if (patches->has_tasks && patches->worker_count >= threads) return TULLE_OK;
    const kept_patch *const all = patches->patches.data;
    uint32_t const patch_count = (uint32_t)patches->patches.count;
    patches->tasks.count = 0;

    /* Large patches: projections first, then contours, which take longest, then triangles. */
    for (uint32_t kind = CHECK_PROJECTION; kind <= CHECK_TURNS; kind++) {
        for (uint32_t i = 0; i < patch_count; i++) {
            if (all[i].triangle_count <= LARGE_PATCH) continue;
            uint32_t const count = kind == CHECK_PROJECTION ? all[i].vertex_count
                                   : kind == CHECK_CONTOUR  ? 1
                                                            : all[i].triangle_count;
            for (uint32_t begin = 0; begin < count; begin += CHECK_CHUNK) {
                uint32_t const end = count - begin > CHECK_CHUNK ? begin + CHECK_CHUNK : count;
                if (!ARRAY_RESERVE(patches->heap, &patches->tasks, 1))
                    return TULLE_ERROR_OUT_OF_MEMORY;
                patches->tasks.data[patches->tasks.count++] =
                    (check_task){.kind = kind, .patch = i, .begin = begin, .end = end};
            }
        }
    }

    /* Small patches: several in a task. And room for the contour of any. */
    size_t longest = 0;
    for (uint32_t i = 0, begin = 0, triangle_count = 0; i < patch_count; i++) {
        if (all[i].triangle_count > 0 && all[i].loop_count > longest) longest = all[i].loop_count;
        if (all[i].triangle_count <= LARGE_PATCH) triangle_count += all[i].triangle_count;
        if (triangle_count < GROUP_SIZE && i + 1 < patch_count) continue;
        if (!ARRAY_RESERVE(patches->heap, &patches->tasks, 1)) return TULLE_ERROR_OUT_OF_MEMORY;
        patches->tasks.data[patches->tasks.count++] =
            (check_task){.kind = CHECK_WHOLE, .begin = begin, .end = i + 1};
        begin = i + 1;
        triangle_count = 0;
    }
    patches->scratch_stride = contour_scratch_size(longest) / 64 * 64 + 64;
    patches->contour_scratch.count = 0;
    if (!ARRAY_RESERVE(patches->heap, &patches->contour_scratch,
                       patches->scratch_stride * (size_t)threads))
        return TULLE_ERROR_OUT_OF_MEMORY;
    patches->worker_count = threads;
    patches->has_tasks = true;
    return TULLE_OK;
}

typedef struct check_run {
    kept_patches *patches;
    const patch_step *step;
    const patch_rules *rules;
    size_t task_begin;
} check_run;

/* Checks a share of a large patch. Triangles that hold give the best verdict, so the worst of all
 * tasks tells by which test the contour holds. */
static void run_share(const check_run *run, check_task *task, void *scratch) {
    kept_patches *const patches = run->patches;
    const kept_patch *const patch = &patches->patches.data[task->patch];
    if (!run->rules->has_certificate) {
        bool const holds = task->kind != CHECK_TURNS ||
                           patch_faces_axis(patches, patch, run->step, run->rules->max_angle,
                                            task->begin, task->end);
        task->verdict = holds ? PATCH_HOLDS_BY_CONE : PATCH_TURNED;
    } else if (task->kind == CHECK_PROJECTION) {
        task->size = project_patch(patches, patch, run->step, task->begin, task->end);
    } else if (!(task->reach > 0.0)) {
        task->verdict = PATCH_TURNED;
    } else if (task->kind == CHECK_CONTOUR) {
        task->verdict = check_contour(patches, patch, task->reach, scratch);
    } else {
        bool const holds = all_turn_left(patches, patch, task->begin, task->end, task->reach);
        task->verdict = holds ? PATCH_HOLDS_BY_STAR : PATCH_TURNED;
    }
}

static void run_tasks(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    (void)chunk;
    const check_run *const run = context;
    kept_patches *const patches = run->patches;
    void *const scratch = patches->contour_scratch.data + (size_t)worker * patches->scratch_stride;
    for (size_t i = begin; i < end; i++) {
        check_task *const task = &patches->tasks.data[run->task_begin + i];
        if (task->kind != CHECK_WHOLE) {
            run_share(run, task, scratch);
            continue;
        }
        for (uint32_t k = task->begin; k < task->end; k++) {
            kept_patch *const patch = &patches->patches.data[k];
            if (patch->triangle_count == 0 || patch->triangle_count > LARGE_PATCH) continue;
            patch->verdict = surface_meets_itself(run->step->set, patch->surface)
                                 ? check_patch(patches, patch, run->step, run->rules, scratch)
                                 : PATCH_LEFT;
        }
    }
}

void check_patches(kept_patches *patches, const patch_step *step, const patch_rules *rules) {
    check_task *const tasks = patches->tasks.data;
    kept_patch *const all = patches->patches.data;
    size_t const task_count = patches->tasks.count;
    size_t projection_count = 0;
    while (projection_count < task_count && tasks[projection_count].kind == CHECK_PROJECTION)
        projection_count++;
    check_run run = {patches, step, rules, 0};
    parallel_for(projection_count, 1, step->threads, run_tasks, &run);

    /* The sizes of a large patch's projections give the planar reach of its later tasks. */
    for (size_t i = projection_count; i < task_count; i++) {
        if (tasks[i].kind == CHECK_WHOLE) continue;
        double size = 0.0;
        for (size_t k = 0; k < projection_count; k++) {
            if (tasks[k].patch != tasks[i].patch) continue;
            double const own = tasks[k].size; /* NaN stays */
            if (!(own <= size) && !(size != size)) size = own;
        }
        tasks[i].reach = compute_planar_reach(rules->reach, size);
    }
    run.task_begin = projection_count;
    parallel_for(task_count - projection_count, 1, step->threads, run_tasks, &run);

    /* The verdict on a large patch is the worst of its tasks. */
    for (size_t i = 0; i < projection_count; i++) all[tasks[i].patch].verdict = PATCH_HOLDS_BY_STAR;
    for (size_t i = projection_count; i < task_count; i++) {
        if (tasks[i].kind == CHECK_WHOLE) continue;
        kept_patch *const patch = &all[tasks[i].patch];
        if (tasks[i].verdict > patch->verdict) patch->verdict = tasks[i].verdict;
        if (!surface_meets_itself(step->set, patch->surface)) patch->verdict = PATCH_LEFT;
    }
}
