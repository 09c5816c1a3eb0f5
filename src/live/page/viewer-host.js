// Rerun's web viewer, fed with the recording of the run.

import { socketAddress } from "/run.js";

const RETRY = 700;
const ACKNOWLEDGE_EVERY = 200;
const TIMELINE = "sim_time";

export class ViewerHost {
  #canvas;
  #handle = null;
  #channel = 0;
  #bytes = 0;
  #socket = null;
  #ended = false;

  constructor(canvas) {
    this.#canvas = canvas;
  }

  // Bytes passed to the viewer so far.
  get bytes() {
    return this.#bytes;
  }

  // The viewer's own API, for tests.
  get handle() {
    return this.#handle;
  }

  // Simulated time up to which the viewer has data, s; null without data.
  seen() {
    const recording = this.#handle?.get_active_recording_id();
    const range = recording && this.#handle.get_timeline_time_range(recording, TIMELINE);
    return range ? range.max / 1e9 : null;
  }

  async start() {
    await wasm_bindgen({ module_or_path: "/viewer.wasm" });
    const handle = new wasm_bindgen.WebHandle({
      render_backend: new URLSearchParams(location.search).get("renderer"),
      hide_welcome_screen: true,
      enable_history: false,
      notebook: false,
      persist: false,
      theme: document.documentElement.dataset.theme,
    });
    await handle.start(this.#canvas);
    this.#handle = handle;
    if (this.#ended) handle.destroy();
    else this.#listen();
  }

  // Ends the viewer and its connection.
  stop() {
    this.#ended = true;
    this.#socket?.close();
    this.#handle?.destroy();
  }

  // Each connection uses a new channel, because the server first sends everything that a viewer needs.
  #listen() {
    const id = `live-${++this.#channel}`;
    const socket = new WebSocket(socketAddress("/stream"));
    this.#socket = socket;
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.#handle.open_channel(id, "squeakscope");
      // Enables flow control on the server.
      socket.send(JSON.stringify({ displayed_s: 0 }));
    };
    // The server skips data if the viewer lags behind.
    const acknowledge = setInterval(() => {
      const seen = this.seen();
      if (seen !== null && socket.readyState === WebSocket.OPEN) {
        socket.send(JSON.stringify({ displayed_s: seen }));
      }
    }, ACKNOWLEDGE_EVERY);
    socket.onmessage = (event) => {
      if (this.#handle.has_panicked()) {
        socket.close();
        return;
      }
      this.#bytes += event.data.byteLength;
      this.#handle.send_rrd_to_channel(id, new Uint8Array(event.data));
    };
    socket.onclose = () => {
      clearInterval(acknowledge);
      if (this.#ended) return;
      try {
        this.#handle.close_channel(id);
      } catch {
        // The channel was not open yet.
      }
      setTimeout(() => this.#listen(), RETRY);
    };
  }
}
