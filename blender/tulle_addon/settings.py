"""What an artist sets: properties of an object (`object.tulle`) and of the scene (`scene.tulle`)."""
import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)

from . import pictures

# May be set on overrides of linked objects.
OVERRIDE = {"LIBRARY_OVERRIDABLE"}

ROLES = [
    ("NONE", "None", "Takes no part"),
    ("CLOTH", "Cloth", "Is simulated as cloth"),
    ("OBSTACLE", "Obstacle", "Cloth meets it; it stands still, or moves as it is animated"),
    ("BODY", "Rigid Body", "Cloth meets it, and contact moves it; its mesh must be closed"),
    ("IGNORED", "Ignored", "Is left out, also where all that is visible is an obstacle, and of instances"),
]

FABRICS = [
    ("cotton", "Cotton", "Shirts and sheets: medium weight, folds well"),
    ("silk", "Silk", "Light, slippery and very soft"),
    ("wool", "Wool", "Soft suiting with some weight"),
    ("denim", "Denim", "Heavy and stiff, as new jeans"),
    ("net", "Net", "Tulle and mosquito net: light, gives way in every direction"),
    ("rubber-sheet", "Rubber Sheet", "One millimetre of rubber: heavy, stretches far, does not slide"),
    ("denim-soft", "Denim, Soft", "Washed denim, measured"),
    ("denim-firm", "Denim, Firm", "Firm denim, measured"),
    ("cotton-broadcloth", "Cotton Broadcloth", "Dense shirt cotton that hardly stretches"),
    ("canvas", "Canvas", "Bags and sails: stiff and heavy"),
    ("chiffon", "Chiffon", "Veils: almost without weight, floats"),
    ("wool-tropical", "Wool, Tropical", "Thin suiting"),
    ("wool-coating", "Wool, Coating", "Thick cloth of coats"),
    ("wool-stretch", "Wool, Stretch", "Suiting with elastane"),
    ("polyester-plain", "Polyester, Plain", "Lining and plain shirts"),
    ("polyester-faille", "Polyester, Faille", "Light dress with a fine rib"),
    ("jersey", "Jersey", "Knitted T-shirts: stretches easily"),
    ("felt", "Felt", "Thick, holds its shape"),
    ("ripstop-nylon", "Ripstop Nylon", "Parachutes and kites: light, does not stretch"),
    ("glass-plain", "Glass, Plain Weave", "Glass fibre: does not stretch, shears freely"),
    ("coated-polyester", "Coated Polyester", "Tents and roofs: heavy, hardly stretches"),
    ("etfe-foil", "ETFE Foil", "Plastic foil of cushions and roofs"),
    ("geotextile", "Geotextile", "Strong woven polyester of earthworks"),
]

REST_SHAPES = [
    ("START", "Start", "The cloth is at rest as it starts"),
    ("KEY", "Shape Key", "The cloth is at rest in a shape key"),
    ("UV", "UV Map", "The active UV map is the flat pattern that the cloth is cut from"),
]

STARTS = [
    ("refuse", "Refuse", "Cloth that intersects something at the start is refused and selected"),
    ("untangle", "Untangle", "Cloth that intersects something at the start is moved until it is free"),
]


class TulleAttachment(bpy.types.PropertyGroup):
    target: PointerProperty(
        override=OVERRIDE, name="To", type=bpy.types.Object, description="Obstacle, rigid body or cloth that holds the vertices"
    )
    vertex_group: StringProperty(
        override=OVERRIDE, name="Vertices", description="Vertices with a weight of at least 0.5; empty: all that are near"
    )
    distance: FloatProperty(
        override=OVERRIDE,
        name="Distance",
        default=0.0,
        min=0.0,
        subtype="DISTANCE",
        unit="LENGTH",
        precision=4,
        description="Vertices that start farther away stay free; 0: none is too far",
    )


