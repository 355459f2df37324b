/* One scene told in other words has the same answer: turned, mirrored, moved, renumbered, in other
 * units, later.
 *
 * Where all products and sums are the same numbers but for signs and powers of two, every bit must
 * be the same, however wild the contact: a dependence on an axis, on the sign of a coordinate, on
 * the time or on a unit shows. Where sums are rounded otherwise, the first steps differ by rounding
 * alone, for a linear solve that leaves no more; after that contact is chaos, and only what it
 * conserves is compared. test/README.md says what depends on units, and why. */
#include "math/vec3.h"
#include "support/changed_world.h"
#include "support/small_world.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const double STEP = 0x1p-6; /* [s] */
static const double FRICTION = 0.3;

static bool is_long(void) { return getenv("TULLE_TEST_LONG") != NULL; }

/* ---- scenes ---- */

/* Takes a mesh in; coordinates become multiples of 2^-20 m, so that a shift is exact. */
static plain_object *add(plain_scene *scene, tulle_mesh mesh) {
    for (size_t i = 0; i < 3 * mesh.vertex_count; i++)
        mesh.positions[i] = ldexp(rint(ldexp(mesh.positions[i], 20)), -20);
    plain_object *const object = &scene->objects[scene->object_count++];
    object->mesh = mesh;
    return object;
}

static plain_object *add_sheet(plain_scene *scene, double side, double z) {
    return add(scene, small_sheet(side, is_long() ? 15 : 9, z));
}

static plain_object *add_solid(plain_scene *scene, tulle_shape kind, double size, vec3 at) {
    tulle_shape_def def = tulle_shape_def_default(kind);
    for (int k = 0; k < 3; k++)
        if (def.size[k] != 0.0) def.size[k] = size;
    if (def.radius != 0.0) def.radius = size;
    if (def.height != 0.0) def.height = 2.0 * size;
    if (kind != TULLE_SHAPE_TETRAHEDRON) def.resolution[0] = 3;
    plain_object *const object = add(scene, small_shape(def, at.x, at.y, at.z));
    object->is_obstacle = true;
    return object;
}

static void pin(plain_object *sheet, size_t count) {
    uint32_t const side = is_long() ? 15 : 9, last = side * side - 1;
    const uint32_t corners[4] = {0, side - 1, last - (side - 1), last};
    memcpy(sheet->pins, corners, count * sizeof *corners);
    sheet->pin_count = count;
}

/* Cloth hangs from two corners in the wind and touches nothing. */
static plain_scene make_hanging(void) {
    plain_scene scene = {.air_speed = 0.5};
    pin(add_sheet(&scene, 0.5, 0.0), 2);
    return scene;
}

static plain_scene make_sphere(void) {
    plain_scene scene = {0};
    add_sheet(&scene, 0.4, 0.105)->velocity[2] = -0.5;
    (void)add_solid(&scene, TULLE_SHAPE_SPHERE, 0.1, vec3_make(0.01, 0.02, 0.0));
    return scene;
}

static plain_scene make_spikes(void) {
    plain_scene scene = {0};
    add_sheet(&scene, 0.4, 0.105)->velocity[2] = -0.5;
    (void)add_solid(&scene, TULLE_SHAPE_TETRAHEDRON, 0.05, vec3_make(0.11, 0.01, 0.0));
    (void)add_solid(&scene, TULLE_SHAPE_TETRAHEDRON, 0.05, vec3_make(-0.062, 0.093, 0.0));
    (void)add_solid(&scene, TULLE_SHAPE_TETRAHEDRON, 0.05, vec3_make(-0.07, -0.09, 0.0));
    return scene;
}

/* A hairpin of cloth falls on a table, and its upper half on the lower one: many ties. */
static plain_scene make_fold(void) {
    plain_scene scene = {0};
    double const radius = 0.01, quarter = 1.5707963267948966;
    plain_object *const sheet = add_sheet(&scene, 0.4, 0.0);
    for (size_t v = 0; v < sheet->mesh.vertex_count; v++) {
        double *const x = sheet->mesh.positions + 3 * v;
        double const angle = x[0] / radius;
        bool const is_round = fabs(angle) < quarter;
        x[2] = is_round ? radius * sin(angle) : copysign(radius, angle);
        x[0] = is_round ? -radius * cos(angle) : radius * (fabs(angle) - quarter);
        for (int k = 0; k < 3; k++) x[k] = ldexp(rint(ldexp(x[k], 20)), -20);
    }
    (void)add_solid(&scene, TULLE_SHAPE_BOX, 0.5, vec3_make(0.0, 0.0, -0.27));
    return scene;
}

