/* detect/patches/patch_schedule.c - when patches are repaired, grown again and given up.
 *
 * The measure is the number of pairs of leaves that searches visit. With patches it is what the
 * last search counted; without patches it is at least the pairs that are near one another on the
 * mesh. Checking an edge of a boundary again costs about as much as visiting a pair. Checking
 * triangles costs as much as patches save on boxes. What patches save becomes credit, which pays
 * for repairs and growth.
 *
 * Patches that save nothing are let go. The next search then counts the pairs without patches. If
 * there are more of them than patches were measured against, patches are grown again at once, else
 * after a number of calls that doubles each time. Only calls, triangles and pairs are counted,
 * never time, so runs can be repeated. */
#include "detect/patches/kept_patches_parts.h"

enum {
    EDGE_COST = 3,          /* [half pairs] of checking an edge of a boundary */
    GROWTH_COST = 4,        /* [pairs] of a triangle that growth looks at, twice what it takes, so
                               that at most half of what is saved goes into growth */
    CREDIT_MOST = 8,        /* [pairs a triangle] */
    ISOLATED_SHARE = 8,     /* growth waits until one in that many triangles is isolated */
    GAIN_SHARE = 4,         /* it paid when one in that many of those found a patch */
    LEAST_SHARE = 16,       /* of all pairs is what patches save at least, to be kept */
    RETRY_SHARE = 4,        /* of all pairs must be saved for a try at once */
    FADING = 64,            /* [calls] */
    REGROW_WAIT_MIN = 8,    /* [calls] */
    REGROW_WAIT_MAX = 1024, /* [calls] */
    MERGE_WAIT_MIN = 64,    /* [calls] */
    MERGE_WAIT_MAX = 4096,  /* [calls] */
    RETRY_WAIT_MIN = 128,   /* [calls] */
    RETRY_WAIT_MAX = 4096   /* [calls] */
};

void reset_schedule(kept_patches *patches) {
    patches->schedule =
        (patch_schedule){.retry_wait = RETRY_WAIT_MIN, .credit = patches->topo->triangle_count};
}

bool schedule_is_possible(const patch_schedule *schedule, uint64_t triangle_count,
                          uint64_t kept_triangle_count) {
    return schedule->call_count > 0 && schedule->is_off <= 1 && schedule->has_grown <= 1 &&
           schedule->is_told <= 1 && schedule->has_changed <= 1 &&
           !(schedule->is_off && kept_triangle_count > 0) &&
           schedule->credit <= CREDIT_MOST * triangle_count &&
           schedule->regrow_wait <= UINT32_MAX && schedule->retry_wait <= UINT32_MAX &&
           schedule->merge_wait <= UINT32_MAX;
}

void kept_patches_tell_search(kept_patches *patches, uint64_t pair_count, uint64_t near_count) {
    patch_schedule *const schedule = &patches->schedule;
    schedule->seen_pairs = pair_count;
    schedule->near_pairs = near_count;
    schedule->is_told = 1;
}

void let_patches_go(kept_patches *patches) {
    patch_schedule *const schedule = &patches->schedule;
    drop_patches(patches);
    if (!patches->scratch) release_patches(patches);
    if (schedule->call_count - schedule->grown_at >= RETRY_WAIT_MIN)
        schedule->retry_wait = RETRY_WAIT_MIN;
    schedule->is_off = 1;
    schedule->retry_at = schedule->call_count + schedule->retry_wait;
    schedule->retry_wait =
        schedule->retry_wait < RETRY_WAIT_MAX / 2 ? 2 * schedule->retry_wait : RETRY_WAIT_MAX;
}

void judge_last_search(kept_patches *patches, uint64_t edge_count) {
    patch_schedule *const schedule = &patches->schedule;
    uint64_t const credit_most = CREDIT_MOST * (uint64_t)patches->topo->triangle_count;
    schedule->call_count++;
    bool const is_told = schedule->is_told == 1;
    schedule->is_told = 0;
    if (!patches->rules.has_certificate || patches->rules.keeps_all) {
        schedule->credit = credit_most;
    } else if (is_told && schedule->is_off) {
        /* A search without patches. Those that were measured against too little are tried again at
         * once, if nothing was known then or what was known had faded: not again and again in a
         * few calls. */
        uint64_t const lasted = schedule->call_count - 1 - schedule->grown_at;
        uint64_t const without = schedule->seen_pairs;
        bool const was_known = schedule->pairs_without > 0 && lasted < FADING;
        bool const paid =
            schedule->pairs_with > 0 && schedule->pairs_with + without / RETRY_SHARE < without;
        if (paid && !was_known) {
            schedule->retry_at = schedule->call_count;
            schedule->retry_wait = RETRY_WAIT_MIN;
        }
        schedule->pairs_without = without;
        schedule->pairs_with = 0;
    } else if (is_told && schedule->has_grown) {
        /* A search with patches: what they save becomes credit; without that they are let go. */
        uint64_t const with = schedule->seen_pairs + EDGE_COST * edge_count / 2;
        uint64_t without = schedule->near_pairs;
        if (schedule->pairs_without > without) without = schedule->pairs_without;
        if (with + without / LEAST_SHARE > without) {
            schedule->pairs_with = with;
            let_patches_go(patches);
            return;
        }
        schedule->credit += without - with;
        if (schedule->credit > credit_most) schedule->credit = credit_most;
        if (schedule->pairs_without > schedule->near_pairs)
            schedule->pairs_without -= (schedule->pairs_without - schedule->near_pairs) / FADING;
    }
}

bool is_growth_due(const kept_patches *patches, uint64_t isolated, uint64_t meeting) {
    const patch_schedule *const schedule = &patches->schedule;
    return isolated * ISOLATED_SHARE >= meeting && schedule->call_count >= schedule->regrow_at &&
           schedule->credit >= GROWTH_COST * isolated;
}

/* Takes the cost of looking at some triangles off the credit, as far as there is some. */
static void pay_looks(patch_schedule *schedule, uint64_t looked_at) {
    uint64_t const cost = GROWTH_COST * looked_at;
    schedule->credit -= cost < schedule->credit ? cost : schedule->credit;
}

bool is_merging_due(const kept_patches *patches) {
    const patch_schedule *const schedule = &patches->schedule;
    return schedule->has_changed && schedule->call_count >= schedule->merge_at &&
           schedule->credit >= GROWTH_COST * (uint64_t)patches->topo->triangle_count;
}

void pay_merging(patch_schedule *schedule, uint64_t looked_at, bool has_merged) {
    pay_looks(schedule, looked_at);
    uint64_t const longer = 2 * schedule->merge_wait;
    schedule->merge_wait = has_merged                ? MERGE_WAIT_MIN
                           : longer > MERGE_WAIT_MAX ? MERGE_WAIT_MAX
                                                     : longer;
    schedule->merge_at = schedule->call_count + schedule->merge_wait;
    schedule->has_changed = 0;
}

void pay_growth(patch_schedule *schedule, uint64_t looked_at, uint64_t isolated, uint64_t gained) {
    pay_looks(schedule, looked_at);
    uint64_t const longer =
        schedule->regrow_wait < REGROW_WAIT_MIN ? REGROW_WAIT_MIN : 2 * schedule->regrow_wait;
    bool const paid = gained * GAIN_SHARE >= isolated;
    schedule->regrow_wait = paid ? 0 : longer > REGROW_WAIT_MAX ? REGROW_WAIT_MAX : longer;
    schedule->regrow_at = schedule->call_count + schedule->regrow_wait;
}
