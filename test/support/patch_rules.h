/* support/patch_rules.h - the rules of patch_search.h: labels for one motion. */
#ifndef TULLE_TEST_PATCH_RULES_H
#define TULLE_TEST_PATCH_RULES_H

#include "detect/patches/kept_patches.h"
#include "support/patch_search.h"

typedef struct rule_state {
    memory *heap;
    patch_rule rule;
    patch_rules settings;
    kept_patches *kept;
    uint64_t seed;
    uint32_t labels[OPEN_TRIANGLES], label_count;
} rule_state;

void rule_begin(rule_state *state, memory *heap, const open_surface *of, patch_rule rule,
                uint64_t *seed);
void rule_end(rule_state *state);
/* Fills in the labels. */
void rule_apply(rule_state *state, const open_surface *of);

#endif
