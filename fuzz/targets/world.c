/* fuzz/targets/world.c - worlds by calls that the bytes choose: settings, cloths, obstacles and
 * bodies, then steps, moves that the host gives for them, saving, going back, looking and asking,
 * and calls that must be refused. Some obstacles are left out by filters.
 *
 * After every call that may change the state the judge looks: nothing may intersect, and no vertex
 * of cloth may lie within a closed obstacle. A call that fails leaves the state as it was. Going
 * back to a saved state and making the same steps leads to the same hash. The whole is done twice,
 * on one thread and on two, where a bit of the input says so: both end in the same state.
 * TULLE_FUZZ_SAY=1 prints the calls. How many worlds and calls there were is told now and then, and
 * at the end. */
#include "support/paper_options.h"
#include "support/queries.h"
#include "support/shapes.h"

#include "tulle/tulle.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    CLOTHS_MAX = 3,
    OBSTACLES_MAX = 3,
    CALLS_MAX = 16,      /* after the start */
    QUESTIONS_MAX = 1500 /* of a step that ends by itself; then it is stopped */
};

/* A world with what was added to it. */
typedef struct session {
    tulle_world *world;
    fuzz_bytes *bytes;
    tulle_mesh cloths[CLOTHS_MAX], obstacles[OBSTACLES_MAX];
    int is_body[OBSTACLES_MAX], is_closed[OBSTACLES_MAX];
    bool is_left_out[OBSTACLES_MAX]; /* it collides with nothing */
    tulle_drive drives[OBSTACLES_MAX];
    bool has_held_pin[CLOTHS_MAX]; /* one that no script moves, and when it lets go */
    double release_times[CLOTHS_MAX], saved_releases[CLOTHS_MAX];
    /* What waits for the next step, and a hash of it all. */
    bool waits[OBSTACLES_MAX], pin_waits[CLOTHS_MAX];
    uint64_t given;
    uint32_t cloth_count, obstacle_count;
    tulle_world_def def;
    bool is_started, watches;
    bool has_started_clean; /* nothing intersected at the start, and nothing is let through later */
    /* The saved state, and the hashes that steps led to since. */
    void *saved;
    size_t saved_size;
    uint64_t saved_hash, followed[CALLS_MAX];
    double followed_steps[CALLS_MAX];
    uint64_t followed_given[CALLS_MAX];
    size_t followed_count, replayed_count;
    bool is_on_the_way; /* no other call has changed the state since it was saved */
    int questions_left;
    bool is_stopped_at_times; /* some steps are asked to stop at once */
    bool was_stopped;         /* when a step asks to stop depends on the clock */
} session;

/* Tells the calls of an input, where the environment asks for it. */
static void say(const char *call, tulle_status status, const tulle_error *error) {
    static int is_asked = -1;
    if (is_asked < 0) is_asked = getenv("TULLE_FUZZ_SAY") != NULL;
    if (is_asked) fprintf(stderr, "  %s: %s\n", call, status ? error->message : "fine");
}

/* ---- how much was tried ---- */

enum { CALLS_TOLD = 10000 };
static unsigned long worlds_made, calls_made;

static void tell_counts(void) {
    fprintf(stderr, "worlds: %lu made, %lu calls\n", worlds_made, calls_made);
}

static void count_call(void) {
    if (worlds_made == 1 && calls_made == 0) atexit(tell_counts);
    if (++calls_made % CALLS_TOLD == 0) tell_counts();
}

/* ---- what is made ---- */

static tulle_world_def take_def(fuzz_bytes *bytes) {
    static const double gravities[] = {-9.81, -9.81, 0.0, -50.0};
    tulle_world_def def = tulle_world_def_default();
    tulle_paper_options *const paper = change_paper(&def);
    def.gravity[2] = gravities[fuzz_take_below(bytes, 4)];
    def.integrator = (tulle_integrator)fuzz_take_below(bytes, 3);
    paper->detection.method = (tulle_detect_method)fuzz_take_below(bytes, TULLE_DETECT_PAPER + 1);
    paper->detection.cone = (tulle_detect_cone)fuzz_take_below(bytes, 2);
    paper->detection.grows_patches_anew = (int)fuzz_take_below(bytes, 2);
    unsigned const choices = fuzz_take(bytes);
    paper->response = choices % 8 == 0 ? TULLE_RESPONSE_PAPER : TULLE_RESPONSE_COUPLED;
    paper->motion_space = (tulle_motion_space)(choices / 8 % 2);
    def.start_intersections = (tulle_start_intersections)(choices / 16 % 3);
    def.on_pinch = (tulle_on_pinch)(choices / 48 % 3);
    def.membrane = choices % 7 > 4 ? TULLE_MEMBRANE_SPRINGS : TULLE_MEMBRANE_WOVEN;
    def.untangle_limit = 20;
    unsigned const effort = fuzz_take_below(bytes, 9);
    paper->solve_rounds = 1 + (int)(effort % 3);
    def.quality = (tulle_quality)((TULLE_QUALITY_NORMAL + effort / 3) % 3);
    paper->impact_rounds = (int)fuzz_take_below(bytes, 12);
    def.contact_distance = fuzz_take_below(bytes, 3) == 2 ? 0.02 : 0.0;
    if (fuzz_take_below(bytes, 4) == 3)
        def.wind = (tulle_wind){{5.0, 0.0, 3.0}, 2.0, 0.3, 0.5, 7, 1.2};
    def.threads = 1;
    if (choices % 3 == 1 && choices % 8 != 0) def.sleep_speed = 0.5, def.sleep_time = 0.03;
    return def;
}

