/* io/animation/usd_layer.c - see usd_layer.h. */
#include "io/animation/usd_layer.h"

#include "base/error.h"
#include "base/hash.h"
#include "base/sort.h"
#include "io/file_data.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum {
    DEPTH_MAX = 100,    /* prims in each other */
    ATTRIBUTE_MAX = 256 /* of a prim, of those that are read: they are looked up one by one */
};
#define TEXTS_LIMIT ((size_t)INT32_MAX) /* [bytes] */

static tulle_status fail_memory(const usd_layer *layer, tulle_error *error) {
    return file_fail_memory(error, layer->text.path);
}

static tulle_status next(usd_layer *layer, tulle_error *error) {
    return usd_text_next(&layer->text, error);
}

/* ---- texts and names ---- */

const char *usd_layer_get_text(const usd_layer *layer, uint32_t text) {
    return layer->texts.data + text;
}

/* Keeps the word at hand. */
static tulle_status keep_word(usd_layer *layer, uint32_t *text, tulle_error *error) {
    size_t const size = layer->text.word.count + 1;
    if (layer->texts.count + size > TEXTS_LIMIT)
        return usd_text_fail(&layer->text, layer->text.place, error, "its names are too many");
    if (!ARRAY_RESERVE(layer->text.heap, &layer->texts, size)) return fail_memory(layer, error);
    *text = (uint32_t)layer->texts.count;
    memcpy(layer->texts.data + layer->texts.count, layer->text.word.data, size);
    layer->texts.count += size;
    return TULLE_OK;
}

static size_t find_slot(const usd_layer *layer, uint32_t parent, const char *name, size_t length) {
    size_t const mask = layer->slot_count - 1;
    uint64_t const hash = hash_bytes(HASH_SEED ^ hash_mix(parent), name, length);
    size_t slot = (size_t)hash_mix(hash) & mask;
    for (; layer->slots[slot] != USD_NONE; slot = (slot + 1) & mask) {
        const usd_prim *const prim = &layer->prims.data[layer->slots[slot]];
        const char *const found = usd_layer_get_text(layer, prim->name);
        if (prim->parent == parent && strncmp(found, name, length) == 0 && found[length] == '\0')
            break;
    }
    return slot;
}

uint32_t usd_layer_find_child(const usd_layer *layer, uint32_t parent, const char *name,
                              size_t length) {
    return layer->slots[find_slot(layer, parent, name, length)];
}

uint32_t usd_layer_find_prim(const usd_layer *layer, const char *path) {
    if (*path == '\0' && layer->default_prim != USD_NONE) {
        const char *const name = usd_layer_get_text(layer, layer->default_prim);
        return usd_layer_find_child(layer, 0, name, strlen(name));
    }
    if (*path != '/') return USD_NONE;
    uint32_t prim = 0;
    while (*path == '/' && prim != USD_NONE) {
        path++;
        size_t const length = strcspn(path, "/");
        prim = usd_layer_find_child(layer, prim, path, length);
        path += length;
    }
    return prim;
}

uint32_t usd_layer_find_attribute(const usd_layer *layer, uint32_t prim, usd_name name,
                                  const char *full_name) {
    uint32_t number = layer->prims.data[prim].first_attribute;
    for (; number != USD_NONE; number = layer->attributes.data[number].next) {
        const usd_attribute *const attribute = &layer->attributes.data[number];
        if (attribute->name == name &&
            (!full_name || strcmp(usd_layer_get_text(layer, attribute->full_name), full_name) == 0))
            break;
    }
    return number;
}

