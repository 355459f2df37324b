/* scene/make_mesh.c - meshes of a scene: read from files or generated, validated, counted. */
#include "scene/scene_data.h"

#include "base/error.h"
#include "base/hash.h"
#include "base/sort.h"
#include "math/vec3.h"

#include "tulle/shapes.h"
#include "tulle_io/mesh_files.h"

#include <math.h>
#include <stdarg.h>
#include <string.h>

const char *store_text(const scene_work *work, const char *format, ...) {
    char text[SCENE_PATH_LIMIT];
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (length < 0 || (size_t)length >= sizeof text) {
        problem_add(work->problems, TULLE_ERROR_LIMIT, (scene_place){work->scene->path, 0, 0},
                    "a path or name is longer than %d bytes", SCENE_PATH_LIMIT);
        return NULL;
    }
    const char *stored = copy_text(&work->scene->storage, text, (size_t)length);
    if (!stored) problem_add_memory(work->problems, work->scene->path);
    return stored;
}

const char *resolve_path(const scene_work *work, const char *path) {
    const char *slash = strrchr(work->scene->path, '/');
    if (path[0] == '/' || !slash) return path;
    return store_text(work, "%.*s/%s", (int)(slash - work->scene->path), work->scene->path, path);
}

uint64_t resolve_seed(const tulle_scene *loaded, uint64_t seed) {
    return seed == SEED_AUTO ? loaded->keys.seed : seed;
}

/* Copies the keys that were given over the shape's defaults. */
static void fill_shape(const scene_work *work, const mesh_keys *keys, tulle_shape_def *def) {
    const struct {
        const char *name;
        const double *from;
        double *to;
    } lengths[] = {
        {"radius", &keys->radius, &def->radius},
        {"inner_radius", &keys->inner_radius, &def->inner_radius},
        {"height", &keys->height, &def->height},
        {"tip_height", &keys->tip_height, &def->tip_height},
        {"head_radius", &keys->head_radius, &def->head_radius},
        {"head_height", &keys->head_height, &def->head_height},
        {"angle", &keys->angle, &def->angle},
        {"strand", &keys->strand, &def->strand},
        {"wavelength", &keys->wavelength, &def->wavelength},
    };
    for (size_t i = 0; i < sizeof lengths / sizeof lengths[0]; i++)
        if (schema_is_given(&mesh_map, keys, lengths[i].name)) *lengths[i].to = *lengths[i].from;
    for (size_t k = 0; k < keys->size.count; k++) def->size[k] = keys->size.value[k];
    for (size_t k = 0; k < keys->resolution.count; k++)
        def->resolution[k] = (uint32_t)keys->resolution.value[k];
    for (size_t k = 0; k < keys->cells.count; k++) def->cells[k] = (uint32_t)keys->cells.value[k];
    if (schema_is_given(&mesh_map, keys, "strand_resolution"))
        def->strand_resolution = (uint32_t)keys->strand_resolution;
    def->is_irregular = keys->irregular;
    if (def->seed != 0) def->seed = resolve_seed(work->scene, keys->seed); /* 0: it takes none */
}

static bool generate(const scene_work *work, const mesh_keys *keys, tulle_mesh *mesh) {
    size_t size_count = shape_size_count(keys->shape);
    if (keys->size.count > 0 && keys->size.count != size_count) {
        problem_add(work->problems, TULLE_ERROR_PARSE, schema_place(keys, "size"),
                    "%s.size: is a list of %zu, must be a list of %zu for shape %s",
                    keys->head.path, keys->size.count, size_count,
                    tulle_shape_name((tulle_shape)keys->shape));
        return false;
    }
    const uint64_t *const fineness = keys->resolution.value;
    if (shape_resolution_count(keys->shape) == 1 && keys->resolution.count == 2 &&
        fineness[0] != fineness[1]) {
        problem_add(work->problems, TULLE_ERROR_PARSE, schema_place(keys, "resolution"),
                    "%s.resolution: is [%llu, %llu]; shape %s has one resolution, as in [%llu]",
                    keys->head.path, (unsigned long long)fineness[0],
                    (unsigned long long)fineness[1], tulle_shape_name((tulle_shape)keys->shape),
                    (unsigned long long)fineness[0]);
        return false;
    }
    tulle_shape_def def = tulle_shape_def_default((tulle_shape)keys->shape);
    fill_shape(work, keys, &def);
    tulle_error error = {0};
    if (tulle_shape_generate(&def, mesh, &error) == TULLE_OK) return true;
    problem_add_error(work->problems, keys->head.place, keys->head.path, &error);
    return false;
}

