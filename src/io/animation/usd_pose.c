/* io/animation/usd_pose.c - values of a USD file at a time, the transforms that come of them, and
 * the vertices that these move.
 *
 * Based on: Pixar, Universal Scene Description, schemas UsdGeomXformable, UsdGeomPointInstancer. */
#include "base/error.h"
#include "base/sort.h"
#include "io/animation/matrix.h"
#include "io/animation/rotation.h"
#include "io/animation/usd_scene.h"
#include "io/file_data.h"

#include <math.h>

static const double PI = 3.14159265358979323846;
/* [rad] As a turn that needs to be looked at: scales and matrices bend the paths of what turns or
 * moves below them. */
static const double SCALE_TURN = 1e-3;
/* [rad] Matrices that turn by less go along lines: the sagitta is below the rounding of floats. */
static const double STILL_TURN = 1e-4;
/* [rad] 170 degrees: from there on the way round that a matrix goes is a guess. */
static const double CLEAR_TURN = 2.96705972839036;

/* ---- values ---- */

/* Reads a value at a place, which should have as many elements as there is room for. */
static tulle_status read_value(usd_scene *scene, const usd_attribute *attribute, usd_place place,
                               usd_numbers numbers, tulle_error *error) {
    usd_text *const text = &scene->layer->text;
    size_t found = 0;
    tulle_status const status = usd_text_read(text, place, numbers, &found, error);
    if (status) return status;
    if (found != numbers.room)
        return usd_text_fail(
            text, place, error, "there are %zu values of %s, not %zu; their number may not change",
            found, usd_layer_get_text(scene->layer, attribute->full_name), numbers.room);
    double *const values = numbers.values;
    for (size_t i = 0; i < numbers.width * numbers.room && !attribute->is_double; i++) {
        values[i] = (double)(float)values[i];
        if (!isfinite(values[i]))
            return usd_text_fail(text, place, error, "number %zu is too large for its type", i);
    }
    return TULLE_OK;
}

bool usd_find_value(const usd_layer *layer, uint32_t number, usd_place *place) {
    if (number == USD_NONE) return false;
    const usd_attribute *const attribute = &layer->attributes.data[number];
    *place = attribute->sample_count > 0 ? layer->samples.data[attribute->first_sample].place
                                         : attribute->value;
    return attribute->sample_count > 0 || attribute->has_value;
}

tulle_status usd_count_named(usd_scene *scene, usd_place place, const double *ids, size_t count,
                             uint32_t *named, tulle_error *error) {
    usd_text *const text = &scene->layer->text;
    size_t found = 0;
    tulle_status status = usd_text_read(text, place, (usd_numbers){1, NULL, 0}, &found, error);
    if (status || found == 0) return status;
    size_t const size = found * sizeof(double);
    double *const list = memory_allocate(text->heap, size);
    if (!list) return file_fail_memory(error, scene->layer->text.path);
    status = usd_text_read(text, place, (usd_numbers){1, list, found}, &found, error);
    if (status == TULLE_OK) sort_in_place(list, found, sizeof *list, compare_doubles);
    for (size_t i = 0; i < count && status == TULLE_OK; i++) {
        double const id = ids ? ids[i] : (double)i;
        size_t low = 0, high = found;
        while (low < high) {
            size_t const middle = low + (high - low) / 2;
            if (list[middle] < id)
                low = middle + 1;
            else
                high = middle;
        }
        named[i] += low < found && list[low] == id;
    }
    memory_release(text->heap, list, size);
    return status;
}

/* Goes a part of the way to another matrix: as a pose where neither shears, so that what is rigid
 * stays rigid; false where it has to go along a line. *angle: [rad] what turns. */
static bool interpolate_pose(double *matrix, const double *next, double part, double *angle) {
    double t[2][3], q[2][4], s[2][3];
    if (!matrix_split(matrix, t[0], q[0], s[0]) || !matrix_split(next, t[1], q[1], s[1]))
        return false;
    if ((s[0][0] < 0.0) != (s[1][0] < 0.0)) return false; /* through a plane */
    *angle = rotation_find_angle(q[0], q[1]);
    if (*angle <= STILL_TURN) return false;
    for (int i = 0; i < 3; i++) {
        t[0][i] = (1.0 - part) * t[0][i] + part * t[1][i];
        s[0][i] = (1.0 - part) * s[0][i] + part * s[1][i];
    }
    rotation_interpolate(q[0], q[1], part, q[0]);
    matrix_make(t[0], q[0], s[0], matrix);
    return true;
}

