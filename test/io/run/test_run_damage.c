/* Damage to any file of a run: it is named with its frame, or made good to the same bytes; never
 * passed on. A table of all files; each is removed, cut short, has bits flipped and blocks zeroed.
 */
#define _DEFAULT_SOURCE /* mkdtemp */
#include "io/run/run_record.h"
#include "io/run_support.h"

#include <stdbool.h>

enum {
    WHOLE_FRAMES = 5,
    ZEROED = 16, /* [bytes] of a zeroed block */
    FILE_LIMIT = 64
};

/* What resuming does about damage in its first half. */
typedef enum remedy {
    REFUSED,   /* names the file; nothing changes */
    MADE_AGAIN /* from the scene, or from the checkpoint before */
} remedy;

static const struct {
    const char *name;
    bool has_frames; /* pieces belong to frames, which messages name */
    remedy remedy;
} table[] = {
    {"run.json", false, REFUSED},
    {"scene.yaml", false, MADE_AGAIN},
    {"frames.csv", true, REFUSED},
    {"report.csv", true, REFUSED},
    {"bodies.csv", true, REFUSED},
    {"checksums.csv", false, REFUSED},
    {"checkpoint.bin", false, MADE_AGAIN},
    {"checkpoint.previous.bin", false, MADE_AGAIN},
    {"debug.bin", true, REFUSED},
    {"sheet.obj", false, MADE_AGAIN},
    {"sheet.pc2", true, REFUSED},
    {"odd_name_...obj", false, MADE_AGAIN},
    {"odd_name_...pc2", true, REFUSED},
    {"Sheet-2.obj", false, MADE_AGAIN},
    {"Sheet-2.pc2", true, REFUSED},
    {"ground.obj", false, MADE_AGAIN},
    {"sheet.pvd", false, MADE_AGAIN},
    {"ground.pvd", false, MADE_AGAIN},
    {"vtp/ground.vtp", false, MADE_AGAIN},
    {"vtp/sheet.000000.vtp", true, REFUSED},
    {"vtp/odd_name_...000002.vtp", true, REFUSED},
    {"vtp/Sheet-2.000005.vtp", true, MADE_AGAIN}, /* only the newest checkpoint counts it */
};
enum { TABLE_COUNT = sizeof table / sizeof table[0] };

static tulle_run_def make_damage_def(const char *directory) {
    tulle_run_def def = make_def(directory, WHOLE_FRAMES);
    def.writes_vtp = 1;
    return def;
}

static tulle_status resume(const char *directory, char *notes, size_t notes_size,
                           tulle_error *error) {
    tulle_run_def const def = make_damage_def(directory);
    tulle_run_writer *writer = NULL;
    tulle_run_checkpoint checkpoint;
    *error = (tulle_error){0};
    tulle_status status = tulle_run_resume(&def, &writer, &checkpoint, error);
    snprintf(notes, notes_size, "%s", tulle_run_get_notes(writer));
    if (!status) status = go_on(writer, &checkpoint, WHOLE_FRAMES, error);
    if (!status) return tulle_run_close(writer, TULLE_RUN_FINISHED, "all is well", error);
    if (writer) tulle_run_close(writer, TULLE_RUN_FAILED, NULL, NULL);
    return status;
}

/* ---- the whole run, kept in memory ---- */

static struct {
    char name[64];
    char *bytes;
    size_t size;
} whole[FILE_LIMIT];
static size_t whole_count;

static char *make_path(const char *directory, const char *name, char path[1024]) {
    snprintf(path, 1024, "%.400s/%.400s", directory, name);
    return path;
}

static void keep_folder(const char *directory, const char *prefix) {
    char path[1024];
    DIR *const folder = opendir(make_path(directory, prefix, path));
    assert_non_null(folder);
    for (struct dirent *entry = readdir(folder); entry; entry = readdir(folder)) {
        if (entry->d_name[0] == '.' || strcmp(entry->d_name, "vtp") == 0) continue;
        assert_true(whole_count < FILE_LIMIT);
        snprintf(whole[whole_count].name, sizeof whole[0].name, "%s%.40s", prefix, entry->d_name);
        whole[whole_count].bytes =
            get_file(make_path(directory, whole[whole_count].name, path), &whole[whole_count].size);
        whole_count++;
    }
    closedir(folder);
}

static size_t find_file(const char *name) {
    for (size_t i = 0; i < whole_count; i++)
        if (strcmp(whole[i].name, name) == 0) return i;
    fail_msg("there is no %s", name);
    return 0;
}

static void put_whole_back(const char *directory) {
    char path[1024];
    for (size_t i = 0; i < whole_count; i++)
        put_file(make_path(directory, whole[i].name, path), whole[i].bytes, whole[i].size);
}

