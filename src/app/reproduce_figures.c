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

static const reproduce_run example_one[] = {{"example_one_low_friction", NULL},
                                            {"example_one_high_friction", NULL}};

#define FOUR_METHODS(scene)                                                                        \
    {scene, "paper"}, {scene, "bvox"}, {scene, "refit"}, { scene, "patches" }
static const reproduce_run animations_four_ways[] = {
    FOUR_METHODS("animation_1"), FOUR_METHODS("animation_2"), FOUR_METHODS("animation_3"),
    FOUR_METHODS("animation_4"), FOUR_METHODS("animation_5"), FOUR_METHODS("animation_6")};

static const reproduce_run animations[] = {{"animation_1", "patches"}, {"animation_2", "patches"},
                                           {"animation_3", "patches"}, {"animation_4", "patches"},
                                           {"animation_5", "patches"}, {"animation_6", "patches"}};
static const reproduce_run rings_and_ribbons[] = {{"rings", NULL}, {"ribbons", NULL}};

#define COUNT(array) (sizeof(array) / sizeof(array)[0])

const reproduce_figure reproduce_figures[] = {
    {.name = "fig6",
     .title = "Fig. 6: example one, low and high friction",
     .runs = example_one,
     .run_count = COUNT(example_one),
     .make = reproduce_fig6,
     .paper = "A cloth of 9,801 particles and 19,200 triangles, some particles held along lines, "
              "falls on rigid bodies of 2,827 particles and 5,472 triangles in gravity and "
              "stochastic wind; 2,400 frames of 1/90 s. With low friction it slips off, with high "
              "friction it stays. The paper shows pictures and gives no number for this.",
     .ours =
         "The scene has the same sizes and is run with low and with high friction. Numbers that "
         "tell slipping from staying, as means over the last quarter: the share of contacts "
         "that stick, the mean way of the cloth's particles from where they started [m], the "
         "height of its centre [m].",
     .differences =
         "The paper gives neither the bodies' shapes nor the coefficients of friction; "
         "ours stand in the scene files. Cloth that has slipped off "
         "comes to rest on the ground, whose contacts count for the share that sticks; cloth that "
         "stays hangs between its held lines and the bodies, at the limit of friction, where each "
         "gust moves most of its contacts by some micrometres. The way and the height tell more. "
         "Friction acts inside the implicit solve, not on forces before it.",
     .items = {{"fig6.csv", "Means over the last quarter"},
               {"fig6_findings.csv", "Slips or stays"},
               {"fig6.svg", "Over time"}},
     .has_stills = true},
    {.name = "fig7",
     .title = "Fig. 7: the angle of patches",
     .runs = example_one,
     .run_count = COUNT(example_one),
     .make = reproduce_fig7,
     .paper =
         "Self-collision detection of example one, scene (a) of Fig. 6, which is that with low "
         "friction, with the largest surface angle from 30 to 89 degrees: 0.8 s a frame at 30 "
         "degrees, 0.23 s at 85, the best, 0.26 s at 89. Over the run 1,910 s at 30 degrees, 700 s "
         "at 60, 540 s at 85; with the cloth against the rigid bodies too 2,070, 860 and 780 s. "
         "Figs. 7b and 7c show these three frame by frame, Fig. 7d the shares of partitioning, "
         "tree construction, traversal and intrinsic test: from 30 to 89 degrees traversal becomes "
         "shorter and partitioning longer.",
     .ours =
         "Recorded frames of example one with low friction, from each one to the next, given to "
         "the detector with the contact distance of the scene as separation; all angles and all "
         "rules take turns on the same frame. With one thread times are of the processor, in which "
         "other work on the machine hardly counts, with several of the wall clock. <b>paper</b>: "
         "patches grown at every frame, the "
         "paper's cone, no certificate. <b>proven</b>: the same trees, tighter cones, only patches "
         "that are proven not to touch themselves are skipped. <b>patches</b>: one refitted tree, "
         "patches that live from frame to frame and are proven; asked about the still frame first, "
         "untimed, so that what they cost to grow, which the first two pay at every frame, is not "
         "in the times. <b>bvox</b>: trees without patches, the same work at every angle: its "
         "longest mean over its shortest tells how far the machine's other load changed the times. "
         "Times over the run are the mean of a frame times the number of frames. The last table is "
         "the same for high friction at the paper's three angles.",
     .differences =
         "Another machine, by two decades; so ratios to the time at 30 degrees stand "
         "beside the paper's. The intrinsic test here is a conservative time of impact in "
         "place of a cubic and a test of the end; the paper leaves out pairs that "
         "collided in the last frame from it, this detector knows no frame before. With "
         "the paper's rules collisions within a patch are missed, see the counterexamples.",
     .items = {{"fig7_findings.csv", "Against the paper's statements"},
               {"fig7a.svg", "7a: self-collision by angle"},
               {"fig7b.svg", "7b: self-collision frame by frame"},
               {"fig7_totals.csv", "7c: with obstacles, over the run"},
               {"fig7c.svg", "7c: with obstacles, frame by frame"},
               {"fig7d.svg", "7d: shares"},
               {"fig7_angles.csv", "7a and 7d: all numbers"},
               {"fig7_high.csv", "The same with high friction"}}},
    {.name = "table1",
     .title = "Table 1: animations 1 to 6",
     .runs = animations_four_ways,
     .run_count = COUNT(animations_four_ways),
     .make = reproduce_table1,
     .paper =
         "Animations 1 to 6 at steps of 0.033 s (the first) and 0.02 s, with the proposed "
         "method at 85 degrees, BVOX-AABB trees alone, and a constant (refitted) AABB tree: "
         "what collision detection (CS), dynamics (DYN) and conjugate gradients (CGM) cost. "
         "The performance of the proposed method is the best, followed by BVOX-AABB and, "
         "last, the AABB tree. The table's numbers are in a picture and not published as text.",
     .ours =
         "The same scenes run four times: <b>paper</b>, by the paper's rules at 85 degrees "
         "without certificate, <b>bvox</b>, <b>refit</b>, and <b>patches</b>, which are kept and "
         "proven. Means of a step [ms] over the steps that all four have: CS is patches, trees, "
         "search, tests and choice of contacts; CGM the linear solves with contact; DYN the rest.",
     .differences =
         "Sizes and shapes of the scenes are ours, since the paper tells few. The contact "
         "solve is coupled to the dynamics, so CGM holds work that the paper counts as "
         "response. Runs by the paper's rules miss collisions, so their states and their "
         "costs drift from those of the others; the judge counts frames with "
         "intersections. The runs are made one after another: the linear solves of bvox, refit and "
         "patches are the same work, and same_work_ratio, their longest time over their shortest, "
         "tells how far the machine's other load changed the times. Differences of CS below it say "
         "nothing: in rankings ~ stands between such methods, and a claim that only they stand "
         "against is within the noise.",
     .items = {{"table1.csv", "Costs of a step"},
               {"table1_ranking.csv", "The paper's ranking, by CS"},
               {"table1.svg", "CS of the four methods"}}},
    {.name = "fig8",
     .title = "Fig. 8: animations 1 to 6",
     .runs = animations,
     .run_count = COUNT(animations),
     .make = reproduce_stills,
     .paper =
         "1: a net slips over the head of a nail, down a bumpy slope, hits a small nail and "
         "falls on sharp crests. 2: a large net falls over sceptres that stand in bumpy ground "
         "and collides with itself. 3: a cloth falls on a hemisphere, slips over a rough "
         "surface and falls on crests. 4: a long ribbon slips over two rows of 12 tiles into "
         "the gap between them. 5: a cloth falls over a smooth and a rough object: one part "
         "slips, one sticks. 6: 80 needles in a spiral on a hemisphere leave one by one, in "
         "strong wind.",
     .ours = "Three stills of each, from the runs with our patches.",
     .differences = "Sizes, shapes and materials are ours. The paper smooths its results by Loop "
                    "subdivision for pictures; these show the particles' triangles as they are.",
     .has_stills = true},
    {.name = "fig9",
     .title = "Fig. 9: rings and ribbons",
     .runs = rings_and_ribbons,
     .run_count = COUNT(rings_and_ribbons),
     .make = reproduce_stills,
     .paper = "9a: nine rings slip over a cape in wind. 9b: nine long ribbons fall on obstacles.",
     .ours = "Three stills of each. The rings are rigid bodies that the cloth pushes back.",
     .differences = "Sizes and shapes are ours.",
     .has_stills = true},
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
