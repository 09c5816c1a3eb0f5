// The connection to one run: its control panel and the data of its views.

import { ViewData } from "/data.js";

const RETRY = 700;

// Address of a web socket of this server, with the key of the page's own address.
export function socketAddress(path) {
  const key = new URLSearchParams(location.search).get("key");
  return `ws://${location.host}${path}${key ? `?key=${encodeURIComponent(key)}` : ""}`;
}

export class Run {
  // Messages of the views that have not been taken.
  #waiting = [];

  constructor(prefix, handlers) {
    this.prefix = prefix;
    this.handlers = handlers;
    this.data = new ViewData();
    this.panel = null;
    this.#control();
    this.#views();
  }

  // Sends a command.
  ask(command) {
    if (this.control?.readyState === WebSocket.OPEN) this.control.send(JSON.stringify(command));
  }

  // Takes the data of the next picture. Browsers deliver messages in bursts: one may wait for the picture after
  // it, so that every refresh of the screen has a new one.
  advance() {
    do {
      const next = this.#waiting.shift();
      if (!next) return;
      this.data.take(next);
      this.taken++;
    } while (this.#waiting.length > 1);
  }

  // Reports that the picture shows all data taken: the server then sends further messages. Returns whether data
  // are waiting.
  drawn() {
    if (this.views?.readyState === WebSocket.OPEN && this.acknowledged !== this.taken) {
      this.acknowledged = this.taken;
      this.views.send(`{"drawn":${this.taken}}`);
    }
    return this.#waiting.length > 0;
  }

  #control() {
    const socket = new WebSocket(socketAddress(`${this.prefix}/control`));
    this.control = socket;
    socket.onopen = () => this.handlers.connected(true);
    socket.onmessage = (event) => {
      for (const [key, value] of Object.entries(JSON.parse(event.data))) {
        if (key === "panel") {
          const before = this.panel;
          this.panel = value;
          this.handlers.panel(value, before);
        } else this.handlers[key]?.(value);
      }
    };
    socket.onclose = () => {
      this.handlers.connected(false);
      if (this.control) setTimeout(() => this.control && this.#control(), RETRY);
    };
  }

  #views() {
    const socket = new WebSocket(socketAddress(`${this.prefix}/views`));
    socket.binaryType = "arraybuffer";
    this.views = socket;
    this.#waiting = [];
    this.taken = 0;
    this.acknowledged = 0;
    socket.onmessage = (event) => {
      this.#waiting.push(event.data);
      this.handlers.data();
    };
    socket.onclose = () => this.views && setTimeout(() => this.views && this.#views(), RETRY);
  }

  close() {
    const sockets = [this.control, this.views];
    this.control = this.views = null;
    for (const socket of sockets) socket.close();
  }
}
