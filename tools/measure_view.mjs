#!/usr/bin/env node
// How quick the live page is, and what it costs: the time from a move of the camera to the first picture, and the paths per
// second that `ondine view` traces while a page is open, against those of `ondine render`.
//
//     node tools/measure_view.mjs target/release/ondine [SCENE] [--size 512x512] [--moves 20] [--seconds 20] [--rounds 3] [--json]
//
// The two speeds are measured by turns. A path of the live page is one of a finished pass, per second on the clock; one of the
// render is what it says of itself. Needs Chromium, and talks to it through its debugging pipe: whatever watches the page's
// traffic would slow it down. Measure on a quiet machine.

import { execFile, spawn } from "node:child_process";
import { mkdtemp, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { parseArgs, promisify } from "node:util";
import { FLAGS, executable, serve, sleep, until } from "../tests/browser/program.mjs";

const options = {
  size: { type: "string", default: "512x512" },
  moves: { type: "string", default: "20" },
  seconds: { type: "string", default: "20" },
  rounds: { type: "string", default: "3" },
  json: { type: "boolean", default: false },
};
const { values: given, positionals } = parseArgs({ options, allowPositionals: true });
const [ondine = "target/release/ondine", scene = "cornell"] = positionals;
const [moves, seconds, rounds] = [given.moves, given.seconds, given.rounds].map(Number);

const median = (values) => {
  const sorted = [...values].sort((a, b) => a - b);
  return (sorted[Math.floor((sorted.length - 1) / 2)] + sorted[Math.ceil((sorted.length - 1) / 2)]) / 2;
};

/** Chromium with one empty page in which expressions can be evaluated. */
async function openBrowser() {
  const profile = await mkdtemp(join(tmpdir(), "ondine-measure-"));
  const flags = ["--headless", "--remote-debugging-pipe", "--window-size=1400,900", `--user-data-dir=${profile}`];
  const child = spawn(executable, [...FLAGS, ...flags], { stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"] });
  process.on("exit", () => child.kill());
  const waiting = new Map();
  let received = "";
  child.stdio[4].setEncoding("utf8").on("data", (data) => {
    const messages = (received + data).split("\0");
    received = messages.pop();
    for (const { id, result, error } of messages.map((message) => JSON.parse(message))) {
      const [resolve, reject] = waiting.get(id) ?? [];
      waiting.delete(id);
      if (error) reject?.(new Error(error.message));
      else resolve?.(result);
    }
  });
  let last = 0;
  const call = (method, params, sessionId) =>
    new Promise((resolve, reject) => {
      last += 1;
      waiting.set(last, [resolve, reject]);
      child.stdio[3].write(`${JSON.stringify({ id: last, method, params, sessionId })}\0`);
    });
  return {
    open: async (url) => {
      const { targetId } = await call("Target.createTarget", { url });
      const { sessionId } = await call("Target.attachToTarget", { targetId, flatten: true });
      return {
        evaluate: async (expression) => {
          const params = { expression, awaitPromise: true, returnByValue: true };
          const { result, exceptionDetails } = await call("Runtime.evaluate", params, sessionId);
          if (exceptionDetails) throw new Error(exceptionDetails.exception?.description ?? exceptionDetails.text);
          return result.value;
        },
        close: () => call("Target.closeTarget", { targetId }),
      };
    },
    close: async () => {
      const ended = new Promise((resolve) => child.on("exit", resolve));
      await call("Browser.close", {}).catch(() => {});
      await ended;
      await rm(profile, { recursive: true, force: true, maxRetries: 5 });
    },
  };
}

/** In the page: turns the camera as the arrow keys do; gives milliseconds to the first picture, by the clock and by the page. */
async function turn(moves) {
  const { dataset } = document.documentElement;
  const picture = document.getElementById("picture");
  const times = [];
  for (let i = 0; i < moves; i++) {
    // At any time of a pass.
    await new Promise((resolve) => setTimeout(resolve, 300 + 500 * Math.random()));
    const generation = Number(dataset.generation);
    delete dataset.latencyMs;
    const begin = performance.now();
    const drawn = new Promise((resolve) => {
      const observer = new MutationObserver(() => {
        if (Number(dataset.generation) <= generation) return;
        observer.disconnect();
        resolve();
      });
      observer.observe(document.documentElement, { attributes: true });
    });
    const key = i % 10 < 5 ? "ArrowRight" : "ArrowLeft";
    picture.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true }));
    await drawn;
    times.push([performance.now() - begin, Number(dataset.latencyMs)]);
  }
  return times;
}

