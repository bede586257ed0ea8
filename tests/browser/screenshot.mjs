// The picture of the page in the documentation.

import { openPage } from "./live.mjs";
import { serve, sleep, until } from "./program.mjs";

/** The box by cosine and by uniform directions, side by side, after some seconds. */
export async function takeScreenshot(browser, ondine, path) {
  const server = await serve(ondine, ["cornell", "--size", "512x512", "--strategy", "cosine"]);
  const live = await openPage(browser, server.url, { viewport: { width: 1440, height: 960 }, colorScheme: "light" });
  await live.page.selectOption("#tonemap", "aces");
  await live.restart(() => live.page.check("#split"));
  await live.restart(() => live.page.selectOption("#strategy-b", "uniform"));
  await until("both sides have some samples", () => live.stats.sides.every(({ samples }) => samples >= 256));
  await sleep(1500); // the picture follows
  await live.page.evaluate(() => document.activeElement?.blur());
  await live.page.screenshot({ path });
  await live.close();
  await server.end();
}
