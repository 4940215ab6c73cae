// Words beside points of the picture.

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
    this.entries.push({ span, object });
  }

  update(camera, width, height) {
    for (const { span, object } of this.entries) {
      let shown = true;
      for (let each = object; each; each = each.parent) shown = shown && each.visible;
      if (shown) {
        object.getWorldPosition(this.point).project(camera);
        shown = Math.abs(this.point.x) < 1 && Math.abs(this.point.y) < 1 && this.point.z < 1;
      }
      span.hidden = !shown;
      if (!shown) continue;
      const x = ((this.point.x + 1) / 2) * width + 4;
      const y = ((1 - this.point.y) / 2) * height - 18;
      span.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
    }
  }
}