void note_add(const scene_work *work, const char *format, ...) {
    tulle_scene *loaded = work->scene;
    char text[SCENE_PATH_LIMIT];
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    for (size_t i = 0; i < loaded->note_count; i++) /* objects may be of the same file */
        if (strcmp(loaded->notes[i], text) == 0) return;
    if (loaded->note_count > SCENE_NOTE_LIMIT) return;
    const char *const kept = loaded->note_count < SCENE_NOTE_LIMIT
                                 ? copy_text(&loaded->storage, text, strlen(text))
                                 : "there are more notes; they are shown once these are settled";
    if (kept) loaded->notes[loaded->note_count++] = kept;
}

double scene_get_end(const scene_work *work) {
    const time_keys *const keys = &work->scene->keys.time;
    return work->scene->frame_count * (double)keys->steps_per_frame * keys->step;
}

void note_late(const scene_work *work, const char *path, const char *what, double time) {
    double const end = scene_get_end(work);
    if (time >= end)
        note_add(work, "%s: %s at %.6g s, and the scene ends at %.6g s", path, what, time, end);
}

tulle_status drop_duplicates(const scene_work *work, const char *path, tulle_mesh *mesh,
                             tulle_mesh_source *source, tulle_error *error) {
    tulle_mesh_duplicates found;
    tulle_status const status =
        tulle_mesh_drop_duplicates(mesh, source->triangle_lines, &found, error);
    if (status != TULLE_OK || found.count == 0) return status;
    char more[48] = "";
    if (found.count > 1) snprintf(more, sizeof more, ", and %zu more", found.count - 1);
    if (found.dropped_line > 0)
        note_add(
            work,
            "%s:%u: triangle %u has the same corners as triangle %u (line %u) and is dropped%s",
            path, found.dropped_line, found.dropped, found.original, found.original_line, more);
    else
        note_add(work, "%s: triangle %u has the same corners as triangle %u and is dropped%s", path,
                 found.dropped, found.original, more);
    return TULLE_OK;
}

static int compare_points(const void *a, const void *b) { return memcmp(a, b, 3 * sizeof(double)); }

/* Boundary vertices that a repair joins with others in the same place. */
static tulle_status count_joined(const tulle_mesh *mesh, size_t *count, tulle_error *error) {
    tulle_mesh copy = {0};
    tulle_mesh_repairs repairs = {0};
    tulle_status status = tulle_mesh_create(mesh->vertex_count, mesh->triangle_count, &copy, error);
    if (status != TULLE_OK) return status;
    memcpy(copy.positions, mesh->positions, 3 * mesh->vertex_count * sizeof(double));
    memcpy(copy.triangles, mesh->triangles, 3 * mesh->triangle_count * sizeof(uint32_t));
    status = tulle_mesh_repair(&copy, 0.0, &repairs, error);
    tulle_mesh_destroy(&copy);
    *count = repairs.counts[TULLE_REPAIR_JOINED];
    /* What --repair cannot mend is told without it. */
    return status == TULLE_ERROR_OUT_OF_MEMORY ? status : TULLE_OK;
}

/* Files of pictures and of panels have several vertices where cloth has one; it would fall apart
 * there. */
static tulle_status note_seams(const scene_work *work, const char *path, const tulle_mesh *mesh,
                               tulle_error *error) {
    memory heap = memory_default();
    size_t const count = mesh->vertex_count, size = 3 * count * sizeof(double);
    double *const points = memory_allocate(&heap, size);
    size_t same_count = 0, joined_count = 0;
    if (!points) return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory to look for seams");
    for (size_t i = 0; i < 3 * count; i++) points[i] = mesh->positions[i] + 0.0; /* -0 is 0 */
    sort_in_place(points, count, 3 * sizeof(double), compare_points);
    for (size_t i = 1; i < count; i++)
        same_count += compare_points(points + 3 * i - 3, points + 3 * i) == 0;
    memory_release(&heap, points, size);
    if (same_count == 0) return TULLE_OK;
    tulle_status const status = count_joined(mesh, &joined_count, error);
    if (status != TULLE_OK) return status;
    bool const is_animation = frame_cache_is_animation(path);
    char advice[SCENE_PATH_LIMIT] = "join them first, as Blender does with Merge by Distance";
    if (joined_count >= same_count)
        snprintf(advice, sizeof advice, "join them first: 'tulle convert %s OUT.ply --repair%s'",
                 path, is_animation ? " --frame 0" : "");
    note_add(work,
             "%s: %zu vertices are in the place of others, and nothing joins them: the cloth "
             "comes apart there; %s",
             path, same_count, advice);
    return TULLE_OK;
}

