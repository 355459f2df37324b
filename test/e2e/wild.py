"""usage: wild.py FOLDER WORK TABLE EVERY: reads each EVERY-th file of FOLDER, compares triangles, box, area and volume with what another
reader reads (assimp; tinyusdz for .usda, where TULLE_TINYUSDZ names the folder in which npm installed it), drops a napkin on it for a
second, lets it fall as cloth where it or its repair is a manifold; a row a file.

Ends with 1 where a file crashes the program, another reader's triangles, box, area or volume are other, a run intersects, or a refusal
lacks the file's name, a place in it or advice."""
import math
import os
import re
import subprocess
import sys

TULLE = os.environ["TULLE"]
TINYUSDZ = os.environ.get("TULLE_TINYUSDZ", "")
LIMIT = 60  # [s] for a command
# Files whose difference is the other reader's fault, and the reason.
OTHERS = {
    "cubevt.obj": "assimp calls its own mesh of it invalid, and writes no face",
    "hardware.modeling.usda": "tinyusdz shows the class of prototypes, and none of its six copies",
    "InternalReferenceUnencapsulatedPrototypes.usda": "tinyusdz shows the prototypes, and none of their six copies",
}
# A refusal says where: a line, a byte, an element, or that the whole file lacks something.
PLACE = re.compile(r":\d+(:\d+)?: |\bbyte \d+|\b(triangle|triangles|vertex|vertices|face|edge|frame|node|mesh|accessor)s? '?\d+"
                   r"|\bholds no |\bshows no |\bhas no |\bis empty|\bno (meshes|triangles)|\bcannot be ")
# And what should be there, or what helps.
ADVICE = re.compile(r"\bshould\b|\bneeds?\b|\bmust\b|\?|([:;,]|mend it,) (write|make|merge|move|give|set|use|save|add|correct|turn|remove|close"
                    r"|choose|export|run|try|convert|join)\b|\bis needed\b")
ENDINGS = (".obj", ".stl", ".ply", ".glb", ".gltf", ".usda")


def run(*words, limit=LIMIT):
    """Exit code and all output; 124 where it took too long."""
    try:
        done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=limit, check=False)
        return done.returncode, done.stdout.decode("utf-8", "replace")
    except subprocess.TimeoutExpired:
        return 124, ""


def read_obj(path):
    """Places and triangles; lines and points are none."""
    places, faces = [], []
    with open(path, encoding="utf-8") as file:
        for line in file:
            words = line.split()
            if words[:1] == ["v"]:
                places.append(tuple(map(float, words[1:4])))
            elif words[:1] == ["f"]:
                faces.append(tuple(int(word.split("/")[0]) - 1 for word in words[1:4]))
    return places, faces


def measure(path):
    """Triangles, the box of those, area and volume."""
    places, faces = read_obj(path)
    used = {corner for face in faces for corner in face}
    if not used:
        return 0, [0.0] * 3, [0.0] * 3, 0.0, 0.0
    low = [min(places[v][k] for v in used) for k in range(3)]
    high = [max(places[v][k] for v in used) for k in range(3)]
    area = volume = 0.0
    for face in faces:
        a, b, c = ([places[v][k] - low[k] for k in range(3)] for v in face)
        u, w = ([q - p for p, q in zip(a, other)] for other in (b, c))
        normal = (u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0])
        area += 0.5 * math.sqrt(sum(x * x for x in normal))
        volume += sum(x * y for x, y in zip(a, normal)) / 6
    return len(faces), low, high, area, volume


def ask_assimp(path, work, is_y_up):
    """The same of what assimp reads and writes as OBJ, with z up; None where it does not read the file."""
    out = os.path.join(work, "assimp.obj")
    run("rm", "-f", out)
    code, _ = run("assimp", "export", path, out, "-tri")
    if code != 0 or not os.path.exists(out):
        return None
    count, low, high, area, volume = measure(out)
    if is_y_up:
        low, high = [low[0], -high[2], low[1]], [high[0], -low[2], high[1]]
    return count, low, high, area, volume


def ask_tinyusdz(path, work):
    """The same of what tinyusdz reads of a stage, with z up and in metres; None where it does not read the file."""
    out = os.path.join(work, "tinyusdz.obj")
    run("rm", "-f", out)
    script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "wild_usd.mjs")
    code, _ = run("node", script, TINYUSDZ, path, out)
    if code != 0 or not os.path.exists(out):
        return None
    with open(path, encoding="utf-8", errors="replace") as file:
        text = file.read()
    metres, up = re.search(r"^ *metersPerUnit *= *([-+.\deE]+)", text, re.M), re.search(r'^ *upAxis *= *"(\w)"', text, re.M)
    scale = float(metres[1]) if metres else 0.01
    count, low, high, area, volume = measure(out)
    if not up or up[1] == "Y":
        low, high = [low[0], -high[2], low[1]], [high[0], -low[2], high[1]]
    return count, [scale * x for x in low], [scale * x for x in high], scale**2 * area, scale**3 * volume


