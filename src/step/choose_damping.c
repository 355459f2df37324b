/* step/choose_damping.c - how far a step goes from its integrator towards implicit Euler.
 *
 * Crank-Nicolson turns the sign of modes that the step does not resolve, and BDF2 continues with
 * velocities from before an impact. So a step with an impact is one of implicit Euler, which also
 * stops the cloth that hangs on the vertex that hit; the next step takes no history from it.
 * Impulses that have not settled excite modes that the step does not resolve, so steps with contact
 * are damped. Free steps of Crank-Nicolson are damped a little. The damping is a rate times the
 * step, so the order without impacts stays two. It is the same for all vertices: linear momentum is
 * kept.
 *
 * Takes rows as gathered and velocities at the start; gives force_options.damping. The numerical
 * damping of free motion is computed here, too. */
#include "step/choose_damping.h"
#include "contact/solve/end_velocities.h"

#include <math.h>

/* [1/s] Least rates with which cloth that hangs free gains no energy at steps of 1/90 s. */
static const double FREE_RATES[] = {[TULLE_INTEGRATOR_IMPLICIT_EULER] = 0.0,
                                    [TULLE_INTEGRATOR_CRANK_NICOLSON] = 10.0,
                                    [TULLE_INTEGRATOR_BDF2] = 0.0};
/* [1/s] With this rate cloth on needles comes to rest about as well as by implicit Euler. */
static const double CONTACT_RATE = 40.0;

double step_choose_damping(const step_model *model, step_work *work) {
    tulle_integrator const integrator = model->def.integrator;
    if (integrator == TULLE_INTEGRATOR_IMPLICIT_EULER) return 0.0;
    const row_list *const list = &work->rows;
    for (size_t i = 0; i < list->rows.count; i++) {
        const contact_row *const row = &list->rows.data[i];
        bool const is_faster = row->law.approach + row->law.fall < row->law.bias;
        if (is_faster && row_is_impact(&work->sub.scene, row)) return 1.0;
    }
    double rate = FREE_RATES[integrator];
    if (work->rows.rows.count > 0) rate = CONTACT_RATE;
    return fmin(rate * work->sub.time_step, 1.0);
}

/* ---- the damping of free motion ---- */

/* By what a step multiplies x + i v / omega of a motion that turns by omega h in it. */
typedef struct amplification {
    double size, angle;
} amplification;

/* `share` is c of docs/method/integrators.md. */
static amplification find_amplification(tulle_integrator integrator, double share, double turn) {
    double const next = share * turn, rest = 1.0 - share;
    if (integrator != TULLE_INTEGRATOR_BDF2)
        return (amplification){hypot(1.0, rest * turn) / hypot(1.0, next),
                               atan(rest * turn) + atan(next)};
    /* The root of (1 - i c turn) z^2 - (2 - c) z + 1 - c that is 1 where nothing turns. */
    double const real = share * share, imaginary = 4.0 * rest * next;
    double const root = sqrt(0.5 * (hypot(real, imaginary) + real));
    double const sum = 2.0 - share + root, part = 0.5 * imaginary / root;
    return (amplification){0.5 * hypot(sum, part) / hypot(1.0, next),
                           atan2(part, sum) + atan(next)};
}

double measure_numerical_damping(tulle_integrator integrator, double time_step, double period) {
    static double const most_turn = 1e9; /* so that nothing overflows */
    double const damping = fmin(FREE_RATES[integrator] * time_step, 1.0);
    double share = 1.0;
    if (integrator == TULLE_INTEGRATOR_CRANK_NICOLSON) share = 0.5 + 0.5 * damping;
    if (integrator == TULLE_INTEGRATOR_BDF2) share = (2.0 + damping) / 3.0;
    double const turn = fmin(2.0 * 3.14159265358979323846 * time_step / period, most_turn);
    amplification const factor = find_amplification(integrator, share, turn);
    double const loss = fmax(-log(factor.size), 0.0);
    return loss / hypot(loss, factor.angle);
}
