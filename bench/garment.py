#!/usr/bin/env python3
"""Makes a garment to measure with: a dress with sleeves, collar and skirt on a body that twists, swings its arms and walks.

usage: garment.py FOLDER      writes garment.yaml, dress_2.5k.obj, dress_10k.obj, body.obj and body.pc2 there

The dress is a mesh as programs for garments give it: triangles of even size without rows, vertices and triangles numbered at
random. It has 5,000 or 20,000 triangles (2.5k or 10k vertices), the body 25,000. Dress and body are surfaces around capsules that
blend into each other. Lengths are in metres, z is up, x is to the body's left, the body looks to -y.
"""
import math
import random
import struct
import sys
from pathlib import Path

FPS, FRAME_COUNT = 60, 121
BLEND = 0.045  # [m] width over which two capsules blend
BODY_CELL = 0.01408  # [m] of a lattice, about the length of an edge: 25,052 triangles
DRESS_CELLS = {"2.5k": 0.0288, "10k": 0.0146}  # [m] 4,968 and 19,960 triangles
LOWEST, HIGHEST, CUFF = 0.5, 1.5, 0.6  # [m] where the dress ends: hem, collar, sleeves
SLACK = 0.012  # [m] from the body to the dress

# End, radius, end, radius. The arms are level in the pose that the dress is made for.
TRUNK = [((-0.07, 0, 0.93), 0.115, (0.07, 0, 0.93), 0.115), ((0, 0, 0.95), 0.115, (0, 0, 1.15), 0.115),
         ((-0.07, 0, 1.27), 0.12, (0.07, 0, 1.27), 0.12), ((-0.14, 0, 1.4), 0.065, (0.14, 0, 1.4), 0.065)]
NECK = [((0, 0, 1.4), 0.055, (0, 0, 1.56), 0.055)]
ARM = [((0.16, 0, 1.4), 0.052, (0.43, 0, 1.4), 0.042), ((0.43, 0, 1.4), 0.042, (0.68, 0, 1.4), 0.033)]
REST = [((0, -0.01, 1.62), 0.09, (0, -0.01, 1.68), 0.095)]  # a head; then what each side has
SIDE = [((0.7, 0, 1.4), 0.036, (0.78, 0, 1.4), 0.034), ((0.1, 0, 0.88), 0.085, (0.11, 0, 0.48), 0.058),
        ((0.11, 0, 0.48), 0.055, (0.12, 0.01, 0.08), 0.04), ((0.12, 0, 0.06), 0.042, (0.12, -0.15, 0.05), 0.036)]
SKIRT = [((0, 0, 0.98), 0.16, (0, 0, 0.3), 0.31)]

SCENE = """# A dress on a body that twists, swings its arms and walks: sleeves on arms, a skirt that legs push. bench/garment.py made it.
title: a dress on a moving body
time: {step: 1/90 s, duration: 2 s, steps_per_frame: 1}
cloth:
  - name: dress
    mesh: {file: dress_2.5k.obj}
    material: {preset: cotton}
obstacles:
  - name: body
    mesh: {file: body.obj}
    friction: 0.3
    motion: {sequence: {cache: body.pc2, fps: 60}}
contact: {delta_c: 2 mm}
"""


# ---- points ----

def add(p, q, factor=1.0):
    return (p[0] + factor * q[0], p[1] + factor * q[1], p[2] + factor * q[2])


def dot(p, q):
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]


def cross(p, q):
    return (p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0])


def mirror(capsules):
    return [((-a[0], *a[1:]), r, (-b[0], *b[1:]), s) for a, r, b, s in capsules]


def both_sides(capsules):
    return capsules + mirror(capsules)


def widen(capsules, by):
    return [(a, r + by, b, s + by) for a, r, b, s in capsules]


# ---- a surface around capsules ----

