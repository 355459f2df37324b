/* render/color_space.h - sRGB, linear RGB and OKLab. Linear RGB has the primaries and the white of
 * sRGB; OKLab is (lightness 0 .. 1, green to red, blue to yellow), in which equal distances look
 * about equally far apart. */
#ifndef TULLE_RENDER_COLOR_SPACE_H
#define TULLE_RENDER_COLOR_SPACE_H

#include <stdint.h>

/* A linear value 0 .. 1 as sRGB stores it, 0 .. 1; values outside go to the nearest end. */
double color_encode_srgb(double linear);
/* The inverse. */
double color_decode_srgb(double encoded);
/* Linear RGB as the nearest bytes of sRGB. */
void color_to_bytes(const float rgb[3], uint8_t bytes[3]);

void color_to_oklab(const double rgb[3], double lab[3]);
/* Not clamped: a color beyond what sRGB can show has components below 0 or above 1. */
void color_from_oklab(const double lab[3], double rgb[3]);
/* OKLab by lightness, chroma and hue [degrees]: 30 is red, 100 yellow, 150 green, 255 blue. */
void color_from_oklch(double lightness, double chroma, double hue, double rgb[3]);

#endif
