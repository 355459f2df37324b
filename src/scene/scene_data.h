/* scene/scene_data.h - what a loaded scene holds, for the files of this folder. */
#ifndef TULLE_SCENE_SCENE_DATA_H
#define TULLE_SCENE_SCENE_DATA_H

#include "scene/frame_cache.h"
#include "scene/keys.h"
#include "scene/pose.h"

#include "tulle/mesh.h"
#include "tulle_io/mesh_files.h"

enum {
    SCENE_OBJECT_LIMIT = 4096,      /* cloths, and obstacles with their copies */
    SCENE_VERTEX_LIMIT = 20000000,  /* of all objects together */
    SCENE_FRAME_LIMIT = 10000000,   /* written frames */
    SCENE_SEQUENCE_LIMIT = 1000000, /* frames of one mesh sequence */
    SCENE_PATH_LIMIT = 4096,        /* [bytes] of a path */
    SCENE_NOTE_LIMIT = 20           /* notes; one more tells that there are others */
};

typedef struct scene_sequence scene_sequence;

/* Where a mesh goes: x -> turn (scale * x). */
typedef struct placement {
    double scale[3];
    pose turn; /* the length of its quaternion is divided out by tulle_mesh_transform */
} placement;

/* Vertices of a cloth and the object that holds them, counted as cloths and obstacles together. */
typedef struct scene_attachment {
    const attach_keys *keys;
    uint32_t *vertices;
    size_t vertex_count, object;
} scene_attachment;

typedef struct scene_cloth {
    const cloth_keys *keys;
    const char *name;
    const char *contact_material;
    placement place;          /* before it is translated */
    tulle_mesh mesh;          /* at the start */
    tulle_mesh_source source; /* what its file has beside; while the scene is loaded */
    tulle_material material;
    /* At rest, as of tulle_cloth_def; null: not given. */
    double *rest_positions, *rest_corners, *warps;
    double *stiffness_factors;
    bool has_flat_rest;
    tulle_crease *creases;
    size_t crease_count;
    tulle_pin *pins;
    size_t pin_count;
    scene_attachment *attachments;
    size_t attachment_count;
} scene_cloth;

typedef struct scene_obstacle {
    const obstacle_keys *keys;
    const char *name;
    const char *contact_material; /* null: none */
    tulle_mesh mesh;              /* at the start, or frame 0 */
    placement place;              /* of the mesh and all frames, whole */
    double grain[3];
    tulle_motion motion;
    scene_sequence *sequence; /* null: none */
    double appears, disappears, delay;
} scene_obstacle;

/* A law for every object of one range against every one of another; cloths and obstacles counted
 * together, cloths first. The first range begins with a cloth. */
typedef struct scene_pair {
    const pair_keys *keys;
    size_t first_begin, first_end, second_begin, second_end;
} scene_pair;

struct tulle_scene {
    memory heap;
    arena storage; /* everything but the meshes and open files */
    const char *path;
    const char *text; /* in place of what the file holds, while the scene is loaded; null: that */
    size_t text_length;
    scene_keys keys;
    uint32_t frame_count;
    scene_cloth *cloths;
    size_t cloth_count;
    scene_obstacle *obstacles;
    size_t obstacle_count;
    scene_pair *pairs;
    size_t pair_count;
    size_t vertex_count;   /* of all objects so far */
    uint64_t content_hash; /* of meshes and sequences so far */
    const char *canonical_text;
    uint64_t hash;
    const char *notes[SCENE_NOTE_LIMIT + 1];
    size_t note_count;
};

/* A scene while it is being made: where its objects come from and where problems go. */
typedef struct scene_work {
    tulle_scene *scene;
    tulle_scene_problems *problems;
} scene_work;

/* Reads the file named by the scene's path into its keys: text, tree, overrides, keys. False after
 * a problem. */
