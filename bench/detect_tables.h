/* bench/detect_tables.h - the tables that the detection benchmark prints, and its CSV. */
#ifndef TULLE_BENCH_DETECT_TABLES_H
#define TULLE_BENCH_DETECT_TABLES_H

#include "detect_measure.h"

#include <stdio.h>

/* What all tables need to know. */
typedef struct bench_options {
    const char *runs; /* directory of the recorded runs */
    const char *only; /* input to take; null: all */
    uint32_t frame;   /* instead of that of the inputs, with its own motion; 0: not */
    int rounds;
    int threads[4]; /* 0 ends the list */
    int has_paper;  /* the paper's method too, which is slow */
    FILE *csv;      /* null: none */
} bench_options;

enum { KIND_COUNT = 4 };
extern const input_source kinds[KIND_COUNT];

/* Both states of each kind's measured step as NAME_start.ply and NAME_end.ply. */
void write_kinds(const bench_options *options, const char *directory);
/* Every method on the four kinds of input: stages, counts, ratio to `refit`. */
void print_kinds(const bench_options *options);
/* Cloth on a sphere, needles, ribbon pile, net: what patches bring, for several alpha_max. */
void print_angles(const bench_options *options);
/* The same draped cloth with 5k to 1.3M triangles. */
void print_growth(const bench_options *options);
/* Consecutive steps of runs, for several alpha_max. */
void print_lasting(const bench_options *options);
/* A pass beside a foreign busy loop on one of two processors. */
void print_busy(const bench_options *options);
/* What each stage has to move and does, beside what the machine can. */
void print_floor(const bench_options *options);
/* Dense inputs that are made here: candidates beside those of tight boxes, stages, first calls. */
void print_dense(const bench_options *options);
/* Reported pairs that do not touch, by rational arithmetic. */
void print_alarms(const bench_options *options);

/* A def of a method with the defaults of the library; threads 0 is not allowed. */
measured_run make_run(tulle_detect_method method, int threads);
void write_csv_header(FILE *csv);
void write_csv(FILE *csv, const char *table, const detect_input *input, const measured_run *run);

#endif
