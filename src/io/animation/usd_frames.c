/* io/animation/usd_frames.c - the frames of a USD file: at the time codes of all samples that move
 * something, and between them where something turns. */
#include "base/sort.h"
#include "io/animation/fine_frames.h"
#include "io/animation/usd_scene.h"
#include "io/file_data.h"

#include <math.h>
#include <string.h>

/* [time codes] Times that are told apart from the codes are as near to them. */
static const double TIME_TOLERANCE = 1e-5;

static tulle_status fail_memory(const usd_scene *scene, tulle_error *error) {
    return file_fail_memory(error, scene->layer->text.path);
}

/* Times that the file tells to the last bit, where they are those of the codes. */
static tulle_status take_exact_times(usd_scene *scene, tulle_error *error) {
    usd_layer *const layer = scene->layer;
    uint32_t number = 0;
    while (number < layer->attributes.count && layer->attributes.data[number].name != USD_TIMES)
        number++;
    usd_place place;
    if (number == layer->attributes.count || !usd_find_value(layer, number, &place))
        return TULLE_OK;
    size_t const count = scene->frames.count;
    size_t found = 0;
    scene->scratch.count = 0;
    if (!ARRAY_RESERVE(layer->text.heap, &scene->scratch, count)) return fail_memory(scene, error);
    double *const times = scene->scratch.data;
    tulle_status const status =
        usd_text_read(&layer->text, place, (usd_numbers){1, times, count}, &found, error);
    bool is_same = found == count;
    for (size_t i = 0; i < count && is_same && status == TULLE_OK; i++)
        is_same = fabs(times[i] * layer->codes_per_second - scene->codes.data[i]) <= TIME_TOLERANCE;
    if (is_same && status == TULLE_OK) memcpy(scene->frames.data, times, count * sizeof *times);
    return status;
}

tulle_status usd_scene_make_frames(usd_scene *scene, tulle_error *error) {
    usd_layer *const layer = scene->layer;
    memory *const heap = layer->text.heap;
    for (size_t i = 0; i < layer->attributes.count; i++) {
        const usd_attribute *const attribute = &layer->attributes.data[i];
        if (!attribute->is_used) continue;
        if (!ARRAY_RESERVE(heap, &scene->codes, attribute->sample_count + 1))
            return fail_memory(scene, error);
        for (size_t k = 0; k < attribute->sample_count; k++)
            scene->codes.data[scene->codes.count++] =
                layer->samples.data[attribute->first_sample + k].code;
    }
    double *const codes = scene->codes.data;
    size_t count = 0;
    sort_in_place(codes, scene->codes.count, sizeof *codes, compare_doubles);
    for (size_t i = 0; i < scene->codes.count; i++)
        if (count == 0 || codes[i] > codes[count - 1]) codes[count++] = codes[i];
    if (count == 0) codes[count++] = isnan(layer->start_code) ? 0.0 : layer->start_code;
    scene->codes.count = count;
    if (!ARRAY_RESERVE(heap, &scene->frames, count)) return fail_memory(scene, error);
    for (size_t i = 0; i < count; i++)
        scene->frames.data[scene->frames.count++] = codes[i] / layer->codes_per_second;
    return take_exact_times(scene, error);
}

static tulle_status pose(void *scene, double code, double *positions, tulle_error *error) {
    return usd_scene_pose(scene, code, positions, error);
}

static tulle_status find_turn(void *scene, double from, double to, double *turn,
                              tulle_error *error) {
    return usd_scene_find_turn(scene, from, to, turn, error);
}

tulle_status usd_scene_add_frames(usd_scene *scene, tulle_error *error) {
    if (scene->codes.count < 2) return TULLE_OK;
    memory *const heap = scene->layer->text.heap;
    size_t const part_count = scene->pieces.count;
    fine_frames fine = {.heap = heap,
                        .path = scene->layer->text.path,
                        .scene = scene,
                        .pose = pose,
                        .find_turn = find_turn,
                        .part_count = part_count,
                        .keys = scene->codes.data,
                        .key_count = scene->codes.count};
    tulle_status status = fine_frames_make(&fine, error);
    if (status == TULLE_OK) {
        for (size_t i = 0; i < part_count; i++)
            fine.first_vertices[i] = scene->pieces.data[i].first_vertex;
        fine.first_vertices[part_count] = scene->vertex_count;
        status = fine_frames_find(&fine, error);
    }
    if (status == TULLE_OK && (!ARRAY_RESERVE(heap, &scene->codes, fine.added_count) ||
                               !ARRAY_RESERVE(heap, &scene->frames, fine.added_count)))
        status = fail_memory(scene, error);
    if (status == TULLE_OK) {
        fine_frames_spread(&fine, scene->codes.data);
        fine_frames_spread(&fine, scene->frames.data);
        scene->codes.count += fine.added_count;
        scene->frames.count += fine.added_count;
        scene->turn_count = fine.added_count;
        scene->is_turning_too_fast = fine.is_cut;
    }
    fine_frames_release(&fine);
    return status;
}
