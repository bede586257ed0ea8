#!/usr/bin/env python3
"""Measures Ondine beside its peers, and all that it was asked to reach, in one run on one machine; writes docs/performance.md.

    performance.py --lab SCRIPTS --work SCRATCH [--ondine PROGRAM] [--only rays,images,sh,promises] [--rounds N] [--threads N]
                   [--quick] [--out docs/performance.json]
    performance.py --page [--out docs/performance.json]       the page again, from figures that are there
    performance.py --self-test

SCRIPTS holds the drivers of the peers (rays/, renderers/), SCRATCH what they built, with meshes, rays and scenes: Embree,
Mitsuba and sphericart. The page is tools/performance.template.md with the tables filled in, beside the raw figures. What is
timed is timed by turns with its peer, in rounds. A section that fails is "not measured", with the reason; the others go on.
`promises` stands for batch, merge, compare, dump, growth, memory and view, which can be named one by one.

Measure on a quiet machine: a quarter of an hour on two cores; --quick tries everything small in a few minutes. Needs the packages
numpy and OpenEXR, and for `view` Node and Chromium. Exit code 1: a section was not measured; 2: bad usage.
"""

import argparse
import json
import os
import platform
import re
import sys
import tempfile
import time
from fractions import Fraction
from pathlib import Path

from performance_page import number, page, shown
from performance_sections import MEASURES, PEERS, PROMISES, Failed, Run, fast_variants, json_lines, launch, legendre_moment, promise, ratio, spread

ROOT = Path(__file__).resolve().parent.parent


def first_line(*command):
    try:
        return launch(*command).printed.strip().splitlines()[0]
    except (Failed, IndexError):
        return "unknown"


def described(path, pattern, absent="unknown"):
    """What a file of the system says, by a pattern with one group."""
    try:
        found = re.search(pattern, Path(path).read_text(), re.M)
    except OSError:
        found = None
    return found[1].strip() if found else absent


def machine():
    """What the figures were taken on."""
    caches = []
    for index in sorted(Path("/sys/devices/system/cpu/cpu0/cache").glob("index*")):
        level, kind, size = ((index / name).read_text().strip() for name in ("level", "type", "size"))
        caches.append(f"L{level} {kind.lower()} {size}")
    kilobytes = int(described("/proc/meminfo", r"^MemTotal:\s*(\d+) kB", "0"))
    told = {key: described("/proc/cpuinfo", rf"^{key}\s*: (.+)$") for key in ("model name", "cpu family", "model", "flags")}
    wide = [flag for flag in ("avx2", "fma", "avx512f") if flag in told["flags"].split()]
    return {
        "processor": f"{told['model name']} (family {told['cpu family']}, model {told['model']}; {', '.join(wide)})",
        "cores": os.cpu_count(),
        "caches": ", ".join(caches) or "unknown",
        "memory": f"{kilobytes / 2**20:.1f} GiB",
        "kernel": platform.release(),
        "system": described("/etc/os-release", r'^PRETTY_NAME="(.+)"$'),
        "load before": f"{os.getloadavg()[0]:.2f}",
    }


def versions(run):
    """Of Ondine, of what built it, and of its peers."""
    packages = "import importlib.metadata as m, sys; print(*(f'{name} {m.version(name)}' for name in sys.argv[1:]), sep=', ')"
    told = {"Ondine": first_line(run.ondine, "--version"), "commit": first_line("git", "rev-parse", "--short=12", "HEAD")}
    told |= {"Rust": first_line("rustc", "--version"), "C++ (the driver of Embree)": first_line("c++", "--version"), "Python": platform.python_version()}
    for environment, names in [("rays/venv", ["embreex"]), ("renderers/venv/py311", ["mitsuba", "drjit", "sphericart"])]:
        told[", ".join(names)] = first_line(run.python(environment), "-c", packages, *names)
    return told


