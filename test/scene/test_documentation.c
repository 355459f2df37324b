/* Prints docs/guide/scene.md from the table of keys, the units, the shapes and the material
 * presets, and compares it with the file. With TULLE_UPDATE_DOCS=1 this program writes the file. */
#define _POSIX_C_SOURCE 200809L
#include "scene/keys.h"

#include "tulle/shapes.h"
#include "tulle/world.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { map_limit = 40, place_limit = 160 };

/* Maps in the order in which they are met, each once, with all places where it may stand. */
typedef struct map_entry {
    const schema_map *map;
    char places[place_limit * 4];
} map_entry;
typedef struct map_list {
    map_entry entries[map_limit];
    size_t count;
} map_list;

static void add_map(map_list *list, const schema_map *map, const char *place) {
    for (size_t i = 0; i < list->count; i++) {
        if (list->entries[i].map != map) continue;
        size_t used = strlen(list->entries[i].places);
        snprintf(list->entries[i].places + used, sizeof list->entries[i].places - used, ", `%s`",
                 place);
        return;
    }
    if (list->count == map_limit) return;
    map_entry *entry = &list->entries[list->count++];
    entry->map = map;
    snprintf(entry->places, sizeof entry->places, "`%s`", place);
    for (size_t k = 0; k < map->key_count; k++) {
        const schema_key *key = &map->keys[k];
        if (key->type != SCHEMA_MAP && key->type != SCHEMA_LIST) continue;
        char inner[place_limit];
        snprintf(inner, sizeof inner, "%.120s%s%.30s%s", place, place[0] ? "." : "", key->name,
                 key->type == SCHEMA_LIST ? "[]" : "");
        add_map(list, key->map, inner);
    }
}

/* A link to the section of this title: its anchor is the title in small letters, with "-" for each
 * blank. */
static void print_link(const char *title, FILE *stream) {
    fprintf(stream, "[%s](#", title);
    for (const char *c = title; *c; c++)
        fputc(*c == ' ' ? '-' : *c >= 'A' && *c <= 'Z' ? *c - 'A' + 'a' : *c, stream);
    fputc(')', stream);
}

/* What a dimension is called in the documentation. */
static const char *name_dimension(unit_dimension dimension) {
    static const char *const names[UNIT_DIMENSION_COUNT] = {"number",
                                                            "length",
                                                            "time",
                                                            "angle",
                                                            "velocity",
                                                            "acceleration",
                                                            "area density",
                                                            "stretch stiffness",
                                                            "bending",
                                                            "force per length",
                                                            "moment per width",
                                                            "rate",
                                                            "drag",
                                                            "mass",
                                                            "density",
                                                            "angular velocity",
                                                            "force",
                                                            "spring stiffness"};
    return names[dimension];
}

static void print_type(const schema_key *key, FILE *stream) {
    switch (key->type) {
    case SCHEMA_NUMBER: fprintf(stream, "%s", name_dimension(key->unit)); break;
    case SCHEMA_INTEGER: fprintf(stream, "whole number"); break;
    case SCHEMA_BOOL: fprintf(stream, "true or false"); break;
    case SCHEMA_TEXT: fprintf(stream, "text"); break;
    case SCHEMA_NAME: fprintf(stream, "name"); break;
    case SCHEMA_PATH: fprintf(stream, "path"); break;
    case SCHEMA_CHOICE: break; /* print_range lists the words */
    case SCHEMA_ROTATION: fprintf(stream, "turn"); break;
    case SCHEMA_NAMES: fprintf(stream, "list of %zu names", key->most_count); break;
    case SCHEMA_INDICES: fprintf(stream, "list of whole numbers and ranges"); break;
    case SCHEMA_MAP:
    case SCHEMA_LIST:
        fputs(key->map->takes_flag       ? "`true`, `false` or a map, see "
              : key->type == SCHEMA_LIST ? "list of maps, see "
                                         : "map, see ",
              stream);
        print_link(key->map->title, stream);
        break;
    case SCHEMA_VECTOR:
    case SCHEMA_INTEGERS:
        fprintf(stream, "list of %zu", key->least_count);
        if (key->most_count > key->least_count) fprintf(stream, " to %zu", key->most_count);
        fprintf(stream, "%s%s", key->type == SCHEMA_INTEGERS ? " whole numbers" : ", each ",
                key->type == SCHEMA_INTEGERS ? "" : name_dimension(key->unit));
        break;
    }
}

