// The spectrum of the velocity of the probe, with its named lines.

import { minus } from "/dom.js";
import { Labels, Plot, note } from "/plot.js";
import shared from "/shared.js";
import { T } from "/texts.js";

const DECADES = [-4, 2];
const ROWS = 3;
// Height of the type below which a row less is used, and the distance to which a name moves away from its line.
const LOW = 16;
const REACH = 9;

const isBase = (label) => /^f\d+$/.test(label);
export const power = (d) => `10${[..."" + d].map((x) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[x] ?? "⁻").join("")}`;

export class Spectrum {
  id = "spectrum";
  needs = "spectrum";

  draw(c, width, height, data, style, other) {
    const highest = (data.start.highest_frequency_hz ?? 2e4) / 1e3;
    const x = { range: [0, highest], label: T.frequencyKhz };
    const decades = Array.from({ length: DECADES[1] - DECADES[0] + 1 }, (_, k) => DECADES[0] + k);
    const y = { range: DECADES, label: T.amplitude, format: power };
    const row = 1.15 * style.em;
    const rows = height < LOW * style.em ? ROWS - 1 : ROWS;
    const plot = new Plot(c, width, height, style, x, y, (rows - 1) * row + 0.4 * style.em);
    const every = Math.ceil((style.em * decades.length) / (plot.bottom - plot.top));
    y.ticks = decades.filter((d) => (d - DECADES[1]) % every === 0);
    plot.axes();
    if (!data.spectrum) return note(c, width, height, style, T.notYet);
    const level = (a) => plot.Y(Math.max(DECADES[0], Math.log10(1e3 * a)));
    plot.clip(() => {
      if (other?.spectrum) {
        c.strokeStyle = style.second;
        c.beginPath();
        other.spectrum.forEach((a, k) => c.lineTo(plot.X(1e-3 * other.bin * k), level(a)));
        c.stroke();
      }
      c.strokeStyle = style.signal;
      c.fillStyle = style.signal;
      c.lineWidth = Math.max(1, style.em / 13);
      c.beginPath();
      data.spectrum.forEach((a, k) => c.lineTo(plot.X((1e-3 * data.bin) * k), level(a)));
      c.stroke();
      c.lineTo(plot.right, plot.bottom);
      c.lineTo(plot.left, plot.bottom);
      c.globalAlpha = 0.14;
      c.fill();
      c.globalAlpha = 1;
    });
    // Base frequencies keep their names first.
    const named = data.lines.toSorted((a, b) => isBase(b.label) - isBase(a.label)).slice(0, shared.named_lines);
    this.#names(c, plot, named, level, [row, rows], style, c.measureText(T.amplitude).width + style.em);
  }

  // Each name takes the place nearest to its line where it covers no other; a name without space is left out.
  #names(c, plot, lines, level, [row, rows], style, label) {
    const labels = new Labels(plot.left, plot.right, rows);
    // The lowest row begins with the label of the axis.
    labels.block(0, 0, label);
    c.font = `600 ${0.8 * style.em}px ${style.family}`;
    c.textAlign = "center";
    c.textBaseline = "bottom";
    for (const { frequency_hz: hz, amplitude, label } of lines) {
      const at = plot.X(1e-3 * hz);
      if (at > plot.right) continue;
      c.fillStyle = style.mark;
      c.beginPath();
      c.arc(at, level(amplitude), 0.22 * style.em, 0, 7);
      c.fill();
      const name = `${label ? `${minus(label)} ` : ""}${(1e-3 * hz).toFixed(2)}`;
      const half = c.measureText(name).width / 2 + 0.3 * style.em;
      const place = labels.place(at, half, isBase(label) ? REACH * style.em : half);
      if (!place) continue;
      const base = plot.top - 0.1 * style.em - place.row * row;
      c.fillStyle = style.text;
      c.fillText(name, place.middle, base);
      c.strokeStyle = style.mark;
      c.globalAlpha = 0.6;
      c.beginPath();
      c.moveTo(Math.min(Math.max(at, place.middle - half), place.middle + half), base);
      c.lineTo(at, level(amplitude));
      c.stroke();
      c.globalAlpha = 1;
    }
  }
}
