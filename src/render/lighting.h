/* render/lighting.h - what the light and the sky send, in closed form. */
#ifndef TULLE_RENDER_LIGHTING_H
#define TULLE_RENDER_LIGHTING_H

#include "render/render.h"

#include "math/vec3.h"

/* A lighting prepared for many points. */
typedef struct render_light {
    vec3 direction, tangent, bitangent; /* unit; to the middle of the light, and across */
    double sine;                        /* of its angular radius */
    double radiance[3];
    double sky[3], horizon[3];
    double floor_color[3];
} render_light;

render_light render_light_prepare(const render_lighting *lighting);

/* Radiance of the sky in a unit direction: from the horizon's color at the horizon and below to the
 * sky's at the zenith, linear in height. */
void render_light_get_sky(const render_light *light, vec3 direction, double radiance[3]);

/* The mean of the whole sky over the hemisphere about a unit normal, weighted by the cosine: what a
 * white surface sends that sees nothing else. */
void render_light_get_ambient(const render_light *light, vec3 normal, double radiance[3]);

/* A random direction to the light. Its density is proportional to the cosine to the middle, so a
 * surface that faces the light receives the same from every sample. */
vec3 render_light_get_direction(const render_light *light, const double point[2]);

/* Factor on a shading normal's cosine, because the surface itself may turn away from the light
 * sooner than its shading normal. It is 1 where it does not, and falls to 0, without a step, where
 * the surface has turned away. */
double render_light_get_agreement(vec3 direction, vec3 shading_normal, vec3 normal);

#endif
