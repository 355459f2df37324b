/* Memory that runs out and a system that fails anywhere in the public functions that are not of a
 * world or a scene: each place of the code that asks for memory, and each that calls the system, is
 * struck once (support/struck_calls.h); recordings and their replay are here, too. The call tells
 * of it; a file is whole then or not there; called again it gives what it gives when nothing is
 * struck. Worlds and scenes: scene.struck_calls. */
#define _XOPEN_SOURCE 700
#include "io/run_support.h"

#include "support/detect_scene.h"
#include "support/object_world.h"
#include "support/recording.h"
#include "support/small_world.h"
#include "support/struck_calls.h"
#include "tulle/check.h"
#include "tulle/shapes.h"
#include "tulle_io/cache.h"
#include "tulle_io/mesh_files.h"
#include "tulle_io/subdivision.h"

static tulle_mesh sheet;    /* open, regular */
static const char *path;    /* of a file that is read or written */
static uint64_t result;     /* hash of what a call gave */
static uint64_t whole_file; /* hash of the file that was written last */
static detect_scene scene;  /* two surfaces that meet */
static tulle_detect_method method;
static tulle_shape shape;

static void take(const void *bytes, size_t byte_count) {
    result = hash_bytes(result, bytes, byte_count);
}

static void take_mesh(const tulle_mesh *mesh) {
    take(mesh->positions, 3 * mesh->vertex_count * sizeof(double));
    take(mesh->triangles, 3 * mesh->triangle_count * sizeof(uint32_t));
}

/* Calls until nothing is struck any more. Whenever all goes well, it gives the same. */
static void survive(const char *name, struck_call call) {
    tulle_error error = {0};
    result = HASH_SEED;
    if (call(NULL, &error) != TULLE_OK) fail_msg("%s: %s", name, error.message);
    uint64_t const expected = result;
    for (int kind = 0; kind < STRIKE_COUNT; kind++) {
        for (bool is_struck = true; is_struck;) {
            result = HASH_SEED;
            tulle_status const status = call_struck(name, (strike)kind, call, NULL, &is_struck);
            if (status == TULLE_OK && result != expected)
                fail_msg("%s: gives something else after a strike", name);
        }
    }
}

/* ---- meshes ---- */

static tulle_status generate(void *unused, tulle_error *error) {
    (void)unused;
    tulle_shape_def def = tulle_shape_def_default(shape);
    if (tulle_shape_is_cloth(shape)) def.is_irregular = 1;
    tulle_mesh mesh = {0};
    tulle_status const status = tulle_shape_generate(&def, &mesh, error);
    take_mesh(&mesh);
    tulle_mesh_destroy(&mesh);
    return status;
}

static void shapes(void **state) {
    (void)state;
    for (int i = 0; i < TULLE_SHAPE_COUNT; i++) {
        shape = (tulle_shape)i;
        survive(tulle_shape_name(shape), generate);
    }
}

static tulle_status examine(void *unused, tulle_error *error) {
    (void)unused;
    tulle_mesh_info info = {0};
    tulle_status status = tulle_mesh_get_info(tulle_mesh_get_view(&sheet), &info, error);
    if (status == TULLE_OK)
        status = tulle_mesh_validate(tulle_mesh_get_view(&sheet), TULLE_MESH_ROLE_CLOTH, error);
    take(&info.area, sizeof info.area);
    return status;
}

static tulle_status drop(void *unused, tulle_error *error) {
    (void)unused;
    tulle_mesh mesh = {0};
    tulle_status status = tulle_mesh_create(4, 4, &mesh, error);
    if (status != TULLE_OK) return status;
    static const uint32_t corners[12] = {0, 1, 2, 0, 2, 3, 2, 1, 0, 1, 2, 0};
    memcpy(mesh.triangles, corners, sizeof corners);
    tulle_mesh_duplicates duplicates = {0};
    status = tulle_mesh_drop_duplicates(&mesh, NULL, &duplicates, error);
    assert_int_equal(mesh.triangle_count, status == TULLE_OK ? 2 : 4);
    assert_memory_equal(mesh.triangles, corners, 6 * sizeof(uint32_t));
    tulle_mesh_destroy(&mesh);
    return status;
}

