/* scene/documentation.c - prints docs/guide/scene.md from the table of keys, the units, the shapes
 * and the material presets. */
#include "scene/keys.h"

#include "tulle/shapes.h"
#include "tulle/world.h"

#include <string.h>

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

static void print_type(const schema_key *key, FILE *stream) {
    switch (key->type) {
    case SCHEMA_NUMBER: fprintf(stream, "%s", unit_dimension_name(key->unit)); break;
    case SCHEMA_INTEGER: fprintf(stream, "whole number"); break;
    case SCHEMA_BOOL: fprintf(stream, "true or false"); break;
    case SCHEMA_TEXT: fprintf(stream, "text"); break;
    case SCHEMA_NAME: fprintf(stream, "name"); break;
    case SCHEMA_PATH: fprintf(stream, "path"); break;
    case SCHEMA_CHOICE: fprintf(stream, "one of the words"); break;
    case SCHEMA_ROTATION: fprintf(stream, "turn"); break;
    case SCHEMA_NAMES: fprintf(stream, "list of %zu names", key->most_count); break;
    case SCHEMA_INDICES: fprintf(stream, "list of whole numbers and ranges"); break;
    case SCHEMA_MAP:
        fprintf(stream, "map%s, see ", key->map->takes_flag ? ", `true` or `false`" : "");
        print_link(key->map->title, stream);
        break;
    case SCHEMA_LIST:
        fprintf(stream, "list of maps, see ");
        print_link(key->map->title, stream);
        break;
    case SCHEMA_VECTOR:
    case SCHEMA_INTEGERS:
        fprintf(stream, "list of %zu", key->least_count);
        if (key->most_count > key->least_count) fprintf(stream, " to %zu", key->most_count);
        if (key->type == SCHEMA_INTEGERS)
            fprintf(stream, " whole numbers");
        else
            fprintf(stream, ", each %s", unit_dimension_name(key->unit));
        break;
    }
}

static void print_default(const schema_map *map, const schema_key *key, FILE *stream) {
    if (key->fallback && key->fallback[0])
        fprintf(stream, "`%s`", key->fallback);
    else if (key->derived)
        fprintf(stream, "%s", key->derived);
    else if (key->flags & SCHEMA_REQUIRED)
        fprintf(stream, "required");
    else if (key->flags & SCHEMA_ALTERNATIVE)
        fprintf(stream, map->needs_alternative ? "one of these" : "none");
    else if (key->flags & SCHEMA_SECOND_ALTERNATIVE)
        fprintf(stream, map->needs_second_alternative ? "one of these" : "none");
    else if (key->type == SCHEMA_MAP)
        fprintf(stream, "its defaults");
    else
        fprintf(stream, "none");
}