static void print_default(const schema_key *key, FILE *stream) {
    if (key->fallback && key->fallback[0])
        fprintf(stream, "; default `%s`", key->fallback);
    else if (key->derived)
        fprintf(stream, "; default: %s", key->derived);
    else if (key->flags & SCHEMA_REQUIRED)
        fputs("; required", stream);
}

/* The range, but for a bound of a million, which the introduction names. */
static void print_range(const schema_key *key, FILE *stream) {
    bool const is_limited = key->minimum != 0 || key->maximum != 0;
    bool const is_above = key->flags & SCHEMA_ABOVE_MINIMUM, is_list = key->type == SCHEMA_LIST;
    bool const has_low = key->minimum != -1e6, has_high = key->maximum != 1e6;
    for (size_t i = 0; key->choices && key->choices[i]; i++)
        fprintf(stream, "%s`%s`", i > 0 ? ", " : "", key->choices[i]);
    if (is_limited && !key->choices && has_low && has_high)
        fprintf(stream, ", %s%.10g%s to %.16g%s", is_above ? "above " : "", key->minimum,
                is_above ? "," : "", key->maximum, is_list ? " entries" : "");
    else if (is_limited && !key->choices && has_low)
        fprintf(stream, ", %s %.10g", is_above ? "above" : "at least", key->minimum);
    if (key->flags & SCHEMA_NOT_ZERO) fputs(", not 0", stream);
    if (key->word) fprintf(stream, ", %s`%s`", is_limited ? "or " : "", key->word);
}

/* Prints a paragraph within 140 columns; further lines begin with `indent` blanks. Code between
 * backticks stays in one line. No line begins like an item of a list, such as "2014.". */
static void print_prose(const char *text, int indent, FILE *stream) {
    size_t column = 0;
    for (const char *word = text, *end = text; *word; word = end) {
        bool is_code = false;
        while (*end == ' ') end++;
        for (word = end; *end && (is_code || *end != ' '); end++) is_code ^= *end == '`';
        size_t const length = (size_t)(end - word), digits = strspn(word, "0123456789");
        bool const is_mark = strchr("-+*#>|", *word) || (digits > 0 && word[digits] == '.');
        bool const breaks = column > 0 && column + 1 + length > 140 && !is_mark;
        column = (breaks ? (size_t)indent : column + (column > 0)) + length;
        fprintf(stream, breaks ? "\n%*s" : "%*s", breaks ? indent : column > length, "");
        fwrite(word, 1, length, stream);
    }
    fputc('\n', stream);
}

/* Which keys with the flag go together. */
static void print_choice(const schema_map *map, unsigned flag, bool is_needed, FILE *stream) {
    const char *separator = is_needed ? "\nExactly one of " : "\nAt most one of ";
    bool has_any = false;
    for (size_t k = 0; k < map->key_count; k++) {
        if (!(map->keys[k].flags & flag)) continue;
        fprintf(stream, "%s`%s`", separator, map->keys[k].name);
        separator = ", ";
        has_any = true;
    }
    if (has_any) fprintf(stream, is_needed ? " is needed.\n" : " may be given.\n");
}

/* What else a key needs in its map. */
static void print_need(const schema_map *map, const schema_key *key, FILE *stream) {
    if (!key->beside) return;
    const schema_key *const other = &map->keys[schema_find_key(map, key->beside)];
    fprintf(stream,
            other->applies ? "; of shapes that may be `%s`, only with it" : "; only with `%s`",
            other->name);
    const char *separator = ": ";
    for (size_t c = 0; key->beside_choices && other->choices[c]; c++) {
        if (!(key->beside_choices >> c & 1)) continue;
        fprintf(stream, "%s`%s`", separator, other->choices[c]);
        separator = " or ";
    }
}

