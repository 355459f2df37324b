/* support/adversarial_motion.c - see adversarial_motion.h. */
#include "support/adversarial_motion.h"

#include "base/hash.h"
#include "math/vec3.h"

#include <math.h>
#include <string.h>

const char *const adversary_names[ADVERSARY_COUNT] = {"sliding", "parallel", "coplanar", "shared",
                                                      "grazing", "turning",  "resting",  "lattice"};
const char *const adversary_place_names[ADVERSARY_PLACE_COUNT] = {
    "at the origin", "far", "farther", "denormal", "tiny", "huge"};

static const double HALF_TURN = 3.14159265358979323846; /* [rad] */

static double uniform(uint64_t *seed, double low, double high) {
    return low + (high - low) * random_uniform(seed);
}

static uint64_t choose(uint64_t *seed, uint64_t count) { return random_next(seed) % count; }

/* A place, or a way, at one end of the step. */
typedef struct sheet_path {
    vec3 origin, along, across; /* of the square at the start; the sheet spans both */
    vec3 way;                   /* of all of it */
    double angle;               /* [rad] about `across` through the origin */
    double fold;                /* [rad] of the half beyond the middle, about the middle line */
    double wrinkle;             /* of the start along the normal */
    bool is_on_lattice;         /* both ends are random points of a lattice instead */
} sheet_path;

static vec3 place_on_sheet(const sheet_path *path, int end, double u, double v) {
    double const bend = end == 1 && u > 0.5 ? path->fold : 0.0, turned = end == 1 ? path->angle : 0;
    vec3 const normal = vec3_cross(path->along, path->across);
    double const reach = u > 0.5 ? u - 0.5 : 0.0, flat = u - reach;
    double const x = flat + reach * cos(bend), z = reach * sin(bend);
    vec3 at = vec3_scale(path->across, v);
    at = vec3_add_scaled(at, path->along, x * cos(turned) - z * sin(turned));
    at = vec3_add_scaled(at, normal, x * sin(turned) + z * cos(turned));
    at = vec3_add(at, path->origin);
    return end == 1 ? vec3_add(at, path->way) : at;
}

/* A square sheet of side x side cells. */
static void add_sheet(detect_scene *scene, const sheet_path *path, uint32_t side, uint64_t *seed) {
    uint32_t const base = (uint32_t)scene->vertex_count;
    vec3 const normal = vec3_cross(path->along, path->across);
    for (uint32_t i = 0; i <= side; i++)
        for (uint32_t j = 0; j <= side; j++) {
            double const u = (double)i / side, v = (double)j / side;
            vec3 ends[2] = {place_on_sheet(path, 0, u, v), place_on_sheet(path, 1, u, v)};
            double const wrinkle = path->wrinkle * uniform(seed, -1.0, 1.0);
            for (int end = 0; end < 2; end++) {
                ends[end] = vec3_add_scaled(ends[end], normal, wrinkle);
                if (path->is_on_lattice)
                    ends[end] = vec3_make((double)choose(seed, 4), (double)choose(seed, 4),
                                          (double)choose(seed, 3));
            }
            vec3_store(scene->start, scene->vertex_count, ends[0]);
            vec3_store(scene->end, scene->vertex_count++, ends[1]);
        }
    for (uint32_t i = 0; i < side; i++)
        for (uint32_t j = 0; j < side; j++) {
            uint32_t const a = base + i * (side + 1) + j, b = a + side + 1;
            const uint32_t corners[6] = {a, b, a + 1, b, b + 1, a + 1};
            memcpy(scene->triangles + 3 * scene->triangle_count, corners, sizeof corners);
            scene->triangle_count += 2;
        }
}

/* The separation, or what lies beside it: a last bit, a part in 2^20, a twentieth. */
static double choose_gap(double separation, uint64_t *seed) {
    switch (choose(seed, 7)) {
    case 0: return nextafter(separation, 1.0);
    case 1: return nextafter(separation, 0.0);
    case 2: return separation * (1.0 + 0x1p-20);
    case 3: return separation * 1.05;
    case 4: return separation + 0x1p-40;
    case 5: return 0.0;
    default: return separation;
    }
}

