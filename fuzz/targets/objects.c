/* fuzz/targets/objects.c - worlds in which objects come and go (tulle/objects.h), by calls that the
 * bytes choose: cloths, obstacles and bodies are added before the start and later, also into each
 * other, and removed, also twice; in between steps, attachments, poses, settings, saving and going
 * back.
 *
 * After every call the world has what was added and not removed, no id of what was removed is
 * taken, and the judge finds nothing where the start refuses what intersects. A call that fails
 * changes nothing. What comes and goes again leaves no trace. All is recorded, and the replay comes
 * to the same end. Where a bit of the input says so all is done on two threads, too. */
#include "support/fuzz.h"
#include "support/paper_options.h"
#include "support/shapes.h"

#include "support/recording.h"
#include "tulle/tulle.h"

#include <math.h>

enum {
    ALIVE_MAX = 6,
    GONE_MAX = 24,
    CALLS_MAX = 24,
    QUESTIONS_MAX = 1500 /* of a step that ends by itself; then it is stopped */
};

/* An object that is there. */
typedef struct thing {
    tulle_object_id id;
    tulle_mesh mesh;
    tulle_drive drive;
    int is_body;
} thing;

typedef struct session {
    tulle_world *world;
    fuzz_bytes *bytes;
    tulle_world_def def;
    thing alive[ALIVE_MAX];
    tulle_object_id gone[GONE_MAX];
    size_t alive_count, gone_count;
    bool is_started;
    void *saved;
    size_t saved_size;
    uint64_t saved_hash;
    int questions_left;
    bool was_stopped; /* when a step asks to stop depends on the clock */
} session;

static int ask(void *context) {
    session *const self = context;
    return self->questions_left-- <= 0;
}

static tulle_cloth_id as_cloth(tulle_object_id id) {
    return (tulle_cloth_id){id.index, id.generation};
}

static tulle_obstacle_id as_obstacle(tulle_object_id id) {
    return (tulle_obstacle_id){id.index, id.generation};
}

/* ---- what must hold ---- */

static size_t judge(const session *self) {
    tulle_check_body judged[ALIVE_MAX];
    size_t count = 0;
    for (size_t i = 0; i < self->alive_count; i++) {
        const thing *const one = &self->alive[i];
        bool const is_cloth = one->id.kind == TULLE_OBJECT_CLOTH;
        if (!is_cloth && !tulle_obstacle_is_present(self->world, as_obstacle(one->id))) continue;
        judged[count] = (tulle_check_body){.mesh = tulle_mesh_get_view(&one->mesh),
                                           .is_obstacle = !is_cloth && !one->is_body};
        size_t vertex_count;
        judged[count].mesh.positions =
            is_cloth
                ? tulle_cloth_get_positions(self->world, as_cloth(one->id), &vertex_count)
                : tulle_obstacle_get_positions(self->world, as_obstacle(one->id), &vertex_count);
        FUZZ_CHECK(vertex_count == one->mesh.vertex_count);
        for (size_t k = 0; k < 3 * vertex_count; k++)
            FUZZ_CHECK(isfinite(judged[count].mesh.positions[k]));
        count++;
    }
    tulle_check_result result;
    tulle_error error = {0};
    FUZZ_CHECK_OK(tulle_check_intersections(judged, count, 1, &result, &error), &error);
    size_t const pair_count = result.pair_count;
    tulle_check_result_destroy(&result);
    return pair_count;
}

