/* The rows of the defs: each number out of its range is refused by its name in the call that takes
 * the def; defaults are in range; rows leave no member out; every value counts in the hash that
 * guards saved states. */
#include "api/arguments.h"
#include "contact/contact_types.h"
#include "support/paper_options.h"
#include "support/small_world.h"
#include "world/fields/fields.h"

static tulle_mesh sheet, box;
static tulle_world *woven, *springs, *started;
static tulle_cloth_id cloth;
static tulle_obstacle_id body;

static tulle_world *make_world(tulle_membrane membrane) {
    tulle_world_def def = tulle_world_def_default();
    def.membrane = membrane;
    def.threads = 1;
    tulle_world *made = NULL;
    FINE(tulle_world_create(&def, &made, &error));
    return made;
}

static int set_up(void **unused) {
    (void)unused;
    sheet = small_sheet(0.3, 4, 1.0);
    box = small_shape(tulle_shape_def_default(TULLE_SHAPE_BOX), 0.0, 0.0, -2.0);
    woven = make_world(TULLE_MEMBRANE_WOVEN);
    springs = make_world(TULLE_MEMBRANE_SPRINGS);
    started = make_world(TULLE_MEMBRANE_WOVEN);
    cloth = small_add_cloth(started, &sheet);
    tulle_obstacle_def def = tulle_obstacle_def_default();
    def.mesh = tulle_mesh_get_view(&box);
    def.body = (tulle_body){.is_dynamic = 1, .density = 300.0};
    FINE(tulle_world_add_obstacle(started, &def, &body, &error));
    FINE(tulle_world_start(started, &error));
    return 0;
}

static int tear_down(void **unused) {
    (void)unused;
    tulle_world_destroy(woven);
    tulle_world_destroy(springs);
    tulle_world_destroy(started);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&box);
    return 0;
}

/* ---- ranges ---- */

/* A call that takes a def. */
typedef tulle_status (*taker)(const void *def);

static tulle_status create(const void *def) {
    tulle_world *made = NULL;
    tulle_status const status = tulle_world_create(def, &made, &error);
    tulle_world_destroy(made);
    return status;
}
static tulle_status set_wind(const void *def) { return tulle_world_set_wind(started, def, &error); }
static tulle_status add_woven(const void *def) {
    return tulle_world_add_cloth(woven, def, NULL, &error);
}
static tulle_status add_springs(const void *def) {
    return tulle_world_add_cloth(springs, def, NULL, &error);
}
static tulle_status add_obstacle(const void *def) {
    return tulle_world_add_obstacle(woven, def, NULL, &error);
}
static tulle_status set_law(const void *def) {
    return tulle_world_set_material_law(woven, "silk", "wool", def, &error);
}
static tulle_status attach(const void *def) {
    tulle_attachment_id id;
    return tulle_world_attach(started, def, &id, &error);
}
static tulle_status set_drive(const void *def) {
    return tulle_obstacle_set_drive(started, body, def, &error);
}
static tulle_status watch(const void *def) {
    return tulle_world_watch_events(started, def, &error);
}

static size_t tried; /* values out of range */

/* Puts a number into the first place of a row; false where its type does not have it. */
static bool put(const field *row, char *at, double value) {
    if (row->kind == FIELD_DOUBLE) {
        memcpy(at, &value, sizeof value);
        return true;
    }
    bool const has_sign = row->kind == FIELD_INT || row->kind == FIELD_ENUM;
    if (isnan(value) || (!has_sign && value < 0.0)) return false;
    int64_t const whole = (int64_t)value; /* little endian */
    memcpy(at, &whole, field_size(row));
    return true;
}

/* The numbers beside a range, and none. */
static void list_wrong(const field *row, double wrong[5]) {
    bool const is_whole = row->kind != FIELD_DOUBLE;
    wrong[0] = is_whole ? row->least - 1.0 : nextafter(row->least, -(double)INFINITY);
    wrong[1] = is_whole ? row->most + 1.0 : nextafter(row->most, (double)INFINITY);
    wrong[2] = (double)NAN;
    wrong[3] = isfinite(row->least) ? (is_whole ? row->least - 99.0 : -(double)INFINITY) : wrong[2];
    wrong[4] = isfinite(row->most) ? (is_whole ? row->most + 99.0 : (double)INFINITY) : wrong[2];
}

