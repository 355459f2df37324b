/* scene/problems.c - collecting what is wrong with a scene. */
#include "scene/problems.h"

#include "base/error.h"
#include "base/text.h"

#include <stdarg.h>
#include <string.h>

static tulle_error *problem_next(tulle_scene_problems *problems) {
    problems->total_count++;
    if (problems->count == TULLE_SCENE_PROBLEMS_MAX) return NULL;
    return &problems->list[problems->count++];
}

tulle_status problem_add(tulle_scene_problems *problems, tulle_status status, scene_place place,
                         const char *format, ...) {
    tulle_error *error = problem_next(problems);
    if (!error) return status;
    va_list arguments;
    va_start(arguments, format);
    char message[sizeof error->message];
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    return error_set_at(error, status, place.file, place.line, place.column, "%s", message);
}

tulle_status problem_add_error(tulle_scene_problems *problems, scene_place place, const char *path,
                               const tulle_error *error) {
    if (!error->file[0])
        return problem_add(problems, error->status, place, "%s: %s", path, error->message);
    scene_place file = {error->file, error->line, error->column};
    if (place.line > 0)
        return problem_add(problems, error->status, file, "%s (read for %s, %s:%d:%d)",
                           error->message, path, place.file, place.line, place.column);
    return problem_add(problems, error->status, file, "%s (read for %s, %s)", error->message, path,
                       place.file);
}

tulle_status problem_add_memory(tulle_scene_problems *problems, const char *file) {
    return problem_add(problems, TULLE_ERROR_OUT_OF_MEMORY, (scene_place){file, 0, 0},
                       "out of memory while loading the scene");
}

void scene_print_problems(const tulle_scene_problems *problems, FILE *stream) {
    for (size_t i = 0; i < problems->count; i++) {
        const tulle_error *error = &problems->list[i];
        char file[sizeof error->file];
        memcpy(file, error->file, sizeof file);
        text_hide_controls(file);
        if (file[0]) fprintf(stream, "%s:", file);
        if (error->line > 0) fprintf(stream, "%d:", error->line);
        if (error->line > 0 && error->column > 0) fprintf(stream, "%d:", error->column);
        fprintf(stream, "%s%s\n", error->file[0] ? " " : "", error->message);
    }
    if (problems->total_count > problems->count)
        fprintf(stream, "and %zu more problems\n", problems->total_count - problems->count);
}

shown_text show_text(const char *text) {
    enum { longest = 60 };
    shown_text shown;
    size_t length = 0;
    for (; text[length] && length < longest; length++) shown.text[length] = text[length];
    shown.text[length] = '\0';
    if (text[length]) {
        text_drop_cut_character(shown.text);
        strcat(shown.text, "...");
    }
    text_hide_controls(shown.text);
    return shown;
}
