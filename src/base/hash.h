/* base/hash.h - a 64-bit hash of bytes (FNV-1a over 8-byte words with a final mix); not for
 * secrets. */
#ifndef TULLE_BASE_HASH_H
#define TULLE_BASE_HASH_H

#include <stddef.h>
#include <stdint.h>

#define HASH_SEED UINT64_C(0xcbf29ce484222325)

/* Adds byte_count bytes to a running hash, HASH_SEED at first. The same on any little-endian
 * machine. */
uint64_t hash_bytes(uint64_t hash, const void *bytes, size_t byte_count);

/* Hash of a block of bytes, some five times as fast as hash_bytes and another value. A block in
 * which one word is another has another hash for certain; of others, one in 2^64 has the same. The
 * same on any little-endian machine. */
uint64_t hash_block(const void *bytes, size_t byte_count);

/* Hashes bytes that come in pieces of any length to what hash_bytes, from the same seed on, makes
 * of all of them at once. */
typedef struct hash_stream {
    uint64_t hash; /* of the whole words so far */
    unsigned char rest[8];
    size_t rest_count;
} hash_stream;
hash_stream hash_stream_make(uint64_t seed);
void hash_stream_add(hash_stream *stream, const void *bytes, size_t byte_count);
/* The hash of the bytes so far; more may follow. */
uint64_t hash_stream_get(const hash_stream *stream);

/* A well-mixed value of one integer (SplitMix64's finaliser); the base of all seeded noise. */
uint64_t hash_mix(uint64_t value);

/* SplitMix64: advances *state and returns 64 random bits; the same on every machine. */
uint64_t random_next(uint64_t *state);
/* Uniform in [0, 1). */
double random_uniform(uint64_t *state);

#endif
