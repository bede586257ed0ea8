#!/usr/bin/env python3
"""Renders the figures and tables of the 2014 report again, each with its error, and writes docs/figures.md.

    figures.py [--ondine PROGRAM] [--out FOLDER] [--only 6,7] [--cache FOLDER] [--threads N] [--repeat N]
    figures.py --quick [--ondine PROGRAM]

The page is tools/figures.template.md with the tables filled in; pictures go to FOLDER/images/figures. Seeds are fixed: a second run
changes nothing but the seconds, and not even those while the cache is kept (target/figures, a folder for each build of the
program). To measure them anew, leave the machine alone and delete the `.seconds` files there.

--only writes the pictures of some figures and prints their tables; the page is left alone. --quick does everything tiny, in a
temporary folder. Exits 1 where what the page says does not hold: light is better than cosine, and that than uniform; errors
fall with the square root of the samples; means agree with the reference; the equations give what they should. 2 is bad usage.

Needs the packages matplotlib, numpy, OpenEXR and pillow.
"""

import argparse
import hashlib
import json
import math
import os
import platform
import re
import statistics
import string
import subprocess
import sys
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

try:
    import matplotlib
    import numpy
    import OpenEXR
    from matplotlib import pyplot
    from PIL import Image, ImageDraw, ImageFont
except ImportError as missing:
    print(f"figures: {missing}; pip install matplotlib numpy OpenEXR pillow", file=sys.stderr)
    sys.exit(2)

import lamp_equations

ROOT = Path(__file__).resolve().parent.parent
PANEL, GAP, HEADER = 256, 12, 40
# Standard errors that a mean may be off its reference: chance alone does it once in 150,000.
FARTHEST = 4.5


@dataclass(frozen=True)
class Shot:
    """One render. Its numbers are independent (pcg), as the report's were."""

    strategy: str
    spp: int
    length: int
    scene: str = "cornell"
    sampler: str = "pcg"

    def __str__(self):
        of = "" if self.scene == "cornell" else f"{self.scene}: "
        return f"{of}{self.strategy} · {self.spp} spp · path length {self.length}"


def shots(strategies, spp, length):
    return [Shot(strategy, spp, length) for strategy in strategies.split()]


# One shot is shown with its reference and its difference from it, two with their reference, more by themselves.
FIGURES = {
    "2": shots("uniform cosine", 10, 2),
    "3": shots("uniform", 1000, 3),
    "4": shots("uniform", 1024, 5),
    "5": shots("cosine", 4096, 5),
    "6": shots("uniform cosine", 5, 5),
    "7": shots("uniform cosine", 10, 5),
    "13": shots("light", 256, 5),
    "14": shots("uniform cosine light", 5, 5),
    "15": shots("uniform cosine light", 10, 5),
    "16": [Shot("mis", 1024, length, scene) for scene, length in [("blur", 6), ("mirror", 8), ("glass", 10), ("glossy", 7)]],
}
GUIDE = "#666666"
SECTIONS = [*(str(number) for number in range(1, 17)), "convergence"]
# Strategy, sampler, colour and marker. The colours have different lightness, and contrast 4.5 or more with white.
LINES = [
    ("uniform", "pcg", "#c8450a", "o"),
    ("cosine", "pcg", "#8a2a6b", "s"),
    ("light", "pcg", "#0a6fae", "^"),
    ("mis", "pcg", "#007a55", "D"),
    ("mis", "sobol", "#222222", "v"),
]


class Wrong(Exception):
    """What the page says does not hold."""


@dataclass
class Reference:
    """The mean of two independent halves, its variance, and its squared error, which their difference tells without a bias."""

    mean: numpy.ndarray
    variance: numpy.ndarray
    squared_error: numpy.ndarray


@dataclass
class Error:
    """Of an image: RMSE, relMSE (of d² / (ref² + 0.01)), and the relative deviation of its mean with the standard error."""

    rmse: float
    relmse: float
    deviation: float
    standard_error: float