def compare(one, other):
    """What of two measurements is other: floats, and quads that are cut along the other diagonal."""
    size = max(abs(x) for x in one[1] + one[2]) or 1.0
    found = ["%d triangles, not %d" % (one[0], other[0])] if one[0] != other[0] else []
    if any(abs(a - b) > 2e-5 * size for a, b in zip(one[1] + one[2], other[1] + other[2])):
        found.append("the box")
    if abs(one[3] - other[3]) > 1e-4 * one[3]:
        found.append("area %g, not %g" % (one[3], other[3]))
    if abs(one[4] - other[4]) > 1e-4 * one[3] ** 1.5:
        found.append("volume %g, not %g" % (one[4], other[4]))
    return ", ".join(found)


def find_lack(said):
    """What a refusal lacks."""
    words = " ".join(said.split())
    lacks = [what for what, pattern in (("a place", PLACE), ("advice", ADVICE)) if not pattern.search(words)]
    return "without %s: " % " and ".join(lacks) if lacks else ""


def drop(work, mesh, box, is_cloth):
    """Of a napkin on the obstacle, or of the mesh as cloth, what `check` says of a second."""
    low, high = box[1:3]
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
        words = [line for line in said.splitlines() if ":" in line or "To mend it" in line] or [said]
        lack = find_lack(said)
        told = "refused: " + lack + (words[0] + " ... " + words[-1] if len(words) > 1 else words[0])[:400].replace(work + "/", "")
        return told, code < 0 or code > 4 or lack != ""
    code, said = run(TULLE, "check", out, "--list", "0")
    return said.splitlines()[-1] if said else "not judged", code != 0


def row(path, work):
    """The cells of a file, and whether one of them is a fault."""
    mesh = os.path.join(work, "mesh.obj")
    code, said = run(TULLE, "convert", path, mesh, *([] if path.endswith((".obj", ".stl", ".ply")) else ["--frame", "0"]))
    if code != 0:
        if code == 124:
            return ["-", "-", "over %d s" % LIMIT, "-", "-"], False
        lack, words = find_lack(said), said.strip().splitlines() or [""]
        is_fault = code not in (2, 3) or os.path.basename(path) not in said or lack != ""
        return ["-", "-", "refused: " + lack + words[0][:200], "-", "-"], is_fault
    box = measure(mesh)
    if box[0] == 0:
        return ["0", "-", "no triangles", "-", "-"], False
    is_y_up = path.endswith((".glb", ".gltf"))
    asks = not path.endswith(".usda") or TINYUSDZ != ""
    other = None if not asks else ask_tinyusdz(path, work) if path.endswith(".usda") else ask_assimp(path, work, is_y_up)
    unlike = compare(box, other) if other else ""
    same = "-" if not asks else "does not read it" if other is None else unlike or "same triangles, box, area and volume"
    reason = OTHERS.get(os.path.basename(path))
    is_unlike = unlike != "" and reason is None
    if unlike and reason:
        same += ": " + reason
    obstacle, is_bad = drop(work, mesh, box, False)
    fixed = os.path.join(work, "fixed.obj")
    code, said = run(TULLE, "convert", mesh, fixed, "--repair")
    reason = re.search(r"^  as cloth +(.*)$", said, re.M)
    cloth, is_torn = "no: " + (reason[1] if reason else said)[:120], False
    if code == 0 and reason and reason[1] == "can be used":
        cloth, is_torn = drop(work, fixed, measure(fixed), True)
        if "repaired    nothing" not in said:
            cloth = "repaired; " + cloth
    return [str(box[0]), same, "read", obstacle, cloth], is_unlike or is_bad or is_torn


def main():
    folder, work, table, every = sys.argv[1:]
    paths = sorted(os.path.join(top, name) for top, _, names in os.walk(folder) for name in names
                   if name.lower().endswith(ENDINGS))
    faults = 0
    with open(table, "w", encoding="utf-8") as file:
        file.write("| file | triangles | another reader | read | as obstacle, a napkin on it | as cloth |\n|---|---|---|---|---|---|\n")
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
