"""Drawings of docs/method: detection."""
import math

from drawing import (BLUE, BLUE_FILL, GREEN, GREEN_FILL, GREY, INK, ORANGE, ORANGE_FILL, PALE, RED, RED_FILL, Drawing, along,
                     turned)


def draw_chord():
    d = Drawing(620, 220, "An obstacle that stops in the middle of its turn stands on its chords")
    centre = (170, 190)
    start, end = (320, 190), turned((320, 190), centre, 80)
    d.arc(centre, 150, 0, 80, GREY, dash="5 4")
    d.line(start, end, BLUE)
    d.arrow(centre, start, INK)
    d.arrow(centre, end, INK)
    middle = along(start, end, 0.5)
    d.arrow(centre, middle, ORANGE)
    d.dot(middle, ORANGE)
    d.text(328, 194, "x0")
    d.text(end[0] - 8, end[1] - 8, "x1")
    d.text(320, 66, "the script: an arc", GREY)
    d.line((316, 68), (289, 86), GREY, 1)
    d.text(400, 102, "time shortened by half: the vertex is\nnearer to the axis than the script says", ORANGE)
    d.line((396, 102), (middle[0] + 7, middle[1]), ORANGE, 1)
    d.text(400, 160, "the path of a step: its chord", BLUE)
    d.line((396, 156), (along(start, end, 0.2)), BLUE, 1)
    return d


def surface(x):
    return 150 - 46 * math.sin(x / 72) - 12 * math.sin(x / 31)


def draw_patch():
    d = Drawing(660, 250, "Triangles of a patch look the same way; its contour does not cross itself")
    points = [(40 + 22 * i, surface(22 * i)) for i in range(12)]
    d.path(points, INK, 2.4)
    for i in range(0, 11):
        a, b = points[i], points[i + 1]
        m = along(a, b, 0.5)
        length = math.hypot(b[0] - a[0], b[1] - a[1])
        n = ((b[1] - a[1]) / length, -(b[0] - a[0]) / length)
        d.arrow(m, (m[0] + 28 * n[0], m[1] + 28 * n[1]), BLUE, 1.2, head=6)
    for p in points:
        d.dot(p, INK, 2.2)
    axis = (330, 190)
    d.polygon([axis, (297, 84), (363, 84)], BLUE, BLUE_FILL, 1, opacity="0.7")
    d.arrow(axis, (330, 62), BLUE, 2)
    d.text(338, 64, "axis zeta", BLUE)
    d.text(372, 92, "all normals, for the\nwhole step, lie within\nthe cone of alpha", BLUE, size=12)
    for i, p in enumerate(points):
        if i in (0, 11):
            d.line(p, (p[0], 222), GREY, 1, "3 4")
    d.line((40, 222), (282, 222), ORANGE, 3)
    d.text(160, 242, "seen along zeta", ORANGE, "middle")
    loop = [(580 + 58 * math.cos(t / 18 * math.pi) * (1 + 0.18 * math.sin(5 * t / 18 * math.pi)),
             148 + 52 * math.sin(t / 18 * math.pi) * (1 + 0.18 * math.sin(5 * t / 18 * math.pi))) for t in range(36)]
    d.polygon(loop, ORANGE, ORANGE_FILL, 2)
    d.text(580, 232, "contour: simple at all times", ORANGE, "middle", 12)
    return d


def draw_ramp():
    d = Drawing(640, 250, "A spiral ramp: all normals lie within the cone, yet its turns lie above one another")
    for k in range(26):
        a0, a1 = math.radians(20.8 * k), math.radians(20.8 * (k + 1))
        quad = []
        for a, r in ((a0, 52), (a0, 110), (a1, 110), (a1, 52)):
            quad.append((165 + r * math.cos(a), 190 - 5.2 * (a * 180 / math.pi) / 20.8 + 0.32 * r * math.sin(a)))
        d.polygon(quad, INK, BLUE_FILL if k < 13 else "#b6d4f2", 0.9, opacity="0.92")
    d.text(165, 240, "a ramp of one and a half turns", INK, "middle")
    d.arrow((290, 150), (290, 60), BLUE, 2)
    d.text(298, 66, "zeta", BLUE)
    centre = (480, 126)
    outer = [(centre[0] + (104 - 0.05 * t) * math.cos(math.radians(t)), centre[1] - (104 - 0.05 * t) * math.sin(math.radians(t)))
             for t in range(0, 541, 6)]
    inner = [(centre[0] + (56 - 0.02 * t) * math.cos(math.radians(t)), centre[1] - (56 - 0.02 * t) * math.sin(math.radians(t)))
             for t in range(540, -1, -6)]
    d.polygon(outer + inner, ORANGE, ORANGE_FILL, 1.8, opacity="0.5")
    for x, y in ((centre[0] - 77, centre[1]), (centre[0] + 77, centre[1])):
        d.circle((x, y), 9, RED, width=2)
    d.text(480, 245, "from above its contour meets itself: no certificate", RED, "middle", 12)
    return d


