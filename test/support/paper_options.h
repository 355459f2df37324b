/* test/support/paper_options.h - options of tulle/paper.h in the def of a world. */
#ifndef TULLE_TEST_PAPER_OPTIONS_H
#define TULLE_TEST_PAPER_OPTIONS_H

#include "tulle/paper.h"

/* What a world of this def has. */
static inline tulle_paper_options get_paper(const tulle_world_def *def) {
    return def->paper ? *def->paper : tulle_paper_options_default();
}

/* The options of a def, to change one. Each call makes a copy, which lives for 63 calls more. */
static inline tulle_paper_options *change_paper(tulle_world_def *def) {
    static tulle_paper_options made[64];
    static unsigned count;
    tulle_paper_options *const mine = &made[count++ % 64];
    *mine = get_paper(def);
    def->paper = mine;
    return mine;
}

#endif