def measure(run, sections):
    """All sections, one after the other: what each gives, or why it gives nothing."""
    measured = {}
    for name in sections:
        begin = time.perf_counter()
        run.folder.mkdir(parents=True, exist_ok=True)
        try:
            measured[name] = MEASURES[name](run)
        except Failed as failed:
            measured[name] = {"not_measured": str(failed)}
        except (OSError, ValueError, KeyError, TypeError, ImportError, ZeroDivisionError) as error:
            measured[name] = {"not_measured": f"{type(error).__name__}: {error}"}
        measured[name]["seconds"] = round(time.perf_counter() - begin, 1)
        print(f"{name}: {measured[name].get('not_measured', 'measured')}, {measured[name]['seconds']} s", file=sys.stderr, flush=True)
    return measured


def self_test():
    """Parsers and tables on texts that were once printed."""
    lines = json_lines(
        "noise\n"
        '{"variant":"medium-fast/i1","set":"diffuse","mrays_s":10.0}\n'
        '{"variant":"medium-fast/i8i","set":"diffuse","mrays_s":9.0}\n'
        '{"variant":"high-fast/i8c","set":"diffuse","mrays_s":3.0}\n'
        '{"variant":"high-fast/i8c","set":"primary","mrays_s":30.0}\n'
        '{"variant":"medium-fast/i1","set":"primary","mrays_s":12.0}\n'
    )
    assert len(lines) == 5
    assert fast_variants(lines) == ["high-fast/i8c", "medium-fast/i1", "medium-fast/i8i"]
    assert fast_variants(lines[:3]) == ["medium-fast/i1", "medium-fast/i8i"]
    assert spread([3, 1, 2]) == {"median": 2, "min": 1, "max": 3, "rounds": [3, 1, 2]}
    assert ratio([4, 9], [2, 3])["rounds"] == [2, 3]
    assert promise("more", [3], at_least=2)["to_asked"] == 1.5
    assert promise("less", [4], at_most=2)["to_asked"] == 0.5
    assert promise("level", [4])["to_asked"] is promise("level", [4])["met"] is None
    assert promise("no error", [0], at_most=1)["met"] and not promise("more", [1], at_least=2)["met"]
    assert [number(value) for value in (12345.6, 99.94, 1.234, 0.0123)] == ["12,346", "99.9", "1.23", "0.0123"]
    assert shown(spread([1, 2, 4])) == "2.00 (1.00–4.00)" and shown(spread([5])) == "5.00"
    # x³ (3x² − 1) / 2 over 0..1.
    assert legendre_moment(2, 3) == Fraction(1, 8)
    done = launch(sys.executable, "-c", "print(1)")
    assert done.printed == "1\n" and done.peak_bytes > 0
    try:
        launch(sys.executable, "-c", "import sys; sys.exit('it broke')")
        raise AssertionError("a failure goes unnoticed")
    except Failed as failed:
        assert "it broke" in str(failed)
    one = spread([2.0])
    row = {"mesh": "cornell", "set": "shadow", "threads": 2, "variants": ["medium-fast/i8c"], "embree": one, "ondine": one, "ratio": one}
    build = {"embree": one, "ondine": one, "ratio": one, "bytes_a_triangle": 53.0}
    promises = [promise("a thing", [3], "×", at_least=2, goal=3), promise("another", [3], "s", at_most=2)]
    sections = {"rays": {"traced": [row], "build": build, "promises": promises, "seconds": 1}, "sh": {"not_measured": "why | not", "seconds": 1}}
    report = {"date": "today", "command": "this", "rounds": 1, "threads": 2, "quick": False, "machine": {"cores": 2}, "versions": {}, "sections": sections}
    text = page(report)
    for expected in [
        "| cornell | shadow | 2 | `medium-fast/i8c` | 2.00 | 2.00 | 2.00 |",
        "| a thing | ≥ 2 × | 3 × | 3.00 × | 1.50 | yes, and the goal |",
        "| another | ≤ 2 s |  | 3.00 s | 0.667 | **no** |",
        "not measured: why / not",
        "Not measured: left out by `--only`.",
    ]:
        assert expected in text, expected
    print("performance: parsers and tables give what they should")


