// Keyboard shortcuts. A control that has the focus keeps its own keys: Space presses a button, arrows move a slider.

import { $, make } from "/dom.js";
import { T } from "/texts.js";

const CONTROLS = "button, select, input, textarea, summary, a[href], dialog, [contenteditable]";
// Controls that take any key.
const TYPED = "select, input:not([type=range], [type=checkbox]), textarea, dialog, [contenteditable]";
const OWN_KEYS = [" ", "Enter", "Home", "End"];

export class Keys {
  // `actions` are functions by key.
  constructor(actions) {
    this.actions = actions;
    const active = localStorage.getItem("shortcuts") !== "off";
    $("shortcuts-on").checked = active;
    $("shortcuts-on").onchange = () => localStorage.setItem("shortcuts", $("shortcuts-on").checked ? "on" : "off");
    const rows = T.keys.map(([keys, text]) =>
      make("tr", {}, make("th", { scope: "row" }, make("kbd", { textContent: keys })), make("td", { textContent: text })),
    );
    $("keys").tBodies[0].replaceChildren(...rows);
    window.addEventListener("keydown", (event) => this.#press(event));
    // After a click the keys are shortcuts again.
    window.addEventListener("click", ({ detail, target }) => {
      if (detail > 0 && !target.closest("dialog") && !document.activeElement?.matches(TYPED)) document.activeElement?.blur();
    });
  }

  #press(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented) return;
    const target = event.target;
    if (event.key === "Escape") {
      // A dialog closes itself.
      if (document.querySelector("dialog[open]")) return;
      if (target.closest?.("details[open]")) target.closest("details").open = false;
      else if (target.matches?.(CONTROLS)) document.activeElement?.blur();
      else this.actions.Escape?.(event);
      return;
    }
    if (target.closest?.(TYPED) || document.querySelector("dialog[open]")) return;
    if (target.closest?.(CONTROLS) && (OWN_KEYS.includes(event.key) || event.key.startsWith("Arrow"))) return;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    if (!this.actions[key] || (!$("shortcuts-on").checked && key !== "?")) return;
    event.preventDefault();
    this.actions[key](event);
  }
}
