/* contact/response.h - the two responses of contact, as tables of their differences. The world and
 * a step never ask which response it is: they call the functions of the table, which are never
 * null, and each bool answers one question.
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
                                 const solve_plan *plan, row_list *list, double *u,
                                 solve_report *report);
    /* Stage 8: changes u, impulses and states, after rows were added for impacts on the paths of u.
     * These are the rows from first_new on. */
    tulle_status (*answer_impacts)(const contact_scene *scene, row_list *list, size_t first_new,
                                   double *u);
    /* Stage 10: marks cloth vertices whose velocity at the end is u itself, whatever the integrator
     * says. is_plain: cloth_vertex_count entries; marks that are already set stay set. */
    void (*mark_plain_ends)(const contact_scene *scene, const row_list *list, uint8_t *is_plain);
    /* Stage 10: makes the velocities at the end obey the laws of impact, see end_velocities.h.
     * Called for whole substeps. */
    tulle_status (*end_contacts)(const contact_scene *scene, row_list *list, const double *u,
                                 double *v1, end_velocities *ends);
    /* Stage 10: keeps facts of the accepted paths x0 -> x1 for the next step, in the rows and in
     * scene->paper. */
    void (*keep_contacts)(const contact_scene *scene, const double *x1, row_list *list);
    /* Energy is balanced: a substep by implicit Euler is solved again when it gains energy, and a
     * rebound gives no more than there is. This needs contacts that keep momentum. */
    bool balances_energy;
    /* The first solves of a substep are rough, because others follow. */
    bool begins_roughly;
    /* If a solution stretches springs by much more energy than the linear system predicts, springs
     * are linearised about it and it is solved again. */
    bool linearises_again;
    /* The solve takes the forces at the start of the step by themselves. */
    bool needs_forces;
    /* Springs stay linear, whatever the material says. Where a substep has one solve, cloth that
     * stiffens would tear. */
    bool has_linear_springs;
    /* Contact may add energy again and again. So edges are tested before a motion is accepted, and
     * torn cloth fails the step. */
    bool may_tear_cloth;
    /* Rows are fitted to obstacles: they take the normal of the obstacle's surface, turn to the end
     * of the step, and are dropped if a nearer row hides them. If false, a row keeps the normal
     * between the features that are nearest. */
    bool fits_rows;
    bool moves_bodies;    /* rigid bodies can answer */
    bool keeps_particles; /* scene->paper is read and written */
};

extern const contact_response coupled_response; /* solve/coupled_response.c */
extern const contact_response paper_response;   /* paper/paper_response.c */

/* By tulle_response. */
static const contact_response *const contact_responses[] = {&coupled_response, &paper_response};

#endif
