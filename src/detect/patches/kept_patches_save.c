/* detect/patches/kept_patches_save.c - kept patches as bytes.
 *
 * The bytes are a header, one record for each label, used or not, and the triangles of all patches,
 * label by label, in the order in which they joined. Loading makes all else again from these and so
 * checks it: bytes that do not describe discs of this topology are refused. Patches that are there
 * already were checked when they were made, and stay. Numbers have this machine's order of bytes,
 * as in the rest of a checkpoint; a header in another order is refused. */
#include "detect/patches/kept_patches_parts.h"

#include <float.h>
#include <string.h>

static const uint64_t SAVED_MAGIC = 0x3330686374617074; /* "tpatch03" */

typedef struct saved_header {
    uint64_t magic, triangle_count, vertex_count;
    uint64_t patch_count, kept_triangle_count;
    double max_angle, reach;
    uint32_t cone, has_certificate, grows_anew, keeps_all;
    patch_schedule schedule;
} saved_header;

typedef struct saved_patch {
    double axis[3];
    uint64_t triangle_count;
} saved_patch;

size_t kept_patches_save(const kept_patches *patches, void *bytes) {
    if (patches->schedule.call_count == 0) return 0;
    size_t triangle_count = 0;
    for (size_t i = 0; i < patches->patches.count; i++)
        triangle_count += patches->patches.data[i].triangle_count;
    size_t const byte_count = sizeof(saved_header) + patches->patches.count * sizeof(saved_patch) +
                              triangle_count * sizeof(uint32_t);
    if (!bytes) return byte_count;
    saved_header const header = {.magic = SAVED_MAGIC,
                                 .triangle_count = patches->topo->triangle_count,
                                 .vertex_count = patches->topo->vertex_count,
                                 .patch_count = patches->patches.count,
                                 .kept_triangle_count = triangle_count,
                                 .max_angle = patches->rules.max_angle,
                                 .reach = patches->rules.reach,
                                 .cone = patches->rules.cone,
                                 .has_certificate = patches->rules.has_certificate,
                                 .grows_anew = patches->rules.grows_anew,
                                 .keeps_all = patches->rules.keeps_all,
                                 .schedule = patches->schedule};
    unsigned char *at = bytes;
    memcpy(at, &header, sizeof header);
    at += sizeof header;
    for (size_t i = 0; i < patches->patches.count; i++, at += sizeof(saved_patch)) {
        const kept_patch *const patch = &patches->patches.data[i];
        saved_patch const saved = {{patch->axis.x, patch->axis.y, patch->axis.z},
                                   patch->triangle_count};
        memcpy(at, &saved, sizeof saved);
    }
    for (size_t i = 0; i < patches->patches.count; i++) {
        const kept_patch *const patch = &patches->patches.data[i];
        size_t const size = patch->triangle_count * sizeof(uint32_t);
        if (size == 0) continue;
        memcpy(at, patches->triangles.data + patch->triangle_begin, size);
        at += size;
    }
    return byte_count;
}

/* Whether the patches are the saved ones already, and have no more dead triangles among theirs than
 * the saved schedule counts. */
static bool are_as_saved(const kept_patches *patches, const saved_header *header,
                         const unsigned char *bytes) {
    const unsigned char *const records = bytes + sizeof *header;
    const unsigned char *triangles = records + header->patch_count * sizeof(saved_patch);
    uint64_t left = header->kept_triangle_count;
    bool is_same = patches->patches.count == header->patch_count &&
                   patches->triangles.count >= left &&
                   patches->triangles.count - left <= header->schedule.dead_triangle_count &&
                   patches->rules.has_certificate == (header->has_certificate == 1);
    for (size_t i = 0; i < header->patch_count && is_same; i++) {
        const kept_patch *const patch = &patches->patches.data[i];
        saved_patch saved;
        memcpy(&saved, records + i * sizeof saved, sizeof saved);
        size_t const size = patch->triangle_count * sizeof(uint32_t);
        double const axis[3] = {patch->axis.x, patch->axis.y, patch->axis.z};
        is_same = saved.triangle_count == patch->triangle_count && saved.triangle_count <= left &&
                  memcmp(saved.axis, axis, sizeof axis) == 0 &&
                  (size == 0 ||
                   memcmp(triangles, patches->triangles.data + patch->triangle_begin, size) == 0);
        triangles += size;
        left -= patch->triangle_count;
    }
    return is_same && left == 0;
}

