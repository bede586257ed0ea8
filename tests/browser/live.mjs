// The live page in Chromium, for tests: opens it, uses it, and notes what is wrong there.
//
// playwright-core is installed under target/, so that nothing of it gets into the tree:
//
//     mkdir -p target/browser && cp tests/browser/package*.json target/browser && npm ci --prefix target/browser

import { createRequire } from "node:module";
import { pathToFileURL } from "node:url";
import { FLAGS, PATIENCE, executable, sleep, until } from "./program.mjs";

const target = process.env.CARGO_TARGET_DIR ?? new URL("../../target", import.meta.url).pathname;
const { chromium } = createRequire(pathToFileURL(`${target}/browser/`))("playwright-core");

export function openBrowser() {
  return chromium.launch({ executablePath: executable, args: FLAGS });
}

/** The page of a server in a window of its own. */
export async function openPage(browser, url, { query = "", ...options } = {}) {
  const context = await browser.newContext({ viewport: { width: 1400, height: 900 }, ...options });
  context.setDefaultTimeout(PATIENCE);
  const page = await context.newPage();
  const live = new Live(page);
  await live.listen();
  await page.goto(url + query);
  await live.until("a picture is drawn", (data) => data.picture !== undefined);
  return live;
}

/** An open page, and what went over its socket. */
export class Live {
  /** What the browser complained about. */
  complaints = [];
  /** Text frames that the page sent, and those it got, but for statistics. */
  sent = [];
  got = [];
  /** All statistics. */
  history = [];
  /** What was drawn last: the header of a picture, and its half floats for each side. */
  drawn = null;
  #pictures = new Map();

  constructor(page) {
    this.page = page;
  }

  async listen() {
    const { page, complaints } = this;
    page.on("console", (message) => {
      // Reading the canvas back is slow: so be it.
      if (["error", "warning"].includes(message.type()) && !message.text().includes("GPU stall due to ReadPixels")) {
        complaints.push(`${message.type()}: ${message.text()}`);
      }
    });
    page.on("pageerror", (error) => complaints.push(`exception: ${error.stack}`));
    page.on("requestfailed", (request) => complaints.push(`failed: ${request.url()} ${request.failure()?.errorText}`));
    page.on("response", (response) => {
      if (response.status() >= 400) complaints.push(`${response.status()}: ${response.url()}`);
    });
    await page.exposeFunction("complain", (text) => complaints.push(text));
    await page.addInitScript(() =>
      document.addEventListener("securitypolicyviolation", (event) =>
        window.complain(`forbidden by ${event.violatedDirective}: ${event.blockedURI}`),
      ),
    );
    page.on("websocket", (socket) => {
      socket.on("framesent", ({ payload }) => this.#onSent(JSON.parse(payload)));
      socket.on("framereceived", ({ payload }) => this.#onReceived(payload));
    });
  }

  #onSent(message) {
    this.sent.push(message);
    if (message.type !== "drawn") return;
    this.drawn = this.#pictures.get(message.picture) ?? this.drawn;
    for (const number of this.#pictures.keys()) if (number <= message.picture) this.#pictures.delete(number);
  }

  #onReceived(payload) {
    if (typeof payload === "string") {
      const message = JSON.parse(payload);
      (message.type === "stats" ? this.history : this.got).push(message);
      return;
    }
    const length = payload.readUInt32LE(0);
    const header = JSON.parse(payload.toString("utf8", 4, 4 + length));
    const start = 4 + length;
    for (const side of header.sides) side.data = payload.subarray(start + side.offset, start + side.offset + side.bytes);
    this.#pictures.set(header.picture, header);
  }

  /** What the page says of itself. */
  data() {
    return this.page.evaluate(() => ({ ...document.documentElement.dataset }));
  }

  view() {
    return this.page.evaluate(() => window.ondine.view());
  }

  /** The last statistics. */
  get stats() {
    return this.history[this.history.length - 1];
  }

  /** The first message of the server. */
  get hello() {
    return this.got.find(({ type }) => type === "hello");
  }

  until(what, condition, patience) {
    return until(what, async () => condition(await this.data()), patience);
  }

  /** Messages that the page sent, but for its receipts of pictures. */
  get asked() {
    return this.sent.filter(({ type }) => type !== "drawn");
  }

  /** Changes something and waits until the server has answered with a view. */
  async change(act) {
    const before = this.asked.length;
    await act();
    return until("the page sends a view and the server answers", () => {
      const ids = this.asked.slice(before).filter(({ type }) => type === "view").map(({ id }) => id);
      const last = ids[ids.length - 1];
      return this.got.find(({ type, id }) => ["view", "refused"].includes(type) && id === last && id !== undefined);
    });
  }

  /** Changes something and waits until a picture of another generation is drawn. */
  async restart(act) {
    const before = Number((await this.data()).generation);
    const answer = await this.change(act);
    await this.until("the image begins anew", ({ generation }) => Number(generation) > before);
    return answer;
  }

  /** Waits until the image has all of its samples, and is drawn like that. */
  done() {
    return until("the image is done", async () => {
      const { limit } = await this.view();
      const { stats, drawn } = this;
      return (
        (await this.data()).state === "done" &&
        stats?.state === "done" &&
        drawn?.generation === stats.generation &&
        drawn.sides.length === stats.sides.length &&
        drawn.sides.every((side) => !side.coarse && side.samples >= limit) &&
        stats.sides.every((side) => side.samples >= limit)
      );
    });
  }

  /** What is on the canvas: a hash of its pixels. */
  shown() {
    return this.page.evaluate(async () => {
      const bytes = new TextEncoder().encode(document.getElementById("picture").toDataURL());
      const hash = await crypto.subtle.digest("SHA-256", bytes);
      return Array.from(new Uint8Array(hash), (byte) => byte.toString(16).padStart(2, "0")).join("");
    });
  }

  /** Stops the render; what is on the canvas stays from here on. */
  async pause() {
    await this.page.click("#pause");
    await this.until("it is paused", ({ state }) => state === "paused");
    let before = "";
    await until("the picture stays", async () => {
      const last = before;
      before = await this.shown();
      await sleep(300);
      return last === before;
    });
  }

  /** Where a pixel of the picture is in the window. */
  async place(x, y) {
    const canvas = this.page.locator("#picture");
    const box = await canvas.boundingBox();
    const [width, height] = await canvas.evaluate((element) => [element.width, element.height]);
    return [box.x + ((x + 0.5) / width) * box.width, box.y + ((y + 0.5) / height) * box.height];
  }

  async clickPixel(x, y, options) {
    const [left, top] = await this.place(x, y);
    await this.page.mouse.click(left, top, options);
  }

  /** Puts a number into a field as people do. */
  async type(id, value) {
    const field = this.page.locator(`#${id}`);
    await field.fill(String(value));
    await field.press("Enter");
    await field.evaluate((element) => element.blur());
  }

  close() {
    return this.page.context().close();
  }
}

/** Half floats of a little-endian buffer. */
export function halves(buffer) {
  return Float64Array.from({ length: buffer.length / 2 }, (_, i) => {
    const bits = buffer.readUInt16LE(2 * i);
    const [exponent, fraction] = [(bits >> 10) & 31, bits & 1023];
    const size = exponent === 0 ? fraction * 2 ** -24 : (1 + fraction / 1024) * 2 ** (exponent - 15);
    return bits & 0x8000 ? -size : size;
  });
}
