/* tips.c - cloth on sharp tips: draped on one needle, pulled down over it by its corners, landing
 * on a row of spikes. A tip never comes through, and what it carries is borne by the cloth around
 * it: no edge is stretched by more than a half. */
#include "support/pins.h"
#include "validation/stage.h"

#include <math.h>
#include <stdio.h>

static const double SIDE = 1.0;                   /* [m] of a sheet on one tip */
static const double TIP_HEIGHT = 1.0;             /* [m] */
static const double STRETCH_MAX = 1.5;            /* length over rest length */
static const double TIP_OFFSET[2] = {7e-3, 4e-3}; /* [m] of the tip from the sheet's middle */
static const double CORNER = 0.06;    /* [m] side of the squares that hold the corners */
static const double WAY_DOWN = 0.3;   /* [m] */
static const double QUIET_FROM = 1.0; /* [s] */
enum { JUDGE_EVERY = 10, CORNERS = 4, CORNER_MAX = 256 };

/* What is told of a run over tips. */
typedef struct tip_record {
    double peak_stretch, late_stretch; /* at any time, at the end */
    double peak_time;                  /* [s] */
    double kinetic_energy;             /* [J] at the end */
    uint64_t early_rescues, late_rescues;
    uint64_t crossing; /* pairs in judged states */
    uint64_t substeps; /* beyond one a step */
} tip_record;

/* `series` is the name of the curve of stretch in the plot. */
static tip_record run_over_tips(validation_run *run, tulle_world *world, double seconds,
                                const char *series) {
    tip_record record = {0};
    long const steps = lround(seconds / VALIDATION_STEP);
    validate_plan(run, steps);
    for (long i = 1; i <= steps; i++) {
        tulle_step_report const report = validate_step(run, world, VALIDATION_STEP);
        uint64_t const rescues = report.rescue_impact_zones + report.rescue_component_scalings +
                                 report.rescue_global_scalings;
        if (report.time > QUIET_FROM)
            record.late_rescues += rescues;
        else
            record.early_rescues += rescues;
        if (report.max_stretch > record.peak_stretch) {
            record.peak_stretch = report.max_stretch;
            record.peak_time = report.time;
        }
        record.late_stretch = report.max_stretch;
        record.kinetic_energy = report.kinetic_energy;
        record.substeps += report.substeps - 1;
        if (i % JUDGE_EVERY == 0) record.crossing += validate_judge(run, world);
        validate_plot_point(run, series, report.time, report.max_stretch);
    }
    return record;
}

static void report_tips(validation_run *run, const char *name, const tip_record *record) {
    char what[120];
    snprintf(what, sizeof what, "%s: largest stretch of an edge, peak", name);
    validate_row(run, what, record->peak_stretch, "", at_most(STRETCH_MAX), "");
    snprintf(what, sizeof what, "%s: the same at the end", name);
    validate_row(run, what, record->late_stretch, "", at_most(STRETCH_MAX), "");
    snprintf(what, sizeof what, "%s: time of the peak", name);
    validate_row(run, what, record->peak_time, "s", nothing(), "");
    snprintf(what, sizeof what, "%s: pairs of triangles that cross, every 10th state", name);
    validate_row(run, what, (double)record->crossing, "", equals(0.0), "the tip stays outside");
    snprintf(what, sizeof what, "%s: rescues after the first second", name);
    validate_row(run, what, (double)record->late_rescues, "", equals(0.0), "");
    snprintf(what, sizeof what, "%s: rescues in the first second", name);
    validate_row(run, what, (double)record->early_rescues, "", nothing(), "");
    snprintf(what, sizeof what, "%s: substeps beyond one a step", name);
    validate_row(run, what, (double)record->substeps, "", nothing(), "");
    snprintf(what, sizeof what, "%s: kinetic energy at the end", name);
    validate_row(run, what, record->kinetic_energy, "J", nothing(), "");
}

static void add_needle(validation_run *run, tulle_world *world) {
    tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_NEEDLE);
    shape.radius = 0.006;
    shape.height = TIP_HEIGHT;
    shape.tip_height = 0.06;
    tulle_mesh *const mesh = validate_make_shape(run, &shape);
    stage_move(mesh, TIP_OFFSET[0], TIP_OFFSET[1], 0.0);
    stage_add_obstacle(run, world, mesh, 0.3);
}

static void start_stretch_plot(validation_run *run, const char *name, const char *title) {
    validate_start_plot(run, &(validation_plot){.name = name,
                                                .title = title,
                                                .x_label = "time [s]",
                                                .y_label = "largest length over rest length"});
}

/* A sheet that falls the last centimetre on a needle and hangs from its tip. */
static void drape(validation_run *run, uint32_t count, double seconds) {
    tulle_world_def const def = validate_world_def(run);
    tulle_world *const world = validate_make_world(run, &def);
    tulle_mesh *const mesh =
        stage_make_sheet(run, (stage_sheet){.size = {SIDE, SIDE},
                                            .counts = {count, count},
                                            .middle = {0.0, 0.0, TIP_HEIGHT + 0.02}});
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(mesh);
    validate_add_cloth(run, world, &cloth);
    add_needle(run, world);
    char name[80];
    snprintf(name, sizeof name, "%u x %u, %g s", count, count, seconds);
    tip_record const record = run_over_tips(run, world, seconds, name);
    report_tips(run, name, &record);
}

