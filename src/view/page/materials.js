// @ts-check
// The scene's materials: which there are, and the one that is edited.

import { byId, create, setOptions } from "./dom.js";
import { ColorRow, NumberRow, css } from "./fields.js";

/** @typedef {import("./protocol.js").Hello} Hello */
/** @typedef {import("./protocol.js").Material} Material */
/** @typedef {import("./protocol.js").MaterialType} MaterialType */
/** @typedef {import("./protocol.js").Vec3} Vec3 */
/** @typedef {import("./protocol.js").View} View */

/** What each map multiplies, as people say it. @type {Record<string, string>} */
const MAPS = {
  color: "A texture multiplies the colour.",
  metallic_roughness: "A texture multiplies metallic and roughness.",
  normal: "A texture bends the normals.",
  alpha: "A texture cuts holes.",
};

/** A range that is at least so wide has its finest part at the low end. */
const WIDE = 50;

/** @param {unknown} a @param {unknown} b */
const same = (a, b) => JSON.stringify(a) === JSON.stringify(b);

export class Materials {
  #list = byId("material", HTMLSelectElement);
  #type = byId("material-type", HTMLSelectElement);
  #parameters = byId("material-parameters", HTMLDivElement);
  #note = byId("material-note", HTMLElement);
  #restore = byId("material-restore", HTMLButtonElement);
  /** @type {Hello | null} */
  #scene = null;
  /** @type {View | null} */
  #view = null;
  /** The material and type whose rows there are. */
  #shown = "";
  /** @type {Map<string, ColorRow | NumberRow>} */
  #rows = new Map();
  /** Colour and roughness that each material had last: a type without them forgets nothing. @type {Map<string, {color?: Vec3, roughness?: number}>} */
  #kept = new Map();

  /** @param {(edit: (view: View) => View) => void} change */
  constructor(change) {
    this.change = change;
    this.#list.addEventListener("change", () => this.#showEditor(true));
    this.#type.addEventListener("change", () => this.#setType(this.#type.value));
    this.#restore.addEventListener("click", () => this.#set(null));
  }

  /** @param {Hello} scene */
  setScene(scene) {
    this.#scene = scene;
    this.#kept.clear();
    this.#shown = "";
    setOptions(
      this.#list,
      scene.materials.map(({ name }) => name),
    );
    this.#list.size = Math.max(2, Math.min(7, scene.materials.length));
    if (this.#list.selectedIndex < 0) this.#list.selectedIndex = 0;
    setOptions(
      this.#type,
      scene.material_types.map(({ type }) => type),
    );
    byId("materials", HTMLDetailsElement).hidden = scene.materials.length === 0;
  }

  /**
   * @param {View} view
   * @param {boolean} forced
   */
  show(view, forced) {
    this.#view = view;
    for (const option of this.#list.options) {
      const material = this.#material(option.value);
      if (material === null) continue;
      const color = this.#color(material);
      option.style.setProperty("--swatch", color === null ? "transparent" : css(color));
      const label = `${option.value}  ·  ${material.type}${option.value in view.materials ? "  ·  changed" : ""}`;
      if (option.text !== label) option.text = label;
    }
    this.#showEditor(forced);
  }

  /**
   * Edits a material, if it is one of the scene's; false where it is not.
   * @param {string} name
   */
  select(name) {
    const index = [...this.#list.options].findIndex((option) => option.value === name);
    if (index < 0) return false;
    this.#list.selectedIndex = index;
    byId("materials", HTMLDetailsElement).open = true;
    this.#showEditor(true);
    return true;
  }

  /** @param {string} name */
  #original(name) {
    return this.#scene?.materials.find((material) => material.name === name) ?? null;
  }

  /**
   * A material as it is wanted.
   * @param {string} name
   * @returns {Material | null}
   */
  #material(name) {
    const changed = this.#view?.materials;
    if (changed !== undefined && Object.hasOwn(changed, name)) return changed[name];
    return this.#original(name)?.material ?? null;
  }

