"""Derivatives beside closed forms, kinks that are told, materials that are found again."""
from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import tulle
from tulle.sensitivity import Rollout, differentiate

G = 9.81
STILL = {"drag_coefficient": 0.0}
EXACT: dict[str, Any] = {"threads": 1, "quality": "exact", "paper": {"cg_tolerance": 1e-11}, "wind": STILL}


def make_curve(stiffness: float) -> tulle.Curve:
    return tulle.Curve(stiffness, 0.0, 1.0)


def hang_strip(values: Any) -> tulle.World:
    """A strip of 0.4 m that hangs from its upper edge."""
    flat = tulle.make_shape("rectangle", size=(0.1, 0.4), resolution=(3, 17))
    strip = tulle.Mesh(flat.positions[:, [0, 2, 1]] * [1, 1, 1], flat.triangles)
    world = tulle.World(**EXACT)
    curve = make_curve(values["stiffness"])
    material = tulle.make_material(area_density=values["density"], warp=curve, weft=curve, shear=make_curve(10.0), poisson=0.0,
                                   air_damping=1.0)
    top = np.flatnonzero(strip.positions[:, 2] > 0.2 - 1e-9)
    world.add_cloth(strip, material=material, pins=[tulle.Pin(top)])
    return world


def test_a_hanging_strip_stretches_by_theory() -> None:
    # u = rho g L^2 / (2 k): so du/dk = -u / k and du/drho = u / rho.
    rollout = Rollout(hang_strip, lambda world: -0.2 - np.array(world.cloths[0].positions)[:, 2].min(), 0.1, 200)
    found = differentiate(rollout, {"stiffness": 50.0, "density": 0.2})
    stretch = 0.2 * G * 0.4**2 / (2 * 50.0)
    assert found.values[0] == pytest.approx(stretch, rel=1e-3)
    for name, theory in (("stiffness", -stretch / 50.0), ("density", stretch / 0.2)):
        assert found.is_smooth[name].all()
        assert found.jacobian[name][0] == pytest.approx(theory, rel=1e-3)
        assert found.error[name][0] < 1e-6 * abs(theory)
    assert found.get_matrix().shape == found.get_errors().shape == (1, 2)


def test_free_fall_depends_on_place_and_velocity_as_it_must() -> None:
    sheet = tulle.make_shape("rectangle", size=(0.1, 0.1), resolution=3)

    def drop(values: Any) -> tulle.World:
        world = tulle.World(**EXACT)
        placed = sheet.transform(translation=values["place"])
        world.add_cloth(placed, material={"air_damping": 0.0}, velocity=values["velocity"])
        return world

    rollout = Rollout(drop, lambda world: np.array(world.cloths[0].positions).mean(axis=0), 0.01, 20)
    found = differentiate(rollout, {"place": np.array([0.0, 1.0, 2.0]), "velocity": np.array([1.0, 0.0, 0.0])},
                          steps={"place": 0.01, "velocity": 0.1})
    assert np.allclose(found.jacobian["place"], np.eye(3), atol=1e-9)
    assert np.allclose(found.jacobian["velocity"], 0.2 * np.eye(3), atol=1e-9)
    assert all(each.all() for each in found.is_smooth.values())


def test_a_pendulum_swings_by_theory() -> None:
    length, step, count = 0.1, 0.002, 100
    rest = np.array([[0, 0, 0], [1, 0, 0], [0, 0, -1], [1, 0, -1]]) * length

    def swing(values: Any) -> tulle.World:
        world = tulle.World(**EXACT, gravity=(0, 0, -values["gravity"]))
        away = length * np.array([0, np.sin(values["angle"]), -np.cos(values["angle"])])
        along = np.array([0, np.cos(values["angle"]), np.sin(values["angle"])])
        mesh = tulle.Mesh(np.vstack([rest[:2], rest[:2] + away]), [[0, 2, 1], [1, 2, 3]])
        material = tulle.make_material(air_damping=0.0, stretch_damping=0.0, bend_damping=0.0, warp=make_curve(1e5),
                                       weft=make_curve(1e5))
        world.add_cloth(mesh, rest_positions=rest, pins=[tulle.Pin([0, 1])], material=material,
                        velocities=np.outer([0, 0, 1, 1], values["velocity"] * along))
        return world

    def swing_in_theory(angle: float, velocity: float, gravity: float) -> float:
        """The small swing, by the same integrator."""
        place, rate = length * angle, gravity / length
        for _ in range(count):
            velocity = (velocity - step * rate * place) / (1 + step * step * rate)
            place += step * velocity
        return place

    values = {"angle": 0.02, "velocity": 0.01, "gravity": G}
    found = differentiate(Rollout(swing, lambda world: world.cloths[0].positions[2, 1], step, count), values, relative_step=0.1)
    for name in values:
        high, low = ({**values, name: values[name] * (1 + sign * 1e-4)} for sign in (1, -1))
        theory = (swing_in_theory(**high) - swing_in_theory(**low)) / (2e-4 * values[name])
        assert found.is_smooth[name].all()
        assert found.jacobian[name][0] == pytest.approx(theory, rel=0.01)


