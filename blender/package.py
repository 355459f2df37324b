"""Packs the add-on with a program into a zip that Blender installs: package.py PROGRAM ZIP"""
import os
import sys
import zipfile

HERE = os.path.dirname(os.path.abspath(__file__))


def pack(program: str, path: str) -> None:
    folder = os.path.join(HERE, "tulle_addon")
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(os.listdir(folder)):
            if name.endswith((".py", ".toml")):
                archive.write(os.path.join(folder, name), "tulle_addon/" + name)
        for name in sorted(os.listdir(os.path.join(folder, "fabrics"))):
            archive.write(os.path.join(folder, "fabrics", name), "tulle_addon/fabrics/" + name, zipfile.ZIP_STORED)
        archive.write(os.path.join(HERE, "..", "LICENSE"), "tulle_addon/LICENSE")
        archive.write(program, "tulle_addon/bin/" + os.path.basename(program))


if __name__ == "__main__":
    pack(sys.argv[1], sys.argv[2])
