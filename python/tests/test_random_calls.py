"""Random calls with random arguments: each succeeds or raises, nothing crashes, and no accepted state intersects.

TULLE_EXAMPLES says how many sequences are tried. `make test-python-asan` does so with libraries under the sanitizers.
"""
from __future__ import annotations

import os
from typing import Any

import numpy as np
import tulle
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

EXPECTED = (tulle.Error, TypeError, ValueError, OverflowError, KeyError, MemoryError)
SHAPES = ["rectangle", "disc", "sphere", "box", "cone", "tetrahedron", "plane", "ribbon"]

numbers = st.one_of(st.floats(-2, 2), st.sampled_from([0.0, -0.0, 1e-3, np.nan, np.inf, -np.inf, 1e300, -1e-300]), st.integers(-3, 2**40))
vectors = st.one_of(st.tuples(*[st.floats(-0.3, 0.3)] * 3), st.lists(numbers, max_size=5), st.none(), st.text(max_size=2), numbers)
counts = st.one_of(st.integers(-2, 40), st.just(2**33), numbers)
steps = st.one_of(st.floats(1e-3, 0.05), st.sampled_from([1 / 90, 1 / 24]), numbers)


@st.composite
def arrays(draw: Any) -> Any:
    """Arrays of many shapes and types, some with gaps, and things that are none."""
    kind = draw(st.sampled_from(["rows", "flat", "odd", "none", "text", "gaps"]))
    rows, dtype = draw(st.integers(0, 30)), draw(st.sampled_from(["f8", "f4", "i8", "u4", "?", "c16", "O"]))
    values = np.random.default_rng(draw(st.integers(0, 99))).normal(0, 0.3, (rows, 3))
    if draw(st.booleans()) and rows:
        values[0, 0] = draw(st.sampled_from([np.nan, np.inf, 0.0]))
    with np.errstate(all="ignore"):
        made = {"rows": values, "flat": values.reshape(-1), "odd": values.reshape(3, -1), "none": None, "text": "positions",
                "gaps": np.repeat(values, 2, axis=0)[::2]}[kind]
        return made.astype(dtype, copy=False) if isinstance(made, np.ndarray) and draw(st.booleans()) else made


