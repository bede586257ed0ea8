// @ts-check
// The live page: wires the parts to each other and to the program.

import { dolly, lookAt, orbit, pan, rounded } from "./camera.js";
import { Connection } from "./connection.js";
import { Controls } from "./controls.js";
import { byId, setOptions } from "./dom.js";
import { numberIn } from "./fields.js";
import { LensFields } from "./lens.js";
import { Materials } from "./materials.js";
import { Picture } from "./picture.js";
import { Saving } from "./saving.js";
import { Settings, sideName } from "./settings.js";
import { StatisticsPanel, threeDigits } from "./statistics.js";
import { handleHelp, handleTheme } from "./window.js";
import { Wanted } from "./wanted.js";

/** @typedef {import("./protocol.js").FromServer} FromServer */
/** @typedef {import("./protocol.js").Hello} Hello */
/** @typedef {import("./protocol.js").Hit} Hit */
/** @typedef {import("./protocol.js").Lens} Lens */
/** @typedef {import("./protocol.js").View} View */

const { dataset } = document.documentElement;

/** @type {Hello | null} */
let scene = null;
/** Where the present drag began. @type {Lens | null} */
let held = null;
/** What has been asked of the picture, by id. @type {Map<number, (hit: Hit | null) => void>} */
const picks = new Map();
let lastId = 0;
/** @type {{clientX: number, clientY: number} | null} */
let pointer = null;

const wanted = new Wanted((view) => {
  if (!connection.isOpen) return null;
  lastId += 1;
  connection.send({ type: "view", id: lastId, view });
  return lastId;
}, showView, (milliseconds) => statistics.showLatency(milliseconds));
const change = (/** @type {(view: View) => View} */ edit) => wanted.change(edit);

const picture = new Picture((data) => {
  connection.send({ type: "drawn", picture: data.picture });
  dataset.picture = String(data.picture);
  dataset.generation = String(data.generation);
  wanted.drawn(data.generation);
  showReadout();
});
const lens = new LensFields(change);
const settings = new Settings(change);
const materials = new Materials(change);
const statistics = new StatisticsPanel();
new Saving(
  () => ({ tonemap: picture.curve, exposure: picture.exposure }),
  (message) => complain(message),
);

new Controls(picture, {
  begin: () => {
    held = wanted.view?.lens ?? null;
  },
  orbit: (right, up) => move((from) => orbit(from, right, up)),
  pan: (right, up) => move((from) => pan(from, right, up)),
  dolly: (factor) => move((from) => dolly(from, factor)),
  end: () => {
    held = null;
  },
  select: (x, y) =>
    pick(x, y, (hit) => {
      if (hit?.material) materials.select(hit.material);
    }),
  aim: (x, y) =>
    pick(x, y, (hit) => {
      if (hit === null) notice("Nothing is there to look at.");
      else change((view) => ({ ...view, lens: lookAt(view.lens, hit.position) }));
    }),
  focus: (x, y) =>
    pick(x, y, (hit) => {
      if (hit === null) return notice("Nothing is there to focus on.");
      const focus_distance = rounded(hit.depth);
      change((view) => ({ ...view, lens: { ...view.lens, focus_distance } }));
      const sharp = wanted.view?.lens.aperture_radius === 0;
      notice(`Focus distance ${focus_distance}.${sharp ? " All is sharp through a pinhole: the aperture radius gives blur." : ""}`);
    }),
  tell: (place) => {
    pointer = place;
    showReadout();
  },
  pause: togglePause,
  reset,
});

const connection = new Connection({
  message: receive,
  picture: (data) => {
    const { view, generation } = wanted.confirmedView;
    if (view !== null && data.generation === generation) frame(view);
    picture.show(data);
  },
  lost: (text, ended) => {
    wanted.connected();
    picks.clear();
    setState("lost", text);
    byId("retry", HTMLButtonElement).hidden = !ended;
  },
});

/** @param {FromServer} message */
function receive(message) {
  switch (message.type) {
    case "hello":
      return greet(message);
    case "view":
      if (message.id !== null) complain("");
      return wanted.confirmed(message);
    case "refused":
      forgetPicks(message.id ?? 0);
      wanted.refused(message.id);
      return complain(message.message);
    case "picked":
      picks.get(message.id)?.(message.hit);
      return forgetPicks(message.id);
    case "stats":
      setState(message.state);
      statistics.show(message);
      return showProgress(message.sides.map(({ samples }) => samples));
  }
}

/** @param {Hello} message */
function greet(message) {
  scene = message;
  wanted.connected();
  byId("retry", HTMLButtonElement).hidden = true;
  // Of a path the file's name; the rest is there for who asks.
  const name = message.scene.split(/[\\/]/).at(-1) || message.scene;
  byId("scene", HTMLElement).textContent = name;
  byId("scene", HTMLElement).title = message.scene;
  document.title = `${name} – Ondine`;
  byId("help-title", HTMLElement).textContent = `Ondine ${message.version}: mouse and keys`;
  setOptions(byId("tonemap", HTMLSelectElement), message.tonemaps);
  lens.setScene(message);
  settings.setScene(message);
  materials.setScene(message);
  setState("rendering");
}

/**
 * @param {View} view
 * @param {boolean} forced
 */
