"""What is run: the scenes, and each tool's settings. All tools get the same meshes and, where they have a knob for it, Tulle's
values of mass, stiffness, damping, friction and contact distance; the formulas below say how a knob's value follows."""
import math
import pathlib
import re

SCENES = ("sphere", "needles", "spikes")
INTERVAL = 1 / 24  # s between frames of the peers; Tulle's scenes have their own
# variant, settings
TULLE = ("as it is", "the scene as it is in scenes/: steps of 1/90 s, three a frame, preset cotton; one thread")
TULLE_LONG_STEPS = ("one step a frame", "the same with steps of 1/24 s, one a frame, which is a frame of the others")

# Of the preset cotton, docs/guide/materials.md, which the scenes use.
COTTON = {"area_density": 0.150, "stretch": 300.0, "bend": 1.0e-5, "stretch_damping": 5e-4, "bend_damping": 2e-3,
          "air_damping": 0.05, "friction": 0.40}  # fmt: skip
SELF_FRICTION = 0.3  # contact.friction of a scene
GRAVITY = 9.81
POISSON = 1 / 3  # of a sheet of springs, which Tulle's is


class Physics:
    """The values of a scene that all tools share, from its run directory."""

    def __init__(self, run, cloth):
        scene = (pathlib.Path(run) / "scene.yaml").read_text(encoding="utf-8")
        self.frictions = {}  # by obstacle: the geometric mean with the cloth's, as Tulle has it
        obstacles = re.sub(r"(?s).*?\nobstacles:", "", scene, count=1)
        for name, friction in re.findall(r'(?s)name: "([^"]+)".*?\n    friction: (\S+)', obstacles):
            self.frictions[name] = math.sqrt(COTTON["friction"] * float(friction))
        self.mass = COTTON["area_density"] * cloth.area
        self.vertex_count = len(cloth.vertices)
        self.mean_edge = cloth.mean_edge
        self.thickness = min(0.2 * cloth.mean_edge, 0.005)  # Tulle's contact distance, docs/method/index.md

    def get_friction(self, mesh):
        """Of an obstacle's OBJ file; copies of an obstacle are NAME.NUMBER."""
        stem = pathlib.Path(mesh).stem
        return self.frictions.get(stem, self.frictions.get(stem.split(".")[0]))


def blender_matched(physics, quality, collision_quality):
    """Blender's cloth counts time in frames of 1/25 s whatever the frame rate, and gravity in thousandths of metres per frame^2:
    9.81 acts as 6.13 m/s^2. Only ratios to the mass count; a vertex keeps the 0.3 kg that are Blender's default."""
    frame, mass = 1 / 25, 0.3
    heavier = mass / (physics.mass / physics.vertex_count)
    spring = math.sqrt(3) / 2 * COTTON["stretch"] * heavier * frame**2  # of a lattice of such a stiffness
    height = math.sqrt(3) / 2 * physics.mean_edge  # of a triangle; a fold pushes its two tips with 0.1 * bending * edge * angle
    bend = 10 * 1.5 * COTTON["bend"] / height**2 * heavier * frame**2
    half = physics.thickness / 2
    return {
        "scene.gravity": GRAVITY / (0.001 / frame**2),
        "settings.quality": quality,
        "collision_settings.collision_quality": collision_quality,
        "settings.mass": mass,
        "settings.tension_stiffness": spring * physics.mean_edge,  # a spring has this over the mean edge
        "settings.compression_stiffness": spring * physics.mean_edge,
        "settings.tension_damping": COTTON["stretch_damping"] / frame * spring,
        "settings.compression_damping": COTTON["stretch_damping"] / frame * spring,
        "settings.bending_stiffness": bend,
        "settings.bending_damping": COTTON["bend_damping"] / frame * 0.1 * bend * physics.mean_edge,
        "settings.air_damping": COTTON["air_damping"] * frame * mass / 0.01,
        "collision_settings.use_self_collision": 1,
        "collision_settings.distance_min": half,  # of the cloth, added to the obstacle's
        "collider.thickness_outer": half,
        "collision_settings.self_distance_min": half,  # counts twice
        "collision_settings.self_friction": 100 * SELF_FRICTION,  # hundredths
        "collider.cloth_friction": "scaled 100",
    }


def blender_as_shipped(_):
    """Factory values with the preset Cotton; a vertex weighs 0.3 kg, so the whole cloth nearly 3 t."""
    return {"settings.quality": 5, "settings.shear_stiffness": 15, "collision_settings.use_self_collision": 1}


def mujoco(physics, **options):
    """Solver and contact values are those of MuJoCo's own model of cloth on a sphere, `drape`."""
    # A plate of this thickness has the cotton's stretch and bend stiffness both.
    plate = math.sqrt(12 * COTTON["bend"] * (1 - POISSON**2) / COTTON["stretch"])
    return {
        "timestep": 0.002, "solver": "CG", "tolerance": 1e-6, "iterations": 400, "integrator": "discrete", "ipc": "disable",
        "passive": "true", "memory": "1G", "young": COTTON["stretch"] / plate, "poisson": POISSON, "shell_thickness": plate,
        "damping": COTTON["stretch_damping"], "radius": physics.thickness / 2, "self_friction": SELF_FRICTION, **options,
    }  # fmt: skip


def bullet(physics, **options):
    spring = math.sqrt(3) / 2 * COTTON["stretch"]
    return {"margin": physics.thickness / 2, "spring": spring, "damping": COTTON["stretch_damping"] * spring, **options}


# tool, variant, what its settings are, a function of the physics that gives them
PEERS = [
    ("Blender", "default quality", "5 steps a frame, collision quality 2; mass, stiffness, friction and distances matched",
     lambda physics: blender_matched(physics, 5, 2)),
    ("Blender", "best quality", "80 steps a frame, collision quality 20, the ends of its sliders; the rest matched",
     lambda physics: blender_matched(physics, 80, 20)),
    ("Blender", "as shipped", "preset Cotton (0.3 kg a vertex), factory values, self-collision on; distances 35 mm and 30 mm",
     blender_as_shipped),
    ("MuJoCo", "as in its drape", "steps of 2 ms, discrete integrator, CG 400 iterations to 1e-6, passive contact; sphere and plane exact",
     mujoco),
    ("MuJoCo", "ipc", "the same with ipc=enable, which is without friction; steps of 2 ms, its default",
     lambda physics: mujoco(physics, ipc="enable")),
    ("MuJoCo", "ipc, 10 ms", "the same with steps of 10 ms",
     lambda physics: mujoco(physics, ipc="enable", timestep=0.01)),
    ("Bullet", "soft body", "position-based; steps of 1/72 s, 1 iteration, its default; no self-collision; no knob for stiffness in N/m",
     lambda physics: bullet(physics, world="soft", steps=3, iterations=1)),
    ("Bullet", "soft body, best", "the same with steps of 1/240 s and 20 iterations",
     lambda physics: bullet(physics, world="soft", steps=10, iterations=20)),
    ("Bullet", "deformable", "mass-spring force, implicit, steps of 1/240 s, self-collision; no bend stiffness",
     lambda physics: bullet(physics, world="deformable", steps=10)),
]  # fmt: skip
