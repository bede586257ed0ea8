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
import shutil
import statistics
import string
import subprocess
import sys
import tempfile
import threading
import time
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PEERS = ["rays", "images", "sh"]
PROMISES = ["batch", "merge", "compare", "dump", "growth", "memory", "view"]
# No command takes as long on a quiet machine.
LONGEST_S = 600


class Failed(Exception):
    """A section cannot be measured."""


@dataclass
class Run:
    """What is measured, with what, and how often."""

    ondine: Path
    lab: Path
    work: Path
    folder: Path
    threads: int
    rounds: int
    quick: bool

    def call(self, *command, **options):
        """What Ondine prints, as JSON."""
        return json.loads(launch(self.ondine, *command, **options).printed)

    def render(self, scene, out, *options):
        return self.call("render", scene, *options, "--no-png", "--quiet", "--json", "-o", out)

    def python(self, environment):
        """The Python with a peer's packages."""
        return self.work / environment / "bin/python"


@dataclass
class Done:
    printed: str
    seconds: float
    peak_bytes: int


def launch(*command, environment=None, good=(0,)):
    """Runs a command: what it printed, its seconds and its peak memory."""
    command = [str(word) for word in command]
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as err:
        begin = time.perf_counter()
        try:
            process = subprocess.Popen(command, stdout=out, stderr=err, cwd=ROOT, env={**os.environ, **(environment or {})})
        except OSError as error:
            raise Failed(f"{command[0]} does not start: {error.strerror}") from error
        late = threading.Timer(LONGEST_S, process.kill)
        late.start()
        _, status, usage = os.wait4(process.pid, 0)
        seconds = time.perf_counter() - begin
        late.cancel()
        process.returncode = os.waitstatus_to_exitcode(status)
        for file in (out, err):
            file.seek(0)
        if process.returncode not in good:
            last = (err.read().strip() or out.read().strip() or "no message").splitlines()[-1]
            raise Failed(f"{Path(command[0]).name} {Path(command[1]).name} ends with {process.returncode}: {last}")
        return Done(out.read(), seconds, 1024 * usage.ru_maxrss)


def spread(values):
    """Median, least and greatest of the rounds."""
    values = [float(value) for value in values]
    return {"median": statistics.median(values), "min": min(values), "max": max(values), "rounds": values}


def ratio(over, under):
    """Of two rows of rounds, by turns."""
    return spread(a / b for a, b in zip(over, under, strict=True))


def promise(what, values, unit="", at_least=None, at_most=None, goal=None):
    """A figure that was asked for. `to_asked` is 1 or more where it is met."""
    measured = spread(values)
    asked = at_least if at_most is None else at_most
    to_asked = None if asked is None else measured["median"] / asked if at_most is None else asked / measured["median"]
    return {"what": what, "unit": unit, "at_least": at_least, "at_most": at_most, "goal": goal, "measured": measured, "to_asked": to_asked}


# Of the rays, in the order of the tables, and what is looked for.
SETS = {"primary": "closest", "diffuse": "closest", "shuffled": "closest", "shadow": "any"}
MESHES = ["cornell", "terrain"]


def json_lines(text):
    return [json.loads(line) for line in text.splitlines() if line.startswith("{")]


def fast_variants(lines, slack=0.85):
    """The variants that come near the best of any set of rays."""
    best = {}
    for line in lines:
        best[line["set"]] = max(line["mrays_s"], best.get(line["set"], 0))
    return sorted({line["variant"] for line in lines if line["mrays_s"] >= slack * best[line["set"]]})


def same_triangles(folder, mesh, kind, ours):
    """The share of rays that hit the same triangle, or miss, as Embree's robust single rays say, by set."""
    import numpy

    shares = {}
    for name in SETS:
        theirs = numpy.fromfile(folder / f"{mesh}.{name}.{SETS[name]}.{kind}.hits", "<u4").reshape(-1, 2)[:, 1]
        mine = numpy.fromfile(ours[name], "<u4").reshape(-1, 2)[:, 1]
        # Any hit has no triangle: whether there is one is all that can agree.
        same = mine == theirs if SETS[name] == "closest" else (mine == 0xFFFFFFFF) == (theirs == 0xFFFFFFFF)
        shares[name] = float(same.mean())
    return shares