static void check_objects(const session *self) {
    tulle_counts const counts = tulle_world_get_counts(self->world);
    FUZZ_CHECK(counts.cloths + counts.obstacles == self->alive_count);
    FUZZ_CHECK(tulle_world_get_object(self->world, (uint32_t)self->alive_count).kind ==
               TULLE_OBJECT_NONE);
    size_t found = 0;
    for (uint32_t n = 0; n < self->alive_count; n++) {
        tulle_object_id const id = tulle_world_get_object(self->world, n);
        for (size_t i = 0; i < self->alive_count; i++) {
            const thing *const one = &self->alive[i];
            if (one->id.kind != id.kind || one->id.index != id.index) continue;
            tulle_object_info const info = tulle_object_get_info(self->world, id);
            FUZZ_CHECK(one->id.generation == id.generation && info.name);
            FUZZ_CHECK(info.vertex_count == one->mesh.vertex_count);
            FUZZ_CHECK(info.triangle_count == one->mesh.triangle_count);
            FUZZ_CHECK(memcmp(info.triangles, one->mesh.triangles,
                              3 * info.triangle_count * sizeof *info.triangles) == 0);
            found++;
        }
    }
    FUZZ_CHECK(found == self->alive_count);
    for (size_t i = 0; i < self->gone_count; i++)
        FUZZ_CHECK(!tulle_object_get_info(self->world, self->gone[i]).name);
    bool const is_clean = self->is_started && self->def.start_intersections == TULLE_START_REFUSE;
    if (is_clean) FUZZ_CHECK(judge(self) == 0);
}

/* After a call that may change the state, but not when it fails. */
static void end_call(session *self, uint64_t before, tulle_status status,
                     const tulle_error *error) {
    if (status) {
        fuzz_check_error(status, error);
        FUZZ_CHECK(tulle_world_get_state_hash(self->world) == before);
        self->was_stopped |= status == TULLE_ERROR_INTERRUPTED;
    }
    check_objects(self);
}

/* ---- calls ---- */

static tulle_status add_cloth(session *self, thing *made, tulle_error *error) {
    fuzz_bytes *const bytes = self->bytes;
    made->mesh = shapes_take_cloth(bytes);
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(&made->mesh);
    unsigned const kind = fuzz_take(bytes);
    uint32_t const corners[2] = {0, (uint32_t)made->mesh.vertex_count - 1};
    tulle_keyframe const keys[2] = {{.rotation_vector = {0, 0, 0}},
                                    {0.3, {0.1, 0, 0.2}, {0, 0, 0}}};
    tulle_pin pin = tulle_pin_default();
    pin.vertices = corners;
    pin.vertex_count = 2;
    if (kind % 4 == 1) pin.motion = (tulle_motion){.keys = keys, .key_count = 2};
    if (kind % 4 == 2) pin.release_time = 0.05;
    def.pins = &pin;
    def.pin_count = kind % 4 != 0;
    def.has_flat_rest = kind / 4 % 4 == 2; /* only such cloth takes targets */
    if (kind / 4 % 4 == 3) def.material.bend_hysteresis_warp = 20.0 * def.material.bend_warp;
    if (kind / 16 % 4 == 3) def.thickness = 2e-3;
    if (kind / 64 == 3) def.contact_material = "some cloth";
    tulle_cloth_id id = {0};
    tulle_status const status = tulle_world_add_cloth(self->world, &def, &id, error);
    made->id = tulle_object_from_cloth(id);
    return status;
}

static tulle_status add_obstacle(session *self, thing *made, tulle_error *error) {
    fuzz_bytes *const bytes = self->bytes;
    int is_closed;
    made->mesh = shapes_take_obstacle(bytes, &is_closed);
    tulle_obstacle_def def = tulle_obstacle_def_default();
    def.mesh = tulle_mesh_get_view(&made->mesh);
    unsigned const kind = fuzz_take(bytes);
    tulle_keyframe const keys[2] = {{.rotation_vector = {0, 0, 0}},
                                    {0.2, {0.1, 0.0, -0.1}, {0.0, 1.2870022175865687, 0.0}}};
    made->is_body = kind % 4 == 1 && is_closed;
    if (made->is_body)
        def.body = (tulle_body){
            .is_dynamic = 1, .density = 200.0, .sleep_speed = 0.02, .sleep_time = 0.05};
    if (kind % 4 == 2) def.motion = (tulle_motion){.keys = keys, .key_count = 2};
    if (kind % 4 == 3) def.drive = kind / 4 % 2 ? TULLE_DRIVE_RIGID : TULLE_DRIVE_DEFORMING;
    if (kind / 8 % 8 == 7) def.appear_time = 0.03;
    if (kind / 64 == 3) def.disappear_time = 0.06;
    made->drive = def.drive;
    tulle_obstacle_id id = {0};
    tulle_status const status = tulle_world_add_obstacle(self->world, &def, &id, error);
    made->id = tulle_object_from_obstacle(id);
    return status;
}

