// @ts-check
// From half floats to the eight bits of a screen: the same curves as those of the program's PNG.

/**
 * How a layer is shown: `light` through exposure and curve, `albedo` by the transfer function alone; as codes, without
 * one, `normal` from [−1, 1] and `depth` from the farthest to 0, where 0 itself is that of nothing, and black.
 * @typedef {"light" | "albedo" | "normal" | "depth"} Mode
 */

/**
 * `exposure`: in EV. `farthest`: the depth that is black.
 * @typedef {{mode: Mode, curve: string, exposure: number, farthest: number}} Display
 */

/** The order of the curves in the shader. */
export const CURVES = ["linear", "reinhard", "aces"];

/** The order of the modes in the shader. */
export const MODES = ["light", "albedo", "normal", "depth"];

/** What follows 65504, the largest finite half: infinity. */
const INFINITE = 0x7c00;

/**
 * @param {string} layer
 * @returns {Mode}
 */
export function modeOf(layer) {
  if (layer === "albedo" || layer === "normal" || layer === "depth") return layer;
  return "light";
}

/**
 * The value of a half float's bits.
 * @param {number} bits
 */
export function half(bits) {
  const exponent = (bits >> 10) & 31;
  const fraction = bits & 1023;
  const sign = bits & 0x8000 ? -1 : 1;
  if (exponent === 31) return fraction ? NaN : sign * Infinity;
  if (exponent === 0) return sign * fraction * 2 ** -24;
  return sign * (1 + fraction / 1024) * 2 ** (exponent - 15);
}

/**
 * The greatest finite one of half floats, 0 where there is none above it.
 * @param {Uint16Array} data
 */
export function largest(data) {
  // Bits of positive half floats are ordered as their values are.
  let most = 0;
  for (let i = 0; i < data.length; i++) {
    if (data[i] > most && data[i] < INFINITE) most = data[i];
  }
  return half(most);
}

/**
 * Linear light in, linear light in [0, 1] out; what is negative and NaN give 0.
 * @param {string} curve
 * @param {number} x
 */
export function apply(curve, x) {
  // The limit keeps quotients finite.
  x = Math.min(x > 0 ? x : 0, 3.4e38);
  let y = x;
  if (curve === "reinhard") y = x / (1 + x);
  if (curve === "aces") y = (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14);
  return Math.min(y, 1);
}

/**
 * The transfer function of IEC 61966-2-1: linear in [0, 1] to encoded in [0, 1].
 * @param {number} linear
 */
export function encode(linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * linear ** (1 / 2.4) - 0.055;
}

/**
 * Its inverse.
 * @param {number} encoded
 */
export function decode(encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : ((encoded + 0.055) / 1.055) ** 2.4;
}

/**
 * What a channel is shown as, in [0, 1].
 * @param {Display} display
 * @param {number} value
 */
function shown({ mode, curve, exposure, farthest }, value) {
  switch (mode) {
    case "light":
      return encode(apply(curve, value * 2 ** exposure));
    case "albedo":
      return encode(apply("linear", value));
    case "normal":
      return 0.5 + 0.5 * value;
    case "depth":
      return value > 0 ? 1 - value / farthest : 0;
  }
}

/**
 * The eight bits of every half float, by its own.
 * @param {Display} display
 */
export function table(display) {
  // Storing clamps to 0 and 255; NaN gives 0.
  return Uint8ClampedArray.from({ length: 65536 }, (_, bits) => Math.floor(255 * shown(display, half(bits)) + 0.5));
}

/** `shown` for the fragment shader, on three channels; rounded, so that every machine rounds alike. */
export const SHADER = `
uniform int mode;
uniform int curve;
uniform float scale;
uniform float farthest;

float tone(float x) {
  x = min(x > 0.0 ? x : 0.0, 1e18);
  if (curve == 1) x = x / (1.0 + x);
  if (curve == 2) x = (x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14);
  return min(x, 1.0);
}

float encode(float x) {
  return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1.0 / 2.4) - 0.055;
}

float shown(float x) {
  if (mode == 0) x = encode(tone(x * scale));
  else if (mode == 1) x = encode(x > 0.0 ? min(x, 1.0) : 0.0);
  else if (mode == 2) x = 0.5 + 0.5 * x;
  else x = x > 0.0 ? 1.0 - x / farthest : 0.0;
  return floor(255.0 * (x > 0.0 ? min(x, 1.0) : 0.0) + 0.5) / 255.0;
}

vec3 shown(vec3 color) {
  return vec3(shown(color.r), shown(color.g), shown(color.b));
}
`;
