// Dark or light: as chosen on the page, else as the system.

const isLight = matchMedia("(prefers-color-scheme: light)").matches;

export function restoreTheme() {
  document.documentElement.dataset.theme = localStorage.getItem("theme") ?? (isLight ? "light" : "dark");
}

restoreTheme();

export function toggleTheme() {
  const next = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
  localStorage.setItem("theme", next);
  document.documentElement.dataset.theme = next;
}
