// The guided tour: a large sentence, the views and the numbers of each step; and the presenter's window with the
// notes. The server holds the step, so that all pages show the same one.

import { $, make, setText } from "/dom.js";
import { motion, peakVelocity, speedText } from "/panel.js";
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
  "peak-velocity": peakVelocity,
  tilt: (panel) => (panel.tilt_deg === null ? null : T.degrees(panel.tilt_deg)),
  nodes: (panel) => panel.nodes && T.nodesShort(...panel.nodes.map((count) => count.toFixed(0))),
};

export class Tour {
  // The step that the server shows, from 0; `null` without one.
  step = null;
  #tour = null;
  #run;
  #show;

  // `show` shows views.
  constructor(run, show) {
    this.#run = run;
    this.#show = show;
    this.presents = new URLSearchParams(location.search).has("presenter");
    $("tour-next").onclick = () => this.move(1);
    $("tour-back").onclick = () => this.move(-1);
    $("tour-end").onclick = () => this.#ask(null);
    $("tour-window").onclick = () => this.#openWindow();
  }

  // Sets the tour of the server; `null` if it has none.
  set tour(tour) {
    this.#tour = tour;
    $("tour-start").hidden = !tour;
    if (!tour) return;
    document.body.classList.toggle("presenter", this.presents);
    const entries = tour.steps.map(({ say }, k) => make("li", {}, make("button", { textContent: say, onclick: () => this.#ask(k) })));
    $("tour-steps").replaceChildren(...entries);
    if (this.presents) setInterval(() => setText($("tour-clock"), new Date().toLocaleTimeString()), 500);
    this.#display();
  }

  // Starts the tour, or ends it.
  toggle() {
    this.#ask(this.step === null ? 0 : null);
  }

  // Moves by steps; before the first one the tour has not started.
  move(by) {
    const step = (this.step ?? -1) + by;
    if (this.#tour?.steps[step]) this.#ask(step);
  }

  #ask(step) {
    this.#run.ask({ do: "tour", step });
  }

  #display() {
    const { steps, title } = this.#tour;
    const shown = steps[this.step];
    $("tour-bar").hidden = !shown && !this.presents;
    $("tour-start").setAttribute("aria-pressed", Boolean(shown));
    setText($("tour-count"), shown ? T.tourCount(title, this.step + 1, steps.length) : title);
    setText($("tour-say"), shown?.say ?? T.tourReady);
    $("tour-back").disabled = !steps[this.step - 1];
    $("tour-next").disabled = Boolean(shown) && !steps[this.step + 1];
    const notes = (step) => step?.notes.trim().split(/\n\s*\n/) ?? [];
    const next = steps[(this.step ?? -1) + 1];
    const words = [...notes(shown), next ? T.tourNext(next.say) : T.tourLast, ...notes(next)];
    const paragraphs = words.map((text, k) => make("p", { textContent: text, className: k < notes(shown).length ? "" : "next" }));
    $("tour-notes").replaceChildren(...paragraphs);
    [...$("tour-steps").children].forEach((entry, k) => entry.setAttribute("aria-current", k === this.step ? "step" : "false"));
    if (shown?.views.length) this.#show(shown.views);
  }

  // Shows the numbers that the present run measures.
  update(panel) {
    if (this.#tour && panel.tour_step !== this.step) {
      this.step = panel.tour_step;
      this.#display();
    }
    const step = this.#tour?.steps[this.step];
    if (!step) return;
    const rows = step.watch.map((name) => [T.quantities[name], QUANTITIES[name](panel, this.#run.data) ?? "–"]);
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
