/* io/bytes.h - numbers of a stated byte order in byte arrays, on any machine. */
#ifndef TULLE_IO_BYTES_H
#define TULLE_IO_BYTES_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

/* Little endian, byte_count 1 .. 8. */
static inline uint64_t bytes_load(const void *bytes, size_t byte_count) {
    const unsigned char *const b = bytes;
    uint64_t value = 0;
    for (size_t i = 0; i < byte_count; i++) value |= (uint64_t)b[i] << (8 * i);
    return value;
}

static inline uint64_t bytes_load_big_endian(const void *bytes, size_t byte_count) {
    const unsigned char *const b = bytes;
    uint64_t value = 0;
    for (size_t i = 0; i < byte_count; i++) value = value << 8 | b[i];
    return value;
}

/* Little endian. */
static inline void bytes_store(void *bytes, size_t byte_count, uint64_t value) {
    unsigned char *const b = bytes;
    for (size_t i = 0; i < byte_count; i++) b[i] = (unsigned char)(value >> (8 * i));
}

static inline float bytes_to_float(uint64_t bits) {
    uint32_t const word = (uint32_t)bits;
    float value;
    memcpy(&value, &word, sizeof value);
    return value;
}

static inline double bytes_to_double(uint64_t bits) {
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static inline void bytes_store_float(void *bytes, float value) {
    uint32_t word;
    memcpy(&word, &value, sizeof word);
    bytes_store(bytes, sizeof word, word);
}

static inline void bytes_store_double(void *bytes, double value) {
    uint64_t word;
    memcpy(&word, &value, sizeof word);
    bytes_store(bytes, sizeof word, word);
}

#endif
