/* io/animation/gltf_animation.c - the first animation of a glTF file, and the vertices at a time:
 * morph targets, then the transforms of nodes or the joints of a skin.
 *
 * Based on: Khronos Group, glTF 2.0 Specification, 2021, sections 3.7 and 3.11, appendix C. */
#include "base/error.h"
#include "base/sort.h"
#include "io/animation/fine_frames.h"
#include "io/animation/gltf_scene.h"
#include "io/animation/matrix.h"
#include "io/animation/rotation.h"
#include "io/file_data.h"

#include <math.h>
#include <string.h>

enum {
    VERTEX_CHUNK = 256, /* vertices of a skin at a time */
    JOINT_SETS = 4      /* of 4 joints each that are read */
};

/* [rad] As a turn that needs to be looked at: a cubic spline, and scales, which bend the paths of
 * what turns or moves below them. */
static const double CURVE_TURN = 2.0, SCALE_TURN = 1e-3;

static tulle_status fail_memory(const gltf_scene *scene, tulle_error *error) {
    return file_fail_memory(error, scene->file->path);
}

/* ---- reading ---- */

/* The number of the times in an accessor, which are read once. */
static tulle_status find_keys(gltf_scene *scene, uint32_t accessor, uint32_t *number,
                              tulle_error *error) {
    gltf_file *const file = scene->file;
    const gltf_accessor *const input = &file->accessors.data[accessor];
    for (*number = 0; *number < scene->keys.count; (*number)++)
        if (scene->keys.data[*number].accessor == accessor) return TULLE_OK;
    if (input->count == 0 || input->numbers.slice == GLTF_NONE)
        return json_fail(&file->json, input->place, error, "times need a buffer view");
    tulle_status status =
        gltf_scene_check_size(scene, input->count * sizeof *scene->times.data, error);
    if (status) return status;
    if (!ARRAY_RESERVE(file->heap, &scene->keys, 1) ||
        !ARRAY_RESERVE(file->heap, &scene->times, (size_t)input->count))
        return fail_memory(scene, error);
    size_t const first = scene->times.count;
    double *const times = scene->times.data + first;
    status = gltf_read(file, accessor, 0, input->count, times, error);
    if (status) return status;
    for (size_t i = 1; i < input->count; i++)
        if (!(times[i] > times[i - 1]))
            return json_fail(&file->json, input->place, error,
                             "time %zu is not later than the time before it", i);
    scene->times.count += (size_t)input->count;
    scene->keys.data[scene->keys.count++] = (gltf_keys){accessor, first, (size_t)input->count};
    return TULLE_OK;
}

static tulle_status read_sampler(gltf_scene *scene, const json_value *sampler,
                                 gltf_channel *channel, tulle_error *error) {
    static const char *const names[] = {"LINEAR", "STEP", "CUBICSPLINE"};
    gltf_file *const file = scene->file;
    uint32_t input;
    const json_value *const kind = json_find(&file->json, sampler, "interpolation");
    tulle_status status = gltf_find_accessor(file, sampler, "input", 1, &input, error);
    if (status == TULLE_OK)
        status = gltf_find_number(file, sampler, "output", file->accessors.count, &channel->values,
                                  error);
    if (status) return status;
    if (input == GLTF_NONE || channel->values == GLTF_NONE)
        return json_fail(&file->json, sampler, error, "\"input\" or \"output\" is missing");
    channel->interpolation = GLTF_LINEAR;
    if (kind) {
        int i = 2;
        while (i >= 0 && (kind->type != JSON_STRING || strcmp(kind->string, names[i]) != 0)) i--;
        if (i < 0) return json_fail(&file->json, kind, error, "this interpolation is not known");
        channel->interpolation = (gltf_interpolation)i;
    }
    return find_keys(scene, input, &channel->keys, error);
}

