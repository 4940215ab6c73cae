// Points of view: inertial space, the observer, the Sun, the body.

const NORTH = new THREE.Vector3(0, 0, 1);
const DISTANCE = 6.5;

export class Views {
  constructor(stage) {
    this.stage = stage;
    this.controls = new THREE.OrbitControls(stage.camera, stage.canvas);
    this.controls.enableDamping = false;
    this.controls.enablePan = false;
    this.controls.minDistance = 1.6;
    this.controls.maxDistance = 40;
    this.controls.addEventListener("change", () => stage.touch());
    this.toward = new THREE.Vector3();
    this.current = null;
    stage.camera.up.copy(NORTH);
    this.choose("inertial");
  }

  names() {
    const found = ["inertial"];
    if (this.stage.observer) found.push("observer");
    if (this.stage.sun) found.push("sun");
    found.push("body");
    return found;
  }

  choose(name) {
    if (!this.names().includes(name)) return;
    this.current = name;
    this.stage.touch();
    const { camera } = this.stage;
    if (name === "observer" || name === "sun") camera.position.set(DISTANCE, 0, 0);
    else camera.position.set(0.62, -0.66, 0.42).multiplyScalar(DISTANCE);
    if (name === "inertial" && this.stage.sun) this.stand();
    this.controls.update();
  }

  // In inertial space the camera begins aside of the Sun, so that the body is seen half lit.
  stand() {
    const sun = this.stage.sun.at(0, this.toward);
    const aside = new THREE.Vector3().crossVectors(NORTH, sun);
    if (aside.lengthSq() < 1e-6) return;
    const { position } = this.stage.camera;
    position.copy(sun).addScaledVector(aside.normalize(), 0.9).addScaledVector(NORTH, 0.35);
    position.setLength(DISTANCE);
  }

  // Turn the world so that the observer or the Sun stands at +x with north up, or the body rests.
  update(time) {
    const { world, pose } = this.stage;
    this.controls.update();
    if (this.current === "inertial") world.quaternion.identity();
    else if (this.current === "body") world.quaternion.copy(pose).invert();
    else this.face(this.stage[this.current].at(time, this.toward));
  }

  face(direction) {
    const { world } = this.stage;
    const longitude = Math.atan2(direction.y, direction.x);
    const latitude = Math.asin(Math.min(Math.max(direction.z, -1), 1));
    const turn = new THREE.Quaternion().setFromAxisAngle(NORTH, -longitude);
    const tilt = new THREE.Quaternion().setFromAxisAngle(new THREE.Vector3(0, 1, 0), latitude);
    world.quaternion.copy(tilt.multiply(turn));
  }
}