  /** @param {string} type */
  #parametersOf(type) {
    return this.#scene?.material_types.find((known) => known.type === type)?.parameters ?? [];
  }

  /**
   * The parameter that is a material's colour: the first that is one.
   * @param {Material} material
   * @returns {Vec3 | null}
   */
  #color(material) {
    const parameter = this.#parametersOf(material.type).find(({ kind }) => kind === "color");
    return parameter === undefined ? null : /** @type {Vec3} */ (material[parameter.name]);
  }

  /** @param {boolean} forced */
  #showEditor(forced) {
    const name = this.#list.value;
    const material = this.#material(name);
    if (material === null) return;
    this.#type.value = material.type;
    this.#restore.disabled = this.#view === null || !Object.hasOwn(this.#view.materials, name);
    const maps = this.#original(name)?.maps ?? [];
    this.#note.textContent = maps.map((map) => MAPS[map] ?? `It has a texture: ${map}.`).join(" ");
    const key = JSON.stringify([name, material.type]);
    if (key !== this.#shown) {
      this.#shown = key;
      this.#buildRows(material.type);
      forced = true;
    }
    for (const [parameter, row] of this.#rows) {
      const value = material[parameter];
      if (row instanceof ColorRow) row.show(/** @type {Vec3} */ (value), forced);
      else row.show(Number(value), forced);
    }
  }

  /** @param {string} type */
  #buildRows(type) {
    this.#rows.clear();
    for (const parameter of this.#parametersOf(type)) {
      const { name } = parameter;
      const settings = { id: `material-${name.replaceAll("_", "-")}`, label: name.replaceAll("_", " ") };
      const changed = (/** @type {number | Vec3} */ value) => this.#setParameter(name, value);
      if (parameter.kind === "color") {
        this.#rows.set(name, new ColorRow(settings, changed));
      } else {
        const { low, high } = parameter;
        const shape = high - low >= WIDE ? "cubic" : "even";
        this.#rows.set(name, new NumberRow({ ...settings, low, high, shape }, changed));
      }
    }
    const rows = [...this.#rows.values()].map((row) => row.element);
    this.#parameters.replaceChildren(...rows);
    if (rows.length === 0) this.#parameters.append(create("p", { class: "note" }, "This type has no parameters."));
  }

  /**
   * @param {string} parameter
   * @param {number | Vec3} value
   */
  #setParameter(parameter, value) {
    const material = this.#material(this.#list.value);
    if (material !== null) this.#set({ ...material, [parameter]: value });
  }

  /** @param {string} type */
  #setType(type) {
    const name = this.#list.value;
    const before = this.#material(name);
    if (before === null) return;
    const original = this.#original(name)?.material;
    const kept = { ...this.#kept.get(name) };
    kept.color = this.#color(before) ?? kept.color;
    if (typeof before.roughness === "number") kept.roughness = before.roughness;
    this.#kept.set(name, kept);
    /** @type {Material} */
    const material = original?.type === type ? { ...original } : { type };
    let colors = 0;
    for (const parameter of this.#parametersOf(type)) {
      material[parameter.name] ??= parameter.value;
      if (parameter.kind === "color") {
        if (colors === 0 && kept.color !== undefined) material[parameter.name] = kept.color;
        colors += 1;
      } else if (parameter.name === "roughness" && kept.roughness !== undefined) {
        material.roughness = Math.max(parameter.low, Math.min(parameter.high, kept.roughness));
      }
    }
    if (type === "phong") leaveRoom(material);
    this.#set(material);
  }

  /** @param {Material | null} material null: as the scene says */
  #set(material) {
    const name = this.#list.value;
    const original = this.#original(name)?.material;
    this.change((view) => {
      const materials = { ...view.materials };
      if (material === null || same(material, original)) delete materials[name];
      else materials[name] = material;
      return { ...view, materials };
    });
  }
}

/**
 * Lowers what a phong material reflects as a mirror would, to what its colour leaves: it cannot reflect more than it gets.
 * @param {Material} material
 */
function leaveRoom(material) {
  const diffuse = /** @type {Vec3} */ (material.diffuse);
  const specular = /** @type {Vec3} */ (material.specular);
  material.specular = /** @type {Vec3} */ (
    specular.map((s, i) => Math.min(s, Math.max(0, Number((1 - diffuse[i]).toPrecision(4)))))
  );
}
