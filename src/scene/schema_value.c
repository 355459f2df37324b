/* scene/schema_value.c - reading one value of a known key: type, unit, range. Every refusal says
 * what was found and what would be right. */
#include "scene/schema.h"

#include "base/text.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Adds "PATH: MESSAGE" at a node. Always false. */
static bool refuse_at(const value_work *work, const scene_node *node, const char *found,
                      const char *wanted) {
    problem_add(work->reader->problems, TULLE_ERROR_PARSE, node->place, "%s: is %s, must be %s",
                work->path, found, wanted);
    return false;
}

static void describe(const scene_node *node, char *text, size_t capacity) {
    if (node->kind == NODE_SCALAR && (node->text[0] || node->is_quoted))
        snprintf(text, capacity, "'%s'", show_text(node->text).text);
    else
        snprintf(text, capacity, "%s", node_kind_text(node));
}

/* "at least 0.01 m and at most 3 m". */
static void describe_range(const schema_key *key, const char *unit, char *text, size_t capacity) {
    const char *space = unit[0] ? " " : "";
    const char *least = key->flags & SCHEMA_ABOVE_MINIMUM ? "above" : "at least";
    bool has_least = key->minimum > -DBL_MAX, has_most = key->maximum < DBL_MAX;
    if (has_least && has_most)
        snprintf(text, capacity, "%s %.10g%s%s and at most %.10g%s%s%s", least, key->minimum, space,
                 unit, key->maximum, space, unit,
                 key->flags & SCHEMA_NOT_ZERO ? ", and not 0" : "");
    else if (has_least)
        snprintf(text, capacity, "%s %.10g%s%s", least, key->minimum, space, unit);
    else
        snprintf(text, capacity, "at most %.10g%s%s", key->maximum, space, unit);
}

static bool is_in_range(const schema_key *key, double value) {
    if (key->minimum == 0 && key->maximum == 0) return true;
    if (value < key->minimum || value > key->maximum) return false;
    if (key->flags & SCHEMA_NOT_ZERO && value == 0) return false;
    return !(key->flags & SCHEMA_ABOVE_MINIMUM) || value > key->minimum;
}

/* What a number of this key looks like: "a number with unit m, km, ... or a plain one in m". */
static void describe_number(const schema_key *key, char *text, size_t capacity) {
    char names[100];
    unit_list_names(key->unit, names, sizeof names);
    int used = key->unit == UNIT_NONE ? snprintf(text, capacity, "a number")
                                      : snprintf(text, capacity, "a number in %s, as in '2 %s'",
                                                 names, unit_si_name(key->unit));
    if (key->word && used > 0 && (size_t)used < capacity)
        snprintf(text + used, capacity - (size_t)used, ", or the word %s", key->word);
}

static bool refuse_number(const value_work *work, const scene_node *node, quantity_state state) {
    char found[80], wanted[200], names[100];
    describe(node, found, sizeof found);
    describe_number(work->key, wanted, sizeof wanted);
    if (state == QUANTITY_NOT_FINITE) {
        problem_add(work->reader->problems, TULLE_ERROR_PARSE, node->place,
                    "%s: is %s, must be finite: %s", work->path, found, wanted);
        return false;
    }
    if (state == QUANTITY_UNKNOWN_UNIT) {
        unit_list_names(work->key->unit, names, sizeof names);
        problem_add(work->reader->problems, TULLE_ERROR_PARSE, node->place,
                    "%s: %s has an unknown unit; allowed here: %s%s", work->path, found,
                    work->key->unit == UNIT_NONE ? "none or " : "", names);
        return false;
    }
    return refuse_at(work, node, found, wanted);
}

static bool read_number(const value_work *work, const scene_node *node, double *value) {
    if (node->kind != NODE_SCALAR) return refuse_number(work, node, QUANTITY_NOT_A_NUMBER);
    if (work->key->word && strcmp(node->text, work->key->word) == 0) {
        *value = work->key->word_value;
        return true;
    }
    double number = 0;
    quantity_state state = quantity_read(node->text, work->key->unit, &number);
    if (state != QUANTITY_READ) return refuse_number(work, node, state);
    if (!is_in_range(work->key, number)) {
        char range[160];
        describe_range(work->key, unit_si_name(work->key->unit), range, sizeof range);
        problem_add(work->reader->problems, TULLE_ERROR_INVALID_ARGUMENT, node->place,
                    "%s: is '%s', must be %s", work->path, show_text(node->text).text, range);
        return false;
    }
    *value = number;
    return true;
}