/* A box slides over a sheet on a table: many ties. */
static plain_scene make_box(void) {
    plain_scene scene = {0};
    add_sheet(&scene, 0.4, 0.0);
    (void)add_solid(&scene, TULLE_SHAPE_BOX, 0.3, vec3_make(0.0, 0.0, -0.155));
    plain_object *const body =
        add_solid(&scene, TULLE_SHAPE_BOX, 0.08, vec3_make(0.02, 0.01, 0.05));
    body->density = 200.0;
    body->velocity[0] = 0.3;
    return scene;
}

/* A ball falls into a hammock whose corners move and turn, in the wind. */
static plain_scene make_hammock(void) {
    plain_scene scene = {.air_speed = 0.5};
    plain_object *const sheet = add_sheet(&scene, 0.5, 0.0);
    pin(sheet, 4);
    sheet->key_count = 2;
    sheet->keys[0] = (tulle_keyframe){0.0, {0.0, 0.0, 0.0}, {0, 0, 0}};
    sheet->keys[1] = (tulle_keyframe){1.0, {0.125, 0.0625, 0.125}, {0.0, 0.5675882184166567, 0.0}};
    add_solid(&scene, TULLE_SHAPE_SPHERE, 0.06, vec3_make(0.03, 0.01, 0.068))->density = 300.0;
    return scene;
}

typedef struct named_scene {
    const char *name;
    plain_scene (*make)(void);
    bool has_body, has_ties;
} named_scene;
static const named_scene scenes[] = {
    {.name = "hanging", .make = make_hanging},
    {.name = "sphere", .make = make_sphere},
    {.name = "spikes", .make = make_spikes},
    {.name = "fold", .make = make_fold, .has_ties = true},
    {.name = "box", .make = make_box, .has_body = true, .has_ties = true},
    {.name = "hammock", .make = make_hammock, .has_body = true}};
enum { SCENE_COUNT = sizeof scenes / sizeof scenes[0] };

/* ---- changes ---- */

#define AS_IT_IS                                                                                   \
    { 1, 0, 0, 0, 1, 0, 0, 0, 1 }
static const change no_change = {.name = "as it is", .matrix = AS_IT_IS};

/* Signs change, or factors that are powers of four: square roots of these are exact, too. */
static const change bodies_too[] = {
    {.name = "mass times 1024", .matrix = AS_IT_IS, .mass = 10},
    {.name = "mass over 16", .matrix = AS_IT_IS, .mass = -4},
    {.name = "twelve days later", .matrix = AS_IT_IS, .start_time = 0x1p20}};
/* Solids may not be turned inside out, and the axes of a body's inertia are found by an iteration
 * that rounds otherwise in a turned frame. */
static const change without_bodies[] = {
    {.name = "half a turn about x", .matrix = {1, 0, 0, 0, -1, 0, 0, 0, -1}},
    {.name = "half a turn about y", .matrix = {-1, 0, 0, 0, 1, 0, 0, 0, -1}},
    {.name = "half a turn about z", .matrix = {-1, 0, 0, 0, -1, 0, 0, 0, 1}},
    {.name = "mirrored along x", .matrix = {-1, 0, 0, 0, 1, 0, 0, 0, 1}},
    {.name = "mirrored along y", .matrix = {1, 0, 0, 0, -1, 0, 0, 0, 1}},
    {.name = "mirrored along z", .matrix = {1, 0, 0, 0, 1, 0, 0, 0, -1}},
    {.name = "mirrored at a point", .matrix = {-1, 0, 0, 0, -1, 0, 0, 0, -1}}};
/* Speeds are the same numbers. Only the time in which anchors of friction fade is not. */
static const change without_friction[] = {
    {.name = "length and time times 16", .matrix = AS_IT_IS, .length = 4, .time = 4},
    {.name = "length and time over 4", .matrix = AS_IT_IS, .length = -2, .time = -2}};
