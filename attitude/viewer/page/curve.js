// The light curve below the picture, with a cursor at the time that is shown.
import { float32, float64 } from "./bytes.js";

const MARGIN = { left: 58, right: 24, top: 12, bottom: 24 };
const UNITS = [[259200, 86400, "d"], [10800, 3600, "h"], [600, 60, "min"], [0, 1, "s"]];

// About `count` round numbers within a range.
export function ticks(low, high, count) {
  const rough = (high - low) / count;
  if (!(rough > 0)) return [low];
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * ([1, 2, 5].find((each) => each * power >= rough) || 10);
  const found = [];
  for (let k = Math.ceil(low / step); k * step <= high * (1 + 1e-12); k++) found.push(k * step);
  return found;
}

export class Curve {
  constructor(canvas, data, clock, shade) {
    this.canvas = canvas;
    this.shade = shade;
    this.clock = clock;
    this.times = float64(data.times);
    this.values = float32(data.values);
    this.label = data.label;
    const seen = this.values.filter(Number.isFinite);
    this.low = seen.reduce((a, b) => Math.min(a, b), Infinity);
    this.high = seen.reduce((a, b) => Math.max(a, b), -Infinity);
    if (!(this.high > this.low)) {
      const middle = seen.length ? this.low : 0;
      [this.low, this.high] = [middle - 0.5, middle + 0.5];
    }
    canvas.hidden = false;
    this.still = document.createElement("canvas");
    this.listen();
  }

  listen() {
    const move = (event) => {
      const box = this.canvas.getBoundingClientRect();
      const part = (event.clientX - box.left - MARGIN.left) / this.width();
      this.clock.set(Math.min(Math.max(part, 0), 1) * this.clock.duration);
    };
    this.canvas.addEventListener("pointerdown", (event) => {
      this.canvas.setPointerCapture(event.pointerId);
      this.clock.play(false);
      move(event);
    });
    this.canvas.addEventListener("pointermove", (event) => {
      if (event.buttons & 1) move(event);
    });
  }

  width() {
    return this.canvas.clientWidth - MARGIN.left - MARGIN.right;
  }

  x(time) {
    return MARGIN.left + (time / this.clock.duration) * this.width();
  }

  // Magnitudes grow downwards.
  y(value) {
    const height = this.canvas.clientHeight - MARGIN.top - MARGIN.bottom;
    return MARGIN.top + ((value - this.low) / (this.high - this.low)) * height;
  }

  resize() {
    const ratio = Math.min(window.devicePixelRatio, 2);
    for (const each of [this.canvas, this.still]) {
      each.width = this.canvas.clientWidth * ratio;
      each.height = this.canvas.clientHeight * ratio;
      each.getContext("2d").setTransform(ratio, 0, 0, ratio, 0, 0);
    }
    this.drawStill();
    this.draw(this.clock.time);
  }

  drawStill() {
    const pen = this.still.getContext("2d");
    pen.clearRect(0, 0, this.canvas.clientWidth, this.canvas.clientHeight);
    if (this.shade) this.drawShade(pen);
    this.drawAxes(pen);
    pen.strokeStyle = "#ffb454";
    pen.lineWidth = 1.2;
    pen.beginPath();
    let isGap = true;
    for (let k = 0; k < this.times.length; k++) {
      const value = this.values[k];
      if (!Number.isFinite(value)) {
        isGap = true;
        continue;
      }
      if (isGap) pen.moveTo(this.x(this.times[k]), this.y(value));
      else pen.lineTo(this.x(this.times[k]), this.y(value));
      isGap = false;
    }
    pen.stroke();
  }

  // Grey where other bodies hide the Sun, in part or wholly.
  drawShade(pen) {
    const { times, lit } = this.shade;
    const height = this.canvas.clientHeight - MARGIN.top - MARGIN.bottom;
    const darkness = (k) => 1 - 0.5 * (lit[k - 1] + lit[k]);
    let first = 1; // of the intervals that are equally dark, drawn as one
    for (let k = 1; k < times.length; k++) {
      if (k + 1 < times.length && darkness(k + 1) === darkness(k)) continue;
      const left = this.x(times[first - 1]);
      pen.fillStyle = `rgba(110, 120, 145, ${(0.4 * darkness(k)).toFixed(3)})`;
      if (darkness(k) > 0) pen.fillRect(left, MARGIN.top, this.x(times[k]) - left, height);
      first = k + 1;
    }
  }

  drawAxes(pen) {
    const { duration } = this.clock;
    const bottom = this.canvas.clientHeight - MARGIN.bottom;
    const [, unit, name] = UNITS.find(([least]) => duration >= least);
    pen.font = "11px system-ui, sans-serif";
    pen.fillStyle = "#8b93a5";
    pen.strokeStyle = "#2b3140";
    pen.textAlign = "center";
    for (const tick of ticks(0, duration / unit, 8)) {
      const x = this.x(tick * unit);
      pen.strokeRect(x, MARGIN.top, 0, bottom - MARGIN.top);
      pen.fillText(`${Number(tick.toPrecision(6))} ${name}`, x, bottom + 15);
    }
    pen.textAlign = "right";
    for (const tick of ticks(this.low, this.high, 4)) {
      pen.fillText(String(Number(tick.toPrecision(5))), MARGIN.left - 6, this.y(tick) + 4);
    }
    pen.save();
    pen.translate(11, (MARGIN.top + bottom) / 2);
    pen.rotate(-Math.PI / 2);
    pen.textAlign = "center";
    pen.fillText(this.label, 0, 0);
    pen.restore();
  }

  draw(time) {
    const pen = this.canvas.getContext("2d");
    const { clientWidth, clientHeight } = this.canvas;
    pen.clearRect(0, 0, clientWidth, clientHeight);
    pen.drawImage(this.still, 0, 0, clientWidth, clientHeight);
    pen.fillStyle = "#ffffff";
    pen.fillRect(this.x(time) - 0.5, MARGIN.top, 1, clientHeight - MARGIN.top - MARGIN.bottom);
    if (this.times[1] === this.times[0]) return; // extremes, which have no value at a time
    const value = this.valueAt(time);
    if (!Number.isFinite(value)) return;
    pen.beginPath();
    pen.arc(this.x(time), this.y(value), 3.5, 0, 2 * Math.PI);
    pen.fill();
  }

  // The curve between its points; NaN in a gap.
  valueAt(time) {
    const last = this.times.length - 1;
    const steps = (time / this.clock.duration) * last;
    const row = Math.min(Math.floor(steps), last - 1);
    return this.values[row] + (this.values[row + 1] - this.values[row]) * (steps - row);
  }
}