static tulle_status remove_object(session *self, tulle_object_id id, tulle_error *error) {
    return id.kind == TULLE_OBJECT_CLOTH
               ? tulle_world_remove_cloth(self->world, as_cloth(id), error)
               : tulle_world_remove_obstacle(self->world, as_obstacle(id), error);
}

static void note_gone(session *self, tulle_object_id id) {
    if (self->gone_count < GONE_MAX) self->gone[self->gone_count++] = id;
}

static void add(session *self) {
    thing made = {0};
    tulle_error error = {0};
    if (self->alive_count == ALIVE_MAX) return;
    uint64_t const before = tulle_world_get_state_hash(self->world);
    self->questions_left = QUESTIONS_MAX;
    tulle_status const status = fuzz_take_below(self->bytes, 2) ? add_cloth(self, &made, &error)
                                                                : add_obstacle(self, &made, &error);
    if (status == TULLE_OK)
        self->alive[self->alive_count++] = made;
    else
        tulle_mesh_destroy(&made.mesh);
    end_call(self, before, status, &error);
}

static void take_away(session *self) {
    tulle_error error = {0};
    uint64_t const before = tulle_world_get_state_hash(self->world);
    uint32_t const choice = fuzz_take_below(self->bytes, 8);
    if (choice == 7 && self->gone_count > 0) {
        tulle_object_id const stale = self->gone[self->gone_count - 1];
        tulle_status const status = remove_object(self, stale, &error);
        FUZZ_CHECK(status == TULLE_ERROR_INVALID_ARGUMENT);
        end_call(self, before, status, &error);
        return;
    }
    if (self->alive_count == 0) return;
    size_t const at = choice % self->alive_count;
    tulle_status const status = remove_object(self, self->alive[at].id, &error);
    if (status == TULLE_OK) {
        note_gone(self, self->alive[at].id);
        tulle_mesh_destroy(&self->alive[at].mesh);
        memmove(&self->alive[at], &self->alive[at + 1],
                (--self->alive_count - at) * sizeof self->alive[0]);
    }
    end_call(self, before, status, &error);
}

/* Comes and goes again at once. Untangling may move what stays, and wakes bodies. */
static void visit(session *self) {
    thing made = {0};
    tulle_error error = {0};
    uint64_t const before = tulle_world_get_state_hash(self->world);
    self->questions_left = QUESTIONS_MAX;
    tulle_status status = fuzz_take_below(self->bytes, 2) ? add_cloth(self, &made, &error)
                                                          : add_obstacle(self, &made, &error);
    tulle_mesh_destroy(&made.mesh);
    if (status == TULLE_OK) {
        FUZZ_CHECK_OK(remove_object(self, made.id, &error), &error);
        FUZZ_CHECK(self->def.start_intersections == TULLE_START_UNTANGLE ||
                   tulle_world_get_state_hash(self->world) == before);
        note_gone(self, made.id);
    }
    end_call(self, before, status, &error);
}

static void start(session *self) {
    tulle_error error = {0};
    if (self->is_started) return;
    self->questions_left = QUESTIONS_MAX;
    tulle_status const status = tulle_world_start(self->world, &error);
    self->is_started = status == TULLE_OK;
    if (status) fuzz_check_error(status, &error);
    self->was_stopped |= status == TULLE_ERROR_INTERRUPTED;
    check_objects(self);
}

static void step(session *self) {
    static const double steps[] = {1.0 / 90.0, 1.0 / 90.0, 1.0 / 30.0, 1.0 / 400.0};
    tulle_error error = {0};
    if (!self->is_started) start(self);
    if (!self->is_started) return;
    uint64_t const before = tulle_world_get_state_hash(self->world);
    self->questions_left = QUESTIONS_MAX;
    double const time_step = steps[fuzz_take_below(self->bytes, 4)];
    end_call(self, before, tulle_world_step(self->world, time_step, NULL, &error), &error);
}

