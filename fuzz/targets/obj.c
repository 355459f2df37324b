/* fuzz/targets/obj.c - the reader of OBJ files. */
#include "support/mesh_file.h"

static const fuzz_mesh_format format = {"mesh.obj", fuzz_read_mesh, fuzz_write_mesh};

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_read_mesh_file(format.name, data, size);
    return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t size_max, unsigned seed) {
    return fuzz_mutate_mesh(&format, data, size, size_max, seed);
}

void fuzz_make_seeds(void) {
    fuzz_put_mesh_seeds(&format);
    fuzz_put_text_seed("polygons",
                       "# made by hand\nmtllib a.mtl\no thing\nvt 0 0\nvn 0 0 1\ns off\ng one two\n"
                       "usemtl red\nv 0 0 0 1\nv 1e0 0 0\nv 1 +1. -0\nv 0 .1E1 \\\n0\n"
                       "v 2 0.5 1 0.1 0.2 0.3\nf 1//1 2/1 3/1/1 -2\nf -4 5 -3\nl 1 2\np 1\r\n"
                       "cstype bezier\n");
}
