#!/usr/bin/env python3
"""Checks an image of Ondine with the reference OpenEXR library.

    check_exr.py IMAGE.exr

The channels are there, and R, G, B, the variances and every AOV follow from the exact sums and the sample count, to
one unit in the last place. Prints one line and exits 0, or 1 with what is wrong. Needs the packages OpenEXR and numpy.
"""

import itertools
import sys
from fractions import Fraction

import numpy
import OpenEXR

WORDS = 4
AOVS = ["albedo.R", "albedo.G", "albedo.B", "normal.X", "normal.Y", "normal.Z", "depth.Z"]


def exact(channels, name):
    """The integers of four UINT channels, as Python numbers."""
    total = 0
    for word in range(WORDS):
        pixels = channels[f"{name}.{word}"].pixels
        if pixels.dtype != numpy.uint32:
            raise ValueError(f"{name}.{word} is {pixels.dtype}, not uint32")
        total = total + pixels.astype(object) * (1 << (32 * word))
    return numpy.where(total >= 1 << 127, total - (1 << 128), total)


def mean(total, count):
    return Fraction(int(total), int(count) << 64) if count else Fraction(0)


def variance(total, square, count):
    """Of the mean: unbiased sample variance over the number of samples."""
    n = int(count)
    if n < 2:
        return Fraction(0)
    spread = Fraction(int(square), 1 << 40) - Fraction(int(total), 1 << 64) ** 2 / n
    return max(spread, Fraction(0)) / (n * (n - 1))


def compare(name, shown, expected):
    """Every float is its exact value to one unit in the last place."""
    if shown.dtype != numpy.float32:
        raise ValueError(f"{name} is {shown.dtype}, not float32")
    for (y, x), value in numpy.ndenumerate(shown):
        ulp = Fraction(float(numpy.spacing(numpy.abs(value))))
        if abs(Fraction(float(value)) - expected[y, x]) > ulp:
            raise ValueError(f"{name} at column {x}, row {y}: {value!r}, not {float(expected[y, x])!r}")


def check(path):
    image = OpenEXR.File(path, separate_channels=True)
    header, channels = image.header(), image.channels()
    count = channels["exact.samples"].pixels
    # All light, and that of each path length, from 1.
    lengths = itertools.takewhile(lambda layer: f"{layer}R" in channels, (f"length.{n}." for n in itertools.count(1)))
    radiance = ["", *lengths]
    for layer, c in itertools.product(radiance, "RGB"):
        total, square = exact(channels, f"exact.{layer}sum.{c}"), exact(channels, f"exact.{layer}square.{c}")
        compare(f"{layer}{c}", channels[f"{layer}{c}"].pixels, numpy.vectorize(mean, otypes=[object])(total, count))
        spread = numpy.vectorize(variance, otypes=[object])(total, square, count)
        compare(f"variance.{layer}{c}", channels[f"variance.{layer}{c}"].pixels, spread)
    aovs = [name for name in AOVS if name in channels]
    for name in aovs:
        total = exact(channels, f"exact.{name}")
        compare(name, channels[name].pixels, numpy.vectorize(mean, otypes=[object])(total, count))
    for name in ["scene", "scene_hash", "seed", "spp", "path_length", "strategy", "sampler", "version"]:
        if f"ondine.{name}" not in header:
            raise ValueError(f"the attribute ondine.{name} is missing")
    rows, columns = count.shape
    return (
        f"{path}: {columns}x{rows} pixels, {len(channels)} channels, {int(count.sum())} samples, "
        f"AOVs {', '.join(aovs) or 'none'}, {len(radiance) - 1} path lengths: all follow from the exact sums"
    )


def main():
    if len(sys.argv) != 2:
        print(__doc__.strip(), file=sys.stderr)
        return 2
    try:
        print(check(sys.argv[1]))
        return 0
    except KeyError as error:
        print(f"{sys.argv[1]}: the channel {error} is missing", file=sys.stderr)
    except Exception as error:
        print(f"{sys.argv[1]}: {error}", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main())
