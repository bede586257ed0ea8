#!/usr/bin/env python3
"""Compares images of Ondine with reference images made by other renderers.

    check_references.py ONDINE FOLDER [--compare SCENE=NAME:LENGTH ...] [--strategies ...] [--spp N] [--of STRATEGY=N ...]
    check_references.py --self-test

Renders each scene (a file or a built-in name) with each strategy by the program ONDINE, at the size of the reference and
with paths of LENGTH edges, and compares it with FOLDER/NAME.npy (float32, height x width x 3, linear radiance, row 0 at the
top) and FOLDER/NAME.var.npy (the variance of that mean). Means over blocks of 8x8 pixels, less those of the reference, over
their standard errors (both images'), are standard normal if both are right; their sum of squares gives p by chi-square, a
channel at a time. p is the chance of a sum so great. The two-sided p also finds one too small: variances that are too great.
Few samples of a caustic are far from normal, and p then too small: on `materials`, 128 do not do where 1024 do.

Exits 0 when all agree, 1 when a p is 0.001 or less or the means of the whole image differ by more than 0.1 %, 2 when it could
not compare. Needs the packages numpy and OpenEXR.
"""

import argparse
import json
import math
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy

BLOCK = 8
LEAST_P = 1e-3
MOST_DIFFERENCE = 1e-3
STRATEGIES = ["uniform", "cosine", "light", "mis"]
COMPARISONS = ["cornell=S1:6", "cornell=S1b3:4", "cornell=S1b2:3", "materials=S2:9"]
# Light that is found by chance alone needs more samples until its sums are normal and its variances right.
MORE_SAMPLES = {"uniform": 8, "cosine": 2}


def gamma_q(a, x):
    """Regularised upper incomplete gamma function (Press et al., Numerical Recipes, 3rd ed., sec. 6.2)."""
    if x <= 0:
        return 1.0
    front = math.exp(a * math.log(x) - x - math.lgamma(a))
    if x < a + 1:
        term = total = 1 / a
        n = a
        while term > total * 1e-16:
            n += 1
            term *= x / n
            total += term
        return max(0.0, 1 - front * total)
    b = x + 1 - a
    c, d = 1e300, 1 / b
    h = d
    for i in range(1, 100_000):
        an = -i * (i - a)
        b += 2
        d = 1 / (an * d + b)
        c = b + an / c
        h *= d * c
        if abs(d * c - 1) < 1e-15:
            break
    return front * h


def block_sums(image):
    """Sums over blocks, the last row and column of which may be smaller: rows x columns x 3."""
    image = image.astype(numpy.float64)
    for axis in (0, 1):
        image = numpy.add.reduceat(image, numpy.arange(0, image.shape[axis], BLOCK), axis=axis)
    return image


@dataclass
class Agreement:
    """How one image agrees with another."""

    p: list
    two_sided: list
    difference: float
    error: float
    worst: float

    @property
    def agrees(self):
        return min(self.p) > LEAST_P and abs(self.difference) <= MOST_DIFFERENCE


def compare(mean, variance, reference, reference_variance):
    """Two images with the variances of their means."""
    if mean.shape != reference.shape:
        raise ValueError(f"the image is {mean.shape}, the reference {reference.shape}")
    for name, values in [("image", mean), ("variance", variance), ("reference", reference)]:
        if not numpy.isfinite(values).all():
            raise ValueError(f"the {name} has values that are not finite")
    difference = block_sums(mean) - block_sums(reference)
    variances = block_sums(variance) + block_sums(reference_variance)
    p, two_sided, worst = [], [], 0.0
    for c in range(3):
        d, v = difference[..., c], variances[..., c]
        known = v > 0
        if (numpy.abs(d[~known]) > 1e-5 * numpy.abs(block_sums(reference)[..., c][~known])).any():
            raise ValueError("blocks without any variance differ")
        z = d[known] / numpy.sqrt(v[known])
        upper = gamma_q(known.sum() / 2, float((z**2).sum()) / 2)
        p.append(upper)
        two_sided.append(2 * min(upper, 1 - upper))
        worst = max(worst, float(numpy.abs(z).max(initial=0)))
    total = reference.astype(numpy.float64).sum()
    # The channels of a sample go together: their standard errors add up.
    error = sum(math.sqrt(variances[..., c].sum()) for c in range(3))
    return Agreement(p, two_sided, float(difference.sum() / total), float(error / total), worst)


def read_exr(path):
    import OpenEXR

    channels = OpenEXR.File(str(path), separate_channels=True).channels()
    stack = lambda prefix: numpy.stack([channels[prefix + c].pixels for c in "RGB"], axis=-1)
    return stack(""), stack("variance.")


