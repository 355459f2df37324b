/* scene/sequence.c - mesh sequences: numbered mesh files, a point cache or an animation. Every
 * frame is read once when the scene is loaded, so that a bad file is found before the run begins.
 * It is read again when a world asks for it; the last two frames are kept. Several worlds may ask
 * at once. */
#include "scene/frame_cache.h"
#include "scene/scene_data.h"

#include "base/error.h"
#include "base/hash.h"

#include "tulle_io/mesh_files.h"

#include <math.h>
#include <stdatomic.h>
#include <string.h>

struct scene_sequence {
    const char *files; /* path with one %d, null for a cache */
    const char *cache; /* path */
    frame_cache open;  /* an animation that stays open; used with what is kept */
    uint64_t first;
    uint32_t frame_count; /* read from files */
    uint32_t period;      /* frames of a round, there and back with pingpong */
    sequence_loop loop;
    const double *times; /* [s] of frames after the first, as played; null: evenly apart */
    double begin;        /* [s] time of the first frame */
    double interval;     /* [s] from one frame of the world to the next */
    double seam;         /* [s] from the last frame to the first one, with times */
    size_t vertex_count;
    double scale[3];
    pose placement;
    double *kept[2]; /* placed positions */
    uint32_t kept_frame[2];
    int next_kept;              /* the slot to be replaced next */
    atomic_flag is_kept_in_use; /* a thread reads or replaces what is kept, or what is open */
};

enum {
    number_width_limit = 18,
    ENDLESS_FRAMES = 1000000000 /* the most that an obstacle may have */
};

/* A last frame as near to the first as this, against the largest step of a vertex between frames,
 * is the first one again. */
static const double SAME_FRAME_SHARE = 1e-3;
/* A time as near to another, as a part of it, is the same, told as a float. */
static const double SAME_TIME_SHARE = 1e-6;
static const double MUCH_OF_A_FRAME = 0.1; /* before it the next frame is hardly shown */
/* The step from the last frame to the first may be so many times the largest one between frames. */
static const double SEAM_STEP_RATIO = 2.0;

/* Finds the one %d, %4d or %04d of a pattern. */
static bool split_pattern(const char *pattern, size_t *before, const char **after, int *width,
                          bool *is_zero_padded) {
    const char *percent = strchr(pattern, '%');
    if (!percent) return false;
    const char *p = percent + 1;
    *is_zero_padded = *p == '0';
    *width = 0;
    for (; *p >= '0' && *p <= '9'; p++) {
        *width = *width * 10 + (*p - '0');
        if (*width > number_width_limit) return false;
    }
    if (*p != 'd' || strchr(p, '%')) return false;
    *before = (size_t)(percent - pattern);
    *after = p + 1;
    return true;
}

static bool write_file_name(const char *pattern, uint64_t number, char *path, size_t capacity) {
    size_t before;
    const char *after;
    int width;
    bool is_zero_padded;
    if (!split_pattern(pattern, &before, &after, &width, &is_zero_padded)) return false;
    int length = snprintf(path, capacity, is_zero_padded ? "%.*s%0*llu%s" : "%.*s%*llu%s",
                          (int)before, pattern, width, (unsigned long long)number, after);
    return length > 0 && (size_t)length < capacity;
}

/* Reads the mesh file of a frame. *polygons_hash: as of tulle_mesh_source. */
static tulle_status read_file(const scene_sequence *sequence, uint32_t frame, tulle_mesh *mesh,
                              uint64_t *polygons_hash, tulle_error *error) {
    char path[SCENE_PATH_LIMIT];
    if (!write_file_name(sequence->files, sequence->first + frame, path, sizeof path))
        return error_set(error, TULLE_ERROR_LIMIT, "the path of frame %u is too long",
                         (unsigned)frame);
    tulle_mesh_source source;
    tulle_status status = tulle_mesh_read_source(path, mesh, &source, error);
    if (status != TULLE_OK) return status;
    *polygons_hash = source.polygons_hash;
    tulle_mesh_source_destroy(&source);
    for (size_t i = 0; i < 3 * mesh->vertex_count; i++)
        if (!isfinite(mesh->positions[i]))
            status = error_set_at(error, TULLE_ERROR_INVALID_MESH, path, 0, 0,
                                  "vertex %zu is not finite", i / 3);
    tulle_mesh_duplicates dropped; /* the first frame's are noted */
    if (status == TULLE_OK) status = tulle_mesh_drop_duplicates(mesh, NULL, &dropped, error);
    if (status == TULLE_OK && sequence->vertex_count > 0 &&
        mesh->vertex_count != sequence->vertex_count)
        status = error_set_at(error, TULLE_ERROR_INVALID_MESH, path, 0, 0,
                              "has %zu vertices, must have %zu as the frames before: all frames of "
                              "a mesh sequence have the same vertices and triangles",
                              mesh->vertex_count, sequence->vertex_count);
    if (status != TULLE_OK) tulle_mesh_destroy(mesh);
    return status;
}