/* Reads the first frame of an animation. */
static tulle_status read_first_frame(const scene_work *work, const char *path, source_mesh *made,
                                     tulle_error *error) {
    frame_cache cache;
    tulle_status status = frame_cache_open(path, &cache, error);
    if (status != TULLE_OK) return status;
    made->axes = cache.axes;
    if (cache.note[0]) note_add(work, "%s: %s", path, cache.note);
    if (cache.frame_count > 1)
        note_add(work, "%s: of %u frames the first one is taken; motion.sequence.cache plays them",
                 path, (unsigned)cache.frame_count);
    status = frame_cache_make_mesh(&cache, 0, made->mesh, error);
    frame_cache_close(&cache);
    return status;
}

tulle_status drop_flat(const scene_work *work, const char *path, tulle_mesh *mesh,
                       const flat_triangles *flat, tulle_error *error) {
    const char *const when = flat->when;
    const uint8_t *const marks = flat->marks;
    size_t const count = mesh->triangle_count;
    size_t marked = 0, first = 0;
    for (size_t t = count; t-- > 0;)
        if (marks[t]) marked++, first = t;
    if (marked == 0) return TULLE_OK;
    if (marked == count)
        return error_set_at(
            error, TULLE_ERROR_INVALID_MESH, path, 0, 0,
            "none of its %zu triangles has an area%s: the heights of all are under "
            "1e-9 of their longest edges; an obstacle needs a triangle with an area",
            count, when);
    char line[24] = "", more[48] = "";
    if (flat->lines) snprintf(line, sizeof line, ":%u", flat->lines[first]);
    if (marked > 1) snprintf(more, sizeof more, ", and %zu more", marked - 1);
    note_add(work,
             "%s%s: triangle %zu has no area%s (its height is under 1e-9 of its longest edge) and "
             "is left out%s",
             path, line, first, when, more);
    return tulle_mesh_drop_marked(mesh, marks, flat->lines, error);
}

/* What an obstacle that keeps its shape goes without. */
static tulle_status drop_degenerate(const scene_work *work, const char *path, tulle_mesh *mesh,
                                    tulle_mesh_source *source, tulle_error *error) {
    memory *const heap = &work->scene->heap;
    size_t const count = mesh->triangle_count;
    uint8_t *const marks = memory_allocate(heap, count);
    tulle_status status = TULLE_OK;
    if (!marks && count > 0)
        status = error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory to look at %zu triangles",
                           count);
    if (status == TULLE_OK)
        status = tulle_mesh_find_degenerate(tulle_mesh_get_view(mesh), marks, NULL, error);
    flat_triangles const flat = {marks, "", source->triangle_lines};
    if (status == TULLE_OK) status = drop_flat(work, path, mesh, &flat, error);
    memory_release(heap, marks, count);
    return status;
}

tulle_status read_mesh(const scene_work *work, const char *path, tulle_mesh_role role,
                       source_mesh *made, tulle_mesh_source *kept, tulle_error *error) {
    tulle_mesh *const mesh = made->mesh;
    tulle_mesh_source source = {0};
    made->is_of_file = true;
    made->axes = (file_axes){false, 1.0};
    tulle_status status = frame_cache_is_animation(path)
                              ? read_first_frame(work, path, made, error)
                              : tulle_mesh_read_source(path, mesh, &source, error);
    if (status != TULLE_OK) return status;
    made->polygons_hash = source.polygons_hash;
    if (source.has_passed_shape) note_add(work, "%s: %s", path, source.note);
    if (role != TULLE_MESH_ROLE_CLOTH) status = drop_duplicates(work, path, mesh, &source, error);
    if (status == TULLE_OK && role == TULLE_MESH_ROLE_OBSTACLE)
        status = drop_degenerate(work, path, mesh, &source, error);
    tulle_mesh_lines const lines = {source.vertex_lines, source.triangle_lines};
    if (status == TULLE_OK && role != TULLE_MESH_ROLE_DEFORMING)
        status = tulle_mesh_validate_lines(tulle_mesh_get_view(mesh), role, lines, error);
    if (status == TULLE_OK && role == TULLE_MESH_ROLE_CLOTH)
        status = note_seams(work, path, mesh, error);
    if (status != TULLE_OK && !error->file[0])
        snprintf(error->file, sizeof error->file, "%s", path);
    if (kept && status == TULLE_OK)
        *kept = source;
    else
        tulle_mesh_source_destroy(&source);
    return status;
}

