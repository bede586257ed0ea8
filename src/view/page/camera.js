// @ts-check
// Moves of a camera: a lens in, another out. The camera turns about `look_at`, its `up` stays.

/** @typedef {import("./protocol.js").Lens} Lens */
/** @typedef {import("./protocol.js").Vec3} Vec3 */

/** Radians from the horizon at which orbits end: at the poles there is no right or left. */
const HIGHEST = (89 * Math.PI) / 180;

/** @type {(a: Vec3, b: Vec3, t?: number) => Vec3} a + t·b */
const add = (a, b, t = 1) => [a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2]];

/** @type {(a: Vec3, b: Vec3) => Vec3} */
const subtract = (a, b) => add(a, b, -1);

/** @type {(a: Vec3, b: Vec3) => number} */
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** @type {(a: Vec3, b: Vec3) => Vec3} */
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

/** @type {(a: Vec3) => number} */
const norm = (a) => Math.hypot(...a);

/** @type {(a: Vec3) => Vec3} */
const unit = (a) => add([0, 0, 0], a, 1 / norm(a));

/**
 * A number of six significant digits, as people write it.
 * @param {number} x
 */
export function rounded(x) {
  return Number(x.toPrecision(6));
}

/**
 * A point of six significant digits, where those are counted from `scale`: nothing is left of what rounding made of 0.
 * @param {Vec3} point
 * @param {number} scale
 * @returns {Vec3}
 */
function roundedPoint(point, scale) {
  const [x, y, z] = point.map((x) => (Math.abs(x) < 1e-7 * scale ? 0 : rounded(x)));
  return [x, y, z];
}

/**
 * How far `look_at` is.
 * @param {Lens} lens
 */
export function distance(lens) {
  return norm(subtract(lens.position, lens.look_at));
}

/**
 * Unit vectors to the right and up in the picture, world space.
 * @param {Lens} lens
 */
function frame(lens) {
  const forward = unit(subtract(lens.look_at, lens.position));
  const right = unit(cross(forward, lens.up));
  return { right, up: cross(right, forward) };
}

/**
 * Goes around `look_at`: to the right by `azimuth` and up by `elevation`, in radians.
 * @param {Lens} lens
 * @param {number} azimuth
 * @param {number} elevation
 * @returns {Lens}
 */
export function orbit(lens, azimuth, elevation) {
  const pole = unit(lens.up);
  const arm = subtract(lens.position, lens.look_at);
  const length = norm(arm);
  const { right } = frame(lens);
  // With `right` and the pole these are the axes of the turntable; this one points from `look_at` to below the camera.
  const out = cross(right, pole);
  const from = Math.asin(Math.max(-1, Math.min(1, dot(arm, pole) / length)));
  const to = Math.max(-HIGHEST, Math.min(HIGHEST, from + elevation));
  const level = add(add([0, 0, 0], out, Math.cos(azimuth)), right, Math.sin(azimuth));
  const direction = add(add([0, 0, 0], level, Math.cos(to)), pole, Math.sin(to));
  return { ...lens, position: roundedPoint(add(lens.look_at, direction, length), length) };
}

/**
 * Moves the camera to the right and up, in heights of the picture at the distance of `look_at`.
 * @param {Lens} lens
 * @param {number} right
 * @param {number} up
 * @returns {Lens}
 */
export function pan(lens, right, up) {
  const height = 2 * Math.tan((lens.vertical_fov * Math.PI) / 360) * distance(lens);
  const axes = frame(lens);
  const step = add(add([0, 0, 0], axes.right, right * height), axes.up, up * height);
  const scale = distance(lens);
  return {
    ...lens,
    position: roundedPoint(add(lens.position, step), scale),
    look_at: roundedPoint(add(lens.look_at, step), scale),
  };
}

/**
 * Moves towards `look_at`, to `factor` of the distance.
 * @param {Lens} lens
 * @param {number} factor
 * @returns {Lens}
 */
export function dolly(lens, factor) {
  const arm = subtract(lens.position, lens.look_at);
  return { ...lens, position: roundedPoint(add(lens.look_at, arm, factor), norm(arm) * factor) };
}

/**
 * Turns towards a point; where that is straight above or below, or here, the lens stays as it is.
 * @param {Lens} lens
 * @param {Vec3} point world space
 * @returns {Lens}
 */
export function lookAt(lens, point) {
  const arm = subtract(point, lens.position);
  const length = norm(arm);
  const look_at = roundedPoint(point, length);
  return norm(cross(arm, unit(lens.up))) > 1e-3 * length ? { ...lens, look_at } : lens;
}
