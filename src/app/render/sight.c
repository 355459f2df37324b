/* app/render/sight.c - see sight.h. Rays go from each of some directions to the cloth of a few
 * frames. The default direction stays where it sees a fair share of the cloth that is in the
 * picture. Otherwise the first direction is taken that is nearly as good as the best one: a level
 * turn comes before a steeper view. */
#include "app/render/sight.h"

#include "base/error.h"

#include <math.h>
#include <stdio.h>

enum {
    SIGHT_SAMPLES = 5, /* frames that are looked at */
    SIGHT_ROWS = 40,   /* rays from the top to the bottom of the picture */
    SIGHT_COLUMNS_MAX = 160,
    AZIMUTHS = 8,
    ELEVATIONS = 6,
    SIDES = 1 + AZIMUTHS * ELEVATIONS /* the default one first */
};
/* [rad] after the default's: steeper, from straight above, level, from below */
static const double elevations[ELEVATIONS - 1] = {0.8, 1.15, 1.5, 0.08, -0.42};
/* The default direction stays from this share of the cloth on, which is half hidden by a body
 * before it and half of the rest by its frame. */
static const double FAIR_SHARE = 0.25;
static const double SEEN_LEAST = 0.01;   /* share that counts as seen at all */
static const double NEARLY_BEST = 0.9;   /* of the best share */
static const double LARGE_ENOUGH = 0.25; /* of the most pixels: no view along the cloth's edge */

typedef struct side_search {
    picture_maker *maker;
    scene_camera asked[SIDES];
    render_sight sights[SIDES];
    size_t *hidden_by; /* of the default side: pixels of each surface in one frame, and the floor */
    size_t *hiders;    /* the same of each body over all frames, and the floor last */
    uint32_t *bodies;  /* of each surface */
} side_search;

static double get_share(const render_sight *sight) {
    return sight->covered > 0 ? (double)sight->seen / (double)sight->covered : 0.0;
}

/* What is drawn in the frame that was read last, cloth first; its number of cloths. */
static size_t gather(side_search *self, render_frame_def *def) {
    picture_maker *const maker = self->maker;
    const picture_run *const run = maker->run;
    size_t cloth_count = 0;
    def->surface_count = 0;
    for (uint32_t i = 0; i < run->body_count; i++) {
        const picture_body *const body = &run->bodies[i];
        if (!body->is_present || body->is_hidden || i == run->floor_body) continue;
        self->bodies[def->surface_count] = i;
        maker->surfaces[def->surface_count++] = (render_surface){.mesh = body->mesh};
        cloth_count += !body->is_obstacle;
    }
    def->surfaces = maker->surfaces;
    return cloth_count;
}

/* Adds what the first `count` sides see in some of the frames. */
static tulle_status look(side_search *self, size_t count, tulle_error *error) {
    picture_run *const run = self->maker->run;
    const picture_options *const options = run->options;
    double const aspect = (double)options->width / options->height;
    uint32_t const samples = picture_run_get_sample_count(run, SIGHT_SAMPLES);
    tulle_status status = TULLE_OK;
    for (size_t c = 0; c < count; c++) self->sights[c] = (render_sight){0};
    for (size_t i = 0; i <= run->body_count; i++) self->hiders[i] = 0;
    for (uint32_t k = 0; k < samples && status == TULLE_OK; k++) {
        render_frame_def def = {
            .lighting = picture_get_lighting(run),
            .width = (uint32_t)fmin(fmax(1.0, SIGHT_ROWS * aspect), SIGHT_COLUMNS_MAX),
            .height = SIGHT_ROWS,
            .samples = 1,
            .threads = options->threads};
        status = picture_run_read_frame(run, picture_run_get_sample(run, SIGHT_SAMPLES, k), error);
        for (size_t c = 0; c < count && status == TULLE_OK; c++)
            status = picture_make_camera(&self->asked[c], &run->view, aspect, (double)k / samples,
                                         &self->sights[c].camera, error);
        if (status != TULLE_OK) return status;
        size_t const cloth_count = gather(self, &def);
        def.camera = self->sights[0].camera;
        for (size_t s = 0; s <= def.surface_count; s++) self->hidden_by[s] = 0;
        self->sights[0].hidden_by = self->hidden_by;
        status =
            render_find_sights(self->maker->context, &def, cloth_count, self->sights, count, error);
        for (size_t s = 0; s <= def.surface_count && status == TULLE_OK; s++)
            self->hiders[s < def.surface_count ? self->bodies[s] : run->body_count] +=
                self->hidden_by[s];
    }
    return status;
}

