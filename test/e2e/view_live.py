"""A live scene of `tulle view`: what is done by hand has its effect, is recorded, and is repeated to the same bits, on any number of
threads, watched or not. usage: view_live.py FOLDER (with sheet.yaml, made by view_start.bash)"""
import hashlib
import json
import os
import re
import signal
import subprocess
import sys
import time

from view_client import PROGRAM, Page, Server

FOLDER = sys.argv[1]
SCENE = os.path.join(FOLDER, "sheet.yaml")
SHEET, BALL, BLOCK, GROUND = 0, 1, 2, 3
FAULTS = []


def expect(truth, what):
    if not truth:
        FAULTS.append(what)
        print("fault:", what, flush=True)


def step(page, count):
    """So many steps, and the exact frame behind them."""
    wanted = (page.state["step"] if page.state else 0) + count
    page.ask("step", count=count)
    page.wait_for(lambda: page.state["step"] >= wanted and page.state.get("hash"))
    page.ask("exact")
    page.wait_for(lambda: page.frame["number"] == wanted and all(code in (0, 1) for code in page.frame["codings"]))
    return page.get_positions(SHEET)


def get_vertex(page, index, vertex):
    return page.get_positions(index)[3 * vertex:3 * vertex + 3]


def get_distance(a, b):
    return sum((x - y) ** 2 for x, y in zip(a, b)) ** 0.5


def ask_well(page, type_name, **members):
    answer = page.ask(type_name, **members)
    expect(answer["type"] != "error", f"{type_name} {members}: {answer}")
    return answer


