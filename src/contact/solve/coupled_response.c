/* contact/solve/coupled_response.c - the table of the coupled response: one solve for the impulses
 * of all rows and the motion of all cloth and bodies. */
#include "contact/response.h"
#include "contact/rows/stick_anchors.h"
#include "contact/solve/project_impulses.h"

static tulle_status answer_impacts(const contact_scene *scene, row_list *list, size_t first_new,
                                   double *u) {
    (void)first_new;
    return project_impulses(scene, list->rows.data, list->rows.count, u);
}

const contact_response coupled_response = {
    .solve_motion = solve_motion,
    .answer_impacts = answer_impacts,
    .mark_plain_ends = NULL,
    .end_contacts = end_contacts,
    .keep_contacts = move_anchors,
    .keeps_momentum = true,
    .fits_rows = true,
    .moves_bodies = true,
};
