/* app/reproduce_table1.c - Table 1: what collision detection, dynamics and the linear solves of
 * animations 1 to 6 cost a step, by the paper's three ways of finding pairs and by ours, and
 * whether the ranking is the paper's.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 6, Table 1. */
#include "app/commands.h"
#include "app/reproduce.h"
#include "app/reproduce_plot.h"

#include <string.h>

enum { ANIMATIONS = 6, METHODS = 4, PAPER_METHODS = 3 };
static const double MS = 1000.0; /* [ms/s] */
/* In the paper's ranking, fastest first; then ours. */
static const char *const methods[METHODS] = {"paper", "bvox", "refit", "patches"};

/* The part of a step that each of its twelve stages belongs to. */
typedef enum cost { COST_CS, COST_DYN, COST_CGM, COST_COUNT } cost;
static const struct {
    const char *stage;
    cost cost;
} stage_costs[] = {
    {"compute_forces", COST_DYN},  {"gather_contacts", COST_DYN}, {"solve_motion", COST_CGM},
    {"propose_paths", COST_DYN},   {"build_patches", COST_CS},    {"build_trees", COST_CS},
    {"find_pairs", COST_CS},       {"test_pairs", COST_CS},       {"select_admissible", COST_CS},
    {"resolve_impacts", COST_DYN}, {"commit_safely", COST_DYN},   {"update_contacts", COST_DYN}};

typedef struct table_cell {
    bool is_there, is_timed; /* its report.csv tells of all steps */
    size_t steps;
    double sums[COST_COUNT], total; /* [s] over the first `steps` steps */
    reproduce_verdict verdict;
} table_cell;

static cost find_cost(int stage) {
    const char *const name = tulle_stage_name(stage);
    for (size_t i = 0; i < sizeof stage_costs / sizeof stage_costs[0]; i++)
        if (strcmp(stage_costs[i].stage, name) == 0) return stage_costs[i].cost;
    return COST_DYN;
}

/* Sums over the first steps of a run, at most `most`. */
static tulle_status add_steps(const char *path, size_t most, table_cell *cell, tulle_error *error) {
    tulle_run_reader *reader = NULL;
    const tulle_step_report *reports = NULL;
    size_t count = 0;
    tulle_status status = tulle_run_reader_open(path, &reader, error);
    if (status == TULLE_OK) status = reproduce_get_reports(reader, &reports, &count, error);
    if (status == TULLE_OK) cell->steps = count < most ? count : most;
    for (size_t i = 0; i < cell->steps; i++) {
        for (int stage = 0; stage < TULLE_STAGE_COUNT; stage++)
            cell->sums[find_cost(stage)] += reports[i].stage_seconds[stage];
        cell->total += reports[i].total_seconds;
    }
    tulle_run_reader_close(reader);
    return status;
}

/* The cells of one animation, over as many steps as all its runs have. */
static tulle_status read_cells(const reproduce *self, const reproduce_run *runs,
                               table_cell cells[METHODS], tulle_error *error) {
    size_t steps = SIZE_MAX;
    tulle_status status = TULLE_OK;
    for (int m = 0; m < METHODS; m++) {
        cells[m] = (table_cell){0};
        cells[m].is_there = reproduce_has_run(self, &runs[m]) &&
                            reproduce_read_verdict(self, &runs[m], &cells[m].verdict);
        cells[m].is_timed = cells[m].is_there && cells[m].verdict.has_reports;
        if (cells[m].is_timed && cells[m].verdict.step_count < steps)
            steps = cells[m].verdict.step_count;
    }
    for (int m = 0; m < METHODS && status == TULLE_OK; m++) {
        char path[REPRODUCE_PATH_SIZE];
        reproduce_find_run(self, &runs[m], path);
        if (cells[m].is_timed) status = add_steps(path, steps, &cells[m], error);
    }
    return status;
}

/* [ms] a step. */
static double get_cost(const table_cell *cell, cost of) {
    return cell->steps > 0 ? MS * cell->sums[of] / (double)cell->steps : 0.0;
}

static void write_cells(FILE *stream, int animation, const table_cell cells[METHODS]) {
    for (int m = 0; m < METHODS; m++) {
        const table_cell *const cell = &cells[m];
        if (!cell->is_there) continue;
        fprintf(stream, "%d,%s,%zu,%zu,%zu,%zu,", animation, methods[m],
                cell->verdict.cloth_vertices, cell->verdict.cloth_triangles,
                cell->verdict.obstacle_vertices, cell->verdict.obstacle_triangles);
        if (cell->steps > 0)
            fprintf(stream, "%zu,%.4g,%.4g,%.4g,%.4g", cell->steps, get_cost(cell, COST_CS),
                    get_cost(cell, COST_DYN), get_cost(cell, COST_CGM),
                    MS * cell->total / (double)cell->steps);
        else
            fputs("0,,,,", stream); /* nothing tells its times */
        fprintf(stream, ",%s,%u,%s\n", cell->verdict.state, (unsigned)cell->verdict.bad_frame_count,
                cell->verdict.conditions);
    }
}

/* bvox, refit and patches lead to the same states, so their linear solves are the same work: the
 * longest over the shortest tells how far the machine's other load changed the times. */
static double get_disturbance(const table_cell cells[METHODS]) {
    double least = get_cost(&cells[1], COST_CGM), most = least;
    for (int m = 2; m < METHODS; m++) {
        double const value = get_cost(&cells[m], COST_CGM);
        if (value < least) least = value;
        if (value > most) most = value;
    }
    return least > 0.0 ? most / least : 0.0;
}

