// Axes, scales and colours of the views.

import shared from "/shared.js";

// The colours and the size of the type, from the style sheet.
export function readStyle() {
  const css = getComputedStyle(document.documentElement);
  const colour = (name) => css.getPropertyValue(`--${name}`).trim();
  const names = ["ground", "raised", "line", "text", "quiet", "signal", "stick", "slip", "separated", "friction", "mark", "second"];
  const style = Object.fromEntries(names.map((name) => [name, colour(name)]));
  style.em = Number.parseFloat(css.fontSize);
  style.light = document.documentElement.dataset.theme === "light";
  style.family = css.fontFamily;
  return style;
}

// Up to about `most` round values within a range.
export function ticks(low, high, most) {
  const raw = (high - low) / Math.max(1, most);
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [...shared.tick_steps, 10].map((m) => m * power).find((s) => s >= raw * 0.999);
  const all = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high * (1 + 1e-9) + 1e-12; k++) all.push(k * step);
  return all;
}

// A number with at most three significant digits.
export const short = (x) => `${Number(x.toPrecision(3))}`.replace("-", "−");

// The factor and symbol of a readable unit for a size in SI units.
export function unit(size, symbol) {
  // Without those of thousands and millions.
  const prefixes = shared.prefixes.slice(0, 5).map((prefix, k) => [Number(`1e${3 * k - 12}`), prefix]);
  const [factor, prefix] = prefixes.findLast(([f]) => size >= f) ?? prefixes[0];
  return { per: 1 / factor, symbol: `${prefix}${symbol}` };
}

// A full scale that changes seldom: it grows at once and shrinks when it is much too large.
export class FullScale {
  #value = 0;

  update(peak, smallest) {
    const wanted = Math.max(peak, smallest);
    if (wanted > this.#value || wanted < 0.35 * this.#value) {
      const power = 10 ** Math.floor(Math.log10(1.1 * wanted));
      this.#value = [...shared.full_scales, 10].map((m) => m * power).find((v) => v >= 1.1 * wanted) ?? 1.1 * wanted;
    }
    return this.#value;
  }
}

// A plot area with linear axes; `x` and `y` are ranges with labels.
export class Plot {
  constructor(context, width, height, style, x, y, top = 0) {
    const em = style.em;
    Object.assign(this, { context, style, x, y });
    this.left = 2.6 * em;
    this.right = width - 0.8 * em;
    this.top = 1.5 * em + top;
    this.bottom = height - 2.2 * em;
  }

  X(value) {
    const [low, high] = this.x.range;
    return this.left + ((value - low) / (high - low)) * (this.right - this.left);
  }

  Y(value) {
    const [low, high] = this.y.range;
    return this.bottom - ((value - low) / (high - low)) * (this.bottom - this.top);
  }

  axes() {
    const { context: c, style, x, y } = this;
    const em = style.em;
    c.font = `${0.78 * em}px ${style.family}`;
    c.lineWidth = 1;
    c.strokeStyle = style.line;
    c.fillStyle = style.quiet;
    c.textBaseline = "top";
    c.textAlign = "center";
    c.beginPath();
    for (const value of x.ticks ?? ticks(...x.range, (this.right - this.left) / (4.2 * em))) {
      const at = Math.round(this.X(value)) + 0.5;
      c.moveTo(at, this.top);
      c.lineTo(at, this.bottom);
      c.fillText(x.format?.(value) ?? short(value), Math.min(at, this.right - 0.3 * em), this.bottom + 0.25 * em);
    }
    c.textAlign = "right";
    c.textBaseline = "middle";
    for (const value of y.ticks ?? ticks(...y.range, (this.bottom - this.top) / (2.4 * em))) {
      const at = Math.round(this.Y(value)) + 0.5;
      c.moveTo(this.left, at);
      c.lineTo(this.right, at);
      c.fillText(y.format?.(value) ?? short(value), this.left - 0.35 * em, at);
    }
    c.stroke();
    c.fillStyle = style.text;
    c.textBaseline = "bottom";
    c.textAlign = "right";
    c.fillText(x.label, this.right, this.bottom + 2.1 * em);
    c.textAlign = "left";
    c.fillText(y.label, 0.6 * em, this.top - 0.4 * em);
  }

  // Draws within the plot area only.
  clip(draw) {
    const { context: c } = this;
    c.save();
    c.beginPath();
    c.rect(this.left, this.top, this.right - this.left, this.bottom - this.top);
    c.clip();
    draw(c);
    c.restore();
  }
}

// Places of labels in rows: a label stays at its mark, or moves sideways where it would cover another one.
export class Labels {
  constructor(left, right, rows) {
    Object.assign(this, { left, right });
    this.rows = Array.from({ length: rows }, () => []);
  }

  // Keeps a part of a row free.
  block(row, from, to) {
    this.rows[row].push([from, to]);
  }

  // The row, and the middle of a label of this half width for a mark at `at`: the nearest free place within `reach`.
  place(at, half, reach = 0) {
    const within = (x) => Math.min(Math.max(x, this.left + half), this.right - half);
    const free = (taken, x) => taken.every(([a, b]) => x + half <= a || x - half >= b);
    const places = this.rows.flatMap((taken, row) =>
      [at, ...taken.flatMap(([a, b]) => [a - half, b + half])]
        .map((x) => ({ row, middle: within(x), away: Math.abs(within(x) - within(at)) }))
        .filter(({ middle, away }) => away <= reach && free(taken, middle)),
    );
    const place = places.toSorted((a, b) => a.away - b.away || a.row - b.row)[0];
    if (place) this.block(place.row, place.middle - half, place.middle + half);
    return place;
  }
}

// A text in lines that are not wider than a width.
export function wrapped(c, text, width) {
  const lines = [""];
  for (const word of text.split(" ")) {
    const longer = lines.at(-1) ? `${lines.at(-1)} ${word}` : word;
    if (lines.at(-1) && c.measureText(longer).width > width) lines.push(word);
    else lines[lines.length - 1] = longer;
  }
  return lines;
}

// Says that there is nothing to draw yet.
export function note(context, width, height, style, text) {
  context.fillStyle = style.quiet;
  context.font = `${0.9 * style.em}px ${style.family}`;
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillText(text, width / 2, height / 2);
}
