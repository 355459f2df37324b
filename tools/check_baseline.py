#!/usr/bin/env python3
"""Checks that code which runs on every x86-64 processor has no instruction of newer ones (SSE3 and later, AVX, BMI ...).

usage: check_baseline.py BUILD_DIR    reads the object files of library and program; prints each function that breaks
                                      the rule as FILE: FUNCTION: INSTRUCTION; exit 1 if there is one, 77 if nothing
                                      can be judged: another processor family, or no objdump
       check_baseline.py --self-test  proves that breaches are found

Left out are the objects of tulle_kernels_avx2 and tulle_kernels_avx512, and the clones that gcc makes for wider
vectors: these run only where the processor has what they need (math/kernel_target.c).
"""
import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile

TARGETS = ["tulle_common", "tulle_engine", "tulle_kernels_base", "tulle_io_parts", "tulle_render", "tulle_app",
           "tulle_program"]
CLONE = re.compile(r"\.(avx\w*|fma|bmi2?|arch_x86_64_v\d)(\.\w+)*$")
FUNCTION = re.compile(r"^[0-9a-f]+ <(.+)>:$")
INSTRUCTION = re.compile(r"^\s+[0-9a-f]+:\t(?:(?:rep|repz|repnz|lock|bnd|notrack|data16|cs|ds|rex\.?\w*) )*([a-z][a-z0-9]*)")

# tzcnt is left out: gcc writes bsf with a prefix that older processors ignore, where both give the same.
NEWER = re.compile(
    r"v(?!err|erw|mcall).*|k(add|and|andn|mov|not|or|ortest|shiftl|shiftr|test|unpck\w+|xnor|xor)[bwdq]|"
    r"addsubp[sd]|haddp[sd]|hsubp[sd]|lddqu|mov(d|sh|sl)dup|fisttp\w*|monitor|mwait|"
    r"pshufb|palignr|pabs[bwd]|ph(add|sub)(w|d|sw)|pmaddubsw|pmulhrsw|psign[bwd]|"
    r"blendv?p[sd]|pblendvb|pblendw|dpp[sd]|extractps|insertps|mpsadbw|packusdw|pcmp(eq|gt)q|pextr[bdq]|pinsr[bdq]|"
    r"phminposuw|p(max|min)(sb|sd|ud|uw)|pmov[sz]x\w+|pmuldq|pmulld|ptest|round[ps][sd]|movntdqa|crc32\w?|pcmp[ei]str[im]|"
    r"popcnt\w?|lzcnt\w?|andn|bextr|bls(i|msk|r)|bzhi|mulx|pdep|pext|rorx|sarx|shlx|shrx|ad[co]x|movbe\w?|"
    r"aes\w+|pclmul\w+|sha(1|256)\w+|gf2p8\w+|rdrand|rdseed|xsave\w*|xrstor\w*|cmpxchg16b")


def judge_lines(lines):
    """Function and instruction of each function that has a newer one; the first of each function."""
    function, told = "", set()
    for line in lines:
        found = FUNCTION.match(line)
        if found:
            function = found.group(1)
            continue
        found = INSTRUCTION.match(line)
        if not found or function in told or CLONE.search(function) or not NEWER.fullmatch(found.group(1)):
            continue
        told.add(function)
        yield function, found.group(1)


def judge_object(path):
    listing = subprocess.run(["objdump", "-d", "--no-show-raw-insn", path], capture_output=True, text=True, check=True)
    return judge_lines(listing.stdout.splitlines())


def find_objects(build):
    for target in TARGETS:
        for folder, _, names in os.walk(os.path.join(build, "CMakeFiles", target + ".dir")):
            for name in sorted(names):
                if name.endswith(".o"):
                    yield os.path.join(folder, name)


def self_test():
    compiler = shutil.which("cc")
    if not compiler:
        print("skipped: no compiler")
        return 77
    code = """
    int count_plain(const unsigned *x) { int sum = 0; for (int i = 0; i < 64; i++) sum += (int)(x[i] & 1u); return sum; }
    __attribute__((target("popcnt"))) int count_bits(unsigned x) { return __builtin_popcount(x); }
    __attribute__((target("ssse3"))) void turn(int *x) { for (int i = 0; i < 64; i++) x[i] = x[i] < 0 ? -x[i] : x[i]; }
    __attribute__((target("avx"))) void add(double *x) { for (int i = 0; i < 64; i++) x[i] += 1.0; }
    __attribute__((target("bmi2"))) unsigned long shift(unsigned long x, int n) { return x << n; }
    __attribute__((target_clones("default", "avx2"))) void scale(double *x) { for (int i = 0; i < 64; i++) x[i] *= 2.0; }
    """
    with tempfile.TemporaryDirectory() as folder:
        source, made = os.path.join(folder, "some.c"), os.path.join(folder, "some.o")
        with open(source, "w") as stream:
            stream.write(code)
        subprocess.run([compiler, "-O3", "-c", source, "-o", made], check=True)
        found = sorted(function for function, _ in judge_object(made))
    wanted = ["add", "count_bits", "shift", "turn"]
    print(f"found {found}, wanted {wanted}")
    return 0 if found == wanted else 1


def main():
    if platform.machine() not in ("x86_64", "AMD64") or not shutil.which("objdump"):
        print("skipped: needs an x86-64 machine and objdump")
        return 77
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    if len(sys.argv) != 2:
        print(__doc__)
        return 2
    objects, breaches = list(find_objects(sys.argv[1])), 0
    if not objects:
        print(f"{sys.argv[1]}: no object files; build first")
        return 2
    for path in objects:
        for function, instruction in judge_object(path):
            print(f"{os.path.relpath(path, sys.argv[1])}: {function}: {instruction}")
            breaches += 1
    print(f"baseline: {len(objects)} objects, {breaches} functions with instructions of newer processors")
    return 1 if breaches else 0


if __name__ == "__main__":
    sys.exit(main())
