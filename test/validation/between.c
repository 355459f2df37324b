/* between.c - a sheet held between two layers slides freely between them without friction.
 *
 * The layers stand still, a little less than two contact distances apart, so that every vertex of
 * the sheet is in contact with both; gravity points along them, and a little to the lower one. The
 * paper's canonical cone of two half-spaces that face each other is empty: what is pressed against
 * either, by however little, it locks. */
#include "support/paper_options.h"
#include "support/pins.h"
#include "validation/stage.h"

#include <math.h>
#include <stdio.h>

static const double CONTACT_DISTANCE = 3e-3; /* [m] */
static const double PULL = 1.0;              /* [m/s^2] along the layers */
static const double PRESS = 0.1;             /* [m/s^2] on the lower one */
static const double SQUEEZE = 0.98;          /* share of the contact distance that is left */
static const double SECONDS = 1.0;

/* Layers of cloth whose vertices are all held, or of obstacles. */
static void add_layer(validation_run *run, tulle_world *world, double height, bool is_cloth) {
    tulle_mesh *const mesh = stage_make_sheet(
        run,
        (stage_sheet){.size = {1.6, 0.6}, .counts = {17, 7}, .middle = {0.313, 0.017, height}});
    if (!is_cloth) {
        stage_add_obstacle(run, world, mesh, 0.0);
        return;
    }
    uint32_t *const all = validate_allocate(run, mesh->vertex_count * sizeof *all);
    for (size_t v = 0; v < mesh->vertex_count; v++) all[v] = (uint32_t)v;
    tulle_pin const pin = make_pin(all, mesh->vertex_count, (double)INFINITY);
    tulle_cloth_def cloth = stage_cloth_def(mesh);
    cloth.pins = &pin;
    cloth.pin_count = 1;
    validate_add_cloth(run, world, &cloth);
}

typedef struct between_record {
    double way; /* [m] */
    uint64_t contacts;
} between_record;

/* Way of the sheet in SECONDS with the response in `def`. */
static between_record slide_between(validation_run *run, tulle_world_def def, bool is_cloth,
                                    double squeeze) {
    def.contact_distance = CONTACT_DISTANCE;
    def.gravity[0] = PULL;
    def.gravity[1] = 0.0;
    def.gravity[2] = -PRESS;
    def.friction_cloth_cloth = 0.0;
    tulle_world *const world = validate_make_world(run, &def);
    tulle_mesh *const mesh = stage_make_sheet(
        run, (stage_sheet){.size = {0.3, 0.3}, .counts = {9, 9}, .middle = {0.0031, 0.0, 0.0}});
    tulle_cloth_def cloth = stage_cloth_def(mesh);
    cloth.material.friction = 0.0;
    tulle_cloth_id const sheet = validate_add_cloth(run, world, &cloth);
    add_layer(run, world, squeeze * CONTACT_DISTANCE, is_cloth);
    add_layer(run, world, -squeeze * CONTACT_DISTANCE, is_cloth);
    between_record record = {0};
    double before[3], after[3];
    validate_mean_position(world, sheet, before);
    for (long i = 0; i < lround(SECONDS / VALIDATION_STEP); i++)
        record.contacts += validate_step(run, world, VALIDATION_STEP).contacts;
    validate_mean_position(world, sheet, after);
    record.way = after[0] - before[0];
    return record;
}

static void slides(validation_run *run) {
    /* implicit Euler moves by the velocity at the end of the step */
    double const expected = 0.5 * PULL * SECONDS * (SECONDS + VALIDATION_STEP);
    tulle_world_def def = validate_world_def(run);
    for (int is_cloth = 0; is_cloth < 2; is_cloth++) {
        between_record const record = slide_between(run, def, is_cloth != 0, SQUEEZE);
        validate_row(run,
                     is_cloth ? "way in 1 s between two cloths" : "way in 1 s between two plates",
                     record.way, "m", within(expected, 0.01), "g t (t + h) / 2: as if free");
        validate_row(run, "contacts, summed", (double)record.contacts, "", at_least(1.0),
                     "it is held");
    }
    change_paper(&def)->response = TULLE_RESPONSE_PAPER;
    change_paper(&def)->motion_space = TULLE_MOTION_SPACE_POLYHEDRAL;
    validate_row(run, "response paper, polyhedral: way in 1 s between two plates",
                 slide_between(run, def, false, SQUEEZE).way, "m", within(expected, 0.01),
                 "as if free");
    change_paper(&def)->motion_space = TULLE_MOTION_SPACE_CONE;
    validate_row(run, "response paper, cone: way in 1 s between two plates",
                 slide_between(run, def, false, SQUEEZE).way, "m", at_most(0.01 * expected),
                 "the canonical cone is empty: it locks");
}

const experiment between_experiments[] = {
    {"between.slides", "a sheet between two layers slides freely without friction", slides, false},
    {0},
};
