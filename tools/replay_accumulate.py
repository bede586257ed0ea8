#!/usr/bin/env python3
"""Replays the accumulate stage of a dump, to the same bits.

    replay_accumulate.py DUMP

From what the stage was given (throughputs and densities of encounters, what they emit, contributions of shadow rays and
which of them are visible) follow the weights, the radiance of each path after each step, the sums of blocks in double
precision, and the exact sums of pixels. Prints one line and exits 0, or 1 with the first path that comes out otherwise.
Needs numpy.
"""

import json
import pathlib
import sys
from fractions import Fraction

import numpy

BLOCK = 16
ONE = numpy.float32(1)


class Dump:
    def __init__(self, root):
        self.root = pathlib.Path(root)
        self.manifest = json.loads((self.root / "manifest.json").read_text())
        self.queues = {(q["edge"], q["stage"], q["queue"]): q for q in self.manifest["queues"]}

    def table(self, edge, stage, queue):
        """A queue's arrays by field; none where it has no record."""
        entry = self.queues.get((edge, stage, queue))
        if entry is None or entry["records"] == 0:
            return None
        return {f["field"]: numpy.load(self.root / f["file"]) for f in entry["fields"]}

    def path(self, number):
        x, y, sample = (int(self.table(0, "paths", "")[key][number]) for key in ["x", "y", "sample"])
        return f"path {number} (pixel {x},{y}, sample {sample})"


def same(dump, place, paths, replayed, dumped):
    """Every bit of every row."""
    width = numpy.uint64 if dumped.dtype == numpy.float64 else numpy.uint32
    if replayed.dtype != dumped.dtype or replayed.shape != dumped.shape:
        raise ValueError(f"{place}: {replayed.dtype} {replayed.shape}, not {dumped.dtype} {dumped.shape}")
    rows = replayed.view(width) != dumped.view(width)
    rows = rows.reshape(len(rows), -1).any(axis=1)
    if rows.any():
        row = int(numpy.argmax(rows))
        raise ValueError(f"{place} of {dump.path(int(paths[row]))}: {replayed[row]}, not {dumped[row]}")


def weights(strategy, pdf, light_pdf):
    """What each strategy gives to light that is met; the power heuristic of Veach 1997, section 9.2.3."""
    if strategy == "light":
        return numpy.where(numpy.isinf(pdf), ONE, numpy.float32(0))
    if strategy == "mis":
        ratio = light_pdf / pdf
        return ONE / (ONE + ratio * ratio)
    return numpy.ones_like(pdf)


def encounters(dump, edge, radiance):
    """Light that was met: added, or on the last edge the shadow rays that ask whether anything is between."""
    terms = dump.table(edge, "accumulate", "encounters")
    if terms is None:
        return
    met = [dump.table(edge, "intersect", queue) for queue in ["encounters", "mesh_encounters"]]
    met = [table for table in met if table is not None]
    paths, throughput, pdf = (numpy.concatenate([table[key] for table in met]) for key in ["path", "throughput", "pdf"])
    order = numpy.argsort(paths)
    paths, throughput, pdf = paths[order], throughput[order], pdf[order]
    place = f"edge {edge}, accumulate, encounters"
    same(dump, f"{place}, path", paths, paths, terms["path"])

    weight = weights(dump.manifest["settings"]["strategy"], pdf, terms["light_pdf"])
    same(dump, f"{place}, weight", paths, weight, terms["weight"])
    contribution = throughput * terms["emitted"] * weight[:, None]
    same(dump, f"{place}, contribution", paths, contribution, terms["contribution"])

    last = edge == dump.manifest["settings"]["path_length"] and edge > 1
    if last and (edge, "intersect", "mesh_encounters") not in dump.queues:
        lit = numpy.abs(contribution).max(axis=1) > 0
        rays = dump.table(edge, "nee", "shadow_rays") or {"path": paths[:0], "contribution": contribution[:0]}
        place = f"edge {edge}, nee, shadow_rays"
        same(dump, f"{place}, path", paths[lit], paths[lit], rays["path"])
        same(dump, f"{place}, contribution", paths[lit], contribution[lit], rays["contribution"])
    else:
        radiance[paths] += contribution
    same(dump, f"edge {edge}, accumulate, encounters, radiance", paths, radiance[paths], terms["radiance"])


