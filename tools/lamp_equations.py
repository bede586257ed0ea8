"""The equations of the 2014 report's figures 8 to 12, explicit sampling of a spherical lamp: a diagram, and what they give in numbers.

Part of tools/figures.py. Source: Shirley and Morley, Realistic Ray Tracing, 2nd ed., "Sampling a spherical luminaire".
"""

import math

import numpy
from matplotlib import pyplot
from matplotlib.patches import Arc, Circle

RED, BLUE, PALE, GREY, BLACK = "#c0392b", "#2f5f9e", "#9db7d6", "#777777", "#222222"
# The lamp of the built-in scene `cornell`, red channel, and a point of its back wall.
CENTRE, RADIUS, RADIANCE, ALBEDO = numpy.array([0.0, 0.7, 0.0]), 0.15, 20.0, 0.73
POINT, NORMAL = numpy.array([0.3, 0.2, -1.0]), numpy.array([0.0, 0.0, 1.0])


def diagram():
    """A lamp over a surface: directions over the hemisphere, and in the cone that the lamp subtends."""
    centre, radius = numpy.array([1.1, 1.75]), 0.6
    distance, towards = math.hypot(*centre), math.atan2(centre[1], centre[0])
    widest = math.asin(radius / distance)

    def at(angle, length):
        return numpy.array([length * math.cos(angle), length * math.sin(angle)])

    def on_lamp(angle):
        """Where the direction meets the lamp."""
        offset = angle - towards
        return at(angle, distance * math.cos(offset) - math.sqrt(radius**2 - (distance * math.sin(offset)) ** 2))

    def line(axis, start, end, colour=BLACK, style="-"):
        axis.plot(*zip(start, end), color=colour, lw=1, ls=style)

    def arrow(axis, end, colour):
        axis.annotate("", end, (0, 0), arrowprops={"arrowstyle": "->", "color": colour, "lw": 1.5, "shrinkA": 0, "shrinkB": 0})

    figure, (left, right) = pyplot.subplots(1, 2, figsize=(10, 3.9))
    for axis, title in [(left, "hemispherical: few directions meet the lamp"), (right, "explicit: all directions do")]:
        axis.add_patch(Circle(centre, radius, facecolor="#ffe9a8", edgecolor="#8a6d00"))
        axis.plot([-1.8, 1.9], [0, 0], color=BLACK, lw=2)
        axis.text(0, -0.22, r"$\mathbf{x}$", ha="center", fontsize=14)
        axis.set(xlim=(-1.9, 1.95), ylim=(-0.3, 2.4), aspect="equal")
        axis.set_title(title, fontsize=12)
        axis.axis("off")

    left.add_patch(Arc((0, 0), 2.6, 2.6, theta1=0, theta2=180, color=GREY, ls="--"))
    for angle in numpy.radians(numpy.arange(11.25, 180, 22.5)):
        meets = abs(angle - towards) < widest
        arrow(left, on_lamp(angle) if meets else at(angle, 1.3), BLUE if meets else RED)
    left.text(-1.9, 1.6, r"$p(\mathbf{k}_i)=\frac{1}{2\pi}$", fontsize=14)

    drawn = towards + 0.55 * widest
    for side in (-1, 1):
        line(right, (0, 0), at(towards + side * widest, distance * math.cos(widest)), GREY, "--")
    for angle, colour in [(towards - 0.7 * widest, PALE), (towards - 0.35 * widest, PALE), (drawn, BLUE)]:
        arrow(right, on_lamp(angle), colour)
    met = on_lamp(drawn)
    line(right, (0, 0), centre)
    line(right, centre, centre + at(towards - math.pi / 2, radius))
    line(right, (0, 0), (0, 1.75))
    line(right, met, 2 * met - centre)
    right.plot(*centre, "o", color=BLACK, ms=4)
    outward = math.degrees(math.atan2(*(met - centre)[::-1])) % 360
    for middle, width, start, end in [
        ((0, 0), 1.6, math.degrees(towards - widest), math.degrees(towards)),
        ((0, 0), 0.9, math.degrees(drawn), 90),
        (met, 0.5, outward, math.degrees(drawn) + 180),
    ]:
        right.add_patch(Arc(middle, width, width, theta1=start, theta2=end, color=BLACK))
    labels = [(r"$\alpha_{\max}$", (0.66, 0.62)), (r"$\theta_i$", (0.03, 0.5)), (r"$\mathbf{n}$", (-0.06, 1.8)),
              (r"$\mathbf{c}$", centre + (-0.06, 0.1)), (r"$r$", centre + (0.26, -0.08)), (r"$\mathbf{x}'$", met + (0.05, 0.08)),
              (r"$\theta'$", met + (-0.4, -0.42)), (r"$\mathbf{k}_i$", (0.14, 0.72)), (r"$q(\mathbf{k}_i)=\frac{1}{2\pi(1-\cos\alpha_{\max})}$", (-1.9, 0.95))]
    for text, (x, y) in labels:
        right.text(x, y, text, fontsize=13, bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.5} if y < 1.2 else None)
    return figure


