// The page: its parts, and the loop that draws.
import { Clock } from "./clock.js";
import { Curve } from "./curve.js";
import { listenToKeys } from "./keys.js";
import { drawsWebGL, showNumbers } from "./numbers.js";
import { Panel } from "./panel.js";
import { Quality } from "./quality.js";
import { listenToShare } from "./share.js";
import { Stage } from "./stage.js";
import { Views } from "./views.js";

const data = JSON.parse(document.getElementById("data").textContent);
const clock = new Clock(data.duration, data.utc, data.speed);
if (!drawsWebGL()) {
  showNumbers(data, clock);
  return;
}
const stage = new Stage(
  document.getElementById("picture"),
  document.getElementById("labels"),
  data,
);
const quality = new Quality(stage);
const views = new Views(stage);
const panel = new Panel(data, stage, views, clock);
const curve = data.curve
  ? new Curve(document.getElementById("curve"), data.curve, clock, stage.shade)
  : null;
listenToKeys(clock, panel);
listenToShare({ data, stage, clock, curve });

// Frames, those of them that drew a picture, and milliseconds of script of all frames, without what
// the graphics processor does later.
const frames = { count: 0, drawn: 0, script: 0 };

function resize() {
  if (curve) curve.resize();
  stage.resize();
}

function drawAt(time) {
  stage.place(time);
  views.update(time);
  stage.draw();
  if (curve) curve.draw(time);
}

let last = null;
function frame(now) {
  const begin = performance.now();
  if (last !== null) clock.advance(Math.min((now - last) / 1000, 0.2));
  last = now;
  quality.frame(now);
  if (stage.changed) {
    drawAt(clock.time);
    frames.drawn += 1;
  }
  frames.count += 1;
  frames.script += performance.now() - begin;
  requestAnimationFrame(frame);
}

window.addEventListener("resize", resize);
clock.onChange(() => stage.touch());
resize();
clock.set(0);
requestAnimationFrame(frame);

// For scripts on the page, such as tests: the attitude at a time as [w, x, y, z], body to ICRF.
window.attitudeViewer = {
  clock,
  frames,
  panel,
  quality,
  stage,
  views,
  drawAt,
  pose(time) {
    const { x, y, z, w } = stage.poses.pose(time, new THREE.Quaternion());
    return [w, x, y, z];
  },
};