/* Reads the positions of a frame of a cache. */
static tulle_status read_cached(const scene_sequence *sequence, frame_cache *cache, uint32_t frame,
                                double *positions, tulle_error *error) {
    tulle_status status = TULLE_OK;
    if (!cache->animation) status = frame_cache_open(sequence->cache, cache, error);
    if (status != TULLE_OK) return status;
    if (cache->vertex_count != sequence->vertex_count)
        status = error_set_at(error, TULLE_ERROR_INVALID_MESH, sequence->cache, 0, 0,
                              "the number of vertices changed to %zu", cache->vertex_count);
    else
        status = frame_cache_read(cache, (uint32_t)sequence->first + frame, positions, error);
    if (!cache->animation) frame_cache_close(cache);
    for (size_t i = 0; status == TULLE_OK && i < 3 * sequence->vertex_count; i++)
        if (!isfinite(positions[i]))
            status = error_set_at(error, TULLE_ERROR_INVALID_MESH, sequence->cache, 0, 0,
                                  "vertex %zu of frame %u is not finite", i / 3, (unsigned)frame);
    return status;
}

/* Reads the positions of a frame, unplaced; an animation stays open in `cache`. */
static tulle_status read_frame(const scene_sequence *sequence, frame_cache *cache, uint32_t frame,
                               double *positions, tulle_error *error) {
    if (sequence->cache) return read_cached(sequence, cache, frame, positions, error);
    tulle_mesh mesh = {0};
    uint64_t polygons_hash;
    tulle_status const status = read_file(sequence, frame, &mesh, &polygons_hash, error);
    if (status != TULLE_OK) return status;
    memcpy(positions, mesh.positions, 3 * sequence->vertex_count * sizeof(double));
    tulle_mesh_destroy(&mesh);
    return TULLE_OK;
}

/* Reads the positions of a frame where it is placed. */
static tulle_status read_placed(const scene_sequence *sequence, frame_cache *cache, uint32_t frame,
                                double *positions, tulle_error *error) {
    tulle_status const status = read_frame(sequence, cache, frame, positions, error);
    if (status != TULLE_OK) return status;
    tulle_mesh placed = {.positions = positions, .vertex_count = sequence->vertex_count};
    tulle_mesh_transform(&placed, sequence->scale, sequence->placement.rotation,
                         sequence->placement.translation);
    return TULLE_OK;
}

/* What is shown as a frame of the world: a part of the way from a frame of the files to another. */
typedef struct frame_mix {
    uint32_t from, to;
    double part; /* 0: `from` alone */
} frame_mix;

static frame_mix find_mix(const scene_sequence *sequence, uint32_t wanted) {
    uint32_t const last = sequence->frame_count - 1;
    if (!sequence->times) {
        uint32_t const within = wanted % sequence->period;
        uint32_t const frame = within <= last ? within : sequence->period - within;
        return (frame_mix){frame, frame, 0.0};
    }
    const double *const times = sequence->times;
    double const end = times[last];
    double time = (double)wanted * sequence->interval - sequence->begin;
    if (sequence->loop == LOOP_REPEAT) time = time > 0.0 ? fmod(time, end + sequence->seam) : 0.0;
    if (sequence->loop == LOOP_PINGPONG) {
        time = time > 0.0 ? fmod(time, 2.0 * end) : 0.0;
        time = fmin(time, 2.0 * end - time);
    }
    if (!(time > 0.0)) return (frame_mix){0, 0, 0.0};
    if (time >= end)
        return (frame_mix){last, 0, sequence->seam > 0.0 ? (time - end) / sequence->seam : 0.0};
    uint32_t low = 0, high = last; /* the last frame that is not later, and one that is */
    while (high - low > 1) {
        uint32_t const middle = low + (high - low) / 2;
        *(times[middle] <= time ? &low : &high) = middle;
    }
    return (frame_mix){low, high, (time - times[low]) / (times[high] - times[low])};
}

