/* io/animation/gltf_read.c - glTF as tulle_animation_open reads it. */
#include "base/error.h"
#include "io/animation/animation_read.h"
#include "io/animation/gltf_scene.h"

#include <string.h>

typedef struct gltf_state {
    gltf_file file;
    gltf_scene scene;
} gltf_state;

/* Tells of extensions that a file uses and could do without, and that may say more of surfaces. */
static void note_extensions(const gltf_file *file, tulle_animation_info *info) {
    const json_value *const used =
        json_find(&file->json, json_get_root(&file->json), "extensionsUsed");
    const json_value *item =
        used && used->type == JSON_ARRAY ? json_get_first(&file->json, used) : NULL;
    for (; item; item = json_get_next(&file->json, item))
        if (item->type == JSON_STRING && !gltf_leaves_surfaces(item->string) &&
            !strstr(item->string, "compression")) /* what is read holds the same, uncompressed */
            animation_add_note(info, "what the extension %.60s says", item->string);
}

static void describe(const gltf_scene *scene, tulle_animation_info *info) {
    *info = (tulle_animation_info){.vertex_count = scene->vertex_count,
                                   .triangle_count = scene->triangles.count / 3,
                                   .frame_count = (uint32_t)scene->frames.count,
                                   .added_frame_count =
                                       (uint32_t)(scene->jump_count + scene->turn_count),
                                   .has_times = 1,
                                   .is_y_up = 1,
                                   .meters_per_unit = 1.0};
    unsigned long long const lines = scene->passed_primitives;
    unsigned long long const animations = scene->passed_animations;
    if (lines > 0) animation_add_note(info, "%llu parts of lines", lines);
    if (animations > 0) animation_add_note(info, "all animations but the first, %llu", animations);
    if (scene->is_turning_too_fast) animation_add_note(info, "%s", ANIMATION_TOO_FAST);
}

static tulle_status open_gltf(memory *heap, const char *path, void *state,
                              animation_content *content, tulle_error *error) {
    gltf_state *const gltf = state;
    tulle_status status = gltf_file_open(heap, path, &gltf->file, error);
    if (status == TULLE_OK) status = gltf_scene_read(&gltf->file, &gltf->scene, error);
    if (status) return status;
    if (gltf->scene.frames.count > INT32_MAX)
        return error_set_at(error, TULLE_ERROR_LIMIT, path, 0, 0, "has too many frames");
    describe(&gltf->scene, &content->info);
    note_extensions(&gltf->file, &content->info);
    content->triangles = gltf->scene.triangles.data;
    content->times = gltf->scene.frames.data;
    content->file_count = gltf->file.sources.count;
    return TULLE_OK;
}

static tulle_status read_gltf(void *state, uint32_t frame, double *positions, tulle_error *error) {
    gltf_scene *const scene = &((gltf_state *)state)->scene;
    return gltf_scene_pose(scene, scene->frames.data[frame], positions, error);
}

static void close_gltf(void *state) {
    gltf_state *const gltf = state;
    gltf_scene_destroy(&gltf->scene);
    if (gltf->file.heap) gltf_file_close(&gltf->file);
}

static int get_file(const void *state, size_t number) {
    return ((const gltf_state *)state)->file.sources.data[number].file;
}

const animation_reader gltf_reader = {.extensions = {".glb", ".gltf"},
                                      .state_size = sizeof(gltf_state),
                                      .open = open_gltf,
                                      .read = read_gltf,
                                      .close = close_gltf,
                                      .get_file = get_file};
