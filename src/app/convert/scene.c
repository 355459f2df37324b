/* app/convert/scene.c - see scene.h. */
#include "app/convert/scene.h"

#include "app/cli/interrupt.h"
#include "base/error.h"
#include "io/text/number.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Meshes of rigid bodies are made from rounded numbers. Copies of a mesh differ by so many
 * roundings of their largest coordinate, and no more. */
static const double COPY_ROUNDINGS = 8.0;
/* A frame rate this near to a whole number, as a part of it, is that number. */
static const double RATE_TOLERANCE = 1e-6;
static const double DEFAULT_RATE = 24.0;
/* Frames that follow each other this fast have the default rate; writers take no higher one. */
static const double RATE_LIMIT = 1e9;

static const double obstacle_color[3] = {0.45, 0.45, 0.45};
static const double cloth_colors[][3] = {{0.60, 0.10, 0.08}, {0.08, 0.25, 0.55},
                                         {0.10, 0.40, 0.15}, {0.70, 0.45, 0.05},
                                         {0.35, 0.10, 0.45}, {0.05, 0.40, 0.42}};
enum { CLOTH_COLOR_COUNT = sizeof cloth_colors / sizeof cloth_colors[0] };

static tulle_status fail_memory(tulle_error *error) {
    return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for the surfaces");
}

/* ---- times ---- */

static double round_rate(double rate) {
    double const whole = round(rate);
    return whole > 0.0 && fabs(rate - whole) <= RATE_TOLERANCE * whole ? whole : rate;
}

/* Whether the frames of the source have times of their own. */
static bool has_times(const convert_source *source) {
    double time = (double)NAN;
    return convert_source_find_time(source, source->frames.first, &time, NULL) != TULLE_OK ||
           isfinite(time);
}

/* Finds the first frame of those that are converted whose time is not after that of the one before;
 * 0: there is none. */
static tulle_status find_standstill(const convert_scene *scene, uint32_t *index,
                                    tulle_error *error) {
    double before = -(double)INFINITY;
    *index = 0;
    for (uint32_t i = 0; i < frame_range_get_count(scene->frames) && *index == 0; i++) {
        double time = (double)NAN;
        tulle_status const status = convert_source_find_time(
            scene->source, frame_range_get(scene->frames, i), &time, error);
        if (status) return status;
        if (!(time > before)) *index = i;
        before = time;
    }
    return TULLE_OK;
}

/* Times of frames must rise; --fps gives those others that have none, or none that rise. */
static tulle_status check_times(convert_scene *scene, const char *fps, tulle_error *error) {
    uint32_t index = 0;
    tulle_status const status = find_standstill(scene, &index, error);
    if (status) return status;
    uint32_t const frame = index > 0 ? frame_range_get(scene->frames, index) : 0;
    if (index > 0 && !fps)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, scene->source->path, 0, 0,
                            "frame %u is not later than frame %u; --fps gives frames other times",
                            frame, frame_range_get(scene->frames, index - 1));
    if (index == 0 && fps)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, scene->source->path, 0, 0,
                            "its frames have times; --fps is for frames without");
    scene->ignores_times = index > 0;
    return TULLE_OK;
}

static tulle_status choose_rate(convert_scene *scene, const char *fps, tulle_error *error) {
    const convert_source *const source = scene->source;
    double rate = DEFAULT_RATE;
    tulle_status const checked = has_times(source) ? check_times(scene, fps, error) : TULLE_OK;
    if (checked) return checked;
    if (fps && (number_parse_double(fps, strlen(fps), &rate) != NUMBER_READ || !(rate > 0.0) ||
                !(rate <= 1e6)))
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT,
                         "--fps is \"%s\"; it should be a number above 0, at most 1e6", fps);
    if (source->kind == SOURCE_RUN) {
        const tulle_run_info *const info = tulle_run_reader_get_info(source->run);
        rate = round_rate(1.0 / (info->time_step * info->steps_per_frame));
    } else if (has_times(source) && !scene->ignores_times &&
               source->frames.last > source->frames.first) {
        double ends[2];
        tulle_status status =
            convert_source_find_time(source, source->frames.first, &ends[0], error);
        if (status == TULLE_OK)
            status = convert_source_find_time(source, source->frames.last, &ends[1], error);
        if (status) return status;
        rate = round_rate((source->frames.last - source->frames.first) / (ends[1] - ends[0]));
    }
    if (rate > 0.0 && rate < RATE_LIMIT) scene->def.frame_rate = rate;
    return TULLE_OK;
}

