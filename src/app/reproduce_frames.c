/* app/reproduce_frames.c - consecutive recorded frames of a run as the two states between which the
 * detector looks, with the contact distance of the run as the separation. */
#include "app/reproduce.h"
#include "base/error.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

static const double DEGREE = 0.017453292519943295; /* [rad] */

static bool takes_part(const reproduce_frames *frames, size_t body, bool has_obstacles) {
    if (!frames->info->bodies[body].is_obstacle) return true;
    return has_obstacles && tulle_run_reader_is_present(frames->reader, 0, body) &&
           tulle_run_reader_is_present(frames->reader, frames->info->frame_count - 1, body);
}

/* Surfaces one behind the other. */
static void choose_surfaces(reproduce_frames *frames, bool has_obstacles) {
    for (size_t i = 0; i < frames->info->body_count; i++) {
        if (!takes_part(frames, i, has_obstacles)) continue;
        const tulle_run_body_info *const body = &frames->info->bodies[i];
        frames->bodies[frames->surface_count] = i;
        frames->surfaces[frames->surface_count++] = (tulle_detect_surface){
            .vertex_begin = (uint32_t)frames->vertex_count,
            .vertex_end = (uint32_t)frames->vertex_count + body->vertex_count,
            .triangle_begin = (uint32_t)frames->triangle_count,
            .triangle_end = (uint32_t)frames->triangle_count + body->triangle_count,
            .is_obstacle = body->is_obstacle,
            .is_static = body->is_static};
        frames->vertex_count += body->vertex_count;
        frames->triangle_count += body->triangle_count;
    }
}

static tulle_status copy_meshes(reproduce_frames *frames, tulle_error *error) {
    for (size_t s = 0; s < frames->surface_count; s++) {
        const tulle_detect_surface *const surface = &frames->surfaces[s];
        tulle_mesh_view mesh;
        tulle_status const status =
            tulle_run_reader_get_mesh(frames->reader, frames->bodies[s], &mesh, error);
        if (status != TULLE_OK) return status;
        memcpy(frames->rest + 3 * (size_t)surface->vertex_begin, mesh.positions,
               3 * mesh.vertex_count * sizeof(double));
        for (size_t i = 0; i < 3 * mesh.triangle_count; i++)
            frames->triangles[3 * (size_t)surface->triangle_begin + i] =
                surface->vertex_begin + mesh.triangles[i];
    }
    return TULLE_OK;
}

tulle_status reproduce_frames_open(const reproduce *self, const reproduce_run *run,
                                   bool has_obstacles, reproduce_frames *frames,
                                   tulle_error *error) {
    char path[REPRODUCE_PATH_SIZE];
    *frames = (reproduce_frames){0};
    reproduce_find_run(self, run, path);
    tulle_status status = tulle_run_reader_open(path, &frames->reader, error);
    if (status != TULLE_OK) return status;
    frames->info = tulle_run_reader_get_info(frames->reader);
    if (frames->info->frame_count < 2)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "%s holds fewer than two frames",
                         path);
    frames->bodies = calloc(frames->info->body_count, sizeof *frames->bodies);
    frames->surfaces = calloc(frames->info->body_count, sizeof *frames->surfaces);
    if (frames->bodies && frames->surfaces) choose_surfaces(frames, has_obstacles);
    size_t const size = 3 * frames->vertex_count * sizeof(double) + 1;
    frames->rest = malloc(size);
    frames->start = malloc(size);
    frames->end = malloc(size);
    frames->triangles = malloc(3 * frames->triangle_count * sizeof *frames->triangles + 1);
    bool const has_memory = frames->bodies && frames->surfaces && frames->rest && frames->start &&
                            frames->end && frames->triangles;
    if (has_memory && frames->surface_count == 0)
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "%s holds no cloth", path);
    if (!has_memory)
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory for two frames of %s", path);
    status = copy_meshes(frames, error);
    if (status != TULLE_OK) return status;
    return reproduce_find_distance(self, run, &frames->distance, error);
}

static tulle_status read_state(reproduce_frames *frames, uint32_t frame, double *to,
                               tulle_error *error) {
    tulle_status status = TULLE_OK;
    for (size_t s = 0; s < frames->surface_count && status == TULLE_OK; s++)
        status = tulle_run_reader_read_positions(frames->reader, frame, frames->bodies[s],
                                                 to + 3 * (size_t)frames->surfaces[s].vertex_begin,
                                                 error);
    return status;
}

tulle_status reproduce_frames_read(reproduce_frames *frames, uint32_t frame, tulle_error *error) {
    tulle_status const status = read_state(frames, frame - 1, frames->start, error);
    return status != TULLE_OK ? status : read_state(frames, frame, frames->end, error);
}

tulle_detect_def reproduce_frames_get_def(const reproduce *self, const reproduce_frames *frames) {
    tulle_detect_def def = tulle_detect_def_default();
    def.triangles = frames->triangles;
    def.triangle_count = frames->triangle_count;
    def.vertex_count = frames->vertex_count;
    def.rest = frames->rest;
    def.surfaces = frames->surfaces;
    def.surface_count = frames->surface_count;
    def.minimum_separation = frames->distance;
    def.threads = self->threads;
    return def;
}

void reproduce_frames_close(reproduce_frames *frames) {
    free(frames->bodies);
    free(frames->surfaces);
    free(frames->triangles);
    free(frames->rest);
    free(frames->start);
    free(frames->end);
    tulle_run_reader_close(frames->reader);
    *frames = (reproduce_frames){0};
}

tulle_detect_def reproduce_use_paper_rules(tulle_detect_def def, double angle) {
    def.method = TULLE_DETECT_PAPER;
    def.cone = TULLE_CONE_PAPER;
    def.has_certificate = 0;
    def.max_angle = angle * DEGREE;
    return def;
}

tulle_detect_def reproduce_use_proof(tulle_detect_def def, double angle) {
    def.method = TULLE_DETECT_PAPER;
    def.cone = TULLE_CONE_BERNSTEIN;
    def.has_certificate = 1;
    def.max_angle = angle * DEGREE;
    return def;
}

uint32_t reproduce_find_stride(uint32_t frame_count, uint32_t most) {
    return frame_count <= most ? 1 : (frame_count - 2) / most + 1;
}

uint32_t reproduce_count_looks(uint32_t frame_count, uint32_t most) {
    return frame_count < 2 ? 0 : (frame_count - 2) / reproduce_find_stride(frame_count, most) + 1;
}

void reproduce_frames_describe(const reproduce_frames *frames, char text[REPRODUCE_TEXT_SIZE]) {
    uint64_t hash = 0;
    uint32_t const count = frames->info->frame_count;
    (void)tulle_run_reader_get_frame(frames->reader, count - 1, NULL, NULL, &hash);
    snprintf(text, REPRODUCE_TEXT_SIZE,
             "scene %016" PRIx64 " frames %u last %016" PRIx64 " distance %.17g",
             frames->info->scene_hash, (unsigned)count, hash, frames->distance);
}
