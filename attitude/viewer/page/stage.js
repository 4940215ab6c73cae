// The picture: body, arrows, light and shadows in ICRF, drawn at one time.
import { arrowsOf } from "./arrows.js";
import { Labels } from "./labels.js";
import { Poinsot } from "./poinsot.js";
import { Directions, Poses } from "./poses.js";
import { Shade } from "./shade.js";
import { bodyMesh, geometryOf } from "./surface.js";

const SHADOWS = 2048; // texels a side
const SUNLIGHT = 3; // intensity of the light
// Names of drivers that compute the picture on the processor: four samples a pixel double its time.
const BY_PROCESSOR = /swiftshader|llvmpipe|softpipe|software|basic render/i;

function drawsByProcessor() {
  const gl = document.createElement("canvas").getContext("webgl2");
  const names = gl && gl.getExtension("WEBGL_debug_renderer_info");
  const name = names ? gl.getParameter(names.UNMASKED_RENDERER_WEBGL) : "";
  if (gl) gl.getExtension("WEBGL_lose_context")?.loseContext();
  return BY_PROCESSOR.test(name);
}

export class Stage {
  constructor(canvas, labels, data) {
    this.canvas = canvas;
    const byProcessor = drawsByProcessor();
    this.renderer = new THREE.WebGLRenderer({
      canvas, antialias: !byProcessor, preserveDrawingBuffer: true,
    });
    // Pixels of the picture for one of the page, and what else `reduce` takes.
    const ratio = byProcessor ? 2 : Math.min(window.devicePixelRatio, 2);
    this.full = { ratio, shadows: SHADOWS, coarse: false };
    this.renderer.setPixelRatio(ratio);
    this.renderer.shadowMap.enabled = !data.surface.convex;
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    this.renderer.shadowMap.autoUpdate = false; // see `renewShadows`
    this.cast = []; // what the shadows were drawn for
    this.changed = true; // since the last picture
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color(0x10131a);
    this.camera = new THREE.PerspectiveCamera(32, 1, 0.05, 60);
    this.labels = new Labels(labels);
    this.world = new THREE.Group(); // ICRF, turned for the point of view
    this.body = new THREE.Group(); // body axes
    this.world.add(this.body);
    this.scene.add(this.world);

    this.poses = new Poses(data.poses);
    this.sun = data.sun ? new Directions(data.sun, data.duration) : null;
    this.shade = data.shade ? new Shade(data.shade) : null;
    this.observer = data.observer ? new Directions(data.observer, data.duration) : null;
    this.mesh = bodyMesh(data.surface);
    this.fine = this.mesh.geometry;
    this.coarse = data.surface.coarse ? geometryOf(data.surface.coarse) : null;
    this.body.add(this.mesh);
    this.arrows = arrowsOf(data, this.labels);
    for (const [name, group] of Object.entries(this.arrows)) {
      for (const arrow of group) (name === "axes" ? this.body : this.world).add(arrow.object);
    }
    this.addPoinsot(data);
    this.addLight(data);
    this.pose = new THREE.Quaternion();
    this.rate = new THREE.Vector3();
    this.direction = new THREE.Vector3();
  }

  addPoinsot(data) {
    this.poinsot = null;
    if (!data.poinsot) return;
    // The body itself is this ellipsoid, or stands inside it.
    const isBody = data.surface.kind === "ellipsoid of inertia";
    this.poinsot = new Poinsot(data.poinsot, isBody ? 1.002 : 1.25);
    this.body.add(this.poinsot.inBody);
    this.world.add(this.poinsot.inSpace);
  }

  addLight(data) {
    this.light = new THREE.DirectionalLight(0xffffff, SUNLIGHT);
    this.light.castShadow = true;
    this.light.shadow.mapSize.set(SHADOWS, SHADOWS);
    Object.assign(this.light.shadow.camera, {
      left: -1.1, right: 1.1, top: 1.1, bottom: -1.1, near: 1, far: 5,
    });
    // Of a closed body the sides away from the Sun are in the map, and lit ones need no bias.
    const { closed, smooth } = data.surface;
    this.light.shadow.normalBias = closed ? 0 : 0.02;
    // Towards the shadow, or light gets into the creases of a round body; flat ones have thin panels.
    this.light.shadow.bias = closed && smooth ? 0.002 : -0.0005;
    this.world.add(this.light, this.light.target);
    this.scene.add(new THREE.AmbientLight(0xffffff, 0.18));
  }

  // The next frame draws the picture; other frames leave it as it is.
  touch() {
    this.changed = true;
  }

  resize() {
    this.touch();
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.aspect = clientWidth / Math.max(clientHeight, 1);
    this.camera.zoom = Math.min(1, this.camera.aspect); // arrows to the side are in it too
    this.camera.updateProjectionMatrix();
  }

  // Draw fewer pixels, coarser shadows or the coarser mesh, or the whole again.
  reduce({ ratio, shadows, coarse }) {
    this.touch();
    this.renderer.setPixelRatio(ratio);
    this.mesh.geometry = coarse && this.coarse ? this.coarse : this.fine;
    const { shadow } = this.light;
    if (shadow.mapSize.x !== shadows) {
      shadow.mapSize.set(shadows, shadows);
      if (shadow.map) shadow.map.dispose();
      shadow.map = null;
    }
    this.cast = [];
  }

  // Place everything as it is at a time; without a Sun the light comes from the camera's side.
  place(time) {
    this.poses.pose(time, this.pose);
    this.body.quaternion.copy(this.pose);
    this.poses.rate(time, this.rate).applyQuaternion(this.pose);
    if (this.arrows.rate && this.rate.lengthSq() > 0) {
      this.arrows.rate[0].point(this.direction.copy(this.rate).normalize());
    }
    if (this.poinsot) this.poinsot.update(this.rate);
    if (this.sun) {
      this.sun.at(time, this.direction);
      this.arrows.sun[0].point(this.direction);
      this.light.position.copy(this.direction).multiplyScalar(3);
    }
    if (this.shade) this.light.intensity = SUNLIGHT * this.shade.at(time);
    if (this.observer) this.arrows.observer[0].point(this.observer.at(time, this.direction));
  }

  draw() {
    this.scene.updateMatrixWorld();
    if (!this.sun) {
      this.direction.set(0.5, 0.6, 1).transformDirection(this.camera.matrixWorld);
      this.world.worldToLocal(this.light.position.copy(this.direction).multiplyScalar(3));
    }
    this.renewShadows();
    this.renderer.render(this.scene, this.camera);
    this.changed = false;
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    this.labels.update(this.camera, clientWidth, clientHeight);
  }

  // The map of shadows is drawn where body, light or switches changed, not where the camera moved.
  renewShadows() {
    const { body, light, mesh } = this;
    light.updateMatrixWorld();
    const key = [
      ...body.matrixWorld.elements,
      ...light.matrixWorld.elements,
      mesh.visible,
      light.castShadow,
    ];
    if (key.every((each, k) => each === this.cast[k])) return;
    this.cast = key;
    this.renderer.shadowMap.needsUpdate = true;
  }
}
