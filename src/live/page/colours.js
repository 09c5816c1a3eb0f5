// Colours of the types of motion. Each is shown with its word; they differ in lightness, too.

const REGIMES = {
  silent: "#5b666d",
  "at rest": "#5b666d",
  transient: "#8d8d52",
  periodic: "#58a9ff",
  "quasi-periodic": "#b98cff",
  chaotic: "#ff7a59",
  noise: "#c9c9c9",
  undetermined: "#3a4247",
  stable: "#5b666d",
};
const UNSTABLE_MODES = ["#5b666d", "#58a9ff", "#43c59e", "#b98cff", "#ffd166", "#ffa53a", "#ff7a59"];

export function colour(kind) {
  const count = Number.parseInt(kind, 10);
  return REGIMES[kind] ?? UNSTABLE_MODES[Math.min(count, UNSTABLE_MODES.length - 1)] ?? "#888";
}
