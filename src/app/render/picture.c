/* app/render/picture.c - see picture.h. */
#include "app/render/picture.h"

#include "base/error.h"
#include "base/hash.h"
#include "render/overlay.h"

#include <stdio.h>
#include <string.h>

enum { RENDER_REVISION = 1 /* of pictures: another one where the same input looks different */ };
static const char *const DIGEST_KEY = "tulle-digest";

tulle_status picture_maker_open(picture_maker *maker, picture_run *run, tulle_error *error) {
    *maker = (picture_maker){.heap = memory_default(), .run = run};
    const picture_options *const options = run->options;
    size_t const value_count = 3 * (size_t)options->width * options->height;
    arena *const storage = &run->storage;
    maker->radiance = ARENA_NEW(storage, float, value_count);
    maker->surfaces = ARENA_NEW_ZEROED(storage, render_surface, run->body_count + 1);
    maker->drawn = ARENA_NEW_ZEROED(storage, tulle_check_body, run->body_count + 1);
    maker->simulated = ARENA_NEW_ZEROED(storage, tulle_check_body, run->body_count + 1);
    maker->names = ARENA_NEW_ZEROED(storage, const char *, run->body_count + 1);
    if (!maker->radiance || !maker->surfaces || !maker->drawn || !maker->simulated || !maker->names)
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY,
                         "out of memory for a picture of %ux%u pixels", options->width,
                         options->height);
    tulle_status status =
        render_image_create(options->width, options->height, &maker->image, error);
    if (status == TULLE_OK) status = render_context_create(&maker->context, error);
    if (status == TULLE_OK) status = picture_explanation_open(&maker->explanation, run, error);
    return status;
}

void picture_maker_close(picture_maker *maker) {
    picture_explanation_close(&maker->explanation);
    render_context_destroy(maker->context);
    render_image_destroy(&maker->image);
}

/* ---- digests ---- */

static uint64_t hash_doubles(uint64_t hash, const double *values, size_t count) {
    return hash_bytes(hash, values, count * sizeof *values);
}

static uint64_t hash_floats(uint64_t hash, const float *values, size_t count) {
    return values ? hash_bytes(hash, values, count * sizeof *values) : hash_mix(hash);
}

static uint64_t hash_surface(uint64_t hash, const render_surface *surface) {
    tulle_mesh_view const mesh = surface->mesh;
    uint64_t const counts[] = {mesh.vertex_count, mesh.triangle_count, (uint64_t)surface->pattern,
                               surface->has_wire, surface->rest_coordinates != NULL};
    double const numbers[] = {surface->pattern_size, surface->crease_angle};
    hash = hash_bytes(hash, counts, sizeof counts);
    hash = hash_doubles(hash, numbers, 2);
    hash = hash_doubles(hash, mesh.positions, 3 * mesh.vertex_count);
    hash = hash_bytes(hash, mesh.triangles, 3 * mesh.triangle_count * sizeof *mesh.triangles);
    if (surface->rest_coordinates)
        hash = hash_doubles(hash, surface->rest_coordinates, 2 * mesh.vertex_count);
    hash = hash_floats(hash, surface->vertex_colors, 3 * mesh.vertex_count);
    hash = hash_floats(hash, surface->triangle_colors, 3 * mesh.triangle_count);
    hash = hash_floats(hash, surface->front_color, 3);
    return hash_floats(hash, surface->back_color, 3);
}

static uint64_t hash_lighting(uint64_t hash, const render_lighting *lighting) {
    uint64_t const counts[] = {lighting->has_floor, lighting->bounces};
    double const numbers[] = {lighting->light_angle, lighting->floor_height};
    hash = hash_bytes(hash, counts, sizeof counts);
    hash = hash_doubles(hash, numbers, 2);
    hash = hash_doubles(hash, lighting->light_direction, 3);
    hash = hash_floats(hash, lighting->light_radiance, 3);
    hash = hash_floats(hash, lighting->sky_color, 3);
    hash = hash_floats(hash, lighting->horizon_color, 3);
    return hash_floats(hash, lighting->floor_color, 3);
}

/* Of everything that decides the picture; what it does not depend on is the number of threads. */
static uint64_t hash_picture(const picture_maker *maker) {
    const render_frame_def *const def = &maker->def;
    uint64_t const counts[] = {
        RENDER_REVISION, TULLE_VERSION_MAJOR, TULLE_VERSION_MINOR, TULLE_VERSION_PATCH, def->width,
        def->height,     def->samples,        def->surface_count,  def->mark_count,     def->seed};
    uint64_t hash = hash_bytes(HASH_SEED, counts, sizeof counts);
    hash = hash_doubles(hash, def->camera.position, 3);
    hash = hash_doubles(hash, def->camera.target, 3);
    hash = hash_doubles(hash, def->camera.up, 3);
    double const numbers[] = {def->camera.field_of_view, maker->run->picture.exposure};
    hash = hash_doubles(hash, numbers, 2);
    hash = hash_lighting(hash, &def->lighting);
    for (size_t i = 0; i < def->surface_count; i++) hash = hash_surface(hash, &def->surfaces[i]);
    for (size_t i = 0; i < def->mark_count; i++) {
        hash = hash_doubles(hash, def->marks[i].position, 3);
        hash = hash_doubles(hash, &def->marks[i].radius, 1);
        hash = hash_floats(hash, def->marks[i].color, 3);
    }
    return picture_explanation_hash(&maker->explanation, hash);
}

