// Colours of the types of motion. Each is shown with its word; they differ in lightness, too.

const REGIMES = {
  silent: "#96a2a9",
  "at rest": "#96a2a9",
  transient: "#b3b36b",
  periodic: "#58a9ff",
  "quasi-periodic": "#4cd09e",
  chaotic: "#ff7a59",
  noise: "#c9c9c9",
  // Hatched: not a type of motion.
  undetermined: "repeating-linear-gradient(135deg, #8b969c 0 4px, #a7b1b6 4px 8px)",
  stable: "#96a2a9",
};
const UNSTABLE_MODES = ["#96a2a9", "#58a9ff", "#43c59e", "#b98cff", "#ffd166", "#ffa53a", "#ff7a59"];

// Colours of the tones by their octave, on a light and on a dark ground: about 1, 2, 4, 8 and 12 kHz.
const TONES = [["#6b3fa0", "#c9a5ff"], ["#7a5a00", "#f5c74a"], ["#00558a", "#6bc9ff"], ["#0b7a55", "#43c59e"], ["#a02a78", "#e59ccf"]];

export function toneColour(hz, style) {
  const octave = Math.round(Math.log2(hz / 1000));
  return TONES[Math.min(Math.max(octave, 0), TONES.length - 1)][style.light ? 0 : 1];
}

export function colour(kind) {
  const count = Number.parseInt(kind, 10);
  return REGIMES[kind] ?? UNSTABLE_MODES[Math.min(count, UNSTABLE_MODES.length - 1)] ?? "#888";
}
