// @ts-check
// The camera's fields: which it is, its field of view, aperture and focus.

import { distance } from "./camera.js";
import { byId, setOptions } from "./dom.js";
import { NumberRow } from "./fields.js";

/** @typedef {import("./protocol.js").Hello} Hello */
/** @typedef {import("./protocol.js").Lens} Lens */
/** @typedef {import("./protocol.js").View} View */

export class LensFields {
  #camera = byId("camera", HTMLSelectElement);
  #rows = byId("lens", HTMLDivElement);
  /** @type {[keyof Lens, NumberRow][]} */
  #fields = [];

  /** @param {(edit: (view: View) => View) => void} change */
  constructor(change) {
    this.change = change;
  }

  /** @param {Hello} scene */
  setScene(scene) {
    const { change } = this;
    setOptions(
      this.#camera,
      scene.cameras.map(({ name }) => name),
    );
    this.#camera.disabled = scene.cameras.length < 2;
    this.#camera.onchange = () => {
      const camera = scene.cameras.find(({ name }) => name === this.#camera.value);
      if (camera !== undefined) change((view) => ({ ...view, camera: camera.name, lens: camera.lens }));
    };
    const size = scene.bounds?.radius || distance(scene.start.lens);
    /** @type {(key: keyof Lens) => (value: number) => void} */
    const set = (key) => (value) => change((view) => ({ ...view, lens: { ...view.lens, [key]: value } }));
    this.#fields = [
      [
        "vertical_fov",
        new NumberRow(
          { id: "vertical-fov", label: "Field of view", unit: "°", low: 5, high: 120, step: 1 },
          set("vertical_fov"),
        ),
      ],
      [
        "aperture_radius",
        new NumberRow(
          { id: "aperture-radius", label: "Aperture radius", low: 0, high: size / 10, shape: "cubic" },
          set("aperture_radius"),
        ),
      ],
      [
        "focus_distance",
        new NumberRow(
          { id: "focus-distance", label: "Focus distance", low: size / 100, high: size * 20, shape: "log" },
          set("focus_distance"),
        ),
      ],
    ];
    this.#rows.replaceChildren(...this.#fields.map(([, row]) => row.element));
  }

  /**
   * @param {View} view
   * @param {boolean} forced
   */
  show(view, forced) {
    this.#camera.value = view.camera;
    for (const [key, row] of this.#fields) row.show(Number(view.lens[key]), forced);
  }
}
