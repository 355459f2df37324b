/* app/check/animation.c - see animation.h. */
#define _POSIX_C_SOURCE 200809L
#include "app/check/animation.h"

#include "app/check/slots.h"
#include "app/check/weld.h"
#include "app/cli/axes.h"
#include "app/commands.h"
#include "app/convert/names.h"
#include "app/convert/source.h"
#include "base/arena.h"
#include "base/error.h"
#include "base/parallel.h"

#include <math.h>
#include <string.h>
#include <sys/stat.h>

typedef struct animation_check {
    const check_animation_choice *choice;
    convert_source *sources; /* of each file */
    axes_change *changes;    /* of each file: to the axes and unit of the first */
    axes_change to_scene;    /* from those of the first */
    tulle_mesh_view *meshes; /* of each file, with triangles whose corners may be joined */
    frame_range range;       /* the frames that are judged */
    size_t leader;           /* the file whose frames are counted */
    double **positions;      /* of each slot and file */
    check_frame *frames;     /* of each slot */
    arena scratch;
} animation_check;

bool check_is_animation(const char *path) {
    struct stat facts;
    convert_format const format = convert_get_format(path);
    if (convert_is_cache(format) || convert_is_scene(format)) return true;
    return name_pattern_is_meant(path) && stat(path, &facts) != 0;
}

static bool is_still(const convert_source *source) {
    return frame_range_get_count(source->frames) == 1;
}

/* ---- files ---- */

static tulle_status open_source(const check_file *file, convert_source *source,
                                tulle_error *error) {
    source_options const options = {.path = file->path, .mesh_path = file->mesh_path};
    tulle_status const status = convert_source_open(&options, source, error);
    if (status != TULLE_OK) return status;
    if (source->mesh.triangle_count == 0)
        return error_set_at(error, TULLE_ERROR_INVALID_MESH, file->path, 0, 0,
                            "holds no triangles, so there is nothing to judge%s",
                            source->kind == SOURCE_CACHE
                                ? "; --mesh names the mesh that the point cache moves"
                                : "");
    return TULLE_OK;
}

static tulle_status open_sources(animation_check *self, tulle_error *error) {
    const check_animation_choice *const choice = self->choice;
    axes_frame first = {"z", "m"};
    for (size_t i = 0; i < choice->file_count; i++) {
        axes_frame own;
        tulle_status status = open_source(&choice->files[i], &self->sources[i], error);
        if (status == TULLE_OK && choice->file_count > 1)
            status =
                convert_source_find_axes(&self->sources[i], (axes_frame){NULL, NULL}, &own, error);
        else
            own = first;
        if (status != TULLE_OK) return status;
        if (i == 0) first = own;
        self->changes[i] = axes_change_make(own, first);
        self->meshes[i] = tulle_mesh_get_view(&self->sources[i].mesh);
        if (is_still(&self->sources[self->leader])) self->leader = i;
    }
    self->to_scene = convert_source_find_scene_change(&self->sources[0]);
    return TULLE_OK;
}

static tulle_status choose_frames(animation_check *self, tulle_error *error) {
    const convert_source *const leader = &self->sources[self->leader];
    uint32_t const count = frame_range_get_count(leader->frames);
    for (size_t i = 0; i < self->choice->file_count; i++) {
        const convert_source *const source = &self->sources[i];
        uint32_t const own = frame_range_get_count(source->frames);
        if (source->needs_frames_named && !self->choice->frames)
            return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, source->path, 0, 0,
                                "there is no file of number %u; --frames names those to be judged",
                                source->gap);
        if (own != 1 && own != count)
            return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, source->path, 0, 0,
                                "has %u frames, but %s has %u; files that are judged together have "
                                "as many frames, or one",
                                own, leader->path, count);
    }
    return frame_range_read(NULL, self->choice->frames, leader->frames, &self->range, error);
}

/* ---- frames ---- */

/* Reads what file `index` has at frame `number` of the leader. */
static tulle_status read_file(animation_check *self, size_t index, uint32_t number,
                              double *positions, tulle_error *error) {
    convert_source *const source = &self->sources[index];
    const convert_source *const leader = &self->sources[self->leader];
    uint32_t const place = (number - leader->frames.first) / leader->frames.step;
    uint32_t const frame = frame_range_get(source->frames, is_still(source) ? 0 : place);
    tulle_status const status = convert_source_read(source, frame, positions, error);
    if (status == TULLE_OK) axes_apply(&self->changes[index], positions, source->mesh.vertex_count);
    return status;
}

static tulle_status read_frame(void *context, size_t slot, uint32_t number, tulle_error *error) {
    animation_check *const self = context;
    const check_animation_choice *const choice = self->choice;
    convert_source *const leader = &self->sources[self->leader];
    check_frame *const frame = &self->frames[slot];
    frame->number = (long)number;
    frame->time = (double)NAN;
    tulle_status status = TULLE_OK;
    if (convert_get_format(leader->path) != CONVERT_PC2) /* which counts in frames */
        status = convert_source_find_time(leader, number, &frame->time, error);
    for (size_t i = 0; i < choice->file_count && status == TULLE_OK; i++) {
        double *const positions = self->positions[slot * choice->file_count + i];
        tulle_mesh_view mesh = self->meshes[i];
        mesh.positions = positions;
        frame->names[i] = choice->files[i].path;
        frame->bodies[i] = (tulle_check_body){mesh, i >= choice->cloth_count};
        status = read_file(self, i, number, positions, error);
    }
    return status;
}

