/* contact/contact_settings.c - default numbers of the response, each with its reason. A world's def
 * begins with those of them that it has. */
#include "contact/contact_types.h"

/* Solves of small cloth take some 30 iterations; with a patience of 16 it creeps where it should
 * stick. A larger factor damps flutter. A looseness of 4.5 slows sliding cloth by half a percent,
 * 10 by one and a half. */
const solve_effort solve_efforts[] = {
    [TULLE_QUALITY_DRAFT] = {100.0, 16, 0, 100.0, 0.1},
    /* 100 times lets a loop of silk hang 1.2 % too high and damps a swing by Crank-Nicolson */
    [TULLE_QUALITY_NORMAL] = {30.0, 48, 32, 4.5, 0.01},
    [TULLE_QUALITY_EXACT] = {0.0, 0, 32, 1.0, 0.0},
};

const contact_settings default_contact_settings = {
    .minimum_gap = 1e-4, /* far over the rounding of float files for scenes of metres */
    .solve_rounds = 1,
    .solve_rounds_landing = 6,
    .impulse_sweeps = 10, /* twenty measured no better */
    .impact_rounds = 5,
    .zone_rounds = 2,
    .component_rounds = 12,
    .push_out_speed = 0.05,     /* [m/s] slow against any motion one sees */
    .slope_tolerance = 0.02,    /* about one degree: flat stays flat in spite of rounding */
    .old_slope_tolerance = 0.3, /* 17 degrees: with 0.02 a third of the rows of three sheets at
                                   rest came and went in every step; 0.1 does as well */
    .slip_speed = 1e-3,         /* far over what held cloth moves, far below what one sees */
    .settled_speed = 1e-3,      /* a hundredth of what gravity gives in a step */
    .settled_drift = 1e-5, /* a patch half a degree over its critical angle gains 1e-3 a step */
    .settled_slip = 1e-4,  /* more than a step's slip at rest: anchors take that back in a second */
    .settled_misfit = 3e-3,   /* 0.1 lets one vertex of a belt that stops stay behind */
    .settled_most = 0.03,     /* 0.3 mm a step, a tenth of a contact distance */
    .hard_stiffness = 10.0,   /* 3 lets fine cloth on tips tear away, with rescues */
    .push_out_softness = 0.1, /* none lets the impulses of a pinch grow until it bursts */
    .anchor_share = 0.3,      /* 0.05 to 1 do as well; more takes offsets for pulls */
    .hard_friction = 1.0,     /* 0.1 holds as well and lets more slip in a round */
    .effort = &solve_efforts[TULLE_QUALITY_NORMAL],
    .cg_tolerance = 1e-4,      /* 1e-3 in all solves falsifies sliding by a tenth */
    .cg_max_iterations = 5000, /* a bound on time, far over what a solve takes */
};
