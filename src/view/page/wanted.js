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
   * The view under way: the generation that there was when it was sent, and its own, once the program has said which.
   * @type {{id: number, sent: number, before: number, generation: number | null} | null}
   */
  #underWay = null;
  /** What was drawn last, and when. */
  #drawn = { generation: -1, at: 0 };

  /**
   * @param {(view: View) => number | null} send gives the id it was sent under, or null where it could not be
   * @param {(view: View, forced: boolean) => void} show controls follow; forced: even those that are being edited
   * @param {(milliseconds: number) => void} seen the first picture of a view, so long after it was sent
   */
  constructor(send, show, seen) {
    this.send = send;
    this.show = show;
    this.seen = seen;
  }

  /** What is wanted now, sent or not. */
  get view() {
    return this.#wanted;
  }

  /** The view that the program has confirmed, and its generation. */
  get confirmedView() {
    return { view: this.#confirmed, generation: this.#generation };
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
    this.#drawn = { generation: -1, at: 0 };
  }

  /** @param {{id: number | null, generation: number, view: View}} message */
  confirmed({ id, generation, view }) {
    this.#confirmed = view;
    this.#generation = generation;
    if (this.#underWay !== null && id === this.#underWay.id) {
      this.#underWay.generation = generation;
      // An image that goes on is there already.
      if (generation === this.#underWay.before) this.#arrived();
      else this.#look();
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
   * A picture has been drawn.
   * @param {number} generation
   */
  drawn(generation) {
    if (generation !== this.#drawn.generation) this.#drawn = { generation, at: performance.now() };
    this.#look();
  }

  /** Whether the view under way has been seen. */
  #look() {
    const view = this.#underWay;
    if (view === null || view.generation === null || this.#drawn.generation < view.generation) return;
    this.#arrived();
    this.seen(this.#drawn.at - view.sent);
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
    this.#underWay = { id, sent: performance.now(), before: this.#generation, generation: null };
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
