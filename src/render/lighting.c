/* render/lighting.c - see lighting.h. The light is a disc at infinity. The sky's radiance is linear
 * in the height z of the direction. So its mean over a tilted hemisphere has a closed form. Let a
 * be the angle between normal n and zenith: the integral of max(z, 0) max(n d, 0) over all
 * directions d is 2/3 (sin a + (pi - a) cos a).
 *
 * Based on: Matt Jen-Yuan Chiang, Yining Karl Li and Brent Burley, Taming the shadow terminator,
 *           2019 (the factor where shading and true normals disagree). */
#include "render/lighting.h"

#include "render/sampling.h"

static const double pi = 3.14159265358979323846;

/* A bright studio: a soft key light from one side, a dim sky, and a floor. The floor sends about as
 * much light as the horizon, so no line shows where they meet. */
render_lighting render_lighting_default(void) {
    return (render_lighting){.light_direction = {-0.74, -0.20, 0.64},
                             .light_angle = 0.10,
                             .light_radiance = {1.22f, 1.17f, 1.11f},
                             .sky_color = {0.16f, 0.18f, 0.21f},
                             .horizon_color = {0.670f, 0.665f, 0.660f},
                             .has_floor = true,
                             .floor_height = 0.0,
                             .floor_color = {0.600f, 0.608f, 0.618f},
                             .bounces = 2};
}

render_light render_light_prepare(const render_lighting *lighting) {
    render_light light = {.direction = vec3_normalize(vec3_load(lighting->light_direction, 0)),
                          .sine = sin(lighting->light_angle)};
    sampling_make_frame(light.direction, &light.tangent, &light.bitangent);
    for (int i = 0; i < 3; i++) {
        light.radiance[i] = (double)lighting->light_radiance[i];
        light.sky[i] = (double)lighting->sky_color[i];
        light.horizon[i] = (double)lighting->horizon_color[i];
        light.floor_color[i] = (double)lighting->floor_color[i];
    }
    return light;
}

void render_light_get_sky(const render_light *light, vec3 direction, double radiance[3]) {
    double const height = direction.z > 0.0 ? direction.z : 0.0;
    for (int i = 0; i < 3; i++)
        radiance[i] = light->horizon[i] + height * (light->sky[i] - light->horizon[i]);
}

void render_light_get_ambient(const render_light *light, vec3 normal, double radiance[3]) {
    double const cosine = fmin(fmax(normal.z, -1.0), 1.0);
    double const share =
        2.0 / (3.0 * pi) * (sqrt(1.0 - cosine * cosine) + (pi - acos(cosine)) * cosine);
    for (int i = 0; i < 3; i++)
        radiance[i] = light->horizon[i] + share * (light->sky[i] - light->horizon[i]);
}

vec3 render_light_get_direction(const render_light *light, const double point[2]) {
    double disc[2];
    sampling_get_disc(point, disc);
    double const x = light->sine * disc[0], y = light->sine * disc[1];
    vec3 const across = vec3_add_scaled(vec3_scale(light->tangent, x), light->bitangent, y);
    return vec3_add_scaled(across, light->direction, sqrt(fmax(0.0, 1.0 - x * x - y * y)));
}

double render_light_get_agreement(vec3 direction, vec3 shading_normal, vec3 normal) {
    double const cosine = vec3_dot(shading_normal, direction);
    double const true_cosine = vec3_dot(normal, direction);
    double const agreement = vec3_dot(shading_normal, normal);
    if (cosine <= 0.0 || true_cosine <= 0.0 || agreement <= 0.0) return 0.0;
    double const ratio = true_cosine / (cosine * agreement);
    return ratio >= 1.0 ? 1.0 : ratio * (1.0 + ratio * (1.0 - ratio));
}