/* Goes a part of the way to other values. Quaternions have 4 numbers, matrices 16, and nothing else
 * here has. Returns by what angle a matrix turns [rad]; 0 for all else. */
static double interpolate(usd_numbers numbers, const double *next, double part) {
    double angle = 0.0;
    if (numbers.width == 16 && interpolate_pose(numbers.values, next, part, &angle)) return angle;
    double *const values = numbers.values;
    bool const is_turn = numbers.width == 4;
    for (size_t i = 0; i < numbers.room && is_turn; i++) {
        double to[4];
        memcpy(to, next + 4 * i, sizeof to);
        rotation_normalize(values + 4 * i);
        rotation_normalize(to);
        rotation_interpolate(values + 4 * i, to, part, values + 4 * i);
    }
    for (size_t i = 0; i < numbers.width * numbers.room && !is_turn; i++)
        values[i] = (1.0 - part) * values[i] + part * next[i];
    return 0.0;
}

tulle_status usd_attribute_read(usd_scene *scene, uint32_t number, double code, usd_numbers numbers,
                                tulle_error *error) {
    const usd_attribute *const attribute = &scene->layer->attributes.data[number];
    const usd_sample *const samples = scene->layer->samples.data + attribute->first_sample;
    if (attribute->sample_count == 0)
        return read_value(scene, attribute, attribute->value, numbers, error);
    size_t low = 0, high = attribute->sample_count; /* the last sample that is not behind */
    while (high - low > 1) {
        size_t const middle = low + (high - low) / 2;
        *(samples[middle].code <= code ? &low : &high) = middle;
    }
    tulle_status status = read_value(scene, attribute, samples[low].place, numbers, error);
    if (status || code <= samples[low].code || low + 1 == attribute->sample_count) return status;
    scene->scratch.count = 0;
    if (!ARRAY_RESERVE(scene->layer->text.heap, &scene->scratch, numbers.width * numbers.room))
        return file_fail_memory(error, scene->layer->text.path);
    usd_numbers const next = {numbers.width, scene->scratch.data, numbers.room};
    status = read_value(scene, attribute, samples[low + 1].place, next, error);
    double const interval = samples[low + 1].code - samples[low].code;
    if (status) return status;
    double const turn = interpolate(numbers, next.values, (code - samples[low].code) / interval);
    if (turn > CLEAR_TURN && scene->half_turn_line == 0)
        scene->half_turn_line = samples[low + 1].place.line;
    return TULLE_OK;
}

/* ---- transforms ---- */

/* Of quarters of a turn, exact. */
static void get_cosine_and_sine(double degrees, double *cosine, double *sine) {
    double const rest = fmod(degrees, 360.0), quarters = rest / 90.0;
    *cosine = cos(rest * (PI / 180.0));
    *sine = sin(rest * (PI / 180.0));
    if (quarters != floor(quarters)) return;
    static const double cosines[] = {1, 0, -1, 0}, sines[] = {0, 1, 0, -1};
    int const quarter = ((int)quarters + 4) % 4;
    *cosine = cosines[quarter];
    *sine = sines[quarter];
}

static void make_rotation(const usd_op *op, const double *angles, double *matrix) {
    memcpy(matrix, MATRIX_IDENTITY, sizeof MATRIX_IDENTITY);
    for (size_t i = 0; i < op->width; i++) {
        double cosine, sine, about[16];
        int const axis = op->axes[i] - 'X', next = (axis + 1) % 3, last = (axis + 2) % 3;
        get_cosine_and_sine(angles[i], &cosine, &sine);
        memcpy(about, MATRIX_IDENTITY, sizeof MATRIX_IDENTITY);
        about[4 * next + next] = about[4 * last + last] = cosine;
        about[4 * next + last] = sine;
        about[4 * last + next] = -sine;
        matrix_multiply(about, matrix, matrix);
    }
}

