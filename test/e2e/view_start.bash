# What the tests of `tulle view` begin with: skips where the program has no viewer; a folder $work with a small scene and a run of it.
command -v python3 >/dev/null || { echo "skipped: python3 is missing"; exit 77; }
if "$TULLE" view "$0.none" 2>&1 | grep -q "without the viewer"; then
    echo "skipped: built without tulle view (it needs libwebsockets and npm)"
    exit 77
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cat >"$work/sheet.yaml" <<'END'
title: a sheet on two pins over a ball
time: {step: 1/60 s, frames: 20}
cloth:
  - name: sheet
    mesh: {shape: rectangle, size: [0.6, 0.6], resolution: [13, 13]}
    translate: [0, 0, 0.45]
    pins:
      - {vertices: [0]}
      - {vertices: [12]}
obstacles:
  - {name: ball, mesh: {shape: sphere, radius: 0.15, resolution: [4]}, translate: [0, 0, 0.25]}
  - {name: block, mesh: {shape: box, size: [0.1, 0.1, 0.1]}, translate: [0.6, 0, 0.06], dynamic: {mass: 0.2}}
  - {name: ground, mesh: {shape: plane, size: [4, 4]}}
END
