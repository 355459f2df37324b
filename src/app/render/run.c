/* app/render/run.c - see run.h. */
#include "app/render/run.h"

#include "base/error.h"
#include "render/rest_coordinates.h"

#include "tulle_io/subdivision.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    VIEW_SAMPLES = 24, /* frames from which the view is found: motion between them is small */
    PATH_SIZE = 4200   /* [bytes] of the scene's path */
};

static tulle_status fail_memory(tulle_error *error) {
    return error_set(error, TULLE_ERROR_OUT_OF_MEMORY,
                     "out of memory for the surfaces; give fewer levels to --subdivide");
}

uint32_t picture_run_get_sample_count(const picture_run *run, uint32_t most) {
    uint32_t const count = frame_range_get_count(run->frames);
    return count < most ? count : most;
}

uint32_t picture_run_get_sample(const picture_run *run, uint32_t most, uint32_t index) {
    uint32_t const count = frame_range_get_count(run->frames);
    uint32_t const samples = count < most ? count : most;
    if (samples < 2) return frame_range_get(run->frames, 0);
    return frame_range_get(run->frames, (uint32_t)((uint64_t)index * (count - 1) / (samples - 1)));
}

/* ---- opening ---- */

/* The frames that are asked for; the last where nothing is said, all for a film. */
static tulle_status choose_frames(picture_run *run, tulle_error *error) {
    const picture_options *const options = run->options;
    if (run->info->frame_count == 0)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, options->directory, 0, 0,
                            "the run holds no whole frame yet, so there is nothing to show");
    picture_kind kind = PICTURE_STILL;
    tulle_status status = TULLE_OK;
    if (options->output) status = picture_find_kind(options->output, &kind, error);
    if (status != TULLE_OK) return status;
    bool const is_still = !options->frame && !options->frames && kind == PICTURE_STILL;
    frame_range const all = frame_range_make(run->info->frame_count);
    return frame_range_read(is_still ? "last" : options->frame, options->frames, all, &run->frames,
                            error);
}

/* What the run's scene file says about pictures. A run without one has the defaults. */
static tulle_status read_scene(picture_run *run, tulle_error *error) {
    run->picture = scene_picture_default();
    if (!run->info->scene_text) return TULLE_OK;
    char path[PATH_SIZE];
    int const length = snprintf(path, sizeof path, "%s/scene.yaml", run->options->directory);
    if (length < 0 || length >= PATH_SIZE) return TULLE_OK;
    tulle_scene_problems *const problems = calloc(1, sizeof *problems);
    if (!problems) return fail_memory(error);
    tulle_status const status = scene_read_picture(path, &run->picture, problems);
    if (status != TULLE_OK) {
        scene_print_problems(problems, stderr);
        error_set_at(error, status, path, 0, 0,
                     "the run's scene file cannot be used; mend it, or move it away to get "
                     "pictures by default");
    }
    free(problems);
    /* Copies may have been edited away: then no look is known to belong to a body. */
    if (run->picture.look_count != run->info->body_count) {
        double const exposure = run->picture.exposure;
        scene_camera const camera = run->picture.camera;
        scene_floor const floor = run->picture.floor;
        scene_picture_destroy(&run->picture);
        run->picture.camera = camera;
        run->picture.floor = floor;
        run->picture.exposure = exposure;
    }
    return status;
}

static tulle_status subdivide_body(picture_run *run, picture_body *body, tulle_error *error) {
    tulle_subdivision_def def = tulle_subdivision_def_default();
    def.levels = run->options->subdivision_levels;
    tulle_status const status =
        tulle_subdivision_create(body->rest, &def, &body->subdivision, error);
    if (status != TULLE_OK) return status;
    body->drawn.vertex_count = tulle_subdivision_get_vertex_count(body->subdivision);
    body->drawn.triangle_count = tulle_subdivision_get_triangle_count(body->subdivision);
    body->drawn.triangles = tulle_subdivision_get_triangles(body->subdivision);
    body->drawn_positions = ARENA_NEW(&run->storage, double, 3 * body->drawn.vertex_count);
    return body->drawn_positions ? TULLE_OK : fail_memory(error);
}