/* False where there is no inverse. */
static bool invert(const double *matrix, double *inverse) {
    const double *const a = matrix, *const b = matrix + 4, *const c = matrix + 8;
    double rows[3][3];
    const double *const columns[3] = {a, b, c};
    for (int i = 0; i < 3; i++) {
        const double *const u = columns[(i + 1) % 3], *const v = columns[(i + 2) % 3];
        for (int k = 0; k < 3; k++)
            rows[i][k] = u[(k + 1) % 3] * v[(k + 2) % 3] - u[(k + 2) % 3] * v[(k + 1) % 3];
    }
    double const determinant = a[0] * rows[0][0] + a[1] * rows[0][1] + a[2] * rows[0][2];
    memcpy(inverse, MATRIX_IDENTITY, sizeof MATRIX_IDENTITY);
    for (int row = 0; row < 3; row++) {
        for (int column = 0; column < 3; column++)
            inverse[4 * column + row] = rows[row][column] / determinant;
        inverse[12 + row] = 0.0;
    }
    for (int row = 0; row < 3; row++)
        for (int k = 0; k < 3; k++) inverse[12 + row] -= inverse[4 * k + row] * matrix[12 + k];
    for (int i = 0; i < 16; i++)
        if (!isfinite(inverse[i])) return false;
    return true;
}

static tulle_status make_op(usd_scene *scene, const usd_op *op, double code, double *matrix,
                            tulle_error *error) {
    static const double no_turn[4] = {0, 0, 0, 1}, no_scale[3] = {1, 1, 1}, no_way[3] = {0, 0, 0};
    double values[16], moves[3] = {0, 0, 0}, scales[3] = {1, 1, 1};
    const usd_attribute *const attribute = &scene->layer->attributes.data[op->attribute];
    tulle_status const status =
        usd_attribute_read(scene, op->attribute, code, (usd_numbers){op->width, values, 1}, error);
    memcpy(matrix, MATRIX_IDENTITY, sizeof MATRIX_IDENTITY);
    if (status) return status;
    switch (op->kind) {
    case USD_TRANSLATE:
        for (size_t i = 0; i < op->width; i++)
            moves[op->axes[i] - 'X'] = op->is_inverse ? -values[i] : values[i];
        matrix_make(moves, no_turn, no_scale, matrix);
        return TULLE_OK;
    case USD_SCALE:
        for (size_t i = 0; i < op->width; i++) scales[op->axes[i] - 'X'] = values[i];
        matrix_make(no_way, no_turn, scales, matrix);
        break;
    case USD_ROTATE: make_rotation(op, values, matrix); break;
    case USD_ORIENT: {
        rotation_normalize(values);
        double const q[4] = {values[1], values[2], values[3], values[0]};
        matrix_make(no_way, q, no_scale, matrix);
        break;
    }
    case USD_MATRIX:
        memcpy(matrix, values, sizeof values);
        if (values[3] != 0.0 || values[7] != 0.0 || values[11] != 0.0 || values[15] != 1.0)
            return usd_text_fail(&scene->layer->text, attribute->place, error,
                                 "the matrix is a projection: its last column should be 0, 0, 0, "
                                 "1");
        break;
    }
    double inverse[16];
    if (!op->is_inverse) return TULLE_OK;
    if (!invert(matrix, inverse))
        return usd_text_fail(&scene->layer->text, attribute->place, error,
                             "the transform has no inverse");
    memcpy(matrix, inverse, sizeof inverse);
    return TULLE_OK;
}

tulle_status usd_node_read_local(usd_scene *scene, usd_node *node, double code,
                                 tulle_error *error) {
    tulle_status status = TULLE_OK;
    memcpy(node->local, MATRIX_IDENTITY, sizeof node->local);
    for (size_t i = 0; i < node->op_count && status == TULLE_OK; i++) {
        double matrix[16];
        status = make_op(scene, &scene->ops.data[node->first_op + i], code, matrix, error);
        if (status == TULLE_OK) matrix_multiply(node->local, matrix, node->local);
    }
    return status;
}