def rays(run):
    """Closest and any hits per second, builds and bytes, beside Embree."""
    data, embree = run.work / "rays/data", run.work / "rays/bin/peer_embree"
    repeat = 1 if run.quick else 5
    traced, builds, variants, promises, agree = [], {"embree": [], "ondine": []}, {}, [], {}

    def peer(mesh, threads, only, repeat, *options):
        jobs = [f"{data}/{mesh}.{name}.f32:{kind}" for name, kind in SETS.items()]
        command = [embree, data / f"{mesh}.ply", "--threads", threads, "--reps", repeat, "--only", ",".join(only), *options]
        return json_lines(launch(*command, *jobs).printed)

    def ours(mesh, threads, name, repeat, *options):
        options = ["--kind", SETS[name], "--threads", threads, "--repeat", repeat, "--json", *options]
        return run.call("rays", data / f"{mesh}.ply", data / f"{mesh}.{name}.f32", *options)

    for mesh in MESHES:
        robust, hits = "medium-robust/i1", {name: run.folder / f"{mesh}.{name}.ours" for name in SETS}
        peer(mesh, run.threads, [robust], 1, "--hits", run.folder)
        for name in SETS:
            report = ours(mesh, run.threads, name, 1, "--hits", hits[name])
        agree[mesh] = same_triangles(run.folder, mesh, f"embree-4.4.0_{robust.replace('/', '_')}", hits)
        size = (report["node_bytes"] + report["triangle_bytes"]) / report["triangles"]
        for threads in sorted({1, run.threads}):
            scouted = peer(mesh, threads, ["medium-fast"] if run.quick else ["/"], repeat)
            only = fast_variants(scouted)
            results = {name: ([], [], set()) for name in SETS}
            for _ in range(run.rounds):
                lines = peer(mesh, threads, [*only, "medium-fast/i1"], repeat)
                reports = {name: ours(mesh, threads, name, repeat) for name in SETS}
                for name, (theirs, mine, won) in results.items():
                    best = max((line for line in lines if line["set"] == name), key=lambda line: line["mrays_s"])
                    theirs.append(best["mrays_s"])
                    won.add(best["variant"])
                    mine.append(reports[name]["mrays_per_s"])
                if mesh == "terrain" and threads == run.threads:
                    builds["embree"].append(min(line["build_s"] for line in lines if line["variant"].startswith("medium")))
                    builds["ondine"].append(statistics.median(report["build_s"] for report in reports.values()))
            for name, (theirs, mine, won) in results.items():
                row = {"mesh": mesh, "set": name, "threads": threads, "variants": sorted(won)}
                traced.append(row | {"embree": spread(theirs), "ondine": spread(mine), "ratio": ratio(mine, theirs)})
                if threads == run.threads:
                    asked = 1.25 if name == "diffuse" else 1.0
                    what = f"rays of {mesh}, {name}: Ondine / Embree, {threads} threads"
                    promises.append(promise(what, traced[-1]["ratio"]["rounds"], "×", at_least=asked, goal=1.5))
    slower = ratio(builds["ondine"], builds["embree"])
    promises.append(promise("build of a million triangles: seconds of Ondine / Embree medium", slower["rounds"], "×", at_most=1.5))
    promises.append(promise("size of the tree of a million triangles", [size], "bytes a triangle", at_most=120))
    for mesh, shares in agree.items():
        least = min(shares.values())
        promises.append(promise(f"{mesh}: same triangle as Embree robust, the least of the sets", [100 * least], "%", at_least=99.999))
    build = {name: spread(values) for name, values in builds.items()} | {"ratio": slower, "bytes_a_triangle": size}
    return {"traced": traced, "build": build, "agree": agree, "promises": promises}


NEUTRAL = "{py} {tool} {{scene}} {{out}} --ondine {ondine} -- --spp {{spp}} --threads {{threads}} --seed {{seed}} --sampler {sampler}"


