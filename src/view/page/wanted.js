// @ts-check
// The view that this page wants, and when the program is told.

import { consistent } from "./protocol.js";
import { nextFrame } from "./dom.js";

/** @typedef {import("./protocol.js").View} View */

/** Milliseconds after which a view is sent although the one before it has not been seen yet. */
const PATIENCE = 300;

/** Milliseconds after which a view counts as passed over: one that another page's follows at once is never answered. */
const PASSED_OVER = 3000;

/**
 * One view is under way at a time, from when it is sent until its first picture is drawn; of what is wanted meanwhile the
 * last is sent next. So no queue builds up, however slow the program or the page is.
 */
export class Wanted {
  /** @type {View | null} */
  #wanted = null;
  /** @type {View | null} */
  #confirmed = null;
  #generation = -1;
  /** Whether `#wanted` has yet to be sent. */
  #dirty = false;
  #scheduled = false;
  /**
   * The view under way; `generation` once the program has said which it is.
   * @type {{id: number, sent: number, generation: number | null} | null}
   */
  #underWay = null;

  /**
   * @param {(view: View) => number | null} send gives the id it was sent under, or null where it could not be
   * @param {(view: View, forced: boolean) => void} show controls follow; forced: even those that are being edited
   */
  constructor(send, show) {
    this.send = send;
    this.show = show;
  }

  /** What is wanted now, sent or not. */
  get view() {
    return this.#wanted;
  }

  /** The generation of the view that the program has confirmed. */
  get generation() {
    return this.#generation;
  }

  /**
   * Wants another view: `edit` gives it from the present one, which it leaves as it is.
   * @param {(view: View) => View} edit
   */
  change(edit) {
    if (this.#wanted === null) return;
    this.#wanted = consistent(edit(this.#wanted));
    this.#dirty = true;
    this.show(this.#wanted, false);
    this.#schedule();
  }

  /** What was under way on another connection will not be answered on this one. */
  connected() {
    this.#underWay = null;
    this.#dirty = false;
  }

  /** @param {{id: number | null, generation: number, view: View}} message */
  confirmed({ id, generation, view }) {
    const sameImage = generation === this.#generation;
    this.#confirmed = view;
    this.#generation = generation;
    if (this.#underWay !== null && id === this.#underWay.id) {
      this.#underWay.generation = generation;
      if (sameImage) this.#arrived();
    }
    // What another page wants holds until it is told what this one wants.
    if (this.#dirty || (this.#underWay !== null && this.#underWay.generation === null)) return;
    this.#fallBack(false);
  }

  /**
   * The view `id` cannot be; false where it is none of this page's.
   * @param {number | null} id
   */
  refused(id) {
    if (this.#underWay === null || id !== this.#underWay.id) return false;
    this.#underWay = null;
    this.#dirty = false;
    this.#fallBack(true);
    return true;
  }

  /**
   * A picture has been drawn: gives the milliseconds from sending its view, where it is the first of it.
   * @param {number} generation
   */
  drawn(generation) {
    const view = this.#underWay;
    if (view === null || view.generation === null || generation < view.generation) return null;
    this.#arrived();
    return performance.now() - view.sent;
  }

  #arrived() {
    this.#underWay = null;
    if (this.#dirty) this.#schedule();
  }

  #schedule() {
    if (this.#scheduled) return;
    this.#scheduled = true;
    nextFrame(() => {
      this.#scheduled = false;
      this.#flush();
    });
  }

  #flush() {
    if (!this.#dirty || this.#wanted === null) return;
    if (this.#underWay !== null) {
      const left = this.#underWay.sent + PATIENCE - performance.now();
      if (left > 0) {
        // Until then `drawn` may have sent it.
        setTimeout(() => this.#schedule(), left);
        return;
      }
    }
    const id = this.send(this.#wanted);
    if (id === null) return;
    this.#dirty = false;
    this.#underWay = { id, sent: performance.now(), generation: null };
    setTimeout(() => this.#giveUp(id), PASSED_OVER);
  }

  /** @param {number} id of a view that has had its time */
  #giveUp(id) {
    if (this.#underWay?.id !== id || this.#underWay.generation !== null) return;
    this.#arrived();
    if (!this.#dirty) this.#fallBack(false);
  }

  /** What is wanted is what there is. @param {boolean} forced */
  #fallBack(forced) {
    this.#wanted = this.#confirmed;
    if (this.#wanted !== null) this.show(this.#wanted, forced);
  }
}
