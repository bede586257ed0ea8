// The program and its windows: what they share, how they end, and whether everybody can use them.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { claim } from "./claims.mjs";
import { openPage } from "./live.mjs";
import { sleep, until } from "./program.mjs";

/** Clock ticks of the processor that a process has used. */
async function ticks(pid) {
  const fields = (await readFile(`/proc/${pid}/stat`, "utf8")).replace(/^.*\) /, "").split(" ");
  return Number(fields[11]) + Number(fields[12]);
}

/** Memory that a process has, in KiB. */
async function memory(pid) {
  return Number(/^VmRSS:\s*(\d+)/m.exec(await readFile(`/proc/${pid}/status`, "utf8"))[1]);
}

/** Waits until a process rests: no more than a fiftieth of a processor. */
function rests(pid) {
  return until("the program rests", async () => {
    const before = await ticks(pid);
    await sleep(500);
    return (await ticks(pid)) - before <= 1;
  });
}

// What is freed is to be seen as such: otherwise the C library may keep it for later.
const RETURNED = { environment: { MALLOC_MMAP_THRESHOLD_: "131072" } };

claim(
  "without a page nothing is rendered, and no image is kept",
  ["cornell", "--size", "512x512"],
  async (live, server, { browser }) => {
    const other = await openPage(browser, server.url);
    await live.until("samples come", ({ samplesA }) => Number(samplesA) >= 16);
    const open = await memory(server.pid);
    await other.close();
    const { samplesA } = await live.data();
    await live.until("the render goes on for the page that is left", (data) => Number(data.samplesA) > Number(samplesA));
    const view = await live.view();
    await live.page.goto("about:blank");
    await rests(server.pid);
    const left = await memory(server.pid);
    // An image has 100 bytes a pixel: sums and sums of squares of 128 bits, and a count.
    assert.ok(open - left > 0.9 * 25_600, `of ${open} KiB ${left} are left`);
    const again = await openPage(browser, server.url);
    await again.until("samples come again", (data) => Number(data.samplesA) >= 16);
    assert.deepEqual(await again.view(), view);
    assert.deepEqual(again.complaints, []);
    await again.pause();
    await rests(server.pid);
    await again.close();
  },
  RETURNED,
);

claim("two pages show one view; exposure is each page's own", ["cornell", "--size", "96x96"], async (live, server, { browser }) => {
  const other = await openPage(browser, server.url);
  const agree = () =>
    until("both show the same view", async () => JSON.stringify(await live.view()) === JSON.stringify(await other.view()));
  await live.page.selectOption("#material", "white");
  await live.restart(() => live.page.selectOption("#material-type", "mirror"));
  await until("the other page has it", async () => (await other.view()).materials.white?.type === "mirror");
  await agree();
  await other.page.focus("#picture");
  await other.restart(() => other.page.keyboard.press("ArrowLeft"));
  await agree();
  await live.page.click("#pause");
  await other.until("the other is paused, too", ({ state }) => state === "paused");
  assert.equal(await other.page.textContent("#pause"), "Resume");
  await live.type("exposure-number", 2);
  assert.equal(await other.page.inputValue("#exposure-number"), "0");
  assert.deepEqual(other.complaints, []);
  await other.close();
});

/** Where Tab goes, from the page's beginning until it is left: names of the elements, and which show no focus. */
async function tabs(page) {
  await page.evaluate(() => {
    document.body.tabIndex = -1;
    document.body.focus();
    document.body.removeAttribute("tabindex");
  });
  const [names, dim] = [[], []];
  for (;;) {
    await page.keyboard.press("Tab");
    const at = await page.evaluate(() => {
      const element = document.activeElement;
      if (element === null || element === document.body) return null;
      const style = getComputedStyle(element);
      const outlined = style.outlineStyle !== "none" && Number.parseFloat(style.outlineWidth) >= 1;
      return { name: window.nameOf(element), seen: outlined || style.boxShadow !== "none" };
    });
    if (at === null || at.name === names[0]) break;
    names.push(at.name);
    if (!at.seen) dim.push(at.name);
    assert.ok(names.length < 200, "Tab never leaves the page");
  }
  return { names, dim };
}

/** All that can be used, in the page's order. */
function controls(page) {
  return page.evaluate(() => {
    window.nameOf = (element) =>
      element.id || `${element.tagName.toLowerCase()} ${element.getAttribute("aria-label") ?? element.textContent.trim()}`;
    const all = document.querySelectorAll("a[href], button, input, select, textarea, summary, [tabindex='0']");
    return [...all].filter((element) => !element.disabled && element.checkVisibility({ visibilityProperty: true })).map(window.nameOf);
  });
}