static bool read_integer(const value_work *work, const scene_node *node, uint64_t *value) {
    char found[80], wanted[160];
    describe(node, found, sizeof found);
    const schema_key *key = work->key;
    if (node->kind == NODE_SCALAR && key->word && strcmp(node->text, key->word) == 0) {
        *value = (uint64_t)key->word_value;
        return true;
    }
    unsigned long long integer = 0;
    bool is_read = node->kind == NODE_SCALAR && integer_read(node->text, &integer);
    if (is_read && is_in_range(key, (double)integer)) {
        *value = integer;
        return true;
    }
    int used = snprintf(wanted, sizeof wanted, "a whole number");
    if (key->maximum > 0)
        used = snprintf(wanted, sizeof wanted, "a whole number from %.0f to %.0f", key->minimum,
                        key->maximum);
    if (key->word)
        snprintf(wanted + used, sizeof wanted - (size_t)used, ", or the word %s", key->word);
    return refuse_at(work, node, found, wanted);
}

static bool read_bool(const value_work *work) {
    char found[80];
    const scene_node *node = work->node;
    describe(node, found, sizeof found);
    bool is_true = node->kind == NODE_SCALAR && strcmp(node->text, "true") == 0;
    bool is_false = node->kind == NODE_SCALAR && strcmp(node->text, "false") == 0;
    if (!is_true && !is_false) return refuse_at(work, node, found, "true or false");
    *(bool *)work->field = is_true;
    return true;
}

static bool is_name(const char *text) {
    size_t const size = strlen(text);
    if (size == 0 || size > 64 || text[0] == '.' || text[0] == ' ' || text[size - 1] == ' ')
        return false;
    size_t length = 0;
    for (; *text; text += length)
        if (!text_is_of_name(text_take_character(text, &length))) return false;
    return true;
}

static bool read_text(const value_work *work) {
    const scene_node *node = work->node;
    char found[80];
    describe(node, found, sizeof found);
    bool is_text = node->kind == NODE_SCALAR && (node->text[0] || node->is_quoted);
    if (!is_text) return refuse_at(work, node, found, "text");
    if (work->key->type == SCHEMA_NAME && !is_name(node->text))
        return refuse_at(work, node, found,
                         "a name of letters and digits of any script, '-', '_', '.' and blanks "
                         "within, of 1 to 64 bytes in UTF-8, not beginning with '.'");
    if (work->key->type == SCHEMA_PATH && !node->text[0])
        return refuse_at(work, node, found, "the path of a file, relative to the scene file");
    *(const char **)work->field = node->text;
    return true;
}

static bool read_choice(const value_work *work) {
    const scene_node *node = work->node;
    const char *const *choices = work->key->choices;
    size_t count = 0;
    char list[400] = "", found[80];
    size_t used = 0;
    for (; choices[count]; count++) {
        if (node->kind == NODE_SCALAR && strcmp(node->text, choices[count]) == 0) {
            *(int *)work->field = (int)count;
            return true;
        }
        int added = snprintf(list + used, sizeof list - used, "%s%s", count > 0 ? ", " : "",
                             choices[count]);
        if (added > 0 && used + (size_t)added < sizeof list) used += (size_t)added;
    }
    describe(node, found, sizeof found);
    const char *meant =
        node->kind == NODE_SCALAR ? text_find_nearest(node->text, choices, count) : NULL;
    problem_add(work->reader->problems, TULLE_ERROR_PARSE, node->place,
                meant ? "%s: is %s, must be one of %s; did you mean '%s'?"
                      : "%s: is %s, must be one of %s",
                work->path, found, list, meant);
    return false;
}

/* "a list of 3 lengths". */
static bool refuse_list(const value_work *work) {
    const schema_key *key = work->key;
    char found[80], wanted[200], number[130];
    if (work->node->kind == NODE_LIST)
        snprintf(found, sizeof found, "a list of %zu", work->node->count);
    else
        describe(work->node, found, sizeof found);
    if (key->type == SCHEMA_VECTOR)
        describe_number(key, number, sizeof number);
    else
        snprintf(number, sizeof number, "a %s",
                 key->type == SCHEMA_NAMES ? "name" : "whole number");
    if (key->least_count == key->most_count)
        snprintf(wanted, sizeof wanted, "a list of %zu, each %s%s", key->most_count, number,
                 key->flags & SCHEMA_UNIFORM ? ", or one for all" : "");
    else
        snprintf(wanted, sizeof wanted, "a list of %zu to %zu, each %s", key->least_count,
                 key->most_count, number);
    return refuse_at(work, work->node, found, wanted);
}

