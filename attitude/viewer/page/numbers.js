// In place of the picture, where the browser draws no WebGL: a sentence, and a table of numbers.
import { Poses } from "./poses.js";

const ROWS = 24;

export function drawsWebGL() {
  try {
    const gl = document.createElement("canvas").getContext("webgl2");
    if (gl) gl.getExtension("WEBGL_lose_context")?.loseContext();
    return gl !== null;
  } catch {
    return false;
  }
}

export function showNumbers(data, clock) {
  const poses = new Poses(data.poses);
  const stage = document.getElementById("stage");
  document.getElementById("title").textContent = data.title;
  document.getElementById("kind").textContent = data.kind;
  for (const [name, value] of data.facts) {
    const rows = [["dt", name], ["dd", value]].map(([kind, text]) => element(kind, text));
    document.getElementById("facts").append(...rows);
  }
  for (const name of ["transport", "views", "help"]) document.getElementById(name).hidden = true;
  document.getElementById("picture").hidden = true;
  const box = document.createElement("div");
  box.id = "numbers";
  box.append(element("p", "This browser draws no WebGL, so that the body is not shown turning; " +
    "switch on hardware acceleration, or open the page in another browser. Attitudes, body to " +
    "ICRF, and angular velocities over the body axes:"));
  const table = document.createElement("table");
  table.append(row("th", ["UTC", "w", "x", "y", "z", "deg/s: x", "y", "z"]));
  const pose = new THREE.Quaternion();
  const rate = new THREE.Vector3();
  for (let k = 0; k <= ROWS; k++) {
    clock.time = (k / ROWS) * data.duration;
    const { x, y, z, w } = poses.pose(clock.time, pose);
    const spin = poses.rate(clock.time, rate).multiplyScalar(180 / Math.PI);
    const numbers = [w, x, y, z].map((each) => each.toFixed(4));
    const rates = [spin.x, spin.y, spin.z].map((each) => each.toPrecision(4));
    table.append(row("td", [clock.utc().replace(" UTC", ""), ...numbers, ...rates]));
  }
  box.append(table);
  stage.append(box);
}

function element(kind, text) {
  const made = document.createElement(kind);
  made.textContent = text;
  return made;
}

function row(kind, texts) {
  const made = document.createElement("tr");
  made.append(...texts.map((each) => element(kind, each)));
  return made;
}
