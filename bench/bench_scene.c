/* Times the same steps of a scene again and again, stage by stage. bench/bench.py runs it for each
 * case and makes tables of what it prints; lab/benchmarks.md tells what is measured.
 *
 * The scene is simulated to a state in the middle of it. A repeat loads that state, makes one step
 * that is not timed, and times the steps after it. All repeats must end in the same state and count
 * the same, on any number of threads: else they did different work, and an error says so.
 *
 * Prints lines "threads,kind,name,value"; a time has a value for each repeat. */
#define _DEFAULT_SOURCE /* access, sigaction */
#include "base/error.h"
#include "base/memory.h"
#include "base/timer.h"
#include "io/file_data.h"
#include "scene/scene.h"

#include "tulle_io/mesh_files.h"

#include <errno.h>
#include <inttypes.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum {
    THREADS_MAX = 256,
    THREAD_NUMBERS_MAX = 8, /* numbers of threads in one call */
    OVERRIDES_MAX = 256,
    REPEATS_MIN = 3, /* however long they take, unless fewer are asked for */
    STEPS_MAX = 10000,
    STEP_TIME = TULLE_STAGE_COUNT,
    PROCESSOR_TIME,
    TIME_COUNT, /* the stages, the step, its processor time */
    EXIT_BAD_INPUT = 2,
    EXIT_CANNOT_GO_ON = 3,
    EXIT_INTERRUPTED = 130
};
static const double LINE_INTERVAL = 10.0; /* [s] between lines of progress */

static const char usage[] =
    "usage: bench_scene SCENE.yaml [options]\n"
    "  --skip N          steps from the start to those that are timed (default: 30)\n"
    "  --steps N         steps that are timed (default: 8)\n"
    "  --threads N,...   numbers of threads (default: 1,2)\n"
    "  --repeat N        how often these steps are made (default: 7)\n"
    "  --seconds N       no further repeat after N s, but three (default: 60)\n"
    "  --set PATH=VALUE  change a key of the scene; may be repeated\n"
    "  --state FILE      keep the state after the skipped steps in FILE, or begin from it\n";

typedef struct bench {
    const char *scene_path, *state_path; /* the second may be null */
    const char *overrides[OVERRIDES_MAX];
    size_t override_count;
    long threads[THREAD_NUMBERS_MAX];
    size_t threads_count;
    long skip_count, step_count, repeat_count, most_seconds;
    tulle_scene *scene;
    double time_step; /* [s] */
    memory heap;
    file_data state;                      /* that each repeat begins from */
    tulle_step_report reports[STEPS_MAX]; /* of the timed steps */
} bench;

static volatile sig_atomic_t is_interrupted;
static void interrupt(int signal_number) { is_interrupted = signal_number; }
static int is_stopped(void *unused) { return unused || is_interrupted; }

/* ---- memory ---- */

/* An allocator that counts. */
typedef struct counted_heap {
    size_t held, most; /* [bytes] */
    uint64_t calls;
} counted_heap;

static void *heap_allocate(void *context, size_t byte_count) {
    counted_heap *const heap = context;
    void *const block = memory_allocate_default(byte_count);
    if (!block) return NULL;
    heap->calls++;
    heap->held += byte_count;
    if (heap->held > heap->most) heap->most = heap->held;
    return block;
}

static void heap_release(void *context, void *block, size_t byte_count) {
    counted_heap *const heap = context;
    if (block) heap->held -= byte_count;
    free(block);
}

/* Most that the process held in memory since the last call, in kB; 0 where the system does not
 * tell. From here on what is held now counts. */
static unsigned long take_most_resident(void) {
    FILE *const file = fopen("/proc/self/status", "r");
    char line[256];
    unsigned long kilobytes = 0;
    while (file && fgets(line, sizeof line, file))
        if (sscanf(line, "VmHWM: %lu kB", &kilobytes) == 1) break;
    if (file) fclose(file);
    FILE *const reset = fopen("/proc/self/clear_refs", "w");
    if (!reset) return 0;
    bool const is_reset = fputs("5", reset) >= 0;
    return fclose(reset) == 0 && is_reset ? kilobytes : 0;
}

/* ---- counts ---- */

#define COUNTS(X)                                                                                  \
    X(contacts), X(new_contacts), X(stick_contacts), X(slip_contacts), X(hard_contacts),           \
        X(box_pairs), X(tested_pairs), X(turning_pairs), X(pair_searches), X(solve_count),         \
        X(cg_iterations), X(impact_rounds), X(rescue_impact_zones), X(rescue_component_scalings),  \
        X(rescue_global_scalings), X(substeps), X(patches)
