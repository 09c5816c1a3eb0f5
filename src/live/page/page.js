// The page of a live run: connects the controls, the views and the server.

import { Bookmarks } from "/bookmarks.js";
import { Comparison } from "/compare.js";
import { Branches, Diagram } from "/diagram.js";
import { $, setText, shown } from "/dom.js";
import { Keys } from "/keys.js";
import { showPanel, speedText } from "/panel.js";
import { Run } from "/run.js";
import { fillShare } from "/share.js";
import { Sound } from "/sound.js";
import { Stage } from "/stage.js";
import { T, fillTexts } from "/texts.js";
import { restoreTheme, toggleTheme } from "/theme.js";
import { Tour } from "/tour.js";

// Wall time for which a requested value is displayed while the server does not confirm it, ms.
const PATIENCE = 2000;

fillTexts(document);

const state = { panel: null, audienceUrl: null, asked: null, askedUntil: 0, refusedUntil: 0, draggingSpeed: false };
const sound = new Sound();
const diagram = new Diagram();
let scenes = [];
let hardKick = null;

const run = new Run("", {
  connected: (on) => $("live").classList.toggle("on", on),
  welcome(sent) {
    scenes = sent.scenes.map(([name]) => name);
    $("scene").replaceChildren(...sent.scenes.map(([name, title]) => new Option(shown(`${name}: ${title}`), name)));
    sound.rate = sent.audio_rate_hz;
    hardKick = sent.hard_kick_mm_per_s;
    state.audienceUrl = sent.audience_url;
    document.body.classList.toggle("audience", !sent.controls);
    for (const control of document.querySelectorAll("#dock input, #dock button:not(#listen), #scene")) control.disabled = !sent.controls;
    $("compare").hidden = !sent.compares || !sent.controls;
  },
  panel(status, before) {
    state.panel = status;
    if (status.run !== before?.run) diagram.setRange(status.tilt_range_deg);
    if (status.diagram !== before?.diagram) diagram.load(status.diagram);
    if (status.diagram_note !== before?.diagram_note) diagram.setNote(status.diagram_note);
    showPanel(status, before);
    showControlled();
    if (!state.draggingSpeed && status.speed) $("speed").value = Math.log10(1e3 * status.speed);
    stage.describe(status.now);
    sound.setLines(status.lines);
    tour.update(status);
    document.body.classList.toggle("blank", status.blank);
    setText($("departure"), status.departure ?? "");
    comparison.update(status);
  },
  refused,
  done,
  data: () => stage.request(),
});
const stage = new Stage(run, $("views"), [new Branches(diagram)], $("choices"));
new Bookmarks(run, stage);
const tour = new Tour(run, (views) => stage.show(views));
const comparison = new Comparison(run, stage, diagram);
comparison.onRefused = refused;
comparison.onPanel = showControlled;
const ask = (command) => comparison.ask(command);
// Times from the slider to the changed picture, ms.
const latencies = [];
stage.onDrawn = (data) => {
  diagram.mark(data.tilt);
  if (state.movedAt && Math.abs(data.tilt - state.movedTo) < 5e-3) {
    latencies.push(performance.now() - state.movedAt);
    state.movedAt = null;
  }
};

function refused(words) {
  state.asked = null;
  setText($("refused"), shown(words));
  $("refused").hidden = false;
  state.refusedUntil = performance.now() + 4000;
  setTimeout(done, 4100);
}

function done() {
  if (performance.now() > state.refusedUntil) $("refused").hidden = true;
}

// ---- tilt

// The panel of the run that the controls act on: that of B only if they act on B alone.
const controlled = () => (comparison.controlsSecond ? comparison.second.panel : null) ?? state.panel;

function showControlled() {
  const status = controlled();
  showTilt(status, state.controlled);
  state.controlled = status;
}

function showTilt(status, before) {
  const slider = $("tilt");
  $("tilting").hidden = !status.tilt_range_deg;
  if (!status.tilt_range_deg || status.tilt_deg === null) return;
  if (status.run !== before?.run) [slider.min, slider.max] = status.tilt_range_deg;
  // A requested tilt is displayed until it is applied or rejected.
  const applied = Math.abs(status.tilt_deg - state.asked) < 5e-3;
  if (applied || status.run !== before?.run || (!status.paused && performance.now() > state.askedUntil)) {
    state.asked = null;
  }
  displayTilt(state.asked ?? status.tilt_deg);
}

function displayTilt(deg) {
  $("tilt").value = deg;
  setText($("tilt-now"), T.degrees(Number(deg)));
  $("tilt").setAttribute("aria-valuetext", T.degrees(Number(deg)));
}

function setTilt(deg) {
  state.asked = Number(deg);
  state.askedUntil = performance.now() + PATIENCE;
  [state.movedAt, state.movedTo] = [performance.now(), state.asked];
  displayTilt(state.asked);
  ask({ do: "tilt", deg: state.asked });
}

function nudge(by) {
  const range = controlled()?.tilt_range_deg;
  if (!range) return;
  const deg = Math.min(range[1], Math.max(range[0], Number($("tilt").value) + by));
  setTilt(deg.toFixed(4));
}

