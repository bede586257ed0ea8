#!/usr/bin/env python3
"""Renders a scene of the neutral JSON form with Ondine, for comparisons with other renderers in one run.

    run_neutral.py SCENE.json OUT.npy [--ondine PROGRAM] [-- OPTIONS OF ondine render]

Translates the scene (neutral_scene.py), renders it, writes the mean as float32 [height, width, 3], row 0 at the top, and
prints one line `PEER_RESULT {...}` with the seconds of the render loop, the rates and the peak memory. Needs the packages
numpy and OpenEXR.
"""
import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy
import OpenEXR


def main():
    arguments = sys.argv[1:]
    split = arguments.index("--") if "--" in arguments else len(arguments)
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--ondine", default="ondine")
    given = parser.parse_args(arguments[:split])
    translate = [sys.executable, Path(__file__).with_name("neutral_scene.py"), given.scene]
    with tempfile.TemporaryDirectory() as folder:
        scene, image = Path(folder, "scene.toml"), Path(folder, "image.exr")
        with scene.open("wb") as file:
            subprocess.run(translate, stdout=file, check=True)
        command = [given.ondine, "render", scene, "-o", image, "--no-png", "--quiet", "--json"]
        done = subprocess.run(command + arguments[split + 1:], stdout=subprocess.PIPE, check=True)
        channels = OpenEXR.File(str(image), separate_channels=True).channels()
        numpy.save(given.out, numpy.stack([channels[name].pixels for name in "RGB"], axis=-1))
    report = json.loads(done.stdout)
    wanted = ["render_s", "mpaths_per_s", "mrays_per_s", "peak_rss_bytes", "strategy", "sampler", "spp", "threads"]
    print("PEER_RESULT", json.dumps({key: report[key] for key in wanted}))


main()
