#!/bin/sh
# Checks that every subcommand and option that --help names stands in the manual page.
# usage: check_man.sh PROGRAM MANUAL
set -eu
program=$1
manual=$2
faults=0
commands=$("$program" --help | sed -n '/^subcommands:/,/^$/s/^  \([a-z]*\) .*/\1/p')
[ -n "$commands" ] || { echo "--help names no subcommand"; exit 1; }
for command in $commands; do
    grep -q "^\.B tulle $command\$" "$manual" || { echo "$manual lacks the subcommand $command"; faults=1; }
    options=$("$program" "$command" --help | sed -n 's/^  \(-[a-z], \|    \)--\([a-z-]*\).*/\2/p')
    for option in $options; do
        [ "$option" = help ] && continue
        tr -d '\\' <"$manual" | grep -q -- "--$option\b" || { echo "$manual lacks --$option of $command"; faults=1; }
    done
done
[ $faults = 0 ] && echo "manual: all of" $commands "are in it"
exit $faults
