/* Steady steps make no heap call, neither through the world's allocator nor past it, on one thread
 * and on two.
 *
 * Buffers grow to what a scene needs, each by half at least, and stay (base.base tests the growth).
 * So, on the scenes of bench/bench.py in small sizes, from their start to where contact is in full
 * swing:
 * - a step that makes calls grows buffers: it ends with more memory held than any step before it;
 * - what the process allocates in a step is what the world's allocator was asked for;
 * - steps that need no more than steps before them make no call: those from the last state on are
 *   made twice, and the second time nothing may be allocated or released. */
#include "scene/scene.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum {
    REPEATED_STEPS = 9, /* odd: buffers that are swapped in each step change their parts */
    STARTING_STEPS = 1  /* make the helper threads, which are not the world's */
};

/* ---- calls of the process ---- */

/* The heap's functions of this program come before those of the C library, so calls of the library
 * itself and of all threads are counted too. Sanitizers have a heap of their own. */
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
enum { COUNTS_PROCESS = 1 };

extern void *__libc_malloc(size_t byte_count);
extern void *__libc_calloc(size_t count, size_t size);
extern void *__libc_realloc(void *block, size_t byte_count);
extern void *__libc_memalign(size_t alignment, size_t byte_count);
extern void __libc_free(void *block);

static atomic_uint_fast64_t process_calls;

void *malloc(size_t byte_count) {
    atomic_fetch_add(&process_calls, 1);
    return __libc_malloc(byte_count);
}
void *calloc(size_t count, size_t size) {
    atomic_fetch_add(&process_calls, 1);
    return __libc_calloc(count, size);
}
void *realloc(void *block, size_t byte_count) {
    atomic_fetch_add(&process_calls, 1);
    return __libc_realloc(block, byte_count);
}
void *aligned_alloc(size_t alignment, size_t byte_count) {
    atomic_fetch_add(&process_calls, 1);
    return __libc_memalign(alignment, byte_count);
}
void free(void *block) {
    atomic_fetch_add(&process_calls, block != NULL);
    __libc_free(block);
}
static uint64_t count_process_calls(void) { return atomic_load(&process_calls); }
#else
enum { COUNTS_PROCESS = 0 };
static uint64_t count_process_calls(void) { return 0; }
#endif

static void calls_within_the_c_library_are_counted(void **state) {
    (void)state;
    if (!COUNTS_PROCESS) skip();
    uint64_t const before = count_process_calls();
    FILE *const file = fopen("/dev/null", "r"); /* allocates, as fclose releases */
    assert_non_null(file);
    fclose(file);
    assert_true(count_process_calls() >= before + 2);
}

/* ---- calls of the world ---- */

typedef struct counted_heap {
    uint64_t calls;
    size_t held; /* [bytes] */
} counted_heap;

static void *heap_allocate(void *context, size_t byte_count) {
    counted_heap *const heap = context;
    heap->calls++;
    heap->held += byte_count;
    return malloc(byte_count);
}

static void heap_release(void *context, void *block, size_t byte_count) {
    counted_heap *const heap = context;
    heap->calls += block != NULL;
    heap->held -= block ? byte_count : 0;
    free(block);
}

/* ---- a scene ---- */

enum { OVERRIDE_MAX = 3 /* of a tulle_scene */ };

/* A scene in a small size. */
typedef struct small_scene {
    const char *name;
    const char *file;   /* below scenes/, without .yaml */
    uint32_t far_steps; /* from the start to where contact is in full swing */
    const char *overrides[OVERRIDE_MAX];
} small_scene;

#define RESOLUTION(text)                                                                           \
    { "cloth[0].mesh.resolution=" text }