/* Makes a larger table of names when half of it is taken. */
static tulle_status grow_slots(usd_layer *layer, tulle_error *error) {
    if (2 * layer->prims.count < layer->slot_count) return TULLE_OK;
    size_t const count = layer->slot_count > 0 ? 2 * layer->slot_count : 64;
    uint32_t *const slots = memory_allocate(layer->text.heap, count * sizeof *slots);
    if (!slots) return fail_memory(layer, error);
    memory_release(layer->text.heap, layer->slots, layer->slot_count * sizeof *layer->slots);
    layer->slots = slots;
    layer->slot_count = count;
    memset(slots, 0xff, count * sizeof *slots);
    for (size_t i = 1; i < layer->prims.count; i++) {
        const usd_prim *const prim = &layer->prims.data[i];
        const char *const name = usd_layer_get_text(layer, prim->name);
        slots[find_slot(layer, prim->parent, name, strlen(name))] = (uint32_t)i;
    }
    return TULLE_OK;
}

/* ---- metadata ---- */

static bool is_one_of(const usd_text *text, const char *const *names) {
    for (; *names; names++)
        if (usd_text_is_name(text, *names)) return true;
    return false;
}

static const char *const list_words[] = {"prepend", "append", "add", "delete", "reorder", NULL};

/* One reference: a file, or a prim of this one, or both. */
static tulle_status parse_reference(usd_layer *layer, uint32_t prim, bool is_inherited,
                                    tulle_error *error) {
    usd_text *const text = &layer->text;
    usd_arc arc = {.next = USD_NONE, .is_inherited = is_inherited, .place = text->place};
    bool is_other = false;
    tulle_status status = TULLE_OK;
    if (text->kind != USD_ASSET && text->kind != USD_PATH)
        return usd_text_fail_word(text, "a path or a file's name", error);
    if (text->kind == USD_ASSET) {
        is_other = text->word.count > 0;
        if (is_other && layer->passed.other_files++ == 0) {
            layer->passed.file_place = text->place;
            status = keep_word(layer, &layer->passed.first_file, error);
        }
        if (status == TULLE_OK) status = next(layer, error);
        text->word.count *= text->kind == USD_PATH;
        text->word.data[text->word.count] = '\0';
    }
    if (status == TULLE_OK) status = keep_word(layer, &arc.path, error);
    if (status == TULLE_OK && text->kind == USD_PATH) status = next(layer, error);
    if (status == TULLE_OK && usd_text_is_sign(text, '(')) { /* another time */
        if (!is_other)
            return usd_text_fail(text, text->place, error,
                                 "a reference with another time is not read here");
        status = usd_text_skip(text, error);
    }
    if (status || is_other) return status;
    if (!ARRAY_RESERVE(text->heap, &layer->arcs, 1)) return fail_memory(layer, error);
    uint32_t const number = (uint32_t)layer->arcs.count;
    usd_prim *const owner = &layer->prims.data[prim];
    if (owner->last_arc == USD_NONE)
        owner->first_arc = number;
    else
        layer->arcs.data[owner->last_arc].next = number;
    owner->last_arc = number;
    layer->arcs.data[layer->arcs.count++] = arc;
    return TULLE_OK;
}

static tulle_status parse_references(usd_layer *layer, uint32_t prim, bool is_inherited,
                                     tulle_error *error) {
    usd_text *const text = &layer->text;
    if (usd_text_is_name(text, "None")) return next(layer, error);
    if (!usd_text_is_sign(text, '[')) return parse_reference(layer, prim, is_inherited, error);
    tulle_status status = next(layer, error);
    while (status == TULLE_OK && !usd_text_is_sign(text, ']')) {
        status = parse_reference(layer, prim, is_inherited, error);
        if (status == TULLE_OK && !usd_text_is_sign(text, ']'))
            status = usd_text_expect(text, ',', error);
    }
    return status == TULLE_OK ? next(layer, error) : status;
}

static tulle_status take_positive(usd_layer *layer, double *value, tulle_error *error) {
    usd_text *const text = &layer->text;
    if (text->kind != USD_NUMBER || !(text->number > 0.0) || !(text->number < 1e9))
        return usd_text_fail_word(text, "a number above 0 and below 1e9", error);
    *value = text->number;
    return next(layer, error);
}