#define BY_PAPER(self) (get_paper(&(self)->def).response == TULLE_RESPONSE_PAPER)

static void add_cloth(session *self) {
    fuzz_bytes *const bytes = self->bytes;
    tulle_mesh *const mesh = &self->cloths[self->cloth_count];
    *mesh = shapes_take_cloth(bytes);
    tulle_cloth_def def = tulle_cloth_def_default();
    def.mesh = tulle_mesh_get_view(mesh);
    FUZZ_CHECK(tulle_material_preset(tulle_material_preset_name(fuzz_take_below(bytes, 23)),
                                     &def.material) == TULLE_OK);
    if (BY_PAPER(self)) def.material.springs.stiffening_strain = 0.0;
    def.material.restitution = fuzz_take_below(bytes, 4) == 3 ? 0.8 : 0.0;
    uint32_t const corners[2] = {0, (uint32_t)mesh->vertex_count - 1};
    tulle_keyframe const keys[2] = {{.rotation_vector = {0, 0, 0}},
                                    {0.3, {fuzz_take_between(bytes, -1, 1), 0, 0.2}, {0, 0, 0}}};
    tulle_pin pin = tulle_pin_default();
    pin.vertices = corners;
    pin.vertex_count = 2;
    unsigned const pins = fuzz_take(bytes);
    if (pins / 4 % 4 == 3) { /* of woven cloth */
        def.material.bend_hysteresis_warp = 20.0 * def.material.bend_warp;
        def.material.bend_hysteresis_weft = 30.0 * def.material.bend_weft;
    }
    if (pins / 16 % 4 == 3) def.material.shear_hysteresis = 0.02 * def.material.shear.stiffness;
    if (pins % 4 == 1) pin.motion = (tulle_motion){.keys = keys, .key_count = 2};
    if (pins % 4 == 2) pin.release_time = 0.05;
    def.pins = &pin;
    def.pin_count = pins % 4 != 0;
    tulle_crease const crease = {{mesh->triangles[0], mesh->triangles[1]},
                                 fuzz_take_between(bytes, -3.0, 3.0)};
    if (fuzz_take_below(bytes, 4) == 3) {
        def.creases = &crease;
        def.crease_count = 1;
    }
    def.velocity[2] = fuzz_take_below(bytes, 4) == 3 ? -20.0 : 0.0;
    def.velocity[0] = fuzz_take_below(bytes, 4) == 3 ? 5.0 : 0.0;
    tulle_cloth_id id;
    tulle_error error = {0};
    FUZZ_CHECK_OK(tulle_world_add_cloth(self->world, &def, &id, &error), &error);
    self->has_held_pin[id.index] = pins % 4 >= 2;
    self->release_times[id.index] = pin.release_time;
    FUZZ_CHECK(id.index == self->cloth_count++);
}

static void add_obstacle(session *self) {
    fuzz_bytes *const bytes = self->bytes;
    uint32_t const index = self->obstacle_count;
    tulle_mesh *const mesh = &self->obstacles[index];
    *mesh = shapes_take_obstacle(bytes, &self->is_closed[index]);
    tulle_obstacle_def def = tulle_obstacle_def_default();
    def.mesh = tulle_mesh_get_view(mesh);
    def.friction = fuzz_take_between(bytes, 0.0, 1.0);
    unsigned const kind = fuzz_take(bytes);
    tulle_keyframe const keys[2] = {
        {.rotation_vector = {0, 0, 0}},
        {fuzz_take_between(bytes, 0.05, 0.5),
         {fuzz_take_between(bytes, -0.5, 0.5), 0.0, fuzz_take_between(bytes, -0.5, 0.5)},
         {0.0, 1.2870022175865687, 0.0}}};
    bool const can_be_body = self->is_closed[index] && !BY_PAPER(self);
    self->is_body[index] = kind % 3 == 1 && can_be_body;
    if (self->is_body[index]) {
        def.body = (tulle_body){.is_dynamic = 1, .density = 200.0, .sleep_time = 0.5};
        def.body.sleep_speed = kind / 3 % 2 ? 0.01 : 0.0;
        def.body.velocity[2] = kind / 6 % 4 == 3 ? -10.0 : 0.0;
        def.body.angular_velocity[1] = kind / 24 % 4 == 3 ? 60.0 : 0.0;
    } else if (kind % 3 == 2) {
        def.motion = (tulle_motion){.keys = keys, .key_count = 2, .is_eased = (int)kind / 3 % 2};
        if (kind / 6 % 4 == 3) def.appear_time = 0.02;
        if (kind / 24 % 4 == 3) def.disappear_time = 0.06;
    } else if (kind % 3 == 0) {
        def.drive = (tulle_drive[]){TULLE_DRIVE_NONE, TULLE_DRIVE_RIGID, TULLE_DRIVE_DEFORMING,
                                    TULLE_DRIVE_RIGID}[kind / 3 % 4];
        if (kind / 12 % 4 == 3) def.appear_time = 0.02;
        if (kind / 48 % 4 == 3) def.motion.pivot[0] = 0.2;
    }
    self->drives[index] = def.drive;
    tulle_obstacle_id id;
    tulle_error error = {0};
    FUZZ_CHECK_OK(tulle_world_add_obstacle(self->world, &def, &id, &error), &error);
    FUZZ_CHECK(id.index == self->obstacle_count++);
    self->is_left_out[index] = kind >= 250;
    if (self->is_left_out[index])
        FUZZ_CHECK_OK(
            tulle_object_set_filter(self->world, tulle_object_from_obstacle(id), 1, 0, &error),
            &error);
}

