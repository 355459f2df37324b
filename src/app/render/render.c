/* app/render/render.c - `tulle render`: pictures and films of a run.
 *
 * Everything that can be wrong with the input is found before the first picture is made. The run is
 * read. The frames, the camera and the colors are chosen. The place of the output and ffmpeg are
 * tried. */
#include "app/cli/interrupt.h"
#include "app/commands.h"
#include "app/render/options.h"
#include "app/render/sequence.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What was made, on standard output. */
static void print_summary(const picture_run *run, const picture_target *target,
                          const picture_totals *totals) {
    const picture_options *const options = run->options;
    static const char *const kinds[] = {"picture", "pictures", "film"};
    app_print_names(stdout, "%s: %s\n", kinds[target->kind], target->path);
    uint32_t const last = run->frames.last;
    if (totals->frame_count == 1)
        printf("frame: %u of 0 to %u", last, run->info->frame_count - 1);
    else
        printf("frames: %u, from %u to %u", totals->frame_count, run->frames.first, last);
    if (totals->frame_count > 1 && run->frames.step > 1) printf(", every %u", run->frames.step);
    printf("; %ux%u pixels, %u samples each\n", options->width, options->height, options->samples);
    size_t hidden_count = 0;
    for (size_t i = 0; i < run->body_count; i++)
        if (run->bodies[i].is_hidden)
            app_print_names(stdout, "%s%s", hidden_count++ == 0 ? "hidden: " : ", ",
                            run->bodies[i].name);
    if (hidden_count > 0) putchar('\n');
    if (totals->sight.has_turned) app_print_names(stdout, "camera: %s\n", totals->sight.said);
    if (target->kind == PICTURE_FILM)
        printf("speed: %.6g frames a second, %s", target->frame_rate,
               target->speed > 0.9995 && target->speed < 1.0005 ? "real time\n" : "");
    if (target->kind == PICTURE_FILM && !(target->speed > 0.9995 && target->speed < 1.0005))
        printf("%.4g times as fast as real\n", target->speed);
    if (totals->made_count > 0)
        printf("traced: %u in %.3g s, %.3g s each\n", totals->made_count, totals->seconds,
               totals->seconds / totals->made_count);
    if (totals->reused_count > 0) printf("reused: %u from before\n", totals->reused_count);
    if (totals->subdivided[0]) printf("subdivided: %s\n", totals->subdivided);
}

static int report_failure(const picture_target *target, const picture_totals *totals,
                          tulle_status status, const tulle_error *error) {
    uint32_t const whole = totals->made_count + totals->reused_count;
    bool const keeps = target->kind != PICTURE_STILL && whole > 0;
    const char *const place = target->kind == PICTURE_FILM ? target->folder : target->path;
    if (status == TULLE_ERROR_INTERRUPTED && keeps)
        app_print_message(
            "render",
            "interrupted; %u of %u pictures are kept in %s; the same command continues from there",
            whole, totals->frame_count, place);
    else if (status == TULLE_ERROR_INTERRUPTED)
        app_print_message("render", "interrupted; nothing was written");
    else
        app_print_error("render", error);
    if (status != TULLE_ERROR_INTERRUPTED && keeps)
        app_print_message("render", "%u of %u pictures are kept in %s", whole, totals->frame_count,
                          place);
    return totals->is_begun ? app_exit_for_run(status) : app_exit_for_input(status);
}

/* Too large for a small stack. */
typedef struct render_session {
    picture_options options;
    picture_run run;
    picture_target target;
    picture_totals totals;
    tulle_error error;
} render_session;

static int make_pictures(render_session *session) {
    picture_run *const run = &session->run;
    tulle_error *const error = &session->error;
    tulle_status status = picture_run_open(run, &session->options, error);
    if (status == TULLE_OK)
        status = picture_target_choose(&session->options, run, &session->target, error);
    if (status == TULLE_OK) {
        interrupt_catch();
        status = picture_make_all(run, &session->target, &session->totals, error);
    }
    int code = APP_EXIT_FINE;
    if (status == TULLE_OK) {
        const picture_totals *const totals = &session->totals;
        print_summary(run, &session->target, totals);
        if (totals->sight.is_unseen) app_print_message("render", "%s", totals->sight.said);
        if (totals->is_intersecting) app_print_message("render", "%s", totals->subdivided);
        code = app_finish_output("render");
    } else {
        code = report_failure(&session->target, &session->totals, status, error);
    }
    picture_run_close(run);
    return code;
}

int app_render(int argc, char **argv) {
    render_session *const session = calloc(1, sizeof *session);
    if (!session) {
        app_print_message("render", "out of memory");
        return APP_EXIT_OUT_OF_MEMORY;
    }
    options_outcome const outcome = picture_options_read(argc, argv, &session->options);
    int const code = outcome == OPTIONS_READ ? make_pictures(session) : options_exit(outcome);
    free(session);
    return code;
}
