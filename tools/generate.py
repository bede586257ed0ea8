#!/usr/bin/env python3
"""Writes the meshes and scenes that are too large to keep.

    generate.py terrain OUT.ply  [--triangles N]    ridged fractal mountains, 100 units square, y up
    generate.py ball    OUT.ply  [--triangles N]    a closed ball of radius about 1 with waves on it
    generate.py sphere  OUT.ply  [--levels N]       the unit sphere, an icosahedron split N times: 20 * 4^N triangles
    generate.py scatter OUT.gltf [--instances N]    rocks, trees and lamps on a ground; writes OUT.bin too
    generate.py --self-test

The same arguments give the same bytes. N triangles are met as nearly as the grid allows. Meshes are little-endian binary PLY
with normals (and, of the terrain, texture coordinates), written in blocks: ten million triangles take some 300 MiB of disk and
little memory. `scatter` is glTF 2.0 with one node for each instance. Needs the package numpy.
"""

import argparse
import json
import math
import sys
import tempfile
from pathlib import Path

import numpy

BLOCK = 1 << 18
FLOATS = "<f4"


# PLY


def write_ply(path, properties, vertices, faces, vertex_blocks, face_blocks):
    """Vertices are arrays of `properties` columns, faces of three indices; both come in blocks."""
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {vertices}"]
    header += [f"property float {name}" for name in properties]
    header += [f"element face {faces}", "property list uchar int vertex_indices", "end_header", ""]
    with open(path, "wb") as out:
        out.write("\n".join(header).encode())
        for block in vertex_blocks:
            out.write(block.astype(FLOATS).tobytes())
        for block in face_blocks:
            record = numpy.empty(len(block), dtype=[("count", "u1"), ("corners", "<i4", 3)])
            record["count"], record["corners"] = 3, block
            out.write(record.tobytes())


def read_ply(path):
    """What `write_ply` wrote: rows of vertices, and corners."""
    with open(path, "rb") as file:
        columns, counts = 0, {}
        while (words := file.readline().split()) != [b"end_header"]:
            columns += words[:2] == [b"property", b"float"]
            if words[0] == b"element":
                counts[words[1]] = int(words[2])
        vertices = numpy.frombuffer(file.read(counts[b"vertex"] * columns * 4), FLOATS).reshape(-1, columns)
        record = numpy.dtype([("count", "u1"), ("corners", "<i4", 3)])
        return vertices, numpy.frombuffer(file.read(), record)["corners"]


def unit(vectors):
    return vectors / numpy.linalg.norm(vectors, axis=-1, keepdims=True)


def quads(a, b, c, d):
    """Two triangles for each quad of corners a, b, c, d."""
    return numpy.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)


# Terrain

TERRAIN_SIDE = 100.0
TERRAIN_HEIGHT = 14.0


def noise(x, z, seed):
    """Gradient noise on the integer lattice (Perlin 2002, Improving Noise), in about [-1, 1]."""
    ix, iz = numpy.floor(x).astype(numpy.int64), numpy.floor(z).astype(numpy.int64)
    fx, fz = x - ix, z - iz

    def corner(dx, dz):
        h = (ix + dx) * 0x9E3779B1 + (iz + dz) * 0x85EBCA77 + seed * 0xC2B2AE3D & 0xFFFFFFFF
        h = (h ^ h >> 15) * 0x2C1B3C6D & 0xFFFFFFFF
        h = (h ^ h >> 12) * 0x297A2D39 & 0xFFFFFFFF
        turn = (h ^ h >> 15) * (2 * math.pi / 2**32)
        return numpy.cos(turn) * (fx - dx) + numpy.sin(turn) * (fz - dz)

    sx, sz = (f**3 * (f * (f * 6 - 15) + 10) for f in (fx, fz))
    near = corner(0, 0) * (1 - sx) + corner(1, 0) * sx
    far = corner(0, 1) * (1 - sx) + corner(1, 1) * sx
    return 1.4 * (near * (1 - sz) + far * sz)


