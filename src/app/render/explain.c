/* app/render/explain.c - see explain.h. */
#include "app/render/explain.h"

#include "base/error.h"
#include "base/hash.h"
#include "base/sort.h"
#include "render/rest_coordinates.h"
#include "render/strain.h"
#include "render/surface_gap.h"

#include "tulle_io/subdivision.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SCALE_SAMPLES = 7 /* frames that are looked at for the scale */ };
static const double GAP_FARTHEST = 0.1;   /* [m] beyond, nothing is near */
static const double GAP_SMALLEST = 1e-7;  /* [m] where the scale begins at the lowest */
static const double STRAIN_SHARE = 0.995; /* of the vertices that the scale of strains holds */
static const double MARK_SIZE = 0.25;     /* radius of a contact's ball, of the mean edge */
static const double OPEN_SIZE = 0.6;      /* of the others, of those that carry no load */
static const double PER_CENT = 100.0;
static const float PALE_FRONT[3] = {0.40f, 0.40f, 0.39f}, PALE_BACK[3] = {0.32f, 0.33f, 0.35f};

static tulle_status fail_memory(tulle_error *error) {
    return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for the colors");
}

static bool is_gradient(picture_color color) {
    return color == PICTURE_GAP || color == PICTURE_VELOCITY || color == PICTURE_STRAIN;
}

/* ---- numbers at the vertices ---- */

static tulle_status read_debug(picture_run *run, const tulle_run_debug **debug,
                               tulle_error *error) {
    *debug = NULL;
    return tulle_run_reader_read_debug(run->reader, run->frame, debug, error);
}

static tulle_status compute_speeds(picture_explanation *self, picture_run *run,
                                   tulle_error *error) {
    const tulle_run_debug *debug = NULL;
    tulle_status const status = read_debug(run, &debug, error);
    if (status != TULLE_OK) return status;
    for (size_t i = 0; i < run->cloth_count; i++) {
        const double *const v = debug ? debug->velocities[i] : NULL;
        for (size_t k = 0; k < run->bodies[i].mesh.vertex_count; k++)
            self->values[i][k] = v ? sqrt(v[3 * k] * v[3 * k] + v[3 * k + 1] * v[3 * k + 1] +
                                          v[3 * k + 2] * v[3 * k + 2])
                                   : (double)NAN;
    }
    return TULLE_OK;
}

static tulle_status measure_gaps(picture_explanation *self, picture_run *run, tulle_error *error) {
    size_t count = 0;
    render_gap_surface *const surfaces =
        memory_allocate_zeroed(&self->heap, run->body_count, sizeof *surfaces);
    if (!surfaces) return fail_memory(error);
    for (size_t i = 0; i < run->body_count; i++) {
        const picture_body *const body = &run->bodies[i];
        if (!body->is_present) continue;
        surfaces[count] = (render_gap_surface){.mesh = body->mesh};
        if (!body->is_obstacle) { /* cloths are always there, so `count` is their index */
            surfaces[count].rest = body->rest.positions;
            surfaces[count].pieces = self->pieces[i];
            surfaces[count].piece_count = self->piece_counts[i];
        }
        count++;
    }
    render_gap_def const def = {.surfaces = surfaces,
                                .surface_count = count,
                                .farthest = GAP_FARTHEST,
                                .threads = run->options->threads};
    tulle_status const status = render_measure_gaps(&self->heap, &def, self->values, error);
    memory_release(&self->heap, surfaces, run->body_count * sizeof *surfaces);
    return status;
}

static void compute_strains(picture_explanation *self, const picture_run *run) {
    for (size_t i = 0; i < run->cloth_count; i++) {
        const picture_body *const body = &run->bodies[i];
        render_get_vertex_strains(body->rest, body->mesh.positions, self->values[i],
                                  self->scratch[i]);
        for (size_t k = 0; k < body->mesh.vertex_count; k++) self->values[i][k] *= PER_CENT;
    }
}

/* Fills self->values for the frame that was read last. */
static tulle_status compute_values(picture_explanation *self, picture_run *run,
                                   tulle_error *error) {
    if (self->color == PICTURE_VELOCITY) return compute_speeds(self, run, error);
    if (self->color == PICTURE_GAP) return measure_gaps(self, run, error);
    compute_strains(self, run);
    return TULLE_OK;
}