def test_sliding_down_an_incline_by_theory_and_the_kink_where_it_sticks() -> None:
    angle, step, count = np.radians(30), 0.01, 50

    def slide(values: Any) -> tulle.World:
        world = tulle.World(**EXACT, gravity=(G * np.sin(angle), 0, -G * np.cos(angle)))
        sheet = tulle.make_shape("rectangle", size=(0.1, 0.1), resolution=6).transform(translation=(0, 0, 0.0045))
        cloth = world.add_cloth(sheet, material={"air_damping": 0.0})
        slope = world.add_obstacle(tulle.make_shape("plane", size=(4, 4)))
        world.set_law(cloth, slope, static_friction=values["friction"], dynamic_friction=values["friction"])
        return world

    rollout = Rollout(slide, lambda world: np.array(world.cloths[0].positions)[:, 0].mean(), step, count)
    theory = -0.5 * G * np.cos(angle) * (step * count) * (step * (count + 1))
    sliding = differentiate(rollout, {"friction": 0.3})
    assert sliding.is_smooth["friction"].all() and sliding.jacobian["friction"][0] == pytest.approx(theory, rel=5e-3)
    sticking = differentiate(rollout, {"friction": 0.7})
    assert sticking.is_smooth["friction"].all() and abs(sticking.jacobian["friction"][0]) < 1e-3 * abs(theory)
    kink = differentiate(rollout, {"friction": float(np.tan(angle))})
    assert not kink.is_smooth["friction"].any() and kink.error["friction"][0] > 0.5 * abs(theory)


def test_rounding_is_told_from_truncation() -> None:
    world = tulle.World()
    empty = Rollout(lambda values: world_of(values["x"]), lambda made: read(made), 0.01, 0)
    table: dict[int, float] = {}

    def world_of(x: float) -> tulle.World:
        made = tulle.World()
        made.start()
        table[id(made)] = x
        return made

    def read(made: tulle.World) -> list[float]:
        x = table[id(made)]
        return [np.sin(x), 1e9 + np.sin(x), abs(x - 1), np.sign(x - 1 - 0.011), 3.0]

    found = differentiate(empty, {"x": 1.0})
    assert found.jacobian["x"][0] == pytest.approx(np.cos(1.0), rel=1e-10)
    assert found.error["x"][0] < 1e-9
    smaller = differentiate(empty, {"x": 1.0}, relative_step=1e-6)
    assert smaller.is_rounding["x"][1] and not smaller.is_smooth["x"][1]
    assert found.is_smooth["x"].tolist() == [True, True, False, False, True]
    assert found.jacobian["x"][4] == 0
    assert abs(found.jacobian["x"][0] - np.cos(1.0)) <= found.error["x"][0]
    world.close()


def test_controls_and_threads() -> None:
    sheet = tulle.make_shape("rectangle", size=(0.2, 0.2), resolution=6)

    def build(values: Any) -> tulle.World:
        world = tulle.World(**EXACT)
        world.add_cloth(sheet, pins=[tulle.Pin(np.arange(12))])
        return world

    def control(world: tulle.World, step: int, values: Any) -> None:
        world.cloths[0].set_pin_targets(0, sheet.positions[:12] + (step + 1) * np.asarray(values["shift"]))

    rollout = Rollout(build, lambda world: np.array(world.cloths[0].positions).mean(axis=0), 0.02, 30, control, (10, 30))
    values = {"shift": np.array([0.001, 0.0, 0.002])}
    one, two = (differentiate(rollout, values, steps={"shift": 5e-4}, threads=threads) for threads in (1, 2))
    assert one.jacobian["shift"].shape == (6, 3) and one.jacobian["shift"][3, 0] > one.jacobian["shift"][0, 0] > 5
    assert np.array_equal(one.jacobian["shift"], two.jacobian["shift"])


def test_bad_input_of_derivatives_is_told() -> None:
    rollout = Rollout(hang_strip, lambda world: 1.0, 0.1, 2)
    with pytest.raises(tulle.InvalidArgumentError, match="steps={\"density\""):
        differentiate(rollout, {"stiffness": 50.0, "density": 0.0})
    with pytest.raises(tulle.InvalidArgumentError, match="steps names \"bend\""):
        differentiate(rollout, {"stiffness": 50.0, "density": 0.2}, steps={"bend": 1})
    with pytest.raises(tulle.InvalidArgumentError, match="not finite"):
        differentiate(Rollout(hang_strip, lambda world: np.nan, 0.1, 2), {"stiffness": 50.0, "density": 0.2})
    with pytest.raises(tulle.InvalidArgumentError, match="measured_after"):
        Rollout(hang_strip, lambda world: 1.0, 0.1, 2, measured_after=(1, 3))