def make_distance(capsules):
    """About the distance of a point to the surface around all capsules, below 0 inside."""
    parts = []
    for a, r, b, s in capsules:
        axis = add(b, a, -1.0)
        parts.append((a, axis, 1.0 / dot(axis, axis), r, s - r))

    def measure(p):
        least = 1e9
        for a, axis, scale, radius, growth in parts:
            x, y, z = p[0] - a[0], p[1] - a[1], p[2] - a[2]
            t = min(max((x * axis[0] + y * axis[1] + z * axis[2]) * scale, 0.0), 1.0)
            x, y, z = x - t * axis[0], y - t * axis[1], z - t * axis[2]
            distance = math.sqrt(x * x + y * y + z * z) - radius - t * growth
            overlap = BLEND - abs(least - distance)
            least = min(least, distance)
            if overlap > 0.0:
                least -= overlap * overlap / (4.0 * BLEND)
        return least

    return measure


def settle(measure, p):
    """The point of the surface near p, by a step of Newton's method."""
    h, value = 1e-4, measure(p)
    slope = ((measure((p[0] + h, p[1], p[2])) - value) / h, (measure((p[0], p[1] + h, p[2])) - value) / h,
             (measure((p[0], p[1], p[2] + h)) - value) / h)
    return add(p, slope, -value / max(dot(slope, slope), 1e-12))