/* ---- what must hold ---- */

/* How many pairs intersect: cloths, bodies and obstacles that are there. */
static size_t judge(const session *self) {
    tulle_check_body judged[CLOTHS_MAX + OBSTACLES_MAX];
    size_t count = 0;
    for (uint32_t i = 0; i < self->cloth_count; i++) {
        judged[count] = (tulle_check_body){.mesh = tulle_mesh_get_view(&self->cloths[i])};
        judged[count++].mesh.positions =
            tulle_cloth_get_positions(self->world, (tulle_cloth_id){i, 1}, NULL);
    }
    for (uint32_t i = 0; i < self->obstacle_count; i++) {
        tulle_obstacle_id const id = {i, 1};
        if (self->is_left_out[i] || !tulle_obstacle_is_present(self->world, id)) continue;
        judged[count] = (tulle_check_body){.mesh = tulle_mesh_get_view(&self->obstacles[i]),
                                           .is_obstacle = !self->is_body[i]};
        judged[count++].mesh.positions = tulle_obstacle_get_positions(self->world, id, NULL);
    }
    tulle_check_result result;
    tulle_error error = {0};
    FUZZ_CHECK_OK(tulle_check_intersections(judged, count, 1, &result, &error), &error);
    size_t const pair_count = result.pair_count;
    tulle_check_result_destroy(&result);
    return pair_count;
}

/* No cloth has slipped into an obstacle as a whole, where the judge sees no pair. */
static void check_nothing_shapes_contain(const session *self) {
    for (uint32_t o = 0; o < self->obstacle_count; o++) {
        tulle_obstacle_id const id = {o, 1};
        if (!self->is_closed[o] || self->is_left_out[o] ||
            !tulle_obstacle_is_present(self->world, id))
            continue;
        const double *const shell = tulle_obstacle_get_positions(self->world, id, NULL);
        for (uint32_t i = 0; i < self->cloth_count; i++) {
            const double *const x =
                tulle_cloth_get_positions(self->world, (tulle_cloth_id){i, 1}, NULL);
            for (size_t v = 0; v < self->cloths[i].vertex_count; v++)
                FUZZ_CHECK(!shapes_contain(&self->obstacles[o], shell, x + 3 * v));
        }
    }
}

static void check_state(const session *self) {
    for (uint32_t i = 0; i < self->cloth_count; i++) {
        size_t count;
        const double *const x =
            tulle_cloth_get_positions(self->world, (tulle_cloth_id){i, 1}, &count);
        FUZZ_CHECK(count == self->cloths[i].vertex_count);
        for (size_t k = 0; k < 3 * count; k++) FUZZ_CHECK(isfinite(x[k]));
    }
    if (!self->has_started_clean) return;
    FUZZ_CHECK(judge(self) == 0);
    check_nothing_shapes_contain(self);
}

/* ---- calls ---- */

static int ask(void *context) {
    session *const self = context;
    return self->questions_left-- <= 0;
}

static void start(session *self) {
    tulle_error error = {0};
    tulle_status const status = tulle_world_start(self->world, &error);
    self->is_started = status == TULLE_OK;
    say("start", status, &error);
    if (status) {
        fuzz_check_error(status, &error);
        self->was_stopped |= status == TULLE_ERROR_INTERRUPTED;
        return;
    }
    /* Of a start that is untangled the report tells whether it became clean; then nothing
     * intersects, but a small thing may be left whole within an obstacle. */
    self->has_started_clean = self->def.start_intersections == TULLE_START_REFUSE;
    check_state(self);
    if (self->def.start_intersections == TULLE_START_UNTANGLE)
        FUZZ_CHECK(judge(self) == 0 || tulle_world_get_untangle_report(self->world).left > 0);
}

/* ---- motion that the host gives ---- */

/* A step and a state that is loaded use up what was given. */
static void let_go_of_given(session *self) {
    memset(self->waits, 0, sizeof self->waits);
    memset(self->pin_waits, 0, sizeof self->pin_waits);
    self->given = 0;
}

static void note_given(session *self, uint32_t object, const double *numbers, size_t count) {
    self->given = self->given * 31 + object;
    for (size_t i = 0; i < count; i++) {
        uint64_t bits;
        memcpy(&bits, &numbers[i], sizeof bits);
        self->given = (self->given ^ bits) * UINT64_C(0x9e3779b97f4a7c15);
        self->given ^= self->given >> 29;
    }
}

