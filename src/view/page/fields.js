// @ts-check
// Fields for numbers and colours.

import { rounded } from "./camera.js";
import { create, setField } from "./dom.js";
import { decode, encode } from "./tonemap.js";

/** @typedef {import("./protocol.js").Vec3} Vec3 */

/** Places along a slider. */
const PLACES = 1000;

/** From a place in [0, 1] to the part of a range, and back. @type {Record<string, {at(t: number): number, of(part: number): number}>} */
const SHAPES = {
  even: { at: (t) => t, of: (part) => part },
  // Fine near the low end.
  cubic: { at: (t) => t ** 3, of: (part) => Math.cbrt(part) },
};

/**
 * A number as a field shows it.
 * @param {number} value
 */
export function text(value) {
  return String(rounded(value));
}

/**
 * What is written in a field, brought into its range; null where it is no number.
 * @param {HTMLInputElement} field
 */
export function numberIn(field) {
  const value = field.valueAsNumber;
  if (Number.isNaN(value)) return null;
  const low = field.min === "" ? -Infinity : Number(field.min);
  const high = field.max === "" ? Infinity : Number(field.max);
  return Math.max(low, Math.min(high, value));
}

/**
 * A labelled slider with a field for the number itself.
 */
export class NumberRow {
  /**
   * `low` and `high` are the slider's: the field takes any number, and the program says what is wrong with it. `shape`:
   * "even", "cubic" or "log".
   * @param {{id: string, label: string, low: number, high: number, shape?: string, unit?: string, step?: number}} settings
   * @param {(value: number) => void} changed
   */
  constructor({ id, label, low, high, shape = "even", unit = "", step = 0.01 }, changed) {
    this.low = low;
    this.high = high;
    this.shape = shape;
    this.field = create("input", { id, type: "number", step: String(step) });
    this.slider = create("input", {
      type: "range",
      min: "0",
      max: String(PLACES),
      step: "1",
      "aria-label": `${label}, slider`,
    });
    const name = create("label", { for: id }, label);
    if (unit !== "") name.append(create("span", { class: "unit" }, ` ${unit}`));
    this.element = create("div", { class: "row number" }, name, this.slider, this.field);
    this.slider.addEventListener("input", () => {
      const value = rounded(this.#value(Number(this.slider.value) / PLACES));
      this.field.value = text(value);
      changed(value);
    });
    this.field.addEventListener("change", () => {
      const value = numberIn(this.field);
      if (value === null) return;
      this.show(value, true);
      changed(value);
    });
  }

  /**
   * @param {number} value
   * @param {boolean} [forced]
   */
  show(value, forced = false) {
    setField(this.field, text(value), forced);
    setField(this.slider, String(Math.round(PLACES * this.#place(value))), forced);
    this.slider.setAttribute("aria-valuetext", text(value));
  }

  /** @param {number} t */
  #value(t) {
    if (this.shape === "log") return this.low * (this.high / this.low) ** t;
    return this.low + (this.high - this.low) * SHAPES[this.shape].at(t);
  }

  /** @param {number} value */
  #place(value) {
    value = Math.max(this.low, Math.min(this.high, value));
    if (this.shape === "log") return Math.log(value / this.low) / Math.log(this.high / this.low);
    return SHAPES[this.shape].of((value - this.low) / (this.high - this.low || 1));
  }
}

/**
 * A colour as a screen shows it, "#rrggbb"; linear in.
 * @param {Vec3} linear
 */
export function css(linear) {
  const code = (/** @type {number} */ x) => Math.round(255 * encode(Math.max(0, Math.min(1, x))));
  return `#${linear.map((x) => code(x).toString(16).padStart(2, "0")).join("")}`;
}

/** A labelled colour: as a screen shows it, and its three linear channels. */
export class ColorRow {
  /** @type {Vec3} */
  #value = [0, 0, 0];

  /**
   * @param {{id: string, label: string}} settings
   * @param {(value: Vec3) => void} changed
   */
  constructor({ id, label }, changed) {
    this.picker = create("input", { id, type: "color", "aria-label": `${label}, as the screen shows it` });
    this.channels = ["red", "green", "blue"].map((channel) =>
      create("input", {
        id: `${id}-${channel}`,
        type: "number",
        min: "0",
        max: "1",
        step: "0.01",
        "aria-label": `${label}, linear ${channel}`,
      }),
    );
    this.element = create("div", { class: "row color" }, create("label", { for: id }, label), this.picker, ...this.channels);
    this.picker.addEventListener("input", () => {
      const code = Number.parseInt(this.picker.value.slice(1), 16);
      // As many digits as it takes to give the code back.
      const channel = (/** @type {number} */ shift) => Number(decode(((code >> shift) & 255) / 255).toPrecision(3));
      this.#value = [channel(16), channel(8), channel(0)];
      this.#showChannels(true);
      changed(this.#value);
    });
    this.channels.forEach((field, i) =>
      field.addEventListener("change", () => {
        const value = numberIn(field);
        if (value === null) return;
        field.value = text(value);
        const next = /** @type {Vec3} */ ([...this.#value]);
        next[i] = value;
        this.#value = next;
        this.picker.value = css(next);
        changed(next);
      }),
    );
  }

  /**
   * @param {Vec3} value
   * @param {boolean} [forced]
   */
  show(value, forced = false) {
    this.#value = value;
    setField(this.picker, css(value), forced);
    this.#showChannels(forced);
  }

  /** @param {boolean} forced */
  #showChannels(forced) {
    this.channels.forEach((field, i) => setField(field, text(this.#value[i]), forced));
  }
}
