#!/usr/bin/env python3
"""Makes the references that the images of `ondine bench` are held to.

    bench_references.py ONDINE [--cases box,sky] [--paths N] [--check]

Each scene is exported as files, and rendered from these by `ondine render` with other random numbers (the sampler pcg, whose
samples are independent, and another seed) and many more of them than a suite takes. What is kept are the means of 64 x 64 cells of the image
and the variances of these means: src/bench/references/NAME.npy, float32 of shape (6, 64, 64): R, G, B, and their variances.

`--check` writes nothing: it renders with the strategy `light` where the references were made with `mis`, and fails where
a stored reference differs from that by more than noise. Needs the packages numpy and OpenEXR.
"""
import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy
import OpenEXR

CELLS = 64
SIDE = 512
PATH_LENGTH = 6
FOLDER = Path(__file__).resolve().parent.parent / "src/bench/references"


def cells(plane):
    """Sums over the cells of an image."""
    side = plane.shape[0] // CELLS
    return plane.astype(numpy.float64).reshape(CELLS, side, CELLS, side).sum(axis=(1, 3))


def rendered(ondine, scene, folder, spp, strategy):
    """Means of the cells and their variances, float64 of shape (6, 64, 64)."""
    image = folder / "image.exr"
    command = [ondine, "render", scene, "--size", f"{SIDE}x{SIDE}", "--path-length", PATH_LENGTH, "--strategy", strategy,
               "--sampler", "pcg", "--seed", "1", "--spp", spp, "--no-png", "--quiet", "-o", image]
    subprocess.run([str(word) for word in command], check=True, stdout=subprocess.DEVNULL)
    channels = OpenEXR.File(str(image), separate_channels=True).channels()
    pixels = (SIDE // CELLS) ** 2
    means = [cells(channels[name].pixels) / pixels for name in "RGB"]
    variances = [cells(channels[f"variance.{name}"].pixels) / pixels**2 for name in "RGB"]
    return numpy.stack(means + variances)


def differs(reference, other):
    """The greatest score of a channel's mean and of its cells' chi-square, standard normal where there is nothing but noise."""
    worst = 0.0
    for channel in range(3):
        difference = other[channel] - reference[channel]
        variance = other[channel + 3] + reference[channel + 3]
        live = variance > 0
        mean = difference.sum() / numpy.sqrt(variance.sum())
        count = live.sum()
        chi = ((difference[live] ** 2 / variance[live]).sum() - count) / numpy.sqrt(2 * count)
        print(f"  {'RGB'[channel]}: mean off by {difference.sum() / reference[channel].sum():+.4%}, z {mean:+.2f}; "
              f"cells {chi:+.2f}")
        worst = max(worst, abs(mean), chi)
    return worst


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("ondine")
    parser.add_argument("--cases", help="only these, by commas")
    parser.add_argument("--paths", type=float, default=256, help="millions of camera paths of each image")
    parser.add_argument("--check", action="store_true")
    given = parser.parse_args()
    wanted = given.cases.split(",") if given.cases else None
    spp = max(16, round(given.paths * 2**20 / SIDE**2))
    wrong = []
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        subprocess.run([given.ondine, "bench", "--suite", "full", "--export", folder], check=True, stdout=subprocess.DEVNULL)
        for scene in sorted(folder.glob("*.toml")):
            name = scene.stem
            if wanted and name not in wanted:
                continue
            print(f"{name}: {spp} samples per pixel", flush=True)
            stored = FOLDER / f"{name}.npy"
            if given.check:
                image = rendered(given.ondine, scene, folder, spp, "light")
                if differs(numpy.load(stored).astype(numpy.float64), image) > 4.5:
                    wrong.append(name)
            else:
                numpy.save(stored, rendered(given.ondine, scene, folder, spp, "mis").astype(numpy.float32))
    if wrong:
        sys.exit("FAILED: other than their references: " + ", ".join(wrong))


if __name__ == "__main__":
    main()
