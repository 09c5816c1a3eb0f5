// The oscilloscope: the velocity of the probe over time, triggered where it rises through zero. Earlier sweeps
// remain visible for a moment: a periodic motion covers them, a torus and chaos do not.

import { FullScale, Plot, unit } from "/plot.js";
import shared from "/shared.js";
import { T } from "/texts.js";

const EARLIER = 7;
export const SWEEPS_MS = [0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500];
// Periods of the strongest line in an automatic sweep.
const PERIODS = 8;

export class Scope {
  id = "scope";
  needs = "samples";
  #scale = new FullScale();
  // Length of a sweep, ms, or 0 for one that suits the scene, and whether it starts at a trigger.
  sweep = 0;
  // The run, and the frequency of its first strongest line, Hz.
  #tone = {};
  trigger = true;

  draw(c, width, height, data, style, other) {
    const v = data.velocity;
    if (this.#tone.run !== data.run) this.#tone = { run: data.run };
    this.#tone.hz ??= data.lines[0]?.frequency_hz;
    const wanted = (1e3 * PERIODS) / (this.#tone.hz ?? 4e3);
    const sweep = this.sweep || (SWEEPS_MS.find((ms) => ms >= wanted) ?? SWEEPS_MS.at(-1));
    const length = Math.max(2, Math.min(v.length - 1, Math.round((1e-3 * sweep) / data.dt)));
    let peak = 0;
    for (let k = 0; k < Math.min(v.length, 4 * length); k++) peak = Math.max(peak, Math.abs(v.at(k)));
    const full = this.#scale.update(peak, data.start.silence_m_per_s);
    const { per, symbol } = unit(full, "m/s");
    const x = { range: [0, sweep], label: T.timeMs };
    const y = { range: [-full * per, full * per], label: `${shared.velocity}, ${symbol}` };
    const plot = new Plot(c, width, height, style, x, y);
    plot.axes();
    if (v.length < 3) return;
    const starts = this.#starts(v, length);
    plot.clip(() => {
      if (other) this.#newest(c, plot, other, per, style, sweep);
      c.lineWidth = Math.max(1.2, style.em / 10);
      c.lineJoin = "round";
      c.strokeStyle = style.signal;
      starts.reverse().forEach(({ age, shift }, k) => {
        c.globalAlpha = k === starts.length - 1 ? 1 : 0.22;
        c.beginPath();
        for (let i = 0; i <= length && i <= age; i++) {
          c.lineTo(plot.X(1e3 * data.dt * (i - shift)), plot.Y(v.at(age - i) * per));
        }
        c.stroke();
      });
      c.globalAlpha = 1;
    });
    if (this.trigger) {
      c.fillStyle = style.mark;
      c.beginPath();
      const [at, size] = [plot.Y(0), 0.4 * style.em];
      c.moveTo(plot.left - size, at - size);
      c.lineTo(plot.left, at);
      c.lineTo(plot.left - size, at + size);
      c.fill();
    }
  }

  // The newest sweep of another run.
  #newest(c, plot, other, per, style, sweep) {
    const v = other.velocity;
    const length = Math.min(v.length - 1, Math.round((1e-3 * sweep) / other.dt));
    if (length < 2) return;
    const [{ age, shift }] = this.#starts(v, length);
    c.lineWidth = Math.max(1.2, style.em / 10);
    c.strokeStyle = style.second;
    c.beginPath();
    for (let i = 0; i <= length && i <= age; i++) {
      c.lineTo(plot.X(1e3 * other.dt * (i - shift)), plot.Y(v.at(age - i) * per));
    }
    c.stroke();
  }

  // Ages of the first samples of the newest sweeps, newest first, with the trigger between two samples.
  #starts(v, length) {
    const found = [];
    if (this.trigger) {
      for (let age = length; age < v.length - 1 && found.length <= EARLIER; age++) {
        const [before, after] = [v.at(age + 1), v.at(age)];
        if (before < 0 && after >= 0) found.push({ age: age + 1, shift: before / (before - after) });
      }
    }
    return found.length ? found : [{ age: length, shift: 0 }];
  }
}
