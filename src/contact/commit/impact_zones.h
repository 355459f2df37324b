/* contact/commit/impact_zones.h - first step of the rescue: cloth vertices that keep hitting one
 * another move as a rigid body. */
#ifndef TULLE_CONTACT_COMMIT_IMPACT_ZONES_H
#define TULLE_CONTACT_COMMIT_IMPACT_ZONES_H

#include "contact/commit/vertex_groups.h"
#include "contact/pairs/pair_scan.h"

/* Zones of one step. At first the groups are new and is_held is zeroed. */
typedef struct impact_zones {
    vertex_groups groups; /* cloth vertices */
    bool *is_held; /* cloth_vertex_count, by group name: a vertex without mass is in the zone */
} impact_zones;

/* Joins the hits to the zones. Sets u and x1 of the vertices of each zone that no obstacle or pin
 * holds: they move along the rigid motion that has the zone's linear and angular momentum.
 * A zone that would turn too far is not moved. *zone_count grows by the number of zones that
 * nothing holds. */
tulle_status project_impact_zones(const contact_scene *scene, impact_zones *zones,
                                  const pair_events *hits, double *u, double *x1,
                                  uint64_t *zone_count);

#endif
