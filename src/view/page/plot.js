// @ts-check
// The estimated error against time or samples, both axes logarithmic.

import { byId } from "./dom.js";

/** @typedef {import("./protocol.js").SideStatistics} SideStatistics */

const SVG = "http://www.w3.org/2000/svg";

/** Lines between decades, as long as there is room for them. */
const WITHIN = [2, 3, 4, 5, 6, 7, 8, 9];

/** CSS pixels around the axes: left, right, top, bottom. */
const MARGIN = { left: 46, right: 12, top: 8, bottom: 34 };

/**
 * A power of ten as an axis says it.
 * @param {number} exponent
 */
function decade(exponent) {
  if (exponent >= 0 && exponent <= 3) return String(10 ** exponent);
  if (exponent >= -3 && exponent < 0) return (10 ** exponent).toFixed(-exponent);
  return `10${String(exponent).replace(/./g, (digit) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(digit)])}`;
}

/**
 * The exponent of a power law through points, over the last decade of x; null where there are too few.
 * @param {[number, number][]} points
 */
export function slope(points) {
  const last = points.at(-1)?.[0] ?? 0;
  const logs = points.filter(([x]) => x >= last / 10).map(([x, y]) => [Math.log(x), Math.log(y)]);
  if (logs.length < 3) return null;
  const mean = (/** @type {number} */ i) => logs.reduce((sum, log) => sum + log[i], 0) / logs.length;
  const [mx, my] = [mean(0), mean(1)];
  let [xy, xx] = [0, 0];
  for (const [x, y] of logs) {
    xy += (x - mx) * (y - my);
    xx += (x - mx) ** 2;
  }
  return xx > 0 ? xy / xx : null;
}

export class Plot {
  #svg = byId("plot", SVGSVGElement);
  #against = byId("against", HTMLSelectElement);
  #slopes = byId("slopes", HTMLElement);
  /** @type {SideStatistics[]} */
  #sides = [];

  constructor() {
    this.#against.addEventListener("change", () => this.#draw());
    new ResizeObserver(() => this.#draw()).observe(this.#svg);
  }

  /** @param {SideStatistics[]} sides */
  show(sides) {
    this.#sides = sides;
    this.#draw();
  }

  #draw() {
    const bySamples = this.#against.value === "samples";
    const lines = this.#sides.map(({ curve }) =>
      curve
        .map(([seconds, samples, error]) => /** @type {[number, number]} */ ([bySamples ? samples : seconds, error]))
        .filter(([x, y]) => x > 0 && y > 0 && Number.isFinite(y)),
    );
    this.#tellSlopes(lines, bySamples ? "n" : "t");
    const { width, height } = this.#svg.getBoundingClientRect();
    if (width < MARGIN.left + MARGIN.right + 20) return;
    this.#svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    const right = width - MARGIN.right;
    const bottom = height - MARGIN.bottom;
    const across = axis(
      lines.flat().map(([x]) => x),
      [1, 10],
    );
    const upwards = axis(
      lines.flat().map(([, y]) => y),
      [0.01, 0.1],
    );
    const x = (/** @type {number} */ value) => MARGIN.left + (right - MARGIN.left) * across.part(value);
    const y = (/** @type {number} */ value) => bottom - (bottom - MARGIN.top) * upwards.part(value);
    const parts = [];
    for (const { value, label, major } of across.ticks) {
      parts.push(line(x(value), MARGIN.top, x(value), bottom, major ? "major" : "minor"));
      if (label !== "") parts.push(words(x(value), bottom + 14, label, "middle"));
    }
    for (const { value, label, major } of upwards.ticks) {
      parts.push(line(MARGIN.left, y(value), right, y(value), major ? "major" : "minor"));
      if (label !== "") parts.push(words(MARGIN.left - 6, y(value) + 3.5, label, "end"));
    }
    parts.push(words((MARGIN.left + right) / 2, height - 4, bySamples ? "samples per pixel" : "seconds of render", "middle"));
    const vertical = words(0, 0, "relative error", "middle");
    vertical.setAttribute("transform", `translate(10 ${(MARGIN.top + bottom) / 2}) rotate(-90)`);
    parts.push(vertical);
    const last = lines[0]?.at(-1);
    if (last !== undefined) parts.push(reference(last, across, { x, y }));
    lines.forEach((points, i) => {
      if (points.length === 0) return;
      const side = "ab"[i];
      const path = element("path", {
        d: points.map(([px, py], j) => `${j ? "L" : "M"}${x(px).toFixed(1)} ${y(py).toFixed(1)}`).join(""),
        class: `curve ${side}`,
        "clip-path": "url(#within)",
      });
      const [px, py] = points[points.length - 1];
      parts.push(path, element("circle", { cx: String(x(px)), cy: String(y(py)), r: "3.5", class: `now ${side}` }));
    });
    const within = element("clipPath", { id: "within" });
    within.append(
      element("rect", {
        x: String(MARGIN.left),
        y: String(MARGIN.top),
        width: String(right - MARGIN.left),
        height: String(bottom - MARGIN.top),
      }),
    );
    this.#svg.replaceChildren(within, ...parts);
  }

  /**
   * @param {[number, number][][]} lines
   * @param {string} symbol
   */
  #tellSlopes(lines, symbol) {
    const told = lines.flatMap((points, i) => {
      const exponent = slope(points);
      if (exponent === null) return [];
      return `${lines.length > 1 ? `${"AB"[i]} ` : ""}falls as ${symbol}^${exponent.toFixed(2).replace("-", "−")}`;
    });
    this.#slopes.textContent = told.join(", ").replace(/(, B) falls/, "$1");
  }
}

