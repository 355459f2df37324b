/* render/image.c - memory of pictures. */
#include "render/image.h"

#include "base/error.h"

tulle_status render_image_create(uint32_t width, uint32_t height, render_image *image,
                                 tulle_error *error) {
    *image = (render_image){0};
    if (width < 1 || height < 1 || width > RENDER_IMAGE_SIDE_MAX || height > RENDER_IMAGE_SIDE_MAX)
        return error_set(error, TULLE_ERROR_LIMIT,
                         "a picture of %ux%u pixels cannot be made: each side has 1 to %d", width,
                         height, RENDER_IMAGE_SIDE_MAX);
    memory heap = memory_default();
    uint8_t *const pixels = memory_allocate_zeroed(&heap, (size_t)width * height, 3);
    if (!pixels)
        return error_set(error, TULLE_ERROR_OUT_OF_MEMORY, "no memory for a picture of %ux%u",
                         width, height);
    *image = (render_image){pixels, width, height};
    return TULLE_OK;
}

void render_image_destroy(render_image *image) {
    memory heap = memory_default();
    memory_release(&heap, image->pixels, 3 * (size_t)image->width * image->height);
    *image = (render_image){0};
}
