// The control panel: sends commands to the server and displays the state of the run.

import { ViewerHost } from "/viewer-host.js";

const $ = (id) => document.getElementById(id);
const RETRY = 700;

// Types of motion, in the colours of the recording.
const REGIME_COLOURS = {
  silent: "#5b666d",
  transient: "#8d8d52",
  periodic: "#58a9ff",
  "quasi-periodic": "#b98cff",
  chaotic: "#ff7a59",
  noise: "#c9c9c9",
  undetermined: "#3a4247",
  stable: "#5b666d",
};
const UNSTABLE_MODE_COLOURS = ["#5b666d", "#58a9ff", "#43c59e", "#b98cff", "#ffd166", "#ffa53a", "#ff7a59"];

function colour(kind) {
  const count = Number.parseInt(kind, 10);
  return REGIME_COLOURS[kind] ?? UNSTABLE_MODE_COLOURS[Math.min(count, UNSTABLE_MODE_COLOURS.length - 1)] ?? "#888";
}
const NODE_COLOURS = ["#ffa53a", "#58a9ff", "#f2f5f7"];

// File and scene names may contain characters that change the direction or layout of other text.
const HIDDEN = /[\p{Cc}\u061c\u200e\u200f\u2028\u2029\u202a-\u202e\u2066-\u2069]/gu;
const shown = (text) =>
  text.replace(HIDDEN, (c) => `\\u${c.charCodeAt(0).toString(16).padStart(4, "0")}`);

const state = { panel: null, refusedUntil: 0, asked: null, askedUntil: 0, draggingSpeed: false };

// ---- theme: dark, or light for a projector

const asSystem = window.matchMedia.bind(window);
const theme = localStorage.getItem("theme") === "light" ? "light" : "dark";
document.documentElement.dataset.theme = theme;
// The viewer follows the colour scheme of the system. The page overrides that query.
window.matchMedia = (query) => {
  const wish = /prefers-color-scheme:\s*(\w+)/.exec(query);
  return asSystem(!wish ? query : wish[1] === theme ? "all" : "not all");
};

function toggleTheme() {
  localStorage.setItem("theme", theme === "dark" ? "light" : "dark");
  location.reload();
}

// ---- connection to the server

let control = null;

function connect() {
  control = new WebSocket(`ws://${location.host}/control`);
  control.onopen = () => $("live").classList.add("on");
  control.onmessage = (event) => {
    for (const [key, value] of Object.entries(JSON.parse(event.data))) {
      handlers[key]?.(value);
    }
  };
  control.onclose = () => {
    $("live").classList.remove("on");
    setTimeout(connect, RETRY);
  };
}

function ask(command) {
  if (control?.readyState === WebSocket.OPEN) {
    control.send(JSON.stringify(command));
  }
}

const handlers = { welcome, bands, panel, refused, done };

function done() {
  if (performance.now() > state.refusedUntil) $("refused").hidden = true;
}

function refused(words) {
  state.asked = null;
  $("refused").textContent = shown(words);
  $("refused").hidden = false;
  state.refusedUntil = performance.now() + 4000;
  setTimeout(done, 4100);
}

// ---- sent once by the server

let scenes = [];
let hardKick = null;

function welcome(sent) {
  scenes = sent.scenes.map(([name]) => name);
  $("scene").replaceChildren(
    ...sent.scenes.map(([name, title]) => new Option(shown(`${name}: ${title}`), name)),
  );
  soundRate = sent.audio_rate_hz;
  hardKick = sent.hard_kick_mm_per_s;
}

let bandsNow = { source: "", at: [] };

function bands(sent) {
  bandsNow = sent;
  drawBands();
}

function showSource() {
  $("bands-source").replaceChildren();
  inline($("bands-source"), bandsNow.source);
}

function drawBands() {
  const svg = $("bands");
  const reach = state.panel?.tilt_range_deg;
  const at = bandsNow.at;
  if (!reach || at.length === 0) {
    svg.replaceChildren();
    $("legend").replaceChildren();
    showSource();
    return;
  }
  const x = (deg) => (1000 * (deg - reach[0])) / (reach[1] - reach[0]);
  // Adjacent tilts with the same type of motion form one band.
  const ranges = [];
  for (const [k, [deg, kind]] of at.entries()) {
    const low = k === 0 ? deg : 0.5 * (at[k - 1][0] + deg);
    const high = k === at.length - 1 ? deg : 0.5 * (deg + at[k + 1][0]);
    const last = ranges.at(-1);
    if (last?.kind === kind) last.high = high;
    else ranges.push({ kind, low, high });
  }
  const rects = ranges.map(({ kind, low, high }) => {
    const rect = document.createElementNS("http://www.w3.org/2000/svg", "rect");
    const left = Math.max(0, x(low));
    rect.setAttribute("x", left);
    rect.setAttribute("width", Math.max(0, Math.min(1000, x(high)) - left) + 0.5);
    rect.setAttribute("height", 34);
    rect.setAttribute("fill", colour(kind));
    return rect;
  });
  svg.replaceChildren(...rects);
  const kinds = [...new Set(at.map(([, kind]) => kind))];
  $("legend").replaceChildren(
    ...kinds.map((kind) => {
      const item = document.createElement("span");
      const swatch = document.createElement("i");
      swatch.style.background = colour(kind);
      item.append(swatch, kind);
      return item;
    }),
  );
  showSource();
}

