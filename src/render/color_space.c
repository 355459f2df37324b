/* render/color_space.c - see color_space.h.
 *
 * Based on: IEC 61966-2-1:1999 (sRGB's curve); B. Ottosson, "A perceptual color space for image
 * processing", 2020 (OKLab's matrices). */
#include "render/color_space.h"

#include <math.h>

static double const degree = 0.017453292519943295; /* [rad] */

static double clamp_unit(double value) { return value > 0.0 ? (value < 1.0 ? value : 1.0) : 0.0; }

double color_encode_srgb(double linear) {
    double const value = clamp_unit(linear);
    if (value == 1.0) return 1.0; /* 1.055 - 0.055 is just below */
    return value <= 0.0031308 ? 12.92 * value : 1.055 * pow(value, 1.0 / 2.4) - 0.055;
}

double color_decode_srgb(double encoded) {
    double const value = clamp_unit(encoded);
    return value <= 0.04045 ? value / 12.92 : pow((value + 0.055) / 1.055, 2.4);
}

void color_to_bytes(const float rgb[3], uint8_t bytes[3]) {
    for (int i = 0; i < 3; i++)
        bytes[i] = (uint8_t)(255.0 * color_encode_srgb((double)rgb[i]) + 0.5);
}

void color_to_oklab(const double rgb[3], double lab[3]) {
    double const r = rgb[0], g = rgb[1], b = rgb[2];
    double const l = cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b);
    double const m = cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b);
    double const s = cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
    lab[0] = 0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s;
    lab[1] = 1.9779984951 * l - 2.4285922050 * m + 0.4505937099 * s;
    lab[2] = 0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * s;
}

static double cube(double value) { return value * value * value; }

void color_from_oklab(const double lab[3], double rgb[3]) {
    double const l = cube(lab[0] + 0.3963377774 * lab[1] + 0.2158037573 * lab[2]);
    double const m = cube(lab[0] - 0.1055613458 * lab[1] - 0.0638541728 * lab[2]);
    double const s = cube(lab[0] - 0.0894841775 * lab[1] - 1.2914855480 * lab[2]);
    rgb[0] = 4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s;
    rgb[1] = -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s;
    rgb[2] = -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s;
}

void color_from_oklch(double lightness, double chroma, double hue, double rgb[3]) {
    double const lab[3] = {lightness, chroma * cos(hue * degree), chroma * sin(hue * degree)};
    color_from_oklab(lab, rgb);
}
