#!/bin/sh
# Runs install_packages.sh with a PATH of stand-ins, and checks what it says and what it would have installed.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/bare" "$work/full"
for program in sh env sed cat rm touch; do ln -s "$(command -v $program)" "$work/bare/$program"; done
# Stand-ins: apt-get writes down how it was called and fails while the file `stale` is there; `update` removes that file.
cat >"$work/bare/apt-get" <<END
#!/bin/sh
echo "apt-get \$*" >>$work/calls
if [ "\$1" = update ]; then rm -f $work/stale; elif [ -e $work/stale ]; then exit 100; fi
END
printf '#!/bin/sh\ncat %s/user\n' "$work" >"$work/bare/id"
chmod +x "$work/bare/apt-get" "$work/bare/id"
cp -R "$work/bare/." "$work/full"
printf '#!/bin/sh\necho sudo >>%s/calls\nexec "$@"\n' "$work" >"$work/full/sudo"
chmod +x "$work/full/sudo"
everything="gcc libc6-dev make cmake pkg-config libyaml-dev libpng-dev libexpat1-dev zlib1g-dev libembree-dev"
faults=0

# check NAME USER PATH CODE SAID CALLS: output's first line and calls of apt-get and sudo, on one line.
check() {
    echo "$2" >"$work/user"
    : >"$work/calls"
    code=0
    PATH=$3 TULLE_NO_INSTALL=${no_install:-0} sh "$here/install_packages.sh" build >"$work/out" 2>&1 || code=$?
    said=$(sed -n 1p "$work/out")
    calls=$(tr '\n' ';' <"$work/calls")
    if [ "$code|$said|$calls" != "$4|$5|$6" ]; then
        echo "$1: exit $code, said \"$said\", calls \"$calls\""
        faults=1
    fi
}

install="apt-get install -y --no-install-recommends $everything;"
check "as root" 0 "$work/bare" 0 "missing packages: $everything" "$install"
check "as a user with sudo" 1000 "$work/full" 0 "missing packages: $everything" "sudo;$install"
check "as a user without sudo" 1000 "$work/bare" 1 "missing packages: $everything" ""
touch "$work/stale"
check "with old lists" 0 "$work/bare" 0 "missing packages: $everything" "${install}apt-get update;$install"
no_install=1
check "TULLE_NO_INSTALL" 0 "$work/bare" 1 "missing packages: $everything" ""
rm "$work/bare/apt-get"
no_install=0
check "without apt-get" 0 "$work/bare" 1 "missing packages: $everything" ""

sh "$here/install_packages.sh" nonsense >/dev/null 2>&1 && { echo "an unknown role passes"; faults=1; }
[ $faults = 0 ] && echo "install_packages.sh: all cases right"
exit $faults
