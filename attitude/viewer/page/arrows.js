// Arrows from the centre of the body: its axes, momentum, angular velocity, Sun, observer.

const ORIGIN = new THREE.Vector3();

// An arrow with a point at its tip, where its label stands.
export class NamedArrow {
  constructor(name, color, length, labels) {
    this.name = name;
    this.color = color;
    const x = new THREE.Vector3(1, 0, 0);
    this.object = new THREE.ArrowHelper(x, ORIGIN, length, color, 0.09, 0.05);
    this.tip = new THREE.Group();
    this.tip.position.y = length; // an ArrowHelper turns its own y axis
    this.object.add(this.tip);
    labels.add(name, color, this.tip);
  }

  point(direction) {
    this.object.setDirection(direction);
  }
}

export const COLORS = {
  axes: ["#ff6b6b", "#7bd88f", "#6cb6ff"],
  momentum: "#f5f5f5",
  rate: "#ffb454",
  sun: "#ffe66d",
  observer: "#c792ea",
};

// Groups of arrows by the name of their switch.
export function arrowsOf(data, labels) {
  const axes = ["x", "y", "z"].map((name, k) => {
    const arrow = new NamedArrow(name, COLORS.axes[k], 1.35, labels);
    arrow.point(new THREE.Vector3().setComponent(k, 1));
    return arrow;
  });
  const found = { axes };
  if (data.momentum) {
    found.momentum = [new NamedArrow("momentum", COLORS.momentum, 1.6, labels)];
    found.momentum[0].point(new THREE.Vector3(...data.momentum));
  }
  // A body at rest has no direction of its angular velocity.
  if (data.turns) found.rate = [new NamedArrow("angular velocity", COLORS.rate, 1.5, labels)];
  if (data.sun) found.sun = [new NamedArrow("Sun", COLORS.sun, 1.6, labels)];
  if (data.observer) found.observer = [new NamedArrow("observer", COLORS.observer, 1.6, labels)];
  return found;
}
