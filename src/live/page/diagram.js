// The diagram under the slider of the tilt: one row for each way of starting, unstable modes above, marks at the
// bifurcations, and a marker at the present tilt. The branches themselves are a view of their own.

import { colour, toneColour } from "/colours.js";
import { $, make, setText } from "/dom.js";
import { Labels, Plot, note, readStyle, short, unit } from "/plot.js";
import shared from "/shared.js";
import { T } from "/texts.js";

// Width of a letter in a band, relative to the size of the type.
const LETTER = 0.48;
// Pictures after which the dot of the present motion moves, and the time from which its amplitude is read, s.
const EVERY = 15;
const RECENT = 5e-3;
// Number of bifurcations up to which their names have space.
const FEW = 4;

// Half the range of the displacement, m.
function amplitude({ displacement: u, dt }) {
  let [low, high] = [Infinity, -Infinity];
  for (let k = 0; k < Math.min(u.length, RECENT / dt); k++) [low, high] = [Math.min(low, u.at(k)), Math.max(high, u.at(k))];
  return high > low ? 0.5 * (high - low) : 0;
}

export class Diagram {
  #range = null;
  #number = null;
  #full = null;
  #note = null;
  // One for each run that is shown, and their tilts, degrees.
  #markers = ["marker", "marker second"].map((className) => make("div", { className, hidden: true }));
  #tilts = [null, null];
  version = 0;

  constructor() {
    new ResizeObserver(() => this.draw()).observe($("sliders"));
  }

  // Fetches the diagram of the present scene by its number, which changes as it grows; `null` if there is none, or none yet.
  async load(number) {
    this.#number = number;
    if (number === null) {
      this.#full = null;
      return this.draw();
    }
    // A growing diagram stays until its next part is here.
    const full = await fetch("/diagram.json").then((answer) => answer.json()).catch(() => null);
    if (number !== this.#number) return;
    this.#full = full;
    this.draw();
  }

  // The tilt of the run, degrees.
  get tilt() {
    return this.#tilts[0];
  }

  get full() {
    return this.#full;
  }

  // What is computed at present, or why the scene has no diagram; `null` for a complete one.
  get note() {
    return this.#note;
  }

  setNote(text) {
    this.#note = text;
    setText($("diagram-note"), text ?? "");
    this.version++;
  }

  setRange(range) {
    this.#range = range;
    this.draw();
  }

  // Moves the marker of a run to a tilt, degrees; `null` hides it.
  mark(deg, run = 0) {
    this.#tilts[run] = deg;
    const marker = this.#markers[run];
    marker.hidden = deg === null || !this.#range;
    if (!marker.hidden) marker.style.left = `${Math.min(100, Math.max(0, this.#percent(deg)))}%`;
  }

  #percent(deg) {
    const [low, high] = this.#range;
    return (100 * (deg - low)) / (high - low);
  }

