"""Meshes, frames and the judge: how much a cloth is stretched, and what it goes through."""
import array
import json
import math
import pathlib
import struct
import subprocess


class Mesh:
    """Vertices and triangles of an OBJ file as Tulle writes it."""

    def __init__(self, path):
        self.vertices, self.triangles = [], []
        with open(path, encoding="utf-8") as file:
            for line in file:
                words = line.split()
                if words[:1] == ["v"]:
                    self.vertices.append(tuple(float(word) for word in words[1:4]))
                elif words[:1] == ["f"]:
                    self.triangles.append(tuple(int(word) - 1 for word in words[1:4]))
        self.edges = sorted({(min(a, b), max(a, b)) for t in self.triangles for a, b in (t[:2], t[1:], (t[2], t[0]))})
        self.rest = [math.dist(self.vertices[a], self.vertices[b]) for a, b in self.edges]
        self.mean_edge = sum(self.rest) / len(self.rest)
        self.area = sum(self.get_area(*triangle) for triangle in self.triangles)

    def get_area(self, a, b, c):
        u, v = ([q - p for p, q in zip(self.vertices[a], self.vertices[corner])] for corner in (b, c))
        return math.hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]) / 2

    def get_stretches(self, frame):
        """Length over rest length less 1 of every edge, in rising order; frame: x, y, z of each vertex."""
        points = list(zip(frame[0::3], frame[1::3], frame[2::3]))
        return sorted(math.dist(points[a], points[b]) / rest - 1 for (a, b), rest in zip(self.edges, self.rest))


def get_percentile(rising, percent):
    """The least value that at least `percent` of them do not pass."""
    return rising[max(0, math.ceil(len(rising) * percent / 100) - 1)]


def read_frames(path, vertex_count, skipped=0):
    """Frames of float32 x, y, z behind `skipped` bytes; one that is not whole is left out."""
    data = pathlib.Path(path).read_bytes()[skipped:]
    size = 12 * vertex_count
    frames = []
    for at in range(0, len(data) - size + 1, size):
        frames.append(array.array("f", data[at : at + size]))
    return frames


def is_finite(frame):
    """Whether all is a number that a judge can take: no peer's cloth is a million kilometres away by right."""
    return all(abs(value) < 1e9 for value in frame)


def write_cache(path, frames):
    with open(path, "wb") as file:
        file.write(struct.pack("<12siiffi", b"POINTCACHE2\0", 1, len(frames[0]) // 3, 0.0, 1.0, len(frames)))
        for frame in frames:
            frame.tofile(file)


def count_pairs(tulle, files, obstacles):
    """Pairs of triangles that intersect in each of the files."""
    options = [word for obstacle in obstacles for word in ("--obstacle", str(obstacle))]
    command = [tulle, "check", *map(str, files), *options, "--json", "--list", "0", "-t", "1"]
    said = subprocess.run(command, capture_output=True, text=True, check=False)
    if said.returncode not in (0, 1):
        raise RuntimeError(f"the judge: {said.stderr.strip()}")
    return parse_counts(said.stdout)


def parse_counts(text):
    """From the judge's JSON lines: those of the files; the last line is a sum."""
    lines = [json.loads(line) for line in text.splitlines()]
    return [line["intersections"] for line in lines if "source" in line]


def judge(tulle, folder, frames, cloth_mesh, obstacles):
    """Intersecting pairs in each frame: (of the cloth with itself, with obstacles)."""
    folder = pathlib.Path(folder)
    write_cache(folder / "judged.pc2", frames)
    for old in folder.glob("judged_*.obj"):
        old.unlink()
    command = [tulle, "convert", folder / "judged.pc2", folder / "judged_%04d.obj", "--mesh", cloth_mesh]
    subprocess.run(command, check=True, capture_output=True)
    files = sorted(folder.glob("judged_*.obj"))
    alone, together = count_pairs(tulle, files, []), count_pairs(tulle, files, obstacles)
    for file in files:
        file.unlink()
    return [(own, both - own) for own, both in zip(alone, together)]