static tulle_status subdivide(void *unused, tulle_error *error) {
    (void)unused;
    tulle_subdivision_def def = tulle_subdivision_def_default();
    uint32_t const crease[] = {sheet.triangles[0], sheet.triangles[1]};
    def.levels = 2;
    def.crease_edges = crease;
    def.crease_edge_count = 1;
    tulle_subdivision *made = NULL;
    tulle_status status = tulle_subdivision_create(tulle_mesh_get_view(&sheet), &def, &made, error);
    assert_int_equal(made != NULL, status == TULLE_OK);
    tulle_mesh mesh = {0};
    if (status == TULLE_OK)
        status = tulle_subdivision_make_mesh(made, sheet.positions, &mesh, error);
    take_mesh(&mesh);
    tulle_mesh_destroy(&mesh);
    tulle_subdivision_destroy(made);
    return status;
}

static void meshes(void **state) {
    (void)state;
    survive("info and validate", examine);
    survive("drop duplicates", drop);
    survive("subdivide", subdivide);
}

/* ---- the judge and the detector ---- */

static tulle_status judge(void *unused, tulle_error *error) {
    (void)unused;
    tulle_mesh_view moved = {scene.end, scene.vertex_count, scene.triangles, scene.triangle_count};
    tulle_check_body const judged[] = {{tulle_mesh_get_view(&sheet), 0}, {moved, 0}, {moved, 1}};
    tulle_check_result found;
    tulle_status const status = tulle_check_intersections(judged, 3, 1, &found, error);
    assert_int_equal(found.pair_count > 0, status == TULLE_OK);
    take(found.pairs, found.pair_count * sizeof *found.pairs);
    tulle_check_result_destroy(&found);
    return status;
}

static int receive(void *context, const tulle_detect_event *events, size_t count) {
    (void)context;
    take(events, count * sizeof *events);
    return 0;
}

static tulle_status detect(void *unused, tulle_error *error) {
    (void)unused;
    tulle_detect_def def = detect_scene_get_def(&scene);
    def.method = method;
    def.threads = 1;
    tulle_detector *detector = NULL;
    tulle_status status = tulle_detector_create(&def, &detector, error);
    assert_int_equal(detector != NULL, status == TULLE_OK);
    for (int call = 0; status == TULLE_OK && call < 2; call++) {
        tulle_detect_result found = {0};
        status = tulle_detector_find_events(detector, scene.start, scene.end, &found, error);
        assert_int_equal(found.event_count > 0, status == TULLE_OK);
        take(found.events, found.event_count * sizeof *found.events);
    }
    tulle_detect_result found = {0};
    if (status == TULLE_OK)
        status =
            tulle_detector_stream_events(detector, scene.start, scene.end,
                                         (tulle_detect_receiver){receive, NULL}, &found, error);
    if (status == TULLE_OK)
        status = tulle_detector_find_earliest(detector, scene.start, scene.end, &found, error);
    if (status == TULLE_OK) take(found.events, found.event_count * sizeof *found.events);
    tulle_detector_destroy(detector);
    return status;
}

static void judge_and_detector(void **state) {
    (void)state;
    static const tulle_detect_method methods[] = {TULLE_DETECT_PATCHES, TULLE_DETECT_REFIT,
                                                  TULLE_DETECT_BVOX, TULLE_DETECT_PAPER};
    survive("judge", judge);
    for (int i = 0; i < 4; i++) {
        method = methods[i];
        survive("detector", detect);
    }
}

/* ---- recordings ---- */

static recording recorded; /* of a call that was not struck */

static tulle_status give_sheet(void *unused, uint32_t frame, double *positions,
                               tulle_error *error) {
    (void)unused, (void)frame, (void)error;
    for (size_t i = 0; i < 3 * sheet.vertex_count; i++)
        positions[i] = sheet.positions[i] - (i % 3 == 2 ? 0.5 : 0.0);
    return TULLE_OK;
}

static int let_all_collide(void *unused, const tulle_world *world, tulle_object_id a,
                           tulle_object_id b) {
    (void)unused, (void)world, (void)a, (void)b;
    return 1;
}

