// The page of a live run: connects the controls, the views and the server.

import { Bookmarks } from "/bookmarks.js";
import { Comparison } from "/compare.js";
import { Controls, TILT } from "/controls.js";
import { Branches, Diagram } from "/diagram.js";
import { $, setText, shown } from "/dom.js";
import { Keys } from "/keys.js";
import { showPanel, speedText } from "/panel.js";
import { Run } from "/run.js";
import { fillShare, fillSheet } from "/share.js";
import { Sound } from "/sound.js";
import { Stage } from "/stage.js";
import { T, fillTexts } from "/texts.js";
import { onSystemTheme, restoreTheme, toggleTheme } from "/theme.js";
import { Tour } from "/tour.js";

fillTexts(document);

const state = { panel: null, audienceUrl: null, refusedUntil: 0, draggingSpeed: false };
// The sound of a run by the path of its socket.
const sound = new Sound((path) => (path.startsWith("/b") ? comparison.second : run)?.data);
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
    for (const control of document.querySelectorAll(":is(#dock input, #dock button:not(#listen)):not(#sound *), #scene")) control.disabled = !sent.controls;
    $("compare").hidden = !sent.compares || !sent.controls;
  },
  panel(status, before) {
    state.panel = status;
    if (status.run !== before?.run) diagram.setRange(status.tilt_range);
    if (status.diagram !== before?.diagram) diagram.load(status.diagram);
    const note = status.diagram_note ?? status.diagram_condition;
    if (note !== diagram.note) diagram.setNote(note);
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
const bookmarks = new Bookmarks(run, stage);
const tour = new Tour(run, (views) => stage.show(views));
fetch("/tour.json").then((answer) => answer.json()).then((sent) => {
  tour.tour = sent.tour;
  bookmarks.shipped = sent.bookmarks?.steps ?? [];
});
const comparison = new Comparison(run, stage, diagram);
comparison.onRefused = refused;
comparison.onPanel = showControlled;
const ask = (command) => comparison.ask(command);
const controls = new Controls((key, value) => {
  if (key === TILT) [state.movedAt, state.movedTo] = [performance.now(), value];
  ask({ do: "set", key, value });
});
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
  controls.refused();
  setText($("refused"), shown(words));
  $("refused").hidden = false;
  state.refusedUntil = performance.now() + 4000;
  setTimeout(done, 4100);
}

function done() {
  if (performance.now() > state.refusedUntil) $("refused").hidden = true;
}

// ---- the numbers of the scene

// The panel of the run that the controls act on: that of B only if they act on B alone.
const controlled = () => (comparison.controlsSecond ? comparison.second.panel : null) ?? state.panel;

function showControlled() {
  const status = controlled();
  if (status) controls.show(status);
}

// During a tour the arrows move between its steps.
const arrow = (sign) => (event) => (tour.step === null ? controls.nudge(sign, event.shiftKey) : tour.move(sign));

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

onSystemTheme(() => stage.refresh());

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
  fillSheet(run);
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
  ArrowLeft: arrow(-1),
  ArrowRight: arrow(1),
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
