/* app/convert/source.c - see source.h. */
#define _POSIX_C_SOURCE 200809L
#include "app/convert/source.h"
#include "app/commands.h"

#include "app/convert/names.h"
#include "base/error.h"
#include "io/animation/animation_read.h"

#include "tulle_io/cache.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { BODY_LIST_SIZE = 1024 /* [bytes] of the bodies' names in a message */ };

static tulle_status refuse(const convert_source *source, tulle_error *error, const char *text) {
    return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, source->path, 0, 0, "%s", text);
}

/* ---- the files that are read ---- */

static bool identify(const char *path, file_identity *identity) {
    struct stat facts;
    if (stat(path, &facts) != 0) return false;
    *identity = (file_identity){facts.st_dev, facts.st_ino};
    return true;
}

static int compare_identities(const void *a, const void *b) {
    const file_identity *const left = a, *const right = b;
    if (left->device != right->device) return left->device < right->device ? -1 : 1;
    return left->node < right->node ? -1 : left->node > right->node;
}

static tulle_status make_inputs(convert_source *source, size_t count, tulle_error *error) {
    source->inputs = calloc(count, sizeof *source->inputs);
    if (source->inputs) return TULLE_OK;
    return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for the names of files");
}

static void add_input(convert_source *source, const char *path) {
    if (identify(path, &source->inputs[source->input_count])) source->input_count++;
}

static void add_open_input(convert_source *source, int file) {
    struct stat facts;
    if (file >= 0 && fstat(file, &facts) == 0)
        source->inputs[source->input_count++] = (file_identity){facts.st_dev, facts.st_ino};
}

bool convert_source_reads(const convert_source *source, const char *path) {
    file_identity identity;
    return identify(path, &identity) && source->input_count > 0 &&
           bsearch(&identity, source->inputs, source->input_count, sizeof identity,
                   compare_identities) != NULL;
}

/* ---- the kinds ---- */

static tulle_status open_mesh(convert_source *source, tulle_error *error) {
    source->kind = SOURCE_MESH;
    source->frames = frame_range_make(1);
    tulle_status status = make_inputs(source, 1, error);
    if (status == TULLE_OK)
        status = mesh_file_read(source->path, &source->mesh, &source->described, error);
    if (status == TULLE_OK) add_input(source, source->path);
    return status;
}

static tulle_status open_cache(convert_source *source, const char *mesh_path, tulle_error *error) {
    source->kind = SOURCE_CACHE;
    tulle_pc2_info *const info = &source->cache_info;
    tulle_status status = make_inputs(source, 2, error);
    if (status == TULLE_OK) status = tulle_pc2_open(source->path, &source->cache, info, error);
    if (status != TULLE_OK) return status;
    add_input(source, source->path);
    if (info->frame_count == 0) return refuse(source, error, "holds no frames");
    source->frames = frame_range_make(info->frame_count);
    if (!mesh_path) {
        status = tulle_mesh_create(info->vertex_count, 0, &source->mesh, error);
        return status == TULLE_OK ? convert_source_read(source, 0, source->mesh.positions, error)
                                  : status;
    }
    status = mesh_file_read(mesh_path, &source->mesh, NULL, error);
    if (status != TULLE_OK) return status;
    add_input(source, mesh_path);
    if (source->mesh.vertex_count == info->vertex_count) return TULLE_OK;
    return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, mesh_path, 0, 0,
                        "has %zu vertices, but the point cache %s has %u; it belongs to another "
                        "mesh",
                        source->mesh.vertex_count, source->path, info->vertex_count);
}

static tulle_status open_animation(convert_source *source, tulle_error *error) {
    source->kind = SOURCE_ANIMATION;
    tulle_animation_info *const info = &source->animation_info;
    tulle_status status = tulle_animation_open(source->path, &source->animation, info, error);
    if (status != TULLE_OK) return status;
    size_t const file_count = animation_get_file_count(source->animation);
    status = make_inputs(source, 1 + file_count, error);
    if (status != TULLE_OK) return status;
    add_input(source, source->path);
    for (size_t i = 0; i < file_count; i++)
        add_open_input(source, animation_get_file(source->animation, i));
    source->frames = frame_range_make(info->frame_count);
    snprintf(source->described.note, sizeof source->described.note, "%s", info->note);
    status = tulle_mesh_create(info->vertex_count, info->triangle_count, &source->mesh, error);
    if (status != TULLE_OK) return status;
    if (info->triangle_count > 0)
        memcpy(source->mesh.triangles, tulle_animation_get_triangles(source->animation),
               3 * info->triangle_count * sizeof(uint32_t));
    return convert_source_read(source, 0, source->mesh.positions, error);
}

