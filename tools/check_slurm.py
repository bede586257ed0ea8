#!/usr/bin/env python3
"""Renders an image in 16 shards on a Slurm of two nodes, one of which is lost in mid-render, and compares it with a plain render.

    check_slurm.py ONDINE

Plans the batch, submits it as a user would (submit.sh), ends node n2 and its task with SIGKILL, brings it back once Slurm has
noticed, and waits for the merge job: the image must have the bits of one `ondine render`. Then deletes one shard and truncates
another: `batch --status` must name these and no others, and the sbatch line that it prints must mend them and touch no others.
Prints what happens and when, and exits 0, or 1 with what is wrong. Needs what slurm-local needs; takes two minutes.
"""

import collections
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time

SLURM_LOCAL = pathlib.Path(__file__).resolve().with_name("slurm-local")
SHARDS = 16
SCENE, SIZE = "materials", "640x480"
RENDER = 24  # seconds that one render takes, so that each of two shards at a time takes three
PATIENCE = 120  # seconds until a wait is given up
STARTED = time.monotonic()

Task = collections.namedtuple("Task", "job number state node")


def say(message):
    print(f"{time.monotonic() - STARTED:6.1f} s  {message}", flush=True)


def expect(truth, message):
    if not truth:
        raise ValueError(message)


def output(*command, code=0):
    """What a command prints; fails if it exits with another code."""
    ran = subprocess.run(command, capture_output=True, text=True)
    expect(ran.returncode == code, f"{' '.join(map(str, command))}: exit code {ran.returncode}, not {code}: {ran.stdout}{ran.stderr}")
    return ran.stdout


def queue():
    """The tasks that have not ended; the number of a job that is no array is N/A."""
    return [Task(*line.split("|")) for line in output("squeue", "-h", "-r", "-o", "%F|%K|%T|%N").splitlines()]


def at_work(tasks, node):
    """The numbers of the array's tasks that run on a node."""
    return {int(task.number) for task in tasks if task.node == node and task.state == "RUNNING" and task.number.isdigit()}


def node_state(node):
    return output("sinfo", "-h", "-N", "-n", node, "-o", "%T").strip()


def wait(until, condition):
    """Polls until `condition(tasks)` holds, and tells how the queue changes meanwhile."""
    deadline, last = time.monotonic() + PATIENCE, None
    while not condition(tasks := queue()):
        pending = sum(task.state == "PENDING" for task in tasks)
        now = f"{pending} pending, {len(tasks) - pending} running; n2 is {node_state('n2')}"
        if now != last:
            say(f"  {now}")
            last = now
        expect(time.monotonic() < deadline, f"waited {PATIENCE} s until {until}")
        time.sleep(0.2)


def shards(plan):
    """The files of the shards that are there, by number; it is their task's too, as the plan is of one image."""
    found = {re.search(r"\.(\d+)-of-\d+\.exr$", part.name): part for part in (plan / "parts").iterdir()}
    return {int(match.group(1)): part for match, part in found.items() if match}


def task_numbers(specification):
    """The numbers of an array specification such as 3,7-9."""
    ranges = [part.split("-") for part in specification.split(",")]
    return {number for ends in ranges for number in range(int(ends[0]), int(ends[-1]) + 1)}


def image_hash(ondine, image):
    return json.loads(output(ondine, "info", "--json", image))["image_hash"]


def lose_a_node(ondine, slurm, plan):
    """Works the plan off, with n2 lost on the way."""
    # One task at a time on each node, however many processors there are.
    output("bash", plan / "submit.sh", "--exclusive")
    array = min((task.job for task in queue()), key=int)
    say(f"submitted jobs {' and '.join(sorted({task.job for task in queue()}, key=int))}")
    wait("a shard is there", lambda _: shards(plan))
    earlier = at_work(queue(), "n2") | set(shards(plan))
    wait("n2 has begun another", lambda tasks: at_work(tasks, "n2") - earlier)
    time.sleep(1)
    running = at_work(queue(), "n2")
    output(SLURM_LOCAL, "kill-node", "n2", "--dir", slurm)
    killed = running - set(shards(plan))
    say(f"killed n2 with its task {', '.join(map(str, killed))} of job {array}; {len(shards(plan))} shards are there")
    expect(killed, "no task was killed: it had ended")
    wait("n2 is down", lambda _: node_state("n2").startswith("down"))
    output(SLURM_LOCAL, "start-node", "n2", "--dir", slurm)
    say("Slurm has noticed; brought n2 back")
    wait("all is done", lambda tasks: not tasks)
    records = output("scontrol", "show", "job", "-o", array)
    again = {int(number) for number in re.findall(r"ArrayTaskId=(\d+) .*Restarts=[1-9]", records)}
    say(f"all is done; started again: task {', '.join(map(str, sorted(again)))}")
    expect(killed <= again, f"task {killed} was killed and not started again")
    output(ondine, "batch", "--status", plan)


