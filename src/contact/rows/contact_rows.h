/* contact/rows/contact_rows.h - a row from a pair and the time at which its frame is taken. */
#ifndef TULLE_CONTACT_ROWS_CONTACT_ROWS_H
#define TULLE_CONTACT_ROWS_CONTACT_ROWS_H

#include "contact/pairs/pair_rules.h"
#include "contact/pairs/pair_scan.h"

/* A row is made in two parts, because most rows are dropped between them. The first one fills
 * features, bodies, normal and weights, as of the event's time along x0 -> x1. */
void begin_contact_row(const contact_scene *scene, const double *x1, const pair_event *event,
                       contact_row *row);
/* The second one fills all that follows from these; the row has no impulse yet. False if the pair
 * has no row: nothing of it can move, or its points coincide, as only ignored pairs may. */
bool finish_contact_row(const contact_scene *scene, contact_row *row);

/* Straightens a row that leans: its normal becomes the nearest one in the normal cone of the
 * obstacle's feature, at time `time` along x0 -> x1. A row may lean by the slope tolerance; on a
 * flat of many triangles it would lift sliding cloth by that share of its path. Changes rows of
 * cloth with a scripted obstacle that does not turn.
 *
 * The row of an impact takes the normal however far it leans, if the sides start on the right side
 * of each other along it. Other rows take it if they lean by the slope tolerance at most, or if no
 * other normal is near. */
void straighten_row(const contact_scene *scene, const double *x1, double time, bool is_impact,
                    contact_row *row);

/* Turns the frame of a row that was made for time 0 to the predicted end of the step. Changes rows
 * of cloth with a scripted obstacle that does not turn. */
void turn_row_to_end(const contact_scene *scene, contact_row *row);

#endif