/* Goes on from `positions` a part of the way to `next`. */
static void mix_positions(double part, const double *next, size_t vertex_count, double *positions) {
    for (size_t i = 0; i < 3 * vertex_count; i++) positions[i] += part * (next[i] - positions[i]);
}

/* A placed frame of the files that is kept, or is read now in place of one that is not `other`. */
static tulle_status find_kept(scene_sequence *sequence, uint32_t frame, uint32_t other,
                              const double **found, tulle_error *error) {
    int slot = 0;
    while (slot < 2 && sequence->kept_frame[slot] != frame) slot++;
    if (slot == 2) {
        slot = sequence->next_kept;
        if (sequence->kept_frame[slot] == other) slot = 1 - slot;
        sequence->kept_frame[slot] = TULLE_NONE;
        tulle_status const status =
            read_placed(sequence, &sequence->open, frame, sequence->kept[slot], error);
        if (status != TULLE_OK) return status;
        sequence->kept_frame[slot] = frame;
        sequence->next_kept = 1 - slot;
    }
    *found = sequence->kept[slot];
    return TULLE_OK;
}

/* Reads what is shown without what is kept. */
static tulle_status read_alone(const scene_sequence *sequence, frame_mix mix, double *positions,
                               tulle_error *error) {
    frame_cache cache = {0};
    memory heap = memory_default();
    size_t const size = 3 * sequence->vertex_count * sizeof(double);
    double *const next = mix.part > 0.0 ? memory_allocate(&heap, size) : NULL;
    tulle_status status = TULLE_OK;
    if (mix.part > 0.0 && !next)
        status = error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory for a frame");
    if (status == TULLE_OK) status = read_placed(sequence, &cache, mix.from, positions, error);
    if (status == TULLE_OK && next) status = read_placed(sequence, &cache, mix.to, next, error);
    if (status == TULLE_OK && next)
        mix_positions(mix.part, next, sequence->vertex_count, positions);
    memory_release(&heap, next, next ? size : 0);
    frame_cache_close(&cache);
    return status;
}

tulle_status sequence_read(void *context, uint32_t wanted, double *positions, tulle_error *error) {
    scene_sequence *sequence = context;
    if (wanted >= sequence_get_frame_count(sequence))
        return error_set(error, TULLE_ERROR_INVALID_ARGUMENT, "frame %u of a sequence of %u",
                         (unsigned)wanted, (unsigned)sequence_get_frame_count(sequence));
    frame_mix const mix = find_mix(sequence, wanted);
    /* While another world uses what is kept, this one reads the file for itself. */
    if (atomic_flag_test_and_set(&sequence->is_kept_in_use))
        return read_alone(sequence, mix, positions, error);
    const double *from, *next;
    tulle_status status = find_kept(sequence, mix.from, mix.to, &from, error);
    if (status == TULLE_OK && mix.part > 0.0)
        status = find_kept(sequence, mix.to, mix.from, &next, error);
    if (status == TULLE_OK) memcpy(positions, from, 3 * sequence->vertex_count * sizeof(double));
    if (status == TULLE_OK && mix.part > 0.0)
        mix_positions(mix.part, next, sequence->vertex_count, positions);
    atomic_flag_clear(&sequence->is_kept_in_use);
    return status;
}

uint32_t sequence_get_frame_count(const scene_sequence *sequence) {
    if (sequence->loop != LOOP_ONCE) return ENDLESS_FRAMES;
    if (!sequence->times) return sequence->frame_count;
    double const end = sequence->begin + sequence->times[sequence->frame_count - 1];
    double const count = 1.0 + ceil(fmax(end, 0.0) / sequence->interval);
    return (uint32_t)fmin(count, (double)ENDLESS_FRAMES);
}

double sequence_get_start(const scene_sequence *sequence) {
    return sequence->times ? 0.0 : sequence->begin;
}

double sequence_get_interval(const scene_sequence *sequence) { return sequence->interval; }

