// The camera, by pointer and by keys.

import assert from "node:assert/strict";
import { claim } from "./claims.mjs";
import { sleep, until } from "./program.mjs";

const SIDE = 256;
const BOX = ["cornell", "--size", `${SIDE}x${SIDE}`];

const subtract = (a, b) => a.map((x, i) => x - b[i]);
const norm = (a) => Math.hypot(...a);
const distance = (lens) => norm(subtract(lens.position, lens.look_at));
const near = (a, b, tolerance) => Math.abs(a - b) <= tolerance * Math.abs(b);

/** Drags from the middle of the picture. */
async function drag(live, right, down, { button = "left", key } = {}) {
  const { mouse, keyboard } = live.page;
  const [x, y] = await live.place(SIDE / 2, SIDE / 2);
  if (key) await keyboard.down(key);
  await mouse.move(x, y);
  await mouse.down({ button });
  await mouse.move(x + right, y + down, { steps: 5 });
  await mouse.up({ button });
  if (key) await keyboard.up(key);
}

/** Does something to the camera; gives the lens before and after. The image must begin anew. */
async function moved(live, act) {
  const before = (await live.view()).lens;
  const { generation } = live.stats;
  const { samples } = live.stats.sides[0];
  await live.restart(act);
  await until("the server has the view that the page shows", async () => {
    const told = live.got.filter(({ type }) => type === "view");
    return JSON.stringify(told[told.length - 1].view.lens) === JSON.stringify((await live.view()).lens);
  });
  await until("new statistics", () => live.stats.generation > generation);
  const first = live.history.find((stats) => stats.generation > generation).sides[0].samples;
  assert.ok(first < samples, `after ${samples} samples it goes on with ${first}`);
  await live.until("some samples more", ({ samplesA }) => Number(samplesA) >= 16);
  return [before, (await live.view()).lens];
}

async function orbits(live, act) {
  const [before, after] = await moved(live, act);
  assert.ok(norm(subtract(before.position, after.position)) > 0.01, "the camera is elsewhere");
  assert.deepEqual(after.look_at, before.look_at);
  assert.ok(near(distance(after), distance(before), 1e-5), "as far away as before");
  return subtract(after.position, before.position);
}

async function pans(live, act) {
  const [before, after] = await moved(live, act);
  const [camera, target] = ["position", "look_at"].map((key) => subtract(after[key], before[key]));
  assert.ok(norm(camera) > 0.01 && norm(subtract(camera, target)) < 1e-4, "camera and target go together");
  return camera;
}

async function dollies(live, act) {
  const [before, after] = await moved(live, act);
  assert.deepEqual(after.look_at, before.look_at);
  const factor = distance(after) / distance(before);
  const arms = [before, after].map((lens) => subtract(lens.position, lens.look_at).map((x) => x / distance(lens)));
  assert.ok(norm(subtract(...arms)) < 1e-4, "along the line of sight");
  return factor;
}

claim("the camera orbits, pans and goes nearer by pointer, and the image begins anew", BOX, async (live) => {
  await live.until("samples come", ({ samplesA }) => Number(samplesA) >= 16);
  // What is in the picture follows the pointer.
  assert.ok((await orbits(live, () => drag(live, 60, 0)))[0] < 0, "to the left");
  assert.ok((await orbits(live, () => drag(live, 0, 40)))[1] > 0, "up");
  assert.ok((await pans(live, () => drag(live, 0, -40, { key: "Shift" })))[1] < 0, "down");
  await pans(live, () => drag(live, 30, 10, { button: "right" }));
  await pans(live, () => drag(live, -30, 10, { button: "middle" }));
  const [x, y] = await live.place(SIDE / 2, SIDE / 2);
  await live.page.mouse.move(x, y);
  assert.ok((await dollies(live, () => live.page.mouse.wheel(0, -100))) < 1, "nearer");
  assert.ok((await dollies(live, () => live.page.mouse.wheel(0, 100))) > 1, "away");
  assert.match(await live.page.textContent("#latency"), /first picture after \d+ ms/);
});

claim("the camera orbits, pans and goes nearer by keys; R resets it, space pauses", BOX, async (live) => {
  const { page } = live;
  await live.until("samples come", ({ samplesA }) => Number(samplesA) >= 16);
  const start = await live.view();
  await page.focus("#picture");
  const press = (key) => () => page.keyboard.press(key);
  assert.ok((await orbits(live, press("ArrowRight")))[0] > 0);
  assert.ok((await orbits(live, press("ArrowUp")))[1] > 0);
  assert.ok((await pans(live, press("Shift+ArrowRight")))[0] > 0);
  assert.ok(near(await dollies(live, press("+")), 0.9, 1e-3));
  assert.ok(near(await dollies(live, press("-")), 1 / 0.9, 1e-3));
  await moved(live, press("r"));
  assert.deepEqual(await live.view(), start);
  await page.keyboard.press(" ");
  await live.until("it is paused", ({ state }) => state === "paused");
  await page.keyboard.press(" ");
  await live.until("it goes on", ({ state }) => state === "rendering");
});

