// The parts of a mechanism as geometries, merged into one for each thing that moves as one.

/** The geometry of a part in the axes of its carrier, with `corners` on a circle; r140's cylinders are along y, ours along z. */
function geometryOf(part, meshes, corners = 32) {
  const geometry = shapeOf(part, meshes, corners);
  const [w, x, y, z] = part.orientation;
  geometry.applyQuaternion(new THREE.Quaternion(x, y, z, w));
  return geometry.translate(...part.position);
}

function shapeOf({ kind, size, mesh }, meshes, corners) {
  if (kind === "box") return new THREE.BoxGeometry(...size);
  if (kind === "sphere") return new THREE.SphereGeometry(size[0], 0.75 * corners, 0.5 * corners);
  if (kind === "cylinder") return new THREE.CylinderGeometry(size[0], size[0], size[1], corners).rotateX(Math.PI / 2);
  if (kind === "tube") return tube(...size, corners);
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(Float32Array.from(meshes[mesh].vertices), 3));
  geometry.setIndex(Array.from(meshes[mesh].triangles));
  const facets = geometry.toNonIndexed(); // each triangle is flat
  facets.computeVertexNormals();
  return facets;
}

/** A hollow cylinder along z: its profile turned about y. */
function tube(outer, inner, length, corners) {
  const half = length / 2;
  const section = [[inner, -half], [outer, -half], [outer, half], [inner, half], [inner, -half]];
  const profile = section.map(([x, y]) => new THREE.Vector2(x, y));
  const turned = new THREE.LatheGeometry(profile, corners).toNonIndexed();
  turned.computeVertexNormals();
  return turned.rotateX(Math.PI / 2);
}

/** Merges several geometries into one without an index. */
function merged(geometries) {
  const flat = geometries.map((geometry) => (geometry.index ? geometry.toNonIndexed() : geometry));
  const whole = new THREE.BufferGeometry();
  for (const name of ["position", "normal"]) {
    const length = flat.reduce((sum, geometry) => sum + geometry.attributes[name].array.length, 0);
    const array = new Float32Array(length);
    let at = 0;
    for (const geometry of flat) {
      array.set(geometry.attributes[name].array, at);
      at += geometry.attributes[name].array.length;
    }
    whole.setAttribute(name, new THREE.BufferAttribute(array, 3));
  }
  geometries.concat(flat).forEach((geometry) => geometry.dispose());
  return whole;
}

/** The number of triangles of a mesh above which its edges are not searched. */
const MOST_EDGED = 20000;

/** The edges of parts as one set of lines: they make a shape plain without light. */
function edgesOf(parts, meshes) {
  const points = [];
  for (const part of parts) {
    if (part.kind === "sphere" || (part.kind === "mesh" && meshes[part.mesh].triangles.length > 3 * MOST_EDGED)) continue;
    const geometry = geometryOf(part, meshes);
    const edges = new THREE.EdgesGeometry(geometry, 35);
    points.push(edges.attributes.position.array);
    geometry.dispose();
  }
  const all = new Float32Array(points.reduce((sum, array) => sum + array.length, 0));
  let at = 0;
  for (const array of points) {
    all.set(array, at);
    at += array.length;
  }
  return new THREE.BufferGeometry().setAttribute("position", new THREE.BufferAttribute(all, 3));
}