/* Where the cloth's vertices lie at rest, for its pattern. */
static tulle_status lay_out_body(picture_run *run, picture_body *body, tulle_error *error) {
    double *const coarse = ARENA_NEW(&run->storage, double, 2 * body->rest.vertex_count);
    if (!coarse) return fail_memory(error);
    tulle_status const status = render_make_rest_coordinates(&run->heap, body->rest, coarse, error);
    body->rest_coordinates = coarse;
    if (status != TULLE_OK || !body->subdivision) return status;
    body->rest_coordinates = ARENA_NEW(&run->storage, double, 2 * body->drawn.vertex_count);
    if (!body->rest_coordinates) return fail_memory(error);
    return tulle_subdivision_apply(body->subdivision, coarse, 2, body->rest_coordinates, error);
}

static tulle_status prepare_body(picture_run *run, size_t index, tulle_error *error) {
    picture_body *const body = &run->bodies[index];
    const tulle_run_body_info *const info = &run->info->bodies[index];
    *body = (picture_body){
        .name = info->name, .is_obstacle = info->is_obstacle != 0, .is_moving = !info->is_static};
    if (run->picture.looks) body->look = run->picture.looks[index];
    tulle_status status = tulle_run_reader_get_mesh(run->reader, index, &body->rest, error);
    if (status != TULLE_OK) return status;
    body->mesh = body->rest;
    if (body->is_moving) {
        body->positions = ARENA_NEW(&run->storage, double, 3 * body->rest.vertex_count + 1);
        if (!body->positions) return fail_memory(error);
        body->mesh.positions = body->positions;
    }
    body->drawn = body->mesh;
    if (body->is_obstacle) return TULLE_OK;
    run->cloth_count++;
    if (run->options->subdivision_levels > 0) {
        status = subdivide_body(run, body, error);
        if (status != TULLE_OK) return status;
        body->drawn.positions = body->drawn_positions;
    }
    return lay_out_body(run, body, error);
}

/* Whether `name` is the body's, or that of the obstacle whose copy it is: NAME.000, NAME.001 ... */
static bool is_named(const picture_body *body, const char *name) {
    size_t const length = strlen(name);
    if (strncmp(body->name, name, length) != 0) return false;
    const char *const rest = body->name + length;
    return !*rest ||
           (rest[0] == '.' && rest[1] && strspn(rest + 1, "0123456789") == strlen(rest + 1));
}

/* What the scene and the options leave out. */
static tulle_status hide_bodies(picture_run *run, tulle_error *error) {
    for (size_t i = 0; i < run->body_count; i++)
        run->bodies[i].is_hidden = run->bodies[i].look.is_hidden;
    const option_list *const names = &run->options->hidden;
    for (size_t k = 0; k < names->count; k++) {
        size_t count = 0;
        for (size_t i = 0; i < run->body_count; i++) {
            if (!is_named(&run->bodies[i], names->items[k])) continue;
            run->bodies[i].is_hidden = true;
            count++;
        }
        if (count == 0)
            return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, run->options->directory, 0, 0,
                                "--hide: no body is called \"%.60s\"; `tulle info` lists them",
                                names->items[k]);
    }
    return TULLE_OK;
}

static void measure_edges(picture_run *run) {
    double sum = 0.0;
    size_t count = 0;
    for (size_t i = 0; i < run->cloth_count; i++) {
        tulle_mesh_view const mesh = run->bodies[i].rest;
        for (size_t k = 0; k < 3 * mesh.triangle_count; k++, count++) {
            const double *const a = mesh.positions + 3 * (size_t)mesh.triangles[k];
            size_t const next = k - k % 3 + (k + 1) % 3;
            const double *const b = mesh.positions + 3 * (size_t)mesh.triangles[next];
            double const x = b[0] - a[0], y = b[1] - a[1], z = b[2] - a[2];
            sum += sqrt(x * x + y * y + z * z);
        }
    }
    run->edge_length = count > 0 ? sum / (double)count : 0.0;
}

/* ---- frames ---- */