// ---- sent repeatedly by the server

function panel(status) {
  const before = state.panel;
  state.panel = status;
  const now = status.time_s;
  $("time").textContent = now < 1 ? `${(1e3 * now).toFixed(1)} ms` : `${now.toFixed(4)} s`;
  if ($("scene").value !== status.scene) $("scene").value = status.scene;
  $("now").textContent = `Now: ${status.now}`;
  $("title").textContent = `The scene as written: ${status.title}`;
  showTilt(status, before);
  showSpeed(status);
  const sure = status.confidence === null ? "" : ` (confidence ${Math.round(100 * status.confidence)} %)`;
  $("regime").textContent = status.regime ? status.regime + sure : "not classified yet";
  $("lines").replaceChildren(...(status.lines.length ? status.lines.slice(0, 3).map(line) : ["none yet"]));
  $("peak-velocity").textContent = `${status.peak_velocity_mm_per_s.toPrecision(3)} mm/s`;
  showNodes(status.nodes);
  if (status.narration !== before?.narration || status.lesson !== before?.lesson || status.run !== before?.run) {
    // The viewer displays the complete lesson; the panel only says where to look.
    const look = status.lesson.split("\n\n").find((part) => part.startsWith("**Look at**"));
    markdown($("words"), `${status.narration || (look ? "" : status.about)}\n\n${look ?? ""}`);
  }
  if (status.recording !== before?.recording) showRecording(status.recording);
  if (status.events.at(-1)?.number !== before?.events.at(-1)?.number) showEvents(status.events);
  $("watching").textContent = status.watching === 1 ? "1 viewer" : `${status.watching} viewers`;
  if (status.run !== before?.run) drawBands();
}

function line({ frequency_hz, amplitude, label: name }) {
  const row = document.createElement("div");
  const label = name ? ` ${name}` : "";
  row.textContent = `${(frequency_hz / 1000).toFixed(3)} kHz${label}, ${(1000 * amplitude).toPrecision(3)} mm/s`;
  return row;
}

function showTilt(status, before) {
  const slider = $("tilt");
  $("tilting").hidden = !status.tilt_range_deg;
  if (!status.tilt_range_deg || status.tilt_deg === null) return;
  if (status.run !== before?.run) {
    [slider.min, slider.max] = status.tilt_range_deg;
  }
  // A requested tilt is displayed until it is applied or rejected.
  const applied = Math.abs(status.tilt_deg - state.asked) < 5e-3;
  if (applied || status.run !== before?.run || (!status.paused && performance.now() > state.askedUntil)) {
    state.asked = null;
  }
  slider.value = state.asked ?? status.tilt_deg;
  $("tilt-now").textContent = `${Number(slider.value).toFixed(2)}°`;
}

// Two significant digits, without exponents.
const short = (x) => `${Number(x.toPrecision(2))}`;

function speedText(msPerS) {
  if (msPerS >= 999.5) return "real time";
  return `${msPerS >= 10 ? msPerS.toFixed(0) : msPerS.toPrecision(2)} ms/s`;
}

function showSpeed(status) {
  const asked = 1e3 * status.speed;
  if (!state.draggingSpeed) $("speed").value = Math.log10(asked);
  $("speed-now").textContent = speedText(asked);
  $("pause").textContent = status.paused ? "Resume" : "Pause";
  $("pause").setAttribute("aria-pressed", status.paused);
  $("lyapunov").hidden = status.lyapunov === null;
  $("lyapunov").firstElementChild.checked = status.lyapunov === true;
  const slow = status.measured_speed !== null && status.measured_speed < 0.9 * status.speed;
  const measured_speed = status.measured_speed === null ? "" : speedText(1e3 * status.measured_speed);
  $("measured_speed").textContent = status.paused
    ? "paused"
    : slow
      ? `actual speed ${measured_speed}${status.lyapunov ? "; faster without Lyapunov exponents" : ""}`
      : `1 ms of simulated time takes ${short(1 / asked)} s`;
}

