/* contact/commit/impact_zones.h - first step of the rescue: cloth vertices that keep hitting one
 * another move as a rigid body. */
#ifndef TULLE_CONTACT_COMMIT_IMPACT_ZONES_H
#define TULLE_CONTACT_COMMIT_IMPACT_ZONES_H

#include "contact/commit/vertex_groups.h"
#include "contact/pairs/pair_scan.h"

/* Zones of one step. */
typedef struct impact_zones {
    vertex_groups groups; /* cloth vertices */
    bool *is_held;        /* by group name: the zone holds a vertex without mass */
} impact_zones;

bool impact_zones_make(impact_zones *zones, const contact_scene *scene);

/* Joins the hits to the zones and moves each zone that is not held by obstacles or pins along the
 * rigid motion with its linear and angular momentum: u and x1 of its vertices. *zone_count grows by
 * the zones moved. */
tulle_status project_impact_zones(const contact_scene *scene, impact_zones *zones,
                                  const pair_events *hits, double *u, double *x1,
                                  uint64_t *zone_count);

#endif