const stepOf = (event) => (event.shiftKey ? 0.5 : 0.1);
const TILT_KEYS = {
  ArrowLeft: (event) => nudge(-stepOf(event)),
  ArrowRight: (event) => nudge(stepOf(event)),
};
// During a tour the arrows move between its steps.
const ARROWS = {
  ArrowLeft: (event) => (tour.step === null ? TILT_KEYS.ArrowLeft(event) : tour.move(-1)),
  ArrowRight: (event) => (tour.step === null ? TILT_KEYS.ArrowRight(event) : tour.move(1)),
};
$("tilt").addEventListener("input", (event) => setTilt(event.target.value));
$("tilt").addEventListener("keydown", (event) => {
  const act = { ...TILT_KEYS, ArrowDown: TILT_KEYS.ArrowLeft, ArrowUp: TILT_KEYS.ArrowRight }[event.key];
  if (!act) return;
  event.preventDefault();
  act(event);
});

// ---- playback

const setSpeed = (ms) => ask({ do: "speed", ms_per_s: Number(ms) });
const kick = (event) => ask({ do: "kick", ...(event.shiftKey && { mm_per_s: hardKick }) });
const togglePause = () => ask({ do: controlled()?.paused ? "resume" : "pause" });
const step = () => ask({ do: "step" });
const restart = () => ask({ do: "reset" });
const toggleLyapunov = () => ask({ do: "lyapunov", enabled: !state.panel?.lyapunov });
const toggleRecord = () => ask({ do: state.panel?.recording ? "stop-recording" : "record" });
const nextScene = () => ask({ do: "scene", name: scenes[(scenes.indexOf(state.panel?.scene) + 1) % scenes.length] });

$("speed").addEventListener("input", (event) => {
  state.draggingSpeed = true;
  const ms = 10 ** Number(event.target.value);
  setText($("speed-now"), speedText(ms));
  $("speed").setAttribute("aria-valuetext", speedText(ms));
  setSpeed(ms);
});
$("speed").addEventListener("change", () => setTimeout(() => (state.draggingSpeed = false), 300));
$("speed-presets").addEventListener("click", (event) => {
  if (event.target.dataset.speed) setSpeed(event.target.dataset.speed);
});
$("scene").addEventListener("change", (event) => ask({ do: "scene", name: event.target.value }));
$("pause").onclick = togglePause;
$("step").onclick = step;
$("kick").onclick = kick;
$("reset").onclick = restart;
$("lyapunov").onchange = toggleLyapunov;
$("record").onclick = toggleRecord;

// ---- the page itself

function changeTheme() {
  toggleTheme();
  stage.refresh();
}

function togglePanel() {
  const alone = document.body.classList.toggle("alone");
  setText($("panel-toggle"), alone ? T.panelShow : T.panelHide);
  $("panel-toggle").setAttribute("aria-expanded", !alone);
}

function toggleFullScreen() {
  if (document.fullscreenElement) document.exitFullscreen();
  else document.documentElement.requestFullscreen?.();
}

function share() {
  fillShare(state.audienceUrl, state.panel?.recordings ?? []);
  $("share").showModal();
}

function compare() {
  comparison.toggle();
  sound.setRuns(comparison.open ? { A: "/sound", B: "/b/sound", [T.leftRight]: "/sound /b/sound" } : { A: "/sound" });
}

// Paper is white.
window.addEventListener("beforeprint", () => {
  document.documentElement.dataset.theme = "light";
  stage.redraw();
});
window.addEventListener("afterprint", () => {
  restoreTheme();
  stage.redraw();
});

const help = () => $("help").showModal();
const listen = () => sound.toggle();
$("listen").onclick = listen;
$("theme").onclick = changeTheme;
$("panel-toggle").onclick = togglePanel;
$("full-screen").onclick = toggleFullScreen;
$("help-open").onclick = help;
$("share-open").onclick = share;
$("print").onclick = () => {
  $("share").close();
  window.print();
};
$("tour-start").onclick = () => tour.toggle();
$("compare").onclick = compare;

new Keys({
  ...ARROWS,
  " ": togglePause,
  ".": step,
  k: kick,
  r: restart,
  n: nextScene,
  1: () => setSpeed(1),
  2: () => setSpeed(20),
  3: () => setSpeed(250),
  4: () => setSpeed(1000),
  m: listen,
  e: toggleLyapunov,
  f: toggleRecord,
  h: togglePanel,
  l: changeTheme,
  g: toggleFullScreen,
  t: () => tour.toggle(),
  // A presenter's remote sends these.
  Enter: () => tour.step !== null && tour.move(1),
  PageDown: () => tour.move(1),
  PageUp: () => tour.move(-1),
  b: () => ask({ do: "blank", on: !state.panel?.blank }),
  "?": help,
  Escape: () => stage.one && stage.enlarge(stage.one),
});

// A menu closes after a choice of its buttons, and with a click elsewhere.
document.addEventListener("click", ({ target }) => {
  for (const menu of document.querySelectorAll("details[open]")) {
    if (!menu.contains(target) || target.tagName === "BUTTON") menu.open = false;
  }
});

// For tests in a browser.
window.squeakscope = { state, run, stage, diagram, latencies, ask, sound, tour, comparison };