/* Reads one of the arrays of an instancer, where there is one. */
static tulle_status read_instances(usd_scene *scene, uint32_t attribute, double code,
                                   usd_numbers numbers, tulle_error *error) {
    return attribute == USD_NONE ? TULLE_OK
                                 : usd_attribute_read(scene, attribute, code, numbers, error);
}

static tulle_status pose_instancer(usd_scene *scene, const usd_instancer *instancer, double code,
                                   tulle_error *error) {
    memory *const heap = scene->layer->text.heap;
    size_t const count = instancer->count, size = 10 * count * sizeof(double);
    double *const moves = memory_allocate_zeroed(heap, 10 * count, sizeof(double));
    if (!moves) return file_fail_memory(error, scene->layer->text.path);
    double *const turns = moves + 3 * count, *const scales = turns + 4 * count;
    for (size_t i = 0; i < count; i++) {
        turns[4 * i] = 1.0;
        for (size_t k = 0; k < 3; k++) scales[3 * i + k] = 1.0;
    }
    tulle_status status =
        read_instances(scene, instancer->positions, code, (usd_numbers){3, moves, count}, error);
    if (status == TULLE_OK)
        status = read_instances(scene, instancer->orientations, code,
                                (usd_numbers){4, turns, count}, error);
    if (status == TULLE_OK)
        status =
            read_instances(scene, instancer->scales, code, (usd_numbers){3, scales, count}, error);
    for (size_t i = 0; i < count && status == TULLE_OK; i++) {
        double *const turn = turns + 4 * i;
        rotation_normalize(turn);
        double const q[4] = {turn[1], turn[2], turn[3], turn[0]};
        uint32_t const node = scene->instances.data[instancer->first_instance + i];
        if (node != USD_NONE)
            matrix_make(moves + 3 * i, q, scales + 3 * i, scene->nodes.data[node].local);
    }
    memory_release(heap, moves, size);
    return status;
}

/* ---- turns ---- */

static bool is_moving(const usd_scene *scene, uint32_t attribute) {
    return attribute != USD_NONE && scene->layer->attributes.data[attribute].sample_count > 1;
}

/* Of a step of a transform that has samples. */
static tulle_status find_op_turn(usd_scene *scene, const usd_op *op, const double codes[2],
                                 double *turn, tulle_error *error) {
    double values[2][16];
    for (int i = 0; i < 2; i++) {
        tulle_status const status = usd_attribute_read(
            scene, op->attribute, codes[i], (usd_numbers){op->width, values[i], 1}, error);
        if (status) return status;
    }
    if (op->kind == USD_ORIENT) *turn += rotation_find_angle(values[0], values[1]);
    for (size_t i = 0; i < op->width && op->kind == USD_ROTATE; i++)
        *turn += fabs(values[1][i] - values[0][i]) * (PI / 180.0);
    double t[3], q[2][4], s[3];
    if (op->kind == USD_MATRIX && matrix_split(values[0], t, q[0], s) &&
        matrix_split(values[1], t, q[1], s))
        *turn += rotation_find_angle(q[0], q[1]);
    bool const may_bend = op->kind == USD_SCALE || op->kind == USD_MATRIX;
    if (may_bend && memcmp(values[0], values[1], op->width * sizeof(double)) != 0)
        *turn += SCALE_TURN;
    return TULLE_OK;
}

/* The largest turn of an instance; their scales bend paths, too. */
static tulle_status find_instancer_turn(usd_scene *scene, const usd_instancer *instancer,
                                        const double codes[2], double *turn, tulle_error *error) {
    if (is_moving(scene, instancer->scales)) *turn += SCALE_TURN;
    if (!is_moving(scene, instancer->orientations)) return TULLE_OK;
    memory *const heap = scene->layer->text.heap;
    size_t const count = instancer->count, size = 8 * count * sizeof(double);
    double *const turns = memory_allocate_zeroed(heap, 8 * count, sizeof(double));
    if (!turns) return file_fail_memory(error, scene->layer->text.path);
    tulle_status status = TULLE_OK;
    for (size_t i = 0; i < 2 && status == TULLE_OK; i++)
        status = usd_attribute_read(scene, instancer->orientations, codes[i],
                                    (usd_numbers){4, turns + 4 * count * i, count}, error);
    double most = 0.0;
    for (size_t i = 0; i < count && status == TULLE_OK; i++)
        most = fmax(most, rotation_find_angle(turns + 4 * i, turns + 4 * (count + i)));
    *turn += most;
    memory_release(heap, turns, size);
    return status;
}