claim("many moves in one drag: no queue builds up, and the last one holds", BOX, async (live) => {
  await live.until("samples come", ({ samplesA }) => Number(samplesA) >= 16);
  const { mouse } = live.page;
  const [x, y] = await live.place(SIDE / 2, SIDE / 2);
  await mouse.move(x, y);
  await mouse.down();
  for (let i = 1; i <= 60; i++) await mouse.move(x + 2 * (i % 30), y + i);
  await mouse.up();
  await sleep(500);
  const sent = live.asked.filter(({ type }) => type === "view");
  const told = live.got.filter(({ type, id }) => type === "view" && id !== null);
  assert.ok(sent.length < 60, `${sent.length} views for 60 moves`);
  assert.equal(told.length, sent.length, "each is answered");
  assert.deepEqual(told[told.length - 1].view.lens, (await live.view()).lens, "page and program agree");
});

// Camera at z = 2.95, looking along −z; the back wall is at z = −1; the blue sphere at (0.42, −0.7, 0.25), of radius 0.3.
const WALL = { pixel: [SIDE / 2, Math.round(SIDE * 0.4)], depth: 3.95 };
const toSphere = [0.42, -0.7, 0.25 - 2.95];
const half = Math.tan((25 * Math.PI) / 180);
const onScreen = (x) => Math.floor(SIDE * (0.5 + (0.5 * x) / -toSphere[2] / half));
const SPHERE = {
  pixel: [onScreen(toSphere[0]), onScreen(-toSphere[1])],
  depth: (-toSphere[2] * (norm(toSphere) - 0.3)) / norm(toSphere),
};

claim("a click with the focus tool focuses on what is there", BOX, async (live) => {
  const { page } = live;
  const focus = async () => (await live.view()).lens.focus_distance;
  for (const { pixel, depth } of [WALL, SPHERE]) {
    await page.click("#focus");
    await live.restart(() => live.clickPixel(...pixel));
    assert.ok(near(await focus(), depth, 1e-3), `${await focus()} is not ${depth}`);
    assert.equal(await page.getAttribute("#focus", "aria-pressed"), "false");
    assert.match(await page.textContent("#notice"), /Focus distance .*pinhole/);
  }
  // By keys: the centre, as long as the pointer is elsewhere.
  await page.mouse.move(5, 5);
  await page.focus("#picture");
  await live.restart(() => page.keyboard.press("f"));
  assert.ok(near(await focus(), WALL.depth, 1e-3));
  assert.ok(near(Number(await page.inputValue("#focus-distance")), WALL.depth, 1e-3), "the field says it too");
});

claim("a double click looks at what is there, a click edits its material", BOX, async (live) => {
  const { page } = live;
  const before = (await live.view()).lens;
  await live.clickPixel(...SPHERE.pixel);
  await until("the sphere's material is edited", async () => (await page.inputValue("#material")) === "blue");
  await live.restart(() => live.clickPixel(...SPHERE.pixel, { clickCount: 2, delay: 20 }));
  const after = (await live.view()).lens;
  assert.deepEqual(after.position, before.position);
  assert.ok(near(norm(subtract(after.look_at, [0.42, -0.7, 0.25])), 0.3, 1e-3), "a point of the sphere");
});

claim("the lens has fields: field of view, aperture, focus", [...BOX, "--spp", "16"], async (live) => {
  const { page } = live;
  await live.done();
  const seen = [await live.shown()];
  for (const [id, key, value] of [
    ["vertical-fov", "vertical_fov", 40],
    ["aperture-radius", "aperture_radius", 0.1],
    ["focus-distance", "focus_distance", 2],
  ]) {
    await live.restart(() => live.type(id, value));
    assert.equal((await live.view()).lens[key], value);
    await live.done();
    seen.push(await live.shown());
  }
  const slider = page.locator("#lens input[type=range]").first();
  await slider.focus();
  await live.restart(() => page.keyboard.press("ArrowRight"));
  assert.ok((await live.view()).lens.vertical_fov > 40);
  assert.equal(new Set(seen).size, seen.length, "each looks different");
});
