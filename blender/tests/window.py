"""The add-on in a window: a bake with a bar is cancelled, goes on, and ends; all panels draw. With a folder behind --, a
picture is kept there.

A generator says what to wait for; a timer of Blender goes on with it.
"""
import os
import shutil
import signal
import sys
import tempfile
import traceback

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.dirname(HERE)]
sys.dont_write_bytecode = True

import addon_utils  # noqa: E402
import bpy  # noqa: E402

PICTURES = sys.argv[sys.argv.index("--") + 1 :][0] if "--" in sys.argv else ""
mouse = [0, 0]
folder = tempfile.mkdtemp(prefix="tulle_window_")


def prepare() -> None:
    addon_utils.enable("tulle_addon", default_set=True)
    bpy.context.preferences.addons["tulle_addon"].preferences.program = os.environ["TULLE"]
    bpy.context.preferences.view.show_splash = False
    bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder, "file.blend"))
    bpy.data.objects.remove(bpy.data.objects["Cube"])
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.3, segments=32, ring_count=16)
    bpy.context.object.name, bpy.context.object.tulle.role = "Ball", "OBSTACLE"
    bpy.ops.object.shade_smooth()
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=40, y_subdivisions=40, size=1.4, location=(0, 0, 0.4))
    sheet = bpy.context.object
    sheet.name, sheet.tulle.role, sheet.tulle.fabric = "Sheet", "CLOTH", "silk"
    sheet.modifiers.new("Subdivision", "SUBSURF")
    bpy.ops.object.shade_smooth()
    bpy.context.scene.frame_end = 90  # it must not be done before it is looked at


def show_sidebar():
    """The sidebar with the tab of the add-on, which is clicked on: before Blender 4.2 its name cannot be set."""
    for area in bpy.context.window.screen.areas:
        if area.type == "PROPERTIES":
            area.spaces.active.context = "PHYSICS"
        if area.type == "VIEW_3D":
            area.spaces.active.show_region_ui = True
            yield 0.3
            side = next(each for each in area.regions if each.type == "UI")
            with bpy.context.temp_override(area=area, region=next(each for each in area.regions if each.type == "WINDOW")):
                bpy.ops.view3d.view_selected()
            mouse[:] = side.x + side.width - 12, side.y + side.height - 180
            for kind, value in (("MOUSEMOVE", "NOTHING"), ("LEFTMOUSE", "PRESS"), ("LEFTMOUSE", "RELEASE")):
                bpy.context.window.event_simulate(kind, value, x=mouse[0], y=mouse[1])
                yield 0.1


def wait_for(condition, seconds: float):
    for _ in range(int(seconds * 20)):
        if condition():
            return
        yield 0.05
    raise AssertionError("waited for %s s" % seconds)