class Renders:
    """What the program renders: each image once, kept in a folder."""

    def __init__(self, program, cache, size, half_spp, threads):
        self.program, self.size, self.half_spp, self.threads = program, size, half_spp, threads
        self.cache = cache / hashlib.sha256(program.read_bytes()).hexdigest()[:12]
        self.cache.mkdir(parents=True, exist_ok=True)

    def call(self, *arguments):
        command = [str(self.program), *(str(argument) for argument in arguments)]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            raise ValueError(f"{' '.join(command)}: exit code {done.returncode}: {done.stderr.strip()}")
        return json.loads(done.stdout)

    def path(self, shot, seed):
        name = f"{shot.scene}-{self.size}x{self.size}-{shot.strategy}-{shot.sampler}-{shot.spp}-{shot.length}-{seed}.exr"
        return self.cache / name

    def render(self, shot, seed, threads):
        """Seconds of the render loop."""
        if sys.stderr.isatty():
            print(f"{shot}, {shot.sampler}, seed {seed}", file=sys.stderr)
        options = ["--size", f"{self.size}x{self.size}", "--strategy", shot.strategy, "--sampler", shot.sampler]
        options += ["--spp", shot.spp, "--path-length", shot.length, "--seed", seed, "--threads", threads]
        return self.call("render", shot.scene, *options, "--no-png", "--json", "--quiet", "-o", self.path(shot, seed))["render_s"]

    def image(self, shot, seed=0):
        """The mean and its variance, rows x columns x 3."""
        path = self.path(shot, seed)
        if not path.exists():
            self.render(shot, seed, self.threads)
        channels = OpenEXR.File(str(path), separate_channels=True).channels()
        return [numpy.stack([channels[layer + c].pixels.astype(float) for c in "RGB"], axis=-1) for layer in ("", "variance.")]

    def seconds(self, shot, repeat):
        """Of the render loop on one thread: the least of some runs, as other work on the machine can only add to them."""
        path = self.path(shot, 0).with_suffix(".seconds")
        runs = json.loads(path.read_text()) if path.exists() else []
        if len(runs) < repeat:
            runs += [self.render(shot, 0, 1) for _ in range(repeat - len(runs))]
            path.write_text(json.dumps(runs))
        return min(runs[:repeat])

    def reference(self, shot):
        """Of the shot's scene and path length."""
        half = replace(shot, strategy="mis", sampler="sobol", spp=self.half_spp)
        (a, a_variance), (b, b_variance) = self.image(half, 1), self.image(half, 2)
        return Reference((a + b) / 2, (a_variance + b_variance) / 4, ((a - b) / 2) ** 2)

    def error(self, shot):
        (mean, variance), reference = self.image(shot), self.reference(shot)
        squares, total = (mean - reference.mean) ** 2 - reference.squared_error, reference.mean.sum()
        relmse = (squares / (reference.mean**2 + 0.01)).mean()
        deviation = mean.sum() / total - 1
        # The channels of a sample go together: their standard errors add up.
        standard_error = numpy.sqrt((variance + reference.variance).sum(axis=(0, 1))).sum() / total
        if abs(deviation) > FARTHEST * standard_error:
            raise Wrong(f"{shot}, {shot.sampler}: the mean is off its reference by {deviation:+.2%} ± {standard_error:.2%}")
        return Error(math.sqrt(squares.mean()), relmse, deviation, standard_error)


def table(heading, rows):
    """In Markdown. Columns whose name begins with a blank go to the right."""
    rule = "|".join("---:" if name.startswith(" ") else "---" for name in heading)
    return "\n".join(["| " + " | ".join(name.strip() for name in heading) + " |", f"|{rule}|", *(f"| {' | '.join(row)} |" for row in rows)])


def tonemapped(radiance):
    """As `--tonemap aces` has it: Narkowicz's fit of the ACES curve, sRGB, eight bits."""
    x = numpy.clip(radiance * (2.51 * radiance + 0.03) / (radiance * (2.43 * radiance + 0.59) + 0.14), 0, 1)
    return numpy.round(255 * numpy.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)).astype(numpy.uint8)


def difference(mean, reference):
    """Of the green channel, relative, from -50 % to 50 %, as colours."""
    relative = (mean - reference)[..., 1] / numpy.maximum(reference[..., 1], 1e-3)
    return (255 * matplotlib.colormaps["RdBu_r"](numpy.clip(relative + 0.5, 0, 1))[..., :3]).astype(numpy.uint8)


