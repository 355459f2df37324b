"""Each module can be imported first, and libraries that do not fit are refused."""
from __future__ import annotations

import os
import pkgutil
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import tulle

MODULES = sorted(module.name for module in pkgutil.walk_packages(tulle.__path__, "tulle.") if not module.name.endswith("__main__"))


def run(text: str, **variables: str) -> subprocess.CompletedProcess[str]:
    """Runs Python code in a process of its own."""
    return subprocess.run([sys.executable, "-c", text], env={**os.environ, **variables}, capture_output=True, text=True, check=False)


def test_each_module_can_be_the_first() -> None:
    failures = {name: done.stderr for name in MODULES for done in [run(f"import {name}")] if done.returncode}
    assert len(MODULES) > 20 and not failures


def test_modules_are_found_without_an_import() -> None:
    done = run("import tulle; print(tulle.envs.list_tasks, tulle.sensitivity.Rollout, hasattr(tulle, 'nothing'))")
    assert not done.returncode and done.stdout.rstrip().endswith("False"), done.stderr


@pytest.mark.skipif(sys.platform != "linux", reason="takes libm of Linux for libtulle")
def test_libraries_that_do_not_fit(tmp_path: Path) -> None:
    assert "names no directory" in run("import tulle.world", TULLE_LIBRARY_PATH="/nowhere").stderr
    (tmp_path / "libtulle.so").write_text("no library")
    (tmp_path / "libtulle_io.so").write_text("no library")
    assert "ImportError: tulle: the libraries cannot be loaded" in run("import tulle.world", TULLE_LIBRARY_PATH=str(tmp_path)).stderr
    other = next(Path("/lib").glob("*-linux-gnu/libm.so.6"))
    for name in ("libtulle.so", "libtulle_io.so"):
        shutil.copy(other, tmp_path / name)
    assert "ImportError: tulle: the package does not fit" in run("import tulle.world", TULLE_LIBRARY_PATH=str(tmp_path)).stderr


def test_help_tells_the_values_of_a_struct() -> None:
    words = tulle.structs.Wind.__doc__ or ""
    assert words.startswith("Wind: a mean velocity") and "\ngust_time: [s] 1e-6 .. 1e6, default 0.5: correlation time" in words
