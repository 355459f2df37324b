#!/bin/sh
# Installs the Debian packages that a build or the tests need and that are missing; does nothing when all is there.
# usage: install_packages.sh ROLE...      ROLE: build, test, paper, python, viewer, wheel, python-test, notebook-test, view, view-test, bench, peers, mutate,
#                                 clang, ubsan, msan, fuzz, musl, m32, portability, docs, formats, slurm, blender
#   TULLE_NO_INSTALL=1   only says what is missing; fails if it cannot be done without
set -eu

# What each role needs: package, how to see that it is there, and whether it can be done without. Things are looked for
# rather than packages, so what was installed by other ways counts.
needs() {
    case $1 in
    build)
        echo "gcc            program:cc          needed"
        echo "libc6-dev      header:stdlib.h     needed"
        echo "make           program:make        needed"
        echo "cmake          program:cmake       needed"
        echo "pkg-config     program:pkg-config  needed"
        echo "libyaml-dev    header:yaml.h       needed"
        echo "libpng-dev     header:png.h        needed"
        echo "libexpat1-dev  header:expat.h      needed"
        echo "zlib1g-dev     header:zlib.h       needed"
        echo "libembree-dev  header:embree3/rtcore.h optional"
        ;;
    test)
        echo "libcmocka-dev  cmocka              needed"
        echo "libgmp-dev     header:gmp.h        needed"
        echo "g++            program:c++         optional"
        echo "libcgal-dev    cgal                optional"
        echo "clang-format   program:clang-format optional"
        echo "python3        program:python3     optional"
        echo "ffmpeg         program:ffmpeg      optional"
        echo "python3-numpy  python:numpy        optional"
        echo "python3-matplotlib python:matplotlib optional"
        echo "python3-cffi   python:cffi,numpy   optional"
        ;;
    paper)
        echo "python3        program:python3     needed"
        echo "python3-numpy  python:numpy        needed"
        echo "python3-cffi   python:cffi,numpy   needed"
        echo "python3-matplotlib python:matplotlib needed"
        echo "ffmpeg         program:ffmpeg      optional"
        ;;
    python)
        echo "python3        program:python3     needed"
        echo "python3-cffi   python:cffi,numpy   needed"
        echo "python3-numpy  python:cffi,numpy   needed"
        echo "python3-tqdm   python:cffi,numpy,tqdm optional"
        echo "python3-yaml   python:cffi,numpy,yaml optional"
        ;;
    viewer)
        echo "nodejs         program:node        optional"
        echo "npm            program:npm         optional"
        ;;
    wheel)
        echo "python3-build  python:cffi,numpy,build.__main__ needed"
        echo "python3-setuptools python:cffi,numpy,setuptools needed"
        echo "python3-wheel  python:cffi,numpy,wheel needed"
        echo "python3-venv   python:cffi,numpy,ensurepip needed"
        ;;
    python-test)
        echo "python3-pytest python:cffi,numpy,pytest needed"
        echo "python3-hypothesis python:cffi,numpy,hypothesis needed"
        echo "python3-matplotlib python:cffi,numpy,matplotlib optional"
        echo "python3-nbformat python:cffi,numpy,nbformat optional"
        echo "python3-nbclient python:cffi,numpy,nbclient optional"
        echo "python3-ipykernel python:cffi,numpy,ipykernel optional"
        echo "mypy           program:mypy        needed"
        ;;
    notebook-test)
        echo "nodejs         program:node        needed"
        echo "npm            program:npm         needed"
        echo "chromium       program:chromium    needed"
        echo "python3-nbconvert python:cffi,numpy,nbconvert optional"
        ;;
    view)
        echo "libwebsockets-dev package:libwebsockets needed"
        echo "nodejs         program:node        needed"
        echo "npm            program:npm         needed"
        ;;
    view-test)
        echo "python3        program:python3     needed"
        echo "nodejs         program:node        needed"
        echo "npm            program:npm         needed"
        echo "chromium       program:chromium    needed"
        ;;
    bench)
        echo "valgrind       program:valgrind    optional"
        ;;
    peers)
        echo "python3        program:python3     needed"
        echo "blender        program:blender     optional"
        echo "g++            program:c++         optional"
        echo "libbullet-dev  package:bullet      optional"
        echo "nodejs         program:node        optional"
        echo "npm            program:npm         optional"
        ;;
    mutate)
        echo "python3        program:python3     needed"
        echo "git            program:git         needed"
        echo "ninja-build    program:ninja       optional"
        echo "ccache         program:ccache      optional"
        echo "lld            program:ld.lld      optional"
        ;;
    clang)
        echo "clang          program:clang       needed"
        ;;
    ubsan | msan)
        echo "clang          program:clang       needed"
        echo "libclang-rt-dev fuzzer             needed"
        ;;
    fuzz)
        echo "clang          program:clang       needed"
        echo "libclang-rt-dev fuzzer             needed"
        echo "afl++          program:afl-clang-fast optional"
        ;;
    musl)
        echo "musl-tools     program:musl-gcc    optional"
        ;;
    m32)
        echo "gcc-i686-linux-gnu program:i686-linux-gnu-gcc optional"
        echo "libc6-dev-i386-cross file:/usr/i686-linux-gnu/include/stdlib.h optional"
        echo "qemu-user      program:qemu-i386 optional"
        ;;
    portability)
        echo "gcc-aarch64-linux-gnu program:aarch64-linux-gnu-gcc optional"
        echo "libc6-dev-arm64-cross file:/usr/aarch64-linux-gnu/include/stdlib.h optional"
        echo "qemu-user      program:qemu-aarch64 optional"
        echo "binutils       program:objdump     optional"
        ;;
    blender)
        echo "blender        program:blender     optional"
        echo "python3-numpy  python:numpy        optional"
        echo "xvfb           program:xvfb-run    optional"
        echo "xauth          program:xauth       optional"
        ;;
    docs)
        echo "python3        program:python3     needed"
        echo "mkdocs         program:mkdocs      needed"
        echo "mkdocs-material file:/usr/share/mkdocs/themes/material/mkdocs_theme.yml needed"
        echo "doxygen        program:doxygen     needed"
        echo "python3-cffi   python:cffi         needed"
        echo "gcc            program:cc          needed"
        ;;
    formats)
        echo "nodejs         program:node        optional"
        echo "npm            program:npm         optional"
        echo "blender        program:blender     optional"
        ;;
    slurm)
        echo "python3        program:python3     needed"
        echo "python3-yaml   python:yaml         needed"
        echo "python3-numpy  python:numpy        needed"
        echo "python3-pytest python:pytest       needed"
        echo "python3-distributed python:distributed optional"
        echo "munge          file:/usr/sbin/munged optional"
        echo "slurm-wlm      program:sbatch      optional"
        ;;
    *)
        echo "install_packages.sh: unknown role \"$1\"; the roles are build, test, paper, python, viewer, wheel, python-test, notebook-test, view, view-test, bench, peers, mutate, clang, ubsan, msan, fuzz, musl, m32, portability, docs, formats, slurm and blender" >&2
        exit 2
        ;;
    esac
}

