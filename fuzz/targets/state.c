/* fuzz/targets/state.c - tulle_world_load_state. A load that fails changes nothing; what a load
 * takes can be saved, loaded again, looked at and stepped, and the world comes back from it.
 *
 * The first byte of an input says what the rest is: bytes in place of a saved state, or changes of
 * one (an offset of two bytes, a length, so many bytes); whether the size and the hash in its head
 * are made right; and whether the world has started. */
#include "support/fuzz.h"

#include "base/hash.h"
#include "tulle/tulle.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    FLAG_CHANGES = 1,
    FLAG_RIGHT_HASH = 2,
    FLAG_FRESH_WORLD = 4,
    STEP_COUNT = 24, /* until the state that is changed: cloth lies on the body */
    CHANGE_MAX = 16, /* [bytes] */
    HASH_PLACE = 8,  /* [bytes] in the head of a state: world/state.c */
    SIZE_PLACE = 16, /* behind the hash, which is of all that follows */
    HEAD_SIZE = 112,
    QUESTIONS_MAX = 300 /* of a step, until it is stopped */
};
static const double time_step = 1.0 / 90.0; /* [s] */

static tulle_mesh make_mesh(tulle_shape shape, double size, uint32_t resolution, double z) {
    tulle_shape_def def = tulle_shape_def_default(shape);
    for (int k = 0; k < 3; k++)
        if (def.size[k] != 0.0) def.size[k] = size; /* 0: the shape has none */
    if (def.radius != 0.0) def.radius = size;
    def.resolution[0] = def.resolution[1] = resolution;
    tulle_mesh mesh = {0};
    FUZZ_CHECK(tulle_shape_generate(&def, &mesh, NULL) == TULLE_OK);
    for (size_t i = 0; i < mesh.vertex_count; i++) mesh.positions[3 * i + 2] += z;
    return mesh;
}

/* Cloth over a rigid body over a box that moves. */
static tulle_world *make_world(void) {
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    def.contact_distance = 5e-3;
    def.membrane = TULLE_MEMBRANE_WOVEN;
    tulle_world *world = NULL;
    tulle_error error = {0};
    FUZZ_CHECK_OK(tulle_world_create(&def, &world, &error), &error);
    tulle_mesh sheet = make_mesh(TULLE_SHAPE_RECTANGLE, 0.3, 4, 0.14);
    tulle_mesh body = make_mesh(TULLE_SHAPE_BOX, 0.1, 2, 0.06);
    tulle_mesh ground = make_mesh(TULLE_SHAPE_BOX, 0.5, 2, -0.25);
    tulle_cloth_def cloth = tulle_cloth_def_default();
    cloth.mesh = tulle_mesh_get_view(&sheet);
    cloth.material.bend_hysteresis_warp = cloth.material.bend_hysteresis_weft = 1e-4;
    cloth.material.shear_hysteresis = 1.0;
    tulle_cloth_id cloth_id;
    FUZZ_CHECK_OK(tulle_world_add_cloth(world, &cloth, &cloth_id, &error), &error);
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    tulle_obstacle_id id;
    obstacle.mesh = tulle_mesh_get_view(&body);
    obstacle.body.is_dynamic = 1;
    obstacle.body.density = 500.0;
    FUZZ_CHECK_OK(tulle_world_add_obstacle(world, &obstacle, &id, &error), &error);
    obstacle.body.is_dynamic = 0;
    obstacle.mesh = tulle_mesh_get_view(&ground);
    tulle_keyframe const keys[2] = {{.rotation_vector = {0, 0, 0}},
                                    {1.0, {0.1, 0.0, 0.0}, {0, 0, 0}}};
    obstacle.motion = (tulle_motion){.keys = keys, .key_count = 2};
    FUZZ_CHECK_OK(tulle_world_add_obstacle(world, &obstacle, &id, &error), &error);
    tulle_mesh_destroy(&sheet);
    tulle_mesh_destroy(&body);
    tulle_mesh_destroy(&ground);
    return world;
}

/* A world in contact, and its state; made once. */
static tulle_world *base_world;
static void *base_bytes;
static size_t base_size;
static uint64_t base_hash;

static void make_hash_right(uint8_t *state, uint64_t size) {
    if (size < HEAD_SIZE) return;
    memcpy(state + SIZE_PLACE, &size, sizeof size);
    uint64_t const hash = hash_block(state + SIZE_PLACE, (size_t)size - SIZE_PLACE);
    memcpy(state + HASH_PLACE, &hash, sizeof hash);
}