#define NAME(member) #member
static const char *const count_names[] = {COUNTS(NAME)};
enum { COUNT_COUNT = sizeof count_names / sizeof count_names[0] };

/* What all repeats of a case share, on any number of threads. */
typedef struct outcome {
    uint64_t start_hash, end_hash, counts[COUNT_COUNT]; /* counts: sums over the timed steps */
} outcome;

static void sum_counts(const bench *self, outcome *found) {
    for (long i = 0; i < self->step_count; i++) {
        const tulle_step_report *const report = &self->reports[i];
#define VALUE(member) report->member
        uint64_t const values[] = {COUNTS(VALUE)};
        for (size_t k = 0; k < COUNT_COUNT; k++) found->counts[k] += values[k];
    }
}

static tulle_status compare_outcomes(const outcome *known, const outcome *found,
                                     tulle_error *error) {
    for (size_t i = 0; i < COUNT_COUNT; i++)
        if (known->counts[i] != found->counts[i])
            return error_set(error, TULLE_ERROR_STEP_FAILED,
                             "the same steps from the same state count other %s: %" PRIu64
                             ", then %" PRIu64 "; this is an error of the library",
                             count_names[i], known->counts[i], found->counts[i]);
    if (known->start_hash == found->start_hash && known->end_hash == found->end_hash)
        return TULLE_OK;
    return error_set(error, TULLE_ERROR_STEP_FAILED,
                     "the same steps from the same state end in another one: %016" PRIx64
                     ", then %016" PRIx64 "; this is an error of the library",
                     known->end_hash, found->end_hash);
}

/* ---- the state that steps are timed from ---- */

static tulle_status simulate(const bench *self, tulle_world *world, tulle_error *error) {
    double const begin = timer_now();
    double shown = begin; /* [s] of the clock */
    tulle_world_set_stop_request(world, is_stopped, NULL);
    tulle_status status = tulle_world_start(world, error);
    for (long done = 1; done <= self->skip_count && status == TULLE_OK; done++) {
        status = tulle_world_step(world, self->time_step, NULL, error);
        double const now = timer_now();
        if (now - shown < LINE_INTERVAL && (done < self->skip_count || now - begin < 1.0)) continue;
        fprintf(stderr, "%s: to where it is timed, step %ld of %ld after %.0f s\n",
                self->scene_path, done, self->skip_count, now - begin);
        shown = now;
    }
    return status;
}

static tulle_status make_state(bench *self, tulle_error *error) {
    tulle_scene_world built = {0};
    void *saved = NULL;
    size_t size = 0;
    tulle_status status = tulle_scene_build_world(self->scene, 0, NULL, &built, error);
    if (status == TULLE_OK) status = simulate(self, built.world, error);
    if (status == TULLE_OK) status = tulle_world_save_state(built.world, &saved, &size, error);
    if (status == TULLE_OK && self->state_path)
        status = tulle_file_write(self->state_path, saved, size, error);
    if (status == TULLE_OK) {
        self->state = (file_data){memory_allocate(&self->heap, size + 1), size};
        if (self->state.bytes)
            memcpy(self->state.bytes, saved, size);
        else
            status = error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for the state");
    }
    if (saved) tulle_world_free_state(built.world, saved, size);
    tulle_scene_destroy_world(&built);
    return status;
}

static tulle_status load_state(const bench *self, tulle_world *world, tulle_error *error) {
    tulle_error fault = {0};
    tulle_status const status =
        tulle_world_load_state(world, self->state.bytes, self->state.byte_count, &fault);
    if (status == TULLE_OK) return TULLE_OK;
    return error_set_at(error, status, self->state_path, 0, 0,
                        "%.200s; delete it, and it is made again", fault.message);
}

/* ---- repeats ---- */

/* The timed steps and nothing else; bench.py lets callgrind count the instructions of this call. */
__attribute__((noinline)) tulle_status bench_make_steps(bench *self, tulle_world *world,
                                                        tulle_error *error);
tulle_status bench_make_steps(bench *self, tulle_world *world, tulle_error *error) {
    tulle_status status = TULLE_OK;
    for (long i = 0; i < self->step_count && status == TULLE_OK; i++)
        status = tulle_world_step(world, self->time_step, &self->reports[i], error);
    return status;
}

