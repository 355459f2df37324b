/* render/embree_trace.c - light by paths. Each sample of a pixel is a ray that finds a surface.
 * From there it asks whether one place of the light is visible, and goes on in a direction chosen
 * by the cosine. After the last bounce the whole sky counts as visible. Surfaces are matt, so no
 * weight but the color enters, and a white surface in uniform light sends exactly that light.
 *
 * Pixels are worked on in square tiles, a tile by one thread; each pixel adds its samples in their
 * order, so the number of threads changes no bit.
 *
 * Based on: James Kajiya, The rendering equation, 1986; Manfred Ernst, Marc Stamminger and Günther
 *           Greiner, Filter importance sampling, 2006 (the pixel's filter by the choice of
 *           places). */
#include "base/error.h"
#include "base/hash.h"
#include "base/parallel.h"
#include "render/check_def.h"
#include "render/embree_scene.h"
#include "render/lighting.h"
#include "render/sampling.h"
#include "render/surface_point.h"

enum { TILE_SIDE = 16 };

/* [pixels] half the width of the tent that a pixel is weighted with. */
static const double filter_radius = 0.9;
/* Cosines below this are as good as none: the ray would run in the surface. */
static const double grazing_cosine = 1e-6;
/* [distances from camera to target] from the target, where the floor begins to fade into the
 * horizon, and is gone. The camera decides, so things that move in a film do not move the fade. */
static const double floor_fade_begin = 1.0, floor_fade_end = 4.0;

/* The pixel's pairs of numbers: place in the pixel, then for each bounce light and direction. */
enum { PAIR_PIXEL, PAIR_LIGHT, PAIR_BOUNCE, PAIRS_OF_BOUNCE = 2 };

/* All that is fixed for a picture. */
typedef struct picture {
    const render_frame_def *def;
    const render_scene *scene;
    render_light light;
    float floor_height;     /* relative to the center, rounded as the vertices are */
    vec3 target;            /* of the camera, relative to the center */
    double target_distance; /* [m] from the camera */
    render_lens lens;
    size_t tile_columns;
    float *radiance;
} picture;

/* One path on its way. */
typedef struct light_path {
    uint32_t index, pixel_seed; /* sample, and hash of its pixel */
    render_ray ray;
    uint32_t depth;
    double weight[3], radiance[3];
} light_path;

static vec3 get_vector(const float *v) {
    return vec3_make((double)v[0], (double)v[1], (double)v[2]);
}

/* Where the ray meets the floor, in lengths of its direction; infinite if it does not. */
static double compute_floor(const picture *p, vec3 origin, vec3 direction) {
    if (!p->def->lighting.has_floor) return (double)INFINITY;
    double const distance = ((double)p->floor_height - origin.z) / direction.z;
    return distance > 0.0 ? distance : (double)INFINITY;
}

/* The first thing a ray meets; false: the sky. A surface that lies in the floor hides it. */
static bool find_point(const picture *p, const render_ray *ray, render_point *point) {
    vec3 const origin = get_vector(ray->origin), direction = get_vector(ray->direction);
    double const floor_distance = compute_floor(p, origin, direction);
    uint32_t const triangle = render_scene_find_first(p->scene, ray);
    if (triangle != TULLE_NONE) {
        const render_geometry *const geometry = &p->scene->geometry;
        render_point_find(geometry, triangle, origin, direction, point);
        if (point->distance <= floor_distance ||
            fabs(point->position.z - (double)p->floor_height) <=
                render_point_get_offset(geometry, point))
            return true;
    }
    if (floor_distance == (double)INFINITY) return false;
    render_point_set_floor((double)p->floor_height, origin, direction, floor_distance, point);
    return true;
}

/* Starts a ray from a point, on its normal's side. */
static void leave_point(const picture *p, const render_point *point, vec3 direction,
                        render_ray *ray) {
    vec3 const start = vec3_add_scaled(point->position, point->normal,
                                       render_point_get_offset(&p->scene->geometry, point));
    *ray = render_ray_make(start, direction, point->triangle);
}

static bool is_blocked(const picture *p, const render_ray *ray) {
    if (compute_floor(p, get_vector(ray->origin), get_vector(ray->direction)) < (double)ray->length)
        return true;
    return render_scene_is_blocked(p->scene, ray);
}

/* The ray to the light from where the surface would be if it were as curved as its normals say. On
 * a flat triangle in place of a bulge, light that only just comes over the bulge would be cut off
 * triangle by triangle. False: there is no bulge, or something lies between. So no light comes
 * through a surface: both parts of the way are free. */
