// Sharing: the address for the audience with its QR code, pictures and clips of views, the sheet, the recordings.

import { $, make, save, setText } from "/dom.js";
import { readStyle, wrapped } from "/plot.js";
import { qrCode } from "/qr.js";
import { T } from "/texts.js";

// Length of a clip, ms, and its pictures per second.
const CLIP = 10_000;
const RATE = 30;

const fileName = (name) => name.toLowerCase().replaceAll(/[^a-zé0-9]+/g, "-");

// Size of a picture, in the pixels of the page and in those of the file for each of them.
const SIZE = [800, 520];
const SCALE = 2;

// Saves a picture of a view, which `draw` draws, with a line about the run below it.
export function savePicture(name, run, draw) {
  const root = document.documentElement;
  const { theme } = root.dataset;
  if ($("picture-light").checked) root.dataset.theme = "light";
  const style = { ...readStyle(), em: 16 };
  const [width, height] = SIZE;
  const { scene, now, time_s: time } = run.panel ?? {};
  const picture = make("canvas", { width: SCALE * width, height: SCALE * (height + 4 * style.em) });
  const context = picture.getContext("2d");
  context.scale(SCALE, SCALE);
  context.fillStyle = style.ground;
  context.fillRect(0, 0, width, picture.height);
  draw(context, width, height, style);
  root.dataset.theme = theme;
  context.fillStyle = style.text;
  context.font = `${0.9 * style.em}px ${style.family}`;
  context.textAlign = "left";
  context.textBaseline = "top";
  const parts = [name, scene, now, tiltOf(run.panel), T.seconds(time ?? 0)];
  const lines = wrapped(context, parts.filter(Boolean).join(" · "), width - 2 * style.em);
  lines.slice(0, 3).forEach((line, k) => context.fillText(line, style.em, height + (0.4 + 1.2 * k) * style.em));
  picture.toBlob((blob) => save(blob, `${fileName(name)}.png`));
}

const tiltOf = (panel) => (panel?.tilt_deg === null ? "" : T.degrees(panel?.tilt_deg ?? 0));

// Fills the line of the printed sheet that says which run it shows.
export function fillSheet({ panel, data }) {
  const { load_n: load, parameters } = data.start;
  const parts = [panel?.scene, tiltOf(panel), load && T.load(load), parameters, new Date().toLocaleString()];
  setText($("sheet"), parts.filter(Boolean).join(" · "));
}

// Saves a clip of a view.
export function saveClip(canvas, name, button) {
  const type = ["video/webm", "video/mp4"].find((candidate) => MediaRecorder.isTypeSupported(candidate));
  const recorder = new MediaRecorder(canvas.captureStream(RATE), { mimeType: type });
  const pieces = [];
  recorder.ondataavailable = ({ data }) => pieces.push(data);
  recorder.onstop = () => {
    button.disabled = false;
    setText(button, T.clip);
    save(new Blob(pieces, { type }), `${fileName(name)}.${type.split("/")[1]}`);
  };
  button.disabled = true;
  setText(button, T.clipRunning);
  recorder.start();
  setTimeout(() => recorder.stop(), CLIP);
}

// The modules of a QR code as a drawing.
function drawing(text) {
  const modules = qrCode(text);
  const size = modules.length + 8;
  const path = modules.flatMap((row, r) => row.map((dark, c) => (dark ? `M${c + 4} ${r + 4}h1v1h-1z` : "")));
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("viewBox", `0 0 ${size} ${size}`);
  svg.setAttribute("role", "img");
  svg.setAttribute("aria-label", T.qrLabel);
  const shape = document.createElementNS("http://www.w3.org/2000/svg", "path");
  shape.setAttribute("d", path.join(""));
  svg.append(shape);
  return svg;
}

// Fills the dialog; without an address for the audience it says how to get one.
export function fillShare(address, recordings) {
  const parts = address
    ? [make("p", { textContent: T.shareAddress }), drawing(address), make("p", {}, make("code", { textContent: address }))]
    : [make("p", { textContent: T.shareLocal })];
  $("share-address").replaceChildren(...parts);
  const key = new URLSearchParams(location.search).get("key");
  const query = key ? `?key=${encodeURIComponent(key)}` : "";
  const links = recordings.map((name) =>
    make("li", {}, make("a", { href: `/recordings/${encodeURIComponent(name)}${query}`, download: name, textContent: name })),
  );
  $("share-recordings").replaceChildren(...(links.length ? links : [make("li", { textContent: T.noRecordings })]));
}