/* Whether its alternatives choose vertices. */
static bool has_choice(const schema_map *map) { return map->keys[0].map == &box_map; }

/* The keys that choose vertices, once for all maps that have them. */
static void print_choices(FILE *stream) {
    fprintf(stream, "\n## Selection\n\n");
    print_prose("Exactly one of these keys chooses vertices of a cloth. A pin and an attachment "
                "take the vertices. A region takes the triangles whose corners are all chosen, a "
                "crease the edges whose ends are both chosen; these two have no `nearest`. Points "
                "are in scene coordinates, where the cloth starts.",
                0, stream);
    fprintf(stream, "\n| key | chooses | value |\n|---|---|---|\n");
    for (size_t k = 0; k < pin_map.key_count; k++) {
        const schema_key *key = &pin_map.keys[k];
        if (!(key->flags & SCHEMA_ALTERNATIVE)) continue;
        fprintf(stream, "| `%s` | %s | ", key->name, key->meaning + strlen("pins "));
        print_type(key, stream);
        fputs(" |\n", stream);
    }
}

static void print_map(const map_entry *entry, FILE *stream) {
    const schema_map *map = entry->map;
    bool const is_selection =
        map == &box_map || map == &line_map || map == &sphere_map || map == &near_map;
    if (map == &box_map) print_choices(stream);
    fprintf(stream, "\n## %s\n\n", map->title);
    print_prose(map->meaning, 0, stream);
    fputc('\n', stream);
    if (entry->places[1] != '`' && !is_selection) fprintf(stream, "At %s.\n\n", entry->places);
    fprintf(stream, "| key | meaning | value |\n|---|---|---|\n");
    if (has_choice(map))
        fprintf(
            stream,
            "| a key of [Selection](#selection) | what it is about | exactly one; required |\n");
    for (size_t k = 0; k < map->key_count; k++) {
        const schema_key *key = &map->keys[k];
        const char *const unit = unit_si_name(key->unit);
        if (has_choice(map) && key->flags & SCHEMA_ALTERNATIVE) continue;
        fprintf(stream, "| `%s` | %s", key->name, key->meaning);
        print_need(map, key, stream);
        fputs(" | ", stream);
        print_type(key, stream);
        if (unit[0]) fprintf(stream, " [%s]", unit);
        print_range(key, stream);
        print_default(key, stream);
        fputs(" |\n", stream);
    }
    if (!has_choice(map)) print_choice(map, SCHEMA_ALTERNATIVE, map->needs_alternative, stream);
    print_choice(map, SCHEMA_SECOND_ALTERNATIVE, map->needs_second_alternative, stream);
}

static void print_units(FILE *stream) {
    fprintf(stream, "\n## Units\n\n| quantity | unit of plain numbers | units |\n|---|---|---|\n");
    for (int d = 0; d < UNIT_DIMENSION_COUNT; d++) {
        char names[100];
        unit_list_names((unit_dimension)d, names, sizeof names);
        fprintf(stream, "| %s | %s | %s |\n", name_dimension((unit_dimension)d),
                unit_si_name((unit_dimension)d), names);
    }
}

static void print_shapes(FILE *stream) {
    const schema_key *selector = &mesh_map.keys[schema_find_key(&mesh_map, "shape")];
    fprintf(stream, "\n## Shapes\n\n[Shapes](shapes.md) explains the keys of each.\n\n| "
                    "shape | for | keys |\n|---|---|---|\n");
    for (int shape = 0; selector->choices[shape]; shape++) {
        fprintf(stream, "| `%s` | %s |", selector->choices[shape],
                tulle_shape_is_cloth((tulle_shape)shape) ? "cloth" : "obstacles");
        for (size_t k = 0; k < mesh_map.key_count; k++) {
            const schema_key *key = &mesh_map.keys[k];
            if (!(key->applies >> shape & 1)) continue;
            fprintf(stream, " `%s`", key->name);
            if (strcmp(key->name, "size") == 0)
                fprintf(stream, " (%zu numbers)", shape_size_count(shape));
            if (strcmp(key->name, "resolution") == 0 && shape_resolution_count(shape) == 1)
                fprintf(stream, " (1 number)");
        }
        fprintf(stream, " |\n");
    }
}

