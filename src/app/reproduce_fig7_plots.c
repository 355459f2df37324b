/* app/reproduce_fig7_plots.c - the plots of Fig. 7: means by angle, frame by frame without and with
 * obstacles, and the shares of the stages. */
#include "app/commands.h"
#include "app/reproduce_fig7.h"

static const double MS = 1000.0; /* [ms/s] */
static const char *const angle_axis = "largest surface angle [degrees]";

static plot_panel make_panel(const char *title, const char *x_label, const char *y_label) {
    return (plot_panel){.title = title, .x_label = x_label, .y_label = y_label};
}

/* Panels of the two kinds of patches whose curves are shown. */
static void name_curves(plot_page *page, const char *paper, const char *patches) {
    if (page->panel_count > 0) return;
    page->panels[0] = make_panel(paper, "frame", "time [ms]");
    page->panels[1] = make_panel(patches, "frame", "time [ms]");
    page->panel_count = 2;
}

static void add_point(plot_page *page, int panel, const char *series, double x, double y) {
    plot_add_point(page, plot_get_series(&page->panels[panel], series), x, y);
}

void fig7_plot_frame(fig7 *figure, double angle, uint32_t frame,
                     const fig7_times times[FIG7_RULES]) {
    char name[PLOT_NAME_SIZE];
    snprintf(name, sizeof name, "%.0f degrees", angle);
    name_curves(&figure->curves, "Self-collision frame by frame, the rules of the paper",
                "Self-collision frame by frame, patches kept and proven");
    name_curves(&figure->totals, "With obstacles frame by frame, the rules of the paper",
                "With obstacles frame by frame, patches kept and proven");
    add_point(&figure->curves, 0, name, frame, MS * times[FIG7_PAPER].total);
    add_point(&figure->curves, 1, name, frame, MS * times[FIG7_PATCHES].total);
    add_point(&figure->totals, 0, name, frame, MS * times[FIG7_PAPER].with_obstacles);
    add_point(&figure->totals, 1, name, frame, MS * times[FIG7_PATCHES].with_obstacles);
}

static void add_published(plot_page *page, int panel, double angle, double ratio) {
    plot_series *const paper = plot_get_series(&page->panels[panel], "published");
    if (paper) paper->is_published = true;
    plot_add_point(page, paper, angle, ratio);
}

/* 7a. */
static int draw_means(const fig7 *figure) {
    plot_page page = {
        .panels = {make_panel("Self-collision of a frame", angle_axis, "mean time [ms]"),
                   make_panel("The same, in times of 30 degrees", angle_axis, "ratio")},
        .panel_count = 2};
    for (int i = 0; i < figure->angle_count; i++) {
        double const angle = figure->angles[i];
        const fig7_published *const told = fig7_find_published(angle);
        for (fig7_rules by = 0; by < FIG7_RULES; by++) {
            double const mean = fig7_get_mean(figure, i, by);
            add_point(&page, 0, fig7_rules_names[by], angle, MS * mean);
            add_point(&page, 1, fig7_rules_names[by], angle, mean / fig7_get_mean(figure, 0, by));
        }
        if (told && told->self_seconds > 0.0)
            add_published(&page, 1, angle,
                          told->self_seconds / fig7_find_published(30)->self_seconds);
    }
    int const code = plot_draw(figure->self, &page, "fig7a.svg");
    plot_release(&page);
    return code;
}

/* 7c: the curves, and the means in times of the first. */
static int draw_totals(fig7 *figure) {
    plot_page *const page = &figure->totals;
    page->panels[2] =
        make_panel("Mean with obstacles, in times of 30 degrees", angle_axis, "ratio");
    page->panel_count = 3;
    for (int i = 0; i < figure->angle_count; i++) {
        double const angle = figure->angles[i];
        if (!fig7_has_curve(angle)) continue;
        for (fig7_rules by = 0; by < FIG7_RULES; by++)
            add_point(page, 2, fig7_rules_names[by], angle,
                      fig7_get_total(figure, i, by) / fig7_get_total(figure, 0, by));
        add_published(page, 2, angle,
                      fig7_find_published(angle)->total_seconds /
                          fig7_find_published(30)->total_seconds);
    }
    return plot_draw(figure->self, page, "fig7c.svg");
}

/* 7d. */
static int draw_shares(const fig7 *figure) {
    static const fig7_rules shown[] = {FIG7_PAPER, FIG7_PATCHES};
    plot_page page = {
        .panels = {make_panel("Shares, the rules of the paper", angle_axis, "share [%]"),
                   make_panel("Shares, patches kept and proven", angle_axis, "share [%]")},
        .panel_count = 2};
    for (int i = 0; i < figure->angle_count; i++)
        for (int panel = 0; panel < 2; panel++) {
            const fig7_times *const sums = &figure->sums[i].sums[shown[panel]];
            double const angle = figure->angles[i];
            add_point(&page, panel, "partition", angle, fig7_get_share(sums->partition, sums));
            add_point(&page, panel, "trees", angle, fig7_get_share(sums->trees, sums));
            add_point(&page, panel, "traversal", angle, fig7_get_share(sums->traversal, sums));
            add_point(&page, panel, "intrinsic test", angle, fig7_get_share(sums->intrinsic, sums));
        }
    int const code = plot_draw(figure->self, &page, "fig7d.svg");
    plot_release(&page);
    return code;
}

int fig7_draw(fig7 *figure) {
    int code = draw_means(figure);
    if (code == APP_EXIT_FINE) code = plot_draw(figure->self, &figure->curves, "fig7b.svg");
    if (code == APP_EXIT_FINE) code = draw_totals(figure);
    return code == APP_EXIT_FINE ? draw_shares(figure) : code;
}