def go():
    from tulle_addon import bake

    settings = bpy.context.scene.tulle
    yield from show_sidebar()
    yield 0.5
    assert bpy.ops.tulle.bake("INVOKE_DEFAULT") == {"RUNNING_MODAL"}
    yield from wait_for(lambda: bake.current and bake.current.caches and bake.current.caches.frame_count >= 16, 300)
    bake.current.process._process.send_signal(signal.SIGSTOP)  # it waits while it is looked at, however slow the window is
    assert 0 < settings.progress < 100 and "Frame" in settings.status, settings.status
    yield from wait_for(lambda: bpy.context.scene.frame_current >= 16, 300)
    keep_picture("panel_running.png")
    bpy.ops.tulle.cancel()
    bake.current.process._process.send_signal(signal.SIGCONT)
    yield from wait_for(lambda: bake.current is None, 300)
    assert settings.state == "CANCELLED", settings.state
    assert bpy.context.scene.frame_current == 1
    sheet = bpy.data.objects["Sheet"]
    assert [each.type for each in sheet.modifiers] == ["MESH_CACHE", "SUBSURF"]
    yield 0.3
    assert bpy.ops.tulle.bake("INVOKE_DEFAULT") == {"RUNNING_MODAL"}
    yield from wait_for(lambda: bake.current is None, 300)
    assert settings.state == "FINISHED" and settings.progress == 100, (settings.state, settings.report)
    bpy.context.scene.frame_set(30)
    yield 0.5
    keep_picture("panel.png")
    for obj in (sheet, bpy.data.objects["Ball"]):
        bpy.context.view_layer.objects.active = obj
        for role in ("CLOTH", "BODY", "OBSTACLE", "IGNORED"):
            obj.tulle.role = role
            yield 0.1
    sheet.tulle.role, bpy.context.scene.frame_end = "CLOTH", 8
    # A scene that has changed asks before it is baked anew.
    ball = bpy.data.objects["Ball"]
    ball.tulle.role, ball.location.x = "OBSTACLE", 0.1
    assert bpy.ops.tulle.bake("INVOKE_DEFAULT") == {"RUNNING_MODAL"}
    yield from wait_for(lambda: bake.current is None, 300)
    assert settings.state == "CHANGED", settings.state
    yield 0.3
    keep_picture("panel_changed.png")
    for value in ("PRESS", "RELEASE"):  # the question is where the mouse is
        bpy.context.window.event_simulate("RET", value, x=mouse[0], y=mouse[1])
        yield 0.1
    yield from wait_for(lambda: bake.current is not None, 5)
    yield from wait_for(lambda: bake.current is None, 300)
    assert settings.state == "FINISHED", (settings.state, settings.report)
    # A start that intersects is refused, selected and shown.
    sheet.location.z = 0.1
    assert bpy.ops.tulle.bake("INVOKE_DEFAULT", restart=True) == {"RUNNING_MODAL"}
    yield from wait_for(lambda: bake.current is None, 300)
    assert settings.state == "FAILED" and sheet.mode == "EDIT", settings.state
    sheet.update_from_editmode()
    assert 0 < sum(polygon.select for polygon in sheet.data.polygons) < len(sheet.data.polygons)
    yield 0.3
    keep_picture("panel_refused.png")
    bpy.ops.object.mode_set(mode="OBJECT")
    # What intersects is mended, and shows by how much.
    bpy.context.view_layer.objects.active = sheet
    assert bpy.ops.tulle.mend("INVOKE_DEFAULT") == {"RUNNING_MODAL"}
    yield from wait_for(lambda: bake.current is None, 300)
    assert settings.state == "FINISHED" and settings.progress == 100, (settings.state, settings.report)
    assert "0 after" in settings.report and "departure" in sheet.data.color_attributes, settings.report
    yield 0.3
    keep_picture("panel_mended.png")
    # Cloth inside a body is refused, and the view goes to the vertex that the program names.
    ball.scale = (9, 9, 9)
    view = next(area for area in bpy.context.window.screen.areas if area.type == "VIEW_3D").spaces.active.region_3d
    distance = view.view_distance
    assert bpy.ops.tulle.mend("INVOKE_DEFAULT") == {"RUNNING_MODAL"}
    yield from wait_for(lambda: bake.current is None, 300)
    assert settings.state == "FAILED" and "lies inside 'Ball'" in settings.report, (settings.state, settings.report)
    sheet.update_from_editmode()
    assert sheet.mode == "EDIT" and sum(vertex.select for vertex in sheet.data.vertices) == 1, sheet.mode
    yield from wait_for(lambda: view.view_distance < 0.5 * distance, 10)
    keep_picture("panel_mend_refused.png")
    bpy.ops.object.mode_set(mode="OBJECT")
    ball.scale = (1, 1, 1)
    sheet.location.z, bpy.context.scene.frame_end = 0.4, 1000  # many: it must not be done before it is looked at
    # Blender's window closes while a bake is under way: the program ends in good order.
    sheet.tulle.role = "CLOTH"
    settings.substeps = 8
    assert bpy.ops.tulle.bake("INVOKE_DEFAULT", restart=True) == {"RUNNING_MODAL"}
    yield from wait_for(lambda: bake.current and bake.current.caches and bake.current.caches.frame_count >= 2, 300)
    under_way = bake.current
    bake.stop()
    yield from wait_for(lambda: under_way.process.get_code() == 130, 5)
    yield 0.3


def keep_picture(name: str) -> None:
    if PICTURES:
        bpy.ops.screen.screenshot(filepath=os.path.join(os.path.abspath(PICTURES), name))


def advance():
    try:
        return next(steps)
    except StopIteration:
        end(0)
    except Exception:
        traceback.print_exc()
        end(1)


def end(code: int) -> None:
    print("window: passed" if code == 0 else "window: failed")
    sys.stdout.flush()
    shutil.rmtree(folder)
    os._exit(code)


prepare()
steps = go()
bpy.app.timers.register(advance, first_interval=1.0)
