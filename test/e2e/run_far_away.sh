#!/usr/bin/env bash
# Cloth that falls so far that floats cannot keep its gaps stops the run with exit 3 and says so; the
# frames up to there are clean.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
cat >far.yaml <<'END'
title: falls for ever
time: {step: 0.1 s, frames: 200}
wind: {drag: 0}
cloth:
  - name: lost
    mesh: {shape: rectangle, size: [0.2, 0.2], resolution: [5, 5]}
END
"$TULLE" run far.yaml -o out --progress none >stdout 2>stderr
code=$?
[ $code = 3 ] || { echo "fault: exit $code, expected 3"; cat stderr; exit 1; }
grep -q "vertex 0 of 'lost'.*floats of the files" stderr || { echo "fault: the message is"; cat stderr; exit 1; }
"$TULLE" check out >verdict || { echo "fault: the frames are not clean"; tail -3 verdict; exit 1; }
grep -q '^0 intersections in [0-9]* frames$' verdict || { echo "fault: no verdict"; exit 1; }