/* Speeds differ, and some of contact are given in m/s. */
static const change without_contact[] = {
    {.name = "length times 4", .matrix = AS_IT_IS, .length = 2},
    {.name = "length over 16", .matrix = AS_IT_IS, .length = -4},
    {.name = "time times 4", .matrix = AS_IT_IS, .time = 2},
    {.name = "time over 16", .matrix = AS_IT_IS, .time = -4},
    {.name = "all units", .matrix = AS_IT_IS, .length = 4, .time = -2, .mass = 6}};
/* Sums are rounded otherwise. */
static const change rounded[] = {
    {.name = "mirrored and turned over",
     .matrix = {-1, 0, 0, 0, 1, 0, 0, 0, 1},
     .turns_over = true},
    {.name = "a quarter turn about x", .matrix = {1, 0, 0, 0, 0, -1, 0, 1, 0}},
    {.name = "a quarter turn about z", .matrix = {0, -1, 0, 1, 0, 0, 0, 0, 1}},
    {.name = "axes exchanged", .matrix = {0, 0, 1, 1, 0, 0, 0, 1, 0}},
    {.name = "moved by a kilometre", .matrix = AS_IT_IS, .shift = {1024, -512, 64}},
    {.name = "objects added in turn", .matrix = AS_IT_IS, .is_reversed = true},
    {.name = "mass times 2", .matrix = AS_IT_IS, .mass = 1},
    /* the quick form has these alone of chaos */
    {.name = "turned", .matrix = {0.36, 0.48, -0.8, -0.8, 0.6, 0.0, 0.48, 0.64, 0.6}},
    {.name = "moved by metres", .matrix = AS_IT_IS, .shift = {1, -2, 4}},
    {.name = "renumbered", .matrix = AS_IT_IS, .seed = 5}};
enum { ROUNDED = sizeof rounded / sizeof rounded[0], QUICK_CHAOS = 3 };

enum { CHANGES_MAX = 32 };
typedef struct change_list {
    const change *changes;
    size_t count;
} change_list;
#define LIST(changes) ((change_list){changes, sizeof(changes) / sizeof(changes)[0]})

/* ---- a scene and its changes, side by side ---- */

typedef struct side_by_side {
    const named_scene *named;
    plain_scene scene;
    changed_world base, others[CHANGES_MAX];
    size_t count;
    uint64_t contacts; /* of the base, over all steps */
    int step_count;
} side_by_side;

/* The scene with the settings of `with`. */
static void begin(side_by_side *own, const named_scene *named, change_list list, plain_scene with) {
    *own = (side_by_side){.named = named, .scene = named->make(), .count = list.count};
    own->scene.cg_tolerance = with.cg_tolerance;
    own->scene.friction = with.friction;
    own->scene.integrator = with.integrator;
    own->scene.membrane = with.membrane;
    own->base = changed_world_make(&own->scene, &no_change);
    for (size_t i = 0; i < list.count; i++)
        own->others[i] = changed_world_make(&own->scene, &list.changes[i]);
}

static void step_all(side_by_side *own) {
    changed_world_step(&own->base, STEP);
    for (size_t i = 0; i < own->count; i++) changed_world_step(&own->others[i], STEP);
    own->contacts += own->base.report.contacts;
    own->step_count++;
}

static void end(side_by_side *own) {
    for (size_t i = 0; i < own->count; i++) {
        size_t const crossings = changed_world_judge(&own->others[i]);
        if (crossings > 0)
            fail_msg("%s, %s: %zu pairs cross", own->named->name, own->others[i].how.name,
                     crossings);
        changed_world_destroy(&own->others[i]);
    }
    changed_world_destroy(&own->base);
    plain_scene_destroy(&own->scene);
}

/* Tests get the membrane as their state. */
static tulle_membrane take_membrane(void **state) { return *(const tulle_membrane *)*state; }

/* ---- to the bit ---- */

static void check_bits(const named_scene *named, change_list list, plain_scene with) {
    side_by_side own;
    begin(&own, named, list, with);
    for (int i = 0; i < (is_long() ? 64 : 8); i++) {
        step_all(&own);
        for (size_t k = 0; k < own.count; k++) {
            difference const found = changed_world_compare(&own.base, &own.others[k]);
            if (found.position != 0.0 || found.velocity != 0.0)
                fail_msg("%s, %s: in step %d places differ by %g m, velocities by %g m/s",
                         named->name, own.others[k].how.name, i, found.position, found.velocity);
        }
    }
    assert_true(own.contacts > 0 || named->make == make_hanging);
    end(&own);
}

