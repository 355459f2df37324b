"""Worlds: what is added, steps, states, what is asked of them."""
from __future__ import annotations

import math

import numpy as np
import pytest
import tulle

STEP = 1 / 90


def drop(world: tulle.World, steps: int = 60) -> None:
    for _ in range(steps):
        world.step(STEP)


def test_a_sheet_falls_on_a_ball(world: tulle.World) -> None:
    drop(world)
    cloth, ball = world.cloths[0], world.obstacles[0]
    assert (cloth.name, ball.name) == ("sheet", "ball")
    assert world.step_count == 60 and math.isclose(world.time, 60 * STEP)
    assert cloth.positions.shape == (144, 3) and cloth.positions[:, 2].max() > 0.29
    assert tulle.Judge().find_world_intersections(world).is_clean
    contacts = world.get_contacts()
    assert contacts.size and contacts["object_a"].max() <= 1 and contacts["object_b"].max() <= 1
    assert np.allclose(np.linalg.norm(contacts["normal"], axis=1), 1)
    assert ball.get_contacts().size == ((contacts["object_a"] == 1) | (contacts["object_b"] == 1)).sum()
    assert cloth.contact_forces.sum(axis=0)[2] > 0
    assert np.allclose(np.linalg.norm(cloth.normals, axis=1), 1)
    assert cloth.strains.shape == (cloth.triangles.shape[0], 3)


def test_the_bits_do_not_depend_on_threads(sheet: tulle.Mesh, ball: tulle.Mesh) -> None:
    hashes = set()
    for threads in (1, 2, 3):
        world = tulle.World(threads=threads)
        world.add_cloth(sheet)
        world.add_obstacle(ball)
        drop(world)
        hashes.add(world.state_hash)
    assert len(hashes) == 1


def test_a_start_amid_a_motion(sheet: tulle.Mesh, ball: tulle.Mesh) -> None:
    worlds = []
    for _ in range(2):
        world = tulle.World(threads=1)
        world.add_cloth(sheet, stiffness_factors=np.linspace(1, 3, sheet.triangle_count))
        world.add_obstacle(ball)
        worlds.append(world)
    first, second = worlds
    drop(first, 5)
    cloth = first.cloths[0]
    second.start_at(first.time, cloth.positions, cloth.velocities, first.step_count)
    assert second.step_count == 5 and second.time == first.time
    assert np.array_equal(second.cloths[0].positions, first.cloths[0].positions)
    for world in worlds:
        drop(world, 5)
    assert np.allclose(second.cloths[0].positions, first.cloths[0].positions, atol=1e-4)
    thrown = [tulle.World(threads=1) for _ in range(2)]
    cube = tulle.make_shape("box", size=(0.1, 0.1, 0.1))
    boxes = [world.add_obstacle(cube, body={"density": 100, "angular_velocity": (3, 0, 1)}) for world in thrown]
    for _ in range(4):
        thrown[0].step(STEP)
    nothing = np.empty((0, 3))
    with pytest.raises(tulle.InvalidArgumentError):
        thrown[1].start_at(thrown[0].time, nothing, nothing)
    thrown[1].start_at(thrown[0].time, nothing, nothing, 4, [boxes[0].transform])
    assert np.allclose(boxes[1].positions, boxes[0].positions, atol=1e-14)
    assert boxes[1].transform.angular_velocity == boxes[0].transform.angular_velocity
    fresh = tulle.World(threads=1)
    fresh.add_cloth(sheet)
    with pytest.raises(tulle.InvalidArgumentError):
        fresh.start_at(0.0, cloth.positions[1:], cloth.velocities[1:])
    with pytest.raises(tulle.InvalidArgumentError):
        fresh.start_at(0.0, cloth.positions, cloth.velocities[1:])
    with pytest.raises(tulle.InvalidArgumentError):
        fresh.add_cloth(sheet, stiffness_factors=[1.0, 2.0])


def test_settings(sheet: tulle.Mesh) -> None:
    settings = tulle.WorldDef(gravity=(0, 0, -1), threads=1)
    world = tulle.World(settings, on_pinch="stop", wind={"velocity": [1, 0, 0]})
    assert settings.on_pinch == tulle.OnPinch.LAG, "the caller's settings stay"
    cloth = world.add_cloth(sheet, material={"area_density": 0.3, "warp": {"stiffness": 9000}}, thickness=2e-3)
    world.step(STEP)
    assert np.allclose(cloth.velocities[:, 2], -STEP, rtol=0.05)
    world.set_gravity((0, 0, 1))
    world.step(STEP)
    world.step(STEP)
    assert cloth.velocities[:, 2].mean() > 0
    assert tulle.make_material("silk").area_density == tulle.make_material("silk", friction=0.9).area_density
    assert "cotton" in tulle.list_materials()