/* The values must be as many as the times need. */
static tulle_status check_channel(const gltf_scene *scene, const json_value *place,
                                  const gltf_channel *channel, tulle_error *error) {
    static const uint32_t widths[GLTF_PATH_COUNT] = {3, 4, 3, 1};
    const gltf_accessor *const values = &scene->file->accessors.data[channel->values];
    gltf_path const path = channel->path;
    uint64_t const each = path == GLTF_WEIGHTS ? channel->width : 1;
    uint64_t const wanted = scene->keys.data[channel->keys].count * each *
                            (channel->interpolation == GLTF_CUBIC ? 3 : 1);
    if (values->numbers.width == widths[path] && values->count == wanted) return TULLE_OK;
    return json_fail(&scene->file->json, place, error,
                     "the channel needs %llu values of %u numbers, but has %llu of %u",
                     (unsigned long long)wanted, widths[path], (unsigned long long)values->count,
                     values->numbers.width);
}

static tulle_status read_channel(gltf_scene *scene, const json_value *item,
                                 const json_value *const *samplers, size_t sampler_count,
                                 tulle_error *error) {
    static const char *const names[] = {"translation", "rotation", "scale", "weights"};
    gltf_file *const file = scene->file;
    const json_value *target = NULL;
    const char *path = NULL;
    uint32_t node, number;
    tulle_status status =
        json_take_member(&file->json, item, "target", JSON_OBJECT, &target, error);
    if (status == TULLE_OK) status = json_take_string(&file->json, target, "path", &path, error);
    if (status == TULLE_OK)
        status = gltf_find_number(file, target, "node", scene->nodes.count, &node, error);
    if (status == TULLE_OK)
        status = gltf_find_number(file, item, "sampler", sampler_count, &number, error);
    if (status || node == GLTF_NONE) return status;
    int kind = GLTF_PATH_COUNT - 1;
    while (kind >= 0 && strcmp(path, names[kind]) != 0) kind--;
    if (kind < 0 || number == GLTF_NONE)
        return json_fail(&file->json, item, error, "the channel has no sampler, or drives nothing");
    if (kind == GLTF_WEIGHTS && scene->nodes.data[node].target_count == 0) return TULLE_OK;
    gltf_channel *const channel = &scene->nodes.data[node].channels[kind];
    channel->path = (gltf_path)kind;
    channel->width = kind == GLTF_WEIGHTS    ? scene->nodes.data[node].target_count
                     : kind == GLTF_ROTATION ? 4
                                             : 3;
    status = read_sampler(scene, samplers[number], channel, error);
    return status == TULLE_OK ? check_channel(scene, item, channel, error) : status;
}

static tulle_status read_channels(gltf_scene *scene, const json_value *channels,
                                  const json_value *samplers, tulle_error *error) {
    gltf_file *const file = scene->file;
    size_t const size = (samplers->count + 1) * sizeof(const json_value *);
    const json_value **const numbered = memory_allocate(file->heap, size);
    if (!numbered) return fail_memory(scene, error);
    const json_value *item = json_get_first(&file->json, samplers);
    for (size_t i = 0; i < samplers->count; i++, item = json_get_next(&file->json, item))
        numbered[i] = item;
    tulle_status status = TULLE_OK;
    for (item = json_get_first(&file->json, channels); item && status == TULLE_OK;
         item = json_get_next(&file->json, item))
        status = read_channel(scene, item, numbered, samplers->count, error);
    memory_release(file->heap, numbered, size);
    return status;
}

static int compare_times(const void *a, const void *b) {
    double const one = *(const double *)a, other = *(const double *)b;
    return (one > other) - (one < other);
}

/* All different times of the keys. */
static tulle_status make_frames(gltf_scene *scene, tulle_error *error) {
    memory *const heap = scene->file->heap;
    size_t const count = scene->times.count;
    if (!ARRAY_RESERVE(heap, &scene->frames, count + 1)) return fail_memory(scene, error);
    double *const frames = scene->frames.data;
    frames[0] = 0.0;
    if (count > 0) memcpy(frames, scene->times.data, count * sizeof *frames);
    if (scene->keys.count > 1 || scene->jump_count > 0)
        sort_in_place(frames, count, sizeof *frames, compare_times);
    scene->frames.count = 1;
    for (size_t i = 1; i < count; i++)
        if (frames[i] > frames[scene->frames.count - 1]) frames[scene->frames.count++] = frames[i];
    return TULLE_OK;
}

static tulle_status sample(gltf_scene *scene, const gltf_channel *channel, double time,
                           double *values, tulle_error *error);

