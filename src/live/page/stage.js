// The views of the run: which ones are shown, and when they are drawn.

import { make } from "/dom.js";
import { readStyle } from "/plot.js";
import { saveClip, savePicture } from "/share.js";
import { T } from "/texts.js";
import { Body } from "/views/body.js";
import { Lesson } from "/views/lesson.js";
import { Patch } from "/views/patch.js";
import { Portrait } from "/views/portrait.js";
import { Recurrence } from "/views/recurrence.js";
import { SWEEPS_MS, Scope } from "/views/scope.js";
import { Section } from "/views/section.js";
import { Spectrogram } from "/views/spectrogram.js";
import { Spectrum } from "/views/spectrum.js";

const VIEWS = [Patch, Portrait, Scope, Spectrum, Section, Recurrence, Body, Spectrogram];
const DEFAULT = ["patch", "portrait", "scope", "spectrum", "section", "recurrence"];
// The same for a scene with a lesson, unless the recurrence plot shows what it is about.
const TAUGHT = ["patch", "portrait", "scope", "spectrum", "section", "lesson"];
const RECURRENT = ["torus", "chaos"];
// Views of a joint, which other systems do not have.
const JOINT = ["patch", "body", "branches"];
// Wall time between two pictures if the system asks for reduced motion, ms.
const CALM = 500;

// The views chosen on this machine, if any.
function chosenViews() {
  const chosen = JSON.parse(localStorage.getItem("views") ?? "null");
  return Array.isArray(chosen) && chosen.length ? chosen : null;
}

export class Stage {
  // Draws a run in an element, with further views; `choices` is the list from which views are chosen, if any.
  constructor(run, place, extra = [], choices = null) {
    this.run = run;
    this.place = place;
    const lesson = new Lesson(`${run.prefix}/lesson.json`);
    lesson.onNews = () => this.request();
    this.views = [...VIEWS.map((View) => new View()), lesson, ...extra];
    this.drawn = 0;
    this.drawnTime = 0;
    this.#calm = matchMedia("(prefers-reduced-motion: reduce)");
    for (const view of this.views) {
      this.#frame(view, choices);
      this.#onScreen.observe(view.figure);
    }
    this.show(chosenViews() ?? DEFAULT);
    this.#isFree = chosenViews() === null;
    new ResizeObserver(() => this.refresh()).observe(place);
    document.addEventListener("visibilitychange", () => this.request());
  }

