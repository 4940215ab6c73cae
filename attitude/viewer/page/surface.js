// The mesh of the body, and a coarser one of the same surface.
import { uint16, uint32 } from "./bytes.js";

export function geometryOf(data) {
  const rounded = uint16(data.vertices);
  const vertices = new Float32Array(rounded.length);
  for (let k = 0; k < rounded.length; k++) {
    vertices[k] = data.low[k % 3] + (data.width[k % 3] * rounded[k]) / 65535;
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(vertices, 3));
  geometry.setIndex(new THREE.BufferAttribute(uint32(data.facets), 1));
  geometry.computeVertexNormals(); // of flat facets for the bias of shadows only
  return geometry;
}

export function bodyMesh(data) {
  const material = new THREE.MeshLambertMaterial({
    color: 0xb9b3a8,
    flatShading: !data.smooth,
    ...(data.closed ? {} : { side: THREE.DoubleSide }),
  });
  const mesh = new THREE.Mesh(geometryOf(data), material);
  mesh.castShadow = !data.convex; // a convex surface casts no shadow on itself
  mesh.receiveShadow = !data.convex;
  return mesh;
}