/**
 * A logarithmic axis around values: where they lie, and what is marked.
 * @param {number[]} values
 * @param {[number, number]} otherwise the ends where there are none
 */
function axis(values, otherwise) {
  let [low, high] = otherwise.map(Math.log10);
  if (values.length > 0) {
    low = Math.log10(Math.min(...values));
    high = Math.log10(Math.max(...values));
    // At least a decade, so that a beginning does not look like an end.
    const missing = Math.max(0, 1 - (high - low));
    low -= 0.04 + missing / 2;
    high += 0.04 + missing / 2;
  }
  const ticks = [];
  const every = Math.ceil((high - low) / 7);
  for (let exponent = Math.floor(low); exponent <= Math.ceil(high); exponent++) {
    const fine = high - low < 3.5 ? WITHIN : [];
    for (const digit of [1, ...fine]) {
      const log = exponent + Math.log10(digit);
      if (log < low || log > high) continue;
      const major = digit === 1;
      let label = major && exponent % every === 0 ? decade(exponent) : "";
      if (!major && high - low < 2.2 && (digit === 2 || digit === 5)) label = inDecade(digit, exponent);
      ticks.push({ value: digit * 10 ** exponent, label, major });
    }
  }
  return { ticks, low, high, part: (/** @type {number} */ value) => (Math.log10(value) - low) / (high - low) };
}

/** @param {number} digit @param {number} exponent */
function inDecade(digit, exponent) {
  if (exponent < -3 || exponent > 4) return "";
  return exponent < 0 ? (digit * 10 ** exponent).toFixed(-exponent) : String(digit * 10 ** exponent);
}

/**
 * Through a point, what falls as a square root does.
 * @param {[number, number]} point
 * @param {{low: number, high: number}} across
 * @param {{x(value: number): number, y(value: number): number}} place
 */
function reference([px, py], { low, high }, { x, y }) {
  const at = (/** @type {number} */ log) => {
    const value = 10 ** log;
    return [x(value), y(py * Math.sqrt(px / value))];
  };
  const [x1, y1] = at(low);
  const [x2, y2] = at(high);
  const dashed = line(x1, y1, x2, y2, "reference");
  dashed.setAttribute("clip-path", "url(#within)");
  return dashed;
}

/**
 * @param {string} tag
 * @param {Record<string, string>} attributes
 */
function element(tag, attributes) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
}

/** @param {number} x1 @param {number} y1 @param {number} x2 @param {number} y2 @param {string} kind */
function line(x1, y1, x2, y2, kind) {
  const fixed = (/** @type {number} */ value) => value.toFixed(1);
  return element("line", { x1: fixed(x1), y1: fixed(y1), x2: fixed(x2), y2: fixed(y2), class: kind });
}

/** @param {number} x @param {number} y @param {string} content @param {string} anchor */
function words(x, y, content, anchor) {
  const made = element("text", { x: x.toFixed(1), y: y.toFixed(1), "text-anchor": anchor });
  made.textContent = content;
  return made;
}
