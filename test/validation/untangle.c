/* untangle.c - starts that intersect: crumpled and rolled up cloth, cloths through one another,
 * cloth through obstacles. All become clean by the exact judge, with minimum gaps kept, and the two
 * steps that follow keep them so. */
#include "support/tangled.h"
#include "validation/validation.h"

#include <math.h>

enum { SEEDS = 10, STEPS = 2, SMALL_SIDE = 13 };
static unsigned const SIDES[] = {15, 21, 27, 33};

typedef struct start_sums {
    size_t starts, clean, through_obstacles, rounds;
    size_t crossing;                    /* pairs in the states after the starts that succeeded */
    double fewest, most;                /* pairs that intersect in a start */
    double displacement, longest, time; /* [m] and [s] largest, [s] of all */
} start_sums;

/* A start and its world. */
typedef struct open_start {
    tangled_start start;
    tulle_world *world;
} open_start;

static void close_start(void *object) {
    open_start *const opened = object;
    tulle_world_destroy(opened->world);
    tangled_destroy(&opened->start);
}

/* Whether the world starts and goes on without a pair that crosses or is nearer than it may be. */
static bool goes_on_clean(validation_run *run, const open_start *opened, start_sums *sums) {
    tulle_error error = {0};
    if (tulle_world_start(opened->world, &error) != TULLE_OK) return false;
    tulle_untangle_report const report = tulle_world_get_untangle_report(opened->world);
    size_t crossing = tangled_judge(&opened->start, opened->world);
    validate_count_judgement(run, crossing);
    double minimum_gap;
    tulle_world_get_distances(opened->world, NULL, NULL, &minimum_gap);
    for (int i = 0; i < STEPS; i++) {
        tulle_step_report step;
        if (tulle_world_step(opened->world, VALIDATION_STEP, &step, &error) != TULLE_OK)
            return false;
        validate_count_step(run, &step, minimum_gap);
        size_t const now = tangled_judge(&opened->start, opened->world);
        validate_count_judgement(run, now);
        crossing += now + step.ignored_pairs;
    }
    sums->crossing += crossing;
    return crossing == 0 && report.keeps_minimum_gap &&
           report.intersections == opened->start.pair_count;
}

static void add_start(validation_run *run, tangled_family family, int seed, start_sums *sums) {
    bool const is_quick = validate_options(run)->is_quick;
    tulle_world_def def = validate_world_def(run);
    def.start_intersections = TULLE_START_UNTANGLE;
    open_start *const opened = validate_allocate(run, sizeof *opened);
    validate_own(run, opened, close_start);
    opened->start = tangled_make(family, (uint64_t)seed, is_quick ? SMALL_SIDE : SIDES[seed % 4]);
    opened->world = tangled_make_world(&opened->start, &def);
    sums->starts++;
    sums->clean += goes_on_clean(run, opened, sums);
    sums->through_obstacles += opened->start.obstacle.vertex_count > 0;
    double const pairs = (double)opened->start.pair_count;
    sums->fewest = fmin(sums->fewest, pairs);
    sums->most = fmax(sums->most, pairs);
    tulle_untangle_report const report = tulle_world_get_untangle_report(opened->world);
    sums->displacement = fmax(sums->displacement, report.largest_displacement);
    sums->rounds += report.rounds;
    sums->longest = fmax(sums->longest, report.seconds);
    sums->time += report.seconds;
}

static void become_clean(validation_run *run) {
    int const seeds = validate_options(run)->is_quick ? 1 : SEEDS;
    start_sums sums = {.fewest = (double)INFINITY};
    validate_plan(run, (long)TANGLED_FAMILY_COUNT * seeds * STEPS);
    for (int family = 0; family < TANGLED_FAMILY_COUNT; family++)
        for (int seed = 1; seed <= seeds; seed++)
            add_start(run, (tangled_family)family, seed, &sums);
    validate_row(run, "starts of ten families that become clean", (double)sums.clean, "",
                 equals((double)sums.starts), "all, and two steps keep them so");
    validate_row(run, "pairs of triangles that cross after the start", (double)sums.crossing, "",
                 equals(0.0), "exact judge");
    validate_row(run, "starts with cloth through an obstacle", (double)sums.through_obstacles, "",
                 at_least(1.0), "");
    validate_row(run, "crossing pairs of a start, fewest", sums.fewest, "",
                 at_least(TANGLED_PAIRS_MIN), "");
    validate_row(run, "crossing pairs of a start, most", sums.most, "", at_most(TANGLED_PAIRS_MAX),
                 "");
    validate_row(run, "rounds of all starts", (double)sums.rounds, "", nothing(), "");
    validate_row(run, "farthest way of a vertex", sums.displacement, "m", nothing(),
                 "cloths of 1 m");
    validate_row(run, "longest time of a start", sums.longest, "s", nothing(), "");
    validate_row(run, "time of all starts", sums.time, "s", nothing(), "");
}

const experiment untangle_experiments[] = {
    {"untangle.starts", "a hundred starts that intersect become clean", become_clean, false},
    {0},
};