/* samples: [s] a step, TIME_COUNT of them. */
static tulle_status make_repeat(bench *self, tulle_world *world, counted_heap *heap,
                                double *samples, outcome *known, tulle_error *error) {
    outcome found = {0};
    tulle_status status = load_state(self, world, error);
    found.start_hash = tulle_world_get_state_hash(world);
    if (status == TULLE_OK) status = tulle_world_step(world, self->time_step, NULL, error);
    heap->calls = 0;
    double const begin = timer_processor_now();
    if (status == TULLE_OK) status = bench_make_steps(self, world, error);
    if (status != TULLE_OK) return status;
    memset(samples, 0, TIME_COUNT * sizeof *samples);
    samples[PROCESSOR_TIME] = timer_processor_now() - begin;
    for (long i = 0; i < self->step_count; i++) {
        for (size_t k = 0; k < TULLE_STAGE_COUNT; k++)
            samples[k] += self->reports[i].stage_seconds[k];
        samples[STEP_TIME] += self->reports[i].total_seconds;
    }
    for (size_t k = 0; k < TIME_COUNT; k++) samples[k] /= (double)self->step_count;
    found.end_hash = tulle_world_get_state_hash(world);
    sum_counts(self, &found);
    if (!known->start_hash) *known = found;
    return compare_outcomes(known, &found, error);
}

/* ---- what is printed ---- */

static void print_sizes(const bench *self, long threads) {
    size_t particles = 0, cloth = 0, obstacles = 0;
    for (size_t i = 0; i < tulle_scene_get_cloth_count(self->scene); i++) {
        particles += tulle_scene_get_cloth_mesh(self->scene, i).vertex_count;
        cloth += tulle_scene_get_cloth_mesh(self->scene, i).triangle_count;
    }
    for (size_t i = 0; i < tulle_scene_get_obstacle_count(self->scene); i++)
        obstacles += tulle_scene_get_obstacle_mesh(self->scene, i).triangle_count;
    printf("%ld,count,particles,%zu\n%ld,count,cloth_triangles,%zu\n", threads, particles, threads,
           cloth);
    printf("%ld,count,obstacle_triangles,%zu\n%ld,count,steps,%ld\n", threads, obstacles, threads,
           self->step_count);
}

static void print_case(const bench *self, long threads, const double *samples, long made,
                       const outcome *known) {
    for (size_t k = 0; k < TIME_COUNT; k++) {
        printf("%ld,time,%s", threads,
               k == STEP_TIME        ? "step"
               : k == PROCESSOR_TIME ? "processor"
                                     : tulle_stage_name((int)k));
        for (long i = 0; i < made; i++) printf(",%.9g", samples[(size_t)i * TIME_COUNT + k]);
        putchar('\n');
    }
    print_sizes(self, threads);
    for (size_t i = 0; i < COUNT_COUNT; i++)
        printf("%ld,count,%s,%" PRIu64 "\n", threads, count_names[i], known->counts[i]);
    unsigned long const kilobytes = take_most_resident();
    if (kilobytes) printf("%ld,about,most_resident,%llu\n", threads, 1024ULL * kilobytes);
    printf("%ld,hash,start,%016" PRIx64 "\n%ld,hash,end,%016" PRIx64 "\n%ld,about,repeats,%ld\n",
           threads, known->start_hash, threads, known->end_hash, threads, made);
}

/* ---- a case ---- */

/* The first repeat warms caches and memory and is made again. */
static tulle_status measure(bench *self, long threads, outcome *known, tulle_error *error) {
    counted_heap heap = {0};
    tulle_allocator const allocator = {
        .allocate = heap_allocate, .release = heap_release, .context = &heap};
    tulle_scene_world built = {0};
    double *const samples = calloc((size_t)self->repeat_count * TIME_COUNT, sizeof *samples);
    if (!samples)
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "out of memory for the measures");
    tulle_status status =
        tulle_scene_build_world(self->scene, (int)threads, &allocator, &built, error);
    if (status == TULLE_OK) tulle_world_set_stop_request(built.world, is_stopped, NULL);
    (void)take_most_resident();
    double const begin = timer_now();
    long made = 0;
    if (status == TULLE_OK && self->repeat_count > 1)
        status = make_repeat(self, built.world, &heap, samples, known, error);
    while (status == TULLE_OK && made < self->repeat_count &&
           (made < REPEATS_MIN || timer_now() - begin < (double)self->most_seconds)) {
        status = make_repeat(self, built.world, &heap, samples + made * TIME_COUNT, known, error);
        made++;
    }
    if (status == TULLE_OK) {
        print_case(self, threads, samples, made, known);
        printf("%ld,memory,most_bytes,%zu\n%ld,memory,allocator_calls,%" PRIu64 "\n", threads,
               heap.most, threads, heap.calls);
    }
    tulle_scene_destroy_world(&built);
    free(samples);
    return status;
}

