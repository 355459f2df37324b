"""`tulle view` of runs and meshes: frames are those of the run, in the order in which they were asked for; overlays, picks and plots; a run
under way is followed, damage is told. usage: view_run.py FOLDER (with sheet.yaml and sheet.run)"""
import csv
import os
import shutil
import signal
import struct
import subprocess
import sys
import time

from view_client import PROGRAM, Page, Server

FOLDER = sys.argv[1]
SCENE, RUN = os.path.join(FOLDER, "sheet.yaml"), os.path.join(FOLDER, "sheet.run")
SHEET, BALL, BLOCK, GROUND = 0, 1, 2, 3
FRAMES = 21
FAULTS = []


def expect(truth, what):
    if not truth:
        FAULTS.append(what)
        print("fault:", what, flush=True)


def read_cache(name):
    """Positions of all frames of a PC2 file."""
    with open(os.path.join(RUN, name), "rb") as file:
        data = file.read()
    assert data[:12] == b"POINTCACHE2\0"
    _, vertices, _, _, frames = struct.unpack_from("<iiffi", data, 12)
    return [struct.unpack_from(f"<{3 * vertices}f", data, 32 + 12 * vertices * frame) for frame in range(frames)]


def find_caches():
    names = sorted(name for name in os.listdir(RUN) if name.endswith(".pc2"))
    return {name.split(".")[0]: read_cache(name) for name in names}


def get_error(page, index, truth):
    return max(abs(a - b) for a, b in zip(page.get_positions(index), truth))


def check_frames(page, caches):
    sheet = next(cache for name, cache in caches.items() if "sheet" in name)
    block = next(cache for name, cache in caches.items() if "block" in name)
    expect(len(sheet) == FRAMES and page.document["frame_count"] == FRAMES, f"frames: {len(sheet)} {page.document['frame_count']}")
    seen = []

    def take(count):
        for _ in range(count):
            before = page.frame_count
            page.wait_for(lambda before=before: page.frame_count > before)
            number = page.frame["number"]
            seen.append(number)
            expect(abs(page.frame["time"] - number / 60) < 1e-12, f"frame {number} at {page.frame['time']}")
            for index, cache in ((SHEET, sheet), (BLOCK, block)):
                limit = 0.0 if page.grids[index].places is None else 0.51 * page.grids[index].step
                expect(get_error(page, index, cache[number]) <= limit, f"frame {number}: object {index} is off by {get_error(page, index, cache[number])}")
    page.wait_for(lambda: page.frame and page.frame["number"] == 0)
    page.ask("frames", **{"from": 0, "count": 1000})
    take(FRAMES)
    page.ask("frames", **{"from": 20, "count": 1, "exact": True})
    take(1)
    page.ask("frames", **{"from": 3, "count": 5, "step": 4})
    take(5)
    page.ask("frames", **{"from": 2, "count": 3, "exact": True})
    take(3)
    expect(seen == list(range(FRAMES)) + [20, 3, 7, 11, 15, 19, 2, 3, 4], f"frames in order: {seen}")
    expect(page.ask("frames", **{"from": FRAMES, "count": 1})["type"] == "error", "a frame that is not there")
    # Frames may come faster than messages may: acknowledging them does not count.
    for _ in range(12):
        page.send("frames", **{"from": 0, "count": 1000})
        page.wait_for(lambda before=page.frame_count: page.frame_count == before + FRAMES)
    # A new request ends the one before; no more than four come without being acknowledged.
    page.acknowledges = False
    page.send("frames", **{"from": 0, "count": 1000})
    before = page.frame_count
    page.wait_for(lambda: page.frame_count == before + 4)
    answer = page.ask("series", names=["contacts"])
    expect(answer["type"] == "series" and page.frame_count == before + 4, f"{page.frame_count - before} frames without being acknowledged")
    page.acknowledges = True
    page.send("frames", **{"from": 15, "count": 1})
    page.send("got", sequence=page.frame["sequence"])
    page.wait_for(lambda: page.frame["number"] == 15)
    expect(page.frame_count <= before + 5, "the request before went on")


def check_rest(page, caches):
    with open(os.path.join(RUN, "report.csv"), encoding="ascii") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    series = page.ask("series", names=["contacts", "kinetic_energy", "elastic_energy"], buckets=1000)
    expect(len(series["steps"]) == len(rows), f"{len(series['steps'])} steps, {len(rows)} in report.csv")
    for name in ("contacts", "kinetic_energy", "elastic_energy"):
        wrong = [i for i, row in enumerate(rows) if abs(float(row[name]) - series["low"][name][i]) > 1e-6 * abs(float(row[name]))]
        expect(not wrong and series["low"][name] == series["high"][name], f"{name} differs in steps {wrong[:5]}")
    page.overlays = {}
    page.ask("overlays", names=["contacts", "velocities", "patches", "strain", "gaps", "crossings"])
    page.ask("frames", **{"from": 20, "count": 1})
    page.wait_for(lambda: len(page.overlays) == 6)
    expect(all(overlay[0] == 20 for overlay in page.overlays.values()), "overlays of another frame")
    expect(page.overlays[1][1] == float(rows[-1]["contacts"]), f"{page.overlays[1][1]} contacts, {rows[-1]['contacts']} in report.csv")
    expect(page.overlays[6][1] == 0, "crossings")
    triangles = len(page.meshes[SHEET][1]) // 3
    strains = struct.unpack_from(f"<{3 * triangles}f", page.overlays[4][2], 8)
    expect(max(map(abs, strains)) < 0.1, f"strains up to {max(map(abs, strains))}")
    gaps = struct.unpack_from("<169f", page.overlays[5][2], 8)
    expect(0.0 < min(gaps) < 0.02, f"gaps from {min(gaps)}")
    sheet = next(cache for name, cache in caches.items() if "sheet" in name)
    found = page.ask("pick", frame=20, object=SHEET, triangle=0, weights=[0.1, 0.1, 0.8])
    vertex = found["vertex"]["index"]
    expect(found["frame"] == 20 and found["vertex"]["position"] == list(sheet[20][3 * vertex:3 * vertex + 3]), f"picked: {found}")
    expect(page.ask("run")["type"] == "error" and page.ask("text")["type"] == "error" and page.ask("grab", object=0, triangle=0, weights=[1, 0, 0], point=[0, 0, 0])["type"] == "error",
           "a run is held")