/* "a, b, c" */
static void list_bodies(const tulle_run_info *info, char text[BODY_LIST_SIZE]) {
    text[0] = '\0';
    for (size_t i = 0; i < info->body_count; i++) {
        size_t const used = strlen(text);
        const char *const name = info->bodies[i].name;
        if (used + strlen(name) + 16 > BODY_LIST_SIZE) {
            snprintf(text + used, BODY_LIST_SIZE - used, " and more");
            return;
        }
        snprintf(text + used, BODY_LIST_SIZE - used, "%s%s", used > 0 ? ", " : "", name);
    }
}

/* The body of that name, or the only cloth. */
static tulle_status find_body(convert_source *source, const char *name, tulle_error *error) {
    const tulle_run_info *const info = tulle_run_reader_get_info(source->run);
    size_t found = info->body_count, cloth_count = 0;
    for (size_t i = 0; i < info->body_count; i++) {
        bool const is_cloth = !info->bodies[i].is_obstacle;
        cloth_count += is_cloth;
        if (name ? strcmp(info->bodies[i].name, name) == 0 : is_cloth) found = i;
    }
    source->body = found;
    if (found < info->body_count && (name || cloth_count == 1)) return TULLE_OK;
    char bodies[BODY_LIST_SIZE];
    list_bodies(info, bodies);
    if (name)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, source->path, 0, 0,
                            "has no body \"%.100s\"; it has %s", name, bodies);
    return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, source->path, 0, 0,
                        "has %zu cloths; name a body by --body: %s", cloth_count, bodies);
}

static void add_run_inputs(convert_source *source, const tulle_run_info *info) {
    char path[NUMBERED_PATH_SIZE];
    for (size_t i = 0; i < info->body_count; i++) {
        const char *const files[2] = {info->bodies[i].mesh_file, info->bodies[i].cache_file};
        for (int k = 0; k < 2; k++) {
            if (!files[k]) continue;
            int const length = snprintf(path, sizeof path, "%s/%s", source->path, files[k]);
            if (length > 0 && length < NUMBERED_PATH_SIZE) add_input(source, path);
        }
    }
}

/* Copies the mesh of the body. */
static tulle_status take_mesh(convert_source *source, tulle_error *error) {
    tulle_mesh_view view;
    tulle_status status = tulle_run_reader_get_mesh(source->run, source->body, &view, error);
    if (status == TULLE_OK)
        status = tulle_mesh_create(view.vertex_count, view.triangle_count, &source->mesh, error);
    if (status != TULLE_OK) return status;
    memcpy(source->mesh.positions, view.positions, 3 * view.vertex_count * sizeof(double));
    if (view.triangle_count > 0)
        memcpy(source->mesh.triangles, view.triangles, 3 * view.triangle_count * sizeof(uint32_t));
    return TULLE_OK;
}

static tulle_status open_run(convert_source *source, const source_options *options,
                             tulle_error *error) {
    source->kind = SOURCE_RUN;
    tulle_status status = tulle_run_reader_open(source->path, &source->run, error);
    if (status != TULLE_OK) return status;
    const tulle_run_info *const info = tulle_run_reader_get_info(source->run);
    if (info->frame_count == 0) return refuse(source, error, "the run holds no whole frame yet");
    source->frames = frame_range_make(info->frame_count);
    if (options->body || !options->takes_all) status = find_body(source, options->body, error);
    if (status == TULLE_OK) status = make_inputs(source, 2 * info->body_count, error);
    if (status != TULLE_OK) return status;
    add_run_inputs(source, info);
    return take_mesh(source, error);
}

tulle_status convert_source_open_body(const convert_source *run, size_t body,
                                      convert_source *source, tulle_error *error) {
    *source = (convert_source){.kind = SOURCE_RUN,
                               .path = run->path,
                               .frames = run->frames,
                               .run = run->run,
                               .borrows_run = true,
                               .body = body};
    return take_mesh(source, error);
}

