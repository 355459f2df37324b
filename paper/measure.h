/* measure.h - the parts of paper_measure. Each prints rows of CSV to standard output and ends the
 * program with a message when something goes wrong. */
#ifndef PAPER_MEASURE_H
#define PAPER_MEASURE_H

/* What every part is told. */
typedef struct measure_words {
    const char *run; /* directory */
    double distance; /* [m] separation: what comes nearer is an event */
    int threads;
} measure_words;

/* Fig. 7: times of detection at patch angles. Reads lines `FRAME ANGLE` or `FRAME ANGLE obstacles`
 * from standard input and prints a row for each of the rules. */
void measure_angles(const measure_words *words);
/* What the paper's rules miss. Reads frames from standard input, prints a row for each. */
void measure_missed(const measure_words *words);
/* The same of two motions that are made here; a row each. */
void measure_motions(int threads);

#endif
