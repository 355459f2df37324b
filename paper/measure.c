/* measure.c - paper_measure: asks the detector about recorded frames, for paper/reproduce.
 *
 * usage: paper_measure angles RUN DISTANCE THREADS   times at patch angles (angles.c)
 *        paper_measure missed RUN DISTANCE THREADS   what the paper's rules miss (missed.c)
 *        paper_measure motions THREADS               the same of two motions made here (missed.c)
 *
 * What is to be measured comes as lines on standard input, so that the caller keeps what is
 * measured, looks up what was measured before, and ends this program at any time. Exit codes: 0
 * fine, 2 bad usage or input, 4 out of memory. */
#include "measure.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { THREADS_MAX = 256, DECIMAL = 10, EXIT_BAD_USAGE = 2 };

static int read_threads(const char *text) {
    char *end = NULL;
    long const threads = strtol(text, &end, DECIMAL);
    return end != text && *end == '\0' && threads >= 1 && threads <= THREADS_MAX ? (int)threads : 0;
}

int main(int argc, char **argv) {
    const char *const part = argc > 1 ? argv[1] : "";
    int const threads = argc > 2 ? read_threads(argv[argc - 1]) : 0;
    if (strcmp(part, "motions") == 0 && argc == 3 && threads > 0) {
        measure_motions(threads);
        return EXIT_SUCCESS;
    }
    bool const is_angles = strcmp(part, "angles") == 0, is_missed = strcmp(part, "missed") == 0;
    char *end = NULL;
    double const distance = argc == 5 ? strtod(argv[3], &end) : -1.0;
    bool const is_distance = end && *end == '\0' && distance >= 0.0;
    if ((!is_angles && !is_missed) || !is_distance || threads == 0) {
        fputs("usage: paper_measure angles|missed RUN DISTANCE THREADS\n"
              "       paper_measure motions THREADS\n",
              stderr);
        return EXIT_BAD_USAGE;
    }
    measure_words const words = {argv[2], distance, threads};
    if (is_angles)
        measure_angles(&words);
    else
        measure_missed(&words);
    return EXIT_SUCCESS;
}