/* Where a frame without a time is, counted in frames: PC2 says where it begins and how far it
 * goes. */
static double count_frames(const convert_source *source, uint32_t frame) {
    const tulle_pc2_info *const info = &source->cache_info;
    bool const is_told = source->kind == SOURCE_CACHE && info->frame_step > 0.0;
    return is_told ? info->start_frame + info->frame_step * frame : (double)frame;
}

static tulle_status read_times(convert_scene *scene, tulle_error *error) {
    uint32_t const count = frame_range_get_count(scene->frames);
    scene->times = calloc(count, sizeof *scene->times);
    if (!scene->times) return fail_memory(error);
    for (uint32_t i = 0; i < count; i++) {
        uint32_t const frame = frame_range_get(scene->frames, i);
        tulle_status const status =
            convert_source_find_time(scene->source, frame, &scene->times[i], error);
        if (status) return status;
        if (isnan(scene->times[i]) || scene->ignores_times)
            scene->times[i] = count_frames(scene->source, frame) / scene->def.frame_rate;
    }
    return TULLE_OK;
}

/* ---- rigid bodies ---- */

/* Reads the poses of all frames. Leaves rigid_count at 0 where the run does not tell them. */
static tulle_status read_poses(convert_scene *scene, tulle_error *error) {
    const tulle_run_info *const info = tulle_run_reader_get_info(scene->source->run);
    size_t rigid_count = 0;
    for (size_t i = 0; i < info->body_count; i++) rigid_count += info->bodies[i].is_dynamic != 0;
    if (rigid_count == 0) return TULLE_OK;
    uint32_t const frame_count = frame_range_get_count(scene->frames);
    tulle_transform *const transforms = calloc(rigid_count, sizeof *transforms);
    scene->poses = calloc(rigid_count * frame_count, 7 * sizeof(double));
    tulle_status status = transforms && scene->poses ? TULLE_OK : fail_memory(error);
    for (uint32_t i = 0; i < frame_count && status == TULLE_OK; i++) {
        status = tulle_run_reader_read_transforms(
            scene->source->run, frame_range_get(scene->frames, i), transforms, error);
        for (size_t k = 0; k < rigid_count && status == TULLE_OK; k++) {
            double *const pose = scene->poses + 7 * (i * rigid_count + k);
            memcpy(pose, transforms[k].position, 3 * sizeof(double));
            memcpy(pose + 3, transforms[k].rotation, 4 * sizeof(double));
            axes_apply(scene->change, pose, 1);
            axes_turn_rotation(scene->change, pose + 3);
        }
    }
    free(transforms);
    if (status == TULLE_ERROR_UNSUPPORTED) return TULLE_OK;
    if (status == TULLE_OK) scene->rigid_count = rigid_count;
    return status;
}

/* Makes the positions of a body without its pose: from the centre of mass. */
static tulle_status make_rigid(convert_scene *scene, size_t surface,
                               const tulle_transform *transform, tulle_error *error) {
    scene_body *const body = &scene->bodies[surface];
    tulle_animation_surface *const made = &scene->surfaces[surface];
    size_t const vertex_count = made->mesh.vertex_count;
    body->mesh = calloc(vertex_count, 3 * sizeof(double));
    if (!body->mesh) return fail_memory(error);
    for (size_t i = 0; i < 3 * vertex_count; i++)
        body->mesh[i] = body->source.mesh.positions[i] - transform->centre[i % 3];
    axes_apply(scene->change, body->mesh, vertex_count);
    made->motion = TULLE_ANIMATION_RIGID;
    made->mesh.positions = body->mesh;
    return convert_target_measure(scene->target, body->mesh, vertex_count, error);
}