/* Tells an obstacle where to go: near where its mesh has it, now and then far away or nowhere. */
static tulle_status give_obstacle(session *self, tulle_obstacle_id id, tulle_drive drive,
                                  bool *is_good, tulle_error *error) {
    static const double turns[4][4] = {
        {1, 0, 0, 0}, {0.8, 0, 0.6, 0}, {0.96, 0.28, 0, 0}, {0.5, 0.5, 0.5, 0.5}};
    fuzz_bytes *const bytes = self->bytes;
    uint32_t const kind = fuzz_take_below(bytes, 16);
    double const size = kind == 15 ? 1e90 : kind == 14 ? (double)INFINITY : 0.3;
    tulle_travel const travel = kind % 4 == 3 ? TULLE_TRAVEL_JUMP : TULLE_TRAVEL_MOVE;
    double numbers[8] = {0};
    for (int k = 0; k < 3; k++) numbers[k] = size * fuzz_take_between(bytes, -1.0, 1.0);
    memcpy(numbers + 3, turns[fuzz_take_below(bytes, 4)], sizeof turns[0]);
    numbers[7] = travel;
    *is_good = isfinite(numbers[0]) && isfinite(numbers[1]) && isfinite(numbers[2]);
    if (drive == TULLE_DRIVE_RIGID) {
        note_given(self, id.index, numbers, 8);
        return tulle_obstacle_set_next_transform(self->world, id, numbers, numbers + 3, travel,
                                                 error);
    }
    bool const is_there = id.index < self->obstacle_count;
    size_t const count = is_there ? self->obstacles[id.index].vertex_count : 1;
    double *const positions = calloc(3 * count, sizeof(double));
    FUZZ_CHECK(positions);
    for (size_t i = 0; is_there && i < 3 * count; i++) /* narrower along x, and moved */
        positions[i] =
            self->obstacles[id.index].positions[i] * (i % 3 ? 1.0 : numbers[3]) + numbers[i % 3];
    note_given(self, id.index, positions, 3 * count);
    note_given(self, 0, numbers + 7, 1);
    tulle_status const status =
        tulle_obstacle_set_next_positions(self->world, id, positions, count, travel, error);
    free(positions);
    return status;
}

static tulle_status give_pin(session *self, tulle_cloth_id id, bool *is_good, tulle_error *error) {
    fuzz_bytes *const bytes = self->bytes;
    bool const is_there = id.index < self->cloth_count && self->has_held_pin[id.index];
    uint32_t const kind = fuzz_take_below(bytes, 16);
    double const size = kind == 15 ? 1e90 : kind == 14 ? (double)NAN : 0.1;
    double targets[6] = {0};
    for (int k = 0; k < 6; k++) {
        const tulle_mesh *const mesh = &self->cloths[is_there ? id.index : 0];
        size_t const vertex = k < 3 ? 0 : mesh->vertex_count - 1;
        targets[k] = mesh->positions[3 * vertex + (size_t)k % 3] +
                     size * fuzz_take_between(bytes, -1.0, 1.0);
    }
    *is_good =
        kind != 14 && is_there && tulle_world_get_time(self->world) < self->release_times[id.index];
    note_given(self, 100 + id.index, targets, 6);
    return tulle_cloth_set_pin_targets(self->world, id, 0, targets, 2, error);
}

/* Gives something or other for the next step; the state is as before. */
static void give_something(session *self) {
    uint64_t const before = tulle_world_get_state_hash(self->world), given = self->given;
    uint32_t const kind = fuzz_take_below(self->bytes, 8);
    uint32_t const count = kind == 0 ? self->cloth_count : self->obstacle_count;
    uint32_t const choice = fuzz_take_below(self->bytes, 16);
    uint32_t const index = choice == 15 || count == 0 ? count : choice % count;
    tulle_error error = {0};
    tulle_status status;
    bool is_good, *waits;
    if (kind == 0) {
        status = give_pin(self, (tulle_cloth_id){index, 1}, &is_good, &error);
        waits = &self->pin_waits[index % CLOTHS_MAX];
    } else {
        bool const is_there = index < self->obstacle_count;
        tulle_drive const drive = is_there ? self->drives[index] : TULLE_DRIVE_NONE;
        tulle_drive const wrong = index % 2 ? TULLE_DRIVE_RIGID : TULLE_DRIVE_DEFORMING;
        tulle_drive const taken = drive == TULLE_DRIVE_NONE || kind == 7 ? wrong : drive;
        status = give_obstacle(self, (tulle_obstacle_id){index, 1}, taken, &is_good, &error);
        is_good = is_good && is_there && taken == drive;
        waits = &self->waits[index % OBSTACLES_MAX];
    }
    say("give", status, &error);
    FUZZ_CHECK((status == TULLE_OK) == (is_good && !*waits));
    FUZZ_CHECK(tulle_world_get_state_hash(self->world) == before);
    if (status) {
        fuzz_check_error(status, &error);
        self->given = given;
    } else {
        *waits = true;
    }
}

static void give(session *self) {
    for (uint32_t left = 1 + fuzz_take_below(self->bytes, 3); left > 0; left--)
        give_something(self);
}

static void step(session *self) {
    static const double steps[] = {1.0 / 90.0, 1.0 / 90.0, 1.0 / 30.0, 1.0 / 400.0, 0.0, 0.2};
    uint32_t const choice = fuzz_take_below(self->bytes, 6);
    bool const is_stopped_early =
        fuzz_take_below(self->bytes, 16) == 15 && self->is_stopped_at_times;
    uint64_t const before = tulle_world_get_state_hash(self->world);
    self->questions_left = is_stopped_early ? 3 : QUESTIONS_MAX;
    tulle_step_report report = {0};
    tulle_error error = {0};
    bool const is_batch = tulle_world_get_step_count(self->world) % 3 == 2;
    tulle_world_batch const batch = {&self->world, 1, 1, &report, NULL};
    tulle_status const status = is_batch
                                    ? tulle_worlds_step(&batch, steps[choice], &error)
                                    : tulle_world_step(self->world, steps[choice], &report, &error);
    uint64_t const after = tulle_world_get_state_hash(self->world);
    say("step", status, &error);
    uint64_t const given = self->given;
    if (steps[choice] > 0.0) let_go_of_given(self);
    if (status) {
        fuzz_check_error(status, &error);
        FUZZ_CHECK(after == before);
        FUZZ_CHECK(status != TULLE_ERROR_INTERRUPTED || self->questions_left < 0);
        self->was_stopped |= status == TULLE_ERROR_INTERRUPTED;
        return;
    }
    FUZZ_CHECK(steps[choice] > 0.0 && report.substeps >= 1 && report.max_stretch >= 0.0);
    check_state(self);
    /* The same steps from the saved state lead to the same states. */
    if (!self->is_on_the_way || self->followed_count == CALLS_MAX) return;
    size_t const at = self->replayed_count;
    if (at < self->followed_count && self->followed_steps[at] == steps[choice] &&
        self->followed_given[at] == given) {
        FUZZ_CHECK(self->followed[at] == after);
    } else {
        self->followed[at] = after;
        self->followed_steps[at] = steps[choice];
        self->followed_given[at] = given;
        self->followed_count = at + 1;
    }
    self->replayed_count++;
}

