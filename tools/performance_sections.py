"""What tools/performance.py measures: a function a section, each by itself.

A section gives its raw figures, and under `promises` those that were asked for. It raises `Failed` where it cannot measure.
"""

import json
import math
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
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
    """A figure that was asked for. `to_asked` is 1 or more where it is met; nothing where there is no limit, or no quotient."""
    measured = spread(values)
    over, under = (measured["median"], at_least) if at_most is None else (at_most, measured["median"])
    limited = at_least is not None or at_most is not None
    row = {"what": what, "unit": unit, "at_least": at_least, "at_most": at_most, "goal": goal, "measured": measured}
    return row | {"to_asked": over / under if limited and under else None, "met": over >= under if limited else None}


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
    repeat = 1 if run.quick else 3
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
        only = fast_variants(peer(mesh, run.threads, ["medium-fast"] if run.quick else ["/"], 1))
        for threads in sorted({1, run.threads}):
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
                    builds["embree"].append(next(line["build_s"] for line in lines if line["variant"] == "medium-fast/i1"))
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
        other = 1 - min(shares.values())
        promises.append(promise(f"rays of {mesh} that meet another triangle than Embree robust says, the worst set", [100 * other], "%", at_most=0.001))
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
        promises.append(promise(f"paths per second on S1, {sampler}: Ondine / Mitsuba", faster, "×", at_least=6, goal=10))
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
    what = "coefficients of Phong lobes against exact integrals, n = 1, 5, 10, 50, 1000, l to 20: the greatest relative error"
    promises.append(promise(what, [lobe_error(run)], at_most=1e-6))
    return {"evaluated": evaluated, "promises": promises}


def legendre_moment(degree, exponent):
    """The integral of x^exponent times the Legendre polynomial over 0..1, exactly."""
    powers = [(-1) ** k * math.comb(degree, k) * math.comb(2 * degree - 2 * k, degree) for k in range(degree // 2 + 1)]
    return sum(Fraction(factor, exponent + degree - 2 * k + 1) for k, factor in enumerate(powers)) / 2**degree


def lobe_error(run):
    """The greatest relative error of clamped Phong lobes' coefficients in closed form; absolute, of those that are 0."""
    worst = 0.0
    for lobe in run.call("sh", "lobe", "--exponent", "1,5,10,50,1000", "--bands", 20, "--json")["lobes"]:
        exponent = round(lobe["exponent"])
        for degree, value in enumerate(lobe["exact"]):
            true = math.sqrt((2 * degree + 1) * math.pi) * float((exponent + 1) * legendre_moment(degree, exponent) / 2)
            worst = max(worst, abs(value - true) / (abs(true) or 1))
    return worst


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


PEERS = {"rays": rays, "images": images, "sh": sh}
PROMISES = {"batch": batch, "merge": merge, "compare": compare, "dump": dump, "growth": growth, "memory": memory, "view": view}
MEASURES = PEERS | PROMISES
