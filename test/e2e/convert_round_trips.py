"""Random animations from every format to every other one and back; NPZ archives as NumPy writes them, made by hand.

Positions are floats; they come back with all bits, but for the sign of zeros where axes are turned (glTF). Triangles come back
from formats that have them. Times are those of each format: to the last bit, as float, or by --fps.
"""
import glob
import itertools
import math
import os
import random
import struct
import subprocess
import sys
import zipfile

faults = 0
random.seed(20)
rate = 25


def expect(is_so, text):
    global faults
    if not is_so:
        faults += 1
        print("fault:", text)


def convert(*words):
    done = subprocess.run([os.environ["TULLE"], "convert", *words], capture_output=True, text=True)
    expect(done.returncode == 0, f"convert {words}: exit {done.returncode}: {done.stderr}")
    return done


def refuse(pattern, *words):
    done = subprocess.run([os.environ["TULLE"], "convert", *words], capture_output=True, text=True)
    expect(done.returncode == 2 and pattern in done.stderr, f"convert {words}: exit {done.returncode}, no {pattern!r} in {done.stderr}")


def round_float(value):
    return struct.unpack("<f", struct.pack("<f", value))[0]


# ---- NPZ ----

def make_npy(values, shape, kind, is_fortran=False, version=1):
    """values: flat, in C order."""
    if is_fortran:
        strides = [math.prod(shape[i + 1:]) for i in range(len(shape))]
        values = [values[sum(i * s for i, s in zip(reversed(index), strides))]
                  for index in itertools.product(*(range(n) for n in reversed(shape)))]
    letter = {"f4": "f", "f8": "d", "i1": "b", "u1": "B", "i2": "h", "u2": "H", "i4": "i", "u4": "I", "i8": "q", "u8": "Q"}[kind[1:]]
    head = f"{{'descr': '{kind}', 'fortran_order': {is_fortran}, 'shape': {tuple(shape)}, }}"
    size = 10 if version == 1 else 12
    head += " " * (-(size + len(head) + 1) % 64) + "\n"
    count = struct.pack("<H" if version == 1 else "<I", len(head))
    order = "<" if kind[0] == "|" else kind[0]
    return b"\x93NUMPY" + bytes([version, 0]) + count + head.encode() + struct.pack(f"{order}{len(values)}{letter}", *values)