# ---- fits ----

SIDE = 9
SHEET = tulle.make_shape("rectangle", size=(0.2, 0.2), resolution=SIDE).transform(translation=(0, 0, 1))
BENDING = ("bend_warp", "bend_weft", "bend_twist")
TENSION = ("warp.stiffness", "weft.stiffness")


def droop(material: tulle.Material) -> tulle.World:
    world = tulle.World(threads=1, quality="exact", paper={"cg_tolerance": 1e-9})
    world.add_cloth(SHEET, material=material, pins=[tulle.Pin(np.arange(2 * SIDE))])
    return world


def make_limp(**changes: Any) -> tulle.Material:
    return tulle.make_material(shear=make_curve(15.0), air_damping=0.5, **{"area_density": 0.2, "warp": make_curve(60.0),
                                                                           "weft": make_curve(60.0), **changes})


def observe(material: tulle.Material, after: list[int], noise: float, seed: int) -> dict[int, np.ndarray]:
    world, random, seen = droop(material), np.random.default_rng(seed), {}
    for step in range(1, after[-1] + 1):
        world.step(0.02)
        if step in after:
            seen[step] = np.array(world.cloths[0].positions) + random.normal(0, noise, (SIDE * SIDE, 3))
    return seen


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_fit_finds_stiffness_and_bending_again(seed: int) -> None:
    seen = observe(make_limp(bend_warp=4e-5, bend_weft=4e-5, bend_twist=2e-5), [10, 20, 40, 60], 2e-4, seed)
    seen[20][:5] = np.nan  # some were not seen
    start = make_limp(warp=make_curve(200.0), weft=make_curve(200.0))
    found = tulle.fit_material(droop, {BENDING: (1e-6, 1e-3), TENSION: (20.0, 1e4)}, seen, time_step=0.02, material=start)
    for name, truth in ((BENDING, 4e-5), (TENSION, 60.0)):
        assert abs(found.values[name] - truth) < 3.5 * found.uncertainties[name] < 0.02 * truth
    assert found.has_settled and found.is_smooth and not found.at_bounds
    assert found.noise == pytest.approx(2e-4, rel=0.15)
    assert found.material.bend_twist == pytest.approx(found.values[BENDING] / 2)


def test_fit_tells_what_only_a_ratio_tells() -> None:
    seen = observe(make_limp(bend_warp=4e-5, bend_weft=4e-5, bend_twist=2e-5), [60], 2e-4, 5)
    found = tulle.fit_material(droop, {BENDING: (1e-6, 1e-3), "area_density": (0.05, 1.0)}, seen, time_step=0.02,
                               material=make_limp())
    bending, density = found.values[BENDING], found.values["area_density"]
    parts = np.array([found.uncertainties[BENDING] / bending, found.uncertainties["area_density"] / density])
    spread = np.sqrt(parts @ parts - 2 * found.correlation[0, 1] * parts.prod())
    assert found.correlation[0, 1] > 0.9
    assert abs(np.log(bending / density / (4e-5 / 0.2))) < 3.5 * spread < 0.03


def test_fit_of_a_residual_and_of_bounds() -> None:
    def sag(world: tulle.World) -> Any:
        return np.array(world.cloths[0].positions)[-SIDE:, 2] - 0.9

    found = tulle.fit_material(droop, {BENDING: (1e-6, 1e-1)}, residual=sag, steps=60, time_step=0.02, material=make_limp())
    assert np.abs(found.residuals).mean() < 2e-3
    bound = tulle.fit_material(droop, {BENDING: (1e-6, 2e-6)}, residual=sag, steps=60, time_step=0.02, material=make_limp())
    assert bound.at_bounds == (BENDING,)


def test_bad_input_of_fits_is_told() -> None:
    seen = {1: SHEET.positions}
    for fields, changes, text in (
            ({}, {}, "no fields"), ({"area_density": (1, 1)}, {}, "bounds of 'area_density'"),
            ({"area_density": (0.1, 1)}, {"observations": {}}, "no observations"), ({"warp": (1, 2)}, {}, "is no number"),
            ({"area_density": (0.1, 1)}, {"observations": None}, "either observations or residual"),
            ({"area_density": (0.1, 1)}, {"observations": {1: np.zeros((4, 3))}}, "should have the shape"),
            ({"area_density": (0.1, 1)}, {"noise": -1.0}, "noise is")):
        with pytest.raises(tulle.InvalidArgumentError, match=text):
            tulle.fit_material(droop, fields, **{"observations": seen, "time_step": 0.02, **changes})  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="did you mean \"area_density\""):
        tulle.fit_material(droop, {"area_densty": (0.1, 1)}, seen, time_step=0.02)
