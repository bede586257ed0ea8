"""Sections 7 and 9 of docs/specification.md: triangles of the world, as they are met and as they emit."""

import math
from fractions import Fraction

from specification.arithmetic import *
from specification.shapes import meet_triangle

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


class Triangle:
    def __init__(self, mesh, corners):
        positions, normals, _ = mesh
        self.corners = [positions[corner] for corner in corners]
        self.normals = normals and [normals[corner] for corner in corners]
        a, b, c = self.corners
        self.edges = b - a, c - a
        longest = greatest(max_abs(self.edges[0]), max_abs(self.edges[1]))
        m = F(1) / longest
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

    def vertex(self, o, w, t):
        """Position, geometric and shading normal, offset."""
        e1, e2 = self.edges
        n = cross(e1, e2)
        k = F(1) / max_abs(n)
        n = n * k
        per = k / dot(n, n)
        s = fma(w, t, o) - self.corners[0]
        b, c = clamp(dot(cross(s, e2), n) * per), clamp(dot(cross(e1, s), n) * per)
        g = F(1) / greatest(b + c, F(1))
        b, c = b * g, c * g
        size = max(map(max_abs, self.corners))
        return self.at(b, c), self.ng, self.shading_normal(b, c, -w), size * F(2**-20)

    def shading_normal(self, b, c, wo):
        if not self.normals:
            return self.ng
        n0, n1, n2 = self.normals
        ns = fma(n1 - n0, b, fma(n2 - n0, c, n0))
        # The cofactors of the identity.
        ns = V(*(fma(F(i == 0), ns.x, fma(F(i == 1), ns.y, F(i == 2) * ns.z)) for i in range(3)))
        ns = normalize(ns * (F(1) / max_abs(ns)))
        ns = ns * F(math.copysign(1, dot(ns, self.ng)))
        return ns if dot(ns, wo) * dot(self.ng, wo) > 0 and dot(ns, self.ng) > 0 else self.ng


def choose(columns, first, second):
    """A triangle of a mesh light, by two numbers of which the first leads."""
    digits = int(first * 2**23) << 23 | int(second * 2**23)
    column, within = divmod(digits * len(columns), 2**46)
    threshold, alias = columns[column]
    return column if F(f(float(Fraction(within))) / F(2.0**46)) < threshold else alias