function showView(view, forced) {
  const split = view.sides.length > 1;
  if (picture.isEmpty) frame(view);
  lens.show(view, forced);
  settings.show(view, forced);
  materials.show(view, forced);
  view.sides.forEach((side, i) => {
    byId(i === 0 ? "legend-a" : "legend-b", HTMLElement).textContent = `${split ? `${"AB"[i]} ` : ""}${sideName(side)}`;
  });
}

/**
 * The picture takes the shape of a view.
 * @param {View} view
 */
function frame(view) {
  picture.expect(view.size, view.sides.map(sideName));
}

/** @type {Record<string, string>} */
const STATES = { rendering: "Rendering", paused: "Paused", done: "Done" };

/**
 * @param {string} state
 * @param {string} [text]
 */
function setState(state, text = STATES[state] ?? state) {
  const status = byId("status", HTMLElement);
  dataset.state = state;
  // Said aloud where it changes, and not at each figure.
  if (status.textContent !== text) status.textContent = text;
  const pause = byId("pause", HTMLButtonElement);
  pause.textContent = state === "paused" ? "Resume" : "Pause";
  pause.disabled = state === "lost" || state === "done";
}

/** @param {number[]} samples */
function showProgress(samples) {
  const limit = wanted.view?.limit;
  const [a, b] = samples;
  const done = b === undefined || a === b ? String(a) : `A ${a}, B ${b}`;
  byId("progress", HTMLElement).textContent = limit === undefined ? "" : `${done} of ${limit} samples per pixel`;
}

function togglePause() {
  if (dataset.state === "rendering" || dataset.state === "paused") {
    connection.send({ type: "pause", paused: dataset.state === "rendering" });
  }
}

function reset() {
  const start = scene?.start;
  if (start !== undefined) change(() => start);
}

/** @param {(from: Lens) => Lens} edit */
function move(edit) {
  const from = held;
  if (from !== null) change((view) => ({ ...view, lens: edit(from) }));
}

/**
 * @param {number} x
 * @param {number} y
 * @param {(hit: Hit | null) => void} then
 */
function pick(x, y, then) {
  lastId += 1;
  picks.set(lastId, then);
  connection.send({ type: "pick", id: lastId, x, y });
}

/**
 * Forgets what was asked up to here: the program answers the last of what is asked at once.
 * @param {number} last
 */
function forgetPicks(last) {
  for (const id of [...picks.keys()]) {
    if (id <= last) picks.delete(id);
  }
}

function showReadout() {
  const pixel = pointer === null ? null : picture.pixelAt(pointer);
  const readout = byId("readout", HTMLOutputElement);
  if (pixel === null) {
    readout.textContent = "";
    return;
  }
  const side = picture.sideAt(pixel[0]);
  const values = picture.valuesAt(...pixel, side);
  const name = picture.isSplit ? `${"AB"[side]}   ` : "";
  readout.textContent = `${name}x ${pixel[0]}  y ${pixel[1]}   ${(values ?? []).map(threeDigits).join("  ")}`;
}

/** @param {string} message */
function complain(message) {
  byId("message", HTMLElement).textContent = message;
  if (message !== "") byId("notice", HTMLElement).textContent = "";
}

let noticeTimer = 0;

/** @param {string} message */
function notice(message) {
  byId("notice", HTMLElement).textContent = message;
  clearTimeout(noticeTimer);
  noticeTimer = setTimeout(() => notice(""), 8000);
}

/** @param {number} exposure */
function expose(exposure) {
  picture.exposure = exposure;
  byId("exposure", HTMLInputElement).value = String(exposure);
  byId("exposure-number", HTMLInputElement).value = String(exposure);
  picture.redraw();
}

byId("exposure", HTMLInputElement).addEventListener("input", ({ target }) =>
  expose(/** @type {HTMLInputElement} */ (target).valueAsNumber),
);
byId("exposure-number", HTMLInputElement).addEventListener("change", ({ target }) =>
  expose(numberIn(/** @type {HTMLInputElement} */ (target)) ?? picture.exposure),
);
byId("tonemap", HTMLSelectElement).addEventListener("change", ({ target }) => {
  picture.curve = /** @type {HTMLSelectElement} */ (target).value;
  picture.redraw();
});
byId("zoom", HTMLElement).addEventListener("click", ({ target, currentTarget }) => {
  if (!(target instanceof HTMLButtonElement)) return;
  for (const button of /** @type {HTMLElement} */ (currentTarget).querySelectorAll("button")) {
    button.setAttribute("aria-pressed", String(button === target));
  }
  picture.zoom = target.value;
});
byId("pause", HTMLButtonElement).addEventListener("click", togglePause);
byId("reset", HTMLButtonElement).addEventListener("click", reset);
byId("retry", HTMLButtonElement).addEventListener("click", () => connection.retry());
// What a field was not told while somebody wrote in it.
document.addEventListener("focusout", () => {
  const view = wanted.view;
  if (view !== null) setTimeout(() => showView(wanted.view ?? view, false));
});
handleTheme();
handleHelp();

/** For tests, and for curious people. */
Object.assign(window, {
  ondine: {
    /** Linear values of a pixel of the last picture. */
    pixel: (/** @type {number} */ x, /** @type {number} */ y, side = 0) => picture.valuesAt(x, y, side),
    view: () => wanted.view,
  },
});