/* The second sheet, which the motion of the family brings to the first one, z = 0 within 0 .. 1. */
static sheet_path choose_path(adversary family, double separation, uint64_t *seed) {
    sheet_path path = {.along = {1.0, 0.0, 0.0}, .across = {0.0, 1.0, 0.0}};
    double const gap = choose_gap(separation, seed), side = choose(seed, 2) ? 1.0 : -1.0;
    bool const is_aligned = choose(seed, 2) == 0;
    path.origin = is_aligned
                      ? vec3_make(0.25 * (double)choose(seed, 4), 0.0, side * gap)
                      : vec3_make(uniform(seed, -0.5, 0.5), uniform(seed, -0.5, 0.5), side * gap);
    switch (family) {
    case ADVERSARY_SLIDING:
        path.way =
            vec3_make(uniform(seed, -1.0, 1.0), is_aligned ? 0.0 : uniform(seed, -1, 1), 0.0);
        break;
    case ADVERSARY_PARALLEL:
        path.origin.z = side * (gap + 0.5);
        path.way.z = -0.5 * side * (choose(seed, 3) == 0 ? 4.0 : 1.0);
        break;
    case ADVERSARY_COPLANAR:
        path.origin.z = 0.0;
        path.origin.x += 1.0 + gap;
        path.way =
            vec3_make(-uniform(seed, 0.0, 0.6), is_aligned ? 0.0 : uniform(seed, -1, 1), 0.0);
        break;
    case ADVERSARY_SHARED:
        path.origin.z = side * (gap + 0.25);
        path.fold = (choose(seed, 2) ? 1.0 : -1.0) *
                    (choose(seed, 2) ? HALF_TURN : uniform(seed, 2.0, 4.0));
        path.way.z = choose(seed, 2) ? 0.0 : -0.25 * side;
        break;
    case ADVERSARY_TURNING:
        path.origin.z = side * uniform(seed, 0.0, 0.3);
        path.angle = uniform(seed, -3.2, 3.2);
        path.wrinkle = choose(seed, 2) ? 0.0 : 0.02;
        break;
    case ADVERSARY_GRAZING: /* stands on its edge or corner, and passes */
        path.along = vec3_make(0.0, is_aligned ? 0.0 : 0.6, is_aligned ? side : 0.8 * side);
        path.across = choose(seed, 2) ? vec3_make(0.0, 1.0, 0.0) : vec3_make(0.0, 0.0, side);
        if (is_aligned) path.along = vec3_make(0.6, 0.0, 0.8 * side);
        path.way = vec3_make(uniform(seed, -1.0, 1.0), uniform(seed, -1.0, 1.0), 0.0);
        break;
    case ADVERSARY_LATTICE: path.is_on_lattice = true; break;
    default: break;
    }
    return path;
}

static void scale_scene(detect_scene *scene, adversary_place place) {
    static const double shifts[ADVERSARY_PLACE_COUNT] = {0.0, 0x1p20, 0x1p40, 0.0, 0.0, 0.0};
    static const double scales[ADVERSARY_PLACE_COUNT] = {1.0,       1.0,      1.0,
                                                         0x1p-1062, 0x1p-560, 0x1p480};
    detect_scene_place(scene, scales[place], shifts[place]);
    scene->minimum_separation *= scales[place];
    for (size_t s = 0; s < scene->surface_count; s++) scene->surfaces[s].thickness *= scales[place];
}

void adversarial_scene_make(detect_scene *scene, adversary family, adversary_place place,
                            adversary_sides sides, unsigned triangle_count, uint64_t *seed) {
    scene->triangle_count = scene->vertex_count = 0;
    scene->has_collides = false;
    scene->is_thorough = true;
    static const double thicknesses[] = {0.0, 0.0, 0x1p-6, 0x1p-8};
    double const first = thicknesses[choose(seed, 4)], second = thicknesses[choose(seed, 4)];
    scene->minimum_separation = choose(seed, 2) ? 0.0 : 0x1p-9;
    bool const is_one = sides == ADVERSARY_ONE_CLOTH;
    double const separation = scene->minimum_separation + (is_one ? first : 0.5 * (first + second));
    sheet_path const still = {.along = {1.0, 0.0, 0.0},
                              .across = {0.0, 1.0, 0.0},
                              .is_on_lattice = family == ADVERSARY_LATTICE};
    sheet_path const path = choose_path(family, separation, seed);
    uint32_t const side = (uint32_t)fmax(1.0, sqrt(0.25 * triangle_count) + 0.5);
    add_sheet(scene, &path, side, seed);
    uint32_t const middle_vertex = (uint32_t)scene->vertex_count;
    uint32_t const middle_triangle = (uint32_t)scene->triangle_count;
    add_sheet(scene, &still, side, seed);
    scene->surface_count = is_one ? 1 : 2;
    scene->surfaces[0] = (tulle_detect_surface){
        .vertex_end = is_one ? (uint32_t)scene->vertex_count : middle_vertex,
        .triangle_end = is_one ? (uint32_t)scene->triangle_count : middle_triangle,
        .thickness = first,
        .is_obstacle = sides == ADVERSARY_MOVING_OBSTACLE};
    scene->surfaces[1] = (tulle_detect_surface){.vertex_begin = middle_vertex,
                                                .vertex_end = (uint32_t)scene->vertex_count,
                                                .triangle_begin = middle_triangle,
                                                .triangle_end = (uint32_t)scene->triangle_count,
                                                .thickness = second,
                                                .is_obstacle = sides == ADVERSARY_STILL_OBSTACLE,
                                                .is_static = sides == ADVERSARY_STILL_OBSTACLE &&
                                                             family != ADVERSARY_LATTICE};
    scale_scene(scene, place);
}