/** Texts that are hard to read before what is behind them: less than 4.5 to 1 (WCAG 2.2, 1.4.3). */
function faint(page) {
  return page.evaluate(() => {
    const context = new OffscreenCanvas(1, 1).getContext("2d", { willReadFrequently: true });
    const rgba = (color) => {
      context.clearRect(0, 0, 1, 1);
      context.fillStyle = color;
      context.fillRect(0, 0, 1, 1);
      return context.getImageData(0, 0, 1, 1).data;
    };
    const luminance = (color) => {
      const [r, g, b] = Array.from(color, (code) => {
        const x = code / 255;
        return x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4;
      });
      return 0.2126 * r + 0.7152 * g + 0.0722 * b;
    };
    const over = ([r, g, b, a], below) => [r, g, b].map((code, i) => below[i] + (a / 255) * (code - below[i]));
    const behind = (element) => {
      if (element === null) return rgba("Canvas");
      const color = rgba(getComputedStyle(element).backgroundColor);
      return color[3] === 255 ? [...color] : over(color, behind(element.parentElement));
    };
    const found = new Set();
    for (const element of document.querySelectorAll("body *")) {
      const own = [...element.childNodes].filter((node) => node.nodeType === Node.TEXT_NODE).map((node) => node.data.trim()).join("");
      if (own === "" || element.matches(":disabled, :disabled *, option, canvas") || !element.checkVisibility()) continue;
      const style = getComputedStyle(element);
      const ink = element instanceof SVGElement ? style.fill : style.color;
      const [a, b] = [luminance(rgba(ink)), luminance(behind(element))].sort((a, b) => b - a);
      const contrast = (a + 0.05) / (b + 0.05);
      if (contrast < 4.5) found.add(`${element.id || element.className || element.tagName}: "${own.slice(0, 30)}" ${contrast.toFixed(2)}`);
    }
    return [...found];
  });
}

claim("by keys alone: Tab reaches every control in order, and shows where it is; light and dark can be read", ["cornell", "--size", "96x96"], async (live) => {
  const { page } = live;
  await live.restart(() => page.check("#split"));
  await live.until("samples come", ({ samplesB }) => Number(samplesB) >= 16);
  const inks = new Set();
  for (const colorScheme of ["light", "dark"]) {
    await page.emulateMedia({ colorScheme });
    await sleep(300); // what is in motion comes to rest
    inks.add(await page.evaluate(() => getComputedStyle(document.body).color));
    assert.deepEqual(await faint(page), [], `hard to read, ${colorScheme}`);
    const all = await controls(page);
    const { names, dim } = await tabs(page);
    assert.deepEqual(names, all, `the order of Tab, ${colorScheme}`);
    assert.deepEqual(dim, [], `no focus to be seen, ${colorScheme}`);
  }
  assert.equal(inks.size, 2, "light and dark are two");
  await page.keyboard.press("?");
  assert.ok(await page.isVisible("#help"));
  await page.keyboard.press("Escape");
  assert.ok(!(await page.isVisible("#help")));
  const named = await page.evaluate(() =>
    [...document.querySelectorAll("button, input, select, textarea")]
      .filter((element) => !element.labels?.length && !element.getAttribute("aria-label") && !element.textContent.trim())
      .map((element) => element.id || element.outerHTML),
  );
  assert.deepEqual(named, [], "without a name");
});

claim("a narrow window: nothing is wider than it", ["cornell", "--size", "512x512"], async (live) => {
  const { page } = live;
  for (const width of [1000, 600, 360]) {
    await page.setViewportSize({ width, height: 800 });
    await sleep(200);
    const wide = await page.evaluate(() => document.documentElement.scrollWidth);
    assert.ok(wide <= width, `at ${width} pixels the page is ${wide} wide`);
    const [box, size] = [await page.locator("#picture").boundingBox(), (await live.view()).size];
    assert.ok(Math.abs(box.width / box.height - size[0] / size[1]) < 0.02, "the picture is not distorted");
  }
});

claim("twenty moves of the camera: each is followed by a picture", ["cornell", "--size", "512x512"], async (live) => {
  const { page } = live;
  await live.until("samples come", ({ samplesA }) => Number(samplesA) >= 16);
  await page.focus("#picture");
  const latencies = [];
  for (let i = 0; i < 20; i++) {
    await page.evaluate(() => delete document.documentElement.dataset.latencyMs);
    await live.restart(() => page.keyboard.press(i % 10 < 5 ? "ArrowRight" : "ArrowLeft"));
    const { latencyMs } = await live.data();
    assert.ok(Number(latencyMs) > 0, `the page does not say how long move ${i + 1} took`);
    latencies.push(Number(latencyMs));
  }
  latencies.sort((a, b) => a - b);
  console.log(`first picture after a move: median ${latencies[10]} ms, worst ${latencies[19]} ms (speed is measured by tools/measure_view.mjs)`);
});

claim(
  "the program ends with a page open: exit code 0, and the page says so",
  ["cornell", "--size", "96x96"],
  async (live, server) => {
    const begin = performance.now();
    assert.equal(await server.end(), 0);
    assert.ok(performance.now() - begin < 10_000, "soon");
    await live.until("the page knows", ({ state }) => state === "lost");
    assert.match(await live.page.textContent("#status"), /trying again/);
    await until("it says so", async () => (await live.page.textContent("#status")) === "The program has ended");
    assert.ok(await live.page.isVisible("#retry"));
  },
  { expected: /^error: WebSocket connection to .* failed/ },
);
