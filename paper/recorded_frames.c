/* recorded_frames.c - see recorded_frames.h. */
#include "recorded_frames.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { EXIT_BAD_INPUT = 2, EXIT_OUT_OF_MEMORY = 4 };
static const double DEGREE = 0.017453292519943295; /* [rad] */

void require(tulle_status status, const tulle_error *error) {
    if (status == TULLE_OK) return;
    fputs("paper_measure: ", stderr);
    if (error->file[0]) fprintf(stderr, "%s: ", error->file);
    if (error->line > 0) fprintf(stderr, "line %u: ", (unsigned)error->line);
    fprintf(stderr, "%s\n", error->message);
    exit(status == TULLE_ERROR_OUT_OF_MEMORY ? EXIT_OUT_OF_MEMORY : EXIT_BAD_INPUT);
}

void *require_memory(size_t bytes) {
    void *const block = malloc(bytes > 0 ? bytes : 1);
    if (block) return block;
    fputs("paper_measure: out of memory\n", stderr);
    exit(EXIT_OUT_OF_MEMORY);
}

static bool takes_part(const recorded_frames *frames, size_t body, bool has_obstacles) {
    if (!frames->info->bodies[body].is_obstacle) return true;
    return has_obstacles && tulle_run_reader_is_present(frames->reader, 0, body) &&
           tulle_run_reader_is_present(frames->reader, frames->info->frame_count - 1, body);
}

/* Surfaces one behind the other. */
static void choose_surfaces(recorded_frames *frames, bool has_obstacles) {
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

static void copy_meshes(recorded_frames *frames) {
    tulle_error error = {0};
    for (size_t s = 0; s < frames->surface_count; s++) {
        const tulle_detect_surface *const surface = &frames->surfaces[s];
        tulle_mesh_view mesh;
        require(tulle_run_reader_get_mesh(frames->reader, frames->bodies[s], &mesh, &error),
                &error);
        memcpy(frames->rest + 3 * (size_t)surface->vertex_begin, mesh.positions,
               3 * mesh.vertex_count * sizeof(double));
        for (size_t i = 0; i < 3 * mesh.triangle_count; i++)
            frames->triangles[3 * (size_t)surface->triangle_begin + i] =
                surface->vertex_begin + mesh.triangles[i];
    }
}

void recorded_frames_open(const char *directory, bool has_obstacles, recorded_frames *frames) {
    tulle_error error = {0};
    *frames = (recorded_frames){0};
    require(tulle_run_reader_open(directory, &frames->reader, &error), &error);
    frames->info = tulle_run_reader_get_info(frames->reader);
    if (frames->info->frame_count < 2) {
        fprintf(stderr, "paper_measure: %s holds fewer than two frames\n", directory);
        exit(EXIT_BAD_INPUT);
    }
    frames->bodies = require_memory(frames->info->body_count * sizeof *frames->bodies);
    frames->surfaces = require_memory(frames->info->body_count * sizeof *frames->surfaces);
    choose_surfaces(frames, has_obstacles);
    if (frames->surface_count == 0) {
        fprintf(stderr, "paper_measure: %s holds no cloth\n", directory);
        exit(EXIT_BAD_INPUT);
    }
    size_t const size = 3 * frames->vertex_count * sizeof(double);
    frames->rest = require_memory(size);
    frames->start = require_memory(size);
    frames->end = require_memory(size);
    frames->triangles = require_memory(3 * frames->triangle_count * sizeof *frames->triangles);
    copy_meshes(frames);
}

static void read_state(recorded_frames *frames, uint32_t frame, double *to) {
    tulle_error error = {0};
    for (size_t s = 0; s < frames->surface_count; s++)
        require(tulle_run_reader_read_positions(frames->reader, frame, frames->bodies[s],
                                                to + 3 * (size_t)frames->surfaces[s].vertex_begin,
                                                &error),
                &error);
}

void recorded_frames_read(recorded_frames *frames, uint32_t frame) {
    if (frame == frames->frame) return;
    if (frame < 1 || frame >= frames->info->frame_count) {
        fprintf(stderr, "paper_measure: there is no motion to frame %u; frames 1 to %u have one\n",
                (unsigned)frame, (unsigned)frames->info->frame_count - 1);
        exit(EXIT_BAD_INPUT);
    }
    read_state(frames, frame - 1, frames->start);
    read_state(frames, frame, frames->end);
    frames->frame = frame;
}

tulle_detect_def recorded_frames_get_def(const recorded_frames *frames, double distance,
                                         int threads) {
    tulle_detect_def def = tulle_detect_def_default();
    def.triangles = frames->triangles;
    def.triangle_count = frames->triangle_count;
    def.vertex_count = frames->vertex_count;
    def.rest = frames->rest;
    def.surfaces = frames->surfaces;
    def.surface_count = frames->surface_count;
    def.minimum_separation = distance;
    def.threads = threads;
    return def;
}

void recorded_frames_close(recorded_frames *frames) {
    free(frames->bodies);
    free(frames->surfaces);
    free(frames->triangles);
    free(frames->rest);
    free(frames->start);
    free(frames->end);
    tulle_run_reader_close(frames->reader);
    *frames = (recorded_frames){0};
}

tulle_detect_def use_paper_rules(tulle_detect_def def, double angle) {
    def.method = TULLE_DETECT_PAPER;
    def.cone = TULLE_CONE_PAPER;
    def.has_certificate = 0;
    def.max_angle = angle * DEGREE;
    return def;
}

tulle_detect_def use_proof(tulle_detect_def def, double angle) {
    def.method = TULLE_DETECT_PAPER;
    def.cone = TULLE_CONE_BERNSTEIN;
    def.has_certificate = 1;
    def.max_angle = angle * DEGREE;
    return def;
}
