/* contact/response.h - the two ways in which contact answers, as tables of what differs between
 * them. A step calls the functions of its scene's table and never asks which one it is.
 *
 * coupled: one solve finds the impulses of all rows and the motion of all cloth and bodies.
 * paper: forces and velocities of each vertex are projected on its motion space, for comparison. */
#ifndef TULLE_CONTACT_RESPONSE_H
#define TULLE_CONTACT_RESPONSE_H

#include "contact/solve/end_velocities.h"
#include "contact/solve/solve_motion.h"

struct contact_response {
    /* Stage 7: finds u and the rows' impulses, see solve_motion.h. */
    tulle_status (*solve_motion)(const contact_scene *scene, const motion_system *system,
                                 row_list *list, double *u, solve_report *report);
    /* Stage 8: changes u, impulses and states, after rows were added for impacts on the paths of u.
     * These are the rows from first_new on. */
    tulle_status (*answer_impacts)(const contact_scene *scene, row_list *list, size_t first_new,
                                   double *u);
    /* Stage 10: marks cloth vertices whose velocity at the end is u itself, whatever the integrator
     * says. is_plain: cloth_vertex_count entries; marks that are already set stay set. Null: every
     * vertex ends as the integrator says. */
    void (*mark_plain_ends)(const contact_scene *scene, const row_list *list, uint8_t *is_plain);
    /* Stage 10: applies the laws of impact to the velocities at the end, see end_velocities.h.
     * Null: u obeys them already. */
    tulle_status (*end_contacts)(const contact_scene *scene, row_list *list, const double *u,
                                 double *v1, end_velocities *ends);
    /* Stage 10: keeps what the next step needs to know of the accepted paths x0 -> x1, in the rows
     * and in scene->paper. */
    void (*keep_contacts)(const contact_scene *scene, const double *x1, row_list *list);
    /* What one side of a contact loses the other one gains. So energy can be balanced, and solves
     * are repeated until the springs agree and no energy is gained. If false, a step has one solve,
     * the springs are linear, and contact may tear cloth. */
    bool keeps_momentum;
    /* Rows are fitted to obstacles: they take the normal of the obstacle's surface, turn to the end
     * of the step, and are dropped where a nearer row hides them. If false, a row keeps the normal
     * between the features that are nearest. */
    bool fits_rows;
    bool moves_bodies;    /* rigid bodies can answer */
    bool keeps_particles; /* scene->paper is read and written */
};

extern const contact_response coupled_response; /* solve/coupled_response.c */
extern const contact_response paper_response;   /* paper/paper_response.c */

static inline const contact_response *get_response(tulle_response kind) {
    return kind == TULLE_RESPONSE_PAPER ? &paper_response : &coupled_response;
}

#endif
