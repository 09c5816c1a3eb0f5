// The sound of the run: the vibration, a loop of its last second, and the tones of its lines.
//
//   player ---+
//   loop -----+--> volume --> limiter --> meter --> loudspeaker
//   tones ----+

import { $, make, setText, short } from "/dom.js";
import { socketAddress } from "/run.js";
import { T } from "/texts.js";

// Length of the loop, s, and its slow-down factors.
const LOOP = 1;
const SLOWER = [1, 2, 4, 8];
// Grains of the loop with kept pitch, s: longer than a period of the lowest tone.
const GRAIN = 0.05;
// Reduction of the limiter that is worth a warning, dB.
const WARNING = -6;
const METER = 100;
const TONES = 6;

export class Sound {
  rate = 48000;
  samples = 0;
  #open = null;
  #opening = false;
  #tones = new Map();

  constructor() {
    $("volume").oninput = () => this.#open?.volume.gain.setTargetAtTime(Number($("volume").value), 0, 0.02);
    $("loop").onclick = () => this.#toggleLoop();
    $("slow").replaceChildren(...SLOWER.map((factor) => new Option(T.slowBy(factor), factor)));
    $("slow").onchange = $("keep-pitch").onchange = () => this.#open?.loop && this.#startLoop();
    $("listen-run").onchange = () => this.#open && this.#connect();
  }

  // The runs that can be heard: paths of their sockets by name.
  setRuns(runs) {
    $("listen-to").hidden = Object.keys(runs).length < 2;
    $("listen-run").replaceChildren(...Object.entries(runs).map(([name, path]) => new Option(name, path)));
    if (this.#open) this.#connect();
  }

  async toggle() {
    if (this.#opening) return;
    if (this.#open) {
      this.mute();
      return;
    }
    this.#opening = true;
    try {
      await this.#listen();
    } finally {
      this.#opening = false;
    }
  }

  mute() {
    const { sockets, context, timer } = this.#open;
    this.#open = null;
    clearInterval(timer);
    for (const socket of sockets) this.#end(socket);
    context.close();
    this.samples = 0;
    this.#tones.clear();
    $("loop").setAttribute("aria-pressed", false);
    this.#show(false);
  }

  #end(socket) {
    socket.onclose = null;
    socket.close();
  }

  #show(on) {
    $("listen").setAttribute("aria-pressed", on);
    setText($("listen"), on ? T.mute : T.listen);
    $("audio").hidden = $("sound").hidden = !on;
    if (on) setText($("audio"), T.waitingForAudio);
  }

  async #listen() {
    const context = new AudioContext({ sampleRate: this.rate });
    await context.audioWorklet.addModule("/listen.js");
    const volume = new GainNode(context, { gain: Number($("volume").value) });
    const limiter = new DynamicsCompressorNode(context, { threshold: -6, knee: 0, ratio: 20, attack: 0.001, release: 0.1 });
    const meter = new AnalyserNode(context, { fftSize: 2048 });
    volume.connect(limiter).connect(meter).connect(context.destination);
    const timer = setInterval(() => this.#measure(), METER);
    this.#open = { context, volume, limiter, meter, timer, sockets: [], kept: new Float32Array(LOOP * this.rate), written: 0 };
    this.#connect();
    this.#show(true);
  }

