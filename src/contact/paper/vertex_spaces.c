/* contact/paper/vertex_spaces.c - see vertex_spaces.h.
 *
 * A row keeps its features apart by a plane through the contact point: corners of the first feature
 * stay before it, those of the second behind it. With V the velocity of the sides together, a the
 * share of the relative velocity that a side takes and s >= 0 how far a corner lies from the plane
 * through its side's contact point, a corner of the first feature may move with
 *      n . u >= n . V + a bias - s / h,
 * where bias is the row's (contact_rows.c). Both sides at their limits move exactly as the row
 * asks.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 4. Departure: planes of polyhedral spaces move; theirs stand still (kind cone). */
#include "contact/paper/vertex_spaces.h"

#include "contact/rows/row_motion.h"

bool vertex_spaces_make(vertex_spaces *spaces, const contact_scene *scene, const row_list *list,
                        tulle_motion_space kind) {
    arena *const scratch = scene->scratch;
    size_t const row_count = list->rows.count, vertex_count = scene->cloth_vertex_count;
    *spaces = (vertex_spaces){.scene = scene, .list = list, .kind = kind};
    uint32_t *const begin = ARENA_NEW_ZEROED(scratch, uint32_t, vertex_count + 1);
    spaces->begin = begin;
    spaces->entries = ARENA_NEW(scratch, uint32_t, 4 * row_count);
    spaces->planes = ARENA_NEW(scratch, half_space, 4 * row_count);
    spaces->shared = ARENA_NEW(scratch, shared_motion, row_count);
    if (!begin || !spaces->entries || !spaces->planes || !spaces->shared) return false;
    uint32_t total = 0;
    for (size_t i = 0; i < row_count; i++)
        for (int k = 0; k < 4; k++) {
            uint32_t const vertex = list->rows.data[i].frame.vertices[k];
            if (vertex >= vertex_count || !(scene->inverse_mass[vertex] > 0.0)) continue;
            begin[vertex + 1]++;
            total++;
        }
    for (size_t i = 0; i < vertex_count; i++) begin[i + 1] += begin[i];
    /* filled from the back, so that begin[i + 1] ends where the entries of i begin */
    for (size_t i = row_count; i-- > 0;)
        for (int k = 3; k >= 0; k--) {
            uint32_t const vertex = list->rows.data[i].frame.vertices[k];
            if (vertex < vertex_count && scene->inverse_mass[vertex] > 0.0)
                spaces->entries[--begin[vertex + 1]] = (uint32_t)(4 * i) + (uint32_t)k;
        }
    for (size_t i = 0; i < vertex_count; i++) begin[i] = begin[i + 1];
    begin[vertex_count] = total;
    return true;
}

/* The weighted point of one side of a row in an array of vectors. */
static vec3 blend_side(const contact_row *row, int side, const double *array) {
    vec3 sum = {0.0, 0.0, 0.0};
    for (int k = 0; k < 4; k++)
        if (get_row_side(row, k) == side)
            sum = vec3_add_scaled(sum, vec3_load(array, row->frame.vertices[k]),
                                  fabs(row->frame.weights[k]));
    return sum;
}

void compute_shared_motions(vertex_spaces *spaces, const double *velocities) {
    for (size_t i = 0; i < spaces->list->rows.count; i++) {
        const contact_row *const row = &spaces->list->rows.data[i];
        double mobility[2] = {0.0, 0.0};
        for (int k = 0; k < 4; k++)
            mobility[get_row_side(row, k)] += row->frame.weights[k] * row->frame.weights[k] *
                                              spaces->scene->inverse_mass[row->frame.vertices[k]];
        double const share = mobility[0] / (mobility[0] + mobility[1]);
        spaces->shared[i] = (shared_motion){
            vec3_lerp(blend_side(row, 0, velocities), blend_side(row, 1, velocities), share),
            share};
    }
}

/* The half-space of a corner, seen from a frame that stands still. */
static half_space make_plane(const vertex_spaces *spaces, uint32_t entry, bool is_closed) {
    const contact_row *const row = &spaces->list->rows.data[entry / 4];
    int const corner = (int)(entry % 4);
    int const side = get_row_side(row, corner);
    bool const is_first = side == 0;
    vec3 const normal = is_first ? row->frame.normal : vec3_neg(row->frame.normal);
    if (spaces->kind == TULLE_MOTION_SPACE_CONE) return (half_space){normal, 0.0};
    const shared_motion *const shared = &spaces->shared[entry / 4];
    double const offset = vec3_dot(normal, shared->velocity);
    if (is_closed) return (half_space){normal, offset};
    const double *const x0 = spaces->scene->x0;
    vec3 const arm =
        vec3_sub(vec3_load(x0, row->frame.vertices[corner]), blend_side(row, side, x0));
    double const behind = fmax(vec3_dot(normal, arm), 0.0) / spaces->scene->time_step;
    double const share = is_first ? shared->first_share : 1.0 - shared->first_share;
    return (half_space){normal, offset + share * row->law.bias - behind};
}

vertex_space make_vertex_space(const vertex_spaces *spaces, uint32_t vertex, space_choice choice) {
    vertex_space result = {.reference = {0.0, 0.0, 0.0}};
    uint32_t const begin = spaces->begin[vertex];
    half_space *const planes = spaces->planes + begin;
    vec3 sum = {0.0, 0.0, 0.0};
    size_t count = 0;
    for (uint32_t i = begin; i < spaces->begin[vertex + 1]; i++) {
        uint32_t const entry = spaces->entries[i];
        const contact_row *const row = &spaces->list->rows.data[entry / 4];
        if (choice.filter && !choice.filter(choice.context, vertex, row)) continue;
        planes[count++] = make_plane(spaces, entry, choice.is_closed);
        sum = vec3_add(sum, spaces->shared[entry / 4].velocity);
    }
    if (spaces->kind == TULLE_MOTION_SPACE_POLYHEDRAL && count > 0) {
        result.reference = vec3_scale(sum, 1.0 / (double)count);
        for (size_t i = 0; i < count; i++)
            planes[i].offset -= vec3_dot(planes[i].normal, result.reference);
    }
    result.space = motion_space_make(spaces->kind, planes, count);
    return result;
}

const contact_row *find_pressed_row(const vertex_spaces *spaces, uint32_t vertex,
                                    const vertex_space *space, space_choice choice, vec3 velocity) {
    const contact_row *pressed = NULL;
    double largest = 0.0;
    size_t plane = 0;
    for (uint32_t i = spaces->begin[vertex]; i < spaces->begin[vertex + 1]; i++) {
        const contact_row *const row = &spaces->list->rows.data[spaces->entries[i] / 4];
        if (choice.filter && !choice.filter(choice.context, vertex, row)) continue;
        double const missing = measure_violation(&space->space.half_spaces[plane++], 1, velocity);
        if (missing <= largest) continue;
        largest = missing;
        pressed = row;
    }
    return pressed;
}
