/* contact/paper/respond_by_paper.h - stages 3 and 10 by the paper's own rules, for comparison:
 * forces are projected on the motion spaces of the vertices before the solve, velocities after it.
 * The safe commit guards what comes out. */
#ifndef TULLE_CONTACT_PAPER_RESPOND_BY_PAPER_H
#define TULLE_CONTACT_PAPER_RESPOND_BY_PAPER_H

#include "contact/solve/solve_motion.h"

/* In: u as for solve_motion. Out: u; the rows that are no contact by the paper's rule are dropped,
 * impulses of the others say what their vertices took; after. scene->paper gives the rules. */
tulle_status respond_by_paper(const contact_scene *scene, const motion_system *system,
                              row_list *list, double *u, solve_report *report);

/* Impact of what the rows from first_new on have found on the paths of u: changes u, the rows'
 * impulses and the states. */
tulle_status respond_to_impacts_by_paper(const contact_scene *scene, row_list *list,
                                         size_t first_new, double *u);

#endif