def check_run_under_way():
    """A run is opened while another process writes it, and followed to its end."""
    path = os.path.join(FOLDER, "growing.run")
    writer = subprocess.Popen([PROGRAM, "run", SCENE, "-o", path, "--progress", "none", "--set", "time.frames=100000", "--set", "cloth[0].mesh.resolution=[50,50]"],
                              stdout=subprocess.DEVNULL)
    while not os.path.exists(os.path.join(path, "run.json")):
        time.sleep(0.02)
    for attempt in range(200):  # the first frame may not be whole yet
        try:
            server = Server(path, folder=FOLDER)
            break
        except RuntimeError as error:
            expect("no whole frame" in str(error) or "cannot" in str(error) or attempt < 199, f"a run that begins: {error}")
            time.sleep(0.05)
    with server, Page(server) as page:
        counts = [page.document["frame_count"]]
        expect(page.document["is_under_way"], "it is under way")
        for _ in range(3):
            page.wait_for(lambda: any(text["type"] == "changed" for text in page.texts), 120)
            counts += [text["frame_count"] for text in page.texts if text["type"] == "changed"]
            page.texts = []
        page.ask("frames", **{"from": counts[-1] - 1, "count": 1})
        page.wait_for(lambda: page.frame["number"] == counts[-1] - 1)
        writer.send_signal(signal.SIGINT)
        writer.wait(60)
        page.wait_for(lambda: any(text["type"] == "changed" and not text["is_under_way"] for text in page.texts), 60)
        expect(counts == sorted(set(counts)), f"frame counts: {counts}")
    shutil.rmtree(path)


def check_damage(caches):
    """A frame that is damaged is told; the frames around it are shown."""
    path = os.path.join(FOLDER, "damaged.run")
    shutil.copytree(RUN, path)
    name = next(name for name in os.listdir(path) if name.endswith(".pc2") and "sheet" in name)
    size = len(next(cache for key, cache in caches.items() if "sheet" in key)[0]) * 4
    with open(os.path.join(path, name), "r+b") as file:
        file.seek(32 + 10 * size + 100)
        file.write(b"\xff\xff")
    with Server(path, folder=FOLDER) as server, Page(server) as page:
        page.ask("frames", **{"from": 10, "count": 1})
        page.wait_for(lambda: any(text["type"] == "error" for text in page.texts))
        message = next(text["message"] for text in page.texts if text["type"] == "error")
        expect("10" in message, f"a damaged frame: {message}")
        page.ask("frames", **{"from": 11, "count": 1})
        page.wait_for(lambda: page.frame["number"] == 11)
    with open(os.path.join(path, "run.json"), "w", encoding="ascii") as file:
        file.write("{")
    found = subprocess.run([PROGRAM, "view", "--no-browser", path], capture_output=True, text=True, timeout=60, check=False)
    expect(found.returncode == 2 and "run.json" in found.stderr, f"a damaged run.json: {found}")
    shutil.rmtree(path)


def check_meshes():
    names = sorted(name for name in os.listdir(RUN) if name.endswith(".obj"))[:2]
    with Server(*(os.path.join(RUN, name) for name in names), folder=FOLDER) as server, Page(server) as page:
        expect(page.document["kind"] == "mesh" and [one["name"] for one in page.document["objects"]] == names, f"meshes: {page.document['objects']}")
        page.wait_for(lambda: page.frame)
        page.overlays = {}
        page.ask("overlays", names=["crossings"])
        page.ask("frames", **{"from": 0, "count": 1})
        page.wait_for(lambda: 6 in page.overlays)
        expect(page.ask("pick", object=1, triangle=0, weights=[1, 0, 0])["type"] == "picked", "picking in meshes")


def main():
    caches = find_caches()
    with Server(RUN, folder=FOLDER) as server:
        with Page(server) as page:
            check_frames(page, caches)
            check_rest(page, caches)
        expect(server.get("recording")[0] == 404, "the recording of a run")
    check_run_under_way()
    check_damage(caches)
    check_meshes()
    print(f"view_run: {len(FAULTS)} faults")
    return 1 if FAULTS else 0


if __name__ == "__main__":
    sys.exit(main())