static bool lift_ray(const picture *p, const render_point *point, vec3 direction, render_ray *ray) {
    vec3 const lift = render_point_get_lift(&p->scene->geometry, point);
    if (vec3_norm2(lift) == 0.0) return false;
    render_ray up;
    leave_point(p, point, lift, &up);
    up.length = 1.0f;
    if (is_blocked(p, &up)) return false;
    *ray = render_ray_make(vec3_add(get_vector(up.origin), lift), direction,
                           vec3_dot(direction, point->normal) > grazing_cosine ? point->triangle
                                                                               : TULLE_NONE);
    return true;
}

/* Light that comes to the point straight from the light, as a white surface sends it back. */
static double measure_light_share(const picture *p, const light_path *path,
                                  const render_point *point) {
    double place[2];
    sampling_get_pair(path->index, path->pixel_seed, PAIR_LIGHT + PAIRS_OF_BOUNCE * path->depth,
                      place);
    vec3 const direction = render_light_get_direction(&p->light, place);
    double const cosine = vec3_dot(direction, point->shading_normal);
    if (cosine <= grazing_cosine) return 0.0;
    double share = cosine / vec3_dot(direction, p->light.direction);
    double const agreement =
        render_light_get_agreement(direction, point->shading_normal, point->normal);
    render_ray ray;
    if (agreement >= 1.0 || !lift_ray(p, point, direction, &ray)) {
        if (vec3_dot(direction, point->normal) <= grazing_cosine) return 0.0;
        share *= agreement;
        leave_point(p, point, direction, &ray);
    }
    return is_blocked(p, &ray) ? 0.0 : share;
}

/* How much of the floor at a point is still floor and not yet horizon. */
static double get_floor_cover(const picture *p, const render_point *point) {
    vec3 const v = vec3_sub(point->position, p->target);
    double const away = sqrt(v.x * v.x + v.y * v.y) / p->target_distance;
    double const s = (away - floor_fade_begin) / (floor_fade_end - floor_fade_begin);
    if (s <= 0.0) return 1.0;
    return s < 1.0 ? (1.0 - s) * (1.0 - s) * (1.0 + 2.0 * s) : 0.0;
}

static void add_radiance(light_path *path, const double radiance[3], double share) {
    for (int i = 0; i < 3; i++) path->radiance[i] += share * path->weight[i] * radiance[i];
}

/* Sends the path on from a point, or ends it with the sky's mean. False: it has ended. */
static bool bounce(const picture *p, light_path *path, const render_point *point) {
    if (path->depth == p->def->lighting.bounces) {
        double ambient[3];
        render_light_get_ambient(&p->light, point->shading_normal, ambient);
        add_radiance(path, ambient, 1.0);
        return false;
    }
    double place[2];
    sampling_get_pair(path->index, path->pixel_seed, PAIR_BOUNCE + PAIRS_OF_BOUNCE * path->depth,
                      place);
    vec3 direction = sampling_get_hemisphere(place, point->shading_normal);
    /* Into the surface: mirrored out of it, so nothing is lost where the normals disagree. */
    double const height = vec3_dot(direction, point->normal);
    if (height < 0.0) direction = vec3_add_scaled(direction, point->normal, -2.0 * height);
    if (fabs(height) < grazing_cosine)
        direction = vec3_add_scaled(direction, point->normal, grazing_cosine);
    leave_point(p, point, direction, &path->ray);
    path->depth++;
    return true;
}

/* Takes the color of a point into the path's weight; false: the path ends at the horizon. */
static bool take_color(const picture *p, light_path *path, const render_point *point,
                       const render_footprint *footprint) {
    double color[3];
    if (point->triangle != TULLE_NONE) {
        render_point_get_color(&p->scene->geometry, point, footprint, color);
        for (int i = 0; i < 3; i++) path->weight[i] *= color[i];
        return true;
    }
    double const cover = get_floor_cover(p, point);
    add_radiance(path, p->light.horizon, 1.0 - cover);
    for (int i = 0; i < 3; i++) path->weight[i] *= cover * p->light.floor_color[i];
    return cover > 0.0;
}

/* One stage of a path: from its ray to the next. False: it has ended. */
static bool follow(const picture *p, light_path *path, const render_footprint *footprint) {
    render_point point;
    bool const is_hit = find_point(p, &path->ray, &point);
    if (footprint) {
        render_ray ray = path->ray;
        if (is_hit) ray.length = (float)point.distance;
        uint32_t const mark = render_scene_find_mark(p->scene, &ray);
        if (mark != TULLE_NONE) {
            const float *const color = p->def->marks[mark].color;
            add_radiance(path, (double[3]){(double)color[0], (double)color[1], (double)color[2]},
                         1.0);
            return false;
        }
    }
    if (!is_hit) {
        double sky[3];
        render_light_get_sky(&p->light, vec3_normalize(get_vector(path->ray.direction)), sky);
        add_radiance(path, sky, 1.0);
        return false;
    }
    if (!take_color(p, path, &point, footprint)) return false;
    add_radiance(path, p->light.radiance, measure_light_share(p, path, &point));
    return bounce(p, path, &point);
}