static const small_scene small_scenes[] = {
    {"needles", "needles", 45, RESOLUTION("[20, 20]")},
    {"sphere", "sphere", 72, RESOLUTION("[20, 20]")},
    {"spikes", "spikes", 54, RESOLUTION("[20, 20]")},
    {"ribbon", "ribbon", 135, RESOLUTION("[201, 2]")},
    {"net",
     "net",
     45,
     {"cloth[0].mesh.cells=[4, 4]", "cloth[0].mesh.size=[0.4107, 0.4107]",
      "cloth[0].mesh.strand_resolution=1"}},
    {"boxes", "boxes", 45, RESOLUTION("[20, 20]")},
    {"hammock", "hammock", 72, RESOLUTION("[27, 15]")},
    {"example_one", "paper/example_one", 72, RESOLUTION("[25, 16]")},
    {"landing", "sphere", 12, RESOLUTION("[20, 20]")},
};
enum { SMALL_SCENE_COUNT = sizeof small_scenes / sizeof small_scenes[0] };

typedef struct heap_run {
    const small_scene *scene;
    int threads;
    const char *override; /* beside those of the size; or null */
    counted_heap heap;
    tulle_world *world;
    double time_step; /* [s] */
    uint32_t pinched_steps;
    uint64_t ignored_pairs; /* at the end */
} heap_run;

static void fail_run(const heap_run *run, const char *text) {
    fail_msg("%s %s, %d threads: %s", run->scene->name, run->override ? run->override : "",
             run->threads, text);
}

static tulle_scene *load_scene(const heap_run *run) {
    char path[1024];
    const char *overrides[OVERRIDE_MAX + 1];
    size_t count = 0;
    for (; count < OVERRIDE_MAX && run->scene->overrides[count]; count++)
        overrides[count] = run->scene->overrides[count];
    if (run->override) overrides[count++] = run->override;
    snprintf(path, sizeof path, "%s/scenes/%s.yaml", getenv("TULLE_SOURCE_DIR"), run->scene->file);
    static tulle_scene_problems problems;
    tulle_scene *loaded = NULL;
    if (tulle_scene_load(path, overrides, count, &loaded, &problems) != TULLE_OK)
        fail_run(run, problems.list[0].message);
    return loaded;
}

/* Returns the calls of the world's allocator. */
static uint64_t make_step(heap_run *run) {
    tulle_error error = {0};
    tulle_step_report report = {0};
    uint64_t const before = run->heap.calls, process_before = count_process_calls();
    tulle_status const status = tulle_world_step(run->world, run->time_step, &report, &error);
    uint64_t const process = count_process_calls() - process_before;
    uint64_t const calls = run->heap.calls - before;
    if (status != TULLE_OK) fail_run(run, error.message);
    if (COUNTS_PROCESS && tulle_world_get_step_count(run->world) > STARTING_STEPS &&
        process != calls)
        fail_run(run, "heap calls past the world's allocator");
    run->pinched_steps += report.pinched != 0;
    run->ignored_pairs = report.ignored_pairs;
    return calls;
}

/* Returns in how many steps buffers grew. */
static uint32_t run_to_contact(heap_run *run) {
    uint32_t growing = 0;
    size_t most_held = 0;
    for (uint32_t i = 0; i < run->scene->far_steps; i++) {
        uint64_t const calls = make_step(run);
        growing += calls > 0;
        if (calls > 0 && run->heap.held <= most_held)
            fail_run(run, "a step makes heap calls though nothing grows");
        most_held = run->heap.held;
    }
    return growing;
}

/* Steps from the state on. Returns all calls of the world's allocator. */
static uint64_t repeat_steps(heap_run *run, const void *bytes, size_t byte_count, uint64_t *hash) {
    assert_int_equal(tulle_world_load_state(run->world, bytes, byte_count, NULL), TULLE_OK);
    uint64_t calls = 0;
    for (int i = 0; i < REPEATED_STEPS; i++) calls += make_step(run);
    *hash = tulle_world_get_state_hash(run->world);
    return calls;
}

