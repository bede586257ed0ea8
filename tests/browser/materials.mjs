// Materials, and what else can be set.

import assert from "node:assert/strict";
import { claim } from "./claims.mjs";
import { until } from "./program.mjs";

// So few samples that each image is done soon: the same settings then give the same picture.
const BOX = ["cornell", "--size", "96x96", "--spp", "16"];

claim("materials: another type, roughness or colour is another picture, and it comes back", BOX, async (live) => {
  const { page } = live;
  await live.done();
  const first = await live.shown();
  const seen = new Map([["as in the scene", first]]);
  const look = async (name, act) => {
    await live.restart(act);
    await live.done();
    const picture = await live.shown();
    for (const [other, before] of seen) assert.notEqual(picture, before, `${name} looks like ${other}`);
    seen.set(name, picture);
    assert.equal(await page.textContent("#message"), "");
  };
  await page.selectOption("#material", "blue");
  for (const type of ["mirror", "glass", "phong", "principled", "conductor"]) {
    await look(type, () => page.selectOption("#material-type", type));
    assert.equal((await live.view()).materials.blue.type, type);
  }
  await look("a rough conductor", () => live.type("material-roughness", 0.7));
  await look("a red conductor", () => page.fill("#material-reflectance", "#c02010"));
  assert.deepEqual(Object.keys((await live.view()).materials), ["blue"]);
  await live.restart(() => page.click("#material-restore"));
  await live.done();
  assert.deepEqual((await live.view()).materials, {});
  assert.equal(await live.shown(), first, "the picture of the scene");
  assert.ok(await page.isDisabled("#material-restore"));
});

claim("what cannot be is said, and the old view stays", BOX, async (live) => {
  const { page } = live;
  await live.done();
  const before = await live.view();
  const picture = await live.shown();
  const answer = await live.change(() => live.type("vertical-fov", 200));
  assert.equal(answer.type, "refused");
  await until("it is said", async () => /vertical_fov must be above 0 and below 180/.test(await page.textContent("#message")));
  await until("the old view is there", async () => JSON.stringify(await live.view()) === JSON.stringify(before));
  assert.equal(Number(await page.inputValue("#vertical-fov")), before.lens.vertical_fov);
  assert.equal(await live.shown(), picture);
});

claim("each setting of a side, size and limit", [...BOX, "--seed", "18446744073709551615"], async (live) => {
  const { page } = live;
  await live.done();
  assert.equal(await page.inputValue("#seed-a"), "18446744073709551615");
  const seen = [await live.shown()];
  const look = async (act) => {
    await live.restart(act);
    await live.done();
    seen.push(await live.shown());
  };
  await look(() => live.type("seed-a", 7));
  await look(() => page.selectOption("#strategy-a", "light"));
  await look(() => page.selectOption("#sampler-a", "pcg"));
  await look(() => live.type("path-length-a", 2));
  await look(() => live.type("path-length-a", 20));
  await look(() => live.type("roulette-a", 3));
  await look(() => live.type("width", 120));
  assert.equal(new Set(seen).size, seen.length, "each looks different");
  const { generation } = await live.data();
  await live.change(() => live.type("limit", 48));
  await live.done();
  assert.equal((await live.data()).generation, generation, "a limit begins nothing anew");
  assert.equal((await live.data()).samplesA, "48");
  await look(() => page.click('#sizes [value="256x256"]'));
  assert.deepEqual(await page.locator("#picture").evaluate(({ width, height }) => [width, height]), [256, 256]);
  await live.restart(() => page.click("#reset"));
  await live.done();
  assert.equal(await live.shown(), seen[0], "Reset brings the first picture back");
});
