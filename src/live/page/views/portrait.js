// The phase portrait: velocity over displacement of the probe, a trail that fades with age.

import { FullScale, Plot, unit } from "/plot.js";
import shared from "/shared.js";

const PIECES = 12;

const lengthOf = (data) => Math.min(data.displacement.length, Math.max(512, Math.round(shared.trail_s / data.dt)));

export class Portrait {
  id = "portrait";
  needs = "samples";
  #scales = [new FullScale(), new FullScale()];

  draw(c, width, height, data, style, other) {
    const runs = other ? [other, data] : [data];
    let [du, dv] = [0, 0];
    for (const run of runs) {
      for (let k = 0; k < lengthOf(run); k++) {
        du = Math.max(du, Math.abs(run.displacement.at(k)));
        dv = Math.max(dv, Math.abs(run.velocity.at(k)));
      }
    }
    // Silence looks silent: of a tone of 1 kHz the displacement is this much smaller than the velocity.
    const silence = data.start.silence_m_per_s;
    const full = [this.#scales[0].update(du, silence / 6283), this.#scales[1].update(dv, silence)];
    const units = [unit(full[0], "m"), unit(full[1], "m/s")];
    const axis = (k, name) => {
      const f = full[k] * units[k].per;
      return { range: [-f, f], label: `${name}, ${units[k].symbol}` };
    };
    const plot = new Plot(c, width, height, style, axis(0, shared.displacement), axis(1, shared.velocity));
    plot.axes();
    plot.clip(() => {
      if (other) this.#trail(c, plot, other, units, style, style.second);
      this.#trail(c, plot, data, units, style, style.signal);
    });
  }

  #trail(c, plot, data, units, style, colour) {
    const { displacement: u, velocity: v } = data;
    const length = lengthOf(data);
    c.strokeStyle = colour;
    c.lineWidth = Math.max(1, style.em / 13);
    c.lineJoin = "round";
    // The oldest piece first, each more opaque than the one before.
    for (let piece = PIECES - 1; piece >= 0; piece--) {
      const [from, to] = [piece, piece + 1].map((k) => Math.floor((k * length) / PIECES));
      c.globalAlpha = 0.1 + 0.9 * (1 - (piece + 0.5) / PIECES) ** 1.6;
      c.beginPath();
      for (let k = Math.min(to, length - 1); k >= from; k--) {
        c.lineTo(plot.X(u.at(k) * units[0].per), plot.Y(v.at(k) * units[1].per));
      }
      c.stroke();
    }
    c.globalAlpha = 1;
    if (length === 0) return;
    c.fillStyle = colour === style.second ? colour : style.mark;
    c.beginPath();
    c.arc(plot.X(u.at(0) * units[0].per), plot.Y(v.at(0) * units[1].per), 0.35 * style.em, 0, 7);
    c.fill();
  }
}
