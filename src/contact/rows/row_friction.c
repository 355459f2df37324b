/* contact/rows/row_friction.c - see row_friction.h.
 *
 * Static or dynamic: a contact slides if it slips faster than slip_speed at the start of the step.
 * The dynamic coefficient bounds its friction; the static one bounds that of all others. The bound
 * holds for the whole step. If friction can stop a sliding contact within the step, it does, and
 * the contact sticks from the next step on. In a patch that is held some rows yield a little while
 * load moves to their neighbours. They are far slower than slip_speed, so they keep the static
 * bound, and the patch keeps its sum.
 *
 * Grain: the bound is an ellipse with the axes mu along the grain and mu times a factor across it.
 * The grain goes with the deformed triangle. Where both sides have one, the logarithms of their
 * tensors add, so factors multiply where grains agree.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, 5.2 (sticking and sliding contacts); Moreau 1988 (slip along the normal of the bound's
 * edge, the rule of largest dissipation). Departure: the paper decides by forces before the solve
 * whether friction stops the slip; here the solve itself decides. */
#include "contact/rows/row_friction.h"

#include "contact/pairs/pair_rules.h"
#include "contact/rows/row_motion.h"

/* Most Newton steps for the nearest point of an ellipse. They start below the root and rise to it.
 */
enum { ELLIPSE_STEPS = 60 };
/* Where two grains meet, smaller factors count as this, so that they have a logarithm. */
static const double LEAST_FACTOR = 1e-6;
/* A grain nearer to the normal than this sine has no direction in the tangent plane. */
static const double LEAST_GRAIN = 1e-6;

/* A tensor of the tangent plane: 1 + (factor - 1) across across^T. */
typedef struct grain_tensor {
    vec3 across; /* unit */
    double factor;
} grain_tensor;

/* The tensor of one side, of `count` vertices from `first` on; false when it has no grain. The
 * grain is the sum, over the triangles that have all of these vertices, of the images of the rest
 * direction under the triangle's deformation from rest to x0. */
static bool make_tensor(const contact_scene *scene, const contact_row *row, int first, int count,
                        grain_tensor *tensor) {
    const topology *const topo = scene->set->topo;
    const adjacency *const around = &topo->vertex_triangles;
    const uint32_t *const vertices = row->frame.vertices + first;
    const surface_grain *const grain = &scene->grains[scene->vertex_surface[vertices[0]]];
    if (grain->across == 1.0) return false;
    vec3 carried = {0.0, 0.0, 0.0};
    for (uint32_t i = around->begin[vertices[0]]; i < around->begin[vertices[0] + 1]; i++) {
        const uint32_t *const corner = topo->triangles + 3 * (size_t)around->items[i];
        bool has_all = true;
        for (int k = 1; k < count; k++)
            has_all &=
                corner[0] == vertices[k] || corner[1] == vertices[k] || corner[2] == vertices[k];
        vec3 const origin = vec3_load(scene->rest, corner[0]);
        vec3 const a = vec3_sub(vec3_load(scene->rest, corner[1]), origin);
        vec3 const b = vec3_sub(vec3_load(scene->rest, corner[2]), origin);
        double const aa = vec3_norm2(a), ab = vec3_dot(a, b), bb = vec3_norm2(b);
        double const determinant = aa * bb - ab * ab;
        if (!has_all || !(determinant > 0.0)) continue;
        /* the direction in the plane of the triangle is s a + t b */
        double const ga = vec3_dot(grain->direction, a), gb = vec3_dot(grain->direction, b);
        double const s = (bb * ga - ab * gb) / determinant, t = (aa * gb - ab * ga) / determinant;
        vec3 const base = vec3_load(scene->x0, corner[0]);
        carried = vec3_add_scaled(carried, vec3_sub(vec3_load(scene->x0, corner[1]), base), s);
        carried = vec3_add_scaled(carried, vec3_sub(vec3_load(scene->x0, corner[2]), base), t);
    }
    vec3 const across = vec3_cross(row->frame.normal, carried);
    double const size = vec3_norm(across);
    if (!(size > LEAST_GRAIN * vec3_norm(carried))) return false;
    *tensor = (grain_tensor){vec3_scale(across, 1.0 / size), grain->across};
    return true;
}