/* What the layer as a whole says. */
static tulle_status parse_layer_fact(usd_layer *layer, const char *key, bool *is_done,
                                     tulle_error *error) {
    usd_text *const text = &layer->text;
    *is_done = true;
    if (strcmp(key, "upAxis") == 0) {
        bool const is_y = text->kind == USD_STRING && strcmp(text->word.data, "Y") == 0;
        if (!is_y && (text->kind != USD_STRING || strcmp(text->word.data, "Z") != 0))
            return usd_text_fail_word(text, "\"Y\" or \"Z\"", error);
        layer->is_y_up = is_y;
        return next(layer, error);
    }
    if (strcmp(key, "metersPerUnit") == 0)
        return take_positive(layer, &layer->meters_per_unit, error);
    if (strcmp(key, "timeCodesPerSecond") == 0)
        return take_positive(layer, &layer->codes_per_second, error);
    if (strcmp(key, "framesPerSecond") == 0)
        return take_positive(layer, &layer->frames_per_second, error);
    if (strcmp(key, "startTimeCode") == 0 && text->kind == USD_NUMBER && isfinite(text->number)) {
        layer->start_code = text->number;
        return next(layer, error);
    }
    if (strcmp(key, "defaultPrim") == 0 && text->kind == USD_STRING) {
        tulle_status const status = keep_word(layer, &layer->default_prim, error);
        return status == TULLE_OK ? next(layer, error) : status;
    }
    if (strcmp(key, "subLayers") == 0) return parse_references(layer, 0, false, error);
    *is_done = false;
    return TULLE_OK;
}

/* What a prim says of itself. */
static tulle_status parse_prim_fact(usd_layer *layer, uint32_t prim, const char *key,
                                    bool is_explicit, bool *is_done, tulle_error *error) {
    usd_text *const text = &layer->text;
    bool const is_inherited = strcmp(key, "inherits") == 0 || strcmp(key, "specializes") == 0;
    *is_done = true;
    if (is_inherited || strcmp(key, "references") == 0 || strcmp(key, "payload") == 0)
        return parse_references(layer, prim, is_inherited, error);
    if (strcmp(key, "active") == 0) {
        layer->prims.data[prim].is_inactive =
            usd_text_is_name(text, "false") || (text->kind == USD_NUMBER && text->number == 0.0);
        return next(layer, error);
    }
    if (strcmp(key, "inactiveIds") == 0 && !usd_text_is_name(text, "None")) {
        if (!ARRAY_RESERVE(text->heap, &layer->inactive, 1)) return fail_memory(layer, error);
        layer->inactive.data[layer->inactive.count++] =
            (usd_inactive){prim, is_explicit, text->place};
    }
    *is_done = false;
    return TULLE_OK;
}

enum { KEY_SIZE = 64 };

/* What stands in ( ) behind the head of the layer (prim 0), of a prim, or of an attribute
 * (USD_NONE). */
static tulle_status parse_metadata(usd_layer *layer, uint32_t prim, tulle_error *error) {
    usd_text *const text = &layer->text;
    tulle_status status = usd_text_expect(text, '(', error);
    while (status == TULLE_OK && !usd_text_is_sign(text, ')')) {
        bool is_done = false, is_deleted = false, is_explicit = true;
        if (text->kind == USD_STRING || usd_text_is_sign(text, ';')) {
            status = next(layer, error);
            continue;
        }
        if (is_one_of(text, list_words)) {
            is_explicit = false;
            is_deleted = text->word.data[0] == 'd' || text->word.data[0] == 'r';
            status = next(layer, error);
        }
        if (status == TULLE_OK && text->kind != USD_NAME)
            status = usd_text_fail_word(text, "a name or \")\"", error);
        if (status) return status;
        char key[KEY_SIZE];
        snprintf(key, sizeof key, "%s", text->word.data);
        status = next(layer, error);
        if (status == TULLE_OK) status = usd_text_expect(text, '=', error);
        if (status == TULLE_OK && prim == 0 && !is_deleted)
            status = parse_layer_fact(layer, key, &is_done, error);
        else if (status == TULLE_OK && prim != USD_NONE && !is_deleted)
            status = parse_prim_fact(layer, prim, key, is_explicit, &is_done, error);
        if (status == TULLE_OK && !is_done) status = usd_text_skip(text, error);
    }
    return status == TULLE_OK ? next(layer, error) : status;
}

