// The sound of the run: the vibration, its last moment at true pitch, a loop of its last second, and the tones of its
// lines.
//
//   player ---+
//   moment ---+
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
// The last moment at true pitch: its longest and shortest length, s, the time over which its end passes into its start,
// s, and the time after which a newer one takes its place, ms.
const MOMENT = [0.08, 0.01];
const SEAM = 0.004;
const RENEWED = 400;
// Playback slower than this is heard as moments at true pitch, unless it shall not be.
const SLOW = 1.02;
const TONES = 6;

export class Sound {
  rate = 48000;
  samples = 0;
  #open = null;
  #opening = false;
  #tones = new Map();
  #data;

  // `data` returns the data of the views of a run by the path of its sound.
  constructor(data) {
    this.#data = data;
    $("pitch").onchange = () => this.#open && this.#repeat();
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
    const { sockets, context, timers } = this.#open;
    this.#open = null;
    timers.forEach(clearInterval);
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
    const timers = [setInterval(() => this.#measure(), METER), setInterval(() => this.#repeat(), RENEWED)];
    this.#open = { context, volume, limiter, meter, timers, stretch: 1, moments: [], sockets: [], kept: new Float32Array(LOOP * this.rate), written: 0 };
    this.#connect();
    this.#show(true);
  }

  // Connects the sound of the chosen run; of both runs, A is left and B is right.
  #connect() {
    const open = this.#open;
    for (const socket of open.sockets) this.#end(socket);
    const paths = this.#paths;
    open.sockets = paths.map((path, k) => {
      const player = new AudioWorkletNode(open.context, "player", { outputChannelCount: [1] });
      const pan = new StereoPannerNode(open.context, { pan: side(k, paths) });
      player.connect(pan).connect(open.volume);
      const socket = new WebSocket(socketAddress(path));
      socket.binaryType = "arraybuffer";
      // The connection to the server is lost.
      socket.onclose = () => this.mute();
      socket.onmessage = (event) => this.#receive(event, player, k === 0);
      return socket;
    });
  }

  get #paths() {
    return ($("listen-run").value || "/sound").split(" ");
  }

  // Whether moments are heard in place of the slow sound.
  get #isTrue() {
    return this.#open.stretch > SLOW && $("pitch").value === "true";
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
    if (!open.loop && !this.#isTrue) player.port.postMessage(piece, [piece.buffer]);
  }

  #describe({ what, time_stretch: stretch }) {
    Object.assign(this.#open, { what, stretch });
    this.#repeat();
  }

  #say() {
    const { what, stretch } = this.#open;
    if (!what) return;
    const heard = this.#isTrue ? T.moment(Math.round(1e3 * MOMENT[0])) : stretch < SLOW ? T.truePitch : T.lowered(short(stretch));
    setText($("audio"), T.audio(what, heard, !this.#isTrue && stretch > 60 ? T.tooLow : ""));
    $("pitch").hidden = stretch < SLOW;
  }

  // ---- the last moment at true pitch

  // Replaces the moments that are heard by the newest ones.
  #repeat() {
    const open = this.#open;
    const { context } = open;
    this.#say();
    const [now, fade] = [context.currentTime, 0.03];
    for (const { node, gain } of open.moments) {
      gain.gain.setTargetAtTime(0, now, fade);
      node.stop(now + 6 * fade);
    }
    open.moments = [];
    if (!this.#isTrue || open.loop) return;
    this.#paths.forEach((path, k, paths) => {
      const samples = moment(this.#data(path), this.rate);
      if (!samples) return;
      const buffer = new AudioBuffer({ length: samples.length, sampleRate: this.rate });
      buffer.copyToChannel(samples, 0);
      const node = new AudioBufferSourceNode(context, { buffer, loop: true });
      const gain = new GainNode(context, { gain: 0 });
      gain.gain.setTargetAtTime(1, now, fade);
      node.connect(gain).connect(new StereoPannerNode(context, { pan: side(k, paths) })).connect(open.volume);
      node.start();
      open.moments.push({ node, gain });
    });
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

// A single run is heard from the middle, two from left and right.
const side = (k, paths) => (paths.length < 2 ? 0 : 2 * k - 1);

// The last moment of a run as a loop at true pitch; `null` if it is too short or silent.
function moment(data, rate) {
  const { velocity, dt, start } = data ?? {};
  if (!velocity) return null;
  const per = 1 / (rate * dt);
  const count = Math.floor(Math.min(velocity.length, MOMENT[0] / dt) / per);
  if (count < MOMENT[1] * rate) return null;
  // The mean over the samples of the run in each sample of the sound.
  const all = Float32Array.from({ length: count }, (_, k) => {
    const [from, to] = [Math.floor((count - 1 - k) * per), Math.max(Math.ceil((count - k) * per), 1)];
    let sum = 0;
    for (let age = from; age < to; age++) sum += velocity.at(age);
    return sum / (to - from);
  });
  const peak = all.reduce((most, x) => Math.max(most, Math.abs(x)), 0);
  if (!(peak > start.silence_m_per_s)) return null;
  // The length after which the motion is most like its start.
  const seam = Math.round(SEAM * rate);
  let best = { length: count - seam, likeness: -Infinity };
  for (let length = count - seam; length > 0.6 * count; length--) {
    let likeness = 0;
    for (let k = 0; k < seam; k++) likeness += all[k] * all[length + k];
    if (likeness > best.likeness) best = { length, likeness };
  }
  return all.slice(0, best.length).map((x, k) => (0.7 / peak) * (k < seam ? (k * x + (seam - k) * all[best.length + k]) / seam : x));
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
