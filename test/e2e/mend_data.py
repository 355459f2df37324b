"""Animations for mend.sh.

usage: mend_data.py make                     writes them all here
       mend_data.py smooth GIVEN MENDED      fails unless far from the ball nothing changed, and near it nothing jumps
       mend_data.py still GIVEN MENDED TABLE MOST JITTER
                                             fails if an acceleration is beyond MOST, or the jitter beyond JITTER, or the table
                                             tells another; with a tremble of half a millimetre it must be beyond
       mend_data.py near ONE OTHER            fails unless both are the same to a micrometre
       mend_data.py archive MENDED CONVERTED    fails unless they are the same but for departures, which are none
       mend_data.py departure GIVEN MENDED ARCHIVE    fails unless the archive has the departures
"""
import csv
import struct
import sys

import numpy as np


def make_grid(count, size):
    x = np.linspace(-size / 2, size / 2, count)
    places = np.array([(a, b, 0.0) for a in x for b in x])
    faces = []
    for i in range(count - 1):
        for j in range(count - 1):
            a, b = i * count + j, (i + 1) * count + j
            faces += [(a, b, b + 1), (a, b + 1, a + 1)]
    return places, np.array(faces)


def make_ball(radius, count=12):
    around = 2 * count
    places, faces = [(0, 0, radius)], []
    for i in range(1, count):
        t = np.pi * i / count
        for j in range(around):
            p = np.pi * j / count
            places.append((radius * np.sin(t) * np.cos(p), radius * np.sin(t) * np.sin(p), radius * np.cos(t)))
    places.append((0, 0, -radius))
    for j in range(around):
        k = (j + 1) % around
        faces.append((0, 1 + j, 1 + k))
        for i in range(count - 2):
            a, b = 1 + i * around + j, 1 + i * around + k
            faces += [(a, a + around, b + around), (a, b + around, b)]
        low = 1 + (count - 2) * around
        faces.append((len(places) - 1, low + k, low + j))
    return np.array(places, float), np.array(faces)


def make_needle(radius, height, count=12):
    """A cone on the plane z = 0, its tip at z = height."""
    angle = 2 * np.pi * np.arange(count) / count
    rim = np.stack([radius * np.cos(angle), radius * np.sin(angle), 0 * angle], axis=1)
    places = np.concatenate([rim, [[0, 0, height], [0, 0, 0]]])
    faces = [(i, (i + 1) % count, count) for i in range(count)] + [((i + 1) % count, i, count + 1) for i in range(count)]
    return places, np.array(faces)


def write_obj(path, places, faces):
    with open(path, "w", encoding="utf-8") as file:
        for place in places:
            file.write("v {!r} {!r} {!r}\n".format(*map(float, place)))
        for face in faces:
            file.write("f {} {} {}\n".format(*(int(corner) + 1 for corner in face)))


def write_cache(path, frames):
    frames = np.asarray(frames, "<f4")
    with open(path, "wb") as file:
        file.write(struct.pack("<12siiffi", b"POINTCACHE2\0", 1, frames.shape[1], 0.0, 1.0, len(frames)) + frames.tobytes())


def read_cache(path):
    with open(path, "rb") as file:
        data = file.read()
    count, frames = struct.unpack("<i", data[16:20])[0], struct.unpack("<i", data[28:32])[0]
    return np.frombuffer(data[32:], "<f4").reshape(frames, count, 3).astype(float)


def make_jaws(places, faces):
    """Two blocks in one mesh."""
    parts, corners = [], []
    for low, high in ((0.01, 0.05), (-0.05, -0.01)):
        base = sum(len(part) for part in parts)
        for height in (high, low):
            part = places * [1.2, 1.2, 1.0]
            part[:, 2] = height
            parts.append(part)
        corners += [tuple(base + c for c in face) for face in faces]
        corners += [tuple(base + len(places) + c for c in face[::-1]) for face in faces]
    return np.concatenate(parts), corners