static bool read_vector(const value_work *work) {
    schema_vector vector = {0};
    const scene_node *node = work->node;
    if (node->kind == NODE_SCALAR && work->key->flags & SCHEMA_UNIFORM) {
        if (!read_number(work, node, &vector.value[0])) return false;
        vector.value[1] = vector.value[2] = vector.value[0];
        vector.count = work->key->most_count;
    } else {
        if (node->kind != NODE_LIST || node->count < work->key->least_count ||
            node->count > work->key->most_count)
            return refuse_list(work);
        for (const scene_node *item = node->first; item; item = item->next)
            if (!read_number(work, item, &vector.value[vector.count++])) return false;
    }
    *(schema_vector *)work->field = vector;
    return true;
}

static bool read_integers(const value_work *work) {
    schema_integers integers = {0};
    const scene_node *node = work->node;
    if (node->kind != NODE_LIST || node->count < work->key->least_count ||
        node->count > work->key->most_count)
        return refuse_list(work);
    for (const scene_node *item = node->first; item; item = item->next)
        if (!read_integer(work, item, &integers.value[integers.count++])) return false;
    *(schema_integers *)work->field = integers;
    return true;
}

static bool read_names(const value_work *work) {
    static const char wanted[] = "the name of a cloth or obstacle";
    schema_names names = {0};
    char found[80];
    const scene_node *node = work->node;
    if (node->kind != NODE_LIST || node->count < work->key->least_count ||
        node->count > work->key->most_count)
        return refuse_list(work);
    for (const scene_node *item = node->first; item; item = item->next) {
        describe(item, found, sizeof found);
        if (item->kind != NODE_SCALAR || !is_name(item->text))
            return refuse_at(work, item, found, wanted);
        names.places[names.count] = item->place;
        names.value[names.count++] = item->text;
    }
    *(schema_names *)work->field = names;
    return true;
}

/* "7" or "3-9". */
static bool read_index_range(const char *text, unsigned long long range[2]) {
    char first[24];
    const char *dash = strchr(text, '-');
    if (!dash) {
        if (!integer_read(text, &range[0])) return false;
        range[1] = range[0];
    } else {
        size_t length = (size_t)(dash - text);
        if (length >= sizeof first) return false;
        memcpy(first, text, length);
        first[length] = '\0';
        if (!integer_read(first, &range[0]) || !integer_read(dash + 1, &range[1])) return false;
    }
    return range[0] <= range[1];
}

enum { index_limit = 20000000 }; /* pinned vertices that one list may name */

static bool read_indices(const value_work *work) {
    const scene_node *node = work->node;
    static const char wanted[] = "a list of vertex numbers from 0 or ranges as 3-9";
    char found[80];
    describe(node, found, sizeof found);
    if (node->kind != NODE_LIST || node->count == 0) return refuse_at(work, node, found, wanted);
    schema_indices indices = {0};
    unsigned long long range[2];
    for (const scene_node *item = node->first; item; item = item->next) {
        describe(item, found, sizeof found);
        bool is_read = item->kind == NODE_SCALAR && read_index_range(item->text, range) &&
                       range[1] < index_limit;
        if (!is_read) return refuse_at(work, item, found, wanted);
        indices.count += (size_t)(range[1] - range[0] + 1);
        if (indices.count > index_limit)
            return refuse_at(work, item, found, "within 20000000 indices in all");
    }
    indices.value = ARENA_NEW(work->reader->storage, uint32_t, indices.count);
    if (!indices.value) {
        problem_add_memory(work->reader->problems, work->reader->file);
        return false;
    }
    size_t count = 0;
    for (const scene_node *item = node->first; item; item = item->next) {
        if (!read_index_range(item->text, range)) return false;
        for (; range[0] <= range[1]; range[0]++) indices.value[count++] = (uint32_t)range[0];
    }
    *(schema_indices *)work->field = indices;
    return true;
}

/* Turns about fixed x, then y, then z. */
static void quaternion_from_angles(const double angles[3], double q[4]) {
    double cx = cos(angles[0] / 2), sx = sin(angles[0] / 2);
    double cy = cos(angles[1] / 2), sy = sin(angles[1] / 2);
    double cz = cos(angles[2] / 2), sz = sin(angles[2] / 2);
    q[0] = cx * cy * cz + sx * sy * sz;
    q[1] = sx * cy * cz - cx * sy * sz;
    q[2] = cx * sy * cz + sx * cy * sz;
    q[3] = cx * cy * sz - sx * sy * cz;
}

