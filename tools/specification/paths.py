"""Section 10 of docs/specification.md: the radiance of a path."""

import sampler
from specification import bsdfs
from specification.arithmetic import *
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
        last = edge == length and edge > 1
        if last:
            t, primitive = closest(scene.emitters, o, w)
        else:
            t, primitive = closest(scene.contents, o, w)
            if scene.room:
                t, primitive = scene.room.meet(o, w, t, primitive)
        light = met(scene, o, w, t, primitive, density, strategy)
        if light is not None:
            light = throughput * light[0] * light[1]
            if not last or visible(scene, o, w, t, primitive):
                total = total + light
        if last or primitive is None or edge == length or not (bsdf := scene.bsdfs.get(scene.materials[primitive])):
            return total

        position = fma(w, t, o)
        normal, wo = scene.shapes[primitive].surface(position), -w
        offset = (max_abs(position) + t) * F(2**-18)
        if not isinstance(bsdf, bsdfs.Glass) and dot(normal, wo) < 0:
            normal = -normal
        frame = Frame(normal)
        local = frame.to_local(wo)

        if not isinstance(bsdf, SPECULAR):
            direct = light_sample(scene, numbers, edge, fma(normal, offset, position), bsdf, frame, local, strategy)
            if direct is not None:
                total = total + throughput * direct[0] * direct[1] * direct[2]
            if strategy == "light" and edge + 1 >= length:
                return total

        if strategy == "uniform" and not isinstance(bsdf, SPECULAR):
            wi = cone(*numbers.pair("BsdfDirection", edge), F(1))
            density = INV_TAU
            throughput = throughput * (bsdf.eval(local, wi)[0] * (F(1) / density))
        else:
            drawn = bsdf.sample(local, *numbers.pair("BsdfDirection", edge), numbers.one("BsdfLobe", edge))
            wi, weighed, density = drawn
            throughput = throughput * weighed
        if not max(throughput) > 0:
            return total
        if roulette and edge >= roulette:
            chance = min(max(throughput), F(1))
            if not numbers.one("Roulette", edge) < chance:
                return total
            throughput = throughput * (F(1) / chance)
        o = fma(normal, F(math.copysign(offset, wi.z)), position)
        w = frame.to_world(wi)
    return total


def met(scene, o, w, t, primitive, density, strategy):
    """Emitted radiance and its weight, where a ray meets a light or the sky."""
    if primitive is None:
        if not scene.lights.sky:
            return None
        emitted, pdf = scene.lights.sky_at(w)
        pdf = pdf * scene.lights.sky_chance()
    elif primitive in scene.emitters:
        emitted, pdf = scene.lights.met(primitive - scene.lights.first, o, w, t)
    else:
        return None
    if strategy == "mis":
        return emitted, weight(pdf / density)
    return emitted, F(1) if strategy != "light" or density == INF else F(0)


def visible(scene, o, w, limit, target):
    """Whether nothing but the target is met before the limit; on the way to the sky, hull and lone light are asked too."""
    shapes = scene.shapes if limit == INF else scene.blockers
    return not any(shape.meet(o, w) < limit for number, shape in shapes.items() if number != target)


def light_sample(scene, numbers, edge, x, bsdf, frame, local, strategy):
    """Radiance, value, and weight over density, of a light sample that arrives."""
    lights = scene.lights
    if strategy not in ("light", "mis"):
        return None
    choice, point = numbers.one("LightChoice", edge), numbers.pair("LightPoint", edge)
    w, distance, arriving, inverse, primitive, punctual = lights.sample(x, choice, *point)
    value, pdf = bsdf.eval(local, frame.to_local(w))
    share = weight(pdf * inverse) if strategy == "mis" and not punctual else F(1)
    scaled = share * inverse
    if not any(abs(a * v * scaled) > 0 for a, v in zip(arriving, value)):
        return None
    return (arriving, value, scaled) if visible(scene, x, w, distance, primitive) else None
