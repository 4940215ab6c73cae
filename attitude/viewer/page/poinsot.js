// Poinsot's construction: the ellipsoid of inertia rolls on the invariable plane.
import { float32 } from "./bytes.js";

const POLHODE = 0xff5c8a;
const HERPOLHODE = 0x4dd0e1;

function lineOf(rows, color) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(rows, 3));
  return new THREE.Line(geometry, new THREE.LineBasicMaterial({ color }));
}

export class Poinsot {
  // scale: the longest semi-axis of the ellipsoid in units of the body.
  constructor(data, scale) {
    this.rate = data.rate;
    this.scale = scale;
    this.inBody = new THREE.Group();
    this.inSpace = new THREE.Group();
    this.ellipsoid = this.rolling(data);
    this.polhode = lineOf(float32(data.polhode), POLHODE);
    this.herpolhode = lineOf(float32(data.herpolhode), HERPOLHODE);
    this.plane = this.touched(data);
    this.contact = new THREE.Mesh(
      new THREE.SphereGeometry(0.025, 16, 8),
      new THREE.MeshBasicMaterial({ color: 0xffffff }),
    );
    this.inBody.add(this.ellipsoid, this.polhode);
    this.inSpace.add(this.plane, this.herpolhode, this.contact);
    this.inBody.scale.setScalar(scale);
    this.inSpace.scale.setScalar(scale);
  }

  rolling(data) {
    const material = new THREE.MeshLambertMaterial({
      color: 0x6fa8dc,
      transparent: true,
      opacity: 0.25,
      depthWrite: false,
    });
    const ball = new THREE.SphereGeometry(1, 64, 32);
    const positions = ball.getAttribute("position");
    const point = new THREE.Vector3();
    for (let k = 0; k < positions.count; k++) {
      point.fromBufferAttribute(positions, k);
      const along = point.toArray().map((value, axis) => value * data.semi_axes[axis]);
      const [x, y, z] = data.axes.map((row) => row.reduce((sum, e, axis) => sum + e * along[axis], 0));
      positions.setXYZ(k, x, y, z);
    }
    ball.computeVertexNormals();
    return new THREE.Mesh(ball, material);
  }

  touched(data) {
    const material = new THREE.MeshBasicMaterial({
      color: 0x4dd0e1,
      transparent: true,
      opacity: 0.12,
      side: THREE.DoubleSide,
      depthWrite: false,
    });
    const disc = new THREE.Mesh(new THREE.CircleGeometry(1.3, 64), material);
    const pole = new THREE.Vector3(...data.pole);
    disc.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), pole);
    disc.position.copy(pole).multiplyScalar(data.distance);
    return disc;
  }

  // The angular velocity, rad/s in ICRF, points to the place where ellipsoid and plane touch.
  update(rate) {
    this.contact.position.copy(rate).divideScalar(this.rate);
  }

  show(parts) {
    this.ellipsoid.visible = parts.polhode;
    this.polhode.visible = parts.polhode;
    this.herpolhode.visible = parts.poinsot;
    this.plane.visible = parts.poinsot;
    this.contact.visible = parts.poinsot;
    this.ellipsoid.visible = parts.polhode || parts.poinsot;
    this.polhode.visible = parts.polhode || parts.poinsot;
  }
}
