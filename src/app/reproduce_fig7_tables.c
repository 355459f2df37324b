/* app/reproduce_fig7_tables.c - the tables of Fig. 7: all angles, times over the run with
 * obstacles, and what the paper says of them beside what was found. */
#include "app/commands.h"
#include "app/reproduce_fig7.h"

#include <inttypes.h>

static const double MS = 1000.0;              /* [ms/s] */
static const double BEST = 85.0, LAST = 89.0; /* [degrees] the paper's best angle; its largest */

/* A number that the paper tells, or nothing. */
static void write_published(FILE *stream, double value) {
    if (value > 0.0)
        fprintf(stream, ",%g", value);
    else
        fputc(',', stream);
}

static double count_run_frames(const fig7 *figure) {
    return (double)figure->frames.cloth.info->frame_count - 1.0;
}

static void write_angle(const fig7 *figure, FILE *stream, int index, fig7_rules by) {
    const fig7_times *const sums = &figure->sums[index].sums[by];
    const fig7_published *const told =
        by == FIG7_PAPER ? fig7_find_published(figure->angles[index]) : NULL;
    double const mean = fig7_get_mean(figure, index, by);
    double const triangles = (double)figure->frames.cloth.triangle_count;
    fprintf(stream, "%s,%.0f,%.5g,%.5g,%.3g,%.3g,%.3g,%.3g,%.4g,%.3g,%" PRIu64,
            fig7_rules_names[by], figure->angles[index], MS * mean, mean * count_run_frames(figure),
            fig7_get_share(sums->partition, sums), fig7_get_share(sums->trees, sums),
            fig7_get_share(sums->traversal, sums), fig7_get_share(sums->intrinsic, sums),
            (double)sums->patches / (double)figure->looks,
            100.0 * (double)sums->patch_triangles / ((double)figure->looks * triangles),
            sums->events);
    write_published(stream, told ? MS * told->self_seconds : 0.0);
    write_published(stream, told ? told->self_total : 0.0);
    fputc('\n', stream);
}

int fig7_write_angles(const fig7 *figure, const char *file) {
    reproduce_table table;
    if (!reproduce_table_begin(&table)) return APP_EXIT_OUT_OF_MEMORY;
    fputs("rules,angle,self_ms,self_run_seconds,partition_percent,trees_percent,traversal_percent,"
          "intrinsic_percent,patches,patch_triangles_percent,events,published_self_ms,"
          "published_self_run_seconds\n",
          table.stream);
    for (int i = 0; i < figure->angle_count; i++)
        for (fig7_rules by = 0; by < FIG7_RULES; by++) write_angle(figure, table.stream, i, by);
    return reproduce_table_end(figure->self, &table, file);
}

int fig7_write_totals(const fig7 *figure) {
    reproduce_table table;
    double const run_frames = count_run_frames(figure);
    const fig7_published *const first = fig7_find_published(figure->angles[0]);
    if (!reproduce_table_begin(&table)) return APP_EXIT_OUT_OF_MEMORY;
    fputs("rules,angle,total_ms,self_run_seconds,total_run_seconds,ratio_to_30,"
          "published_self_run_seconds,published_total_run_seconds,published_ratio_to_30\n",
          table.stream);
    for (int i = 0; i < figure->angle_count; i++) {
        if (!fig7_has_curve(figure->angles[i])) continue;
        const fig7_published *const told = fig7_find_published(figure->angles[i]);
        for (fig7_rules by = 0; by < FIG7_RULES; by++) {
            double const total = fig7_get_total(figure, i, by);
            fprintf(table.stream, "%s,%.0f,%.5g,%.5g,%.5g,%.4g,%g,%g,%.4g\n", fig7_rules_names[by],
                    figure->angles[i], MS * total, fig7_get_mean(figure, i, by) * run_frames,
                    total * run_frames, total / fig7_get_total(figure, 0, by), told->self_total,
                    told->total_seconds, told->total_seconds / first->total_seconds);
        }
    }
    return reproduce_table_end(figure->self, &table, "fig7_totals.csv");
}

