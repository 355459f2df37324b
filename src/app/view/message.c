/* app/view/message.c - see message.h. */
#include "app/view/message.h"

#include "app/view/overlays.h"
#include "app/view/series.h"
#include "base/memory.h"
#include "base/text.h"
#include "io/text/json_read.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

typedef enum field_kind {
    FIELD_WHOLE,    /* uint32_t */
    FIELD_COUNT,    /* uint64_t */
    FIELD_BOOL,     /* bool */
    FIELD_NUMBER,   /* double */
    FIELD_NUMBERS,  /* `count` doubles */
    FIELD_NAME,     /* name[] */
    FIELD_TEXT,     /* text */
    FIELD_OVERLAYS, /* list of names */
    FIELD_SERIES,   /* list of names */
    FIELD_WHAT,     /* setting_kind */
    FIELD_VALUE     /* a number, a list of numbers or a name */
} field_kind;

typedef struct message_field {
    const char *key;
    field_kind kind;
    size_t offset;
    double least, most, fallback; /* fallback NAN: the field must be there */
    size_t count;
} message_field;

enum { FIELDS_MAX = 6 };

typedef struct message_form {
    const char *name;
    message_field fields[FIELDS_MAX];
} message_form;

#define AT(field) offsetof(view_request, field)
#define ANY_WHOLE 0.0, 4294967295.0
#define ANY_COUNT 0.0, 9007199254740991.0 /* 2^53 - 1: what a double tells exactly */
#define MUST ((double)NAN)

#define OBJECT                                                                                     \
    { "object", FIELD_WHOLE, AT(object), 0.0, 65535.0, MUST, 1 }
#define TRIANGLE                                                                                   \
    { "triangle", FIELD_WHOLE, AT(triangle), ANY_WHOLE, MUST, 1 }
#define WEIGHTS                                                                                    \
    { "weights", FIELD_NUMBERS, AT(weights), -1e-3, 1.001, MUST, 3 }
#define POINT                                                                                      \
    { "point", FIELD_NUMBERS, AT(point), -1e6, 1e6, MUST, 3 }
#define GRAB                                                                                       \
    { "grab", FIELD_WHOLE, AT(grab), ANY_WHOLE, MUST, 1 }

static const message_form forms[REQUEST_COUNT] = {
    [REQUEST_NONE] = {"", {{0}}},
    [REQUEST_FRAMES] = {"frames",
                        {{"from", FIELD_WHOLE, AT(from), ANY_WHOLE, MUST, 1},
                         {"count", FIELD_WHOLE, AT(count), ANY_WHOLE, 1.0, 1},
                         {"step", FIELD_WHOLE, AT(stride), 1.0, 1e6, 1.0, 1},
                         {"exact", FIELD_BOOL, AT(is_exact), 0.0, 1.0, 0.0, 1}}},
    [REQUEST_GOT] = {"got", {{"sequence", FIELD_WHOLE, AT(sequence), ANY_WHOLE, MUST, 1}}},
    [REQUEST_FOLLOW] = {"follow", {{"rate", FIELD_NUMBER, AT(rate), 0.0, 1000.0, 60.0, 1}}},
    [REQUEST_EXACT] = {"exact", {{0}}},
    [REQUEST_OVERLAYS] = {"overlays", {{"names", FIELD_OVERLAYS, AT(overlays), 0, 0, MUST, 1}}},
    [REQUEST_SERIES] = {"series",
                        {{"names", FIELD_SERIES, AT(columns), 0, 0, MUST, 1},
                         {"from", FIELD_COUNT, AT(from_step), ANY_COUNT, 0.0, 1},
                         {"to", FIELD_COUNT, AT(to_step), ANY_COUNT, 9007199254740991.0, 1},
                         {"buckets", FIELD_WHOLE, AT(buckets), 1.0, SERIES_BUCKET_MAX, 512.0, 1}}},
    [REQUEST_PICK] = {"pick",
                      {{"frame", FIELD_WHOLE, AT(frame), ANY_WHOLE, 4294967295.0, 1},
                       OBJECT,
                       TRIANGLE,
                       WEIGHTS}},
    [REQUEST_RUN] = {"run", {{"speed", FIELD_NUMBER, AT(speed), 0.0, 1000.0, 1.0, 1}}},
    [REQUEST_PAUSE] = {"pause", {{0}}},
    [REQUEST_STEP] = {"step", {{"count", FIELD_WHOLE, AT(count), 1.0, 1e6, 1.0, 1}}},
    [REQUEST_RESET] = {"reset", {{0}}},
    [REQUEST_REWIND] = {"rewind", {{"step", FIELD_COUNT, AT(step), ANY_COUNT, MUST, 1}}},
    [REQUEST_GRAB] = {"grab",
                      {OBJECT,
                       TRIANGLE,
                       WEIGHTS,
                       POINT,
                       {"force", FIELD_NUMBER, AT(force), 1e-9, 1e6, 2.0, 1},
                       {"grab", FIELD_WHOLE, AT(grab), ANY_WHOLE, 0.0, 1}}},
    [REQUEST_PINS] = {"pins", {OBJECT}},
    [REQUEST_DRAG] = {"drag", {GRAB, POINT}},
    [REQUEST_LET_GO] = {"let_go", {GRAB}},
    [REQUEST_CUT_PIN] = {"cut_pin",
                         {OBJECT, {"vertex", FIELD_WHOLE, AT(vertex), ANY_WHOLE, MUST, 1}}},
    [REQUEST_MOVE] = {"move",
                      {OBJECT,
                       {"position", FIELD_NUMBERS, AT(position), -1e6, 1e6, MUST, 3},
                       {"rotation", FIELD_NUMBERS, AT(rotation), -1.001, 1.001, MUST, 4},
                       {"force", FIELD_NUMBER, AT(force), 1e-9, 1e6, 100.0, 1}}},
    [REQUEST_SET] = {"set",
                     {{"what", FIELD_WHAT, AT(what), 0, 0, MUST, 1},
                      {"object", FIELD_WHOLE, AT(object), 0.0, 65535.0, 0.0, 1},
                      {"value", FIELD_VALUE, AT(values), -1e6, 1e6, MUST, REQUEST_VALUES_MAX}}},
    [REQUEST_SAVE_SESSION] = {"save_session", {{0}}},
    [REQUEST_TEXT] = {"text", {{0}}},
    [REQUEST_CHECK] = {"check", {{"text", FIELD_TEXT, AT(text), 0, 0, MUST, 1}}},
    [REQUEST_SAVE] = {"save", {{"text", FIELD_TEXT, AT(text), 0, 0, MUST, 1}}},
    [REQUEST_SCHEMA] = {"schema", {{0}}},
    [REQUEST_EXAMPLES] = {"examples", {{0}}},
    [REQUEST_EXAMPLE] = {"example", {{"name", FIELD_NAME, AT(name), 0, 0, MUST, 1}}},
};

