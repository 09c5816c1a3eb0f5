// Dark or light: as chosen on the page, else as the system.

const asSystem = window.matchMedia.bind(window);
const isLight = asSystem("(prefers-color-scheme: light)").matches;

export function restoreTheme() {
  document.documentElement.dataset.theme = localStorage.getItem("theme") ?? (isLight ? "light" : "dark");
}

restoreTheme();
// The Rerun viewer follows the colour scheme of the system. The page overrides that query.
window.matchMedia = (query) => {
  const wish = /prefers-color-scheme:\s*(\w+)/.exec(query);
  return asSystem(!wish ? query : wish[1] === document.documentElement.dataset.theme ? "all" : "not all");
};

export function toggleTheme() {
  const next = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
  localStorage.setItem("theme", next);
  document.documentElement.dataset.theme = next;
}