scene_sequence *sequence_place(const scene_work *work, const scene_sequence *origin,
                               const placement *where, double delay) {
    arena *storage = &work->scene->storage;
    scene_sequence *sequence = ARENA_NEW(storage, scene_sequence, 1);
    double *kept = ARENA_NEW(storage, double, 6 * origin->vertex_count);
    if (!sequence || !kept) {
        problem_add_memory(work->problems, work->scene->path);
        return NULL;
    }
    *sequence = *origin;
    sequence->open = (frame_cache){0};
    sequence->begin += delay;
    memcpy(sequence->scale, where->scale, sizeof sequence->scale);
    sequence->placement = where->turn;
    sequence->kept[0] = kept;
    sequence->kept[1] = kept + 3 * origin->vertex_count;
    sequence->kept_frame[0] = sequence->kept_frame[1] = TULLE_NONE;
    sequence->next_kept = 0;
    atomic_flag_clear(&sequence->is_kept_in_use);
    return sequence;
}

/* Finds the range of frames. False after a problem. */
static bool set_range(const scene_work *work, const sequence_keys *keys, uint64_t frames_there,
                      scene_sequence *sequence) {
    bool has_last = schema_is_given(&sequence_map, keys, "last");
    uint64_t last = has_last ? keys->last : frames_there > 0 ? frames_there - 1 : 0;
    const char *path = keys->head.path;
    if (keys->files && !has_last) {
        problem_add(work->problems, TULLE_ERROR_PARSE, keys->head.place,
                    "%s: the key 'last' is missing: number of the last file", path);
        return false;
    }
    if (last < keys->first || last - keys->first >= SCENE_SEQUENCE_LIMIT) {
        problem_add(work->problems, TULLE_ERROR_INVALID_ARGUMENT, schema_place(keys, "last"),
                    "%s.last: is %llu, must be at least first (%llu) and less than %d above", path,
                    (unsigned long long)last, (unsigned long long)keys->first,
                    SCENE_SEQUENCE_LIMIT);
        return false;
    }
    if (keys->cache && last >= frames_there) {
        problem_add(work->problems, TULLE_ERROR_INVALID_ARGUMENT, schema_place(keys, "last"),
                    "%s.last: is %llu, must be below %llu, the number of frames in the cache", path,
                    (unsigned long long)last, (unsigned long long)frames_there);
        return false;
    }
    sequence->first = keys->first;
    sequence->frame_count = (uint32_t)(last - keys->first + 1);
    return true;
}

/* ---- times ---- */

static bool lacks_times(const scene_work *work, const sequence_keys *keys, const char *why) {
    if (why)
        problem_add(work->problems, TULLE_ERROR_PARSE, keys->head.place,
                    "%s: needs one of the keys interval, fps: %s", keys->head.path, why);
    return false;
}

/* Tells where a file's own times are others than the scene's fps says. */
static void note_other_rate(const scene_work *work, const sequence_keys *keys,
                            const scene_sequence *sequence) {
    for (uint32_t i = 1; i < sequence->frame_count; i++) {
        double const even = i / (keys->fps * keys->speed);
        if (fabs(sequence->times[i] - even) <= SAME_TIME_SHARE * even) continue;
        note_add(
            work,
            "%s: fps %g is not used: the file's own times hold, and frame %llu is %.6g s after "
            "the first one; interval plays frames evenly",
            sequence->cache, keys->fps, (unsigned long long)(sequence->first + i),
            sequence->times[i] * keys->speed);
        return;
    }
}

/* Takes the times that the file has for its frames. False after a problem: it has none, or they do
 * not rise. */
static bool take_times(const scene_work *work, const sequence_keys *keys, const frame_cache *cache,
                       scene_sequence *sequence) {
    double *const times = ARENA_NEW(&work->scene->storage, double, sequence->frame_count);
    if (!times) {
        problem_add_memory(work->problems, work->scene->path);
        return false;
    }
    double first = 0.0;
    for (uint32_t i = 0; i < sequence->frame_count; i++) {
        uint32_t const frame = (uint32_t)sequence->first + i;
        double const time = frame_cache_get_time(cache, frame);
        if (i == 0) first = time;
        times[i] = (time - first) / keys->speed;
        if (i > 0 ? times[i] > times[i - 1] : isfinite(time)) continue;
        return lacks_times(work, keys,
                           store_text(work, "the times of '%s' do not rise: frame %u is at %g s",
                                      keys->cache, (unsigned)frame, time));
    }
    bool const is_placed = schema_is_given(&sequence_map, keys, "start") ||
                           schema_is_given(&sequence_map, keys, "first");
    sequence->times = times;
    sequence->begin = is_placed ? keys->start : (first - cache->start_time) / keys->speed;
    sequence->interval = work->scene->keys.time.step;
    work->scene->content_hash =
        hash_bytes(work->scene->content_hash, times, sequence->frame_count * sizeof *times);
    work->scene->content_hash =
        hash_bytes(work->scene->content_hash, &sequence->begin, sizeof sequence->begin);
    if (schema_is_given(&sequence_map, keys, "fps")) note_other_rate(work, keys, sequence);
    return true;
}

