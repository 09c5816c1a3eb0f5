// Two runs side by side: A, the run of the page, and B, a second one on the server.

import { changedNumbers } from "/controls.js";
import { $, make, setText } from "/dom.js";
import { motion } from "/panel.js";
import { Run } from "/run.js";
import { Stage } from "/stage.js";
import { T } from "/texts.js";

// Kick of the perturbed copy, mm/s: much smaller than a squeak, and larger than the errors of the steps.
const PERTURBATION = 1e-4;

// Views of each run if all chosen ones would be too small.
const COMPARED = ["portrait", "scope", "spectrum", "section"];

const summary = ({ scene, tilt_deg: tilt, ...panel }) => `${scene}${tilt === null ? "" : `, ${T.degrees(tilt)}`}: ${motion(panel)}`;

export class Comparison {
  second = null;
  #run;
  #stage;
  #diagram;
  #other = null;
  // Views before the comparison.
  #chosen = null;

  constructor(run, stage, diagram) {
    this.#run = run;
    this.#stage = stage;
    this.#diagram = diagram;
    $("compare-same").onclick = () => this.#perturb();
    $("compare-over").onchange = () => this.#arrange();
    stage.onPlaced = () => this.#other?.show(stage.visible);
  }

  get open() {
    return this.second !== null;
  }

  // Whether the controls act on B alone.
  get controlsSecond() {
    return this.open && $("compare-target").value === "b";
  }

  // The runs that a command controls: as chosen, while two runs are shown.
  ask(command) {
    if (!this.controlsSecond) this.#run.ask(command);
    if (this.open && $("compare-target").value !== "a") this.second.ask(command);
  }

  toggle() {
    const open = !this.open;
    $("compare").setAttribute("aria-pressed", open);
    $("compare-bar").hidden = $("name-a").hidden = !open;
    if (!open) {
      // A second run that is not shown must not slow the first one.
      this.second.ask({ do: "pause" });
      const { second } = this;
      setTimeout(() => second.close(), 200);
      this.second = this.#other = null;
      this.#diagram.mark(null, 1);
      $("views-b").replaceChildren();
      this.#arrange();
      if (this.#chosen) this.#stage.show(this.#chosen);
      this.#chosen = null;
      return;
    }
    let begun = false;
    this.second = new Run("/b", {
      connected: () => {},
      panel: (panel) => {
        if (!begun) {
          begun = true;
          this.#together({}, {});
        }
        setText($("now-b"), summary(panel));
        this.#diagram.mark(panel.tilt_deg, 1);
        this.onPanel?.(panel);
      },
      refused: (words) => this.onRefused?.(words),
      data: () => this.#other?.request(),
    });
    this.#other = new Stage(this.second, $("views-b"));
    this.#other.setNarrow(true);
    if (this.#stage.visible.length > COMPARED.length) {
      this.#chosen = this.#stage.shown;
      this.#stage.show(COMPARED);
    } else this.#other.show(this.#stage.visible);
    this.#arrange();
  }

  // Both runs beside each other, or B drawn over A.
  #arrange() {
    const over = this.open && $("compare-over").checked;
    $("stage-b").hidden = !this.open || over;
    $(over ? "name-a" : "name-b").append($("label-b"));
    this.#stage.setNarrow(this.open && !over);
    this.#stage.overlay(over ? this.second : null);
  }

  // Starts both runs at the present scene and speed, each with its settings.
  #together(first, second) {
    const { scene, speed } = this.#run.panel;
    const same = { do: "open", scene, speed_ms_per_s: 1e3 * speed };
    this.#run.ask({ ...same, ...first });
    this.second.ask({ ...same, ...second });
  }

  // Two equal runs, of which B gets a tiny kick: chaos parts them, a tone and a torus do not.
  #perturb() {
    const set = changedNumbers(this.#run.panel);
    this.#together({ set }, { set, kick_mm_per_s: PERTURBATION });
  }

  update(panel) {
    if (this.open) setText($("now-a"), summary(panel));
  }
}
