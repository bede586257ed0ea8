// @ts-check
// What is taken away: images, and the command lines that render them again.

import { byId, create } from "./dom.js";

/**
 * Bytes of a header as they were meant.
 * @param {string | null} text percent-encoded
 */
function decoded(text) {
  try {
    return text === null ? null : decodeURIComponent(text);
  } catch {
    return text;
  }
}

/**
 * The name that an attachment is saved under.
 * @param {string | null} disposition
 * @param {string} otherwise
 */
function fileName(disposition, otherwise) {
  return /filename="([^"]+)"/.exec(disposition ?? "")?.[1] ?? otherwise;
}

/** How long an entry says that it was copied, in milliseconds. */
const NOTICE = 2000;

export class Saving {
  #log = byId("log", HTMLElement);
  #waiting = byId("save-note", HTMLElement);
  #side = byId("save-side", HTMLSelectElement);
  #buttons = ["save-exr", "save-png", "copy-command"].map((id) => byId(id, HTMLButtonElement));

  /**
   * @param {() => {tonemap: string, exposure: number}} display
   * @param {(message: string) => void} fail
   */
  constructor(display, fail) {
    this.display = display;
    this.fail = fail;
    const [exr, png, copy] = this.#buttons;
    exr.addEventListener("click", () => this.#wait("Ends the pass that is under way …", () => this.#save("exr")));
    png.addEventListener("click", () => this.#wait("Ends the pass that is under way …", () => this.#save("png")));
    copy.addEventListener("click", () => this.#wait("Asks for the command line …", () => this.#copy()));
  }

  /** The side that is meant. */
  get #place() {
    return document.documentElement.classList.contains("split") ? this.#side.value : "0";
  }

  /**
   * @param {string} note
   * @param {() => Promise<void>} work
   */
  async #wait(note, work) {
    for (const button of this.#buttons) button.disabled = true;
    this.#waiting.textContent = note;
    try {
      await work();
    } catch (error) {
      // What `fetch` throws says nothing to people.
      this.fail(error instanceof Refusal ? error.message : "The program does not answer.");
    }
    this.#waiting.textContent = "";
    for (const button of this.#buttons) button.disabled = false;
  }

  /** @param {"exr" | "png"} kind */
  async #save(kind) {
    const answer = await ask(kind === "exr" ? `image.exr?side=${this.#place}` : `image.png?${this.#query()}`);
    const name = fileName(answer.headers.get("Content-Disposition"), `ondine.${kind}`);
    const command = decoded(answer.headers.get("Ondine-Command-Line"));
    const url = URL.createObjectURL(await answer.blob());
    create("a", { href: url, download: name }).click();
    // The browser reads it after the click.
    setTimeout(() => URL.revokeObjectURL(url), 60_000);
    this.#enter(`Saved ${name}`, command ?? "");
  }

  async #copy() {
    const answer = await ask(`command?${this.#query()}`);
    const command = (await answer.text()).trimEnd();
    const entry = this.#enter("Command line", command);
    await entry.copy();
  }

  #query() {
    const { tonemap, exposure } = this.display();
    return new URLSearchParams({ side: this.#place, tonemap, exposure: String(exposure) });
  }

  /**
   * Shows a command line, the latest first.
   * @param {string} title
   * @param {string} command
   */
  #enter(title, command) {
    const field = create("textarea", { readonly: "", rows: "3", spellcheck: "false", "aria-label": title });
    field.value = command;
    const button = create("button", { type: "button" }, "Copy");
    const copy = async () => {
      try {
        await navigator.clipboard.writeText(command);
        button.textContent = "Copied";
      } catch {
        // Not allowed here: by hand, then.
        field.focus();
        field.select();
        button.textContent = "Press Ctrl+C";
      }
      setTimeout(() => {
        button.textContent = "Copy";
      }, NOTICE);
    };
    button.addEventListener("click", copy);
    const heading = create("div", { class: "heading" }, create("span", {}, title), ...(command === "" ? [] : [button]));
    this.#log.prepend(create("li", {}, heading, ...(command === "" ? [] : [field])));
    return { copy };
  }
}

/** What the program answers instead, in one line for people. */
class Refusal extends Error {}

/** @param {string} address */
async function ask(address) {
  const answer = await fetch(address);
  if (!answer.ok) throw new Refusal((await answer.text()).trim() || `The program answers ${answer.status}.`);
  return answer;
}
