/* bench/detect_input.h - what the detection benchmark runs on: three consecutive states of a
 * recorded run, its cloth made finer by Loop subdivision. The first step, from state 0 to 1, is for
 * warming up; the one from 1 to 2 is measured. */
#ifndef TULLE_BENCH_DETECT_INPUT_H
#define TULLE_BENCH_DETECT_INPUT_H

#include "tulle/detect.h"

enum { INPUT_SURFACES_MAX = 512 };

typedef struct input_source {
    const char *name;
    const char *run;   /* directory within that of all runs */
    uint32_t frame;    /* of the run, at the end of the measured step; >= 2 */
    int levels;        /* of subdivision of cloth */
    int is_turned;     /* 1: askew to the axes, so that boxes fit no part of it well */
    int has_obstacles; /* 1: with the obstacles of the run */
    double motion;     /* [edge lengths] the mean motion of the measured step is scaled to this;
                          0: as simulated */
} input_source;

typedef struct detect_input {
    const char *name;
    size_t vertex_count, triangle_count, surface_count;
    double *rest, *states[3]; /* [m] 3 * vertex_count each */
    uint32_t *triangles;
    tulle_detect_surface surfaces[INPUT_SURFACES_MAX];
    double edge;   /* [m] mean length of the edges of cloth */
    double motion; /* [edge] mean motion of the vertices of cloth in the measured step */
} detect_input;

/* Ends the program, with a message, when the run cannot be read. */
void input_load(const char *runs, const input_source *source, detect_input *input);
void input_destroy(detect_input *input);
/* Whether the run is there and long enough. */
int input_exists(const char *runs, const input_source *source);

#endif
