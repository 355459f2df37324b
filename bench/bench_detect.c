/* Times passes of the detector on inputs that bench/make_inputs.sh makes of scenes.
 * Usage: bench_detect [options] [kinds] [angles] [lasting] [growth] [busy] [floor] [dense] [alarms]
 * (no table named: all)
 *   --runs DIR      recorded runs (default: build/bench_inputs)
 *   --input NAME    this input only
 *   --frame N       this frame of it, with the motion as simulated
 *   --rounds N      measured passes (default 15)
 *   --threads A,B   (default 2,1; the tables other than kinds use the first)
 *   --paper         the paper's method too
 *   --csv FILE      every figure, one line a measurement
 *   --write DIR     writes the first and last state of each kind's measured step as PLY, and ends
 * Times are medians, minima and ninth deciles of wall clock; `cpu` is processor time of all
 * threads. The methods of one table take turns, so their ratios hold on a busy machine too. */
#include "detect_tables.h"

#include <stdlib.h>
#include <string.h>

typedef struct bench_table {
    const char *name;
    void (*print)(const bench_options *options);
} bench_table;

static const bench_table tables[] = {{"kinds", print_kinds},     {"angles", print_angles},
                                     {"lasting", print_lasting}, {"growth", print_growth},
                                     {"busy", print_busy},       {"floor", print_floor},
                                     {"dense", print_dense},     {"alarms", print_alarms}};
enum { TABLE_COUNT = sizeof tables / sizeof *tables };

static void fail(const char *what, const char *word) {
    fprintf(stderr, "bench_detect: %s %s\n", what, word);
    exit(2);
}

static void read_threads(const char *text, int threads[4]) {
    int count = 0;
    for (const char *at = text; at && *at && count < 3; count++) {
        threads[count] = atoi(at);
        if (threads[count] < 1 || threads[count] > 256) fail("not a list of threads:", text);
        at = strchr(at, ',');
        if (at) at++;
    }
    threads[count] = 0;
}

static void read_option(const char *name, const char *value, bench_options *options,
                        const char **write) {
    if (!value) fail("a value is missing after", name);
    if (strcmp(name, "--runs") == 0) {
        options->runs = value;
    } else if (strcmp(name, "--input") == 0) {
        options->only = value;
    } else if (strcmp(name, "--frame") == 0) {
        options->frame = (uint32_t)atoi(value);
    } else if (strcmp(name, "--rounds") == 0) {
        options->rounds = atoi(value);
        if (options->rounds < 1 || options->rounds > ROUNDS_MAX)
            fail("1 to 201 rounds, not", value);
    } else if (strcmp(name, "--threads") == 0) {
        read_threads(value, options->threads);
    } else if (strcmp(name, "--write") == 0) {
        *write = value;
    } else if (strcmp(name, "--csv") == 0) {
        options->csv = fopen(value, "w");
        if (!options->csv) fail("cannot write", value);
    } else {
        fail("unknown option", name);
    }
}

int main(int argc, char **argv) {
    bench_options options = {.runs = "build/bench_inputs", .rounds = 15, .threads = {2, 1}};
    int is_wanted[TABLE_COUNT] = {0}, wanted_count = 0;
    const char *write = NULL;
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--paper") == 0) {
            options.has_paper = 1;
        } else if (strncmp(argv[i], "--", 2) == 0) {
            read_option(argv[i], i + 1 < argc ? argv[i + 1] : NULL, &options, &write);
            i++;
        } else {
            int t = 0;
            while (t < TABLE_COUNT && strcmp(argv[i], tables[t].name) != 0) t++;
            if (t == TABLE_COUNT) fail("no such table:", argv[i]);
            is_wanted[t] = 1;
            wanted_count++;
        }
    }
    if (write) {
        write_kinds(&options, write);
        return 0;
    }
    write_csv_header(options.csv);
    for (int t = 0; t < TABLE_COUNT; t++)
        if (wanted_count == 0 || is_wanted[t]) tables[t].print(&options);
    if (options.csv) fclose(options.csv);
    return 0;
}