static const char *const setting_names[SETTING_COUNT] = {"gravity", "wind", "gusts", "material",
                                                         "friction"};

/* ---- reading ---- */

typedef struct field_work {
    const json_document *document;
    const message_field *field;
    const json_value *value;
    view_request *request;
    char *reason;
} field_work;

static bool refuse(const field_work *work, const char *wanted) {
    snprintf(work->reason, REASON_SIZE, "%s: must be %s", work->field->key, wanted);
    return false;
}

static bool read_number(const field_work *work, const json_value *value, double *number) {
    const message_field *const field = work->field;
    bool const is_whole = field->kind == FIELD_WHOLE || field->kind == FIELD_COUNT;
    if (value->type != JSON_NUMBER || !(value->number >= field->least) ||
        !(value->number <= field->most) || (is_whole && floor(value->number) != value->number)) {
        snprintf(work->reason, REASON_SIZE, "%s: must be a %snumber from %g to %g", field->key,
                 is_whole ? "whole " : "", field->least, field->most);
        return false;
    }
    *number = value->number;
    return true;
}

static bool read_numbers(const field_work *work, double *numbers, size_t *count) {
    if (work->value->type != JSON_ARRAY || work->value->count > work->field->count ||
        work->value->count == 0)
        return refuse(work, "a list of numbers of the right length");
    *count = 0;
    for (const json_value *item = json_get_first(work->document, work->value); item;
         item = json_get_next(work->document, item))
        if (!read_number(work, item, &numbers[(*count)++])) return false;
    return true;
}

/* Names are those of presets and examples, which are plain. */
static bool read_name(const field_work *work, const json_value *value) {
    bool is_good = value->type == JSON_STRING && strlen(value->string) < REQUEST_NAME_SIZE;
    for (const char *c = is_good ? value->string : ""; *c; c++) is_good &= *c >= ' ' && *c <= '~';
    if (!is_good) return refuse(work, "a short name");
    snprintf(work->request->name, REQUEST_NAME_SIZE, "%s", value->string);
    return true;
}

static bool read_text(const field_work *work) {
    if (work->value->type != JSON_STRING) return refuse(work, "a text");
    memory heap = memory_default();
    view_request *const request = work->request;
    request->text_length = strlen(work->value->string);
    request->text = memory_allocate(&heap, request->text_length + 1);
    if (!request->text) return refuse(work, "shorter: there is no memory for it");
    memcpy(request->text, work->value->string, request->text_length + 1);
    return true;
}