static void save(session *self) {
    tulle_error error = {0};
    tulle_world_free_state(self->world, self->saved, self->saved_size);
    FUZZ_CHECK_OK(tulle_world_save_state(self->world, &self->saved, &self->saved_size, &error),
                  &error);
    say("save", TULLE_OK, NULL);
    /* Into memory of its own it gives the same bytes. */
    size_t size = 0;
    unsigned char *const into = malloc(self->saved_size);
    FUZZ_CHECK(into && tulle_world_get_state_size(self->world) == self->saved_size);
    FUZZ_CHECK(tulle_world_save_state_into(self->world, into, self->saved_size - 1, &size,
                                           &error) == TULLE_ERROR_INVALID_ARGUMENT);
    FUZZ_CHECK_OK(tulle_world_save_state_into(self->world, into, self->saved_size, &size, &error),
                  &error);
    FUZZ_CHECK(size == self->saved_size && memcmp(into, self->saved, size) == 0);
    free(into);
    self->saved_hash = tulle_world_get_state_hash(self->world);
    memcpy(self->saved_releases, self->release_times, sizeof self->release_times);
    self->followed_count = self->replayed_count = 0;
    self->is_on_the_way = true;
}

static void go_back(session *self) {
    tulle_error error = {0};
    if (!self->saved) return;
    FUZZ_CHECK_OK(tulle_world_load_state(self->world, self->saved, self->saved_size, &error),
                  &error);
    FUZZ_CHECK(tulle_world_get_state_hash(self->world) == self->saved_hash);
    say("go back", TULLE_OK, NULL);
    memcpy(self->release_times, self->saved_releases, sizeof self->release_times);
    let_go_of_given(self);
    self->replayed_count = 0;
    self->is_on_the_way = true;
    check_state(self);
}

/* After a call that may change the state, but not when it fails. */
static void end_change(session *self, uint64_t before, tulle_status status,
                       const tulle_error *error) {
    if (status) {
        fuzz_check_error(status, error);
        FUZZ_CHECK(tulle_world_get_state_hash(self->world) == before);
    } else {
        self->is_on_the_way = false;
    }
}

/* Changes gravity or wind, to what may be or to what may not. */
static void change_settings(session *self) {
    fuzz_bytes *const bytes = self->bytes;
    uint64_t const before = tulle_world_get_state_hash(self->world);
    uint32_t const kind = fuzz_take_below(bytes, 8);
    double const value = kind == 7 ? (double)NAN : kind == 6 ? 1e30 : 20.0;
    double numbers[3];
    for (int k = 0; k < 3; k++) numbers[k] = value * fuzz_take_between(bytes, -1.0, 1.0);
    tulle_wind wind = self->def.wind;
    memcpy(wind.velocity, numbers, sizeof numbers);
    wind.gust_strength = fuzz_take_below(bytes, 2) ? 1.0 : 0.0;
    bool const is_good =
        fabs(numbers[0]) <= 1e6 && fabs(numbers[1]) <= 1e6 && fabs(numbers[2]) <= 1e6;
    tulle_error error = {0};
    tulle_status const status = kind % 2 ? tulle_world_set_gravity(self->world, numbers, &error)
                                         : tulle_world_set_wind(self->world, &wind, &error);
    say("change", status, &error);
    FUZZ_CHECK((status == TULLE_OK) == is_good);
    end_change(self, before, status, &error);
}

/* Changes the law of a cloth and an obstacle, if they are there. */
static void change_law(session *self) {
    fuzz_bytes *const bytes = self->bytes;
    tulle_cloth_id const cloth = {fuzz_take_below(bytes, CLOTHS_MAX), 1};
    tulle_obstacle_id const obstacle = {fuzz_take_below(bytes, OBSTACLES_MAX), 1};
    tulle_contact_law const law = {fuzz_take_between(bytes, 0.0, 1.0), -1.0,
                                   fuzz_take_between(bytes, 0.0, 1.1)};
    bool const is_good = cloth.index < self->cloth_count && obstacle.index < self->obstacle_count &&
                         law.restitution <= 1.0;
    uint64_t const before = tulle_world_get_state_hash(self->world);
    tulle_error error = {0};
    tulle_status const status =
        tulle_world_set_cloth_obstacle_law(self->world, cloth, obstacle, &law, &error);
    say("change a law", status, &error);
    FUZZ_CHECK((status == TULLE_OK) == is_good);
    end_change(self, before, status, &error);
}