function showNodes(nodes) {
  $("nodes").hidden = $("nodes-words").hidden = !nodes;
  if (!nodes) return;
  const all = nodes.reduce((a, b) => a + b, 0) || 1;
  $("nodes").replaceChildren(
    ...nodes.map((count, k) => {
      const bar = document.createElement("span");
      bar.style.cssText = `width:${(100 * count) / all}%;background:${NODE_COLOURS[k]}`;
      return bar;
    }),
  );
  const [stick, slip, separated] = nodes.map((count) => count.toFixed(0));
  $("nodes-words").textContent = `contact nodes, mean over 5 ms: ${stick} stick, ${slip} slip, ${separated} separated`;
}

function showEvents(events) {
  $("latest").textContent = events.at(-1)?.text ?? "";
  $("events").replaceChildren(
    ...events.toReversed().slice(0, 6).map(({ time_s, text }) => {
      const item = document.createElement("li");
      const words = document.createElement("b");
      words.textContent = text;
      item.append(`${(1e3 * time_s).toFixed(1)} ms`, words);
      return item;
    }),
  );
}

function showRecording(file) {
  $("record").setAttribute("aria-pressed", Boolean(file));
  $("record").textContent = file ? "Stop recording" : "Record";
  $("recording").hidden = !file;
  $("recording").textContent = file ? `recording to ${file}` : "";
}

