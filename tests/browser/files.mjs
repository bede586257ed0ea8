// What is saved, and the command lines that render it again.

import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import { mkdtemp, readFile, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { promisify } from "node:util";
import { claim } from "./claims.mjs";
import { until } from "./program.mjs";

const run = promisify(execFile);

/** Clicks a button that saves; gives where the file lies, and the command line that the page says. */
async function save(live, button, folder) {
  const before = await live.page.locator("#log li").count();
  const download = live.page.waitForEvent("download");
  await live.page.click(button);
  const file = await download;
  const path = join(folder, `saved-${file.suggestedFilename()}`);
  await file.saveAs(path);
  await until("the command line is shown", async () => (await live.page.locator("#log li").count()) > before);
  return { path, name: file.suggestedFilename(), command: await live.page.locator("#log textarea").first().inputValue() };
}

/** What an image is, to the last bit: of which scene, with which samples and layers. */
async function facts(ondine, path) {
  const { stdout } = await run(ondine, ["info", "--json", path]);
  const { image_hash, scene_hash, samples, camera, parts } = JSON.parse(stdout);
  return { image_hash, scene_hash, samples, camera, channels: parts[0].channels.map(({ name }) => name) };
}

/** Runs a command line as a shell does, with another program in the place of `ondine`; gives its image. */
async function follow(ondine, command, folder) {
  assert.match(command, /^ondine render cornell /);
  await run("bash", ["-c", `"$0"${command.slice("ondine".length)} --quiet`, ondine], { cwd: folder });
  const output = /--output=(\S+)/.exec(command);
  assert.ok(output, command);
  return join(folder, output[1]);
}

async function inFolder(body) {
  const folder = await mkdtemp(join(tmpdir(), "ondine-browser-"));
  try {
    await body(folder);
  } finally {
    await rm(folder, { recursive: true });
  }
}

const BOX = ["cornell", "--size", "120x100"];

claim("a saved EXR has the bits of ondine render with the copied command line", BOX, (live, _, { ondine }) =>
  inFolder(async (folder) => {
    const { page } = live;
    const seen = new Set();
    const same = async () => {
      const { path, name, command } = await save(live, "#save-exr", folder);
      const saved = await facts(ondine, path);
      assert.match(name, /^cornell-[a-z]+-\d+spp\.exr$/);
      const rendered = await follow(ondine, command, folder);
      assert.equal(rendered, join(folder, name), "the same name");
      assert.deepEqual(await facts(ondine, rendered), saved, command);
      seen.add(JSON.stringify(saved));
      return command;
    };
    await live.until("samples come", ({ samplesA }) => Number(samplesA) >= 16);
    await same();

    await page.focus("#picture");
    await live.restart(() => page.keyboard.press("ArrowLeft"));
    await live.restart(() => page.keyboard.press("Shift+ArrowUp"));
    await live.restart(() => live.type("aperture-radius", 0.0123));
    await same();

    await page.selectOption("#material", "white");
    await live.restart(() => page.selectOption("#material-type", "principled"));
    await live.restart(() => live.type("material-roughness", 0.35));
    assert.match(await same(), /materials\.white/);

    await live.restart(() => page.check("#first-hits"));
    await live.restart(() => page.check("#lengths"));
    assert.match(await same(), /--aov/);

    await live.restart(() => page.check("#split"));
    await live.restart(() => live.type("path-length-a", 4));
    await live.restart(() => page.selectOption("#sampler-b", "pcg"));
    await live.restart(() => live.type("seed-b", "12345678901234567890"));
    await live.restart(() => live.type("roulette-b", 2));
    await live.until("both sides have samples", ({ samplesA, samplesB }) => Number(samplesA) >= 16 && Number(samplesB) >= 16);
    assert.match(await same(), /--strategy=mis/);
    await page.selectOption("#save-side", "1");
    const command = await same();
    assert.match(command, /--strategy=cosine/);
    assert.match(command, /--seed=12345678901234567890/);

    assert.equal(seen.size, 6, "each is another image");

    await live.pause();
    await same();
  }),
);

claim("a saved PNG is one, and its command line renders it", BOX, (live, _, { ondine }) =>
  inFolder(async (folder) => {
    await live.page.selectOption("#tonemap", "aces");
    await live.type("exposure-number", -1.5);
    await live.until("samples come", ({ samplesA }) => Number(samplesA) >= 16);
    const { path, name, command } = await save(live, "#save-png", folder);
    const png = await readFile(path);
    assert.match(name, /^cornell-mis-\d+spp\.png$/);
    assert.equal(png.toString("hex", 0, 8), "89504e470d0a1a0a");
    assert.deepEqual([png.readUInt32BE(16), png.readUInt32BE(20)], [120, 100], "width and height");
    const rendered = (await follow(ondine, command, folder)).replace(/exr$/, "png");
    assert.ok(png.equals(await readFile(rendered)), command);
  }),
);

claim("the command line goes to the clipboard, and is shown", BOX, async (live) => {
  const { page } = live;
  await page.context().grantPermissions(["clipboard-read", "clipboard-write"]);
  await live.until("samples come", ({ samplesA }) => Number(samplesA) >= 16);
  await page.click("#copy-command");
  const shown = page.locator("#log textarea").first();
  await shown.waitFor();
  const command = await shown.inputValue();
  assert.match(command, /^ondine render cornell .*--spp=\d+/);
  await until("it is copied", async () => (await page.evaluate(() => navigator.clipboard.readText())) === command);
});
