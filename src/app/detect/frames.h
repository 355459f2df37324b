/* app/detect/frames.h - the two states of a surface between which `tulle detect` looks. */
#ifndef TULLE_APP_DETECT_FRAMES_H
#define TULLE_APP_DETECT_FRAMES_H

#include "tulle/mesh.h"

/* Both meshes have the same number of vertices and the same triangles in the same order. */
typedef struct detect_frames {
    tulle_mesh start, end;
} detect_frames;

/* Reads both by their names, which end in .obj, .ply or .vtp; one without triangles is refused,
 * any other triangles are taken. Two that do not belong together are refused with the first
 * difference. Errors: those of mesh_file_read; TULLE_ERROR_UNSUPPORTED, TULLE_ERROR_INVALID_MESH.
 */
tulle_status detect_frames_read(const char *start_path, const char *end_path, detect_frames *frames,
                                tulle_error *error);
/* How many pairs of triangles intersect in the start, by the judge; DETECT_CROSSINGS_MAX + 1 when
 * they are more. */
#define DETECT_CROSSINGS_MAX ((uint64_t)1 << 26)
tulle_status detect_frames_count_crossings(const detect_frames *frames, int threads,
                                           uint64_t *count, tulle_error *error);
void detect_frames_destroy(detect_frames *frames);

#endif
