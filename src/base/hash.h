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
/* A well-mixed value of one integer (SplitMix64's finaliser); the base of all seeded noise. */
uint64_t hash_mix(uint64_t value);

/* SplitMix64: advances *state and returns 64 random bits; the same on every machine. */
uint64_t random_next(uint64_t *state);
/* Uniform in [0, 1). */
double random_uniform(uint64_t *state);

#endif
