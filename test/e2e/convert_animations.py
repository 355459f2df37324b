"""Compares what convert_animations.sh made with the files of the run, by readers of its own."""
import csv
import json
import math
import os
import re
import struct
import sys
import zipfile

faults = 0


def expect(is_so, text):
    global faults
    if not is_so:
        faults += 1
        print("fault:", text)


def round_float(value):
    return struct.unpack("<f", struct.pack("<f", value))[0]


def read_pc2(path):
    data = open(path, "rb").read()
    count, _, _, frames = struct.unpack_from("<iffi", data, 16)
    return [struct.unpack_from(f"<{3 * count}f", data, 32 + 12 * count * i) for i in range(frames)]


def read_obj(path):
    lines = [line.split() for line in open(path)]
    return ([float(word) for line in lines if line[0] == "v" for word in line[1:]],
            [int(word) - 1 for line in lines if line[0] == "f" for word in line[1:]])


def read_npz(path):
    """Arrays as (shape, flat values); zipfile checks the sums."""
    arrays = {}
    with zipfile.ZipFile(path) as archive:
        expect(archive.testzip() is None, f"{path}: a sum is wrong")
        for name in archive.namelist():
            data = archive.read(name)
            expect(data[:8] == b"\x93NUMPY\1\0", f"{path}: {name} is no .npy")
            size = struct.unpack_from("<H", data, 8)[0]
            head = eval(data[10:10 + size].decode())
            expect((10 + size) % 64 == 0 and not head["fortran_order"], f"{path}: the head of {name}")
            body, kind = data[10 + size:], head["descr"]
            if kind.startswith("<U"):
                width = 4 * int(kind[2:])
                values = [body[i:i + width].decode("utf-32-le").rstrip("\0") for i in range(0, len(body), width)]
            else:
                letter = {"<f4": "f", "<f8": "d", "<i8": "q"}[kind]
                values = struct.unpack(f"<{len(body) // int(kind[2])}{letter}", body)
            expect(len(values) == math.prod(head["shape"]), f"{path}: {name} has {len(values)} values")
            arrays[name[:-4]] = (head["shape"], values)
    return arrays


def read_gltf(path):
    data = open(path, "rb").read()
    if path.endswith(".gltf"):
        document = json.loads(data)
        return document, open(document["buffers"][0]["uri"], "rb").read()
    expect(struct.unpack_from("<4sII", data) == (b"glTF", 2, len(data)), f"{path}: header")
    size = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20:20 + size]), data[28 + size:]


def read_accessor(gltf, number):
    document, buffer = gltf
    accessor = document["accessors"][number]
    width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}[accessor["type"]] * accessor["count"]
    begin = document["bufferViews"][accessor["bufferView"]]["byteOffset"] + accessor["byteOffset"]
    return struct.unpack_from(f"<{width}{'I' if accessor['componentType'] == 5125 else 'f'}", buffer, begin)


def turn(values):
    """From z up to y up."""
    return tuple(round_float(x) for i in range(0, len(values), 3) for x in (values[i], values[i + 2], -values[i + 1]))


def read_usd(path):
    """Prims by name: attributes as text, time samples as {code: text}."""
    prims, stack, samples = {}, [], None
    text = re.sub(r",\n\s+(?=[-\d(])(?![-\d.e+]+: )", ", ", open(path).read())
    for line in text.split("\n"):
        line = line.strip()
        begin = re.match(r'(?:def|class)(?: \w+)? "(\w+)"', line)
        if begin:
            stack.append(begin[1])
            prims["/".join(stack)] = {}
        elif line.endswith(".timeSamples = {"):
            samples = prims["/".join(stack)].setdefault(line.split()[1][:-len(".timeSamples")], {})
        elif line == "}":
            if samples is None:
                stack.pop()
            samples = None
        elif samples is not None:
            code, value = line.split(": ", 1)
            samples[float(code)] = value.rstrip(",")
        elif " = " in line and stack:
            name, value = line.split(" = ", 1)
            prims["/".join(stack)][name.split()[-1]] = value
    return prims


def get_numbers(text):
    return [float(word) for word in re.findall(r"-?\d[\d.]*(?:e[-+]?\d+)?", text)]


def get_floats(text):
    return tuple(round_float(value) for value in get_numbers(text))


names = [body["name"] for body in json.load(open("falls/run.json"))["bodies"]]
obj = {name: read_obj(f"falls/{name}.obj") for name in names}
frames = {}
for name in names:
    path = f"falls/{name}.pc2"
    frames[name] = read_pc2(path) if os.path.exists(path) else [tuple(map(round_float, obj[name][0]))] * 9
times = [float(row["time"]) for row in csv.DictReader(open("falls/frames.csv"))]
expect(names == ["sheet", "floor", "wall", "box.000", "box.001"] and len(times) == 9, f"the run has {names}")

