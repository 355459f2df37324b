/* world/step/choose_damping.c - how far a step goes from its integrator towards implicit Euler.
 *
 * Crank-Nicolson turns the sign of modes that the step does not resolve, and BDF2 goes on with
 * velocities from before an impact. So a step with an impact is one of implicit Euler, which also
 * stops what hangs on the vertex that hit; the next step takes no history from it. Impulses that
 * have not settled excite modes that the step does not resolve, so steps with contact are damped.
 * Free steps of Crank-Nicolson are damped a little. The damping is a rate times the step, so the
 * order without impacts stays two. It is the same for all vertices: linear momentum is kept.
 *
 * Takes rows as gathered and velocities at the start; gives force_options.damping. */
#include "contact/solve/end_velocities.h"
#include "world/step/step.h"

#include <math.h>

/* [1/s] Least rate with which cloth that hangs free gains no energy at steps of 1/90 s. */
static const double FREE_RATE = 10.0;
/* [1/s] With this rate cloth on needles comes to rest about as well as by implicit Euler. */
static const double CONTACT_RATE = 40.0;

double world_choose_damping(const step_context *context) {
    const tulle_world *const world = context->world;
    tulle_integrator const integrator = world->def.integrator;
    if (integrator == TULLE_INTEGRATOR_IMPLICIT_EULER) return 0.0;
    const row_list *const list = &world->rows;
    for (size_t i = 0; i < list->rows.count; i++) {
        const contact_row *const row = &list->rows.data[i];
        bool const is_faster = row->law.approach + row->law.fall < row->law.bias;
        if (is_faster && row_is_impact(&context->scene, row)) return 1.0;
    }
    double rate = integrator == TULLE_INTEGRATOR_CRANK_NICOLSON ? FREE_RATE : 0.0;
    if (world->rows.rows.count > 0) rate = CONTACT_RATE;
    return fmin(rate * context->time_step, 1.0);
}
