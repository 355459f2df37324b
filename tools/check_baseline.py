#!/usr/bin/env python3
"""Checks that code which runs on every x86-64 processor has no instruction of newer ones (SSE3 and later, AVX, BMI ...), and
that none joins a product and a sum, which rounds once for twice.

usage: check_baseline.py [--fused] BUILD_DIR    reads the object files of library and program; prints each function that breaks
                                      the rule as FILE: FUNCTION: INSTRUCTION; exit 1 if there is one, 77 if nothing
                                      can be judged: another processor family, or no objdump
       check_baseline.py --self-test  proves that breaches are found

The objects of tulle_kernels_avx2 and tulle_kernels_avx512, and the clones that gcc makes for wider vectors, may have newer
instructions: these run only where the processor has what they need (math/kernel_target.c). With --fused all may have them, as
in a build with -march=native.
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
WIDE_TARGETS = ["tulle_kernels_avx2", "tulle_kernels_avx512"]
FUSED = re.compile(r"vfn?m(add|sub)\w*")
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


def judge_lines(lines, rule):
    """Function and instruction of each function that has one of the rule; the first of each function."""
    function, told = "", set()
    for line in lines:
        found = FUNCTION.match(line)
        if found:
            function = found.group(1)
            continue
        found = INSTRUCTION.match(line)
        if not found or function in told or CLONE.search(function) or not rule.fullmatch(found.group(1)):
            continue
        told.add(function)
        yield function, found.group(1)


def judge_object(path, rule=NEWER):
    listing = subprocess.run(["objdump", "-d", "--no-show-raw-insn", path], capture_output=True, text=True, check=True)
    return judge_lines(listing.stdout.splitlines(), rule)


def find_objects(build, targets):
    for target in targets:
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
    __attribute__((target("fma"))) double join(double x, double y, double z) { return __builtin_fma(x, y, z); }
    __attribute__((target("bmi2"))) unsigned long shift(unsigned long x, int n) { return x << n; }
    __attribute__((target_clones("default", "avx2"))) void scale(double *x) { for (int i = 0; i < 64; i++) x[i] *= 2.0; }
    """
    with tempfile.TemporaryDirectory() as folder:
        source, made = os.path.join(folder, "some.c"), os.path.join(folder, "some.o")
        with open(source, "w") as stream:
            stream.write(code)
        subprocess.run([compiler, "-O3", "-c", source, "-o", made], check=True)
        found = [sorted(function for function, _ in judge_object(made, rule)) for rule in (NEWER, FUSED)]
    wanted = [["add", "count_bits", "join", "shift", "turn"], ["join"]]
    print(f"found {found}, wanted {wanted}")
    return 0 if found == wanted else 1


def main():
    if platform.machine() not in ("x86_64", "AMD64") or not shutil.which("objdump"):
        print("skipped: needs an x86-64 machine and objdump")
        return 77
    if sys.argv[1:] == ["--self-test"]:
        return self_test()
    build, is_plain = sys.argv[-1], len(sys.argv) == 2
    if not is_plain and (len(sys.argv) != 3 or sys.argv[1] != "--fused"):
        print(__doc__)
        return 2
    objects = [(path, NEWER if is_plain else FUSED) for path in find_objects(build, TARGETS)]
    objects += [(path, FUSED) for path in find_objects(build, WIDE_TARGETS)]
    if not objects:
        print(f"{build}: no object files; build first")
        return 2
    breaches = 0
    for path, rule in objects:
        for function, instruction in judge_object(path, rule):
            print(f"{os.path.relpath(path, build)}: {function}: {instruction}")
            breaches += 1
    print(f"baseline: {len(objects)} objects, {breaches} functions with instructions of newer processors, or fused ones")
    return 1 if breaches else 0


if __name__ == "__main__":
    sys.exit(main())