def test_pins_drives_and_frames(sheet: tulle.Mesh, ball: tulle.Mesh) -> None:
    world = tulle.World(threads=1)
    cloth = world.add_cloth(sheet, pins=[tulle.Pin([0, 11]), {"vertices": [5], "release_time": 0.1}])
    lift = np.array([0, 0, 0.001])
    frames = np.stack([ball.positions + i * lift for i in range(10)])
    deforming = world.add_obstacle(ball, frames=frames, frame_interval=STEP)
    asked = []

    def give(frame: int) -> np.ndarray:
        asked.append(frame)
        return ball.positions - (0, 0, 1) + frame * lift

    world.add_obstacle(ball.transform(translation=(0, 0, -1)), frames=give, frame_count=10, frame_interval=STEP)
    driven = world.add_obstacle(ball.transform(translation=(3, 0, 0)), drive="rigid")
    world.start()
    for i in range(5):
        cloth.set_pin_targets(0, sheet.positions[[0, 11]] + (i + 1) * lift)
        driven.set_next_transform(translation=(i + 1) * lift)
        world.step(STEP)
    assert np.allclose(cloth.positions[[0, 11]], sheet.positions[[0, 11]] + 5 * lift)
    assert np.allclose(deforming.positions, frames[5])
    assert np.allclose(driven.positions, ball.positions + (3, 0, 0) + 5 * lift)
    assert asked and max(asked) <= 9


def test_targets_and_place(sheet: tulle.Mesh) -> None:
    paper = tulle.PaperOptions(cg_tolerance=1e-10)
    world = tulle.World(threads=1, gravity=(0, 0, 0), wind={"drag_coefficient": 0.0}, paper=paper)
    cloth = world.add_cloth(sheet, has_flat_rest=True)
    world.start()
    goal = sheet.positions + (0, 0, 0.02)
    cloth.set_targets(goal)
    world.step(STEP)
    assert np.allclose(cloth.positions, goal, atol=1e-4)
    with pytest.raises(tulle.InvalidArgumentError, match="144"):
        cloth.set_targets(goal[:3])
    with pytest.raises(tulle.InvalidArgumentError, match="flags"):
        cloth.set_targets(goal, is_led=[True])
    cloth.set_targets(goal, np.zeros_like(goal), np.ones(len(goal)))
    world.step(STEP)
    assert np.array_equal(cloth.positions, goal)
    world.place(sheet.positions)
    assert np.array_equal(cloth.positions, sheet.positions)
    with pytest.raises(tulle.InvalidArgumentError, match="cg_tolerance"):
        tulle.World(paper={"cg_tolerance": 1.0})


def test_bodies_and_attachments(sheet: tulle.Mesh) -> None:
    world = tulle.World(threads=1)
    cloth = world.add_cloth(sheet, pins=[tulle.Pin(range(12))])
    box = tulle.make_shape("box", size=(0.1, 0.1, 0.1)).transform(translation=(2, 0, 1))
    body = world.add_obstacle(box, body={"density": 100})
    assert isinstance(body, tulle.Body)
    world.start()
    assert math.isclose(body.transform.mass, 0.1, rel_tol=1e-9)
    body.set_velocity((0, 0, 1))
    body.add_force((0, 0, 0.1 * 9.81))
    world.step(STEP)
    assert math.isclose(body.transform.velocity[2], 1, rel_tol=1e-6)
    held = world.attach(cloth, [143], cloth.positions[[143]], break_force=50.0)
    world.step(STEP)
    assert held.holds(143) and held.report.held_count == 1
    held.set_points(cloth.positions[[143]] + (0, 0, 0.01))
    world.step(STEP)
    held.release()
    world.step(STEP)
    assert held.report.held_count == 0


def test_rollback(world: tulle.World) -> None:
    drop(world, 40)
    state, before = world.save_state(), world.state_hash
    drop(world, 10)
    after = world.state_hash
    world.load_state(state)
    assert world.state_hash == before
    drop(world, 10)
    assert world.state_hash == after
    with pytest.raises(tulle.ParseError):
        world.load_state(state[:-1])
    assert world.state_hash == after
    with pytest.raises(tulle.InvalidArgumentError):
        tulle.World().load_state(state)