/* Frames just before the keys at which steps change a value, so that vertices jump there. */
static tulle_status add_jumps(gltf_scene *scene, const gltf_channel *channel, tulle_error *error) {
    const gltf_keys keys = scene->keys.data[channel->keys];
    memory *const heap = scene->file->heap;
    size_t const width = channel->width, size = 6 * width * sizeof(double);
    double *const values = memory_allocate(heap, size);
    if (!values) return fail_memory(scene, error);
    double *now = values, *before = values + 3 * width;
    tulle_status status = TULLE_OK;
    for (size_t i = 0; i < keys.count && status == TULLE_OK; i++) {
        double const key = scene->times.data[keys.first + i];
        status = sample(scene, channel, key, now, error);
        float time = nextafterf((float)key, -INFINITY);
        if ((double)time >= key) time = nextafterf(time, -INFINITY);
        bool const jumps = status == TULLE_OK && i > 0 &&
                           memcmp(now, before, width * sizeof *now) != 0 &&
                           (double)time > scene->times.data[keys.first + i - 1];
        if (jumps && !ARRAY_RESERVE(heap, &scene->times, 1)) status = fail_memory(scene, error);
        if (jumps && status == TULLE_OK) {
            scene->times.data[scene->times.count++] = (double)time;
            scene->jump_count++;
        }
        double *const spare = now;
        now = before;
        before = spare;
    }
    memory_release(heap, values, size);
    return status;
}

static tulle_status add_all_jumps(gltf_scene *scene, tulle_error *error) {
    tulle_status status = TULLE_OK;
    for (size_t i = 0; i < scene->nodes.count; i++)
        for (int path = 0; path < GLTF_PATH_COUNT && status == TULLE_OK; path++) {
            const gltf_channel *const channel = &scene->nodes.data[i].channels[path];
            if (channel->keys != GLTF_NONE && channel->interpolation == GLTF_STEP)
                status = add_jumps(scene, channel, error);
        }
    return status;
}

/* What turns the vertices of a channel's node, or leads them along a curve. */
static tulle_status find_channel_turn(gltf_scene *scene, const gltf_channel *channel,
                                      const double moments[2], double *turn, tulle_error *error) {
    const gltf_keys *const keys = &scene->keys.data[channel->keys];
    const double *const times = scene->times.data + keys->first;
    bool const is_cubic = channel->interpolation == GLTF_CUBIC;
    if (channel->interpolation == GLTF_STEP || moments[1] <= times[0] ||
        moments[0] >= times[keys->count - 1])
        return TULLE_OK;
    if (is_cubic) *turn += CURVE_TURN;
    if (is_cubic || channel->path == GLTF_TRANSLATION || channel->path == GLTF_WEIGHTS)
        return TULLE_OK;
    double values[2][12];
    for (int i = 0; i < 2; i++) {
        tulle_status const status = sample(scene, channel, moments[i], values[i], error);
        if (status) return status;
    }
    if (channel->path == GLTF_ROTATION)
        *turn += rotation_find_angle(values[0], values[1]);
    else if (memcmp(values[0], values[1], 3 * sizeof(double)) != 0)
        *turn += SCALE_TURN;
    return TULLE_OK;
}

static tulle_status find_turn(void *context, double from, double to, double *turn,
                              tulle_error *error) {
    gltf_scene *const scene = context;
    double const moments[2] = {from, to};
    tulle_status status = TULLE_OK;
    for (size_t i = 0; i < scene->nodes.count; i++)
        for (int path = 0; path < GLTF_PATH_COUNT && status == TULLE_OK; path++) {
            const gltf_node *const node = &scene->nodes.data[i];
            if (node->channels[path].keys != GLTF_NONE && !node->has_matrix)
                status = find_channel_turn(scene, &node->channels[path], moments, turn, error);
        }
    return status;
}

static tulle_status pose(void *scene, double time, double *positions, tulle_error *error) {
    return gltf_scene_pose(scene, time, positions, error);
}