/* ---- the scale ---- */

/* The magnitude that all but a few values stay under. */
static double get_most_magnitudes(const picture_explanation *self, size_t body, size_t count) {
    double *const sorted = self->scratch[body];
    for (size_t k = 0; k < count; k++) sorted[k] = fabs(self->values[body][k]);
    qsort(sorted, count, sizeof *sorted, compare_doubles);
    return count > 0 ? sorted[(size_t)(STRAIN_SHARE * (double)(count - 1))] : 0.0;
}

/* The next of 1, 2, 5 times a power of ten, from above. */
static double round_up(double value) {
    double const power = pow(10.0, floor(log10(value)));
    double const digits = value / power;
    return power * (digits <= 1.0 ? 1.0 : digits <= 2.0 ? 2.0 : digits <= 5.0 ? 5.0 : 10.0);
}

static void set_scale(picture_explanation *self, double least, double most) {
    self->scale = (tick_scale){.low = 0.0};
    if (self->color == PICTURE_GAP) {
        double const low = fmin(fmax(least, GAP_SMALLEST), 0.1 * GAP_FARTHEST);
        self->scale = (tick_scale){.low = pow(10.0, floor(log10(low))),
                                   .high = GAP_FARTHEST,
                                   .is_logarithmic = true,
                                   .has_prefixes = true,
                                   .unit = "m"};
    } else if (self->color == PICTURE_VELOCITY) {
        self->scale.high = round_up(fmax(most, 1e-3));
        self->scale.unit = "m/s";
    } else {
        self->scale.high = round_up(fmax(most, 1e-2));
        self->scale.low = -self->scale.high;
        self->scale.unit = "%";
    }
}

static tulle_status survey(picture_explanation *self, picture_run *run, tulle_error *error) {
    double least = (double)INFINITY, most = 0.0;
    uint32_t const count = picture_run_get_sample_count(run, SCALE_SAMPLES);
    for (uint32_t sample = 0; sample < count; sample++) {
        uint32_t const frame = picture_run_get_sample(run, SCALE_SAMPLES, sample);
        tulle_status status = picture_run_read_frame(run, frame, error);
        if (status == TULLE_OK) status = compute_values(self, run, error);
        if (status != TULLE_OK) return status;
        for (size_t i = 0; i < run->cloth_count; i++) {
            size_t const vertex_count = run->bodies[i].mesh.vertex_count;
            for (size_t k = 0; k < vertex_count; k++) least = fmin(least, self->values[i][k]);
            if (self->color == PICTURE_STRAIN)
                most = fmax(most, get_most_magnitudes(self, i, vertex_count));
            else
                for (size_t k = 0; k < vertex_count; k++) most = fmax(most, self->values[i][k]);
        }
    }
    set_scale(self, least, most);
    return TULLE_OK;
}

/* ---- opening ---- */

/* Arrays of one body; false when memory is short. */
static bool allocate_body(picture_explanation *self, picture_run *run, size_t i) {
    arena *const storage = &run->storage;
    const picture_body *const body = &run->bodies[i];
    if (self->color == PICTURE_PATCHES) {
        self->patch_colors[i] = ARENA_NEW(storage, float, 3 * body->mesh.triangle_count + 1);
        self->triangle_colors[i] = self->patch_colors[i];
        if (body->subdivision)
            self->triangle_colors[i] = ARENA_NEW(storage, float, 3 * body->drawn.triangle_count);
        return self->patch_colors[i] && self->triangle_colors[i];
    }
    if (!is_gradient(self->color)) return true;
    self->values[i] = ARENA_NEW(storage, double, body->mesh.vertex_count + 1);
    self->scratch[i] = ARENA_NEW(storage, double, body->mesh.vertex_count + 1);
    self->drawn_values[i] = self->values[i];
    if (body->subdivision)
        self->drawn_values[i] = ARENA_NEW(storage, double, body->drawn.vertex_count + 1);
    self->vertex_colors[i] = ARENA_NEW(storage, float, 3 * body->drawn.vertex_count + 1);
    self->pieces[i] = ARENA_NEW(storage, uint32_t, body->mesh.triangle_count + 1);
    return self->values[i] && self->scratch[i] && self->drawn_values[i] && self->vertex_colors[i] &&
           self->pieces[i];
}

