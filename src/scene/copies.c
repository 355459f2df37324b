/* scene/copies.c - where the copies of an obstacle stand: in a row, a grid, on a ring, on a spiral
 * over a sphere. */
#include "scene/scene_data.h"

#include <math.h>

size_t count_copies(const obstacle_keys *keys) {
    const copies_keys *copies = &keys->copies;
    if (!copies->head.node) return 1;
    if (schema_is_given(&copies_map, copies, "row")) return (size_t)copies->row.count;
    if (schema_is_given(&copies_map, copies, "ring")) return (size_t)copies->ring.count;
    if (schema_is_given(&copies_map, copies, "spiral")) return (size_t)copies->spiral.count;
    const schema_integers *count = &copies->grid.count; /* each 1 .. 4096: no overflow */
    return (size_t)(count->value[0] * count->value[1] * (count->count == 3 ? count->value[2] : 1));
}

static void place_row(const row_keys *row, size_t count, pose *poses) {
    for (size_t i = 0; i < count; i++) {
        poses[i] = POSE_IDENTITY;
        for (int k = 0; k < 3; k++) poses[i].translation[k] = (double)i * row->offset.value[k];
    }
}

static void place_grid(const grid_keys *grid, size_t count, pose *poses) {
    size_t sizes[3] = {1, 1, 1};
    for (size_t k = 0; k < grid->count.count; k++) sizes[k] = (size_t)grid->count.value[k];
    for (size_t i = 0; i < count; i++) {
        size_t index[3] = {i % sizes[0], i / sizes[0] % sizes[1], i / sizes[0] / sizes[1]};
        poses[i] = POSE_IDENTITY;
        for (int k = 0; k < 3; k++)
            poses[i].translation[k] =
                ((double)index[k] - 0.5 * (double)(sizes[k] - 1)) * grid->spacing.value[k];
    }
}

static const double axis_y[3] = {0, 1, 0}, axis_z[3] = {0, 0, 1};

static void place_ring(const ring_keys *ring, size_t count, pose *poses) {
    for (size_t i = 0; i < count; i++) {
        double angle = ring->from + 6.283185307179586 * (double)i / (double)count;
        make_rotation(axis_z, angle, poses[i].rotation);
        poses[i].translation[0] = ring->radius * cos(angle);
        poses[i].translation[1] = ring->radius * sin(angle);
        poses[i].translation[2] = 0;
    }
}

/* Arc length per polar angle of the spiral azimuth = rate * (polar - from), for radius 1. */
static double spiral_speed(double polar, double rate) {
    return sqrt(1 + rate * rate * sin(polar) * sin(polar));
}

/* Walks the spiral in small pieces and sets a copy down whenever its share of the length is passed,
 * so that copies stand at even distances along the curve. */
static void place_spiral(const spiral_keys *spiral, size_t count, pose *poses) {
    enum { piece_count = 4096 }; /* a piece is far shorter than a distance between copies */
    double span = spiral->to - spiral->from;
    double rate = span != 0 ? 6.283185307179586 * spiral->turns / span : 0;
    double width = span / piece_count, length = 0, walked = 0;
    for (int p = 0; p < piece_count; p++)
        length += spiral_speed(spiral->from + (p + 0.5) * width, rate);
    size_t next = 0;
    for (int p = 0; p < piece_count && next < count; p++) {
        double piece = spiral_speed(spiral->from + (p + 0.5) * width, rate);
        for (; next < count; next++) {
            double target = count > 1 ? length * (double)next / (double)(count - 1) : 0;
            bool is_last = p == piece_count - 1;
            if (target > walked + piece && !is_last) break;
            double within = (target - walked) / piece;
            double polar = spiral->from + (p + (within < 1 ? within : 1)) * width;
            double azimuth = rate * (polar - spiral->from), tilt[4], turn[4];
            make_rotation(axis_y, polar, tilt);
            make_rotation(axis_z, azimuth, turn);
            multiply_rotations(turn, tilt, poses[next].rotation);
            const double pole[3] = {0, 0, spiral->radius};
            rotate_vector(poses[next].rotation, pole, poses[next].translation);
        }
        walked += piece;
    }
}

void place_copies(const copies_keys *keys, size_t count, pose *poses) {
    if (!keys->head.node)
        poses[0] = POSE_IDENTITY;
    else if (schema_is_given(&copies_map, keys, "row"))
        place_row(&keys->row, count, poses);
    else if (schema_is_given(&copies_map, keys, "grid"))
        place_grid(&keys->grid, count, poses);
    else if (schema_is_given(&copies_map, keys, "ring"))
        place_ring(&keys->ring, count, poses);
    else
        place_spiral(&keys->spiral, count, poses);
}
