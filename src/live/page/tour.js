// The guided tour: a large sentence, the views and the numbers of each step; and the presenter's window with the
// notes, which steers the tour of the other windows of this browser.

import { $, make, setText } from "/dom.js";
import { motion, speedText } from "/panel.js";
import { T } from "/texts.js";

const kilo = (hz) => `${(1e-3 * hz).toFixed(3)} kHz`;

// The numbers of a run, in words, from its panel and the data of its views; `null` while they are not known.
const QUANTITIES = {
  motion,
  lines: (panel) => panel.lines.slice(0, 3).map((l) => `${l.label ? `${l.label} ` : ""}${kilo(l.frequency_hz)}`).join(", ") || null,
  halves: (panel, data) => data.lines.filter(({ label }) => label.endsWith("/2")).slice(0, 2).map((l) => `${l.label} ${kilo(l.frequency_hz)}`).join(", ") || null,
  difference(panel) {
    const base = (name) => panel.lines.find(({ label }) => label === name)?.frequency_hz;
    const [f1, f2] = [base("f1"), base("f2")];
    return f1 && f2 ? kilo(Math.abs(f1 - f2)) : null;
  },
  "peak-velocity": (panel) => `${panel.peak_velocity_mm_per_s.toPrecision(3)} mm/s`,
  tilt: (panel) => (panel.tilt_deg === null ? null : T.degrees(panel.tilt_deg)),
  nodes: (panel) => panel.nodes && T.nodesShort(...panel.nodes.map((count) => count.toFixed(0))),
};

export class Tour {
  step = null;
  #tour = null;
  #run;
  #show;
  #channel = new BroadcastChannel("squeakscope tour");
  // Whether the tour starts as soon as the run is known.
  #starts = false;

  // `show` shows views.
  constructor(run, show) {
    this.#run = run;
    this.#show = show;
    this.presents = new URLSearchParams(location.search).has("presenter");
    $("tour-next").onclick = () => this.go(this.step + 1);
    $("tour-back").onclick = () => this.go(this.step - 1);
    $("tour-end").onclick = () => this.end();
    $("tour-window").onclick = () => this.#openWindow();
    this.#channel.onmessage = ({ data }) => (data.step === null ? this.#hide() : this.#display(data.step, data.from));
    this.#load();
  }

  async #load() {
    const { tour, starts } = await (await fetch("/tour.json")).json().catch(() => ({}));
    this.#tour = tour;
    $("tour-start").hidden = !tour;
    if (!tour) return;
    document.body.classList.toggle("presenter", this.presents);
    if (this.presents) this.#display(0);
    else this.#starts = starts;
  }

  // Starts the tour, or ends it.
  toggle() {
    if (this.step === null) this.go(0);
    else this.end();
  }

  go(step) {
    if (!this.#tour || !this.#tour.steps[step]) return;
    this.#display(step);
    this.#channel.postMessage({ step, from: this.presents ? "presenter" : "page" });
    // The window with the views sends the commands.
    if (!this.presents) this.#apply(this.#tour.steps[step]);
  }

  end() {
    this.#hide();
    this.#channel.postMessage({ step: null });
  }

  #hide() {
    this.step = null;
    $("tour-bar").hidden = true;
    $("tour-start").setAttribute("aria-pressed", false);
  }

  #display(step, from) {
    const { steps, title } = this.#tour ?? { steps: [] };
    if (!steps[step]) return;
    this.step = step;
    if (from === "presenter" && !this.presents) this.#apply(steps[step]);
    $("tour-bar").hidden = false;
    $("tour-start").setAttribute("aria-pressed", true);
    setText($("tour-count"), T.tourCount(title, step + 1, steps.length));
    setText($("tour-say"), steps[step].say);
    $("tour-back").disabled = step === 0;
    $("tour-next").disabled = step === steps.length - 1;
    const next = steps[step + 1];
    const words = [...steps[step].notes.trim().split(/\n\s*\n/), next ? T.tourNext(next.say) : T.tourLast];
    $("tour-notes").replaceChildren(...words.filter(Boolean).map((text) => make("p", { textContent: text })));
    this.update(this.#run.panel);
  }

  // Sends the commands of a step.
  #apply(step) {
    const run = this.#run;
    if (step.views.length) this.#show(step.views);
    const commands = [];
    if (step.tilt_deg !== null) commands.push({ do: "tilt", deg: step.tilt_deg });
    if (step.kick_mm_per_s !== null) commands.push({ do: "kick", mm_per_s: step.kick_mm_per_s });
    if (step.speed_ms_per_s !== null) run.ask({ do: "speed", ms_per_s: step.speed_ms_per_s });
    const scene = step.scene ?? run.scene;
    if (scene !== run.scene || step.restart) run.start(scene, commands);
    else run.follow(run.panel?.paused ? [...commands, { do: "resume" }] : commands);
  }

  // Shows the numbers that the present run measures.
  update(panel) {
    if (this.#starts && panel?.time_s > 0) {
      this.#starts = false;
      this.go(0);
    }
    if (!panel || this.step === null) return;
    const { watch } = this.#tour.steps[this.step];
    const rows = watch.map((name) => [T.quantities[name], QUANTITIES[name](panel, this.#run.data) ?? "–"]);
    rows.push([T.speed, speedText(1e3 * panel.speed)]);
    const key = JSON.stringify(rows);
    if (key === this.shown) return;
    this.shown = key;
    $("tour-numbers").replaceChildren(
      ...rows.map(([name, value]) => make("div", {}, make("dt", { textContent: name }), make("dd", { textContent: value }))),
    );
  }

  #openWindow() {
    const query = new URLSearchParams(location.search);
    query.set("presenter", "1");
    window.open(`/?${query}`, "presenter", "width=900,height=600");
  }
}
