// The time of the motion that is shown, in seconds from the start, and how fast it runs.

const FACTORS = [-10, -1, 0.01, 0.1, 0.25, 0.5, 1, 2, 4, 10, 100, 1000];

export class Clock {
  constructor(duration, utc, speed) {
    this.duration = duration;
    this.begin = Date.parse(utc[0] + "Z");
    this.end = Date.parse(utc[1] + "Z");
    this.time = 0;
    this.speed = speed;
    this.factor = 1;
    this.playing = true;
    this.listeners = [];
  }

  static factors() {
    return FACTORS;
  }

  onChange(listener) {
    this.listeners.push(listener);
  }

  set(time) {
    this.time = Math.min(Math.max(time, 0), this.duration);
    for (const listener of this.listeners) listener(this.time);
  }

  // After some seconds of the viewer; from the end the motion begins again.
  advance(seconds) {
    if (!this.playing) return;
    const next = this.time + seconds * this.speed * this.factor;
    if (next > this.duration) this.set(0);
    else if (next < 0) this.set(this.duration);
    else this.set(next);
  }

  play(playing) {
    this.playing = playing;
    this.set(this.time);
  }

  // The next slower or faster factor.
  change(by) {
    const at = FACTORS.indexOf(this.factor) + by;
    this.factor = FACTORS[Math.min(Math.max(at, 0), FACTORS.length - 1)];
    this.set(this.time);
  }

  // UTC, with milliseconds where the span is short; seconds where JavaScript has no date.
  utc() {
    const part = this.duration > 0 ? this.time / this.duration : 0;
    const unit = this.duration < 600 ? 1 : 1000;
    if (!Number.isFinite(this.begin + this.end)) return `${this.time.toPrecision(7)} s`;
    const moment = Math.round((this.begin + part * (this.end - this.begin)) / unit) * unit;
    const text = new Date(moment).toISOString();
    return `${text.slice(0, unit === 1 ? 23 : 19).replace("T", " ")} UTC`;
  }
}