  draw() {
    this.version++;
    if (!this.#range) return $("bands").replaceChildren();
    const kinds = new Map();
    const drawn = (this.#full?.responses ?? []).map((row) => this.#row(row, kinds));
    const marks = (this.#full?.bifurcations ?? []).map(({ tilt_deg, text }) =>
      make("div", { className: "event", title: text, style: `left:${this.#percent(tilt_deg)}%` }),
    );
    $("bands").replaceChildren(...marks, ...this.#counts(), ...drawn, ...this.#markers);
    // Kinds whose bands are too narrow for their names.
    const unnamed = [...kinds].filter(([, named]) => !named);
    const key = drawn.length ? [make("span", { textContent: T.rowsKey, className: "fine" })] : [];
    $("legend").replaceChildren(
      ...unnamed.map(([kind]) => make("span", {}, make("i", { style: `background:${colour(kind)}` }), kind)),
      ...key,
    );
    this.#tilts.forEach((deg, run) => this.mark(deg, run));
  }

  // Adjacent tilts with the same type of motion and frequency form one band.
  #row({ start, tilt_deg: tilts, regime, frequency_hz }, kinds) {
    const ranges = [];
    for (const [k, deg] of tilts.entries()) {
      const kind = regime[k];
      const text = frequency_hz[k] ? `${kind} ${(1e-3 * frequency_hz[k]).toFixed(1)} kHz` : kind;
      const low = k === 0 ? deg : 0.5 * (tilts[k - 1] + deg);
      const high = k === tilts.length - 1 ? deg : 0.5 * (deg + tilts[k + 1]);
      const last = ranges.at(-1);
      if (last?.text === text) last.high = high;
      else ranges.push({ kind, text, low, high });
    }
    const bands = ranges.map(({ kind, text, low, high }) => {
      const [left, right] = [low, high].map((deg) => Math.min(100, Math.max(0, this.#percent(deg))));
      const space = (0.01 * (right - left) * $("bands").clientWidth) / readStyle().em;
      const name = [text, kind].find((words) => space > LETTER * words.length) ?? "";
      kinds.set(kind, Boolean(name) || kinds.get(kind));
      const style = `left:${left}%;width:${right - left}%;background:${colour(kind)}`;
      return make("div", { className: "band", title: text, style, textContent: name });
    });
    const label = make("span", { className: "row-name", textContent: T.started[start] });
    return make("div", { className: "bands-row" }, ...bands, label);
  }

  // Numbers of unstable modes, at the tilts from which they hold.
  #counts() {
    const counts = this.#full?.unstable_modes ?? [];
    if (!counts.length) return [];
    const spans = counts.map(({ tilt_deg: [low, high], count }) =>
      make("span", { textContent: `${count}`, title: T.unstableModes(count), style: `left:${this.#percent(low)}%;width:${this.#percent(high) - this.#percent(low)}%` }),
    );
    const name = make("b", { className: "row-name", textContent: T.unstable });
    return [make("div", { className: "count" }, name, ...spans)];
  }
}

// The branches: amplitude over the tilt, solid where stable and dashed where not.
export class Branches {
  id = "branches";
  #diagram;

  constructor(diagram) {
    this.#diagram = diagram;
  }

  version(data) {
    return `${this.#diagram.version} ${this.#diagram.tilt} ${Math.floor(data.versions.samples / EVERY)}`;
  }

  draw(c, width, height, data, style) {
    const full = this.#diagram.full;
    if (!full?.branches?.length) return note(c, width, height, style, this.#diagram.note ?? T.noDiagram);
    const em = style.em;
    const tilts = full.branches.flatMap((branch) => branch.tilt_deg);
    const most = Math.max(...full.branches.flatMap((branch) => branch.amplitude_m));
    const { per, symbol } = unit(most, "m");
    const x = { range: [Math.min(...tilts), Math.max(...tilts)], label: shared.tilt };
    const y = { range: [0, 1.15 * most * per], label: T.amplitudeIn(symbol), format: short };
    const bifurcations = full.bifurcations ?? [];
    // Above the axis: its label, and the list of short names.
    const plot = new Plot(c, width, height, style, x, y, (bifurcations.length > FEW ? 2.3 : 1.2) * em);
    plot.axes();
    plot.clip(() => full.branches.forEach((branch) => this.#branch(c, plot, branch, per, toneColour(branch.frequency_hz[0], style))));
    this.#marks(c, plot, bifurcations, style);
    this.#tones(c, plot, full.branches, per, style);
    const at = plot.X(data.tilt ?? 0);
    c.fillStyle = c.strokeStyle = style.mark;
    c.lineWidth = 2;
    c.beginPath();
    c.moveTo(at, plot.top);
    c.lineTo(at, plot.bottom);
    c.stroke();
    // The present motion.
    c.beginPath();
    c.arc(at, Math.max(plot.top, plot.Y(per * amplitude(data))), 0.35 * em, 0, 7);
    c.fill();
  }

  // The frequency of each branch, where it covers no other one.
  #tones(c, plot, branches, per, style) {
    const em = style.em;
    c.font = `600 ${0.75 * em}px ${style.family}`;
    c.textAlign = "center";
    c.textBaseline = "bottom";
    const taken = [];
    for (const { tilt_deg, amplitude_m, frequency_hz } of branches) {
      for (const share of [0.8, 0.5, 0.2, 0.95]) {
        const k = Math.floor(share * (tilt_deg.length - 1));
        const text = T.frequency((1e-3 * frequency_hz[k]).toFixed(2));
        const half = c.measureText(text).width / 2 + 0.2 * em;
        const [x, y] = [Math.min(Math.max(plot.X(tilt_deg[k]), plot.left + half), plot.right - half), plot.Y(per * amplitude_m[k]) - 0.2 * em];
        if (taken.some((other) => Math.abs(other.x - x) < other.half + half && Math.abs(other.y - y) < em)) continue;
        taken.push({ x, y, half });
        c.fillStyle = toneColour(frequency_hz[k], style);
        c.fillText(text, x, Math.max(y, plot.top + em));
        break;
      }
    }
  }

  #branch(c, plot, { tilt_deg, amplitude_m, stable }, per, colour) {
    c.strokeStyle = colour;
    c.lineWidth = 2;
    for (let k = 1; k < tilt_deg.length; k++) {
      // The piece before a point has its stability: a bifurcation has that of the point before it.
      c.setLineDash(stable[k] ? [] : [5, 4]);
      // A run of points of the same stability is one line, so that its dashes are even.
      c.beginPath();
      c.moveTo(plot.X(tilt_deg[k - 1]), plot.Y(per * amplitude_m[k - 1]));
      const solid = stable[k];
      while (k < tilt_deg.length && stable[k] === solid) {
        c.lineTo(plot.X(tilt_deg[k]), plot.Y(per * amplitude_m[k]));
        k++;
      }
      k--;
      c.stroke();
    }
    c.setLineDash([]);
  }

  #marks(c, plot, bifurcations, style) {
    const em = style.em;
    c.font = `${0.75 * em}px ${style.family}`;
    c.textBaseline = "bottom";
    c.textAlign = "center";
    c.strokeStyle = c.fillStyle = style.text;
    c.lineWidth = 1;
    const labels = new Labels(plot.left, plot.right, 2);
    // The upper row begins with the label of the axis.
    labels.block(0, 0, plot.left + 6 * em);
    const isDense = bifurcations.length > FEW;
    if (isDense) {
      labels.block(0, plot.left, plot.right);
      const kinds = [...new Set(bifurcations.map(({ kind }) => kind))].map((kind) => `${T.kindsShort[kind] ?? ""} ${T.kinds[kind] ?? kind}`.trim());
      c.textAlign = "right";
      c.fillText(kinds.join(", "), plot.right, plot.top - 1.3 * em);
      c.textAlign = "center";
    }
    for (const { kind, tilt_deg } of bifurcations) {
      const at = plot.X(tilt_deg);
      c.setLineDash([2, 3]);
      c.beginPath();
      c.moveTo(at, plot.top);
      c.lineTo(at, plot.bottom);
      c.stroke();
      c.setLineDash([]);
      const name = (isDense ? T.kindsShort : T.kinds)[kind] ?? kind;
      const half = c.measureText(name).width / 2 + 0.3 * em;
      const place = labels.place(at, half, half + 3 * em);
      if (!place) continue;
      const base = plot.top + (1.1 * place.row - 0.1) * em;
      c.fillText(name, place.middle, base);
      c.beginPath();
      c.moveTo(at, plot.top + 0.3 * em);
      c.lineTo(Math.min(Math.max(at, place.middle - half), place.middle + half), base);
      c.stroke();
    }
  }
}