// Renders headings, lists, tables, bold, italic and code.
function markdown(where, text) {
  const blocks = [];
  let list = null;
  for (const line of text.split("\n")) {
    const heading = line.match(/^(#+) (.*)/);
    const item = line.match(/^[*-] (.*)/);
    if (!item) list = null;
    if (line.startsWith("|")) {
      const cells = line.split("|").slice(1, -1).map((cell) => cell.trim());
      if (cells.every((cell) => /^[-:]*$/.test(cell))) continue;
      if (blocks.at(-1)?.tagName !== "TABLE") blocks.push(document.createElement("table"));
      const row = document.createElement("tr");
      row.append(...cells.map((cell, k) => inline(document.createElement(k ? "td" : "th"), cell)));
      blocks.at(-1).append(row);
    } else if (heading) {
      blocks.push(inline(document.createElement(heading[1].length < 3 ? "h2" : "h3"), heading[2]));
    } else if (item) {
      if (!list) blocks.push((list = document.createElement("ul")));
      list.append(inline(document.createElement("li"), item[1]));
    } else if (line.trim()) {
      const last = blocks.at(-1);
      if (last?.tagName === "P" && last.dataset.open) inline(last, ` ${line}`);
      else {
        const paragraph = inline(document.createElement("p"), line);
        paragraph.dataset.open = "1";
        blocks.push(paragraph);
      }
    } else if (blocks.at(-1)?.dataset) {
      delete blocks.at(-1).dataset.open;
    }
  }
  where.replaceChildren(...blocks);
}

function inline(element, text) {
  for (const part of text.split(/(\*\*[^*]+\*\*|\*[^*]+\*|`[^`]+`)/)) {
    const marked = (tag, cut) => {
      const inner = document.createElement(tag);
      inner.textContent = part.slice(cut, -cut);
      element.append(inner);
    };
    if (part.startsWith("**")) marked("strong", 2);
    else if (part.startsWith("*") && part.length > 2) marked("em", 1);
    else if (part.startsWith("`")) marked("code", 1);
    else element.append(part);
  }
  return element;
}

// ---- sound

let soundRate = 48000;
let sound = null;

let opening = false;

function mute() {
  const { socket, context } = sound;
  sound = null;
  socket.onclose = null;
  socket.close();
  context.close();
  $("listen").setAttribute("aria-pressed", "false");
  $("listen").textContent = "Listen";
  $("audio").hidden = true;
}

async function listen() {
  if (opening) return;
  if (sound) {
    mute();
    return;
  }
  opening = true;
  try {
    await openSound();
  } finally {
    opening = false;
  }
}

async function openSound() {
  const context = new AudioContext({ sampleRate: soundRate });
  await context.audioWorklet.addModule("/listen.js");
  const player = new AudioWorkletNode(context, "player", { outputChannelCount: [1] });
  player.connect(context.destination);
  const socket = new WebSocket(`ws://${location.host}/sound`);
  socket.binaryType = "arraybuffer";
  sound = { context, socket, samples: 0 };
  const mine = sound;
  // The connection to the server is lost.
  socket.onclose = mute;
  socket.onmessage = (event) => {
    if (typeof event.data === "string") {
      showAudio(JSON.parse(event.data).audio);
      return;
    }
    const piece = new Float32Array(event.data);
    mine.samples += piece.length;
    player.port.postMessage(piece, [piece.buffer]);
  };
  $("listen").setAttribute("aria-pressed", "true");
  $("listen").textContent = "Mute";
  $("audio").hidden = false;
  $("audio").textContent = "waiting for audio…";
}

function showAudio({ what, time_stretch: stretch }) {
  const pitch =
    stretch < 1.02 ? "at true pitch" : `slowed down and lowered by a factor of ${short(stretch)}`;
  const hint = stretch > 60 ? "; too low to hear: choose a higher playback speed" : "";
  $("audio").textContent = `${what}, ${pitch}, level normalised${hint}`;
}

// ---- user input

function setTilt(deg) {
  state.asked = Number(deg);
  state.askedUntil = performance.now() + 2000;
  ask({ do: "tilt", deg: state.asked });
}
const setSpeed = (ms) => ask({ do: "speed", ms_per_s: Number(ms) });
const kick = (event) =>
  ask({ do: "kick", ...(event.shiftKey && { mm_per_s: hardKick }) });
const togglePause = () => ask({ do: state.panel?.paused ? "resume" : "pause" });
const toggleLyapunov = () => ask({ do: "lyapunov", enabled: !state.panel?.lyapunov });
const toggleRecord = () => ask({ do: state.panel?.recording ? "stop-recording" : "record" });

$("tilt").addEventListener("input", (event) => {
  $("tilt-now").textContent = `${Number(event.target.value).toFixed(2)}°`;
  setTilt(event.target.value);
});
$("tilt").addEventListener("change", (event) => setTilt(event.target.value));
$("speed").addEventListener("input", (event) => {
  state.draggingSpeed = true;
  setSpeed(10 ** Number(event.target.value));
});
$("speed").addEventListener("change", () => setTimeout(() => (state.draggingSpeed = false), 300));
$("speed-presets").addEventListener("click", (event) => {
if (event.target.dataset.speed) setSpeed(event.target.dataset.speed);
});
$("scene").addEventListener("change", (event) => {
  ask({ do: "scene", name: event.target.value });
  // Returns the keyboard focus to the shortcuts.
  event.target.blur();
});
$("pause").addEventListener("click", togglePause);
$("step").addEventListener("click", () => ask({ do: "step" }));
$("kick").addEventListener("click", kick);
$("reset").addEventListener("click", () => ask({ do: "reset" }));
$("lyapunov").addEventListener("change", toggleLyapunov);
$("record").addEventListener("click", toggleRecord);
$("listen").addEventListener("click", listen);

function nudge(by) {
  const panel = state.panel;
  if (!panel?.tilt_range_deg) return;
  const [low, high] = panel.tilt_range_deg;
  const deg = Math.min(high, Math.max(low, Number($("tilt").value) + by));
  $("tilt").value = deg;
  setTilt(deg.toFixed(4));
}

const KEYS = {
  " ": togglePause,
  ".": () => ask({ do: "step" }),
  k: kick,
  r: () => ask({ do: "reset" }),
  m: listen,
  e: toggleLyapunov,
  f: toggleRecord,
  l: toggleTheme,
  h: () => document.body.classList.toggle("alone"),
  n: () => {
    const next = scenes[(scenes.indexOf(state.panel?.scene) + 1) % scenes.length];
    ask({ do: "scene", name: next });
  },
  1: () => setSpeed(1),
  2: () => setSpeed(20),
  3: () => setSpeed(250),
  4: () => setSpeed(1000),
};

// Captures keys before the viewer, which has its own shortcuts, and before a focused slider or button.
window.addEventListener(
  "keydown",
  (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const lists = ["ArrowUp", "ArrowDown", "Enter", " "];
    if (event.target instanceof HTMLSelectElement && lists.includes(event.key)) return;
    if (event.target === $("speed") && event.key.startsWith("Arrow")) return;
    const step = event.shiftKey ? 0.5 : 0.1;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const act =
      key === "ArrowLeft" ? () => nudge(-step) : key === "ArrowRight" ? () => nudge(step) : KEYS[key];
    if (!act) return;
    event.preventDefault();
    event.stopPropagation();
    act(event);
  },
  true,
);

// ---- start

connect();
const host = new ViewerHost($("viewer"));
// For tests in a browser.
window.squeakscope = { host, state, ask, soundSamples: () => sound?.samples ?? 0 };
host
  .start()
  .then(() => $("loading").remove())
  .catch((fault) => {
    $("loading").textContent = `The viewer cannot start: ${fault}`;
  });