/* Changes what a cloth is made of, how thick it is, or lets go of a pin. */
static void change_cloth(session *self) {
    fuzz_bytes *const bytes = self->bytes;
    uint64_t const before = tulle_world_get_state_hash(self->world);
    tulle_cloth_id const id = {fuzz_take_below(bytes, self->cloth_count + 1), 1};
    uint32_t const kind = fuzz_take_below(bytes, 4);
    tulle_error error = {0};
    tulle_status status;
    if (kind == 3) {
        status = tulle_cloth_wake(self->world, id, &error);
    } else if (kind == 0) {
        tulle_material material;
        FUZZ_CHECK(tulle_material_preset(tulle_material_preset_name(fuzz_take_below(bytes, 23)),
                                         &material) == TULLE_OK);
        if (BY_PAPER(self)) material.springs.stiffening_strain = 0.0;
        if (fuzz_take_below(bytes, 8) == 7) material.area_density = (double)NAN;
        status = tulle_cloth_set_material(self->world, id, &material, &error);
    } else if (kind == 1) {
        double contact;
        tulle_world_get_distances(self->world, &contact, NULL, NULL);
        double const thickness = contact * fuzz_take_between(bytes, 0.0, 1.2);
        status = tulle_cloth_set_thickness(self->world, id, thickness, &error);
    } else {
        status = tulle_cloth_release_pin(self->world, id, fuzz_take_below(bytes, 2), &error);
        if (status == TULLE_OK)
            self->release_times[id.index] =
                fmin(self->release_times[id.index], tulle_world_get_time(self->world));
    }
    say("change cloth", status, &error);
    end_change(self, before, status, &error);
}

/* Attaches vertices of a cloth to this or that, moves what it attached, or lets go. */
static void attach(session *self) {
    fuzz_bytes *const bytes = self->bytes;
    uint64_t const before = tulle_world_get_state_hash(self->world);
    uint32_t const kind = fuzz_take_below(bytes, 8);
    tulle_attachment_id const id = fuzz_take_below(bytes, 4);
    double points[9];
    for (int k = 0; k < 9; k++) points[k] = fuzz_take_between(bytes, -0.6, 0.6);
    if (fuzz_take_below(bytes, 16) == 15) points[4] = (double)NAN;
    tulle_error error = {0};
    tulle_status status;
    if (kind == 0) {
        status = tulle_attachment_release(self->world, id, &error);
    } else if (kind == 1) {
        status = tulle_attachment_set_points(self->world, id, points, 3, &error);
    } else {
        tulle_attachment_def def = tulle_attachment_def_default();
        def.cloth = (tulle_cloth_id){fuzz_take_below(bytes, self->cloth_count + 1), 1};
        uint32_t const first = fuzz_take_below(bytes, 12);
        uint32_t const vertices[3] = {first, first + 1, first + 2};
        def.vertices = vertices;
        def.vertex_count = 3;
        uint32_t const triangles[3] = {fuzz_take_below(bytes, 16), 0, 1};
        double const weights[9] = {0.2, 0.3, 0.5, 1.0, 0.0, 0.0, 1.2, -0.1, -0.1};
        if (kind < 4) def.points = points;
        if (kind == 4 || kind == 5)
            def.obstacle = (tulle_obstacle_id){fuzz_take_below(bytes, OBSTACLES_MAX), 1};
        if (kind > 5) def.other_cloth = (tulle_cloth_id){fuzz_take_below(bytes, CLOTHS_MAX), 1};
        if (kind == 5 || kind == 7) {
            def.triangles = triangles;
            def.weights = weights;
        }
        uint32_t const law = fuzz_take_below(bytes, 8);
        if (law % 2) def.stiffness = law > 3 ? 1e4 : 5.0;
        if (law % 4 > 1) def.break_force = fuzz_take_between(bytes, 0.0, 5.0);
        if (law == 7) def.max_distance = 0.2;
        tulle_attachment_id made;
        status = tulle_world_attach(self->world, &def, &made, &error);
        FUZZ_CHECK(status != TULLE_OK ||
                   tulle_attachment_get_report(self->world, made).held_count > 0);
    }
    say("attach", status, &error);
    end_change(self, before, status, &error);
}

static void push_body(session *self) {
    tulle_obstacle_id const id = {fuzz_take_below(self->bytes, OBSTACLES_MAX + 1), 1};
    double const impulse[3] = {fuzz_take_between(self->bytes, -1, 1), 0.0,
                               fuzz_take_between(self->bytes, -1, 1)};
    double const point[3] = {0.0, 0.0, 0.1};
    tulle_error error = {0};
    bool const is_body = id.index < self->obstacle_count && self->is_body[id.index];
    uint64_t const before = tulle_world_get_state_hash(self->world);
    tulle_status const status = tulle_obstacle_add_impulse(self->world, id, point, impulse, &error);
    say("push", status, &error);
    FUZZ_CHECK((status == TULLE_OK) == is_body);
    if (status) {
        fuzz_check_error(status, &error);
        FUZZ_CHECK(tulle_world_get_state_hash(self->world) == before);
        return;
    }
    self->is_on_the_way = false;
    FUZZ_CHECK_OK(tulle_obstacle_wake(self->world, id, &error), &error);
}

/* Locks and drives of a body, by what may be or by what may not; a force or a velocity now and
 * then. */