/* ---- findings ---- */

static int find_angle(const fig7 *figure, double angle) {
    int index = 0;
    while (index + 1 < figure->angle_count && figure->angles[index] != angle) index++;
    return index;
}

static int find_best(const fig7 *figure) {
    int best = 0;
    for (int i = 1; i < figure->angle_count; i++)
        if (fig7_get_mean(figure, i, FIG7_PAPER) < fig7_get_mean(figure, best, FIG7_PAPER))
            best = i;
    return best;
}

/* The same work at every angle: its longest time over its shortest. */
static double get_noise(const fig7 *figure) {
    double least = fig7_get_mean(figure, 0, FIG7_BVOX), most = least;
    for (int i = 1; i < figure->angle_count; i++) {
        double const mean = fig7_get_mean(figure, i, FIG7_BVOX);
        if (mean < least) least = mean;
        if (mean > most) most = mean;
    }
    return most / least;
}

/* Whether a ratio that the paper has above 1 is so here, beyond what the machine's load can do. */
static const char *judge_ratio(double ratio, double noise) {
    if (ratio > noise) return "yes";
    return ratio * noise < 1.0 ? "no" : "within the noise";
}

static void write_ratio(FILE *stream, const char *finding, double ratio, double told,
                        double noise) {
    fprintf(stream, "%s,%.3g", finding, ratio);
    if (told > 0.0)
        fprintf(stream, ",%.3g", told);
    else
        fputs(",above 1", stream);
    fprintf(stream, ",%s\n", judge_ratio(ratio, noise));
}

int fig7_write_findings(const fig7 *figure) {
    reproduce_table table;
    if (!reproduce_table_begin(&table)) return APP_EXIT_OUT_OF_MEMORY;
    FILE *const stream = table.stream;
    double const noise = get_noise(figure);
    int const best = find_best(figure), theirs = find_angle(figure, BEST);
    int const last = find_angle(figure, LAST);
    const fig7_times *const first_sums = &figure->sums[0].sums[FIG7_PAPER];
    const fig7_times *const last_sums = &figure->sums[last].sums[FIG7_PAPER];
    double const first_mean = fig7_get_mean(figure, 0, FIG7_PAPER);
    double const their_mean = fig7_get_mean(figure, theirs, FIG7_PAPER);
    double const last_mean = fig7_get_mean(figure, last, FIG7_PAPER);
    const fig7_published *const told = fig7_find_published(figure->angles[0]);
    bool const is_near = their_mean <= noise * fig7_get_mean(figure, best, FIG7_PAPER);
    fputs("finding,ours,published,verdict\n", stream);
    fprintf(stream, "best angle of the paper's rules [degrees],%.0f,%.0f,%s\n",
            figure->angles[best], BEST,
            best == theirs ? "yes"
            : is_near      ? "within the noise"
                           : "no");
    write_ratio(stream, "time at 30 degrees over time at 85", first_mean / their_mean,
                told->self_seconds / fig7_find_published(BEST)->self_seconds, noise);
    write_ratio(stream, "time at 30 degrees over time at 89", first_mean / last_mean,
                told->self_seconds / fig7_find_published(LAST)->self_seconds, noise);
    write_ratio(stream, "traversal at 30 degrees over traversal at 89",
                first_sums->traversal / last_sums->traversal, 0.0, noise);
    write_ratio(stream, "partition at 89 degrees over partition at 30",
                last_sums->partition / first_sums->partition, 0.0, noise);
    write_ratio(stream, "with obstacles: time at 30 degrees over time at 85",
                fig7_get_total(figure, 0, FIG7_PAPER) / fig7_get_total(figure, theirs, FIG7_PAPER),
                told->total_seconds / fig7_find_published(BEST)->total_seconds, noise);
    fprintf(stream, "same work at all angles (bvox): longest over shortest,%.4g,,\n", noise);
    return reproduce_table_end(figure->self, &table, "fig7_findings.csv");
}
