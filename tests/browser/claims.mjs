// What is claimed of the live page: each claim has a server and a window of its own, in which nothing may go wrong.

import assert from "node:assert/strict";
import { openPage } from "./live.mjs";
import { serve } from "./program.mjs";

const claims = [];

/**
 * A claim that `body` shows, given the page of `ondine view` with these options. `expected`: what the browser may complain
 * about; `query`: what follows the page's address; `environment`: variables for the program.
 */
export function claim(name, options, body, { query = "", expected = /$^/, environment } = {}) {
  const show = async (browser, ondine) => {
    const server = await serve(ondine, options, environment);
    try {
      const live = await openPage(browser, server.url, { query });
      try {
        await body(live, server, { browser, ondine });
        const complaints = live.complaints.filter((complaint) => !expected.test(complaint));
        assert.deepEqual(complaints, [], "the browser complains");
      } finally {
        await live.close();
      }
    } finally {
      assert.equal(await server.end(), 0, `exit code; it said ${server.said()}`);
    }
  };
  claims.push({ name, show });
}

/** Shows all claims whose name has these words, as tests within `test`. */
export async function showAll(test, browser, ondine, words) {
  for (const { name, show } of claims.filter((claim) => claim.name.includes(words))) {
    await test.test(name, { timeout: 180_000 }, () => show(browser, ondine));
  }
}
