// @ts-check
// How each side is rendered, and what both share: size, samples, layer.

import { byId, create, setField, setOptions } from "./dom.js";
import { numberIn } from "./fields.js";
import { layers, recordOf } from "./protocol.js";

/** @typedef {import("./protocol.js").Hello} Hello */
/** @typedef {import("./protocol.js").Side} Side */
/** @typedef {import("./protocol.js").View} View */
/** @typedef {(edit: (view: View) => View) => void} Change */

/** The greatest seed. */
const MAX_SEED = 2n ** 64n - 1n;

/** What groups of layers are called, by what has to be recorded for them. */
const GROUPS = { first_hits: "Of first hits", lengths: "By path length" };

/** @param {string} layer */
function layerName(layer) {
  if (layer === "error") return "error (estimated)";
  const [, length] = layer.split(":");
  return length === undefined ? layer : `paths of ${length} ${length === "1" ? "edge" : "edges"}`;
}

/**
 * Fills the list of layers, in groups; those that are not recorded say what showing them takes.
 * @param {HTMLSelectElement} select
 * @param {View} view
 */
function setLayers(select, { sides, aovs, layer }) {
  const all = layers(sides);
  if (select.options.length !== all.length) {
    const option = (/** @type {string} */ name) => new Option(layerName(name), name);
    const groups = /** @type {const} */ (["first_hits", "lengths"]).map((record) => {
      const group = create("optgroup", { "data-record": record });
      group.append(...all.filter((name) => recordOf(name) === record).map(option));
      return group;
    });
    select.replaceChildren(...all.filter((name) => recordOf(name) === null).map(option), ...groups);
  }
  for (const group of select.querySelectorAll("optgroup")) {
    const record = /** @type {keyof typeof GROUPS} */ (group.dataset.record);
    group.label = aovs[record] ? GROUPS[record] : `${GROUPS[record]}: the image begins anew`;
  }
  select.value = layer;
}

/**
 * The name of a side's settings.
 * @param {Side} side
 */
export function sideName({ strategy, sampler, path_length }) {
  return `${strategy} · ${sampler} · ${path_length}`;
}

/**
 * The side to begin a comparison with: another strategy than the one there is.
 * @param {Side} side
 * @param {string[]} strategies
 * @returns {Side}
 */
function otherSide(side, strategies) {
  // What draws directions from the BSDF shows best what looking for lights is worth.
  const wanted = side.strategy === "cosine" ? "mis" : "cosine";
  const strategy = strategies.includes(wanted) ? wanted : strategies.find((name) => name !== side.strategy);
  return { ...side, strategy: strategy ?? side.strategy };
}

/** The fields of one side. */
class SideFields {
  /**
   * @param {"a" | "b"} letter
   * @param {(edit: (side: Side) => Side) => void} change
   */
  constructor(letter, change) {
    const name = `of side ${letter.toUpperCase()}`;
    const select = (/** @type {string} */ id, /** @type {string} */ label) =>
      create("select", { id: `${id}-${letter}`, "aria-label": `${label} ${name}` });
    const whole = (/** @type {string} */ id, /** @type {string} */ label, /** @type {Record<string, string>} */ more) =>
      create("input", { id: `${id}-${letter}`, "aria-label": `${label} ${name}`, ...more });
    this.strategy = select("strategy", "Strategy");
    this.sampler = select("sampler", "Sampler");
    this.length = whole("path-length", "Path length", { type: "number", min: "1", max: "10000", step: "1" });
    this.seed = whole("seed", "Seed", { type: "text", inputmode: "numeric", autocomplete: "off", spellcheck: "false" });
    this.roulette = whole("roulette", "Roulette from edge", {
      type: "number",
      min: "1",
      max: "10000",
      step: "1",
      placeholder: "off",
    });
    this.elements = [this.strategy, this.sampler, this.length, this.seed, this.roulette];
    this.strategy.addEventListener("change", () => change((side) => ({ ...side, strategy: this.strategy.value })));
    this.sampler.addEventListener("change", () => change((side) => ({ ...side, sampler: this.sampler.value })));
    this.length.addEventListener("change", () => {
      const value = numberIn(this.length);
      change((side) => ({ ...side, path_length: value === null ? side.path_length : Math.round(value) }));
    });
    this.seed.addEventListener("change", () => {
      const digits = /^\d{1,20}$/.test(this.seed.value.trim()) ? BigInt(this.seed.value) : null;
      change((side) => ({ ...side, seed: digits !== null && digits <= MAX_SEED ? String(digits) : side.seed }));
    });
    this.roulette.addEventListener("change", () => {
      const value = numberIn(this.roulette);
      change((side) => ({ ...side, roulette: value === null ? null : Math.round(value) }));
    });
  }

