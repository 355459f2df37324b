/* io/animation/usd_read.c - USD in its text form as tulle_animation_open reads it. */
#include "io/animation/animation_read.h"
#include "io/animation/usd_scene.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

typedef struct usd_state {
    usd_layer layer;
    usd_scene scene;
} usd_state;

static void describe(const usd_state *usd, tulle_animation_info *info) {
    const usd_passed *const passed = &usd->layer.passed;
    double const start = usd->layer.start_code / usd->layer.codes_per_second;
    *info = (tulle_animation_info){.vertex_count = usd->scene.vertex_count,
                                   .triangle_count = usd->scene.triangles.count / 3,
                                   .frame_count = (uint32_t)usd->scene.frames.count,
                                   .added_frame_count = (uint32_t)usd->scene.turn_count,
                                   .has_times = 1,
                                   .start_time = isnan(start) ? 0.0 : start,
                                   .is_y_up = usd->layer.is_y_up,
                                   .meters_per_unit = usd->layer.meters_per_unit};
    if (passed->other_files > 0)
        animation_add_note(info, "%zu other files, as @%.60s@", passed->other_files,
                           usd_layer_get_text(&usd->layer, passed->first_file));
    if (passed->classes > 0)
        animation_add_note(info, "what prims inherit from %zu that are not there, as <%.60s>",
                           passed->classes, usd_layer_get_text(&usd->layer, passed->first_class));
    if (passed->variant_sets > 0)
        animation_add_note(info, "%zu variant sets", passed->variant_sets);
    if (passed->shapes > 0)
        animation_add_note(info, "%zu spheres, curves and the like", passed->shapes);
    if (passed->hidden > 0) animation_add_note(info, "%zu that are hidden", passed->hidden);
    if (passed->changing > 0)
        animation_add_note(info, "when %zu are visible, so they always are", passed->changing);
    if (usd->scene.is_turning_too_fast) animation_add_note(info, "%s", ANIMATION_TOO_FAST);
    if (usd->scene.half_turn_line > 0)
        animation_add_note(info,
                           "a turn of half a circle between two matrices, as in line %d, has no "
                           "direction; add a sample between them",
                           usd->scene.half_turn_line);
    if (passed->skins > 0) animation_add_note(info, "skins of %zu meshes", passed->skins);
    if (passed->smooth > 0)
        animation_add_note(info, "the subdivision of %zu meshes", passed->smooth);
    char polygons[200];
    polygon_cutter_describe(&usd->scene.cutter, polygons, sizeof polygons);
    size_t const length = strlen(info->note);
    if (polygons[0])
        (void)snprintf(info->note + length, sizeof info->note - length, "%s%s",
                       length > 0 ? "; " : "", polygons);
}

static tulle_status open_usd(memory *heap, const char *path, void *state,
                             animation_content *content, tulle_error *error) {
    usd_state *const usd = state;
    tulle_status status = usd_layer_open(heap, path, &usd->layer, error);
    if (status == TULLE_OK) status = usd_scene_read(&usd->layer, &usd->scene, error);
    if (status) return status;
    describe(usd, &content->info);
    content->triangles = usd->scene.triangles.data;
    content->times = usd->scene.frames.data;
    return TULLE_OK;
}

static tulle_status read_usd(void *state, uint32_t frame, double *positions, tulle_error *error) {
    usd_scene *const scene = &((usd_state *)state)->scene;
    return usd_scene_pose(scene, scene->codes.data[frame], positions, error);
}

static void close_usd(void *state) {
    usd_state *const usd = state;
    usd_scene_destroy(&usd->scene);
    usd_layer_close(&usd->layer);
}

const animation_reader usd_reader = {.extensions = {".usda", ".usd", ".usdc"},
                                     .state_size = sizeof(usd_state),
                                     .open = open_usd,
                                     .read = read_usd,
                                     .close = close_usd};