tulle_status picture_run_read_frame(picture_run *run, uint32_t frame, tulle_error *error) {
    for (size_t i = 0; i < run->body_count; i++) {
        picture_body *const body = &run->bodies[i];
        body->is_present = tulle_run_reader_is_present(run->reader, frame, i) != 0;
        if (!body->is_present) continue;
        tulle_status status = TULLE_OK;
        if (body->is_moving)
            status = tulle_run_reader_read_positions(run->reader, frame, i, body->positions, error);
        if (status == TULLE_OK && body->subdivision)
            status = tulle_subdivision_apply(body->subdivision, body->mesh.positions, 3,
                                             body->drawn_positions, error);
        if (status != TULLE_OK) return status;
    }
    run->frame = frame;
    return TULLE_OK;
}

/* Boxes of everything over a sample of the frames give the view and the floor. */
static tulle_status survey(picture_run *run, tulle_error *error) {
    picture_view *const views = ARENA_NEW(&run->storage, picture_view, run->body_count + 1);
    if (!views) return fail_memory(error);
    for (size_t i = 0; i < run->body_count; i++) views[i] = picture_view_empty();
    uint32_t const count = picture_run_get_sample_count(run, VIEW_SAMPLES);
    for (uint32_t sample = 0; sample < count; sample++) {
        tulle_status const status =
            picture_run_read_frame(run, picture_run_get_sample(run, VIEW_SAMPLES, sample), error);
        if (status != TULLE_OK) return status;
        for (size_t i = 0; i < run->body_count; i++) {
            picture_body *const body = &run->bodies[i];
            if (body->is_present && !body->is_hidden)
                picture_view_add(&views[i], body->mesh.positions, body->mesh.vertex_count);
            body->is_ever_absent |= !body->is_present;
        }
    }
    double low = (double)INFINITY;
    run->view = picture_view_empty();
    for (size_t i = 0; i < run->cloth_count; i++) picture_view_join(&run->view, &views[i]);
    bool const has_cloth = !picture_bounds_is_empty(&run->view.bounds);
    for (size_t i = run->cloth_count; i < run->body_count && !has_cloth; i++)
        picture_view_join(&run->view, &views[i]); /* all cloths are hidden */
    picture_bounds const cloths = run->view.bounds;
    for (size_t i = run->cloth_count; i < run->body_count; i++)
        picture_view_add_obstacle(&run->view, &cloths, &views[i]);
    for (size_t i = 0; i < run->body_count; i++) low = fmin(low, views[i].bounds.low[2]);
    run->cloth_size = picture_bounds_get_diagonal(&cloths);
    picture_choose_floor(run, &cloths, low);
    return TULLE_OK;
}

tulle_status picture_run_open(picture_run *run, const picture_options *options,
                              tulle_error *error) {
    *run = (picture_run){.heap = memory_default(), .options = options, .floor_body = TULLE_NONE};
    run->storage = arena_make(&run->heap);
    tulle_status status = tulle_run_reader_open(options->directory, &run->reader, error);
    if (status != TULLE_OK) return status;
    run->info = tulle_run_reader_get_info(run->reader);
    status = choose_frames(run, error);
    if (status == TULLE_OK) status = read_scene(run, error);
    if (status != TULLE_OK) return status;
    run->bodies = ARENA_NEW_ZEROED(&run->storage, picture_body, run->info->body_count + 1);
    if (!run->bodies) return fail_memory(error);
    for (; run->body_count < run->info->body_count && status == TULLE_OK; run->body_count++)
        status = prepare_body(run, run->body_count, error);
    if (status == TULLE_OK) status = hide_bodies(run, error);
    if (status != TULLE_OK) return status;
    measure_edges(run);
    picture_dress_bodies(run);
    return survey(run, error);
}

void picture_run_close(picture_run *run) {
    for (size_t i = 0; i < run->body_count; i++)
        tulle_subdivision_destroy(run->bodies[i].subdivision);
    scene_picture_destroy(&run->picture);
    tulle_run_reader_close(run->reader);
    arena_destroy(&run->storage);
}
