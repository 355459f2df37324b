/* detect/patches/patch_schedule.c - when patches are grown, merged, repaired and given up.
 *
 * The measure is the number of pairs of leaves that searches visit. With patches it is what the
 * last search counted; without patches it is at least the pairs that are near one another on the
 * mesh. Checking an edge of a boundary again costs about as much as visiting a pair. Checking
 * triangles costs as much as patches save on boxes. What patches save becomes credit, which pays
 * for repairs and growth.
 *
 * Patches that save nothing are let go. The next search then counts the pairs without patches. If
 * there are more of them than patches were measured against, patches are grown again at once. Else
 * they are grown again after a number of calls, which doubles each time. Only calls, triangles and
 * pairs are counted, never time, so runs can be repeated. */
#include "detect/patches/kept_patches_parts.h"

enum {
    EDGE_COST = 3,          /* [half pairs] of checking an edge of a boundary */
    GROWTH_COST = 4,        /* [pairs] of a triangle that growth looks at, twice what it takes, so
                               that at most half of what is saved goes into growth */
    REPAIR_COST = 2,        /* [pairs] of a triangle of a patch that is repaired, twice what it
                               takes, so that at most half of what is saved goes into repairs */
    CREDIT_MOST = 8,        /* [pairs a triangle] */
    ISOLATED_SHARE = 8,     /* growth waits until one in that many triangles is isolated */
    GAIN_SHARE = 4,         /* it paid when one in that many of those found a patch */
    LEAST_SHARE = 16,       /* of all pairs is what patches save at least, to be kept */
    RETRY_SHARE = 4,        /* of all pairs must be saved for a try at once */
    FADING = 64,            /* [calls] */
    REGROW_WAIT_MIN = 8,    /* [calls] */
    REGROW_WAIT_MAX = 1024, /* [calls] */
    MERGED_FIRST = 4,       /* triangles that merging looks at, over all, after growth of all */
    MERGE_WAIT_MIN = 64,    /* [calls] */
    MERGE_WAIT_MAX = 4096,  /* [calls] */
    RETRY_WAIT_MIN = 128,   /* [calls] */
    RETRY_WAIT_MAX = 4096   /* [calls] */
};

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
    if (schedule->call_count == 0) {
        schedule->credit = patches->topo->triangle_count;
        schedule->retry_wait = RETRY_WAIT_MIN;
    }
    schedule->call_count++;
    bool const is_told = schedule->is_told == 1;
    schedule->is_told = 0;
    if (!patches->rules.has_certificate || patches->rules.keeps_all) {
        schedule->credit = credit_most;
    } else if (is_told && schedule->is_off) {
        /* A search without patches. They are tried again at once where they were measured against
         * too little, and where nothing was known then or what was known had faded. So they are not
         * tried again and again within a few calls. */
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
    } else if (is_told && !schedule->has_grown) {
        schedule->pairs_without = schedule->seen_pairs;
    } else if (is_told) {
        /* A search with patches. What they save becomes credit; if they save little, they are let
         * go. */
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

bool pay_for_repair(patch_schedule *schedule, uint32_t triangle_count) {
    uint64_t const cost = REPAIR_COST * (uint64_t)triangle_count;
    if (schedule->credit < cost) return false;
    schedule->credit -= cost;
    return true;
}

/* Takes the cost of looking at some triangles off the credit, as far as there is some. */
static void pay_looks(patch_schedule *schedule, uint64_t looked_at) {
    uint64_t const cost = GROWTH_COST * looked_at;
    schedule->credit -= cost < schedule->credit ? cost : schedule->credit;
}

tulle_status grow_first(kept_patches *patches, const growth_input *input, patch_counts *counts) {
    patch_schedule *const schedule = &patches->schedule;
    drop_patches(patches);
    schedule->has_grown = 1;
    schedule->grown_at = schedule->call_count;
    schedule->regrow_at = schedule->regrow_wait = 0;
    schedule->merge_wait = MERGE_WAIT_MIN;
    schedule->merge_at = schedule->call_count + schedule->merge_wait;
    schedule->has_changed = 0;
    tulle_status const status = grow_kept_patches(patches, input, counts);
    schedule->is_off = 0;
    if (status != TULLE_OK || !input->rules->has_certificate || input->rules->grows_anew)
        return status;
    if (!patches->scratch) release_cones(patches);
    return merge_patches(patches, input, MERGED_FIRST * patches->topo->triangle_count, counts);
}

tulle_status grow_when_due(kept_patches *patches, const growth_input *input, patch_counts *counts,
                           bool *has_grown) {
    patch_schedule *const schedule = &patches->schedule;
    patch_cover const before = measure_cover(patches, input->step->set);
    uint64_t const isolated = before.meeting > before.covered ? before.meeting - before.covered : 0;
    *has_grown = isolated >= input->minimum && isolated * ISOLATED_SHARE >= before.meeting &&
                 schedule->call_count >= schedule->regrow_at &&
                 schedule->credit >= GROWTH_COST * isolated;
    if (!*has_grown) return TULLE_OK;
    uint64_t const looked_at = counts->grown_triangle_count;
    tulle_status const status = grow_kept_patches(patches, input, counts);
    if (status != TULLE_OK) return status;
    pay_looks(schedule, counts->grown_triangle_count - looked_at);

    /* Growth that found patches for few triangles waits longer each time. */
    uint64_t const gained = measure_cover(patches, input->step->set).covered - before.covered;
    uint64_t const longer =
        schedule->regrow_wait < REGROW_WAIT_MIN ? REGROW_WAIT_MIN : 2 * schedule->regrow_wait;
    bool const paid = gained * GAIN_SHARE >= isolated;
    schedule->regrow_wait = paid ? 0 : longer > REGROW_WAIT_MAX ? REGROW_WAIT_MAX : longer;
    schedule->regrow_at = schedule->call_count + schedule->regrow_wait;
    return TULLE_OK;
}

tulle_status merge_when_due(kept_patches *patches, const growth_input *input,
                            patch_counts *counts) {
    patch_schedule *const schedule = &patches->schedule;
    uint64_t const triangle_count = patches->topo->triangle_count;
    bool const is_due = input->rules->has_certificate && schedule->has_changed &&
                        schedule->call_count >= schedule->merge_at &&
                        schedule->credit >= GROWTH_COST * triangle_count;
    if (!is_due) return TULLE_OK;
    uint64_t const looked_at = counts->grown_triangle_count;
    uint64_t const dead = schedule->dead_triangle_count;
    tulle_status status = reserve_growth(patches);
    if (status == TULLE_OK) status = merge_patches(patches, input, triangle_count, counts);
    if (status != TULLE_OK) return status;
    pay_looks(schedule, counts->grown_triangle_count - looked_at);

    /* Merging that joined none waits longer each time. */
    bool const has_merged = schedule->dead_triangle_count > dead;
    uint64_t const longer = 2 * schedule->merge_wait;
    schedule->merge_wait = has_merged                ? MERGE_WAIT_MIN
                           : longer > MERGE_WAIT_MAX ? MERGE_WAIT_MAX
                                                     : longer;
    schedule->merge_at = schedule->call_count + schedule->merge_wait;
    schedule->has_changed = 0;
    return TULLE_OK;
}