/* ---- one picture ---- */

/* Surfaces of the bodies that are there; the ground that the floor stands for is left out. */
static void gather_surfaces(picture_maker *maker) {
    picture_run *const run = maker->run;
    maker->surface_count = 0;
    for (size_t i = 0; i < run->body_count; i++) {
        picture_body *const body = &run->bodies[i];
        if (!body->is_present || body->is_hidden || i == run->floor_body) continue;
        body->surface.mesh = body->drawn;
        maker->surfaces[maker->surface_count++] = body->surface;
    }
}

static tulle_status judge(picture_maker *maker, tulle_error *error) {
    const picture_run *const run = maker->run;
    if (run->options->subdivision_levels == 0) return TULLE_OK;
    size_t count = 0;
    for (size_t i = 0; i < run->body_count; i++) {
        const picture_body *const body = &run->bodies[i];
        if (!body->is_present) continue;
        maker->names[count] = body->name;
        maker->drawn[count] = (tulle_check_body){body->drawn, body->is_obstacle};
        maker->simulated[count++] = (tulle_check_body){body->mesh, body->is_obstacle};
    }
    subdivided_frame const frame = {.number = (long)run->frame,
                                    .bodies = maker->drawn,
                                    .simulated = maker->simulated,
                                    .names = maker->names,
                                    .body_count = count};
    subdivided_verdict verdict;
    tulle_status const status =
        subdivided_check_frame(&frame, run->options->threads, &verdict, error);
    if (status == TULLE_OK) subdivided_totals_add(&maker->subdivided, &verdict);
    return status;
}

tulle_status picture_prepare(picture_maker *maker, uint32_t frame, double share,
                             char digest[PICTURE_DIGEST_SIZE], tulle_error *error) {
    picture_run *const run = maker->run;
    const picture_options *const options = run->options;
    tulle_status status = picture_run_read_frame(run, frame, error);
    if (status == TULLE_OK) status = judge(maker, error);
    if (status == TULLE_OK) status = picture_explain_frame(&maker->explanation, run, error);
    if (status != TULLE_OK) return status;
    gather_surfaces(maker);
    maker->def = (render_frame_def){.surfaces = maker->surfaces,
                                    .surface_count = maker->surface_count,
                                    .marks = maker->explanation.marks,
                                    .mark_count = maker->explanation.mark_count,
                                    .lighting = picture_get_lighting(run),
                                    .width = options->width,
                                    .height = options->height,
                                    .samples = options->samples,
                                    .threads = options->threads,
                                    .seed = 1};
    status =
        picture_make_camera(&maker->asked, &run->view, (double)options->width / options->height,
                            share, &maker->def.camera, error);
    snprintf(digest, PICTURE_DIGEST_SIZE, "%016llx", (unsigned long long)hash_picture(maker));
    return status;
}

tulle_status picture_trace(picture_maker *maker, tulle_error *error) {
    tulle_status const status = render_trace(maker->context, &maker->def, maker->radiance, error);
    if (status != TULLE_OK) return status;
    render_expose(maker->radiance, maker->run->picture.exposure, &maker->image);
    if (maker->explanation.has_legend)
        overlay_draw_legend(&maker->image, &maker->explanation.legend);
    return TULLE_OK;
}

tulle_status picture_write(const picture_maker *maker, const char *path, const char *digest,
                           tulle_error *error) {
    char software[40], frame[16];
    snprintf(software, sizeof software, "tulle %d.%d.%d", TULLE_VERSION_MAJOR, TULLE_VERSION_MINOR,
             TULLE_VERSION_PATCH);
    snprintf(frame, sizeof frame, "%u", maker->run->frame);
    render_note const notes[] = {
        {"Software", software}, {"tulle-frame", frame}, {DIGEST_KEY, digest}};
    return render_image_write_png(path, &maker->image, notes, 3, error);
}

bool picture_read_again(picture_maker *maker, const char *path, const char *digest) {
    render_image kept = {0};
    char note[64] = "";
    if (render_image_read_png(path, &kept, DIGEST_KEY, note, sizeof note, NULL) != TULLE_OK)
        return false;
    bool const is_same = strcmp(note, digest) == 0 && kept.width == maker->image.width &&
                         kept.height == maker->image.height;
    if (!is_same) {
        render_image_destroy(&kept);
        return false;
    }
    render_image_destroy(&maker->image);
    maker->image = kept;
    return true;
}
