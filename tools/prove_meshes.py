#!/usr/bin/env python3
"""Proves, by images of Ondine alone, that meshes render like what they stand for.

    prove_meshes.py ONDINE [--only sphere|instances|light ...] [--size N] [--spp N] [--levels A,B] [--keep FOLDER]

sphere     A sphere of triangles with smooth normals against the analytic sphere, at growing levels of tessellation. Its
           vertices are on the sphere: triangles of size h sink h^2 / 8 below it, and all that follows (outline, shadow,
           shading between normals) is off by O(h^2) too. Each level halves h, so the error falls to a quarter: order 2.
           The error is the root mean square, relative to the mean, of differences over blocks of 8x8 pixels. Both images
           take the same random numbers, so their noise nearly cancels; what is left cancels in products of differences of
           two seeds, whose mean is the square of the error without bias. The finest level, with other random numbers, must
           agree with the analytic sphere by the statistics of check_references.py.
instances  Turned, squeezed, mirrored and moved instances of one mesh against one mesh with all of them in it.
light      A light of triangles, of very different sizes, against the quad that they fill, with each strategy.

Exits 0 when all holds, 1 when anything does not, 2 when it could not be tried. Needs the packages numpy and OpenEXR.
"""

import argparse
import math
import sys
import tempfile
from pathlib import Path

import numpy

import check_references
import generate

# Orders are asymptotic: this much is left to the terms that follow.
TOLERANCE = 0.15
SEEDS = [11, 12, 13, 14]

STAGE = """version = 1
[camera]
position = [0.0, 1.5, 5.0]
look_at = [0.0, 0.0, 0.0]
vertical_fov = 36.0

[materials.floor]
type = "lambert"
albedo = [0.6, 0.55, 0.5]
[materials.blue]
type = "lambert"
albedo = [0.3, 0.4, 0.7]
[[objects]]
quad = { corner = [-4.0, -1.0, 4.0], u = [8.0, 0.0, 0.0], v = [0.0, 0.0, -8.0] }
material = "floor"
[environment]
constant = [0.25, 0.3, 0.35]
"""
LAMP = 'quad = { corner = [-2.5, 2.5, -0.5], u = [1.0, 0.0, 0.0], v = [0.0, 0.3, 1.0] }'
LIGHT = "[[lights]]\n{shape}\nradiance = [14.0, 13.0, 12.0]\n"
OBJECT = '[[objects]]\n{shape}\nmaterial = "blue"\n'


class Stage:
    """A folder of scenes, and the program that renders them."""

    def __init__(self, options, folder):
        self.options, self.folder = options, Path(folder)

    def scene(self, name, *parts):
        path = self.folder / f"{name}.toml"
        path.write_text(STAGE + "".join(parts))
        return str(path)

    def mesh(self, name, vertices, corners, normals=None):
        columns = ["x", "y", "z"] if normals is None else ["x", "y", "z", "nx", "ny", "nz"]
        rows = vertices if normals is None else numpy.concatenate([vertices, normals], axis=1)
        generate.write_ply(self.folder / f"{name}.ply", columns, len(rows), len(corners), [rows], [corners])
        return f'mesh = {{ file = "{name}.ply" }}'

    def render(self, scene, seed, strategy="mis"):
        options = argparse.Namespace(sampler="pcg", seed=seed)
        size = (self.options.size, self.options.size)
        spp = self.options.spp * check_references.MORE_SAMPLES.get(strategy, 1)
        return check_references.render(self.options.program, scene, size, 4, strategy, spp, options, self.folder)[:2]

    def agree(self, name, scene, reference, strategy="mis"):
        """Whether two scenes are one image, by independent samples: block by block, and within three standard errors in all."""
        got = check_references.compare(*self.render(scene, 1, strategy), *self.render(reference, 2, strategy))
        agrees = min(got.p) > check_references.LEAST_P and abs(got.difference) <= 3 * got.error
        p = " ".join(f"{p:.4f}" for p in got.p)
        print(
            f"{name:<28} p {p}, greatest |z| {got.worst:.2f}, mean differs by {100 * got.difference:+.4f} % "
            f"+- {100 * got.error:.4f} %{'' if agrees else '  DIFFERS'}",
            flush=True,
        )
        return agrees


def squared_error(differences, mean):
    """Mean square of differences over blocks, relative to their mean, without the noise; and its standard error."""
    seeds = len(differences)
    total = differences.sum(axis=0)
    # The sum over pairs of different seeds: the square of the sum, less the squares.
    products = (total**2 - (differences**2).sum(axis=0)) / (seeds * (seeds - 1))
    noise = differences.var(axis=0, ddof=1)
    variance = 2 * noise**2 / (seeds * (seeds - 1)) + 4 * numpy.maximum(products, 0) * noise / seeds
    scale = mean**2 * products.size
    return products.sum() / scale, math.sqrt(variance.sum()) / scale


