/* render/embree_sight.c - how much of some surfaces cameras see. A ray goes through the middle of
 * each pixel and on through whatever it meets, until it comes to a wanted surface. */
#include "base/error.h"
#include "base/parallel.h"
#include "render/check_def.h"
#include "render/embree_scene.h"
#include "render/surface_point.h"

/* A ray that has met so many triangles without a wanted one is given up. */
enum { HITS_MAX = 256 };

typedef struct sight_task {
    const render_frame_def *def;
    const render_scene *scene;
    size_t wanted_count;
    render_sight *sights;
} sight_task;

static vec3 get_vector(const float v[3]) {
    return vec3_make((double)v[0], (double)v[1], (double)v[2]);
}

/* Follows a ray to a wanted surface. *first: what it meets before, a surface, or surface_count
 * where that is the floor. */
static bool find_wanted(const sight_task *task, render_ray ray, size_t *first) {
    const render_geometry *const geometry = &task->scene->geometry;
    vec3 const origin = get_vector(ray.origin), direction = get_vector(ray.direction);
    double const height = (double)(float)(task->def->lighting.floor_height - geometry->center.z);
    double const to_floor = (height - origin.z) / direction.z;
    bool const meets_floor = task->def->lighting.has_floor && to_floor > 0.0;
    *first = SIZE_MAX;
    for (int hits = 0; hits < HITS_MAX; hits++) {
        uint32_t const triangle = render_scene_find_first(task->scene, &ray);
        if (triangle == TULLE_NONE) return false;
        render_point point;
        render_point_find(geometry, triangle, get_vector(ray.origin), direction, &point);
        size_t const surface = geometry->part_index[triangle];
        if (*first == SIZE_MAX)
            *first = meets_floor && to_floor < point.distance ? task->def->surface_count : surface;
        if (surface < task->wanted_count) return true;
        ray = (render_ray){
            {(float)point.position.x, (float)point.position.y, (float)point.position.z},
            {ray.direction[0], ray.direction[1], ray.direction[2]},
            triangle,
            INFINITY};
    }
    return false;
}

static void look(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    const sight_task *const task = context;
    (void)chunk, (void)worker;
    uint32_t const width = task->def->width, height = task->def->height;
    for (size_t c = begin; c < end; c++) {
        render_sight *const sight = &task->sights[c];
        render_lens const lens =
            render_lens_make(&sight->camera, task->scene->geometry.center, width, height);
        for (uint32_t pixel = 0; pixel < width * height; pixel++) {
            size_t first;
            vec3 const direction =
                render_lens_get_direction(&lens, pixel % width + 0.5, pixel / width + 0.5);
            if (!find_wanted(task, render_ray_make(lens.origin, direction, TULLE_NONE), &first))
                continue;
            sight->covered++;
            if (first < task->wanted_count)
                sight->seen++;
            else if (sight->hidden_by)
                sight->hidden_by[first]++;
        }
    }
}

tulle_status render_find_sights(render_context *context, const render_frame_def *def,
                                size_t wanted_count, render_sight *sights, size_t sight_count,
                                tulle_error *error) {
    tulle_status status = render_check_def(def, error);
    render_scene scene;
    if (status == TULLE_OK) status = render_scene_build(context->device, def, &scene, error);
    if (status != TULLE_OK) return status;
    sight_task task = {def, &scene, wanted_count, sights};
    parallel_for(sight_count, 1, parallel_resolve_threads(def->threads), look, &task);
    render_scene_destroy(&scene);
    return TULLE_OK;
}
