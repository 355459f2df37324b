/* fuzz/targets/ply.c - the reader of PLY files. */
#include "support/mesh_file.h"

#include <string.h>

static const fuzz_mesh_format format = {"mesh.ply", fuzz_read_mesh, fuzz_write_mesh};

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_read_mesh_file(format.name, data, size);
    return 0;
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t size_max, unsigned seed) {
    return fuzz_mutate_mesh(&format, data, size, size_max, seed);
}

void fuzz_make_seeds(void) {
    fuzz_put_mesh_seeds(&format);
    fuzz_put_text_seed("text", "ply\nformat ascii 1.0\ncomment by hand\nobj_info none\n"
                               "element vertex 4\nproperty float x\nproperty float y\n"
                               "property float z\nproperty uchar red\nelement edge 1\n"
                               "property int vertex1\nproperty int vertex2\nelement face 2\n"
                               "property list uchar int vertex_index\n"
                               "property list uchar float texcoord\nend_header\n"
                               "0 0 0 255\n1 0 0 0\n1 1 0.5 7\n0 1 1e-3 9\n0 1\n"
                               "3 0 1 2 0\n4 0 1 2 3 2 0.5 0.5\n");
    static const char head[] = "ply\r\nformat binary_big_endian 1.0\r\nelement vertex 3\r\n"
                               "property float64 x\r\nproperty int16 y\r\nproperty uint8 z\r\n"
                               "element face 1\r\nproperty list uint8 uint16 vertex_indices\r\n"
                               "end_header\r\n";
    static const char body[] = "\x3f\xf0\0\0\0\0\0\0\0\1\2\xbf\xf0\0\0\0\0\0\0\xff\xff\0"
                               "\0\0\0\0\0\0\0\0\0\7\5\3\0\0\0\1\0\2";
    char big_endian[sizeof head + sizeof body];
    memcpy(big_endian, head, sizeof head - 1);
    memcpy(big_endian + sizeof head - 1, body, sizeof body - 1);
    fuzz_put_seed("big_endian", big_endian, sizeof head + sizeof body - 2);
}
