#!/usr/bin/env python3
"""Checks the ꟻLIP of `ondine compare` against the package flip-evaluator.

    check_flip.py ONDINE

Renders a few pairs of images (other noise, less light, a missing bounce), compares each with both, and prints one line for each.
Exits 0, or 1 where a mean differs by more than 1e-3 or the exposures are not the same. Needs flip-evaluator, numpy and OpenEXR.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

import flip_evaluator
import numpy
import OpenEXR

TOLERANCE = 1e-3

RENDERS = {
    "reference": ["cornell", "--spp", "64"],
    "noise": ["cornell", "--spp", "8", "--seed", "7"],
    "short": ["cornell", "--spp", "64", "--path-length", "3"],
    "glossy": ["materials", "--spp", "16"],
    "glossy-noise": ["materials", "--spp", "16", "--seed", "3"],
}


def pixels(path):
    channels = OpenEXR.File(str(path), separate_channels=True).channels()
    planes = [channels[name].pixels for name in "RGB"]
    return numpy.ascontiguousarray(numpy.stack(planes, axis=2), dtype=numpy.float32)


def write(path, image):
    channels = {name: numpy.ascontiguousarray(image[..., c]) for c, name in enumerate("RGB")}
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, channels).write(str(path))


def check(ondine, name, reference, test):
    # Whether they are called biased is not asked here.
    command = [ondine, "compare", str(reference), str(test), "--json"]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode not in (0, 1):
        raise ValueError(done.stderr.strip())
    found = json.loads(done.stdout)["metrics"]
    _, mean, used = flip_evaluator.evaluate(pixels(reference), pixels(test), "HDR", applyMagma=False)
    at = found["flip_exposures"]
    print(f"{name}: {found['flip']:.6f}, flip-evaluator {mean:.6f}, {at['count']} exposures")
    if abs(found["flip"] - mean) > TOLERANCE:
        raise ValueError(f"{name}: {found['flip']} is not {mean}")
    expected = (used["startExposure"], used["stopExposure"], used["numExposures"])
    if not numpy.allclose((at["start"], at["stop"], at["count"]), expected, atol=1e-4):
        raise ValueError(f"{name}: exposures {at}, not {expected}")


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    ondine = sys.argv[1]
    with tempfile.TemporaryDirectory() as folder:
        image = {name: pathlib.Path(folder, f"{name}.exr") for name in [*RENDERS, "darker", "spot"]}
        for name, arguments in RENDERS.items():
            command = [ondine, "render", *arguments, "--size", "200x130", "--no-png", "--quiet", "-o", str(image[name])]
            subprocess.run(command, check=True, capture_output=True)
        reference = pixels(image["reference"])
        write(image["darker"], 0.8 * reference)
        spot = reference.copy()
        spot[40:52, 60:75] *= [3.0, 1.0, 0.2]
        write(image["spot"], spot)
        for name in ["noise", "short", "darker", "spot"]:
            check(ondine, name, image["reference"], image[name])
        check(ondine, "glossy-noise", image["glossy"], image["glossy-noise"])


if __name__ == "__main__":
    try:
        main()
    except (ValueError, subprocess.CalledProcessError) as error:
        sys.exit(f"FAILED: {error}")