static void trace_sample(const picture *p, uint32_t x, uint32_t y, light_path *path) {
    double place[2];
    sampling_get_pair(path->index, path->pixel_seed, PAIR_PIXEL, place);
    double const column = x + 0.5 + filter_radius * sampling_get_tent(place[0]);
    double const row = y + 0.5 + filter_radius * sampling_get_tent(place[1]);
    vec3 const direction = render_lens_get_direction(&p->lens, column, row);
    path->ray = render_ray_make(p->lens.origin, direction, TULLE_NONE);
    render_footprint const footprint = {get_vector(path->ray.direction), p->lens.right,
                                        p->lens.down};
    if (!follow(p, path, &footprint)) return;
    while (follow(p, path, NULL)) continue;
}

static void trace_pixel(const picture *p, uint32_t x, uint32_t y) {
    uint64_t const place = ((uint64_t)y << 32) | x;
    uint32_t const pixel_seed = (uint32_t)hash_mix(place ^ hash_mix(p->def->seed));
    double sum[3] = {0};
    for (uint32_t s = 0; s < p->def->samples; s++) {
        light_path path = {.index = s, .pixel_seed = pixel_seed, .weight = {1.0, 1.0, 1.0}};
        trace_sample(p, x, y, &path);
        for (int i = 0; i < 3; i++) sum[i] += path.radiance[i];
    }
    float *const out = p->radiance + 3 * ((size_t)y * p->def->width + x);
    for (int i = 0; i < 3; i++) out[i] = (float)(sum[i] / p->def->samples);
}

static void trace_tiles(void *context, size_t begin, size_t end, size_t chunk, int worker) {
    const picture *const p = context;
    (void)chunk, (void)worker;
    for (size_t tile = begin; tile < end; tile++) {
        uint32_t const left = (uint32_t)(tile % p->tile_columns) * TILE_SIDE;
        uint32_t const top = (uint32_t)(tile / p->tile_columns) * TILE_SIDE;
        for (uint32_t y = top; y < top + TILE_SIDE && y < p->def->height; y++)
            for (uint32_t x = left; x < left + TILE_SIDE && x < p->def->width; x++)
                trace_pixel(p, x, y);
    }
}

static picture make_picture(const render_frame_def *def, const render_scene *scene,
                            float *radiance) {
    const render_camera *const camera = &def->camera;
    vec3 const center = scene->geometry.center, target = vec3_load(camera->target, 0);
    return (picture){.def = def,
                     .scene = scene,
                     .light = render_light_prepare(&def->lighting),
                     .floor_height = (float)(def->lighting.floor_height - center.z),
                     .target = vec3_sub(target, center),
                     .target_distance = vec3_norm(vec3_sub(target, vec3_load(camera->position, 0))),
                     .lens = render_lens_make(camera, center, def->width, def->height),
                     .tile_columns = (def->width + TILE_SIDE - 1) / TILE_SIDE,
                     .radiance = radiance};
}

bool render_is_available(void) { return true; }

tulle_status render_context_create(render_context **context, tulle_error *error) {
    *context = NULL;
    memory heap = memory_default();
    render_context *const made = memory_allocate(&heap, sizeof *made);
    if (!made) return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory for the ray tracer");
    made->device = rtcNewDevice("threads=1,set_affinity=0,start_threads=0");
    if (!made->device) {
        memory_release(&heap, made, sizeof *made);
        return error_set(error,
                         rtcGetDeviceError(NULL) == RTC_ERROR_UNSUPPORTED_CPU
                             ? TULLE_ERROR_UNSUPPORTED
                             : TULLE_ERROR_OUT_OF_MEMORY,
                         "the ray tracer Embree cannot be started on this machine");
    }
    *context = made;
    return TULLE_OK;
}

void render_context_destroy(render_context *context) {
    if (!context) return;
    rtcReleaseDevice(context->device);
    memory heap = memory_default();
    memory_release(&heap, context, sizeof *context);
}

tulle_status render_trace(render_context *context, const render_frame_def *def, float *radiance,
                          tulle_error *error) {
    tulle_status status = render_check_def(def, error);
    render_scene scene;
    if (status == TULLE_OK) status = render_scene_build(context->device, def, &scene, error);
    if (status != TULLE_OK) return status;
    picture const p = make_picture(def, &scene, radiance);
    size_t const tile_rows = (def->height + TILE_SIDE - 1) / TILE_SIDE;
    parallel_for(p.tile_columns * tile_rows, 1, parallel_resolve_threads(def->threads), trace_tiles,
                 (void *)(uintptr_t)&p);
    render_scene_destroy(&scene);
    return TULLE_OK;
}