static double find_largest(const double *values, size_t count) {
    double largest = 0.0;
    for (size_t i = 0; i < count; i++) largest = fmax(largest, fabs(values[i]));
    return largest;
}

/* Whether a mesh is a copy of another, moved without being turned. */
static bool is_copy(const convert_scene *scene, size_t surface, size_t other) {
    tulle_mesh_view const a = scene->surfaces[surface].mesh, b = scene->surfaces[other].mesh;
    if (a.vertex_count != b.vertex_count || a.triangle_count != b.triangle_count ||
        memcmp(a.triangles, b.triangles, 3 * a.triangle_count * sizeof(uint32_t)) != 0)
        return false;
    size_t const count = 3 * a.vertex_count;
    double const largest = fmax(find_largest(scene->bodies[surface].source.mesh.positions, count),
                                find_largest(scene->bodies[other].source.mesh.positions, count));
    double const bound =
        COPY_ROUNDINGS * DBL_EPSILON * largest * scene->change->multiplier / scene->change->divisor;
    for (size_t i = 0; i < count; i++)
        if (!(fabs(a.positions[i] - b.positions[i]) <= bound)) return false;
    return true;
}

static tulle_status make_rigid_bodies(convert_scene *scene, tulle_error *error) {
    const tulle_run_info *const info = tulle_run_reader_get_info(scene->source->run);
    if (scene->rigid_count == 0) return TULLE_OK;
    tulle_transform *const transforms = calloc(scene->rigid_count, sizeof *transforms);
    if (!transforms) return fail_memory(error);
    tulle_status status = tulle_run_reader_read_transforms(scene->source->run, scene->frames.first,
                                                           transforms, error);
    size_t next = 0;
    for (size_t i = 0; i < scene->count && status == TULLE_OK; i++) {
        if (!info->bodies[i].is_dynamic) continue;
        scene->bodies[i].number = next;
        status = make_rigid(scene, i, &transforms[next++], error);
        for (size_t k = 0; k < i && status == TULLE_OK; k++)
            if (scene->bodies[k].mesh && scene->surfaces[k].prototype == k &&
                is_copy(scene, i, k)) {
                scene->surfaces[i].prototype = k;
                break;
            }
    }
    free(transforms);
    return status;
}

void convert_scene_place_rigid(const convert_scene *scene, size_t surface, uint32_t index,
                               double *positions) {
    tulle_mesh_view const mesh = scene->surfaces[scene->surfaces[surface].prototype].mesh;
    bool const is_float =
        scene->target->format == CONVERT_GLB || scene->target->format == CONVERT_GLTF;
    double pose[7], norm2 = 0.0;
    memcpy(pose, scene->poses + 7 * (index * scene->rigid_count + scene->bodies[surface].number),
           sizeof pose);
    for (int i = 3; i < 7; i++) norm2 += pose[i] * pose[i];
    for (int i = 3; i < 7; i++) pose[i] /= sqrt(norm2);
    for (int i = 0; i < 7 && is_float; i++) pose[i] = (double)(float)pose[i];
    const double *const axis =
        pose + 4; /* of the quaternion (w, u): p + w (2 u x p) + u x (2 u x p) */
    for (size_t i = 0; i < mesh.vertex_count; i++) {
        double point[3], twist[3];
        for (size_t k = 0; k < 3; k++) point[k] = (double)(float)mesh.positions[3 * i + k];
        for (size_t k = 0; k < 3; k++)
            twist[k] = 2.0 * (axis[(k + 1) % 3] * point[(k + 2) % 3] -
                              axis[(k + 2) % 3] * point[(k + 1) % 3]);
        for (size_t k = 0; k < 3; k++)
            positions[3 * i + k] = pose[k] + point[k] + pose[3] * twist[k] +
                                   axis[(k + 1) % 3] * twist[(k + 2) % 3] -
                                   axis[(k + 2) % 3] * twist[(k + 1) % 3];
    }
}

/* ---- surfaces ---- */

