// QR codes after ISO/IEC 18004: byte mode, error correction level L, versions 1 to 9 (up to 230 bytes).

// By version: error-correction bytes per block, and number of data bytes of each block.
const BLOCKS = [[7, [19]], [10, [34]], [15, [55]], [20, [80]], [26, [108]], [18, [68, 68]], [20, [78, 78]], [24, [97, 97]], [30, [116, 116]]];
// By version: centres of the alignment patterns.
const CENTRES = [[], [6, 18], [6, 22], [6, 26], [6, 30], [6, 34], [6, 22, 38], [6, 24, 42], [6, 26, 46]];

// Powers and logarithms in the field of 256 elements.
const [EXP, LOG] = [new Uint8Array(512), new Uint8Array(256)];
for (let k = 0, x = 1; k < 255; k++, x = (x << 1) ^ (x & 0x80 ? 0x11d : 0)) [EXP[k], EXP[k + 255], LOG[x]] = [x, x, k];
const times = (a, b) => (a && b ? EXP[LOG[a] + LOG[b]] : 0);

// Reed-Solomon bytes for a block.
function correction(data, count) {
  let generator = [1];
  for (let k = 0; k < count; k++) {
    const next = new Array(generator.length + 1).fill(0);
    generator.forEach((g, i) => {
      next[i] ^= g;
      next[i + 1] ^= times(g, EXP[k]);
    });
    generator = next;
  }
  const rest = [...data, ...new Array(count).fill(0)];
  for (let k = 0; k < data.length; k++) {
    const factor = rest[k];
    generator.forEach((g, i) => (rest[k + i] ^= times(g, factor)));
  }
  return rest.slice(data.length);
}

// The bytes of a text with their corrections, interleaved.
function codewords(bytes, version) {
  const [correcting, sizes] = BLOCKS[version - 1];
  const capacity = sizes.reduce((a, b) => a + b, 0);
  const bits = [];
  const put = (value, length) => {
    for (let k = length - 1; k >= 0; k--) bits.push((value >> k) & 1);
  };
  put(4, 4);
  put(bytes.length, 8);
  for (const byte of bytes) put(byte, 8);
  put(0, Math.min(4, 8 * capacity - bits.length));
  while (bits.length % 8) bits.push(0);
  const data = [];
  for (let k = 0; k < bits.length; k += 8) data.push(Number.parseInt(bits.slice(k, k + 8).join(""), 2));
  for (let pad = 0xec; data.length < capacity; pad ^= 0xec ^ 0x11) data.push(pad);
  let start = 0;
  const blocks = sizes.map((size) => data.slice(start, (start += size)));
  const corrections = blocks.map((block) => correction(block, correcting));
  const interleaved = (lists) => Array.from({ length: lists[0].length }, (_, k) => lists.map((list) => list[k])).flat();
  return [...interleaved(blocks), ...interleaved(corrections)];
}

// Remainder of a division of polynomials over the field of two elements, for format and version.
function remainder(value, divisor, degree) {
  let rest = value << degree;
  for (let k = 31; k >= degree; k--) if (rest & (1 << k)) rest ^= divisor << (k - degree);
  return (value << degree) | rest;
}

const MASKS = [
  (r, c) => (r + c) % 2, (r) => r % 2, (r, c) => c % 3, (r, c) => (r + c) % 3,
  (r, c) => ((r >> 1) + Math.floor(c / 3)) % 2, (r, c) => ((r * c) % 2) + ((r * c) % 3),
  (r, c) => (((r * c) % 2) + ((r * c) % 3)) % 2, (r, c) => (((r + c) % 2) + ((r * c) % 3)) % 2,
];

// Penalty of a pattern: long runs, blocks and an unequal number of dark modules; finder-like runs.
function penalty(dark) {
  const size = dark.length;
  let sum = 0;
  const lines = [...dark, ...dark.map((_, c) => dark.map((row) => row[c]))];
  for (const line of lines) {
    const text = line.map(Number).join("");
    for (const [run] of text.matchAll(/0{5,}|1{5,}/g)) sum += run.length - 2;
    for (const _ of text.matchAll(/(?=10111010000|00001011101)/g)) sum += 40;
  }
  for (let r = 1; r < size; r++) {
    for (let c = 1; c < size; c++) {
      if (dark[r][c] === dark[r - 1][c] && dark[r][c] === dark[r][c - 1] && dark[r][c] === dark[r - 1][c - 1]) sum += 3;
    }
  }
  const share = dark.flat().filter(Boolean).length / size ** 2;
  return sum + 10 * Math.floor(Math.abs(share - 0.5) * 20);
}

// The modules of the code of a text, row by row: true is dark.
export function qrCode(text) {
  const bytes = new TextEncoder().encode(text);
  const version = BLOCKS.findIndex(([, sizes]) => sizes.reduce((a, b) => a + b, 0) >= bytes.length + 2) + 1;
  if (version === 0) throw new RangeError("the text is too long for a QR code");
  const size = 17 + 4 * version;
  const grid = Array.from({ length: size }, () => new Array(size).fill(null));
  const square = (row, column, pattern) => {
    for (let r = -pattern; r <= pattern; r++) {
      for (let c = -pattern; c <= pattern; c++) {
        const ring = Math.max(Math.abs(r), Math.abs(c));
        if (grid[row + r]?.[column + c] !== undefined) grid[row + r][column + c] = pattern === 4 ? ring !== 2 && ring !== 4 : ring !== 1;
      }
    }
  };
  square(3, 3, 4);
  square(3, size - 4, 4);
  square(size - 4, 3, 4);
  for (let k = 8; k < size - 8; k++) grid[6][k] = grid[k][6] = k % 2 === 0;
  const centres = CENTRES[version - 1];
  const last = centres.at(-1);
  for (const r of centres) {
    for (const c of centres) if (!((r === 6 && c === 6) || (r === 6 && c === last) || (r === last && c === 6))) square(r, c, 2);
  }
  grid[size - 8][8] = true;
  if (version >= 7) {
    const bits = remainder(version, 0x1f25, 12);
    for (let k = 0; k < 18; k++) grid[Math.floor(k / 3)][size - 11 + (k % 3)] = grid[size - 11 + (k % 3)][Math.floor(k / 3)] = Boolean((bits >> k) & 1);
  }
  const format = (target, mask) => {
    const bits = remainder((1 << 3) | mask, 0x537, 10) ^ 0x5412;
    for (let k = 0; k < 15; k++) {
      const bit = Boolean((bits >> k) & 1);
      target[k < 6 ? k : k < 8 ? k + 1 : size - 15 + k][8] = bit;
      target[8][k < 8 ? size - 1 - k : k === 8 ? 7 : 14 - k] = bit;
    }
    target[size - 8][8] = true;
  };
  format(grid, 0);
  const bits = codewords(bytes, version).flatMap((byte) => [7, 6, 5, 4, 3, 2, 1, 0].map((k) => (byte >> k) & 1));
  const free = [];
  for (let right = size - 1, up = true; right > 0; right -= 2, up = !up) {
    if (right === 6) right = 5;
    for (let k = 0; k < size; k++) {
      const row = up ? size - 1 - k : k;
      for (const column of [right, right - 1]) if (grid[row][column] === null) free.push([row, column]);
    }
  }
  const masked = MASKS.map((mask, number) => {
    const dark = grid.map((row) => [...row]);
    free.forEach(([r, c], k) => (dark[r][c] = Boolean((bits[k] ?? 0) ^ (mask(r, c) === 0))));
    format(dark, number);
    return dark;
  });
  return masked.reduce((best, dark) => (penalty(dark) < penalty(best) ? dark : best));
}