def test_objects_come_and_go(world: tulle.World, ball: tulle.Mesh) -> None:
    drop(world, 5)
    late = world.add_obstacle(ball.transform(translation=(2, 0, 0)))
    assert world.objects[2] is late
    world.step(STEP)
    world.remove(late)
    assert len(world.obstacles) == 1
    cloth = world.add_cloth(tulle.make_shape("rectangle", resolution=3).transform(translation=(0, 0, 3)))
    world.remove(cloth)
    for read in (lambda: late.positions, lambda: late.is_present, lambda: cloth.is_asleep, lambda: cloth.fineness, lambda: cloth.mesh):
        with pytest.raises(tulle.InvalidArgumentError, match="removed"):
            read()
    world.step(STEP)
    with pytest.raises(tulle.IntersectingStartError):
        world.add_obstacle(tulle.make_shape("sphere", radius=0.1).transform(translation=(0, 0, world.cloths[0].positions[60, 2])))
    assert world.get_intersections().size == world.get_overlaps().size > 0


def test_triangles_without_area(sheet: tulle.Mesh) -> None:
    places = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0.5, 0, 0]]
    plate = tulle.Mesh(places, [[0, 1, 2], [0, 3, 1], [2, 1, 0], [0, 0, 1], [0, 2, 1]])
    assert plate.find_degenerate().tolist() == [False, True, False, True, False]
    world = tulle.World(threads=1)
    world.add_cloth(sheet)
    with pytest.warns(UserWarning) as told:
        still = world.add_obstacle(plate)
    assert [str(each.message) for each in told] == [
        "obstacle: triangle 1 has no area and is left out, and 1 more",
        "obstacle: triangle 2 has the same corners as another one and is left out, and 1 more"]
    assert told[0].filename == __file__
    frames = np.array([places, places], float)
    frames[1, 3, 1] = -1
    with pytest.warns(UserWarning):
        moving = world.add_obstacle(plate, frames=frames, frame_interval=0.1)
    assert still.mesh.triangle_count == 1 and moving.mesh.triangle_count == 2
    world.start()
    for _ in range(3):
        world.step(1 / 60)
    assert len(world.get_intersections()) == 0
    with pytest.raises(tulle.InvalidMeshError, match="zero area"):
        world.add_obstacle(tulle.Mesh(places, [[0, 3, 1]]))


def test_queries(world: tulle.World) -> None:
    world.start()
    hit = world.cast_ray((0.01, 0.02, 2), (0.01, 0.02, -2))
    assert hit is not None and world.find_object(hit.object) is world.cloths[0]
    assert math.isclose(hit.distance, 1.5)
    assert world.cast_ray((5, 5, 2), (5, 5, -2)) is None
    nearest = world.find_closest_point((0, 0, 0.35), 0.2)
    assert nearest is not None and world.find_object(nearest.object) is world.find_object("ball")
    assert world.find_closest_point((9, 9, 9), 0.1) is None
    found = world.find_box_overlaps((-2, -2, 0.49), (2, 2, 0.51))
    assert len(found) == world.cloths[0].triangles.shape[0] and found[0] == (world.cloths[0], 0)
    pairs = world.find_mesh_overlaps(tulle.make_shape("sphere", radius=0.1).transform(translation=(0, 0, 0.5)))
    assert pairs and all(each is world.cloths[0] for each, _, _ in pairs)
    assert world.counts.cloth_triangles == world.cloths[0].triangles.shape[0]


def test_events(world: tulle.World) -> None:
    world.start()
    world.watch_events()
    drop(world, 60)
    events, lost = world.poll_events()
    begins = events[events["kind"] == int(tulle.EventKind.CONTACT_BEGIN)]
    assert begins.size and lost == 0
    assert begins[0]["object_a"] == 0 and begins[0]["object_b"] == 1 and begins[0]["force"] > 0


def test_laws_and_filters(sheet: tulle.Mesh, ball: tulle.Mesh) -> None:
    asked = []
    world = tulle.World(threads=1)
    cloth, first = world.add_cloth(sheet, name="sheet"), world.add_obstacle(ball, name="first")
    second = world.add_obstacle(ball.transform(translation=(0, 0, 0.5)), name="ghost")
    world.set_law(first, cloth, static_friction=0.9)

    def collides(a: tulle.Object, b: tulle.Object) -> bool:
        asked.append((a.name, b.name))
        return b is not second

    world.set_pair_filter(collides)
    world.start()
    assert ("sheet", "ghost") in asked and ("sheet", "first") in asked
    world.step(STEP)


def test_record_and_replay(tmp_path, sheet: tulle.Mesh, ball: tulle.Mesh) -> None:
    path = tmp_path / "calls.rec"
    world = tulle.World(threads=1)
    world.record(path)
    world.add_cloth(sheet)
    world.add_obstacle(ball)
    drop(world, 10)
    world.end_recording()
    report = tulle.replay(path, threads=2)
    assert report.is_whole and not report.is_different and report.hash == world.state_hash
    path.write_bytes(path.read_bytes()[:100])
    assert not tulle.replay(path).is_whole
    path.write_bytes(b"no recording")
    with pytest.raises(tulle.ParseError):
        tulle.replay(path)


