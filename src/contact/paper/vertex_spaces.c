/* contact/paper/vertex_spaces.c - see vertex_spaces.h.
 *
 * A row keeps its features apart by a plane through the contact point: corners of the first feature
 * stay before it, those of the second behind it. A corner of the first feature may move with
 *      n . u >= n . V + a bias - s / h.
 * V is the velocity of both sides together, and a the share of the relative velocity that the side
 * takes. bias is the row's (contact_rows.c). s >= 0 is how far the corner lies from the plane
 * through the contact point of its side. If both sides are at their limits they move exactly as the
 * row asks.
 *
 * Based on: Wong, Baciu, Dynamic interaction between deformable surfaces and nonsmooth objects,
 * 2005, section 4. Departure: planes of polyhedral spaces move. The paper's stand still, as do
 * those of the kind cone. */
#include "contact/paper/vertex_spaces.h"

#include "contact/rows/row_motion.h"

/* The weighted sum of an array of vectors over one side of a row. */
static vec3 blend_side(const contact_row *row, int side, const double *array) {
    vec3 sum = {0.0, 0.0, 0.0};
    for (int k = 0; k < 4; k++)
        if (get_row_side(row, k) == side)
            sum = vec3_add_scaled(sum, vec3_load(array, row->frame.vertices[k]),
                                  fabs(row->frame.weights[k]));
    return sum;
}

bool vertex_spaces_make(vertex_spaces *spaces, const contact_scene *scene, const row_list *list,
                        const double *velocities) {
    arena *const scratch = scene->scratch;
    size_t const row_count = list->rows.count, vertex_count = scene->cloth_vertex_count;
    *spaces = (vertex_spaces){.scene = scene, .list = list, .kind = scene->paper->motion_space};
    uint32_t *const begin = ARENA_NEW_ZEROED(scratch, uint32_t, vertex_count + 1);
    spaces->begin = begin;
    spaces->entries = ARENA_NEW(scratch, uint32_t, 4 * row_count);
    spaces->planes = ARENA_NEW(scratch, half_space, 4 * row_count);
    spaces->shared = ARENA_NEW(scratch, shared_motion, row_count);
    if (!begin || !spaces->entries || !spaces->planes || !spaces->shared) return false;
    /* the entries of each vertex: counted, then placed */
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
    for (size_t i = 0; i < row_count; i++) {
        const contact_row *const row = &list->rows.data[i];
        double mobility[2] = {0.0, 0.0};
        for (int k = 0; k < 4; k++)
            mobility[get_row_side(row, k)] += row->frame.weights[k] * row->frame.weights[k] *
                                              scene->inverse_mass[row->frame.vertices[k]];
        double const share = mobility[0] / (mobility[0] + mobility[1]);
        vec3 const first = blend_side(row, 0, velocities), second = blend_side(row, 1, velocities);
        spaces->shared[i] = (shared_motion){vec3_lerp(first, second, share), share};
    }
    return true;
}

vertex_space make_vertex_space(const vertex_spaces *spaces, uint32_t vertex, space_choice choice) {
    vertex_space result = {.reference = {0.0, 0.0, 0.0}};
    uint32_t const begin = spaces->begin[vertex];
    half_space *const planes = spaces->planes + begin;
    const double *const x0 = spaces->scene->x0;
    vec3 sum = {0.0, 0.0, 0.0};
    size_t count = 0;
    for (uint32_t i = begin; i < spaces->begin[vertex + 1]; i++) {
        uint32_t const entry = spaces->entries[i];
        const contact_row *const row = &spaces->list->rows.data[entry / 4];
        if (choice.filter && !choice.filter(choice.context, vertex, row)) continue;
        const shared_motion *const shared = &spaces->shared[entry / 4];
        sum = vec3_add(sum, shared->velocity);
        /* the plane as seen from a frame that stands still */
        int const side = get_row_side(row, (int)(entry % 4));
        half_space *const plane = &planes[count++];
        plane->normal = side == 0 ? row->frame.normal : vec3_neg(row->frame.normal);
        plane->offset = 0.0;
        if (spaces->kind == TULLE_MOTION_SPACE_CONE) continue;
        plane->offset = vec3_dot(plane->normal, shared->velocity);
        if (choice.is_closed) continue;
        vec3 const arm = vec3_sub(vec3_load(x0, vertex), blend_side(row, side, x0));
        double const behind = fmax(vec3_dot(plane->normal, arm), 0.0) / spaces->scene->time_step;
        double const share = side == 0 ? shared->first_share : 1.0 - shared->first_share;
        plane->offset = plane->offset + share * row->law.bias - behind;
    }
    /* ... and as seen from the frame of what the vertex touches */
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
        double const missing =
            measure_missing(&space->space.half_spaces[plane++], OFFSETS_AS_GIVEN, velocity);
        if (missing <= largest) continue;
        largest = missing;
        pressed = row;
    }
    return pressed;
}
