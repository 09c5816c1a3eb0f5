// Bookmarks: scene, tilt, playback speed and views under a name, kept in this browser.

import { $, make } from "/dom.js";
import { T } from "/texts.js";

const SHIPPED = [
  { name: T.bookmarkNames[0], scene: "torus-3deg", tilt: 0, speed: 20, views: ["portrait", "spectrum", "scope", "section"] },
  { name: T.bookmarkNames[1], scene: "torus-3deg", tilt: 3, speed: 20, views: ["portrait", "section", "spectrum", "recurrence"] },
  { name: T.bookmarkNames[2], scene: "torus-3deg", tilt: 5.5, speed: 20, views: ["portrait", "section", "spectrum", "recurrence"] },
  { name: T.bookmarkNames[3], scene: "lift-off", tilt: null, speed: 1, views: ["patch", "body"] },
  { name: T.bookmarkNames[4], scene: "stick-slip", tilt: null, speed: 1, views: ["patch", "scope", "portrait"] },
  { name: T.bookmarkNames[5], scene: "hysteresis", tilt: null, speed: 50, views: ["spectrogram", "spectrum", "branches"] },
];

export class Bookmarks {
  #run;
  #stage;

  constructor(run, stage) {
    this.#run = run;
    this.#stage = stage;
    $("bookmark-add").onclick = () => this.#ask();
    $("bookmark-new").onclose = () => this.#add($("bookmark-new").returnValue === "keep" && $("bookmark-name").value.trim());
    this.#draw();
  }

  get #own() {
    return JSON.parse(localStorage.getItem("bookmarks") ?? "[]");
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
    const { scene, tilt_deg: tilt, speed } = this.#run.panel;
    if (name) this.#keep([...this.#own, { name, scene, tilt, speed: 1e3 * speed, views: this.#stage.shown }]);
  }

  #draw() {
    const own = this.#own;
    const entry = (bookmark, remove) => {
      const parts = [make("button", { textContent: bookmark.name, onclick: () => this.open(bookmark) })];
      if (remove) parts.push(make("button", { textContent: "×", "aria-label": T.bookmarkRemove(bookmark.name), className: "remove", onclick: remove }));
      return make("span", { className: "bookmark" }, ...parts);
    };
    const entries = own.map((bookmark, k) => entry(bookmark, () => this.#keep(own.filter((_, i) => i !== k))));
    $("bookmark-list").replaceChildren(...SHIPPED.map((bookmark) => entry(bookmark)), ...entries);
  }

  open({ scene, tilt, speed, views }) {
    this.#stage.show(views);
    this.#run.ask({ do: "speed", ms_per_s: speed });
    const commands = tilt === null ? [] : [{ do: "tilt", deg: tilt }];
    if (scene === this.#run.scene) this.#run.follow(commands);
    else this.#run.start(scene, commands);
  }
}