  // Connects the sound of the chosen run; of both runs, A is left and B is right.
  #connect() {
    const open = this.#open;
    for (const socket of open.sockets) this.#end(socket);
    const paths = ($("listen-run").value || "/sound").split(" ");
    open.sockets = paths.map((path, k) => {
      const player = new AudioWorkletNode(open.context, "player", { outputChannelCount: [1] });
      const pan = new StereoPannerNode(open.context, { pan: paths.length < 2 ? 0 : 2 * k - 1 });
      player.connect(pan).connect(open.volume);
      const socket = new WebSocket(socketAddress(path));
      socket.binaryType = "arraybuffer";
      // The connection to the server is lost.
      socket.onclose = () => this.mute();
      socket.onmessage = (event) => this.#receive(event, player, k === 0);
      return socket;
    });
  }

  #receive({ data }, player, first) {
    const open = this.#open;
    if (typeof data === "string") {
      if (first) this.#describe(JSON.parse(data).audio);
      return;
    }
    const piece = new Float32Array(data);
    if (first) {
      this.samples += piece.length;
      for (const x of piece) open.kept[open.written++ % open.kept.length] = x;
    }
    if (!open.loop) player.port.postMessage(piece, [piece.buffer]);
  }

  #describe({ what, time_stretch: stretch }) {
    const pitch = stretch < 1.02 ? T.truePitch : T.lowered(short(stretch));
    setText($("audio"), T.audio(what, pitch, stretch > 60 ? T.tooLow : ""));
  }

  #measure() {
    const { meter, limiter } = this.#open;
    const samples = new Float32Array(meter.fftSize);
    meter.getFloatTimeDomainData(samples);
    $("level").value = samples.reduce((peak, x) => Math.max(peak, Math.abs(x)), 0);
    setText($("limiter"), limiter.reduction < WARNING ? T.limiterActive : "");
  }

  // ---- the loop of the last second

  #toggleLoop() {
    const open = this.#open;
    if (!open) return;
    if (open.loop) {
      open.loop.stop();
      open.loop = null;
    } else {
      const { kept, written } = open;
      const at = written % kept.length;
      open.looped = written < kept.length ? kept.slice(0, at) : Float32Array.from([...kept.subarray(at), ...kept.subarray(0, at)]);
      if (open.looped.length > 1) this.#startLoop();
    }
    $("loop").setAttribute("aria-pressed", Boolean(open.loop));
  }

  #startLoop() {
    const open = this.#open;
    open.loop?.stop();
    const slower = Number($("slow").value);
    const keep = $("keep-pitch").checked;
    const samples = keep ? stretched(open.looped, slower, Math.round(GRAIN * this.rate)) : open.looped;
    const buffer = new AudioBuffer({ length: samples.length, sampleRate: this.rate });
    buffer.copyToChannel(samples, 0);
    open.loop = new AudioBufferSourceNode(open.context, { buffer, loop: true, playbackRate: keep ? 1 : 1 / slower });
    open.loop.connect(open.volume);
    open.loop.start();
  }

  // ---- the tones of the lines

  // Offers the lines of the present motion; the tones that play follow their lines.
  setLines(lines) {
    if (!this.#open) return;
    const named = lines.slice(0, TONES).map(({ frequency_hz, label }) => ({ frequency: frequency_hz, name: label || `${(1e-3 * frequency_hz).toFixed(2)} kHz` }));
    const names = named.map(({ name }) => name).join();
    for (const { frequency, name } of named) this.#tones.get(name)?.frequency.setTargetAtTime(frequency, 0, 0.05);
    if ($("tones").dataset.names === names) return;
    $("tones").dataset.names = names;
    for (const [name, tone] of this.#tones) {
      if (named.some((line) => line.name === name)) continue;
      tone.stop();
      this.#tones.delete(name);
    }
    $("tones").replaceChildren(
      ...named.map((line) =>
        make("button", { textContent: line.name, "aria-pressed": this.#tones.has(line.name), onclick: (event) => this.#toggleTone(line, event.target) }),
      ),
    );
  }

  #toggleTone({ frequency, name }, button) {
    const { context, volume } = this.#open;
    const playing = this.#tones.get(name);
    if (playing) {
      playing.stop();
      this.#tones.delete(name);
    } else {
      const tone = new OscillatorNode(context, { frequency });
      tone.connect(new GainNode(context, { gain: 0.25 })).connect(volume);
      tone.start();
      this.#tones.set(name, tone);
    }
    button.setAttribute("aria-pressed", !playing);
  }
}

// A sound slowed down at its pitch: overlapping grains, each faded in and out.
function stretched(samples, slower, grain) {
  const out = new Float32Array(samples.length * slower);
  const hop = grain >> 1;
  for (let at = 0; at < out.length; at += hop) {
    const from = Math.floor(at / slower);
    for (let k = 0; k < grain; k++) {
      const fade = 0.5 - 0.5 * Math.cos((2 * Math.PI * k) / grain);
      out[(at + k) % out.length] += fade * samples[(from + k) % samples.length];
    }
  }
  return out;
}
