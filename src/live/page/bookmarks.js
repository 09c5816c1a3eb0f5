// Bookmarks: scene, changed numbers, state, playback speed, views and the motion reached under a name, kept in this browser.
// The server says what the present motion is.

import { $, make } from "/dom.js";
import { T } from "/texts.js";

export class Bookmarks {
  #run;
  #stage;
  #shipped = [];
  // What the server says of the motion to keep.
  #present = null;

  constructor(run, stage) {
    this.#run = run;
    this.#stage = stage;
    $("bookmark-add").onclick = () => this.#ask();
    $("bookmark-new").onclose = () => this.#add($("bookmark-new").returnValue === "keep" && $("bookmark-name").value.trim());
    this.#draw();
  }

  // Sets the bookmarks that ship.
  set shipped(steps) {
    this.#shipped = steps;
    this.#draw();
  }

  get #own() {
    return JSON.parse(localStorage.getItem("bookmarks") ?? "[]");
  }

  #keep(bookmarks) {
    localStorage.setItem("bookmarks", JSON.stringify(bookmarks));
    this.#draw();
  }

  // Asks for the name of a bookmark of the present motion.
  #ask() {
    const { scene, tilt_deg: tilt } = this.#run.panel ?? {};
    if (!scene) return;
    this.#present = fetch("/bookmark.json").then((answer) => answer.json());
    $("bookmark-name").value = tilt === null ? scene : `${scene}, ${T.degrees(tilt)}`;
    $("bookmark-new").returnValue = "";
    $("bookmark-new").showModal();
    $("bookmark-name").select();
  }

  async #add(name) {
    if (!name) return;
    const present = await this.#present;
    this.#keep([...this.#own, { ...present, say: name, views: this.#stage.shown }]);
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
  open(bookmark) {
    this.#stage.show(bookmark.views);
    this.#run.ask({ do: "open", ...bookmark });
  }
}