static void refuse_rows(const field_table *table, char *part, taker take, const void *whole,
                        const char *without) {
    for (size_t r = 0; r < table->row_count; r++) {
        const field *const row = &table->rows[r];
        if (row->group && without && strcmp(row->group, without) == 0) continue;
        char *at = part + row->offset; /* of an array: its first item */
        if (row->is_pointer || row->is_array) memcpy((void *)&at, at, sizeof(char *));
        if (!at) continue;
        if (row->kind == FIELD_STRUCT && strcmp(row->name, "mesh") != 0)
            refuse_rows(row->inner, at, take, whole, without);
        if (!row->range) continue;
        double wrong[5];
        list_wrong(row, wrong);
        for (int i = 0; i < 5; i++) {
            char kept[sizeof(double)];
            bool const is_wrong = isnan(wrong[i]) || wrong[i] < row->least || wrong[i] > row->most;
            if (!is_wrong || (row->takes_zero && wrong[i] == 0.0)) continue;
            memcpy(kept, at, field_size(row));
            if (!put(row, at, wrong[i])) continue;
            expect_status(TULLE_ERROR_INVALID_ARGUMENT, take(whole), row->name, __LINE__);
            take(whole);
            if (!strstr(error.message, row->name))
                fail_msg("%s.%s = %g: %s", table->name, row->name, wrong[i], error.message);
            memcpy(at, kept, field_size(row));
            tried++;
        }
    }
}

/* All values of a def that the call takes as it is. */
static void refuse_all(const field_table *table, void *def, taker take, const char *without) {
    error = (tulle_error){0};
    tried = 0;
    refuse_rows(table, def, take, def, without);
    assert_true(tried > 5);
    FINE(take(def));
}

static void numbers_out_of_range_are_refused(void **unused) {
    (void)unused;
    tulle_world_def world = tulle_world_def_default();
    (void)change_paper(&world);
    refuse_all(&world_def_fields, &world, create, NULL);
    refuse_all(&wind_fields, &world.wind, set_wind, NULL);
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(&sheet);
    double velocities[3 * 16] = {0}, warps[3 * 18], factors[18], corners[9 * 18];
    for (size_t t = 0; t < 18; t++) {
        factors[t] = 1.0;
        for (size_t k = 0; k < 3; k++) warps[3 * t + k] = 1.0;
        for (size_t k = 0; k < 9; k++)
            corners[9 * t + k] = sheet.positions[3 * sheet.triangles[3 * t + k / 3] + k % 3];
    }
    tulle_crease const crease = {{0, 1}, 0.5};
    uint32_t const vertex = 0;
    tulle_pin pin = tulle_pin_default();
    pin.vertices = &vertex;
    pin.vertex_count = def.crease_count = def.pin_count = 1;
    def.velocities = velocities;
    def.warps = warps;
    def.stiffness_factors = factors;
    def.rest_corners = corners;
    def.creases = &crease;
    def.pins = &pin;
    refuse_all(&cloth_def_fields, &def, add_woven, "cloth of springs");
    refuse_all(&cloth_def_fields, &def, add_springs, "woven cloth");
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    obstacle.mesh = tulle_mesh_get_view(&box);
    obstacle.body = (tulle_body){.is_dynamic = 1, .density = 300.0};
    refuse_all(&obstacle_def_fields, &obstacle, add_obstacle, NULL);
    tulle_contact_law law = {0.5, 0.4, 0.1};
    refuse_all(&contact_law_fields, &law, set_law, NULL);
    double point[3] = {0.0, 0.0, 1.0};
    tulle_attachment_def attached = tulle_attachment_def_default();
    attached.cloth = cloth;
    attached.vertices = &vertex;
    attached.vertex_count = 1;
    attached.points = point;
    refuse_all(&attachment_def_fields, &attached, attach, NULL);
    tulle_body_drive drive = tulle_body_drive_default();
    refuse_all(&body_drive_fields, &drive, set_drive, NULL);
    tulle_event_watch events = tulle_event_watch_default();
    refuse_all(&event_watch_fields, &events, watch, NULL);
}