static void print_range(const schema_key *key, FILE *stream) {
    if (key->choices) {
        for (size_t i = 0; key->choices[i]; i++)
            fprintf(stream, "%s`%s`", i > 0 ? " " : "", key->choices[i]);
        return;
    }
    bool is_limited = key->minimum != 0 || key->maximum != 0;
    const char *entries = key->type == SCHEMA_LIST ? " entries" : "";
    if (is_limited && key->flags & SCHEMA_ABOVE_MINIMUM)
        fprintf(stream, "above %.10g, to %.16g", key->minimum, key->maximum);
    else if (is_limited)
        fprintf(stream, "%.10g to %.16g%s%s", key->minimum, key->maximum, entries,
                key->flags & SCHEMA_NOT_ZERO ? ", not 0" : "");
    if (key->word) fprintf(stream, "%s`%s`", is_limited ? ", or " : "", key->word);
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

static void print_map(const map_entry *entry, FILE *stream) {
    const schema_map *map = entry->map;
    fprintf(stream, "\n## %s\n\n%s\n\n", map->title, map->meaning);
    if (entry->places[1] != '`') fprintf(stream, "At %s.\n\n", entry->places);
    fprintf(stream, "| key | type | unit | default | range | meaning |\n"
                    "|---|---|---|---|---|---|\n");
    for (size_t k = 0; k < map->key_count; k++) {
        const schema_key *key = &map->keys[k];
        fprintf(stream, "| `%s` | ", key->name);
        print_type(key, stream);
        fprintf(stream, " | %s | ", unit_si_name(key->unit));
        print_default(map, key, stream);
        fprintf(stream, " | ");
        print_range(key, stream);
        fprintf(stream, " | %s", key->meaning);
        print_need(map, key, stream);
        fputs(" |\n", stream);
    }
    print_choice(map, SCHEMA_ALTERNATIVE, map->needs_alternative, stream);
    print_choice(map, SCHEMA_SECOND_ALTERNATIVE, map->needs_second_alternative, stream);
}

static void print_units(FILE *stream) {
    fprintf(stream, "\n## Units\n\n| quantity | unit of plain numbers | units |\n|---|---|---|\n");
    for (int d = 0; d < UNIT_DIMENSION_COUNT; d++) {
        char names[100];
        unit_list_names((unit_dimension)d, names, sizeof names);
        fprintf(stream, "| %s | %s | %s |\n", unit_dimension_name((unit_dimension)d),
                unit_si_name((unit_dimension)d), names);
    }
}

static void print_shapes(FILE *stream) {
    const schema_key *selector = &mesh_map.keys[schema_find_key(&mesh_map, "shape")];
    fprintf(stream, "\n## Shapes\n\n[Shapes](shapes.md) tells what the keys mean for each.\n\n| "
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
    fprintf(stream,
            "\n## Material presets\n\nValues in bold were measured, all others are estimates; the "
            "sources are below. Warp, weft and shear are stiffness / knee / limit, bend is warp / "
            "weft, hysteresis is that of bending along warp / weft / that of shear. Thickness [m] "
            "is told only; `cloth[].thickness` is for contact.\n\n"
            "| preset | area_density | thickness | warp | weft | shear | bend | hysteresis | "
            "friction | poisson | bend_twist | stretch_damping | bend_damping | air_damping |\n"
            "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|\n");
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
    fprintf(stream, "\nWhere the values come from:\n\n");
    for (size_t i = 0; (name = tulle_material_preset_name(i)); i++)
        fprintf(stream, "- `%s`: %s.\n", name, tulle_material_preset_source(i));
    fprintf(stream, "\n[Materials](materials.md) tells what the values mean.\n");
}

static const char introduction[] =
    "# Scene keys\n\n"
    "A scene is one YAML document. `tulle run` reads it. The program prints this page from the "
    "table by which it reads scenes, so the two agree.\n\n"
    "- All values are in SI units. A number may carry a unit: `2 mm`, `30 deg`, `5 km/h`, "
    "`0.2 kg/m^2`, `1/90 s`; the [units](#units) are at the end. Plain numbers are metres, "
    "seconds, radians and so on. z is up.\n"
    "- A turn is a list of angles about the fixed axes x, then y, then z, for example `[0, 90 deg, "
    "0]`, or a map `{axis: [0, 0, 1], angle: 30 deg}`.\n"
    "- Paths are relative to the scene file.\n"
    "- A key that does nothing beside the others is an error, unless it has its default: "
    "`gust_length` without `gust_strength`, or a woven value with `membrane: springs`. An override "
    "may leave keys of the file without a use. So may a material file.\n"
    "- NaN, infinities, unknown and duplicate keys are errors. Anchors, aliases, tags and several "
    "documents are refused. A file has at most 4 MiB and 200,000 values, nested at most 32 deep; a "
    "scene at most 20,000,000 vertices and 4,096 obstacles.\n"
    "- `--set PATH=VALUE` on the command line replaces or adds a value: `--set time.frames=10`, "
    "`--set 'cloth[0].mesh.resolution=[40, 40]'`. An empty value removes a key. Of keys that "
    "exclude each other the one that was set wins.\n\n"
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

void scene_print_documentation(FILE *stream) {
    map_list list = {.count = 0};
    add_map(&list, &scene_map, "");
    fputs(introduction, stream);
    for (size_t i = 0; i < list.count; i++) print_map(&list.entries[i], stream);
    print_shapes(stream);
    print_presets(stream);
    print_units(stream);
}