tulle_status usd_scene_find_turn(usd_scene *scene, double from, double to, double *turn,
                                 tulle_error *error) {
    double const codes[2] = {from, to};
    tulle_status status = TULLE_OK;
    *turn = 0.0;
    for (size_t i = 0; i < scene->instancers.count && status == TULLE_OK; i++)
        status = find_instancer_turn(scene, &scene->instancers.data[i], codes, turn, error);
    for (size_t i = 0; i < scene->nodes.count; i++) {
        const usd_node *const node = &scene->nodes.data[i];
        for (size_t k = 0; k < node->op_count && node->is_used && status == TULLE_OK; k++) {
            const usd_op *const op = &scene->ops.data[node->first_op + k];
            if (is_moving(scene, op->attribute))
                status = find_op_turn(scene, op, codes, turn, error);
        }
    }
    return status;
}

static tulle_status pose_nodes(usd_scene *scene, double code, tulle_error *error) {
    tulle_status status = TULLE_OK;
    for (size_t i = 0; i < scene->instancers.count && status == TULLE_OK; i++)
        status = pose_instancer(scene, &scene->instancers.data[i], code, error);
    for (size_t i = 0; i < scene->nodes.count && status == TULLE_OK; i++) {
        usd_node *const node = &scene->nodes.data[i];
        if (!node->is_used) continue;
        if (node->is_moving) status = usd_node_read_local(scene, node, code, error);
        if (node->parent == USD_NONE || node->resets)
            memcpy(node->global, node->local, sizeof node->global);
        else
            matrix_multiply(scene->nodes.data[node->parent].global, node->local, node->global);
    }
    return status;
}

tulle_status usd_scene_turn(usd_scene *scene, tulle_error *error) {
    size_t left = scene->pieces.count;
    for (size_t frame = 0; frame < scene->codes.count && left > 0; frame++) {
        tulle_status const status = pose_nodes(scene, scene->codes.data[frame], error);
        if (status) return status;
        for (size_t i = 0; i < scene->pieces.count; i++) {
            usd_piece *const piece = &scene->pieces.data[i];
            double const side = matrix_get_determinant(scene->nodes.data[piece->node].global);
            if (piece->has_side || side == 0.0) continue;
            piece->has_side = true;
            left--;
            if (side < 0.0)
                turn_triangles(scene->triangles.data + 3 * piece->first_triangle,
                               piece->triangle_count);
        }
    }
    return TULLE_OK;
}

/* ---- vertices ---- */

static tulle_status pose_piece(usd_scene *scene, const usd_piece *piece, double code,
                               double *positions, tulle_error *error) {
    const double *const matrix = scene->nodes.data[piece->node].global;
    tulle_status status = TULLE_OK;
    if (piece->first_kept != SIZE_MAX)
        memcpy(positions, scene->kept.data + piece->first_kept,
               3 * piece->vertex_count * sizeof(double));
    else
        status = usd_attribute_read(scene, piece->points, code,
                                    (usd_numbers){3, positions, piece->vertex_count}, error);
    if (status || matrix_is_identity(matrix)) return status;
    for (size_t i = 0; i < piece->vertex_count; i++)
        matrix_transform(matrix, positions + 3 * i, positions + 3 * i);
    return TULLE_OK;
}

tulle_status usd_scene_pose(usd_scene *scene, double code, double *positions, tulle_error *error) {
    tulle_status status = pose_nodes(scene, code, error);
    for (size_t i = 0; i < scene->pieces.count && status == TULLE_OK; i++)
        status = pose_piece(scene, &scene->pieces.data[i], code,
                            positions + 3 * scene->pieces.data[i].first_vertex, error);
    for (size_t i = 0; i < 3 * scene->vertex_count && status == TULLE_OK; i++)
        if (!isfinite(positions[i]))
            status = error_set_at(error, TULLE_ERROR_PARSE, scene->layer->text.path, 0, 0,
                                  "at the time code %g vertex %zu is not finite", code, i / 3);
    return status;
}
