// The viewer beside the panel: Rerun's, fed with the run as it comes.

const RETRY = 700;
const TELL_EVERY = 200;
const TIMELINE = "sim_time";

export class ViewerHost {
  #canvas;
  #handle = null;
  #channel = 0;
  #bytes = 0;

  constructor(canvas) {
    this.#canvas = canvas;
  }

  // Bytes that the viewer has been given.
  get bytes() {
    return this.#bytes;
  }

  // The viewer's own interface, for those who look into it.
  get handle() {
    return this.#handle;
  }

  // Simulated time up to which the viewer has the run, s; null before it has any.
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
      theme: "dark",
    });
    await handle.start(this.#canvas);
    this.#handle = handle;
    this.#listen();
  }

  // A channel of its own for each connection: the server begins with all that the viewer needs.
  #listen() {
    const id = `live-${++this.#channel}`;
    const socket = new WebSocket(`ws://${location.host}/stream`);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.#handle.open_channel(id, "squeakscope");
      // From now on the server minds how far the viewer is.
      socket.send(JSON.stringify({ seen: 0 }));
    };
    // The server leaves out what the viewer would only show too late.
    const tell = setInterval(() => {
      const seen = this.seen();
      if (seen !== null && socket.readyState === WebSocket.OPEN) {
        socket.send(JSON.stringify({ seen }));
      }
    }, TELL_EVERY);
    socket.onmessage = (event) => {
      if (this.#handle.has_panicked()) {
        socket.close();
        return;
      }
      this.#bytes += event.data.byteLength;
      this.#handle.send_rrd_to_channel(id, new Uint8Array(event.data));
    };
    socket.onclose = () => {
      clearInterval(tell);
      try {
        this.#handle.close_channel(id);
      } catch {
        // It had not been opened yet.
      }
      setTimeout(() => this.#listen(), RETRY);
    };
  }
}
