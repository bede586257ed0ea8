"""Sections 7 and 8 of docs/specification.md: images on triangles, as colours, roughness, normals and holes."""

import math
import struct
import zlib

from specification.arithmetic import *

BELOW_ONE = F(1 - 2**-24)


def read_png(path):
    """Rows of RGBA bytes, of a PNG of eight bits without filters, as those of this folder are."""
    data, place, packed = path.read_bytes(), 8, b""
    while place < len(data):
        length, kind = struct.unpack(">I4s", data[place : place + 8])
        chunk = data[place + 8 : place + 8 + length]
        if kind == b"IHDR":
            width, height = struct.unpack(">II", chunk[:8])
        packed += chunk if kind == b"IDAT" else b""
        place += 12 + length
    flat = zlib.decompress(packed)
    rows = [flat[y * (4 * width + 1) + 1 : (y + 1) * (4 * width + 1)] for y in range(height)]
    return [[row[x : x + 4] for x in range(0, 4 * width, 4)] for row in rows]


def linear(code):
    x = code / 255
    return f(x / 12.92 if x <= 0.04045 else ((x + 0.055) / 1.055) ** 2.4)


class Texture:
    def __init__(self, described, folder, is_color):
        described = {"texture": described} if isinstance(described, str) else described
        curve = linear if is_color else lambda code: F(code) / F(255)
        rows = read_png(folder / described["texture"])
        self.texels = [[[*map(curve, texel[:3]), F(texel[3]) / F(255)] for texel in row] for row in rows]
        self.repeat = [f(x) for x in described.get("repeat", [1, 1])]
        self.wrap, self.nearest = described.get("wrap", "repeat"), described.get("filter") == "nearest"

    def side(self, x, size):
        """Texels before and after, and how far it is from one to the other."""
        if self.wrap == "repeat":
            x = x - F(math.floor(x))
        elif self.wrap == "mirror":
            x = x - F(math.floor(x * F(0.5))) * 2
            x = least(x, F(2) - x)
        x = least(x if x > 0 else F(0), BELOW_ONE)
        at = fma(x, F(size), F(0 if self.nearest else -0.5))
        before = math.floor(at)
        low, high = (size - 1, 0) if self.wrap == "repeat" else (0, size - 1)
        pair = low if before < 0 else before, high if before + 1 > size - 1 else before + 1
        return pair, F(0) if self.nearest else at - F(before)

    def at(self, u, v):
        u, v = fma(self.repeat[0], u, fma(F(0), v, F(0))), fma(F(0), u, fma(-self.repeat[1], v, F(1)))
        (left, right), across = self.side(u, len(self.texels[0]))
        rows, down = self.side(v, len(self.texels))
        mix = lambda a, b, t: [fma(y - x, t, x) for x, y in zip(a, b)]
        first, second = (mix(self.texels[row][left], self.texels[row][right], across) for row in rows)
        return mix(first, second, down)


class Maps:
    """The textures of a material."""

    def __init__(self, material, folder):
        colors = [material.get(name) for name in ("albedo", "reflectance", "diffuse", "base_color")]
        self.color = next((Texture(color, folder, True) for color in colors if isinstance(color, dict)), None)
        of = lambda name: Texture(material[name], folder, False) if name in material else None
        self.rough, self.normal = of("metallic_roughness"), of("normal_map")
        bumps = material.get("normal_map")
        self.strength = f(bumps.get("strength", 1)) if isinstance(bumps, dict) else F(1)
        self.cutoff = f(material["alpha_cutoff"]) if "alpha_cutoff" in material else None

    def __bool__(self):
        return any((self.color, self.rough, self.normal))

    def factors(self, u, v):
        """Of colour, metallic and roughness."""
        cut = lambda x: least(x, F(1))
        color = V(*map(cut, self.color.at(u, v)[:3])) if self.color else V(1, 1, 1)
        _, rough, metallic, _ = map(cut, self.rough.at(u, v)) if self.rough else [F(1)] * 4
        return color, metallic, rough

    def is_there(self, u, v):
        return self.cutoff is None or self.color.at(u, v)[3] >= self.cutoff

    def bend(self, ns, edges, uvs, u, v):
        """The shading normal as the normal map has it."""
        if not self.normal:
            return ns
        r, g, b, _ = self.normal.at(u, v)
        signed = lambda x: fma(x, F(2), F(-1))
        local = normalize(V(signed(r) * self.strength, signed(g) * self.strength, greatest(signed(b), f(1e-3))))
        e1, e2 = edges
        (u0, v0), (u1, v1), (u2, v2) = uvs
        u1, v1, u2, v2 = u1 - u0, v1 - v0, u2 - u0, v2 - v0
        sign = F(math.copysign(1, fma(u1, v2, -(u2 * v1))))
        du, dv = (e1 * v2 - e2 * v1) * sign, (e2 * u1 - e1 * u2) * sign
        a, d = self.normal.repeat[0], -self.normal.repeat[1]
        turn = F(math.copysign(1, fma(a, d, F(-0.0))))
        ds, dt = (du * d - dv * F(0)) * turn, (dv * a - du * F(0)) * turn
        t = ds - ns * dot(ds, ns)
        t = normalize(t * (F(1) / max_abs(t)))
        s = cross(ns, t)
        s = s * F(math.copysign(1, -dot(s, dt)))
        bent = normalize(fma(t, local.x, fma(s, local.y, ns * local.z)))
        return bent if dot(bent, bent) > 0 else ns
