/* render/embree_scene.c - see embree_scene.h. The device builds on one thread, so the tree, and
 * with it the order in which triangles at the same distance are met, is the same each time. */
#include "render/embree_scene.h"

#include "base/error.h"

#include <string.h>

/* What a ray carries to the filter. Embree hands back the first member. */
typedef struct filtered_query {
    struct RTCIntersectContext context;
    uint32_t excluded;
} filtered_query;

render_lens render_lens_make(const render_camera *camera, vec3 center, uint32_t width,
                             uint32_t height) {
    vec3 const position = vec3_load(camera->position, 0);
    vec3 const forward = vec3_normalize(vec3_sub(vec3_load(camera->target, 0), position));
    vec3 const right = vec3_normalize(vec3_cross(forward, vec3_load(camera->up, 0)));
    vec3 const down = vec3_cross(forward, right);
    double const pixel = 2.0 * tan(0.5 * camera->field_of_view) / height;
    vec3 const origin = vec3_sub(position, center);
    render_lens lens = {.origin = vec3_make((double)(float)origin.x, (double)(float)origin.y,
                                            (double)(float)origin.z),
                        .right = vec3_scale(right, pixel),
                        .down = vec3_scale(down, pixel)};
    lens.corner = vec3_add_scaled(vec3_add_scaled(forward, lens.right, -0.5 * width), lens.down,
                                  -0.5 * height);
    return lens;
}

/* The hits of a packet are arrays, one after the other: the primitive's number is the sixth.
 * Embree's header has a function for it in C++ only. */
static uint32_t get_triangle(const struct RTCFilterFunctionNArguments *arguments, unsigned lane) {
    uint32_t triangle;
    memcpy(&triangle, (const char *)arguments->hit + 4 * (5 * (size_t)arguments->N + lane), 4);
    return triangle;
}

static void exclude_origin(const struct RTCFilterFunctionNArguments *arguments) {
    const filtered_query *const query = (const filtered_query *)(const void *)arguments->context;
    for (unsigned lane = 0; lane < arguments->N; lane++)
        if (arguments->valid[lane] && get_triangle(arguments, lane) == query->excluded)
            arguments->valid[lane] = 0;
}

static filtered_query make_query(const render_ray *ray) {
    filtered_query query = {.excluded = ray->excluded};
    rtcInitIntersectContext(&query.context);
    if (ray->excluded != TULLE_NONE) query.context.filter = exclude_origin;
    return query;
}

static struct RTCRay make_ray(const render_ray *ray) {
    return (struct RTCRay){.org_x = ray->origin[0],
                           .org_y = ray->origin[1],
                           .org_z = ray->origin[2],
                           .dir_x = ray->direction[0],
                           .dir_y = ray->direction[1],
                           .dir_z = ray->direction[2],
                           .tfar = ray->length,
                           .mask = UINT32_MAX};
}

static uint32_t find_first(RTCScene scene, const render_ray *ray) {
    filtered_query query = make_query(ray);
    struct RTCRayHit hit = {.ray = make_ray(ray)};
    hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene, &query.context, &hit);
    return hit.hit.geomID == RTC_INVALID_GEOMETRY_ID ? TULLE_NONE : hit.hit.primID;
}

uint32_t render_scene_find_first(const render_scene *scene, const render_ray *ray) {
    return scene->triangles ? find_first(scene->triangles, ray) : TULLE_NONE;
}

uint32_t render_scene_find_mark(const render_scene *scene, const render_ray *ray) {
    return scene->marks ? find_first(scene->marks, ray) : TULLE_NONE;
}

bool render_scene_is_blocked(const render_scene *scene, const render_ray *ray) {
    if (!scene->triangles) return false;
    filtered_query query = make_query(ray);
    struct RTCRay shadow = make_ray(ray);
    rtcOccluded1(scene->triangles, &query.context, &shadow);
    return shadow.tfar < 0.0f;
}

/* Commits a scene of one geometry, which it takes over; null on failure. */
static RTCScene make_scene(RTCDevice device, RTCGeometry geometry) {
    RTCScene const scene = rtcNewScene(device);
    if (scene) {
        rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(scene, geometry);
        rtcCommitScene(scene);
    }
    rtcReleaseGeometry(geometry);
    if (rtcGetDeviceError(device) == RTC_ERROR_NONE) return scene;
    if (scene) rtcReleaseScene(scene);
    return NULL;
}

static bool build_triangles(RTCDevice device, render_scene *scene) {
    const render_geometry *const g = &scene->geometry;
    if (g->triangle_count == 0) return true;
    RTCGeometry const geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    if (!geometry) return false;
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, g->vertices,
                               0, 3 * sizeof(float), g->vertex_count);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, g->triangles,
                               0, 3 * sizeof(uint32_t), g->triangle_count);
    scene->triangles = make_scene(device, geometry);
    return scene->triangles;
}

static bool build_marks(RTCDevice device, const render_frame_def *def, render_scene *scene) {
    if (def->mark_count == 0) return true;
    scene->mark_count = def->mark_count;
    scene->mark_balls = memory_allocate(&scene->heap, 16 * def->mark_count);
    if (!scene->mark_balls) return false;
    for (size_t i = 0; i < def->mark_count; i++) {
        vec3 const place = vec3_sub(vec3_load(def->marks[i].position, 0), scene->geometry.center);
        float *const ball = scene->mark_balls + 4 * i;
        ball[0] = (float)place.x;
        ball[1] = (float)place.y;
        ball[2] = (float)place.z;
        ball[3] = (float)def->marks[i].radius;
    }
    RTCGeometry const geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
    if (!geometry) return false;
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4,
                               scene->mark_balls, 0, 4 * sizeof(float), def->mark_count);
    scene->marks = make_scene(device, geometry);
    return scene->marks;
}

tulle_status render_scene_build(RTCDevice device, const render_frame_def *def, render_scene *scene,
                                tulle_error *error) {
    *scene = (render_scene){.heap = memory_default()};
    tulle_status const status = render_geometry_build(def, &scene->geometry, error);
    if (status != TULLE_OK) return status;
    if (build_triangles(device, scene) && build_marks(device, def, scene)) return TULLE_OK;
    size_t const triangle_count = scene->geometry.triangle_count;
    rtcGetDeviceError(device); /* reading it clears it */
    render_scene_destroy(scene);
    return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory for a picture of %zu triangles",
                     triangle_count);
}

void render_scene_destroy(render_scene *scene) {
    if (scene->triangles) rtcReleaseScene(scene->triangles);
    if (scene->marks) rtcReleaseScene(scene->marks);
    memory_release(&scene->heap, scene->mark_balls, 16 * scene->mark_count);
    render_geometry_destroy(&scene->geometry);
    *scene = (render_scene){0};
}