static tulle_status parse_any_metadata(usd_layer *layer, uint32_t prim, tulle_error *error) {
    return usd_text_is_sign(&layer->text, '(') ? parse_metadata(layer, prim, error) : TULLE_OK;
}

/* ---- attributes ---- */

static usd_name find_name(const char *name) {
    static const char *const names[USD_OP] = {"points",
                                              "faceVertexCounts",
                                              "faceVertexIndices",
                                              "holeIndices",
                                              "orientation",
                                              "subdivisionScheme",
                                              "visibility",
                                              "purpose",
                                              "xformOpOrder",
                                              "prototypes",
                                              "protoIndices",
                                              "positions",
                                              "orientations",
                                              "scales",
                                              "invisibleIds",
                                              "ids",
                                              "primvars:skel:jointIndices",
                                              "tulle:times"};
    if (strncmp(name, "xformOp:", 8) == 0) return USD_OP;
    int i = 0;
    while (i < USD_OP && strcmp(name, names[i]) != 0) i++;
    return i < USD_OP ? (usd_name)i : USD_NAME_COUNT;
}

/* The attribute at hand, which may be told in several places: a value here, samples there. */
static tulle_status take_attribute(usd_layer *layer, uint32_t prim, usd_name name, uint32_t *number,
                                   tulle_error *error) {
    usd_text *const text = &layer->text;
    *number = usd_layer_find_attribute(layer, prim, name, text->word.data);
    if (*number != USD_NONE) return TULLE_OK;
    usd_attribute made = {.name = name,
                          .piece = USD_NONE,
                          .next = layer->prims.data[prim].first_attribute,
                          .place = text->place};
    if (layer->prims.data[prim].attribute_count++ == ATTRIBUTE_MAX)
        return usd_text_fail(text, text->place, error, "the prim has more than %d attributes",
                             ATTRIBUTE_MAX);
    tulle_status const status = keep_word(layer, &made.full_name, error);
    if (status) return status;
    if (!ARRAY_RESERVE(text->heap, &layer->attributes, 1)) return fail_memory(layer, error);
    *number = (uint32_t)layer->attributes.count;
    layer->attributes.data[layer->attributes.count++] = made;
    layer->prims.data[prim].first_attribute = *number;
    return TULLE_OK;
}

static int compare_samples(const void *a, const void *b) {
    const usd_sample *const one = a, *const other = b;
    return (one->code > other->code) - (one->code < other->code);
}

/* { code: value, ... } */
static tulle_status parse_samples(usd_layer *layer, uint32_t number, tulle_error *error) {
    usd_text *const text = &layer->text;
    size_t const first = layer->samples.count;
    bool is_rising = true;
    tulle_status status = usd_text_expect(text, '{', error);
    while (status == TULLE_OK && !usd_text_is_sign(text, '}')) {
        if (text->kind != USD_NUMBER || !isfinite(text->number))
            return usd_text_fail_word(text, "a time", error);
        usd_sample sample = {.code = text->number};
        status = next(layer, error);
        if (status == TULLE_OK) status = usd_text_expect(text, ':', error);
        sample.place = text->place;
        if (status == TULLE_OK && usd_text_is_name(text, "None") && number != USD_NONE)
            status = usd_text_fail(text, text->place, error,
                                   "a sample without a value is not read here");
        if (status == TULLE_OK) status = usd_text_skip(text, error);
        if (status == TULLE_OK && !usd_text_is_sign(text, '}'))
            status = usd_text_expect(text, ',', error);
        if (status || number == USD_NONE) continue;
        if (!ARRAY_RESERVE(text->heap, &layer->samples, 1)) return fail_memory(layer, error);
        if (layer->samples.count > first)
            is_rising =
                is_rising && layer->samples.data[layer->samples.count - 1].code < sample.code;
        layer->samples.data[layer->samples.count++] = sample;
    }
    if (status) return status;
    if (number == USD_NONE) return next(layer, error);
    usd_attribute *const attribute = &layer->attributes.data[number];
    if (attribute->sample_count > 0)
        return usd_text_fail(text, attribute->place, error, "has time samples in two places");
    attribute->first_sample = first;
    attribute->sample_count = layer->samples.count - first;
    usd_sample *const samples = layer->samples.data + first;
    if (!is_rising)
        sort_in_place(samples, attribute->sample_count, sizeof *samples, compare_samples);
    for (size_t i = 1; i < attribute->sample_count; i++)
        if (!(samples[i - 1].code < samples[i].code))
            return usd_text_fail(text, samples[i].place, error,
                                 "there are two samples at the time %g", samples[i].code);
    return next(layer, error);
}

