#!/usr/bin/env bash
# `tulle info` of meshes and point caches, good and bad.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
faults=0

# expect CODE PATTERN FILE...: exit code, and a line of either output.
expect() {
    local code=$1 pattern=$2
    shift 2
    "$TULLE" info "$@" >out 2>&1
    local found=$?
    [ $found = "$code" ] || { echo "tulle info $*: exit $found, expected $code"; faults=1; }
    grep -Eq -- "$pattern" out || { echo "tulle info $*: no \"$pattern\" in:"; cat out; faults=1; }
}

# A tetrahedron, a square with one diagonal, three triangles on one edge.
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n' >solid.obj
printf 'v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 9 9 9\nf 1 2 3\nf 1 3 4\n' >sheet.obj
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 -1 0\nf 1 2 3\nf 1 2 4\nf 1 2 5\n' >fan.obj
expect 0 '^  vertices +4 \(0 used' solid.obj
expect 0 '^  edges +6 \(0 on the boundary in 0 loops' solid.obj
expect 0 '^  V - E \+ F +2$' solid.obj
expect 0 '^  as cloth +can be used' solid.obj
expect 0 '^  vertices +5 \(1 used' sheet.obj
expect 0 '^  edges +5 \(4 on the boundary in 1 loops' sheet.obj
expect 0 '^  area +4 m\^2' sheet.obj
expect 0 '^  edge length +2 least, .* 2.82843 greatest' sheet.obj
expect 0 '^  smallest angle +45 deg' sheet.obj
expect 0 '^  edges .* 1 with three or more triangles' fan.obj
expect 0 '^  as obstacle +can be used' fan.obj
grep -Eq '^  as cloth +can be used' out && { echo "three triangles on an edge pass as cloth"; faults=1; }
expect 0 '^sheet.obj: triangle mesh' solid.obj sheet.obj

# Panels that meet with doubled vertices: cloth would come apart there, unless it is joined.
printf 'v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 1 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nf 1 2 3 4\nf 5 6 7 8\n' >panels.obj
expect 0 '^ +but 2 boundary vertices are in the place of others' panels.obj
expect 0 "^ +'tulle convert panels.obj OUT.ply --repair' joins them$" panels.obj
"$TULLE" convert panels.obj joined.ply --repair >/dev/null || faults=1
expect 0 '^  as cloth +can be used' joined.ply
grep -q 'in the place of others' out && { echo "joined panels are told of seams"; faults=1; }

# As other tools write them, and a triangle twice.
printf 'o it\nv 0 0 0\nv 1 0 0\nv 0 1 0\nseam 1 2\nl 1 2\nl 2 3\nvt 0 0\nf 1/1 2/1 3/1\nf 3 2 1\n' >other.obj
expect 0 "^  file +passed over: 1 'o' \\(line 1\\), 1 'seam' \\(line 5\\), 2 'l' \\(line 6\\)$" other.obj
expect 0 '^  as cloth +triangle 1 \(line 10\) has the same three vertices as triangle 0 \(line 9\) \(first vertex 2 \(line 4\)' other.obj
expect 0 '^  as obstacle +can be used$' other.obj
expect 0 '^ +dropped there: 1 triangles .*; triangle 1 \(line 10\) is triangle 0 \(line 9\) again$' other.obj
"$TULLE" convert other.obj other.ply | grep -q "^  loss  *passed over: 1 'o' (line 1), 1 'seam'" || { echo "convert does not say what it passes over"; faults=1; }
expect 0 '^  triangles +2 ' other.ply
grep -q '^  file' out && { echo "a PLY file has a note"; faults=1; }

