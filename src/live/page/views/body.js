// The deforming body: ball and beam, magnified. A stroboscope in step with the strongest line slows the vibration.

import { FullScale, note } from "/plot.js";
import { T } from "/texts.js";

// View from obliquely above: rotation about the axis of the beam, and inclination, rad.
const TURN = 0.6;
const INCLINATION = 1.15;

export class Body {
  id = "body";
  needs = "samples";
  #scale = new FullScale();
  #full = 1;
  #rest = null;

  draw(c, width, height, data, style) {
    if (!data.body) return note(c, width, height, style, data.received ? T.noBody : T.notYet);
    if (!data.pose) return note(c, width, height, style, T.notYet);
    const moved = this.#moved(data);
    const em = style.em;
    const points = this.#project(data, moved, width, height - 2 * em, em);
    this.#surface(c, data.body.triangles, points, moved, style);
    c.font = `${0.85 * em}px ${style.family}`;
    c.fillStyle = style.quiet;
    c.textAlign = "center";
    c.textBaseline = "bottom";
    const um = 1e6 * moved.peak;
    c.fillText(T.bodyCaption(um >= 0.01 ? um.toFixed(2) : um.toExponential(0), this.magnification), width / 2, height - 0.3 * em);
  }

  // Displacements of the vertices, m: the sum of the mode shapes, with its largest magnitude.
  #moved({ body, pose }) {
    const count = body.vertices.length;
    const sum = new Float32Array(count);
    pose.forEach((q, mode) => {
      const from = mode * count;
      for (let i = 0; i < count; i++) sum[i] += q * body.shapes[from + i];
    });
    let peak = 0;
    const size = new Float32Array(count / 3);
    for (let k = 0; k < size.length; k++) {
      size[k] = Math.hypot(sum[3 * k], sum[3 * k + 1], sum[3 * k + 2]);
      peak = Math.max(peak, size[k]);
    }
    return { sum, size, peak };
  }

  #project({ body, start }, { sum, peak }, width, height, em) {
    const rest = body.vertices;
    if (this.#rest?.of !== rest) {
      let [low, high] = [Infinity, -Infinity];
      for (let i = 2; i < rest.length; i += 3) [low, high] = [Math.min(low, rest[i]), Math.max(high, rest[i])];
      this.#rest = { of: rest, low, high };
    }
    const { low, high } = this.#rest;
    const length = high - low;
    // At the magnification of the scene, or less if the body would leave the picture.
    this.#full = this.#scale.update(peak, 1e-10);
    this.magnification = Math.min(start.magnification, (0.09 * length) / this.#full);
    const [sinT, cosT, sinI, cosI] = [Math.sin(TURN), Math.cos(TURN), Math.sin(INCLINATION), Math.cos(INCLINATION)];
    const scale = (height - 1.5 * em) / (1.12 * length * sinI);
    const middle = 0.5 * (low + high);
    const count = rest.length / 3;
    const [x, y, depth] = [new Float32Array(count), new Float32Array(count), new Float32Array(count)];
    for (let k = 0; k < count; k++) {
      const [a, b, z] = [0, 1, 2].map((i) => rest[3 * k + i] + this.magnification * sum[3 * k + i]);
      const across = cosT * a - sinT * b;
      const away = sinT * a + cosT * b;
      x[k] = width / 2 + scale * across;
      y[k] = 0.6 * em + height / 2 - scale * ((z - middle) * sinI - away * cosI);
      depth[k] = scale * (away * sinI + (z - middle) * cosI);
    }
    return { x, y, depth };
  }

  #surface(c, triangles, { x, y, depth }, { size }, style) {
    const front = [];
    for (let t = 0; t < triangles.length; t += 3) {
      const [i, j, k] = [triangles[t], triangles[t + 1], triangles[t + 2]];
      const facing = (x[j] - x[i]) * (y[k] - y[i]) - (x[k] - x[i]) * (y[j] - y[i]);
      if (facing < 0) front.push({ i, j, k, depth: depth[i] + depth[j] + depth[k], shade: shade(x, y, depth, i, j, k) });
    }
    front.sort((a, b) => b.depth - a.depth);
    const full = this.#full;
    for (const { i, j, k, shade: lit } of front) {
      const strain = Math.min(1, (size[i] + size[j] + size[k]) / (3 * full));
      const grey = style.light ? 150 + 70 * lit : 70 + 110 * lit;
      const [r, g, b] = [grey + strain * (250 * lit - grey), grey + strain * (170 * lit + 20 - grey), grey * (1 - 0.75 * strain)];
      c.fillStyle = c.strokeStyle = `rgb(${r | 0},${g | 0},${b | 0})`;
      c.beginPath();
      c.moveTo(x[i], y[i]);
      c.lineTo(x[j], y[j]);
      c.lineTo(x[k], y[k]);
      c.closePath();
      c.fill();
      // Closes the gaps that smoothing leaves between neighbours.
      c.lineWidth = 0.7;
      c.stroke();
    }
  }
}

// Brightness of a triangle, 0.25 to 1, in light from the upper left of the viewer.
function shade(x, y, depth, i, j, k) {
  const u = [x[j] - x[i], y[j] - y[i], depth[j] - depth[i]];
  const v = [x[k] - x[i], y[k] - y[i], depth[k] - depth[i]];
  const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
  const length = Math.hypot(...n) || 1;
  const light = (0.45 * n[0] + 0.55 * n[1] - 0.7 * n[2]) / length;
  return 0.3 + 0.7 * Math.max(0, Math.min(1, Math.abs(light)));
}
