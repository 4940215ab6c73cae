// How much of the Sun's disc other bodies leave free, and what the page says of it.
import { float32, float64 } from "./bytes.js";

export class Shade {
  constructor(data) {
    this.times = float64(data.times);
    this.lit = float32(data.lit);
    this.names = data.names;
  }

  // From 0, in the umbra, to 1, in sunlight.
  at(time) {
    const { times, lit } = this;
    const after = times.findIndex((each) => each >= time);
    const row = after < 0 ? times.length - 1 : Math.max(after, 1);
    const part = (time - times[row - 1]) / (times[row] - times[row - 1]);
    return lit[row - 1] + (lit[row] - lit[row - 1]) * Math.min(Math.max(part, 0), 1);
  }

  words(time) {
    const lit = this.at(time);
    if (lit >= 1) return "";
    return `in ${this.names} ${lit > 0 ? "penumbra" : "umbra"}`;
  }
}
