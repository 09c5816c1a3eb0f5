// The recurrence plot: dark where the motion returns close to an earlier state.

import { Plot, note } from "/plot.js";
import shared from "/shared.js";
import { T } from "/texts.js";

export class Recurrence {
  id = "recurrence";
  needs = "recurrence";
  #canvas = document.createElement("canvas");
  #drawn = null;

  draw(c, width, height, data, style) {
    const plotted = data.recurrence;
    const span = 1e3 * (plotted?.window ?? 12e-3);
    const axis = { range: [0, span], label: T.timeMs };
    const plot = new Plot(c, width, height, style, axis, axis);
    // A square in the middle of the space.
    const side = Math.min(plot.right - plot.left, plot.bottom - plot.top);
    plot.left += (plot.right - plot.left - side) / 2;
    plot.right = plot.left + side;
    plot.top = plot.bottom - side;
    plot.axes();
    if (!plotted) return note(c, width, height, style, T.notYet);
    // In a small picture several cells share a pixel: their mean keeps the density of the lines.
    const merged = Math.max(1, Math.ceil(plotted.size / (side * (window.devicePixelRatio || 1)) - 0.1));
    const key = `${data.run} ${data.versions.recurrence} ${style.light} ${merged}`;
    if (this.#drawn !== key) {
      this.#drawn = key;
      this.#paint(plotted, style, merged);
    }
    c.imageSmoothingEnabled = true;
    c.imageSmoothingQuality = "high";
    c.drawImage(this.#canvas, plot.left, plot.top, side, side);
  }

  #paint({ bits, size }, style, merged) {
    const canvas = this.#canvas;
    const side = Math.ceil(size / merged);
    canvas.width = canvas.height = side;
    const context = canvas.getContext("2d");
    const image = context.createImageData(side, side);
    const shares = new Float64Array(side * side);
    for (let i = 0; i < size; i++) {
      for (let j = 0; j < size; j++) {
        const at = i * size + j;
        // The first row is the oldest state, at the bottom.
        const row = side - 1 - Math.floor(i / merged);
        if (bits[at >> 3] & (0x80 >> (at & 7))) shares[row * side + Math.floor(j / merged)] += 1 / merged ** 2;
      }
    }
    const [red, green, blue] = shared.signal[style.light ? 0 : 1];
    shares.forEach((share, at) => image.data.set([red, green, blue, 255 * share], 4 * at));
    context.putImageData(image, 0, 0);
  }
}
