"""Section 9 of docs/specification.md: lights of a scene file, chosen, drawn from, and met."""

import copy
import math
import tomllib

from specification.arithmetic import *
from specification.meshes import choose


def cone_of(s):
    if not s < 1:
        return F(2), False
    series = fma(fma(fma(fma(s, f(7 / 256), f(5 / 128)), s, F(1 / 16)), s, F(1 / 8)), s, F(0.5)) * s
    return series if s < f(0.04) else F(1) - safe_sqrt(F(1) - s), True


class Lights:
    """Those of a scene file's text. `ids` are the primitives of those with a surface (of a mesh its first triangle),
    `triangles` those of all meshes by id."""

    def __init__(self, text, ids=(0, 1), triangles={}):
        described = tomllib.loads(text)
        self.ids, self.triangles = ids, triangles
        self.objects = described.get("objects", [])
        listed = described.get("lights", [])
        self.surfaces = [light for light in listed if "radiance" in light]
        self.sky = described.get("environment")
        punctual = [light for light in listed if "radiance" not in light]
        self.meshes = {n: self.of_mesh(n) for n, light in enumerate(self.surfaces) if "mesh" in light}
        self.choose_among(self.surfaces + ([self.sky] if self.sky else []) + punctual)
        self.punctual = copy.copy(self)
        self.punctual.choose_among(punctual)

    def choose_among(self, lights):
        """Chances by power."""
        self.all = lights
        powers = [self.power(light, n) for n, light in enumerate(lights)]
        raised = [max(power, 1e-3 * added(powers) / len(powers)) if power > 0 else 0.0 for power in powers]
        self.chances = [power / added(raised) for power in raised]
        self.columns = alias_table(self.chances)

    def of_mesh(self, number):
        """The triangles of a mesh light, their area in all, and the table they are chosen by."""
        own = [triangle for triangle in self.triangles.values() if triangle.light == number]
        areas = [triangle.area() for triangle in own]
        area = added(areas)
        return own, area, alias_table([each * (1 / area) for each in areas])

    def radius(self):
        """Half the diagonal of the box around all shapes, and lamps do not count; f32."""
        points = []
        for triangle in self.triangles.values():
            points += triangle.corners
        for light in self.objects + self.surfaces:
            if "mesh" in light:
                continue
            if "sphere" in light:
                c, r = single(light["sphere"]["center"]), f(light["sphere"]["radius"])
                points += [c - gray(r), c + gray(r)]
            else:
                p, a, b = (single(light["quad"][name]) for name in ("corner", "u", "v"))
                points += [p, p + a, p + b, p + a + b]
        if not points:
            return F(1)
        d = V(*(max(p[i] for p in points) - min(p[i] for p in points) for i in range(3)))
        return sqrt(d.x * d.x + d.y * d.y + d.z * d.z) / 2

    def power(self, light, number):
        if "radiance" in light:
            if "mesh" in light:
                area = self.meshes[number][1]
            elif "sphere" in light:
                area = 4 * float(PI) * float(f(light["sphere"]["radius"])) ** 2
            else:
                n = outer(exact(light["quad"]["u"]), exact(light["quad"]["v"]))
                area = math.sqrt(inner(n, n))
            sides = 2 if light.get("two_sided") else 1
            return float(plain_luminance(single(light["radiance"]))) * area * sides * float(PI)
        r = self.radius()
        if "constant" in light:
            return float(F(2) * TAU * plain_luminance(single(light["constant"]))) * float(PI * r * r)
        if "gradient" in light:
            return float(self.gradient()["integral"]) * float(PI * r * r)
        if "point" in light:
            return 4 * math.pi * float(plain_luminance(single(light["point"]["intensity"])))
        if "spot" in light:
            inside, outside = map(float, self.cosines(light["spot"]))
            cap = 1 - inside + (inside - outside) / 3
            return 2 * math.pi * cap * float(plain_luminance(single(light["spot"]["intensity"])))
        return math.pi * float(r) ** 2 * float(plain_luminance(single(light["distant"]["irradiance"])))

    @staticmethod
    def cosines(spot):
        return [f(math.cos(math.radians(spot[name]))) for name in ("inner_degrees", "outer_degrees")]

    def gradient(self):
        described = self.sky["gradient"]
        zenith, horizon, ground = (single(described[name]) for name in ("zenith", "horizon", "ground"))
        z, h, g = (float(plain_luminance(color)) for color in (zenith, horizon, ground))
        ends = [(f(h / (0.5 * (h + end))), f(end / (0.5 * (h + end)))) for end in (z, g)]
        up = f((h + z) / (2 * h + z + g))
        integral = f(math.pi * (h + z) + math.pi * (h + g))
        rise = zenith - horizon, ground - horizon
        return {"horizon": horizon, "rise": rise, "ends": ends, "up": up, "integral": integral}

    def sky_at(self, w):
        if "constant" in self.sky:
            return single(self.sky["constant"]), F(0.25) * INV_PI
        g = self.gradient()
        radiance = fma(g["rise"][not w.y >= 0], abs(w.y), g["horizon"])
        radiance = V(*(greatest(x, F(0)) for x in radiance))
        return radiance, luminance(radiance) * (F(1) / g["integral"])

    def sky_direction(self, u, v):
        if "constant" in self.sky:
            return cone(u, v, F(2))
        g = self.gradient()
        above = u < g["up"]
        t0 = (u if above else u - g["up"]) / (g["up"] if above else F(1) - g["up"])
        a, b = g["ends"][not above]
        squares = fma(F(1) - t0, square(a), t0 * square(b))
        t = least(t0 * 2 / greatest(a + sqrt(squares), TINY), F(1))
        r = sqrt((F(1) - t) * (F(1) + t))
        s, c = sin_cos_turns(v)
        return V(r * s, t if above else -t, -(r * c))

    def choose(self, u):
        """A light, and what is left of the number."""
        n = len(self.columns)
        s = u * n
        column = min(math.floor(s), n - 1)
        threshold, alias = self.columns[column]
        within = s - F(column)
        if within < threshold:
            return column, within / threshold
        return alias, (within - threshold) / (F(1) - threshold)

    def sample(self, x, choice, u, v):
        """Direction, distance, radiance, 1 / pdf, primitive, whether it is punctual; `choice` is a pair."""
        number, rest = self.choose(choice[0])
        light = self.all[number]
        inverse_chance = f(1 / self.chances[number])
        if "sphere" in light:
            k, r = single(light["sphere"]["center"]) - x, f(light["sphere"]["radius"])
            d2 = dot(k, k)
            i2 = F(1) / d2
            i = sqrt(i2)
            spread, outside = cone_of(square(r) * i2)
            l = cone(u, v, spread)
            half = safe_sqrt(fma(-fma(l.x, l.x, l.y * l.y), d2, square(r)))
            distance = fma(d2 * i, l.z, -half if outside else half)
            inverse = (spread * TAU if outside or light.get("two_sided") else F(0)) * inverse_chance
            return Frame(k * i).to_world(l), distance, single(light["radiance"]), inverse, self.ids[number], False
        if "mesh" in light:
            triangles, area, columns = self.meshes[number]
            triangle = choose(columns, choice[1], rest)
            k = triangles[triangle].at(*triangle_warp(u, v)) - x
            d2 = dot(k, k)
            distance = sqrt(d2)
            w = k * (F(1) / distance)
            facing = -dot(w, triangles[triangle].ng)
            inverse = abs(facing) * f(area) / d2
            inverse = inverse if facing > 0 or light.get("two_sided") else F(0)
            return w, distance, single(light["radiance"]), inverse * inverse_chance, self.ids[number] + triangle, False
        if "quad" in light:
            p, a, b = (single(light["quad"][name]) for name in ("corner", "u", "v"))
            n = outer(exact(a), exact(b))
            k = fma(a, u, fma(b, v, p)) - x
            d2 = dot(k, k)
            i2 = F(1) / d2
            i = sqrt(i2)
            w = k * i
            facing = -dot(w, single(unit(n)))
            inverse = abs(facing) * f(math.sqrt(inner(n, n))) * i2
            inverse = inverse if facing > 0 or light.get("two_sided") else F(0)
            return w, d2 * i, single(light["radiance"]), inverse * inverse_chance, self.ids[number], False
        if light is self.sky:
            w = self.sky_direction(u, v)
            radiance, pdf = self.sky_at(w)
            inverse = F(1) / (pdf * self.sky_chance()) if pdf > 0 else F(0)
            return w, INF, radiance, inverse, None, False
        if "distant" in light:
            way = single(unit(exact(light["distant"]["direction"])))
            return -way, INF, single(light["distant"]["irradiance"]), inverse_chance, None, True
        kind = "point" if "point" in light else "spot"
        k = single(light[kind]["position"]) - x
        d2 = dot(k, k)
        d = sqrt(d2)
        w = k * (F(1) / d)
        slope, offset, way = F(0), F(1), V(0, 0, 0)
        if kind == "spot":
            inside, outside = self.cosines(light["spot"])
            slope = F(1) / greatest(inside - outside, f(0.001))
            offset, way = -outside * slope, single(unit(exact(light["spot"]["direction"])))
        ramp = least(greatest(fma(-dot(w, way), slope, offset), F(0)), F(1))
        return w, d, single(light[kind]["intensity"]) * (square(ramp) / d2), inverse_chance, None, True

    def met(self, number, o, w, distance, ng=None):
        """Emitted radiance and density; of a mesh by its geometric normal."""
        light, chance = self.surfaces[number], f(self.chances[number])
        if "sphere" in light:
            k = single(light["sphere"]["center"]) - o
            spread, front = cone_of(square(f(light["sphere"]["radius"])) / dot(k, k))
            inverse = spread * TAU
        else:
            if number in self.meshes:
                area = self.meshes[number][1]
            else:
                n = outer(exact(light["quad"]["u"]), exact(light["quad"]["v"]))
                area, ng = math.sqrt(inner(n, n)), single(unit(n))
            facing = -dot(w, ng)
            front = facing > 0
            inverse = abs(facing) * f(area) / square(distance)
        return single(light["radiance"]) if front or light.get("two_sided") else V(0, 0, 0), chance / inverse

    def sky_chance(self):
        return f(self.chances[len(self.surfaces)])


def added(values):
    """One after another: `sum` compensates from Python 3.12 on."""
    total = 0.0
    for value in values:
        total += value
    return total


def alias_table(chances):
    """Vose's."""
    scaled = [chance * len(chances) for chance in chances]
    small = [number for number, s in enumerate(scaled) if s < 1]
    large = [number for number, s in enumerate(scaled) if not s < 1]
    columns = [(F(1), number) for number in range(len(chances))]
    while small and large:
        less, more = small.pop(), large[-1]
        columns[less] = (f(scaled[less]), more)
        scaled[more] -= 1 - scaled[less]
        if scaled[more] < 1:
            small.append(large.pop())
    return columns
