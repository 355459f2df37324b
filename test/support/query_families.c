/* support/query_families.c - see query_families.h. */
#include "support/query_families.h"

#include "base/hash.h"

const char *const query_family_names[QUERY_FAMILY_COUNT] = {
    "uniform", "slow",     "grid",      "grid noise", "coplanar", "parallel",
    "needles", "touching", "near miss", "coincident", "scaled",   "offset"};

static double signed_random(uint64_t *seed) { return 2.0 * random_uniform(seed) - 1.0; }

static vec3 random_vector(uint64_t *seed) {
    double const x = signed_random(seed), y = signed_random(seed);
    return vec3_make(x, y, signed_random(seed));
}

static vec3 grid_vector(uint64_t *seed) {
    uint64_t const bits = random_next(seed);
    return vec3_make((double)(bits & 3), (double)(bits >> 2 & 3), (double)(bits >> 4 & 3));
}

static moving_pair make_uniform(uint64_t *seed, double motion) {
    moving_pair pair;
    for (int i = 0; i < 4; i++) {
        pair.start[i] = random_vector(seed);
        pair.end[i] = motion < 1.0 ? vec3_add_scaled(pair.start[i], random_vector(seed), motion)
                                   : random_vector(seed);
    }
    return pair;
}

static moving_pair make_grid(uint64_t *seed) {
    moving_pair pair;
    bool const is_flat = random_next(seed) % 4 == 0;
    for (int i = 0; i < 4; i++) {
        pair.start[i] = grid_vector(seed);
        pair.end[i] = grid_vector(seed);
        if (is_flat) pair.start[i].z = pair.end[i].z = 0.0;
    }
    return pair;
}

static double nudge(double x, uint64_t *seed) {
    uint64_t const choice = random_next(seed) % 6;
    return choice == 0 ? nextafter(x, 10.0) : choice == 1 ? nextafter(x, -10.0) : x;
}

static vec3 nudge_vector(vec3 a, uint64_t *seed) {
    double const x = nudge(a.x, seed), y = nudge(a.y, seed);
    return vec3_make(x, y, nudge(a.z, seed));
}

/* Puts the four points at both ends into a plane through the origin, up to rounding, or exactly
 * into z = 0. */
static void flatten(moving_pair *pair, uint64_t *seed) {
    bool const is_exact = random_next(seed) % 2 == 0;
    double const a = signed_random(seed), b = signed_random(seed);
    for (int i = 0; i < 4; i++) {
        pair->start[i].z = is_exact ? 0.0 : a * pair->start[i].x + b * pair->start[i].y;
        pair->end[i].z = is_exact ? 0.0 : a * pair->end[i].x + b * pair->end[i].y;
    }
}

static void make_parallel(moving_pair *pair, feature_kind kind, uint64_t *seed) {
    int const from = kind == FEATURE_EDGE_EDGE ? 0 : 1, to = kind == FEATURE_EDGE_EDGE ? 2 : 2;
    double const factor = random_next(seed) % 2 ? 1.0 : signed_random(seed);
    vec3 const direction = vec3_sub(pair->start[from + 1], pair->start[from]);
    pair->start[to + 1] = vec3_add_scaled(pair->start[to], direction, factor);
    if (random_next(seed) % 2) {
        vec3 const later = vec3_sub(pair->end[from + 1], pair->end[from]);
        pair->end[to + 1] = vec3_add_scaled(pair->end[to], later, factor);
    } else { /* translations */
        vec3 const first = random_vector(seed), second = random_vector(seed);
        for (int i = 0; i < 4; i++)
            pair->end[i] = vec3_add(pair->start[i], i <= from + 1 ? first : second);
    }
}

static void stretch(moving_pair *pair, uint64_t *seed) {
    double const width = random_next(seed) % 2 ? 1e-6 : 1e-3;
    for (int i = 0; i < 4; i++) {
        pair->start[i].y *= width;
        pair->start[i].z *= width * width;
        pair->end[i].y *= width;
        pair->end[i].z *= width * width;
    }
}

