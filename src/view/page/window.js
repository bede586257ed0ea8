// @ts-check
// What belongs to the window alone: light or dark, and the help.

import { byId } from "./dom.js";

/** Where the theme is kept, until the window is closed. */
const THEME = "theme";

/** Light or dark as the system says, unless told otherwise. */
export function handleTheme() {
  const select = byId("theme", HTMLSelectElement);
  const set = (/** @type {string} */ theme) => {
    document.documentElement.dataset.theme = theme;
  };
  select.value = stored() ?? "auto";
  set(select.value);
  select.addEventListener("change", () => {
    set(select.value);
    try {
      sessionStorage.setItem(THEME, select.value);
    } catch {
      // Not allowed here: then it holds for this page.
    }
  });
}

function stored() {
  try {
    return sessionStorage.getItem(THEME);
  } catch {
    return null;
  }
}

/** Whether keys are letters of a text here. @param {EventTarget | null} target */
const isText = (target) =>
  target instanceof HTMLTextAreaElement ||
  (target instanceof HTMLInputElement && !["range", "checkbox", "color"].includes(target.type));

/** "?" opens the help. */
export function handleHelp() {
  const help = byId("help", HTMLDialogElement);
  const open = () => {
    if (!help.open) help.showModal();
  };
  byId("help-open", HTMLButtonElement).addEventListener("click", open);
  document.addEventListener("keydown", (event) => {
    if (event.key === "?" && !isText(event.target)) open();
  });
  // A click beside it closes it.
  help.addEventListener("click", (event) => {
    if (event.target === help) help.close();
  });
}
