"""The page of tools/performance.py: its tables, from the raw figures.

A figure is a median with the least and the greatest of its rounds. Tables are in Markdown, their places in performance.template.md.
"""

import string
from pathlib import Path

TEMPLATE = Path(__file__).resolve().with_name("performance.template.md")


def number(value):
    """Three digits, but all of those before the point."""
    return f"{value:,.0f}" if abs(value) >= 100 else f"{value:.3g}" if abs(value) < 1 else f"{value:.2f}" if abs(value) < 10 else f"{value:.1f}"


def shown(figure):
    """A median, and what the rounds range over."""
    low, high = number(figure["min"]), number(figure["max"])
    return number(figure["median"]) + (f" ({low}–{high})" if low != high else "")


def table(heading, rows):
    """In Markdown. Columns whose name begins with a blank go to the right."""
    rule = "|".join("---:" if name.startswith(" ") else "---" for name in heading)
    return "\n".join(["| " + " | ".join(name.strip() for name in heading) + " |", f"|{rule}|", *(f"| {' | '.join(row)} |" for row in rows)])


def ray_table(section):
    rows = []
    for row in section["traced"]:
        speeds = [shown(row["embree"]), shown(row["ondine"]), shown(row["ratio"])]
        rows.append([row["mesh"], row["set"], str(row["threads"]), ", ".join(f"`{name}`" for name in row["variants"]), *speeds])
    return table(["mesh", "rays", " threads", "Embree's best", " Embree, M rays/s", " Ondine, M rays/s", " ratio"], rows)


def build_table(section):
    build = section["build"]
    row = [shown(build["embree"]), shown(build["ondine"]), shown(build["ratio"]), number(build["bytes_a_triangle"])]
    return table([" Embree medium, s", " Ondine, s", " Ondine / Embree", " bytes a triangle"], [row])


def image_table(section):
    names = {"mi_llvm": "Mitsuba, independent", "mi_llvm_mj": "Mitsuba, multijitter", "pcg": "Ondine, `pcg`", "sobol": "Ondine, `sobol`"}
    rows = []
    for row in section["rendered"]:
        ratios = [shown(row[key]) if key in row else "" for key in ("faster", "better")]
        rows.append([row["scene"], names[row["peer"]], shown(row["mpaths_s"]), ratios[0], shown(row["relmse"]), shown(row["efficiency"]), ratios[1]])
    return table(["scene", "renderer", " M paths/s", " ratio", " relMSE", " 1 / (relMSE · s)", " ratio"], rows)


def thread_table(section):
    return table(["sampler", " two threads / one"], [[f"`{name}`", shown(figure)] for name, figure in section["threads"].items()])


def sh_table(section):
    rows = []
    for row in section["evaluated"]:
        rows.append([f"{row['directions']:,}", str(row["degree"]), *(shown(row[key]) for key in ("sphericart", "ondine", "ratio"))])
    return table([" directions a call", " degree", " sphericart, M/s", " Ondine, M/s", " ratio"], rows)


def growth_table(section):
    rows = []
    for row in section["grown"]:
        numbers = [row["build_s"], *row["mrays_per_s"].values(), row["diffuse_ns_by_log"], row["build_ns_by_log"]]
        rows.append([f"{row['triangles']:,}", *map(number, numbers)])
    heading = [" triangles", " build, s", " primary", " diffuse", " shuffled", " shadow", " ns a diffuse ray / log₂ n", " build, ns a triangle / log₂ n"]
    return table(heading, rows)


def promise_table(sections):
    """Every figure that was asked for, and those that could not be measured."""
    rows = []
    for name, section in sections.items():
        if "not_measured" in section:
            rows.append([f"all of `{name}`", "", "", f"not measured: {section['not_measured'].replace('|', '/')}", "", ""])
            continue
        for row in section["promises"]:
            figure = row["measured"]
            sign, asked = ("≥", row["at_least"]) if row["at_most"] is None else ("≤", row["at_most"])
            unit = f" {row['unit']}" if row["unit"] else ""
            limit = "" if asked is None else f"{sign} {asked:,g}{unit}"
            met = {None: "", True: "yes", False: "**no**"}[row["met"]]
            if met == "yes" and row["goal"] is not None and figure["median"] >= row["goal"]:
                met = "yes, and the goal"
            goal = "" if row["goal"] is None else f"{row['goal']:g}{unit}"
            rows.append([row["what"], limit, goal, shown(figure) + unit, "" if row["to_asked"] is None else number(row["to_asked"]), met])
    return table(["what", " asked", " goal", " measured", " to what was asked", "met"], rows)


TABLES = {"ray_table": ("rays", ray_table), "build_table": ("rays", build_table), "image_table": ("images", image_table)}
TABLES |= {"thread_table": ("images", thread_table), "sh_table": ("sh", sh_table), "growth_table": ("growth", growth_table)}


def page(report):
    """The page, from the raw figures."""
    sections = report["sections"]
    values = {key: report[key] for key in ("date", "command", "rounds", "threads")}
    values["quick"] = "**These figures are of `--quick`, a trial: they say nothing.**\n\n" if report["quick"] else ""
    for key in ("machine", "versions"):
        values[key] = table(["", ""], [[name, str(told)] for name, told in report[key].items()])
    for key, (name, build) in TABLES.items():
        section = sections.get(name, {"not_measured": "left out by `--only`"})
        values[key] = f"Not measured: {section['not_measured']}." if "not_measured" in section else build(section)
    judged = [row["met"] for section in sections.values() for row in section.get("promises", []) if row["met"] is not None]
    values |= {"met": sum(judged), "asked": len(judged), "promise_table": promise_table(sections)}
    values["spp"] = sections.get("images", {}).get("spp", "some")
    values["minutes"] = f"{sum(section['seconds'] for section in sections.values()) / 60:.0f}"
    return string.Template(TEMPLATE.read_text()).substitute(values)
