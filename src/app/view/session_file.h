/* app/view/session_file.h - NAME.session: what was done by hand in a scene, line by line as JSON,
 * so that it can be repeated to the same bits, and read.
 *
 *   {"tulle_session":1,"program":"0.1.0","scene":"NAME.yaml","scene_hash":"..."}
 *   {"at":STEP,"type":"grab",...}          commands, as web/PROTOCOL.md has them
 *   {"at":STEP,"type":"end","hash":"..."}  of the state */
#ifndef TULLE_APP_VIEW_SESSION_FILE_H
#define TULLE_APP_VIEW_SESSION_FILE_H

#include "app/view/message.h"

#include "tulle_io/scene.h"

/* A line behind the first. */
typedef struct session_line {
    uint64_t at; /* steps made before it */
    bool is_end;
    uint64_t hash; /* of the end */
    view_request request;
} session_line;

void session_file_begin(const tulle_scene *scene, view_buffer *text);
void session_file_end(uint64_t step, uint64_t hash, view_buffer *text);
/* Writes NAME.session into the folder in which the program was started. */
tulle_status session_file_write(const tulle_scene *scene, const view_buffer *text,
                                tulle_error *error);
/* Member "file" of an answer. */
void session_file_write_name(const tulle_scene *scene, view_buffer *buffer);

/* Checks the first line against the scene; *rest is what follows. Errors: TULLE_ERROR_PARSE. */
tulle_status session_file_check(const char *text, const tulle_scene *scene, const char **rest,
                                tulle_error *error);
/* Reads a line and gives what follows it; null with an error. */
const char *session_file_read_line(const char *text, session_line *line, tulle_error *error);

#endif
