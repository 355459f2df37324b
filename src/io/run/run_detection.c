/* io/run/run_detection.c - how a run found its pairs and answered contact, as run.json says it:
 * {"method": "patches", "cone": "bernstein", "alpha_max": 1.047, "certificate": true, "patches":
 * "keep"}; "response": "paper", "motion_space": "cone" (this only with paper). */
#include "base/words.h"
#include "io/run/run_record.h"

#include <string.h>

/* The name, or null: nothing is said of a value that has none. */
static const char *get_name(const char *const *names, unsigned index) {
    for (unsigned i = 0; names[i]; i++)
        if (i == index) return names[i];
    return NULL;
}

#define AT(key, kind, type, name)                                                                  \
    { key, JSON_##kind, offsetof(type, name) }
static const json_field detection_fields[] = {
    AT("alpha_max", DOUBLE, tulle_world_detection, max_angle),
    AT("certificate", FLAG, tulle_world_detection, has_certificate)};
static const json_field untangle_fields[] = {
    AT("intersections", COUNT, tulle_untangle_report, intersections),
    AT("rounds", WHOLE, tulle_untangle_report, rounds),
    AT("moved_vertices", COUNT, tulle_untangle_report, moved_vertices),
    AT("largest_displacement", DOUBLE, tulle_untangle_report, largest_displacement)};

void run_detection_write(json_writer *writer, const run_record *record) {
    const tulle_world_detection *const detection = &record->detection;
    if (!record->has_detection) return;
    json_begin(writer, "detection", '{');
    json_put_string(writer, "method", get_name(method_words, (unsigned)detection->method));
    json_put_string(writer, "cone", get_name(cone_words, (unsigned)detection->cone));
    json_put_fields(writer, detection_fields, 2, detection);
    json_put_string(writer, "patches", patches_words[detection->grows_patches_anew != 0]);
    json_end(writer, '}');
}

static tulle_status take_choice(const json_document *document, const json_value *object,
                                const char *key, const char *const *names, int *choice,
                                tulle_error *error) {
    const char *name = "";
    tulle_status const status = json_take_string(document, object, key, &name, error);
    if (status) return status;
    for (*choice = 0; names[*choice]; (*choice)++)
        if (strcmp(name, names[*choice]) == 0) return TULLE_OK;
    return json_fail(document, object, error, "\"%s\" is not known: \"%.40s\"", key, name);
}

tulle_status run_detection_read(run_record *record, const json_document *document,
                                const json_value *root, tulle_error *error) {
    const json_value *object = NULL;
    tulle_world_detection detection = {0};
    int method = 0, cone = 0;
    if (!json_find(document, root, "detection")) return TULLE_OK;
    tulle_status status =
        json_take_member(document, root, "detection", JSON_OBJECT, &object, error);
    if (!status) status = take_choice(document, object, "method", method_words, &method, error);
    if (!status) status = take_choice(document, object, "cone", cone_words, &cone, error);
    if (!status)
        status = json_take_fields(document, object, detection_fields, 2, &detection, error);
    if (!status)
        status = take_choice(document, object, "patches", patches_words,
                             &detection.grows_patches_anew, error);
    if (status) return status;
    detection.method = (tulle_detect_method)method;
    detection.cone = (tulle_detect_cone)cone;
    record->detection = detection;
    record->has_detection = true;
    return TULLE_OK;
}

void run_response_write(json_writer *writer, const run_record *record) {
    if (!record->has_response) return;
    json_put_string(writer, "response", get_name(response_words, (unsigned)record->response));
    if (record->response != TULLE_RESPONSE_PAPER) return;
    json_put_string(writer, "motion_space",
                    get_name(motion_space_words, (unsigned)record->motion_space));
}

tulle_status run_response_read(run_record *record, const json_document *document,
                               const json_value *root, tulle_error *error) {
    int response = 0, space = TULLE_MOTION_SPACE_POLYHEDRAL;
    if (!json_find(document, root, "response")) return TULLE_OK;
    tulle_status status = take_choice(document, root, "response", response_words, &response, error);
    if (!status && response == TULLE_RESPONSE_PAPER)
        status = take_choice(document, root, "motion_space", motion_space_words, &space, error);
    if (status) return status;
    record->response = (tulle_response)response;
    record->motion_space = (tulle_motion_space)space;
    record->has_response = true;
    return TULLE_OK;
}

void run_untangle_write(json_writer *writer, const run_record *record) {
    const tulle_untangle_report *const untangle = &record->untangle;
    if (!record->has_untangle || untangle->intersections == 0) return;
    json_begin(writer, "untangle", '{');
    json_put_fields(writer, untangle_fields, 4, untangle);
    json_end(writer, '}');
}

tulle_status run_untangle_read(run_record *record, const json_document *document,
                               const json_value *root, tulle_error *error) {
    if (!json_find(document, root, "untangle")) return TULLE_OK;
    tulle_untangle_report report = {0};
    const json_value *object = NULL;
    tulle_status status = json_take_member(document, root, "untangle", JSON_OBJECT, &object, error);
    if (!status) status = json_take_fields(document, object, untangle_fields, 4, &report, error);
    if (status) return status;
    record->has_untangle = true;
    record->untangle = report;
    return TULLE_OK;
}