def test_many_worlds(sheet: tulle.Mesh, ball: tulle.Mesh) -> None:
    worlds = []
    for i in range(4):
        world = tulle.World(threads=1, gravity=(0, 0, -9.81 - i))
        world.add_cloth(sheet)
        world.add_obstacle(ball)
        worlds.append(world)
    alone = tulle.World(threads=1)
    alone.add_cloth(sheet)
    alone.add_obstacle(ball)
    for _ in range(30):
        reports = tulle.step_worlds(worlds, STEP, threads=2)
        alone.step(STEP)
    assert [report.step for report in reports] == [29] * 4
    assert worlds[0].state_hash == alone.state_hash and len({world.state_hash for world in worlds}) == 4
    assert reports[0].contacts == alone.get_contacts().size
    with pytest.raises(tulle.BusyError):
        tulle.step_worlds([worlds[0], worlds[0]], STEP)
    assert all(isinstance(answer, tulle.InvalidArgumentError) for answer in tulle.step_worlds(worlds, -1))
    with pytest.raises(tulle.InvalidArgumentError, match="threads"):
        tulle.step_worlds(worlds, STEP, threads=1000)
    assert tulle.step_worlds([], STEP) == []


def test_a_world_that_fails_keeps_no_other_from_its_step(sheet: tulle.Mesh, ball: tulle.Mesh) -> None:
    good, bad = tulle.World(threads=1), tulle.World(threads=1)
    good.add_cloth(sheet)
    bad.add_cloth(sheet)
    bad.add_obstacle(ball.transform(translation=(0, 0, 0.5)))
    answers = tulle.step_worlds([bad, good], STEP)
    assert isinstance(answers[0], tulle.IntersectingStartError) and isinstance(answers[1], tulle.StepReport)
    assert good.step_count == 1 and bad.step_count == 0


def make_dragged_cloth(on_pinch: str) -> tuple[tulle.World, np.ndarray]:
    """A sheet without gravity that pins on keyframes drag into a wall, obstacle 0, and the vertices of the pins."""
    world = tulle.World(threads=1, on_pinch=on_pinch, gravity=(0, 0, 0))
    sheet = tulle.make_shape("rectangle", size=(0.2, 0.2), resolution=(9, 9))
    right = np.nonzero(sheet.positions[:, 0] > 0.099)[0]
    keys = [tulle.Keyframe(time=0.05), tulle.Keyframe(time=0.35, translation=(0.6, 0, 0)), tulle.Keyframe(time=2, translation=(0.6, 0, 0))]
    world.add_cloth(sheet, pins=[tulle.Pin(right, motion=tulle.Motion(keys=keys))])
    wall = tulle.make_shape("box", size=(0.1, 1, 1))
    wall.positions[:, 0] += 0.2
    world.add_obstacle(wall, name="wall")
    return world, right


def test_pins_that_waited_come_back_without_a_jump() -> None:
    world, right = make_dragged_cloth("slow")
    last, ways = world.cloths[0].positions[right].copy(), []
    for step in range(60):
        if step == 9:
            world.remove(world.obstacles[0])
        world.step(STEP)
        now = world.cloths[0].positions[right].copy()
        ways.append(np.linalg.norm(now - last, axis=1).max())
        last = now
    of_script = 2.0 * STEP  # 22 mm a step
    assert min(ways[6:9]) == 0.0  # they waited
    assert 0.0 < ways[10] and max(ways) < 2.0 * of_script  # what is removed holds nothing back
    assert abs(last[:, 0].max() - 0.7) < 1e-3


def test_what_deforms_waits_for_a_body_by_slow_as_by_lag() -> None:
    for on_pinch in ("lag", "slow"):
        world = tulle.World(threads=1, on_pinch=on_pinch)
        ground = tulle.make_shape("box", size=(1, 1, 0.1))
        ground.positions[:, 2] -= 0.05
        world.add_obstacle(ground)
        die = tulle.make_shape("box", size=(0.2, 0.2, 0.2))
        die.positions[:, 2] += 0.106
        world.add_obstacle(die, body={"mass": 1.0})
        press = tulle.make_shape("box", size=(1, 1, 0.1))
        press.positions[:, 2] += 0.5
        depths = [-0.4 * min(1, k / 60) for k in range(90)]
        world.add_obstacle(press, frames=np.array([press.positions + (0, 0, depth) for depth in depths]), frame_interval=STEP)
        lags = [world.step(STEP).largest_lag for _ in range(80)]
        assert max(lags) > 0.1, on_pinch
        assert tulle.Judge().find_world_intersections(world).is_clean