def make():
    sheet, faces = make_grid(51, 1.0)
    small, small_faces = make_grid(9, 0.1)
    ball, ball_faces = make_ball(0.1)
    write_obj("sheet.obj", sheet, faces)
    write_obj("small.obj", small, small_faces)
    write_obj("ball.obj", ball, ball_faces)
    coarse, coarse_faces = make_grid(13, 0.4)
    write_obj("layers.obj", np.concatenate([coarse, coarse]), np.concatenate([coarse_faces, coarse_faces + len(coarse)]))
    for seed in range(1, 5):
        rng = np.random.default_rng(seed)
        wave, phase, turn = rng.uniform(3, 12, 2), rng.uniform(0, 6), rng.uniform(-0.5, 0.5)
        frames = []
        for k in range(10):
            lower = coarse.copy()
            lower[:, 2] = 0.03 * np.sin(wave[0] * coarse[:, 0] + phase + 0.3 * k) * np.cos(wave[1] * coarse[:, 1])
            upper = lower + [0.0, 0.0, 10.0 ** rng.uniform(-5, -2)]
            c, s = np.cos(turn * k), np.sin(turn * k)
            frames.append(np.concatenate([lower, upper]) @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) + rng.normal(size=3))
        write_cache(f"clean{seed}.pc2", frames)
    heights = [0.13 - 0.06 * np.sin(np.pi * k / 24) ** 2 for k in range(40)]
    write_cache("poke.pc2", [sheet + [0, 0, heights[min(k, 24)]] for k in range(40)])
    # A ball of which a vertex lies on its neighbour at the start and in the middle: two of its triangles have no area then.
    closing = np.array([ball] * 40)
    closing[:6, 1] = closing[18:24, 1] = ball[2]
    write_obj("closing.obj", ball, ball_faces)
    write_cache("closing.pc2", closing)
    write_cache("start.pc2", [sheet + [0, 0, 0.05 + 0.01 * k] for k in range(12)])
    write_cache("short.pc2", [sheet] * 5)
    bump = np.exp(-(coarse[:, 0] ** 2 + coarse[:, 1] ** 2) / 0.01)[:, None] * [0, 0, 1]
    frames = []
    for k in range(24):
        apart = 0.01 * np.cos(np.pi * np.clip((k - 4) / 4, 0, 1)) if k < 14 else -0.01 * np.cos(np.pi * np.clip((k - 16) / 4, 0, 1))
        frames.append(np.concatenate([coarse, coarse + [0.003, 0.002, 0.01] + bump * (apart - 0.01)]))
    write_cache("exchange.pc2", frames)
    jaws, jaw_faces = make_jaws(*make_grid(5, 1.0))
    write_obj("jaws.obj", jaws, jaw_faces)
    move = np.where(np.arange(len(jaws)) < len(jaws) // 2, -1, 1)[:, None] * [0, 0, 1]
    write_cache("jaws.pc2", [jaws + 0.015 * move * np.sin(np.pi * k / 8) ** 2 for k in range(9)])
    write_cache("between.pc2", [sheet] * 9)
    far = [ball + [0, 0, 2 + 0.01 * k] for k in range(10)]
    write_obj("far.obj", far[0], ball_faces)
    write_cache("far.pc2", far)
    # A press whose jaws, one mesh, close through each other over the middle of a sheet that waves.
    press = jaws * [0.5, 0.5, 1.0]
    write_obj("press.obj", press, jaw_faces)
    closed = [0.018 * np.sin(np.pi * k / 10) ** 2 for k in range(11)]
    write_cache("press.pc2", [press + move * far for far in closed])
    write_cache("pressed.pc2", [sheet + [0, 0, 0.004] * np.sin(6 * sheet[:, :1] + 0.5 * k) for k in range(11)])
    # A sheet that lands on a floor and goes on through it, and one that falls over a needle and slides to the side below its tip.
    floor, floor_faces = make_grid(5, 3.0)
    write_obj("floor.obj", floor, floor_faces)
    write_cache("landing.pc2", [sheet + [0, 0, 0.13 - 0.02 * k] for k in range(16)])
    write_obj("needle.obj", *make_needle(0.02, 0.3))
    write_cache("hanging.pc2", [sheet + [0.002 * k, 0.003, 0.24 + 0.14 * np.cos(np.pi * min(k, 20) / 20)] for k in range(30)])
    jump = np.array([sheet + [0, 0, 0.2]] * 6)
    jump[3, 1300] = [0, 0, -0.5]
    write_cache("jump.pc2", jump)
    broken = np.array([sheet] * 3)
    broken[1, 7, 1] = np.nan
    write_cache("nan.pc2", broken)
    flat = np.array([sheet] * 3)
    flat[0, 52] = flat[0, 51]
    write_cache("flat.pc2", flat)
    write_cache("inside.pc2", [small * 0.5] * 3)


def smooth(given, mended):
    given, mended = read_cache(given), read_cache(mended)
    away = (given != mended).any(axis=2)
    corners = np.abs(given[:, :, :2]).max(axis=2) > 0.49
    assert not (away & corners).any(), "vertices far from the ball are not as they were given"
    assert not away[:3].any() and not away[-1].any(), "frames without trouble are not as they were given"
    departure = mended - given
    change = np.abs(np.diff(departure, axis=0)).max()
    bend = np.abs(np.diff(departure, 2, axis=0)).max()
    assert change < 0.03 and bend < 0.03, f"departures change by {change} a frame and bend by {bend}"
    lengths = np.linalg.norm(departure, axis=2)
    side = lengths.reshape(len(lengths), 51, 51)
    jump = max(np.abs(np.diff(side, axis=1)).max(), np.abs(np.diff(side, axis=2)).max())
    assert jump < 0.5 * lengths.max(), f"departures jump by {jump} between neighbours"


def measure_motion(given, mended):
    """The largest acceleration, and by frame what turns round of them, of vertices that are away in one of the frames."""
    away = (given != mended).any(axis=2)
    acceleration = np.diff(mended, 2, axis=0)
    largest = np.linalg.norm(acceleration, axis=2)[away[2:] | away[1:-1] | away[:-2]].max()
    turning = np.maximum(0.0, -(acceleration[1:] * acceleration[:-1]).sum(axis=2))
    counts = away[3:] | away[2:-1] | away[1:-2] | away[:-3]
    return largest, [np.sqrt(t[c].mean()) if c.any() else None for t, c in zip(turning, counts)]


def still(given, mended, table, most, most_jitter):
    given, mended = read_cache(given), read_cache(mended)
    largest, jitters = measure_motion(given, mended)
    with open(table, encoding="utf-8") as file:
        told = [float(row["mended_jitter"]) if row["mended_jitter"] else None for row in csv.DictReader(file)]
    for frame, (found, expected) in enumerate(zip(told[3:], jitters), 3):
        assert (found is None) == (expected is None), f"frame {frame}: the table has {found}, not {expected}"
        assert found is None or abs(found - expected) <= 1e-6 * expected + 1e-12, f"frame {frame}: {found}, not {expected}"
    jitter = max(value for value in jitters if value is not None)
    print(f"largest acceleration {largest:.6f}, jitter {jitter:.6f}")
    assert largest <= float(most), f"an acceleration of {largest}"
    assert jitter <= float(most_jitter), f"a jitter of {jitter}"
    tremble = 0.0005 * (-1.0) ** np.arange(len(mended))[:, None] * (given != mended).any(axis=2)
    jitters = measure_motion(given, mended + tremble[:, :, None] * [0, 0, 1])[1]
    assert max(value for value in jitters if value is not None) > float(most_jitter), "a tremble is not found"


def near(one, other):
    distance = np.abs(read_cache(one) - read_cache(other)).max()
    assert distance < 1e-6, f"they are {distance} apart"


def archive(mended, converted):
    mended, converted = np.load(mended), np.load(converted)
    assert sorted(mended) == sorted([*converted, "departure"])
    assert all(mended[name].tobytes() == converted[name].tobytes() for name in converted)
    assert mended["departure"].shape == mended["positions"].shape[:2] and not mended["departure"].any()


def departure(given, mended, path):
    given, mended, arrays = read_cache(given), read_cache(mended), np.load(path)
    expected = np.linalg.norm(mended - given, axis=2)
    assert arrays["departure"].shape == expected.shape and arrays["departure"].dtype == arrays["positions"].dtype
    assert np.abs(arrays["departure"] - expected).max() < 1e-7 and expected.max() > 0.01
    assert ((arrays["departure"] == 0) == (mended == given).all(axis=2)).all()


if sys.argv[1] == "make":
    make()
else:
    {"smooth": smooth, "still": still, "near": near, "archive": archive, "departure": departure}[sys.argv[1]](*sys.argv[2:])
