// The spectrogram: the level of each frequency over time, newest at the right.

import { Plot, note } from "/plot.js";
import { COLUMNS } from "/data.js";
import shared from "/shared.js";
import { T } from "/texts.js";

// The colour map of the recording, of increasing lightness; on a light ground in reverse.
function colours(light) {
  const table = new Uint32Array(256);
  for (let k = 0; k < 256; k++) {
    const [r, g, b] = shared.spectrogram[light ? 255 - k : k];
    table[k] = (255 << 24) | (b << 16) | (g << 8) | r;
  }
  return table;
}

export class Spectrogram {
  id = "spectrogram";
  needs = "columns";
  #canvas = document.createElement("canvas");
  #drawn = 0;
  #run = null;
  #light = null;
  #table = null;

  draw(c, width, height, data, style) {
    const last = data.columns.at(-1);
    const highest = 1e-3 * (data.columnBin ?? 1e3) * (last?.length ?? 20);
    const span = 1e3 * (data.columnEvery ?? 1e-3) * COLUMNS;
    const x = { range: [-span, 0], label: T.timeMs };
    const y = { range: [0, highest], label: T.frequencyKhz };
    const plot = new Plot(c, width, height, style, x, y);
    plot.axes();
    if (!last) return note(c, width, height, style, T.notYet);
    this.#update(data, style, last.length);
    // The columns form a ring: the oldest one follows the newest one.
    const oldest = data.versions.columns % COLUMNS;
    const step = (plot.right - plot.left) / COLUMNS;
    const tall = plot.bottom - plot.top;
    c.imageSmoothingEnabled = false;
    const part = (from, count, at) =>
      count && c.drawImage(this.#canvas, from, 0, count, last.length, plot.left + at * step, plot.top, count * step, tall);
    part(oldest, COLUMNS - oldest, 0);
    part(0, oldest, COLUMNS - oldest);
  }

  // Writes the columns that are new.
  #update(data, style, bins) {
    const [canvas, total] = [this.#canvas, data.versions.columns];
    if (this.#run !== data.run || this.#light !== style.light || canvas.height !== bins) {
      [canvas.width, canvas.height] = [COLUMNS, bins];
      [this.#run, this.#light, this.#drawn] = [data.run, style.light, 0];
      this.#table = colours(style.light);
    }
    const context = canvas.getContext("2d");
    const image = context.createImageData(1, bins);
    const pixels = new Uint32Array(image.data.buffer);
    const first = Math.max(this.#drawn, total - data.columns.length);
    for (let k = first; k < total; k++) {
      const column = data.columns[data.columns.length - (total - k)];
      for (let i = 0; i < bins; i++) pixels[bins - 1 - i] = this.#table[column[i] ?? 0];
      context.putImageData(image, k % COLUMNS, 0);
    }
    this.#drawn = total;
  }
}
