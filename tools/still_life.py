#!/usr/bin/env python3
"""Writes scenes/still-life.glb: a glTF 2.0 scene with something of all that Ondine reads.

    still_life.py OUT.glb

A vase with base-colour, metallic-roughness and normal textures stands on a tiled table in a ring of golden beads
(instances of one mesh), beside a ball of glass, under a lamp that emits. Plain Python; the same bytes every time.
"""

import json
import math
import struct
import sys
import zlib

FLOAT, UNSIGNED_SHORT = 5126, 5123
TAU = 2 * math.pi


class Glb:
    """The JSON and the buffer of a file in the making."""

    def __init__(self):
        self.buffer = bytearray()
        self.json = {"asset": {"version": "2.0", "generator": "Ondine tools/still_life.py"}, "scene": 0}

    def add(self, kind, item):
        items = self.json.setdefault(kind, [])
        items.append(item)
        return len(items) - 1

    def view(self, data):
        self.buffer.extend(bytes(-len(self.buffer) % 4))
        start = len(self.buffer)
        self.buffer.extend(data)
        return self.add("bufferViews", {"buffer": 0, "byteOffset": start, "byteLength": len(data)})

    def vectors(self, rows, bounds=False):
        flat = [x for row in rows for x in row]
        width = len(rows[0])
        accessor = {
            "bufferView": self.view(struct.pack(f"<{len(flat)}f", *flat)),
            "componentType": FLOAT,
            "count": len(rows),
            "type": f"VEC{width}",
        }
        if bounds:
            columns = [struct.unpack(f"<{len(rows)}f", struct.pack(f"<{len(rows)}f", *c)) for c in zip(*rows)]
            accessor |= {"min": [min(c) for c in columns], "max": [max(c) for c in columns]}
        return self.add("accessors", accessor)

    def mesh(self, name, grid, material):
        """`grid`: rows of (position, normal, uv), counter-clockwise from outside along rows and then columns."""
        columns = len(grid[0])
        vertices = [vertex for row in grid for vertex in row]
        corners = []
        for i in range(len(grid) - 1):
            for j in range(columns - 1):
                a, b = i * columns + j, (i + 1) * columns + j
                corners += [a, b, b + 1, a, b + 1, a + 1]
        # A pole is a row of one point: its triangles without an area are left out.
        point = lambda c: tuple(round(x, 7) for x in vertices[c][0])
        triangles = [corners[k : k + 3] for k in range(0, len(corners), 3)]
        triangles = [t for t in triangles if len({point(c) for c in t}) == 3]
        corners = [c for t in triangles for c in t]
        indices = self.view(struct.pack(f"<{len(corners)}H", *corners))
        primitive = {
            "attributes": {
                "POSITION": self.vectors([v[0] for v in vertices], bounds=True),
                "NORMAL": self.vectors([v[1] for v in vertices]),
                "TEXCOORD_0": self.vectors([v[2] for v in vertices]),
            },
            "indices": self.add(
                "accessors",
                {"bufferView": indices, "componentType": UNSIGNED_SHORT, "count": len(corners), "type": "SCALAR"},
            ),
            "material": material,
        }
        return self.add("meshes", {"name": name, "primitives": [primitive]})

    def texture(self, name, side, pixel):
        """A square image of `pixel(u, v)`, each channel in [0, 1]."""
        rows = bytearray()
        for y in range(side):
            rows.append(0)
            for x in range(side):
                color = pixel((x + 0.5) / side, (y + 0.5) / side)
                rows.extend(round(255 * min(max(c, 0), 1)) for c in color)
        chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        header = struct.pack(">IIBBBBB", side, side, 8, 2, 0, 0, 0)
        png = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(bytes(rows), 9)) + chunk(b"IEND", b"")
        image = self.add("images", {"name": name, "bufferView": self.view(png), "mimeType": "image/png"})
        return self.add("textures", {"source": image})

    def write(self, path):
        self.json["buffers"] = [{"byteLength": len(self.buffer)}]
        text = json.dumps(self.json, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        self.buffer.extend(bytes(-len(self.buffer) % 4))
        chunks = struct.pack("<I4s", len(text), b"JSON") + text
        chunks += struct.pack("<I4s", len(self.buffer), b"BIN\0") + bytes(self.buffer)
        with open(path, "wb") as file:
            file.write(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)


def lathe(profile, rows, columns):
    """A surface of revolution around y; `profile(t)` is (radius, height) from the bottom up, t in [0, 1]."""
    grid = []
    for i in range(rows + 1):
        t = i / rows
        radius, height = profile(t)
        (r0, y0), (r1, y1) = profile(max(t - 1e-4, 0)), profile(min(t + 1e-4, 1))
        slope = math.hypot(r1 - r0, y1 - y0)
        out, up = (y1 - y0) / slope, (r0 - r1) / slope
        row = []
        for j in range(columns + 1):
            angle = TAU * j / columns
            x, z = math.sin(angle), math.cos(angle)
            row.append(((radius * x, height, radius * z), (out * x, up, out * z), (j / columns, 1 - t)))
        grid.append(row[::-1])
    return grid


def sphere(t):
    return math.sin(math.pi * t), -math.cos(math.pi * t)


def vase(t):
    return 0.42 + 0.22 * math.sin(TAU * (0.9 * t - 0.12)) - 0.12 * t, 2.2 * t


def plane(x, z):
    """Facing up, 2x by 2z."""
    corner = lambda i, j: ((x * (2 * j - 1), 0, z * (2 * i - 1)), (0, 1, 0), (j, i))
    return [[corner(i, j) for j in range(2)] for i in range(2)]


def tiles(u, v):
    even = (u < 0.5) == (v < 0.5)
    joint = min(abs(u * 2 % 1 - 0.5), abs(v * 2 % 1 - 0.5)) > 0.48
    return (0.25, 0.23, 0.2) if joint else (0.72, 0.66, 0.55) if even else (0.33, 0.2, 0.16)


def stripes(u, v):
    return (0.75, 0.7, 0.6) if is_metal(u, v) else (0.08, 0.22, 0.42) if v < 0.75 else (0.6, 0.2, 0.1)


def is_metal(u, v):
    return abs((v * 5) % 1 - 0.5 - 0.15 * math.sin(3 * TAU * u)) < 0.12


def finish(u, v):
    """Green is roughness, blue is metal."""
    return (0, 0.25, 1) if is_metal(u, v) else (0, 0.6, 0)


def dents(u, v):
    slope = lambda a, b: -0.5 * math.cos(TAU * 2 * a) * math.sin(TAU * 2 * b)
    x, y = slope(u, v), slope(v, u)
    length = math.sqrt(x * x + y * y + 1)
    return (0.5 + 0.5 * x / length, 0.5 + 0.5 * y / length, 0.5 + 0.5 / length)


def turn(axis, degrees):
    half = math.radians(degrees) / 2
    return [a * math.sin(half) for a in axis] + [math.cos(half)]


def main(path):
    glb = Glb()
    repeat = lambda texture, n: {"index": texture, "extensions": {"KHR_texture_transform": {"scale": [n, n]}}}
    matte = lambda color, roughness: {"baseColorFactor": color + [1], "metallicFactor": 0, "roughnessFactor": roughness}
    table = glb.add("materials", {"name": "table", "pbrMetallicRoughness": {
        "baseColorTexture": repeat(glb.texture("tiles", 64, tiles), 5), "metallicFactor": 0, "roughnessFactor": 0.35}})
    wall = glb.add("materials", {"name": "wall", "pbrMetallicRoughness": matte([0.6, 0.62, 0.65], 0.9)})
    gold = glb.add("materials", {"name": "gold", "pbrMetallicRoughness": {
        "baseColorFactor": [1.0, 0.77, 0.34, 1], "metallicFactor": 1, "roughnessFactor": 0.25}})
    glazed = glb.add("materials", {"name": "glazed", "doubleSided": True,
        "pbrMetallicRoughness": {
            "baseColorTexture": {"index": glb.texture("stripes", 128, stripes)},
            "metallicRoughnessTexture": {"index": glb.texture("finish", 128, finish)}},
        "normalTexture": repeat(glb.texture("dents", 64, dents), 6) | {"scale": 0.6}})
    glass = glb.add("materials", {"name": "glass", "pbrMetallicRoughness": matte([1, 1, 1], 0), "extensions": {
        "KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_ior": {"ior": 1.5},
        "KHR_materials_volume": {"thicknessFactor": 1}}})
    lamp = glb.add("materials", {"name": "lamp", "pbrMetallicRoughness": matte([0.8, 0.8, 0.8], 1),
        "emissiveFactor": [1.0, 0.85, 0.65], "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 9}}})

    bead = glb.mesh("bead", lathe(sphere, 12, 24), gold)
    panel = glb.mesh("panel", plane(6, 6), wall)
    nodes = [
        {"name": "table", "mesh": glb.mesh("table", plane(6, 6), table)},
        {"name": "back", "mesh": panel, "translation": [0, 6, -4], "rotation": turn([1, 0, 0], 90)},
        {"name": "left", "mesh": panel, "translation": [-6, 6, 0], "rotation": turn([0, 0, 1], -90)},
        {"name": "vase", "mesh": glb.mesh("vase", lathe(vase, 32, 48), glazed), "translation": [-0.5, 0, -0.4]},
        {"name": "glass ball", "mesh": glb.mesh("ball", lathe(sphere, 32, 48), glass), "scale": [0.5] * 3, "translation": [1.3, 0.5, 0.1]},
        {"name": "lamp", "mesh": glb.mesh("lamp", plane(1.2, 1.2), lamp), "translation": [2, 5.5, 2.5], "rotation": turn([1, 0, 0], 180)},
        {"name": "camera", "camera": glb.add("cameras", {"type": "perspective", "perspective": {
            "yfov": math.radians(26), "aspectRatio": 4 / 3, "znear": 0.1}}),
            "translation": [0.1, 2.2, 7.4], "rotation": turn([1, 0, 0], -9)},
    ]
    roots = [glb.add("nodes", node) for node in nodes]
    beads = []
    for k in range(20):
        angle = TAU * k / 20
        beads.append(glb.add("nodes", {"mesh": bead, "scale": [0.13] * 3,
            "translation": [round(1.1 * math.sin(angle), 6), 0.13, round(1.1 * math.cos(angle), 6)]}))
    roots.append(glb.add("nodes", {"name": "beads", "children": beads, "translation": [-0.5, 0, -0.4]}))
    glb.add("scenes", {"nodes": roots})
    glb.json["extensionsUsed"] = ["KHR_materials_emissive_strength", "KHR_materials_ior", "KHR_materials_transmission",
        "KHR_materials_volume", "KHR_texture_transform"]
    glb.write(path)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__.strip().splitlines()[2].strip())
    main(sys.argv[1])
