// The live page of `ondine view`, used in Chromium.
//
//     node tests/browser/view.mjs [ONDINE [WORDS]]                   all claims, or those with these words
//     node tests/browser/view.mjs ONDINE --screenshot PICTURE.png    the picture of the page in the documentation
//
// Needs playwright-core (see live.mjs) and Chromium, at $CHROMIUM or where Debian has it.

import { resolve } from "node:path";
import { test } from "node:test";
import { showAll } from "./claims.mjs";
import { openBrowser } from "./live.mjs";
import { takeScreenshot } from "./screenshot.mjs";

await import("./pictures.mjs");
await import("./convergence.mjs");
await import("./camera.mjs");
await import("./materials.mjs");
await import("./files.mjs");
await import("./windows.mjs");

const [, , ondine = "target/release/ondine", words = "", picture] = process.argv;
if (words === "--screenshot") {
  const browser = await openBrowser();
  await takeScreenshot(browser, resolve(ondine), picture);
  await browser.close();
} else {
  test("the live page", async (all) => {
    const browser = await openBrowser();
    try {
      await showAll(all, browser, resolve(ondine), words);
    } finally {
      await browser.close();
    }
  });
}
