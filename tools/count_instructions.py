#!/usr/bin/env python3
"""Counts the instructions of each benchmark, and holds them to those of benches/instructions.json.

    count_instructions.py BENCH_BINARY            a table: each case, what an element of its work takes, and the change
    count_instructions.py BENCH_BINARY --check    and exit code 1 where it takes more than 2 % more instructions
    count_instructions.py BENCH_BINARY --write    what is counted becomes what is stored
    count_instructions.py --self-test

`cargo bench --no-run` builds the binary and says where it is. --filter TEXT takes the cases whose name has TEXT in it.

Valgrind's callgrind runs each case and counts how often each instruction of its work is executed: so often on a busy machine,
too. What the instructions are, objdump says: floating-point operations are the adds, multiplications and so on of FLOPS, each
lane of a register one, whether its path is alive or not; bytes are those of operands in memory, spilled registers among
them, those that push, pop, call and ret move by themselves not. Valgrind's processor has AVX2 and FMA, and no instructions for
SHA-256: what real ones do for an image hash is less than what is counted.

Counts of another rustc are told, and not held to: it is the code of the compiler that they are counts of. The file has totals:
{"rustc": "...", "cases": {name: {"elements", "instructions", "flops", "loaded_bytes", "stored_bytes"}}}.
Needs valgrind and binutils. Exit code 2: what is needed is missing, or something does not run.
"""

import argparse
import json
import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

STORED = Path(__file__).resolve().parent.parent / "benches" / "instructions.json"

# More instructions than this, relative to what is stored, are a slowdown; so much fewer are worth storing.
TOLERANCE = 0.02

# The function that runs a case's work (benches/count.rs).
COUNTED = "*count::count_instructions*"

# What callgrind calls the file of an instruction that it finds in none: jumps from one library to another. They are counted,
# and taken to do nothing, while they are at most this part of all.
UNKNOWN = "???"
FEW = 0.001
NOTHING = (0, 0, 0)

# Programs, and the packages that have them.
NEEDED = {"valgrind": "valgrind", "objdump": "binutils", "objcopy": "binutils", "readelf": "binutils"}

# Valgrind runs side by side.
AT_A_TIME = 2

# Seconds for a case: some thirty times as many as the slowest takes.
PATIENCE = 300


class Failed(Exception):
    """What is told in one line, with exit code 2."""


# What an instruction does


# Operations of a lane.
FLOPS = {
    **dict.fromkeys(["add", "sub", "mul", "div", "sqrt", "min", "max", "addsub", "hadd", "hsub"], 1),
    **dict.fromkeys(["fmadd", "fmsub", "fnmadd", "fnmsub", "fmaddsub", "fmsubadd"], 2),
}
ARITHMETIC = re.compile(rf"v?({'|'.join(FLOPS)})(?:132|213|231)?([ps])([sd])")
LANE = {"s": 4, "d": 8}
REGISTER = {"x": 16, "y": 32, "z": 64}

OPERAND = {"BYTE": 1, "WORD": 2, "DWORD": 4, "FWORD": 6, "QWORD": 8, "TBYTE": 10, "XMMWORD": 16, "YMMWORD": 32, "ZMMWORD": 64}
IN_MEMORY = re.compile(rf"\b({'|'.join(OPERAND)}) PTR ")
VECTOR = re.compile(r"\b([xyz])mm\d")
PREFIXES = {"lock", "rep", "repz", "repnz", "notrack", "bnd", "data16", "cs", "ds", "es"}

# With a first operand in memory: those that do not touch it, those that only read it, those that only write it. All others
# do both.
UNTOUCHED = re.compile(r"lea|nop|prefetch|clflush|clwb|invlpg")
ONLY_READ = re.compile(r"cmp(?!xchg)|test|bt$|push|call|jmp|i?mul|i?div|f(ld|ild|add|sub|mul|div|com)|v?ldmxcsr|scas|lods")
ONLY_WRITTEN = re.compile(r"v?p?mov|vp?maskmov|v?p?extr|set|v?stmxcsr|stos|f(n?st|ist)|pop|vcvtps2ph")