/* Adds frames where vertices turn. */
static tulle_status add_frames(gltf_scene *scene, tulle_error *error) {
    memory *const heap = scene->file->heap;
    size_t const part_count = scene->pieces.count;
    fine_frames fine = {.heap = heap,
                        .path = scene->file->path,
                        .scene = scene,
                        .pose = pose,
                        .find_turn = find_turn,
                        .part_count = part_count,
                        .keys = scene->frames.data,
                        .key_count = scene->frames.count};
    tulle_status status = fine_frames_make(&fine, error);
    if (status == TULLE_OK) {
        for (size_t i = 0; i < part_count; i++)
            fine.first_vertices[i] = scene->pieces.data[i].first_vertex;
        fine.first_vertices[part_count] = scene->vertex_count;
        status = fine_frames_find(&fine, error);
    }
    if (status == TULLE_OK && !ARRAY_RESERVE(heap, &scene->frames, fine.added_count))
        status = fail_memory(scene, error);
    if (status == TULLE_OK) {
        fine_frames_spread(&fine, scene->frames.data);
        scene->frames.count += fine.added_count;
        scene->turn_count = fine.added_count;
        scene->is_turning_too_fast = fine.is_cut;
    }
    fine_frames_release(&fine);
    return status;
}

tulle_status gltf_animation_read(gltf_scene *scene, tulle_error *error) {
    gltf_file *const file = scene->file;
    size_t count, most_targets = 0;
    const json_value *const animation = gltf_get_items(file, "animations", &count);
    const json_value *channels = NULL, *samplers = NULL;
    tulle_status status = TULLE_OK;
    scene->passed_animations = count > 1 ? count - 1 : 0;
    if (animation) {
        status = json_take_member(&file->json, animation, "channels", JSON_ARRAY, &channels, error);
        if (status == TULLE_OK)
            status =
                json_take_member(&file->json, animation, "samplers", JSON_ARRAY, &samplers, error);
        if (status) return status;
        status = read_channels(scene, channels, samplers, error);
    }
    if (status == TULLE_OK) status = add_all_jumps(scene, error);
    if (status == TULLE_OK) status = make_frames(scene, error);
    if (status) return status;
    size_t most_vertices = 0;
    for (size_t i = 0; i < scene->pieces.count; i++) {
        const gltf_piece *const piece = &scene->pieces.data[i];
        if (piece->target_count > most_targets) most_targets = piece->target_count;
        if (piece->vertex_count > most_vertices) most_vertices = piece->vertex_count;
    }
    if (!ARRAY_RESERVE(file->heap, &scene->weights, 3 * most_targets + 1) ||
        !ARRAY_RESERVE(file->heap, &scene->scratch, 3 * most_vertices))
        return fail_memory(scene, error);
    return scene->frames.count > 1 ? add_frames(scene, error) : TULLE_OK;
}

/* ---- values at a time ---- */

/* Reads the value of a channel to `values`, which has room for three times as many numbers. */
static tulle_status sample(gltf_scene *scene, const gltf_channel *channel, double time,
                           double *values, tulle_error *error) {
    gltf_path const path = channel->path;
    size_t const width = channel->width;
    const gltf_keys *const keys = &scene->keys.data[channel->keys];
    const double *const times = scene->times.data + keys->first;
    size_t low = 0, high = keys->count; /* the last key that is not behind */
    while (high - low > 1) {
        size_t const middle = low + (high - low) / 2;
        *(times[middle] <= time ? &low : &high) = middle;
    }
    size_t const each = path == GLTF_WEIGHTS ? width : 1; /* elements of a value */
    bool const is_cubic = channel->interpolation == GLTF_CUBIC;
    size_t const stride = is_cubic ? 3 * each : each;
    size_t const at = low * stride + (is_cubic ? each : 0);
    gltf_file *const file = scene->file;
    tulle_status status = gltf_read(file, channel->values, at, each, values, error);
    if (status || time <= times[low] || low + 1 == keys->count ||
        channel->interpolation == GLTF_STEP)
        return status;
    double const interval = times[low + 1] - times[low], part = (time - times[low]) / interval;
    double *const next = values + width, *const tangent = values + 2 * width;
    status = gltf_read(file, channel->values, at + stride, each, next, error);
    if (status) return status;
    if (path == GLTF_ROTATION && !is_cubic) {
        rotation_interpolate(values, next, part, values);
        return TULLE_OK;
    }
    double const square = part * part, cube = square * part;
    for (size_t i = 0; i < width; i++)
        values[i] = is_cubic ? (2.0 * cube - 3.0 * square + 1.0) * values[i] +
                                   (3.0 * square - 2.0 * cube) * next[i]
                             : (1.0 - part) * values[i] + part * next[i];
    if (!is_cubic) return TULLE_OK;
    status =
        gltf_read(file, channel->values, at + each, each, tangent, error); /* out of this key */
    for (size_t i = 0; i < width && status == TULLE_OK; i++)
        values[i] += interval * (cube - 2.0 * square + part) * tangent[i];
    if (status == TULLE_OK) /* into the next one */
        status = gltf_read(file, channel->values, at + stride - each, each, tangent, error);
    for (size_t i = 0; i < width && status == TULLE_OK; i++)
        values[i] += interval * (cube - square) * tangent[i];
    if (path == GLTF_ROTATION) rotation_normalize(values);
    return status;
}

