/* world/step/stretch.c - what a substep would do to the lengths of cloth edges: the judgement of
 * its paths before they are taken. */
#include "world/step/step.h"

#include <math.h>

/* Growth that only takes up slack is free up to this stretch. */
static const double STRETCH_FREE = 1.15;

/* A torn edge becomes longer by this factor within one substep. */
static const double TORN_GROWTH = 1.5;

/* Lengths of an edge [m]: at rest, at the start of the substep, at its end. */
typedef struct edge_lengths {
    double rest, start, end;
} edge_lengths;

static double find_length(const double *x, size_t a, size_t b) {
    return vec3_norm(vec3_sub(vec3_load(x, a), vec3_load(x, b)));
}

static edge_lengths find_lengths(const step_context *context, size_t edge) {
    tulle_world const *const world = context->world;
    size_t const a = world->topo.edges[2 * edge], b = world->topo.edges[2 * edge + 1];
    return (edge_lengths){find_length(world->rest, a, b),
                          find_length(context->state->positions, a, b),
                          find_length(context->end, a, b)};
}

double world_measure_stretch_growth(const step_context *context) {
    double largest = 0.0;
    for (size_t e = 0; e < world_cloth_edge_count(context->world); e++) {
        edge_lengths const length = find_lengths(context, e);
        double const before = fmax(length.start / length.rest, STRETCH_FREE);
        largest = fmax(largest, length.end / length.rest - before);
    }
    return largest;
}

bool world_is_torn(const step_context *context) {
    for (size_t e = 0; e < world_cloth_edge_count(context->world); e++) {
        edge_lengths const length = find_lengths(context, e);
        if (length.end > WORLD_TORN_STRETCH * length.rest &&
            length.end > TORN_GROWTH * length.start)
            return true;
    }
    return false;
}
