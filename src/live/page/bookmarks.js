// Bookmarks: scene, changed numbers, playback speed, views and the motion reached under a name, kept in this browser.

import { changedNumbers } from "/controls.js";
import { $, make } from "/dom.js";
import { T } from "/texts.js";

// Simulated time after which a motion counts as settled, ms.
const SETTLED = 300;

export class Bookmarks {
  #run;
  #stage;
  #shipped = [];

  constructor(run, stage) {
    this.#run = run;
    this.#stage = stage;
    $("bookmark-add").onclick = () => this.#ask();
    $("bookmark-new").onclose = () => this.#add($("bookmark-new").returnValue === "keep" && $("bookmark-name").value.trim());
    this.#load();
  }

  async #load() {
    const { bookmarks } = await (await fetch("/tour.json")).json().catch(() => ({}));
    this.#shipped = bookmarks?.steps ?? [];
    this.#draw();
  }

  get #own() {
    const stored = JSON.parse(localStorage.getItem("bookmarks") ?? "[]");
    return stored;
  }

  #keep(bookmarks) {
    localStorage.setItem("bookmarks", JSON.stringify(bookmarks));
    this.#draw();
  }

  // Asks for the name of a bookmark.
  #ask() {
    const { scene, tilt_deg: tilt } = this.#run.panel ?? {};
    if (!scene) return;
    $("bookmark-name").value = tilt === null ? scene : `${scene}, ${T.degrees(tilt)}`;
    $("bookmark-new").returnValue = "";
    $("bookmark-new").showModal();
    $("bookmark-name").select();
  }

  #add(name) {
    const { scene, speed, time_s, regime, confidence, lines } = this.#run.panel;
    if (!name) return;
    const promise = confidence === null ? null : {
      motion: regime,
      line_khz: lines.length ? 1e-3 * lines[0].frequency_hz : null,
      after_ms: Math.min(1e3 * time_s, SETTLED),
    };
    this.#keep([...this.#own, { say: name, scene, set: changedNumbers(this.#run.panel), speed_ms_per_s: 1e3 * speed, views: this.#stage.shown, promise }]);
  }

  #draw() {
    const own = this.#own;
    const entry = (bookmark, remove) => {
      const parts = [make("button", { textContent: bookmark.say, onclick: () => this.open(bookmark) })];
      if (remove) parts.push(make("button", { textContent: "×", "aria-label": T.bookmarkRemove(bookmark.say), className: "remove", onclick: remove }));
      return make("span", { className: "bookmark" }, ...parts);
    };
    const entries = own.map((bookmark, k) => entry(bookmark, () => this.#keep(own.filter((_, i) => i !== k))));
    $("bookmark-list").replaceChildren(...this.#shipped.map((bookmark) => entry(bookmark)), ...entries);
  }

  // Restarts the scene: the motion does not depend on what ran before.
  open({ scene, set, speed_ms_per_s, promise, views }) {
    this.#stage.show(views);
    this.#run.ask({ do: "open", scene, set, speed_ms_per_s, promise });
  }
}
