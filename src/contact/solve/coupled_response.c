/* contact/solve/coupled_response.c - the table of the coupled response: one solve for the impulses
 * of all rows and the motion of all cloth and bodies. */
#include "contact/response.h"
#include "contact/rows/stick_anchors.h"
#include "contact/solve/body_drives.h"
#include "contact/solve/project_impulses.h"

static tulle_status answer_impacts(const contact_scene *scene, row_list *list, size_t first_new,
                                   double *u) {
    (void)first_new;
    return project_driven_impulses(scene, list->rows.data, list->rows.count, u);
}

/* Every vertex ends as the integrator says. */
static void mark_no_plain_ends(const contact_scene *scene, const row_list *list,
                               uint8_t *is_plain) {
    (void)scene, (void)list, (void)is_plain;
}

const contact_response coupled_response = {
    .solve_motion = solve_motion,
    .answer_impacts = answer_impacts,
    .mark_plain_ends = mark_no_plain_ends,
    .end_contacts = end_contacts,
    .keep_contacts = move_anchors,
    .balances_energy = true,
    .begins_roughly = true,
    .linearises_again = true,
    .fits_rows = true,
    .moves_bodies = true,
};
