// @ts-check
// The picture: what is on the canvas, how large it is, and where its two sides meet.

import { CanvasScreen } from "./canvas.js";
import { byId, nextFrame } from "./dom.js";
import { GlScreen } from "./gl.js";
import { half, largest, modeOf } from "./tonemap.js";

/** @typedef {import("./protocol.js").Picture} Data */

/** What an arrow key moves the divider by, of the width; with shift, and by page, ten times that. */
const STEP = 0.01;

export class Picture {
  #stage = byId("stage", HTMLDivElement);
  #frame = byId("frame", HTMLDivElement);
  #divider = byId("divider", HTMLDivElement);
  #canvas = byId("picture", HTMLCanvasElement);
  /** @type {GlScreen | CanvasScreen} */
  #screen;
  /** @type {Data | null} */
  #data = null;
  /** What has yet to be told of as drawn. */
  #undrawn = false;
  #scheduled = false;
  #farthest = 0;
  #zoom = "fit";
  /** Where the second side begins, of the width. */
  #meeting = 0.5;
  #split = false;
  exposure = 0;
  curve = "linear";

  /** @param {(picture: Data) => void} drawn a new picture is on the canvas */
  constructor(drawn) {
    this.drawn = drawn;
    const plain = new URLSearchParams(location.search).has("canvas");
    this.#screen = (plain ? null : GlScreen.on(this.#canvas)) ?? this.#withoutGl();
    this.#frame.addEventListener("webglcontextlost", (event) => event.preventDefault(), true);
    this.#frame.addEventListener("webglcontextrestored", () => this.#restore(), true);
    new ResizeObserver(() => this.#layOut()).observe(this.#stage);
    this.#handleDivider();
  }

  /** Whether there is one yet. */
  get isEmpty() {
    return this.#data === null;
  }

  /** Whether it has two sides. */
  get isSplit() {
    return this.#split;
  }

  /** The size in pixels of the image. */
  get size() {
    return [this.#canvas.width, this.#canvas.height];
  }

  /** CSS pixels that the picture's height takes. */
  get shownHeight() {
    return this.#canvas.getBoundingClientRect().height;
  }

  /**
   * "fit": as large as the image is, or as the room allows; else CSS pixels for each pixel.
   * @param {string} zoom
   */
  set zoom(zoom) {
    this.#zoom = zoom;
    this.#layOut();
  }

  /**
   * What the next picture shows: until then the last one stays as it is, in its own shape.
   * @param {[number, number]} size
   * @param {string[]} labels of its sides
   */
  expect([width, height], labels) {
    this.#split = labels.length > 1;
    this.#divider.hidden = !this.#split;
    this.#frame.classList.toggle("split", this.#split);
    labels.forEach((label, i) => {
      byId(i === 0 ? "label-a" : "label-b", HTMLElement).textContent = `${"AB"[i]}  ${label}`;
    });
    if (this.#canvas.width !== width || this.#canvas.height !== height) {
      this.#canvas.width = width;
      this.#canvas.height = height;
      this.#layOut();
      if (!this.#screen.fits()) this.#screen = this.#withoutGl();
    }
    this.#meet(this.#meeting);
  }

  /** @param {Data} data */
  show(data) {
    this.#data = data;
    const mode = modeOf(data.layer);
    this.#farthest = mode === "depth" ? Math.max(...data.sides.map((side) => largest(side.data))) : 0;
    this.#screen.upload(data.sides);
    this.#undrawn = true;
    this.redraw();
  }

  /** Draws it in the next frame. */
  redraw() {
    if (this.#scheduled) return;
    this.#scheduled = true;
    nextFrame(() => {
      this.#scheduled = false;
      this.#draw();
    });
  }

  /**
   * The pixel under a place of the window, or null beside the picture.
   * @param {{clientX: number, clientY: number}} place
   * @returns {[number, number] | null}
   */
  pixelAt({ clientX, clientY }) {
    const box = this.#canvas.getBoundingClientRect();
    const x = Math.floor(((clientX - box.left) / box.width) * this.#canvas.width);
    const y = Math.floor(((clientY - box.top) / box.height) * this.#canvas.height);
    return x >= 0 && y >= 0 && x < this.#canvas.width && y < this.#canvas.height ? [x, y] : null;
  }

  /**
   * The side that shows a column.
   * @param {number} x
   */
  sideAt(x) {
    return this.#split && x >= this.#meetingColumn() ? 1 : 0;
  }

  /**
   * The values of a pixel, of one or three channels, or null where there are none yet.
   * @param {number} x
   * @param {number} y
   * @param {number} side
   * @returns {number[] | null}
   */
  valuesAt(x, y, side) {
    const image = this.#data?.sides[side];
    const [width, height] = this.size;
    if (image === undefined || !(x >= 0 && y >= 0 && x < width && y < height)) return null;
    // A coarse picture has fewer pixels over the same frame.
    const column = Math.floor((x * image.width) / width);
    const row = Math.floor((y * image.height) / height);
    const start = (row * image.width + column) * image.channels;
    return Array.from(image.data.subarray(start, start + image.channels), half);
  }

  #draw() {
    const data = this.#data;
    if (data === null) return;
    const { exposure, curve } = this;
    const display = { mode: modeOf(data.layer), curve, exposure, farthest: this.#farthest };
    this.#screen.draw(display, this.#split ? this.#meetingColumn() : this.#canvas.width);
    if (!this.#undrawn) return;
    this.#undrawn = false;
    this.drawn(data);
  }

  #restore() {
    if (!this.#screen.restore()) this.#screen = this.#withoutGl();
    this.redraw();
  }

  /** Another canvas in the place of one that WebGL has, or failed on. */
  #withoutGl() {
    const canvas = /** @type {HTMLCanvasElement} */ (this.#canvas.cloneNode());
    this.#canvas.replaceWith(canvas);
    this.#canvas = canvas;
    const screen = new CanvasScreen(canvas);
    if (this.#data !== null) screen.upload(this.#data.sides);
    return screen;
  }

  /** The frame takes the picture's size in CSS pixels. */
  #layOut() {
    const [width, height] = this.size;
    const room = Math.min(1, this.#stage.clientWidth / width, this.#stage.clientHeight / height);
    const zoom = this.#zoom === "fit" ? room : Number(this.#zoom);
    this.#frame.style.width = `${width * zoom}px`;
    this.#frame.style.height = `${height * zoom}px`;
    this.#frame.classList.toggle("exact", zoom >= 1);
  }

  #meetingColumn() {
    return Math.round(this.#meeting * this.#canvas.width);
  }

  /** @param {number} meeting */
  #meet(meeting) {
    this.#meeting = Math.max(0, Math.min(1, meeting));
    const percent = Math.round(100 * this.#meeting);
    this.#frame.style.setProperty("--meeting", `${100 * (this.#meetingColumn() / this.#canvas.width)}%`);
    this.#divider.setAttribute("aria-valuenow", String(percent));
    this.#divider.setAttribute("aria-valuetext", `A on the left ${percent} % of the picture`);
    this.redraw();
  }

  #handleDivider() {
    const divider = this.#divider;
    divider.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      divider.setPointerCapture(event.pointerId);
      divider.focus();
      event.preventDefault();
    });
    divider.addEventListener("pointermove", (event) => {
      if (!divider.hasPointerCapture(event.pointerId)) return;
      const box = this.#canvas.getBoundingClientRect();
      this.#meet((event.clientX - box.left) / box.width);
    });
    divider.addEventListener("dblclick", () => this.#meet(0.5));
    divider.addEventListener("keydown", (event) => {
      const step = event.shiftKey ? 10 * STEP : STEP;
      /** @type {Record<string, number>} */
      const moves = {
        ArrowLeft: -step,
        ArrowDown: -step,
        ArrowRight: step,
        ArrowUp: step,
        PageDown: -10 * STEP,
        PageUp: 10 * STEP,
        Home: -1,
        End: 1,
      };
      if (!(event.key in moves)) return;
      event.preventDefault();
      event.stopPropagation();
      this.#meet(this.#meeting + moves[event.key]);
    });
  }
}
