// The laboratory: Rerun's viewer with the complete recording of the run, loaded only when it is opened.

import { $, make } from "/dom.js";
import { T } from "/texts.js";
import { ViewerHost } from "/viewer-host.js";

export class Laboratory {
  host = null;

  get open() {
    return !$("laboratory").hidden;
  }

  toggle() {
    const open = !this.open;
    $("laboratory").hidden = !open;
    $("stages").hidden = open;
    $("laboratory-open").setAttribute("aria-pressed", open);
    if (open) this.#load();
    else this.#stop();
    (open ? $("laboratory-close") : $("laboratory-open")).focus();
  }

  // Loads the viewer again, for example in other colours.
  reload() {
    if (!this.open) return;
    this.#stop();
    this.#load();
  }

  // A hidden viewer would still draw.
  #stop() {
    this.host?.stop();
    this.host = null;
    $("laboratory").replaceChildren();
  }

  async #load() {
    const close = make("button", { id: "laboratory-close", textContent: T.backToViews, onclick: () => this.toggle() });
    const loading = make("span", { id: "loading", role: "status", textContent: T.loadingViewer });
    const canvas = make("canvas", { id: "viewer", tabIndex: 0, "aria-label": T.viewer, role: "application" });
    $("laboratory").replaceChildren(make("div", { className: "bar" }, close, loading), canvas);
    const host = new ViewerHost(canvas);
    this.host = host;
    try {
      if (!window.wasm_bindgen) await loadScript("/viewer.js");
      await host.start();
      loading.remove();
    } catch (fault) {
      loading.textContent = T.viewerFault(fault);
    }
  }
}

const loadScript = (src) =>
  new Promise((resolve, reject) => {
    document.head.append(make("script", { src, onload: resolve, onerror: () => reject(src) }));
  });