def compare_renderers(run, peers, samplers, scenes, spp, seed):
    """One round of the renderers' driver: a report for each scene and peer."""
    file = run.folder / "renders.jsonl"
    file.unlink(missing_ok=True)
    command = [run.python("renderers/venv/py311"), run.lab / "renderers/run_all.py", "--peers", peers, "--scenes", scenes, "--spp", spp, "--seed", seed]
    command += ["--threads", run.threads, "--retries", 0, "--no-lock", "--jsonl", file]
    for sampler in samplers:
        told = {"py": "{py}", "tool": ROOT / "tools/run_neutral.py", "ondine": run.ondine, "sampler": sampler}
        command += ["--add", f"{sampler}={NEUTRAL.format(**told)}"]
    printed = launch(*command, environment={"LAB": str(run.work)}).printed
    reports = {(line["scene"], line["peer"]): line for line in (json_lines(file.read_text()) if file.exists() else [])}
    if missing := {(scene, peer) for scene in scenes.split(",") for peer in [*filter(None, peers.split(",")), *samplers]} - set(reports):
        failed = [line for line in printed.splitlines() if "FAILED" in line or "skipped" in line]
        raise Failed(f"no image of {sorted(missing)}: {'; '.join(failed)}")
    return reports


def images(run):
    """Paths per second and quality for the time, beside Mitsuba; both thread counts; memory; means against references."""
    spp, peers, samplers = 16 if run.quick else 64, ["mi_llvm", "mi_llvm_mj"], ["pcg", "sobol"]
    rounds = [compare_renderers(run, ",".join(peers), samplers, "S1,S2", spp, seed) for seed in range(1, run.rounds + 1)]
    rendered, promises = [], []
    for scene in ["S1", "S2"]:
        speed, quality = ({peer: [reports[scene, peer][key] for reports in rounds] for peer in peers + samplers} for key in ("mpaths_s", "eff_relmse"))
        for peer in peers + samplers:
            relmse = spread(reports[scene, peer]["relmse"] for reports in rounds)
            rendered.append({"scene": scene, "peer": peer, "mpaths_s": spread(speed[peer]), "relmse": relmse, "efficiency": spread(quality[peer])})
            if peer in samplers:
                rendered[-1]["faster"] = ratio(speed[peer], list(map(max, speed["mi_llvm"], speed["mi_llvm_mj"])))
                rendered[-1]["better"] = ratio(quality[peer], list(map(max, quality["mi_llvm"], quality["mi_llvm_mj"])))
    of = {(row["scene"], row["peer"]): row for row in rendered}
    for sampler in samplers:
        faster = of["S1", sampler]["faster"]["rounds"]
        promises.append(promise(f"paths per second on S1, {sampler}: Ondine / Mitsuba", faster, "×", at_least=6, goal=10 if sampler == "pcg" else None))
    promises.append(promise("equal quality on S1, sobol: Ondine / Mitsuba, 1 / (relMSE · s)", of["S1", "sobol"]["better"]["rounds"], "×", at_least=6))
    threads, peaks = {}, []
    options = ["--size", "256x256", "--path-length", 6, "--strategy", "mis", "--spp", 64 if run.quick else 512]
    for sampler in samplers:
        seconds = {1: [], 2: []}
        for _ in range(run.rounds):
            for count, times in seconds.items():
                report = run.render("cornell", run.folder / "threads.exr", *options, "--sampler", sampler, "--threads", count)
                times.append(report["render_s"])
                peaks.append(report["peak_rss_bytes"] / 2**20)
        threads[sampler] = ratio(seconds[1], seconds[2])
        promises.append(promise(f"two threads / one, {sampler}", threads[sampler]["rounds"], "×", at_least=1.9))
    promises.append(promise("peak memory at 256 × 256", peaks, "MiB", at_most=64))
    scenes = "S1" if run.quick else "S1,S1b2,S1b3,S2"
    means = compare_renderers(run, "", ["pcg"], scenes, 64 if run.quick else 1024, 1)
    off = max(abs(report["mean_rel"]) for report in means.values())
    promises.append(promise(f"mean of the image against the reference, {scenes}: the greatest deviation", [100 * off], "%", at_most=0.1))
    return {"rendered": rendered, "spp": spp, "threads": threads, "promises": promises}


