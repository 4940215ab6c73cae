// How much of the picture is drawn.  While frames follow each other and take too long, as on machines
// without graphics hardware, the next ones have fewer pixels, coarser shadows and a coarser mesh; a
// picture that stays is drawn whole.

const SLOW = 33; // ms between frames: 30 frames a second
const COUNT = 8; // intervals between frames whose median is compared with it
const STILL = 15; // frames without a change after which the picture counts as one that stays

export class Quality {
  constructor(stage) {
    this.stage = stage;
    const whole = stage.full;
    const fast = Math.min(whole.ratio, 1);
    this.levels = [
      whole,
      { ratio: fast, shadows: 1024, coarse: false },
      { ratio: fast, shadows: 1024, coarse: true },
      { ratio: fast, shadows: 512, coarse: true },
      { ratio: 0.6, shadows: 512, coarse: true },
    ].filter(({ coarse, shadows }) => !coarse || stage.coarse !== null || shadows === 512);
    this.level = 0; // of frames that follow each other
    this.drawn = 0; // of the last picture
    this.idle = 0; // frames since the last change
    this.last = null;
    this.intervals = [];
  }

  // Before each frame, at a time in ms.
  frame(now) {
    if (this.stage.changed) this.moved(now);
    else if (++this.idle === STILL) this.use(0);
  }

  moved(now) {
    if (this.idle >= STILL) {
      this.level = Math.max(this.level - 1, 0); // the machine may be less busy than it was
      this.intervals = [];
    } else if (this.last !== null) this.intervals.push(now - this.last);
    this.last = now;
    this.idle = 0;
    if (this.intervals.length === COUNT) {
      const median = this.intervals.sort((a, b) => a - b)[COUNT / 2];
      if (median > SLOW) this.level += median > 3 * SLOW ? 2 : 1;
      this.level = Math.min(this.level, this.levels.length - 1);
      this.intervals = [];
    }
    this.use(this.level);
  }

  use(level) {
    if (level === this.drawn) return;
    this.drawn = level;
    this.stage.reduce(this.levels[level]);
  }
}