def write_npz(path, arrays, is_deflated=False, is_zip64=False, comment=b""):
    """arrays: name -> bytes of an .npy file."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED if is_deflated else zipfile.ZIP_STORED) as archive:
        archive.comment = comment
        for name, data in arrays.items():
            with archive.open(name + ".npy", "w", force_zip64=is_zip64) as file:
                file.write(data)


def read_npz(path):
    arrays = {}
    with zipfile.ZipFile(path) as archive:
        for name in archive.namelist():
            data = archive.read(name)
            size = struct.unpack_from("<H", data, 8)[0]
            head = eval(data[10:10 + size].decode())
            if head["descr"].startswith("<U"):
                continue
            letter = {"<f4": "f", "<f8": "d", "<i8": "q"}[head["descr"]]
            count = math.prod(head["shape"])
            arrays[name[:-4]] = (head["shape"], struct.unpack_from(f"<{count}{letter}", data, 10 + size))
    return arrays


def get_bits(values):
    return struct.pack(f"<{len(values)}d", *values)


class Animation:
    def __init__(self, frame_count, vertex_count, triangle_count):
        def number():
            return round_float(random.choice([0.0, -0.0, 1.0, random.uniform(-2, 2), random.uniform(-1, 1) * 10 ** random.uniform(-30, 30)]))
        self.shape = (frame_count, vertex_count, 3)
        self.positions = [number() for _ in range(3 * frame_count * vertex_count)]
        # Of different corners, so that every reader takes them for triangles.
        self.triangles = [corner for _ in range(triangle_count) for corner in random.sample(range(vertex_count), 3)]
        self.times = [round_float(i / rate + (random.uniform(0, 0.5) / rate if i else 0)) for i in range(frame_count)]

    def write(self, path, kind="<f4", whole="<i8", is_fortran=False, version=1, **how):
        write_npz(path, {"positions": make_npy(self.positions, self.shape, kind, is_fortran, version),
                         "triangles": make_npy(self.triangles, (len(self.triangles) // 3, 3), whole, is_fortran, version),
                         "times": make_npy(self.times, self.shape[:1], "<f8")}, **how)

    def compare(self, path, what, has_triangles=True, has_times=True, is_signed=True, is_float=False):
        arrays = read_npz(path)
        found = arrays["positions"][1]
        expect(arrays["positions"][0] == self.shape, f"{what}: {arrays['positions'][0]}, not {self.shape}")
        expect(found == tuple(self.positions) and (not is_signed or get_bits(found) == get_bits(self.positions)), f"{what}: positions")
        expect(not has_triangles or list(arrays["triangles"][1]) == self.triangles, f"{what}: triangles")
        times = self.times if has_times else [i / rate for i in range(len(self.times))]
        if is_float:
            times = [round_float(time) for time in times]
        expect(list(arrays["times"][1]) == times, f"{what}: times {arrays['times'][1]}, not {times}")


animation = Animation(4, 7, 5)
for kind, is_fortran, is_deflated in itertools.product(["<f4", ">f4", "<f8", ">f8"], [False, True], [False, True]):
    for whole in ["<i4", "<i8", "<u4", ">i4", ">u8", "|u1", "<i2"]:
        animation.write("in.npz", kind, whole, is_fortran, random.choice([1, 2]), is_deflated=is_deflated,
                        is_zip64=random.random() < 0.5, comment=b"PK\5\6" * random.randrange(3))
        convert("in.npz", "out.npz", "--double")
        animation.compare("out.npz", f"{kind} {whole} Fortran {is_fortran} deflated {is_deflated}")
large = Animation(40, 900, 30)  # more than a window of bytes
for is_fortran, is_deflated in itertools.product([False, True], [False, True]):
    large.write("in.npz", "<f8", is_fortran=is_fortran, is_deflated=is_deflated)
    convert("in.npz", "out.npz", "--double")
    large.compare("out.npz", f"large Fortran {is_fortran} deflated {is_deflated}")
positions, triangles = make_npy(animation.positions, animation.shape, "<f4"), make_npy(animation.triangles, (5, 3), "<i4")
write_npz("in.npz", {"positions": positions, "more": triangles})
expect("there are no times; a second has 24 frames" in convert("in.npz", "out.npz").stdout, "archives without times")
for pattern, arrays in [
        ('has no array "positions"', {"points": positions}),
        ("positions.npy: should be floating point numbers", {"positions": triangles}),
        ("positions.npy: should be floating point numbers", {"positions": make_npy([], (0, 7, 3), "<f4")}),
        ("positions.npy: key 'descr'", {"positions": positions.replace(b"<f4", b"<c8")}),
        ("positions.npy: key 'shape'", {"positions": positions.replace(b"(4, 7", b"(4; 7")}),
        ("positions.npy: key 'fortran_order'", {"positions": positions.replace(b"False", b"Maybe")}),
        ("positions.npy: has 336 bytes of numbers", {"positions": positions.replace(b"(4, 7", b"(5, 7")}),
        ("positions.npy: is not an .npy file", {"positions": positions.replace(b"NUMPY\1", b"NUMPY\7")}),
        ("frame 0: vertex 1 is not finite", {"positions": make_npy([0.0] * 5 + [math.nan] + [0.0] * 15, (7, 3), "<f8")}),
        ("triangles.npy: triangle 4 uses vertex 9", {"positions": positions, "triangles": make_npy(animation.triangles[:-1] + [9], (5, 3), "<i4")}),
        ("triangles.npy: should be whole numbers", {"positions": positions, "triangles": make_npy(animation.triangles, (15,), "<i4")}),
        ("times.npy: should be numbers of one dimension", {"positions": positions, "times": make_npy([0.0], (1,), "<f8")})]:
    write_npz("bad.npz", arrays)
    refuse(pattern, "bad.npz", "x.npz")

# ---- every format to every other one ----

# Name: (what is written, triangles, times, signs of zeros).
formats = {"npz": ("f.npz", True, True, True), "usda": ("f.usda", True, True, True), "glb": ("f.glb", True, True, False),
           "gltf": ("f.gltf", True, True, False), "mdd": ("f.mdd", False, True, True), "pc2": ("f.pc2", False, False, True),
           "obj": ("f_%03d.obj", True, False, True), "ply": ("f_%03d.ply", True, False, True), "vtp": ("f_%03d.vtp", True, False, True)}
without_times = ("pc2", "obj", "ply", "vtp")
for number, (first, second) in enumerate(itertools.product(formats, formats)):
    for frame_count in (2, 5):
        animation = Animation(frame_count, random.randrange(3, 12), random.randrange(1, 9))
        for path in glob.glob("f*") + glob.glob("g*"):
            os.remove(path)
        animation.write("start.npz")
        one, other = formats[first], formats[second]
        middle, last = one[0], other[0].replace("f", "g", 1)
        convert("start.npz", middle)
        fps = ["--fps", str(rate)]
        # Numbered files and PC2 have no times; formats that have them take --fps.
        convert(middle, last, *(fps if first in without_times and second not in without_times else []))
        convert(last, "end.npz", *(fps if second in without_times else []))
        animation.compare("end.npz", f"{first} to {second}, {frame_count} frames", one[1] and other[1], one[2] and other[2], one[3] and other[3],
                          first in without_times and second in ("glb", "gltf", "mdd"))
print(f"{len(formats) ** 2} pairs of formats")
sys.exit(faults > 0)