tulle_status kept_patches_load(kept_patches *patches, const void *bytes, size_t size) {
    const topology *const topo = patches->topo;
    saved_header header = {0};
    if (size >= sizeof header) memcpy(&header, bytes, sizeof header);

    /* The counts fit the topology and the number of bytes, the rest what an update may leave. */
    bool const has_size = header.magic == SAVED_MAGIC &&
                          header.triangle_count == topo->triangle_count &&
                          header.vertex_count == topo->vertex_count &&
                          header.kept_triangle_count <= topo->triangle_count &&
                          header.patch_count <= size / sizeof(saved_patch) &&
                          size == sizeof header + header.patch_count * sizeof(saved_patch) +
                                      header.kept_triangle_count * sizeof(uint32_t);
    bool const has_rules = header.max_angle > 0.0 && header.max_angle < 1.5707963267948966 &&
                           header.reach >= 0.0 && header.reach <= DBL_MAX &&
                           header.cone <= CONE_PAPER && header.has_certificate <= 1 &&
                           header.grows_anew <= 1 && header.keeps_all <= 1;
    bool const is_good =
        has_size && has_rules &&
        schedule_is_possible(&header.schedule, topo->triangle_count, header.kept_triangle_count);
    bool const are_there = is_good && are_as_saved(patches, &header, bytes);
    if (!are_there) drop_patches(patches);
    patches->schedule = (patch_schedule){0};
    patches->rules = (patch_rules){0};
    if (!is_good) return size == 0 ? TULLE_OK : TULLE_ERROR_INVALID_ARGUMENT;

    /* Records stand one after the other, and so do the triangles of their patches. These are copied
     * for their alignment. */
    tulle_status status = are_there ? TULLE_OK : reserve_growth(patches);
    uint64_t const patch_count = are_there ? 0 : header.patch_count;
    const unsigned char *record = (const unsigned char *)bytes + sizeof header;
    const unsigned char *triangles = record + header.patch_count * sizeof(saved_patch);
    uint64_t left = are_there ? 0 : header.kept_triangle_count;
    for (uint64_t i = 0; i < patch_count && status == TULLE_OK; i++) {
        saved_patch saved;
        memcpy(&saved, record, sizeof saved);
        vec3 const axis = vec3_make(saved.axis[0], saved.axis[1], saved.axis[2]);
        double const length2 = vec3_norm2(axis);
        if (saved.triangle_count > left || !(length2 > 0.99 && length2 < 1.01)) {
            status = TULLE_ERROR_INVALID_ARGUMENT;
            break;
        }
        uint32_t *const list = patches->growth.queue;
        size_t const count = (size_t)saved.triangle_count;
        if (count > 0) memcpy(list, triangles, count * sizeof(uint32_t));
        status = append_patch(patches, list, count, axis, header.has_certificate == 1);
        record += sizeof saved;
        triangles += count * sizeof(uint32_t);
        left -= count;
    }
    if (status == TULLE_OK && left > 0) status = TULLE_ERROR_INVALID_ARGUMENT;
    if (status != TULLE_OK) {
        drop_patches(patches);
        return status;
    }
    patches->rules = (patch_rules){.cone = (cone_rule)header.cone,
                                   .max_angle = header.max_angle,
                                   .has_certificate = header.has_certificate == 1,
                                   .grows_anew = header.grows_anew == 1,
                                   .reach = header.reach,
                                   .keeps_all = header.keeps_all == 1};
    patches->schedule = header.schedule;
    return TULLE_OK;
}
