#!/usr/bin/env python3
"""Writes the drawings of docs/method.

usage: draw_method.py [--check] [DIRECTORY]   without DIRECTORY docs/method/drawings; --check writes nothing, and fails if a
                                              drawing there differs or no page shows it
"""
import os
import sys

import draw_contact
import draw_detection
import draw_others

PLACE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "docs", "method")


def make_drawings():
    return {name: make() for module in (draw_detection, draw_contact, draw_others)
            for name, make in module.DRAWINGS.items()}


def find_faults(drawings, place):
    pages = ""
    for name in sorted(os.listdir(PLACE)):
        if name.endswith(".md"):
            with open(os.path.join(PLACE, name), encoding="utf-8") as file:
                pages += file.read()
    faults = [f"{name}: no drawing of ours" for name in sorted(os.listdir(place)) if name[:-4] not in drawings]
    for name, drawing in drawings.items():
        path = os.path.join(place, name + ".svg")
        words = open(path, encoding="utf-8").read() if os.path.exists(path) else ""
        if words != drawing.write():
            faults.append(f"{name}.svg differs from what the script draws")
        if f"(drawings/{name}.svg)" not in pages:
            faults.append(f"{name}.svg is on no page")
    return faults


def main(arguments):
    is_check = "--check" in arguments
    places = [a for a in arguments if a != "--check"]
    place = places[0] if places else os.path.join(PLACE, "drawings")
    drawings = make_drawings()
    if is_check:
        faults = find_faults(drawings, place)
        for fault in faults:
            print(f"drawings: {fault}")
        print(f"drawings: {len(drawings)} as drawn" if not faults else f"drawings: {len(faults)} faults")
        return 1 if faults else 0
    os.makedirs(place, exist_ok=True)
    for name, drawing in drawings.items():
        with open(os.path.join(place, name + ".svg"), "w", encoding="utf-8") as file:
            file.write(drawing.write())
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
