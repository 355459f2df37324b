#!/usr/bin/env python3
"""How many frames a second `tulle view` sends to a client that takes all of them, by the number of triangles: of a run, and of a live
scene beside the same scene without a client. The client checks the head of each frame and decodes nothing.

usage: view_rates.py --tulle PROGRAM [--seconds S] [--triangles N...] [--require]   (--require: fails below 60 frames a second of 20,000
triangles and 20 of 200,000)"""
import argparse
import os
import struct
import sys
import tempfile
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "test", "e2e"))
REQUIRED = {20000: 60.0, 200000: 20.0}
FRAMES = 6
SCENE = """time: {{step: 1/60 s, frames: {frames}}}
wind: {{velocity: [1, 0, 0], gust_strength: 3, gust_length: 0.2}}
cloth:
  - mesh: {{shape: rectangle, size: [2, 2], resolution: [{side}, {side}]}}
    translate: [0, 0, 1]
"""


def take_frames(page, seconds, ask):
    """Frames and bytes in so many seconds; `ask` is called when those that were asked for are there."""
    begin, frames, size, last = time.monotonic(), 0, 0, None
    while time.monotonic() - begin < seconds:
        if ask and (last is None or last == FRAMES):
            ask()
        message = page.receive()
        if not isinstance(message, bytes):
            page.state = message if message["type"] == "state" else page.state
            continue
        if message[0] != 2:
            continue
        number, sequence = struct.unpack_from("<I", message, 4)[0], struct.unpack_from("<I", message, 16)[0]
        page.send("got", sequence=sequence)
        frames, size, last = frames + 1, size + len(message), number
    return frames / (time.monotonic() - begin), size / max(frames, 1)


def measure(view_client, folder, triangles, seconds):
    side = round((triangles / 2) ** 0.5) + 1
    scene = os.path.join(folder, f"sheet_{triangles}.yaml")
    run = os.path.join(folder, f"sheet_{triangles}.run")
    with open(scene, "w", encoding="ascii") as file:
        file.write(SCENE.format(side=side, frames=FRAMES))
    if os.system(f'"{view_client.PROGRAM}" run "{scene}" -o "{run}" --progress none >/dev/null') != 0:
        sys.exit("the run failed")
    with view_client.Server(run) as server, view_client.Page(server) as page:
        rate, size = take_frames(page, seconds, lambda: page.send("frames", **{"from": 0, "count": FRAMES + 1}))
    with view_client.Server(scene) as server:
        with view_client.Page(server) as page:
            page.ask("run", speed=0)
            page.send("follow", rate=1000)
            page.wait_for(lambda: page.state["step"] > 0)
            begin, step = time.monotonic(), page.state["step"]
            live, _ = take_frames(page, seconds, None)
            watched = (page.state["step"] - step) / (time.monotonic() - begin)
    return 2 * (side - 1) ** 2, rate, size, live, watched


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--tulle", required=True)
    parser.add_argument("--seconds", type=float, default=5.0)
    parser.add_argument("--triangles", type=int, nargs="*", default=list(REQUIRED))
    parser.add_argument("--require", action="store_true")
    arguments = parser.parse_args()
    os.environ["TULLE"] = os.path.abspath(arguments.tulle)
    import view_client  # reads TULLE
    slow = 0
    print("| triangles | frames a second of a run | kB a frame | frames a second, live | steps a second, live |\n|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for triangles in arguments.triangles:
            count, rate, size, live, watched = measure(view_client, folder, triangles, arguments.seconds)
            slow += rate < REQUIRED.get(triangles, 0.0)
            print(f"| {count} | {rate:.0f} | {size / 1000:.0f} | {live:.1f} | {watched:.1f} |", flush=True)
    return 1 if slow and arguments.require else 0


if __name__ == "__main__":
    sys.exit(main())
