// The data of the views: decodes the messages of `/views` and keeps a short past.

const TYPES = { f32: Float32Array, i16: Int16Array, u16: Uint16Array, u8: Uint8Array };
// Samples, intersections and columns of the spectrogram that are kept; powers of two for the rings.
export const SAMPLES = 1 << 14;
export const POINTS = 600;
export const COLUMNS = 480;

// The header of a message, with its arrays by name. Arrays of fractions are scaled.
export function decode(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const message = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  let offset = 4 + length;
  for (const [name, type, count] of message.arrays) {
    const numbers = new TYPES[type](buffer, offset, count);
    offset = 4 * Math.ceil((offset + numbers.byteLength) / 4);
    const scale = message[`${name}_scale`];
    message[name] = scale === undefined ? numbers : Float32Array.from(numbers, (x) => (scale / 32767) * x);
  }
  return message;
}

// The newest values of a series.
class Ring {
  constructor(size) {
    this.values = new Float32Array(size);
    this.count = 0;
  }

  push(numbers) {
    for (const x of numbers) this.values[this.count++ & (this.values.length - 1)] = x;
  }

  get length() {
    return Math.min(this.count, this.values.length);
  }

  // The value `age` before the newest one.
  at(age) {
    return this.values[(this.count - 1 - age) & (this.values.length - 1)];
  }
}

export class ViewData {
  constructor() {
    this.received = 0;
    this.bytes = 0;
    this.run = 0;
    this.clear({});
  }

  clear(start) {
    this.start = start;
    this.dt = 1 / (start.sample_rate_hz ?? 1);
    this.displacement = new Ring(SAMPLES);
    this.velocity = new Ring(SAMPLES);
    this.counted = 0;
    this.time = 0;
    this.tilt = null;
    this.points = [];
    this.columns = [];
    for (const name of ["pose", "nodes", "areas", "states", "spectrum", "recurrence", "body"]) this[name] = null;
    this.lines = [];
    this.versions = { samples: 0, patch: 0, spectrum: 0, columns: 0, recurrence: 0, points: 0 };
  }

  take(buffer) {
    const message = decode(buffer);
    this.received++;
    this.bytes += buffer.byteLength;
    if (message.start) {
      this.clear(message.start);
      if (message.vertices) this.body = (({ vertices, triangles, shapes }) => ({ vertices, triangles, shapes }))(message);
    }
    this.run = message.run;
    this.time = message.time_s;
    this.tilt = message.tilt_deg;
    this.#samples(message);
    this.#patch(message);
    this.#pictures(message);
  }

  #samples(message) {
    if (!message.displacement) return;
    // Without the samples that were left out, the past would be joined to the present.
    const missing = message.sample_count - message.displacement.length - this.counted;
    if (missing > 0) {
      this.displacement = new Ring(SAMPLES);
      this.velocity = new Ring(SAMPLES);
    }
    this.counted = message.sample_count;
    this.displacement.push(message.displacement);
    this.velocity.push(message.velocity);
    if (message.pose) this.pose = message.pose;
    this.versions.samples++;
  }

  #patch(message) {
    if (message.nodes) [this.nodes, this.areas] = [message.nodes, message.areas];
    if (message.states) {
      this.states = message.states;
      this.normalForce = message.normal_force;
      this.friction = message.friction;
      this.versions.patch++;
    }
  }

  #pictures(message) {
    if (message.spectrum) {
      this.spectrum = message.spectrum;
      this.bin = message.spectrum_bin_hz;
      this.lines = message.lines;
      this.versions.spectrum++;
    }
    if (message.columns) {
      const bins = message.column_bins;
      this.columnBin = message.column_bin_hz;
      this.columnEvery = message.column_every_s;
      for (let k = 0; k < message.columns.length; k += bins) {
        this.columns.push(message.columns.subarray(k, k + bins));
      }
      this.versions.columns += message.columns.length / bins;
      this.columns.splice(0, this.columns.length - COLUMNS);
    }
    if (message.recurrence) {
      this.recurrence = {
        bits: message.recurrence,
        size: message.recurrence_size,
        window: message.recurrence_window_s,
        rate: message.recurrence_rate,
      };
      this.versions.recurrence++;
    }
    if (message.points) {
      for (let k = 0; k < message.points.length; k += 2) {
        this.points.push([message.points[k], message.points[k + 1]]);
      }
      this.points.splice(0, this.points.length - POINTS);
      this.versions.points++;
    }
  }
}
