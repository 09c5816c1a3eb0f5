// The sliders of the numbers that a run can change: those that the scene names, the others under *More*.

import { $, make, setText } from "/dom.js";
import { T } from "/texts.js";

// Wall time for which a requested value is displayed while the server does not confirm it, ms.
const PATIENCE = 2000;
// Steps of a slider, of an arrow key and of an arrow key with Shift, relative to the range.
const STEPS = { slide: 1e-3, arrow: 1e-2, shifted: 5e-2 };
// Ratio of the ends of a range from which the slider is logarithmic.
const WIDE = 30;
// The number of the diagram.
export const TILT = "load.tilt_deg";

// The numbers of a run that differ from those of its scene, by key. A tilt that a schedule moves is held.
export function changedNumbers({ controls }) {
  return Object.fromEntries(controls.filter(({ value, start }) => value !== start).map(({ key, value }) => [key, value]));
}

class Slider {
  // A requested value that the server has not confirmed, and until when it is displayed.
  #asked = null;
  #askedUntil = 0;

  // `send` sends a value.
  constructor(control, send) {
    const { key, label, unit, meaning, range } = control;
    Object.assign(this, { key, unit, range, send });
    this.log = range[0] > 0 && range[1] > WIDE * range[0];
    const [min, max] = this.log ? range.map(Math.log) : range;
    const name = make("label", { textContent: label, htmlFor: key, title: meaning });
    this.now = make("output", { id: `${key}-now`, htmlFor: key });
    this.input = make("input", { id: key, type: "range", min, max, step: STEPS.slide * (max - min) });
    this.element = make("div", { className: "control" }, make("div", {}, name, this.now), this.input);
    this.input.oninput = () => this.ask(this.log ? Math.exp(this.input.value) : Number(this.input.value));
    this.input.onkeydown = (event) => {
      const sign = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
      if (!sign) return;
      event.preventDefault();
      this.nudge(sign, event.shiftKey);
    };
    this.display(control.value);
  }

  display(value) {
    this.value = value;
    this.input.value = this.log ? Math.log(value) : value;
    const text = T.value(value, this.unit);
    setText(this.now, text);
    this.input.setAttribute("aria-valuetext", text);
  }

  // Displays the present value; a requested one is displayed until it is applied or rejected.
  show(value, paused) {
    const applied = Math.abs(value - this.#asked) <= STEPS.slide * (this.range[1] - this.range[0]);
    if (applied || (!paused && performance.now() > this.#askedUntil)) this.#asked = null;
    this.display(this.#asked ?? value);
  }

  forget() {
    this.#asked = null;
  }

  ask(value) {
    const [low, high] = this.range;
    this.#asked = Math.min(high, Math.max(low, Number(value.toPrecision(6))));
    this.#askedUntil = performance.now() + PATIENCE;
    this.display(this.#asked);
    this.send(this.#asked);
  }

  nudge(sign, shifted) {
    const by = sign * (shifted ? STEPS.shifted : STEPS.arrow);
    const [low, high] = this.range;
    this.ask(this.log ? this.value * (high / low) ** by : this.value + by * (high - low));
  }
}

export class Controls {
  #sliders = [];
  #shown = null;
  #send;

  // `send` sends a key and its value.
  constructor(send) {
    this.#send = send;
  }

  // Shows the controls of a run.
  show({ run, scene, controls, paused }) {
    const shown = `${scene} ${run} ${controls.map(({ key }) => key)}`;
    if (shown !== this.#shown) {
      this.#shown = shown;
      this.#build(controls);
    }
    controls.forEach(({ value }, k) => this.#sliders[k].show(value, paused));
  }

  #build(controls) {
    this.#sliders = controls.map((control) => new Slider(control, (value) => this.#send(control.key, value)));
    const [first, ...others] = this.#sliders.map(({ element }) => element);
    const named = controls.filter((control) => control.named).length;
    $("sliders").hidden = !first;
    $("slider-first").replaceChildren(...(first ? [first] : []));
    $("slider-others").replaceChildren(...others.slice(0, Math.max(0, named - 1)), $("slider-more"));
    $("slider-rest").replaceChildren(...others.slice(Math.max(0, named - 1)));
    $("slider-more").hidden = others.length < named;
    const audience = document.body.classList.contains("audience");
    for (const { input } of this.#sliders) input.disabled = audience;
    $("bands").hidden = $("legend").hidden = $("diagram-note").hidden = controls[0]?.key !== TILT;
  }

  // Moves the first slider.
  nudge(sign, shifted) {
    this.#sliders[0]?.nudge(sign, shifted);
  }

  // A request was refused: the present values are shown.
  refused() {
    this.#sliders.forEach((slider) => slider.forget());
  }
}
