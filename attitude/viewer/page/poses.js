// The attitude and the angular velocity of the body at any time of the span.
import { float32, int16 } from "./bytes.js";

export class Poses {
  constructor(pieces) {
    this.pieces = pieces.map((piece) => ({
      start: piece.start,
      step: piece.step,
      wxyz: int16(piece.wxyz),
      rates: float32(piece.rates),
      last: int16(piece.wxyz).length / 4 - 1,
    }));
    this.before = new THREE.Quaternion();
    this.after = new THREE.Quaternion();
  }

  // The piece of a time, the attitude before it, and the part of the step to the next one.
  at(time) {
    let k = this.pieces.length - 1;
    while (k > 0 && time < this.pieces[k].start) k--;
    const piece = this.pieces[k];
    const steps = Math.min(Math.max((time - piece.start) / piece.step, 0), piece.last);
    const row = Math.min(Math.floor(steps), Math.max(piece.last - 1, 0));
    return { piece, row, part: steps - row };
  }

  // Body to ICRF; along a great circle between two attitudes.
  pose(time, target) {
    const { piece, row, part } = this.at(time);
    this.read(piece, row, this.before);
    this.read(piece, Math.min(row + 1, piece.last), this.after);
    return target.slerpQuaternions(this.before, this.after, part);
  }

  // rad/s over the body axes.
  rate(time, target) {
    const { piece, row, part } = this.at(time);
    const next = Math.min(row + 1, piece.last);
    const along = (k) => piece.rates[3 * row + k] * (1 - part) + piece.rates[3 * next + k] * part;
    return target.set(along(0), along(1), along(2));
  }

  read(piece, row, target) {
    const [w, x, y, z] = piece.wxyz.subarray(4 * row, 4 * row + 4);
    return target.set(x, y, z, w).normalize();
  }
}

// Unit vectors at equal steps over the span, or one for all times.
export class Directions {
  constructor(text, duration) {
    this.rows = float32(text);
    this.last = this.rows.length / 3 - 1;
    this.duration = duration;
  }

  at(time, target) {
    const steps = Math.min(Math.max(time / this.duration, 0), 1) * this.last;
    const row = Math.min(Math.floor(steps), Math.max(this.last - 1, 0));
    const next = Math.min(row + 1, this.last);
    const part = steps - row;
    const along = (k) => this.rows[3 * row + k] * (1 - part) + this.rows[3 * next + k] * part;
    return target.set(along(0), along(1), along(2)).normalize();
  }
}
