/* app/check/run.c - see run.h. */
#include "app/check/run.h"

#include "app/check/slots.h"
#include "app/cli/run_damage.h"
#include "app/commands.h"
#include "base/arena.h"
#include "base/error.h"
#include "base/parallel.h"
#include "tulle_io/run.h"

#include <stdio.h>

typedef struct run_check {
    const char *directory;
    tulle_run_reader *reader;
    const tulle_run_info *info;
    frame_range range;       /* the frames that are judged */
    tulle_mesh_view *meshes; /* of every body, as its OBJ file holds it */
    check_slots slots;
    double **positions; /* of each slot and body; null for static bodies */
} run_check;

static tulle_status report_memory(const run_check *self, tulle_error *error) {
    return error_set_at(error, TULLE_ERROR_OUT_OF_MEMORY, self->directory, 0, 0,
                        "no memory for %zu frames; use fewer threads", self->slots.count);
}

static bool allocate_slot(run_check *self, arena *scratch, size_t slot) {
    size_t const body_count = self->info->body_count;
    check_frame *const frame = &self->slots.frames[slot];
    frame->bodies = ARENA_NEW_ZEROED(scratch, tulle_check_body, body_count);
    frame->names = ARENA_NEW_ZEROED(scratch, const char *, body_count);
    if (!frame->bodies || !frame->names) return false;
    for (size_t body = 0; body < body_count; body++) {
        if (self->info->bodies[body].is_static) continue;
        double *const positions = ARENA_NEW(scratch, double, 3 * self->meshes[body].vertex_count);
        if (!positions) return false;
        self->positions[slot * body_count + body] = positions;
    }
    return true;
}

static tulle_status open_run(run_check *self, const char *frames, arena *scratch,
                             tulle_error *error) {
    size_t const body_count = self->info->body_count;
    if (self->info->frame_count == 0)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, self->directory, 0, 0,
                            "the run holds no whole frame yet, so there is nothing to judge");
    tulle_status status = frame_range_read(NULL, frames, frame_range_make(self->info->frame_count),
                                           &self->range, error);
    if (status != TULLE_OK) return status;
    size_t const slot_count = check_slots_count(self->range, self->slots.threads);
    self->slots.count = slot_count;
    self->meshes = ARENA_NEW_ZEROED(scratch, tulle_mesh_view, body_count);
    self->slots.frames = ARENA_NEW_ZEROED(scratch, check_frame, slot_count);
    self->positions = ARENA_NEW_ZEROED(scratch, double *, slot_count *body_count);
    if (!self->meshes || !self->slots.frames || !self->positions) return report_memory(self, error);
    for (size_t body = 0; body < body_count; body++) {
        status = tulle_run_reader_get_mesh(self->reader, body, &self->meshes[body], error);
        if (status != TULLE_OK) return status;
    }
    for (size_t slot = 0; slot < slot_count; slot++)
        if (!allocate_slot(self, scratch, slot)) return report_memory(self, error);
    return TULLE_OK;
}

/* Fills slot number `slot` with the frame. */
static tulle_status read_frame(void *context, size_t slot, uint32_t number, tulle_error *error) {
    run_check *const self = context;
    check_frame *const frame = &self->slots.frames[slot];
    frame->source = self->directory;
    frame->number = (long)number;
    frame->body_count = 0;
    tulle_status status =
        tulle_run_reader_get_frame(self->reader, number, &frame->time, NULL, NULL);
    if (status != TULLE_OK)
        return error_set_at(error, status, self->directory, 0, 0, "frame %u cannot be read",
                            (unsigned)number);
    frame->run_bodies = self->info->bodies;
    (void)tulle_run_reader_get_lags(self->reader, number, &frame->lags, &frame->lag_count);
    for (size_t body = 0; body < self->info->body_count; body++) {
        const tulle_run_body_info *const info = &self->info->bodies[body];
        if (!tulle_run_reader_is_present(self->reader, number, body)) continue;
        tulle_mesh_view mesh = self->meshes[body];
        double *const positions = self->positions[slot * self->info->body_count + body];
        if (positions) {
            status = tulle_run_reader_read_positions(self->reader, number, body, positions, error);
            if (status != TULLE_OK) return status;
            mesh.positions = positions;
        }
        frame->names[frame->body_count] = info->name;
        frame->bodies[frame->body_count++] =
            (tulle_check_body){mesh, info->is_obstacle && !info->is_dynamic};
    }
    return TULLE_OK;
}

tulle_status check_run_directory(const char *directory, check_run_choice choice,
                                 const check_report *report, check_totals *totals,
                                 tulle_error *error) {
    run_check self = {.directory = directory,
                      .slots = {.source = directory,
                                .threads = parallel_resolve_threads(choice.threads),
                                .read = read_frame,
                                .context = &self}};
    tulle_status status = tulle_run_reader_open(directory, &self.reader, error);
    if (status != TULLE_OK) return status;
    self.info = tulle_run_reader_get_info(self.reader);
    memory heap = memory_default();
    arena scratch = arena_make(&heap);
    /* Some frames alone are compared with their checksums as they are read. */
    if (!choice.frames) status = run_damage_report("check", directory, self.reader, error);
    if (status == TULLE_OK) status = open_run(&self, choice.frames, &scratch, error);
    if (status == TULLE_OK)
        status = check_slots_judge(&self.slots, self.range, report, totals, error);
    arena_destroy(&scratch);
    tulle_run_reader_close(self.reader);
    return status;
}