def repair(ondine, plan, image):
    """Damages two shards, and has them mended as `batch --status` says."""
    before = shards(plan)
    expect(set(before) == set(range(1, SHARDS + 1)), f"there are shards {sorted(before)}, not 1 to {SHARDS}")
    times = {number: part.stat().st_mtime_ns for number, part in before.items()}
    damaged = {5, 12}
    image.unlink()
    before[5].unlink()
    os.truncate(before[12], before[12].stat().st_size // 2)

    status = output(ondine, "batch", "--status", plan, code=1)
    named = {int(number) for number in re.findall(rf"shard (\d+)/{SHARDS}\b", status)}
    expect(named == damaged, f"batch --status names shards {named}, not {damaged}: {status}")
    line = re.search(r"^sbatch -a ([\d,-]+) .*$", status, re.MULTILINE)
    expect(line and task_numbers(line.group(1)) == damaged, f"batch --status prints no sbatch -a for {damaged}: {status}")
    say(f"deleted shard 5 and truncated shard 12; status says: {line.group()}")
    output("sh", "-c", line.group())
    wait("they are mended", lambda tasks: not tasks)
    changed = {number for number, part in shards(plan).items() if part.stat().st_mtime_ns != times[number]}
    expect(changed == damaged, f"shards {changed} were written, not {damaged}")

    status = output(ondine, "batch", "--status", plan, code=1)
    line = re.search(r"^sbatch \S*merge.sbatch$", status, re.MULTILINE)
    expect(line, f"batch --status prints no sbatch for the merging: {status}")
    output("sh", "-c", line.group())
    wait("the image is merged", lambda tasks: not tasks)
    output(ondine, "batch", "--status", plan)


def samples(ondine, folder):
    """Samples per pixel that take about RENDER seconds on this machine: some blocks of 16 for each shard."""
    trial = output(ondine, "render", SCENE, "--size", SIZE, "--spp", "32", "--no-png", "--json", "-o", folder / "trial.exr")
    return 16 * SHARDS * max(1, round(RENDER / json.loads(trial)["render_s"] * 32 / (16 * SHARDS)))


def check(ondine, folder):
    plain, jobs, image, plan, slurm = [folder / name for name in ("plain.exr", "jobs.toml", "image.exr", "plan", "slurm")]
    spp = samples(ondine, folder)
    output(ondine, "render", SCENE, "--size", SIZE, "--spp", str(spp), "--no-png", "-o", plain)
    wanted = image_hash(ondine, plain)
    say(f"one render: {wanted}; {SCENE}, {SIZE}, {spp} spp")

    def compare(name):
        found = image_hash(ondine, image)
        expect(found == wanted, f"the {name} image has the hash {found}, and one render {wanted}")
        say(f"{name}: {found}")

    job = {"scene": SCENE, "size": SIZE, "spp": spp, "png": False, "output": image.name}
    jobs.write_text("version = 1\n[[jobs]]\n" + "".join(f"{key} = {json.dumps(value)}\n" for key, value in job.items()))
    output(ondine, "batch", jobs, "--plan", plan, "--shards", str(SHARDS))
    os.environ["SLURM_CONF"] = str(slurm / "slurm.conf")
    output(SLURM_LOCAL, "start", "--dir", slurm)
    try:
        lose_a_node(ondine, slurm, plan)
        compare("merged")
        repair(ondine, plan, image)
        compare("mended")
    except ValueError:
        for log in [*sorted(slurm.glob("*.log")), *sorted((plan / "logs").iterdir())]:
            print(f"--- {log.name}\n{log.read_text(errors='replace')[-1500:]}", file=sys.stderr)
        raise
    finally:
        output(SLURM_LOCAL, "stop", "--dir", slurm)


def main():
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__.strip())
    # An end by SIGTERM is to stop the Slurm too.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(128 + signal.SIGTERM))
    with tempfile.TemporaryDirectory(prefix="check-slurm-") as folder:
        try:
            check(pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(folder))
        except ValueError as error:
            sys.exit(f"check_slurm: {error}")
    say("passed")


if __name__ == "__main__":
    main()