def draw_star():
    d = Drawing(640, 210, "Star test: the angle about the centre rises along the contour")
    o = (150, 105)
    loop = [(o[0] + r * math.cos(math.radians(a)), o[1] - r * math.sin(math.radians(a)))
            for a, r in ((0, 80), (40, 94), (78, 66), (118, 88), (160, 74), (205, 96), (248, 70), (290, 86), (330, 68))]
    d.polygon(loop, INK, BLUE_FILL, 2)
    for p in loop:
        d.line(o, p, GREY, 1, "3 4")
        d.dot(p, INK, 2.6)
    d.dot(o, ORANGE, 4)
    d.text(o[0] - 4, o[1] + 20, "o", ORANGE)
    d.arc(o, 26, 4, 74, ORANGE, 2)
    d.text(284, 60, "every edge turns left about o:\ncross(a - o, b - o)(t) > 0 for all t", GREEN)
    d.text(284, 118, "quadratic in t: positive if its three\nBernstein coefficients are", INK)
    d.text(284, 172, "once round at the start, so once round always:\nthe contour is simple", INK)
    return d


def draw_tree():
    d = Drawing(660, 250, "Boxes hold the whole path of what they contain; a node holds the boxes of its children")
    tri = [(60, 170), (110, 186), (84, 130)]
    move = (46, -34)
    end = [(x + move[0], y + move[1]) for x, y in tri]
    d.polygon(tri, INK, PALE)
    d.polygon(end, INK, BLUE_FILL, dash="4 3")
    for a, b in zip(tri, end):
        d.arrow(a, b, BLUE, 1.2, head=6)
    d.box(48, 84, 120, 114, ORANGE, dash="6 4")
    d.text(48, 218, "box of a triangle: both ends\nof its path, and a margin", ORANGE, size=12)
    d.label(430, 24, 80, 30, "root", INK, PALE)
    for i in range(3):
        x = 300 + 130 * i
        d.label(x, 96, 80, 30, "node", INK, PALE)
        d.line((470, 54), (x + 40, 96), GREY)
        for k in range(3):
            d.label(x - 18 + 40 * k, 164, 34, 26, "leaf", BLUE, BLUE_FILL)
            d.line((x + 40, 126), (x - 1 + 40 * k, 164), GREY)
    d.text(282, 216, "leaf: up to 8 triangles; each vertex and edge belongs to one leaf", BLUE, size=12)
    d.text(282, 234, "node: boxes of up to 8 children, compared at once", INK, size=12)
    return d


def draw_drift():
    d = Drawing(660, 236, "Two features that move alike: boxes around paths overlap, boxes that drift along do not")
    for x0, name, fill in ((30, "boxes around whole paths", False), (350, "boxes that drift along", True)):
        d.text(x0, 22, name, INK, bold=True)
        for y, color in ((136, BLUE), (190, ORANGE)):
            a, b = (x0 + 18, y), (x0 + 70, y - 16)
            d.path([a, b], color, 3)
            shift = (150, -66 if y == 136 else -60)
            d.path([(a[0] + shift[0], a[1] + shift[1]), (b[0] + shift[0], b[1] + shift[1])], color, 3, dash="5 4")
            d.arrow(along(a, b, 0.5), (along(a, b, 0.5)[0] + shift[0], along(a, b, 0.5)[1] + shift[1]), color, 1.2)
            if not fill:
                d.box(x0 + 12, y - 90, 214, 98, color, dash="4 3")
            else:
                d.box(x0 + 12, y - 22, 64, 28, color)
        if fill:
            d.box(x0 + 12, 168 - 6, 64, 34, ORANGE, dash="4 3")
            d.text(x0 + 96, 188, "wider only by what one\nmoves against the other", ORANGE, size=12)
        else:
            d.text(x0, 226, "they overlap: the pair must be tested", RED, size=12)
    d.text(350, 226, "apart at both ends, so in between too", GREEN, size=12)
    return d