def effect(text):
    """Floating-point operations, bytes loaded and bytes stored by an instruction in Intel's syntax."""
    mnemonic, _, operands = text.partition(" ")
    while mnemonic in PREFIXES:
        mnemonic, _, operands = operands.strip().partition(" ")
    operands = re.sub(r"[#<].*", "", operands).strip()

    flops = 0
    if arithmetic := ARITHMETIC.fullmatch(mnemonic):
        operation, packed, kind = arithmetic.groups()
        widest = max((REGISTER[name] for name in VECTOR.findall(operands)), default=16)
        flops = FLOPS[operation] * (widest // LANE[kind] if packed == "p" else 1)

    loaded = stored = 0
    if not UNTOUCHED.match(mnemonic):
        for place, operand in enumerate(split(operands)):
            if not (size := IN_MEMORY.match(operand)):
                continue
            size = OPERAND[size[1]]
            if "gather" in mnemonic:
                # The operand is that of one lane.
                size = REGISTER[VECTOR.search(operands)[1]]
            first = place == 0
            if not first or not ONLY_WRITTEN.match(mnemonic):
                loaded += size
            if first and not ONLY_READ.match(mnemonic):
                stored += size
    return flops, loaded, stored


def split(operands):
    """At the commas; those of addresses are none in Intel's syntax."""
    return [operand.strip() for operand in operands.split(",")] if operands else []


# What the programs say


def executions(text):
    """How often each instruction was executed, by (object, address), from what callgrind writes."""
    counts, thing, is_call, total = Counter(), "", False, None
    for line in text.splitlines():
        if line.startswith("0x"):
            # The line after a call is what the called function took, which is counted there.
            if not is_call:
                address, count = line.split()
                counts[thing, int(address, 16)] += int(count)
            is_call = False
        elif line.startswith("ob="):
            thing = line[3:]
        elif line.startswith("calls="):
            is_call = True
        elif line.startswith("totals:"):
            total = int(line.split()[1])
    if total is None or total != sum(counts.values()):
        raise Failed(f"callgrind's file has {sum(counts.values())} instructions, and says that it has {total}")
    return counts


def instructions(lines, addresses):
    """The instructions at these addresses, from what objdump writes."""
    found = {}
    for line in lines:
        address, colon, text = line.partition(":\t")
        if colon and (address := int(address, 16)) in addresses:
            found[address] = text.strip()
    return found


def run(*command, **options):
    """A program's output."""
    done = subprocess.run(command, capture_output=True, text=True, **options)
    if done.returncode:
        why = " ".join((done.stderr or done.stdout).split())
        raise Failed(f"{' '.join(map(str, command))}: exit code {done.returncode}: {why or 'no word'}")
    return done.stdout


def rustc_of(program):
    """The compiler that made it, as it has written into it."""
    made_by = re.search(r"rustc version (.+)", run("readelf", "--string-dump=.comment", program))
    if not made_by:
        raise Failed(f"{program}: no word of the rustc that made it; name what `cargo bench --no-run` built")
    return f"rustc {made_by[1].strip()}"


def count(program, name, folder):
    """Elements of a case's work, and its executions."""
    out = folder / f"{re.sub(r'[^a-z0-9]+', '-', name)}.callgrind"
    said = run(
        *["valgrind", "--tool=callgrind", "--quiet", "--collect-atstart=no", f"--toggle-collect={COUNTED}"],
        *["--dump-instr=yes", "--dump-line=no", "--compress-strings=no", "--compress-pos=no", f"--callgrind-out-file={out}"],
        *[program, "--count", name],
        # The same surroundings everywhere: addresses decide how a copy begins.
        cwd=folder,
        env={"PATH": "/usr/bin:/bin", "TMPDIR": str(folder)},
        timeout=PATIENCE,
    )
    elements = re.search(r"^elements (\d+)$", said, re.MULTILINE)
    executed = executions(out.read_text())
    out.unlink()
    if not elements or not executed:
        raise Failed(f"{name}: nothing was counted; is count_instructions of benches/count.rs still there?")
    return int(elements[1]), executed


def measure(program, only):
    """What each case takes, by name."""
    with tempfile.TemporaryDirectory(prefix="count") as folder:
        folder = Path(folder)
        copy = folder / "benches"
        # Valgrind reads what there is to debug each time.
        run("objcopy", "--strip-debug", program, copy)
        names = [name for name in run(copy, "--count", "--list").split() if only in name]
        with ThreadPoolExecutor(AT_A_TIME) as pool:
            counted = dict(zip(names, pool.map(lambda name: count(copy, name, folder), names)))
        return summed(counted)


def summed(counted):
    """Executions become sums of what they do."""
    places = {}
    for _, executed in counted.values():
        for thing, address in executed:
            places.setdefault(thing, set()).add(address)
    effects = {}
    for thing, addresses in places.items():
        if thing == UNKNOWN:
            effects.update(((thing, address), NOTHING) for address in addresses)
            continue
        listing = run("objdump", "--disassemble", "--disassembler-options=intel", "--no-show-raw-insn", thing)
        texts = instructions(listing.splitlines(), addresses)
        if missing := addresses - texts.keys():
            raise Failed(f"{thing}: callgrind has an instruction at {min(missing):#x}, and objdump has none there")
        effects.update(((thing, address), effect(text)) for address, text in texts.items())
    return {name: sums(elements, executed, effects) for name, (elements, executed) in counted.items()}


def sums(elements, executed, effects):
    unknown = sum(times for (thing, _), times in executed.items() if thing == UNKNOWN)
    if unknown > FEW * executed.total():
        raise Failed(f"callgrind does not know where {unknown} of {executed.total()} instructions are from")
    flops, loaded, stored = (
        sum(times * effects[place][what] for place, times in executed.items()) for what in range(3)
    )
    return {
        "elements": elements,
        "instructions": executed.total(),
        "flops": flops,
        "loaded_bytes": loaded,
        "stored_bytes": stored,
    }


# What is stored


def read():
    if not STORED.exists():
        return {"rustc": None, "cases": {}}
    try:
        stored = json.loads(STORED.read_text())
        stored["rustc"], [case["instructions"] / case["elements"] for case in stored["cases"].values()]
    except (ValueError, KeyError, TypeError, ZeroDivisionError) as error:
        raise Failed(f"{STORED} is not what --write writes: {error!r}") from error
    return stored


def write(rustc, measured, only):
    stored = read()
    if only and rustc != stored["rustc"]:
        raise Failed(f"what is stored was counted with {stored['rustc']}, not {rustc}: --write without --filter")
    cases = {**stored["cases"], **measured} if only else measured
    STORED.write_text(json.dumps({"rustc": rustc, "cases": dict(sorted(cases.items()))}, indent=2) + "\n")
    print(f"{len(measured)} cases written to {STORED}")


def change(now, before):
    """Of the instructions of an element, relative."""
    return now["instructions"] / now["elements"] / (before["instructions"] / before["elements"]) - 1


def table(measured, stored):
    print(f"{'':38} {'elements':>8} {'instructions':>12} {'change':>8} {'flops':>9} {'loaded':>9} {'stored':>9}")
    for name, case in measured.items():
        changed = f"{100 * change(case, stored[name]):+.2f} %" if name in stored else "new"
        instructions, flops, loaded, written = (
            f"{case[key] / case['elements']:.1f}" for key in ("instructions", "flops", "loaded_bytes", "stored_bytes")
        )
        print(f"{name:38} {case['elements']:8} {instructions:>12} {changed:>8} {flops:>9} {loaded:>9} {written:>9}")
    print("instructions, floating-point operations, bytes: of one element; the change is that of the instructions")


def verdict(measured, stored, comparable):
    """What is wrong, and what is worth storing, a line each."""
    wrong = [f"{name} is not in {STORED.name}" for name in measured if name not in stored]
    wrong += [f"{name} is in {STORED.name}, and no case" for name in stored if name not in measured]
    better = []
    for name in measured if comparable else []:
        if name not in stored:
            continue
        changed = change(measured[name], stored[name])
        if changed > TOLERANCE:
            wrong.append(f"{name} takes {100 * changed:.2f} % more instructions")
        elif changed < -TOLERANCE:
            better.append(f"{name} takes {-100 * changed:.2f} % fewer instructions")
    return wrong, better


def check(rustc, measured, stored):
    comparable = stored["rustc"] in (rustc, None)
    wrong, better = verdict(measured, stored["cases"], comparable)
    if not comparable:
        print(f"counted with {rustc}, stored with {stored['rustc']}: counts of two compilers are not compared")
    for line in better:
        print(f"better: {line}")
    for line in wrong:
        print(f"WRONG: {line}")
    if wrong or better:
        print("where that is meant, --write in place of --check stores what was counted")
    return 1 if wrong else 0


# The tool itself

CALLGRIND = """\
version: 1
positions: instr
events: Ir

ob=/bin/one
fn=count_instructions
0x1000 8
0x1004 8
cob=/lib/two
cfn=memcpy
calls=8 0x20
0x1008 24
fn=again
0x1008 16

ob=/lib/two
fn=memcpy
0x20 24
totals: 56
"""

OBJDUMP = """\
/bin/one:     file format elf64-x86-64

0000000000001000 <count_instructions>:
    1000:\tvfmadd231ps ymm0,ymm1,YMMWORD PTR [rdi+rax*4+0x20]
    1004:\tcall   20 <memcpy>
    1008:\tvmovups YMMWORD PTR [rsp+0x40],ymm0
    1010:\tret
"""

EFFECTS = {
    "vaddps ymm0,ymm1,ymm2": (8, 0, 0),
    "vsubps xmm0,xmm1,xmm2": (4, 0, 0),
    "vmulsd xmm0,xmm1,QWORD PTR [rip+0x10]        # 1234 <x>": (1, 8, 0),
    "vdivpd ymm0,ymm1,ymm2": (4, 0, 0),
    "vsqrtss xmm0,xmm1,xmm2": (1, 0, 0),
    "vfnmadd213ss xmm0,xmm1,DWORD PTR [rax]": (2, 4, 0),
    "vfmaddsub132pd ymm0,ymm1,ymm2": (8, 0, 0),
    "vminps ymm0,ymm1,YMMWORD PTR [rsi]": (8, 32, 0),
    "vpminud ymm0,ymm1,ymm2": (0, 0, 0),
    "vcmpltps ymm0,ymm1,ymm2": (0, 0, 0),
    "vcvtdq2ps ymm0,ymm1": (0, 0, 0),
    "vbroadcastss ymm0,DWORD PTR [rax]": (0, 4, 0),
    "vgatherdps ymm0,DWORD PTR [rax+ymm1*4],ymm2": (0, 32, 0),
    "vmaskmovps YMMWORD PTR [rax],ymm0,ymm1": (0, 0, 32),
    "vextractf128 XMMWORD PTR [rax],ymm0,0x1": (0, 0, 16),
    "vpextrd DWORD PTR [rax],xmm0,0x1": (0, 0, 4),
    "add    DWORD PTR [rax],0x1": (0, 4, 4),
    "lock cmpxchg QWORD PTR [rdx],rcx": (0, 8, 8),
    "cmp    BYTE PTR [rax],0x0": (0, 1, 0),
    "mov    WORD PTR [rax],cx": (0, 0, 2),
    "movzx  eax,BYTE PTR [rdi]": (0, 1, 0),
    "call   QWORD PTR [rax+0x18]": (0, 8, 0),
    "rep movs BYTE PTR es:[rdi],BYTE PTR ds:[rsi]": (0, 1, 1),
    "rep stos QWORD PTR es:[rdi],rax": (0, 0, 8),
    "lea    rax,[rdi+rsi*8]": (0, 0, 0),
    "nop    WORD PTR cs:[rax+rax*1+0x0]": (0, 0, 0),
    "push   rbp": (0, 0, 0),
    "prefetcht0 BYTE PTR [rax]": (0, 0, 0),
}


def self_test():
    """Small texts whose numbers are known, and verdicts on made-up counts."""
    for text, want in EFFECTS.items():
        assert effect(text) == want, (text, effect(text), want)

    executed = executions(CALLGRIND)
    assert executed == {("/bin/one", 0x1000): 8, ("/bin/one", 0x1004): 8, ("/bin/one", 0x1008): 16, ("/lib/two", 0x20): 24}
    try:
        executions(CALLGRIND.replace("totals: 56", "totals: 57"))
    except Failed:
        pass
    else:
        raise AssertionError("a file of which a part is missing is read")

    texts = instructions(OBJDUMP.splitlines(), {0x1000, 0x1004, 0x1008})
    assert texts.keys() == {0x1000, 0x1004, 0x1008}
    effects = {("/bin/one", address): effect(text) for address, text in texts.items()}
    effects["/lib/two", 0x20] = effect("rep movs BYTE PTR es:[rdi],BYTE PTR ds:[rsi]")
    counts = sums(8, executed, effects)
    want = {"elements": 8, "instructions": 56, "flops": 128, "loaded_bytes": 280, "stored_bytes": 536}
    assert counts == want, counts

    def case(instructions, elements=8):
        return {**counts, "elements": elements, "instructions": instructions}

    stored = {"slower": case(1000), "same": case(1000), "faster": case(1000), "gone": case(1000)}
    measured = {"slower": case(1021), "same": case(2038, 16), "faster": case(979), "new": case(1000)}
    wrong, better = verdict(measured, stored, comparable=True)
    assert [line.split()[0] for line in wrong] == ["new", "gone", "slower"], wrong
    assert [line.split()[0] for line in better] == ["faster"], better
    wrong, better = verdict(measured, stored, comparable=False)
    assert [line.split()[0] for line in wrong] == ["new", "gone"] and not better, (wrong, better)
    print("count_instructions: the self-test passes")
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", nargs="?", type=Path, metavar="BENCH_BINARY", help="what `cargo bench --no-run` built")
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--check", action="store_true", help="exit with 1 where a case takes more instructions than stored")
    what.add_argument("--write", action="store_true", help=f"store the counts in {STORED.name}")
    what.add_argument("--self-test", action="store_true", help="check the arithmetic, run nothing")
    parser.add_argument("--filter", default="", metavar="TEXT", help="only the cases whose name has this in it")
    options = parser.parse_args()
    if options.self_test:
        return self_test()
    if not options.program:
        parser.error("name the binary that `cargo bench --no-run` builds")
    try:
        for needed, package in NEEDED.items():
            if not shutil.which(needed):
                raise Failed(f"{needed} is missing: install {package}")
        stored = read()
        stored["cases"] = {name: case for name, case in stored["cases"].items() if options.filter in name}
        rustc = rustc_of(options.program)
        measured = measure(options.program, options.filter)
        if not measured:
            raise Failed(f"no case has {options.filter!r} in its name")
        table(measured, stored["cases"])
        if options.write:
            write(rustc, measured, options.filter)
        return check(rustc, measured, stored) if options.check else 0
    except (Failed, OSError, subprocess.TimeoutExpired) as error:
        print(f"count_instructions: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
