// Colours of the types of motion, which are those of figures and recordings. Each is shown with its word.

import shared from "/shared.js";

// Hatched: not a type of motion.
const UNDETERMINED = "repeating-linear-gradient(135deg, #8b969c 0 4px, #a7b1b6 4px 8px)";

// Colours of the tones by their octave, on a light and on a dark ground: about 1, 2, 4, 8 and 12 kHz.
const TONES = [["#6b3fa0", "#c9a5ff"], ["#7a5a00", "#f5c74a"], ["#00558a", "#6bc9ff"], ["#0b7a55", "#43c59e"], ["#a02a78", "#e59ccf"]];

export function toneColour(hz, style) {
  const octave = Math.round(Math.log2(hz / 1000));
  return TONES[Math.min(Math.max(octave, 0), TONES.length - 1)][style.light ? 0 : 1];
}

// The colour on a dark ground in both themes: the words on it are dark.
export function colour(kind) {
  if (kind === "undetermined") return UNDETERMINED;
  const [, [r, g, b]] = shared.regimes[kind];
  return `rgb(${r}, ${g}, ${b})`;
}