static tulle_status fill_recorded(tulle_world *world, tulle_error *error) {
    double const frame_of_rest[] = {0.0, 0.0, -9.0};
    tulle_cloth_def cloth = tulle_cloth_def_default();
    tulle_obstacle_def obstacle = tulle_obstacle_def_default();
    cloth.mesh = obstacle.mesh = tulle_mesh_get_view(&sheet);
    obstacle.read_frame = give_sheet;
    obstacle.frame_count = 9;
    tulle_status status = tulle_world_add_cloth(world, &cloth, NULL, error);
    if (status == TULLE_OK) status = tulle_world_add_obstacle(world, &obstacle, NULL, error);
    if (status == TULLE_OK)
        status = tulle_world_set_pair_filter(world, let_all_collide, NULL, error);
    for (int i = 0; i < 3 && status == TULLE_OK; i++) {
        status = tulle_world_set_gravity(world, frame_of_rest, error);
        if (status == TULLE_OK) status = tulle_world_step(world, 0.05, NULL, error);
    }
    return status;
}

static tulle_status record(void *unused, tulle_error *error) {
    (void)unused;
    recording bytes;
    tulle_record_writer const writer = recording_begin(&bytes);
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    tulle_world *world = NULL;
    tulle_status status = tulle_world_create(&def, &world, error);
    if (status == TULLE_OK) status = tulle_world_record(world, &writer, error);
    if (status == TULLE_OK) status = fill_recorded(world, error);
    if (status == TULLE_OK) status = tulle_world_record(world, NULL, error);
    tulle_world_destroy(world);
    if (status == TULLE_OK) take(bytes.bytes, bytes.byte_count);
    if (status == TULLE_OK && !recorded.bytes)
        recorded = bytes;
    else
        free(bytes.bytes);
    return status;
}

static tulle_status replay(void *unused, tulle_error *error) {
    (void)unused;
    tulle_replay_report report;
    tulle_status const status =
        tulle_replay(recorded.bytes, recorded.byte_count, NULL, &report, error);
    if (status != TULLE_OK) return status;
    assert_true(report.is_whole && !report.is_different);
    take(&report.hash, sizeof report.hash);
    return status;
}

static void recordings(void **state) {
    (void)state;
    survive("record", record);
    survive("replay", replay);
    free(recorded.bytes);
}

/* ---- objects ---- */

/* A world of a sheet, a pinned one, a body and what is driven or deforms, with what can be carried
 * over: changed settings, an attachment, a watch. */
static tulle_status fill_changed(tulle_world *world, tulle_object_id ids[THING_COUNT],
                                 tulle_error *error) {
    tulle_status status = TULLE_OK;
    for (thing what = 0; what < THING_COUNT && status == TULLE_OK; what++)
        status = things_try(world, what, 0.0, &ids[what], error);
    if (status == TULLE_OK) status = tulle_world_start(world, error);
    tulle_cloth_id const cloth = {ids[THING_SHEET].index, ids[THING_SHEET].generation};
    tulle_event_watch watch = tulle_event_watch_default();
    watch.kinds = 1u << TULLE_EVENT_SLEEP; /* contacts ask for room for none */
    if (status == TULLE_OK) status = tulle_world_watch_events(world, &watch, error);
    tulle_material material = tulle_cloth_def_default().material;
    material.area_density *= 1.5;
    if (status == TULLE_OK) status = tulle_cloth_set_material(world, cloth, &material, error);
    double distance;
    tulle_world_get_distances(world, &distance, NULL, NULL);
    if (status == TULLE_OK) status = tulle_cloth_set_thickness(world, cloth, 0.5 * distance, error);
    tulle_attachment_def def = tulle_attachment_def_default();
    uint32_t const vertex = 3;
    double const point[3] = {0.0, 0.0, 0.1};
    tulle_attachment_id id;
    def.cloth = cloth;
    def.vertices = &vertex;
    def.vertex_count = 1;
    def.points = point;
    if (status == TULLE_OK) status = tulle_world_attach(world, &def, &id, error);
    for (int i = 0; i < 8 && status == TULLE_OK; i++)
        status = tulle_world_step(world, THING_STEP, NULL, error);
    return status;
}

