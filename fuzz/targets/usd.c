/* fuzz/targets/usd.c - the reader of USD in its text form. */
#include "support/animation.h"
#include "support/fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_read_animation("a.usda", data, size);
    return 0;
}

void fuzz_make_seeds(void) { fuzz_make_animation_seed("a.usda", 1); }
