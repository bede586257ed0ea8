// @ts-check
// Pictures by WebGL 2: half floats go to the graphics card as they are, and the fragment shader maps them.

import { CURVES, MODES, SHADER } from "./tonemap.js";

/** @typedef {import("./protocol.js").Image} Image */
/** @typedef {import("./tonemap.js").Display} Display */

const VERTEX = `#version 300 es
// One triangle that covers the picture.
void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  gl_Position = vec4(4.0 * corner - 1.0, 0.0, 1.0);
}
`;

const FRAGMENT = `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
uniform sampler2D image;
uniform vec2 size;
uniform bool coarse;
uniform bool grey;
out vec4 color;
${SHADER}
void main() {
  vec2 place = vec2(gl_FragCoord.x, size.y - gl_FragCoord.y);
  vec3 value = coarse ? texture(image, place / size).rgb : texelFetch(image, ivec2(place), 0).rgb;
  color = vec4(shown(grey ? value.rrr : value), 1.0);
}
`;

export class GlScreen {
  /** @type {WebGLTexture[]} */
  #textures = [];
  /** @type {Image[]} */
  #images = [];
  /** @type {Map<string, WebGLUniformLocation | null>} */
  #places = new Map();

  /**
   * Draws on a canvas from here on, or gives null where this machine cannot.
   * @param {HTMLCanvasElement} canvas
   */
  static on(canvas) {
    // Kept, so that what is on the canvas can be copied at any time.
    const gl = canvas.getContext("webgl2", { alpha: false, antialias: false, depth: false, preserveDrawingBuffer: true });
    if (gl === null) return null;
    const screen = new GlScreen(canvas, gl);
    return screen.#prepare() ? screen : null;
  }

  /**
   * @param {HTMLCanvasElement} canvas
   * @param {WebGL2RenderingContext} gl
   */
  constructor(canvas, gl) {
    this.canvas = canvas;
    this.gl = gl;
  }

  /** Whether pictures of this size can be drawn, once the canvas has it. */
  fits() {
    const { canvas, gl } = this;
    const most = gl.getParameter(gl.MAX_TEXTURE_SIZE);
    if (gl.isContextLost()) return true;
    return (
      gl.drawingBufferWidth === canvas.width &&
      gl.drawingBufferHeight === canvas.height &&
      Math.max(canvas.width, canvas.height) <= most
    );
  }

  /** After the context was lost, and is there again. */
  restore() {
    this.#textures = [];
    const ready = this.#prepare();
    if (ready) this.upload(this.#images);
    return ready;
  }

  /** @param {Image[]} images */
  upload(images) {
    const { gl } = this;
    this.#images = images;
    if (gl.isContextLost()) return;
    // A row of half floats begins at any even address.
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 2);
    images.forEach(({ width, height, channels, coarse, data }, i) => {
      this.#textures[i] ??= /** @type {WebGLTexture} */ (gl.createTexture());
      gl.bindTexture(gl.TEXTURE_2D, this.#textures[i]);
      const [internal, format] = channels === 1 ? [gl.R16F, gl.RED] : [gl.RGB16F, gl.RGB];
      gl.texImage2D(gl.TEXTURE_2D, 0, internal, width, height, 0, format, gl.HALF_FLOAT, data);
      const filter = coarse ? gl.LINEAR : gl.NEAREST;
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, filter);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, filter);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    });
  }

  /**
   * @param {Display} display
   * @param {number} divider the column at which the second side begins
   */
  draw(display, divider) {
    const { gl, canvas } = this;
    if (gl.isContextLost()) return;
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.uniform1i(this.#place("mode"), MODES.indexOf(display.mode));
    gl.uniform1i(this.#place("curve"), CURVES.indexOf(display.curve));
    gl.uniform1f(this.#place("scale"), 2 ** display.exposure);
    gl.uniform1f(this.#place("farthest"), display.farthest);
    gl.uniform2f(this.#place("size"), canvas.width, canvas.height);
    gl.enable(gl.SCISSOR_TEST);
    this.#images.forEach((image, i) => {
      gl.bindTexture(gl.TEXTURE_2D, this.#textures[i]);
      const start = i === 0 ? 0 : divider;
      gl.scissor(start, 0, canvas.width - start, canvas.height);
      gl.uniform1i(this.#place("coarse"), Number(image.width !== canvas.width || image.height !== canvas.height));
      gl.uniform1i(this.#place("grey"), Number(image.channels === 1));
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    });
  }

  #prepare() {
    const { gl } = this;
    const program = gl.createProgram();
    if (program === null) return false;
    for (const [kind, source] of /** @type {[number, string][]} */ ([
      [gl.VERTEX_SHADER, VERTEX],
      [gl.FRAGMENT_SHADER, FRAGMENT],
    ])) {
      const shader = gl.createShader(kind);
      if (shader === null) return false;
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) return false;
    gl.useProgram(program);
    this.#places.clear();
    for (const name of ["mode", "curve", "scale", "farthest", "size", "coarse", "grey"]) {
      this.#places.set(name, gl.getUniformLocation(program, name));
    }
    return true;
  }

  /** @param {string} name */
  #place(name) {
    return this.#places.get(name) ?? null;
  }
}