def render(program, scene, size, length, strategy, spp, options, folder):
    image = Path(folder) / "image.exr"
    command = [program, "render", scene, "-o", str(image), "--json", "--quiet", "--no-png"]
    command += ["--size", f"{size[0]}x{size[1]}", "--path-length", str(length), "--strategy", strategy]
    command += ["--spp", str(spp), "--sampler", options.sampler, "--seed", str(options.seed)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        raise ValueError(f"{' '.join(command)}: exit code {done.returncode}: {done.stderr.strip()}")
    report = json.loads(done.stdout)
    if report["rejected_samples"]:
        raise ValueError(f"{scene}, {strategy}: {report['rejected_samples']} samples were rejected")
    return (*read_exr(image), report["render_s"])


def check(options):
    spps = {s: options.spp * MORE_SAMPLES.get(s, 1) for s in STRATEGIES}
    spps.update((name, int(spp)) for name, spp in (each.split("=") for each in options.of))
    heading = f"{'scene':<10} {'reference':<9} {'edges':>5} {'strategy':<8} {'spp':>6} {'p(R)':>8} {'p(G)':>8} {'p(B)':>8}"
    print(f"{heading} {'2-sided':>8} {'max |z|':>7} {'mean diff':>10} {'error':>8} {'seconds':>8}")
    agree = True
    for comparison in options.compare or COMPARISONS:
        scene, rest = comparison.split("=")
        name, length = rest.rsplit(":", 1)
        reference = numpy.load(Path(options.folder) / f"{name}.npy")
        reference_variance = numpy.load(Path(options.folder) / f"{name}.var.npy")
        size = (reference.shape[1], reference.shape[0])
        for strategy in options.strategies:
            with tempfile.TemporaryDirectory() as folder:
                spp = spps[strategy]
                mean, variance, seconds = render(
                    options.program, scene, size, length, strategy, spp, options, folder
                )
            got = compare(mean, variance, reference, reference_variance)
            shown = " ".join(f"{p:8.4f}" for p in got.p)
            print(
                f"{Path(scene).stem:<10} {name:<9} {length:>5} {strategy:<8} {spp:>6} {shown} {min(got.two_sided):8.4f}"
                f" {got.worst:7.2f} {100 * got.difference:+9.4f}% {100 * got.error:7.4f}% {seconds:8.1f}"
                f"{'' if got.agrees else '  DIFFERS'}",
                flush=True,
            )
            agree &= got.agrees
    return 0 if agree else 1


def self_test():
    """The statistics, on images whose noise is known."""
    for a, x, want in [(5, 18.307 / 2, 0.05), (0.5, 3.841459 / 2, 0.05), (50, 124.342113 / 2, 0.05), (512, 512, 0.494)]:
        assert abs(gamma_q(a, x) - want) < 1e-3, (a, x, gamma_q(a, x))
    assert (block_sums(numpy.ones((20, 17, 3))).sum(axis=(0, 1)) == 20 * 17).all()

    random = numpy.random.default_rng(1)
    truth = random.uniform(0.1, 2, (96, 128, 3))
    spread = random.uniform(0.5, 1.5, truth.shape)

    def image(scale, noise, believed=None):
        variance = (noise * spread) ** 2
        # What is known of the variance is noisy itself: 16 degrees of freedom.
        estimate = variance * random.chisquare(16, truth.shape) / 16 * (believed or 1.0)
        return truth * scale + random.normal(0, 1, truth.shape) * numpy.sqrt(variance), estimate

    right = [compare(*image(1, 0.01), *image(1, 0.02)) for _ in range(300)]
    p = numpy.array([each.p for each in right])
    assert 0.43 < p.mean() < 0.57 and 0.25 < p.std() < 0.33, (p.mean(), p.std())
    assert p.min() > 1e-5 and (p < 0.05).mean() < 0.09, p.min()
    assert sum(each.agrees for each in right) >= 295
    assert max(abs(each.difference) / each.error for each in right) < 4

    brighter = compare(*image(1.002, 0.01), *image(1, 0.02))
    assert not brighter.agrees and abs(brighter.difference - 2e-3) < 4 * brighter.error, brighter
    mean, variance = image(1, 0.01)
    mean[:16, :16] *= 1.02
    assert min(compare(mean, variance, *image(1, 0.01)).p) < 1e-6
    boastful = compare(*image(1, 0.01, believed=0.5), *image(1, 0.01, believed=0.5))
    assert max(boastful.p) < 1e-6
    timid = compare(*image(1, 0.01, believed=2), *image(1, 0.01, believed=2))
    assert min(timid.p) > 0.999 and max(timid.two_sided) < 1e-6

    for broken in [(mean[:8], variance[:8]), (mean * numpy.nan, variance)]:
        try:
            compare(*broken, *image(1, 0.01))
        except ValueError:
            continue
        raise AssertionError("compared what cannot be")
    print("check_references: the self-test passes")
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", nargs="?", help="the ondine binary")
    parser.add_argument("folder", nargs="?", help="holds NAME.npy and NAME.var.npy")
    parser.add_argument("--compare", nargs="+", metavar="SCENE=NAME:LENGTH", help=f"default: {' '.join(COMPARISONS)}")
    parser.add_argument("--strategies", nargs="+", choices=STRATEGIES, default=STRATEGIES)
    parser.add_argument("--spp", type=int, default=1024, help="of light and mis; cosine takes 2 times, uniform 8 times as many")
    parser.add_argument("--of", nargs="+", default=[], metavar="STRATEGY=SPP", help="samples of a strategy by itself")
    parser.add_argument("--sampler", default="pcg", help="independent samples, so that variances are what they say")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--self-test", action="store_true", help="check the statistics, render nothing")
    options = parser.parse_args()
    if options.self_test:
        return self_test()
    if not options.program or not options.folder:
        parser.error("name the ondine binary and the folder of references")
    try:
        return check(options)
    except (OSError, ValueError, KeyError) as error:
        print(f"check_references: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