# Run by the Python that has sphericart: DIRECTIONS.npy, greatest degree, calls a run, runs; prints seconds a call of each run.
SPHERICART = """
import json, sys, time
import numpy, sphericart
directions = numpy.load(sys.argv[1])
degree, calls, runs = map(int, sys.argv[2:])
basis = sphericart.SphericalHarmonics(degree)
basis.compute(directions)
seconds = []
for _ in range(runs):
    begin = time.perf_counter()
    for _ in range(calls):
        basis.compute(directions)
    seconds.append((time.perf_counter() - begin) / calls)
print(json.dumps(seconds))
"""


def sh(run):
    """The basis of spherical harmonics, beside sphericart, on one thread; an environment's coefficients."""
    import numpy

    repeat, evaluated, promises = 3 if run.quick else 7, [], []
    numbers = numpy.random.Generator(numpy.random.PCG64(1))
    for count, calls in [(100_000 if run.quick else 1_000_000, 1), (256, 200)]:
        file = run.folder / f"{count}.npy"
        directions = numbers.normal(size=(count, 3))
        numpy.save(file, (directions / numpy.linalg.norm(directions, axis=1, keepdims=True)).astype(numpy.float32))
        for degree in (4, 8, 16):
            theirs, mine = [], []
            for _ in range(run.rounds):
                command = [run.python("renderers/venv/py311"), "-c", SPHERICART, file, degree, calls, repeat]
                seconds = json.loads(launch(*command, environment={"OMP_NUM_THREADS": "1"}).printed)
                theirs.append(count / statistics.median(seconds) / 1e6)
                options = ["--bands", degree, "--threads", 1, "--repeat", repeat * calls, "--json"]
                mine.append(run.call("sh", "basis", file, *options)["points_per_s"] / 1e6)
            row = {"directions": count, "degree": degree, "sphericart": spread(theirs), "ondine": spread(mine), "ratio": ratio(mine, theirs)}
            evaluated.append(row)
            what = f"SH basis to degree {degree}, {count:,} directions a call: Ondine / sphericart"
            promises.append(promise(what, row["ratio"]["rounds"], "×", at_least=2, goal=4))
    sky = run.folder / "sky.exr"
    run.render("sky", sky, "--size", "2048x1024", "--spp", 1)
    project = ["sh", "project", sky, "--bands", 8, "--threads", run.threads, "--json", "-o", run.folder / "sky.json"]
    times = [1e3 * run.call(*project)["project_s"] for _ in range(run.rounds)]
    promises.append(promise("an environment of 2048 × 1024 to degree 8", times, "ms", at_most=60))
    return {"evaluated": evaluated, "promises": promises}


def batch(run):
    """Many small renders in one call, against the sum of their render loops."""
    jobs, memory = (30, 100) if run.quick else (200, 1000)
    tool = [sys.executable, ROOT / "tools/measure_batch.py", run.ondine, "--json", "--threads", run.threads]
    report = json.loads(launch(*tool, "--jobs", jobs, "--repeat", run.rounds, "--memory", memory).printed)
    few, many = report["memory"]
    flat = [many["peak_rss_bytes"] / few["peak_rss_bytes"]]
    growth = f"peak memory of a batch: {many['jobs']:,} jobs / {few['jobs']:,} jobs (asked: flat)"
    promises = [promise(f"batch of {jobs} renders of 128 × 128, 16 spp: seconds / sum of render loops", report["ratios"], "×", at_most=1.1)]
    return report | {"promises": [*promises, promise(growth, flat, "×")]}