def picture(path, panels):
    """Panels in rows of three, or two if there are four, each with two lines of text above it."""
    fonts = Path(matplotlib.get_data_path()) / "fonts/ttf"
    bold, plain = (ImageFont.truetype(fonts / name, 12, layout_engine=ImageFont.Layout.BASIC) for name in ("DejaVuSans-Bold.ttf", "DejaVuSans.ttf"))
    columns = 2 if len(panels) == 4 else 3
    height = HEADER + PANEL + GAP
    canvas = Image.new("RGB", (GAP + columns * (PANEL + GAP), math.ceil(len(panels) / columns) * height), "white")
    draw = ImageDraw.Draw(canvas)
    for i, (title, text, pixels) in enumerate(panels):
        x, y = GAP + i % columns * (PANEL + GAP), i // columns * height
        draw.text((x, y + 6), title, "#111111", bold if bold.getlength(title) <= PANEL else plain)
        draw.text((x, y + 22), text, "#444444", plain)
        canvas.paste(Image.fromarray(pixels).resize((PANEL, PANEL), Image.Resampling.NEAREST), (x, y + HEADER))
    canvas.save(path, quality=88, subsampling=0, optimize=True)


def figure(number, renders, images):
    """Writes a figure's picture; the table of its errors."""
    panels, rows = [], []
    for shot in FIGURES[number]:
        error = renders.error(shot)
        panels.append((str(shot), f"relMSE {error.relmse:.3g} · RMSE {error.rmse:.3g}", tonemapped(renders.image(shot)[0])))
        deviation, z = f"{error.deviation:+.3%} ± {error.standard_error:.3%}", f"{error.deviation / error.standard_error:+.1f}"
        rows.append([f"`{shot.scene}`", f"`{shot.strategy}`", str(shot.spp), str(shot.length), f"{error.relmse:.3g}", f"{error.rmse:.3g}", deviation, z])
    if len(panels) < 3:
        reference = renders.reference(shot)
        panels.append((f"reference · path length {shot.length}", f"mis, sobol, {2 * renders.half_spp} spp", tonemapped(reference.mean)))
        if len(panels) < 3:
            colours = difference(renders.image(shot)[0], reference.mean)
            panels.append(("relative difference, green", "blue −50 % … white 0 … red +50 %", colours))
    picture(images / f"figure-{number}.jpg", panels)
    heading = ["scene", "strategy", " spp", " path length", " relMSE", " RMSE", " mean's deviation", " z"]
    return {f"errors_{number}": table(heading, rows)}


def coefficients(renders):
    """The report's tables: what it prints, what its integral is, and what was meant."""
    lobes = renders.call("sh", "lobe", "--exponent", "1,5,10,50", "--bands", "6", "--convention", "report", "--json")["lobes"]
    rows = []
    for lobe in lobes:
        for printed in lobe["printed"]:
            for degree, value in enumerate(printed["values"]):
                if value is None:
                    continue
                integral, true = lobe["exact"][degree], lobe["lobe"][degree]
                off = f"{value / integral - 1:+.2%}".replace("-0.00%", "0.00%") if integral else "all noise"
                numbers = [f"{value:.4f}", f"{integral:.4f}" if integral else "0", off, f"{true:.4f}", f"{value / true:.2f}"]
                rows.append([printed["name"], f"{lobe['exponent']:g}", str(degree), *numbers])
    heading = ["the report's", " n", " l", " printed", " its integral", " off by", " true", " printed / true"]
    return {"coefficients": table(heading, rows), "cosine_1": f"{lobes[0]['lobe'][1]:.4f}"}


def power(value):
    """One digit times a power of ten."""
    digit, exponent = f"{value:.0e}".split("e")
    return f"{digit}·10{str(int(exponent)).translate(str.maketrans('-0123456789', '⁻⁰¹²³⁴⁵⁶⁷⁸⁹'))}"


def svg(drawing, path):
    drawing.savefig(path, metadata={"Date": None, "Creator": None}, facecolor="white", bbox_inches="tight", pad_inches=0.1)
    pyplot.close(drawing)