def draw_labels():
    d = Drawing(640, 210, "Nodes with the same patch label are not compared with each other")
    colors = {"1": (BLUE, BLUE_FILL), "2": (ORANGE, ORANGE_FILL), "-": (GREY, PALE)}
    xs = [30 + 74 * i for i in range(8)]
    marks = "1111-222"
    for x, m in zip(xs, marks):
        color, fill = colors[m]
        d.label(x, 130, 56, 30, f"leaf {m}" if m != "-" else "leaf", color, fill)
    for i, m in ((0, "1"), (1, "1"), (2, "-"), (3, "2")):
        color, fill = colors[m]
        x = xs[2 * i] + 37
        d.label(x, 74, 56, 30, f"node {m}" if m != "-" else "node", color, fill)
        for k in (0, 1):
            d.line((x + 28, 104), (xs[2 * i + k] + 28, 130), GREY)
    for i, m in ((0, "1"), (1, "-")):
        color, fill = colors[m]
        x = xs[4 * i] + 110
        d.label(x, 20, 56, 30, f"node {m}" if m != "-" else "node", color, fill)
        for k in (0, 1):
            d.line((x + 28, 50), (xs[4 * i + 2 * k] + 65, 74), GREY)
    d.text(30, 184, "node 1 is skipped whole against itself; node 2 as well", BLUE, size=12)
    d.text(30, 202, "only pairs of 1 with 2, and what a leaf without a label meets, are opened", INK, size=12)
    return d


def draw_direction():
    d = Drawing(660, 250, "A fixed direction separates two moving features: all gaps along it are linear in time")
    w = (0.28, -0.96)
    vertex, tri = (86, 66), [(30, 164), (178, 176), (120, 214)]
    move, tri_move = (70, 42), (34, 14)
    end = [(x + tri_move[0], y + tri_move[1]) for x, y in tri]
    d.polygon(tri, INK, PALE)
    d.polygon(end, GREY, "none", 1.2, dash="4 3")
    d.arrow(vertex, (vertex[0] + move[0], vertex[1] + move[1]), BLUE, 1.8)
    d.dot(vertex, BLUE, 4)
    d.arrow(tri[0], end[0], GREY, 1.2, head=6)
    d.arrow((216, 150), (216 + 74 * w[0], 150 + 74 * w[1]), ORANGE, 2)
    d.text(244, 96, "w", ORANGE)
    d.line((24, 122), (214, 160), ORANGE, 1.4, "6 4")
    d.text(28, 40, "a vertex and a triangle, both moving", INK, size=12)
    x0, y0 = 350, 206
    d.arrow((x0, y0), (x0 + 280, y0))
    d.arrow((x0, y0), (x0, 34))
    d.text(x0 + 262, y0 + 20, "t = 1", size=12)
    d.text(x0 - 6, y0 + 20, "t = 0", size=12)
    d.text(x0 + 8, 40, "gap along w", size=12)
    d.line((x0, 172), (x0 + 262, 172), RED, 1.4, "6 4")
    d.text(x0 + 180, 188, "separation s", RED, size=12)
    for g0, g1 in ((64, 112), (84, 158), (100, 84)):
        d.line((x0, g0), (x0 + 262, g1), BLUE)
        d.dot((x0, g0), BLUE)
        d.dot((x0 + 262, g1), BLUE)
    d.text(x0 + 40, 238, "above s at both ends, so above s in between", GREEN, size=12)
    return d


