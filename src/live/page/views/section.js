// The Poincaré section: a point for each crossing. One or a few points are a periodic motion, a closed curve is a
// torus, a scattered set chaos.

import { Plot, note, unit } from "/plot.js";
import { T } from "/texts.js";

// Width of the axes over the range of the points, and the smallest over the size of the motion.
const MARGIN = 1.25;
const SMALLEST = 0.3;
// The newest points determine the range, so that a transient does not.
const NEWEST = 250;

export class Section {
  id = "section";
  needs = "points";
  #ranges = [null, null];
  #run = null;

  draw(c, width, height, data, style, other) {
    if (this.#run !== data.run) [this.#run, this.#ranges] = [data.run, [null, null]];
    if (!data.points.length) return note(c, width, height, style, T.notYet);
    const named = data.start.section ?? [["", ""], ["", ""]];
    const newest = [data, other].flatMap((run) => run?.points.slice(-NEWEST) ?? []);
    const ranges = [0, 1].map((k) => this.#range(newest, k));
    // Two coordinates of one quantity have one unit.
    const isOne = named[0][1] === named[1][1];
    const axes = named.map(([name, base], k) => {
      const size = Math.max(...(isOne ? ranges.flat() : ranges[k]).map(Math.abs));
      // Modal coordinates have a root of the mass before their unit.
      const root = base.startsWith("√kg ") ? "√kg " : "";
      const { per, symbol } = unit(size, base.slice(root.length));
      return { per, range: ranges[k].map((x) => per * x), label: `${name}, ${root}${symbol}` };
    });
    const plot = new Plot(c, width, height, style, ...axes);
    const [X, Y] = [(x) => plot.X(axes[0].per * x), (y) => plot.Y(axes[1].per * y)];
    plot.axes();
    plot.clip(() => {
      const radius = Math.max(1.6, 0.14 * style.em);
      c.fillStyle = style.second;
      for (const [x, y] of other?.points ?? []) c.fillRect(X(x) - radius / 2, Y(y) - radius / 2, radius, radius);
      c.fillStyle = style.signal;
      data.points.forEach(([x, y], k) => {
        c.globalAlpha = 0.15 + 0.85 * ((k + 1) / data.points.length) ** 2;
        c.beginPath();
        c.arc(X(x), Y(y), radius, 0, 7);
        c.fill();
      });
      c.globalAlpha = 1;
      const [x, y] = data.points.at(-1);
      c.fillStyle = style.mark;
      c.beginPath();
      c.arc(X(x), Y(y), 2 * radius, 0, 7);
      c.fill();
    });
  }

  // The range of an axis. A range that still fits is kept, so that the picture does not jump.
  #range(points, k) {
    let [low, high] = [Infinity, -Infinity];
    for (const point of points) {
      low = Math.min(low, point[k]);
      high = Math.max(high, point[k]);
    }
    const motion = Math.max(Math.abs(low), Math.abs(high), 1e-12);
    const half = Math.max(0.5 * MARGIN * (high - low), 0.5 * SMALLEST * motion);
    const [from, to] = this.#ranges[k] ?? [0, 0];
    if (!(from <= low && high <= to && to - from <= 3 * half)) {
      const middle = 0.5 * (low + high);
      this.#ranges[k] = [middle - half, middle + half];
    }
    return this.#ranges[k];
  }
}
