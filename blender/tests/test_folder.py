"""What lies in the folder may come from others: nothing is read, written or removed outside of it."""
import json
import os
import shutil

import bpy

from support import SceneTest
from tulle_addon import files, job, program
from tulle_addon.meshes import Refusal


class Folder(SceneTest):
    frames = 2

    def read_victims(self):
        with open(self.victim, encoding="ascii") as file:
            return sorted(os.listdir(os.path.dirname(self.victim))), file.read()

    def setUp(self):
        super().setUp()
        self.victim = os.path.join(self.folder, "victim", "mine.pc2")
        os.mkdir(os.path.dirname(self.victim))
        with open(self.victim, "w", encoding="ascii") as file:
            file.write("mine")
        self.add_sheet()

    def press(self, operator):
        """The words with which an operator refuses; None: it does not."""
        try:
            self.assertEqual(operator(), {"FINISHED"})
        except RuntimeError as error:
            return str(error)
        return None

    def change_names(self, path, change):
        with open(path, encoding="utf-8") as file:
            read = json.load(file)
        change(read)
        with open(path, "w", encoding="utf-8") as file:
            json.dump(read, file)

    def test_names_of_blender_json(self):
        """Import would write the cache elsewhere, Free would remove what is there."""
        self.bake_all()
        before = self.read_victims()
        run_file, link_file = self.path("run", "run.json"), self.path("blender.json")
        for name in ("../../victim/mine", self.victim[:-4], "..", "a\\b", "C:mine", ".hidden", "", "a\0b", 7, None):
            for path in (run_file, link_file):
                self.change_names(path, lambda read: read["bodies"][0].update({"name": name}))
            for operator in (bpy.ops.tulle.import_results, bpy.ops.tulle.free):
                self.assertIn("no name of a body", self.press(operator) or "", repr(name))
            self.assertEqual(self.read_victims(), before)
        self.assertTrue(os.path.isfile(self.path("cache", "sheet.pc2")))
        self.change_names(link_file, lambda read: read.update({"bodies": read["bodies"] + [dict(read["bodies"][0])]}))
        self.change_names(link_file, lambda read: [body.update({"name": "sheet"}) for body in read["bodies"]])
        self.assertIn("no name of a body", self.press(bpy.ops.tulle.free) or "")

    def test_names_of_run_json(self):
        self.bake_all()
        before = self.read_victims()
        for key in ("mesh", "cache"):
            self.change_names(self.path("run", "run.json"), lambda read: read["bodies"][0].update({key: "../../victim/mine.pc2"}))
            for operator in (bpy.ops.tulle.import_results, bpy.ops.tulle.free):
                self.assertIn("names files that are not in its folder", self.press(operator) or "")
            self.change_names(self.path("run", "run.json"), lambda read: read["bodies"][0].update({key: "sheet.pc2"}))
        self.assertEqual(self.read_victims(), before)

    def test_links(self):
        """A link anywhere in the folder, and in place of the folder, is refused by all that write or remove."""
        self.bake_all()
        before = self.read_victims()
        away = os.path.join(self.folder, "away")
        for parts in ((), ("cache",), ("meshes",), ("run",), ("scene.yaml",), ("blender.json",), ("left.csv",), ("scene.yaml.tmp",),
                      ("cache", "sheet.pc2"), ("cache", "sheet.pc2.tmp"), ("meshes", "sheet.obj"), ("run.before",), ("mend",)):  # fmt: skip
            path = self.path(*parts)
            is_there = os.path.exists(path)
            if is_there:
                shutil.move(path, away)
            is_file = "." in os.path.basename(path) and parts != ("run.before",)
            os.symlink(self.victim if is_file else os.path.dirname(self.victim), path)
            for operator in (bpy.ops.tulle.bake, bpy.ops.tulle.export, bpy.ops.tulle.import_results, bpy.ops.tulle.free):
                self.assertIn("is a link", self.press(operator) or "", path)
                self.assertTrue(os.path.islink(path))
            self.assertEqual(self.read_victims(), before, path)
            os.remove(path)
            if is_there:
                shutil.move(away, path)
        self.bake_all(restart=True)
        self.assertIsNone(self.press(bpy.ops.tulle.free))
        self.assertFalse(os.path.exists(self.path()))

    def test_files_are_replaced(self):
        """What another folder shares by a hard link is not written through it."""
        self.bake_all()
        for parts in (("scene.yaml",), ("blender.json",), ("meshes", "sheet.obj"), ("cache", "sheet.pc2")):
            os.remove(self.path(*parts))
            os.link(self.victim, self.path(*parts))
        before = self.read_victims()
        self.bake_all(restart=True)
        self.assertEqual(self.read_victims(), before)

    def test_a_file_is_whole_or_not_there(self):
        path = os.path.join(self.folder, "a.txt")
        with self.assertRaises(ZeroDivisionError), files.replacing(path, encoding="ascii") as file:
            file.write("half")
            raise ZeroDivisionError
        self.assertFalse(os.path.exists(path) or os.path.exists(path + ".tmp"))
        os.symlink(self.victim, path + ".tmp")
        with files.replacing(path, encoding="ascii") as file:
            file.write("whole")
        self.assertEqual(self.read_victims()[1], "mine")
        self.assertFalse(os.path.lexists(path + ".tmp"))

    def test_files_beside_each_other(self):
        """Each has a folder of its own, named after it; a scene may name another."""
        self.assertEqual(job.find_folder(self.scene), self.path())
        bpy.ops.wm.save_as_mainfile(filepath=os.path.join(self.folder, "other.blend"))
        self.assertEqual(job.find_folder(self.scene), os.path.join(self.folder, "tulle_other"))
        self.scene.tulle.folder = "//mine"
        self.assertEqual(job.find_folder(self.scene), os.path.join(self.folder, "mine"))

    def test_no_program_of_the_present_folder(self):
        """A program that lies where Blender was started, or in a relative folder of PATH, is not run."""
        bpy.context.preferences.addons["tulle_addon"].preferences.program = ""
        planted = os.path.join(self.folder, program.FILE_NAME)
        shutil.copy("/bin/true" if os.path.exists("/bin/true") else "/usr/bin/true", planted)
        usual, paths = os.getcwd(), os.environ["PATH"]
        os.chdir(self.folder)
        try:
            for path in (".", "", os.pathsep, "."  + os.pathsep + "nowhere"):
                os.environ["PATH"] = path
                with self.assertRaises(Refusal):
                    program.find_program()
            os.environ["PATH"] = "." + os.pathsep + self.folder
            self.assertEqual(program.find_program(), planted)
        finally:
            os.chdir(usual)
            os.environ["PATH"] = paths