static tulle_status open_files(convert_source *source, tulle_error *error) {
    source->kind = SOURCE_FILES;
    name_pattern pattern;
    tulle_status status = name_pattern_read(source->path, &pattern, error);
    if (status == TULLE_OK) status = numbered_files_find(&pattern, &source->files, error);
    if (status == TULLE_OK) status = make_inputs(source, source->files.count, error);
    if (status != TULLE_OK) return status;
    source->frames = source->files.range;
    source->needs_frames_named = source->files.has_gaps;
    source->gap = source->files.gap;
    char path[NUMBERED_PATH_SIZE];
    for (size_t i = 0; i < source->files.count; i++)
        if (numbered_files_get_path(&source->files, source->files.files[i].number, path))
            add_input(source, path);
    if (!numbered_files_get_path(&source->files, source->frames.first, path))
        return refuse(source, error, "the path is too long");
    return mesh_file_read(path, &source->mesh, &source->described, error);
}

static tulle_status check_options(const source_options *options, const convert_source *source,
                                  bool is_run, bool is_cache, tulle_error *error) {
    if (options->mesh_path && !is_cache)
        return refuse(source, error, "--mesh goes with a point cache (.pc2, .mdd) alone");
    if (options->body && !is_run)
        return refuse(source, error, "--body goes with the directory of a run alone");
    return TULLE_OK;
}

tulle_status convert_source_open(const source_options *options, convert_source *source,
                                 tulle_error *error) {
    *source = (convert_source){.path = options->path};
    bool const is_run = tulle_run_is_directory(options->path) != 0;
    bool const is_cache = !is_run && convert_is_cache(convert_get_format(options->path));
    tulle_status status = check_options(options, source, is_run, is_cache, error);
    if (status != TULLE_OK) return status;
    struct stat facts;
    bool const is_there = stat(options->path, &facts) == 0;
    if (!is_run && is_there && S_ISDIR(facts.st_mode))
        return refuse(source, error,
                      "this directory holds no run.json; name a run directory, a file, or numbered "
                      "files as in frame_%04d.obj");
    if (is_run)
        status = open_run(source, options, error);
    else if (!is_there && name_pattern_is_meant(options->path))
        status = is_cache ? refuse(source, error, "point caches are not numbered; name one")
                          : open_files(source, error);
    else if (is_cache)
        status = open_cache(source, options->mesh_path, error);
    else if (convert_is_scene(convert_get_format(options->path)))
        status = open_animation(source, error);
    else
        status = open_mesh(source, error);
    if (source->input_count > 0)
        qsort(source->inputs, source->input_count, sizeof *source->inputs, compare_identities);
    return status;
}

void convert_source_close(convert_source *source) {
    tulle_mesh_destroy(&source->mesh);
    tulle_mesh_source_destroy(&source->described);
    tulle_pc2_close(source->cache);
    tulle_animation_close(source->animation);
    if (!source->borrows_run) tulle_run_reader_close(source->run);
    numbered_files_destroy(&source->files);
    free(source->inputs);
    *source = (convert_source){0};
}

/* ---- frames ---- */

static tulle_status read_file(convert_source *source, uint32_t frame, double *positions,
                              tulle_error *error) {
    char path[NUMBERED_PATH_SIZE];
    if (!numbered_files_get_path(&source->files, frame, path))
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, source->path, 0, 0,
                            "there is no file of number %u; --frames names those to be read",
                            frame);
    tulle_mesh mesh = {0};
    tulle_status status = mesh_file_read(path, &mesh, NULL, error);
    if (status != TULLE_OK) return status;
    const tulle_mesh *const first = &source->mesh;
    if (mesh.vertex_count == first->vertex_count && mesh.triangle_count == first->triangle_count &&
        (mesh.triangle_count == 0 ||
         memcmp(mesh.triangles, first->triangles, 3 * mesh.triangle_count * sizeof(uint32_t)) == 0))
        memcpy(positions, mesh.positions, 3 * mesh.vertex_count * sizeof(double));
    else
        status = error_set_at(
            error, TULLE_ERROR_INVALID_MESH, path, 0, 0,
            "it has %zu vertices and %zu triangles, but the first file has %zu and %zu; all files "
            "of a sequence must have the same vertices and triangles",
            mesh.vertex_count, mesh.triangle_count, first->vertex_count, first->triangle_count);
    tulle_mesh_destroy(&mesh);
    return status;
}