static void equal_numbers_give_equal_bits(void **state) {
    plain_scene with = {.membrane = take_membrane(state), .friction = FRICTION};
    tulle_integrator const last =
        is_long() ? TULLE_INTEGRATOR_BDF2 : TULLE_INTEGRATOR_IMPLICIT_EULER;
    for (; with.integrator <= last; with.integrator++)
        for (size_t i = 0; i < SCENE_COUNT; i++) {
            check_bits(&scenes[i], LIST(bodies_too), with);
            if (!scenes[i].has_body) check_bits(&scenes[i], LIST(without_bodies), with);
        }
    with.integrator = TULLE_INTEGRATOR_IMPLICIT_EULER;
    check_bits(&scenes[0], LIST(without_contact), with);
    with.friction = 0.0;
    for (size_t i = 0; i < SCENE_COUNT; i++) check_bits(&scenes[i], LIST(without_friction), with);
}

/* ---- the first steps ---- */

enum { FIRST_STEPS = 5 };
/* The tightest that a world takes. */
static const double LEAST_TOLERANCE = 1e-12;
/* What a scene makes of rounding depends on its stiffness, its contact and how far solves are from
 * their answer. So it is measured: controls are the scene itself, its vertices moved by some
 * roundings of the largest coordinate. A change may differ by this many times what the controls of
 * its extent do. */
static const double JITTER = 0x1p-47, MOST_TIMES_CONTROL = 32.0;

/* [m] of a scene as told, about the origin. */
static double get_extent(const change *how) {
    double extent = 0.5;
    for (int k = 0; k < 3; k++) extent = fmax(extent, 0.5 + fabs(how->shift[k]));
    return extent;
}

/* Puts controls behind the changes, unless there are such already. */
enum { CONTROLS = 6 };
static void add_controls(change *changes, size_t *count, double jitter) {
    for (size_t i = 0; i < *count; i++)
        if (changes[i].jitter == jitter) return;
    for (uint64_t seed = 1; seed <= CONTROLS; seed++) {
        assert_true(*count < CHANGES_MAX);
        changes[(*count)++] = (change){
            .name = "moved a little", .matrix = AS_IT_IS, .jitter = jitter, .jitter_seed = seed};
    }
}

/* [m] how far any control of that extent has moved from the scene so far. */
static double find_control_difference(const double *differences, const change_list *all,
                                      const change *how) {
    double most = 0.0;
    for (size_t k = 0; k < all->count; k++)
        if (all->changes[k].jitter == JITTER * get_extent(how) && !(differences[k] <= most))
            most = differences[k];
    return most;
}

/* Ties are decided by rounding, and by the numbers of vertices. So scenes with ties are left out
 * from the first contact on. */
static void first_steps_differ_by_rounding(void **state) {
    plain_scene const with = {
        .membrane = take_membrane(state), .friction = FRICTION, .cg_tolerance = LEAST_TOLERANCE};
    change changes[CHANGES_MAX];
    change_list all = {changes, ROUNDED};
    memcpy(changes, rounded, sizeof rounded);
    for (size_t i = 0; i < ROUNDED; i++)
        add_controls(changes, &all.count, JITTER * get_extent(&rounded[i]));
    for (size_t s = 0; s < SCENE_COUNT; s++) {
        side_by_side own;
        begin(&own, &scenes[s], all, with);
        double most[CHANGES_MAX] = {0.0}; /* [m] over all steps so far */
        for (int i = 0; i < FIRST_STEPS; i++) {
            step_all(&own);
            if (scenes[s].has_ties && own.contacts > 0) break;
            for (size_t k = 0; k < all.count; k++)
                most[k] = fmax(most[k], changed_world_compare(&own.base, &own.others[k]).position);
            for (size_t k = 0; k < ROUNDED; k++) {
                double const control = find_control_difference(most, &all, &changes[k]);
                if (!(most[k] <= MOST_TIMES_CONTROL * control))
                    fail_msg("%s, %s: in step %d places differ by %g m, controls by %g m",
                             scenes[s].name, changes[k].name, i, most[k], control);
            }
        }
        end(&own);
    }
}