def draw_advance():
    d = Drawing(660, 220, "Conservative advancement: nine tenths of the way to the first closing, again and again")
    x0, y0 = 50, 186

    def distance(t):
        return 34 + 118 * (1 - t) ** 1.7 - 8 * math.sin(5 * t) * (1 - t)

    d.arrow((x0, y0), (x0 + 560, y0))
    d.arrow((x0, y0), (x0, 24))
    d.text(x0 + 8, 30, "distance", size=12)
    d.text(x0 + 566, y0 + 4, "t", size=12)
    d.line((x0, y0 - 22), (x0 + 545, y0 - 22), RED, 1.4, "6 4")
    d.text(x0 + 452, y0 - 8, "separation s", RED, size=12)
    d.path([(x0 + 500 * t / 60, y0 - distance(t / 60)) for t in range(55)], INK, 2.2)
    t = 0.0
    for step in (0.47, 0.265, 0.135):
        a = (x0 + 500 * t, y0 - distance(t))
        closing = (x0 + 500 * (t + step), y0 - 22)
        d.line(a, closing, BLUE, 1.4, "4 3")
        d.dot(a, BLUE, 4)
        t += 0.9 * step
    d.dot((x0 + 500 * t, y0 - distance(t)), BLUE, 4)
    d.text(300, 40, "dashed: the first gap along the closest direction that closes", BLUE, size=12)
    d.text(300, 60, "a gap never closes later than the distance does", INK, size=12)
    return d


def draw_orient():
    d = Drawing(640, 210, "An edge meets a triangle if its ends lie on both sides and three signs agree")
    tri = [(60, 150), (250, 170), (170, 90)]
    d.polygon(tri, BLUE, BLUE_FILL, 2)
    d.line((120, 30), (166, 138), INK, 2.2)
    d.line((166, 138), (180, 171), GREY, 1.4, "4 3")
    d.line((180, 171), (194, 203), INK, 2.2)
    d.dot((166, 138), ORANGE, 4)
    d.dot((120, 30), INK)
    d.dot((194, 203), INK)
    d.text(98, 28, "p")
    d.text(202, 206, "q")
    for name, p in zip("abc", ((44, 156), (256, 178), (168, 82))):
        d.text(p[0], p[1], name, BLUE)
    d.text(320, 58, "1. orient3d(a, b, c, p) and orient3d(a, b, c, q):", INK)
    d.text(338, 78, "not on the same side of the plane", GREEN)
    d.text(320, 112, "2. the line p q passes a b, b c and c a on one side:", INK)
    d.text(338, 132, "three signs of orient3d", GREEN)
    d.text(320, 166, "signs are exact, so the answer is", INK)
    return d


def draw_untangle():
    d = Drawing(640, 220, "A contour parts a surface; the smaller region went through and is pushed back")
    d.path([(30, 120), (120, 118), (200, 110), (280, 106)], INK, 2.4)
    d.path([(100, 40), (130, 84), (160, 128), (206, 146), (250, 132), (270, 92), (286, 40)], BLUE, 2.4)
    for p in ((154, 114), (263, 107)):
        d.circle(p, 7, RED, width=2)
    d.text(58, 180, "two crossings: the piece\nbelow went through", RED, size=12)
    for x in (186, 206, 228):
        d.arrow((x, 142), (x, 118), ORANGE, 1.6, head=6)
    d.text(200, 200, "votes push it back", ORANGE, size=12)
    patch = [(400 + 190 * u, 40 + 140 * v) for u, v in ((0, 0), (1, 0), (1, 1), (0, 1))]
    d.polygon(patch, BLUE, BLUE_FILL, 2)
    ring = [(510 + 46 * math.cos(t / 12 * math.pi), 116 + 30 * math.sin(t / 12 * math.pi)) for t in range(24)]
    d.polygon(ring, RED, ORANGE_FILL, 2)
    d.text(510, 120, "wrong", ORANGE, "middle")
    d.text(420, 66, "right: the largest region", BLUE)
    d.text(495, 204, "the contour cuts edges; flooding finds both sides", INK, "middle", 12)
    return d


DRAWINGS = {"chord": draw_chord, "patch": draw_patch, "ramp": draw_ramp, "star": draw_star, "tree": draw_tree,
            "drift": draw_drift, "labels": draw_labels, "direction": draw_direction, "advance": draw_advance,
            "orient": draw_orient, "untangle": draw_untangle}
