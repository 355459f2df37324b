"""usage: wild.py FOLDER WORK TABLE EVERY: reads each EVERY-th file of FOLDER, compares triangles, box and area with assimp's where it
reads the format, drops a napkin on it for a second, lets it fall as cloth where it or its repair is a manifold; a row a file.

Ends with 1 where a file crashes the program, a message names no file, a run intersects, or another reader's box is other."""
import os
import re
import subprocess
import sys

TULLE = os.environ["TULLE"]
LIMIT = 60  # [s] for a command
ENDINGS = (".obj", ".stl", ".ply", ".glb", ".gltf", ".usda")


def run(*words, limit=LIMIT):
    """Exit code and all output; 124 where it took too long."""
    try:
        done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=limit, check=False)
        return done.returncode, done.stdout.decode("utf-8", "replace")
    except subprocess.TimeoutExpired:
        return 124, ""


def read_obj(path):
    """Places and triangles that `tulle convert` wrote."""
    places, faces = [], []
    with open(path, encoding="utf-8") as file:
        for line in file:
            words = line.split()
            if words[:1] == ["v"]:
                places.append(tuple(map(float, words[1:4])))
            elif words[:1] == ["f"]:
                faces.append(tuple(int(word) - 1 for word in words[1:4]))
    return places, faces


def measure(path):
    places, faces = read_obj(path)
    used = {corner for face in faces for corner in face}
    if not used:
        return 0, [0.0] * 3, [0.0] * 3
    low = [min(places[v][k] for v in used) for k in range(3)]
    high = [max(places[v][k] for v in used) for k in range(3)]
    return len(faces), low, high


def ask_assimp(path, is_y_up):
    """Triangles and box, with z up; None where it does not read the file."""
    code, said = run("assimp", "info", path)
    faces = re.search(r"^Faces:\s+(\d+)", said, re.M)
    low = re.search(r"^Minimum point\s+\(([^)]*)\)", said, re.M)
    high = re.search(r"^Maximum point\s+\(([^)]*)\)", said, re.M)
    if code != 0 or not (faces and low and high):
        return None
    low, high = (list(map(float, found[1].split())) for found in (low, high))
    if is_y_up:
        low, high = [low[0], -high[2], low[1]], [high[0], -low[2], high[1]]
    return int(faces[1]), low, high


def differ(one, other):
    """Whether two boxes are others: assimp prints six digits."""
    size = max(abs(x) for x in one[1] + one[2]) or 1.0
    return any(abs(a - b) > 2e-5 * size for a, b in zip(one[1] + one[2], other[1] + other[2]))


def drop(work, mesh, box, is_cloth):
    """Of a napkin on the obstacle, or of the mesh as cloth, what `check` says of a second."""
    _, low, high = box
    size = max(b - a for a, b in zip(low, high)) or 1.0
    scale, top = 1.0 / size, (high[2] - low[2]) / size
    place = [-0.5 * (a + b) * scale for a, b in zip(low, high)]
    place[2] = -low[2] * scale
    body = "{mesh: {file: %s}, scale: %r, translate: [%r, %r, %r]%s}"
    thing = body % (os.path.basename(mesh), scale, *place[:2], place[2] + 0.05 * is_cloth, "")
    with open(os.path.join(work, "scene.yaml"), "w", encoding="utf-8") as file:
        file.write("time: {step: 1/30 s, frames: 30}\n")
        if is_cloth:
            file.write("cloth: [%s]\nobstacles: [{mesh: {shape: plane, size: [4, 4]}}]\n" % thing)
        else:
            file.write("cloth: [{mesh: {shape: rectangle, size: [0.6, 0.6], resolution: [16, 16]}, translate: [0, 0, %r]}]\n"
                       "obstacles: [%s]\n" % (top + 0.03, thing))
    out = os.path.join(work, "run")
    run("rm", "-rf", out)
    code, said = run(TULLE, "run", os.path.join(work, "scene.yaml"), "-o", out, "--progress", "none", "-t", "1")
    if code == 124:
        return "over %d s" % LIMIT, False
    if code != 0:
        words = [line for line in said.splitlines() if ":" in line]
        return "refused: " + (words[0] if words else said)[:160].replace(work + "/", ""), code < 0 or code > 4
    code, said = run(TULLE, "check", out, "--list", "0")
    return said.splitlines()[-1] if said else "not judged", code != 0


def row(path, work):
    """The cells of a file, and whether one of them is a fault."""
    mesh = os.path.join(work, "mesh.obj")
    code, said = run(TULLE, "convert", path, mesh, *([] if path.endswith((".obj", ".stl", ".ply")) else ["--frame", "0"]))
    if code != 0:
        words = said.strip().splitlines()
        is_fault = code not in (2, 3, 124) or (code != 124 and os.path.basename(path) not in said)
        return ["-", "-", "over %d s" % LIMIT if code == 124 else "refused: " + words[0][:200], "-", "-"], is_fault
    box = measure(mesh)
    if box[0] == 0:
        return ["0", "-", "no triangles", "-", "-"], False
    is_y_up = path.endswith((".glb", ".gltf"))
    other = ask_assimp(path, is_y_up) if not path.endswith(".usda") else None
    same = "-" if other is None else "box differs" if differ(box, other) else "same box, %d triangles" % other[0]
    obstacle, is_bad = drop(work, mesh, box, False)
    fixed = os.path.join(work, "fixed.obj")
    code, said = run(TULLE, "convert", mesh, fixed, "--repair")
    reason = re.search(r"^  as cloth +(.*)$", said, re.M)
    cloth, is_torn = "no: " + (reason[1] if reason else said)[:120], False
    if code == 0 and reason and reason[1] == "can be used":
        cloth, is_torn = drop(work, fixed, measure(fixed), True)
        if "repaired    nothing" not in said:
            cloth = "repaired; " + cloth
    return [str(box[0]), same, "read", obstacle, cloth], is_bad or is_torn


def main():
    folder, work, table, every = sys.argv[1:]
    paths = sorted(os.path.join(top, name) for top, _, names in os.walk(folder) for name in names
                   if name.lower().endswith(ENDINGS))
    faults = 0
    with open(table, "w", encoding="utf-8") as file:
        file.write("| file | triangles | assimp | read | as obstacle, a napkin on it | as cloth |\n|---|---|---|---|---|---|\n")
        for path in paths[:: int(every)]:
            cells, is_fault = row(path, work)
            faults += is_fault
            name = os.path.relpath(path, folder)
            file.write("| %s%s | %s |\n" % (name, " **fault**" if is_fault else "",
                                           " | ".join(cell.replace("|", "/") for cell in cells)))
            file.flush()
            if is_fault:
                print("%s: %s" % (name, cells))
    print("%d of %d files, %d faults" % (len(paths[:: int(every)]), len(paths), faults))
    return 1 if faults else 0


sys.exit(main())