/* Whether all files are as they were, but for `spared` (null: none). */
static const char *find_difference(const char *directory, const char *spared) {
    char path[1024];
    for (size_t i = 0; i < whole_count; i++) {
        if (spared && strcmp(whole[i].name, spared) == 0) continue;
        if (access(make_path(directory, whole[i].name, path), F_OK) != 0) return whole[i].name;
        size_t size;
        char *const bytes = get_file(path, &size);
        bool const is_same = size == whole[i].size && memcmp(bytes, whole[i].bytes, size) == 0;
        free(bytes);
        if (!is_same) return whole[i].name;
    }
    return NULL;
}

/* ---- damage ---- */

typedef enum damage_kind { REMOVED, CUT, FLIPPED, CLEARED, DAMAGE_KINDS } damage_kind;
static const char *const kind_names[] = {"removed", "cut", "bit flipped", "zeroed"};

/* False where the file would not change. */
static bool damage_file(const char *directory, size_t file, damage_kind kind, size_t place) {
    char path[1024];
    make_path(directory, whole[file].name, path);
    size_t const size = whole[file].size;
    char *const bytes = malloc(size + 1);
    memcpy(bytes, whole[file].bytes, size);
    if (kind == FLIPPED) bytes[place] ^= (char)(1 << (place * 5 + place / 8) % 8);
    if (kind == CLEARED) memset(bytes + place, 0, size - place < ZEROED ? size - place : ZEROED);
    bool const is_changed = kind < FLIPPED || memcmp(bytes, whole[file].bytes, size) != 0;
    if (kind == REMOVED)
        assert_int_equal(remove(path), 0);
    else
        put_file(path, bytes, kind == CUT ? place : size);
    free(bytes);
    return is_changed;
}

static bool names_file(const tulle_error *error, const char *name) {
    return strstr(error->file, name) || strstr(error->message, name);
}

/* Reads all of the run; true if it names the file, and the frame where it has frames. */
static bool reader_names(const char *directory, const char *name, bool has_frames) {
    tulle_run_reader *reader = NULL;
    tulle_error error = {0};
    if (tulle_run_reader_open(directory, &reader, &error)) {
        assert_null(reader);
        if (!names_file(&error, name)) fail_msg("%s: %s: %s", name, error.file, error.message);
        return true;
    }
    const tulle_run_damage *damages = NULL;
    size_t count = 0;
    assert_int_equal(tulle_run_reader_find_damage(reader, &damages, &count, &error), TULLE_OK);
    bool is_named = false;
    for (size_t i = 0; i < count; i++) {
        assert_string_equal(damages[i].file, name);
        is_named = true;
        assert_true(damages[i].message[0] != '\0');
        if (damages[i].frame >= 0) {
            assert_true(has_frames && damages[i].frame <= WHOLE_FRAMES);
            char frame[32];
            snprintf(frame, sizeof frame, "frame %d", (int)damages[i].frame);
            if (!strstr(damages[i].message, frame) && !strstr(damages[i].message, "opened"))
                fail_msg("%s: no \"%s\" in: %s", name, frame, damages[i].message);
        }
    }
    tulle_run_reader_close(reader);
    return is_named;
}

/* What is read of a damaged run is what was written, or an error; but for the scene, which users
 * may edit. */
static void assert_never_passed_on(const char *directory) {
    tulle_run_reader *reader = NULL;
    if (tulle_run_reader_open(directory, &reader, NULL)) return;
    const tulle_run_info *const info = tulle_run_reader_get_info(reader);
    assert_int_equal(info->frame_count, WHOLE_FRAMES + 1);
    uint64_t state = 42;
    for (uint32_t frame = 0; frame < info->frame_count; frame++) {
        uint64_t hash = 0;
        assert_int_equal(tulle_run_reader_get_frame(reader, frame, NULL, NULL, &hash), TULLE_OK);
        assert_true(hash == hash_mix(state));
        for (int body = 0; body < BODY_COUNT; body++) {
            double expected[3 * CLOTH_VERTICES], read[3 * CLOTH_VERTICES];
            tulle_error error = {0};
            size_t const count = 3 * bodies[body].mesh.vertex_count;
            find_positions(state, body, expected);
            if (tulle_run_reader_read_positions(reader, frame, (size_t)body, read, &error)) {
                assert_true(error.file[0] && error.message[0]);
                continue;
            }
            if (bodies[body].is_static)
                assert_memory_equal(read, box_positions, sizeof box_positions);
            else
                assert_floats(read, expected, count);
        }
        const tulle_run_debug *debug = NULL;
        if (tulle_run_reader_read_debug(reader, frame, &debug, NULL) == TULLE_OK)
            assert_debug(debug, state, frame * STEPS_PER_FRAME);
        for (int i = 0; i < STEPS_PER_FRAME; i++) state = hash_mix(state + 1);
    }
    const tulle_step_report *reports = NULL;
    size_t count = 0;
    if (tulle_run_reader_get_reports(reader, &reports, &count, NULL) == TULLE_OK) {
        assert_int_equal(count, WHOLE_FRAMES * STEPS_PER_FRAME);
        for (size_t i = 0; i < count; i++) assert_int_equal(reports[i].step, i);
    }
    tulle_run_reader_close(reader);
}