static tulle_status pose_nodes(gltf_scene *scene, double time, tulle_error *error) {
    for (size_t i = 0; i < scene->order.count; i++) {
        gltf_node *const node = &scene->nodes.data[scene->order.data[i]];
        double values[3][12];
        memcpy(values[GLTF_TRANSLATION], node->translation, sizeof node->translation);
        memcpy(values[GLTF_ROTATION], node->rotation, sizeof node->rotation);
        memcpy(values[GLTF_SCALE], node->scale, sizeof node->scale);
        for (int path = 0; path < GLTF_WEIGHTS; path++) {
            if (node->channels[path].keys == GLTF_NONE) continue;
            tulle_status const status =
                sample(scene, &node->channels[path], time, values[path], error);
            if (status) return status;
        }
        if (node->has_matrix)
            memcpy(node->global, node->matrix, sizeof node->global);
        else
            matrix_make(values[GLTF_TRANSLATION], values[GLTF_ROTATION], values[GLTF_SCALE],
                        node->global);
        if (node->parent != GLTF_NONE)
            matrix_multiply(scene->nodes.data[node->parent].global, node->global, node->global);
    }
    return TULLE_OK;
}

/* ---- vertices ---- */

static tulle_status add_targets(gltf_scene *scene, const gltf_piece *piece, double time,
                                double *positions, tulle_error *error) {
    gltf_node *const node = &scene->nodes.data[piece->node];
    const gltf_channel *const channel = &node->channels[GLTF_WEIGHTS];
    double *const weights = scene->weights.data;
    memset(weights, 0, piece->target_count * sizeof *weights);
    tulle_status status = TULLE_OK;
    if (channel->keys != GLTF_NONE) {
        status = sample(scene, channel, time, weights, error);
    } else if (node->weights) {
        const json_value *item = json_get_first(&scene->file->json, node->weights);
        for (size_t i = 0; i < piece->target_count; i++) {
            weights[i] = item->number;
            item = json_get_next(&scene->file->json, item);
        }
    }
    for (size_t i = 0; i < piece->target_count && status == TULLE_OK; i++) {
        uint32_t const target = scene->targets.data[piece->first_target + i];
        if (weights[i] == 0.0 || target == GLTF_NONE) continue;
        status = gltf_read(scene->file, target, 0, piece->vertex_count, scene->scratch.data, error);
        for (size_t k = 0; k < 3 * piece->vertex_count && status == TULLE_OK; k++)
            positions[k] += weights[i] * scene->scratch.data[k];
    }
    return status;
}

/* A skin as the frame has it: joints by number, matrices of those that are to be bound. */
typedef struct skin {
    const json_value *joints;
    uint32_t bindings; /* accessor, or GLTF_NONE */
    double *matrices;  /* 16 a joint */
    size_t joint_count;
    const gltf_piece *piece;        /* that it moves */
    const double *positions;        /* of that, before */
    double moved[3 * VERTEX_CHUNK]; /* of some of its vertices, after */
} skin;