def parse_sections(text):
    names = [part for word in text.split(",") for part in (PROMISES if word == "promises" else [word])]
    if unknown := [name for name in names if name not in MEASURES]:
        raise argparse.ArgumentTypeError(f"there is no section {', '.join(unknown)}; there are {', '.join(MEASURES)}, and promises")
    return names


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--ondine", type=Path, default=ROOT / "target/release/ondine", metavar="PROGRAM", help="default: target/release/ondine")
    parser.add_argument("--lab", type=Path, metavar="SCRIPTS", help="the drivers of the peers")
    parser.add_argument("--work", type=Path, metavar="SCRATCH", help="what they built; what is measured is written there, too")
    parser.add_argument("--only", type=parse_sections, default=list(MEASURES), metavar="LIST", help="sections, with commas between")
    parser.add_argument("--rounds", type=int, metavar="N", help="by turns; default 3, with --quick 1")
    parser.add_argument("--threads", type=int, default=2, metavar="N", help="default 2")
    parser.add_argument("--quick", action="store_true", help="everything small: a trial")
    out = "raw figures, the page beside them; default: docs/performance.json"
    parser.add_argument("--out", type=Path, default=ROOT / "docs/performance.json", metavar="FILE", help=out)
    parser.add_argument("--page", action="store_true", help="write the page from the raw figures, without measuring")
    parser.add_argument("--self-test", action="store_true")
    options = parser.parse_args()
    if options.self_test:
        self_test()
        return 0
    try:
        if options.page:
            report = json.loads(options.out.read_text())
            options.out.with_suffix(".md").write_text(page(report))
            return 0
        if options.rounds is not None and options.rounds < 1 or options.threads < 1:
            parser.error("--rounds and --threads are at least 1")
        if not options.ondine.is_file():
            parser.error(f"there is no program {options.ondine}; `cargo build --release` builds it, and --ondine names another")
        if set(PEERS) & set(options.only) and not (options.lab and options.work):
            parser.error("rays, images and sh need --lab and --work; --only promises does without")
        for folder in filter(None, (options.lab, options.work)):
            if not folder.is_dir():
                parser.error(f"there is no folder {folder}")
        rounds = options.rounds or (1 if options.quick else 3)
        with tempfile.TemporaryDirectory(dir=options.work) as scratch:
            lab, work = ((path or Path(scratch)).resolve() for path in (options.lab, options.work))
            run = Run(options.ondine.resolve(), lab, work, Path(scratch).resolve(), options.threads, rounds, options.quick)
            report = {"date": time.strftime("%Y-%m-%d"), "rounds": rounds, "threads": run.threads, "quick": run.quick, "machine": machine()}
            only = "" if options.only == list(MEASURES) else f" --only {','.join(options.only)}"
            report["command"] = f"tools/performance.py --lab SCRIPTS --work SCRATCH{only} --rounds {rounds} --threads {run.threads}{' --quick' * run.quick}"
            report |= {"versions": versions(run), "sections": measure(run, options.only)}
        text = json.dumps(report, indent=1)
        # Where things lie on this machine is nobody's matter.
        for path in sorted({str(path) for path in (run.folder, run.lab, run.work, ROOT)}, key=len, reverse=True):
            text = re.sub(rf"{re.escape(path)}(?:/|(?![\w.-]))", "", text)
        options.out.write_text(text + "\n")
        options.out.with_suffix(".md").write_text(page(json.loads(text)))
    except (OSError, ValueError, KeyError) as error:
        print(f"performance: {options.out}: {error}", file=sys.stderr)
        return 2
    return 1 if any("not_measured" in section for section in report["sections"].values()) else 0


if __name__ == "__main__":
    sys.exit(main())