/* Draws a cloth to a place near where it is, or puts all that deforms there. */
static tulle_status lead(session *self, tulle_object_id cloth, const double by[3],
                         tulle_error *error) {
    bool const is_put = fuzz_take_below(self->bytes, 2) == 1;
    double *positions = NULL;
    size_t sum = 0;
    for (int kind = 0; kind < (is_put ? 2 : 1); kind++)
        for (size_t i = 0; i < self->alive_count; i++) {
            tulle_object_id const id = self->alive[i].id;
            size_t const count = self->alive[i].mesh.vertex_count;
            bool const is_cloth = id.kind == TULLE_OBJECT_CLOTH;
            if (is_cloth != (kind == 0) || (!is_put && id.index != cloth.index)) continue;
            const double *const from =
                is_cloth ? tulle_cloth_get_positions(self->world, as_cloth(id), NULL)
                         : tulle_obstacle_get_positions(self->world, as_obstacle(id), NULL);
            positions = realloc(positions, 3 * (sum + count) * sizeof *positions);
            FUZZ_CHECK(positions && from);
            for (size_t k = 0; k < 3 * count; k++) positions[3 * sum + k] = from[k] + by[k % 3];
            sum += count;
        }
    tulle_cloth_targets const targets = {.positions = positions, .vertex_count = sum};
    tulle_status const status =
        is_put ? tulle_world_place(self->world, positions, sum, error)
               : tulle_cloth_set_targets(self->world, as_cloth(cloth), &targets, error);
    free(positions);
    return status;
}

/* Tells something where to go, holds cloth at something, or changes cloth. */
static void use(session *self) {
    fuzz_bytes *const bytes = self->bytes;
    tulle_error error = {0};
    if (self->alive_count == 0) return;
    uint64_t const before = tulle_world_get_state_hash(self->world);
    const thing *const one = &self->alive[fuzz_take_below(bytes, (uint32_t)self->alive_count)];
    const thing *const other = &self->alive[fuzz_take_below(bytes, (uint32_t)self->alive_count)];
    double const turn[4] = {1, 0, 0, 0};
    double const place[3] = {fuzz_take_between(bytes, -0.1, 0.1), 0.0,
                             fuzz_take_between(bytes, -0.1, 0.1)};
    tulle_status status;
    if (one->id.kind == TULLE_OBJECT_OBSTACLE) {
        status = one->drive == TULLE_DRIVE_DEFORMING
                     ? tulle_obstacle_set_next_positions(
                           self->world, as_obstacle(one->id), one->mesh.positions,
                           one->mesh.vertex_count, TULLE_TRAVEL_MOVE, &error)
                     : tulle_obstacle_set_next_transform(self->world, as_obstacle(one->id), place,
                                                         turn, TULLE_TRAVEL_MOVE, &error);
    } else if (fuzz_take_below(bytes, 4) == 0) {
        double contact;
        tulle_world_get_distances(self->world, &contact, NULL, NULL);
        status = tulle_cloth_set_thickness(self->world, as_cloth(one->id),
                                           contact * fuzz_take_between(bytes, 0.0, 1.0), &error);
    } else if (fuzz_take_below(bytes, 4) == 0 && fuzz_take_below(bytes, 2) == 0) {
        status = lead(self, one->id, place, &error);
    } else if (fuzz_take_below(bytes, 8) == 0) {
        tulle_material material = tulle_cloth_def_default().material;
        material.area_density = 0.3;
        status = tulle_cloth_set_material(self->world, as_cloth(one->id), &material, &error);
    } else {
        uint32_t const vertices[2] = {1, 2};
        double const points[6] = {place[0], place[1], place[2], 0.1, 0.0, 0.1};
        tulle_attachment_def def = tulle_attachment_def_default();
        tulle_attachment_id id;
        def.cloth = as_cloth(one->id);
        def.vertices = vertices;
        def.vertex_count = 2;
        def.stiffness = fuzz_take_below(bytes, 2) ? 20.0 : (double)INFINITY;
        if (other == one)
            def.points = points;
        else if (other->id.kind == TULLE_OBJECT_CLOTH)
            def.other_cloth = as_cloth(other->id);
        else
            def.obstacle = as_obstacle(other->id);
        status = tulle_world_attach(self->world, &def, &id, &error);
    }
    end_call(self, before, status, &error);
}