static tulle_status make_skin(gltf_scene *scene, uint32_t number, skin *made, tulle_error *error) {
    gltf_file *const file = scene->file;
    size_t count;
    const json_value *item = gltf_get_items(file, "skins", &count);
    for (uint32_t i = 0; i < number; i++) item = json_get_next(&file->json, item);
    tulle_status status =
        json_take_member(&file->json, item, "joints", JSON_ARRAY, &made->joints, error);
    if (status == TULLE_OK)
        status = gltf_find_accessor(file, item, "inverseBindMatrices", 16, &made->bindings, error);
    if (status) return status;
    made->joint_count = made->joints->count;
    if (made->bindings != GLTF_NONE &&
        file->accessors.data[made->bindings].count < made->joint_count)
        return json_fail(&file->json, item, error, "the skin has fewer matrices than joints");
    made->matrices = memory_allocate(file->heap, 16 * made->joint_count * sizeof(double));
    if (!made->matrices) return fail_memory(scene, error);
    const json_value *joint = json_get_first(&file->json, made->joints);
    for (size_t i = 0; i < made->joint_count && status == TULLE_OK; i++) {
        double *const matrix = made->matrices + 16 * i;
        if (joint->type != JSON_NUMBER || !(joint->number >= 0.0) ||
            joint->number >= (double)scene->nodes.count)
            return json_fail(&file->json, joint, error, "there is no such node");
        memcpy(matrix, MATRIX_IDENTITY, sizeof MATRIX_IDENTITY);
        if (made->bindings != GLTF_NONE)
            status = gltf_read(file, made->bindings, i, 1, matrix, error);
        matrix_multiply(scene->nodes.data[(size_t)joint->number].global, matrix, matrix);
        joint = json_get_next(&file->json, joint);
    }
    return status;
}

/* Adds what the joints of one set, the accessors of joints and weights, make of `count` vertices.
 */
static tulle_status add_joints(gltf_scene *scene, skin *bound, const uint32_t set[2], size_t first,
                               size_t count, tulle_error *error) {
    double joints[4 * VERTEX_CHUNK], weights[4 * VERTEX_CHUNK];
    tulle_status status = gltf_read(scene->file, set[0], first, count, joints, error);
    if (status == TULLE_OK) status = gltf_read(scene->file, set[1], first, count, weights, error);
    for (size_t i = 0; i < 4 * count && status == TULLE_OK; i++) {
        if (weights[i] == 0.0) continue;
        size_t const vertex = first + i / 4;
        if (!(joints[i] >= 0.0 && joints[i] < (double)bound->joint_count))
            return json_fail(&scene->file->json, bound->piece->primitive, error,
                             "vertex %zu hangs at joint %.0f, but there are only %zu", vertex,
                             joints[i], bound->joint_count);
        double point[3];
        matrix_transform(bound->matrices + 16 * (size_t)joints[i], bound->positions + 3 * vertex,
                         point);
        for (size_t k = 0; k < 3; k++) bound->moved[3 * (i / 4) + k] += weights[i] * point[k];
    }
    return status;
}

static tulle_status find_joint_sets(gltf_scene *scene, const gltf_piece *piece,
                                    uint32_t sets[JOINT_SETS][2], int *set_count,
                                    tulle_error *error) {
    static const char *const names[JOINT_SETS][2] = {{"JOINTS_0", "WEIGHTS_0"},
                                                     {"JOINTS_1", "WEIGHTS_1"},
                                                     {"JOINTS_2", "WEIGHTS_2"},
                                                     {"JOINTS_3", "WEIGHTS_3"}};
    gltf_file *const file = scene->file;
    const json_value *const attributes = json_find(&file->json, piece->primitive, "attributes");
    for (*set_count = 0; *set_count < JOINT_SETS; (*set_count)++) {
        uint32_t *const set = sets[*set_count];
        for (int i = 0; i < 2; i++) {
            tulle_status const status =
                gltf_find_accessor(file, attributes, names[*set_count][i], 4, &set[i], error);
            if (status) return status;
            if (set[i] != GLTF_NONE && file->accessors.data[set[i]].count != piece->vertex_count)
                return json_fail(&file->json, attributes, error,
                                 "joints or weights are not as many as the vertices");
        }
        if (set[0] == GLTF_NONE || set[1] == GLTF_NONE) break;
    }
    if (*set_count > 0) return TULLE_OK;
    return json_fail(&file->json, piece->primitive, error, "the mesh of a skin has no joints");
}