def ridges(x, z, octaves, seed):
    """Ridged multifractal (Musgrave, in Ebert et al., Texturing and Modeling, 3rd ed., ch. 16), in about [0, 1]."""
    total, weight, gain, frequency = 0.0, 1.0, 0.5, 3.0
    for octave in range(octaves):
        # Crests are a little round, or no normal there would do for both sides.
        valley = numpy.hypot(noise(x * frequency, z * frequency, seed + octave), 0.07)
        ridge = (1 - valley) ** 2 * weight
        weight = numpy.clip(2 * ridge, 0, 1)
        total, gain, frequency = total + ridge * gain, gain * 0.5, frequency * 2.03
    return total


def terrain(path, triangles, seed):
    cells = max(2, round(math.sqrt(triangles / 2)))
    row = cells + 1
    # Down to ridges of four cells.
    octaves = max(1, round(math.log2(cells / 12)))
    rows = max(1, BLOCK // row)

    def heights(first, last):
        """Rows `first` to `last`, and one more on all sides, for the slopes."""
        z, x = numpy.arange(first - 1, last + 1) / cells, numpy.arange(-1, row + 1) / cells
        x, z = numpy.broadcast_arrays(x[None, :], z[:, None])
        return TERRAIN_HEIGHT * ridges(x, z, octaves, seed)

    def vertex_blocks():
        for first in range(0, row, rows):
            last = min(first + rows, row)
            h = heights(first, last)
            z, x = numpy.meshgrid(numpy.arange(first, last) / cells, numpy.arange(row) / cells, indexing="ij")
            step = 2 * TERRAIN_SIDE / cells
            slope_x = (h[1:-1, 2:] - h[1:-1, :-2]) / step
            slope_z = (h[2:, 1:-1] - h[:-2, 1:-1]) / step
            normal = unit(numpy.stack([-slope_x, numpy.ones_like(x), -slope_z], axis=-1))
            place = numpy.stack([(x - 0.5) * TERRAIN_SIDE, h[1:-1, 1:-1], (z - 0.5) * TERRAIN_SIDE], axis=-1)
            yield numpy.concatenate([place, normal, x[..., None], 1 - z[..., None]], axis=-1).reshape(-1, 8)

    def face_blocks():
        for first in range(0, cells, rows):
            z, x = numpy.meshgrid(numpy.arange(first, min(first + rows, cells)), numpy.arange(cells), indexing="ij")
            a = (z * row + x).ravel()
            yield quads(a, a + row, a + row + 1, a + 1)

    properties = ["x", "y", "z", "nx", "ny", "nz", "u", "v"]
    write_ply(path, properties, row * row, 2 * cells * cells, vertex_blocks(), face_blocks())


# Ball


def cube_index(i, j, k, n):
    """Number of a lattice point on the surface of the cube [0, n]^3: the layer k = 0, rings, the layer k = n."""
    ring = numpy.select([j == 0, i == n, j == n], [i, n + j, 3 * n - i], 4 * n - j) % (4 * n)
    layer, side = i * (n + 1) + j, (n + 1) ** 2
    return numpy.select([k == 0, k == n], [layer, side + 4 * n * (n - 1) + layer], side + 4 * n * (k - 1) + ring)


def ring(n):
    """i and j around the cube, counter-clockwise seen from +k."""
    up, level = numpy.arange(n), numpy.full(n, n)
    zero = numpy.zeros(n, dtype=int)
    return numpy.concatenate([up, level, n - up, zero]), numpy.concatenate([zero, up, level, n - up])


def cube_blocks(n):
    """Lattice points i, j, k on the surface of the cube, in the order of their numbers."""
    i, j = (grid.ravel() for grid in numpy.meshgrid(numpy.arange(n + 1), numpy.arange(n + 1), indexing="ij"))
    around = ring(n)
    yield numpy.stack([i, j, numpy.zeros_like(i)], axis=-1)
    layers = max(1, BLOCK // (4 * n))
    for first in range(1, n, layers):
        k = numpy.arange(first, min(first + layers, n))
        yield numpy.stack([numpy.tile(around[0], len(k)), numpy.tile(around[1], len(k)), numpy.repeat(k, 4 * n)], axis=-1)
    yield numpy.stack([i, j, numpy.full_like(i, n)], axis=-1)


def cube_faces(n):
    """Triangles of the cube's surface, seen counter-clockwise from outside."""
    i, j = (grid.ravel() for grid in numpy.meshgrid(numpy.arange(n), numpy.arange(n), indexing="ij"))
    at = lambda i, j, k: cube_index(i, j, numpy.full_like(i, k), n)
    yield quads(at(i, j, 0), at(i, j + 1, 0), at(i + 1, j + 1, 0), at(i + 1, j, 0))
    (i0, j0), (i1, j1) = ring(n), (numpy.roll(c, -1) for c in ring(n))
    for k in range(n):
        yield quads(at(i0, j0, k), at(i1, j1, k), at(i1, j1, k + 1), at(i0, j0, k + 1))
    yield quads(at(i, j, n), at(i + 1, j, n), at(i + 1, j + 1, n), at(i, j + 1, n))


def waves(seed):
    """Wave vectors, phases and amplitudes: some 0.25 in all."""
    random = numpy.random.Generator(numpy.random.PCG64(seed))
    length = numpy.geomspace(2, 40, 24)
    vectors = unit(random.normal(size=(24, 3))) * length[:, None]
    return vectors, random.uniform(0, 2 * math.pi, 24), 0.16 / length


def displaced(directions, seed):
    """The ball's surface in these directions, and its normals."""
    vectors, phases, amplitudes = waves(seed)
    angle = directions @ vectors.T + phases
    radius = 1 + numpy.sin(angle) @ amplitudes
    # The surface is |p| = r(p / |p|): its normal is the gradient of |p| - r, and r varies along the sphere alone.
    gradient = (numpy.cos(angle) * amplitudes) @ vectors
    gradient -= (gradient * directions).sum(axis=-1, keepdims=True) * directions
    return directions * radius[:, None], unit(directions - gradient / radius[:, None])


def ball_blocks(n, seed):
    for block in cube_blocks(n):
        for part in numpy.array_split(block, -(-len(block) // BLOCK)):
            # Equal angles along each axis make quads of nearly one size.
            directions = unit(numpy.tan((part / n * 2 - 1) * (math.pi / 4)))
            yield numpy.concatenate(displaced(directions, seed), axis=-1)


def ball(path, triangles, seed):
    n = max(2, round(math.sqrt(triangles / 12)))
    write_ply(path, ["x", "y", "z", "nx", "ny", "nz"], 6 * n * n + 2, 12 * n * n, ball_blocks(n, seed), cube_faces(n))


# Sphere


def icosphere(levels):
    """Unit vertices and corners."""
    golden = (1 + math.sqrt(5)) / 2
    points = [p for a in (-1, 1) for b in (-golden, golden) for p in ((0, a, b), (a, b, 0), (b, 0, a))]
    points = unit(numpy.array(points, dtype=float))
    near = numpy.linalg.norm(points[:, None] - points[None], axis=-1) < 1.2
    triples = [(a, b, c) for a in range(12) for b in range(a) for c in range(b) if near[a, b] and near[b, c] and near[c, a]]
    corners = numpy.array([(a, b, c) if numpy.linalg.det(points[[a, b, c]]) > 0 else (a, c, b) for a, b, c in triples])
    for _ in range(levels):
        edges = numpy.sort(corners[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        edges, middle = numpy.unique(edges, axis=0, return_inverse=True)
        ab, bc, ca = (len(points) + middle.reshape(-1, 3)).T
        a, b, c = corners.T
        points = numpy.concatenate([points, unit(points[edges].sum(axis=1))])
        corners = numpy.stack([a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca], axis=-1).reshape(-1, 3)
    return points, corners


def sphere(path, levels):
    points, corners = icosphere(levels)
    rows = numpy.concatenate([points, points], axis=-1)
    write_ply(path, ["x", "y", "z", "nx", "ny", "nz"], len(points), len(corners), [rows], [corners])


# Scatter


class Gltf:
    """A glTF document under construction, and its one buffer."""

    def __init__(self):
        self.bytes = bytearray()
        self.document = {
            "asset": {"version": "2.0", "generator": "tools/generate.py"},
            "extensionsUsed": ["KHR_materials_emissive_strength"],
            "scene": 0,
            "scenes": [{"nodes": []}],
            **{name: [] for name in ("nodes", "meshes", "materials", "accessors", "bufferViews", "cameras")},
        }

    def add(self, kind, value):
        self.document[kind].append(value)
        return len(self.document[kind]) - 1

    def accessor(self, array, target):
        """FLOAT vectors for vertices (34962), UNSIGNED_INT scalars for indices (34963)."""
        data = array.astype("<u4" if array.ndim == 1 else FLOATS)
        view = {"buffer": 0, "byteOffset": len(self.bytes), "byteLength": data.nbytes, "target": target}
        self.bytes += data.tobytes()
        accessor = {"bufferView": self.add("bufferViews", view), "componentType": 5125 if array.ndim == 1 else 5126}
        accessor |= {"count": len(data), "type": "SCALAR" if array.ndim == 1 else "VEC3"}
        if array.ndim == 2:
            accessor |= {"min": data.min(axis=0).tolist(), "max": data.max(axis=0).tolist()}
        return self.add("accessors", accessor)

    def mesh(self, name, *parts):
        """Parts are vertices, normals, corners and a material."""
        primitives = []
        for vertices, normals, corners, material in parts:
            attributes = {"POSITION": self.accessor(vertices, 34962), "NORMAL": self.accessor(normals, 34962)}
            indices = self.accessor(corners.ravel(), 34963)
            primitives.append({"attributes": attributes, "indices": indices, "material": material})
        return self.add("meshes", {"name": name, "primitives": primitives})

    def material(self, name, color, metallic=0.0, roughness=1.0, emission=None):
        material = {"name": name}
        material["pbrMetallicRoughness"] = {
            "baseColorFactor": [*color, 1.0],
            "metallicFactor": metallic,
            "roughnessFactor": roughness,
        }
        if emission:
            strength = max(emission)
            material["emissiveFactor"] = [c / strength for c in emission]
            material["extensions"] = {"KHR_materials_emissive_strength": {"emissiveStrength": strength}}
        return self.add("materials", material)

    def node(self, **values):
        self.document["scenes"][0]["nodes"].append(self.add("nodes", values))

    def write(self, path):
        buffer = path.with_suffix(".bin")
        self.document["buffers"] = [{"uri": buffer.name, "byteLength": len(self.bytes)}]
        buffer.write_bytes(self.bytes)
        path.write_text(json.dumps(self.document, separators=(",", ":")) + "\n")


def lathe(profile, around):
    """Turns a profile of (radius, height), top to bottom, around y; normals across its segments."""
    radius, height = numpy.array(profile, dtype=float).T
    turn = numpy.arange(around) / around * 2 * math.pi
    spread = lambda r, y: numpy.stack([numpy.outer(r, numpy.cos(turn)), numpy.outer(y, numpy.ones(around)), numpy.outer(r, numpy.sin(turn))], axis=-1)
    points, normals = spread(radius, height), unit(spread(-numpy.gradient(height), numpy.gradient(radius)))
    i, j = numpy.meshgrid(numpy.arange(len(radius) - 1), numpy.arange(around), indexing="ij")
    next_j = (j + 1) % around
    a, b, c, d = (at.ravel() for at in (i * around + j, (i + 1) * around + j, (i + 1) * around + next_j, i * around + next_j))
    corners = quads(a, d, c, b)
    # Where the profile begins or ends on the axis, every other triangle is none.
    a, b, c = points.reshape(-1, 3)[corners.T]
    corners = corners[numpy.linalg.norm(numpy.cross(b - a, c - a), axis=1) > 0]
    return points.reshape(-1, 3), normals.reshape(-1, 3), corners


def rock(seed):
    n = 6
    rows = numpy.concatenate(list(ball_blocks(n, seed)))
    return rows[:, :3], rows[:, 3:], numpy.concatenate(list(cube_faces(n)))


def looking(eye, at):
    """The rotation, a quaternion x y z w, of a camera that looks along -z."""
    back = unit(numpy.subtract(eye, at).astype(float))
    right = unit(numpy.cross([0, 1, 0], back))
    matrix = numpy.stack([right, numpy.cross(back, right), back], axis=-1)
    w = math.sqrt(1 + numpy.trace(matrix)) / 2
    x, y, z = (matrix[c] - matrix.T[c] for c in range(3))
    return [float(-y[2] / (4 * w)), float(x[2] / (4 * w)), float(-x[1] / (4 * w)), w]


def scatter(path, instances, seed):
    random = numpy.random.Generator(numpy.random.PCG64(seed))
    gltf = Gltf()
    earth = gltf.material("earth", [0.32, 0.26, 0.18], roughness=0.95)
    stone = gltf.material("stone", [0.42, 0.41, 0.40], roughness=0.6)
    bark = gltf.material("bark", [0.22, 0.14, 0.08], roughness=0.9)
    leaf = gltf.material("leaf", [0.10, 0.30, 0.07], roughness=0.7)
    brass = gltf.material("brass", [0.91, 0.78, 0.42], metallic=1.0, roughness=0.25)
    glow = gltf.material("glow", [0.0, 0.0, 0.0], emission=[40.0, 26.0, 12.0])
    sky = gltf.material("panel", [0.0, 0.0, 0.0], emission=[9.0, 10.0, 12.0])

    cone = lathe([(0.0, 2.2), (0.3, 1.5), (0.6, 0.8), (0.9, 0.3)], 12)
    trunk = lathe([(0.12, 0.5), (0.14, 0.2), (0.16, -0.2)], 8)
    bulb = lathe([(0.0, 0.9), (0.12, 0.85), (0.16, 0.7), (0.12, 0.55), (0.0, 0.5)], 10)
    post = lathe([(0.05, 0.5), (0.05, 0.1), (0.15, -0.1)], 8)
    kinds = [
        (0.45, gltf.mesh("rock", (*rock(seed), stone)), 0.3),
        (0.35, gltf.mesh("tree", (*cone, leaf), (*trunk, bark)), 1.0),
        (0.19, gltf.mesh("ingot", (*rock(seed + 1), brass)), 0.15),
        (0.01, gltf.mesh("lamp", (*bulb, glow), (*post, brass)), 1.2),
    ]
    side = 1.2 * math.sqrt(instances)
    ground = numpy.array([(-1, 0, -1), (-1, 0, 1), (1, 0, 1), (1, 0, -1)]) * side
    up, square = numpy.tile([0.0, 1.0, 0.0], (4, 1)), numpy.array([[0, 1, 2], [0, 2, 3]])
    gltf.node(mesh=gltf.mesh("ground", (ground, up, square, earth)), name="ground")
    panel = gltf.mesh("panel", (ground * 0.2, -up, square[:, ::-1], sky))
    gltf.node(mesh=panel, name="panel", translation=[-0.5 * side, 0.8 * side, 0.0])

    kind = random.choice(len(kinds), size=instances, p=[share for share, _, _ in kinds])
    places = random.uniform(-0.5 * side, 0.5 * side, (instances, 2))
    turns = random.uniform(0, 2 * math.pi, instances)
    sizes = random.lognormal(0, 0.3, instances)
    for which, (x, z), turn, size in zip(kind, places, turns, sizes):
        _, mesh, scale = kinds[which]
        gltf.node(
            mesh=mesh,
            translation=[round(float(x), 4), 0.0, round(float(z), 4)],
            rotation=[0.0, round(math.sin(turn / 2), 6), 0.0, round(math.cos(turn / 2), 6)],
            scale=[round(float(size * scale), 4)] * 3,
        )
    eye = [0.35 * side, 0.16 * side, 0.55 * side]
    camera = gltf.add("cameras", {"type": "perspective", "perspective": {"yfov": 0.8, "aspectRatio": 1.5, "znear": 0.1}})
    gltf.node(camera=camera, name="camera", translation=eye, rotation=looking(eye, [0, 0, 0]))
    gltf.write(path)


# Self-test


def assert_closed(vertices, corners):
    """Each edge is run along once in each direction, and the volume inside is positive."""
    edges = corners[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    there, back = (set(map(tuple, e)) for e in (edges, edges[:, ::-1]))
    assert len(there) == len(edges) and there == back, "open edges"
    a, b, c = (vertices[corners[:, k], :3].astype(float) for k in range(3))
    volume = (a * numpy.cross(b, c)).sum() / 6
    assert volume > 1, volume


def assert_normals(vertices, corners, least):
    """Normals are unit, and those of corners agree with their triangle's."""
    a, b, c = (vertices[corners[:, k], :3].astype(float) for k in range(3))
    flat = numpy.cross(b - a, c - a)
    assert (numpy.linalg.norm(flat, axis=1) > 0).all(), "triangles without area"
    assert abs(numpy.linalg.norm(vertices[:, 3:6], axis=1) - 1).max() < 1e-6
    cosines = (unit(flat)[:, None] * vertices[corners, 3:6]).sum(axis=-1)
    assert cosines.min() > least, cosines.min()


def self_test():
    """Counts, closedness and normals of small ones, the same bytes twice, and blocks that leave no seam."""
    global BLOCK
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        path = folder / "mesh.ply"
        for write, count, least in [
            (lambda: terrain(path, 20_000, 1), 20_000, 0.4),
            (lambda: ball(path, 30_000, 1), 30_000, 0.9),
            (lambda: sphere(path, 3), 1280, 0.98),
        ]:
            write()
            first = path.read_bytes()
            whole, BLOCK = BLOCK, 1000
            write()
            BLOCK = whole
            assert path.read_bytes() == first, "blocks show"
            vertices, corners = read_ply(path)
            assert abs(len(corners) / count - 1) < 0.01, len(corners)
            assert len(numpy.unique(corners)) == len(vertices) == corners.max() + 1
            assert numpy.isfinite(vertices).all()
            assert_normals(vertices, corners, least)
            if vertices.shape[1] == 6:
                assert_closed(vertices, corners)
            else:
                assert vertices[:, 1].max() - vertices[:, 1].min() > 8, "the terrain is flat"
                assert vertices[:, 6:].min() == 0 and vertices[:, 6:].max() == 1
        radius = numpy.linalg.norm(vertices[:, :3], axis=1)
        assert abs(radius - 1).max() < 1e-6

        path = folder / "scatter.gltf"
        scatter(path, 300, 1)
        first = path.read_bytes(), path.with_suffix(".bin").read_bytes()
        scatter(path, 300, 1)
        assert (path.read_bytes(), path.with_suffix(".bin").read_bytes()) == first
        document = json.loads(first[0])
        assert len(document["nodes"]) == 303 and len(document["cameras"]) == 1
        assert document["buffers"][0]["byteLength"] == len(first[1])
        for mesh in document["meshes"]:
            for primitive in mesh["primitives"]:
                arrays = []
                for index in (*primitive["attributes"].values(), primitive["indices"]):
                    accessor = document["accessors"][index]
                    view = document["bufferViews"][accessor["bufferView"]]
                    kind = FLOATS if accessor["type"] == "VEC3" else "<u4"
                    arrays.append(numpy.frombuffer(first[1], kind, view["byteLength"] // 4, view["byteOffset"]))
                assert_normals(numpy.concatenate([a.reshape(-1, 3) for a in arrays[:2]], axis=1), arrays[2].reshape(-1, 3), 0.2)
        x, y, z, w = document["nodes"][-1]["rotation"]
        ahead = numpy.array([-2 * (x * z + w * y), -2 * (y * z - w * x), -(1 - 2 * (x * x + y * y))])
        eye = numpy.array(document["nodes"][-1]["translation"])
        assert numpy.allclose(ahead, unit(-eye), atol=1e-6), (ahead, unit(-eye))
    print("generate: the self-test passes")
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", nargs="?", choices=["terrain", "ball", "sphere", "scatter"])
    parser.add_argument("out", nargs="?", type=Path, help="the file to write")
    parser.add_argument("--triangles", type=int, default=1_000_000, help="of terrain and ball, 8 to 10^8; default 10^6")
    parser.add_argument("--levels", type=int, default=5, help="of sphere, 0 to 10; default 5")
    parser.add_argument("--instances", type=int, default=10_000, help="of scatter, 1 to 10^6; default 10^4")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--self-test", action="store_true", help="check small ones, write nothing")
    options = parser.parse_args()
    if options.self_test:
        return self_test()
    if not options.out:
        parser.error("say what to write, and where")
    for name, low, high in [("triangles", 8, 10**8), ("levels", 0, 10), ("instances", 1, 10**6), ("seed", 0, 2**31)]:
        if not low <= getattr(options, name) <= high:
            parser.error(f"--{name} is from {low} to {high}")
    try:
        if options.what == "sphere":
            sphere(options.out, options.levels)
        elif options.what == "scatter":
            scatter(options.out, options.instances, options.seed)
        else:
            write = terrain if options.what == "terrain" else ball
            write(options.out, options.triangles, options.seed)
    except OSError as error:
        print(f"generate: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