/* ---- what chaos leaves ---- */

/* Sums over all steps: of the energy of motion and springs, and of contacts, which come and go in
 * other steps. */
enum { ENERGY, CONTACTS, SUMS };
static const char *const sum_names[SUMS] = {"J", "contacts"};
/* Contact makes as much of a nanometre, here [m], as of any difference, and sooner. A change may
 * differ by this many times what such controls differ by, and by a share where ties fall otherwise.
 */
static const double CHAOS_JITTER = 0x1p-30;
static const double MOST_TIMES_SPREAD = 3.0, MOST_SHARE[SUMS] = {0.03, 0.1};
/* Beyond this spread sums test nothing: a nanometre decides to which side cloth folds. They are
 * judged after the last step at which it does not, of these at least. */
static const double MOST_SPREAD = 0.5;
enum { CHAOS_STEPS = 12, LONG_CHAOS_STEPS = 32 };

typedef double sum_array[CHANGES_MAX + 1][SUMS]; /* of the changes, then of the base */

static double find_spread(const change_list *all, sum_array sums, int q) {
    double spread = 0.0;
    for (size_t k = 0; k < all->count; k++)
        if (all->changes[k].jitter > 0.0)
            spread = fmax(spread, fabs(sums[k][q] - sums[all->count][q]));
    return spread;
}

static void check_sums(const named_scene *named, const change_list *all, sum_array sums) {
    const double *const base = sums[all->count];
    for (int q = 0; q < SUMS; q++) {
        double const spread = find_spread(all, sums, q);
        double const most = MOST_TIMES_SPREAD * spread + MOST_SHARE[q] * base[q];
        for (size_t k = 0; k < all->count; k++)
            if (!(fabs(sums[k][q] - base[q]) <= most))
                fail_msg("%s, %s: %g %s of %g, and controls differ by %g", named->name,
                         all->changes[k].name, sums[k][q], sum_names[q], base[q], spread);
    }
}

static void chaos_keeps_energy_and_contacts(void **state) {
    plain_scene const with = {.membrane = take_membrane(state), .friction = FRICTION};
    change changes[CHANGES_MAX];
    change_list all = {changes, is_long() ? ROUNDED : QUICK_CHAOS};
    memcpy(changes, rounded + ROUNDED - all.count, all.count * sizeof *changes);
    add_controls(changes, &all.count, CHAOS_JITTER);
    for (size_t s = 0; s < SCENE_COUNT; s++) {
        side_by_side own;
        begin(&own, &scenes[s], all, with);
        sum_array sums = {{0.0}}, next = {{0.0}};
        int judged = 0;
        for (int steps = 1; steps <= (is_long() ? LONG_CHAOS_STEPS : CHAOS_STEPS); steps++) {
            step_all(&own);
            for (size_t k = 0; k <= all.count; k++) {
                const changed_world *const world = k < all.count ? &own.others[k] : &own.base;
                next[k][ENERGY] += changed_world_get_energy(world);
                next[k][CONTACTS] += (double)world->report.contacts;
            }
            bool is_judged = steps >= CHAOS_STEPS;
            for (int q = 0; q < SUMS; q++)
                is_judged &= find_spread(&all, next, q) <= MOST_SPREAD * next[all.count][q];
            if (!is_judged) continue;
            memcpy(sums, next, sizeof sums);
            judged = steps;
        }
        if (judged == 0) fail_msg("%s: a nanometre decides all", scenes[s].name);
        check_sums(&scenes[s], &all, sums);
        end(&own);
    }
}

int main(void) {
    tulle_membrane woven = TULLE_MEMBRANE_WOVEN, springs = TULLE_MEMBRANE_SPRINGS;
    const struct CMUnitTest tests[] = {

        cmocka_unit_test_prestate(equal_numbers_give_equal_bits, &woven),
        cmocka_unit_test_prestate(first_steps_differ_by_rounding, &woven),
        cmocka_unit_test_prestate(chaos_keeps_energy_and_contacts, &woven),

        cmocka_unit_test_prestate(equal_numbers_give_equal_bits, &springs),
        cmocka_unit_test_prestate(first_steps_differ_by_rounding, &springs),
        cmocka_unit_test_prestate(chaos_keeps_energy_and_contacts, &springs),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
