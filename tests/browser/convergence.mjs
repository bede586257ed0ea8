// How the error falls, and two sides against each other.

import assert from "node:assert/strict";
import { claim } from "./claims.mjs";
import { halves } from "./live.mjs";
import { sleep, until } from "./program.mjs";

/** The exponent of a power law through points of a curve, against samples. */
function slope(curve, least) {
  const logs = curve.filter(([, samples]) => samples >= least).map(([, samples, error]) => [Math.log(samples), Math.log(error)]);
  assert.ok(logs.length >= 10, `${logs.length} points`);
  const [mx, my] = [0, 1].map((i) => logs.reduce((sum, log) => sum + log[i], 0) / logs.length);
  const sum = (f) => logs.reduce((sum, [x, y]) => sum + f(x - mx, y - my), 0);
  return sum((x, y) => x * y) / sum((x) => x * x);
}

// Independent samples of matte surfaces under a lamp that every vertex looks at: their spread has a light tail, so that its
// estimate is good at few samples already.
const STEADY = ["cornell", "--size", "64x64", "--sampler", "pcg", "--strategy", "mis", "--path-length", "4"];

claim("the error falls as one over the root of the samples", [...STEADY, "--spp", "2048"], async (live) => {
  await live.done();
  const exponent = slope(live.stats.sides[0].curve, 32);
  assert.ok(Math.abs(exponent + 0.5) < 0.05, `it falls as n^${exponent}`);
  await live.page.selectOption("#against", "samples");
  const told = Number(/n\^(\S+)/.exec(await live.page.textContent("#slopes"))?.[1].replace("−", "-"));
  assert.ok(Math.abs(told + 0.5) < 0.05, `the page says n^${told}`);
  assert.equal(await live.page.locator("#plot path.curve").count(), 1);
});

claim("the error that is told is the one between two seeds", [...STEADY, "--spp", "256"], async (live) => {
  await live.restart(() => live.page.check("#split"));
  await live.change(() => live.page.selectOption("#strategy-b", "mis"));
  await live.change(() => live.type("seed-b", 1));
  await live.done();
  const [a, b] = live.drawn.sides.map(({ data }) => halves(data));
  const mean = a.reduce((sum, x) => sum + x, 0) / a.length;
  const rms = Math.sqrt(a.reduce((sum, x, i) => sum + (x - b[i]) ** 2, 0) / a.length);
  const measured = rms / Math.SQRT2 / mean;
  const { curve } = live.stats.sides[0];
  const [, samples, error] = curve[curve.length - 1];
  assert.equal(Number((await live.data()).errorA), error);
  // The curve may end some samples before the image does.
  const told = error * Math.sqrt(samples / 256);
  assert.ok(Math.abs(measured / told - 1) < 0.1, `told ${told}, measured ${measured}`);
});

/** Cosine at the left, uniform at the right. */
async function compareStrategies(live) {
  const { page } = live;
  await live.restart(() => page.selectOption("#strategy-a", "cosine"));
  await live.restart(() => page.check("#split"));
  await live.restart(() => page.selectOption("#strategy-b", "uniform"));
  assert.deepEqual((await live.view()).sides.map(({ strategy }) => strategy), ["cosine", "uniform"]);
}

const BOX = ["cornell", "--size", "96x96", "--sampler", "pcg"];

claim("split: of equal samples, cosine has less error than uniform", [...BOX, "--spp", "256"], async (live) => {
  const { page } = live;
  await compareStrategies(live);
  assert.equal(await page.inputValue("#balance"), "samples");
  await live.done();
  const [cosine, uniform] = live.stats.sides;
  assert.equal(cosine.samples, uniform.samples);
  const { errorA, errorB } = await live.data();
  assert.equal(Number(errorA), cosine.curve[cosine.curve.length - 1][2]);
  assert.ok(Number(errorA) < 0.95 * Number(errorB), `cosine ${errorA}, uniform ${errorB}`);
  assert.match(await page.textContent("#label-a"), /cosine · pcg · 6/);
  assert.match(await page.textContent("#label-b"), /uniform · pcg · 6/);
  assert.ok((await page.isVisible("#label-a")) && (await page.isVisible("#label-b")));
  assert.equal(await page.locator("#plot path.curve").count(), 2);
  assert.equal(await page.locator("#legend-b").textContent(), "B cosine · pcg · 6".replace("cosine", "uniform"));
});

claim("split: of equal time, sides that need unequal time have unequal samples", BOX, async (live) => {
  await compareStrategies(live);
  await live.restart(() => live.type("path-length-b", 30));
  const { generation } = await live.data();
  await live.change(() => live.page.selectOption("#balance", "time"));
  // They differ by a round at most, however long that takes on a busy machine.
  await until("neither side has a fifth more than the other, nor less than a second", () => {
    const [a, b] = live.stats.sides.map(({ seconds }) => seconds);
    return Math.min(a, b) > 1 && Math.max(a, b) < 1.2 * Math.min(a, b);
  });
  const [a, b] = live.stats.sides.map(({ samples }) => samples);
  assert.ok(b < 0.7 * a, `${a} samples of short paths, and ${b} of long ones`);
  assert.equal((await live.data()).generation, generation, "nothing begins anew");
});

claim("split: the divider moves by pointer and by keys, and shows one side or the other", [...BOX, "--spp", "16"], async (live) => {
  const { page } = live;
  await compareStrategies(live);
  await live.done();
  const asked = live.asked.length;
  const divider = page.locator("#divider");
  const at = async () => Number(await divider.getAttribute("aria-valuenow"));
  assert.equal(await at(), 50);
  const both = await live.shown();
  await divider.focus();
  await page.keyboard.press("ArrowRight");
  assert.equal(await at(), 51);
  await page.keyboard.press("Shift+ArrowLeft");
  assert.equal(await at(), 41);
  await page.keyboard.press("End");
  assert.equal(await at(), 100);
  await sleep(100);
  const cosine = await live.shown();
  await page.keyboard.press("Home");
  assert.equal(await at(), 0);
  await sleep(100);
  const uniform = await live.shown();
  assert.equal(new Set([both, cosine, uniform]).size, 3, "each looks different");
  await page.keyboard.press("PageUp");

  const picture = await page.locator("#picture").boundingBox();
  const box = await divider.boundingBox();
  const middle = picture.y + picture.height / 2;
  await page.mouse.move(box.x + box.width / 2, middle);
  await page.mouse.down();
  await page.mouse.move(picture.x + 0.75 * picture.width, middle, { steps: 4 });
  await page.mouse.up();
  assert.ok(Math.abs((await at()) - 75) <= 1, `it is at ${await at()} %`);
  await divider.dblclick();
  assert.equal(await at(), 50);
  await sleep(100);
  assert.equal(await live.shown(), both, "the same as at first");
  assert.equal(live.asked.length, asked, "nothing was asked for");

  await live.restart(() => page.uncheck("#split"));
  assert.ok(!(await divider.isVisible()) && !(await page.isVisible("#label-b")));
});
