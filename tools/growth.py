#!/usr/bin/env python3
"""Measures how the tree grows: terrains of 10^4 to 10^7 triangles, traced by `ondine rays`, as a table in Markdown.

    growth.py ONDINE [--triangles N ...] [--threads N] [--repeat N] [--side N] [--folder FOLDER] [--json]

Each terrain of tools/generate.py has the same shape in more detail. Rays: `primary`, SIDE x SIDE from one camera in tiles of
8x8 pixels; `diffuse`, from what those met, cosine-distributed about the triangle's normal, in that order; `shuffled`, the same
in random order; `shadow`, from there towards a lamp 25 units square, any hit. The last columns divide by what theory says: time
a ray (ns) over log2 n, build time (ns) a triangle over log2 n. Both stay nearly level if traversal grows like log n and
building like n log n, but for what no longer fits in caches.

--json prints the rows as one array. Meshes and rays stay in FOLDER if one is named (some 700 MB). Needs the package numpy.
"""

import argparse
import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy

import generate

HIT = numpy.dtype([("distance", "<f4"), ("triangle", "<u4")])
MISS = 0xFFFFFFFF
EYE, AT, FIELD_OF_VIEW = [-46.0, 19.0, -46.0], [0.0, 0.0, 0.0], 50.0
LAMP = [[20.0, 70.0, -20.0], [25.0, 0.0, 0.0], [0.0, 0.0, 25.0]]


def random(seed):
    return numpy.random.Generator(numpy.random.PCG64(seed))


def write_rays(path, origin, direction, farthest=1e30):
    """Eight floats a ray: origin, least distance, unit direction, greatest distance."""
    rays = numpy.empty((len(direction), 8), "<f4")
    rays[:, :3], rays[:, 3], rays[:, 4:7], rays[:, 7] = origin, 0, generate.unit(direction), farthest
    rays.tofile(path)


