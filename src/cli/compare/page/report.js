"use strict";
{
  const data = JSON.parse(document.getElementById("data").textContent);
  const $ = (id) => document.getElementById(id);
  const { columns: W, rows: H, scale, x0, y0 } = data;

  // Colours: magma (van der Walt & Smith 2015) at ten steps; blue over grey to red (Moreland 2009) for what has a sign.
  const hex = (list) => list.split(" ").map((c) => [0, 2, 4].map((i) => parseInt(c.slice(i, i + 2), 16)));
  const MAGMA = hex("000004 180f3d 440f76 721f81 9e2f7f cd4071 f1605d fd9668 feca8d fcfdbf");
  const SIGNED = hex("3b4cc0 7b9ff9 c0d4f5 dddddd f5c4ac f18e70 b40426");
  const ramp = (stops) => Array.from({ length: 256 }, (_, i) => {
    const at = i / 255 * (stops.length - 1), k = Math.min(Math.floor(at), stops.length - 2), t = at - k;
    return stops[k].map((a, c) => Math.round(a + (stops[k + 1][c] - a) * t));
  });
  const ramps = { flip: ramp(MAGMA), relative: ramp(SIGNED), blocks: ramp(SIGNED) };

  const linear = (code) => { const v = code / 255; return v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4; };
  const encode = (v) => 255 * Math.min(1, v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055);
  const number = (v) => {
    if (v === 0) return "0";
    const size = Math.abs(v);
    return size >= 1e-3 && size < 1e5 ? Number(v.toPrecision(3)).toString() : v.toExponential(2);
  };
  const layer = (w = W, h = H) => Object.assign(document.createElement("canvas"), { width: w, height: h });

  const VIEWS = ["reference", "test", "split", "flip", "relative", "blocks"];
  const NAMES = { reference: "Reference", test: "Test", split: "Split", flip: "ꟻLIP", relative: "Relative difference", blocks: "Blocks" };
  const views = VIEWS.filter((v) => v !== "flip" || data.flip);
  // Z beyond this has the full colour.
  const Z_END = 6;

  /** Codes of each image, and what is drawn of it. */
  const codes = {}, drawn = {};
  let view = "reference", side = "reference", zoom = 1, left = 0, top = 0, fitted = true, hover = null, timer = 0;

  const canvas = $("canvas"), brush = canvas.getContext("2d");

  async function read(name) {
    const image = $("image-" + name);
    if (!image) return;
    await image.decode();
    const into = layer().getContext("2d", { willReadFrequently: true });
    into.drawImage(image, 0, 0);
    codes[name] = into.getImageData(0, 0, W, H).data;
  }

  function paint(name, pixel) {
    const into = drawn[name] ??= layer();
    const brush = into.getContext("2d"), image = brush.createImageData(W, H), to = image.data;
    for (let i = 0; i < to.length; i += 4) { pixel(i, to); to[i + 3] = 255; }
    brush.putImageData(image, 0, 0);
  }

  function expose() {
    const gain = 2 ** Number($("exposure").value);
    const low = Uint8Array.from({ length: 256 }, (_, c) => Math.round(encode(linear(c) * gain)));
    const high = Uint8Array.from({ length: 256 }, (_, c) => Math.round(encode(linear(c) * data.headroom * gain)));
    for (const name of ["reference", "test"]) {
      const base = codes[name], over = codes[name + "-bright"];
      paint(name, (i, to) => {
        for (let c = i; c < i + 3; c++) to[c] = over && base[c] === 255 && over[c] ? high[over[c]] : low[base[c]];
      });
    }
  }

  /** Linear radiance under a pixel, as well as eight bits tell. */
  function radiance(name, i) {
    const base = codes[name], over = codes[name + "-bright"];
    return [0, 1, 2].map((c) => {
      const bright = over && base[i + c] === 255 && over[i + c];
      return (bright ? linear(bright) * data.headroom : linear(base[i + c])) / data.gain;
    });
  }

  const chosen = () => {
    const { columns, rows, z } = data.layers[Number($("layer").value) || 0];
    return { columns, rows, z: z[Number($("channel").value) || 0] };
  };

  function draw() {
    const { width, height } = canvas;
    brush.setTransform(1, 0, 0, 1, 0, 0);
    brush.fillStyle = "#2a2a2a";
    brush.fillRect(0, 0, width, height);
    brush.imageSmoothingEnabled = zoom < 1;
    brush.setTransform(zoom, 0, 0, zoom, left, top);
    if (view === "split") {
      const edge = width * Number($("split").value) / 1000;
      for (const [name, from, to] of [["reference", 0, edge], ["test", edge, width]]) {
        brush.save();
        brush.setTransform(1, 0, 0, 1, 0, 0);
        brush.beginPath();
        brush.rect(from, 0, to - from, height);
        brush.clip();
        brush.setTransform(zoom, 0, 0, zoom, left, top);
        brush.drawImage(drawn[name], 0, 0);
        brush.restore();
      }
      brush.setTransform(1, 0, 0, 1, 0, 0);
      brush.fillStyle = "#fff";
      brush.fillRect(edge - 1, 0, 2, height);
    } else if (view === "blocks") {
      brush.drawImage(drawn.grey, 0, 0);
      blocks();
    } else {
      brush.drawImage(drawn[view], 0, 0);
    }
    const shown = view === "split" ? "Reference | Test" : NAMES[view];
    if ($("badge").textContent !== shown) $("badge").textContent = shown;
    $("zoom").textContent = `${number(zoom / (devicePixelRatio * scale) * 100)} %`;
  }

  function blocks() {
    const { columns, rows, z } = chosen(), across = columns.length - 1;
    brush.setTransform(1, 0, 0, 1, 0, 0);
    // Whole pixels of the screen: no seams.
    const x = columns.map((c) => Math.round(left + c * zoom / scale)), y = rows.map((r) => Math.round(top + r * zoom / scale));
    const at = (i) => {
      const c = i % across, r = Math.floor(i / across);
      return [x[c], y[r], x[c + 1] - x[c], y[r + 1] - y[r]];
    };
    z.forEach((value, i) => {
      const part = Math.max(-1, Math.min(1, value / Z_END));
      brush.globalAlpha = 0.15 + 0.55 * Math.abs(part);
      brush.fillStyle = `rgb(${ramps.blocks[Math.round(127.5 + 127.5 * part)]})`;
      brush.fillRect(...at(i));
    });
    brush.globalAlpha = 1;
    if (hover && hover.block >= 0) {
      brush.lineWidth = 2 * devicePixelRatio;
      brush.strokeStyle = "#fff";
      brush.strokeRect(...at(hover.block));
    }
  }

  function show(next) {
    view = next;
    if (next === "reference" || next === "test") side = next;
    const radio = $("view-" + next);
    if (radio) radio.checked = true;
    $("split").hidden = view !== "split";
    legend();
    draw();
    readout();
  }

  function flip() { show(side === "reference" ? "test" : "reference"); }

  function legend() {
    const colours = ramps[view];
    $("legend").hidden = !colours;
    if (!colours) return;
    const brush = $("scale").getContext("2d");
    colours.forEach((c, i) => { brush.fillStyle = `rgb(${c})`; brush.fillRect(i, 0, 1, 1); });
    const percent = `${number(data.relative_range * 100)} %`;
    const [low, high, what] = {
      flip: ["0", "1", "error that an observer sees"],
      relative: [`−${percent}`, `+${percent}`, "difference of luminance over the reference's"],
      blocks: [`−${Z_END}`, `+${Z_END}`, "normal score of each block's mean difference; the reference is behind"],
    }[view];
    $("low").textContent = low;
    $("high").textContent = high;
    $("what").textContent = what;
  }

  function readout() {
    if (!hover) { $("readout").textContent = "Point at a pixel for its values."; return; }
    const { x, y } = hover, i = 4 * (y * W + x);
    const rgb = (name) => radiance(name, i).map(number).join("  ");
    const place = scale === 1 ? `pixel ${x0 + x},${y0 + y}` : `pixels from ${x0 + x * scale},${y0 + y * scale}`;
    let text = `${place}   reference ≈ ${rgb("reference")}   test ≈ ${rgb("test")}`;
    const relative = (codes.relative[i] - 128) / 127 * data.relative_range * 100;
    text += `\nrelative difference ≈ ${relative > 0 ? "+" : ""}${relative.toFixed(0)} %`;
    if (data.flip) text += `   ꟻLIP ${(codes.flip[i] / 255).toFixed(2)}`;
    if (hover.block >= 0) {
      const { columns, rows, z } = chosen(), across = columns.length - 1, b = hover.block;
      const [c, r] = [b % across, Math.floor(b / across)];
      text += `   block ${x0 + columns[c]},${y0 + rows[r]} to ${x0 + columns[c + 1]},${y0 + rows[r + 1]}: z = ${z[b].toFixed(2)}`;
    }
    $("readout").textContent = text;
  }

  function point(event) {
    const box = canvas.getBoundingClientRect();
    const px = (event.clientX - box.left) * canvas.width / box.width, py = (event.clientY - box.top) * canvas.height / box.height;
    const x = Math.floor((px - left) / zoom), y = Math.floor((py - top) / zoom);
    hover = null;
    if (x >= 0 && y >= 0 && x < W && y < H) {
      const { columns, rows } = chosen();
      const column = columns.findLastIndex((c) => c <= x * scale), row = rows.findLastIndex((r) => r <= y * scale);
      const across = columns.length - 1;
      hover = { x, y, block: across > 0 ? Math.min(row, rows.length - 2) * across + Math.min(column, across - 1) : -1 };
    }
    readout();
    if (view === "blocks") draw();
    return [px, py];
  }

  function fit() {
    zoom = Math.min(canvas.width / W, canvas.height / H);
    left = (canvas.width - W * zoom) / 2;
    top = (canvas.height - H * zoom) / 2;
    fitted = true;
    draw();
  }

  function scaleBy(factor, px = canvas.width / 2, py = canvas.height / 2) {
    const least = Math.min(1, canvas.width / W, canvas.height / H) / 2;
    const next = Math.max(least, Math.min(64 * devicePixelRatio, zoom * factor));
    left = px - (px - left) * next / zoom;
    top = py - (py - top) * next / zoom;
    zoom = next;
    fitted = false;
    draw();
  }

  function resize() {
    const width = canvas.parentElement.clientWidth;
    const height = Math.max(180, Math.min(width * H / W, innerHeight * 0.75));
    canvas.style.setProperty("height", `${height}px`);
    canvas.width = Math.round(width * devicePixelRatio);
    canvas.height = Math.round(height * devicePixelRatio);
    if (fitted) fit(); else draw();
    histogram();
  }

  function histogram() {
    const { z } = chosen();
    $("histogram-section").hidden = z.length === 0;
    if (z.length === 0) return;
    const width = Math.max(280, $("histogram").clientWidth), height = 240, foot = 34, side = 40, step = 0.5;
    const bins = 2 * Z_END / step, counts = new Array(bins).fill(0);
    for (const value of z) counts[Math.max(0, Math.min(bins - 1, Math.floor((value + Z_END) / step)))]++;
    const density = (t) => z.length * step * Math.exp(-t * t / 2) / Math.sqrt(2 * Math.PI);
    const most = Math.max(...counts, density(0)) * 1.08;
    const x = (t) => side + (t + Z_END) / (2 * Z_END) * (width - side - 12), y = (n) => height - foot - n / most * (height - foot - 14);
    const svg = (name, attributes, text) => {
      const element = document.createElementNS("http://www.w3.org/2000/svg", name);
      for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
      if (text !== undefined) element.textContent = text;
      return element;
    };
    const far = z.filter((value) => Math.abs(value) > 3).length;
    const said = `${z.length} blocks; ${far} have |z| above 3, ${number(z.length * 0.0027)} would by chance. The line is the standard normal; the bars at the ends hold all beyond.`;
    const plot = svg("svg", { viewBox: `0 0 ${width} ${height}`, height, role: "img", "aria-label": `Histogram of z: ${said}` });
    counts.forEach((n, i) => {
      const from = -Z_END + i * step, beyond = Math.abs(from + step / 2) > 3;
      const bar = svg("rect", { x: x(from) + 0.5, width: x(from + step) - x(from) - 1, y: y(n), height: y(0) - y(n), class: beyond ? "block far" : "block" });
      bar.append(svg("title", {}, `${n} blocks with z from ${from} to ${from + step}`));
      plot.append(bar);
    });
    const curve = Array.from({ length: 241 }, (_, i) => { const t = -Z_END + i * Z_END / 120; return `${x(t).toFixed(1)},${y(density(t)).toFixed(1)}`; });
    plot.append(svg("polyline", { points: curve.join(" "), class: "normal" }));
    plot.append(svg("line", { x1: x(-Z_END), x2: x(Z_END), y1: y(0), y2: y(0), class: "axis" }));
    for (let t = -Z_END; t <= Z_END; t += 2) plot.append(svg("text", { x: x(t), y: height - foot + 17, "text-anchor": "middle" }, String(t).replace("-", "−")));
    plot.append(svg("text", { x: (x(-Z_END) + x(Z_END)) / 2, y: height - 3, "text-anchor": "middle" }, "z"));
    plot.append(svg("text", { x: side - 6, y: y(0), "text-anchor": "end" }, "0"));
    plot.append(svg("text", { x: side - 6, y: y(most / 1.08) + 4, "text-anchor": "end" }, number(Math.round(most / 1.08))));
    $("histogram").replaceChildren(plot);
    $("histogram-text").textContent = said;
  }

  function controls() {
    for (const name of views) {
      const label = document.createElement("label");
      const radio = Object.assign(document.createElement("input"), { type: "radio", name: "view", id: "view-" + name, value: name });
      radio.addEventListener("change", () => show(name));
      label.append(radio, NAMES[name]);
      document.querySelector(".views").append(label);
    }
    data.layers.forEach((layer, i) => $("layer").append(new Option(layer.name, i)));
    data.channels.forEach((name, i) => $("channel").append(new Option(name, i)));
    $("layer").value = String(data.layer);
    $("channel").value = String(data.channel);
    for (const id of ["layer", "channel"]) $(id).addEventListener("change", () => { hover = null; histogram(); draw(); readout(); });
    $("flip").addEventListener("click", flip);
    $("blink").addEventListener("change", (event) => {
      clearInterval(timer);
      if (event.target.checked) timer = setInterval(flip, 600);
    });
    $("split").addEventListener("input", draw);
    $("exposure").addEventListener("input", () => {
      const ev = Number($("exposure").value);
      $("ev").textContent = `${ev > 0 ? "+" : ev < 0 ? "−" : ""}${Math.abs(ev)} EV`;
      expose();
      draw();
    });
    $("fit").addEventListener("click", fit);
    $("in").addEventListener("click", () => scaleBy(2));
    $("out").addEventListener("click", () => scaleBy(0.5));

    const touches = new Map();
    canvas.addEventListener("pointerdown", (event) => { canvas.setPointerCapture(event.pointerId); touches.set(event.pointerId, point(event)); });
    canvas.addEventListener("pointermove", (event) => {
      const before = touches.get(event.pointerId), now = point(event);
      if (!before) return;
      const others = [...touches].filter(([id]) => id !== event.pointerId);
      if (others.length) {
        const [, still] = others[0], reach = ([x, y]) => Math.hypot(x - still[0], y - still[1]);
        if (reach(before) > 0) scaleBy(reach(now) / reach(before), ...still);
      } else {
        left += now[0] - before[0];
        top += now[1] - before[1];
        fitted = false;
        draw();
      }
      touches.set(event.pointerId, now);
    });
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => touches.delete(event.pointerId));
    canvas.addEventListener("pointerleave", () => { hover = null; readout(); if (view === "blocks") draw(); });
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      scaleBy(2 ** (-Math.sign(event.deltaY) * Math.min(1, Math.abs(event.deltaY) / 200)), ...point(event));
    }, { passive: false });

    const nudge = (steps) => {
      $("exposure").value = String(Number($("exposure").value) + steps / 2);
      $("exposure").dispatchEvent(new Event("input"));
    };
    document.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey || event.target.tagName === "SELECT") return;
      const keys = {
        f: flip, b: () => $("blink").click(), "+": () => scaleBy(2), "=": () => scaleBy(2), "-": () => scaleBy(0.5), 0: fit,
        "[": () => nudge(-1), "]": () => nudge(1),
      };
      views.forEach((name, i) => { keys[i + 1] = () => show(name); });
      const act = keys[event.key.toLowerCase()];
      if (act) { event.preventDefault(); act(); return; }
      const move = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
      if (move && event.target === canvas) {
        event.preventDefault();
        left += move[0] * canvas.width / 8;
        top += move[1] * canvas.height / 8;
        fitted = false;
        draw();
      }
    });
    new ResizeObserver(resize).observe(canvas.parentElement);
  }

  async function start() {
    const names = ["reference", "test", "reference-bright", "test-bright", "relative", "flip"];
    await Promise.all(names.map(read));
    expose();
    // Behind the blocks: where in the image they are.
    paint("grey", (i, to) => {
      const [r, g, b] = codes.reference.subarray(i, i + 3);
      to[i] = to[i + 1] = to[i + 2] = 40 + 0.5 * (0.2126 * r + 0.7152 * g + 0.0722 * b);
    });
    for (const name of ["flip", "relative"]) {
      if (codes[name]) paint(name, (i, to) => to.set(ramps[name][codes[name][i]], i));
    }
    controls();
    $("plates").hidden = true;
    $("viewer").hidden = false;
    show("reference");
    resize();
    document.documentElement.dataset.ready = "";
  }
  start();
}