static tulle_status allocate(picture_explanation *self, picture_run *run, tulle_error *error) {
    arena *const storage = &run->storage;
    size_t const count = run->body_count + 1;
    self->values = ARENA_NEW_ZEROED(storage, double *, count);
    self->scratch = ARENA_NEW_ZEROED(storage, double *, count);
    self->drawn_values = ARENA_NEW_ZEROED(storage, double *, count);
    self->vertex_colors = ARENA_NEW_ZEROED(storage, float *, count);
    self->triangle_colors = ARENA_NEW_ZEROED(storage, float *, count);
    self->patch_colors = ARENA_NEW_ZEROED(storage, float *, count);
    self->pieces = ARENA_NEW_ZEROED(storage, uint32_t *, count);
    self->piece_counts = ARENA_NEW_ZEROED(storage, size_t, count);
    if (!self->values || !self->scratch || !self->drawn_values || !self->vertex_colors ||
        !self->triangle_colors || !self->patch_colors || !self->pieces || !self->piece_counts)
        return fail_memory(error);
    for (size_t i = 0; i < run->cloth_count; i++) {
        if (!allocate_body(self, run, i)) return fail_memory(error);
        if (self->color != PICTURE_GAP) continue;
        tulle_status const status = render_find_pieces(
            &self->heap, run->bodies[i].rest, self->pieces[i], &self->piece_counts[i], error);
        if (status != TULLE_OK) return status;
    }
    return TULLE_OK;
}

static void make_legend(picture_explanation *self) {
    static const char *const titles[] = {"",         "patches", "contacts", "nearest surface",
                                         "velocity", "strain"};
    self->has_legend = self->color != PICTURE_MATERIAL;
    self->legend = (overlay_legend){.corner = OVERLAY_BOTTOM_LEFT,
                                    .title = titles[self->color],
                                    .has_gradient = is_gradient(self->color),
                                    .map = self->color == PICTURE_STRAIN ? COLOR_MAP_DIVERGING
                                                                         : COLOR_MAP_SEQUENTIAL,
                                    .scale = self->scale};
}

tulle_status picture_explanation_open(picture_explanation *self, picture_run *run,
                                      tulle_error *error) {
    const picture_options *const options = run->options;
    *self = (picture_explanation){.heap = memory_default(), .color = options->color};
    bool const needs_debug = self->color == PICTURE_PATCHES || self->color == PICTURE_CONTACTS ||
                             self->color == PICTURE_VELOCITY;
    bool const has_record =
        self->color == PICTURE_VELOCITY ? run->info->has_velocities : run->info->has_debug;
    if (needs_debug && !has_record)
        return error_set_at(error, TULLE_ERROR_INVALID_ARGUMENT, options->directory, 0, 0,
                            "the run has no record of what --color %s shows; run it again with "
                            "`tulle run %s --record debug`",
                            options->color_name, run->info->scene_path);
    tulle_status status = allocate(self, run, error);
    if (status == TULLE_OK && is_gradient(self->color)) status = survey(self, run, error);
    make_legend(self);
    for (size_t i = 0; i < run->cloth_count && self->color == PICTURE_CONTACTS; i++) {
        render_surface *const surface = &run->bodies[i].surface;
        memcpy(surface->front_color, PALE_FRONT, sizeof PALE_FRONT);
        memcpy(surface->back_color, PALE_BACK, sizeof PALE_BACK);
        surface->pattern = RENDER_PATTERN_PLAIN;
    }
    return status;
}

void picture_explanation_close(picture_explanation *self) {
    memory_release(&self->heap, self->marks, self->mark_capacity * sizeof *self->marks);
}

/* ---- one frame ---- */

static tulle_status color_vertices(picture_explanation *self, picture_run *run,
                                   tulle_error *error) {
    tulle_status status = compute_values(self, run, error);
    for (size_t i = 0; i < run->cloth_count && status == TULLE_OK; i++) {
        picture_body *const body = &run->bodies[i];
        if (body->subdivision)
            status = tulle_subdivision_apply(body->subdivision, self->values[i], 1,
                                             self->drawn_values[i], error);
        for (size_t k = 0; k < body->drawn.vertex_count && status == TULLE_OK; k++)
            color_map_get(self->legend.map,
                          tick_scale_get_part(&self->scale, self->drawn_values[i][k]),
                          self->vertex_colors[i] + 3 * k);
        body->surface.vertex_colors = self->vertex_colors[i];
    }
    return status;
}

