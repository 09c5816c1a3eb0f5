// The control panel: what the hands do goes out, what the run does comes in.

import { ViewerHost } from "/viewer-host.js";

const $ = (id) => document.getElementById(id);
const RETRY = 700;

// Kinds of motion, in the colours of the recording.
const KINDS = {
  silent: "#5b666d",
  transient: "#8d8d52",
  periodic: "#58a9ff",
  "quasi-periodic": "#b98cff",
  chaotic: "#ff7a59",
  noise: "#c9c9c9",
  unsure: "#3a4247",
  stable: "#5b666d",
};
const BY_NUMBER = ["#5b666d", "#58a9ff", "#43c59e", "#b98cff", "#ffd166", "#ffa53a", "#ff7a59"];

function colour(kind) {
  const count = Number.parseInt(kind, 10);
  return KINDS[kind] ?? BY_NUMBER[Math.min(count, BY_NUMBER.length - 1)] ?? "#888";
}
const NODE_COLOURS = ["#ffa53a", "#58a9ff", "#f2f5f7"];

// Names of files and scenes may hold characters that change how other text is shown.
const HIDDEN = /[\p{Cc}\u061c\u200e\u200f\u2028\u2029\u202a-\u202e\u2066-\u2069]/gu;
const shown = (text) =>
  text.replace(HIDDEN, (c) => `\\u${c.charCodeAt(0).toString(16).padStart(4, "0")}`);

const state = { panel: null, refusedUntil: 0, asked: null, askedUntil: 0, pacing: false };

// ---- dark, or light for a projector in a bright room

const asSystem = window.matchMedia.bind(window);
const theme = localStorage.getItem("theme") === "light" ? "light" : "dark";
document.documentElement.dataset.theme = theme;
// The viewer goes by what it takes for the system's wish.
window.matchMedia = (query) => {
  const wish = /prefers-color-scheme:\s*(\w+)/.exec(query);
  return asSystem(!wish ? query : wish[1] === theme ? "all" : "not all");
};

function toggleTheme() {
  localStorage.setItem("theme", theme === "dark" ? "light" : "dark");
  location.reload();
}

// ---- talking with the server

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

// ---- what is told once

let scenes = [];
let hardKick = null;

function welcome(told) {
  scenes = told.scenes.map(([name]) => name);
  $("scene").replaceChildren(
    ...told.scenes.map(([name, title]) => new Option(shown(`${name}: ${title}`), name)),
  );
  soundRate = told.sound_rate;
  hardKick = told.hard_kick;
}

let bandsNow = { source: "", at: [] };

function bands(told) {
  bandsNow = told;
  drawBands();
}

function showSource() {
  $("bands-source").replaceChildren();
  inline($("bands-source"), bandsNow.source);
}

function drawBands() {
  const svg = $("bands");
  const reach = state.panel?.reach_deg;
  const at = bandsNow.at;
  if (!reach || at.length === 0) {
    svg.replaceChildren();
    $("legend").replaceChildren();
    showSource();
    return;
  }
  const x = (deg) => (1000 * (deg - reach[0])) / (reach[1] - reach[0]);
  // Neighbours of one kind are one band.
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

// ---- what is told again and again

function panel(told) {
  const before = state.panel;
  state.panel = told;
  const now = told.time_s;
  $("time").textContent = now < 1 ? `${(1e3 * now).toFixed(1)} ms` : `${now.toFixed(4)} s`;
  if ($("scene").value !== told.scene) $("scene").value = told.scene;
  $("title").textContent = told.title;
  showTilt(told, before);
  showPace(told);
  const sure = told.confidence === null ? "" : ` (${Math.round(100 * told.confidence)} % sure)`;
  $("regime").textContent = told.regime ? told.regime + sure : "not yet told";
  $("lines").replaceChildren(...(told.lines.length ? told.lines.slice(0, 3).map(line) : ["none yet"]));
  $("speed").textContent = `${told.speed_mm_s.toPrecision(3)} mm/s`;
  showNodes(told.nodes);
  if (told.words !== before?.words || told.lesson !== before?.lesson || told.run !== before?.run) {
    // The lesson itself stands in the viewer; here is what to look at.
    const look = told.lesson.split("\n\n").find((part) => part.startsWith("**Look at**"));
    markdown($("words"), `${told.words || (look ? "" : told.about)}\n\n${look ?? ""}`);
  }
  if (told.recording !== before?.recording) showRecording(told.recording);
  if (told.events.at(-1)?.number !== before?.events.at(-1)?.number) showEvents(told.events);
  $("watching").textContent = told.watching === 1 ? "1 viewer" : `${told.watching} viewers`;
  if (told.run !== before?.run) drawBands();
}

function line({ frequency_hz, amplitude, label: name }) {
  const row = document.createElement("div");
  const label = name ? ` ${name}` : "";
  row.textContent = `${(frequency_hz / 1000).toFixed(3)} kHz${label}, ${(1000 * amplitude).toPrecision(3)} mm/s`;
  return row;
}

function showTilt(told, before) {
  const slider = $("tilt");
  $("tilting").hidden = !told.reach_deg;
  if (!told.reach_deg || told.tilt_deg === null) return;
  if (told.run !== before?.run) {
    [slider.min, slider.max] = told.reach_deg;
  }
  // What was asked for stands until it is there, or was refused.
  const there = Math.abs(told.tilt_deg - state.asked) < 5e-3;
  if (there || told.run !== before?.run || (!told.paused && performance.now() > state.askedUntil)) {
    state.asked = null;
  }
  slider.value = state.asked ?? told.tilt_deg;
  $("tilt-now").textContent = `${Number(slider.value).toFixed(2)}°`;
}

// Two digits, without powers of ten.
const short = (x) => `${Number(x.toPrecision(2))}`;

function paceWords(msPerS) {
  if (msPerS >= 999.5) return "real time";
  return `${msPerS >= 10 ? msPerS.toFixed(0) : msPerS.toPrecision(2)} ms/s`;
}

function showPace(told) {
  const asked = 1e3 * told.pace;
  if (!state.pacing) $("pace").value = Math.log10(asked);
  $("pace-now").textContent = paceWords(asked);
  $("pause").textContent = told.paused ? "Go on" : "Pause";
  $("pause").setAttribute("aria-pressed", told.paused);
  $("neighbours").hidden = told.neighbours === null;
  $("neighbours").firstElementChild.checked = told.neighbours === true;
  const slow = told.reached !== null && told.reached < 0.9 * told.pace;
  const reached = told.reached === null ? "" : paceWords(1e3 * told.reached);
  $("reached").textContent = told.paused
    ? "time stands still"
    : slow
      ? `this machine reaches ${reached}${told.neighbours ? "; without neighbours it is faster" : ""}`
      : `1 ms takes ${short(1 / asked)} s`;
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
  const [stick, slip, open] = nodes;
  $("nodes-words").textContent = `contact nodes: ${stick} stick, ${slip} slide, ${open} open`;
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
  $("recording").textContent = file ? `into ${file}` : "";
}

// Headings, lists, tables, bold, italic and code: what the words of a run are made of.
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
  $("heard").hidden = true;
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
  // A server that is gone plays no more.
  socket.onclose = mute;
  socket.onmessage = (event) => {
    if (typeof event.data === "string") {
      heard(JSON.parse(event.data).heard);
      return;
    }
    const piece = new Float32Array(event.data);
    mine.samples += piece.length;
    player.port.postMessage(piece, [piece.buffer]);
  };
  $("listen").setAttribute("aria-pressed", "true");
  $("listen").textContent = "Mute";
  $("heard").hidden = false;
  $("heard").textContent = "listening…";
}

