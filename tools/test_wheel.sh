#!/bin/sh
# Builds the wheel and the sdist, installs the wheel into a fresh environment without a network, and uses it there.
set -eu
python=$(sh paper/find_python.sh 'cffi, numpy, build.__main__')
rm -rf build/wheel
# The libraries are those of build/release, unless TULLE_BUILD is set and empty: then they are built from the sdist.
export TULLE_BUILD="${TULLE_BUILD-$PWD/build/release}"
make --no-print-directory wheel >build/wheel.log 2>&1 || { tail -30 build/wheel.log; exit 1; }
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
"$python" -m venv --system-site-packages "$place/venv"
"$place/venv/bin/pip" install --quiet --no-index --no-cache-dir build/wheel/tulle-*.whl
root=$PWD
cd "$place"
unset PYTHONPATH TULLE TULLE_LIBRARY_PATH
"$place/venv/bin/python" "$root/examples/hello_cloth.py"
viewer=without
[ ! -e "$root/python/tulle/viewer.js" ] || viewer=with
"$place/venv/bin/python" - "$root/scenes/sphere.yaml" $viewer <<'END'
import sys
import tulle

assert "/venv/" in tulle.__file__ and "/venv/" in tulle.find_program(), (tulle.__file__, tulle.find_program())
changes = {"time.frames": 2, "cloth[0].mesh.resolution": [10, 10]}
run = tulle.simulate(sys.argv[1], "run", overrides=changes, progress=False)
scene = tulle.Scene(sys.argv[1], changes)
world = scene.build_world()
for _ in range(2 * scene.steps_per_frame):
    world.step(scene.time_step)
assert run.get_frame(-1).state_hash == world.state_hash
assert tulle.check_files("run")[-1]["intersections"] == 0
is_viewer_inside = "srcdoc=" in world._repr_html_() and "data:image/png" not in world._repr_html_()
assert is_viewer_inside == (sys.argv[2] == "with"), sys.argv[2]
print("the wheel works:", tulle.__version__, sys.argv[2], "the viewer of notebooks")
END