/* What lies in the same place in all frames of a file: joined, or told. */
static tulle_status weld_file(animation_check *self, size_t index, double *positions,
                              tulle_error *error) {
    tulle_mesh_view *const mesh = &self->meshes[index];
    uint32_t const count = frame_range_get_count(self->range);
    bool const is_moving = !is_still(&self->sources[index]);
    check_weld weld = {0};
    tulle_status status = TULLE_OK;
    for (uint32_t i = 0; i < count && (i == 0 || is_moving) && status == TULLE_OK; i++) {
        status = read_file(self, index, frame_range_get(self->range, i), positions, error);
        if (status == TULLE_OK && i == 0)
            status = check_weld_open(positions, mesh->vertex_count, &weld, error);
        else if (status == TULLE_OK)
            check_weld_part(&weld, positions);
        if (!self->choice->welds) break; /* the first frame tells whether a word is worth while */
    }
    if (status == TULLE_OK && self->choice->welds) {
        uint32_t *const corners = ARENA_NEW(&self->scratch, uint32_t, 3 * mesh->triangle_count);
        if (!corners)
            status = error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory for %zu triangles",
                               mesh->triangle_count);
        for (size_t i = 0; i < 3 * mesh->triangle_count && corners; i++)
            corners[i] = weld.same[mesh->triangles[i]];
        mesh->triangles = corners;
    } else if (status == TULLE_OK && check_weld_count(&weld) > 0) {
        app_print_message("check",
                          "%s: %zu vertices are in the place of others; what touches there counts, "
                          "and --weld makes one of those that stay together",
                          self->choice->files[index].path, check_weld_count(&weld));
    }
    check_weld_close(&weld);
    return status;
}

/* Joins or tells of seams, where a format has them. */
static tulle_status weld(animation_check *self, tulle_error *error) {
    size_t const file_count = self->choice->file_count;
    for (size_t i = 0; i < file_count; i++) {
        bool const has_seams = self->sources[i].kind == SOURCE_ANIMATION;
        if (!has_seams && !self->choice->welds) continue;
        tulle_status const status = weld_file(self, i, self->positions[i], error);
        if (status != TULLE_OK) return status;
    }
    return TULLE_OK;
}

static bool allocate_slots(animation_check *self, size_t slot_count) {
    size_t const file_count = self->choice->file_count;
    arena *const scratch = &self->scratch;
    self->frames = ARENA_NEW_ZEROED(scratch, check_frame, slot_count);
    self->positions = ARENA_NEW_ZEROED(scratch, double *, slot_count *file_count);
    if (!self->frames || !self->positions) return false;
    for (size_t slot = 0; slot < slot_count; slot++) {
        check_frame *const frame = &self->frames[slot];
        frame->source =
            self->choice->cloth_count > 1 ? "all files together" : self->choice->files[0].path;
        frame->bodies = ARENA_NEW_ZEROED(scratch, tulle_check_body, file_count);
        frame->names = ARENA_NEW_ZEROED(scratch, const char *, file_count);
        frame->body_count = file_count;
        frame->to_scene = &self->to_scene;
        if (!frame->bodies || !frame->names) return false;
        for (size_t i = 0; i < file_count; i++) {
            double *const positions =
                ARENA_NEW(scratch, double, 3 * self->sources[i].mesh.vertex_count);
            if (!positions) return false;
            self->positions[slot * file_count + i] = positions;
        }
    }
    return true;
}

static tulle_status judge(animation_check *self, const check_report *report, check_totals *totals,
                          tulle_error *error) {
    int const threads = parallel_resolve_threads(self->choice->threads);
    size_t const slot_count = check_slots_count(self->range, threads);
    if (!allocate_slots(self, slot_count))
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY,
                         "no memory for %zu frames; use fewer threads", slot_count);
    tulle_status const status = weld(self, error);
    if (status != TULLE_OK) return status;
    check_slots slots = {.source = self->frames[0].source,
                         .frames = self->frames,
                         .count = slot_count,
                         .threads = threads,
                         .read = read_frame,
                         .context = self};
    return check_slots_judge(&slots, self->range, report, totals, error);
}

tulle_status check_animations(const check_animation_choice *choice, const check_report *report,
                              check_totals *totals, tulle_error *error) {
    memory heap = memory_default();
    animation_check self = {.choice = choice, .scratch = arena_make(&heap)};
    self.sources = ARENA_NEW_ZEROED(&self.scratch, convert_source, choice->file_count);
    self.changes = ARENA_NEW_ZEROED(&self.scratch, axes_change, choice->file_count);
    self.meshes = ARENA_NEW_ZEROED(&self.scratch, tulle_mesh_view, choice->file_count);
    tulle_status status = TULLE_OK;
    if (!self.sources || !self.changes || !self.meshes)
        status = error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory for %zu files",
                           choice->file_count);
    if (status == TULLE_OK) status = open_sources(&self, error);
    if (status == TULLE_OK) status = choose_frames(&self, error);
    if (status == TULLE_OK) status = judge(&self, report, totals, error);
    for (size_t i = 0; self.sources && i < choice->file_count; i++)
        convert_source_close(&self.sources[i]);
    arena_destroy(&self.scratch);
    return status;
}
