#!/usr/bin/env bash
# `tulle info --plot`: pictures of a short run, of one cut short, names that look like commands, and what goes wrong.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
faults=0
search=$PATH # where tulle looks for gnuplot
fail() { echo "$*"; faults=1; }

# expect CODE PATTERN ARGUMENT...: exit code of tulle info, and a line of its messages.
expect() {
    local code=$1 pattern=$2
    shift 2
    env PATH="$search" "$TULLE" info "$@" >out 2>&1
    local found=$?
    [ $found = "$code" ] || { fail "tulle info $*: exit $found, expected $code"; cat out; }
    [ -z "$pattern" ] || grep -Eq -- "$pattern" out || { fail "tulle info $*: no \"$pattern\" in:"; cat out; }
}

"$TULLE" run "$TULLE_SOURCE_DIR/scenes/pinch.yaml" -o run --frames 2 >out 2>&1 || { cat out; exit 1; }

expect 2 'svg, .png or .pdf' --plot run -o plot.txt
expect 2 'one directory' --plot run run -o plot.svg
expect 2 'directory of a run' --plot "$work" -o plot.svg
expect 2 'goes with --plot' run -o plot.svg
mkdir bare
search=$work/bare
expect 2 'gnuplot.*gnuplot-nox' --plot run -o plot.svg
search=$PATH
ls | grep -q plot.svg && fail "something half-written is left"

cp -R run damaged
sed -i '3s/^[0-9]*,/x,/' damaged/report.csv
expect 2 'report.csv: frame 2: damaged' --plot damaged -o plot.svg

# In a run of an older version, without checksums, damage is found as the report is read.
sed -i 's/"format_version": 3/"format_version": 2/; s/"checksum": .*/"comment": ""/' run/run.json
cp -R run empty
head -n 1 run/report.csv >empty/report.csv
expect 2 'nothing to plot' --plot empty -o plot.svg
cp -R run bad
sed -i '3s/^[0-9]*,/x,/' bad/report.csv
expect 2 'report.csv:3:1: column step should hold a whole number' --plot bad -o plot.svg
sed -i '3s/^x,//' bad/report.csv
expect 2 'report.csv:3:' --plot bad -o plot.svg
sed -i '1s/^step/stop/' bad/report.csv
expect 2 'report.csv:1:.*heading' --plot bad -o plot.svg

if ! command -v gnuplot >/dev/null; then
    [ $faults = 0 ] || exit 1
    echo "skipped: gnuplot is not installed, so nothing is drawn"
    exit 77
fi

expect 0 '' --plot run -o plot.svg
grep -q '</svg>' plot.svg || fail "plot.svg is no whole SVG file"
for panel in 'step time' contacts 'smallest gap' energy 'CG iterations' 'max stretch' solve_motion; do
    grep -q "$panel" plot.svg || fail "plot.svg lacks $panel"
done
expect 0 '' --plot run -o again.svg
cmp -s plot.svg again.svg || fail "the same report gives two pictures"
expect 0 '' --plot run
[ -s plot.svg ] || fail "no plot.svg by default"

# A run cut short in the middle of a line: its whole lines.
cp -R run cut
truncate -s -9 cut/report.csv
expect 0 '' --plot cut -o cut.svg

# Names are never commands.
name=$'it\'s "a" `touch taken` $(touch taken) @x \\ %s\nsystem "touch taken" #'
cp -R run "$name"
expect 0 '' --plot "$name" -o "$name.svg"
[ -s "$name.svg" ] || fail "no plot of a run with a strange name"
[ ! -e taken ] || fail "a name was taken as a command"

expect 2 'cannot be written: No such file' --plot run -o missing/plot.svg
mkdir folder.svg
expect 2 'is there and no file' --plot run -o folder.svg
ls | grep -q 'tmp$' && fail "a temporary file is left"
# gnuplot's own message comes through.
printf '#!/bin/sh\necho "line 0: all is lost" >&2\nexit 1\n' >bare/gnuplot
chmod +x bare/gnuplot
search=$work/bare:$PATH
expect 3 'gnuplot failed: line 0: all is lost' --plot run -o failed.svg
[ ! -e failed.svg ] || fail "a failed plot is left"
# A gnuplot that ends well and drew half a picture, as on a full disk.
printf '#!/bin/sh\necho "<svg><path"\n' >bare/gnuplot
expect 3 'failed.svg: gnuplot did not write it to its end' --plot run -o failed.svg
ls | grep -qE 'failed|tmp$' && fail "half a plot is left"

[ $faults = 0 ] && echo "plots: all as expected"
exit $faults
