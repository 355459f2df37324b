#!/usr/bin/env python3
"""Writes the meshes of detect.sh into the current folder: small ones with known events as OBJ, and two states of two waving
sheets that go through each other, in every variety of PLY: sheets_* have coordinates that floats hold, fine_* such that only
doubles hold."""
import math
import struct

# name: (positions at the start, positions at the end, triangles)
FLOOR = [(-4, -4, 0), (4, -4, 0), (0, 4, 0)]
SMALL = {
    # A corner comes through the floor's inside at t = 0.5.
    "drop": (FLOOR + [(0, 0, 0.5), (0.1, 0, 5), (0, 0.1, 5)], FLOOR + [(0, 0, -0.5), (0.1, 0, 5), (0, 0.1, 5)],
             [(0, 1, 2), (3, 4, 5)]),
    # An edge of each of two upright triangles, one turned by 90 degrees, meets the other's at t = 0.25.
    "edges": ([(-1, 0, 0), (1, 0, 0), (0, 0, -3), (0, -1, 0.25), (0, 1, 0.25), (0, 0, 3)],
              [(-1, 0, 0), (1, 0, 0), (0, 0, -3), (0, -1, -0.75), (0, 1, -0.75), (0, 0, 3)],
              [(0, 1, 2), (3, 4, 5)]),
    # A corner lies on the floor and leaves it.
    "touching": (FLOOR + [(0, 0, 0), (0.1, 0, 5), (0, 0.1, 5)], FLOOR + [(0, 0, 1), (0.1, 0, 5), (0, 0.1, 5)],
                 [(0, 1, 2), (3, 4, 5)]),
    # Two triangles cross, and stay as they are.
    "crossing": (FLOOR + [(0, 0, -1), (1, 0, 1), (0, 1, 1)],) * 2 + ([(0, 1, 2), (3, 4, 5)],),
    # Nothing comes near anything.
    "apart": (FLOOR + [(0, 0, 1), (1, 0, 2), (0, 1, 2)], FLOOR + [(0, 0, 0.5), (1, 0, 2), (0, 1, 2)],
              [(0, 1, 2), (3, 4, 5)]),
    # Three triangles on an edge, one without area, a vertex without triangles, opposite orientations; the drop's event in it.
    "strange": (FLOOR + [(0, 0, 0.5), (0.1, 0, 5), (0, 0.1, 5), (9, 9, 9), (0.2, 0.2, 5), (0, -0.1, 5), (20, 0, 0), (21, 0, 0),
                         (22, 0, 0)],
                FLOOR + [(0, 0, -0.5), (0.1, 0, 5), (0, 0.1, 5), (9, 9, 9), (0.2, 0.2, 5), (0, -0.1, 5), (20, 0, 0), (21, 0, 0),
                         (22, 0, 0)],
                [(0, 1, 2), (3, 4, 5), (4, 5, 7), (4, 5, 8), (9, 10, 11)]),
}
SIDE = 24  # vertices along a side of a sheet
TYPES = {"float": "f", "double": "d"}
ORDERS = {"ascii": None, "binary_little_endian": "<", "binary_big_endian": ">"}


def write_obj(path, points, triangles):
    with open(path, "w", encoding="ascii") as file:
        file.writelines("v %r %r %r\n" % tuple(point) for point in points)
        file.writelines("f %d %d %d\n" % tuple(i + 1 for i in triangle) for triangle in triangles)


def write_ply(path, points, triangles, kind, order):
    header = f"ply\nformat {order} 1.0\nelement vertex {len(points)}\n"
    header += "".join(f"property {kind} {axis}\n" for axis in "xyz")
    header += f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    with open(path, "wb") as file:
        file.write(header.encode())
        if order == "ascii":
            file.writelines(("%r %r %r\n" % tuple(point)).encode() for point in points)
            file.writelines(("3 %d %d %d\n" % tuple(triangle)).encode() for triangle in triangles)
            return
        mark = ORDERS[order]
        file.writelines(struct.pack(mark + "3" + TYPES[kind], *point) for point in points)
        file.writelines(struct.pack(mark + "B3i", 3, *triangle) for triangle in triangles)


def as_float(value):
    return struct.unpack("<f", struct.pack("<f", value))[0]


def make_sheets(time, narrow):
    """Two sheets, the upper one waving down through the lower one; narrow rounds a coordinate."""
    points, triangles = [], []
    for sheet in range(2):
        first = len(points)
        for row in range(SIDE):
            for column in range(SIDE):
                x, y = row / SIDE + 0.013 * sheet, column / SIDE + 0.007 * sheet
                height = 0.02 * math.sin(7 * x + 3 * time) * math.cos(6 * y)
                points.append(tuple(map(narrow, (x, y, height + sheet * (0.05 - 0.06 * time)))))
        for row in range(SIDE - 1):
            for column in range(SIDE - 1):
                a = first + row * SIDE + column
                triangles += [(a, a + 1, a + SIDE + 1), (a, a + SIDE + 1, a + SIDE)]
    return points, triangles


def main():
    for name, (start, end, triangles) in SMALL.items():
        write_obj(f"{name}_0.obj", start, triangles)
        write_obj(f"{name}_1.obj", end, triangles)
    for state in (0, 1):
        points, triangles = make_sheets(state, float)
        write_obj(f"fine_{state}.obj", points, triangles)
        for order in ORDERS:
            write_ply(f"fine_{state}_double_{order}.ply", points, triangles, "double", order)
        points, triangles = make_sheets(state, as_float)
        write_obj(f"sheets_{state}.obj", points, triangles)
        for kind in TYPES:
            for order in ORDERS:
                write_ply(f"sheets_{state}_{kind}_{order}.ply", points, triangles, kind, order)


main()
