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


SECTIONS = {}


def main():
    return 0


if __name__ == "__main__":
    sys.exit(main())
