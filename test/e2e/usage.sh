#!/usr/bin/env bash
# The program's own face: help, version, unknown words, output that cannot be written.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
faults=0

# expect CODE PATTERN ARGUMENTS...: exit code, and a line of either output.
expect() {
    local code=$1 pattern=$2
    shift 2
    "$TULLE" "$@" >"$work/out" 2>&1 </dev/null
    local found=$?
    if [ $found != "$code" ]; then
        echo "tulle $*: exit $found, expected $code"
        faults=1
    fi
    grep -q -- "$pattern" "$work/out" || { echo "tulle $*: no \"$pattern\" in:"; cat "$work/out"; faults=1; }
}

version=$(sed -n 's/^#define TULLE_VERSION_[A-Z]* //p' "$TULLE_SOURCE_DIR/include/tulle/base.h" | paste -sd.)
expect 0 "^tulle $version\$" --version
expect 0 "^usage: tulle SUBCOMMAND" --help
expect 0 "^usage: tulle SUBCOMMAND" help
expect 2 "^usage: tulle SUBCOMMAND"
expect 2 "unknown option \"--vresion\"; did you mean \"--version\"?" --vresion
expect 2 "unknown subcommand \"xyzzy\"" xyzzy
for command in $("$TULLE" --help | sed -n '/^subcommands:/,/^$/s/^  \([a-z]*\) .*/\1/p'); do
    expect 0 "^usage: tulle $command " "$command" --help
    expect 2 "is missing; usage: tulle $command" "$command"
    expect 2 "unknown option --xyzzy" "$command" --xyzzy
    expect 2 "did you mean --help" "$command" --hepl
    expect 2 "unknown subcommand \"x$command\"; did you mean \"$command\"" "x$command"
    "$TULLE" "$command" --help >/dev/full 2>"$work/out"
    [ $? = 3 ] || { echo "tulle $command --help onto a full disk: no exit 3"; faults=1; }
done
"$TULLE" --help 2>&1 >/dev/null | grep -q . && { echo "tulle --help writes to standard error"; faults=1; }
exit $faults