def merge(run):
    """Parts of a large image put together."""
    parts, size = (8 if run.quick else 64), "1920x1080"
    names = [run.folder / f"part-{k}.exr" for k in range(1, parts + 1)]
    for k, name in enumerate(names, 1):
        run.render("cornell", name, "--size", size, "--spp", parts, "--shard", f"{k}/{parts}")
    whole = run.render("cornell", run.folder / "whole.exr", "--size", size, "--spp", parts)["image_hash"]
    turns = []
    for _ in range(run.rounds):
        turns.append(launch(run.ondine, "merge", *names, "-o", run.folder / "merged.exr", "--no-png", "--json"))
        if (merged := json.loads(turns[-1].printed)["image_hash"]) != whole:
            raise Failed(f"merged parts have image hash {merged}, the whole {whole}")
    what = f"merge of {parts} shards of 1920 × 1080"
    promises = [promise(f"{what}, the bits of the whole", [done.seconds for done in turns], "s", at_most=10)]
    return {"promises": [*promises, promise(f"{what}: peak memory", [done.peak_bytes / 2**20 for done in turns], "MiB", at_most=1024)]}


def compare(run):
    """Two large images, with and without ꟻLIP. Whether the images agree is no matter here: exit code 1 is an answer."""
    pair = [run.folder / "first.exr", run.folder / "second.exr"]
    for seed, image in enumerate(pair):
        run.render("cornell", image, "--size", "1920x1080", "--spp", 4, "--seed", seed)
    plain, flip = [], []
    for _ in range(run.rounds):
        plain.append(launch(run.ondine, "compare", *pair, "--no-flip", good=(0, 1)).seconds)
        flip.append(launch(run.ondine, "compare", *pair, good=(0, 1)).seconds)
    what = "compare of two images of 1920 × 1080"
    return {"promises": [promise(what, plain, "s", at_most=1), promise(f"{what}, with ꟻLIP", flip, "s", at_most=3)]}


def dump(run):
    """All that passes between the stages, for one tile of 16 × 16 pixels."""
    out = run.folder / "dump"
    times = [launch(run.ondine, "dump", "cornell", "--tile", "120,96", "--samples", "0..16", "--out", out).seconds for _ in range(run.rounds)]
    return {"promises": [promise("dump of a 16 × 16 tile, 16 spp", times, "s", at_most=1)]}


def growth(run):
    """Rays and builds from ten thousand triangles to ten million."""
    counts = [10_000, 100_000] if run.quick else [10_000, 100_000, 1_000_000, 10_000_000]
    tool = [sys.executable, ROOT / "tools/growth.py", run.ondine, "--json", "--threads", run.threads, "--repeat", 3, "--folder", run.folder]
    rows = json.loads(launch(*tool, "--triangles", *counts).printed)
    first, last = rows[0], rows[-1]
    promises = []
    for what, key, theory in [("a diffuse ray", "diffuse_ns_by_log", "log₂ n"), ("a build", "build_ns_by_log", "n log₂ n")]:
        share = [last[key] / first[key]]
        promises.append(promise(f"time of {what} over {theory}: {last['triangles']:,} triangles / {first['triangles']:,} (asked: level)", share, "×"))
    return {"grown": rows, "promises": promises}


def memory(run):
    """The peak of a render of a very large mesh."""
    count = 1_000_000 if run.quick else 10_000_000
    # As tools/growth.py calls it: what is there is not made again.
    mesh = run.folder / f"terrain{count}.ply"
    if not mesh.exists():
        launch(sys.executable, ROOT / "tools/generate.py", "terrain", mesh, "--triangles", count)
    peak = run.render(mesh, run.folder / "terrain.exr", "--size", "640x480", "--spp", 4)["peak_rss_bytes"] / 2**30
    return {"promises": [promise(f"render of {count:,} triangles: peak memory", [peak], "GiB", at_most=4)]}


def view(run):
    """The live page in a browser: how soon a picture, and how much of a render's speed is left."""
    if not shutil.which("node"):
        raise Failed("Node is not installed")
    moves, seconds = (3, 3) if run.quick else (20, 8)
    tool = ["node", ROOT / "tools/measure_view.mjs", run.ondine, "cornell", "--json", "--moves", moves, "--seconds", seconds, "--rounds", run.rounds]
    report = json.loads(launch(*tool).printed)
    shares = [100 * turn["page_open"] / turn["render"] for turn in report["rounds"]]
    delay = report["key_to_picture_ms"]
    promises = [promise("first picture after a move of the camera, 512 × 512, median", [delay["median"]], "ms", at_most=150)]
    promises.append(promise("the same, the worst", [delay["worst"]], "ms", at_most=150))
    return report | {"promises": [*promises, promise("paths per second with the page open / those of a render", shares, "%", at_least=85)]}