/* Finds when frames are shown: by the interval of the scene; else by the times of the file; else by
 * the fps of the scene, in whose frames a PC2 file has its start and its step. `cache`: null for
 * files. False after a problem. */
static bool set_times(const scene_work *work, const sequence_keys *keys, const frame_cache *cache,
                      scene_sequence *sequence) {
    bool const has_fps = schema_is_given(&sequence_map, keys, "fps");
    sequence->begin = keys->start;
    sequence->interval = keys->interval / keys->speed;
    if (schema_is_given(&sequence_map, keys, "interval")) return true;
    bool const has_times = cache && cache->has_times;
    if (has_times && (!has_fps || frame_cache_rises(cache)))
        return take_times(work, keys, cache, sequence);
    if (!has_fps)
        return lacks_times(work, keys,
                           !cache             ? "numbered files have no times"
                           : cache->animation ? "the file has no times"
                                              : "a PC2 file counts in frames");
    double const frame_step = cache ? cache->frame_step : 1.0;
    if (!(frame_step > 0.0))
        return lacks_times(work, keys,
                           store_text(work,
                                      "'%s' says that its frames are %g frames apart; interval "
                                      "says how far they are",
                                      keys->cache, frame_step));
    sequence->interval = frame_step / (keys->fps * keys->speed);
    if (cache && !schema_is_given(&sequence_map, keys, "start") &&
        !schema_is_given(&sequence_map, keys, "first"))
        sequence->begin = cache->start_frame / (keys->fps * keys->speed);
    if (cache)
        work->scene->content_hash =
            hash_bytes(work->scene->content_hash, &sequence->interval, sizeof sequence->interval);
    return true;
}

/* Unmarks the triangles that have an area in a frame, and extends the largest extent. `marks`: a
 * byte for each triangle, then room for as many. */
static tulle_status look_at_frame(tulle_mesh_view frame, uint8_t *marks, double *extent,
                                  tulle_error *error) {
    uint8_t *const here = marks + frame.triangle_count;
    for (size_t k = 0; k < 3; k++) {
        double low = INFINITY, high = -INFINITY;
        for (size_t v = 0; v < frame.vertex_count; v++) {
            low = fmin(low, frame.positions[3 * v + k]);
            high = fmax(high, frame.positions[3 * v + k]);
        }
        *extent = fmax(*extent, high - low);
    }
    if (!memchr(marks, 1, frame.triangle_count)) return TULLE_OK;
    tulle_status const status = tulle_mesh_find_degenerate(frame, here, NULL, error);
    for (size_t t = 0; status == TULLE_OK && t < frame.triangle_count; t++) marks[t] &= here[t];
    return status;
}

/* Reads all files, compares their triangles or polygons with the mesh's, adds them to the hash. The
 * cut of polygons is that of the mesh in all frames. */
