/* scene/scene.c - what a loaded scene tells about itself. */
#include "scene/scene_data.h"

double tulle_scene_get_time_step(const tulle_scene *loaded) { return loaded->keys.time.step; }
uint32_t tulle_scene_get_frame_count(const tulle_scene *loaded) { return loaded->frame_count; }
uint32_t tulle_scene_get_steps_per_frame(const tulle_scene *loaded) {
    return (uint32_t)loaded->keys.time.steps_per_frame;
}
const char *tulle_scene_get_path(const tulle_scene *loaded) { return loaded->path; }
uint64_t tulle_scene_get_seed(const tulle_scene *loaded) { return loaded->keys.seed; }
tulle_start_intersections tulle_scene_get_start_intersections(const tulle_scene *loaded) {
    return (tulle_start_intersections)loaded->keys.contact.start_intersections;
}

size_t tulle_scene_get_cloth_count(const tulle_scene *loaded) { return loaded->cloth_count; }
const char *tulle_scene_get_cloth_name(const tulle_scene *loaded, size_t index) {
    return loaded->cloths[index].name;
}
tulle_mesh_view tulle_scene_get_cloth_mesh(const tulle_scene *loaded, size_t index) {
    return tulle_mesh_get_view(&loaded->cloths[index].mesh);
}
size_t tulle_scene_get_obstacle_count(const tulle_scene *loaded) { return loaded->obstacle_count; }
const char *tulle_scene_get_obstacle_name(const tulle_scene *loaded, size_t index) {
    return loaded->obstacles[index].name;
}
tulle_mesh_view tulle_scene_get_obstacle_mesh(const tulle_scene *loaded, size_t index) {
    return tulle_mesh_get_view(&loaded->obstacles[index].mesh);
}
int tulle_scene_is_obstacle_moving(const tulle_scene *loaded, size_t index) {
    const scene_obstacle *const obstacle = &loaded->obstacles[index];
    return obstacle->motion.key_count > 0 || obstacle->sequence ||
           obstacle->keys->dynamic.head.node != NULL;
}

int tulle_scene_is_obstacle_dynamic(const tulle_scene *loaded, size_t index) {
    return loaded->obstacles[index].keys->dynamic.head.node != NULL;
}

const char *tulle_scene_get_canonical_text(const tulle_scene *loaded) {
    return loaded->canonical_text;
}
uint64_t tulle_scene_get_hash(const tulle_scene *loaded) { return loaded->hash; }

size_t tulle_scene_get_note_count(const tulle_scene *loaded) { return loaded->note_count; }
const char *tulle_scene_get_note(const tulle_scene *loaded, size_t index) {
    return loaded->notes[index];
}
