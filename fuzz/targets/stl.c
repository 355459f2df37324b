/* fuzz/targets/stl.c - the readers of STL files, binary and text. */
#include "support/mesh_file.h"

static const fuzz_mesh_format format = {"mesh.stl", fuzz_read_mesh, fuzz_write_mesh};

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_read_mesh_file(format.name, data, size);
    return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t size_max, unsigned seed) {
    return fuzz_mutate_mesh(&format, data, size, size_max, seed);
}

void fuzz_make_seeds(void) {
    fuzz_put_mesh_seeds(&format);
    fuzz_put_text_seed("text", "solid a thing\n  facet normal 0 0 1\n    outer loop\n"
                               "      vertex 0 0 0\n      vertex 1 0 0\n      vertex 0 1.5e0 -0\n"
                               "    endloop\n  endfacet\n  facet normal 0 0 0\n outer loop\n"
                               "vertex 1 0 0\nvertex 1 1 0\nvertex 0 1.5 0\nendloop\nendfacet\n"
                               "endsolid a thing\n");
}