/* Damages the file so and looks what becomes of it. */
static void try_damage(const char *directory, size_t row, damage_kind kind, size_t place) {
    const char *const name = table[row].name;
    size_t const file = find_file(name);
    if (!damage_file(directory, file, kind, place)) return;
    char notes[4096], what[160];
    snprintf(what, sizeof what, "%s %s at byte %zu", name, kind_names[kind], place);
    /* Without the checkpoint before nothing of the run is lost. */
    bool const is_spare = kind == REMOVED && strcmp(name, "checkpoint.previous.bin") == 0;
    if (!reader_names(directory, name, table[row].has_frames) && !is_spare)
        fail_msg("%s: the reader does not name it", what);
    assert_never_passed_on(directory);
    tulle_error error;
    tulle_status const status = resume(directory, notes, sizeof notes, &error);
    if (status) {
        if (table[row].remedy == MADE_AGAIN)
            fail_msg("%s: not made again: %s: %s", what, error.file, error.message);
        if (!names_file(&error, name)) fail_msg("%s: %s: %s", what, error.file, error.message);
        const char *const changed = find_difference(directory, name);
        if (changed) fail_msg("%s: refused, but %s was changed", what, changed);
    } else {
        /* The generation before depends on where the run goes on. */
        const char *const differing = find_difference(directory, "checkpoint.previous.bin");
        if (differing) fail_msg("%s: resumed, but %s differs", what, differing);
        /* What is written when a run is closed is written again without a word. */
        bool const is_closing = strstr(name, ".pvd") || strcmp(name, "checksums.csv") == 0;
        bool const is_told = strstr(notes, name) || is_spare || is_closing;
        if (!is_told) fail_msg("%s: made good without a word: \"%s\"", what, notes);
        if (reader_names(directory, name, table[row].has_frames))
            fail_msg("%s: resumed, but damaged", what);
    }
    put_whole_back(directory);
}

static void every_damage_is_named_or_made_good(void **state) {
    (void)state;
    const char *const directory = test_path("run");
    bool const is_long = getenv("TULLE_TEST_LONG") != NULL;
    size_t count = 0;
    for (size_t row = 0; row < TABLE_COUNT; row++) {
        size_t const size = whole[find_file(table[row].name)].size;
        size_t const step = is_long ? 1 : 1 + size / 9;
        try_damage(directory, row, REMOVED, 0);
        for (int kind = CUT; kind < DAMAGE_KINDS; kind++)
            for (size_t place = 0; place < size; place += step, count++)
                try_damage(directory, row, (damage_kind)kind, place);
        /* the first and last bytes, where formats have their marks and numbers of four bytes */
        for (size_t i = 0; i < 40 && i < size; i += is_long ? 1 : 4, count += 2) {
            try_damage(directory, row, FLIPPED, i);
            try_damage(directory, row, FLIPPED, size - 1 - i);
        }
    }
    print_message("%zu damages\n", count);
    put_whole_back(directory);
    assert_null(find_difference(directory, NULL));
}

/* What may not be made good is refused although other files could be; damage behind the checkpoint
 * does not matter. */
static void damage_behind_the_checkpoint_is_cut_off(void **state) {
    (void)state;
    const char *const directory = test_path("killed");
    tulle_run_def const def = make_damage_def(directory);
    tulle_run_writer *writer = NULL;
    tulle_run_checkpoint none = {0};
    char notes[4096];
    tulle_error error = {0};
    assert_int_equal(tulle_run_create(&def, TULLE_RUN_REFUSE, &writer, &error), TULLE_OK);
    assert_int_equal(go_on(writer, &none, 2, &error), TULLE_OK);
    uint64_t later = 42;
    for (int i = 0; i < 3 * STEPS_PER_FRAME; i++) later = hash_mix(later + 1);
    assert_int_equal(write_frame(writer, later, 3 * STEPS_PER_FRAME, &error), TULLE_OK);
    /* A child that is killed holds no lock: here the writer is let go of as it is. */
    tulle_run_close(writer, TULLE_RUN_RUNNING, NULL, NULL);
    char path[1024];
    size_t size;
    char *const bytes = get_file(make_path(directory, "sheet.pc2", path), &size);
    bytes[size - 5] ^= 4;
    put_file(path, bytes, size);
    free(bytes);
    assert_true(reader_names(directory, "sheet.pc2", true));
    assert_int_equal(resume(directory, notes, sizeof notes, &error), TULLE_OK);
    assert_string_equal(notes, "");
    assert_false(reader_names(directory, "sheet.pc2", true));
    for (const char *const *name =
             (const char *const[]){"sheet.pc2", "frames.csv", "debug.bin", "report.csv", NULL};
         *name; name++)
        assert_same_file(directory, test_path("run"), *name);
}