static void drapes(validation_run *run) {
    start_stretch_plot(run, "tip_drape", "Cloth draped on one needle tip");
    if (validate_options(run)->is_quick) {
        drape(run, 21, 4.0);
        return;
    }
    drape(run, 41, 30.0);
    drape(run, 81, 30.0);
}

/* Vertices of the square at corner (i, k) of the rest mesh. */
static size_t find_corner(const tulle_mesh *mesh, int i, int k, uint32_t vertices[CORNER_MAX]) {
    size_t count = 0;
    double const from = 0.5 * SIDE - CORNER - 1e-9;
    for (size_t v = 0; v < mesh->vertex_count && count < CORNER_MAX; v++) {
        double const x = mesh->positions[3 * v], y = mesh->positions[3 * v + 1];
        if ((i ? x : -x) >= from && (k ? y : -y) >= from) vertices[count++] = (uint32_t)v;
    }
    return count;
}

/* A sheet that lies on the tip is drawn down by its four corners, 0.3 m in two seconds. */
static void pull(validation_run *run, uint32_t count, double seconds) {
    tulle_world_def const def = validate_world_def(run);
    tulle_world *const world = validate_make_world(run, &def);
    tulle_mesh *const mesh =
        stage_make_sheet(run, (stage_sheet){.size = {SIDE, SIDE},
                                            .counts = {count, count},
                                            .middle = {0.0, 0.0, TIP_HEIGHT + 0.006}});
    tulle_keyframe const keys[2] = {stage_key(0.1, 0.0, 0.0, 0.0),
                                    stage_key(2.1, 0.0, 0.0, -WAY_DOWN)};
    tulle_pin pins[CORNERS];
    for (int i = 0; i < CORNERS; i++) {
        uint32_t *const vertices = validate_allocate(run, CORNER_MAX * sizeof(uint32_t));
        pins[i] = make_pin(vertices, find_corner(mesh, i & 1, i >> 1, vertices), (double)INFINITY);
        pins[i].motion = (tulle_motion){.keys = keys, .key_count = 2, .is_eased = 1};
    }
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(mesh);
    cloth.pins = pins;
    cloth.pin_count = CORNERS;
    validate_add_cloth(run, world, &cloth);
    add_needle(run, world);
    char name[80];
    snprintf(name, sizeof name, "%u x %u, %g s", count, count, seconds);
    tip_record const record = run_over_tips(run, world, seconds, name);
    report_tips(run, name, &record);
}

static void is_pulled_down(validation_run *run) {
    start_stretch_plot(run, "tip_pull", "Cloth pulled down over a needle tip");
    bool const is_quick = validate_options(run)->is_quick;
    pull(run, is_quick ? 21 : 41, 4.0);
    if (!is_quick) pull(run, 81, 4.0);
}

static void drapes_finely(validation_run *run) {
    start_stretch_plot(run, "tip_fine_drape", "Cloth draped on one needle tip");
    drape(run, 161, 30.0);
}

static void is_pulled_down_finely(validation_run *run) {
    start_stretch_plot(run, "tip_fine_pull", "Cloth pulled down over a needle tip");
    pull(run, 161, 4.0);
}

/* The scene of a row of spikes. */
static void land(validation_run *run, uint32_t count) {
    tulle_world_def const def = validate_world_def(run);
    tulle_world *const world = validate_make_world(run, &def);
    tulle_mesh *const mesh = stage_make_sheet(
        run, (stage_sheet){.size = {2.0, 2.0}, .counts = {count, count}, .middle = {0, 0, 0.6}});
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(mesh);
    validate_add_cloth(run, world, &cloth);
    tulle_mesh *const ground =
        stage_make_sheet(run, (stage_sheet){.size = {6.0, 6.0}, .counts = {2, 2}});
    stage_add_obstacle(run, world, ground, 0.4);
    for (int i = 0; i < 7; i++) {
        tulle_shape_def shape = tulle_shape_def_default(TULLE_SHAPE_TETRAHEDRON);
        shape.radius = 0.1;
        shape.height = 0.5;
        tulle_mesh *const spike = validate_make_shape(run, &shape);
        stage_move(spike, 0.28 * (i - 3), 0.0, 0.0);
        stage_add_obstacle(run, world, spike, 0.3);
    }
    char name[80];
    snprintf(name, sizeof name, "%u x %u", count, count);
    tip_record const record = run_over_tips(run, world, 1.5, name);
    report_tips(run, name, &record);
}

static void lands_on_spikes(validation_run *run) {
    start_stretch_plot(run, "tip_landing", "Cloth landing on seven spikes");
    land(run, validate_options(run)->is_quick ? 31 : 99);
}

const experiment tips_experiments[] = {
    {"tips.drape", "a sheet hangs from one needle tip for 30 s", drapes, false},
    {"tips.pull", "a sheet is pulled down over a needle tip by its corners", is_pulled_down, false},
    {"tips.spikes", "a sheet falls on seven spikes", lands_on_spikes, false},
    {"tips.fine_drape", "the same with 161 x 161 particles", drapes_finely, true},
    {"tips.fine_pull", "the same with 161 x 161 particles", is_pulled_down_finely, true},
    {0},
};
