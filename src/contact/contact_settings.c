/* contact/contact_settings.c - default numbers of the response, each with its reason. A world's def
 * begins with those of them that it has. */
#include "contact/contact_types.h"

const contact_settings default_contact_settings = {
    .minimum_gap = 1e-4,  /* far over the rounding of float files for scenes of metres */
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
};