def explicit_sampling(renders, images):
    """The diagram, and the equations in numbers."""
    svg(lamp_equations.diagram(), images / "figure-8.svg")
    direct = renders.reference(Shot("mis", 1, 2))
    rows, explicit, blind = lamp_equations.checks()
    rows.insert(2, lamp_equations.wall(direct.mean[..., 0], direct.squared_error[..., 0]))
    shown = []
    for number, claim, expected, found, error in rows:
        if abs(found - expected) > FARTHEST * error:
            raise Wrong(f"figure {number}: {claim}: {found} is not {expected} ± {error}")
        known = round(found, 1 - math.floor(math.log10(error)))
        shown.append([number, claim, f"{expected:.6g}", f"{known:.6g}", power(error)])
    values = {"explicit_spread": f"{explicit:.3f}", "blind_spread": f"{blind:.1f}", "blind_samples": f"{(blind / explicit) ** 2:,.0f}"}
    return {"lamp": table(["figure", "what", " expected", " found", " ±"], shown), **values}


def apart(values, gap):
    """Heights of labels, pushed apart to `gap` at least."""
    order, placed = numpy.argsort(values), numpy.array(values, float)
    for _ in range(100):
        for low, high in zip(order, order[1:]):
            push = max(0.0, gap - (placed[high] - placed[low])) / 2
            placed[low], placed[high] = placed[low] - push, placed[high] + push
    return placed


def processor():
    try:
        told = dict(re.findall(r"^(.+?)\s*: (.+)$", Path("/proc/cpuinfo").read_text(), re.M))
        return f"{told['model name']} (family {told['cpu family']}, model {told['model']})"
    except (OSError, KeyError):
        return platform.processor() or platform.machine()


