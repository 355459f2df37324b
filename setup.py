"""Builds libtulle, libtulle_io and the program with CMake and puts them into the package.

The environment variable TULLE_BUILD names a build directory whose libraries and program are taken instead.
"""
from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

from setuptools import Distribution, setup
from setuptools.command.build_py import build_py

try:
    from setuptools.command.bdist_wheel import bdist_wheel
except ImportError:  # setuptools before 70
    from wheel.bdist_wheel import bdist_wheel

ROOT = Path(__file__).resolve().parent
TARGETS = ("tulle_shared", "tulle_io_shared", "tulle_program")
FILES = {"libtulle.so": "lib", "libtulle_io.so": "lib", "tulle": "bin"}


def read_version() -> str:
    """The version of the public header."""
    text = (ROOT / "include/tulle/base.h").read_text(encoding="utf-8")
    return ".".join(re.search(rf"define TULLE_VERSION_{part} (\d+)", text)[1] for part in ("MAJOR", "MINOR", "PATCH"))


class BuildWithLibraries(build_py):
    """Beside the modules: the libraries, the program, and what generate.py makes of the headers."""

    def run(self) -> None:
        super().run()
        package, built = Path(self.build_lib).resolve() / "tulle", os.environ.get("TULLE_BUILD")
        build = Path(built) if built else ROOT / "build" / "wheel-build"
        jobs = os.environ.get("JOBS") or str(os.cpu_count() or 1)
        configure = ["cmake", "-S", str(ROOT), "-B", str(build), "-DCMAKE_BUILD_TYPE=Release", "-DTULLE_BUILD_TESTS=OFF",
                     "-DTULLE_VIEW=off"]  # libwebsockets would have to be there wherever the wheel goes
        for command in () if built else (configure, ["cmake", "--build", str(build), "-j", jobs, "--target", *TARGETS]):
            subprocess.run(command, check=True)
        for name, folder in FILES.items():
            (package / folder).mkdir(exist_ok=True)
            shutil.copy2((build / name).resolve(), package / folder / name)
            subprocess.run(["strip", "--strip-unneeded", str(package / folder / name)], check=False)
        subprocess.run([sys.executable, str(ROOT / "python/generate.py"), str(ROOT / "include"), str(package)], check=True)


class DistributionOfPlatform(Distribution):
    """What it holds is for one platform."""

    def has_ext_modules(self) -> bool:
        return True


class WheelOfAnyPython(bdist_wheel):
    """The package is Python alone beside the libraries: any Python 3 of this platform takes it."""

    def get_tag(self) -> tuple[str, str, str]:
        return "py3", "none", super().get_tag()[2]


setup(version=read_version(), distclass=DistributionOfPlatform,
      cmdclass={"build_py": BuildWithLibraries, "bdist_wheel": WheelOfAnyPython})