/* The first side that is nearly as good as the best one. */
static size_t choose(const side_search *self) {
    size_t most = 0;
    for (size_t c = 0; c < SIDES; c++)
        most = self->sights[c].seen > most ? self->sights[c].seen : most;
    double best = 0.0;
    for (int pass = 0; pass < 2; pass++)
        for (size_t c = 0; c < SIDES; c++) {
            if ((double)self->sights[c].seen < LARGE_ENOUGH * (double)most) continue;
            if (pass == 1 && get_share(&self->sights[c]) >= NEARLY_BEST * best) return c;
            best = fmax(best, get_share(&self->sights[c]));
        }
    return 0;
}

/* The name of what hides most of the cloth from the default side, or "the floor". */
static const char *find_hider(const side_search *self) {
    const picture_run *const run = self->maker->run;
    size_t most = 0;
    for (size_t i = 1; i <= run->body_count; i++)
        if (self->hiders[i] > self->hiders[most]) most = i;
    if (most == run->body_count)
        return run->floor_body != TULLE_NONE ? run->bodies[run->floor_body].name : "the floor";
    return run->bodies[most].name;
}

static void describe(const side_search *self, size_t side, picture_sight *sight) {
    double const degree = acos(-1.0) / 180.0;
    const char *const hider = find_hider(self);
    sight->has_turned = side > 0;
    sight->is_unseen = get_share(&self->sights[side]) < SEEN_LEAST;
    if (sight->is_unseen)
        snprintf(sight->said, sizeof sight->said,
                 "no cloth is seen: \"%.70s\" hides it; leave that out with --hide, or look from "
                 "elsewhere with --camera",
                 hider);
    else if (sight->has_turned)
        snprintf(
            sight->said, sizeof sight->said,
            "orbit=%.0fdeg,%.0fdeg, for from the usual side \"%.70s\" hides %.0f %% of the cloth",
            self->asked[side].azimuth / degree, self->asked[side].elevation / degree, hider,
            100.0 * (1.0 - get_share(&self->sights[0])));
}

tulle_status picture_choose_side(picture_maker *maker, picture_sight *sight, tulle_error *error) {
    picture_run *const run = maker->run;
    *sight = (picture_sight){0};
    maker->asked = picture_camera_merge(&run->options->camera, &run->picture.camera);
    side_search *const self = ARENA_NEW_ZEROED(&run->storage, side_search, 1);
    if (!self) return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for a camera");
    self->maker = maker;
    self->hidden_by = ARENA_NEW(&run->storage, size_t, run->body_count + 1);
    self->hiders = ARENA_NEW(&run->storage, size_t, run->body_count + 1);
    self->bodies = ARENA_NEW(&run->storage, uint32_t, run->body_count + 1);
    if (!self->hidden_by || !self->hiders || !self->bodies)
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for a camera");
    bool const is_open = !maker->asked.has_position && !maker->asked.has_orbit;
    for (size_t c = 0; c < SIDES; c++) {
        self->asked[c] = maker->asked;
        if (c == 0) continue;
        size_t const turn = (c - 1) % AZIMUTHS; /* 0, 1, -1, 2, -2 ... eighths of a turn */
        double const eighths = turn % 2 ? 0.5 * (double)(turn + 1) : -0.5 * (double)turn;
        self->asked[c].has_orbit = true;
        self->asked[c].azimuth = PICTURE_AZIMUTH + eighths * 0.25 * acos(-1.0);
        size_t const row = (c - 1) / AZIMUTHS;
        self->asked[c].elevation = row > 0 ? elevations[row - 1] : PICTURE_ELEVATION;
    }
    tulle_status status = look(self, 1, error);
    if (status != TULLE_OK || self->sights[0].covered == 0) return status;
    double const share = get_share(&self->sights[0]);
    size_t side = 0;
    if (is_open && share < FAIR_SHARE) {
        status = look(self, SIDES, error);
        if (status != TULLE_OK) return status;
        side = choose(self);
        if (get_share(&self->sights[side]) <= fmax(share, SEEN_LEAST)) side = 0;
    }
    if (side > 0) maker->asked = self->asked[side];
    describe(self, side, sight);
    return TULLE_OK;
}