static void make_base(void) {
    if (base_world) return;
    tulle_error error = {0};
    base_world = make_world();
    tulle_obstacle_id const body = {0, 1};
    tulle_body_drive drive = tulle_body_drive_default();
    drive.stiffness[0] = drive.angular_damping[1] = 1.0;
    drive.force_limit[0] = 0.1;
    FUZZ_CHECK_OK(tulle_world_start(base_world, &error), &error);
    FUZZ_CHECK_OK(tulle_obstacle_set_drive(base_world, body, &drive, &error), &error);
    FUZZ_CHECK_OK(tulle_obstacle_set_locks(base_world, body, TULLE_LOCK_Y, 0, &error), &error);
    for (int i = 0; i < STEP_COUNT; i++)
        FUZZ_CHECK_OK(tulle_world_step(base_world, time_step, NULL, &error), &error);
    base_hash = tulle_world_get_state_hash(base_world);
    FUZZ_CHECK_OK(tulle_world_save_state(base_world, &base_bytes, &base_size, &error), &error);
    /* The places above are those of the format: what is right stays as it is. */
    FUZZ_CHECK(base_size > HEAD_SIZE);
    uint8_t *const copy = malloc(base_size);
    FUZZ_CHECK(copy);
    memcpy(copy, base_bytes, base_size);
    make_hash_right(copy, base_size);
    FUZZ_CHECK(memcmp(copy, base_bytes, base_size) == 0);
    free(copy);
}

static void change_bytes(uint8_t *state, fuzz_bytes *input) {
    while (input->used < input->size) {
        size_t const high = fuzz_take(input), offset = (256 * high + fuzz_take(input)) % base_size;
        fuzz_bytes const change = fuzz_take_part(input, 1 + fuzz_take_below(input, CHANGE_MAX));
        for (size_t i = 0; i < change.size && offset + i < base_size; i++)
            state[offset + i] = change.data[i];
    }
}

static void look_at(tulle_world *world) {
    const tulle_contact *contacts;
    size_t count;
    tulle_error error = {0};
    tulle_status const status = tulle_world_get_contacts(world, &contacts, &count, &error);
    if (status) fuzz_check_error(status, &error);
    (void)tulle_world_find_largest_stretch(world);
    tulle_transform transform;
    FUZZ_CHECK_OK(
        tulle_obstacle_get_transform(world, (tulle_obstacle_id){0, 1}, &transform, &error), &error);
    uint32_t labels[64];
    tulle_patch_options const options = {0};
    (void)tulle_cloth_get_patches(world, (tulle_cloth_id){0, 1}, &options, labels, &count, &error);
}

/* The state that was just loaded survives being saved and loaded. */
static void check_saved_again(tulle_world *world) {
    void *bytes = NULL;
    size_t size;
    tulle_error error = {0};
    uint64_t const hash = tulle_world_get_state_hash(world);
    FUZZ_CHECK_OK(tulle_world_save_state(world, &bytes, &size, &error), &error);
    FUZZ_CHECK_OK(tulle_world_load_state(world, bytes, size, &error), &error);
    FUZZ_CHECK(tulle_world_get_state_hash(world) == hash);
    tulle_world_free_state(world, bytes, size);
}

static int stop_after_a_while(void *context) { return ++*(int *)context > QUESTIONS_MAX; }

/* Loads the state, uses it, and comes back. */
static void load(tulle_world *world, const uint8_t *state, size_t size) {
    uint64_t const before = tulle_world_get_state_hash(world);
    tulle_error error = {0};
    tulle_status status = tulle_world_load_state(world, state, size, &error);
    if (status) {
        fuzz_check_error(status, &error);
        FUZZ_CHECK(tulle_world_get_state_hash(world) == before);
    } else {
        check_saved_again(world);
        look_at(world);
        uint64_t const loaded = tulle_world_get_state_hash(world);
        /* A body whose saved velocity is huge takes up to 4096 substeps. */
        int questions = 0;
        tulle_world_set_stop_request(world, stop_after_a_while, &questions);
        status = tulle_world_step(world, time_step, NULL, &error);
        tulle_world_set_stop_request(world, NULL, NULL);
        if (status) fuzz_check_error(status, &error);
        FUZZ_CHECK(!status || tulle_world_get_state_hash(world) == loaded);
    }
    FUZZ_CHECK_OK(tulle_world_load_state(world, base_bytes, base_size, &error), &error);
    FUZZ_CHECK(tulle_world_get_state_hash(world) == base_hash);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    make_base();
    fuzz_bytes input = {data, size, 0};
    unsigned const flags = fuzz_take(&input);
    size_t const state_size = flags & FLAG_CHANGES ? base_size : input.size - input.used;
    uint8_t *const state = malloc(state_size + 1);
    FUZZ_CHECK(state);
    if (flags & FLAG_CHANGES) {
        memcpy(state, base_bytes, base_size);
        change_bytes(state, &input);
    } else {
        memcpy(state, input.data + input.used, state_size);
    }
    if (flags & FLAG_RIGHT_HASH) make_hash_right(state, state_size);
    if (flags & FLAG_FRESH_WORLD) {
        tulle_world *const world = make_world();
        load(world, state, state_size);
        tulle_world_destroy(world);
    } else {
        load(base_world, state, state_size);
    }
    free(state);
    return 0;
}

void fuzz_make_seeds(void) {
    make_base();
    uint8_t *const seed = malloc(1 + base_size);
    FUZZ_CHECK(seed);
    memcpy(seed + 1, base_bytes, base_size);
    for (uint8_t flags = 0; flags < 8; flags++) {
        char name[32];
        seed[0] = flags;
        snprintf(name, sizeof name, "flags_%d", flags);
        /* Changes: some bytes of the state, taken as offsets and lengths. */
        fuzz_put_seed(name, seed, flags & FLAG_CHANGES ? 200 : 1 + base_size);
    }
    free(seed);
}
