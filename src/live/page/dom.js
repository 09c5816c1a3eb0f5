// Helpers for the elements of the page.

export const $ = (id) => document.getElementById(id);

// Creates an element with properties and children.
export function make(tag, properties = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name in element) element[name] = value;
    else element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
}

// Sets a text only if it changes: screen readers announce each change.
export function setText(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

// Two significant digits, without exponents.
export const short = (x) => minus(`${Number(x.toPrecision(2))}`);

// A text with minus signs in front of its negative numbers.
export const minus = (text) => text.replaceAll(/(^|[\s(±/])-(?=\d)/g, "$1−").replaceAll(/ - (?=f\d|\d+ f\d)/g, " − ");

// Offers a file for download.
export function save(blob, name) {
  const link = make("a", { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

// File and scene names may contain characters that change the direction or layout of other text.
const HIDDEN = /[\p{Cc}\u061c\u200e\u200f\u2028\u2029\u202a-\u202e\u2066-\u2069]/gu;
export const shown = (text) =>
  text.replace(HIDDEN, (c) => `\\u${c.charCodeAt(0).toString(16).padStart(4, "0")}`);