def shadow_rays(dump, edge, radiance):
    """The light of those that are visible."""
    rays = dump.table(edge, "nee", "shadow_rays")
    if rays is None:
        return
    visible, total = dump.table(edge, "intersect", "visible"), dump.table(edge, "accumulate", "shadow_rays")
    paths = rays["path"]
    for table, stage in [(visible, "intersect, visible"), (total, "accumulate, shadow_rays")]:
        same(dump, f"edge {edge}, {stage}, path", paths, paths, table["path"])
    lit = visible["visible"] == 1
    radiance[paths[lit]] += rays["contribution"][lit]
    same(dump, f"edge {edge}, accumulate, shadow_rays, radiance", paths, radiance[paths], total["radiance"])


def words(numbers):
    """Integers of 128 bits as four words each, the least first."""
    return numpy.array([[[(n >> (32 * w)) & 0xFFFFFFFF for w in range(4)] for n in row] for row in numbers], numpy.uint32)


def film(dump, radiance):
    """Blocks of samples in double precision, and integers of them."""
    first, end = dump.manifest["samples"]
    samples = end - first
    table = dump.table(0, "film", "radiance")
    same(dump, "film, radiance", numpy.arange(len(radiance)), radiance, table["radiance"])

    # What is not finite, or 2^32 and more, is kept out.
    kept = (numpy.abs(radiance) < numpy.float32(2**32)).all(axis=1).reshape(-1, samples)
    pixels = radiance.astype(numpy.float64).reshape(-1, samples, 3)
    starts = sorted({max(first, sample // BLOCK * BLOCK) for sample in range(first, end)})
    count = numpy.zeros((len(pixels), len(starts)), numpy.uint32)
    sums, squares = (numpy.zeros((len(pixels), len(starts), 3)) for _ in range(2))
    for block, start in enumerate(starts):
        for sample in range(start, min(end, start // BLOCK * BLOCK + BLOCK)):
            keep = kept[:, sample - first]
            value = pixels[keep, sample - first]
            count[keep, block] += 1
            sums[keep, block] += value
            # A square of single precision is exact in double.
            squares[keep, block] += value * value
    blocks = dump.table(0, "film", "blocks")
    paths = blocks["pixel"] * samples + blocks["first_sample"] - first
    same(dump, "film, blocks, count, from", paths, count.reshape(-1), blocks["count"])
    same(dump, "film, blocks, sum, from", paths, sums.reshape(-1, 3), blocks["sum"])
    same(dump, "film, blocks, square, from", paths, squares.reshape(-1, 3), blocks["square"])

    # Python rounds fractions to the nearest, ties to even.
    def exact(blocks, unit):
        return words([[sum(round(Fraction(float(b)) * unit) for b in c) for c in pixel.T] for pixel in blocks])

    exacts = dump.table(0, "film", "pixels")
    paths = numpy.arange(len(pixels)) * samples
    same(dump, "film, pixels, exact_sum, from", paths, exact(sums, 1 << 64), exacts["exact_sum"])
    same(dump, "film, pixels, exact_square, from", paths, exact(squares, 1 << 40), exacts["exact_square"])


def replay(root):
    dump = Dump(root)
    radiance = numpy.zeros((dump.manifest["paths"], 3), numpy.float32)
    edges = max(edge for edge, _, _ in dump.queues)
    with numpy.errstate(all="ignore"):
        for edge in range(1, edges + 1):
            encounters(dump, edge, radiance)
            shadow_rays(dump, edge, radiance)
        film(dump, radiance)
    lit = int((radiance > 0).any(axis=1).sum())
    return f"{root}: {len(radiance)} paths, {lit} with light, {edges} edges: the same bits"


def main():
    if len(sys.argv) != 2:
        print(__doc__.strip(), file=sys.stderr)
        return 2
    try:
        print(replay(sys.argv[1]))
        return 0
    except Exception as error:
        print(f"{sys.argv[1]}: {error}", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main())