/* Each thing goes and comes again; what fails leaves the world as it was. */
static tulle_status change_objects(void *unused, tulle_error *error) {
    (void)unused;
    tulle_object_id ids[THING_COUNT];
    tulle_world_def def = tulle_world_def_default();
    def.threads = 1;
    def.start_intersections = TULLE_START_IGNORE;
    tulle_world *world = NULL;
    tulle_status status = tulle_world_create(&def, &world, error);
    if (status == TULLE_OK) status = fill_changed(world, ids, error);
    for (thing what = 0; what < THING_COUNT && status == TULLE_OK; what++) {
        uint64_t before = tulle_world_get_state_hash(world);
        status = things_try_remove(world, ids[what], error);
        if (status == TULLE_OK) {
            before = tulle_world_get_state_hash(world);
            take(&before, sizeof before);
            status = things_try(world, what, 0.0, &ids[what], error);
        }
        if (status != TULLE_OK) assert_true(tulle_world_get_state_hash(world) == before);
    }
    if (status == TULLE_OK) status = tulle_world_step(world, THING_STEP, NULL, error);
    uint64_t const hash = tulle_world_get_state_hash(world);
    if (status == TULLE_OK) take(&hash, sizeof hash);
    tulle_world_destroy(world);
    return status;
}

static void objects(void **state) {
    (void)state;
    survive("change objects", change_objects);
}

/* ---- files ---- */

static tulle_status read_mesh(void *unused, tulle_error *error) {
    (void)unused;
    tulle_mesh mesh = {0};
    tulle_mesh_source source = {0};
    tulle_status const status = tulle_mesh_read_source(path, &mesh, &source, error);
    take_mesh(&mesh);
    tulle_mesh_destroy(&mesh);
    tulle_mesh_source_destroy(&source);
    return status;
}

static tulle_status read_vtp(void *unused, tulle_error *error) {
    (void)unused;
    tulle_mesh mesh = {0};
    tulle_status const status = tulle_vtp_read(path, &mesh, NULL, error);
    take_mesh(&mesh);
    tulle_mesh_destroy(&mesh);
    return status;
}

/* The file is there, whole, or not at all, and nothing beside it. */
static tulle_status end_writing(tulle_status status) {
    size_t const file_count = count_files(test_path("out"));
    assert_true(status == TULLE_OK ? file_count == 1 : file_count <= 1);
    if (file_count == 0) return status;
    size_t size;
    char *const bytes = get_file(path, &size);
    uint64_t const hash = hash_bytes(HASH_SEED, bytes, size);
    free(bytes);
    remove(path);
    if (status == TULLE_OK) whole_file = hash;
    assert_true(hash == whole_file);
    take(&hash, sizeof hash);
    return status;
}

static tulle_status write_mesh(void *unused, tulle_error *error) {
    (void)unused;
    return end_writing(tulle_mesh_write(path, tulle_mesh_get_view(&sheet), error));
}

static tulle_status write_vtp(void *unused, tulle_error *error) {
    (void)unused;
    return end_writing(tulle_vtp_write(path, tulle_mesh_get_view(&sheet), sheet.positions, error));
}

static tulle_status write_pvd(void *unused, tulle_error *error) {
    (void)unused;
    const char *const files[] = {"a.vtp", "b.vtp"};
    double const times[] = {0.0, 0.5};
    return end_writing(tulle_pvd_write(path, files, times, 2, error));
}

static tulle_status use_cache(void *unused, tulle_error *error) {
    (void)unused;
    tulle_pc2_writer *writer = NULL;
    tulle_status status =
        tulle_pc2_writer_open(path, (uint32_t)sheet.vertex_count, 0, &writer, error);
    for (int frame = 0; status == TULLE_OK && frame < 2; frame++)
        status = tulle_pc2_writer_append(writer, sheet.positions, error);
    tulle_status const closed = tulle_pc2_writer_close(writer, status ? NULL : error);
    if (status == TULLE_OK) status = closed;
    tulle_pc2 *cache = NULL;
    tulle_pc2_info info;
    if (status == TULLE_OK) status = tulle_pc2_open(path, &cache, &info, error);
    double *const positions = calloc(3 * sheet.vertex_count, sizeof(double));
    assert_non_null(positions);
    if (status == TULLE_OK) status = tulle_pc2_read_frame(cache, 1, positions, error);
    take(positions, 3 * sheet.vertex_count * sizeof(double));
    free(positions);
    tulle_pc2_close(cache);
    remove(path);
    return status;
}

