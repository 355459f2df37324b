/* A glTF file with everything that moves vertices. Include in one file of the program only. */
#ifndef TULLE_TEST_EVERYTHING_H
#define TULLE_TEST_EVERYTHING_H

#include "io/bytes.h"

#include "io/animation/animation_sample.h"

static const char base64_digits[] =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

static inline void encode(const unsigned char *bytes, size_t count, char *text) {
    for (size_t i = 0; i < count; i += 3) {
        uint32_t bits = 0;
        for (size_t k = 0; k < 3; k++) bits = bits << 8 | (i + k < count ? bytes[i + k] : 0u);
        for (int k = 0; k < 4; k++) *text++ = base64_digits[bits >> (18 - 6 * k) & 63];
    }
    *text = '\0';
}

/* Node 0 turns by a quarter about z in 1 s and holds node 1, which shows mesh 0 (a strip of
 * bytes as indices, two targets, one of them sparse) and is moved by a matrix of scale 2. Node 2
 * shows mesh 1 (a fan without indices) on a skin of the joints 3 and 4, and joint 4 rises on a
 * cubic spline. */
static inline size_t write_everything(const char *path) {
    static const float values[] = {
        0, 0,    0, 1,    0,    0,    0,           1,           0, 1, 1, 0, /*   0: four corners */
        0, 0,    1, 0,    0,    1,    0,           0,           1, 0, 0, 1, /*  48: target 0: up */
        5, 0,    0,                                             /*  96: target 1 of vertex 2 */
        0, 1,                                                   /* 108: times */
        0, 0,    0, 1,    0,    0,    0.70710678f, 0.70710678f, /* 116: rotations */
        0, 0,    1, 0.5f,                                       /* 148: weights */
        1, 0,    0, 0,    0.5f, 0.5f, 0,           0,           0, 1, 0, 0, 0, 1, 0, 0, /* 164:
                                                                                           weights
                                                                                           of joints
                                                                                         */
        0, 0,    0, 0,    0,    0,    2,           0,           0, 0, 0, 0, 4, 0, 0, 0, 0,
        0,           /* 228: cubic: in, value, out */
        0, 0.5f, 1}; /* 300: times of the cubic's frames */
    static const unsigned char small[] = {0, 1, 2, 3, 2, 0, 0, 0,                          /* 312 */
                                          0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0}; /* 320 */
    unsigned char bytes[400];
    char text[600];
    size_t size = 0;
    for (size_t i = 0; i < sizeof values / sizeof values[0]; i++, size += 4)
        bytes_store_float(bytes + size, values[i]);
    assert_int_equal(size, 312);
    memcpy(bytes + size, small, sizeof small);
    size += sizeof small;
    encode(bytes, size, text);
    static char json[8192];
    int const length = snprintf(
        json, sizeof json,
        "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,2,3]}],\n"
        "\"nodes\":[{\"children\":[1]},{\"mesh\":0,\"matrix\":[2,0,0,0,0,2,0,0,0,0,2,0,10,0,0,1]},"
        "\n"
        "{\"mesh\":1,\"skin\":0,\"translation\":[100,0,0]},{\"children\":[4]},{}],\n"
        "\"skins\":[{\"joints\":[3,4]}],\n"
        "\"meshes\":[{\"primitives\":[{\"mode\":5,\"indices\":6,\"attributes\":{\"POSITION\":0},"
        "\"targets\":[{\"POSITION\":1},{\"POSITION\":2}]},{\"mode\":1,\"attributes\":{\"POSITION\":"
        "0}}],\"weights\":[0,1]},\n"
        "{\"primitives\":[{\"mode\":6,\"attributes\":{\"POSITION\":0,\"JOINTS_0\":7,\"WEIGHTS_0\":8"
        "}}]}],\n"
        "\"animations\":[{\"samplers\":[{\"input\":3,\"output\":4},{\"input\":3,\"output\":5,"
        "\"interpolation\":\"STEP\"},{\"input\":3,\"output\":9,\"interpolation\":\"CUBICSPLINE\"},"
        "{\"input\":10,\"output\":11}],\n"
        "\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"rotation\"}},{\"sampler\":"
        "1,"
        "\"target\":{\"node\":1,\"path\":\"weights\"}},{\"sampler\":2,\"target\":{\"node\":4,"
        "\"path\":"
        "\"translation\"}},{\"sampler\":3,\"target\":{\"node\":3,\"path\":\"scale\"}}]},{}],\n"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},\n"
        "{\"bufferView\":0,\"byteOffset\":48,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},"
        "\n"
        "{\"componentType\":5126,\"count\":4,\"type\":\"VEC3\",\"sparse\":{\"count\":1,\"indices\":"
        "{\"bufferView\":0,\"byteOffset\":316,\"componentType\":5121},\"values\":{\"bufferView\":0,"
        "\"byteOffset\":96}}},\n"
        "{\"bufferView\":0,\"byteOffset\":108,\"componentType\":5126,\"count\":2,\"type\":"
        "\"SCALAR\"},"
        "\n{\"bufferView\":0,\"byteOffset\":116,\"componentType\":5126,\"count\":2,\"type\":"
        "\"VEC4\"},"
        "\n{\"bufferView\":0,\"byteOffset\":148,\"componentType\":5126,\"count\":4,\"type\":"
        "\"SCALAR\""
        "},\n{\"bufferView\":0,\"byteOffset\":312,\"componentType\":5121,\"count\":4,\"type\":"
        "\"SCALAR\"},\n{\"bufferView\":0,\"byteOffset\":320,\"componentType\":5121,\"count\":4,"
        "\"type\":\"VEC4\"},\n{\"bufferView\":0,\"byteOffset\":164,\"componentType\":5126,"
        "\"count\":4,"
        "\"type\":\"VEC4\"},\n{\"bufferView\":0,\"byteOffset\":228,\"componentType\":5126,"
        "\"count\":6,"
        "\"type\":\"VEC3\"},\n{\"bufferView\":0,\"byteOffset\":300,\"componentType\":5126,"
        "\"count\":3,"
        "\"type\":\"SCALAR\"},\n{\"bufferView\":1,\"componentType\":5126,\"count\":3,\"type\":"
        "\"VEC3\""
        "}],\n\"bufferViews\":[{\"buffer\":0,\"byteLength\":%zu},{\"buffer\":1,\"byteLength\":36}],"
        "\n"
        "\"buffers\":[{\"byteLength\":%zu,\"uri\":\"data:application/octet-stream;base64,%s\"},"
        "{\"byteLength\":36,\"uri\":\"data:;base64,"
        "AACAPwAAgD8AAIA/AACAPwAAgD8AAIA/AACAPwAAgD8AAIA/\"}]}\n",
        size, size, text);
    assert_true(length > 0 && length < (int)sizeof json);
    put_file(path, json, (size_t)length);
    return (size_t)length;
}

#endif
