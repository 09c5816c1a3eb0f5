// Starts Rerun's web viewer with the recording of this server.

// The colours of the recordings are made for a dark viewer. It asks for those of the system.
const ask = window.matchMedia.bind(window);
window.matchMedia = (query) => {
  const scheme = /prefers-color-scheme:\s*(\w+)/.exec(query)?.[1];
  return ask(!scheme ? query : scheme === "dark" ? "all" : "not all");
};

async function start() {
  await wasm_bindgen({ module_or_path: "/viewer.wasm" });
  const handle = new wasm_bindgen.WebHandle({
    url: [`${location.origin}/recording.rrd`],
    render_backend: new URLSearchParams(location.search).get("renderer"),
    hide_welcome_screen: true,
    enable_history: false,
    notebook: false,
    persist: false,
  });
  await handle.start(document.getElementById("viewer"));
  window.handle = handle;
  document.getElementById("status").remove();
  const watch = setInterval(() => {
    if (!handle.has_panicked()) return;
    clearInterval(watch);
    fail(handle.panic_message());
  }, 1000);
}

function fail(fault) {
  document.getElementById("viewer").remove();
  const said = document.createElement("p");
  said.textContent = `The viewer cannot show the recording: ${fault}. The native viewer may: rerun FILE.rrd`;
  document.body.replaceChildren(said);
}

start().catch(fail);
