/* dynamics/bend.c - bending forces from the hinges' vectors c (see bending_matrix.c).
 *
 * Elastic: energy 1/2 sum_ij C_ij d_i . d_j with d = c - r n, r the rest value of c along the hinge
 * normal n. For a flat rest shape (r = 0) the force is linear in the positions. Otherwise the term
 * r n follows the hinge, as in Garg, Grinspun, Wardetzky, Zorin, Cubic shells, 2007; the force is
 * the exact gradient of the energy, so it keeps both momenta.
 * Damping: bend_damping.c. */
#include "dynamics/bend.h"

/* Sides folded onto each other have no hinge normal. Below this length of the sum of their unit
 * normals (fold angle above 174 degrees) curved rest shapes rest. */
static const double FOLDED_LIMIT = 0.1;

/* The hinge's normal is along a x m, with a the edge and m the difference of the corners' offsets
 * over twice the rest areas: the sum of the sides' unit normals where they keep their areas. */
typedef struct hinge_frame {
    vec3 edge, across; /* a [m], m [1/m] */
    double length;     /* |a x m| */
} hinge_frame;

static hinge_frame get_frame(const cloth_hinge *hinge, const cloth_hinge_rest *rest,
                             const double *positions, vec3 *normal) {
    vec3 const x0 = vec3_load(positions, hinge->vertices[0]);
    vec3 const left = vec3_sub(vec3_load(positions, hinge->vertices[2]), x0);
    vec3 const right = vec3_sub(vec3_load(positions, hinge->vertices[3]), x0);
    hinge_frame frame = {.edge = vec3_sub(vec3_load(positions, hinge->vertices[1]), x0)};
    frame.across = vec3_sub(vec3_scale(left, rest->inv_double_areas[0]),
                            vec3_scale(right, rest->inv_double_areas[1]));
    vec3 const sum = vec3_cross(frame.edge, frame.across);
    frame.length = vec3_norm(sum);
    bool const is_folded = !(frame.length > FOLDED_LIMIT);
    *normal = is_folded ? (vec3){0.0, 0.0, 0.0} : vec3_scale(sum, 1.0 / frame.length);
    return frame;
}

/* Adds r (dn/dx_k)^T y to each corner: the gradient of r n . y at fixed y, r the curvature. */
static void add_normal_gradient(const cloth_hinge_rest *rest, const hinge_frame *frame, vec3 normal,
                                vec3 y, vec3 corners[4]) {
    vec3 const tangential = vec3_scale(vec3_add_scaled(y, normal, -vec3_dot(normal, y)),
                                       rest->curvature / frame->length);
    vec3 const by_edge = vec3_cross(frame->across, tangential);
    vec3 const by_across = vec3_cross(tangential, frame->edge);
    vec3 const by_left = vec3_scale(by_across, rest->inv_double_areas[0]);
    vec3 const by_right = vec3_scale(by_across, -rest->inv_double_areas[1]);
    corners[1] = vec3_add(corners[1], by_edge);
    corners[2] = vec3_add(corners[2], by_left);
    corners[3] = vec3_add(corners[3], by_right);
    corners[0] = vec3_sub(corners[0], vec3_add(by_edge, vec3_add(by_left, by_right)));
}

vec3 bend_get_deviation(const cloth_model *model, size_t number, const double *positions) {
    const cloth_hinge *const hinge = &model->hinges[number];
    /* Weights sum to zero: offsets from the first corner keep rounding small far from the origin.
     */
    vec3 const origin = vec3_load(positions, hinge->vertices[0]);
    vec3 c = {0.0, 0.0, 0.0}, normal;
    for (int k = 1; k < 4; k++)
        c = vec3_add_scaled(c, vec3_sub(vec3_load(positions, hinge->vertices[k]), origin),
                            hinge->weights[k]);
    if (!model->hinge_rests || model->hinge_rests[number].curvature == 0.0) return c;
    get_frame(hinge, &model->hinge_rests[number], positions, &normal);
    return vec3_add_scaled(c, normal, -model->hinge_rests[number].curvature);
}

void bend_get_forces(const cloth_model *model, size_t number, const double *positions,
                     hinge_moments moments, vec3 forces[4]) {
    const cloth_hinge *const hinge = &model->hinges[number];
    const cloth_hinge_rest *const rest = &model->hinge_rests[number];
    vec3 const all = vec3_add(moments.elastic, moments.damping);
    for (size_t k = 0; k < 4; k++) forces[k] = bend_get_flat_force(hinge, k, all);
    if (rest->curvature == 0.0) return;
    vec3 normal;
    hinge_frame const frame = get_frame(hinge, rest, positions, &normal);
    if (vec3_norm2(normal) == 0.0) return;
    add_normal_gradient(rest, &frame, normal, moments.elastic, forces);
}
