/* base/timer.c - clocks. */
#define _POSIX_C_SOURCE 200809L
#include "base/timer.h"

#include <time.h>

double timer_now(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

double timer_processor_now(void) {
    struct timespec const moment = {.tv_nsec = 200000};
    struct timespec now;
    nanosleep(&moment, NULL);
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}