static tulle_status color_by_patch(picture_explanation *self, picture_run *run,
                                   tulle_error *error) {
    const tulle_run_debug *debug = NULL;
    tulle_status status = read_debug(run, &debug, error);
    uint64_t patch_count = 0;
    for (size_t i = 0; i < run->cloth_count && status == TULLE_OK; i++) {
        picture_body *const body = &run->bodies[i];
        body->surface.triangle_colors = NULL;
        if (!debug || !debug->patch_labels[i]) continue;
        status = color_patches(&self->heap, body->mesh, debug->patch_labels[i],
                               self->patch_colors[i], NULL, error);
        patch_count += debug->patch_counts[i];
        for (size_t t = 0; t < body->drawn.triangle_count && body->subdivision; t++) {
            size_t const parent =
                tulle_subdivision_get_parent_triangle(body->subdivision, (uint32_t)t);
            memcpy(self->triangle_colors[i] + 3 * t, self->patch_colors[i] + 3 * parent,
                   3 * sizeof(float));
        }
        body->surface.triangle_colors = self->triangle_colors[i];
    }
    snprintf(self->note, sizeof self->note, "%llu in this frame", (unsigned long long)patch_count);
    self->legend.note = self->note;
    return status;
}

static color_contact get_contact_color(const tulle_contact *contact) {
    if (contact->is_new) return COLOR_CONTACT_NEW;
    if (contact->state == TULLE_CONTACT_STICK) return COLOR_CONTACT_STICK;
    if (contact->state == TULLE_CONTACT_SLIP) return COLOR_CONTACT_SLIP;
    return contact->is_hard ? COLOR_CONTACT_HARD : COLOR_CONTACT_OPEN;
}

static tulle_status mark_contacts(picture_explanation *self, picture_run *run, tulle_error *error) {
    const tulle_run_debug *debug = NULL;
    tulle_status const status = read_debug(run, &debug, error);
    if (status != TULLE_OK) return status;
    size_t const count = debug ? debug->contact_count : 0;
    self->mark_count = 0;
    if (!array_reserve(&self->heap, (void **)&self->marks, &self->mark_capacity, 0, count + 1,
                       sizeof *self->marks))
        return fail_memory(error);
    for (int state = 0; state < COLOR_CONTACT_COUNT; state++) {
        self->swatches[state] = (overlay_swatch){
            .name = color_map_contact_name((color_contact)state), .has_count = true};
        color_map_contact((color_contact)state, self->swatches[state].color);
    }
    for (size_t i = 0; i < count; i++) {
        overlay_swatch *const swatch = &self->swatches[get_contact_color(&debug->contacts[i])];
        swatch->count++;
        render_mark *const mark = &self->marks[self->mark_count++];
        bool const is_open = swatch == &self->swatches[COLOR_CONTACT_OPEN];
        *mark = (render_mark){.radius = MARK_SIZE * run->edge_length * (is_open ? OPEN_SIZE : 1.0)};
        memcpy(mark->position, debug->contacts[i].position, sizeof mark->position);
        memcpy(mark->color, swatch->color, sizeof mark->color);
    }
    self->legend.swatches = self->swatches;
    self->legend.swatch_count = COLOR_CONTACT_COUNT;
    return TULLE_OK;
}

tulle_status picture_explain_frame(picture_explanation *self, picture_run *run,
                                   tulle_error *error) {
    switch (self->color) {
    case PICTURE_MATERIAL: return TULLE_OK;
    case PICTURE_PATCHES: return color_by_patch(self, run, error);
    case PICTURE_CONTACTS: return mark_contacts(self, run, error);
    default: return color_vertices(self, run, error);
    }
}

uint64_t picture_explanation_hash(const picture_explanation *self, uint64_t hash) {
    double const numbers[] = {self->scale.low, self->scale.high};
    uint64_t const kind = self->color;
    hash = hash_bytes(hash, &kind, sizeof kind);
    hash = hash_bytes(hash, numbers, sizeof numbers);
    for (size_t i = 0; i < self->legend.swatch_count; i++)
        hash = hash_bytes(hash, &self->swatches[i].count, sizeof self->swatches[i].count);
    return hash_bytes(hash, self->note, strlen(self->note));
}