def play(page):
    """A session that has everything in it."""
    page.wait_for(lambda: page.state and page.state.get("hash"))
    expect(page.state["step"] == 0 and not page.state["is_running"], "a scene opens paused at its start")
    step(page, 10)
    corner = 12 * 13 + 6  # in the middle of the edge opposite to the pins
    triangle = next(i for i in range(len(page.meshes[SHEET][1]) // 3) if corner in page.meshes[SHEET][1][3 * i:3 * i + 3])
    weights = [1.0 if vertex == corner else 0.0 for vertex in page.meshes[SHEET][1][3 * triangle:3 * triangle + 3]]
    point = get_vertex(page, SHEET, corner)
    grab = ask_well(page, "grab", object=SHEET, triangle=triangle, weights=weights, point=point, force=5.0)["grab"]
    target = [point[0], point[1] - 0.05, point[2] + 0.2]
    for i in range(1, 9):
        ask_well(page, "drag", grab=grab, point=[a + (b - a) * i / 8 for a, b in zip(point, target)])
        step(page, 5)
    step(page, 30)
    expect(get_distance(get_vertex(page, SHEET, corner), target) < 0.02, f"what was grabbed is at {get_vertex(page, SHEET, corner)}, not {target}")
    expect(page.state["held"] == [grab], f"held: {page.state['held']}")
    ask_well(page, "drag", grab=grab, point=[0, 0, 1000.0])  # beyond what five newtons can do
    step(page, 10)
    expect(get_vertex(page, SHEET, corner)[2] < 2.0, "the force has a limit")
    ask_well(page, "drag", grab=grab, point=target)
    step(page, 10)
    pins = ask_well(page, "pins", object=SHEET)["pins"]
    expect(pins == [[0], [12]], f"pins: {pins}")
    before = get_vertex(page, SHEET, 0)
    ask_well(page, "cut_pin", object=SHEET, vertex=0)
    step(page, 10)
    expect(get_vertex(page, SHEET, 0)[2] < before[2] - 0.01, "a pin that was cut lets go")
    ask_well(page, "let_go", grab=grab)
    expect(page.ask("let_go", grab=grab)["type"] == "error", "a grab ends once")
    ask_well(page, "set", what="wind", value=[0, 3, 0])
    ask_well(page, "set", what="gusts", value=0.5)
    ask_well(page, "set", what="gravity", value=[0, 0, -3.0])
    ask_well(page, "set", what="material", object=SHEET, value="silk")
    ask_well(page, "set", what="friction", object=SHEET, value=0.9)
    step(page, 10)
    ask_well(page, "move", object=BALL, position=[0, 0.05, 0.3], rotation=[0.9238795325112867, 0, 0, 0.3826834323650898])
    before = get_vertex(page, BALL, 0)
    step(page, 30)
    moved = get_distance(before, get_vertex(page, BALL, 0))
    expect(0.03 < moved < 0.4, f"the ball moved by {moved}")
    block = get_vertex(page, BLOCK, 0)
    held = ask_well(page, "grab", object=BLOCK, triangle=0, weights=[1, 0, 0], point=get_vertex(page, BLOCK, page.meshes[BLOCK][1][0]), force=20.0)["grab"]
    ask_well(page, "drag", grab=held, point=[0.9, 0, 0.5])
    step(page, 60)
    expect(get_vertex(page, BLOCK, 0)[2] > block[2] + 0.2, f"the block was not lifted: {block} {get_vertex(page, BLOCK, 0)}")
    ask_well(page, "let_go", grab=held)
    ask_well(page, "move", object=BLOCK, position=[0.6, 0.2, 0.2], rotation=[1, 0, 0, 0], force=50.0)
    step(page, 40)
    return page.state["hash"], page.state["step"]


def check_replays(state, steps, recording):
    """The session and the recording come to the same state, on one thread and on two."""
    path = os.path.join(FOLDER, "recording.tullerec")
    with open(path, "wb") as file:
        file.write(recording)
    for threads in ("1", "2"):
        found = subprocess.run([PROGRAM, "replay", path, "--threads", threads], capture_output=True, text=True, timeout=300, check=False)
        expect(found.returncode == 0 and f"the last {state}" in found.stdout, f"tulle replay: {found.returncode} {found.stdout} {found.stderr}")
        with Server(SCENE, "--replay", "sheet.session", "--threads", threads, folder=FOLDER) as server:
            server.read_line()
            line = server.read_line()
            expect(line == f"session repeated: {steps} steps, the same state {state}", f"--replay on {threads} threads: {line!r}, wanted {steps} {state}")
    with open(os.path.join(FOLDER, "sheet.session"), encoding="utf-8") as file:
        lines = file.read().splitlines()
    with open(os.path.join(FOLDER, "other.session"), "w", encoding="utf-8") as file:
        file.write("\n".join(re.sub(r'"value":\[0,3,0\]', '"value":[0,3.5,0]', line) for line in lines) + "\n")
    with Server(SCENE, "--replay", "other.session", folder=FOLDER) as server:
        server.read_line()
        line = server.read_line()
        expect("another state" in line, f"a session that was changed: {line!r}")
    expect(server.code == 1, f"a session that was changed: exit code {server.code}")
    os.remove(os.path.join(FOLDER, "other.session"))


def check_whether_watched():
    """120 steps without a page, with one, and with three that want everything: the same hash."""
    hashes = set()
    for pages in (0, 1, 3):
        for threads in ("1", "2"):
            with Server(SCENE, "--threads", threads, folder=FOLDER) as server:
                watchers = [Page(server) for _ in range(max(pages, 1))]
                first = watchers[0]
                for page in watchers[:pages]:
                    page.ask("overlays", names=page.document["overlays"])
                first.ask("step", count=120)
                if pages == 0:
                    first.socket.close()
                    time.sleep(1.0)
                    first = Page(server)
                first.wait_for(lambda: first.state and first.state["step"] == 120 and first.state.get("hash"))
                hashes.add(first.state["hash"])
    expect(len(hashes) == 1, f"hashes: {hashes}")
    run = subprocess.run([PROGRAM, "run", SCENE, "-o", os.path.join(FOLDER, "watched.run"), "--set", "time.frames=120", "--set", "time.steps_per_frame=1"],
                         capture_output=True, text=True, timeout=300, check=True)
    expect(f"state hash: {hashes.copy().pop()}" in run.stdout + run.stderr, f"tulle run comes to another state: {hashes} {run.stdout}")


def check_time_travel(page):
    """Rewinding leads to the same states again; reset to the start."""
    page.ask("reset")
    page.wait_for(lambda: page.state["step"] == 0 and page.state.get("hash"))
    start = page.state["hash"]
    step(page, 100)
    first, saved = page.state["hash"], page.state["saved"]
    expect(len(saved) >= 3 and saved[0] == 0, f"saved states: {saved}")
    ask_well(page, "rewind", step=saved[2] + 1)
    page.wait_for(lambda: page.state["step"] == saved[2])
    expect(page.state["saved"] == saved[:3], f"saved after rewinding: {page.state['saved']}")
    step(page, 100 - saved[2])
    expect(page.state["hash"] == first, "another state after rewinding")
    # Behind a moved obstacle, to a time before it was moved.
    ask_well(page, "move", object=BALL, position=[0, 0, 0.2], rotation=[1, 0, 0, 0])
    step(page, 40)
    second = page.state["hash"]
    ask_well(page, "rewind", step=saved[1])
    page.wait_for(lambda: page.state["step"] == saved[1])
    step(page, 100 - saved[1])
    expect(page.state["hash"] == first, "another state after rewinding to before a move")
    ask_well(page, "move", object=BALL, position=[0, 0, 0.2], rotation=[1, 0, 0, 0])
    step(page, 40)
    expect(page.state["hash"] == second, "another state when the move is done again")
    session = os.path.join(FOLDER, "sheet.session")
    if os.path.exists(session):
        os.remove(session)
    os.symlink("elsewhere.txt", session)  # whoever gave the folder may have put it there
    answer = page.ask("save_session")
    expect(answer["type"] == "error" and "symbolic link" in answer["message"], f"a session through a link: {answer}")
    expect(not os.path.exists(os.path.join(FOLDER, "elsewhere.txt")), "a session was written through a link")
    os.remove(session)
    ask_well(page, "save_session")
    page.ask("reset")
    page.wait_for(lambda: page.state["step"] == 0 and page.state.get("hash"))
    expect(page.state["hash"] == start, "another start after a reset")
    return second


def check_pick(page):
    step(page, 60)
    found = ask_well(page, "pick", object=SHEET, triangle=10, weights=[0.2, 0.3, 0.5])
    corners = page.meshes[SHEET][1][30:33]
    expect(found["triangle"]["vertices"] == list(corners), f"picked: {found}")
    expect(get_distance(found["vertex"]["position"], get_vertex(page, SHEET, found["vertex"]["index"])) < 1e-5, f"picked: {found}")
    expect(found["vertex"]["mass"] > 0 and set(found["triangle"]["strain"]) == {"warp", "weft", "shear"}, f"picked: {found}")
    page.ask("overlays", names=["contacts", "crossings", "gaps", "strain", "velocities", "patches"])
    page.wait_for(lambda: len(page.overlays) == 6)
    expect(page.overlays[1][1] > 0 and len(page.overlays[1][2]) == 44 * page.overlays[1][1], f"contacts: {page.overlays[1][1]}")
    expect(page.overlays[6][1] == 0, "crossings")
    with_contacts, others = 0, set()
    for triangle in range(0, len(page.meshes[SHEET][1]) // 3):
        if triangle % 100 == 99:
            time.sleep(1.0)
        contacts = ask_well(page, "pick", object=SHEET, triangle=triangle, weights=[1, 0, 0])["contacts"]
        with_contacts += bool(contacts)
        others |= {(contact["object"], contact["name"]) for contact in contacts}
    expect(with_contacts > 0 and (BALL, "ball") in others, f"contacts that were picked: {others}")
    expect(all(page.document["objects"][number]["name"] == name for number, name in others), f"contacts that were picked: {others}")
    series = ask_well(page, "series", names=["kinetic_energy", "contacts", "seconds"], buckets=7)
    expect(len(series["steps"]) == 7 and len(series["low"]["contacts"]) == 7, f"series: {series}")
    expect(all(low <= high for low, high in zip(series["low"]["kinetic_energy"], series["high"]["kinetic_energy"])), f"series: {series}")
    page.ask("overlays", names=[])


def check_editing(server):
    with Page(server) as page, Page(server) as other:
        page.wait_for(lambda: page.state and page.state.get("hash"))
        text = ask_well(page, "text")["text"]
        with open(SCENE, encoding="utf-8") as file:
            expect(file.read() == text, "the text is the file's")
        answer = ask_well(page, "check", text=text.replace("radius: 0.15", "radius: -1"))
        expect(answer["list"] and answer["list"][0]["line"] == 11, f"check: {answer}")
        expect(ask_well(page, "check", text=text)["list"] == [], "check of a good scene")
        keys = {key["path"]: key for key in ask_well(page, "schema")["keys"]}
        expect(keys["time.step"]["unit"] == "s" and "sphere" in keys["obstacles[].mesh.shape"]["choices"], "the schema")
        expect("silk" in keys["cloth[].material.preset"]["choices"], "presets in the schema")
        names = ask_well(page, "examples")["names"]
        expect("ball.yaml" in names, f"examples: {names}")
        example = ask_well(page, "example", name="ball.yaml")["text"]
        expect("cloth:" in example, "an example")
        meshes = len(page.document["objects"])
        answer = ask_well(page, "save", text=text.replace("name: ball,", "name: globe,"))
        expect(answer["type"] == "saved", f"save: {answer}")
        for one in (page, other):
            one.wait_for(lambda one=one: one.document["objects"][BALL]["name"] == "globe" and len(one.meshes) == meshes and one.frame)
        step(page, 5)
        ask_well(page, "save", text=text)
        with open(SCENE, encoding="utf-8") as file:
            expect(file.read() == text, "saved again")
        # A file that was changed elsewhere is not replaced before one is told; permissions stay.
        os.chmod(SCENE, 0o640)
        changed = text + "# changed elsewhere\n"
        with open(SCENE, "w", encoding="utf-8") as file:
            file.write(changed)
        answer = page.ask("save", text=text)
        with open(SCENE, encoding="utf-8") as file:
            expect(answer["type"] == "error" and "has changed" in answer["message"] and file.read() == changed, f"a change was lost: {answer}")
        expect(page.ask("save", text=text)["type"] == "saved", "saving in spite of a change")
        expect(ask_well(other, "text")["text"] == text, "the other page reads what was saved")
        expect(page.ask("save", text=text + "# mine\n")["type"] == "saved", "its own text is no change of others")
        expect(other.ask("save", text=text)["type"] == "error", "a page replaces what another saved")
        expect(other.ask("save", text=text)["type"] == "saved", "saving in spite of another page")
        expect(os.stat(SCENE).st_mode & 0o777 == 0o640, f"permissions of a saved scene: {os.stat(SCENE).st_mode:o}")


def check_errors():
    """A scene with errors opens to be mended; one that is not there does not, nor do other things."""
    broken = os.path.join(FOLDER, "broken.yaml")
    with open(SCENE, encoding="utf-8") as file:
        text = file.read()
    with open(broken, "w", encoding="utf-8") as file:
        file.write(text.replace("resolution: [13, 13]", "resolution: [1, 1]"))
    with Server(broken, folder=FOLDER) as server:
        with Page(server) as page:
            expect(page.document["objects"] == [] and page.document["problems"] and "edit" in page.document["abilities"], f"a broken scene: {page.document}")
            expect(page.ask("run")["type"] == "error", "a broken scene runs")
            expect(ask_well(page, "save", text=text)["type"] == "saved", "mending")
            page.wait_for(lambda: page.document["objects"] and page.state and page.state.get("hash"))
            page.ask("step", count=3)
            page.wait_for(lambda: page.state["step"] == 3)
    with open(broken, "w", encoding="utf-8") as file:  # a start that intersects
        file.write(text.replace("translate: [0, 0, 0.45]", "translate: [0, 0, 0.3]"))
    with Server(broken, folder=FOLDER) as server:
        with Page(server) as page:
            page.wait_for(lambda: page.state and page.state["has_failed"])
            expect("intersect" in page.state["message"], f"a start that intersects: {page.state['message']}")
            expect(page.ask("run")["type"] == "error" and page.ask("save_session")["type"] == "error", "it runs all the same")
            ask_well(page, "pick", object=0, triangle=0, weights=[1, 0, 0])
    near = text.replace("translate: [0, 0, 0.45]", "translate: [0, 0, 0.2 mm]")
    near = near[: near.index("obstacles:")] + "obstacles: [{name: table, mesh: {shape: plane, size: [2, 2]}}]\n"
    with open(broken, "w", encoding="utf-8") as file:  # a start that is narrower than the least contact distance
        file.write(near)
    with Server(broken, folder=FOLDER) as server:
        with Page(server) as page:
            page.wait_for(lambda: page.state and page.state.get("hash"))
            expect("a thickness of 0.2 mm" in page.state["message"], f"a narrow start: {page.state['message']}")
    for arguments, words in ((["none.yaml"], "cannot be opened"), (["none"], "none"), ([FOLDER], ""), (["sheet.yaml", "--replay", "none"], "none"),
                             (["sheet.yaml", "--replay", "sheet.yaml"], ""), (["sheet.yaml", "--port", "99999"], "65535"), (["sheet.yaml", "--listen", "203.0.113.1"], "listened"), (["sheet.yaml", "--host-name", "a/b"], "letters"),
                             (["sheet.yaml", "--listen", "lo"], "in numbers"), (["sheet.yaml", "--listen", ""], "in numbers")):
        found = subprocess.run([PROGRAM, "view", "--no-browser", *arguments], cwd=FOLDER, capture_output=True, text=True, timeout=60, check=False)
        expect(found.returncode in (2, 3) and words in found.stderr and found.stderr.startswith("tulle view: "), f"view {arguments}: {found}")
    with Server(SCENE, folder=FOLDER) as server:
        found = subprocess.run([PROGRAM, "view", "--no-browser", "--port", str(server.port), SCENE], capture_output=True, text=True, timeout=60, check=False)
        expect(found.returncode == 3 and "listened" in found.stderr, f"a port in use: {found}")
    with Server(SCENE, "--listen", "localhost", folder=FOLDER) as server:
        expect(server.host == "127.0.0.1" and server.get("")[0] == 200, f"localhost is {server.host}")
    check_browser()


def check_browser():
    """The browser is opened with the address, and Ctrl-C of the terminal is not for it."""
    folder = os.path.join(FOLDER, "browser")
    os.mkdir(folder)
    with open(os.path.join(folder, "xdg-open"), "w", encoding="ascii") as file:
        file.write(f'#!/bin/sh\necho "$1 $(cut -d" " -f5 /proc/$$/stat)" > {folder}/new && mv {folder}/new {folder}/opened\n')
    os.chmod(os.path.join(folder, "xdg-open"), 0o755)
    with subprocess.Popen([PROGRAM, "view", SCENE], stdout=subprocess.PIPE, text=True, env={**os.environ, "PATH": folder + ":" + os.environ["PATH"]}) as process:
        address = process.stdout.readline().strip()
        end = time.monotonic() + 60.0
        while not os.path.exists(os.path.join(folder, "opened")) and time.monotonic() < end:
            time.sleep(0.02)
        with open(os.path.join(folder, "opened"), encoding="ascii") as file:
            opened, group = file.read().split()
        expect(opened == address and int(group) != os.getpgid(process.pid), f"opened {opened} in group {group}")
        process.send_signal(signal.SIGINT)


def main():
    with Server(SCENE, folder=FOLDER) as server:
        with Page(server) as page:
            state, steps = play(page)
            answer = ask_well(page, "save_session")
            expect(answer["file"] == "sheet.session", f"save_session: {answer}")
            recording = server.get("recording")[2]
            check_pick(page)
            print("played", flush=True)
            moved = check_time_travel(page)
            with Server(SCENE, "--replay", "sheet.session", folder=FOLDER) as other:
                other.read_line()
                expect("the same state " + moved in other.read_line(), "a session that was rewound")
        check_editing(server)
    expect(server.code == 0, f"exit code {server.code}: {server.errors}")
    with Server(SCENE, folder=FOLDER) as server:  # a play from the start has the same hash, on another server
        with Page(server) as page:
            again, _ = play(page)
            expect(again == state, "playing again comes to another state")
            ask_well(page, "save_session")
    check_replays(state, steps, recording)
    print("repeated", flush=True)
    check_whether_watched()
    check_errors()
    begin = time.monotonic()
    with Server(SCENE, folder=FOLDER) as server:  # Ctrl-C in the middle of a step
        with Page(server) as page:
            page.ask("run", speed=0)
            page.wait_for(lambda: page.state and page.state["step"] > 3)
            server.process.send_signal(signal.SIGTERM)
    expect(server.code == 0, "SIGTERM")
    print(f"view_live: {len(FAULTS)} faults; {hashlib.sha256(json.dumps(state).encode()).hexdigest()[:8]} {time.monotonic() - begin:.1f} s")
    return 1 if FAULTS else 0


if __name__ == "__main__":
    sys.exit(main())