def sphere(stage):
    first, last = stage.options.levels
    lamp = LIGHT.format(shape=LAMP)
    exact = stage.scene("sphere", OBJECT.format(shape="sphere = { center = [0.0, 0.0, 0.0], radius = 1.0 }"), lamp)
    references = numpy.stack([check_references.block_sums(stage.render(exact, seed)[0]) for seed in SEEDS])
    holds, before = True, None
    for level in range(first, last + 1):
        points, corners = generate.icosphere(level)
        scene = stage.scene(f"sphere{level}", OBJECT.format(shape=stage.mesh(f"sphere{level}", points, corners, points)), lamp)
        images = numpy.stack([check_references.block_sums(stage.render(scene, seed)[0]) for seed in SEEDS])
        square, deviation = squared_error(images - references, references.mean())
        line = f"sphere, {len(corners):>6} triangles     error {100 * math.sqrt(max(square, 0)):.4f} %"
        if before:
            # The error of a logarithm is relative.
            order = math.log2(before[0] / square) / 2 if square > 0 else math.inf
            error = math.hypot(before[1] / before[0], deviation / square) / (2 * math.log(2))
            right = abs(order - 2) <= TOLERANCE + 3 * error and error < 0.5
            line += f", order {order:.2f} +- {error:.2f}{'' if right else '  IS NOT 2'}"
            holds &= right
        print(line, flush=True)
        before = square, deviation
    return stage.agree("sphere, the finest", scene, exact) and holds


def turned(angles):
    """About x, then y, then z, axes that stay where they are."""
    (cx, cy, cz), (sx, sy, sz) = numpy.cos(angles), numpy.sin(angles)
    about_x = numpy.array([[1, 0, 0], [0, cx, -sx], [0, sx, cx]])
    about_y = numpy.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    about_z = numpy.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]])
    return about_z @ about_y @ about_x


def instances(stage):
    n = 8
    rows = numpy.concatenate(list(generate.ball_blocks(n, 1)))
    corners = numpy.concatenate(list(generate.cube_faces(n)))
    shape = stage.mesh("ball", rows[:, :3], corners, rows[:, 3:])
    random = numpy.random.Generator(numpy.random.PCG64(3))
    parts, vertices, normals, faces = [], [], [], []
    for i in range(12):
        angles = numpy.round(random.uniform(-180, 180, 3), 3)
        scale = numpy.round(random.uniform(0.2, 0.6, 3) * random.choice([-1, 1], 3), 4)
        move = numpy.round(random.uniform([-1.6, -0.6, -1.5], [1.6, 1.0, 1.0]), 4)
        matrix = turned(numpy.radians(angles)) @ numpy.diag(scale)
        transform = f"translate = {move.tolist()}, rotate_degrees = {angles.tolist()}, scale = {scale.tolist()}"
        parts.append(OBJECT.format(shape=f"{shape}\ntransform = {{ {transform} }}"))
        faces.append(corners[:, :: int(numpy.sign(numpy.linalg.det(matrix)))] + len(rows) * i)
        vertices.append(rows[:, :3] @ matrix.T + move)
        normals.append(generate.unit(rows[:, 3:] @ numpy.linalg.inv(matrix)))
    lamp = LIGHT.format(shape=LAMP)
    whole = stage.mesh("whole", numpy.concatenate(vertices), numpy.concatenate(faces), numpy.concatenate(normals))
    flat = stage.scene("flat", OBJECT.format(shape=whole), lamp)
    return stage.agree("12 instances", stage.scene("instances", *parts, lamp), flat)


def light(stage):
    quad = stage.scene("quad", OBJECT.format(shape="sphere = { center = [0.0, -0.2, 0.0], radius = 0.8 }"), LIGHT.format(shape=LAMP))
    # A grid whose lines crowd towards one corner.
    at = numpy.linspace(0, 1, 7) ** 3
    u, v = (grid.ravel()[:, None] for grid in numpy.meshgrid(at, at, indexing="ij"))
    points = numpy.array([-2.5, 2.5, -0.5]) + u * [1.0, 0.0, 0.0] + v * [0.0, 0.3, 1.0]
    i, j = (grid.ravel() for grid in numpy.meshgrid(numpy.arange(6), numpy.arange(6), indexing="ij"))
    corners = generate.quads(i * 7 + j, (i + 1) * 7 + j, (i + 1) * 7 + j + 1, i * 7 + j + 1)
    shape = stage.mesh("lamp", points, corners)
    scene = stage.scene("mesh", OBJECT.format(shape="sphere = { center = [0.0, -0.2, 0.0], radius = 0.8 }"), LIGHT.format(shape=shape))
    return all([stage.agree(f"light of 72 triangles, {s}", scene, quad, s) for s in check_references.STRATEGIES])


PROOFS = {"sphere": sphere, "instances": instances, "light": light}


def levels(text):
    first, last = (int(word) for word in text.split(","))
    if not 2 <= first < last <= 8:
        raise ValueError
    return first, last


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", help="the ondine binary")
    parser.add_argument("--only", nargs="+", choices=PROOFS, default=list(PROOFS))
    parser.add_argument("--size", type=int, default=128, help="pixels on a side; default 128")
    parser.add_argument("--spp", type=int, default=1024, help="of light and mis; cosine takes 2 times, uniform 8 times as many")
    parser.add_argument("--levels", type=levels, default=(3, 6), metavar="A,B", help="of the sphere, 2 to 8; default 3,6")
    parser.add_argument("--keep", metavar="FOLDER", help="write scenes and meshes there, and leave them")
    options = parser.parse_args()
    try:
        with tempfile.TemporaryDirectory() as folder:
            if options.keep:
                Path(options.keep).mkdir(parents=True, exist_ok=True)
            stage = Stage(options, options.keep or folder)
            return 0 if all([PROOFS[name](stage) for name in options.only]) else 1
    except (OSError, ValueError, KeyError) as error:
        print(f"prove_meshes: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
