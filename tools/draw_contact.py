"""Drawings of docs/method: contact and the solve."""
import math

from drawing import (BLUE, BLUE_FILL, GREEN, GREEN_FILL, GREY, INK, ORANGE, ORANGE_FILL, PALE, RED, RED_FILL, Drawing, along,
                     turned)


def draw_row():
    d = Drawing(660, 240, "A contact row: closest points, normal, and the half-space on the approach")
    tri = [(40, 190), (250, 200), (150, 150)]
    d.polygon(tri, INK, PALE, 2)
    vertex, foot = (136, 78), (146, 178)
    d.dot(vertex, BLUE, 4.5)
    d.dot(foot, BLUE, 4.5)
    d.arrow(foot, (138.6, 104), BLUE, 2)
    d.text(150, 108, "n", BLUE)
    d.arrow((118, 176), (110, 82), ORANGE, 1.2, head=6)
    d.arrow((110, 82), (118, 176), ORANGE, 1.2, head=6)
    d.text(64, 134, "gap g0", ORANGE, size=12)
    d.text(122, 62, "first feature", INK, size=12)
    d.text(70, 224, "second feature: weights w_i of its corners", INK, size=12)
    x0, y0 = 400, 206
    d.arrow((x0, y0), (x0 + 230, y0))
    d.arrow((x0, y0), (x0, 30))
    d.text(x0 + 150, y0 + 20, "time of the step", size=12)
    d.text(x0 + 6, 34, "gap", size=12)
    for y, words in ((92, "delta_s: a contact ends"), (134, "delta_c: it carries load"), (192, "xi: never nearer")):
        d.line((x0, y), (x0 + 210, y), RED if "xi" in words else GREY, 1.2, "6 4")
        d.text(x0 + 216, y + 4, words, RED if "xi" in words else GREY, size=12)
    d.arrow((x0, 62), (x0 + 206, 133), BLUE, 2)
    d.dot((x0, 62), BLUE)
    d.arrow((x0, 166), (x0 + 206, 150), ORANGE, 2)
    d.dot((x0, 166), ORANGE)
    return d


def draw_cones():
    d = Drawing(660, 220, "Edges inside a flat mesh get no row; the edge of a box gets one")
    d.path([(30, 160), (110, 160), (190, 160), (270, 160)], INK, 2.4)
    for x in (110, 190):
        d.dot((x, 160))
    d.dot((92, 104), BLUE, 4.5)
    d.arrow((110, 160), (95, 110), RED, 1.8)
    d.line((110, 160), (110, 90), GREEN, 2)
    d.text(118, 96, "its normal cone is one direction", GREEN, size=12)
    d.text(30, 192, "an edge inside a flat: the direction to the vertex\nleans out of the cone: no row", RED, size=12)
    d.polygon([(400, 130), (560, 130), (560, 186), (400, 186)], INK, PALE, 2)
    d.polygon([(400, 130), (400, 64), (334, 130)], GREEN, GREEN_FILL, 1, opacity="0.8")
    d.text(410, 76, "normal cone of the edge of a box", GREEN, size=12)
    d.dot((352, 88), BLUE, 4.5)
    d.arrow((400, 130), (356, 91), BLUE, 1.8)
    d.text(400, 206, "the direction lies in the cone: a row", BLUE, size=12)
    return d


def draw_end_frame():
    d = Drawing(640, 220, "Cloth slides round an edge: the normal turns within the step")
    d.polygon([(40, 210), (250, 210), (250, 130), (40, 130)], INK, PALE, 2)
    edge = (250, 130)
    d.arc(edge, 52, 0, 90, GREY, 1.2, "5 4")
    d.path([(60, 78), (250, 78)], BLUE, 2.4)
    d.arc(edge, 52, 0, 90, BLUE, 2.4)
    d.path([(302, 130), (302, 206)], BLUE, 2.4)
    d.dot(edge, INK, 4)
    n0, n1 = turned((302, 130), edge, 72), turned((302, 130), edge, 30)
    d.arrow(edge, n0, GREY, 2)
    d.arrow(edge, n1, ORANGE, 2)
    d.text(n0[0] - 4, n0[1] - 10, "n of x0", GREY, size=12)
    d.text(n1[0] + 8, n1[1] - 4, "n1 of the end", ORANGE, size=12)
    d.arrow((190, 62), (240, 62), BLUE, 1.4)
    d.text(204, 54, "v", BLUE)
    d.text(400, 90, "angle v h / r\nr: contact distance", INK)
    d.text(400, 140, "With the normal of x0 the row lags by this\nangle. It would act like more friction:\nmu + v h / r.", INK, size=12)
    return d


