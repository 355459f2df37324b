/* app/run/left.c - the pairs of triangles for which a start was refused, as CSV, the deepest first.
 * A line has the names of the two objects, the number of the triangle in each, its three vertices,
 * how deep the triangles lie in each other, and where. */
#define _POSIX_C_SOURCE 200809L
#include "app/run/session.h"
#include "base/error.h"
#include "io/text/number.h"

#include "tulle_io/mesh_files.h"

#include <stdio.h>
#include <stdlib.h>

static const char *get_name(const run_session *session, uint32_t object) {
    size_t const cloth_count = session->built.cloth_count;
    return object < cloth_count
               ? tulle_scene_get_cloth_name(session->scene, object)
               : tulle_scene_get_obstacle_name(session->scene, object - cloth_count);
}

/* "sleeve",7,1,2,9 */
static void print_triangle(FILE *file, const run_session *session, uint32_t object,
                           uint32_t triangle) {
    size_t const cloth_count = session->built.cloth_count;
    tulle_mesh_view const mesh =
        object < cloth_count ? tulle_scene_get_cloth_mesh(session->scene, object)
                             : tulle_scene_get_obstacle_mesh(session->scene, object - cloth_count);
    const uint32_t *const corners = mesh.triangles + 3 * (size_t)triangle;
    fputc('"', file);
    for (const char *letter = get_name(session, object); *letter; letter++) {
        if (*letter == '"') fputc('"', file);
        fputc(*letter, file);
    }
    fprintf(file, "\",%u,%u,%u,%u", triangle, corners[0], corners[1], corners[2]);
}

tulle_status run_write_left(const run_session *session, tulle_error *error) {
    const char *const path = session->options.left_path;
    if (!path) return TULLE_OK;
    char *lines = NULL;
    size_t byte_count = 0;
    FILE *const file = open_memstream(&lines, &byte_count);
    size_t count = 0;
    const tulle_intersection *const pairs =
        tulle_world_get_intersections(session->built.world, &count);
    size_t overlap_count = 0;
    const tulle_overlap *const overlaps =
        tulle_world_get_overlaps(session->built.world, &overlap_count);
    if (file)
        fprintf(file, "object_a,triangle_a,a0,a1,a2,object_b,triangle_b,b0,b1,b2,depth,x,y,z\n");
    for (size_t i = 0; file && i < count && i < overlap_count; i++) {
        print_triangle(file, session, pairs[i].object_a, pairs[i].triangle_a);
        fputc(',', file);
        print_triangle(file, session, pairs[i].object_b, pairs[i].triangle_b);
        const double *const position = overlaps[i].position;
        const double numbers[] = {overlaps[i].depth, position[0], position[1], position[2]};
        for (int k = 0; k < 4; k++) {
            char text[NUMBER_TEXT_SIZE];
            number_format_double(numbers[k], text);
            fprintf(file, ",%s", text);
        }
        fputc('\n', file);
    }
    bool const is_whole = file && !ferror(file);
    tulle_status const status = file && fclose(file) == 0 && is_whole
                                    ? tulle_file_write(path, lines, byte_count, error)
                                    : error_set_at(error, TULLE_ERROR_OUT_OF_MEMORY, path, 0, 0,
                                                   "out of memory for the pairs that intersect");
    free(lines);
    return status;
}