function heard({ what, slower }) {
  const pitch =
    slower < 1.02 ? "at its true pitch" : `${short(slower)} times slower, and so lower, than life`;
  const hint = slower > 60 ? "; too low to hear: choose a faster pace" : "";
  $("heard").textContent = `${what}, ${pitch}, made as loud as it may be${hint}`;
}

// ---- hands

function tilted(deg) {
  state.asked = Number(deg);
  state.askedUntil = performance.now() + 2000;
  ask({ do: "tilt", deg: state.asked });
}
const paced = (ms) => ask({ do: "pace", ms_per_s: Number(ms) });
const kick = (event) =>
  ask({ do: "kick", ...(event.shiftKey && { mm_per_s: hardKick }) });
const togglePause = () => ask({ do: state.panel?.paused ? "resume" : "pause" });
const toggleNeighbours = () => ask({ do: "neighbours", follow: !state.panel?.neighbours });
const toggleRecord = () => ask({ do: state.panel?.recording ? "stop-recording" : "record" });

$("tilt").addEventListener("input", (event) => {
  $("tilt-now").textContent = `${Number(event.target.value).toFixed(2)}°`;
  tilted(event.target.value);
});
$("tilt").addEventListener("change", (event) => tilted(event.target.value));
$("pace").addEventListener("input", (event) => {
  state.pacing = true;
  paced(10 ** Number(event.target.value));
});
$("pace").addEventListener("change", () => setTimeout(() => (state.pacing = false), 300));
$("paces").addEventListener("click", (event) => {
  if (event.target.dataset.pace) paced(event.target.dataset.pace);
});
$("scene").addEventListener("change", (event) => {
  ask({ do: "scene", name: event.target.value });
  // Keys steer again.
  event.target.blur();
});
$("pause").addEventListener("click", togglePause);
$("step").addEventListener("click", () => ask({ do: "step" }));
$("kick").addEventListener("click", kick);
$("reset").addEventListener("click", () => ask({ do: "reset" }));
$("neighbours").addEventListener("change", toggleNeighbours);
$("record").addEventListener("click", toggleRecord);
$("listen").addEventListener("click", listen);

function nudge(by) {
  const panel = state.panel;
  if (!panel?.reach_deg) return;
  const [low, high] = panel.reach_deg;
  const deg = Math.min(high, Math.max(low, Number($("tilt").value) + by));
  $("tilt").value = deg;
  tilted(deg.toFixed(4));
}

const KEYS = {
  " ": togglePause,
  ".": () => ask({ do: "step" }),
  k: kick,
  r: () => ask({ do: "reset" }),
  m: listen,
  e: toggleNeighbours,
  f: toggleRecord,
  l: toggleTheme,
  h: () => document.body.classList.toggle("alone"),
  n: () => {
    const next = scenes[(scenes.indexOf(state.panel?.scene) + 1) % scenes.length];
    ask({ do: "scene", name: next });
  },
  1: () => paced(1),
  2: () => paced(20),
  3: () => paced(250),
  4: () => paced(1000),
};

// Before the viewer sees it, which has keys of its own, and before a focused slider or button does.
window.addEventListener(
  "keydown",
  (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const lists = ["ArrowUp", "ArrowDown", "Enter", " "];
    if (event.target instanceof HTMLSelectElement && lists.includes(event.key)) return;
    if (event.target === $("pace") && event.key.startsWith("Arrow")) return;
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

// ---- begin

connect();
const host = new ViewerHost($("viewer"));
// For those who look into the page.
window.squeakscope = { host, state, ask, soundSamples: () => sound?.samples ?? 0 };
host
  .start()
  .then(() => $("loading").remove())
  .catch((fault) => {
    $("loading").textContent = `The viewer cannot start: ${fault}`;
  });
