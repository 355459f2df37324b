/* app/reproduce_figures.c - the figures and tables of the paper that `tulle reproduce` makes: the
 * runs of each, what the paper shows, what is done here and what differs. */
#include "app/reproduce.h"

#include <string.h>

static const reproduce_run every_scene[] = {{"example_one_low_friction", NULL},
                                            {"example_one_high_friction", NULL},
                                            {"animation_1", "patches"},
                                            {"animation_2", "patches"},
                                            {"animation_3", "patches"},
                                            {"animation_4", "patches"},
                                            {"animation_5", "patches"},
                                            {"animation_6", "patches"},
                                            {"rings", NULL},
                                            {"ribbons", NULL}};

#define COUNT(array) (sizeof(array) / sizeof(array)[0])

const reproduce_figure reproduce_figures[] = {
    {.name = "counterexamples",
     .title = "What the rule for patches misses",
     .runs = every_scene,
     .run_count = COUNT(every_scene),
     .make = reproduce_counterexamples,
     .paper = "Section 3.3 skips every pair of triangles within one patch whose normals stay "
              "within a cone, and says that this misses collisions of two parts of one patch at "
              "different sides, and in surfaces with holes or narrow regions; section 7 leaves "
              "them open. No number is given.",
     .ours = "Two motions, both clean at the start and at the end: a spiral ramp that is turned "
             "upside down, and an open ring whose ends go through each other. Then recorded frames "
             "of the paper's scenes, from each one to the next, with the contact distance of the "
             "scene: what a search without patches finds (events), what the paper's rules find at "
             "their best angle, 85 degrees, and what they miss. The last column is the same with "
             "only those patches skipped that are proven not to touch themselves.",
     .differences = "The frames are those of runs in which nothing was missed, so each one starts "
                    "clean; in a run by the paper's rules a collision that was missed once stays.",
     .items = {{"counterexamples_motions.csv", "Motions made for this"},
               {"counterexamples_scenes.csv", "Recorded frames of the scenes"}}},
};
const size_t reproduce_figure_count = COUNT(reproduce_figures);

static bool is_same_run(const reproduce_run *a, const reproduce_run *b) {
    if (strcmp(a->scene, b->scene) != 0 || !a->method != !b->method) return false;
    return !a->method || strcmp(a->method, b->method) == 0;
}

size_t reproduce_add_runs(const reproduce_figure *figure,
                          const reproduce_run *runs[REPRODUCE_RUNS_MAX], size_t count) {
    for (size_t i = 0; i < figure->run_count; i++) {
        size_t k = 0;
        while (k < count && !is_same_run(runs[k], &figure->runs[i])) k++;
        if (k == count && count < REPRODUCE_RUNS_MAX) runs[count++] = &figure->runs[i];
    }
    return count;
}

size_t reproduce_list_runs(const reproduce_run *runs[REPRODUCE_RUNS_MAX]) {
    size_t count = 0;
    for (size_t f = 0; f < reproduce_figure_count; f++)
        count = reproduce_add_runs(&reproduce_figures[f], runs, count);
    return count;
}