  /** @param {Hello} scene */
  setScene(scene) {
    setOptions(this.strategy, scene.strategies);
    setOptions(this.sampler, scene.samplers);
  }

  /**
   * @param {Side} side
   * @param {boolean} forced
   */
  show(side, forced) {
    this.strategy.value = side.strategy;
    this.sampler.value = side.sampler;
    setField(this.length, String(side.path_length), forced);
    setField(this.seed, side.seed, forced);
    setField(this.roulette, side.roulette === null ? "" : String(side.roulette), forced);
  }
}

export class Settings {
  #split = byId("split", HTMLInputElement);
  #balance = byId("balance", HTMLSelectElement);
  #layer = byId("layer", HTMLSelectElement);
  #firstHits = byId("first-hits", HTMLInputElement);
  #lengths = byId("lengths", HTMLInputElement);
  #width = byId("width", HTMLInputElement);
  #height = byId("height", HTMLInputElement);
  #limit = byId("limit", HTMLInputElement);
  #table = byId("sides", HTMLDivElement);
  /** @type {SideFields[]} */
  #sides;
  /** The second side as it was last: what is compared with comes back. @type {Side | null} */
  #second = null;
  /** @type {string[]} */
  #strategies = [];

  /** @param {Change} change */
  constructor(change) {
    this.change = change;
    this.#sides = /** @type {const} */ (["a", "b"]).map(
      (letter, place) =>
        new SideFields(letter, (edit) =>
          change((view) => ({ ...view, sides: view.sides.map((side, i) => (i === place ? edit(side) : side)) })),
        ),
    );
    // The labels lie in the table, row by row; each side's field goes beside its own.
    const rows = this.#table.querySelectorAll(".row");
    rows.forEach((row, i) => row.append(...this.#sides.map(({ elements }) => elements[i])));
    this.#split.addEventListener("change", () => this.#toggle(this.#split.checked));
    this.#balance.addEventListener("change", () => change((view) => ({ ...view, balance: this.#balance.value })));
    this.#layer.addEventListener("change", () => change((view) => ({ ...view, layer: this.#layer.value })));
    this.#handleRecords();
    this.#handleSize();
    this.#limit.addEventListener("change", () => {
      const limit = numberIn(this.#limit);
      change((view) => ({ ...view, limit: limit === null ? view.limit : Math.round(limit) }));
    });
  }

  /** @param {Hello} scene */
  setScene(scene) {
    this.#strategies = scene.strategies;
    for (const side of this.#sides) side.setScene(scene);
  }

  /**
   * @param {View} view
   * @param {boolean} forced
   */
  show(view, forced) {
    const split = view.sides.length > 1;
    if (split) this.#second = view.sides[1];
    this.#split.checked = split;
    document.documentElement.classList.toggle("split", split);
    this.#balance.value = view.balance;
    view.sides.forEach((side, i) => this.#sides[i]?.show(side, forced));
    setLayers(this.#layer, view);
    this.#firstHits.checked = view.aovs.first_hits;
    this.#lengths.checked = view.aovs.lengths;
    setField(this.#width, String(view.size[0]), forced);
    setField(this.#height, String(view.size[1]), forced);
    setField(this.#limit, String(view.limit), forced);
  }

  /** @param {boolean} split */
  #toggle(split) {
    this.change((view) => {
      const [first] = view.sides;
      const second = this.#second ?? otherSide(first, this.#strategies);
      return { ...view, sides: split ? [first, second] : [first] };
    });
  }

  #handleRecords() {
    for (const [box, record] of /** @type {const} */ ([
      [this.#firstHits, "first_hits"],
      [this.#lengths, "lengths"],
    ])) {
      box.addEventListener("change", () =>
        this.change((view) => {
          const layer = !box.checked && recordOf(view.layer) === record ? "radiance" : view.layer;
          return { ...view, layer, aovs: { ...view.aovs, [record]: box.checked } };
        }),
      );
    }
  }

  #handleSize() {
    for (const [field, place] of /** @type {const} */ ([
      [this.#width, 0],
      [this.#height, 1],
    ])) {
      field.addEventListener("change", () => {
        const value = numberIn(field);
        if (value === null) return;
        this.change((view) => {
          /** @type {[number, number]} */
          const size = [...view.size];
          size[place] = Math.round(value);
          return { ...view, size };
        });
      });
    }
    byId("sizes", HTMLElement).addEventListener("click", ({ target }) => {
      if (!(target instanceof HTMLButtonElement)) return;
      const [width, height] = target.value.split("x").map(Number);
      this.change((view) => ({ ...view, size: [width, height] }));
    });
  }
}
