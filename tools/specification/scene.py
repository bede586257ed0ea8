"""Sections 6 to 9 of docs/specification.md: a scene file, without transforms, ready to be traced."""

import functools
import math
import tomllib

from specification import bsdfs
from specification.arithmetic import *
from specification.lights import Lights
from specification.meshes import FIRST, Triangle, of_quad, read_ply
from specification.shapes import Quad, Room, Sphere
from specification.textures import Maps


class Camera:
    def __init__(self, described, width, height, pixel_filter):
        position = exact(described["position"])
        forward = unit(subtract(exact(described["look_at"]), position))
        right = unit(outer(forward, exact(described.get("up", [0, 1, 0]))))
        up = outer(right, forward)
        t = math.tan(math.radians(f(described["vertical_fov"])) / 2)
        radius = float(f(described.get("aperture_radius", 0.0)))
        self.position, self.forward = single(position), single(forward)
        self.half_right, self.half_up = single(scale(right, t * (width / height))), single(scale(up, t))
        self.scale_x, self.scale_y = f(2 / width), f(2 / height)
        self.lens = (single(scale(right, radius)), single(scale(up, radius))) if radius else None
        self.focus = f(described.get("focus_distance", 0.0))
        self.filter = pixel_filter

    def ray(self, column, row, in_filter, on_lens):
        u, v = in_filter
        if self.filter == "tent":
            u, v = tent(u) + F(0.5), tent(v) + F(0.5)
        elif self.filter == "gaussian":
            u, v = (offset + F(0.5) for offset in gaussian(u, v))
        across = fma(F(column) + u, self.scale_x, F(-1))
        upward = fma(-(F(row) + v), self.scale_y, F(1))
        through = fma(self.half_right, across, fma(self.half_up, upward, self.forward))
        if not self.lens:
            return self.position, normalize(through)
        x, y, _ = disk(*on_lens)
        offset = fma(self.lens[0], x, self.lens[1] * y)
        return self.position + offset, normalize(through * self.focus - offset)


def parameters(material):
    """What is computed of a material: the numbers that its BSDF is made of."""
    plain = lambda value: value.get("scale", [1, 1, 1]) if isinstance(value, dict) else value
    color = lambda name: single(plain(material[name]))
    match material["type"]:
        case "lambert":
            row = [*color("albedo")]
        case "mirror":
            row = [*color("reflectance")]
        case "glass":
            etas = (1 / float(f(material["ior"])), float(f(material["ior"])))
            row = [f(x) for eta in etas for x in (eta, eta * eta, (1 - eta) * (1 + eta))]
        case "phong":
            diffuse, specular = color("diffuse"), color("specular")
            both = plain_luminance(diffuse) + plain_luminance(specular)
            choose = plain_luminance(specular) / both if both > 0 else F(0)
            row = [*diffuse, *specular, f(material["exponent"]), choose]
        case "conductor":
            alpha = greatest(f(material["roughness"]), f(1e-4))
            inverse = 1 / (float(alpha) * float(alpha))
            row = [*color("reflectance"), alpha, alpha * alpha, f(inverse), f(inverse * (1 / math.pi))]
        case "principled":
            ior = float(f(material.get("ior", 1.5)))
            normal = ((ior - 1) / (ior + 1)) ** 2
            row = [*color("base_color"), f(material.get("metallic", 1)), f(material.get("roughness", 1))]
            row += [f(normal), f(min(50 * normal, 1))]
    return row + [F(0)] * (8 - len(row))


def corners(quad):
    p, a, b = (exact(quad[name]) for name in ("corner", "u", "v"))
    add = lambda *vectors: [sum(components) for components in zip(*vectors)]
    return [p, add(p, a), add(p, b), add(p, a, b)]


def is_hull(quad, shapes, points):
    """Whether all is on one side of a quad's plane."""
    normal = unit(outer(exact(quad["u"]), exact(quad["v"])))
    height = lambda p: inner(normal, subtract(p, exact(quad["corner"])))
    heights = [0.0, *map(height, points)]
    for shape in shapes:
        if "sphere" in shape:
            h, r = height(exact(shape["sphere"]["center"])), float(f(shape["sphere"]["radius"]))
            heights += [h - r, h + r]
        else:
            heights += map(height, corners(shape["quad"]))
    tolerance = 1e-6 * (max(heights) - min(heights))
    return min(heights) >= -tolerance or max(heights) <= tolerance


