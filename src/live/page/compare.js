// Two runs side by side: A, the run of the page, and B, a second one on the server.

import { $, make, setText } from "/dom.js";
import { motion } from "/panel.js";
import { Run } from "/run.js";
import { Stage } from "/stage.js";
import { T } from "/texts.js";

// Kick of the perturbed copy, mm/s: much smaller than a squeak, and larger than the errors of the steps.
const PERTURBATION = 1e-4;

const summary = (panel) => (panel.tilt_deg === null ? motion(panel) : `${T.degrees(panel.tilt_deg)}: ${motion(panel)}`);

export class Comparison {
  second = null;
  #run;
  #stage;
  #other = null;

  constructor(run, stage) {
    this.#run = run;
    this.#stage = stage;
    $("compare-same").onclick = () => this.#perturb();
    $("compare-over").onchange = () => this.#arrange();
    stage.onPlaced = () => this.#other?.show(stage.visible);
  }

  get open() {
    return this.second !== null;
  }

  // Whether the controls act on B alone.
  get steersSecond() {
    return this.open && $("compare-target").value === "b";
  }

  // The runs that a command controls: as chosen, while two runs are shown.
  ask(command) {
    if (!this.steersSecond) this.#run.ask(command);
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
      $("views-b").replaceChildren();
      this.#arrange();
      return;
    }
    let begun = false;
    this.second = new Run("/b", {
      connected: () => {},
      panel: (panel) => {
        if (!begun) {
          begun = true;
          this.#together();
        }
        setText($("now-b"), summary(panel));
        this.onPanel?.(panel);
      },
      refused: (words) => this.onRefused?.(words),
      data: () => this.#other?.request(),
    });
    this.#other = new Stage(this.second, $("views-b"));
    this.#other.setNarrow(true);
    this.#other.show(this.#stage.visible);
    this.#arrange();
  }

  // Both runs beside each other, or B drawn over A.
  #arrange() {
    const over = this.open && $("compare-over").checked;
    $("stage-b").hidden = !this.open || over;
    this.#stage.setNarrow(this.open && !over);
    this.#stage.overlay(over ? this.second : null);
  }

  // Starts both runs at the same scene, speed and time.
  #together() {
    const { scene, speed } = this.#run.panel;
    this.second.ask({ do: "resume" });
    this.#run.ask({ do: "resume" });
    for (const run of [this.#run, this.second]) {
      run.ask({ do: "speed", ms_per_s: 1e3 * speed });
      run.ask({ do: "scene", name: scene });
    }
  }

  // Two equal runs, of which B gets a tiny kick: chaos parts them, a tone and a torus do not.
  #perturb() {
    const before = this.second.panel.run;
    const { tilt_deg: tilt } = this.#run.panel;
    this.#together();
    const wait = setInterval(() => {
      if (this.second && !(this.second.panel.run > before && this.second.panel.time_s > 0)) return;
      clearInterval(wait);
      if (tilt !== null) for (const run of [this.#run, this.second]) run?.ask({ do: "tilt", deg: tilt });
      this.second?.ask({ do: "kick", mm_per_s: PERTURBATION });
    }, 50);
  }

  update(panel) {
    if (this.open) setText($("now-a"), summary(panel));
  }
}