static void save(session *self) {
    tulle_error error = {0};
    if (!self->is_started) return;
    tulle_world_free_state(self->world, self->saved, self->saved_size);
    FUZZ_CHECK_OK(tulle_world_save_state(self->world, &self->saved, &self->saved_size, &error),
                  &error);
    self->saved_hash = tulle_world_get_state_hash(self->world);
}

/* The state may be of other objects; then it is refused. */
static void go_back(session *self) {
    tulle_error error = {0};
    if (!self->saved || !self->is_started) return;
    uint64_t const before = tulle_world_get_state_hash(self->world);
    tulle_status const status =
        tulle_world_load_state(self->world, self->saved, self->saved_size, &error);
    if (status == TULLE_OK) FUZZ_CHECK(tulle_world_get_state_hash(self->world) == self->saved_hash);
    end_call(self, before, status, &error);
}

/* ---- the run ---- */

typedef struct run_end {
    uint64_t hash;
    bool was_stopped;
} run_end;

static tulle_world_def take_def(fuzz_bytes *bytes) {
    tulle_world_def def = tulle_world_def_default();
    tulle_paper_options *const paper = change_paper(&def);
    unsigned const choices = fuzz_take(bytes);
    def.integrator = (tulle_integrator)(choices % 3);
    def.start_intersections = (tulle_start_intersections)(choices / 3 % 3);
    def.on_pinch = (tulle_on_pinch)(choices / 9 % 3);
    paper->detection.method = (tulle_detect_method)(choices / 27 % 3);
    paper->response = choices >= 240 ? TULLE_RESPONSE_PAPER : TULLE_RESPONSE_COUPLED;
    def.membrane = choices >= 220 ? TULLE_MEMBRANE_SPRINGS : TULLE_MEMBRANE_WOVEN;
    def.untangle_limit = 20;
    return def;
}

static void repeat(const recording *bytes) {
    tulle_replay_report report;
    tulle_error error = {0};
    FUZZ_CHECK_OK(tulle_replay(bytes->bytes, bytes->byte_count, NULL, &report, &error), &error);
    FUZZ_CHECK(report.is_whole && !report.is_different);
}

static run_end run(fuzz_bytes bytes, int threads) {
    session self = {.bytes = &bytes, .def = take_def(&bytes)};
    tulle_error error = {0};
    recording record;
    tulle_record_writer const writer = recording_begin(&record);
    self.def.threads = threads;
    FUZZ_CHECK_OK(tulle_world_create(&self.def, &self.world, &error), &error);
    FUZZ_CHECK_OK(tulle_world_record(self.world, &writer, &error), &error);
    tulle_world_set_stop_request(self.world, ask, &self);
    for (uint32_t left = fuzz_take_below(&bytes, 4); left > 0; left--) add(&self);
    static void (*const calls[])(session *) = {step,      step, step,  step,   add,
                                               add,       add,  use,   use,    take_away,
                                               take_away, save, visit, go_back};
    for (int left = CALLS_MAX; left > 0 && bytes.used < bytes.size; left--)
        calls[fuzz_take_below(&bytes, sizeof calls / sizeof calls[0])](&self);
    run_end const end = {tulle_world_get_state_hash(self.world), self.was_stopped};
    FUZZ_CHECK_OK(tulle_world_record(self.world, NULL, &error), &error);
    tulle_world_free_state(self.world, self.saved, self.saved_size);
    tulle_world_destroy(self.world);
    if (threads == 1) repeat(&record);
    free(record.bytes);
    for (size_t i = 0; i < self.alive_count; i++) tulle_mesh_destroy(&self.alive[i].mesh);
    return end;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_bytes bytes = {data, size, 0};
    bool const is_done_twice = fuzz_take_below(&bytes, 4) == 3;
    run_end const end = run(bytes, 1);
    if (!is_done_twice) return 0;
    run_end const again = run(bytes, 2);
    FUZZ_CHECK(end.was_stopped || again.was_stopped || end.hash == again.hash);
    return 0;
}

void fuzz_make_seeds(void) { fuzz_put_random_seeds(40, 160); }
