/* scene/frame_cache.c - see frame_cache.h. */
#define _POSIX_C_SOURCE 200809L
#include "scene/frame_cache.h"

#include <math.h>
#include <string.h>
#include <strings.h>

bool frame_cache_is_animation(const char *path) {
    static const char *const extensions[] = {".glb",  ".gltf", ".usda", ".usd",
                                             ".usdc", ".npz",  ".abc"};
    size_t const length = strlen(path);
    for (size_t i = 0; i < sizeof extensions / sizeof extensions[0]; i++) {
        size_t const tail = strlen(extensions[i]);
        if (length >= tail && strcasecmp(path + length - tail, extensions[i]) == 0) return true;
    }
    return false;
}

tulle_status frame_cache_open(const char *path, frame_cache *cache, tulle_error *error) {
    *cache = (frame_cache){.frame_step = 1.0, .axes = {false, 1.0}};
    if (frame_cache_is_animation(path)) {
        tulle_animation_info info;
        tulle_status const status = tulle_animation_open(path, &cache->animation, &info, error);
        if (status != TULLE_OK) return status;
        cache->vertex_count = info.vertex_count;
        cache->triangle_count = info.triangle_count;
        cache->frame_count = info.frame_count;
        cache->has_times = info.has_times != 0;
        cache->start_time = info.start_time;
        cache->axes = (file_axes){info.is_y_up != 0, info.meters_per_unit};
        memcpy(cache->note, info.note, sizeof cache->note);
        return TULLE_OK;
    }
    tulle_pc2_info info;
    tulle_status const status = tulle_pc2_open(path, &cache->points, &info, error);
    if (status != TULLE_OK) return status;
    cache->vertex_count = info.vertex_count;
    cache->frame_count = info.frame_count;
    cache->start_frame = info.start_frame;
    cache->frame_step = info.frame_step;
    cache->has_times = info.frame_count > 0 && isfinite(frame_cache_get_time(cache, 0));
    return TULLE_OK;
}

double frame_cache_get_time(const frame_cache *cache, uint32_t frame) {
    double time = (double)NAN;
    if (cache->animation) return tulle_animation_get_time(cache->animation, frame);
    tulle_pc2_get_time(cache->points, frame, &time, NULL);
    return time;
}

bool frame_cache_rises(const frame_cache *cache) {
    for (uint32_t i = 1; i < cache->frame_count; i++)
        if (!(frame_cache_get_time(cache, i) > frame_cache_get_time(cache, i - 1))) return false;
    return true;
}

void frame_cache_close(frame_cache *cache) {
    tulle_pc2_close(cache->points);
    tulle_animation_close(cache->animation);
    *cache = (frame_cache){0};
}

tulle_status frame_cache_read(frame_cache *cache, uint32_t frame, double *positions,
                              tulle_error *error) {
    return cache->animation ? tulle_animation_read_frame(cache->animation, frame, positions, error)
                            : tulle_pc2_read_frame(cache->points, frame, positions, error);
}

tulle_status frame_cache_make_mesh(frame_cache *cache, uint32_t frame, tulle_mesh *mesh,
                                   tulle_error *error) {
    tulle_status const status =
        tulle_mesh_create(cache->vertex_count, cache->triangle_count, mesh, error);
    if (status != TULLE_OK) return status;
    if (cache->triangle_count > 0)
        memcpy(mesh->triangles, tulle_animation_get_triangles(cache->animation),
               3 * cache->triangle_count * sizeof(uint32_t));
    return frame_cache_read(cache, frame, mesh->positions, error);
}