static tulle_status check_files(const scene_work *work, scene_sequence *sequence, source_mesh *made,
                                uint8_t *marks, tulle_error *error) {
    tulle_scene *const loaded = work->scene;
    tulle_mesh *const mesh = made->mesh;
    sequence->vertex_count = mesh->vertex_count;
    for (uint32_t frame = 0; frame < sequence->frame_count; frame++) {
        tulle_mesh read = {0};
        uint64_t polygons_hash;
        tulle_status status = read_file(sequence, frame, &read, &polygons_hash, error);
        if (status != TULLE_OK) return status;
        loaded->content_hash = hash_bytes(loaded->content_hash, read.positions,
                                          3 * read.vertex_count * sizeof(double));
        bool is_same = read.triangle_count == mesh->triangle_count &&
                       memcmp(read.triangles, mesh->triangles,
                              3 * read.triangle_count * sizeof(uint32_t)) == 0;
        is_same = is_same || (polygons_hash != 0 && polygons_hash == made->polygons_hash &&
                              read.vertex_count == mesh->vertex_count);
        tulle_mesh_view const view = {read.positions, read.vertex_count, mesh->triangles,
                                      mesh->triangle_count};
        if (frame == 0 && is_same)
            memcpy(mesh->positions, read.positions, 3 * read.vertex_count * sizeof(double));
        if (is_same) status = look_at_frame(view, marks, &made->extent, error);
        tulle_mesh_destroy(&read);
        if (status != TULLE_OK) return status;
        char path[SCENE_PATH_LIMIT];
        if (!is_same &&
            write_file_name(sequence->files, sequence->first + frame, path, sizeof path))
            return error_set_at(error, TULLE_ERROR_INVALID_MESH, path, 0, 0,
                                "its triangles differ from the frames before: all frames "
                                "of a mesh sequence have the same vertices and triangles");
    }
    return TULLE_OK;
}

/* Reads all frames of a cache; the mesh gets the first one. */
static tulle_status check_cache(tulle_scene *loaded, scene_sequence *sequence, source_mesh *made,
                                uint8_t *marks, tulle_error *error) {
    tulle_mesh *const mesh = made->mesh;
    sequence->vertex_count = mesh->vertex_count;
    for (uint32_t frame = sequence->frame_count; frame-- > 0;) {
        tulle_status status = read_frame(sequence, &sequence->open, frame, mesh->positions, error);
        if (status != TULLE_OK) return status;
        loaded->content_hash = hash_bytes(loaded->content_hash, mesh->positions,
                                          3 * mesh->vertex_count * sizeof(double));
        status = look_at_frame(tulle_mesh_get_view(mesh), marks, &made->extent, error);
        if (status != TULLE_OK) return status;
    }
    return TULLE_OK;
}

/* Reads all frames. Triangles that have no area in any of them are left out; those that have one in
 * some of them guard there. */
static tulle_status check_frames(const scene_work *work, scene_sequence *sequence,
                                 source_mesh *made, tulle_error *error) {
    tulle_mesh *const mesh = made->mesh;
    memory *const heap = &work->scene->heap;
    size_t const count = mesh->triangle_count;
    uint8_t *const marks = memory_allocate(heap, 2 * count);
    if (!marks && count > 0)
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory to look at %zu triangles",
                         count);
    if (count > 0) memset(marks, 1, count);
    tulle_status status = sequence->cache ? check_cache(work->scene, sequence, made, marks, error)
                                          : check_files(work, sequence, made, marks, error);
    flat_triangles const flat = {marks, " in any frame", NULL};
    if (status == TULLE_OK)
        status = drop_flat(work, sequence->cache ? sequence->cache : sequence->files, mesh, &flat,
                           error);
    memory_release(heap, marks, 2 * count);
    if (status != TULLE_OK) return status;
    return tulle_mesh_validate(tulle_mesh_get_view(mesh), TULLE_MESH_ROLE_DEFORMING, error);
}

/* Takes the obstacle's mesh from an animation, where it has none of its own. */
static tulle_status take_mesh(const scene_work *work, const scene_sequence *sequence,
                              frame_cache *cache, tulle_mesh *mesh, tulle_error *error) {
    tulle_mesh_source source = {0};
    tulle_status const status = frame_cache_make_mesh(cache, 0, mesh, error);
    return status == TULLE_OK ? drop_duplicates(work, sequence->cache, mesh, &source, error)
                              : status;
}

/* Tells where the triangles of an animation are others than those of the mesh that the scene gives.
 */
static void compare_triangles(const scene_work *work, const char *path, const frame_cache *cache,
                              const tulle_mesh *mesh) {
    size_t const count = cache->triangle_count;
    if (count == 0 || (count == mesh->triangle_count &&
                       memcmp(tulle_animation_get_triangles(cache->animation), mesh->triangles,
                              3 * count * sizeof *mesh->triangles) == 0))
        return;
    note_add(work,
             "%s: its %zu triangles are not used: the obstacle has the key 'mesh', with %zu; "
             "without that key the file's own are taken",
             path, count, mesh->triangle_count);
}

