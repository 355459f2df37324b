/* support/queries.h - queries of a world whose answers must agree. */
#ifndef TULLE_FUZZ_QUERIES_H
#define TULLE_FUZZ_QUERIES_H

#include "tulle/tulle.h"

/* Asks for what is on a ray, near a point and at the mesh of cloth 0, as `chosen` says. */
void queries_ask(tulle_world *world, const tulle_mesh *cloth, uint64_t chosen);

#endif