def primary(side):
    """Directions through the pixels of a square image, tile by tile, jittered."""
    tiles, pixels = numpy.arange(side // 8), numpy.arange(8)
    grid = numpy.meshgrid(tiles, tiles, pixels, pixels, indexing="ij")
    tile_y, tile_x, y, x = (axis.ravel() for axis in grid)
    jitter = random(1).random((2, side * side))
    ahead = generate.unit(numpy.subtract(AT, EYE))
    right = generate.unit(numpy.cross(ahead, [0, 1, 0]))
    spread = math.tan(math.radians(FIELD_OF_VIEW) / 2)
    across = ((tile_x * 8 + x + jitter[0]) / side * 2 - 1) * spread
    down = ((tile_y * 8 + y + jitter[1]) / side * 2 - 1) * spread
    return ahead + across[:, None] * right - down[:, None] * numpy.cross(right, ahead)


class Tree:
    """One mesh, traced by the program."""

    def __init__(self, options, mesh):
        self.options, self.mesh = options, mesh

    def trace(self, rays, kind="closest", hits=None):
        command = [self.options.program, "rays", self.mesh, rays, "--kind", kind, "--json"]
        command += ["--threads", self.options.threads, "--repeat", self.options.repeat]
        command += ["--hits", hits] if hits else []
        done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
        if done.returncode != 0:
            raise ValueError(f"{' '.join(map(str, command))}: exit code {done.returncode}: {done.stderr.strip()}")
        return json.loads(done.stdout)


def bounces(mesh, hits, direction):
    """Where rays met the mesh, a little above it, and its normal there, towards the camera."""
    vertices, corners = generate.read_ply(mesh)
    met = hits["triangle"] != MISS
    a, b, c = (vertices[corners[hits["triangle"][met]][:, k], :3].astype(float) for k in range(3))
    normal = generate.unit(numpy.cross(b - a, c - a))
    normal[(normal * direction[met]).sum(axis=1) > 0] *= -1
    points = numpy.array(EYE) + hits["distance"][met, None] * generate.unit(direction[met])
    return points + 1e-3 * normal, normal


def measure(options, folder, triangles):
    """The program's reports on each set of rays."""
    mesh = folder / f"terrain{triangles}.ply"
    if not mesh.exists():
        generate.terrain(mesh, triangles, 1)
    tree, reports = Tree(options, mesh), {}
    sets = {name: folder / f"{triangles}.{name}.f32" for name in ("primary", "diffuse", "shuffled", "shadow")}
    direction = primary(options.side)
    write_rays(sets["primary"], EYE, direction)
    hits = folder / f"{triangles}.hits"
    reports["primary"] = tree.trace(sets["primary"], hits=hits)
    origin, normal = bounces(mesh, numpy.fromfile(hits, HIT), direction)
    numbers = random(2)
    # Cosine-distributed: the normal and a point of the unit sphere.
    scattered = 1.0001 * normal + generate.unit(numbers.normal(size=normal.shape))
    write_rays(sets["diffuse"], origin, scattered)
    order = numbers.permutation(len(origin))
    write_rays(sets["shuffled"], origin[order], scattered[order])
    corner, u, v = (numpy.array(edge) for edge in LAMP)
    to_lamp = corner + numbers.random((len(origin), 1)) * u + numbers.random((len(origin), 1)) * v - origin
    facing = (to_lamp * normal).sum(axis=1) > 0
    distance = numpy.linalg.norm(to_lamp[facing], axis=1)
    write_rays(sets["shadow"], origin[facing], to_lamp[facing], 0.999 * distance)
    for name in ("diffuse", "shuffled", "shadow"):
        reports[name] = tree.trace(sets[name], "any" if name == "shadow" else "closest")
    return 2 * round(math.sqrt(triangles / 2)) ** 2, reports


def rows(options, folder):
    """What the table shows, one mesh after the other."""
    for wanted in options.triangles:
        count, reports = measure(options, folder, wanted)
        build = sorted(report["build_s"] for report in reports.values())[len(reports) // 2]
        speeds = {name: reports[name]["mrays_per_s"] for name in ("primary", "diffuse", "shuffled", "shadow")}
        size = (reports["primary"]["node_bytes"] + reports["primary"]["triangle_bytes"]) / count
        log = math.log2(count)
        by_log = {"diffuse_ns_by_log": 1e3 / speeds["diffuse"] / log, "build_ns_by_log": 1e9 * build / count / log}
        yield {"triangles": count, "build_s": build, "mrays_per_s": speeds, "bytes_a_triangle": size, **by_log}


def table(options, folder):
    print("| triangles | build, s | primary | diffuse | shuffled | shadow | bytes a triangle | ns a diffuse ray / log2 n | build ns a triangle / log2 n |")
    print("|" + "---:|" * 9)
    for row in rows(options, folder):
        columns = [f"{row['triangles']:,}", f"{row['build_s']:.3f}", *(f"{speed:.2f}" for speed in row["mrays_per_s"].values())]
        columns += [f"{row['bytes_a_triangle']:.0f}", f"{row['diffuse_ns_by_log']:.2f}", f"{row['build_ns_by_log']:.2f}"]
        print(f"| {' | '.join(columns)} |", flush=True)
    print(f"\nM rays/s, {options.threads} threads, median of {options.repeat}.")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", help="the ondine binary")
    parser.add_argument("--triangles", type=int, nargs="+", default=[10**4, 10**5, 10**6, 10**7])
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--side", type=int, default=1024, help="of the image of primary rays, a multiple of 8; default 1024")
    parser.add_argument("--folder", type=Path, help="keep meshes and rays there")
    parser.add_argument("--json", action="store_true", help="print one JSON array instead of a table")
    options = parser.parse_args()
    if options.side < 8 or options.side % 8:
        parser.error("--side is a multiple of 8")
    try:
        with tempfile.TemporaryDirectory() as folder:
            if options.folder:
                options.folder.mkdir(parents=True, exist_ok=True)
            folder = options.folder or Path(folder)
            if options.json:
                print(json.dumps(list(rows(options, folder))))
            else:
                table(options, folder)
    except (OSError, ValueError, KeyError) as error:
        print(f"growth: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
