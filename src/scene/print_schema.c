/* scene/print_schema.c - the table of keys as JSON, for editors that complete what one types. */
#include "scene/keys.h"

#include "io/text/json_quote.h"

#include "tulle/world.h"

#include <stdio.h>
#include <string.h>

enum { PATH_SIZE = 256, DEPTH_MAX = 8 };

static void print_text(const char *name, const char *text, FILE *stream) {
    if (!text) return;
    fprintf(stream, ",\"%s\":\"", name);
    char piece[JSON_PIECE_SIZE];
    while (json_take_piece(&text, piece) > 0) fputs(piece, stream);
    fputc('"', stream);
}

static const char *get_kind(const schema_key *key) {
    static const char *const kinds[] = {
        [SCHEMA_NUMBER] = "number", [SCHEMA_INTEGER] = "integer", [SCHEMA_BOOL] = "bool",
        [SCHEMA_TEXT] = "text",     [SCHEMA_NAME] = "name",       [SCHEMA_PATH] = "path",
        [SCHEMA_CHOICE] = "choice", [SCHEMA_VECTOR] = "vector",   [SCHEMA_INTEGERS] = "integers",
        [SCHEMA_NAMES] = "names",   [SCHEMA_INDICES] = "indices", [SCHEMA_ROTATION] = "turn",
        [SCHEMA_MAP] = "map",       [SCHEMA_LIST] = "list"};
    return kinds[key->type];
}

/* The words that may stand there: of a choice, or the presets of fabrics. */
static void print_choices(const schema_map *map, const schema_key *key, FILE *stream) {
    bool const is_preset = map == &material_map && strcmp(key->name, "preset") == 0;
    if (!key->choices && !key->word && !is_preset) return;
    fputs(",\"choices\":[", stream);
    const char *separator = "";
    for (size_t i = 0; key->choices && key->choices[i]; i++, separator = ",")
        fprintf(stream, "%s\"%s\"", separator, key->choices[i]);
    for (size_t i = 0; is_preset && tulle_material_preset_name(i); i++, separator = ",")
        fprintf(stream, "%s\"%s\"", separator, tulle_material_preset_name(i));
    if (key->word) fprintf(stream, "%s\"%s\"", separator, key->word);
    fputc(']', stream);
}

static void print_map(const schema_map *map, const char *place, int depth, FILE *stream) {
    for (size_t k = 0; k < map->key_count; k++) {
        const schema_key *const key = &map->keys[k];
        char path[PATH_SIZE];
        snprintf(path, sizeof path, "%.200s%s%.40s", place, place[0] ? "." : "", key->name);
        if (depth > 0 || k > 0) fputc(',', stream);
        fprintf(stream, "\n{\"path\":\"%s\",\"kind\":\"%s\"", path, get_kind(key));
        if (key->type == SCHEMA_NUMBER || key->type == SCHEMA_VECTOR)
            print_text("unit", unit_si_name(key->unit), stream);
        print_choices(map, key, stream);
        print_text("default", key->fallback ? key->fallback : key->derived, stream);
        if (key->flags & SCHEMA_REQUIRED) fputs(",\"required\":true", stream);
        print_text("help", key->meaning, stream);
        fputc('}', stream);
        if ((key->type != SCHEMA_MAP && key->type != SCHEMA_LIST) || depth >= DEPTH_MAX) continue;
        if (key->type == SCHEMA_LIST) snprintf(path + strlen(path), 3, "[]");
        print_map(key->map, path, depth + 1, stream);
    }
}

void scene_print_schema(FILE *stream) {
    fputc('[', stream);
    print_map(&scene_map, "", 0, stream);
    fputs("]\n", stream);
}
