// The text and the numbers of a run.

import { $, make, setText, short, shown } from "/dom.js";
import { markdown } from "/markdown.js";
import { unit } from "/plot.js";
import { T } from "/texts.js";

const NODE_COLOURS = ["var(--stick)", "var(--slip)", "var(--separated)"];
// Wall time for which a present motion must last before it is announced, ms.
const SETTLED = 1500;

export function speedText(msPerS) {
  if (msPerS >= 999.5) return T.realTime;
  return T.speedOf(msPerS >= 10 ? msPerS.toFixed(0) : Number(msPerS.toPrecision(2)));
}

const kilo = (hz) => (1e-3 * hz).toFixed(2);

// Shows the status of the run; `before` is the previous one.
export function showPanel(status, before) {
  const now = status.time_s;
  setText($("time"), now < 1 ? `${(1e3 * now).toFixed(1)} ms` : `${now.toFixed(4)} s`);
  if ($("scene").value !== status.scene) $("scene").value = status.scene;
  announce(status);
  setText($("title"), T.sceneAsWritten(status.now, status.title));
  showSpeed(status);
  const sure = status.confidence === null || status.tilt_moves ? "" : T.confidence(Math.round(100 * status.confidence));
  setText($("regime"), motion(status) + sure);
  const lines = status.lines.length ? status.lines.slice(0, 3).map(line) : [T.noLines];
  $("lines").replaceChildren(...lines);
  setText($("peak-velocity"), peakVelocity(status));
  showNodes(status.nodes);
  if (status.narration !== before?.narration || status.lesson !== before?.lesson || status.run !== before?.run) {
    markdown($("words"), `${status.narration || status.about}\n\n${status.lesson}`);
  }
  if (status.recording !== before?.recording) showRecording(status.recording);
  if (status.events.at(-1)?.number !== before?.events.at(-1)?.number) showEvents(status.events);
  setText($("watching"), T.viewers(status.watching));
}

export function peakVelocity({ regime, peak_velocity_mm_per_s: mm }) {
  const { per, symbol } = unit(1e-3 * mm, "m/s");
  return regime === "at rest" ? T.atRest : `${(1e-3 * per * mm).toPrecision(3)} ${symbol}`;
}

// The present motion in words: one verdict for all parts of the page.
export const motion = (status) => status.motion;

// The present motion in words. A change is announced only once it has lasted a while.
let announced = { text: "", since: 0 };

function announce(status) {
  const text = motion(status);
  if (text !== announced.text) announced = { text, since: performance.now() };
  if (performance.now() - announced.since > SETTLED) setText($("lasting"), text);
  setText($("now"), text);
  // A periodic motion has one base frequency; the line of another one that decays is no tone of its own.
  const bases = status.regime === "periodic" ? /^f1$/ : /^f\d+$/;
  const named = status.lines.filter(({ label }) => bases.test(label)).slice(0, 3);
  const lines = (named.length ? named : status.lines.slice(0, 1)).map((l) => T.frequency(kilo(l.frequency_hz), l.label));
  setText($("now-lines"), lines.join(" · "));
}

function line({ frequency_hz, amplitude, label }) {
  const text = T.line((frequency_hz / 1000).toFixed(3), label, (1000 * amplitude).toPrecision(3));
  return make("div", { textContent: text });
}

function showSpeed(status) {
  // Between two runs there is no speed.
  if (!status.speed) return;
  const asked = 1e3 * status.speed;
  setText($("speed-now"), speedText(asked));
  setText($("pause"), status.paused ? T.resume : T.pause);
  $("lyapunov").hidden = status.lyapunov === null;
  $("lyapunov").firstElementChild.checked = status.lyapunov === true;
  setText($("measured_speed"), status.paused ? T.paused : reached(status));
}

// The measured ratio of simulated time to wall time.
function reached({ measured_speed: ratio, speed, lyapunov }) {
  if (ratio === null) return "";
  const text = ratio >= 0.95 ? T.realTime : T.ofRealTime(short(ratio));
  return ratio < 0.9 * speed ? text + T.slower(lyapunov) : text;
}

function showNodes(nodes) {
  $("nodes").hidden = $("nodes-words").hidden = !nodes;
  if (!nodes) return;
  const all = nodes.reduce((a, b) => a + b, 0) || 1;
  const bars = nodes.map((count, k) => make("span", { style: `width:${(100 * count) / all}%;background:${NODE_COLOURS[k]}` }));
  $("nodes").replaceChildren(...bars);
  setText($("nodes-words"), T.nodeCounts(...nodes.map((count) => count.toFixed(0))));
}

// The newest message first. Messages of earlier runs would seem to be later than the new run.
function showEvents(events) {
  const newest = events.at(-1);
  setText($("latest"), newest ? shown(newest.text) : "");
  const start = events.findLastIndex(({ text }) => text.endsWith(" starts"));
  // A run that gets its commands at its start is paused for a moment.
  const shownOnes = events.slice(Math.max(0, start)).filter(({ time_s, text }) => time_s > 0 || !/^(paused|resumed)$/.test(text));
  const items = shownOnes.toReversed().slice(0, 6);
  $("events").replaceChildren(
    ...items.map(({ time_s, text }) =>
      make("li", {}, `${(1e3 * time_s).toFixed(1)} ms`, make("b", { textContent: shown(text) })),
    ),
  );
}

function showRecording(file) {
  $("record").setAttribute("aria-pressed", Boolean(file));
  setText($("record"), file ? T.stopRecording : T.record);
  $("recording").hidden = !file;
  setText($("recording"), file ? T.recordingTo(file) : "");
}