/* "name[.part] [= value] [(metadata)]" behind the type of an attribute or "rel". */
static tulle_status parse_property(usd_layer *layer, uint32_t prim, bool is_double,
                                   tulle_error *error) {
    usd_text *const text = &layer->text;
    if (text->kind != USD_NAME) return usd_text_fail_word(text, "the name of an attribute", error);
    usd_name const name = find_name(text->word.data);
    uint32_t number = USD_NONE;
    tulle_status status =
        name < USD_NAME_COUNT ? take_attribute(layer, prim, name, &number, error) : TULLE_OK;
    if (status == TULLE_OK) status = next(layer, error);
    bool has_samples = false, is_value = true;
    if (status == TULLE_OK && usd_text_is_sign(text, '.')) {
        status = next(layer, error);
        has_samples = usd_text_is_name(text, "timeSamples");
        is_value = usd_text_is_name(text, "default");
        if (status == TULLE_OK && text->kind != USD_NAME)
            status = usd_text_fail_word(text, "\"timeSamples\" or \"connect\"", error);
        if (status == TULLE_OK) status = next(layer, error);
    }
    if (number != USD_NONE && status == TULLE_OK)
        layer->attributes.data[number].is_double = is_double;
    if (status == TULLE_OK && usd_text_is_sign(text, '=')) {
        status = next(layer, error);
        if (status == TULLE_OK && has_samples) {
            status = parse_samples(layer, number, error);
        } else if (status == TULLE_OK) {
            if (number != USD_NONE && is_value && !usd_text_is_name(text, "None")) {
                layer->attributes.data[number].has_value = true;
                layer->attributes.data[number].value = text->place;
            }
            status = usd_text_skip(text, error);
        }
    }
    return status == TULLE_OK ? parse_any_metadata(layer, USD_NONE, error) : status;
}

/* ---- prims ---- */

static usd_type find_type(const char *name) {
    static const char *const shapes[] = {
        "Cube",        "Sphere",     "Cylinder",     "Cylinder_1",  "Capsule", "Capsule_1",
        "Cone",        "Plane",      "TetMesh",      "BasisCurves", "Volume",  "HermiteCurves",
        "NurbsCurves", "NurbsPatch", "OpenVDBAsset", NULL};
    if (strcmp(name, "Mesh") == 0) return USD_MESH;
    if (strcmp(name, "Points") == 0) return USD_POINT_CLOUD;
    if (strcmp(name, "PointInstancer") == 0) return USD_INSTANCER;
    if (strcmp(name, "Scope") == 0) return USD_SCOPE;
    for (int i = 0; shapes[i]; i++)
        if (strcmp(name, shapes[i]) == 0) return USD_SHAPE;
    return USD_GROUP;
}

static tulle_status parse_contents(usd_layer *layer, uint32_t prim, int depth, tulle_error *error);