printf 'time: {frames: 1, step: 0.01}\ncloth: [{mesh: {shape: rectangle}, translate: [0, 0, 1]}]\nobstacles: [{mesh: {file: other.obj}}]\n' >scene.yaml
"$TULLE" run scene.yaml -o out_run --progress none >/dev/null 2>notes || { echo "a scene with other.obj: $(cat notes)"; faults=1; }
mv notes run_notes
"$TULLE" info scene.yaml >/dev/null 2>info_notes
"$TULLE" check other.obj >/dev/null 2>check_notes
"$TULLE" detect other.obj other.obj >/dev/null 2>detect_notes
for name in run info check detect; do
    mv ${name}_notes notes
    grep -q "^tulle $name: other.obj: passed over: 1 'o' (line 1), 1 'seam' (line 5)" notes || { echo "$name: no note: $(cat notes)"; faults=1; }
    [ $name = run ] || [ $name = info ] || continue
    grep -q "^tulle $name: other.obj:10: triangle 1 has the same corners as triangle 0 (line 9) and is dropped$" notes || { echo "$name: no warning: $(cat notes)"; faults=1; }
done

# Far from the origin floats do not hold it, nearer they do; and never where an edge is too short for the mesh itself.
printf 'v 500000 0 0\nv 500000.02 0 0\nv 500000.02 0.02 0\nv 500000 0.02 0\nf 1 2 3 4\n' >far.obj
expect 0 '^  as cloth +can be used$' far.obj
expect 0 '^ +within 2\.97e\+04 m of the origin only, and it reaches 5e\+05 m: .* triangle, of 0\.0141 m,' far.obj
printf 'v 0 0 0\nv 1 0 0\nv 1 1e-7 0\nf 1 2 3\n' >low.obj
expect 0 '^  as cloth +triangle 0 \(line 4\) is 1e-07 m high .* is 1e-07 m long\. .* 2\.38e-07 m in a mesh that reaches 0\.5 m from its middle' low.obj

# An obstacle goes without triangles that have no area.
printf 'v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0.5 0 0\nf 1 2 3\nf 1 4 2\n' >flat.obj
expect 0 '^  as cloth +triangle 1 \(line 6\) .* has zero area' flat.obj
expect 0 '^  as obstacle +can be used$' flat.obj
expect 0 '^ +left out there: 1 triangles without area, first triangle 1 \(line 6\)$' flat.obj
printf 'v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0.5 -1 0\nf 1 2 3\nf 1 4 2\n' >flat_1.obj
cp flat.obj flat_0.obj
expect 0 '^ +left out there: 1 triangles without area in this frame, unless they have one in others' 'flat_%d.obj'

# What cannot be cloth is repaired: here a bow tie and a loose vertex, three triangles at an edge, a T-junction within a tolerance.
repair() {
    local pattern=$1
    shift
    "$TULLE" convert "$@" --repair >out 2>&1 || { echo "convert $* --repair: $(cat out)"; faults=1; }
    grep -Eq -- "$pattern" out && grep -q '^  as cloth    can be used$' out && grep -q '^  judged      0 pairs of triangles intersect, ' out ||
        { echo "convert $* --repair: no \"$pattern\" in:"; cat out; faults=1; }
}
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv -1 0 0\nv 0 -1 0\nv 9 9 9\nf 1 2 3\nf 1 4 5\n' >bow.obj
printf 'v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.00005 0\nv 0.5 -1 0\nf 1 2 3\nf 1 3 4\nf 1 6 5\nf 2 5 6\n' >junction.obj
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 2 3 4\n' >turned.obj
expect 0 "'tulle convert bow.obj OUT.ply --repair' makes it cloth" bow.obj
repair '^  repaired    1 vertices doubled .*, first at \(0, 0, 0\)$' bow.obj bow.ply
grep -q '1 vertices without a triangle left out, first at (9, 9, 9)' out || { echo "a loose vertex is not told"; faults=1; }
repair '^  repaired    nothing' bow.ply bow_again.ply
cmp bow.ply bow_again.ply || { echo "a second repair changes something"; faults=1; }
repair '1 edges with three triangles or more cut' fan.obj fan.ply
repair '^  repaired    1 triangles turned over' turned.obj turned.ply
repair '^  repaired    1 T-junctions mended' junction.obj junction.ply --tolerance 0.1mm
"$TULLE" convert junction.obj junction.ply --repair >out
grep -q 'T-junctions' out && { echo "a T-junction is mended without a tolerance"; faults=1; }
"$TULLE" convert bow.obj no.ply --tolerance 1mm 2>out && { echo "a tolerance without a repair passes"; faults=1; }
"$TULLE" convert 'flat_%d.obj' no.ply --repair 2>out && { echo "two frames are repaired at once"; faults=1; }
grep -q 'choose it by --frame' out || { echo "two frames: $(cat out)"; faults=1; }

