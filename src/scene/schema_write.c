/* scene/schema_write.c - a filled struct as canonical YAML: every key in the table's order,
 * defaults included, SI units. Numbers have the fewest digits that read back to the same double,
 * in every locale, so that the text decides the scene. */
#include "scene/schema.h"

#include "base/text.h"
#include "io/text/number.h"

#include <math.h>
#include <stdarg.h>
#include <string.h>

void text_append(text_buffer *buffer, const char *format, ...) {
    char piece[512];
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(piece, sizeof piece, format, arguments);
    va_end(arguments);
    if (length < 0 || buffer->is_failed) return;
    size_t added = (size_t)length < sizeof piece ? (size_t)length : sizeof piece - 1;
    if (buffer->count + added + 1 > buffer->capacity) {
        size_t capacity = 2 * (buffer->count + added + 1);
        char *data = ARENA_NEW(buffer->storage, char, capacity);
        if (!data) {
            buffer->is_failed = true;
            return;
        }
        if (buffer->count > 0) memcpy(data, buffer->data, buffer->count);
        buffer->data = data;
        buffer->capacity = capacity;
    }
    memcpy(buffer->data + buffer->count, piece, added + 1);
    buffer->count += added;
}

/* Whether YAML takes a character for a line break, or does not take it at all. */
static bool needs_escape(unsigned c) {
    return c < 0x20 || (c >= 0x7f && c < 0xa0) || c == 0x2028 || c == 0x2029 || c == 0xfeff ||
           c == 0xfffe || c == 0xffff;
}

/* In double quotes, with YAML's escapes. */
static void write_text(const char *text, text_buffer *buffer) {
    text_append(buffer, "\"");
    size_t length = 1;
    for (; *text; text += length) {
        unsigned const c = text_take_character(text, &length);
        if (c == '"' || c == '\\')
            text_append(buffer, "\\%c", (int)c);
        else if (needs_escape(c))
            text_append(buffer, "\\u%04x", c);
        else
            text_append(buffer, "%.*s", (int)length, text);
    }
    text_append(buffer, "\"");
}

static void write_double(double value, text_buffer *buffer) {
    char text[NUMBER_TEXT_SIZE];
    number_format_double(value, text);
    text_append(buffer, "%s", text);
}

static void write_number(const schema_key *key, double value, text_buffer *buffer) {
    bool is_word = key->word && (value == key->word_value || !isfinite(value));
    if (is_word)
        text_append(buffer, "%s", key->word);
    else
        write_double(value, buffer);
}

static void write_components(const schema_key *key, const void *field, text_buffer *buffer) {
    text_append(buffer, "[");
    if (key->type == SCHEMA_VECTOR) {
        const schema_vector *vector = field;
        for (size_t i = 0; i < vector->count; i++) {
            text_append(buffer, "%s", i > 0 ? ", " : "");
            write_number(key, vector->value[i], buffer);
        }
    } else if (key->type == SCHEMA_INTEGERS) {
        const schema_integers *integers = field;
        for (size_t i = 0; i < integers->count; i++)
            text_append(buffer, "%s%llu", i > 0 ? ", " : "",
                        (unsigned long long)integers->value[i]);
    } else if (key->type == SCHEMA_NAMES) {
        const schema_names *names = field;
        for (size_t i = 0; i < names->count; i++) {
            text_append(buffer, "%s", i > 0 ? ", " : "");
            write_text(names->value[i], buffer);
        }
    } else {
        const schema_indices *indices = field;
        for (size_t i = 0; i < indices->count; i++) {
            size_t first = i;
            while (i + 1 < indices->count && indices->value[i + 1] == indices->value[i] + 1) i++;
            text_append(buffer, "%s%u", first > 0 ? ", " : "", (unsigned)indices->value[first]);
            if (i > first) text_append(buffer, "-%u", (unsigned)indices->value[i]);
        }
    }
    text_append(buffer, "]");
}

static void write_rotation(const schema_rotation *rotation, text_buffer *buffer) {
    text_append(buffer, rotation->has_axis ? "{axis: [" : "[");
    for (int i = 0; i < 3; i++) {
        text_append(buffer, "%s", i > 0 ? ", " : "");
        write_double(rotation->given[i], buffer);
    }
    text_append(buffer, "]");
    if (!rotation->has_axis) return;
    text_append(buffer, ", angle: ");
    write_double(rotation->given[3], buffer);
    text_append(buffer, "}");
}

static void write_value(const schema_key *key, const void *field, text_buffer *buffer) {
    switch (key->type) {
    case SCHEMA_NUMBER: write_number(key, *(const double *)field, buffer); break;
    case SCHEMA_INTEGER:
        if (key->word && *(const uint64_t *)field == (uint64_t)key->word_value)
            text_append(buffer, "%s", key->word);
        else
            text_append(buffer, "%llu", (unsigned long long)*(const uint64_t *)field);
        break;
    case SCHEMA_BOOL: text_append(buffer, *(const bool *)field ? "true" : "false"); break;
    case SCHEMA_TEXT:
    case SCHEMA_NAME:
    case SCHEMA_PATH: write_text(*(const char *const *)field, buffer); break;
    case SCHEMA_CHOICE: text_append(buffer, "%s", key->choices[*(const int *)field]); break;
    case SCHEMA_VECTOR:
    case SCHEMA_INTEGERS:
    case SCHEMA_NAMES:
    case SCHEMA_INDICES: write_components(key, field, buffer); break;
    case SCHEMA_ROTATION: write_rotation(field, buffer); break;
    case SCHEMA_MAP:
    case SCHEMA_LIST: break;
    }
}

/* A map below its heading, or {} behind it where no key is written. */
static void write_map(const schema_map *map, const void *target, int indent, text_buffer *buffer) {
    text_append(buffer, "\n");
    size_t const before = buffer->count;
    schema_write(map, target, indent, buffer);
    if (buffer->count > before || buffer->is_failed) return;
    buffer->count--;
    text_append(buffer, " {}\n");
}

static void write_list(const schema_key *key, const schema_list *list, int indent,
                       text_buffer *buffer) {
    text_append(buffer, "%*s%s:%s\n", indent, "", key->name, list->count > 0 ? "" : " []");
    for (size_t i = 0; i < list->count; i++) {
        text_append(buffer, "%*s-", indent + 2, "");
        write_map(key->map, (const char *)list->items + i * key->map->size, indent + 4, buffer);
    }
}

void schema_write(const schema_map *map, const void *target, int indent, text_buffer *buffer) {
    const schema_head *head = target;
    for (size_t k = 0; k < map->key_count; k++) {
        const schema_key *key = &map->keys[k];
        const void *field = (const char *)target + key->offset;
        bool is_given = head->given >> k & 1;
        bool is_default_map = key->type == SCHEMA_MAP && !(key->flags & SCHEMA_OPTIONAL);
        bool has_value = is_given || key->fallback || is_default_map;
        if (!has_value || !schema_applies(map, key, target) || key->flags & buffer->left_out)
            continue;
        if (key->type == SCHEMA_MAP) {
            text_append(buffer, "%*s%s:", indent, "", key->name);
            write_map(key->map, field, indent + 2, buffer);
        } else if (key->type == SCHEMA_LIST) {
            write_list(key, field, indent, buffer);
        } else {
            text_append(buffer, "%*s%s: ", indent, "", key->name);
            write_value(key, field, buffer);
            text_append(buffer, "\n");
        }
    }
}