def close_room(walls):
    """The room that six quads, by their numbers, make."""
    if len(walls) != 6:
        return None
    (first, quad), *others = walls.items()
    p, a, b = (exact(quad[name]) for name in ("corner", "u", "v"))
    middle = lambda quad: scale([sum(c) for c in zip(*corners(quad))], 0.25)
    length = lambda v: math.sqrt(inner(v, v))
    for _, other in others:
        w = subtract(middle(other), middle(quad))
        tolerance = 1e-6 * (length(a) + length(b) + length(w))
        if abs(inner(outer(a, b), w)) <= tolerance * length(outer(a, b)):
            continue
        add = lambda u, v: [x + y for x, y in zip(u, v)]
        faces = [(p, a, b), (add(p, w), a, b), (p, b, w), (add(p, a), b, w), (p, w, a), (add(p, b), w, a)]
        near = lambda u, v: length(subtract(u, v)) <= tolerance
        places = {}
        for number, wall in walls.items():
            for place, (c, x, y) in enumerate(faces):
                face = [c, add(c, x), add(c, y), add(add(c, x), y)]
                if place not in places and all(any(near(u, v) for u in corners(wall)) for v in face):
                    places[place] = number
        if len(places) == 6:
            slabs = []
            for place, across in ((0, w), (2, a), (4, b)):
                c, x, y = faces[place]
                n = unit(outer(x, y))
                n = scale(n, math.copysign(1, inner(n, across)))
                planes = f(inner(n, c)), f(inner(n, c) + inner(n, across))
                slabs.append((single(n), planes, (places[place], places[place + 1])))
            return Room(slabs)
    return None


class Scene:
    def __init__(self, text, width, height, folder=None):
        described = tomllib.loads(text)
        self.camera = Camera(described["camera"], width, height, described.get("film", {}).get("filter", "box"))
        materials = described.get("materials", {})
        make = lambda material, *maps: getattr(bsdfs, material["type"].capitalize())(parameters(material), *maps)
        maps = {name: Maps(material, folder) for name, material in materials.items()}
        objects, lights = described.get("objects", []), described.get("lights", [])
        surfaces = [light for light in lights if "radiance" in light]
        self.triangles, self.shapes, ids, kept = {}, {}, [], []
        for place, part in enumerate(objects + surfaces):
            light = place - len(objects) if place >= len(objects) else None
            material = materials.get(part.get("material"))
            mapped = maps.get(part.get("material"), Maps({}, folder))
            if "mesh" in part or "quad" in part and mapped:
                ids.append(FIRST + len(self.triangles))
                mesh = read_ply(folder / part["mesh"]["file"]) if "mesh" in part else of_quad(part["quad"])
                # On meshes maps always count, be they 1.
                bsdf = functools.partial(make, material) if material else None
                for corners in mesh[2]:
                    triangle = self.triangles[FIRST + len(self.triangles)] = Triangle(mesh, corners, mapped, bsdf)
                    triangle.light = light
            else:
                ids.append(len(kept))
                sphere = "sphere" in part
                shape = Sphere(**part["sphere"]) if sphere else Quad(*(part["quad"][name] for name in ("corner", "u", "v")))
                shape.bsdf, shape.light = make(material) if material else None, light
                self.shapes[len(kept)] = shape
                kept.append(part)
        self.lights = Lights(text, ids[len(objects) :], self.triangles)

        points = [exact(light[kind]["position"]) for light in lights for kind in ("point", "spot") if kind in light]
        points += box_corners([corner for triangle in self.triangles.values() for corner in triangle.corners])
        hull = {n for n, part in enumerate(kept) if "quad" in part and is_hull(part["quad"], kept, points)}
        self.room, self.contents = None, self.shapes
        if not any(isinstance(self.shapes[number].bsdf, bsdfs.Glass) for number in hull):
            self.room = close_room({number: kept[number]["quad"] for number in hull})
        if self.room:
            self.contents = {number: shape for number, shape in self.shapes.items() if number not in hull}
        self.emitters = {number: shape for number, shape in self.shapes.items() if shape.light is not None}
        lone = set(self.emitters) if len(lights) == 1 else set()
        self.blockers = {number: shape for number, shape in self.shapes.items() if number not in hull | lone}
        self.emits = bool(self.lights.meshes)


def box_corners(points):
    """The eight corners of the box around points."""
    if not points:
        return []
    ends = [(min(p[axis] for p in points), max(p[axis] for p in points)) for axis in range(3)]
    return [[float(ends[axis][corner >> axis & 1]) for axis in range(3)] for corner in range(8)]