# Polygons that are there twice, the other way round and from another corner, are duplicates.
printf 'v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nf 4 3 2 1\n' >double.obj
{
    printf 'v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n'
    printf 'f %s\n' '4 3 2 1' '5 6 7 8' '1 2 6 5' '2 3 7 6' '3 4 8 7' '4 1 5 8'
    printf 'f %s\n' '1 2 3 4' '8 7 6 5' '5 6 2 1' '6 7 3 2' '7 8 4 3' '8 5 1 4'
} >double_cube.obj
expect 0 '^ +dropped there: 2 triangles with the same corners as others; triangle 2 \(line 6\) is triangle 0 \(line 5\) again$' double.obj
repair '^  repaired    2 triangles with the same corners as others dropped' double.obj double.ply
grep -q '^element face 2$' double.ply || { echo "a double quad keeps more than 2 triangles"; faults=1; }
repair '^  repaired    12 triangles with the same corners as others dropped' double_cube.obj double_cube.ply
grep -aq '^element face 12$' double_cube.ply || { echo "a double cube keeps more than 12 triangles"; faults=1; }

# Names by which a scene chooses triangles.
printf 'v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\ng left all\nusemtl Red Wool\nf 1 2 3\ng right all\nf 1 3 4\n' >named.obj
expect 0 '^  groups +left: 1 triangles$' named.obj
grep -Eq '^ +all: 2 triangles$' out && grep -Eq '^ +right: 1 triangles$' out && grep -Eq '^  materials +Red Wool: 2 triangles$' out ||
    { echo "names are missing:"; cat out; faults=1; }

# Of a series, check notes the first three files and how many more there are.
for count in 1 2 3 4 5; do cp other.obj "other_$count.obj"; done
"$TULLE" check other_[1-3].obj >/dev/null 2>notes
[ "$(wc -l <notes)" = 3 ] || { echo "three files: $(cat notes)"; faults=1; }
"$TULLE" check other_[1-4].obj >/dev/null 2>notes
grep -q '^tulle check: \.\.\. and something was passed over in 1 more file$' notes || { echo "four files: $(cat notes)"; faults=1; }
"$TULLE" check other_[1-5].obj >/dev/null 2>notes
[ "$(grep -c '^tulle check: other_[1-3]\.obj: passed over: ' notes)" = 3 ] && [ "$(wc -l <notes)" = 4 ] &&
    grep -q '^tulle check: \.\.\. and something was passed over in 2 more files$' notes || { echo "five files: $(cat notes)"; faults=1; }

# A cache of 2 points and 2 frames: signature, version, points, start, rate, frames; then the frames, float32.
{
    printf 'POINTCACHE2\0\001\0\0\0\002\0\0\0\0\0\0\0\0\0\200?\002\0\0\0'
    printf '\0\0\200?\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0@\0\0\0\0'
    printf '\0\0\200?\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0@\0\0\200\277'
} >motion.pc2
expect 0 '^  frames +2, first 0, one every 1' motion.pc2
expect 0 '^ +z  -1 .. 0 m' motion.pc2

head -c 20 motion.pc2 >cut.pc2
: >empty.obj
printf 'v 0 0 0\nf 1 2 3\n' >range.obj
expect 2 'cut.pc2' cut.pc2
expect 2 'empty.obj' empty.obj
expect 2 'range.obj:2' range.obj
expect 2 'missing.obj' missing.obj
expect 2 '^solid.obj: triangle mesh' missing.obj solid.obj
"$TULLE" info solid.obj >/dev/full 2>out
[ $? = 3 ] || { echo "onto a full disk: no exit 3"; faults=1; }
exit $faults