class TulleObject(bpy.types.PropertyGroup):
    role: EnumProperty(override=OVERRIDE, name="Role", items=ROLES, default="NONE", description="What the object is for Tulle")
    fabric: EnumProperty(override=OVERRIDE, name="Fabric", items=FABRICS, default="cotton")  # `register` adds the pictures
    use_thickness: BoolProperty(
        override=OVERRIDE, name="Set Thickness", default=False, description="Otherwise the size of the meshes decides"
    )
    thickness: FloatProperty(
        override=OVERRIDE,
        name="Thickness",
        default=0.005,
        min=1e-6,
        subtype="DISTANCE",
        unit="LENGTH",
        precision=4,
        description="Distance that contact keeps between layers",
    )
    use_friction: BoolProperty(
        override=OVERRIDE,
        name="Set Friction",
        default=False,
        description="Otherwise the fabric's own, and 0.3 for what is no cloth",
    )
    friction: FloatProperty(override=OVERRIDE, name="Friction", default=0.3, min=0.0, max=10.0, description="0: ice, 1: rubber")
    density: FloatProperty(
        override=OVERRIDE,
        name="Density",
        default=1000.0,
        min=1e-6,
        soft_min=1.0,
        soft_max=20000.0,
        description="Of a rigid body [kg/m^3]: wood 600, water 1000, steel 7800",
    )
    pin_group: StringProperty(
        override=OVERRIDE, name="Pins", description="Vertices with a weight of at least 0.5 are held, and follow the object"
    )
    stiffness_group: StringProperty(
        override=OVERRIDE, name="Stiffness", description="Weights that make the fabric stiffer or softer, in all ways alike"
    )
    stiffness_from: FloatProperty(
        override=OVERRIDE,
        name="From",
        default=1.0,
        min=0.01,
        max=100.0,
        description="Factor on the fabric's stiffness where the weight is 0",
    )
    stiffness_to: FloatProperty(
        override=OVERRIDE,
        name="To",
        default=10.0,
        min=0.01,
        max=100.0,
        description="Factor on the fabric's stiffness where the weight is 1",
    )
    rest: EnumProperty(
        override=OVERRIDE, name="Rest Shape", items=REST_SHAPES, default="START", description="Shape in which nothing pulls"
    )
    rest_key: StringProperty(override=OVERRIDE, name="Shape Key", description="Shape key in which the cloth is at rest")
    uv_scale: FloatProperty(
        override=OVERRIDE,
        name="UV Size",
        default=1.0,
        min=1e-6,
        subtype="DISTANCE",
        unit="LENGTH",
        precision=4,
        description="Length of the side of the UV square",
    )
    attachments: CollectionProperty(override=OVERRIDE | {"USE_INSERTION"}, type=TulleAttachment)
    strength: FloatProperty(
        override=OVERRIDE,
        name="Strength",
        default=0.5,
        min=1e-3,
        max=1e3,
        soft_max=10.0,
        description="How strongly Mend draws the cloth to where it is given; less is smoother",
    )
    muted_cloth: StringProperty(
        override=OVERRIDE, options={"HIDDEN"}, description="Blender's cloth modifiers that the bake switched off"
    )


class TulleScene(bpy.types.PropertyGroup):
    folder: StringProperty(
        name="Folder", subtype="DIR_PATH",
        description="Where scenes, runs and caches are written; empty: tulle_NAME beside the file NAME.blend",
    )
    substeps: IntProperty(
        name="Substeps",
        default=0,
        min=0,
        max=1000,
        description="Steps of the simulation in a frame; 0: as many as give steps of 1/90 s at most",
    )
    threads: IntProperty(
        name="Threads", default=0, min=0, max=1024, description="0: one for each processor; the result does not depend on it"
    )
    all_obstacles: BoolProperty(
        name="All Visible Objects Are Obstacles",
        default=False,
        description="Besides those that are marked; leave out what is marked Ignored",
    )
    start: EnumProperty(name="At the Start", items=STARTS, default="refuse")
    follow: BoolProperty(
        name="Follow", default=True, description="The view goes to the last whole frame while the bake is under way"
    )
    # What the last bake came to; shown in the panels.
    state: StringProperty(options={"SKIP_SAVE"})
    progress: FloatProperty(name="Progress", subtype="PERCENTAGE", min=0.0, max=100.0, options={"SKIP_SAVE"})
    status: StringProperty(options={"SKIP_SAVE"})
    report: StringProperty(options={"SKIP_SAVE"})


CLASSES = (TulleAttachment, TulleObject, TulleScene)


def register() -> None:
    TulleObject.__annotations__["fabric"] = EnumProperty(
        override=OVERRIDE, name="Fabric", items=pictures.load_fabrics(FABRICS), default="cotton"
    )
    for each in CLASSES:
        bpy.utils.register_class(each)
    bpy.types.Object.tulle = PointerProperty(type=TulleObject, override=OVERRIDE)
    bpy.types.Scene.tulle = PointerProperty(type=TulleScene)


def unregister() -> None:
    del bpy.types.Scene.tulle
    del bpy.types.Object.tulle
    for each in reversed(CLASSES):
        bpy.utils.unregister_class(each)
    pictures.release()
