// @ts-check
// Pictures without WebGL 2: the same, by a table of all half floats.

import { table } from "./tonemap.js";

/** @typedef {import("./protocol.js").Image} Image */
/** @typedef {import("./tonemap.js").Display} Display */

export class CanvasScreen {
  /** @type {Image[]} */
  #images = [];
  /** @type {HTMLCanvasElement[]} Each image as it is shown, in its own size. */
  #shown = [];
  #table = new Uint8ClampedArray(0);
  /** What the table and what is shown were made for. */
  #display = "";
  #current = false;

  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
    this.context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d", { alpha: false }));
  }

  fits() {
    return true;
  }

  restore() {
    return true;
  }

  /** @param {Image[]} images */
  upload(images) {
    this.#images = images;
    this.#current = false;
  }

  /**
   * @param {Display} display
   * @param {number} divider the column at which the second side begins
   */
  draw(display, divider) {
    const { context, canvas } = this;
    const key = JSON.stringify(display);
    if (this.#display !== key) {
      this.#table = table(display);
      this.#display = key;
      this.#current = false;
    }
    if (!this.#current) this.#shown = this.#images.map((image, i) => this.#map(image, this.#shown[i]));
    this.#current = true;
    context.imageSmoothingEnabled = true;
    this.#shown.forEach((shown, i) => {
      context.save();
      context.beginPath();
      context.rect(i === 0 ? 0 : divider, 0, canvas.width, canvas.height);
      context.clip();
      context.drawImage(shown, 0, 0, canvas.width, canvas.height);
      context.restore();
    });
  }

  /**
   * @param {Image} image
   * @param {HTMLCanvasElement} [canvas] to draw on again
   */
  #map({ width, height, channels, data }, canvas = document.createElement("canvas")) {
    canvas.width = width;
    canvas.height = height;
    const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d", { alpha: false }));
    const pixels = context.createImageData(width, height);
    const codes = this.#table;
    const [green, blue] = channels === 1 ? [0, 0] : [1, 2];
    for (let from = 0, to = 0; from < data.length; from += channels, to += 4) {
      pixels.data[to] = codes[data[from]];
      pixels.data[to + 1] = codes[data[from + green]];
      pixels.data[to + 2] = codes[data[from + blue]];
      pixels.data[to + 3] = 255;
    }
    context.putImageData(pixels, 0, 0);
    return canvas;
  }
}
