"""Drawings of docs/method: the step, subdivision, pictures."""
import math

from drawing import (BLUE, BLUE_FILL, GREEN, GREEN_FILL, GREY, INK, ORANGE, ORANGE_FILL, PALE, RED, RED_FILL, Drawing, along)

STAGES = ("predict_paths", "update_patches", "build_trees", "find_pairs", "gather_rows", "compute_forces", "solve_motion",
          "resolve_impacts", "commit_safely", "accept_state")


def draw_step():
    d = Drawing(760, 330, "The ten stages of a step and what happens when one does not succeed")
    colors = [(BLUE, BLUE_FILL)] * 4 + [(ORANGE, ORANGE_FILL)] * 4 + [(GREEN, GREEN_FILL)] * 2
    places = []
    for i, (name, (color, fill)) in enumerate(zip(STAGES, colors)):
        x = 20 + 148 * (i % 5)
        y = 56 if i < 5 else 156
        d.label(x, y, 128, 40, f"{i + 1} {name}", color, fill)
        places.append((x, y))
        if i % 5 < 4:
            d.arrow((x + 128, y + 20), (x + 148, y + 20))
    last, first = places[4], places[5]
    d.path([(last[0] + 58, 96), (last[0] + 58, 126), (first[0] + 58, 126)], INK)
    d.arrow((first[0] + 58, 126), (first[0] + 58, 154))
    d.text(20, 34, "state: x0, v0, contacts", INK, bold=True)
    d.arrow((78, 38), (78, 54))
    d.arrow((places[9][0] + 58, 196), (places[9][0] + 58, 232))
    d.text(places[9][0] + 128, 250, "new state", INK, "end", bold=True)
    d.text(20, 84 + 34, "detection", BLUE, size=12)
    d.text(230, 144, "response: how good it looks", ORANGE, size=12)
    d.text(478, 144, "safety: what is accepted", GREEN, size=12)
    d.label(240, 244, 220, 40, "retry: what to try next", RED, RED_FILL, bold=True)
    for i in (6, 7, 8):
        d.arrow((places[i][0] + 58, 196), (min(max(places[i][0] + 58, 260), 440), 242), RED, 1.2, "4 3")
    d.dot((449, 176), RED, 3.6)
    d.text(440, 212, "motion judged", RED, "middle", size=11)
    d.path([(240, 264), (8, 264), (8, 76)], RED, 1.2, dash="4 3")
    d.arrow((8, 76), (18, 76), RED, 1.2)
    d.text(20, 306, "A stage reports what happened. retry.c decides: solve again, half the substep, undo the step.", RED, size=12)
    return d


def draw_subdivision():
    d = Drawing(640, 240, "Loop subdivision: weights of an edge point and of a vertex point")
    a, b, c, e = (60, 120), (220, 120), (140, 36), (140, 204)
    d.polygon([a, b, c], INK, PALE)
    d.polygon([a, e, b], INK, PALE)
    for p, words, dx, dy in ((a, "3/8", -34, 4), (b, "3/8", 10, 4), (c, "1/8", 8, -4), (e, "1/8", 10, 8)):
        d.dot(p)
        d.text(p[0] + dx, p[1] + dy, words)
    d.dot((140, 120), ORANGE, 5)
    d.text(100, 142, "edge point", ORANGE, size=12)
    centre = (460, 120)
    ring = [(centre[0] + 88 * math.cos(math.radians(60 * k)), centre[1] - 88 * math.sin(math.radians(60 * k))) for k in range(6)]
    d.polygon(ring, INK, PALE)
    for k, p in enumerate(ring):
        d.line(centre, p, INK, 1.2)
        d.dot(p)
        d.text(p[0] + (9 if p[0] > centre[0] else -22), p[1] + (14 if p[1] > centre[1] else -4), "w")
    d.dot(centre, ORANGE, 5)
    d.text(centre[0] + 10, centre[1] - 8, "1 - n w", ORANGE)
    d.text(370, 232, "vertex point, n neighbours (here 6: w = 1/16)", ORANGE, size=12)
    return d


def draw_path():
    d = Drawing(640, 220, "A path of the renderer")
    d.line((30, 190), (610, 190), GREY, 1.4)
    d.polygon([(40, 60), (66, 50), (66, 70)], INK, PALE)
    d.text(30, 44, "camera", size=12)
    d.path([(190, 190), (236, 132), (300, 112), (366, 136), (410, 190)], BLUE, 2.6)
    d.arrow((66, 60), (244, 128), INK, 1.8)
    d.arrow((246, 128), (300, 34), ORANGE, 1.6, "5 4")
    d.circle((306, 24), 11, ORANGE, ORANGE_FILL)
    d.text(324, 28, "one place of the light: seen or not", ORANGE, size=12)
    d.arrow((244, 126), (150, 186), BLUE, 1.6)
    d.text(118, 208, "a bounce, by the cosine", BLUE, size=12)
    d.arrow((148, 186), (112, 92), GREEN, 1.6)
    d.text(84, 84, "sky", GREEN, size=12)
    d.text(420, 130, "cloth: weight of the path", INK, size=12)
    d.text(420, 148, "= product of the colours", INK, size=12)
    return d


DRAWINGS = {"step": draw_step, "subdivision": draw_subdivision, "path": draw_path}