def draw_coulomb():
    d = Drawing(640, 230, "The Coulomb cone: a trial inside sticks, one outside slides on the nearest point")
    apex = (170, 204)
    d.polygon([apex, (60, 54), (280, 54)], GREEN, GREEN_FILL, 1.4, opacity="0.7")
    d.arrow(apex, (170, 24))
    d.text(178, 30, "push (normal part of p)", size=12)
    d.arrow((40, 204), (310, 204))
    d.text(268, 222, "friction", size=12)
    d.line((96, 104), (244, 104), INK, 1, "4 3")
    d.dot((196, 104), BLUE, 4.5)
    d.text(178, 94, "sticks", BLUE, size=12)
    d.dot((330, 104), ORANGE, 4.5)
    d.arrow((322, 104), (250, 104), ORANGE, 1.6)
    d.dot((244, 104), ORANGE, 4.5)
    d.text(296, 92, "slides", ORANGE, size=12)
    d.text(392, 74, "bound: mu times the push", GREEN)
    d.text(392, 108, "trial: the tangential part of p,\nless penalty times slip", INK)
    d.text(392, 162, "with a grain the bound is an ellipse\nin the tangent plane", INK)
    return d


def draw_forces():
    d = Drawing(640, 220, "A spring along each edge, a hinge across it, wind on each triangle")
    a, b, c, e = (70, 120), (210, 120), (140, 30), (150, 196)
    d.polygon([a, b, c], INK, PALE)
    d.polygon([a, e, b], INK, "#f4f6f8")
    zig = [along(a, b, 0.16)]
    for i in range(1, 10):
        p = along(a, b, 0.16 + 0.068 * i)
        zig.append((p[0], p[1] + (6 if i % 2 else -6)))
    zig.append(along(a, b, 0.84))
    d.path([a, *zig, b], BLUE, 2.2)
    d.text(112, 104, "spring", BLUE, size=12)
    for p in (a, b, c, e):
        d.dot(p)
    d.line(c, e, ORANGE, 1.4, "5 4")
    d.text(34, 176, "hinge: four\nvertices", ORANGE, size=12)
    d.arrow((250, 40), (178, 72), GREEN, 2)
    d.text(226, 34, "wind", GREEN, size=12)
    x0, y0 = 400, 180
    d.arrow((x0 - 60, y0), (x0 + 200, y0))
    d.arrow((x0, y0 + 30), (x0, 24))
    d.text(x0 + 128, y0 + 18, "extension e", size=12)
    d.text(x0 + 8, 32, "tension t(e)", size=12)
    curve = [(x0 - 60, y0 + 17)]
    for i in range(0, 31):
        s = i / 10
        curve.append((x0 + 44 * s, y0 - (12.5 * s * (1 + s * s)) if s <= 2 else y0 - 125 - (s - 2) * 160))
    d.path([p for p in curve if p[1] > 30], BLUE, 2.2)
    d.line((x0, y0), (x0 + 180, y0 - 51), GREY, 1.2, "5 4")
    d.line((x0 + 44, y0), (x0 + 44, y0 - 25), ORANGE, 1.2, "3 3")
    d.text(x0 + 32, y0 + 18, "s L", ORANGE, size=12)
    d.text(x0 + 116, 100, "stiffens", BLUE, size=12)
    d.text(x0 + 140, 154, "linear", GREY, size=12)
    return d


def draw_round():
    d = Drawing(660, 190, "One round of solve_motion")
    boxes = (("solve\n(A + J'KJ) u =\nb + J'(p + K w)", BLUE, BLUE_FILL),
             ("normal part\np + k (w - v),\nnever a pull", ORANGE, ORANGE_FILL),
             ("friction\ntrial on the\nCoulomb bound", ORANGE, ORANGE_FILL),
             ("other rows\nsweeps in the\ntrue masses", GREEN, GREEN_FILL))
    for i, (words, color, fill) in enumerate(boxes):
        x = 20 + 160 * i
        d.label(x, 36, 130, 76, words, color, fill)
        if i < 3:
            d.arrow((x + 130, 74), (x + 160, 74))
    d.path([(565, 112), (565, 146), (85, 146)], INK, 1.6)
    d.arrow((85, 146), (85, 114))
    d.text(324, 140, "until little is missing; six rounds at most", INK, "middle", 12)
    d.text(20, 24, "impulses p of the last step", GREY, size=12)
    d.text(324, 176, "J': from impulses of rows to vertices. K: penalties. At the fixed point nothing changes.", GREY, "middle", 12)
    return d