bool make_mesh(const scene_work *work, const mesh_keys *keys, tulle_mesh_role role,
               source_mesh *made, tulle_mesh_source *source) {
    tulle_mesh *const mesh = made->mesh;
    tulle_error error = {0};
    made->axes = (file_axes){false, 1.0};
    if (!schema_is_given(&mesh_map, keys, "file")) {
        if (!generate(work, keys, mesh)) return false;
        if (tulle_mesh_validate(tulle_mesh_get_view(mesh), role, &error) == TULLE_OK) return true;
        problem_add_error(work->problems, keys->head.place, keys->head.path, &error);
        return false;
    }
    const char *const path = resolve_path(work, keys->file);
    if (!path) return false;
    if (read_mesh(work, path, role, made, source, &error) == TULLE_OK) return true;
    problem_add_error(work->problems, schema_place(keys, "file"), keys->head.path, &error);
    return false;
}

bool count_mesh(const scene_work *work, const tulle_mesh *mesh, scene_place place,
                const char *path) {
    tulle_scene *loaded = work->scene;
    loaded->vertex_count += mesh->vertex_count;
    if (loaded->vertex_count > SCENE_VERTEX_LIMIT) {
        problem_add(work->problems, TULLE_ERROR_LIMIT, place,
                    "%s: brings the scene to %zu vertices, at most %d are allowed", path,
                    loaded->vertex_count, SCENE_VERTEX_LIMIT);
        return false;
    }
    uint64_t hash = loaded->content_hash;
    hash = hash_bytes(hash, mesh->positions, 3 * mesh->vertex_count * sizeof(double));
    hash = hash_bytes(hash, mesh->triangles, 3 * mesh->triangle_count * sizeof(uint32_t));
    loaded->content_hash = hash;
    return true;
}

/* [rad] Of a turn that has two ways. */
static const double HALF_TURN = 3.141592653589793;
/* As step/motion.c has it: the sine between two axes that are one. */
static const double SAME_AXIS_SINE = 1e-12;

/* Between keyframes about different axes the turn goes the shorter way. Where the angles that were
 * given go by half a turn or more that is told. */
static void note_long_way(const scene_work *work, const keyframe_keys *from,
                          const keyframe_keys *to) {
    const schema_rotation *const a = &from->rotate, *const b = &to->rotate;
    vec3 const u = vec3_load(a->vector, 0), v = vec3_load(b->vector, 0);
    bool const is_one_axis =
        a->is_about_one_axis && b->is_about_one_axis &&
        vec3_norm(vec3_cross(u, v)) <= SAME_AXIS_SINE * vec3_norm(u) * vec3_norm(v);
    bool const has_angles = !a->has_axis && !b->has_axis;
    double way = vec3_norm(vec3_sub(v, u));
    for (int k = 0; has_angles && k < 3; k++)
        way = k == 0 ? fabs(b->given[0] - a->given[0]) : fmax(way, fabs(b->given[k] - a->given[k]));
    if (is_one_axis || !(way >= HALF_TURN)) return;
    note_add(
        work,
        "%s:%d: %s.rotate: is about another axis than the keyframe before and goes by %.6g deg "
        "from there; the turn goes the shorter way. Give keyframes in between, or turns about "
        "one axis by {axis, angle}",
        work->scene->path, schema_place(to, "rotate").line, to->head.path, way * 180.0 / HALF_TURN);
}

bool make_motion(const scene_work *work, const schema_list *keyframes, const pose *axes,
                 double delay, tulle_motion *motion) {
    const keyframe_keys *frames = keyframes->items;
    tulle_keyframe *keys = ARENA_NEW(&work->scene->storage, tulle_keyframe, keyframes->count + 1);
    if (!keys) {
        problem_add_memory(work->problems, work->scene->path);
        return false;
    }
    for (size_t i = 0; i < keyframes->count; i++) {
        if (i > 0 && !(frames[i].time > frames[i - 1].time)) {
            problem_add(work->problems, TULLE_ERROR_INVALID_ARGUMENT,
                        schema_place(&frames[i], "time"),
                        "%s.time: is %g s, must be later than the keyframe before, %g s",
                        frames[i].head.path, frames[i].time, frames[i - 1].time);
            return false;
        }
        keys[i].time = frames[i].time + delay;
        rotate_vector(axes->rotation, frames[i].translate.value, keys[i].translation);
        rotate_vector(axes->rotation, frames[i].rotate.vector, keys[i].rotation_vector);
        if (i > 0) note_long_way(work, &frames[i - 1], &frames[i]);
    }
    motion->keys = keys;
    motion->key_count = keyframes->count;
    if (keyframes->count > 1) note_late(work, frames[0].head.path, "motion begins", keys[0].time);
    return true;
}
