// The contact patch seen from outside: the state of each node by shape and colour, and the friction on the ball.

import { note } from "/plot.js";
import { T } from "/texts.js";

const [STICK, SLIP, SEPARATED] = [0, 1, 2];
// Length of an arrow for a friction force equal to the mean share of the load, relative to the radius.
const ARROW = 0.35;

export class Patch {
  id = "patch";
  needs = "patch";

  draw(c, width, height, data, style) {
    const { nodes, areas, states, normalForce, friction, start } = data;
    if (!start.patch_radius_m) return note(c, width, height, style, data.received ? T.noPatch : T.notYet);
    if (!states || !nodes || nodes.length !== 2 * states.length) return note(c, width, height, style, T.notYet);
    const em = style.em;
    const tall = this.#legend(c, width, height, style, states) - 0.4 * em;
    const scale = Math.min(width - em, tall - 0.6 * em) / (2.12 * start.patch_radius_m);
    const [cx, cy] = [width / 2, 0.2 * em + tall / 2];
    const X = (k) => cx + scale * nodes[2 * k];
    const Y = (k) => cy - scale * nodes[2 * k + 1];
    c.strokeStyle = style.line;
    c.lineWidth = 1.5;
    c.beginPath();
    c.arc(cx, cy, scale * start.patch_radius_m * 1.06, 0, 7);
    c.stroke();
    const pressure = start.load_n / (Math.PI * start.patch_radius_m ** 2);
    for (let k = 0; k < states.length; k++) {
      const cell = scale * Math.sqrt(areas[k] / Math.PI);
      const share = Math.sqrt(Math.max(0, normalForce[k]) / (2 * pressure * areas[k]));
      node(c, style, states[k], X(k), Y(k), cell * Math.min(0.85, 0.25 + 0.52 * share));
    }
    const arrow = (ARROW * start.patch_radius_m * states.length * scale) / start.load_n;
    c.strokeStyle = style.friction;
    c.lineWidth = Math.max(1.2, em / 11);
    c.beginPath();
    for (let k = 0; k < states.length; k++) {
      const [dx, dy] = [arrow * friction[2 * k], -arrow * friction[2 * k + 1]];
      if (dx * dx + dy * dy > 4) line(c, X(k), Y(k), dx, dy);
    }
    c.stroke();
  }

  // The symbols with the number of nodes of each state, in a row or two at the bottom; returns the upper end.
  #legend(c, width, height, style, states) {
    const em = style.em;
    const count = (kind) => states.reduce((sum, state) => sum + (state === kind), 0);
    const names = [T.stick, T.slip, T.separated].map((name, kind) => `${name} ${count(kind)}`);
    c.font = `${0.85 * em}px ${style.family}`;
    c.textAlign = "left";
    c.textBaseline = "middle";
    const entries = [...names, T.frictionArrow].map((name, kind) => ({ kind, name, wide: c.measureText(name).width + 1.95 * em }));
    const total = entries.reduce((sum, { wide }) => sum + wide, 0);
    const perRow = total > width ? 2 : entries.length;
    const column = Math.max(...entries.map(({ wide }) => wide));
    const left = Math.max(0.3 * em, (width - Math.min(total, perRow * column)) / 2);
    const top = height - (perRow === 2 ? 3.2 : 1.8) * em;
    let x = left;
    entries.forEach(({ kind, name, wide }, k) => {
      const y = top + (0.7 + 1.4 * Math.floor(k / perRow)) * em;
      if (perRow === 2) x = left + (k % perRow) * column;
      if (kind < 3) node(c, style, kind, x + 0.6 * em, y, 0.42 * em);
      else {
        c.strokeStyle = style.friction;
        c.beginPath();
        line(c, x + 0.1 * em, y, em, 0);
        c.stroke();
      }
      c.fillStyle = style.text;
      c.fillText(name, x + 1.35 * em, y);
      x += wide;
    });
    return top;
  }
}

function line(c, x, y, dx, dy) {
  c.moveTo(x, y);
  c.lineTo(x + dx, y + dy);
  const head = 0.28;
  c.moveTo(x + dx - head * (dx - 0.6 * dy), y + dy - head * (dy + 0.6 * dx));
  c.lineTo(x + dx, y + dy);
  c.lineTo(x + dx - head * (dx + 0.6 * dy), y + dy - head * (dy - 0.6 * dx));
}

// A node: a square sticks, a disc slips, a ring is separated.
function node(c, style, state, x, y, radius) {
  c.beginPath();
  if (state === STICK) {
    c.fillStyle = style.stick;
    c.fillRect(x - 0.9 * radius, y - 0.9 * radius, 1.8 * radius, 1.8 * radius);
  } else if (state === SLIP) {
    c.fillStyle = style.slip;
    c.arc(x, y, radius, 0, 7);
    c.fill();
  } else if (state === SEPARATED) {
    c.strokeStyle = style.separated;
    c.lineWidth = 1.6;
    c.arc(x, y, Math.max(2, radius - 0.8), 0, 7);
    c.stroke();
  }
}
