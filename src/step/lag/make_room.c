/* step/lag/make_room.c - see room.h: how lagging surfaces give way at places that lack room. */
#include "step/lag/lag.h"
#include "step/lag/room.h"

#include <math.h>
#include <string.h>

/* [contact distances] A place that lacks less room has it. */
static const double ROOM_TOLERANCE = 1e-3;
/* [contact distances] What gives way with a point. */
static const double GIVING_RADIUS = 40.0;
/* Sweeps over all places, at most, in which a surface gives way around them; in which it does not.
 */
enum { WIDE_SWEEPS = 16, NARROW_SWEEPS = 100 };
/* A vertex of the side itself always goes along, by this part at least. */
static const double OWN_PART_MIN = 1e-3;

/* What goes along when a point of a surface gives way: what is within a way along its edges. The
 * arrays have room for all vertices. */
typedef struct giving {
    const step_model *model;
    const step_work *work;
    const double *starts; /* [m] all vertices before anything gave way */
    double *ends;         /* [m] all vertices */
    vec3 *shifts;         /* [m] per surface: of what is rigid, which is not in `ends` yet */
    double radius;        /* [m] */
    double *lengths;    /* [m] along edges to the point; INFINITY, but while one is looked around */
    uint32_t *queue;    /* ring of vertices whose neighbours are next */
    uint8_t *waits;     /* is in the ring */
    uint32_t *vertices; /* `count` that go along */
    double *parts;      /* of the way, up to 1; in the order of `vertices` */
    size_t count;
} giving;

/* Finds the vertices within the radius of the side's point, and the ways to them. */
static void search_surface(giving *self, const room_side *side) {
    const double *const x = self->work->start->positions;
    const adjacency *const next = &self->model->topo.vertex_neighbours;
    size_t const capacity = self->model->vertex_count;
    vec3 const centre = get_side_point(side, x);
    size_t first = 0, waiting = 0;
    self->count = 0;
    for (int k = 0; k < 3; k++) {
        uint32_t const v = side->vertices[k];
        if (self->waits[v]) continue;
        self->lengths[v] = vec3_norm(vec3_sub(vec3_load(x, v), centre));
        self->waits[v] = 1;
        self->vertices[self->count++] = v;
        self->queue[waiting++] = v;
    }
    while (waiting > 0) {
        uint32_t const v = self->queue[first];
        first = (first + 1) % capacity;
        waiting--;
        self->waits[v] = 0;
        for (uint32_t k = next->begin[v]; k < next->begin[v + 1]; k++) {
            uint32_t const w = next->items[k];
            double const edge = vec3_norm(vec3_sub(vec3_load(x, w), vec3_load(x, v)));
            double const length = self->lengths[v] + edge;
            if (!(length < self->radius) || !(length < self->lengths[w])) continue;
            if (isinf(self->lengths[w])) self->vertices[self->count++] = w;
            self->lengths[w] = length;
            if (self->waits[w]) continue;
            self->waits[w] = 1;
            self->queue[(first + waiting++) % capacity] = w;
        }
    }
}

/* Finds what goes along with a side, and returns how far its point goes when it is moved by 1.
 * Where the surface leads from it to the other side, each takes half of the way between. */
static double look_around(giving *self, const room_side *side, const room_side *other) {
    search_surface(self, side);
    double reach = self->radius;
    for (int k = 0; k < 3; k++) reach = fmin(reach, 0.5 * self->lengths[other->vertices[k]]);
    size_t const found = self->count;
    double answer = 0.0;
    self->count = 0;
    for (size_t i = 0; i < found; i++) {
        uint32_t const v = self->vertices[i];
        double const share = reach > 0.0 ? self->lengths[v] / reach : 1.0;
        double const left = fmax(0.0, 1.0 - share * share);
        double part = left * left;
        self->lengths[v] = (double)INFINITY;
        for (int k = 0; k < 3; k++)
            if (side->vertices[k] == v) part = fmax(part, OWN_PART_MIN);
        if (!(part > 0.0)) continue;
        for (int k = 0; k < 3; k++)
            if (side->vertices[k] == v) answer += side->weights[k] * part;
        self->vertices[self->count] = v;
        self->parts[self->count++] = part;
    }
    return answer;
}

