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

/* Four words at a time, each in a lane of its own: the lanes do not wait for one another. What a
 * lane does with a word can be undone, and so can what joins the lanes: one word that is another
 * makes another hash. */
enum { LANES = 4 };

static inline uint64_t add_to_lane(uint64_t lane, uint64_t word) {
    lane = (lane ^ word) * UINT64_C(0x9e3779b97f4a7c15);
    return lane ^ (lane >> 32);
}

uint64_t hash_block(const void *bytes, size_t byte_count) {
    uint64_t lanes[LANES], words[LANES];
    size_t const rest = byte_count % sizeof words;
    const unsigned char *cursor = bytes;
    const unsigned char *const end = cursor + (byte_count - rest);
    for (uint64_t i = 0; i < LANES; i++) lanes[i] = hash_mix(HASH_SEED + i);
    for (; cursor < end; cursor += sizeof words) {
        memcpy(words, cursor, sizeof words);
        for (int i = 0; i < LANES; i++) lanes[i] = add_to_lane(lanes[i], words[i]);
    }
    memset(words, 0, sizeof words);
    if (rest > 0) memcpy(words, cursor, rest);
    uint64_t hash = hash_mix(byte_count);
    for (int i = 0; i < LANES; i++) hash = hash_mix(hash ^ add_to_lane(lanes[i], words[i]));
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