static tulle_status open_bodies(convert_scene *scene, tulle_error *error) {
    const tulle_run_info *const info = tulle_run_reader_get_info(scene->source->run);
    scene->bodies = calloc(info->body_count, sizeof *scene->bodies);
    scene->surfaces = calloc(info->body_count, sizeof *scene->surfaces);
    if (!scene->bodies || !scene->surfaces) return fail_memory(error);
    size_t cloth_count = 0;
    for (; scene->count < info->body_count; scene->count++) {
        size_t const i = scene->count;
        const tulle_run_body_info *const body = &info->bodies[i];
        tulle_status const status =
            convert_source_open_body(scene->source, i, &scene->bodies[i].source, error);
        if (status) return status;
        scene->surfaces[i] = (tulle_animation_surface){
            .name = body->name,
            .mesh = tulle_mesh_get_view(&scene->bodies[i].source.mesh),
            .motion = body->is_static ? TULLE_ANIMATION_STILL : TULLE_ANIMATION_DEFORMS,
            .prototype = i};
        memcpy(scene->surfaces[i].color,
               body->is_obstacle ? obstacle_color : cloth_colors[cloth_count % CLOTH_COLOR_COUNT],
               3 * sizeof(double));
        cloth_count += !body->is_obstacle;
    }
    if (scene->target->format == CONVERT_NPZ) return TULLE_OK;
    tulle_status const status = read_poses(scene, error);
    return status == TULLE_OK ? make_rigid_bodies(scene, error) : status;
}

tulle_status convert_scene_open(convert_scene *scene, convert_source *source,
                                convert_target *target, const scene_options *options,
                                frame_range frames, tulle_error *error) {
    *scene = (convert_scene){.source = source,
                             .change = options->change,
                             .target = target,
                             .frames = frames,
                             .def = tulle_animation_def_default()};
    scene->def.is_y_up = strcmp(options->up, "y") == 0;
    scene->def.meters_per_unit = options->meters_per_unit;
    scene->def.is_stepped = options->is_stepped;
    scene->def.is_double = options->is_double;
    tulle_status status = choose_rate(scene, options->fps, error);
    if (status == TULLE_OK) status = read_times(scene, error);
    if (status == TULLE_OK && options->takes_all) status = open_bodies(scene, error);
    if (status != TULLE_OK || options->takes_all) return status;
    scene->surfaces = calloc(1, sizeof *scene->surfaces);
    return scene->surfaces ? TULLE_OK : fail_memory(error);
}

/* The last part of a path, without its extension. */
static const char *get_stem(const char *path) {
    const char *const slash = strrchr(path, '/');
    return slash && slash[1] ? slash + 1 : path;
}

void convert_scene_set_surface(convert_scene *scene, tulle_mesh_view mesh, const double *corner_uvs,
                               scene_reader read, void *context) {
    const convert_source *const source = scene->source;
    const char *const name = get_stem(convert_source_get_name(source));
    bool const is_still = source->kind == SOURCE_RUN &&
                          tulle_run_reader_get_info(source->run)->bodies[source->body].is_static;
    scene->surfaces[0] = (tulle_animation_surface){.name = *name ? name : "surface",
                                                   .mesh = mesh,
                                                   .corner_uvs = corner_uvs,
                                                   .motion = is_still ? TULLE_ANIMATION_STILL
                                                                      : TULLE_ANIMATION_DEFORMS};
    memcpy(scene->surfaces[0].color, cloth_colors[0], 3 * sizeof(double));
    scene->count = 1;
    scene->read = read;
    scene->context = context;
}

/* Of the one surface. */
static tulle_status read_array(void *context, size_t surface, uint32_t index, double *values,
                               tulle_error *error) {
    (void)surface;
    convert_scene *const scene = context;
    uint32_t const frame = frame_range_get(scene->frames, scene->first_index + index);
    if (interrupt_is_pending()) return error_set(error, TULLE_ERROR_INTERRUPTED, "interrupted");
    return scene->read_array(scene->context, frame, values, error);
}

void convert_scene_add_array(convert_scene *scene, const char *name, scene_reader read) {
    scene->read_array = read;
    scene->def.vertex_array = name;
    scene->def.read_vertex_array = read_array;
}

