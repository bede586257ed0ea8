"""Section 7 of docs/specification.md: rays against quads, spheres, rooms and triangles."""

import math

from specification.arithmetic import *


class Shape:
    """What can be met. `vertex` gives position, geometric and shading normal, offset, and the BSDF there."""

    bsdf = light = None


class Quad(Shape):
    def __init__(self, p, a, b):
        p, a, b = exact(p), exact(a), exact(b)
        n = outer(a, b)
        self.normal = single(unit(n))
        self.d = f(inner(unit(n), p))
        side, other = (scale(outer(*pair), 2 / inner(n, n)) for pair in ((b, n), (n, a)))
        self.axes = [(single(axis), f(-1 - inner(axis, p))) for axis in (side, other)]

    def meet(self, o, w):
        n = self.normal
        height = fma(-n.x, o.x, fma(-n.y, o.y, fma(-n.z, o.z, self.d)))
        t = height / dot(n, w)
        q = fma(w, t, o)
        a, b = (abs(fma(s.x, q.x, fma(s.y, q.y, fma(s.z, q.z, s0)))) for s, s0 in self.axes)
        return t if greatest(a, b) <= 1 + 4 * EPSILON and positive(t) else INF

    def vertex(self, o, w, t):
        position, offset = place(o, w, t)
        return position, self.normal, self.normal, offset, self.bsdf


class Sphere(Shape):
    def __init__(self, center, radius):
        self.c, self.r2, self.inverse = single(center), f(radius) * f(radius), F(1) / f(radius)

    def meet(self, o, w):
        k = self.c - o
        m = dot(k, w)
        x, y, z = (fma(-w[i], m, k[i]) for i in range(3))
        h = sqrt(fma(-x, x, fma(-y, y, fma(-z, z, self.r2))))
        return next((t for t in (m - h, m + h) if positive(t)), INF)

    def vertex(self, o, w, t):
        position, offset = place(o, w, t)
        n = (position - self.c) * self.inverse
        normal = n * fma(-dot(n, n), F(0.5), F(1.5))
        return position, normal, normal, offset, self.bsdf


def place(o, w, t):
    """Position on a shape, and offset of rays from there."""
    position = fma(w, t, o)
    return position, (max_abs(position) + t) * F(2**-18)


def positive(t):
    return t >= 0 and math.copysign(1, t) > 0


class Room:
    """Slabs: unit normal, its two planes, the numbers of its walls."""

    def __init__(self, slabs):
        self.slabs = slabs

    def meet(self, o, w, nearest=INF, wall=None):
        for n, planes, numbers in self.slabs:
            speed = dot(n, w)
            back = speed < 0
            t = (planes[not back] - dot(n, o)) / speed
            if t < nearest:
                nearest, wall = t, numbers[not back]
        return nearest, wall


def closest(shapes, o, w):
    """Of shapes by number: quads before spheres; a later one must be nearer."""
    nearest, primitive = INF, None
    for kind in (Quad, Sphere):
        for number, shape in shapes.items():
            if isinstance(shape, kind) and (t := shape.meet(o, w)) < nearest:
                nearest, primitive = t, number
    return nearest, primitive


def meet_triangle(corners, o, w):
    """The distance, or none."""
    size = [abs(x) for x in w]
    z = max((2, 1, 0), key=lambda axis: size[axis])
    x, y = (z + 1) % 3, (z + 2) % 3
    scale = F(1) / w[z]
    sx, sy = -w[x] * scale, -w[y] * scale
    relative = [corner - o for corner in corners]
    a, b, c = ((fma(r[z], sx, r[x]), fma(r[z], sy, r[y]), r[z]) for r in relative)
    u = c[0] * b[1] - c[1] * b[0]
    v = a[0] * c[1] - a[1] * c[0]
    e = b[0] * a[1] - b[1] * a[0]
    det = u + v + e
    if det == 0 or not (min(u, v, e) >= 0 or max(u, v, e) <= 0):
        return None
    return fma(u, a[2], fma(v, b[2], e * c[2])) * scale / det
