/* The canonical text of a scene leads to the same scene: random scenes that give every key of the
 * table a random value, in random units and spellings, read, written and read again. Every double
 * comes back to the bit, every text to the byte. */
#include "scene/keys.h"

#include "base/hash.h"
#include "support/comma_locale.h"

#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { SCENE_COUNT = 400, TEXT_SIZE = 1 << 18, KEY_COUNT_MAX = 512, ITEMS_MAX = 3 };

/* ---- random text of a map ---- */

typedef struct scene_writer {
    uint64_t seed;
    char *text; /* TEXT_SIZE bytes */
    size_t count;
} scene_writer;

/* Keys that some scene has given a value. */
static const schema_key *seen_keys[KEY_COUNT_MAX];
static size_t seen_count;

static void note_key(const schema_key *key) {
    for (size_t i = 0; i < seen_count; i++)
        if (seen_keys[i] == key) return;
    assert_true(seen_count < KEY_COUNT_MAX);
    seen_keys[seen_count++] = key;
}

static void put(scene_writer *writer, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
static void put(scene_writer *writer, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    int const length =
        vsnprintf(writer->text + writer->count, TEXT_SIZE - writer->count, format, arguments);
    va_end(arguments);
    assert_true(length >= 0 && writer->count + (size_t)length < TEXT_SIZE);
    writer->count += (size_t)length;
}

static size_t below(scene_writer *writer, size_t count) {
    return (size_t)(random_next(&writer->seed) % count);
}

static bool is_chosen(scene_writer *writer, double share) {
    return random_uniform(&writer->seed) < share;
}

/* Within the range of the key: of any size where the range has several. */
static double choose_number(scene_writer *writer, const schema_key *key) {
    bool const has_range = key->minimum != 0 || key->maximum != 0;
    double const low = has_range ? fmax(key->minimum, -1e6) : -1e6;
    double const high = has_range ? fmin(key->maximum, 1e6) : 1e6;
    double const share = 0.999 * random_uniform(&writer->seed) + 0.0005;
    double value = low + (high - low) * share;
    if (is_chosen(writer, 0.5)) {
        double const smaller = value * pow(10.0, -6.0 * random_uniform(&writer->seed));
        if (smaller > low && smaller < high) value = smaller;
    }
    return value;
}

/* "0.25", "2.5 cm", "1/3 turn". */
static void put_number(scene_writer *writer, const schema_key *key) {
    if (key->word && is_chosen(writer, 0.2)) {
        put(writer, "%s", key->word);
        return;
    }
    double const value = choose_number(writer, key);
    char names[100], *name = NULL;
    unit_list_names(key->unit, names, sizeof names);
    size_t left = below(writer, 8);
    for (char *unit = strtok(names, ","); unit && left-- > 0; unit = strtok(NULL, ",")) name = unit;
    double factor = 1.0;
    if (name) {
        char one[120];
        snprintf(one, sizeof one, "1 %s", name + (*name == ' '));
        assert_int_equal(quantity_read(one, key->unit, &factor), QUANTITY_READ);
    }
    int const digits = 1 + (int)below(writer, 17);
    char number[64];
    if (is_chosen(writer, 0.2))
        snprintf(number, sizeof number, "%.17g/%d", 7.0 * (value / factor), 7);
    else
        snprintf(number, sizeof number, "%.*g", digits, value / factor);
    for (char *c = number; *c; c++)
        if (*c == ',') *c = '.';
    double read;
    /* Fewer digits, or a rounded factor, may lie outside of the range. */
    char text[200];
    snprintf(text, sizeof text, "%s%s%s", number, name ? " " : "",
             name ? name + (*name == ' ') : "");
    assert_int_equal(quantity_read(text, key->unit, &read), QUANTITY_READ);
    bool const is_outside =
        (key->minimum != 0 || key->maximum != 0) && (read <= key->minimum || read > key->maximum);
    if (!is_outside) {
        put(writer, "%s", text);
        return;
    }
    snprintf(number, sizeof number, "%.17g", value);
    for (char *c = number; *c; c++)
        if (*c == ',') *c = '.';
    put(writer, "%s", number);
}

static void put_integer(scene_writer *writer, const schema_key *key) {
    if (key->word && is_chosen(writer, 0.2)) {
        put(writer, "%s", key->word);
        return;
    }
    uint64_t const most = key->maximum > 0 ? (uint64_t)key->maximum : UINT64_C(1) << 53;
    uint64_t const least = (uint64_t)key->minimum;
    put(writer, "%llu",
        (unsigned long long)(least + random_next(&writer->seed) % (most - least + 1)));
}

/* Of what YAML may take for something else: quotes, escapes, line breaks, colons, and characters
 * that it does not print. */
static void put_text(scene_writer *writer, bool is_path) {
    static const char *const pieces[] = {
        "a",       "B7",      " ",       ": ",      " #",      "'",       "\\\"", "\\\\",
        "\\n",     "\\t",     "\\r",     "\\x01",   "\\x7f",   "\\N",     "\\L",  "\\P",
        "\\u0080", "\\u009f", "\\u00a0", "\\ufeff", "\\ufffd", "\\ufffe", "é",    "\u2028",
        "漢",      "🧵",    "{",       "]",       "- ",      "&",       "*x",   "!",
        "%",       "@",       "`",       "null",    "~",       "true",    "1e5",  "\\e"};
    put(writer, "\"%s", is_path ? "x" : "");
    for (size_t i = below(writer, 12); i > 0; i--)
        put(writer, "%s", pieces[below(writer, sizeof pieces / sizeof pieces[0])]);
    put(writer, "\"");
}

static void put_name(scene_writer *writer) {
    static const char letters[] = "abcXYZ0123456789-_.";
    put(writer, "\"n");
    for (size_t i = below(writer, 20); i > 0; i--)
        put(writer, "%c", letters[below(writer, sizeof letters - 1)]);
    put(writer, "\"");
}

static void put_components(scene_writer *writer, const schema_key *key) {
    if (key->flags & SCHEMA_UNIFORM && is_chosen(writer, 0.3)) {
        put_number(writer, key);
        return;
    }
    size_t const count = key->least_count + below(writer, key->most_count - key->least_count + 1);
    put(writer, "[");
    for (size_t i = 0; i < count; i++) {
        put(writer, "%s", i > 0 ? ", " : "");
        if (key->type == SCHEMA_VECTOR) put_number(writer, key);
        if (key->type == SCHEMA_INTEGERS) put_integer(writer, key);
        if (key->type == SCHEMA_NAMES) put_name(writer);
    }
    put(writer, "]");
}

static void put_indices(scene_writer *writer) {
    put(writer, "[%zu", below(writer, 1000));
    for (size_t i = below(writer, 6); i > 0; i--) {
        size_t const first = below(writer, 1000);
        put(writer, is_chosen(writer, 0.5) ? ", %zu-%zu" : ", %zu", first,
            first + below(writer, 9));
    }
    put(writer, "]");
}

static void put_rotation(scene_writer *writer) {
    static const schema_key angle = {.unit = UNIT_ANGLE, .minimum = -999, .maximum = 999};
    static const schema_key axis = {.minimum = -1, .maximum = 1};
    bool const has_axis = is_chosen(writer, 0.5);
    put(writer, has_axis ? "{axis: [" : "[");
    for (int i = 0; i < 3; i++) {
        put(writer, "%s", i > 0 ? ", " : "");
        put_number(writer, has_axis ? &axis : &angle);
    }
    put(writer, "]");
    if (!has_axis) return;
    put(writer, ", angle: ");
    put_number(writer, &angle);
    put(writer, "}");
}

static void put_map(scene_writer *writer, const schema_map *map);

static void put_value(scene_writer *writer, const schema_key *key) {
    note_key(key);
    switch (key->type) {
    case SCHEMA_NUMBER: put_number(writer, key); break;
    case SCHEMA_INTEGER: put_integer(writer, key); break;
    case SCHEMA_BOOL: put(writer, is_chosen(writer, 0.5) ? "true" : "false"); break;
    case SCHEMA_TEXT: put_text(writer, false); break;
    case SCHEMA_PATH: put_text(writer, true); break;
    case SCHEMA_NAME: put_name(writer); break;
    case SCHEMA_CHOICE: {
        size_t count = 0;
        while (key->choices[count]) count++;
        put(writer, "%s", key->choices[below(writer, count)]);
        break;
    }
    case SCHEMA_VECTOR:
    case SCHEMA_INTEGERS:
    case SCHEMA_NAMES: put_components(writer, key); break;
    case SCHEMA_INDICES: put_indices(writer); break;
    case SCHEMA_ROTATION: put_rotation(writer); break;
    case SCHEMA_MAP: put_map(writer, key->map); break;
    case SCHEMA_LIST: {
        size_t const least = (size_t)key->minimum;
        size_t const count = least + below(writer, ITEMS_MAX);
        put(writer, "[");
        for (size_t i = 0; i < count; i++) {
            put(writer, "%s", i > 0 ? ", " : "");
            put_map(writer, key->map);
        }
        put(writer, "]");
        break;
    }
    }
}

/* One of the keys with a flag, or none where none is needed; key_count: none. */
static size_t choose_alternative(scene_writer *writer, const schema_map *map, unsigned flag,
                                 bool is_needed) {
    size_t places[64], count = 0;
    for (size_t k = 0; k < map->key_count; k++)
        if (map->keys[k].flags & flag) places[count++] = k;
    if (count == 0 || (!is_needed && is_chosen(writer, 0.2))) return map->key_count;
    return places[below(writer, count)];
}

/* In the order of the table, each key that may be there with some chance. */
static void put_map(scene_writer *writer, const schema_map *map) {
    if (map->takes_flag && is_chosen(writer, 0.1)) {
        put(writer, "true");
        return;
    }
    enum { BOTH = SCHEMA_ALTERNATIVE | SCHEMA_SECOND_ALTERNATIVE };
    size_t const chosen =
        choose_alternative(writer, map, SCHEMA_ALTERNATIVE, map->needs_alternative);
    size_t const second =
        choose_alternative(writer, map, SCHEMA_SECOND_ALTERNATIVE, map->needs_second_alternative);
    int selected = -1; /* no value of the selector */
    bool is_first = true;
    int put_choices[64]; /* by key: the choice, 0 where it is none; -1: not there */
    for (size_t k = 0; k < map->key_count; k++) put_choices[k] = -1;
    put(writer, "{");
    for (int is_rest = 0; is_rest < 2; is_rest++) {
        for (size_t k = 0; k < map->key_count; k++) {
            const schema_key *const key = &map->keys[k];
            bool const is_selector = map->selector && strcmp(key->name, map->selector) == 0;
            bool const may_be = !(key->flags & BOTH) || k == chosen || k == second;
            bool const must_be = key->flags & SCHEMA_REQUIRED || k == chosen || k == second;
            bool const applies =
                !map->selector || !key->applies || (selected >= 0 && key->applies >> selected & 1);
            if (is_selector == (is_rest == 1) || !may_be || !applies) continue;
            if (!must_be && is_chosen(writer, 0.4)) continue;
            if (key->beside) { /* stands behind it in the table */
                size_t const other = schema_find_key(map, key->beside);
                const schema_key *const beside = &map->keys[other];
                assert_true(other < k);
                bool const is_known =
                    !beside->applies || (selected >= 0 && beside->applies >> selected & 1);
                bool const is_of_choice = !key->beside_choices || put_choices[other] < 0 ||
                                          key->beside_choices >> put_choices[other] & 1;
                if (is_known && (put_choices[other] < 0 || !is_of_choice)) continue;
            }
            put(writer, "%s%s: ", is_first ? "" : ", ", key->name);
            is_first = false;
            size_t const begin = writer->count;
            put_value(writer, key);
            put_choices[k] = 0;
            for (int i = 0; key->type == SCHEMA_CHOICE && key->choices[i]; i++)
                if (strcmp(writer->text + begin, key->choices[i]) == 0) put_choices[k] = i;
            if (is_selector) selected = put_choices[k];
        }
    }
    put(writer, "}");
}

/* ---- reading, writing and comparing ---- */

typedef struct read_scene {
    memory heap;
    arena storage;
    tulle_scene_problems *problems;
    scene_keys keys;
    text_buffer written;
} read_scene;

static void read_and_write(read_scene *scene, const char *text, size_t length) {
    *scene = (read_scene){.heap = memory_default()};
    scene->storage = arena_make(&scene->heap);
    scene->problems = calloc(1, sizeof *scene->problems);
    assert_non_null(scene->problems);
    tree_source const source = {
        .name = "s.yaml", .needs = "", .has_lines = true, .text = text, .length = length};
    const scene_node *const root = tree_read(&source, &scene->storage, scene->problems);
    schema_reader const reader = {&scene->storage, scene->problems, "s.yaml"};
    scene->keys.head = (schema_head){.node = root, .place = {"s.yaml", 1, 1}, .path = ""};
    if (!root || !schema_read(&reader, &scene_map, root, &scene->keys)) {
        scene_print_problems(scene->problems, stderr);
        fail_msg("a scene is refused:\n%s", text);
    }
    scene->written = (text_buffer){.storage = &scene->storage};
    schema_write(&scene_map, &scene->keys, 0, &scene->written);
    assert_false(scene->written.is_failed);
}

static void release_scene(read_scene *scene) {
    arena_destroy(&scene->storage);
    free(scene->problems);
}

static void expect_same_map(const schema_map *map, const void *first, const void *second);

static void expect_same_value(const schema_key *key, const void *first, const void *second) {
    const schema_list *const list[2] = {first, second};
    const schema_names *const names[2] = {first, second};
    const schema_indices *const indices[2] = {first, second};
    switch (key->type) {
    case SCHEMA_NUMBER: assert_memory_equal(first, second, sizeof(double)); break;
    case SCHEMA_INTEGER: assert_memory_equal(first, second, sizeof(uint64_t)); break;
    case SCHEMA_BOOL: assert_int_equal(*(const bool *)first, *(const bool *)second); break;
    case SCHEMA_TEXT:
    case SCHEMA_NAME:
    case SCHEMA_PATH:
        assert_string_equal(*(const char *const *)first, *(const char *const *)second);
        break;
    case SCHEMA_CHOICE: assert_int_equal(*(const int *)first, *(const int *)second); break;
    case SCHEMA_VECTOR: assert_memory_equal(first, second, sizeof(schema_vector)); break;
    case SCHEMA_INTEGERS: assert_memory_equal(first, second, sizeof(schema_integers)); break;
    case SCHEMA_NAMES:
        assert_int_equal(names[0]->count, names[1]->count);
        for (size_t i = 0; i < names[0]->count; i++)
            assert_string_equal(names[0]->value[i], names[1]->value[i]);
        break;
    case SCHEMA_INDICES:
        assert_int_equal(indices[0]->count, indices[1]->count);
        assert_memory_equal(indices[0]->value, indices[1]->value,
                            indices[0]->count * sizeof(uint32_t));
        break;
    case SCHEMA_ROTATION:
        assert_memory_equal(((const schema_rotation *)first)->quaternion,
                            ((const schema_rotation *)second)->quaternion, 4 * sizeof(double));
        break;
    case SCHEMA_MAP: expect_same_map(key->map, first, second); break;
    case SCHEMA_LIST:
        assert_int_equal(list[0]->count, list[1]->count);
        for (size_t i = 0; i < list[0]->count; i++)
            expect_same_map(key->map, (const char *)list[0]->items + i * key->map->size,
                            (const char *)list[1]->items + i * key->map->size);
        break;
    }
}

/* What has no default is given in both or in neither: some of it says by being there what is meant.
 */
static void expect_same_map(const schema_map *map, const void *first, const void *second) {
    const schema_head *const heads[2] = {first, second};
    for (size_t k = 0; k < map->key_count; k++) {
        const schema_key *const key = &map->keys[k];
        bool const applies = schema_applies(map, key, first);
        assert_int_equal(applies, schema_applies(map, key, second));
        bool const has_default =
            key->fallback || (key->type == SCHEMA_MAP && !(key->flags & SCHEMA_OPTIONAL));
        bool const is_given = heads[0]->given >> k & 1;
        if (!has_default) assert_int_equal(is_given, heads[1]->given >> k & 1);
        if (!applies || (!has_default && !is_given)) continue;
        expect_same_value(key, (const char *)first + key->offset,
                          (const char *)second + key->offset);
    }
}

/* ---- the property ---- */

static void expect_round_trips(uint64_t seed, int count) {
    scene_writer writer = {.text = malloc(TEXT_SIZE)};
    assert_non_null(writer.text);
    for (int i = 0; i < count; i++) {
        writer.seed = hash_mix(seed + (uint64_t)i);
        writer.count = 0;
        put_map(&writer, &scene_map);
        read_scene first, second;
        read_and_write(&first, writer.text, writer.count);
        read_and_write(&second, first.written.data, first.written.count);
        expect_same_map(&scene_map, &first.keys, &second.keys);
        assert_string_equal(first.written.data, second.written.data);
        release_scene(&first);
        release_scene(&second);
    }
    free(writer.text);
}

static size_t count_keys(const schema_map *map, const schema_map *counted[], size_t *map_count) {
    for (size_t i = 0; i < *map_count; i++)
        if (counted[i] == map) return 0;
    assert_true(*map_count < 64);
    counted[(*map_count)++] = map;
    size_t count = map->key_count;
    for (size_t k = 0; k < map->key_count; k++)
        if (map->keys[k].map) count += count_keys(map->keys[k].map, counted, map_count);
    return count;
}

static void test_every_key_comes_back(void **state) {
    (void)state;
    const schema_map *counted[64];
    size_t map_count = 0;
    expect_round_trips(1, getenv("TULLE_TEST_LONG") ? 25 * SCENE_COUNT : SCENE_COUNT);
    assert_int_equal(seen_count, count_keys(&scene_map, counted, &map_count));
    assert_true(seen_count > 100);
}

static void test_every_key_comes_back_with_a_decimal_comma(void **state) {
    (void)state;
    use_decimal_comma();
    expect_round_trips(1000000, SCENE_COUNT / 4);
    use_decimal_point();
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_key_comes_back),
        cmocka_unit_test(test_every_key_comes_back_with_a_decimal_comma),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
