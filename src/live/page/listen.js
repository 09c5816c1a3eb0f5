// Plays what comes, with a little in hand; when that runs out it fades to silence and gathers anew.

const IN_HAND = 0.15;
const AT_MOST = 1.0;
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
      // Whoever was asleep for a while does not hear the past.
      while (this.#count > AT_MOST * sampleRate) {
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
      this.#playing = this.#playing ? this.#count > 0 : this.#count > IN_HAND * sampleRate;
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
