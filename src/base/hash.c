/* base/hash.c - see hash.h. Based on: Fowler, Noll, Vo (FNV-1a); Steele, Lea, Flood, Fast
 * splittable pseudorandom number generators, 2014 (SplitMix64). */
#include "base/hash.h"

#include <string.h>

uint64_t hash_mix(uint64_t value) {
    value ^= value >> 30;
    value *= UINT64_C(0xbf58476d1ce4e5b9);
    value ^= value >> 27;
    value *= UINT64_C(0x94d049bb133111eb);
    return value ^ (value >> 31);
}

uint64_t hash_bytes(uint64_t hash, const void *bytes, size_t byte_count) {
    const unsigned char *cursor = bytes;
    for (; byte_count >= 8; cursor += 8, byte_count -= 8) {
        uint64_t word;
        memcpy(&word, cursor, 8);
        hash = hash_mix(hash ^ word) * UINT64_C(0x100000001b3);
    }
    for (size_t i = 0; i < byte_count; i++) hash = (hash ^ cursor[i]) * UINT64_C(0x100000001b3);
    return hash;
}

hash_stream hash_stream_make(uint64_t seed) { return (hash_stream){.hash = seed}; }

void hash_stream_add(hash_stream *stream, const void *bytes, size_t byte_count) {
    const unsigned char *cursor = bytes;
    while (byte_count > 0) {
        size_t const whole = stream->rest_count == 0 ? byte_count - byte_count % 8 : 0;
        size_t const taken = whole > 0 ? whole : 1;
        if (whole > 0)
            stream->hash = hash_bytes(stream->hash, cursor, whole);
        else
            stream->rest[stream->rest_count++] = *cursor;
        if (stream->rest_count == 8) {
            stream->hash = hash_bytes(stream->hash, stream->rest, 8);
            stream->rest_count = 0;
        }
        cursor += taken;
        byte_count -= taken;
    }
}

uint64_t hash_stream_get(const hash_stream *stream) {
    return hash_bytes(stream->hash, stream->rest, stream->rest_count);
}

uint64_t random_next(uint64_t *state) {
    *state += UINT64_C(0x9e3779b97f4a7c15);
    return hash_mix(*state);
}

double random_uniform(uint64_t *state) { return (double)(random_next(state) >> 11) * 0x1.0p-53; }