def convergence(renders, images, most_spp, repeat):
    """Error by samples and by seconds: a plot and a table."""
    spps = numpy.array([1 << k for k in range(2, most_spp.bit_length())])
    curves, rows = {}, []
    for strategy, sampler, *_ in LINES:
        shots = [Shot(strategy, int(spp), 5, sampler=sampler) for spp in spps]
        errors = numpy.sqrt([renders.error(shot).relmse for shot in shots])
        seconds = numpy.array([renders.seconds(shot, repeat) for shot in shots])
        slope, level = numpy.polyfit(numpy.log(spps), numpy.log(errors), 1)
        if sampler == "pcg" and not -0.6 < slope < -0.4:
            raise Wrong(f"{strategy}, {sampler}: the error goes with the {slope:.2f}th power of the samples")
        curves[strategy, sampler] = errors, seconds
        to_one_tenth = math.exp((math.log(0.1) - level) / slope)
        a_sample = statistics.median(seconds[len(spps) // 2 :] / spps[len(spps) // 2 :])
        times = [f"{1e9 * a_sample / renders.size**2:.0f}", f"{to_one_tenth * a_sample:.2g}"]
        rows.append([f"`{strategy}`", f"`{sampler}`", f"{slope:.2f}", f"{errors[-1]:.3f}", f"{to_one_tenth:,.0f}", *times])
    for better, worse in [("cosine", "uniform"), ("light", "cosine")]:
        if numpy.log(curves[better, "pcg"][0]).mean() >= numpy.log(curves[worse, "pcg"][0]).mean():
            raise Wrong(f"{better} is not better than {worse}")
    svg(plot(spps, curves), images / "convergence.svg")
    heading = ["strategy", "sampler", " slope", f" error at {most_spp} spp", " samples to 10 %", " ns a path", " seconds to 10 %"]
    return {"convergence": table(heading, rows), "most_spp": most_spp, "repeat": repeat, "processor": processor()}


def plot(spps, curves):
    drawing, axes = pyplot.subplots(1, 2, figsize=(10.2, 5), sharey=True)
    for which, (axis, name) in enumerate(zip(axes, ["samples per pixel", "seconds, one thread"])):
        ends = []
        for strategy, sampler, colour, marker in LINES:
            errors, seconds = curves[strategy, sampler]
            xs = seconds if which else spps
            # What lies under another line is drawn larger.
            axis.loglog(xs, errors, color=colour, marker=marker, ms=9 if strategy == "light" else 5, lw=1.8, ls="-" if sampler == "pcg" else "--")
            ends.append((xs[-1], errors[-1], strategy if sampler == "pcg" else f"{strategy}, {sampler}", colour))
        heights = 10 ** apart(numpy.log10([end[1] for end in ends]), 0.12)
        for (x, _, text, colour), height in zip(ends, heights):
            axis.text(x * 1.3, height, text, color=colour, va="center", fontsize=11, fontweight="bold")
        low, high = min(axis.lines[i].get_xdata()[0] for i in range(len(LINES))), max(end[0] for end in ends)
        axis.set(xlabel=name, xlim=(low / 1.5, high * (18 if which else 14)))
        guide = numpy.array([low, low * 30])
        bottom = min(end[1] for end in ends)
        axis.plot(guide, bottom * 1.6 * numpy.sqrt(30 * low / guide), color=GUIDE, lw=1.4, ls=":")
        axis.text(low, bottom * 3.2, "slope −1/2", color=GUIDE, va="top", fontsize=11)
        axis.grid(True, which="major", color="#dddddd", lw=0.6)
        axis.spines[["top", "right"]].set_visible(False)
    axes[0].set_ylabel("relative error, √relMSE")
    drawing.tight_layout()
    return drawing


def write(options, folder, size, half_spp, most_spp, repeat):
    images = folder / "images/figures"
    images.mkdir(parents=True, exist_ok=True)
    renders = Renders(options.ondine, options.cache, size, half_spp, options.threads)
    wanted = set(options.only or SECTIONS)
    values = {}
    for number in FIGURES:
        if number in wanted:
            values |= figure(number, renders, images)
    if "1" in wanted:
        values |= coefficients(renders)
    if wanted & {"8", "9", "10", "11", "12"}:
        values |= explicit_sampling(renders, images)
    if "convergence" in wanted:
        values |= convergence(renders, images, most_spp, repeat)
    if options.only:
        print("\n\n".join(f"{name}\n{value}" for name, value in values.items()))
        return
    values |= {"size": size, "reference_spp": 2 * half_spp}
    page = string.Template((ROOT / "tools/figures.template.md").read_text()).substitute(values)
    (folder / "figures.md").write_text(page)
    print(f"figures: {len(FIGURES) + 2} pictures, and {folder / 'figures.md'}; what it says holds")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--ondine", type=Path, default=ROOT / "target/release/ondine", metavar="PROGRAM", help="default: target/release/ondine")
    parser.add_argument("--out", type=Path, default=ROOT / "docs", metavar="FOLDER", help="default: docs")
    parser.add_argument("--only", type=lambda text: text.split(","), metavar="LIST", help="figures, 1 to 16, and convergence, with commas between")
    parser.add_argument("--quick", action="store_true", help="everything tiny, in a temporary folder")
    parser.add_argument("--cache", type=Path, default=ROOT / "target/figures", metavar="FOLDER", help="keeps renders; default: target/figures")
    parser.add_argument("--threads", type=int, default=os.cpu_count(), metavar="N", help="of renders that are not timed; default: one for each processor")
    parser.add_argument("--repeat", type=int, default=10, metavar="N", help="runs of each timed render; default 10")
    options = parser.parse_args()
    if unknown := set(options.only or []) - set(SECTIONS):
        parser.error(f"--only: there is no figure {', '.join(sorted(unknown))}; there are 1 to 16 and convergence")
    if options.repeat < 1:
        parser.error("--repeat is at least 1")
    if not options.ondine.is_file():
        parser.error(f"there is no program {options.ondine}; `cargo build --release` builds it, and --ondine names another")
    options.ondine = options.ondine.resolve()
    matplotlib.use("Agg")
    matplotlib.rcParams.update({"svg.hashsalt": "figures", "font.size": 11})
    try:
        if options.quick:
            with tempfile.TemporaryDirectory() as folder:
                options.cache = Path(folder)
                write(options, Path(folder), size=64, half_spp=1024, most_spp=256, repeat=1)
        else:
            write(options, options.out, size=256, half_spp=8192, most_spp=1024, repeat=options.repeat)
    except Wrong as wrong:
        print(f"figures: {wrong}", file=sys.stderr)
        return 1
    except (OSError, ValueError, KeyError) as error:
        print(f"figures: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
