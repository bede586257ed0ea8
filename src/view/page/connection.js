// @ts-check
// The socket: opened again when it breaks, for as long as the program may be there.

import { decodePicture, parse, serialise } from "./protocol.js";

/** @typedef {import("./protocol.js").FromServer} FromServer */
/** @typedef {import("./protocol.js").Picture} Picture */
/** @typedef {import("./protocol.js").ToServer} ToServer */

/** Milliseconds before each further try: some ten seconds together. */
const WAITS = [250, 500, 1000, 2000, 3000, 4000];

/** What a program says that closes the socket over a message it does not understand. */
const POLICY_VIOLATION = 1008;

/**
 * @typedef {{message(message: FromServer): void, picture(picture: Picture): void,
 *   lost(text: string, ended: boolean): void}} Listener
 */

export class Connection {
  /** @type {WebSocket | null} */
  #socket = null;
  #tries = 0;
  #timer = 0;

  /** @param {Listener} listener */
  constructor(listener) {
    this.listener = listener;
    this.#open();
  }

  /** Whether what is sent now arrives. */
  get isOpen() {
    return this.#socket?.readyState === WebSocket.OPEN;
  }

  /**
   * Sends it, or drops it where nobody listens: what a page wants is said anew when there is somebody again.
   * @param {ToServer} message
   */
  send(message) {
    if (this.isOpen) this.#socket?.send(serialise(message));
  }

  /** Tries anew, however often it failed. */
  retry() {
    clearTimeout(this.#timer);
    this.#tries = 0;
    if (this.#socket === null) this.#open();
  }

  #open() {
    const socket = new WebSocket(new URL("events", location.href).href.replace(/^http/, "ws"));
    this.#socket = socket;
    socket.binaryType = "arraybuffer";
    socket.onmessage = (event) => this.#receive(socket, event.data);
    socket.onclose = (event) => this.#closed(event);
  }

  /**
   * @param {WebSocket} socket
   * @param {string | ArrayBuffer} data
   */
  #receive(socket, data) {
    this.#tries = 0;
    /** @type {() => void} */
    let deliver;
    try {
      if (typeof data === "string") {
        const message = parse(data);
        deliver = () => this.listener.message(message);
      } else {
        const picture = decodePicture(data);
        deliver = () => this.listener.picture(picture);
      }
    } catch {
      // Not of this program, or of another version of it.
      socket.onclose = null;
      socket.close();
      this.#socket = null;
      this.listener.lost("The program says what this page does not understand. Load the page again.", true);
      return;
    }
    deliver();
  }

  /** @param {CloseEvent} event */
  #closed(event) {
    this.#socket = null;
    if (event.code === POLICY_VIOLATION) {
      this.listener.lost(`The program closed the connection: ${event.reason || "it did not understand this page"}.`, true);
    } else if (this.#tries < WAITS.length) {
      this.listener.lost("Connection lost; trying again", false);
      this.#timer = setTimeout(() => this.#open(), WAITS[this.#tries]);
      this.#tries += 1;
    } else {
      this.listener.lost("The program has ended", true);
    }
  }
}