static void files(void **state) {
    (void)state;
    static const char *const names[] = {"a.obj", "a.ply", "a.stl", "a.vtp"};
    assert_int_equal(mkdir(test_path("out"), 0777), 0);
    for (int i = 0; i < 4; i++) {
        char name[32];
        snprintf(name, sizeof name, "out/%s", names[i]);
        path = test_path(name);
        survive(name, i < 3 ? write_mesh : write_vtp);
        path = test_path(names[i]);
        assert_int_equal(i < 3 ? tulle_mesh_write(path, tulle_mesh_get_view(&sheet), NULL)
                               : tulle_vtp_write(path, tulle_mesh_get_view(&sheet), NULL, NULL),
                         TULLE_OK);
        survive(names[i], i < 3 ? read_mesh : read_vtp);
    }
    path = test_path("named.obj");
    put_text(path, "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\ng a b\nusemtl x y\nf 1/1 2 3\n"
                   "g c\nf 1 3 4\n");
    survive("named.obj", read_mesh);
    path = test_path("out/a.pvd");
    survive("out/a.pvd", write_pvd);
    path = test_path("a.pc2");
    survive("a.pc2", use_cache);
}

/* ---- runs ---- */

enum { WRITTEN_FRAMES = 3 };

static tulle_status write_run(void *unused, tulle_error *error) {
    (void)unused;
    return resume_run(path, WRITTEN_FRAMES, error);
}

static tulle_status read_run(void *unused, tulle_error *error) {
    (void)unused;
    tulle_run_reader *reader = NULL;
    tulle_status status = tulle_run_reader_open(path, &reader, error);
    const tulle_run_debug *debug = NULL;
    const tulle_step_report *reports = NULL;
    const tulle_run_damage *damages = NULL;
    size_t report_count = 0, damage_count = 0;
    double positions[3 * CLOTH_VERTICES] = {0};
    for (size_t body = 0; status == TULLE_OK && body < BODY_COUNT; body++) {
        tulle_mesh_view mesh;
        status = tulle_run_reader_get_mesh(reader, body, &mesh, error);
        for (uint32_t frame = 0; status == TULLE_OK && frame <= WRITTEN_FRAMES; frame++) {
            status = tulle_run_reader_read_positions(reader, frame, body, positions, error);
            take(positions, 3 * bodies[body].mesh.vertex_count * sizeof(double));
        }
    }
    for (uint32_t frame = 0; status == TULLE_OK && frame <= WRITTEN_FRAMES; frame++)
        status = tulle_run_reader_read_debug(reader, frame, &debug, error);
    if (status == TULLE_OK)
        status = tulle_run_reader_get_reports(reader, &reports, &report_count, error);
    if (status == TULLE_OK)
        status = tulle_run_reader_find_damage(reader, &damages, &damage_count, error);
    if (status == TULLE_OK) assert_int_equal(report_count, WRITTEN_FRAMES * STEPS_PER_FRAME);
    if (damage_count > 0) { /* what cannot be read is told as a damage */
        assert_int_equal(damage_count, 1);
        snprintf(error->message, sizeof error->message, "%s", damages[0].message);
        status = error->status = TULLE_ERROR_IO;
    }
    tulle_run_reader_close(reader);
    return status;
}

static void runs(void **state) {
    (void)state;
    path = test_path("run");
    for (int kind = 0; kind < STRIKE_COUNT; kind++)
        for (int begins_anew = 0; begins_anew < 2; begins_anew++) {
            remove_tree(path);
            run_whole(path, 1);
            for (bool is_struck = true; is_struck;) {
                if (begins_anew) remove_tree(path);
                call_struck(begins_anew ? "write a run" : "go on with a run", (strike)kind,
                            write_run, NULL, &is_struck);
                if (tulle_run_is_directory(path)) assert_sound(path);
            }
            assert_int_equal(assert_sound(path), WRITTEN_FRAMES + 1);
        }
    survive("read a run", read_run);
}

static int set_up(void **state) {
    tulle_shape_def def = tulle_shape_def_default(TULLE_SHAPE_RECTANGLE);
    def.resolution[0] = def.resolution[1] = 6;
    uint64_t seed = 4;
    detect_scene_add(&scene, DETECT_CURL, 5, &seed);
    detect_scene_add(&scene, DETECT_FAST, 6, &seed);
    make_bodies();
    return tulle_shape_generate(&def, &sheet, NULL) || make_test_folder(state);
}

static int tear_down(void **state) {
    tulle_mesh_destroy(&sheet);
    print_message("%zu places were struck\n", count_struck_places());
    return remove_test_folder(state);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shapes),
        cmocka_unit_test(meshes),
        cmocka_unit_test(judge_and_detector),
        cmocka_unit_test(objects),
        cmocka_unit_test(recordings),
        cmocka_unit_test(files),
        cmocka_unit_test(runs),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