MEASURES = {"rays": rays, "images": images, "sh": sh}
MEASURES |= {"batch": batch, "merge": merge, "compare": compare, "dump": dump, "growth": growth, "memory": memory, "view": view}


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


def number(value):
    """Three digits, but all of those before the point."""
    return f"{value:,.0f}" if abs(value) >= 100 else f"{value:.3g}" if abs(value) < 1 else f"{value:.2f}" if abs(value) < 10 else f"{value:.1f}"


def shown(figure):
    """A median, and what the rounds range over."""
    low, high = number(figure["min"]), number(figure["max"])
    return number(figure["median"]) + (f" ({low}–{high})" if low != high else "")


def table(heading, rows):
    """In Markdown. Columns whose name begins with a blank go to the right."""
    rule = "|".join("---:" if name.startswith(" ") else "---" for name in heading)
    return "\n".join(["| " + " | ".join(name.strip() for name in heading) + " |", f"|{rule}|", *(f"| {' | '.join(row)} |" for row in rows)])


def ray_table(section):
    rows = []
    for row in section["traced"]:
        speeds = [shown(row["embree"]), shown(row["ondine"]), shown(row["ratio"])]
        rows.append([row["mesh"], row["set"], str(row["threads"]), ", ".join(f"`{name}`" for name in row["variants"]), *speeds])
    return table(["mesh", "rays", " threads", "Embree's best", " Embree, M rays/s", " Ondine, M rays/s", " ratio"], rows)


def build_table(section):
    build = section["build"]
    row = [shown(build["embree"]), shown(build["ondine"]), shown(build["ratio"]), number(build["bytes_a_triangle"])]
    return table([" Embree medium, s", " Ondine, s", " Ondine / Embree", " bytes a triangle"], [row])


def image_table(section):
    names = {"mi_llvm": "Mitsuba, independent", "mi_llvm_mj": "Mitsuba, multijitter", "pcg": "Ondine, `pcg`", "sobol": "Ondine, `sobol`"}
    rows = []
    for row in section["rendered"]:
        ratios = [shown(row[key]) if key in row else "" for key in ("faster", "better")]
        rows.append([row["scene"], names[row["peer"]], shown(row["mpaths_s"]), ratios[0], shown(row["relmse"]), shown(row["efficiency"]), ratios[1]])
    return table(["scene", "renderer", " M paths/s", " ratio", " relMSE", " 1 / (relMSE · s)", " ratio"], rows)


def thread_table(section):
    return table(["sampler", " two threads / one"], [[f"`{name}`", shown(figure)] for name, figure in section["threads"].items()])


def sh_table(section):
    rows = []
    for row in section["evaluated"]:
        rows.append([f"{row['directions']:,}", str(row["degree"]), *(shown(row[key]) for key in ("sphericart", "ondine", "ratio"))])
    return table([" directions a call", " degree", " sphericart, M/s", " Ondine, M/s", " ratio"], rows)


def growth_table(section):
    rows = []
    for row in section["grown"]:
        numbers = [row["build_s"], *row["mrays_per_s"].values(), row["diffuse_ns_by_log"], row["build_ns_by_log"]]
        rows.append([f"{row['triangles']:,}", *map(number, numbers)])
    heading = [" triangles", " build, s", " primary", " diffuse", " shuffled", " shadow", " ns a diffuse ray / log₂ n", " build, ns a triangle / log₂ n"]
    return table(heading, rows)


