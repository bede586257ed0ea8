// @ts-check
// What each side has done so far, in figures.

import { byId, create } from "./dom.js";
import { Plot } from "./plot.js";

/** @typedef {import("./protocol.js").SideStatistics} SideStatistics */
/** @typedef {import("./protocol.js").Statistics} Message */

/**
 * Three significant digits, without an exponent.
 * @param {number} value
 */
export function threeDigits(value) {
  if (!Number.isFinite(value)) return Number.isNaN(value) ? "NaN" : value > 0 ? "∞" : "−∞";
  const text = Math.abs(value) >= 100 ? value.toFixed(0) : value.toPrecision(3);
  return (text.includes("e") ? Number(text).toExponential(2) : text).replace("-", "−");
}

/** @param {number} value */
const millions = (value) => (value > 0 ? `${threeDigits(value / 1e6)} M` : "–");

/** @param {number} value @param {number} [digits] */
const percent = (value, digits = 0) => `${(100 * value).toFixed(digits)} %`;

/** @param {number} seconds */
function duration(seconds) {
  if (seconds < 60) return `${seconds.toFixed(seconds < 10 ? 2 : 1)} s`;
  const [minutes, rest] = [Math.floor(seconds / 60), Math.floor(seconds % 60)];
  if (minutes < 60) return `${minutes} min ${String(rest).padStart(2, "0")} s`;
  return `${Math.floor(minutes / 60)} h ${String(minutes % 60).padStart(2, "0")} min`;
}

/** @param {SideStatistics} side */
const errorOf = (side) => side.curve.at(-1)?.[2] ?? null;

export class StatisticsPanel {
  #plot = new Plot();

  /** @param {Message} message */
  show({ sides }) {
    this.#plot.show(sides);
    const { dataset } = document.documentElement;
    for (const [i, letter] of ["a", "b"].entries()) {
      const side = sides[i];
      const tell = (/** @type {string} */ what, /** @type {string} */ text) => {
        byId(`${what}-${letter}`, HTMLElement).textContent = text;
      };
      const samples = i === 0 ? "samplesA" : "samplesB";
      const error = i === 0 ? "errorA" : "errorB";
      if (side === undefined) {
        delete dataset[samples];
        delete dataset[error];
        for (const what of ["samples", "seconds", "paths", "rays", "error", "rejected"]) tell(what, "");
        byId(`stages-${letter}`, HTMLTableSectionElement).replaceChildren();
        continue;
      }
      const relative = errorOf(side);
      dataset[samples] = String(side.samples);
      dataset[error] = relative === null ? "" : String(relative);
      tell("samples", String(side.samples));
      tell("seconds", duration(side.seconds));
      tell("paths", millions(side.paths_per_s));
      tell("rays", millions(side.rays_per_s));
      tell("error", relative === null ? "–" : percent(relative, relative < 0.1 ? 2 : 1));
      tell("rejected", String(side.rejected));
      byId(`stages-${letter}`, HTMLTableSectionElement).replaceChildren(...stageRows(side, letter));
    }
  }

  /** @param {number} milliseconds */
  showLatency(milliseconds) {
    document.documentElement.dataset.latencyMs = milliseconds.toFixed(0);
    byId("latency", HTMLElement).textContent = `first picture after ${milliseconds.toFixed(0)} ms`;
  }
}

/**
 * A row for each stage: its part of the time, what it handles in a second, and how full its lanes are.
 * @param {SideStatistics} side
 * @param {string} letter
 */
function stageRows({ stages }, letter) {
  const all = stages.reduce((sum, { seconds }) => sum + seconds, 0);
  return stages.map(({ name, seconds, items, lane_use }) => {
    const part = all > 0 ? seconds / all : 0;
    const bar = create("span", { class: `bar ${letter}` });
    bar.style.width = `${100 * part}%`;
    return create(
      "tr",
      {},
      create("th", { scope: "row" }, name),
      create("td", { class: "part" }, create("span", { class: "track" }, bar), create("span", {}, percent(part))),
      create("td", {}, seconds > 0 ? millions(items / seconds) : "–"),
      create("td", {}, percent(lane_use)),
    );
  });
}
