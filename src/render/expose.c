/* render/expose.c - radiance to bytes. A fixed curve for every picture, so a film does not flicker:
 * proportional up to a knee, then bent towards a ceiling below white which it nears but never
 * reaches. Below the knee colors are what they were given as, so a legend in those colors is true.
 *
 * Based on: IEC 61966-2-1, 1999 (sRGB's transfer curve). */
#include "render/render.h"

#include <math.h>

/* [radiance] where the curve leaves the straight line. Higher: whites are flatter and colors truer;
 * a soft shoulder needs the rest. */
static const double knee = 0.6;
/* sRGB's 254.4 of 255, linear: the largest byte is 254. */
static const double ceiling_radiance = 0.9947;

static double bend(double radiance) {
    if (!(radiance > 0.0)) return 0.0; /* NaN too */
    if (radiance <= knee) return radiance;
    double const room = ceiling_radiance - knee;
    return knee + room * (1.0 - exp(-(radiance - knee) / room));
}

static uint8_t encode(double linear) {
    double const value =
        linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1.0 / 2.4) - 0.055;
    return (uint8_t)(255.0 * value + 0.5);
}

void render_expose(const float *radiance, double exposure, render_image *image) {
    size_t const count = 3 * (size_t)image->width * image->height;
    for (size_t i = 0; i < count; i++)
        image->pixels[i] = encode(bend(exposure * (double)radiance[i]));
}
