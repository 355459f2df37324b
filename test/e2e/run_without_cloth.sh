#!/usr/bin/env bash
# A scene of rigid bodies alone runs, resumes, and is read by every command that reads runs; one in which nothing moves is refused.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
scene=$TULLE_SOURCE_DIR/test/e2e/scenes/dice.yaml
faults=0
fault() { echo "fault: $*"; faults=1; }
# tell COMMAND...: runs it; what it says is in told.
tell() { "$@" >told 2>&1 || fault "$*: exit $?: $(tail -n 1 told)"; }

tell "$TULLE" run "$scene" -o dice --write vtp --record debug --progress none
hash=$(tail -n 1 told)
tell "$TULLE" run "$scene" -o cut --frames 5 --progress none
tell "$TULLE" run "$scene" -o cut --resume --progress none
[ "$(tail -n 1 told)" = "$hash" ] || fault "resumed: $(tail -n 1 told), not $hash"
cmp -s dice/bodies.csv cut/bodies.csv || fault "the resumed run places bodies elsewhere"
[ "$(wc -l <dice/bodies.csv)" = 40 ] || fault "bodies.csv has $(wc -l <dice/bodies.csv) lines, not a head and 3 of each of 13 frames"
tell "$TULLE" check dice
grep -q '^0 intersections in 13 frames' told || fault "check: $(tail -n 1 told)"
tell "$TULLE" info dice
grep -q 'moving obstacle *die.002' told || fault "info does not name die.002"
tell "$TULLE" convert dice --body die.001 --frame 12 die.vtp
tell "$TULLE" convert dice --body die.001 die.pc2
tell "$TULLE" check die.vtp
if "$TULLE" render --help >help 2>&1 && "$TULLE" render dice -o die.png --size 32x18 --samples 1 >told 2>&1; then
    [ -s die.png ] || fault "render wrote no picture"
else
    grep -q -i 'without' told || fault "render: $(tail -n 1 told)"
fi

"$TULLE" run "$scene" -o spun --set 'obstacles[1].dynamic.spin=[0, 0, 10000]' --set 'time.step=0.2 s' --progress none >told 2>&1
[ $? = 3 ] || fault "a step that no substeps follow went on"
grep -q "'die.000' spins with .* rad/s in step 0, .* use a time step of at most" told || fault "spin: $(cat told)"

for change in 'obstacles[1].dynamic=false' 'obstacles=[]'; do
    "$TULLE" run "$scene" -o still --set "$change" --progress none >told 2>&1
    [ $? = 2 ] || fault "$change was not refused"
    grep -q 'nothing moves: the scene needs a cloth, or an obstacle that is dynamic' told || fault "$change: $(cat told)"
    [ -e still ] && fault "$change: wrote something"
done
exit $faults