/* [m] */
static vec3 get_end(const giving *self, const room_side *side) {
    return vec3_add(get_side_point(side, self->ends),
                    self->shifts[self->model->vertex_surface[side->vertices[0]]]);
}

/* Takes a side `missing` [m] farther along a direction. What is around it follows by its part, but
 * not where it has gone so far already: what many sides take along goes no farther than the one
 * that takes it farthest. */
static void take_along(giving *self, const room_side *side, const room_side *other, vec3 direction,
                       double missing) {
    size_t const surface = self->model->vertex_surface[side->vertices[0]];
    vec3 *const shift = &self->shifts[surface];
    if (!step_deforms(self->model, surface - self->model->cloths.count)) {
        *shift = vec3_add_scaled(*shift, direction, missing);
        return;
    }
    double const answer = look_around(self, side, other);
    vec3 const way = vec3_sub(get_side_point(side, self->ends), get_side_point(side, self->starts));
    double const wanted = fmax(vec3_dot(direction, way), 0.0) + missing;
    for (size_t i = 0; i < self->count; i++) {
        uint32_t const v = self->vertices[i];
        vec3 const end = vec3_load(self->ends, v);
        vec3 const gone = vec3_sub(end, vec3_load(self->starts, v));
        double const lacks = wanted * self->parts[i] / answer - vec3_dot(direction, gone);
        if (lacks > 0.0) vec3_store(self->ends, v, vec3_add_scaled(end, direction, lacks));
    }
}

/* Gives all places that lack room what they lack. False when none did. */
static bool sweep_places(giving *self, const room_list *places, double tolerance) {
    bool has_given = false;
    for (size_t i = 0; i < places->count; i++) {
        const room_place *const place = &places->data[i];
        const room_side *const first = &place->sides[0], *const second = &place->sides[1];
        vec3 const between = vec3_sub(get_end(self, second), get_end(self, first));
        double const missing = place->room - vec3_dot(place->normal, between);
        if (!(missing > tolerance)) continue;
        has_given = true;
        if (place->share > 0.0)
            take_along(self, first, second, vec3_neg(place->normal), place->share * missing);
        if (place->share < 1.0)
            take_along(self, second, first, place->normal, (1.0 - place->share) * missing);
    }
    return has_given;
}

tulle_status step_make_room(const step_model *model, step_work *work, const room_list *places,
                            double *ends) {
    size_t const n = model->vertex_count;
    arena *const scratch = &work->scratch;
    double const tolerance = ROOM_TOLERANCE * model->contact_distance;
    if (places->count == 0) return TULLE_OK;
    double *const starts = ARENA_NEW(scratch, double, 3 * n);
    giving self = {.model = model,
                   .work = work,
                   .starts = starts,
                   .ends = ends,
                   .shifts = ARENA_NEW_ZEROED(scratch, vec3, model->surface_count),
                   .radius = GIVING_RADIUS * model->contact_distance,
                   .lengths = ARENA_NEW(scratch, double, n),
                   .queue = ARENA_NEW(scratch, uint32_t, n),
                   .waits = ARENA_NEW_ZEROED(scratch, uint8_t, n),
                   .vertices = ARENA_NEW(scratch, uint32_t, n),
                   .parts = ARENA_NEW(scratch, double, n)};
    if (!starts || !self.shifts || !self.lengths || !self.queue || !self.waits || !self.vertices ||
        !self.parts)
        return TULLE_ERROR_OUT_OF_MEMORY;
    memcpy(starts, ends, 3 * n * sizeof(double));
    for (size_t v = 0; v < n; v++) self.lengths[v] = (double)INFINITY;
    int sweep = 0;
    while (sweep++ < WIDE_SWEEPS && sweep_places(&self, places, tolerance)) {}
    self.radius = 0.0; /* what the wide sweeps leave lacking takes nothing along */
    sweep = 0;
    while (sweep++ < NARROW_SWEEPS && sweep_places(&self, places, tolerance)) {}
    for (size_t v = model->cloth_vertex_count + 2 * model->body_count; v < n; v++) {
        vec3 const shift = self.shifts[model->vertex_surface[v]];
        if (vec3_norm2(shift) > 0.0) vec3_store(ends, v, vec3_add(vec3_load(ends, v), shift));
    }
    return TULLE_OK;
}