def net_surface(measure, cell, is_kept):
    """Points and triangles of the surface where cells of a lattice, which is_kept chooses, meet it (surface nets)."""
    values, points, found, waiting = {}, [], {}, []

    def get(corner):
        if corner not in values:
            values[corner] = measure(tuple(cell * (k + 0.5) for k in corner))
        return values[corner]

    corners = [(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    edges = [(a, b) for a in corners for b in corners if a < b and sum(x != y for x, y in zip(a, b)) == 1]

    def visit(at):
        if at in found:
            return
        found[at] = None
        here = [get(add(at, corner)) for corner in corners]
        if min(here) >= 0.0 or max(here) < 0.0 or not is_kept(tuple(cell * (k + 1) for k in at)):
            return
        total, count = (0.0, 0.0, 0.0), 0
        for a, b in edges:
            va, vb = here[corners.index(a)], here[corners.index(b)]
            if (va < 0.0) != (vb < 0.0):
                share = va / (va - vb)
                total, count = add(total, add(add(a, at), add(b, a, -1.0), share)), count + 1
        found[at] = len(points)
        points.append(settle(measure, tuple(cell * (x / count + 0.5) for x in total)))
        waiting.append(at)

    first = (0, 0, math.floor(1.0 / cell))  # inside the trunk; from there along x to the surface
    while not waiting:
        visit(first)
        first = (first[0] + 1, *first[1:])
    while waiting:
        at = waiting.pop()
        for k in range(3):
            for side in (-1, 1):
                visit(tuple(x + side * (i == k) for i, x in enumerate(at)))
    triangles = []
    for at in sorted(key for key, point in found.items() if point is not None):
        for k in range(3):
            u, v = (k + 1) % 3, (k + 2) % 3
            low, high = get(at), get(tuple(x + (i == k) for i, x in enumerate(at)))
            if (low < 0.0) == (high < 0.0):
                continue
            ring = [found.get(tuple(x - du * (i == u) - dv * (i == v) for i, x in enumerate(at)))
                    for du, dv in ((0, 0), (1, 0), (1, 1), (0, 1))]
            if None in ring:
                continue
            a, b, c, d = ring if low < 0.0 else ring[::-1]
            if math.dist(points[a], points[c]) > math.dist(points[b], points[d]):
                a, b, c, d = b, c, d, a
            triangles += [(a, b, c), (a, c, d)]
    used = sorted({corner for triangle in triangles for corner in triangle})
    number = {old: new for new, old in enumerate(used)}
    return [points[i] for i in used], [tuple(number[i] for i in triangle) for triangle in triangles]


# ---- a mesh without rows ----

class Irregular:
    """A mesh whose points are scattered on their surface and then relax, while edges flip to what Delaunay's rule says."""

    def __init__(self, measure, points, triangles):
        self.measure, self.points = measure, points
        self.opposite = {}  # of an edge as its triangle goes around: the third corner
        for a, b, c in triangles:
            self.opposite.update({(a, b): c, (b, c): a, (c, a): b})

    def get_triangles(self):
        return [(a, b, c) for (a, b), c in sorted(self.opposite.items()) if a < b and a < c]

    def normal(self, a, b, c):
        p = self.points[a]
        return cross(add(self.points[b], p, -1.0), add(self.points[c], p, -1.0))

    def angle(self, a, c, b):
        """Of a triangle at its corner c."""
        u, v = add(self.points[a], self.points[c], -1.0), add(self.points[b], self.points[c], -1.0)
        w = cross(u, v)
        return math.atan2(math.sqrt(dot(w, w)), dot(u, v))

    def flip_where_due(self):
        waiting = sorted(edge for edge in self.opposite if edge[0] < edge[1])
        while waiting:
            a, b = waiting.pop()
            if (a, b) not in self.opposite or (b, a) not in self.opposite:
                continue
            c, d = self.opposite[a, b], self.opposite[b, a]
            if self.angle(a, c, b) + self.angle(a, d, b) <= math.pi + 1e-9 or (c, d) in self.opposite or (d, c) in self.opposite:
                continue
            if dot(self.normal(a, d, c), self.normal(d, b, c)) <= 0.0:
                continue
            del self.opposite[a, b], self.opposite[b, a]
            self.opposite.update({(a, d): c, (d, c): a, (c, a): d, (d, b): c, (b, c): d, (c, d): b})
            waiting += [(a, d), (d, b), (b, c), (c, a)]

    def relax(self, share):
        """Moves each point towards the mean of its neighbours; of an edge of the mesh towards that of its two along it."""
        around = [[] for _ in self.points]
        along = [[] for _ in self.points]
        for a, b in sorted(self.opposite):
            if (b, a) in self.opposite:
                around[a].append(b)
            else:
                along[a].append(b)
                along[b].append(a)
        moved = []
        for point, ring, rim in zip(self.points, around, along):
            near = rim or ring
            mean = tuple(sum(self.points[i][k] for i in near) / len(near) for k in range(3))
            moved.append(settle(self.measure, add(point, add(mean, point, -1.0), share)))
        self.points = moved

    def scatter(self, chance, distance):
        self.points = [settle(self.measure, tuple(x + distance * (2.0 * chance.random() - 1.0) for x in point))
                       for point in self.points]


def shuffle(points, triangles, chance):
    """The same mesh, its vertices and triangles numbered at random."""
    order = sorted(range(len(points)), key=[chance.random() for _ in points].__getitem__)
    number = {old: new for new, old in enumerate(order)}
    order_of_triangles = sorted(range(len(triangles)), key=[chance.random() for _ in triangles].__getitem__)
    return [points[i] for i in order], [tuple(number[i] for i in triangles[t]) for t in order_of_triangles]


def make_dress(cell):
    """Points and triangles of the dress."""
    measure = make_distance(widen(TRUNK + NECK, SLACK) + both_sides(widen(ARM, 1.5 * SLACK)) + SKIRT)
    mesh = Irregular(measure, *net_surface(measure, cell, lambda p: LOWEST < p[2] < HIGHEST and abs(p[0]) < CUFF))
    chance = random.Random(63)
    for _ in range(3):
        mesh.scatter(chance, 0.3 * cell)
        mesh.flip_where_due()
    for _ in range(10):
        mesh.relax(0.5)
        mesh.flip_where_due()
    return shuffle(mesh.points, mesh.get_triangles(), chance)


# ---- the body ----

def ease(x, begin, end):
    """From 0 to 1 between two places, gently."""
    t = min(max((x - begin) / (end - begin), 0.0), 1.0)
    return t * t * (3.0 - 2.0 * t)


def turn(p, center, axis, angle):
    """Turns a point about an axis, 0 to 2 for x to z, through the center."""
    u, v = (axis + 1) % 3, (axis + 2) % 3
    c, s = math.cos(angle), math.sin(angle)
    q = list(p)
    q[u] = center[u] + c * (p[u] - center[u]) - s * (p[v] - center[v])
    q[v] = center[v] + s * (p[u] - center[u]) + c * (p[v] - center[v])
    return tuple(q)


def pose(p, time):
    """Where a point of the body is at a time [s]. Near a joint a point takes a share of its turn, as skins do."""
    side = 1.0 if p[0] >= 0.0 else -1.0
    swing = ease(time, 0.2, 0.9) * math.sin(2.0 * math.pi * 0.9 * time)
    across = abs(p[0])
    q = p
    arm = ease(across, 0.12, 0.26) * ease(p[2], 1.2, 1.32)
    if arm > 0.0:
        elbow, shoulder = (side * 0.43, 0.0, 1.4), (side * 0.17, 0.0, 1.4)
        q = turn(q, elbow, 2, -side * 0.9 * ease(time, 0.3, 1.0) * ease(across, 0.38, 0.48) * arm)
        q = turn(q, shoulder, 1, side * math.radians(50.0) * ease(time, 0.0, 0.9) * arm)
        q = turn(q, shoulder, 0, side * 0.4 * swing * arm)
    leg = ease(across, 0.0, 0.05) * (1.0 - ease(p[2], 0.8, 0.96))
    if leg > 0.0:
        bend = 0.5 * ease(time, 0.2, 0.9) * (1.0 + side * math.cos(2.0 * math.pi * 0.9 * time))
        q = turn(q, (side * 0.11, 0.0, 0.48), 0, -0.7 * bend * (1.0 - ease(p[2], 0.42, 0.54)))
        q = turn(q, (side * 0.1, 0.0, 0.9), 0, side * 0.5 * swing * leg)
    q = turn(q, (0.0, 0.0, 1.0), 2, 0.2 * swing * ease(p[2], 0.95, 1.3))
    return add(q, (0.02 * swing, 0.0, 0.012 * swing * swing))


def make_body(cell):
    measure = make_distance(TRUNK + NECK + both_sides(ARM) + REST + both_sides(SIDE))
    mesh = Irregular(measure, *net_surface(measure, cell, lambda p: True))
    for _ in range(3):
        mesh.relax(0.5)
        mesh.flip_where_due()
    return mesh.points, mesh.get_triangles()


# ---- files ----

def write_obj(path, points, triangles):
    with open(path, "w", encoding="ascii") as file:
        file.writelines("v %.6f %.6f %.6f\n" % point for point in points)
        file.writelines("f %d %d %d\n" % tuple(i + 1 for i in triangle) for triangle in triangles)


def write_motion(path, points, frame_count):
    with open(path, "wb") as file:
        file.write(struct.pack("<12siiffi", b"POINTCACHE2\0", 1, len(points), 0.0, 1.0, frame_count))
        for frame in range(frame_count):
            values = [x for point in points for x in pose(point, frame / FPS)]
            file.write(struct.pack("<%df" % len(values), *values))


def write_files(folder, dress_cells, body_cell, frame_count):
    """Writes the scene last: where it is, the meshes are whole."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    for name, cell in dress_cells.items():
        write_obj(folder / f"dress_{name}.obj", *make_dress(cell))
    points, triangles = make_body(body_cell)
    write_obj(folder / "body.obj", points, triangles)
    write_motion(folder / "body.pc2", points, frame_count)
    (folder / "garment.yaml").write_text(SCENE, encoding="utf-8")


def main(words):
    if len(words) != 1 or words[0].startswith("-"):
        sys.exit(__doc__)
    write_files(words[0], DRESS_CELLS, BODY_CELL, FRAME_COUNT)


if __name__ == "__main__":
    main(sys.argv[1:])