def draw_solve_phases():
    d = Drawing(640, 150, "Phases of the linear solve")
    for i, (words, color, fill) in enumerate((("single precision,\nblocks of the diagonal", BLUE, BLUE_FILL),
                                              ("single precision,\nwith aggregates", BLUE, BLUE_FILL),
                                              ("double precision", ORANGE, ORANGE_FILL))):
        x = 20 + 215 * i
        d.label(x, 50, 160, 52, words, color, fill)
        if i < 2:
            d.arrow((x + 160, 76), (x + 215, 76))
    d.text(207, 42, "8 iterations", GREY, "middle", 12)
    d.text(422, 42, "comes no nearer", GREY, "middle", 12)
    d.text(320, 132, "each ends when the residual is a small part of the force impulse", INK, "middle", 12)
    return d


def draw_impacts():
    d = Drawing(660, 190, "resolve_impacts: test, make rows, sweep, test what changed")
    for i, (words, color, fill) in enumerate((("test the paths\nx0 to x1", BLUE, BLUE_FILL),
                                              ("each hit\nbecomes a row", ORANGE, ORANGE_FILL),
                                              ("sweeps over\nall rows", ORANGE, ORANGE_FILL),
                                              ("new paths", BLUE, BLUE_FILL))):
        x = 20 + 160 * i
        d.label(x, 40, 126, 52, words, color, fill)
        if i < 3:
            d.arrow((x + 126, 66), (x + 160, 66))
    d.path([(563, 92), (563, 124), (60, 124)], INK)
    d.arrow((60, 124), (60, 94))
    d.text(324, 118, "pairs with a changed vertex; five rounds at most", INK, "middle", 12)
    d.arrow((110, 92), (110, 160), GREEN)
    d.text(122, 160, "nothing is hit: test all candidates once, then the paths are clean", GREEN, size=12)
    return d


def draw_rescue():
    d = Drawing(680, 210, "The rescue: impact zones, scaled components, shorter time")
    for i, name in enumerate(("1. impact zones", "2. components", "3. shorter time")):
        x = 20 + 225 * i
        d.text(x, 24, name, bold=True)
        d.box(x, 36, 205, 120, GREY, stroke=1)
        if i == 0:
            for p in ((70, 70), (96, 84), (84, 112), (60, 100)):
                d.dot((x + p[0] - 20, p[1]), BLUE, 4)
            d.polygon([(x + 50, 70), (x + 76, 84), (x + 64, 112), (x + 40, 100)], BLUE, "none", 1.2)
            d.arrow((x + 84, 92), (x + 118, 92), BLUE)
            moved = [turned((x + p + 100, y), (x + 158, 91), 40) for p, y in ((50, 70), (76, 84), (64, 112), (40, 100))]
            d.polygon(moved, BLUE, BLUE_FILL, 1.2)
        if i == 1:
            for k, y in enumerate((64, 84, 104, 128)):
                color = ORANGE if k in (1, 2) else GREY
                d.arrow((x + 24, y), (x + (104 if k in (1, 2) else 170), y), color)
                if k in (1, 2):
                    d.line((x + 104, y), (x + 170, y), PALE, 1.4, "4 3")
        if i == 2:
            for y in (60, 80, 100, 120, 140):
                d.arrow((x + 24, y), (x + 84, y), RED)
                d.line((x + 84, y), (x + 170, y), PALE, 1.4, "4 3")
    d.text(20, 176, "hit vertices move as a\nrigid body", size=12)
    d.text(245, 176, "what is joined by hits goes a\npart of its way", size=12)
    d.text(470, 176, "all go the same part; the rest\nis another substep", size=12)
    return d


def draw_rebound():
    d = Drawing(620, 170, "A rebound changes velocities, not positions")
    d.line((40, 130), (280, 130), INK, 3)
    d.dot((90, 50), BLUE, 5)
    d.arrow((90, 50), (150, 112), BLUE)
    d.dot((152, 114), BLUE, 5)
    d.arrow((152, 114), (206, 66), ORANGE)
    d.text(60, 40, "x0", BLUE)
    d.text(128, 152, "x1: proven, stays", BLUE, size=12)
    d.text(212, 66, "v1: k_c times the\napproach, upward", ORANGE, size=12)
    d.text(370, 66, "positions: as proven in stage 9", INK)
    d.text(370, 92, "velocities: as the law of impact says,", INK)
    d.text(370, 112, "with no more energy than there is", INK)
    return d