bool read_scene_keys(const scene_work *work, const char *const *overrides, size_t count);
/* Keys of the picture that do not go together. False after a problem. */
bool check_picture(const scene_work *work);
/* A path of the scene file made relative to it; null after a problem. */
const char *resolve_path(const scene_work *work, const char *path);
/* Text formatted into the scene's storage; null after a problem. */
const char *store_text(const scene_work *work, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
/* The value of a seed key. */
uint64_t resolve_seed(const tulle_scene *loaded, uint64_t seed);

/* Adds a note for tulle_scene_get_note. */
void note_add(const scene_work *work, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
/* [s] */
double scene_get_end(const scene_work *work);
/* Notes things that come only when the scene is over. `what`: with a verb; `time`: [s] */
void note_late(const scene_work *work, const char *path, const char *what, double time);
/* A mesh as its file has it, or as it was generated: then metres, z up. */
typedef struct source_mesh {
    tulle_mesh *mesh;
    file_axes axes;
    bool is_of_file;
    uint64_t polygons_hash; /* as of tulle_mesh_source */
    double extent;          /* of its largest frame, in units of the file; 0: it has no frames */
} source_mesh;
/* Reads a mesh file, or the first frame of an animation; drops what an obstacle has twice, and what
 * has no area unless it deforms; validates the mesh for its role unless it deforms (sequence_open
 * does); notes what was passed over and dropped. An error names the file, and the line where it has
 * lines. `kept`, if not null, gets the contents that the reader found; an error leaves it as it is.
 */
tulle_status read_mesh(const scene_work *work, const char *path, tulle_mesh_role role,
                       source_mesh *made, tulle_mesh_source *kept, tulle_error *error);
/* Of triangles that an obstacle has twice, one is as good as two: drops the other, and notes it. */
tulle_status drop_duplicates(const scene_work *work, const char *path, tulle_mesh *mesh,
                             tulle_mesh_source *source, tulle_error *error);
/* Triangles of an obstacle that have no area. */
typedef struct flat_triangles {
    const uint8_t *marks; /* 1 for each of them, 0 for the others */
    const char *when;     /* nothing, or " in any frame" */
    uint32_t *lines;      /* of all triangles in their file, or null */
} flat_triangles;
/* Drops them, and notes it. Error: none is left. */
tulle_status drop_flat(const scene_work *work, const char *path, tulle_mesh *mesh,
                       const flat_triangles *flat, tulle_error *error);
/* As read_mesh, or generates a mesh and validates it for its role; `source` as `kept`, left as it
 * is for a generated one. False after a problem. */
bool make_mesh(const scene_work *work, const mesh_keys *keys, tulle_mesh_role role,
               source_mesh *made, tulle_mesh_source *source);
/* Adds a mesh to the scene's count of vertices and to its hash. False when that is too many. */
bool count_mesh(const scene_work *work, const tulle_mesh *mesh, scene_place place,
                const char *path);

/* Fills keys from keyframes: along the axes of `axes`, delayed. False after a problem. */
bool make_motion(const scene_work *work, const schema_list *keyframes, const pose *axes,
                 double delay, tulle_motion *motion);

/* Which keys say where a mesh goes. */
typedef struct placement_keys {
    const schema_vector *scale;
    const schema_rotation *rotate;
    const place_keys *place;
} placement_keys;
/* Finds where a mesh goes. Where the keys do not say which axis is up, or a scale, the axes and the
 * unit of the file count. Notes a size that speaks of another unit; `name` is that of the object.
 * False after a problem. */
bool find_placement(const scene_work *work, const placement_keys *keys, const source_mesh *source,
                    const char *name, placement *result);
/* Moves a cloth's mesh, or its rest mesh, to its place. */
void place_cloth_mesh(const scene_cloth *cloth, tulle_mesh *mesh);
/* The obstacles of one name made so far: one, or all copies of an entry. False where there is none.
 */
bool find_obstacles(const tulle_scene *loaded, const char *name, size_t *begin, size_t *end);
/* The end of a message about a name that no object has: how copies of it count, or the nearest of
 * `names`, which may be null; or nothing. */
const char *tell_meant(const scene_work *work, const char *name, const char **names, size_t count);
/* Adds a problem about a name that no obstacle has. Always false. */
bool refuse_obstacle_name(const scene_work *work, const void *keys, const char *key,
                          const char *name);

/* Makes a cloth with its pins. False after a problem; the mesh is then destroyed with the scene. */
bool make_cloth(const scene_work *work, const cloth_keys *keys, size_t index, scene_cloth *cloth);
/* Fills the cloth's material and its name in contacts. False after a problem. */
bool make_material(const scene_work *work, const material_keys *keys, scene_cloth *cloth);
/* make_material.c: whether the scene itself says that its cloth is made of springs. Where an
 * override says so, keys of the file may be left without a use. */
bool scene_has_springs(const scene_work *work);
/* Whether the grain of an entry has a direction. False with a problem. */
bool check_grain(const scene_work *work, const schema_head *head, const schema_vector *grain);
/* Fills what is at rest. False after a problem. */
bool make_rest(const scene_work *scene, const cloth_keys *keys, scene_cloth *cloth);
bool make_pins(const scene_work *work, scene_cloth *cloth);
/* The vertices that an entry means: `keys` is the entry, a struct of `map`. */
typedef struct vertex_choice {
    const schema_map *map;
    const void *keys;
    const choice_keys *where;
} vertex_choice;
/* Adds `mark` to the marks of these vertices of a cloth. False after a problem. */
bool choose_vertices(const scene_work *work, const scene_cloth *cloth, const vertex_choice *choice,
                     unsigned char mark, unsigned char *marks);
/* Whether the entry names a group or a material of the cloth's file. */
bool names_part(const vertex_choice *choice);
/* Sets the flags of that part's triangles. False after a problem: there is no such part. */
bool choose_part(const scene_work *work, const scene_cloth *cloth, const vertex_choice *choice,
                 unsigned char *flags);
/* Adds `mark` to the marks of the vertices that are at most `within` [m] from the triangles of an
 * obstacle, both as they start. False after a problem. */
bool mark_near(const scene_work *work, const tulle_mesh *mesh, const tulle_mesh *obstacle,
               double within, unsigned char mark, unsigned char *marks);
/* [m] */
double measure_to_segment(const double a[3], const double b[3], const double point[3]);
/* Adds a problem that tells where the cloth lies. Always false. */
bool refuse_empty_choice(const scene_work *work, const tulle_mesh *mesh, const schema_head *head,
                         const char *problem);

/* Makes an obstacle and all its copies at *obstacles, which has room for copy_count. */
size_t count_copies(const obstacle_keys *keys);
bool make_obstacles(const scene_work *work, const obstacle_keys *keys, size_t index,
                    scene_obstacle *obstacles);
/* Where each of `count` copies stands in the obstacle's frame. */
void place_copies(const copies_keys *keys, size_t count, pose *poses);

/* Whether the map of `keys` asks for no more dynamic friction than static. False after a problem.
 */
bool check_dynamic_friction(const scene_work *work, const void *keys, double dynamic,
                            double friction);
/* The name of a cloth or an obstacle; `object` counts both, cloths first. */
const char *get_object_name(const tulle_scene *loaded, size_t object);
/* Attachments of all cloths, after all objects are made. False after a problem. */
bool make_attachments(const scene_work *work);
/* Names of contact.pairs resolved and those of contact.materials checked, after all objects are
 * made. False after a problem. */
bool make_pairs(const scene_work *work);

/* A mesh sequence. `made` is the obstacle's mesh, or an empty one to take that of the first file or
 * of an animation, whose axes count then. Every frame is read once to check it,
 * and adds to the scene's hash. Null after a problem. */
scene_sequence *sequence_open(const scene_work *work, const obstacle_keys *keys, source_mesh *made);
/* A second reader of the same frames with its own placement, `delay` [s] later; null after a
 * problem. */
scene_sequence *sequence_place(const scene_work *work, const scene_sequence *origin,
                               const placement *where, double delay);
/* Closes what is open; it opens again when a frame is read. Null is fine. */
void sequence_close(scene_sequence *sequence);
/* Frames that the world may ask for; more than it can ever reach where the sequence loops. */
uint32_t sequence_get_frame_count(const scene_sequence *sequence);
/* [s] When the first frame is that the world may ask for. */
double sequence_get_start(const scene_sequence *sequence);
/* [s] From one frame of the world to the next: those of the file, or, where it has times of its
 * own, the steps of the scene. */
double sequence_get_interval(const scene_sequence *sequence);
/* A tulle_frame_reader; context is the sequence. */
tulle_status sequence_read(void *context, uint32_t frame, double *positions, tulle_error *error);

#endif