static tulle_status add_prim(usd_layer *layer, usd_prim made, uint32_t *number,
                             tulle_error *error) {
    usd_text *const text = &layer->text;
    const char *const name = text->word.data;
    if (text->kind != USD_STRING || text->word.count == 0)
        return usd_text_fail_word(text, "the name of a prim in quotes", error);
    if (usd_layer_find_child(layer, made.parent, name, text->word.count) != USD_NONE)
        return usd_text_fail_word(text, "another name: the prim above has this one already", error);
    made.place = text->place;
    tulle_status status = keep_word(layer, &made.name, error);
    if (status == TULLE_OK && !ARRAY_RESERVE(text->heap, &layer->prims, 1))
        status = fail_memory(layer, error);
    if (status) return status;
    *number = (uint32_t)layer->prims.count;
    layer->slots[find_slot(layer, made.parent, name, text->word.count)] = *number;
    layer->prims.data[layer->prims.count++] = made;
    usd_prim *const parent = &layer->prims.data[made.parent];
    if (parent->last_child == USD_NONE)
        parent->first_child = *number;
    else
        layer->prims.data[parent->last_child].next = *number;
    parent->last_child = *number;
    return grow_slots(layer, error);
}

/* "def Mesh "name" (metadata) { ... }" from its first word on. */
static tulle_status parse_prim(usd_layer *layer, uint32_t parent, int depth, tulle_error *error) {
    usd_text *const text = &layer->text;
    char const first = text->word.data[0];
    usd_prim made = {.parent = parent,
                     .next = USD_NONE,
                     .first_child = USD_NONE,
                     .last_child = USD_NONE,
                     .first_attribute = USD_NONE,
                     .first_arc = USD_NONE,
                     .last_arc = USD_NONE,
                     .specifier = first == 'd'   ? USD_DEF
                                  : first == 'o' ? USD_OVER
                                                 : USD_CLASS};
    if (depth >= DEPTH_MAX)
        return usd_text_fail(text, text->place, error, "more than %d prims in each other",
                             DEPTH_MAX);
    tulle_status status = next(layer, error);
    if (status == TULLE_OK && text->kind == USD_NAME) {
        made.type = find_type(text->word.data);
        status = next(layer, error);
    }
    uint32_t prim = USD_NONE;
    if (status == TULLE_OK) status = add_prim(layer, made, &prim, error);
    if (status == TULLE_OK) status = next(layer, error);
    if (status == TULLE_OK) status = parse_any_metadata(layer, prim, error);
    usd_place const opening = text->place;
    if (status == TULLE_OK) status = usd_text_expect(text, '{', error);
    if (status == TULLE_OK) status = parse_contents(layer, prim, depth + 1, error);
    if (status) return status;
    if (text->kind == USD_END)
        return usd_text_fail(text, opening, error, "the bracket that opens here is not closed");
    return usd_text_expect(text, '}', error);
}

/* variantSet "name" = { "a" { ... } ... } */
static tulle_status skip_variants(usd_layer *layer, tulle_error *error) {
    usd_text *const text = &layer->text;
    layer->passed.variant_sets++;
    tulle_status status = next(layer, error);
    if (status == TULLE_OK && text->kind != USD_STRING)
        status = usd_text_fail_word(text, "the name of a variant set in quotes", error);
    if (status == TULLE_OK) status = next(layer, error);
    if (status == TULLE_OK) status = usd_text_expect(text, '=', error);
    return status == TULLE_OK ? usd_text_skip(text, error) : status;
}

static tulle_status parse_typed(usd_layer *layer, uint32_t prim, tulle_error *error) {
    static const char *const words[] = {"custom", "uniform", "varying", "config", NULL};
    usd_text *const text = &layer->text;
    tulle_status status = TULLE_OK;
    while (status == TULLE_OK && (is_one_of(text, words) || is_one_of(text, list_words)))
        status = next(layer, error);
    if (status == TULLE_OK && text->kind != USD_NAME)
        status = usd_text_fail_word(text, "the type of an attribute, a prim or \"}\"", error);
    if (status) return status;
    size_t const length = text->word.count;
    bool const is_double = (length > 1 && text->word.data[length - 1] == 'd') ||
                           strncmp(text->word.data, "double", 6) == 0;
    status = next(layer, error);
    if (status == TULLE_OK && usd_text_is_sign(text, '[')) {
        status = next(layer, error);
        if (status == TULLE_OK) status = usd_text_expect(text, ']', error);
    }
    return status == TULLE_OK ? parse_property(layer, prim, is_double, error) : status;
}

