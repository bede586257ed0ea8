// @ts-check
// The picture by pointer and by keys.

import { byId } from "./dom.js";

/** @typedef {import("./picture.js").Picture} Picture */

/** Radians of an orbit for each CSS pixel, and for each press of an arrow key. */
const TURN = 0.006;
const KEY_TURN = Math.PI / 36;

/** Heights of the picture that an arrow key pans by. */
const KEY_PAN = 0.05;

/** What `+` leaves of the distance. */
const KEY_DOLLY = 0.9;

/** CSS pixels that a hand moves without meaning it. */
const STILL = 4;

/**
 * What pointer and keys ask for. Moves are of the camera: to the right and up, in radians (`orbit`) or heights of the
 * picture (`pan`); `dolly` to a part of the distance. They begin where the lens was at `begin`, and `scrolled` ones where
 * it is.
 * @typedef {{begin(): void, orbit(right: number, up: number): void, pan(right: number, up: number): void,
 *   dolly(factor: number): void, end(): void, select(x: number, y: number): void, aim(x: number, y: number): void,
 *   focus(x: number, y: number): void, tell(place: {clientX: number, clientY: number} | null): void,
 *   pause(): void, reset(): void}} Actions
 */

export class Controls {
  #frame = byId("frame", HTMLDivElement);
  #focusTool = byId("focus", HTMLButtonElement);
  /** @type {Map<number, {x: number, y: number}>} Pointers that are down, where they are. */
  #pointers = new Map();
  /** @type {{x: number, y: number, button: number, moved: boolean, pans: boolean} | null} Where a drag began. */
  #drag = null;
  /** @type {{x: number, y: number, gap: number} | null} Where two fingers began. */
  #pinch = null;
  #over = false;

  /**
   * @param {Picture} picture
   * @param {Actions} actions
   */
  constructor(picture, actions) {
    this.picture = picture;
    this.actions = actions;
    const frame = this.#frame;
    frame.addEventListener("pointerdown", (event) => this.#down(event));
    frame.addEventListener("pointermove", (event) => this.#move(event));
    frame.addEventListener("pointerup", (event) => this.#up(event));
    frame.addEventListener("pointercancel", (event) => this.#up(event));
    frame.addEventListener("pointerleave", () => {
      this.#over = false;
      actions.tell(null);
    });
    frame.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    frame.addEventListener("dblclick", (event) => {
      const pixel = this.#isPicture(event) && event.button === 0 ? picture.pixelAt(event) : null;
      if (pixel !== null) actions.aim(...pixel);
    });
    frame.addEventListener("contextmenu", (event) => event.preventDefault());
    frame.addEventListener("keydown", (event) => {
      if (this.#isPicture(event) && this.#key(event)) event.preventDefault();
    });
    this.#focusTool.addEventListener("click", () => this.#arm(!this.#armed));
  }

  get #armed() {
    return this.#focusTool.getAttribute("aria-pressed") === "true";
  }

  /** @param {boolean} armed whether the next click says what is in focus */
  #arm(armed) {
    this.#focusTool.setAttribute("aria-pressed", String(armed));
    this.#frame.classList.toggle("focusing", armed);
  }

  /** @param {Event} event */
  #isPicture(event) {
    return event.target instanceof HTMLCanvasElement;
  }

  /** @param {PointerEvent} event */
  #down(event) {
    if (!this.#isPicture(event)) return;
    const canvas = /** @type {HTMLCanvasElement} */ (event.target);
    canvas.focus({ preventScroll: true });
    // Pressing the wheel would scroll.
    event.preventDefault();
    canvas.setPointerCapture(event.pointerId);
    this.#pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    this.actions.begin();
    if (this.#pointers.size === 2) {
      this.#drag = null;
      this.#pinch = this.#fingers();
    } else if (this.#pointers.size === 1) {
      const { clientX: x, clientY: y, button } = event;
      this.#drag = { x, y, button, moved: false, pans: event.shiftKey || button !== 0 };
    }
  }

  /** @param {PointerEvent} event */
  #move(event) {
    this.#over = this.#isPicture(event);
    this.actions.tell(this.#over ? event : null);
    if (!this.#pointers.has(event.pointerId)) return;
    this.#pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    const height = this.picture.shownHeight;
    if (this.#pinch !== null && this.#pointers.size === 2) {
      const now = this.#fingers();
      this.actions.begin();
      this.actions.pan((this.#pinch.x - now.x) / height, (now.y - this.#pinch.y) / height);
      this.actions.begin();
      this.actions.dolly(this.#pinch.gap / Math.max(1, now.gap));
      this.#pinch = now;
      return;
    }
    if (this.#drag === null) return;
    const [right, down] = [event.clientX - this.#drag.x, event.clientY - this.#drag.y];
    if (!this.#drag.moved && Math.hypot(right, down) < STILL) return;
    this.#drag.moved = true;
    // What is in the picture follows the pointer: the camera goes the other way.
    if (this.#drag.pans) this.actions.pan(-right / height, down / height);
    else this.actions.orbit(-right * TURN, down * TURN);
  }

  /** @param {PointerEvent} event */
  #up(event) {
    if (!this.#pointers.delete(event.pointerId)) return;
    const drag = this.#drag;
    this.#drag = null;
    this.#pinch = null;
    this.actions.end();
    if (drag === null || drag.moved || drag.button !== 0 || event.type !== "pointerup") return;
    const pixel = this.picture.pixelAt(event);
    if (pixel === null) return;
    if (this.#armed) {
      this.#arm(false);
      this.actions.focus(...pixel);
    } else {
      this.actions.select(...pixel);
    }
  }

  #fingers() {
    const [a, b] = [...this.#pointers.values()];
    return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, gap: Math.hypot(a.x - b.x, a.y - b.y) };
  }

  /** @param {WheelEvent} event */
  #wheel(event) {
    event.preventDefault();
    const unit = [1, 16, 100][event.deltaMode] ?? 1;
    // A pinch on a touchpad comes as a wheel with ctrl, in small steps.
    const speed = event.ctrlKey ? 0.01 : 0.001;
    const turned = Math.max(-300, Math.min(300, event.deltaY * unit));
    this.actions.begin();
    this.actions.dolly(Math.exp(turned * speed));
    this.actions.end();
  }

  /** @param {KeyboardEvent} event */
  #key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return false;
    const { actions } = this;
    /** @type {Record<string, [number, number]>} */
    const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    if (event.key in arrows) {
      const [right, up] = arrows[event.key];
      actions.begin();
      if (event.shiftKey) actions.pan(right * KEY_PAN, up * KEY_PAN);
      else actions.orbit(right * KEY_TURN, up * KEY_TURN);
      actions.end();
      return true;
    }
    switch (event.key) {
      case "+":
      case "=":
      case "-":
        actions.begin();
        actions.dolly(event.key === "-" ? 1 / KEY_DOLLY : KEY_DOLLY);
        actions.end();
        return true;
      case "f":
      case "F":
        if (!this.#over || this.#armed) this.#focusCentre();
        else this.#arm(true);
        return true;
      case "Escape":
        this.#arm(false);
        return true;
      case " ":
        if (!event.repeat) actions.pause();
        return true;
      case "r":
      case "R":
        if (!event.repeat) actions.reset();
        return true;
      default:
        return false;
    }
  }

  #focusCentre() {
    const [width, height] = this.picture.size;
    this.#arm(false);
    this.actions.focus(Math.floor(width / 2), Math.floor(height / 2));
  }
}