def around(axis, cosine, turn):
    """Unit vectors that have these cosines and azimuths about a unit vector that is not y."""
    u = numpy.cross(axis, [0.0, 1.0, 0.0])
    u /= numpy.linalg.norm(u)
    v = numpy.cross(axis, u)
    sine = numpy.sqrt(1 - cosine**2)[:, None]
    return cosine[:, None] * axis + sine * (numpy.cos(turn)[:, None] * u + numpy.sin(turn)[:, None] * v)


def to_lamp(directions):
    """Distances from POINT to the lamp; NaN where it is missed."""
    along = directions @ (CENTRE - POINT)
    with numpy.errstate(invalid="ignore"):
        return along - numpy.sqrt(along**2 + RADIUS**2 - ((CENTRE - POINT) ** 2).sum())


def checks(samples=1_000_000):
    """Rows of figure, claim, expected, found, and how far apart the two may be at one standard error or by rounding; then the
    relative standard deviations of an explicit and of a hemispherical sample."""
    random = numpy.random.Generator(numpy.random.PCG64(1))
    d = numpy.linalg.norm(CENTRE - POINT)
    towards = (CENTRE - POINT) / d
    ratio = numpy.linspace(0.01, 0.99, 99)
    forms = numpy.abs(numpy.arcsin(ratio) - numpy.arccos(numpy.sqrt(1 - ratio**2))).max()

    cos_max = math.sqrt(1 - (RADIUS / d) ** 2)
    turn = 2 * math.pi * random.random(samples)
    hemisphere = around(NORMAL, random.random(samples), turn)
    meets = numpy.isfinite(to_lamp(hemisphere))

    q = 1 / (2 * math.pi * (1 - cos_max))
    middles = (numpy.arange(10_000) + 0.5) / 10_000
    alpha = math.acos(cos_max) * middles
    over_cone = (q * 2 * math.pi * numpy.sin(alpha)).mean() * math.acos(cos_max)
    cone = around(towards, 1 + random.random(samples) * (cos_max - 1), turn)
    distance = to_lamp(cone)
    found = numpy.isfinite(distance)

    # The visible cap of the lamp, by the angle at its centre.
    beta = math.acos(RADIUS / d) * middles
    squared = d * d + RADIUS**2 - 2 * d * RADIUS * numpy.cos(beta)
    facing = (d * numpy.cos(beta) - RADIUS) / numpy.sqrt(squared)
    over_cap = (q * facing / squared * 2 * math.pi * RADIUS**2 * numpy.sin(beta)).mean() * math.acos(RADIUS / d)

    # Figure 9 to the letter; what rounding puts beyond the rim is lost.
    direction, distance = cone[found], distance[found]
    cos_light = ((CENTRE - POINT - direction * distance[:, None]) * direction).sum(axis=1) / RADIUS
    p = q * cos_light / distance**2
    explicit = ALBEDO / math.pi * RADIANCE * (direction @ NORMAL) * cos_light / (p * distance**2)
    blind = ALBEDO / math.pi * RADIANCE * (hemisphere @ NORMAL) * meets / (1 / (2 * math.pi))
    exact = ALBEDO * RADIANCE * (RADIUS / d) ** 2 * (towards @ NORMAL)

    def error(values):
        return values.std() / math.sqrt(len(values))

    rows = [
        ("9", "mean of explicit samples, W/(sr m²)", exact, explicit.mean(), error(explicit)),
        ("9", "mean of hemispherical samples, W/(sr m²)", exact, blind.mean(), error(blind)),
        ("10", "greatest difference of its two forms, r/‖x−c‖ from 0.01 to 0.99", 0, forms, 1e-13),
        ("10", "1 − cos α_max: share of the hemisphere's directions that meet the lamp", 1 - cos_max, meets.mean(), error(meets)),
        ("11", "∫ q dω over the cone", 1, over_cone, 1e-8),
        ("11", "share of the directions it draws that meet the lamp", 1, found.mean(), 1e-5),
        ("12", "∫ p dA over the part of the lamp that is seen", 1, over_cap, 1e-7),
    ]
    return rows, explicit.std() / exact, blind.std() / exact


def wall(direct, squared_error):
    """The same for the renderer: a row that holds its image of direct light to the closed form, on the back wall above the spheres."""
    size = len(direct)
    # Through the middles of pixels: a pinhole at z = 2.95, half of whose field of view is 25 degrees.
    half = math.tan(math.radians(25)) * 3.95
    across = ((numpy.arange(size) + 0.5) / size * 2 - 1) * half
    free = numpy.ix_((across < 0) & (across > -0.6), numpy.abs(across) < 0.8)
    squared = (across[None, :] - CENTRE[0]) ** 2 + (-across[:, None] - CENTRE[1]) ** 2 + 1
    closed = (ALBEDO * RADIANCE * RADIUS**2 / squared**1.5)[free]
    noise = math.sqrt((squared_error[free] / closed**2).mean() / closed.size)
    # A pixel's mean is not its middle: that is some 1e-5 at 256 pixels, and goes with the square of their size.
    bound = noise + 1e-5 * (256 / size) ** 2
    return ("9", "Ondine, path length 2, over the closed form, on the back wall above the spheres", 1, (direct[free] / closed).mean(), bound)