def draw_body_row():
    d = Drawing(620, 210, "A row on a rigid body: its arm from the centre to the contact point")
    d.line((40, 176), (320, 176), INK, 3)
    square = [turned(p, (170, 110), 20) for p in ((120, 62), (224, 62), (224, 158), (120, 158))]
    d.polygon(square, INK, PALE, 2)
    centre = (171, 110)
    low = max(square, key=lambda p: p[1])
    d.dot(centre, INK, 4)
    d.arrow(centre, low, ORANGE, 2)
    d.text(along(centre, low, 0.45)[0] + 8, along(centre, low, 0.45)[1], "a", ORANGE)
    d.arrow((low[0], 176), (low[0], 116), BLUE, 2)
    d.text(low[0] + 8, 126, "p", BLUE)
    d.arrow(centre, (236, 96), GREEN, 1.6)
    d.text(240, 94, "V", GREEN)
    d.arc(centre, 30, 110, 250, GREEN, 1.6)
    d.text(128, 104, "w", GREEN)
    d.text(370, 80, "the contact moves by s V + w x a", INK)
    d.text(370, 108, "an impulse p gives", INK)
    d.text(386, 128, "s p to the body,", BLUE)
    d.text(386, 148, "a x p to its spin", BLUE)
    return d


def draw_pinch():
    d = Drawing(455, 220, "A press closes on cloth: stop, slow")
    for i, (name, words) in enumerate((("stop", "the step fails;\nthe state stays"),
                                       ("slow", "the plates stand, the gap\nis kept; the script goes on"))):
        x = 20 + 225 * i
        d.text(x, 24, f"on_pinch: {name}", bold=True)
        top, bottom = (64, 120) if name == "stop" else (78, 112)
        for y, sign in ((top, -1), (bottom, 1)):
            d.box(x + 20, y - (20 if sign < 0 else 0), 150, 20, INK, PALE)
        d.path([(x + 10, 98), (x + 60, 94), (x + 130, 98), (x + 186, 93)], BLUE, 2.4)
        if name == "slow":
            d.arrow((x + 95, 82), (x + 95, 108), ORANGE, 1.4, head=6)
            d.arrow((x + 95, 108), (x + 95, 82), ORANGE, 1.4, head=6)
        if name == "stop":
            d.arrow((x + 95, 66), (x + 95, 86), RED, 1.6, head=6)
            d.arrow((x + 95, 118), (x + 95, 104), RED, 1.6, head=6)
        d.text(x, 176, words, size=12)
    return d


def draw_motion_space():
    d = Drawing(660, 220, "Two half-spaces, the cone inside them, and the polyhedral space")
    for i, name in enumerate(("cone", "polyhedral")):
        x = 40 + 320 * i
        apex = (x + 110, 180)
        d.text(x, 26, f"motion_space: {name}", bold=True)
        wedge = [apex, (x + 10, 60), (x + 230, 76)]
        d.polygon(wedge, GREY, PALE, 1, opacity="0.8")
        d.line(apex, (x - 2, 46), INK, 2)
        d.line(apex, (x + 246, 62), INK, 2)
        if name == "cone":
            d.polygon([apex, (x + 44, 66), (x + 200, 80)], BLUE, BLUE_FILL, 1.2, opacity="0.8")
            d.arrow(apex, (x + 120, 60), BLUE)
            d.text(x + 126, 70, "axis", BLUE, size=12)
            d.arrow(apex, (x + 232, 160), RED)
            d.arrow(apex, (x + 176, 103), ORANGE)
            d.text(x + 236, 164, "v", RED)
            d.text(x + 168, 122, "v . Z", ORANGE, size=12)
        else:
            d.arrow(apex, (x + 232, 160), RED)
            d.arrow(apex, (x + 196, 106), ORANGE)
            d.text(x + 236, 164, "v", RED)
            d.text(x + 202, 112, "v . Z", ORANGE, size=12)
    d.text(40, 208, "the widest circular cone inside the half-spaces", size=12)
    d.text(360, 208, "the nearest point of the half-spaces", size=12)
    return d


DRAWINGS = {"row": draw_row, "cones": draw_cones, "end_frame": draw_end_frame, "coulomb": draw_coulomb, "forces": draw_forces,
            "round": draw_round, "solve_phases": draw_solve_phases, "impacts": draw_impacts, "rescue": draw_rescue,
            "rebound": draw_rebound, "body_row": draw_body_row, "pinch": draw_pinch, "motion_space": draw_motion_space}
