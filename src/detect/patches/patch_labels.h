/* detect/patches/patch_labels.h - which patch each triangle belongs to. */
#ifndef TULLE_DETECT_PATCHES_PATCH_LABELS_H
#define TULLE_DETECT_PATCHES_PATCH_LABELS_H

#include <stdint.h>

/* labels: one a triangle of the topology, 0: none, else 1 .. label_count; null: no patches.
 * version: labels at the same place with the same version are the same; 0: nothing is known. */
typedef struct patch_labels {
    const uint32_t *labels;
    uint32_t label_count;
    uint64_t version;
} patch_labels;

#endif