static void a_run_without_both_checkpoints_is_not_begun_anew(void **state) {
    (void)state;
    const char *const directory = test_path("run");
    char path[1024], notes[4096];
    tulle_error error;
    remove(make_path(directory, "checkpoint.bin", path));
    remove(make_path(directory, "checkpoint.previous.bin", path));
    assert_int_equal(resume(directory, notes, sizeof notes, &error), TULLE_ERROR_PARSE);
    assert_non_null(strstr(error.file, "checkpoint.bin"));
    assert_true(reader_names(directory, "checkpoint.bin", false));
    put_whole_back(directory);
}

/* A replacement that fails on its way has taken the end off run.json, and has removed the
 * checkpoints first, then the lines of frames: nothing is promised of the rest. */
static void what_a_replacement_leaves_is_no_damage(void **state) {
    (void)state;
    static const char *const removed[] = {"checkpoint.previous.bin", "checkpoint.bin", "frames.csv",
                                          "sheet.obj"};
    const char *const directory = test_path("replaced");
    tulle_run_def const def = make_damage_def(directory);
    tulle_run_writer *writer = NULL;
    tulle_run_checkpoint none = {0};
    tulle_error error = {0};
    assert_int_equal(tulle_run_create(&def, TULLE_RUN_REFUSE, &writer, &error), TULLE_OK);
    assert_int_equal(go_on(writer, &none, 2, &error), TULLE_OK);
    tulle_run_close(writer, TULLE_RUN_RUNNING, NULL, NULL);
    char record_path[1024];
    memory heap = memory_default();
    run_record record = run_record_make(&heap);
    make_path(directory, "run.json", record_path);
    assert_int_equal(run_record_read(&record, record_path, &error), TULLE_OK);
    record.has_end = false;
    assert_int_equal(run_record_write(&record, record_path, &error), TULLE_OK);
    run_record_destroy(&record);
    for (size_t i = 0; i < sizeof removed / sizeof removed[0]; i++) {
        char path[1024];
        assert_int_equal(remove(make_path(directory, removed[i], path)), 0);
        tulle_run_reader *reader = NULL;
        const tulle_run_damage *damages;
        size_t count;
        assert_int_equal(tulle_run_reader_open(directory, &reader, &error), TULLE_OK);
        assert_int_equal(tulle_run_reader_find_damage(reader, &damages, &count, &error), TULLE_OK);
        if (count > 0) fail_msg("without %s %s is damaged", removed[i], damages[0].file);
        tulle_run_reader_close(reader);
    }
}

/* It is whole by itself, but not the one that the end of the run tells of. */
static void another_checkpoint_in_the_place_of_the_newest_is_damage(void **state) {
    (void)state;
    const char *const directory = test_path("run");
    char path[1024];
    size_t size;
    assert_false(reader_names(directory, "checkpoint.bin", false));
    char *const bytes = get_file(make_path(directory, "checkpoint.previous.bin", path), &size);
    put_file(make_path(directory, "checkpoint.bin", path), bytes, size);
    free(bytes);
    assert_true(reader_names(directory, "checkpoint.bin", false));
    put_whole_back(directory);
}

static int make_whole_run(void **state) {
    if (make_test_folder(state)) return -1;
    make_bodies();
    const char *const directory = test_path("run");
    tulle_run_def const def = make_damage_def(directory);
    tulle_run_writer *writer = NULL;
    tulle_run_checkpoint none = {0};
    tulle_error error = {0};
    if (tulle_run_create(&def, TULLE_RUN_REFUSE, &writer, &error) ||
        go_on(writer, &none, WHOLE_FRAMES, &error) ||
        tulle_run_close(writer, TULLE_RUN_FINISHED, "all is well", &error))
        return -1;
    keep_folder(directory, "");
    keep_folder(directory, "vtp/");
    return 0;
}

static int forget_whole_run(void **state) {
    for (size_t i = 0; i < whole_count; i++) free(whole[i].bytes);
    return remove_test_folder(state);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_damage_is_named_or_made_good),
        cmocka_unit_test(damage_behind_the_checkpoint_is_cut_off),
        cmocka_unit_test(a_run_without_both_checkpoints_is_not_begun_anew),
        cmocka_unit_test(what_a_replacement_leaves_is_no_damage),
        cmocka_unit_test(another_checkpoint_in_the_place_of_the_newest_is_damage),
    };
    return cmocka_run_group_tests(tests, make_whole_run, forget_whole_run);
}
