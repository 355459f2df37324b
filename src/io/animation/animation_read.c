/* io/animation/animation_read.c - tulle_animation_open and what follows: a file of an animation as
 * one mesh that moves. */
#include "io/animation/animation_read.h"

#include "base/error.h"
#include "base/memory.h"
#include "io/animation/gltf_scene.h"
#include "io/file_data.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

struct tulle_animation {
    memory heap;
    char *path;
    size_t path_size;
    gltf_file file;
    gltf_scene scene;
};

static bool has_extension(const char *path, const char *extension) {
    size_t const length = strlen(path), tail = strlen(extension);
    return length >= tail && strcasecmp(path + length - tail, extension) == 0;
}

static void describe(const gltf_scene *scene, tulle_animation_info *info) {
    *info = (tulle_animation_info){.vertex_count = scene->vertex_count,
                                   .triangle_count = scene->triangles.count / 3,
                                   .frame_count = (uint32_t)scene->frames.count,
                                   .is_y_up = 1,
                                   .meters_per_unit = 1.0};
    unsigned long long const lines = scene->passed_primitives;
    unsigned long long const animations = scene->passed_animations;
    int length = 0;
    if (lines > 0)
        length = snprintf(info->note, sizeof info->note, "passed over: %llu parts of lines", lines);
    if (animations > 0)
        snprintf(info->note + length, sizeof info->note - (size_t)length,
                 "%sall animations but the first, %llu",
                 length > 0 ? ", " : "passed over: ", animations);
}

static tulle_status open_scene(tulle_animation *animation, tulle_animation_info *info,
                               tulle_error *error) {
    tulle_status status =
        gltf_file_open(&animation->heap, animation->path, &animation->file, error);
    if (status == TULLE_OK) status = gltf_scene_read(&animation->file, &animation->scene, error);
    if (status) return status;
    if (animation->scene.frames.count > INT32_MAX)
        return error_set_at(error, TULLE_ERROR_LIMIT, animation->path, 0, 0, "has too many frames");
    if (info) describe(&animation->scene, info);
    return TULLE_OK;
}

tulle_status tulle_animation_open(const char *path, tulle_animation **animation,
                                  tulle_animation_info *info, tulle_error *error) {
    if (!path || !animation)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "path and animation may not be null");
    *animation = NULL;
    if (!has_extension(path, ".glb") && !has_extension(path, ".gltf"))
        return error_set_at(error, TULLE_ERROR_UNSUPPORTED, path, 0, 0,
                            "animations that can be read end in .glb or .gltf");
    memory heap = memory_default();
    tulle_animation *const made = memory_allocate_zeroed(&heap, 1, sizeof *made);
    if (!made) return file_fail_memory(error, path);
    made->heap = heap;
    made->path_size = strlen(path) + 1;
    made->path = memory_allocate(&made->heap, made->path_size);
    if (made->path) memcpy(made->path, path, made->path_size);
    tulle_status const status =
        made->path ? open_scene(made, info, error) : file_fail_memory(error, path);
    if (status)
        tulle_animation_close(made);
    else
        *animation = made;
    return status;
}

size_t animation_get_buffer_count(const tulle_animation *animation) {
    return animation->file.buffers.count;
}

int animation_get_buffer_file(const tulle_animation *animation, size_t buffer) {
    return animation->file.buffers.data[buffer].file;
}

const uint32_t *tulle_animation_get_triangles(const tulle_animation *animation) {
    return animation && animation->scene.triangles.count > 0 ? animation->scene.triangles.data
                                                             : NULL;
}

double tulle_animation_get_time(const tulle_animation *animation, uint32_t frame) {
    if (!animation || frame >= animation->scene.frames.count) return (double)NAN;
    return animation->scene.frames.data[frame];
}

tulle_status tulle_animation_read_frame(tulle_animation *animation, uint32_t frame,
                                        double *positions, tulle_error *error) {
    if (!animation || !positions || frame >= animation->scene.frames.count)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "there is no frame %u", frame);
    return gltf_scene_pose(&animation->scene, animation->scene.frames.data[frame], positions,
                           error);
}

void tulle_animation_close(tulle_animation *animation) {
    if (!animation) return;
    gltf_scene_destroy(&animation->scene);
    if (animation->file.heap) gltf_file_close(&animation->file);
    memory_release(&animation->heap, animation->path, animation->path_size);
    memory heap = animation->heap;
    memory_release(&heap, animation, sizeof *animation);
}