void convert_scene_close(convert_scene *scene) {
    for (size_t i = 0; i < scene->count && scene->bodies; i++) {
        convert_source_close(&scene->bodies[i].source);
        free(scene->bodies[i].mesh);
    }
    free(scene->bodies);
    free(scene->surfaces);
    free(scene->poses);
    free(scene->times);
    *scene = (convert_scene){0};
}

/* ---- frames ---- */

static tulle_status read_values(convert_scene *scene, size_t surface, uint32_t index,
                                double *values, tulle_error *error) {
    uint32_t const place = scene->first_index + index;
    uint32_t const frame = frame_range_get(scene->frames, place);
    if (interrupt_is_pending()) return error_set(error, TULLE_ERROR_INTERRUPTED, "interrupted");
    if (!scene->bodies) {
        tulle_status const status = scene->read(scene->context, frame, values, error);
        return status == TULLE_OK
                   ? convert_target_measure(scene->target, values,
                                            scene->surfaces[0].mesh.vertex_count, error)
                   : status;
    }
    scene_body *const body = &scene->bodies[surface];
    if (body->mesh) {
        memcpy(values, scene->poses + 7 * (place * scene->rigid_count + body->number),
               7 * sizeof(double));
        return TULLE_OK;
    }
    size_t const vertex_count = body->source.mesh.vertex_count;
    tulle_status const status = convert_source_read(&body->source, frame, values, error);
    if (status != TULLE_OK) return status;
    axes_apply(scene->change, values, vertex_count);
    return convert_target_measure(scene->target, values, vertex_count, error);
}

/* Readings of frames that writing takes, as far as it can be told before. */
static uint64_t count_readings(const convert_scene *scene) {
    uint64_t moving_count = 0;
    for (size_t i = 0; i < scene->count; i++)
        moving_count += scene->surfaces[i].motion == TULLE_ANIMATION_DEFORMS;
    uint64_t const passes = scene->target->format == CONVERT_MDD    ? 1
                            : scene->target->format == CONVERT_USDA ? 5
                                                                    : 2;
    return passes * moving_count * scene->def.frame_count;
}

static void show_progress(convert_scene *scene, size_t surface) {
    if (!scene->progress || scene->reading_count < 2 ||
        scene->surfaces[surface].motion != TULLE_ANIMATION_DEFORMS)
        return;
    if (scene->readings_done + 1 < scene->reading_count) scene->readings_done++;
    frame_progress_show(scene->progress, scene->readings_done, scene->reading_count);
}

static tulle_status read_surface(void *context, size_t surface, uint32_t index, double *values,
                                 tulle_error *error) {
    convert_scene *const scene = context;
    scene->is_reading = true;
    show_progress(scene, surface);
    tulle_status const status = read_values(scene, surface, index, values, error);
    scene->is_reading = status != TULLE_OK;
    return status;
}

static int is_present(void *context, size_t surface, uint32_t index) {
    const convert_scene *const scene = context;
    size_t const body = scene->bodies ? surface : scene->source->body;
    return tulle_run_reader_is_present(
        scene->source->run, frame_range_get(scene->frames, scene->first_index + index), body);
}

tulle_status convert_scene_write(convert_scene *scene, frame_range frames, tulle_error *error) {
    scene->first_index = (frames.first - scene->frames.first) / scene->frames.step;
    scene->def.surfaces = scene->surfaces;
    scene->def.surface_count = scene->count;
    scene->def.times = scene->times + scene->first_index;
    scene->def.frame_count = frame_range_get_count(frames);
    scene->def.read = read_surface;
    scene->def.is_present = scene->source->kind == SOURCE_RUN ? is_present : NULL;
    scene->def.context = scene;
    scene->readings_done = 0;
    scene->reading_count = scene->def.frame_count > 1 ? count_readings(scene) : 0;
    tulle_status const status =
        convert_target_write_animation(scene->target, frames, &scene->def, error);
    if (status == TULLE_OK && scene->progress && scene->reading_count > 1)
        frame_progress_show(scene->progress, scene->reading_count, scene->reading_count);
    return status;
}
