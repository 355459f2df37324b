/* app/mend/store.h - mended frames in a file without a name beside OUT, until all are there. So
 * nothing is left of them whatever happens. */
#ifndef TULLE_APP_MEND_STORE_H
#define TULLE_APP_MEND_STORE_H

#include "tulle/base.h"

typedef struct mend_store {
    const char *path;    /* of OUT */
    int file;            /* -1: none */
    size_t vertex_count; /* of a frame */
} mend_store;

/* Release with mend_store_close, also after a failure. */
tulle_status mend_store_open(const char *path, size_t vertex_count, mend_store *store,
                             tulle_error *error);
void mend_store_close(mend_store *store);

/* Keeps the first vertex_count positions as frame `index`, from 0. */
tulle_status mend_store_keep(mend_store *store, uint32_t index, const double *positions,
                             tulle_error *error);
/* Reads `count` vertices from number `first` on. */
tulle_status mend_store_read(const mend_store *store, uint32_t index, size_t first, size_t count,
                             double *positions, tulle_error *error);

#endif