def promise_table(sections):
    """Every figure that was asked for, and those that could not be measured."""
    rows = []
    for name, section in sections.items():
        if "not_measured" in section:
            rows.append([f"all of `{name}`", "", "", f"not measured: {section['not_measured'].replace('|', '/')}", "", ""])
            continue
        for row in section["promises"]:
            sign, asked = ("≥", row["at_least"]) if row["at_most"] is None else ("≤", row["at_most"])
            unit = f" {row['unit']}" if row["unit"] else ""
            limit = "" if asked is None else f"{sign} {asked:,g}{unit}"
            met = "" if asked is None else "yes" if row["to_asked"] >= 1 else "**no**"
            if met == "yes" and row["goal"] is not None and row["measured"]["median"] >= row["goal"]:
                met = "yes, and the goal"
            goal = "" if row["goal"] is None else f"{row['goal']:g}{unit}"
            figure = row["measured"]
            # Three digits do not tell 99.998 from 99.999.
            value = f"{figure['median']:.4f}" if row["unit"] == "%" and 99.9 < figure["median"] < 100 else shown(figure)
            rows.append([row["what"], limit, goal, value + unit, "" if asked is None else number(row["to_asked"]), met])
    return table(["what", " asked", " goal", " measured", " to what was asked", "met"], rows)


TABLES = {"ray_table": ("rays", ray_table), "build_table": ("rays", build_table), "image_table": ("images", image_table)}
TABLES |= {"thread_table": ("images", thread_table), "sh_table": ("sh", sh_table), "growth_table": ("growth", growth_table)}


def page(report):
    """The page, from the raw figures."""
    sections = report["sections"]
    values = {key: report[key] for key in ("date", "command", "rounds", "threads")}
    values["quick"] = "**These figures are of `--quick`, a trial: they say nothing.**\n\n" if report["quick"] else ""
    for key in ("machine", "versions"):
        values[key] = table(["", ""], [[name, str(told)] for name, told in report[key].items()])
    for key, (name, build) in TABLES.items():
        section = sections.get(name, {"not_measured": "left out by `--only`"})
        values[key] = f"Not measured: {section['not_measured']}." if "not_measured" in section else build(section)
    judged = [row["to_asked"] >= 1 for section in sections.values() for row in section.get("promises", []) if row["to_asked"] is not None]
    values |= {"met": sum(judged), "asked": len(judged), "promise_table": promise_table(sections)}
    values["spp"] = sections.get("images", {}).get("spp", "some")
    values["minutes"] = f"{sum(section['seconds'] for section in sections.values()) / 60:.0f}"
    return string.Template((ROOT / "tools/performance.template.md").read_text()).substitute(values)


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
    assert promise("level", [4])["to_asked"] is None
    assert [number(value) for value in (12345.6, 99.94, 1.234, 0.0123)] == ["12,346", "99.9", "1.23", "0.0123"]
    assert shown(spread([1, 2, 4])) == "2.00 (1.00–4.00)" and shown(spread([5])) == "5.00"
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
    parser.add_argument("--only", type=parse_sections, default=PEERS + PROMISES, metavar="LIST", help="sections, with commas between")
    parser.add_argument("--rounds", type=int, metavar="N", help="by turns; default 3, with --quick 1")
    parser.add_argument("--threads", type=int, default=2, metavar="N", help="default 2")
    parser.add_argument("--quick", action="store_true", help="everything small: a trial")
    parser.add_argument("--out", type=Path, default=ROOT / "docs/performance.json", metavar="FILE", help="raw figures, and the page beside them; default: docs/performance.json")
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
            only = "" if options.only == PEERS + PROMISES else f" --only {','.join(options.only)}"
            report["command"] = f"tools/performance.py --lab SCRIPTS --work SCRATCH{only} --rounds {rounds} --threads {run.threads}{' --quick' * run.quick}"
            report |= {"versions": versions(run), "sections": measure(run, options.only)}
        text = json.dumps(report, indent=1)
        for path in {str(path) for path in (run.folder, run.lab, run.work, ROOT)}:
            text = text.replace(f"{path}/", "").replace(path, ".")
        options.out.write_text(text + "\n")
        options.out.with_suffix(".md").write_text(page(json.loads(text)))
    except (OSError, ValueError, KeyError) as error:
        print(f"performance: {options.out}: {error}", file=sys.stderr)
        return 2
    return 1 if any("not_measured" in section for section in report["sections"].values()) else 0


if __name__ == "__main__":
    sys.exit(main())