static const schema_key angles_key = {.name = "rotate",
                                      .type = SCHEMA_VECTOR,
                                      .unit = UNIT_ANGLE,
                                      .minimum = -1000,
                                      .maximum = 1000,
                                      .least_count = 3,
                                      .most_count = 3};

typedef struct axis_angle {
    schema_head head;
    schema_vector axis;
    double angle;
} axis_angle;
static const schema_key axis_angle_keys[] = {
    {.name = "axis",
     .meaning = "direction to turn about",
     .type = SCHEMA_VECTOR,
     .least_count = 3,
     .most_count = 3,
     .minimum = -1e6,
     .maximum = 1e6,
     .flags = SCHEMA_REQUIRED,
     .offset = offsetof(axis_angle, axis)},
    {.name = "angle",
     .meaning = "how far to turn",
     .type = SCHEMA_NUMBER,
     .unit = UNIT_ANGLE,
     .minimum = -1000,
     .maximum = 1000,
     .flags = SCHEMA_REQUIRED,
     .offset = offsetof(axis_angle, angle)},
};
static const schema_map axis_angle_map = {
    .keys = axis_angle_keys, .key_count = 2, .size = sizeof(axis_angle)};

static bool read_rotation(const value_work *work) {
    schema_rotation *rotation = work->field;
    double *q = rotation->quaternion;
    if (work->node->kind == NODE_LIST) {
        schema_vector angles;
        value_work inner = *work;
        inner.key = &angles_key;
        inner.field = &angles;
        if (!read_vector(&inner)) return false;
        const double *const a = angles.value;
        quaternion_from_angles(a, q);
        memcpy(rotation->given, a, 3 * sizeof(double));
        rotation->has_axis = false;
        rotation->is_about_one_axis = (a[0] != 0.0) + (a[1] != 0.0) + (a[2] != 0.0) <= 1;
        double const sine = sqrt(q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
        double const sign = q[0] < 0.0 ? -1.0 : 1.0;
        double const factor = sine > 0.0 ? 2.0 * sign * atan2(sine, sign * q[0]) / sine : 0.0;
        for (int k = 0; k < 3; k++)
            rotation->vector[k] = rotation->is_about_one_axis ? a[k] : factor * q[k + 1];
        return true;
    }
    if (work->node->kind != NODE_MAP) {
        char found[80];
        describe(work->node, found, sizeof found);
        return refuse_at(work, work->node, found,
                         "three angles about x, y, z, as in [0, 90 deg, 0], or {axis: [0, 0, 1], "
                         "angle: 30 deg}");
    }
    axis_angle turn = {.head = {.place = work->node->place, .path = work->path}};
    if (!schema_read(work->reader, &axis_angle_map, work->node, &turn)) return false;
    const double *a = turn.axis.value;
    double length = sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
    if (length < 1e-9) /* shorter has no direction that could be meant */
        return refuse_at(work, tree_find(work->node, "axis"), "zero", "a direction");
    q[0] = cos(turn.angle / 2);
    for (int k = 0; k < 3; k++) q[k + 1] = sin(turn.angle / 2) * a[k] / length;
    for (int k = 0; k < 3; k++) rotation->vector[k] = turn.angle * a[k] / length;
    rotation->is_about_one_axis = true;
    memcpy(rotation->given, a, 3 * sizeof(double));
    rotation->given[3] = turn.angle;
    rotation->has_axis = true;
    return true;
}

bool schema_read_value(const value_work *work) {
    switch (work->key->type) {
    case SCHEMA_NUMBER: return read_number(work, work->node, work->field);
    case SCHEMA_INTEGER: return read_integer(work, work->node, work->field);
    case SCHEMA_BOOL: return read_bool(work);
    case SCHEMA_TEXT:
    case SCHEMA_NAME:
    case SCHEMA_PATH: return read_text(work);
    case SCHEMA_CHOICE: return read_choice(work);
    case SCHEMA_VECTOR: return read_vector(work);
    case SCHEMA_INTEGERS: return read_integers(work);
    case SCHEMA_NAMES: return read_names(work);
    case SCHEMA_INDICES: return read_indices(work);
    case SCHEMA_ROTATION: return read_rotation(work);
    case SCHEMA_MAP:
    case SCHEMA_LIST: break;
    }
    return false;
}