static tulle_status read_frame(convert_source *source, uint32_t frame, double *positions,
                               tulle_error *error) {
    switch (source->keeps_mesh ? SOURCE_MESH : source->kind) {
    case SOURCE_ANIMATION:
        return tulle_animation_read_frame(source->animation, frame, positions, error);
    case SOURCE_CACHE: return tulle_pc2_read_frame(source->cache, frame, positions, error);
    case SOURCE_RUN:
        return tulle_run_reader_read_positions(source->run, frame, source->body, positions, error);
    case SOURCE_FILES: return read_file(source, frame, positions, error);
    default:
        memmove(positions, source->mesh.positions, 3 * source->mesh.vertex_count * sizeof(double));
        return TULLE_OK;
    }
}

void convert_source_keep_mesh(convert_source *source) {
    tulle_mesh_source kept = {0};
    snprintf(kept.note, sizeof kept.note, "%s", source->described.note);
    kept.has_passed_shape = source->described.has_passed_shape;
    tulle_mesh_source_destroy(&source->described);
    source->described = kept;
    source->keeps_mesh = true;
}

tulle_status convert_source_read(convert_source *source, uint32_t frame, double *positions,
                                 tulle_error *error) {
    tulle_status const status = read_frame(source, frame, positions, error);
    for (size_t i = 0; i < 3 * source->mesh.vertex_count && status == TULLE_OK; i++)
        if (!isfinite(positions[i]))
            return error_set_at(error, TULLE_ERROR_INVALID_MESH, source->path, 0, 0,
                                "frame %u: vertex %zu is not finite", frame, i / 3);
    return status;
}

tulle_status convert_source_find_time(const convert_source *source, uint32_t frame, double *time,
                                      tulle_error *error) {
    *time = (double)NAN;
    if (source->kind == SOURCE_CACHE) return tulle_pc2_get_time(source->cache, frame, time, error);
    if (source->kind == SOURCE_RUN)
        tulle_run_reader_get_frame(source->run, frame, time, NULL, NULL);
    if (source->kind == SOURCE_ANIMATION)
        *time = tulle_animation_get_time(source->animation, frame);
    return TULLE_OK;
}

/* What the file says of its axes and unit; a file that says nothing has z up and metres. */
static const char *get_up(const convert_source *source) {
    return source->kind == SOURCE_ANIMATION && source->animation_info.is_y_up ? "y" : "z";
}

static double get_meters(const convert_source *source) {
    return source->kind == SOURCE_ANIMATION ? source->animation_info.meters_per_unit : 1.0;
}

tulle_status convert_source_find_axes(const convert_source *source, axes_frame options,
                                      axes_frame *axes, tulle_error *error) {
    double const meters = get_meters(source);
    *axes = options;
    if (!axes->up) axes->up = get_up(source);
    if (!axes->unit) axes->unit = axes_find_unit(meters);
    if (axes->unit) return TULLE_OK;
    return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, source->path, 0, 0,
                        "its unit is %g m, but only m, cm, mm, in and ft are known; give its unit "
                        "by --from-units of tulle convert",
                        meters);
}

axes_change convert_source_find_scene_change(const convert_source *source) {
    return axes_change_to_scene(get_up(source), get_meters(source));
}

const char *convert_source_get_name(const convert_source *source) {
    if (source->kind != SOURCE_RUN) return source->path;
    return tulle_run_reader_get_info(source->run)->bodies[source->body].name;
}

uint32_t convert_source_count_absent(const convert_source *source, frame_range frames) {
    uint32_t count = 0;
    if (source->kind != SOURCE_RUN) return 0;
    for (uint32_t i = 0; i < frame_range_get_count(frames); i++)
        count +=
            !tulle_run_reader_is_present(source->run, frame_range_get(frames, i), source->body);
    return count;
}

void convert_source_print(const convert_source *source, bool has_all) {
    static const char *const kinds[] = {"mesh", "point cache", "run", "numbered meshes",
                                        "animation"};
    app_print_names(stdout, "  %-11s %s %s", "from", kinds[source->kind], source->path);
    if (source->kind == SOURCE_RUN && !has_all) {
        const tulle_run_body_info *const body =
            &tulle_run_reader_get_info(source->run)->bodies[source->body];
        app_print_names(stdout, ", %s %s", body->is_obstacle ? "obstacle" : "cloth", body->name);
    }
    putchar('\n');
}
