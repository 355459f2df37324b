/* fuzz/targets/gltf.c - the reader of glTF: a .glb or, where the bytes are a text, a .gltf. */
#include "support/animation.h"
#include "support/fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_read_animation("a.glb", data, size);
    return 0;
}

void fuzz_make_seeds(void) { fuzz_make_animation_seed("a.glb", 1); }
