/* app/cli/mesh_file.c - see mesh_file.h. */
#include "app/cli/mesh_file.h"

#include "app/commands.h"
#include "app/convert/names.h"

#include <stdio.h>

enum { NOTES_MAX = 3 };

tulle_status mesh_file_read(const char *path, tulle_mesh *mesh, tulle_mesh_source *source,
                            tulle_error *error) {
    if (convert_get_format(path) != CONVERT_VTP)
        return tulle_mesh_read_source(path, mesh, source, error);
    tulle_vtp_passed_over passed = {0};
    tulle_status const status = tulle_vtp_read(path, mesh, &passed, error);
    if (!source) return status;
    *source = (tulle_mesh_source){0};
    unsigned long long const cells = passed.vertex_cells, lines = passed.lines;
    size_t length = 0;
    if (cells > 0 && lines > 0)
        length = (size_t)snprintf(source->note, sizeof source->note,
                                  "passed over: %llu vertex cells, %llu lines", cells, lines);
    else if (cells > 0 || lines > 0)
        length = (size_t)snprintf(source->note, sizeof source->note, "passed over: %llu %s",
                                  cells + lines, cells > 0 ? "vertex cells" : "lines");
    if (passed.polygons[0])
        snprintf(source->note + length, sizeof source->note - length, "%s%s",
                 length > 0 ? "; " : "", passed.polygons);
    source->has_passed_shape = passed.polygons[0] != '\0';
    return status;
}

tulle_status mesh_file_read_noted(const char *path, mesh_file_notes *notes, tulle_mesh *mesh,
                                  tulle_error *error) {
    tulle_mesh_source source = {0};
    tulle_status const status = mesh_file_read(path, mesh, &source, error);
    if (status != TULLE_OK) return status;
    if (source.has_passed_shape && notes->count++ < NOTES_MAX)
        app_print_message(notes->command, "%s: %s", path, source.note);
    tulle_mesh_source_destroy(&source);
    return TULLE_OK;
}

void mesh_file_finish_notes(const mesh_file_notes *notes) {
    if (notes->count <= NOTES_MAX) return;
    size_t const more = notes->count - NOTES_MAX;
    app_print_message(notes->command, "... and something was passed over in %zu more %s", more,
                      more == 1 ? "file" : "files");
}
