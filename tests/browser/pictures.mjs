// What is on the canvas.

import assert from "node:assert/strict";
import { claim } from "./claims.mjs";
import { sleep } from "./program.mjs";

const SMALL = ["cornell", "--size", "96x80"];

/** The greatest difference between the canvas and the program's PNG, in codes; and how many codes differ, of how many. */
function difference(live, tonemap, exposure) {
  return live.page.evaluate(
    async ([tonemap, exposure]) => {
      const answer = await fetch(`image.png?side=0&tonemap=${tonemap}&exposure=${exposure}`);
      const image = await createImageBitmap(await answer.blob());
      const pixels = (/** @type {CanvasImageSource} */ source) => {
        const canvas = new OffscreenCanvas(image.width, image.height);
        const context = canvas.getContext("2d");
        context.drawImage(source, 0, 0);
        return context.getImageData(0, 0, image.width, image.height).data;
      };
      const [png, shown] = [pixels(image), pixels(document.getElementById("picture"))];
      let [most, differ] = [0, 0];
      png.forEach((code, i) => {
        most = Math.max(most, Math.abs(code - shown[i]));
        differ += Number(code !== shown[i]);
      });
      return { most, differ, of: png.length };
    },
    [tonemap, exposure],
  );
}

async function display(live, tonemap, exposure) {
  await live.page.selectOption("#tonemap", tonemap);
  await live.type("exposure-number", exposure);
  await sleep(100); // drawn in the next frame
}

for (const [way, query] of [
  ["WebGL 2", ""],
  ["a plain canvas", "?canvas"],
]) {
  const shown = (name, options, body) => claim(`by ${way}: ${name}`, options, body, { query });

  shown("loads, renders, and draws the scene", SMALL, async (live) => {
    const { page, hello } = live;
    const uses = await page.evaluate(() => document.getElementById("picture").getContext("webgl2") !== null);
    assert.equal(uses, query === "", "how it draws");
    await live.until("samples come", ({ state, samplesA }) => state === "rendering" && Number(samplesA) >= 32);
    assert.equal(hello.scene, "cornell");
    assert.equal(await page.title(), "cornell – Ondine");
    assert.equal(await page.locator("#tonemap option").count(), hello.tonemaps.length);
    assert.deepEqual(
      await page.locator("#material option").evaluateAll((options) => options.map(({ value }) => value)),
      hello.materials.map(({ name }) => name),
    );
    const colors = await page.evaluate(() => {
      const picture = document.getElementById("picture");
      const context = new OffscreenCanvas(picture.width, picture.height).getContext("2d");
      context.drawImage(picture, 0, 0);
      const { data } = context.getImageData(0, 0, picture.width, picture.height);
      return new Set(new Uint32Array(data.buffer)).size;
    });
    assert.ok(colors > 1000, `${colors} colours are no picture of the box`);
    const { picture } = await live.data();
    await live.until("pictures follow", (data) => Number(data.picture) > Number(picture) + 2);
    assert.equal(await page.locator("#message").textContent(), "");
  });

  shown("exposure and curve change the picture at once, and ask for nothing", SMALL, async (live) => {
    const { page } = live;
    await page.focus("#exposure");
    for (let i = 0; i < 5; i++) await page.keyboard.press("ArrowRight");
    await page.selectOption("#tonemap", "reinhard");
    assert.equal(await page.inputValue("#exposure-number"), "0.5");
    assert.deepEqual(live.asked, [], "while it renders");

    await live.pause();
    const { samplesA } = await live.data();
    const seen = [await live.shown()];
    for (const [tonemap, exposure] of [["reinhard", 1], ["aces", 1], ["linear", 1], ["linear", -2]]) {
      await display(live, tonemap, exposure);
      seen.push(await live.shown());
    }
    assert.equal(new Set(seen).size, seen.length, "each looks different");
    await display(live, "reinhard", 0.5);
    assert.equal(await live.shown(), seen[0], "and as before when it is set back");
    await page.focus("#exposure");
    await page.keyboard.press("ArrowRight");
    await sleep(100);
    assert.notEqual(await live.shown(), seen[0], "while the slider moves");
    assert.equal((await live.data()).samplesA, samplesA, "no sample was traced");
    assert.deepEqual(live.asked.map(({ type }) => type), ["pause"]);
  });

  shown("the canvas has the pixels of the program's PNG, to one code", [...SMALL, "--spp", "64"], async (live) => {
    await live.done();
    for (const tonemap of ["linear", "reinhard", "aces"]) {
      for (const exposure of [0, 0.5, -3]) {
        await display(live, tonemap, exposure);
        const { most, differ, of } = await difference(live, tonemap, exposure);
        assert.ok(most <= 1 && differ < 0.03 * of, `${tonemap}, ${exposure} EV: ${differ} of ${of} codes differ, by ${most}`);
      }
    }
  });
}

claim("a pause in the middle of a pass: what is saved is what is shown", ["cornell", "--size", "320x240"], async (live) => {
  await live.until("samples come", ({ samplesA }) => Number(samplesA) >= 16);
  await sleep(500);
  await live.pause();
  await display(live, "aces", 0.5);
  // What is saved is whole passes: these are drawn, too.
  await difference(live, "aces", 0.5);
  await sleep(1000);
  const { most, differ, of } = await difference(live, "aces", 0.5);
  assert.ok(most <= 1, `${differ} of ${of} codes differ, by up to ${most}`);
});

claim("layers show what was recorded, and begin the image anew only to record it", [...SMALL, "--spp", "64"], async (live) => {
  const { page } = live;
  const pictures = new Map();
  const look = async (layer, anew) => {
    const { generation } = await live.data();
    await live.change(() => page.selectOption("#layer", layer));
    await live.until(`${layer} is drawn`, () => live.drawn.layer === layer);
    await live.done();
    assert.equal((await live.data()).generation !== generation, anew, `${layer} begins the image anew`);
    pictures.set(layer, await live.shown());
  };
  await live.done();
  pictures.set("radiance", await live.shown());
  await look("error", false);
  await look("normal", true);
  await look("depth", false);
  await look("albedo", false);
  await look("length:2", true);
  await look("length:3", false);
  assert.equal(new Set(pictures.values()).size, pictures.size, "each layer looks different");
  const radiance = pictures.get("radiance");
  await look("radiance", false);
  assert.equal(pictures.get("radiance"), radiance, "radiance is the same with and without them");
});