/* Moves the end of the first feature so that both touch at time t, `gap` apart. */
static void aim(moving_pair *pair, feature_kind kind, double gap, uint64_t *seed) {
    double const t = random_next(seed) % 3 == 0 ? (double)(1 + random_next(seed) % 4) / 4.0
                                                : 0.1 + 0.9 * random_uniform(seed);
    double const a = random_uniform(seed), b = random_uniform(seed) * (1.0 - a);
    vec3 at[4];
    for (int i = 0; i < 4; i++) at[i] = vec3_lerp(pair->start[i], pair->end[i], t);
    vec3 miss;
    if (kind == FEATURE_VERTEX_TRIANGLE) {
        vec3 const foot = vec3_add_scaled(
            vec3_add_scaled(at[1], vec3_sub(at[2], at[1]), random_next(seed) % 4 ? a : 0.0),
            vec3_sub(at[3], at[1]), b);
        miss = vec3_sub(foot, at[0]);
        vec3 const normal = vec3_cross(vec3_sub(at[2], at[1]), vec3_sub(at[3], at[1]));
        miss = vec3_add_scaled(miss, vec3_normalize(normal), gap);
    } else {
        vec3 const first = vec3_lerp(at[0], at[1], random_next(seed) % 4 ? a : 1.0);
        miss = vec3_sub(vec3_lerp(at[2], at[3], b), first);
        vec3 const normal = vec3_cross(vec3_sub(at[1], at[0]), vec3_sub(at[3], at[2]));
        miss = vec3_add_scaled(miss, vec3_normalize(normal), gap);
    }
    for (int i = 0; i < (kind == FEATURE_EDGE_EDGE ? 2 : 1); i++)
        pair->end[i] = vec3_add_scaled(pair->end[i], miss, 1.0 / t);
}

static void make_coincident(moving_pair *pair, uint64_t *seed) {
    for (int round = 0; round < 2; round++) {
        uint64_t const i = random_next(seed) % 4, j = random_next(seed) % 4;
        uint64_t const where = random_next(seed) % 3;
        if (where != 1) pair->start[i] = pair->start[j];
        if (where != 0) pair->end[i] = pair->end[j];
    }
}

static void transform(moving_pair *pair, double scale, vec3 offset) {
    for (int i = 0; i < 4; i++) {
        pair->start[i] = vec3_add(vec3_scale(pair->start[i], scale), offset);
        pair->end[i] = vec3_add(vec3_scale(pair->end[i], scale), offset);
    }
}

moving_pair make_query(query_family family, feature_kind kind, uint64_t *seed) {
    moving_pair pair = make_uniform(seed, 1.0);
    switch (family) {
    case QUERY_SLOW: return make_uniform(seed, 0.1);
    case QUERY_GRID: return make_grid(seed);
    case QUERY_GRID_NOISE:
        pair = make_grid(seed);
        for (int i = 0; i < 4; i++) {
            pair.start[i] = nudge_vector(pair.start[i], seed);
            pair.end[i] = nudge_vector(pair.end[i], seed);
        }
        break;
    case QUERY_COPLANAR: flatten(&pair, seed); break;
    case QUERY_PARALLEL:
        make_parallel(&pair, kind, seed);
        if (random_next(seed) % 2) flatten(&pair, seed); /* else they hardly ever touch */
        break;
    case QUERY_NEEDLES:
        if (random_next(seed) % 2) aim(&pair, kind, 0.0, seed);
        stretch(&pair, seed);
        break;
    case QUERY_TOUCHING: aim(&pair, kind, 0.0, seed); break;
    case QUERY_NEAR_MISS:
        aim(&pair, kind, pow(10.0, -1.0 - 12.0 * random_uniform(seed)), seed);
        break;
    case QUERY_COINCIDENT: make_coincident(&pair, seed); break;
    case QUERY_SCALED: {
        query_family const inner = (query_family)(random_next(seed) % QUERY_SCALED);
        pair = make_query(inner, kind, seed);
        transform(&pair, ldexp(1.0, (int)(random_next(seed) % 601) - 300),
                  vec3_make(0.0, 0.0, 0.0));
        break;
    }
    case QUERY_OFFSET: {
        query_family const inner = (query_family)(random_next(seed) % QUERY_SCALED);
        pair = make_query(inner, kind, seed);
        transform(&pair, 1.0, vec3_scale(random_vector(seed), 1e6));
        break;
    }
    default: break;
    }
    return pair;
}
