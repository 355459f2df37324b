/* scene/scene.c - what a loaded scene tells about itself. */
#include "scene/scene_data.h"

double tulle_scene_get_time_step(const tulle_scene *loaded) {
    return loaded ? loaded->keys.time.step : 0.0;
}
uint32_t tulle_scene_get_frame_count(const tulle_scene *loaded) {
    return loaded ? loaded->frame_count : 0;
}
uint32_t tulle_scene_get_steps_per_frame(const tulle_scene *loaded) {
    return loaded ? (uint32_t)loaded->keys.time.steps_per_frame : 0;
}
const char *tulle_scene_get_path(const tulle_scene *loaded) { return loaded ? loaded->path : NULL; }
uint64_t tulle_scene_get_seed(const tulle_scene *loaded) { return loaded ? loaded->keys.seed : 0; }
tulle_start_intersections tulle_scene_get_start_intersections(const tulle_scene *loaded) {
    return loaded ? (tulle_start_intersections)loaded->keys.contact.start_intersections
                  : TULLE_START_REFUSE;
}

static const scene_cloth *get_cloth(const tulle_scene *loaded, size_t index) {
    return loaded && index < loaded->cloth_count ? &loaded->cloths[index] : NULL;
}

static const scene_obstacle *get_obstacle(const tulle_scene *loaded, size_t index) {
    return loaded && index < loaded->obstacle_count ? &loaded->obstacles[index] : NULL;
}

size_t tulle_scene_get_cloth_count(const tulle_scene *loaded) {
    return loaded ? loaded->cloth_count : 0;
}
const char *tulle_scene_get_cloth_name(const tulle_scene *loaded, size_t index) {
    const scene_cloth *const cloth = get_cloth(loaded, index);
    return cloth ? cloth->name : NULL;
}
tulle_mesh_view tulle_scene_get_cloth_mesh(const tulle_scene *loaded, size_t index) {
    const scene_cloth *const cloth = get_cloth(loaded, index);
    return tulle_mesh_get_view(cloth ? &cloth->mesh : NULL);
}
size_t tulle_scene_get_obstacle_count(const tulle_scene *loaded) {
    return loaded ? loaded->obstacle_count : 0;
}
const char *tulle_scene_get_obstacle_name(const tulle_scene *loaded, size_t index) {
    const scene_obstacle *const obstacle = get_obstacle(loaded, index);
    return obstacle ? obstacle->name : NULL;
}
tulle_mesh_view tulle_scene_get_obstacle_mesh(const tulle_scene *loaded, size_t index) {
    const scene_obstacle *const obstacle = get_obstacle(loaded, index);
    return tulle_mesh_get_view(obstacle ? &obstacle->mesh : NULL);
}
int tulle_scene_is_obstacle_moving(const tulle_scene *loaded, size_t index) {
    const scene_obstacle *const obstacle = get_obstacle(loaded, index);
    return obstacle && (obstacle->motion.key_count > 0 || obstacle->sequence ||
                        obstacle->keys->dynamic.head.node != NULL);
}

int tulle_scene_is_obstacle_dynamic(const tulle_scene *loaded, size_t index) {
    const scene_obstacle *const obstacle = get_obstacle(loaded, index);
    return obstacle && obstacle->keys->dynamic.head.node != NULL;
}

const char *tulle_scene_get_canonical_text(const tulle_scene *loaded) {
    return loaded ? loaded->canonical_text : NULL;
}
uint64_t tulle_scene_get_hash(const tulle_scene *loaded) { return loaded ? loaded->hash : 0; }

size_t tulle_scene_get_note_count(const tulle_scene *loaded) {
    return loaded ? loaded->note_count : 0;
}
const char *tulle_scene_get_note(const tulle_scene *loaded, size_t index) {
    return loaded && index < loaded->note_count ? loaded->notes[index] : NULL;
}