  // On a telephone most views are scrolled away, and drawing them would slow down the others.
  #onScreen = new IntersectionObserver((changes) => {
    for (const { target, isIntersecting } of changes) {
      this.views.find((view) => view.figure === target).isAway = !isIntersecting;
    }
    this.request();
  });
  #calm;
  #style = null;
  #requested = false;
  #last = 0;
  // Whether nobody has chosen views: each scene then has its own.
  #isFree = false;
  // The run for which the views are arranged.
  #arranged = null;
  #all = true;

  // The figure of a view, with its tools.
  #frame(view, choices) {
    const name = T.viewNames[view.id];
    view.canvas = make("canvas", { role: "img", "aria-label": name });
    view.visible = false;
    const tool = (text, label, act) => make("button", { textContent: text, "aria-label": label, title: label, onclick: act });
    view.enlarge = tool(T.enlarge, T.enlargeOf(name), () => this.enlarge(view.id));
    view.clip = tool(T.clip, T.clipOf(name), (event) => saveClip(view.canvas, name, event.target));
    const tools = make("span", { className: "tools" });
    if (view.id === "scope") tools.append(...this.#scopeTools(view));
    const more = make("div", { className: "quiet-tools" },
      tool(T.picture, T.pictureOf(name), () => {
        savePicture(name, this.run, (...where) => view.draw(...where.slice(0, 3), this.run.data, where[3], this.over?.data));
        this.refresh();
      }),
      view.clip,
      view.enlarge,
    );
    const caption = make("figcaption", {}, make("span", { textContent: name, title: T.viewHints[view.id] }), tools);
    const hint = make("p", { className: "hint fine", textContent: T.viewHints[view.id] });
    view.figure = make("figure", { className: `view-${view.id}` }, caption, more, hint, view.canvas);
    const choice = make("input", { type: "checkbox", onchange: () => this.#choose() });
    view.choice = choice;
    choices?.append(make("label", {}, choice, ` ${name}`));
  }

  #scopeTools(view) {
    const options = [new Option(T.sweepAuto, 0), ...SWEEPS_MS.map((ms) => new Option(T.sweepOf(ms), ms))];
    const sweep = make("select", { "aria-label": T.sweep, title: T.sweep }, ...options);
    sweep.value = view.sweep;
    sweep.onchange = () => {
      view.sweep = Number(sweep.value);
      this.refresh();
    };
    const trigger = make("input", { type: "checkbox", checked: view.trigger });
    trigger.onchange = () => {
      view.trigger = trigger.checked;
      this.refresh();
    };
    return [sweep, make("label", {}, trigger, T.trigger)];
  }

  #choose() {
    const chosen = this.views.filter((view) => view.choice.checked).map((view) => view.id);
    if (chosen.length) localStorage.setItem("views", JSON.stringify(chosen));
    this.show(chosen.length ? chosen : this.shown);
  }

  // Shows these views, in the order of the page.
  show(ids) {
    this.#isFree = false;
    this.shown = this.views.map((view) => view.id).filter((id) => ids.includes(id));
    if (this.shown.length === 0) this.shown = [...DEFAULT];
    this.one = null;
    this.#place();
  }

  // Draws another run over this one, in the views of curves.
  overlay(run) {
    this.over = run;
    this.refresh();
  }

  // Arranges the views for half of the page, or for all of it.
  setNarrow(narrow) {
    this.narrow = narrow;
    this.#place();
  }

  // The views that are visible.
  get visible() {
    const { start } = this.run.data;
    const isSmall = start.scene !== undefined && start.patch_radius_m === undefined;
    const present = isSmall ? this.shown.filter((id) => !JOINT.includes(id)) : [];
    return this.one ? [this.one] : present.length ? present : this.shown;
  }

  // Shows one view, or all chosen ones again.
  enlarge(id) {
    this.one = this.one === id ? null : id;
    this.#place();
  }

  #place() {
    const ids = this.visible;
    for (const view of this.views) {
      const visible = ids.includes(view.id);
      view.choice.checked = this.shown.includes(view.id);
      view.enlarge.textContent = this.one ? T.reduce : T.enlarge;
      view.enlarge.setAttribute("aria-label", this.one ? T.reduceOf(T.viewNames[view.id]) : T.enlargeOf(T.viewNames[view.id]));
      // An element that keeps its place keeps the focus.
      if (visible && !view.figure.isConnected) this.place.append(view.figure);
      if (!visible) view.figure.remove();
    }
    const order = this.views.filter((view) => view.figure.isConnected).map((view) => view.figure);
    if ([...this.place.children].some((figure, k) => figure !== order[k])) this.place.replaceChildren(...order);
    const count = ids.length;
    const wide = count <= 2 ? count : count === 4 ? 2 : count > 6 ? Math.ceil(count / 2) : 3;
    const columns = this.narrow ? (count <= 3 ? 1 : 2) : wide;
    this.place.style.setProperty("--columns", columns);
    // The last view fills the last row.
    this.place.style.setProperty("--last", columns - ((count - 1) % columns));
    this.place.classList.toggle("one", count === 1);
    this.refresh();
    this.onPlaced?.();
  }

  // Draws everything again, for example in other colours or sizes.
  refresh() {
    this.#style = null;
    this.#all = true;
    this.request();
  }

  // Draws everything at once, for a printer.
  redraw() {
    this.#style = null;
    this.#all = true;
    this.#draw();
  }

  // Draws what is new with the next picture of the screen.
  request() {
    if (this.#requested || document.hidden) return;
    this.#requested = true;
    const wait = this.#calm.matches ? Math.max(0, this.#last + CALM - performance.now()) : 0;
    if (wait) setTimeout(() => requestAnimationFrame(() => this.#draw()), wait);
    else requestAnimationFrame(() => this.#draw());
  }

  #draw() {
    this.#requested = false;
    this.#last = performance.now();
    this.run.advance();
    const data = this.run.data;
    if (!data.run) return;
    if (this.#arranged !== data.run) {
      this.#arranged = data.run;
      if (this.#isFree) {
        const { lesson } = data.start;
        this.show(lesson && !RECURRENT.includes(lesson) ? TAUGHT : DEFAULT);
        this.#isFree = true;
      } else this.#place();
    }
    this.#style ??= readStyle();
    for (const view of this.views) {
      if (!view.figure.isConnected) continue;
      const isClipped = view.clip.disabled;
      if (view.isAway && !isClipped && !this.#all) continue;
      const version = `${data.run} ${data.versions[view.needs] ?? view.version?.(data)}`;
      if (!this.#all && version === view.drawnVersion) continue;
      view.drawnVersion = version;
      this.#drawView(view, data);
    }
    this.#all = false;
    this.drawn++;
    this.drawnTime = performance.now() - this.#last;
    this.onDrawn?.(data);
    if (this.run.drawn()) this.request();
  }

  #drawView(view, data) {
    const canvas = view.canvas;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (width < 20 || height < 20) return;
    const ratio = Math.min(2, window.devicePixelRatio || 1);
    const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
    if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
    const context = canvas.getContext("2d", { willReadFrequently: true });
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.fillStyle = this.#style.ground;
    context.fillRect(0, 0, width, height);
    view.draw(context, width, height, data, this.#style, this.over?.data);
  }

  // Describes the views for screen readers; not more often than the motion changes.
  describe(now) {
    for (const view of this.views) {
      const label = T.viewLabel(T.viewNames[view.id], now);
      if (view.canvas.getAttribute("aria-label") !== label) view.canvas.setAttribute("aria-label", label);
    }
  }
}