/* The contents of a prim up to the bracket that closes it, or of the file up to its end. */
static tulle_status parse_contents(usd_layer *layer, uint32_t prim, int depth, tulle_error *error) {
    static const char *const specifiers[] = {"def", "over", "class", NULL};
    usd_text *const text = &layer->text;
    tulle_status status = TULLE_OK;
    while (status == TULLE_OK && text->kind != USD_END && !usd_text_is_sign(text, '}')) {
        if (is_one_of(text, specifiers)) {
            status = parse_prim(layer, prim, depth, error);
        } else if (usd_text_is_name(text, "variantSet")) {
            status = skip_variants(layer, error);
        } else if (usd_text_is_sign(text, ';')) {
            status = next(layer, error);
        } else if (usd_text_is_name(text, "reorder")) { /* reorder nameChildren = [...] */
            status = next(layer, error);
            while (status == TULLE_OK && text->kind == USD_NAME) status = next(layer, error);
            if (status == TULLE_OK) status = usd_text_expect(text, '=', error);
            if (status == TULLE_OK) status = usd_text_skip(text, error);
        } else if (depth == 0) {
            status = usd_text_fail_word(text, "def, over or class", error);
        } else {
            status = parse_typed(layer, prim, error);
        }
    }
    return status;
}

tulle_status usd_layer_open(memory *heap, const char *path, usd_layer *layer, tulle_error *error) {
    *layer = (usd_layer){.is_y_up = true,
                         .meters_per_unit = (double)NAN,
                         .codes_per_second = (double)NAN,
                         .frames_per_second = (double)NAN,
                         .start_code = (double)NAN,
                         .default_prim = USD_NONE};
    usd_prim const root = {.parent = USD_NONE,
                           .next = USD_NONE,
                           .first_child = USD_NONE,
                           .last_child = USD_NONE,
                           .first_attribute = USD_NONE,
                           .first_arc = USD_NONE,
                           .last_arc = USD_NONE,
                           .type = USD_GROUP};
    tulle_status status = usd_text_open(heap, path, &layer->text, error);
    if (status) return status;
    if (!ARRAY_RESERVE(heap, &layer->texts, 1) || !ARRAY_RESERVE(heap, &layer->prims, 1) ||
        !ARRAY_RESERVE(heap, &layer->samples, 1))
        return fail_memory(layer, error);
    layer->texts.data[layer->texts.count++] = '\0';
    layer->prims.data[layer->prims.count++] = root;
    status = grow_slots(layer, error);
    if (status == TULLE_OK) status = parse_any_metadata(layer, 0, error);
    if (status == TULLE_OK) status = parse_contents(layer, 0, 0, error);
    if (status == TULLE_OK && layer->text.kind != USD_END)
        status = usd_text_fail_word(&layer->text, "def, over or class", error);
    if (isnan(layer->codes_per_second)) /* as USD's standard has it */
        layer->codes_per_second = isnan(layer->frames_per_second) ? 24.0 : layer->frames_per_second;
    if (isnan(layer->meters_per_unit)) layer->meters_per_unit = 0.01;
    return status;
}

void usd_layer_close(usd_layer *layer) {
    memory *const heap = layer->text.heap;
    if (!heap) return;
    memory_release(heap, layer->slots, layer->slot_count * sizeof *layer->slots);
    ARRAY_FREE(heap, &layer->prims);
    ARRAY_FREE(heap, &layer->attributes);
    ARRAY_FREE(heap, &layer->arcs);
    ARRAY_FREE(heap, &layer->samples);
    ARRAY_FREE(heap, &layer->inactive);
    ARRAY_FREE(heap, &layer->texts);
    usd_text_close(&layer->text);
    *layer = (usd_layer){0};
}
