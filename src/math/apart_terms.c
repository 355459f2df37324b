/* math/apart_terms.c - see apart_terms.h.
 *
 * Every sum has one order, however many chunks are done at once: each term is pulled by itself,
 * and a vertex adds what it gets in the order of terms. */
#include "math/apart_terms.h"

#include "base/error.h"
#include "base/parallel.h"

bool apart_terms_make(const matrix_term *const *terms, size_t count, size_t vertex_count,
                      size_t chunk_size, arena *scratch, apart_terms *apart) {
    size_t const chunk_count = parallel_chunk_count(vertex_count, chunk_size);
    size_t share_count = 0;
    for (size_t t = 0; t < count; t++)
        for (size_t k = 0; k < 4; k++) share_count += terms[t]->vertices[k] != TULLE_NONE;
    *apart = (apart_terms){.terms = terms, .count = count, .chunk_count = chunk_count};
    apart->pulls = ARENA_NEW(scratch, double, 3 * count);
    apart->curvatures = ARENA_NEW(scratch, double, count);
    apart->share_begin = ARENA_NEW_ZEROED(scratch, uint32_t, chunk_count + 1);
    apart->shares = ARENA_NEW(scratch, apart_share, share_count);
    if (!apart->pulls || !apart->curvatures || !apart->share_begin || !apart->shares) return false;

    /* Sorts the shares by chunk; those of one chunk keep the order of terms. */
    uint32_t *const begin = apart->share_begin;
    for (size_t t = 0; t < count; t++)
        for (size_t k = 0; k < 4; k++) {
            uint32_t const vertex = terms[t]->vertices[k];
            if (vertex != TULLE_NONE) begin[vertex / chunk_size + 1]++;
        }
    for (size_t chunk = 0; chunk < chunk_count; chunk++) begin[chunk + 1] += begin[chunk];
    for (size_t t = count; t-- > 0;)
        for (size_t k = 4; k-- > 0;) {
            uint32_t const vertex = terms[t]->vertices[k];
            if (vertex == TULLE_NONE) continue;
            apart->shares[--begin[vertex / chunk_size + 1]] =
                (apart_share){vertex, (uint32_t)t, terms[t]->weights[k]};
        }
    /* Each entry has come down to the begin of the chunk before it. */
    for (size_t chunk = 0; chunk < chunk_count; chunk++) begin[chunk] = begin[chunk + 1];
    begin[chunk_count] = (uint32_t)share_count;
    return true;
}

void apart_terms_pull(const apart_terms *apart, size_t chunk, const float *direction) {
    size_t const begin = apart->count * chunk / apart->chunk_count;
    size_t const end = apart->count * (chunk + 1) / apart->chunk_count;
    for (size_t t = begin; t < end; t++) {
        const matrix_term *const term = apart->terms[t];
        double way[3] = {0.0, 0.0, 0.0};
        for (size_t k = 0; k < 4; k++)
            for (size_t i = 0; i < 3 && term->vertices[k] != TULLE_NONE; i++)
                way[i] += term->weights[k] * (double)direction[3 * (size_t)term->vertices[k] + i];
        vec3 const pull = mat3_multiply_vec3(&term->stiffness, vec3_load(way, 0));
        vec3_store(apart->pulls, t, pull);
        apart->curvatures[t] = vec3_dot(vec3_load(way, 0), pull);
    }
}

void apart_terms_add(const apart_terms *apart, size_t chunk, float *product) {
    for (uint32_t s = apart->share_begin[chunk]; s < apart->share_begin[chunk + 1]; s++) {
        const apart_share *const share = &apart->shares[s];
        for (size_t i = 0; i < 3; i++)
            product[3 * (size_t)share->vertex + i] +=
                (float)(share->weight * apart->pulls[3 * (size_t)share->term + i]);
    }
}
