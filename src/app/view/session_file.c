/* app/view/session_file.c - see session_file.h. */
#define _POSIX_C_SOURCE 200809L
#include "app/view/session_file.h"

#include "base/error.h"
#include "base/memory.h"
#include "io/text/json_read.h"

#include "tulle_io/mesh_files.h"

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

enum { NAME_SIZE = 300, LINE_MAX_BYTES = MESSAGE_SMALL_MAX };

static const char *find_file_name(const tulle_scene *scene) {
    const char *const path = tulle_scene_get_path(scene);
    const char *const slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

static void make_name(const tulle_scene *scene, char name[NAME_SIZE]) {
    const char *const file = find_file_name(scene), *const dot = strrchr(file, '.');
    int const length = dot && dot != file ? (int)(dot - file) : (int)strlen(file);
    snprintf(name, NAME_SIZE, "%.*s.session", length < 250 ? length : 250, file);
}

void session_file_begin(const tulle_scene *scene, view_buffer *text) {
    buffer_print(text, "{\"tulle_session\":1");
    buffer_json_text(text, "program", tulle_version());
    buffer_json_text(text, "scene", find_file_name(scene));
    buffer_print(text, ",\"scene_hash\":\"%016llx\"}\n",
                 (unsigned long long)tulle_scene_get_hash(scene));
}

void session_file_end(uint64_t step, uint64_t hash, view_buffer *text) {
    buffer_print(text, "{\"at\":%llu,\"type\":\"end\",\"hash\":\"%016llx\"}\n",
                 (unsigned long long)step, (unsigned long long)hash);
}

tulle_status session_file_write(const tulle_scene *scene, const view_buffer *text,
                                tulle_error *error) {
    char name[NAME_SIZE];
    make_name(scene, name);
    struct stat facts;
    if (lstat(name, &facts) == 0 && S_ISLNK(facts.st_mode))
        return error_set_at(error, TULLE_ERROR_IO, name, 0, 0,
                            "is a symbolic link; a session is not written through links. Remove "
                            "it, or start the program in another folder");
    return tulle_file_write(name, buffer_get(text), text->count, error);
}

void session_file_write_name(const tulle_scene *scene, view_buffer *buffer) {
    char name[NAME_SIZE];
    make_name(scene, name);
    buffer_json_text(buffer, "file", name);
}

/* ---- reading ---- */

/* A line as JSON; `*rest` is what follows it. */
static tulle_status read_json(memory *heap, const char *text, const char **rest,
                              json_document *document, tulle_error *error) {
    const char *const end = strchr(text, '\n');
    size_t const length = end ? (size_t)(end - text) : strlen(text);
    if (length == 0)
        return error_set(error, TULLE_ERROR_PARSE, "the session ends without its last line");
    if (length > LINE_MAX_BYTES)
        return error_set(error, TULLE_ERROR_PARSE, "a line of the session is too long");
    *rest = end ? end + 1 : text + length;
    return json_read(heap, "session", text, length, document, error);
}

tulle_status session_file_check(const char *text, const tulle_scene *scene, const char **rest,
                                tulle_error *error) {
    memory heap = memory_default();
    json_document document;
    tulle_status status = read_json(&heap, text, rest, &document, error);
    if (status != TULLE_OK) return status;
    const json_value *const root = json_get_root(&document);
    uint32_t version = 0;
    uint64_t hash = 0;
    status = root->type == JSON_OBJECT
                 ? json_take_whole(&document, root, "tulle_session", &version, error)
                 : error_set(error, TULLE_ERROR_PARSE, "this is not a session");
    if (status == TULLE_OK && version != 1)
        status = error_set(error, TULLE_ERROR_PARSE, "a session of another version");
    if (status == TULLE_OK) status = json_take_hash(&document, root, "scene_hash", &hash, error);
    if (status == TULLE_OK && hash != tulle_scene_get_hash(scene))
        status = error_set(error, TULLE_ERROR_PARSE,
                           "the session is of another scene, or the scene has changed since");
    json_destroy(&document);
    return status;
}

static tulle_status read_end(const json_document *document, const json_value *root,
                             session_line *line, tulle_error *error) {
    line->is_end = true;
    return json_take_hash(document, root, "hash", &line->hash, error);
}

const char *session_file_read_line(const char *text, session_line *line, tulle_error *error) {
    memory heap = memory_default();
    json_document document;
    const char *rest = NULL, *type = NULL;
    *line = (session_line){0};
    if (read_json(&heap, text, &rest, &document, error) != TULLE_OK) return NULL;
    const json_value *const root = json_get_root(&document);
    tulle_status status = root->type == JSON_OBJECT
                              ? json_take_count(&document, root, "at", &line->at, error)
                              : error_set(error, TULLE_ERROR_PARSE, "a line is not a JSON object");
    if (status == TULLE_OK) status = json_take_string(&document, root, "type", &type, error);
    bool const is_end = status == TULLE_OK && strcmp(type, "end") == 0;
    if (is_end) status = read_end(&document, root, line, error);
    json_destroy(&document);
    if (status != TULLE_OK) return NULL;
    if (is_end) return rest;
    const char *const end = strchr(text, '\n');
    char reason[REASON_SIZE];
    if (request_read(text, end ? (size_t)(end - text) : strlen(text), &line->request, reason) !=
        REQUEST_READ) {
        error_set(error, TULLE_ERROR_PARSE, "%s", reason);
        return NULL;
    }
    request_release(&line->request); /* no command that is kept has a text */
    return rest;
}