static int refuse(tulle_status status, const tulle_error *error, bool is_input) {
    if (status == TULLE_ERROR_INTERRUPTED) return EXIT_INTERRUPTED;
    fprintf(stderr, "bench_scene: %s%s%s\n", error->file, error->file[0] ? ": " : "",
            error->message);
    return is_input ? EXIT_BAD_INPUT : EXIT_CANNOT_GO_ON;
}

static int run(bench *self) {
    tulle_error error = {0};
    outcome known = {0};
    bool const is_read = self->state_path && access(self->state_path, F_OK) == 0;
    tulle_status status = is_read
                              ? file_load(&self->heap, self->state_path, 0, &self->state, &error)
                              : make_state(self, &error);
    if (status != TULLE_OK) return refuse(status, &error, is_read);
#ifdef __clang__
    printf(",about,compiler,%s\n", __VERSION__);
#else
    puts(",about,compiler,gcc " __VERSION__);
#endif
    for (size_t i = 0; i < self->threads_count && status == TULLE_OK; i++)
        status = measure(self, self->threads[i], &known, &error);
    if (status != TULLE_OK) return refuse(status, &error, status == TULLE_ERROR_PARSE);
    if (fflush(stdout) == 0) return EXIT_SUCCESS;
    fprintf(stderr, "bench_scene: standard output: %s\n", strerror(errno));
    return EXIT_CANNOT_GO_ON;
}

/* ---- the command line ---- */

static bool read_number(const char *text, long least, long most, long *value) {
    char *end = NULL;
    errno = 0;
    *value = strtol(text, &end, 10);
    return end != text && !*end && errno == 0 && *value >= least && *value <= most;
}

static bool read_threads(const char *text, bench *self) {
    self->threads_count = 0;
    for (;; text++) {
        char *end = NULL;
        long const number = strtol(text, &end, 10);
        if (end == text || number < 1 || number > THREADS_MAX || (*end && *end != ',') ||
            self->threads_count == THREAD_NUMBERS_MAX)
            return false;
        self->threads[self->threads_count++] = number;
        if (!*end) return true;
        text = end;
    }
}

/* False: the option is unknown, or its value is not what it should be. */
static bool read_option(bench *self, const char *name, char *value) {
    struct {
        const char *name;
        long least, most, *value;
    } const numbers[] = {{"--skip", 0, 10000000, &self->skip_count},
                         {"--steps", 1, STEPS_MAX, &self->step_count},
                         {"--repeat", 1, 1000, &self->repeat_count},
                         {"--seconds", 1, 1000000, &self->most_seconds}};
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++)
        if (strcmp(name, numbers[i].name) == 0)
            return read_number(value, numbers[i].least, numbers[i].most, numbers[i].value);
    if (strcmp(name, "--threads") == 0) return read_threads(value, self);
    if (strcmp(name, "--state") == 0) {
        self->state_path = value;
        return true;
    }
    if (strcmp(name, "--set") != 0 || self->override_count == OVERRIDES_MAX) return false;
    self->overrides[self->override_count++] = value;
    return true;
}

static bool read_words(bench *self, int argc, char **argv) {
    for (int i = 1; i < argc; i++) {
        if (strncmp(argv[i], "--", 2) != 0 && !self->scene_path) {
            self->scene_path = argv[i];
        } else if (i + 1 < argc && read_option(self, argv[i], argv[i + 1])) {
            i++;
        } else {
            fprintf(stderr, "bench_scene: \"%.80s%s%.80s\" is not understood\n%s", argv[i],
                    i + 1 < argc ? " " : "", i + 1 < argc ? argv[i + 1] : "", usage);
            return false;
        }
    }
    if (!self->scene_path) fputs(usage, stderr);
    return self->scene_path;
}

int main(int argc, char **argv) {
    static bench self = {.threads = {1, 2},
                         .threads_count = 2,
                         .skip_count = 30,
                         .step_count = 8,
                         .repeat_count = 7,
                         .most_seconds = 60};
    if (!read_words(&self, argc, argv)) return EXIT_BAD_INPUT;
    struct sigaction const on_interrupt = {.sa_handler = interrupt, .sa_flags = (int)SA_RESETHAND};
    sigaction(SIGINT, &on_interrupt, NULL);
    static tulle_scene_problems problems;
    if (tulle_scene_load(self.scene_path, self.overrides, self.override_count, &self.scene,
                         &problems) != TULLE_OK) {
        scene_print_problems(&problems, stderr);
        return EXIT_BAD_INPUT;
    }
    self.heap = memory_default();
    self.time_step = tulle_scene_get_time_step(self.scene);
    int const code = run(&self);
    file_release(&self.heap, &self.state);
    tulle_scene_destroy(self.scene);
    return code;
}
