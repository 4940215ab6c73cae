// Text, switches, the choice of the view and the transport.
import { COLORS } from "./arrows.js";
import { Clock } from "./clock.js";

const SWITCHES = [
  ["body", "body", "#b9b3a8", true],
  ["axes", "body axes", COLORS.axes[0], true],
  ["momentum", "momentum", COLORS.momentum, true],
  ["rate", "angular velocity", COLORS.rate, true],
  ["sun", "direction to the Sun", COLORS.sun, true],
  ["observer", "direction to the observer", COLORS.observer, true],
  ["polhode", "polhode on the ellipsoid of inertia", "#ff5c8a", false],
  ["poinsot", "Poinsot's construction", "#4dd0e1", false],
  ["shadows", "shadows", "#555c6b", true],
];
const TITLES = { inertial: "inertial", observer: "observer", sun: "Sun", body: "body" };

export class Panel {
  constructor(data, stage, views, clock) {
    this.stage = stage;
    this.views = views;
    this.clock = clock;
    document.getElementById("title").textContent = data.title;
    document.getElementById("kind").textContent = data.kind;
    for (const [name, value] of data.facts) this.addFact(name, value);
    this.shown = {};
    this.boxes = {};
    for (const [name, text, color, isOn] of SWITCHES) {
      if (this.exists(name)) this.addSwitch(name, text, color, isOn);
    }
    this.buttons = {};
    for (const name of views.names()) this.addView(name);
    this.play = document.getElementById("play");
    this.scrubber = document.getElementById("scrubber");
    this.speed = document.getElementById("speed");
    this.utc = document.getElementById("utc");
    this.shade = document.getElementById("shade");
    this.listen();
    this.show();
    this.choose(views.current);
  }

  exists(name) {
    if (name === "polhode" || name === "poinsot") return this.stage.poinsot !== null;
    if (name === "shadows") return this.stage.mesh.castShadow;
    return name === "body" || name in this.stage.arrows;
  }

  addFact(name, value) {
    const term = document.createElement("dt");
    const meaning = document.createElement("dd");
    term.textContent = name;
    meaning.textContent = value;
    document.getElementById("facts").append(term, meaning);
  }

  addSwitch(name, text, color, isOn) {
    const label = document.createElement("label");
    const box = document.createElement("input");
    box.type = "checkbox";
    box.checked = isOn;
    box.name = name;
    const mark = document.createElement("i");
    mark.style.background = color;
    label.append(box, mark, text);
    document.getElementById("switches").appendChild(label);
    this.shown[name] = isOn;
    this.boxes[name] = box;
    box.addEventListener("change", () => this.toggle(name, box.checked));
  }

  addView(name) {
    const button = document.createElement("button");
    button.textContent = TITLES[name];
    button.name = name;
    button.addEventListener("click", () => this.choose(name));
    document.getElementById("views").appendChild(button);
    this.buttons[name] = button;
  }

  listen() {
    for (const factor of Clock.factors()) {
      this.speed.add(new Option(`${factor}×`, factor));
    }
    this.play.addEventListener("click", () => this.clock.play(!this.clock.playing));
    this.speed.addEventListener("change", () => {
      this.clock.factor = Number(this.speed.value);
    });
    this.scrubber.addEventListener("input", () => {
      const part = Number(this.scrubber.value) / 1e5; // before the clock moves the scrubber
      this.clock.play(false);
      this.clock.set(part * this.clock.duration);
    });
    this.clock.onChange(() => this.update());
  }

  toggle(name, isOn = !this.shown[name]) {
    if (!(name in this.shown)) return;
    this.shown[name] = isOn;
    this.boxes[name].checked = isOn;
    this.show();
  }

  choose(name) {
    this.views.choose(name);
    for (const [each, button] of Object.entries(this.buttons)) {
      button.setAttribute("aria-pressed", String(each === this.views.current));
    }
  }

  show() {
    const { stage, shown } = this;
    stage.mesh.visible = shown.body;
    stage.light.castShadow = shown.shadows;
    for (const [name, group] of Object.entries(stage.arrows)) {
      for (const arrow of group) arrow.object.visible = shown[name];
    }
    if (stage.poinsot) stage.poinsot.show(shown);
    stage.touch();
  }

  update() {
    this.play.textContent = this.clock.playing ? "❚❚" : "▶";
    this.scrubber.value = String(Math.round((this.clock.time / this.clock.duration) * 1e5));
    this.speed.value = String(this.clock.factor);
    this.utc.textContent = this.clock.utc();
    const { shade } = this.stage;
    this.shade.textContent = shade ? shade.words(this.clock.time) : "";
  }
}