/* Opens the cache for its counts. False after a problem. */
static bool begin_cache(const scene_work *work, const sequence_keys *keys, source_mesh *made,
                        scene_sequence *sequence) {
    tulle_mesh *const mesh = made->mesh;
    tulle_error error = {0};
    frame_cache cache;
    tulle_status status = frame_cache_open(sequence->cache, &cache, &error);
    if (cache.note[0]) note_add(work, "%s: %s", sequence->cache, cache.note);
    bool const has_own_mesh = mesh->vertex_count > 0;
    if (status == TULLE_OK && !has_own_mesh && cache.animation)
        status = take_mesh(work, sequence, &cache, mesh, &error);
    if (status == TULLE_OK && cache.vertex_count != mesh->vertex_count)
        status = error_set_at(&error, TULLE_ERROR_INVALID_MESH, sequence->cache, 0, 0,
                              "has %zu vertices, must have %zu as the obstacle's mesh",
                              cache.vertex_count, mesh->vertex_count);
    if (status == TULLE_OK && has_own_mesh && cache.animation)
        compare_triangles(work, sequence->cache, &cache, mesh);
    bool is_good = status == TULLE_OK;
    if (!is_good)
        problem_add_error(work->problems, schema_place(keys, "cache"), keys->head.path, &error);
    is_good = is_good && set_range(work, keys, cache.frame_count, sequence) &&
              set_times(work, keys, &cache, sequence);
    if (cache.animation) made->axes = cache.axes;
    made->is_of_file = true;
    frame_cache_close(&cache);
    return is_good;
}

/* Opens the first file for the mesh, where the obstacle has none. False after a problem. */
static bool begin_files(const scene_work *work, const sequence_keys *keys, source_mesh *made,
                        scene_sequence *sequence) {
    char path[SCENE_PATH_LIMIT];
    if (!write_file_name(sequence->files, 0, path, sizeof path)) {
        problem_add(work->problems, TULLE_ERROR_PARSE, schema_place(keys, "files"),
                    "%s.files: is '%s', must hold one number as %%d or %%03d, as in body_%%02d.obj",
                    keys->head.path, show_text(keys->files).text);
        return false;
    }
    if (!set_range(work, keys, 0, sequence) || !set_times(work, keys, NULL, sequence)) return false;
    tulle_error error = {0};
    if (made->mesh->vertex_count > 0 ||
        !write_file_name(sequence->files, sequence->first, path, sizeof path) ||
        read_mesh(work, path, TULLE_MESH_ROLE_DEFORMING, made, NULL, &error) == TULLE_OK)
        return true;
    problem_add_error(work->problems, schema_place(keys, "files"), keys->head.path, &error);
    return false;
}

/* ---- loops ---- */

/* How far the vertices move, unplaced. */
typedef struct sequence_steps {
    double largest; /* [m] between frames that follow each other */
    double seam;    /* [m] from the last to the first */
    size_t seam_vertex;
} sequence_steps;

static double find_largest_step(const double *from, const double *to, size_t vertex_count,
                                size_t *vertex) {
    double largest = 0.0;
    *vertex = 0;
    for (size_t v = 0; v < vertex_count; v++) {
        const double *const a = from + 3 * v, *const b = to + 3 * v;
        double const step = hypot(hypot(b[0] - a[0], b[1] - a[1]), b[2] - a[2]);
        if (step > largest) largest = step, *vertex = v;
    }
    return largest;
}

/* `room`: for the positions of three frames. */
static tulle_status measure_steps(scene_sequence *sequence, double *room, sequence_steps *steps,
                                  tulle_error *error) {
    size_t const count = 3 * sequence->vertex_count;
    double *const first = room, *before = room + count, *now = room + 2 * count;
    size_t vertex;
    *steps = (sequence_steps){0};
    tulle_status status = read_frame(sequence, &sequence->open, 0, first, error);
    memcpy(before, first, count * sizeof *first);
    for (uint32_t frame = 1; status == TULLE_OK && frame < sequence->frame_count; frame++) {
        status = read_frame(sequence, &sequence->open, frame, now, error);
        if (status != TULLE_OK) break;
        steps->largest =
            fmax(steps->largest, find_largest_step(before, now, sequence->vertex_count, &vertex));
        double *const spare = before;
        before = now;
        now = spare;
    }
    steps->seam = find_largest_step(before, first, sequence->vertex_count, &steps->seam_vertex);
    return status;
}