# ---- NPZ ----
for path in ("falls.npz", "double.npz", "y.npz"):
    arrays = read_npz(path)
    counts = [len(obj[name][0]) // 3 for name in names]
    expect(arrays["names"][1] == names, f"{path}: {arrays['names']}")
    expect(list(arrays["times"][1]) == times, f"{path}: times")
    expect(arrays["positions"][0] == (9, sum(counts), 3), f"{path}: shape {arrays['positions'][0]}")
    expect(list(arrays["first_vertices"][1]) == [sum(counts[:i]) for i in range(6)], f"{path}: first_vertices")
    corners, first = [], 0
    for name, count in zip(names, counts):
        corners += [first + corner for corner in obj[name][1]]
        first += count
    expect(list(arrays["triangles"][1]) == corners, f"{path}: triangles")
    wanted = [value for i in range(9) for name in names
              for value in ((turn if path == "y.npz" else tuple)(
                  obj[name][0] if path == "double.npz" and name == "floor" else frames[name][i]))]
    expect(list(arrays["positions"][1]) == wanted, f"{path}: positions")
expect(read_npz("seam.npz")["names"][1] == ["a sheet é.obj"], "a name with a blank and a letter beyond ASCII")

# ---- MDD ----
data = open("sheet.mdd", "rb").read()
expect(struct.unpack_from(">ii", data) == (9, 36), "sheet.mdd: counts")
expect(struct.unpack_from(">9f", data, 8) == tuple(map(round_float, times)), "sheet.mdd: times")
expect(struct.unpack_from(">972f", data, 44) == sum(frames["sheet"], ()), "sheet.mdd: positions")


# ---- glTF ----
def check_morphs(path, node, wanted, wanted_times):
    gltf = read_gltf(path)
    document = gltf[0]
    mesh = document["meshes"][node["mesh"]]
    primitive = mesh["primitives"][0]
    expect(len(primitive["targets"]) == len(wanted) == len(mesh["weights"]), f"{path}: targets")
    expect(mesh["weights"] == [1] + [0] * (len(wanted) - 1), f"{path}: weights")
    base = read_accessor(gltf, primitive["attributes"]["NORMAL"])
    for target, positions in zip(primitive["targets"], wanted):
        expect(read_accessor(gltf, target["POSITION"]) == turn(positions), f"{path}: a target")
        normals = [a + b for a, b in zip(base, read_accessor(gltf, target["NORMAL"]))]
        expect(all(abs(math.dist((0, 0, 0), normals[i:i + 3]) - 1) < 1e-6 for i in range(0, len(normals), 3)),
               f"{path}: normals")
    for sampler in document["animations"][0]["samplers"]:
        expect(read_accessor(gltf, sampler["input"]) == tuple(map(round_float, wanted_times)), f"{path}: times")
    channel = [channel for channel in document["animations"][0]["channels"] if channel["target"]["path"] == "weights"][0]
    sampler = document["animations"][0]["samplers"][channel["sampler"]]
    size = len(wanted)
    expect(read_accessor(gltf, sampler["output"]) == tuple(float(i // size == i % size) for i in range(size * size)),
           f"{path}: weights over time")
    return sampler["interpolation"]


for path in ("falls.glb", "falls.gltf"):
    gltf = read_gltf(path)
    nodes = gltf[0]["nodes"]
    expect([node["name"] for node in nodes] == names, f"{path}: nodes")
    for node in (nodes[0], nodes[2]):
        expect(check_morphs(path, node, frames[node["name"]], times) == "LINEAR", path)
    mesh = gltf[0]["meshes"][nodes[1]["mesh"]]["primitives"][0]
    expect(read_accessor(gltf, mesh["attributes"]["POSITION"]) == turn(frames["floor"][0]), f"{path}: floor")
    expect(list(read_accessor(gltf, mesh["indices"])) == obj["floor"][1], f"{path}: indices")
    expect(nodes[3]["mesh"] == nodes[4]["mesh"], f"{path}: the boxes share no mesh")
    # Poses against the caches: translation and rotation of the nodes, applied here.
    animation = gltf[0]["animations"][0]
    for number in (3, 4):
        drives = {channel["target"]["path"]: read_accessor(gltf, animation["samplers"][channel["sampler"]]["output"])
                  for channel in animation["channels"] if channel["target"]["node"] == number}
        primitive = gltf[0]["meshes"][nodes[number]["mesh"]]["primitives"][0]
        local = read_accessor(gltf, primitive["attributes"]["POSITION"])
        worst = 0.0
        for i in range(9):
            x, y, z, w = drives["rotation"][4 * i:4 * i + 4]
            rows = ((1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
                    (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
                    (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)))
            wanted = turn(frames[names[number]][i])
            for v in range(0, len(local), 3):
                for k in range(3):
                    value = drives["translation"][3 * i + k] + sum(rows[k][j] * local[v + j] for j in range(3))
                    worst = max(worst, abs(value - wanted[v + k]))
        expect(worst < 2e-7, f"{path}: {names[number]} is {worst} m off")
thin = read_gltf("thin.glb")[0]
expect(check_morphs("thin.glb", thin["nodes"][0], [frames["sheet"][i] for i in (1, 4, 7)], [times[i] for i in (1, 4, 7)]) ==
       "STEP", "thin.glb: interpolation")
expect(sorted(name for name in os.listdir(".") if name.startswith("one_")) == ["one_002.glb", "one_004.glb"], "one_*.glb")
gltf = read_gltf("one_004.glb")
expect("animations" not in gltf[0], "one_004.glb moves")
mesh = gltf[0]["meshes"][0]["primitives"][0]
expect(read_accessor(gltf, mesh["attributes"]["POSITION"]) == turn(frames["sheet"][4]), "one_004.glb")
gltf = read_gltf("smooth.glb")
ply = open("smooth_last.ply", "rb").read()
count = int(re.search(rb"element vertex (\d+)", ply)[1])
last = struct.unpack_from(f"<{3 * count}d", ply, ply.index(b"end_header\n") + 11)
expect(read_accessor(gltf, gltf[0]["meshes"][0]["primitives"][0]["targets"][-1]["POSITION"]) ==
       tuple(map(round_float, last)), "smooth.glb: the last frame")
gltf = read_gltf("seam.glb")
mesh = gltf[0]["meshes"][0]["primitives"][0]
corners = read_accessor(gltf, mesh["indices"])
points, uvs = (read_accessor(gltf, mesh["attributes"][name]) for name in ("POSITION", "TEXCOORD_0"))
expect(corners[:4] == (0, 1, 2, 4) and len(points) == 15, f"seam.glb: vertices {corners}")
expect([uvs[2 * c:2 * c + 2] for c in corners] ==
       [(0, 1), (1, 1), (1, 0), (0.25, 0.875), (1, 0), (0, 0)], f"seam.glb: texture coordinates {uvs}")

# ---- USD ----
prims = read_usd("falls.usda")
for name in ("sheet", "wall"):
    prim = prims[f"World/{name}"]
    points = prim["points"]
    expect(sorted(points) == list(range(9)), f"falls.usda: times of {name}")
    for i in range(9):
        expect(get_floats(points[i]) == frames[name][i], f"falls.usda: {name}, frame {i}")
        wanted = tuple(pick(frames[name][i][k::3]) for pick in (min, max) for k in range(3))
        expect(get_floats(prim["extent"][i]) == wanted, f"falls.usda: extent of {name}")
        following = min(i, 7)
        speeds = [(b - a) / (times[following + 1] - times[following])
                  for a, b in zip(frames[name][following], frames[name][following + 1])]
        expect(all(abs(a - b) <= 1e-6 * max(1, abs(b)) for a, b in zip(get_floats(prim["velocities"][i]), speeds)),
               f"falls.usda: velocities of {name}, frame {i}")
        normals = get_floats(prim["normals"][i])
        expect(all(abs(math.dist((0, 0, 0), normals[v:v + 3]) - 1) < 1e-6 for v in range(0, len(normals), 3)),
               f"falls.usda: normals of {name}")
expect(get_floats(prims["World/floor"]["points"]) == frames["floor"][0], "falls.usda: floor")
rows = {(int(row["frame"]), int(row["body"])): row for row in csv.DictReader(open("falls/bodies.csv"))}
for number in (3, 4):
    prim = prims["World/" + names[number].replace(".", "_")]
    for i in range(9):
        row = rows[i, number]
        expect(get_numbers(prim["xformOp:translate"][i]) == [float(row[key]) for key in "xyz"], "falls.usda: a translation")
        given, wanted = get_numbers(prim["xformOp:orient"][i]), [float(row[key]) for key in ("qw", "qx", "qy", "qz")]
        expect(any(max(abs(a - side * b) for a, b in zip(given, wanted)) < 1e-15 for side in (1, -1)),
               "falls.usda: a rotation")
feet = read_usd("feet.usda")["World/sheet"]["points"]
expect(get_floats(feet[3]) == tuple(round_float(x * 10000 / 3048) for x in frames["sheet"][3]), "feet.usda")
expect("metersPerUnit = 0.3048" in open("feet.usda").read(), "feet.usda: its unit")
prim = read_usd("seam.usda")["World/a_sheet___obj"]
expect(prim["displayName"] == '"a sheet é.obj"' if "displayName" in prim else
       'displayName = "a sheet é.obj"' in open("seam.usda").read(), "seam.usda: its name")
expect(get_floats(prim["primvars:st"]) == (0, 0, 1, 0, 1, 1, 0.25, 0.125, 1, 1, 0, 1), "seam.usda: texture coordinates")
sys.exit(faults > 0)