static void control_body(session *self) {
    fuzz_bytes *const bytes = self->bytes;
    tulle_obstacle_id const id = {fuzz_take_below(bytes, OBSTACLES_MAX + 1), 1};
    bool const is_body = id.index < self->obstacle_count && self->is_body[id.index];
    uint32_t const kind = fuzz_take_below(bytes, 8), bad = fuzz_take_below(bytes, 16);
    static const double gains[] = {0.0, 1.0, 1e3, 1e12}, limits[] = {0.0, 0.1, 10.0, 1e6};
    double const value = bad == 15 ? (double)NAN : bad == 14 ? 1e300 : 1.0;
    double numbers[3];
    for (int k = 0; k < 3; k++) numbers[k] = value * fuzz_take_between(bytes, -1.0, 1.0);
    bool is_good =
        is_body && fabs(numbers[0]) < 1e6 && fabs(numbers[1]) < 1e6 && fabs(numbers[2]) < 1e6;
    uint64_t const before = tulle_world_get_state_hash(self->world);
    tulle_error error = {0};
    tulle_status status;
    if (kind == 0) {
        status = tulle_obstacle_set_velocity(self->world, id, numbers, numbers, &error);
    } else if (kind == 1) {
        status = tulle_obstacle_add_force(self->world, id, numbers, numbers, &error);
    } else if (kind == 2) {
        status = tulle_obstacle_add_torque(self->world, id, numbers, &error);
    } else if (kind < 5) {
        unsigned const locks = fuzz_take(bytes);
        is_good = is_body && locks < 64;
        status = tulle_obstacle_set_locks(self->world, id, locks % 8, locks / 8, &error);
    } else {
        tulle_body_drive drive = tulle_body_drive_default();
        memcpy(drive.position, numbers, sizeof numbers);
        memcpy(drive.velocity, numbers, sizeof numbers);
        for (int k = 0; k < 3; k++) {
            unsigned const choice = fuzz_take(bytes);
            drive.stiffness[k] = gains[choice % 4];
            drive.damping[k] = gains[choice / 4 % 4];
            drive.force_limit[k] = limits[choice / 16 % 4];
            drive.angular_stiffness[k] = gains[choice / 64];
            drive.torque_limit[k] = limits[choice % 3];
        }
        status = tulle_obstacle_set_drive(self->world, id, &drive, &error);
    }
    say("control", status, &error);
    FUZZ_CHECK((status == TULLE_OK) == is_good);
    if (status) {
        fuzz_check_error(status, &error);
        FUZZ_CHECK(tulle_world_get_state_hash(self->world) == before);
        return;
    }
    self->is_on_the_way = false;
    if (kind == 1 || kind == 2)
        note_given(self, 200 + 10 * kind + id.index, numbers, 3); /* waits */
    double force[3], torque[3];
    FUZZ_CHECK_OK(tulle_obstacle_get_drive_force(self->world, id, force, torque, &error), &error);
    for (int k = 0; k < 3; k++) FUZZ_CHECK(isfinite(force[k]) && isfinite(torque[k]));
}

/* Watches events, or takes those that are there. */
static void watch(session *self) {
    uint64_t const before = tulle_world_get_state_hash(self->world);
    tulle_error error = {0};
    if (fuzz_take_below(self->bytes, 3) == 0) {
        tulle_event_watch wanted = tulle_event_watch_default();
        wanted.kinds = fuzz_take(self->bytes) * 16u;
        wanted.capacity = fuzz_take_below(self->bytes, 8);
        wanted.contact_force = fuzz_take_between(self->bytes, -0.1, 1.0);
        bool const is_good = wanted.kinds > 0 && wanted.kinds < 1u << TULLE_EVENT_KIND_COUNT &&
                             wanted.capacity > 0 && wanted.contact_force >= 0.0;
        tulle_status const status = tulle_world_watch_events(self->world, &wanted, &error);
        FUZZ_CHECK((status == TULLE_OK) == is_good);
        if (status) fuzz_check_error(status, &error);
        if (status == TULLE_OK) self->watches = true;
    }
    tulle_event events[4];
    size_t count;
    uint64_t lost;
    tulle_status const status =
        tulle_world_poll_events(self->world, events, 4, &count, &lost, &error);
    FUZZ_CHECK((status == TULLE_OK) == self->watches && count <= 4);
    uint32_t const object_count = self->cloth_count + self->obstacle_count;
    for (size_t i = 0; i < count; i++) {
        FUZZ_CHECK(events[i].kind < TULLE_EVENT_KIND_COUNT && events[i].force >= 0.0);
        FUZZ_CHECK(events[i].object_a < object_count || events[i].object_a == UINT32_MAX);
        FUZZ_CHECK(events[i].object_b < object_count || events[i].object_b == UINT32_MAX);
        FUZZ_CHECK(events[i].step < tulle_world_get_step_count(self->world));
    }
    FUZZ_CHECK(tulle_world_get_state_hash(self->world) == before);
}