static void check_run(heap_run *run) {
    tulle_scene *const loaded = load_scene(run);
    tulle_allocator const allocator = {heap_allocate, heap_release, &run->heap, 0};
    tulle_scene_world built = {0};
    assert_int_equal(tulle_scene_build_world(loaded, run->threads, &allocator, &built, NULL),
                     TULLE_OK);
    run->world = built.world;
    run->time_step = tulle_scene_get_time_step(loaded);
    uint32_t const growing = run_to_contact(run);
    assert_true(growing > 0 && growing < run->scene->far_steps);
    void *bytes = NULL;
    size_t byte_count = 0;
    assert_int_equal(tulle_world_save_state(run->world, &bytes, &byte_count, NULL), TULLE_OK);
    uint64_t first_hash, second_hash;
    uint64_t const first = repeat_steps(run, bytes, byte_count, &first_hash);
    uint64_t const second = repeat_steps(run, bytes, byte_count, &second_hash);
    print_message("%s %s, %d threads: buffers grew in %u of %u steps; then %u calls, then %u\n",
                  run->scene->name, run->override ? run->override : "", run->threads, growing,
                  run->scene->far_steps, (unsigned)first, (unsigned)second);
    assert_true(first_hash == second_hash);
    assert_int_equal(second, 0);
    tulle_world_free_state(run->world, bytes, byte_count);
    tulle_scene_destroy_world(&built);
    tulle_scene_destroy(loaded);
}

static void check_scene(const small_scene *which, int threads, const char *override) {
    heap_run run = {.scene = which, .threads = threads, .override = override};
    check_run(&run);
}

/* ---- tests ---- */

static void steady_steps_of_all_scenes_make_no_heap_call(void **state) {
    (void)state;
    for (size_t i = 0; i < SMALL_SCENE_COUNT; i++)
        for (int threads = TULLE_TIME_FACTOR > 1 ? 2 : 1; threads <= 2; threads++)
            check_scene(&small_scenes[i], threads, NULL);
}

/* Patches grow in the repeated steps of a net of this size; see update_patches. */
static void growth_of_patches_makes_no_heap_call(void **state) {
    (void)state;
    if (TULLE_TIME_FACTOR > 1) skip();
    static const small_scene net = {"net of 2k",
                                    "net",
                                    45,
                                    {"cloth[0].mesh.cells=[9, 9]",
                                     "cloth[0].mesh.size=[0.904, 0.904]",
                                     "cloth[0].mesh.strand_resolution=1"}};
    check_scene(&net, 2, NULL);
}

static void other_methods_make_no_heap_call(void **state) {
    (void)state;
    static const char *const overrides[] = {"contact.method=refit", "contact.method=bvox",
                                            "contact.method=paper", "contact.response=paper"};
    for (size_t i = 0; i < sizeof overrides / sizeof *overrides; i++)
        check_scene(&small_scenes[2], 2, overrides[i]); /* spikes */
}

/* Triangles that intersect at the start are judged in every step until they come apart. */
static void ignored_pairs_make_no_heap_call(void **state) {
    (void)state;
    static const small_scene caught = {"caught on spikes",
                                       "spikes",
                                       8,
                                       {"cloth[0].mesh.resolution=[20, 20]",
                                        "cloth[0].translate=[0, 0, 0.49]",
                                        "contact.start_intersections=ignore"}};
    heap_run run = {.scene = &caught, .threads = 2};
    check_run(&run);
    assert_true(run.ignored_pairs > 0);
}

/* Plates close on cloth to nothing and are held back. */
static void held_plates_make_no_heap_call(void **state) {
    (void)state;
    static const small_scene pinched = {"pinched", "pinch_zero", 100, {"contact.on_pinch=slow"}};
    heap_run run = {.scene = &pinched, .threads = 2};
    check_run(&run);
    assert_true(run.pinched_steps > 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(calls_within_the_c_library_are_counted),
        cmocka_unit_test(steady_steps_of_all_scenes_make_no_heap_call),
        cmocka_unit_test(growth_of_patches_makes_no_heap_call),
        cmocka_unit_test(other_methods_make_no_heap_call),
        cmocka_unit_test(ignored_pairs_make_no_heap_call),
        cmocka_unit_test(held_plates_make_no_heap_call),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