/* "bvox < refit ~ paper": the methods by what detection costs, cheapest first; ~ between two that
 * differ by less than the machine's load can. */
static void rank(const table_cell cells[METHODS], int count, double noise, char text[64]) {
    bool is_used[METHODS] = {false};
    double last = 0.0;
    text[0] = '\0';
    for (int place = 0; place < count; place++) {
        int best = -1;
        for (int m = 0; m < count; m++) {
            if (is_used[m]) continue;
            if (best < 0 || get_cost(&cells[m], COST_CS) < get_cost(&cells[best], COST_CS))
                best = m;
        }
        is_used[best] = true;
        double const value = get_cost(&cells[best], COST_CS);
        size_t const length = strlen(text);
        const char *const sign = value > noise * last ? " < " : " ~ ";
        snprintf(text + length, 64 - length, "%s%s", place > 0 ? sign : "", methods[best]);
        last = value;
    }
}

/* The paper's claim: each method costs less than those that follow it. */
static const char *judge_claim(const table_cell cells[METHODS], double noise) {
    bool is_confirmed = true;
    for (int m = 0; m < PAPER_METHODS; m++)
        for (int n = m + 1; n < PAPER_METHODS; n++) {
            double const less = get_cost(&cells[m], COST_CS), more = get_cost(&cells[n], COST_CS);
            if (less > noise * more) return "not confirmed";
            is_confirmed = is_confirmed && more > noise * less;
        }
    return is_confirmed ? "confirmed" : "within the noise";
}

/* Whether all runs were made by one build with as many threads on one kind of processor. */
static bool has_one_condition(const table_cell cells[METHODS]) {
    const char *const first = cells[0].verdict.conditions;
    for (int m = 1; m < METHODS; m++)
        if (strcmp(cells[m].verdict.conditions, first) != 0) return false;
    return strcmp(first, "mixed") != 0 && strcmp(first, "unknown") != 0;
}

static void write_finding(FILE *stream, int animation, const table_cell cells[METHODS]) {
    static const char *const claim = "paper < bvox < refit";
    bool is_timed = true;
    for (int m = 0; m < METHODS; m++) {
        if (!cells[m].is_there) return;
        is_timed = is_timed && cells[m].is_timed;
    }
    bool const is_one = has_one_condition(cells);
    if (!is_one)
        app_print_message("reproduce",
                          "animation %d: its times are not compared, since its runs were made by "
                          "several builds, on several processors or with several numbers of "
                          "threads; without runs/animation_%d.* they are made again",
                          animation, animation);
    if (!is_one || !is_timed) {
        fprintf(stream, "%d,%s,,not compared,,\n", animation, claim);
        return;
    }
    char three[64], four[64];
    double const noise = get_disturbance(cells);
    rank(cells, PAPER_METHODS, noise, three);
    rank(cells, METHODS, noise, four);
    fprintf(stream, "%d,%s,%s,%s,%s,%.4g\n", animation, claim, three, judge_claim(cells, noise),
            four, noise);
}

static void plot_cells(plot_page *page, int animation, const table_cell cells[METHODS]) {
    for (int m = 0; m < METHODS; m++)
        if (cells[m].is_timed)
            plot_add_point(page, plot_get_series(&page->panels[0], methods[m]), animation,
                           get_cost(&cells[m], COST_CS));
}

static int write_files(reproduce *self, const reproduce_figure *figure, reproduce_table *table,
                       reproduce_table *findings, plot_page *page) {
    tulle_error error = {0};
    fputs("animation,method,cloth_particles,cloth_triangles,obstacle_particles,obstacle_triangles,"
          "steps,cs_ms,dyn_ms,cgm_ms,step_ms,state,bad_frames,conditions\n",
          table->stream);
    fputs("animation,paper_ranking,our_ranking,verdict,with_patches,same_work_ratio\n",
          findings->stream);
    for (int animation = 1; animation <= ANIMATIONS; animation++) {
        table_cell cells[METHODS];
        const reproduce_run *const runs = figure->runs + (size_t)(animation - 1) * METHODS;
        if (read_cells(self, runs, cells, &error) != TULLE_OK) return reproduce_fail(&error);
        write_cells(table->stream, animation, cells);
        write_finding(findings->stream, animation, cells);
        plot_cells(page, animation, cells);
    }
    return APP_EXIT_FINE;
}

int reproduce_table1(reproduce *self, const reproduce_figure *figure) {
    reproduce_table table, findings;
    if (!reproduce_table_begin(&table)) return APP_EXIT_OUT_OF_MEMORY;
    if (!reproduce_table_begin(&findings)) {
        reproduce_table_discard(&table);
        return APP_EXIT_OUT_OF_MEMORY;
    }
    plot_page page = {.panels = {{.title = "Collision detection (CS)",
                                  .x_label = "animation",
                                  .y_label = "CS of a step [ms]"}},
                      .panel_count = 1};
    int code = write_files(self, figure, &table, &findings, &page);
    code = reproduce_table_finish(self, &table, "table1.csv", code);
    code = reproduce_table_finish(self, &findings, "table1_ranking.csv", code);
    if (code == APP_EXIT_FINE) code = plot_draw(self, &page, "table1.svg");
    plot_release(&page);
    return code;
}
