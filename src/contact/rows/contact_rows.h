/* contact/rows/contact_rows.h - a row from a pair and the time at which its frame is taken. */
#ifndef TULLE_CONTACT_ROWS_CONTACT_ROWS_H
#define TULLE_CONTACT_ROWS_CONTACT_ROWS_H

#include "contact/pairs/pair_rules.h"
#include "contact/pairs/pair_scan.h"

/* Fills a row with normal and weights of the event's time along x0 -> x1, without impulse. False
 * when the pair has no row: nothing of it can move, or its points coincide (which only pairs do
 * that are let intersect). */
bool make_contact_row(const contact_scene *scene, const double *x1, const pair_event *event,
                      contact_row *row);

/* The same in three steps, since most rows are dropped after the first or the second. The closest
 * points of the event's time, and the pair's vertices: */
closest_points compute_contact_points(const contact_scene *scene, const double *x1,
                                      const pair_event *event, uint32_t vertices[4]);
/* the row's frame and bodies: */
void begin_contact_row(const contact_scene *scene, const pair_event *event,
                       const uint32_t vertices[4], const closest_points *closest, contact_row *row);
/* and all that follows from these; false as make_contact_row. */
bool finish_contact_row(const contact_scene *scene, contact_row *row);

/* Puts the normal of an admissible row of cloth with an obstacle that stands or shifts into the
 * normal cone of the obstacle's feature at that time along x0 -> x1. A row may lean by the slope
 * tolerance; on a flat of many triangles that would lift what slides by as much of its way. */
void straighten_row(const contact_scene *scene, const double *x1, double time, contact_row *row);

/* The same for a row of an impact, however far its normal leans, if the sides start on the right
 * side of each other along the new one. */
void straighten_impact(const contact_scene *scene, const double *x1, double time, contact_row *row);

/* Turns the frame of a row of cloth with a scripted obstacle, made for time 0, to the predicted end
 * of the step. */
void turn_row_to_end(const contact_scene *scene, contact_row *row);

#endif