static bool refuse_loop(const scene_work *work, const sequence_keys *keys, const char *text) {
    if (text)
        problem_add(work->problems, TULLE_ERROR_INVALID_ARGUMENT, schema_place(keys, "loop"),
                    "%s.loop: %s", keys->head.path, text);
    return false;
}

/* Whether the ends meet, and how long a round is. False after a problem. */
static bool join_ends(const scene_work *work, const sequence_keys *keys, scene_sequence *sequence) {
    memory *const heap = &work->scene->heap;
    size_t const bytes = 9 * sequence->vertex_count * sizeof(double);
    double *const room = memory_allocate_zeroed(heap, 9 * sequence->vertex_count, sizeof *room);
    if (!room) {
        problem_add_memory(work->problems, work->scene->path);
        return false;
    }
    sequence_steps steps;
    tulle_error error = {0};
    tulle_status const status = measure_steps(sequence, room, &steps, &error);
    memory_release(heap, room, bytes);
    if (status != TULLE_OK) {
        problem_add_error(work->problems, schema_place(keys, "loop"), keys->head.path, &error);
        return false;
    }
    if (steps.seam <= SAME_FRAME_SHARE * steps.largest)
        sequence->period = sequence->frame_count - 1;
    else if (!(steps.seam <= SEAM_STEP_RATIO * steps.largest))
        return refuse_loop(
            work, keys,
            store_text(work,
                       "the ends do not meet: from the last frame to the first vertex %zu goes "
                       "%.3g m, between other frames none goes more than %.3g m; with pingpong "
                       "they need not meet",
                       steps.seam_vertex, steps.seam, steps.largest));
    else if (sequence->times)
        sequence->seam =
            sequence->times[sequence->frame_count - 1] / (double)(sequence->frame_count - 1);
    return true;
}

static bool set_loop(const scene_work *work, const sequence_keys *keys, scene_sequence *sequence) {
    sequence->period = sequence->frame_count;
    sequence->loop = (sequence_loop)keys->loop;
    if (sequence->loop == LOOP_ONCE) return true;
    if (sequence->frame_count < 2)
        return refuse_loop(work, keys, "there is one frame only, a loop needs two at least");
    if (sequence->loop == LOOP_REPEAT) return join_ends(work, keys, sequence);
    sequence->period = 2 * (sequence->frame_count - 1);
    return true;
}

void sequence_close(scene_sequence *sequence) {
    if (sequence) frame_cache_close(&sequence->open);
}

/* Tells where a scene is over before much of the way to the second frame. */
static void note_slow(const scene_work *work, const scene_sequence *sequence, const char *path) {
    if (sequence->frame_count < 2) return;
    double const way = sequence->times ? sequence->times[1] : sequence->interval;
    if (sequence->begin + MUCH_OF_A_FRAME * way >= scene_get_end(work))
        note_late(work, path, "its second frame comes", sequence->begin + way);
}

scene_sequence *sequence_open(const scene_work *work, const obstacle_keys *keys,
                              source_mesh *made) {
    const sequence_keys *from = &keys->motion.sequence;
    scene_sequence *sequence = ARENA_NEW_ZEROED(&work->scene->storage, scene_sequence, 1);
    if (!sequence) {
        problem_add_memory(work->problems, work->scene->path);
        return NULL;
    }
    bool has_files = schema_is_given(&sequence_map, from, "files");
    const char *path = resolve_path(work, has_files ? from->files : from->cache);
    if (!path) return NULL;
    sequence->files = has_files ? path : NULL;
    sequence->cache = has_files ? NULL : path;
    bool const is_begun = has_files ? begin_files(work, from, made, sequence)
                                    : begin_cache(work, from, made, sequence);
    if (!is_begun) return NULL;
    tulle_error error = {0};
    tulle_status status = check_frames(work, sequence, made, &error);
    bool const is_whole = status == TULLE_OK && set_loop(work, from, sequence);
    sequence_close(sequence);
    if (is_whole) note_slow(work, sequence, path);
    if (status == TULLE_OK) return is_whole ? sequence : NULL;
    if (!error.file[0]) snprintf(error.file, sizeof error.file, "%s", path);
    problem_add_error(work->problems, schema_place(from, has_files ? "files" : "cache"),
                      from->head.path, &error);
    return NULL;
}