static tulle_status apply_skin(gltf_scene *scene, const gltf_piece *piece, double *positions,
                               tulle_error *error) {
    skin bound = {.piece = piece, .positions = positions};
    uint32_t sets[JOINT_SETS][2];
    int set_count = 0;
    tulle_status status = find_joint_sets(scene, piece, sets, &set_count, error);
    if (status == TULLE_OK)
        status = make_skin(scene, scene->nodes.data[piece->node].skin, &bound, error);
    for (size_t first = 0; first < piece->vertex_count && status == TULLE_OK;
         first += VERTEX_CHUNK) {
        size_t const rest = piece->vertex_count - first;
        size_t const count = rest < VERTEX_CHUNK ? rest : VERTEX_CHUNK;
        memset(bound.moved, 0, sizeof bound.moved);
        for (int i = 0; i < set_count && status == TULLE_OK; i++)
            status = add_joints(scene, &bound, sets[i], first, count, error);
        memcpy(positions + 3 * first, bound.moved, 3 * count * sizeof(double));
    }
    memory_release(scene->file->heap, bound.matrices, 16 * bound.joint_count * sizeof(double));
    return status;
}

/* The determinant of what moves a piece: its node, or the first joint of its skin. */
static tulle_status measure_side(gltf_scene *scene, const gltf_piece *piece, double *side,
                                 tulle_error *error) {
    const gltf_node *const node = &scene->nodes.data[piece->node];
    *side = matrix_get_determinant(node->global);
    if (node->skin == GLTF_NONE) return TULLE_OK;
    skin bound = {.piece = piece};
    tulle_status const status = make_skin(scene, node->skin, &bound, error);
    if (status == TULLE_OK && bound.joint_count > 0) *side = matrix_get_determinant(bound.matrices);
    memory_release(scene->file->heap, bound.matrices, 16 * bound.joint_count * sizeof(double));
    return status;
}

tulle_status gltf_scene_turn(gltf_scene *scene, tulle_error *error) {
    size_t left = scene->pieces.count;
    for (size_t frame = 0; frame < scene->frames.count && left > 0; frame++) {
        tulle_status status = pose_nodes(scene, scene->frames.data[frame], error);
        for (size_t i = 0; i < scene->pieces.count && status == TULLE_OK; i++) {
            gltf_piece *const piece = &scene->pieces.data[i];
            if (piece->has_side) continue;
            double side;
            status = measure_side(scene, piece, &side, error);
            if (status || side == 0.0) continue;
            piece->has_side = true;
            left--;
            if (side < 0.0)
                turn_triangles(scene->triangles.data + 3 * piece->first_triangle,
                               piece->triangle_count);
        }
        if (status) return status;
    }
    return TULLE_OK;
}

static tulle_status pose_piece(gltf_scene *scene, const gltf_piece *piece, double time,
                               double *positions, tulle_error *error) {
    const gltf_node *const node = &scene->nodes.data[piece->node];
    tulle_status status =
        gltf_read(scene->file, piece->positions, 0, piece->vertex_count, positions, error);
    if (status == TULLE_OK && piece->target_count > 0)
        status = add_targets(scene, piece, time, positions, error);
    if (status) return status;
    if (node->skin != GLTF_NONE) return apply_skin(scene, piece, positions, error);
    if (matrix_is_identity(node->global)) return TULLE_OK;
    for (size_t i = 0; i < piece->vertex_count; i++)
        matrix_transform(node->global, positions + 3 * i, positions + 3 * i);
    return TULLE_OK;
}

tulle_status gltf_scene_pose(gltf_scene *scene, double time, double *positions,
                             tulle_error *error) {
    tulle_status status = pose_nodes(scene, time, error);
    for (size_t i = 0; i < scene->pieces.count && status == TULLE_OK; i++)
        status = pose_piece(scene, &scene->pieces.data[i], time,
                            positions + 3 * scene->pieces.data[i].first_vertex, error);
    for (size_t i = 0; i < 3 * scene->vertex_count && status == TULLE_OK; i++)
        if (!isfinite(positions[i]))
            status = error_set_at(error, TULLE_ERROR_PARSE, scene->file->path, 0, 0,
                                  "at %g s vertex %zu is not finite", time, i / 3);
    return status;
}
