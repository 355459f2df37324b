/* scene/facts.c - what one asks about a scene that is simulated by hand: materials, pins, gravity
 * and wind. */
#include "scene/scene.h"
#include "scene/scene_data.h"

#include <string.h>

scene_object_facts scene_get_object_facts(const tulle_scene *loaded, size_t object) {
    scene_object_facts facts = {0};
    if (object < loaded->cloth_count) {
        const scene_cloth *const cloth = &loaded->cloths[object];
        const material_keys *const keys = &cloth->keys->material;
        facts.material = keys->name     ? keys->name
                         : keys->preset ? keys->preset
                                        : cloth->contact_material;
        facts.cloth_material = &cloth->material;
        facts.thickness = cloth->keys->thickness;
        facts.friction = cloth->material.friction;
        facts.restitution = cloth->material.restitution;
        facts.pin_count = cloth->pin_count;
    } else if (object < loaded->cloth_count + loaded->obstacle_count) {
        const scene_obstacle *const obstacle = &loaded->obstacles[object - loaded->cloth_count];
        facts.material = obstacle->contact_material;
        facts.friction = obstacle->keys->friction;
        facts.restitution = obstacle->keys->restitution;
    }
    return facts;
}

size_t scene_find_pin(const tulle_scene *loaded, size_t cloth, uint32_t vertex, size_t limit) {
    if (cloth >= loaded->cloth_count) return SIZE_MAX;
    const scene_cloth *const held = &loaded->cloths[cloth];
    size_t pin = held->pin_count < limit ? held->pin_count : limit;
    while (pin-- > 0)
        for (size_t k = 0; k < held->pins[pin].vertex_count; k++)
            if (held->pins[pin].vertices[k] == vertex) return pin;
    return SIZE_MAX;
}

const uint32_t *scene_get_pin_vertices(const tulle_scene *loaded, size_t cloth, size_t pin,
                                       size_t *count) {
    *count = 0;
    if (cloth >= loaded->cloth_count || pin >= loaded->cloths[cloth].pin_count) return NULL;
    *count = loaded->cloths[cloth].pins[pin].vertex_count;
    return loaded->cloths[cloth].pins[pin].vertices;
}

void scene_get_weather(const tulle_scene *loaded, double gravity[3], tulle_wind *wind) {
    const scene_keys *const keys = &loaded->keys;
    memcpy(gravity, keys->gravity.value, 3 * sizeof(double));
    *wind = (tulle_wind){.gust_strength = keys->wind.gust_strength,
                         .gust_length = keys->wind.gust_length,
                         .gust_time = keys->wind.gust_time,
                         .seed = resolve_seed(loaded, keys->wind.seed),
                         .drag_coefficient = keys->wind.drag};
    memcpy(wind->velocity, keys->wind.velocity.value, sizeof wind->velocity);
}
