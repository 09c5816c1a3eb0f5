// The pictures of the lesson: what its text names, as panels of axes and layers from the server.

import { Labels, Plot, note, wrapped } from "/plot.js";
import { T } from "/texts.js";
import { power } from "/views/spectrum.js";

// Time between two requests of the panels, ms.
const EVERY = 250;
// Width of a panel over its height, as far as the view permits.
const ASPECT = 1.5;

export class Lesson {
  id = "lesson";
  #path;
  #panels = null;
  #run = null;
  #asked = 0;
  #version = 0;
  // Called when new panels are here.
  onNews = () => {};

  // `path` is the address of the panels of the run.
  constructor(path) {
    this.#path = path;
  }

  // Changes when new panels are here; asks for them while the view is shown.
  version(data) {
    if (this.#run !== data.run) [this.#run, this.#panels, this.#asked] = [data.run, null, 0];
    if (performance.now() > this.#asked + EVERY) {
      this.#asked = performance.now();
      fetch(this.#path).then((answer) => answer.json()).then((panels) => {
        this.#panels = panels;
        this.#version++;
        this.onNews();
      }, () => {});
    }
    return this.#version;
  }

  draw(c, width, height, data, style) {
    if (!data.start.lesson) return note(c, width, height, style, T.noLesson);
    const panels = this.#panels ?? [];
    if (!panels.length) return note(c, width, height, style, T.notYet);
    const columns = panels.length > 1 && width > ASPECT * height ? panels.length : 1;
    const [w, h] = [width / columns, (height * columns) / panels.length];
    panels.forEach((panel, k) => {
      c.save();
      c.translate((k % columns) * w, Math.floor(k / columns) * h);
      drawPanel(c, w, h, panel, style);
      c.restore();
    });
  }
}

const colourOf = (layer, style) => `rgb(${layer.color[style.light ? 0 : 1].join()})`;

// The range of an axis in its unit, its ticks and their texts; a logarithmic axis is drawn linearly over the exponent.
function axisOf({ name, unit: { symbol, factor }, range, scale }) {
  const label = [name, symbol].filter(Boolean).join(", ");
  const shown = range.map((end) => factor * end);
  if (scale !== "Logarithmic") return { range: shown, label, of: (x) => factor * x };
  const [low, high] = shown.map(Math.log10);
  const ticks = [];
  const steps = high - low > 3 ? [1] : [1, 2, 5];
  for (let d = Math.floor(low); d <= high + 1e-9; d++) {
    for (const step of steps) {
      const at = d + Math.log10(step);
      if (at >= low - 1e-9 && at <= high + 1e-9) ticks.push(at);
    }
  }
  const format = (d) => (Math.abs(d) > 2 ? power(Math.round(d)) : `${Number((10 ** d).toPrecision(1))}`);
  return { range: [low, high], label, ticks, format, of: (x) => Math.log10(Math.max(factor * x, 1e-300)) };
}

function drawPanel(c, width, height, panel, style) {
  const em = style.em;
  const [x, y] = [axisOf(panel.x), axisOf(panel.y)];
  const top = head(c, width, panel, style);
  const plot = new Plot(c, width, height, style, x, y, top);
  const space = (plot.bottom - plot.top) / (1.2 * em);
  if (y.ticks && y.ticks.length > space) y.ticks = y.ticks.filter((_, k) => k % Math.ceil(y.ticks.length / space) === 0);
  plot.axes();
  // A value far outside keeps the direction of its line.
  const far = ([low, high], v) => Math.min(Math.max(v, low - 9 * (high - low)), high + 9 * (high - low));
  const at = (point) => [plot.X(far(x.range, x.of(point[0]))), plot.Y(far(y.range, y.of(point[1])))];
  plot.clip(() => {
    for (const layer of panel.layers) {
      c.strokeStyle = c.fillStyle = colourOf(layer, style);
      const { Lines: lines, Points: points, Peaks: peaks } = layer.shape;
      if (lines) drawLines(c, lines, layer, at, em);
      for (const point of points ?? []) dot(c, at(point), (layer.size * em) / 11);
      for (const [point] of peaks ?? []) dot(c, at(point), 0.22 * em);
    }
  });
  const labels = new Labels(plot.left, plot.right, 1);
  c.font = `600 ${0.75 * em}px ${style.family}`;
  c.textAlign = "center";
  c.textBaseline = "bottom";
  c.fillStyle = style.text;
  for (const [point, text] of panel.layers.flatMap((layer) => layer.shape.Peaks ?? [])) {
    const [px, py] = at(point);
    if (px > plot.right) continue;
    const half = c.measureText(text).width / 2 + 0.2 * em;
    const place = labels.place(px, half, 2 * half);
    if (place) c.fillText(text, place.middle, Math.max(plot.top + em, py - 0.3 * em));
  }
}

function drawLines(c, strips, { dashed, size }, at, em) {
  c.setLineDash(dashed ? [0.4 * em, 0.3 * em] : []);
  c.lineWidth = Math.max(1, (size * em) / 11);
  c.lineJoin = "round";
  for (const strip of strips) {
    c.beginPath();
    let pen = "moveTo";
    for (const point of strip) {
      // A gap where a value is not finite.
      if (point.includes(null)) pen = "moveTo";
      else {
        c[pen](...at(point));
        pen = "lineTo";
      }
    }
    c.stroke();
  }
  c.setLineDash([]);
}

function dot(c, [x, y], radius) {
  c.beginPath();
  c.arc(x, y, radius, 0, 7);
  c.fill();
}

// Draws title and legend, and returns their height.
function head(c, width, panel, style) {
  const em = style.em;
  const row = 1.1 * em;
  c.textAlign = "left";
  c.textBaseline = "top";
  c.font = `600 ${0.85 * em}px ${style.family}`;
  c.fillStyle = style.text;
  const lines = wrapped(c, panel.title, width - 1.2 * em);
  lines.forEach((line, k) => c.fillText(line, 0.6 * em, (0.2 + 1.1 * k) * em));
  let [left, top] = [0.6 * em, lines.length * row + 0.2 * em];
  c.font = `${0.78 * em}px ${style.family}`;
  for (const layer of panel.layers.filter(({ label }) => label)) {
    const space = c.measureText(layer.label).width + 1.9 * em;
    if (left > em && left + space > width) [left, top] = [0.6 * em, top + row];
    c.fillStyle = colourOf(layer, style);
    c.fillRect(left, top + 0.2 * em, 0.6 * em, 0.6 * em);
    c.fillStyle = style.text;
    c.fillText(layer.label, left + 0.85 * em, top);
    left += space;
  }
  return top + row - 0.4 * em;
}