compiles() { command -v cc >/dev/null && printf '%s\n' "$1" | cc -x c -fsyntax-only - 2>/dev/null; }

is_there() { # PROBE
    case $1 in
    program:*) command -v "${1#program:}" >/dev/null ;;
    file:*) [ -e "${1#file:}" ] ;;
    python:*) sh "${0%/*}/../paper/find_python.sh" "${1#python:}" >/dev/null ;;
    package:*) command -v pkg-config >/dev/null && pkg-config --exists "${1#package:}" ;;
    header:*) compiles "#include <${1#header:}>" ;;
    cmocka) compiles "#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>" ;;
    fuzzer) command -v clang >/dev/null && [ -e "$(clang -print-file-name="libclang_rt.fuzzer-$(uname -m).a")" ] ;;
    cgal) [ -e /usr/include/CGAL/version.h ] || [ -e /usr/local/include/CGAL/version.h ] ;;
    esac
}

missing="" needed=""
for role in "$@"; do
    list=$(needs "$role")
    while read -r package probe weight; do
        is_there "$probe" && continue
        missing="$missing $package"
        [ "$weight" = optional ] || needed="$needed $package"
    done <<END
$list
END
done
[ -n "$missing" ] || exit 0

echo "missing packages:$missing"
if [ "${TULLE_NO_INSTALL:-0}" = 1 ]; then
    [ -n "$needed" ] || exit 0
    echo "install them: apt-get install$needed" >&2
    exit 1
fi
if ! command -v apt-get >/dev/null; then
    echo "there is no apt-get here: install what these Debian packages hold by other ways" >&2
    [ -z "$needed" ] && exit 0
    exit 1
fi
as_root=""
if [ "$(id -u)" != 0 ]; then
    as_root=sudo
    command -v sudo >/dev/null || { echo "not root and no sudo: run as root: apt-get install$missing" >&2; exit 1; }
fi
install_missing() {
    # shellcheck disable=SC2086
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends $missing
}
echo "installing them with apt-get"
# The package lists may be missing or old; then they are fetched, and the packages asked for again.
install_missing >/dev/null 2>&1 || { $as_root apt-get update && install_missing; }
