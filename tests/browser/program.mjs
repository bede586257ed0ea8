// `ondine view` and the browser that its page is opened in, for tests and measurements.

import { spawn } from "node:child_process";

/** Chromium, where Debian has it. */
export const executable = process.env.CHROMIUM ?? "/usr/bin/chromium";

export const FLAGS = [
  "--no-sandbox", // CI runs as root
  "--disable-gpu",
  "--enable-unsafe-swiftshader", // WebGL without a graphics card
  "--force-color-profile=srgb",
  "--no-first-run",
  "--disable-background-networking",
  "--disable-component-update",
  "--disable-sync",
  "--disable-quic",
];

/** How long anything on the page may take, in milliseconds: much longer than it does, on a busy machine too. */
export const PATIENCE = 60_000;

export const sleep = (milliseconds) => new Promise((resolve) => setTimeout(resolve, milliseconds));

/** Waits until `condition` gives something, and gives that. */
export async function until(what, condition, patience = PATIENCE) {
  const end = performance.now() + patience;
  for (;;) {
    const answer = await condition();
    if (answer) return answer;
    if (performance.now() > end) throw new Error(`it does not come to this: ${what}`);
    await sleep(20);
  }
}

/** Processes that end with this one, however it ends. */
const started = new Set();
process.on("exit", () => started.forEach((child) => child.kill()));
for (const signal of ["SIGINT", "SIGTERM", "SIGHUP"]) process.on(signal, () => process.exit(1));

/** `ondine view` with these arguments, and more in its environment, once its page can be opened. */
export async function serve(ondine, options, environment = {}) {
  const env = { ...process.env, ...environment };
  const child = spawn(ondine, ["view", ...options], { env, stdio: ["ignore", "pipe", "pipe"] });
  let [printed, said] = ["", ""];
  child.stdout.on("data", (data) => (printed += data));
  child.stderr.on("data", (data) => (said += data));
  const ended = new Promise((resolve, reject) => {
    child.on("error", reject);
    child.on("exit", (code, signal) => resolve(code ?? signal));
  });
  started.add(child);
  child.on("exit", () => started.delete(child));
  const early = ended.then((code) => Promise.reject(new Error(`ondine view ends with ${code}: ${said}`)));
  await Promise.race([until("an address is printed", () => printed.includes("\n")), early]);
  early.catch(() => {}); // that it ends is wanted from here on
  return {
    pid: child.pid,
    url: printed.trim(),
    said: () => said,
    /** As Ctrl-C does; gives the exit code. */
    end: () => {
      if (child.exitCode === null) child.kill("SIGINT");
      return ended;
    },
  };
}
