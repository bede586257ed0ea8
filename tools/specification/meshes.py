"""Sections 7 and 9 of docs/specification.md: triangles of the world, as they are met and as they emit."""

import math
from fractions import Fraction

from specification.arithmetic import *
from specification.shapes import Shape, meet_triangle

# Ids of triangles begin here, beyond those of other primitives.
FIRST = 1 << 31


def read_ply(path):
    """Positions, normals or none, and triangles of an ascii PLY of this folder's form."""
    header, body = path.read_text().split("end_header\n")
    count = int(header.split("element vertex ")[1].split()[0])
    rows = [line.split() for line in body.splitlines()]
    vertices = [[f(float(number)) for number in row] for row in rows[:count]]
    normals = [single(unit(exact(row[3:6]))) for row in vertices] if "property float nx" in header else None
    return [V(*row[:3]) for row in vertices], normals, [tuple(map(int, row[1:])) for row in rows[count:]]


def of_quad(quad):
    """The mesh of a quad that has maps: positions, texture coordinates, triangles."""
    p, a, b = (single(quad[name]) for name in ("corner", "u", "v"))
    uvs = [(F(0), F(0)), (F(1), F(0)), (F(1), F(1)), (F(0), F(1))]
    return [p, p + a, p + a + b, p + b], None, [(0, 1, 2), (0, 2, 3)], uvs


class Triangle(Shape):
    def __init__(self, mesh, corners, maps, make):
        positions, normals, _, *uvs = mesh
        self.corners = [positions[corner] for corner in corners]
        self.normals = normals and [normals[corner] for corner in corners]
        self.uvs = [uvs[0][corner] for corner in corners] if uvs else [(F(0), F(0))] * 3
        self.maps, self.make = maps, make
        a, b, c = self.corners
        self.edges = b - a, c - a
        m = F(1) / greatest(max_abs(self.edges[0]), max_abs(self.edges[1]))
        self.ng = normalize(cross(self.edges[0] * m, self.edges[1] * m))

    def meet(self, o, w):
        t = meet_triangle(self.corners, o, w)
        return t if t is not None and t > 0 else INF

    def at(self, b, c):
        return fma(self.edges[0], b, fma(self.edges[1], c, self.corners[0]))

    def area(self):
        a, b, c = (list(map(float, corner)) for corner in self.corners)
        n = outer(subtract(b, a), subtract(c, a))
        return 0.5 * math.sqrt(inner(n, n))

    def barycentric(self, point):
        e1, e2 = self.edges
        n = cross(e1, e2)
        k = F(1) / max_abs(n)
        n = n * k
        per = k / dot(n, n)
        s = point - self.corners[0]
        b, c = clamp(dot(cross(s, e2), n) * per), clamp(dot(cross(e1, s), n) * per)
        g = F(1) / greatest(b + c, F(1))
        return b * g, c * g

    def uv(self, b, c):
        return [fma(q - p, b, fma(r - p, c, p)) for p, q, r in zip(*self.uvs)]

    def is_there(self, o, w, t):
        return self.maps.is_there(*self.uv(*self.barycentric(fma(w, t, o))))

    def vertex(self, o, w, t):
        b, c = self.barycentric(fma(w, t, o))
        uv = self.uv(b, c)
        ns = self.maps.bend(self.interpolated(b, c), self.edges, self.uvs, *uv)
        same_side = dot(ns, -w) * dot(self.ng, -w) > 0 and dot(ns, self.ng) > 0
        offset = max(map(max_abs, self.corners)) * F(2**-20)
        bsdf = self.make and self.make(self.maps.factors(*uv))
        return self.at(b, c), self.ng, ns if same_side else self.ng, offset, bsdf

    def interpolated(self, b, c):
        if not self.normals:
            return self.ng
        n0, n1, n2 = self.normals
        n = fma(n1 - n0, b, fma(n2 - n0, c, n0))
        # The cofactors of the identity.
        n = V(*(fma(F(i == 0), n.x, fma(F(i == 1), n.y, F(i == 2) * n.z)) for i in range(3)))
        n = normalize(n * (F(1) / max_abs(n)))
        return n * F(math.copysign(1, dot(n, self.ng)))


def choose(columns, first, second):
    """A triangle of a mesh light, by two numbers of which the first leads."""
    digits = int(first * 2**23) << 23 | int(second * 2**23)
    column, within = divmod(digits * len(columns), 2**46)
    threshold, alias = columns[column]
    return column if F(f(float(Fraction(within))) / F(2.0**46)) < threshold else alias