/* A cell of the table of presets; bold, if its values were measured. */
static void print_values(const double *values, int count, bool is_measured, FILE *stream) {
    const char *const mark = is_measured ? "**" : "";
    fprintf(stream, " %s", mark);
    for (int i = 0; i < count; i++) fprintf(stream, "%s%g", i > 0 ? " / " : "", values[i]);
    fprintf(stream, "%s |", mark);
}

static void print_tension(const tulle_curve *curve, unsigned measured, FILE *stream) {
    const char *const mark = measured & TULLE_MEASURED_TENSION ? "**" : "";
    const char *const limit_mark = measured & TULLE_MEASURED_LIMIT ? "**" : "";
    fprintf(stream, " %s%g / %g%s / %s%g%s |", mark, curve->stiffness, curve->knee, mark,
            limit_mark, curve->limit, limit_mark);
}

static void print_preset(size_t index, const tulle_material *m, FILE *stream) {
    unsigned const measured = tulle_material_preset_measured(index);
    double const thickness = tulle_material_preset_thickness(index);
    double const bend[] = {m->bend_warp, m->bend_weft};
    double const hysteresis[] = {m->bend_hysteresis_warp, m->bend_hysteresis_weft,
                                 m->shear_hysteresis};
    const char *const shear_mark = measured & TULLE_MEASURED_SHEAR ? "**" : "";
    fprintf(stream, "| `%s` |", tulle_material_preset_name(index));
    print_values(&m->area_density, 1, measured & TULLE_MEASURED_AREA_DENSITY, stream);
    print_values(&thickness, 1, measured & TULLE_MEASURED_THICKNESS, stream);
    print_tension(&m->warp, measured, stream);
    print_tension(&m->weft, measured, stream);
    fprintf(stream, " %s%g%s / %g / %g |", shear_mark, m->shear.stiffness, shear_mark,
            m->shear.knee, m->shear.limit);
    print_values(bend, 2, measured & TULLE_MEASURED_BENDING, stream);
    print_values(hysteresis, 3, measured & TULLE_MEASURED_HYSTERESIS, stream);
    print_values(&m->friction, 1, measured & TULLE_MEASURED_FRICTION, stream);
    fprintf(stream, " %g | %g | %g | %g | %g |\n", m->poisson, m->bend_twist, m->stretch_damping,
            m->bend_damping, m->air_damping);
}

static void print_presets(FILE *stream) {
    fputs("\n## Material presets\n\n", stream);
    print_prose("Values in bold were measured, all others are estimates. Warp, "
                "weft and shear are stiffness / knee / limit, bend is warp / weft, hysteresis is "
                "bending along warp / along weft / shear. Thickness [m] is for information only; "
                "contact uses `cloth[].thickness`.",
                0, stream);
    fputs("\n| preset | area_density | thickness | warp | weft | shear | bend | hysteresis | "
          "friction | "
          "poisson | bend_twist | stretch_damping | bend_damping | air_damping |\n"
          "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
          stream);
    const char *name;
    for (size_t i = 0; (name = tulle_material_preset_name(i)); i++) {
        tulle_material m;
        if (tulle_material_preset(name, &m) == TULLE_OK) print_preset(i, &m, stream);
    }
    fprintf(stream, "\nWith `membrane: springs`:\n\n| preset | stretch | stiffening_strain | bend "
                    "|\n|---|---|---|---|\n");
    for (size_t i = 0; (name = tulle_material_preset_name(i)); i++) {
        tulle_material m;
        if (tulle_material_preset(name, &m) != TULLE_OK) continue;
        fprintf(stream, "| `%s` | %g | %g | %g |\n", name, m.springs.stretch_stiffness,
                m.springs.stiffening_strain, m.springs.bend_stiffness);
    }
    fputs(
        "\nWhere measured values come from; `tulle_material_preset_source` in C has the origin of "
        "all others, too:\n\n",
        stream);
    for (size_t i = 0; (name = tulle_material_preset_name(i)); i++) {
        if (tulle_material_preset_measured(i) == 0) continue;
        char text[2048];
        snprintf(text, sizeof text, "- `%s`: %s.", name, tulle_material_preset_source(i));
        print_prose(text, 2, stream);
    }
    fprintf(stream, "\n[Materials](materials.md) explains the values.\n");
}

