// Dark or light: as chosen on the page, else as the system.

const light = matchMedia("(prefers-color-scheme: light)");

export function restoreTheme() {
  document.documentElement.dataset.theme = localStorage.getItem("theme") ?? (light.matches ? "light" : "dark");
}

restoreTheme();

// Follows the system while the page is open.
export function onSystemTheme(act) {
  light.addEventListener("change", () => {
    restoreTheme();
    act();
  });
}

export function toggleTheme() {
  const next = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
  localStorage.setItem("theme", next);
  document.documentElement.dataset.theme = next;
}
