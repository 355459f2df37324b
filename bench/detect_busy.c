/* bench/detect_busy.c - how much longer a pass takes beside a foreign process that never sleeps on
 * one of the two processors that this program is held to. */
#define _GNU_SOURCE /* sched_setaffinity */
#include "detect_tables.h"

#include <sched.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

/* Holds the process to the first `count` processors of those it may use; returns how many. */
static int hold_to_processors(int count) {
    cpu_set_t allowed, chosen;
    int taken = 0;
    CPU_ZERO(&chosen);
    if (sched_getaffinity(0, sizeof allowed, &allowed) != 0) return 0;
    for (size_t cpu = 0; cpu < CPU_SETSIZE && taken < count; cpu++) {
        if (!CPU_ISSET(cpu, &allowed)) continue;
        CPU_SET(cpu, &chosen);
        taken++;
    }
    return sched_setaffinity(0, sizeof chosen, &chosen) == 0 ? taken : 0;
}

/* The child ends with its parent. */
static pid_t start_busy_loop(void) {
    pid_t const child = fork();
    if (child != 0) return child;
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    hold_to_processors(1);
    for (volatile unsigned turns = 0;; turns++) continue;
}

static void end_busy_loop(pid_t child) {
    kill(child, SIGKILL);
    waitpid(child, NULL, 0);
}

static void print_row(const char *name, const measured_run *run, double idle) {
    const spread *const total = &run->times[STAGE_TOTAL];
    printf("%-8s %-6s %9.2f %9.2f %9.2f %9.2f %8.2f\n", run->name, name, 1e3 * total->median,
           1e3 * total->least, 1e3 * total->ninth_decile, 1e3 * run->times[STAGE_PROCESSOR].median,
           idle > 0.0 ? total->median / idle : 1.0);
    fflush(stdout);
}

/* Idle, busy, idle again: the lower of both idle medians is what the busy one is compared with. */
static void compare(const bench_options *options, const detect_input *input,
                    tulle_detect_method method) {
    measured_run before = make_run(method, 2), busy = before, after = before;
    measure_runs(input, &before, 1, options->rounds);
    pid_t const child = start_busy_loop();
    if (child < 0) return;
    usleep(100000);
    measure_runs(input, &busy, 1, options->rounds);
    end_busy_loop(child);
    measure_runs(input, &after, 1, options->rounds);
    if (before.status != TULLE_OK) return;
    double const first = before.times[STAGE_TOTAL].median, last = after.times[STAGE_TOTAL].median;
    double const idle = first < last ? first : last;
    print_row("idle", &before, idle);
    print_row("busy", &busy, idle);
    print_row("idle", &after, idle);
    write_csv(options->csv, "busy-idle", input, first < last ? &before : &after);
    write_csv(options->csv, "busy", input, &busy);
}

void print_busy(const bench_options *options) {
    printf(
        "\n== Beside a busy loop on one of two processors: 2 threads, times in ms, medians of %d "
        "passes\n",
        options->rounds);
    if (hold_to_processors(2) < 2) {
        printf("left out: there are no two processors\n");
        return;
    }
    for (size_t i = 0; i < KIND_COUNT; i++) {
        detect_input input;
        if (options->only && strcmp(options->only, kinds[i].name) != 0) continue;
        if (!input_exists(options->runs, &kinds[i])) continue;
        input_load(options->runs, &kinds[i], &input);
        printf("\n%s\n%-8s %-6s %9s %9s %9s %9s %8s\n", input.name, "method", "", "total", "min",
               "p90", "cpu", "/idle");
        compare(options, &input, TULLE_DETECT_REFIT);
        compare(options, &input, TULLE_DETECT_PATCHES);
        input_destroy(&input);
    }
}
