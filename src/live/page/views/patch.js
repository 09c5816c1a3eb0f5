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
    const tall = height - 2.2 * em;
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
    const counts = [0, 0, 0];
    for (let k = 0; k < states.length; k++) {
      counts[states[k]]++;
      const cell = scale * Math.sqrt(areas[k] / Math.PI);
      const share = Math.sqrt(Math.max(0, normalForce[k]) / (2 * pressure * areas[k]));
      node(c, style, states[k], X(k), Y(k), cell * Math.min(1, 0.3 + 0.62 * share));
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
    this.#legend(c, width, height, style, counts);
  }

  #legend(c, width, height, style, counts) {
    let em = style.em;
    const names = [T.stick, T.slip, T.separated].map((name, k) => `${name} ${counts[k]}`);
    const entries = [...names.map((name, k) => [k, name]), [3, T.frictionArrow]];
    c.font = `${0.85 * em}px ${style.family}`;
    const wanted = entries.reduce((sum, [, name]) => sum + c.measureText(name).width + 2.2 * em, 0);
    em *= Math.min(1, (width - em) / wanted);
    c.font = `${0.85 * em}px ${style.family}`;
    c.textAlign = "left";
    c.textBaseline = "middle";
    const widths = entries.map(([, name]) => c.measureText(name).width + 2.2 * em);
    let x = Math.max(0.3 * em, (width - widths.reduce((a, b) => a + b, 0)) / 2);
    const y = height - 1.1 * em;
    entries.forEach(([kind, name], k) => {
      if (kind < 3) node(c, style, kind, x + 0.6 * em, y, 0.42 * em);
      else {
        c.strokeStyle = style.friction;
        c.beginPath();
        line(c, x + 0.1 * em, y, em, 0);
        c.stroke();
      }
      c.fillStyle = style.text;
      c.fillText(name, x + 1.35 * em, y);
      x += widths[k];
    });
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
