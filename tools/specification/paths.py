"""Section 10 of docs/specification.md: the radiance of a path."""

import math

import sampler
from specification import bsdfs
from specification.arithmetic import *
from specification.meshes import Triangle
from specification.shapes import closest

SPECULAR = (bsdfs.Mirror, bsdfs.Glass)


class Numbers:
    """The random numbers of a path, by decision and edge."""

    def __init__(self, kind, seed, column, row, sample):
        self.kind = kind
        key = sampler.pcg_key if kind == "pcg" else sampler.sobol_key
        self.path = key(seed, row << 16 | column, sample)

    def pair(self, dimension, edge):
        position = 14 * edge + 2 * sampler.DIMENSIONS.index(dimension)
        if self.kind == "pcg":
            words = sampler.pcg_words(*self.path, position)
        else:
            words = sampler.sobol_words(*self.path, position, edge)
        return [F((word >> 9) / 2**23) for word in words]

    def one(self, dimension, edge):
        return self.pair(dimension, edge)[0]


def radiance(scene, numbers, column, row, strategy, length, roulette=None):
    """W/(sr m^2), of a path through a pixel."""
    o, w = scene.camera.ray(column, row, numbers.pair("PixelFilter", 0), numbers.pair("Lens", 0))
    throughput, density, total = V(1, 1, 1), INF, V(0, 0, 0)
    for edge in range(1, length + 1):
        # What the last edge meets does not matter, if it is no light.
        shadowed = edge == length and edge > 1 and not scene.emits
        t, primitive = closest(scene.emitters, o, w) if shadowed else hit(scene, o, w)
        part = scene.triangles.get(primitive) or scene.shapes.get(primitive)
        light = met(scene, o, w, t, part, density, strategy)
        if light is not None and (not shadowed or visible(scene, o, w, t, primitive)):
            total = total + throughput * light[0] * light[1]
        if part is None or edge == length:
            return total
        position, ng, normal, offset, bsdf = part.vertex(o, w, t)
        if bsdf is None:
            return total

        smooth, clear = isinstance(part, Triangle), isinstance(bsdf, bsdfs.Glass)
        if not clear and dot(normal, -w) < 0:
            normal = -normal
        ng = ng * F(math.copysign(1, dot(ng, normal))) if smooth else normal
        frame = Frame(normal)
        wo = frame.to_local(-w)

        if not isinstance(bsdf, SPECULAR):
            x = fma(ng, offset, position)
            direct = light_sample(scene, numbers, edge, x, bsdf, frame, wo, strategy, ng if smooth else None)
            if direct is not None:
                total = total + throughput * direct[0] * direct[1] * direct[2]
            if strategy == "light" and edge + 1 >= length:
                return total

        if strategy == "uniform" and not isinstance(bsdf, SPECULAR):
            wi, density = cone(*numbers.pair("BsdfDirection", edge), F(1)), INV_TAU
            throughput = throughput * (bsdf.eval(wo, wi)[0] * (F(1) / density))
        else:
            drawn = bsdf.sample(wo, *numbers.pair("BsdfDirection", edge), numbers.one("BsdfLobe", edge))
            wi, weighed, density = drawn
            throughput = throughput * weighed
        if not max(throughput) > 0:
            return total
        if roulette and edge >= roulette:
            chance = min(max(throughput), F(1))
            if not numbers.one("Roulette", edge) < chance:
                return total
            throughput = throughput * (F(1) / chance)
        w = frame.to_world(wi)
        height = dot(ng, w) if smooth else wi.z
        if smooth and not clear and not height > 0:
            return total
        o = fma(ng, F(math.copysign(offset, height)), position)
    return total


def hit(scene, o, w):
    """The closest of all: shapes, walls, triangles, those with holes, each strictly nearer than what was before."""
    t, primitive = closest(scene.contents, o, w)
    if scene.room:
        t, primitive = scene.room.meet(o, w, t, primitive)
    for number, triangle in scene.triangles.items():
        if triangle.maps.cutoff is None and (nearer := triangle.meet(o, w)) < t:
            t, primitive = nearer, number
    through = first_beyond_holes(scene, o, w, t)
    return through or (t, primitive)


def first_beyond_holes(scene, o, w, farthest, ignored=None):
    """The first triangle of those with holes where there is none."""
    nearest = F(0)
    pierced = {number: triangle for number, triangle in scene.triangles.items() if triangle.maps.cutoff is not None}
    while True:
        met = [(triangle.meet(o, w), number) for number, triangle in pierced.items()]
        met = [(t, number) for t, number in met if nearest < t < farthest]
        if not met:
            return None
        nearest, number = min(met)
        if number != ignored and pierced[number].is_there(o, w, nearest):
            return nearest, number


def met(scene, o, w, t, part, density, strategy):
    """Emitted radiance and its weight, where a ray meets a light or the sky."""
    if part is None:
        if not scene.lights.sky:
            return None
        emitted, pdf = scene.lights.sky_at(w)
        pdf = pdf * scene.lights.sky_chance()
    elif part.light is None:
        return None
    else:
        emitted, pdf = scene.lights.met(part.light, o, w, t, getattr(part, "ng", None))
    if strategy == "mis":
        return emitted, weight(pdf / density)
    return emitted, F(1) if strategy != "light" or density == INF else F(0)


def visible(scene, o, w, limit, target):
    """Whether nothing but the target is met before the limit; on the way to the sky, hull and lone light are asked too."""
    shapes = scene.shapes if limit == INF else scene.blockers
    if any(shape.meet(o, w) < limit for number, shape in shapes.items() if number != target):
        return False
    limit = fma(limit, F(1 - 2**-18), max_abs(o) * F(-(2**-18)))
    if first_beyond_holes(scene, o, w, limit, target):
        return False
    whole = {number: triangle for number, triangle in scene.triangles.items() if triangle.maps.cutoff is None}
    return not any(triangle.meet(o, w) < limit for number, triangle in whole.items() if number != target)


def light_sample(scene, numbers, edge, x, bsdf, frame, wo, strategy, ng):
    """Radiance, value, and weight over density, of a light sample that arrives."""
    lights = scene.lights if strategy in ("light", "mis") else scene.lights.punctual
    if not lights.all:
        return None
    choice, point = numbers.pair("LightChoice", edge), numbers.pair("LightPoint", edge)
    w, distance, arriving, inverse, primitive, punctual = lights.sample(x, choice, *point)
    value, pdf = bsdf.eval(wo, frame.to_local(w))
    share = weight(pdf * inverse) if strategy == "mis" and not punctual else F(1)
    scaled = share * inverse
    if not any(abs(a * v * scaled) > 0 for a, v in zip(arriving, value)) or (ng and not dot(ng, w) > 0):
        return None
    return (arriving, value, scaled) if visible(scene, x, w, distance, primitive) else None