static bool read_names(const field_work *work) {
    if (work->value->type != JSON_ARRAY) return refuse(work, "a list of names");
    for (const json_value *item = json_get_first(work->document, work->value); item;
         item = json_get_next(work->document, item)) {
        if (item->type != JSON_STRING) return refuse(work, "a list of names");
        bool const is_overlay = work->field->kind == FIELD_OVERLAYS;
        int const limit = is_overlay ? OVERLAY_COUNT : SERIES_COUNT;
        int const number =
            is_overlay ? (int)overlays_find(item->string) : series_find(item->string);
        if (number == limit) {
            snprintf(work->reason, REASON_SIZE, "%s: there is no \"%.60s\"", work->field->key,
                     item->string);
            text_hide_controls(work->reason);
            return false;
        }
        if (is_overlay)
            work->request->overlays |= 1u << number;
        else
            work->request->columns |= UINT64_C(1) << number;
    }
    return true;
}

static bool read_what(const field_work *work) {
    for (int k = 0; k < SETTING_COUNT && work->value->type == JSON_STRING; k++)
        if (strcmp(work->value->string, setting_names[k]) == 0) {
            work->request->what = (setting_kind)k;
            return true;
        }
    return refuse(work, "gravity, wind, gusts, material or friction");
}

static bool read_value(const field_work *work) {
    view_request *const request = work->request;
    if (work->value->type == JSON_STRING) return read_name(work, work->value);
    if (work->value->type == JSON_NUMBER) {
        request->value_count = 1;
        return read_number(work, work->value, request->values);
    }
    size_t count = 0;
    if (!read_numbers(work, request->values, &count)) return false;
    request->value_count = (uint32_t)count;
    return true;
}

static bool read_field(const field_work *work) {
    void *const place = (char *)work->request + work->field->offset;
    double number = work->field->fallback;
    size_t count = 0;
    if (!work->value && isnan(number)) return refuse(work, "given");
    switch (work->field->kind) {
    case FIELD_WHOLE:
        if (work->value && !read_number(work, work->value, &number)) return false;
        *(uint32_t *)place = (uint32_t)number;
        return true;
    case FIELD_COUNT:
        if (work->value && !read_number(work, work->value, &number)) return false;
        *(uint64_t *)place = (uint64_t)number;
        return true;
    case FIELD_NUMBER:
        if (work->value && !read_number(work, work->value, &number)) return false;
        *(double *)place = number;
        return true;
    case FIELD_BOOL:
        if (work->value && work->value->type != JSON_BOOL) return refuse(work, "true or false");
        *(bool *)place = work->value && work->value->number != 0.0;
        return true;
    case FIELD_NUMBERS:
        if (!read_numbers(work, place, &count)) return false;
        return count == work->field->count || refuse(work, "a list of the right length");
    case FIELD_NAME: return read_name(work, work->value);
    case FIELD_TEXT: return read_text(work);
    case FIELD_OVERLAYS:
    case FIELD_SERIES: return read_names(work);
    case FIELD_WHAT: return read_what(work);
    case FIELD_VALUE: return read_value(work);
    }
    return false;
}

/* What several fields say together. */
static bool check_whole(const view_request *request, char *reason) {
    if (request->type == REQUEST_MOVE) {
        double norm = 0.0;
        for (int k = 0; k < 4; k++) norm += request->rotation[k] * request->rotation[k];
        norm = sqrt(norm);
        if (!(fabs(norm - 1.0) <= 1e-3)) {
            snprintf(reason, REASON_SIZE, "rotation: must be a unit quaternion");
            return false;
        }
    }
    if (request->type == REQUEST_PICK || request->type == REQUEST_GRAB) {
        double const sum = request->weights[0] + request->weights[1] + request->weights[2];
        if (!(fabs(sum - 1.0) <= 1e-2)) {
            snprintf(reason, REASON_SIZE, "weights: must add up to 1");
            return false;
        }
    }
    if (request->type != REQUEST_SET) return true;
    static const uint32_t counts[SETTING_COUNT] = {3, 3, 1, 0, 1};
    bool const has_name = request->name[0] != '\0';
    double const value = request->values[0];
    bool const is_good = request->value_count == counts[request->what] &&
                         has_name == (request->what == SETTING_MATERIAL) &&
                         (request->what != SETTING_FRICTION || (value >= 0.0 && value <= 10.0)) &&
                         (request->what != SETTING_GUSTS || value >= 0.0);
    if (!is_good)
        snprintf(reason, REASON_SIZE,
                 "value: gravity and wind take three numbers, gusts a speed, friction a number "
                 "from 0 to 10, material the name of a preset");
    return is_good;
}

