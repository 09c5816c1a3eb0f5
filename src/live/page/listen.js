// Plays audio blocks from a short buffer. If the buffer runs empty, the player fades to silence and refills
// it.

const BUFFERED = 0.15;
const MAX_BUFFERED = 1.0;
const FADE = 1 / 256;

class Player extends AudioWorkletProcessor {
  #pieces = [];
  #at = 0;
  #count = 0;
  #playing = false;
  #gain = 0;
  #last = 0;

  constructor() {
    super();
    this.port.onmessage = ({ data }) => {
      this.#pieces.push(data);
      this.#count += data.length;
      // After a pause of the browser tab, old audio is dropped.
      while (this.#count > MAX_BUFFERED * sampleRate) {
        this.#count -= this.#pieces.shift().length - this.#at;
        this.#at = 0;
      }
    };
  }

  #next() {
    const piece = this.#pieces[0];
    const sample = piece[this.#at++];
    this.#count--;
    if (this.#at === piece.length) {
      this.#pieces.shift();
      this.#at = 0;
    }
    return sample;
  }

  process(_, [[channel]]) {
    for (let k = 0; k < channel.length; k++) {
      this.#playing = this.#playing ? this.#count > 0 : this.#count > BUFFERED * sampleRate;
      if (this.#playing) {
        this.#gain = Math.min(1, this.#gain + FADE);
        this.#last = this.#next();
      } else {
        this.#gain = Math.max(0, this.#gain - FADE);
      }
      channel[k] = this.#gain * this.#last;
    }
    return true;
  }
}

registerProcessor("player", Player);
