// @ts-check
// What the page and the program say to each other.

/** @typedef {[number, number, number]} Vec3 */

/**
 * A camera: world space, `vertical_fov` in degrees, lengths in units of the scene.
 * @typedef {{position: Vec3, look_at: Vec3, up: Vec3, vertical_fov: number, aperture_radius: number,
 *   focus_distance: number}} Lens
 */

/**
 * How one side is rendered. Seeds go up to 2⁶⁴ − 1, more than a number holds here: they are kept as digits.
 * @typedef {{strategy: string, sampler: string, path_length: number, seed: string, roulette: number | null}} Side
 */

/**
 * A type and exactly its parameters.
 * @typedef {{type: string, [parameter: string]: string | number | Vec3}} Material
 */

/**
 * @typedef {{size: [number, number], camera: string, lens: Lens, sides: Side[], balance: string,
 *   materials: Record<string, Material>, aovs: {first_hits: boolean, lengths: boolean}, layer: string,
 *   limit: number}} View
 */

/** @typedef {{name: string, maps: string[], material: Material}} NamedMaterial */

/**
 * @typedef {{name: string, kind: "color", value: Vec3}
 *   | {name: string, kind: "number", low: number, high: number, value: number}} Parameter
 */

/** @typedef {{type: string, parameters: Parameter[]}} MaterialType */

/**
 * @typedef {{type: "hello", version: string, scene: string, threads: number, cameras: {name: string, lens: Lens}[],
 *   materials: NamedMaterial[], material_types: MaterialType[], strategies: string[], samplers: string[],
 *   tonemaps: string[], bounds: {center: Vec3, radius: number} | null, start: View}} Hello
 */

/** @typedef {{name: string, seconds: number, items: number, lane_use: number}} Stage */

/**
 * `curve`: seconds, samples and error, ascending.
 * @typedef {{samples: number, seconds: number, paths: number, rays: number, paths_per_s: number, rays_per_s: number,
 *   rejected: number, stages: Stage[], curve: Vec3[]}} SideStatistics
 */

/** @typedef {{type: "stats", generation: number, state: string, sides: SideStatistics[]}} Statistics */

/** @typedef {{position: Vec3, depth: number, distance: number, material: string | null}} Hit */

/**
 * @typedef {Hello
 *   | {type: "view", id: number | null, generation: number, view: View}
 *   | {type: "refused", id: number | null, message: string}
 *   | {type: "picked", id: number, hit: Hit | null}
 *   | Statistics} FromServer
 */

/**
 * @typedef {{type: "view", id: number, view: View}
 *   | {type: "drawn", picture: number}
 *   | {type: "pick", id: number, x: number, y: number}
 *   | {type: "pause", paused: boolean}} ToServer
 */

/**
 * One side of a picture: rows from the top, `channels` half floats a pixel.
 * @typedef {{width: number, height: number, channels: number, samples: number, coarse: boolean,
 *   data: Uint16Array}} Image
 */

/** @typedef {{picture: number, generation: number, layer: string, sides: Image[]}} Picture */

/**
 * A text frame of the program.
 * @param {string} text
 * @returns {FromServer}
 */
export function parse(text) {
  // Within a string of JSON the quotes would be escaped, so this finds the key alone.
  return JSON.parse(text.replace(/"seed":\s*(\d+)/g, '"seed":"$1"'));
}

/**
 * A text frame for the program.
 * @param {ToServer} message
 */
export function serialise(message) {
  return JSON.stringify(message).replace(/"seed":"(\d+)"/g, '"seed":$1');
}

/**
 * A binary frame of the program; throws where it is not one.
 * @param {ArrayBuffer} frame
 * @returns {Picture}
 */
export function decodePicture(frame) {
  const length = new DataView(frame).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(frame, 4, length)));
  for (const side of header.sides) {
    side.data = new Uint16Array(frame, 4 + length + side.offset, side.width * side.height * side.channels);
  }
  return header;
}

/**
 * The layers of these sides, by the name the program knows; one that shows paths of a length is there for each length
 * that all sides have.
 * @param {Side[]} sides
 */
export function layers(sides) {
  // Nobody looks for a path of so many edges in a list.
  const longest = Math.min(64, ...sides.map((side) => side.path_length));
  const lengths = Array.from({ length: longest }, (_, i) => `length:${i + 1}`);
  return ["radiance", "error", "albedo", "normal", "depth", ...lengths];
}

/**
 * What has to be recorded for a layer to be shown, or null.
 * @param {string} layer
 * @returns {"first_hits" | "lengths" | null}
 */
export function recordOf(layer) {
  if (layer.startsWith("length:")) return "lengths";
  return layer === "radiance" || layer === "error" ? null : "first_hits";
}

/**
 * A view that the program can take: its layer exists, and is recorded.
 * @param {View} view
 * @returns {View}
 */
export function consistent(view) {
  if (!layers(view.sides).includes(view.layer)) view = { ...view, layer: "radiance" };
  const record = recordOf(view.layer);
  if (record === null || view.aovs[record]) return view;
  return { ...view, aovs: { ...view.aovs, [record]: true } };
}