/* Looks at everything; nothing changes by that. */
static void look(session *self) {
    uint64_t const before = tulle_world_get_state_hash(self->world);
    const tulle_contact *contacts;
    size_t count;
    tulle_error error = {0};
    FUZZ_CHECK_OK(tulle_world_get_contacts(self->world, &contacts, &count, &error), &error);
    for (size_t i = 0; i < count; i++) {
        FUZZ_CHECK(contacts[i].object_a < self->cloth_count + self->obstacle_count);
        FUZZ_CHECK(contacts[i].object_b < self->cloth_count + self->obstacle_count);
        FUZZ_CHECK(isfinite(contacts[i].gap) && contacts[i].gap >= 0.0);
    }
    for (uint32_t i = 0; i < self->obstacle_count; i++) {
        double impulse[3], moment[3];
        FUZZ_CHECK_OK(tulle_obstacle_get_contact_impulse(self->world, (tulle_obstacle_id){i, 1},
                                                         impulse, moment, &error),
                      &error);
        for (int k = 0; k < 3; k++) FUZZ_CHECK(isfinite(impulse[k]) && isfinite(moment[k]));
    }
    tulle_stretch const stretch = tulle_world_find_largest_stretch(self->world);
    FUZZ_CHECK(isfinite(stretch.stretch));
    double const ratio =
        tulle_world_get_numerical_damping(self->world, fuzz_take_between(self->bytes, -0.1, 1.0),
                                          fuzz_take_between(self->bytes, -1, 9));
    FUZZ_CHECK(ratio >= 0.0 && ratio <= 1.0);
    tulle_fineness const fineness = tulle_cloth_get_fineness(self->world, (tulle_cloth_id){0, 1});
    FUZZ_CHECK(fineness.mean_edge > 0.0 && isfinite(fineness.mean_edge));
    FUZZ_CHECK(fineness.bending_length >= 0.0 && isfinite(fineness.bending_length));
    static uint32_t labels[1024];
    tulle_patch_options const options = {.time_step = 0.01,
                                         .is_in_use = (int)fuzz_take_below(self->bytes, 2)};
    tulle_cloth_id const cloth = {fuzz_take_below(self->bytes, CLOTHS_MAX + 1), 1};
    tulle_status const status =
        tulle_cloth_get_patches(self->world, cloth, &options, labels, &count, &error);
    FUZZ_CHECK((status == TULLE_OK) == (cloth.index < self->cloth_count));
    queries_ask(self->world, &self->cloths[0], before);
    FUZZ_CHECK(tulle_world_get_state_hash(self->world) == before);
}

/* Calls that a world that has started refuses. */
static void be_refused(session *self) {
    uint64_t const before = tulle_world_get_state_hash(self->world);
    tulle_error error = {0};
    FUZZ_CHECK(tulle_world_remove_cloth(self->world, (tulle_cloth_id){0, 2}, &error) ==
               TULLE_ERROR_INVALID_ARGUMENT);
    FUZZ_CHECK(tulle_world_step(self->world, -1.0, NULL, &error) == TULLE_ERROR_INVALID_ARGUMENT);
    FUZZ_CHECK(tulle_world_step(self->world, (double)NAN, NULL, &error) ==
               TULLE_ERROR_INVALID_ARGUMENT);
    FUZZ_CHECK(tulle_world_load_state(self->world, "nothing", 7, &error) == TULLE_ERROR_PARSE);
    FUZZ_CHECK(!tulle_cloth_get_positions(self->world, (tulle_cloth_id){0, 0}, NULL));
    FUZZ_CHECK(tulle_world_get_state_hash(self->world) == before);
}

/* How a run ended. */
typedef struct run_end {
    uint64_t hash;
    bool was_stopped;
} run_end;

/* Makes a world of the bytes and all calls. */
static run_end run(fuzz_bytes bytes, int threads, bool is_stopped_at_times) {
    session self = {
        .bytes = &bytes, .def = take_def(&bytes), .is_stopped_at_times = is_stopped_at_times};
    tulle_error error = {0};
    self.def.threads = threads;
    FUZZ_CHECK_OK(tulle_world_create(&self.def, &self.world, &error), &error);
    worlds_made++;
    for (uint32_t left = 1 + fuzz_take_below(&bytes, CLOTHS_MAX); left > 0; left--)
        add_cloth(&self);
    for (uint32_t left = fuzz_take_below(&bytes, OBSTACLES_MAX + 1); left > 0; left--)
        add_obstacle(&self);
    self.questions_left = QUESTIONS_MAX;
    tulle_world_set_stop_request(self.world, ask, &self);
    count_call();
    start(&self);
    static void (*const calls[])(session *) = {
        step,       step,   step,         step,         step,         save, go_back,
        push_body,  look,   be_refused,   give,         give,         give, change_settings,
        change_law, attach, change_cloth, control_body, control_body, watch};
    for (int left = CALLS_MAX; left > 0 && self.is_started && bytes.used < bytes.size; left--) {
        count_call();
        calls[fuzz_take_below(&bytes, sizeof calls / sizeof calls[0])](&self);
    }
    run_end const end = {tulle_world_get_state_hash(self.world), self.was_stopped};
    tulle_world_free_state(self.world, self.saved, self.saved_size);
    tulle_world_destroy(self.world);
    for (uint32_t i = 0; i < self.cloth_count; i++) tulle_mesh_destroy(&self.cloths[i]);
    for (uint32_t i = 0; i < self.obstacle_count; i++) tulle_mesh_destroy(&self.obstacles[i]);
    return end;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_bytes bytes = {data, size, 0};
    bool const is_done_twice = fuzz_take_below(&bytes, 4) == 3;
    run_end const end = run(bytes, 1, !is_done_twice);
    if (!is_done_twice) return 0;
    run_end const again = run(bytes, 2, false);
    FUZZ_CHECK(end.was_stopped || again.was_stopped || end.hash == again.hash);
    return 0;
}

void fuzz_make_seeds(void) { fuzz_put_random_seeds(40, 160); }
