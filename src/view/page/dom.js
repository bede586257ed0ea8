// @ts-check
// What every part of the page needs.

/**
 * The element of this id, which the page has.
 * @template {typeof Element} T
 * @param {string} id
 * @param {T} type
 * @returns {InstanceType<T>}
 */
export function byId(id, type) {
  const element = document.getElementById(id);
  if (!(element instanceof type)) throw new Error(`the page has no ${type.name} "${id}"`);
  return /** @type {InstanceType<T>} */ (element);
}

/**
 * A new element with attributes and children.
 * @template {keyof HTMLElementTagNameMap} K
 * @param {K} tag
 * @param {Record<string, string>} [attributes]
 * @param {(Node | string)[]} children
 * @returns {HTMLElementTagNameMap[K]}
 */
export function create(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

/**
 * Fills a list to choose from.
 * @param {HTMLSelectElement} select
 * @param {string[]} values
 * @param {(value: string) => string} [label]
 */
export function setOptions(select, values, label = (value) => value) {
  const { options } = select;
  if (options.length === values.length && values.every((value, i) => options[i].value === value)) return;
  const chosen = select.value;
  select.replaceChildren(...values.map((value) => new Option(label(value), value)));
  if (values.includes(chosen)) select.value = chosen;
}

/**
 * Puts a value into a field, unless somebody is writing there.
 * @param {HTMLInputElement} field
 * @param {string} value
 * @param {boolean} [forced]
 */
export function setField(field, value, forced = false) {
  if (forced || field !== document.activeElement) field.value = value;
}

/**
 * Calls back before the next frame is shown, or soon where none is: pages in the background get no frames.
 * @param {() => void} callback
 */
export function nextFrame(callback) {
  let done = false;
  const once = () => {
    if (done) return;
    done = true;
    cancelAnimationFrame(frame);
    clearTimeout(timer);
    callback();
  };
  const frame = requestAnimationFrame(once);
  const timer = setTimeout(once, document.hidden ? 0 : 200);
}