/* ---- rows ---- */

/* Each byte of a def is that of a row, of the cookie, or of the gap before a larger member. */
static void rows_leave_no_member_out(void **unused) {
    (void)unused;
    static const field_table *const tables[] = {
        &world_def_fields,      &paper_options_fields, &cloth_def_fields,  &obstacle_def_fields,
        &attachment_def_fields, &wind_fields,          &material_fields,   &pin_fields,
        &contact_law_fields,    &body_drive_fields,    &event_watch_fields};
    for (size_t t = 0; t < sizeof tables / sizeof tables[0]; t++) {
        size_t end = tables[t]->cookie ? sizeof tables[t]->cookie : 0;
        for (size_t r = 0; r < tables[t]->row_count; r++) {
            const field *const row = &tables[t]->rows[r];
            if (row->offset < end || row->offset - end >= sizeof(double))
                fail_msg("%s: something lies before %s", tables[t]->name, row->name);
            size_t const size = row->is_array || row->is_pointer || row->kind == FIELD_TEXT ||
                                        row->kind == FIELD_CALL
                                    ? sizeof(void *)
                                : row->kind == FIELD_HOST && r + 1 < tables[t]->row_count
                                    ? row[1].offset - row->offset
                                : row->kind == FIELD_HOST ? tables[t]->size - row->offset
                                                          : row->count * field_size(row);
            end = row->offset + size;
        }
        if (tables[t]->size - end >= sizeof(double)) fail_msg("%s: its end", tables[t]->name);
    }
    contact_settings const settings = default_contact_settings;
    tulle_world_def const def = tulle_world_def_default();
    assert_true(get_paper(&def).impulse_sweeps == settings.impulse_sweeps &&
                get_paper(&def).impact_rounds == settings.impact_rounds);
    assert_int_equal(tulle_event_watch_default().kinds, (1u << TULLE_EVENT_KIND_COUNT) - 1u);
}

/* A state fits a world of the same defs alone. */
static void another_value_is_another_scene(void **unused) {
    (void)unused;
    void *bytes = NULL;
    size_t count = 0;
    FINE(tulle_world_save_state(started, &bytes, &count, &error));
    for (int i = 0; i < 4; i++) {
        tulle_world_def def = tulle_world_def_default();
        def.threads = i + 1; /* the host's: any */
        if (i == 0) {        /* how it is solved, too */
            def.quality = TULLE_QUALITY_EXACT;
            change_paper(&def)->cg_tolerance = 1e-6;
            change_paper(&def)->solve_rounds = 2;
            change_paper(&def)->detection.method = TULLE_DETECT_REFIT;
            def.on_pinch = TULLE_ON_PINCH_STOP;
        }
        if (i == 1) def.wind.velocity[0] = 1.0;
        tulle_world *other = NULL;
        FINE(tulle_world_create(&def, &other, &error));
        tulle_cloth_def cloth_def = tulle_cloth_def_default();
        cloth_def.mesh = tulle_mesh_get_view(&sheet);
        if (i == 2) cloth_def.material.bend_damping *= 2.0;
        FINE(tulle_world_add_cloth(other, &cloth_def, NULL, &error));
        tulle_obstacle_def box_def = tulle_obstacle_def_default();
        box_def.mesh = tulle_mesh_get_view(&box);
        box_def.body = (tulle_body){.is_dynamic = 1, .density = 300.0};
        if (i == 3) box_def.body.linear_damping = 1.0;
        FINE(tulle_world_add_obstacle(other, &box_def, NULL, &error));
        if (i == 0)
            FINE(tulle_world_load_state(other, bytes, count, &error));
        else
            REFUSED(tulle_world_load_state(other, bytes, count, &error));
        tulle_world_destroy(other);
    }
    tulle_world_free_state(started, bytes, count);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(another_value_is_another_scene),
        cmocka_unit_test(numbers_out_of_range_are_refused),
        cmocka_unit_test(rows_leave_no_member_out),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
