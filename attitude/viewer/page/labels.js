// Words beside points of the picture, each where it hides no other.

const LINE = 16; // pixels from a label to one below it
const MOST = 8; // lines that a label moves, up or down

export class Labels {
  constructor(parent) {
    this.parent = parent;
    this.entries = [];
    this.point = new THREE.Vector3();
  }

  // A label at an object's place; hidden with it.
  add(text, color, object) {
    const span = document.createElement("span");
    span.textContent = text;
    span.style.color = color;
    this.parent.appendChild(span);
    this.entries.push({ span, object, text, color, x: 0, y: 0, width: 0 });
  }

  // Those that are seen: text, color and place of the upper left corner.
  shown() {
    return this.entries.filter(({ span }) => !span.hidden);
  }

  update(camera, width, height) {
    const taken = this.buttons();
    for (const entry of this.entries) {
      const { span, object } = entry;
      let shown = true;
      for (let each = object; each; each = each.parent) shown = shown && each.visible;
      if (shown) {
        object.getWorldPosition(this.point).project(camera);
        shown = Math.abs(this.point.x) < 1 && Math.abs(this.point.y) < 1 && this.point.z < 1;
      }
      span.hidden = !shown;
      if (!shown) continue;
      entry.width ||= span.offsetWidth;
      // beyond the tip, seen from the centre: not on the arrow
      const { x, y } = this.point;
      entry.x = ((x + 1) / 2) * width + (x < 0 ? -4 - entry.width : 4);
      entry.x = Math.max(0, Math.min(entry.x, width - entry.width));
      entry.y = this.free(entry, ((1 - y) / 2) * height + (y < 0 ? 2 : -18), taken, height);
      taken.push(entry);
      span.style.transform = `translate(${entry.x.toFixed(1)}px, ${entry.y.toFixed(1)}px)`;
    }
  }

  // The height nearest to the wanted one at which a label hides none of those placed.
  free({ x, width }, wanted, taken, height) {
    for (let k = 0; k <= 2 * MOST; k++) {
      const y = wanted + (k % 2 ? -1 : 1) * Math.ceil(k / 2) * LINE;
      const hides = (other) =>
        x < other.x + other.width && other.x < x + width &&
        y < other.y + (other.height || LINE) && other.y < y + LINE;
      if (y >= 0 && y <= height - LINE && !taken.some(hides)) return y;
    }
    return wanted;
  }

  // The buttons that lie on the picture.
  buttons() {
    const { offsetLeft, offsetTop, offsetWidth, offsetHeight } = document.getElementById("views");
    return [{ x: offsetLeft, y: offsetTop, width: offsetWidth, height: offsetHeight }];
  }
}
