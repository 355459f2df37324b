#!/usr/bin/env bash
# A pipe that nobody writes to, a device, a directory or a socket in the place of a file is refused by every subcommand,
# at once and with a message that names it.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
scene=$TULLE_SOURCE_DIR/test/e2e/scenes/small.yaml
faults=0
fault() { echo "fault: $*"; faults=1; }

# refuse FILE CODE ARGUMENTS...: exit CODE within seconds, and a message that says what FILE is.
refuse() {
    local file=$1 wanted=$2
    shift 2
    timeout -k 1 20 "$TULLE" "$@" >stdout 2>stderr </dev/null
    local code=$?
    [ $code = "$wanted" ] || fault "tulle $*: exit $code, not $wanted"
    grep -Eq "$file: .*(not a regular file|no regular file|is a directory|is a folder)" stderr || fault "tulle $*: $(cat stderr)"
}

printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' >mesh.obj
for kind in pipe device directory socket; do
    for name in odd.yaml odd.obj odd.vtp odd.pc2; do
        rm -rf $name
        case $kind in
            pipe) mkfifo $name ;;
            device) ln -s /dev/zero $name ;;
            directory) mkdir $name ;;
            socket) python3 -c 'import socket, sys; socket.socket(socket.AF_UNIX).bind(sys.argv[1])' $name ;;
        esac || fault "no $kind can be made"
    done
    refuse odd.yaml 2 run odd.yaml -o out
    refuse odd.obj 2 run "$scene" -o out --set "cloth[0].mesh={file: $work/odd.obj}"
    refuse odd.obj 2 detect odd.obj mesh.obj
    [ $kind = directory ] && continue # the other subcommands take a directory for a run
    for mesh in odd.obj odd.vtp; do
        refuse $mesh 2 convert $mesh out.ply
        refuse $mesh 2 check $mesh
    done
    for any in odd.obj odd.yaml odd.pc2; do refuse $any 2 info $any; done
    refuse odd.pc2 2 convert odd.pc2 out_%d.ply --mesh mesh.obj
    [ -e out ] && { fault "$kind: the output directory was made"; rm -rf out; }
done

# Within the directory of a run.
"$TULLE" run "$scene" -o whole --frames 2 --progress none >stdout || fault "two frames: exit $?"
for name in frames.csv report.csv sheet.pc2 sheet.obj scene.yaml checkpoint.bin; do
    rm -rf run
    cp -r whole run && rm run/$name && mkfifo run/$name
    refuse run/$name 2 run "$scene" -o run --resume --progress none
    case $name in
        frames.csv | sheet.pc2 | sheet.obj | scene.yaml) refuse run/$name 2 check run ;;
    esac
done
exit $faults