void set_row_friction(const contact_scene *scene, contact_row *row) {
    row_law *const law = &row->law;
    const contact_law *const given = get_contact_law(scene, row->frame.vertices);
    vec3 const velocity =
        scene->v0 ? get_relative_velocity(row, scene->v0) : vec3_make(0.0, 0.0, 0.0);
    law->approach = vec3_dot(velocity, row->frame.normal);
    /* gravity pulls vertices with mass, and the bodies of both sides */
    double const pull = vec3_dot(row->frame.normal, scene->gravity);
    law->fall = 0.0;
    for (int k = 0; k < 4; k++)
        if (scene->inverse_mass[row->frame.vertices[k]] > 0.0)
            law->fall += scene->time_step * row->frame.weights[k] * pull;
    for (int side = 0; side < 2 && row->frame.has_body; side++) {
        const contact_body *const body = find_side_body(scene, row, side);
        if (!body) continue;
        double const damping = body->body->linear_damping;
        vec3 own = vec3_add_scaled(scene->gravity, body->start.velocity, -damping);
        if (body->drive) own = mask_locked(body->drive, own);
        law->fall += scene->time_step * (side == 0 ? 1.0 : -1.0) *
                     vec3_dot(row->frame.normal, own) / (1.0 + scene->time_step * damping);
    }
    vec3 const slip = vec3_add_scaled(velocity, row->frame.normal, -law->approach);
    law->restitution = given->restitution;
    law->is_sliding = vec3_norm(slip) > scene->settings.slip_speed;
    law->friction = law->is_sliding ? given->dynamic_friction : given->static_friction;
    law->friction_along = law->friction_across = 1.0;
    if (!scene->grains) return;
    int const first_count = row->frame.kind == FEATURE_VERTEX_TRIANGLE ? 1 : 2;
    grain_tensor tensors[2];
    int count = make_tensor(scene, row, 0, first_count, &tensors[0]);
    count += make_tensor(scene, row, first_count, 4 - first_count, &tensors[count]);
    if (count == 0) return;
    vec3 const across = tensors[0].across, along = vec3_cross(across, row->frame.normal);
    if (count == 1) {
        law->grain = along;
        law->friction_across = tensors[0].factor;
        return;
    }
    /* Two tensors meet: the principal axes of the sum of their logarithms. x is across the first
     * grain, y along it. */
    double const p = log(fmax(tensors[0].factor, LEAST_FACTOR));
    double const q = log(fmax(tensors[1].factor, LEAST_FACTOR));
    double const c = vec3_dot(tensors[1].across, across), s = vec3_dot(tensors[1].across, along);
    double const xx = p + q * c * c, xy = q * c * s, yy = q * s * s;
    double const middle = 0.5 * (xx + yy), difference = 0.5 * (xx - yy);
    double const half = sqrt(difference * difference + xy * xy);
    double const angle = 0.5 * atan2(2.0 * xy, xx - yy);
    vec3 const major = vec3_add_scaled(vec3_scale(across, cos(angle)), along, sin(angle));
    law->grain = vec3_cross(major, row->frame.normal);
    law->friction_across = exp(middle + half);
    law->friction_along = exp(middle - half);
}

/* (x, y) outside of the ellipse with half axes a and b becomes its nearest point
 * (a^2 x / (a^2 + t), b^2 y / (b^2 + t)): t > 0 makes it lie on the ellipse. */
static void project_on_ellipse(const double axes[2], double point[2]) {
    double t = 0.0, near[2] = {0.0, 0.0};
    for (int k = 0; k < 2; k++) t = fmax(t, axes[k] * (fabs(point[k]) - axes[k]));
    for (int step = 0; step < ELLIPSE_STEPS; step++) {
        double value = -1.0, slope = 0.0; /* of the ellipse's equation in t */
        for (int k = 0; k < 2; k++) {
            double const square = axes[k] * axes[k];
            near[k] = 0.0;
            if (!(square + t > 0.0)) continue;
            double const part = axes[k] * point[k] / (square + t);
            value += part * part;
            slope -= 2.0 * part * part / (square + t);
            near[k] = square * point[k] / (square + t);
        }
        if (!(value > 1e-15) || !(slope < 0.0)) break;
        double const next = t - value / slope;
        if (!(next > t)) break;
        t = next;
    }
    point[0] = near[0];
    point[1] = near[1];
}

vec3 limit_friction(const contact_row *row, double normal, vec3 tangential, bool *is_inside) {
    const row_law *const law = &row->law;
    double const cap = law->friction * normal;
    if (law->friction_along == law->friction_across) {
        double const size = vec3_norm(tangential), limit = cap * law->friction_along;
        *is_inside = !(size > limit);
        return *is_inside ? tangential : vec3_scale(tangential, limit / size);
    }
    vec3 const across = vec3_cross(row->frame.normal, law->grain);
    const double axes[2] = {cap * law->friction_along, cap * law->friction_across};
    double point[2] = {vec3_dot(tangential, law->grain), vec3_dot(tangential, across)};
    double const a = axes[0], b = axes[1], x = point[0], y = point[1];
    *is_inside = b * b * x * x + a * a * y * y <= a * a * b * b && fabs(x) <= a && fabs(y) <= b;
    if (*is_inside) return tangential;
    project_on_ellipse(axes, point);
    return vec3_add_scaled(vec3_scale(law->grain, point[0]), across, point[1]);
}

/* r / (r + d): r the radius of curvature of the bound at the point, d the distance to the trial. */
double measure_bound_follow(const contact_row *row, double normal, vec3 friction, vec3 trial) {
    double const distance = vec3_norm(vec3_sub(trial, friction));
    double radius = vec3_norm(friction);
    if (row->law.friction_along != row->law.friction_across) {
        double const cap = row->law.friction * normal;
        double const a = cap * row->law.friction_along, b = cap * row->law.friction_across;
        double const x = vec3_dot(friction, row->law.grain);
        double const y = vec3_dot(friction, vec3_cross(row->frame.normal, row->law.grain));
        if (!(a > 0.0)) return fabs(y) < b ? 1.0 : 0.0; /* a segment */
        if (!(b > 0.0)) return fabs(x) < a ? 1.0 : 0.0;
        double const steep_x = x / (a * a), steep_y = y / (b * b);
        double const slope = sqrt(steep_x * steep_x + steep_y * steep_y);
        radius = a * a * b * b * slope * slope * slope;
    }
    return radius + distance > 0.0 ? radius / (radius + distance) : 0.0;
}