static bool read_id(const json_document *document, const json_value *root, view_request *request,
                    char *reason) {
    const json_value *const id = json_find(document, root, "id");
    if (!id) return true;
    if (id->type != JSON_NUMBER || !(id->number >= 0.0) || !(id->number <= 9007199254740991.0) ||
        floor(id->number) != id->number) {
        snprintf(reason, REASON_SIZE, "id: must be a whole number from 0 to 2^53 - 1");
        return false;
    }
    request->has_id = true;
    request->id = (uint64_t)id->number;
    return true;
}

static request_outcome read_members(const json_document *document, size_t length,
                                    view_request *request, char *reason) {
    const json_value *const root = json_get_root(document);
    const json_value *const type =
        root->type == JSON_OBJECT ? json_find(document, root, "type") : NULL;
    if (!type || type->type != JSON_STRING) {
        snprintf(reason, REASON_SIZE, "a message is a JSON object with a type");
        return REQUEST_BAD;
    }
    if (!read_id(document, root, request, reason)) return REQUEST_REFUSED;
    const message_form *form = NULL;
    for (int k = 1; k < REQUEST_COUNT && !form; k++)
        if (strcmp(type->string, forms[k].name) == 0) {
            form = &forms[k];
            request->type = (request_type)k;
        }
    bool const has_text = request->type == REQUEST_CHECK || request->type == REQUEST_SAVE;
    if (length > MESSAGE_SMALL_MAX && !has_text) {
        snprintf(reason, REASON_SIZE, "a message of this type has at most %d bytes",
                 MESSAGE_SMALL_MAX);
        return REQUEST_BAD;
    }
    if (!form) {
        snprintf(reason, REASON_SIZE, "there is no message of the type \"%.60s\"", type->string);
        text_hide_controls(reason);
        return REQUEST_REFUSED;
    }
    for (int k = 0; k < FIELDS_MAX && form->fields[k].key; k++) {
        const message_field *const field = &form->fields[k];
        field_work const work = {document, field, json_find(document, root, field->key), request,
                                 reason};
        if (!read_field(&work)) return REQUEST_REFUSED;
    }
    return check_whole(request, reason) ? REQUEST_READ : REQUEST_REFUSED;
}

request_outcome request_read(const char *text, size_t length, view_request *request,
                             char reason[REASON_SIZE]) {
    *request = (view_request){0};
    reason[0] = '\0';
    if (length > MESSAGE_TEXT_MAX) {
        snprintf(reason, REASON_SIZE, "a message has at most %d bytes", MESSAGE_TEXT_MAX);
        return REQUEST_BAD;
    }
    memory heap = memory_default();
    json_document document;
    tulle_error error = {0};
    if (json_read(&heap, "message", text, length, &document, &error) != TULLE_OK) {
        snprintf(reason, REASON_SIZE, "%.400s", error.message);
        return REQUEST_BAD;
    }
    request_outcome const outcome = read_members(&document, length, request, reason);
    json_destroy(&document);
    if (outcome != REQUEST_READ) request_release(request);
    return outcome;
}

void request_release(view_request *request) {
    memory heap = memory_default();
    if (request->text) memory_release(&heap, request->text, request->text_length + 1);
    request->text = NULL;
    request->text_length = 0;
}

/* ---- writing ---- */

static void write_field(const view_request *request, const message_field *field,
                        view_buffer *buffer) {
    const void *const place = (const char *)request + field->offset;
    switch (field->kind) {
    case FIELD_WHOLE: buffer_json_whole(buffer, field->key, *(const uint32_t *)place); break;
    case FIELD_COUNT: buffer_json_whole(buffer, field->key, *(const uint64_t *)place); break;
    case FIELD_BOOL: buffer_json_bool(buffer, field->key, *(const bool *)place); break;
    case FIELD_NUMBER: buffer_json_double(buffer, field->key, *(const double *)place); break;
    case FIELD_NUMBERS: buffer_json_doubles(buffer, field->key, place, field->count); break;
    case FIELD_WHAT: buffer_json_text(buffer, field->key, setting_names[request->what]); break;
    case FIELD_VALUE:
        if (request->name[0])
            buffer_json_text(buffer, field->key, request->name);
        else if (request->value_count == 1)
            buffer_json_double(buffer, field->key, request->values[0]);
        else
            buffer_json_doubles(buffer, field->key, request->values, request->value_count);
        break;
    case FIELD_NAME: buffer_json_text(buffer, field->key, request->name); break;
    case FIELD_TEXT: buffer_json_text(buffer, field->key, request->text); break;
    case FIELD_OVERLAYS:
    case FIELD_SERIES: break; /* of no command that is kept */
    }
}

void request_write(const view_request *request, view_buffer *buffer) {
    const message_form *const form = &forms[request->type];
    buffer_print(buffer, "\"type\":\"%s\"", form->name);
    for (int k = 0; k < FIELDS_MAX && form->fields[k].key; k++)
        write_field(request, &form->fields[k], buffer);
}