class Calls(RuleBasedStateMachine):
    """A world, used as a careless program would."""

    def __init__(self) -> None:
        super().__init__()
        self.world = tulle.World(threads=1)
        self.other = tulle.World(threads=1)
        self.states: list[bytes] = []
        self.gone: list[Any] = []
        self.old: list[Any] = []
        self.is_promised = True

    def attempt(self, call: Any) -> Any:
        """Calls; what it raises must be an exception that is expected."""
        try:
            return call()
        except EXPECTED:
            return None

    def pick(self, number: int) -> Any:
        """An object of the world, one that has gone, or one of another world."""
        all_of_them = [*self.world.objects, *self.gone, *self.other.objects] if self.world._handle else self.gone
        return all_of_them[number % len(all_of_them)] if all_of_them else None

    @initialize(height=st.floats(0.05, 0.3), pins=st.lists(st.integers(0, 15), max_size=3, unique=True))
    def begin(self, height: float, pins: list[int]) -> None:
        sheet = tulle.make_shape("rectangle", size=(0.4, 0.4), resolution=4)
        self.world.add_cloth(sheet.transform(translation=(0, 0, height)), pins=[tulle.Pin(pins)] if pins else [])

    @rule(shape=st.sampled_from(["rectangle", "disc", "sphere", "box", "cone"]), place=st.tuples(*[st.floats(-0.5, 0.5)] * 3),
          kind=st.sampled_from(["cloth", "body", "none", "rigid", "deforming"]))
    def add(self, shape: str, place: tuple[float, ...], kind: str) -> None:
        mesh = tulle.make_shape(shape, resolution=None if shape == "tetrahedron" else 4).transform(scale=0.2, translation=place)
        calls = {"cloth": lambda: self.world.add_cloth(mesh), "body": lambda: self.world.add_obstacle(mesh, body={"density": 200.0})}
        if len(self.world.objects) < 6:
            self.attempt(calls.get(kind, lambda: self.world.add_obstacle(mesh, drive=kind)))

    @rule(number=st.integers(0, 9), move=st.tuples(*[st.floats(-0.02, 0.02)] * 3), count=st.integers(1, 5))
    def drive(self, number: int, move: tuple[float, ...], count: int) -> None:
        each = self.pick(number)
        for _ in range(count):
            if isinstance(each, tulle.Cloth):
                self.attempt(lambda: each.set_pin_targets(0, each.positions[:1] + move))
                self.attempt(lambda: each.set_targets(each.positions + move))
            elif isinstance(each, tulle.Obstacle):
                self.attempt(lambda: each.set_next_transform(move))
                self.attempt(lambda: each.set_next_positions(each.positions + move))
            self.step(1 / 90, 1)

    @rule(shape=st.sampled_from(SHAPES), place=vectors, settings=st.fixed_dictionaries({}, optional={
        "thickness": numbers, "velocity": vectors, "grain": vectors, "rest_positions": arrays(), "name": st.text(max_size=3)}),
        material=st.sampled_from(["cotton", "silk", "nothing", None, {"area_density": -1}, {"poisson": 7.0}]))
    def add_cloth(self, shape: str, place: Any, settings: Any, material: Any) -> None:
        def call() -> None:
            mesh = tulle.make_shape(shape, resolution=None if shape == "tetrahedron" else 4).transform(scale=0.2, translation=place)
            self.world.add_cloth(mesh, material=material, pins=[tulle.Pin([0])], **settings)
        if len(self.world.objects) < 6:
            self.attempt(call)

    @rule(shape=st.sampled_from(SHAPES), place=vectors, body=st.sampled_from([None, {"density": 100.0}, {"mass": -1}, {}]),
          drive=st.sampled_from(["none", "rigid", "deforming", "hover"]), frames=st.one_of(st.none(), arrays()))
    def add_obstacle(self, shape: str, place: Any, body: Any, drive: str, frames: Any) -> None:
        def call() -> None:
            mesh = tulle.make_shape(shape, resolution=None if shape == "tetrahedron" else 4).transform(scale=0.2, translation=place)
            self.world.add_obstacle(mesh, body=body, drive=drive, frames=frames)
        if len(self.world.objects) < 6:
            self.attempt(call)

    @rule(positions=arrays(), triangles=arrays())
    def add_anything(self, positions: Any, triangles: Any) -> None:
        self.attempt(lambda: self.world.add_obstacle(tulle.Mesh(positions, triangles)))

    @rule(number=st.integers(0, 9))
    def remove(self, number: int) -> None:
        each = self.pick(number)
        if each is not None and self.attempt(lambda: (self.world.remove(each), True)):
            self.gone.append(each)

    @rule(time_step=steps, count=st.integers(1, 8))
    def step(self, time_step: Any, count: int) -> None:
        for _ in range(count):
            report = self.attempt(lambda: self.world.step(time_step))
            if report is not None:
                assert isinstance(report.to_dict(), dict)
            if report is not None and self.is_promised:
                assert tulle.Judge(1).find_world_intersections(self.world).is_clean

    @rule()
    def save(self) -> None:
        state = self.attempt(self.world.save_state)
        if state is not None:
            self.states.append(state)

    @rule(number=st.integers(0, 9), place=st.integers(0, 5000), value=st.integers(0, 255), damages=st.booleans())
    def load(self, number: int, place: int, value: int, damages: bool) -> None:
        if self.states:
            state = bytearray(self.states[number % len(self.states)])
            if damages:
                state[place % len(state)] = value
            self.attempt(lambda: self.world.load_state(state))

    @rule(number=st.integers(0, 9), values=vectors, rows=arrays(), index=counts, amount=numbers)
    def use_object(self, number: int, values: Any, rows: Any, index: Any, amount: Any) -> None:
        each = self.pick(number)
        if each is None:
            return
        calls = [lambda: each.positions, lambda: each.velocities, lambda: each.normals, lambda: each.contact_forces, lambda: each.strains,
                 lambda: each.copy_values("positions", rows), lambda: each.copy_values(values), lambda: each.get_contacts(),
                 lambda: each.mesh.get_info(), lambda: each.set_material({"area_density": amount}), lambda: each.set_thickness(amount),
                 lambda: each.release_pin(index), lambda: each.set_pin_targets(index, rows), lambda: each.find_patches(max_angle=amount),
                 lambda: each.wake(), lambda: each.set_next_transform(values), lambda: each.set_next_positions(rows),
                 lambda: each.add_force(values), lambda: each.add_impulse(values, values),
                 lambda: each.set_velocity(values, values), lambda: each.set_drive(stiffness=values), lambda: each.set_locks(index, 1),
                 lambda: each.transform.mass, lambda: each.contact_impulse, lambda: each.fineness.mean_edge]
        for call in calls:
            try:
                result = call()
            except AttributeError:  # a cloth has no velocity to set, an obstacle no pins
                continue
            except EXPECTED:
                continue
            if isinstance(result, tulle.StateArray):
                self.old.append(result)

    @rule(number=st.integers(0, 99), category=counts, mask=counts)
    def set_filter(self, number: int, category: Any, mask: Any) -> None:
        each = self.pick(number)
        if each is not None and number > 80 and self.attempt(lambda: (each.set_filter(category, mask), True)):
            self.is_promised = False  # what does not collide may pass through one another

    @rule(a=st.integers(0, 9), b=st.integers(0, 9), rows=arrays(), vertices=st.one_of(arrays(), st.just([1, 2]), st.just([1])), amount=numbers)
    def use_two(self, a: int, b: int, rows: Any, vertices: Any, amount: Any) -> None:
        first, second = self.pick(a), self.pick(b)
        if first is None:
            return
        self.attempt(lambda: self.world.set_law(first, second, static_friction=amount))
        held = self.attempt(lambda: self.world.attach(first, vertices, second if a % 2 else rows, stiffness=amount))
        if held is not None:
            self.attempt(lambda: held.report.force)
            self.attempt(lambda: held.set_points(rows))
            if b % 2:
                self.attempt(held.release)

    @rule(values=vectors, other=vectors, mask=counts, amount=numbers)
    def use_world(self, values: Any, other: Any, mask: Any, amount: Any) -> None:
        world = self.world
        for call in (lambda: world.cast_ray(values, other, mask=mask), lambda: world.find_closest_point(values, amount),
                     lambda: world.find_box_overlaps(values, other), lambda: world.set_gravity(values), world.get_contacts, world.start,
                     lambda: world.set_wind(velocity=other, gust_length=amount), lambda: world.watch_events(capacity=mask),
                     world.poll_events, lambda: world.counts.cloths, world.get_intersections, lambda: world.largest_stretch.stretch,
                     lambda: world.find_mesh_overlaps(tulle.make_shape("box", resolution=2)), lambda: tulle.step_worlds([world, self.other], 0.01)):
            self.attempt(call)

    @rule(number=st.integers(0, 99))
    def read_old(self, number: int) -> None:
        if self.old:
            self.attempt(lambda: self.old[number % len(self.old)].sum())

    @invariant()
    def the_world_answers(self) -> None:
        assert self.world.time >= 0 and self.world.state_hash >= 0

    def teardown(self) -> None:
        self.world.close()
        self.other.close()
        for each in self.gone:
            self.attempt(lambda each=each: each.positions)


Calls.TestCase.settings = settings(max_examples=int(os.environ.get("TULLE_EXAMPLES", "40")), stateful_step_count=25, deadline=None,
                                   derandomize="TULLE_EXAMPLES" not in os.environ, suppress_health_check=list(HealthCheck))
TestCalls = Calls.TestCase
