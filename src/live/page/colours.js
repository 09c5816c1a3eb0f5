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

export function colour(kind) {
  const count = Number.parseInt(kind, 10);
  return REGIMES[kind] ?? UNSTABLE_MODES[Math.min(count, UNSTABLE_MODES.length - 1)] ?? "#888";
}