/* clang-format off */
static const char introduction[] =
    "# Scene keys\n"
    "\n"
    "A scene is one YAML document. `tulle run` reads it. This page is printed from the table that reads scenes, so the two agree.\n"
    "\n"
    "- All values are in SI units. A number may carry a unit: `2 mm`, `30 deg`, `5 km/h`, `0.2 kg/m^2`, `1/90 s`; the [units](#units) are at the\n"
    "  end. Plain numbers are metres, seconds, radians and so on. z is up.\n"
    "- A turn is a list of angles about the fixed axes x, then y, then z, for example `[0, 90 deg, 0]`, or a map\n"
    "  `{axis: [0, 0, 1], angle: 30 deg}`.\n"
    "- Paths are relative to the scene file.\n"
    "- A key without effect is an error, unless it has its default value: `gust_length` without `gust_strength`, or a woven value with\n"
    "  `membrane: springs`. Overrides and material files may leave keys without effect.\n"
    "- The range stands behind the kind of a value. Where it names no upper bound, the absolute value is at most 1,000,000.\n"
    "- NaN, infinities, unknown and duplicate keys are errors. Anchors, aliases, tags and several documents are refused. A file has at most 4 MiB\n"
    "  and 200,000 values, nested at most 32 deep; a scene at most 20,000,000 vertices and 4,096 obstacles.\n"
    "- `--set PATH=VALUE` on the command line replaces or adds a value: `--set time.frames=10`, `--set 'cloth[0].mesh.resolution=[40, 40]'`. An\n"
    "  empty value removes a key. If keys exclude each other, the key of `--set` wins.\n"
    "\n"
    "```yaml\n"
    "time: {step: 1/90 s, duration: 2 s}\n"
    "cloth:\n"
    "  - mesh: {shape: rectangle, size: [1, 1], resolution: [50, 50]}\n"
    "    translate: [0, 0, 0.7]\n"
    "    material: {preset: cotton}\n"
    "obstacles:\n"
    "  - mesh: {shape: sphere, radius: 30 cm}\n"
    "    translate: [0, 0, 0.3]\n"
    "  - mesh: {shape: plane, size: [4, 4]}\n"
    "```\n";
/* clang-format on */

static void print_documentation(FILE *stream) {
    map_list list = {.count = 0};
    add_map(&list, &scene_map, "");
    fputs(introduction, stream);
    for (size_t i = 0; i < list.count; i++) print_map(&list.entries[i], stream);
    print_shapes(stream);
    print_presets(stream);
    print_units(stream);
}

static char *print_page(size_t *length) {
    char *page = NULL;
    FILE *stream = open_memstream(&page, length);
    assert_non_null(stream);
    print_documentation(stream);
    assert_int_equal(fclose(stream), 0);
    return page;
}

static void test_page_is_current(void **state) {
    (void)state;
    const char *source = getenv("TULLE_SOURCE_DIR");
    char path[1024];
    assert_true(snprintf(path, sizeof path, "%s/docs/guide/scene.md", source ? source : ".") > 0);
    size_t length = 0;
    char *page = print_page(&length);
    assert_true(length > 10000);
    if (getenv("TULLE_UPDATE_DOCS")) {
        FILE *file = fopen(path, "wb");
        assert_non_null(file);
        assert_int_equal(fwrite(page, 1, length, file), length);
        assert_int_equal(fclose(file), 0);
    }
    char *kept = calloc(1, length + 2);
    FILE *file = fopen(path, "rb");
    size_t kept_length = file && kept ? fread(kept, 1, length + 1, file) : 0;
    if (file) fclose(file);
    if (kept_length != length || memcmp(kept, page, length) != 0)
        fail_msg("%s is stale; run this program with TULLE_UPDATE_DOCS=1", path);
    free(kept);
    free(page);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_page_is_current)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
