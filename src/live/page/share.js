// Sharing: the address for the audience with its QR code, pictures and clips of views, the sheet, the recordings.

import { $, make, save, setText } from "/dom.js";
import { qrCode } from "/qr.js";
import { T } from "/texts.js";

// Length of a clip, ms, and its pictures per second.
const CLIP = 10_000;
const RATE = 30;

const fileName = (name) => name.toLowerCase().replaceAll(/[^a-zé0-9]+/g, "-");

// Saves a picture of a view, with a line about the run below it.
export function savePicture(canvas, name, run) {
  const css = getComputedStyle(document.documentElement);
  const line = 2 * Number.parseFloat(css.fontSize) * (canvas.width / canvas.clientWidth);
  const picture = make("canvas", { width: canvas.width, height: canvas.height + line });
  const context = picture.getContext("2d");
  context.fillStyle = css.getPropertyValue("--ground");
  context.fillRect(0, 0, picture.width, picture.height);
  context.drawImage(canvas, 0, 0);
  context.fillStyle = css.getPropertyValue("--text");
  context.font = `${line / 2.4}px ${css.fontFamily}`;
  const { scene, now, tilt_deg: tilt, time_s: time } = run.panel ?? {};
  const parts = [name, scene, now, tilt === null || tilt === undefined ? "" : T.degrees(tilt), T.seconds(time ?? 0)];
  context.fillText(parts.filter(Boolean).join(" · "), line / 3, picture.height - line / 3);
  picture.toBlob((blob) => save(blob, `${fileName(name)}.png`));
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
