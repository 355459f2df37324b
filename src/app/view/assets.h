/* app/view/assets.h - files that are part of the program: the page, and example scenes. The build
 * makes their list: cmake/view.cmake. */
#ifndef TULLE_APP_VIEW_ASSETS_H
#define TULLE_APP_VIEW_ASSETS_H

#include <stddef.h>

typedef struct view_asset {
    const char *name; /* "index.html", "examples/ball.yaml" */
    const unsigned char *bytes, *end;
} view_asset;

/* Ends with a null name. */
extern const view_asset view_assets[];

static inline const view_asset *assets_get(size_t index) {
    return view_assets[index].name ? &view_assets[index] : NULL;
}

#endif
