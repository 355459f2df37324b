#!/usr/bin/env python3
"""Makes the three bodies of the scenes in this folder: a mesh (OBJ) and its frames (PC2) each.

    python3 scenes/characters/make_bodies.py [FOLDER]

The bodies move as those of many animations do: their parts pass through one another by some
centimetres. An arm closes into a chest, thighs cross, a knee folds by 160 degrees until calf and
thigh share the same place. Lengths are in metres, z is up.
"""
import math
import os
import struct
import sys

FPS = 60


class Mesh:
    """Closed parts in one list of vertices and triangles."""

    def __init__(self):
        self.vertices, self.triangles = [], []

    def add_tube(self, rings):
        """Adds rings of as many points each, from one end to the other, and closes both ends."""
        around, first = len(rings[0]), len(self.vertices)
        for ring in rings:
            self.vertices += ring
        ends = []
        for ring in (rings[0], rings[-1]):
            ends.append(len(self.vertices))
            self.vertices.append(tuple(sum(p[k] for p in ring) / around for k in range(3)))
        for i in range(around):
            j = (i + 1) % around
            for k in range(len(rings) - 1):
                a, b = first + k * around, first + (k + 1) * around
                self.triangles += [(a + i, a + j, b + j), (a + i, b + j, b + i)]
            last = first + (len(rings) - 1) * around
            self.triangles += [(ends[0], first + j, first + i), (ends[1], last + i, last + j)]


def make_limb(length, radii, step=0.012, around=32):
    """Rings of a limb along z from 0 up to `length`, with round ends. radii: at even distances."""
    def radius(s):
        place = min(max(s / length, 0.0), 1.0) * (len(radii) - 1)
        k = min(int(place), len(radii) - 2)
        return radii[k] + (place - k) * (radii[k + 1] - radii[k])

    stations = []
    for k in range(1, 7):
        turn = math.pi / 2 * k / 6
        stations.append((-radii[0] * math.cos(turn), radii[0] * math.sin(turn)))
    count = max(2, round(length / step))
    stations += [(length * k / count, radius(length * k / count)) for k in range(1, count)]
    for k in range(6, 0, -1):
        turn = math.pi / 2 * k / 6
        stations.append((length + radii[-1] * math.cos(turn), radii[-1] * math.sin(turn)))
    return [[(r * math.cos(2 * math.pi * i / around), r * math.sin(2 * math.pi * i / around), z)
             for i in range(around)] for z, r in stations]


def place(rings, move):
    return [[move(p) for p in ring] for ring in rings]


def turn_about_y(angle, at):
    """Turns by `angle` about the axis through `at` along y, from +z towards +x."""
    c, s = math.cos(angle), math.sin(angle)
    return lambda p: (at[0] + c * p[0] + s * p[2], at[1] + p[1], at[2] - s * p[0] + c * p[2])


def ease(time, begin, end):
    """From 0 to 1 between two times, gently."""
    x = min(max((time - begin) / (end - begin), 0.0), 1.0)
    return x * x * (3.0 - 2.0 * x)


def make_arm(time):
    """A chest and an arm, which closes from level until it is 4 cm deep in the chest, and opens."""
    mesh = Mesh()
    chest = make_limb(0.36, [0.11, 0.12, 0.12, 0.11], around=48)
    mesh.add_tube(place(chest, lambda p: (1.5 * p[0], p[1], p[2] + 0.1)))
    closed = ease(time, 0.6, 1.4) - ease(time, 1.9, 2.7)
    angle = math.radians(90.0 + 93.0 * closed)
    mesh.add_tube(place(make_limb(0.55, [0.052, 0.045, 0.035]),
                        turn_about_y(angle, (0.21, 0.0, 0.5))))
    return mesh


def make_thighs(time):
    """Hips and two legs, which cross until one is some 4 cm deep in the other, twice."""
    mesh = Mesh()
    hips = make_limb(0.14, [0.11, 0.12, 0.11], around=48)
    mesh.add_tube(place(hips, lambda p: (1.45 * p[0], p[1], p[2] + 0.84)))
    closed = ease(time, 0.6, 1.1) - ease(time, 1.4, 1.9) + ease(time, 2.0, 2.5) - ease(time, 2.8, 3.3)
    for side in (-1.0, 1.0):
        angle = math.radians(180.0 - side * (3.0 - 10.0 * closed))
        legs = make_limb(0.68, [0.08, 0.07, 0.052, 0.04])
        mesh.add_tube(place(legs, turn_about_y(angle, (side * 0.088, 0.0, 0.84))))
    return mesh


def make_knee(time):
    """A leg in one piece, level at the thigh, whose knee folds by 160 degrees and opens again."""
    mesh = Mesh()
    fold = math.radians(160.0) * (ease(time, 0.6, 1.6) - ease(time, 2.1, 3.1))
    length, knee, width = 0.84, 0.42, 0.09

    def move(p):
        # the share of the shank in the turn about the knee, as a skin of two bones has it
        share = ease(p[2], knee - width, knee + width)
        c, s = math.cos(fold), math.sin(fold)
        x, z = p[0], p[2] - knee
        bent = (c * x - s * z, p[1], s * x + c * z)
        return ((1 - share) * x + share * bent[0], p[1], (1 - share) * z + share * bent[2])

    def lay(p):
        # the thigh along x, the shank folds below it
        return (p[2] + 0.0, p[1], p[0] + 0.6)

    mesh.add_tube(place(make_limb(length, [0.08, 0.075, 0.06, 0.058, 0.05, 0.038]),
                        lambda p: lay(move(p))))
    return mesh


BODIES = {"arm": (make_arm, 3.2), "thighs": (make_thighs, 3.8), "knee": (make_knee, 3.6)}


def main():
    folder = sys.argv[1] if len(sys.argv) > 1 else os.path.dirname(os.path.abspath(__file__))
    for name, (make, duration) in BODIES.items():
        frames = int(duration * FPS) + 1
        first = make(0.0)
        with open(os.path.join(folder, name + ".obj"), "w", encoding="ascii") as file:
            file.writelines("v %.9g %.9g %.9g\n" % v for v in first.vertices)
            file.writelines("f %d %d %d\n" % tuple(i + 1 for i in t) for t in first.triangles)
        with open(os.path.join(folder, name + ".pc2"), "wb") as file:
            count = len(first.vertices)
            file.write(struct.pack("<12siiffi", b"POINTCACHE2\0", 1, count, 0.0, 1.0, frames))
            for frame in range(frames):
                points = [c for v in make(frame / FPS).vertices for c in v]
                file.write(struct.pack("<%df" % len(points), *points))
        print("%s: %d vertices, %d triangles, %d frames" % (name, count, len(first.triangles), frames))


if __name__ == "__main__":
    main()
