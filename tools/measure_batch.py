#!/usr/bin/env python3
"""How well a batch keeps a machine busy: many small renders in one `ondine batch`, against the sum of their render times.

    python3 tools/measure_batch.py target/release/ondine [--jobs 200] [--size 128x128] [--spp 16] [--memory 1000] [--json]

Three scenes, each with as many seeds as it takes. Some of each are rendered by themselves on one thread: `render_s`, the
render loop alone, times the number of jobs, divided by the number of threads, is what a batch without any overhead would
take. Printed: that time, the time of the batch with process start, scenes and files, and their ratio, the median of some runs;
and the same against the whole processes of the single renders. With --memory N: peak memory of a batch of N jobs against one of
N/10. --json prints one object instead. Measure on a quiet machine.
"""

import argparse
import json
import os
import pathlib
import statistics
import subprocess
import tempfile
import time


def jobs(count, size, spp):
    """Three scenes, as many seeds as it takes."""
    seeds = -(-count // 3)
    return f"""version = 1
[defaults]
size = "{size}"
spp = {spp}
output = "out/{{scene}}-{{seed}}.exr"
[[jobs]]
scene = ["cornell", "materials", "many-lights"]
seed = {list(range(seeds))}
"""


def run(command, folder):
    """Seconds, and what it printed."""
    begin = time.perf_counter()
    done = subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True)
    return time.perf_counter() - begin, done.stdout


def batch(ondine, folder, count, size, spp, threads):
    """Seconds and peak memory of a batch in an empty folder."""
    folder.mkdir()
    (folder / "jobs.toml").write_text(jobs(count, size, spp))
    command = [ondine, "batch", "jobs.toml", "--quiet", "--json", "--threads", str(threads)]
    seconds, printed = run(command, folder)
    report = json.loads(printed)
    assert report["done"] == report["jobs"] >= count, report
    return seconds, report


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("ondine")
    parser.add_argument("--jobs", type=int, default=200)
    parser.add_argument("--size", default="128x128")
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--memory", type=int, default=0)
    parser.add_argument("--json", action="store_true")
    asked = parser.parse_args()
    say = (lambda line: None) if asked.json else print
    memory = []
    ondine = str(pathlib.Path(asked.ondine).resolve())
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        if asked.memory:
            for count in [asked.memory // 10, asked.memory]:
                _, report = batch(ondine, folder / f"memory-{count}", count, "64x64", 4, asked.threads)
                memory.append({key: report[key] for key in ("jobs", "peak_rss_bytes")})
                say(f"{report['jobs']} jobs: peak memory {report['peak_rss_bytes'] / 2**20:.1f} MiB")
        ratios = []
        for turn in range(asked.repeat):
            seconds, report = batch(ondine, folder / f"batch-{turn}", asked.jobs, asked.size, asked.spp, asked.threads)
            # Those of a scene differ by their seed alone.
            loops = processes = 0.0
            for scene in ["cornell", "materials", "many-lights"]:
                times = []
                for seed in range(5):
                    options = f"--size {asked.size} --spp {asked.spp} --seed {seed} --threads 1 --json --quiet -o alone.exr"
                    process, printed = run([ondine, "render", scene, *options.split()], folder)
                    times.append((json.loads(printed)["render_s"], process))
                share = report["jobs"] / 3 / asked.threads
                loops += share * statistics.median(loop for loop, _ in times)
                processes += share * statistics.median(process for _, process in times)
            ratios.append(seconds / loops)
            say(
                f"{report['jobs']} jobs in {seconds:.2f} s on {asked.threads} threads; render loops alone {loops:.2f} s: {ratios[-1]:.3f}; "
                f"one process each {processes:.2f} s: {seconds / processes:.3f}"
            )
    say(f"median {statistics.median(ratios):.3f}")
    if asked.json:
        print(json.dumps({"ratios": ratios, "memory": memory}))


if __name__ == "__main__":
    main()