/** In the page: how many samples per pixel a second come, by the clock. */
async function count(seconds) {
  const { dataset } = document.documentElement;
  const points = [];
  const observer = new MutationObserver(() => {
    const samples = Number(dataset.samplesA);
    if (samples !== points[points.length - 1]?.[1]) points.push([performance.now() / 1000, samples]);
  });
  observer.observe(document.documentElement, { attributes: true, attributeFilter: ["data-samples-a"] });
  await new Promise((resolve) => setTimeout(resolve, 1000 * seconds));
  observer.disconnect();
  const [[t0, n0], [t1, n1]] = [points[0], points[points.length - 1]];
  return (n1 - n0) / (t1 - t0);
}

/** What `measure` gives for the page of a server of its own. */
async function onPage(browser, measure) {
  const server = await serve(ondine, [scene, "--size", given.size, "--spp", "134217728"]);
  const page = await browser.open(server.url);
  await until("samples come", () => page.evaluate("Number(document.documentElement?.dataset.samplesA) >= 16"));
  await sleep(1000);
  const measured = await measure(page);
  await page.close();
  await server.end();
  return measured;
}

async function rendered(folder) {
  const parameters = ["render", scene, "--size", given.size, "--time", String(seconds), "--json", "--no-png", "-o", join(folder, "image.exr")];
  const { stdout } = await promisify(execFile)(ondine, parameters);
  const said = JSON.parse(stdout);
  return said.paths / said.render_s;
}

const [width, height] = given.size.split("x").map(Number);
const folder = await mkdtemp(join(tmpdir(), "ondine-measure-"));
const browser = await openBrowser();
const times = await onPage(browser, (page) => page.evaluate(`(${turn})(${moves})`));
const speeds = [];
for (let round = 0; round < rounds; round++) {
  const open = width * height * (await onPage(browser, (page) => page.evaluate(`(${count})(${seconds})`)));
  speeds.push({ page_open: open, render: await rendered(folder) });
}
await browser.close();
await rm(folder, { recursive: true });

const [clock, page] = [0, 1].map((i) => times.map((time) => time[i]));
const summary = (values) => ({ median: median(values), worst: Math.max(...values) });
const speed = (key) => median(speeds.map((round) => round[key]));
const report = {
  scene,
  size: given.size,
  key_to_picture_ms: summary(clock),
  view_to_picture_ms: summary(page),
  paths_per_s: { page_open: speed("page_open"), render: speed("render") },
  ratio: median(speeds.map(({ page_open, render }) => page_open / render)),
  rounds: speeds,
};
if (given.json) {
  console.log(JSON.stringify(report));
} else {
  const ms = ({ median, worst }) => `median ${median.toFixed(0)} ms, worst ${worst.toFixed(0)} ms`;
  console.log(`${scene} at ${given.size}, ${moves} moves of the camera`);
  console.log(`from key to first picture:       ${ms(report.key_to_picture_ms)}`);
  console.log(`from view sent to first picture: ${ms(report.view_to_picture_ms)}`);
  for (const { page_open, render } of speeds) {
    console.log(`Mpaths/s: page open ${(page_open / 1e6).toFixed(3)}, render ${(render / 1e6).toFixed(3)}: ${((100 * page_open) / render).toFixed(1)} %`);
  }
  console.log(`median of the parts: ${(100 * report.ratio).toFixed(1)} %`);
}
