"""The zip, installed in a Blender of its own that has no tulle elsewhere: it bakes with the program inside."""
import os
import subprocess
import sys
import tempfile
import unittest

import bpy

import package
from support import TULLE

SCRIPT = """
import bpy, os, sys
if bpy.app.version < (4, 2, 0):
    bpy.ops.preferences.addon_install(filepath=os.environ["ZIP"])
    bpy.ops.preferences.addon_enable(module="tulle_addon")
else:
    bpy.ops.extensions.package_install_files(filepath=os.environ["ZIP"], repo="user_default", enable_on_install=True)
bpy.ops.wm.save_as_mainfile(filepath=os.path.join(os.environ["HOME"], "file.blend"))
bpy.data.objects["Cube"].tulle.role = "OBSTACLE"
bpy.ops.mesh.primitive_grid_add(size=1, location=(0, 0, 1.01))
bpy.context.object.tulle.role = "CLOTH"
bpy.context.scene.frame_end = 3
print("BAKED", bpy.ops.tulle.bake(), bpy.context.scene.tulle.status)
names = [name for name in bpy.context.preferences.addons.keys() if name.endswith("tulle_addon")]
bpy.ops.preferences.addon_disable(module=names[0])
print("OFF", hasattr(bpy.types.Object, "tulle"))
"""


class Zip(unittest.TestCase):
    def test_installed(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "tulle_addon.zip")
            package.pack(TULLE, path)
            environment = {key: value for key, value in os.environ.items() if not key.startswith("TULLE")}
            # Debian's Blender from 4.2 on looks for Python on PATH.
            folders = [each for each in os.get_exec_path() if not os.path.exists(os.path.join(each, "tulle"))]
            environment.update(
                {"ZIP": path, "HOME": folder, "BLENDER_USER_RESOURCES": folder, "PATH": os.pathsep.join(folders)}
            )
            done = subprocess.run(
                [bpy.app.binary_path, "-b", "--factory-startup", "--python-exit-code", "1", "--python-expr", SCRIPT],
                env=environment, capture_output=True, text=True, check=False,
            )  # fmt: skip
            words = done.stdout + done.stderr
            self.assertEqual(done.returncode, 0, words)
            self.assertIn("BAKED {'FINISHED'} 3 frames", words)
            self.assertIn("OFF False", words)
            sys.stdout.flush()
