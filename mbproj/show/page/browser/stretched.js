// Rods, springs and dampers, which extend between two points; and arrows of forces.

const TURNS = 9;
const Z = new THREE.Vector3(0, 0, 1);

/** A spring of length 1 along z, with straight ends. */
function coil(radius) {
  class Helix extends THREE.Curve {
    getPoint(t) {
      const wound = Math.min(Math.max((t - 0.08) / 0.84, 0), 1);
      const out = radius * Math.min(1, Math.min(t, 1 - t) / 0.08);
      const angle = 2 * Math.PI * TURNS * wound;
      return new THREE.Vector3(out * Math.cos(angle), out * Math.sin(angle), t - 0.5);
    }
  }
  return new THREE.TubeGeometry(new Helix(), 40 * TURNS, 0.16 * radius, 6);
}

/** A rod of length 1 along z from `low` to `high`. */
function rod(radius, low = -0.5, high = 0.5) {
  return new THREE.CylinderGeometry(radius, radius, high - low, 20).rotateX(Math.PI / 2).translate(0, 0, (low + high) / 2);
}

const SPANS = {
  rod: (radius) => [rod(radius)],
  spring: (radius) => [coil(radius)],
  damper: (radius) => [rod(0.25 * radius), rod(0.62 * radius, -0.3, 0.12)],
  strut: (radius) => [coil(radius), rod(0.2 * radius), rod(0.45 * radius, -0.3, 0.12)],
};

class Spans {
  constructor(run, ghost) {
    this.run = run;
    this.root = new THREE.Group();
    this.scratch = new THREE.Object3D();
    this.ends = [new THREE.Vector3(), new THREE.Vector3()];
    this.items = run.look.spans.map((span) => {
      const colour = ghost ? GHOST_COLOUR : span.kind === "rod" ? "#5d6875" : "#2f8f6b";
      const material = new THREE.MeshPhongMaterial({ color: colour, transparent: ghost, opacity: ghost ? 0.28 : 1 });
      const mesh = new THREE.Mesh(merged(SPANS[span.kind](span.radius)), material);
      mesh.userData = { layer: "springs", kind: span.kind === "rod" ? "joints" : "forces", name: span.name, colour: new THREE.Color(colour), opacity: ghost ? 0.28 : 1 };
      this.root.add(mesh);
      return { span, mesh };
    });
  }

  /** The normal of a rope's plane. */
  #normal(span, at) {
    const [tip, foot] = [new THREE.Vector3(), new THREE.Vector3()];
    this.run.point(span.frame, span.normal, at, tip, this.scratch);
    this.run.point(span.frame, [0, 0, 0], at, foot, this.scratch);
    return tip.sub(foot).normalize();
  }

  move(at) {
    for (const { span, mesh } of this.items) {
      this.ends.forEach((end, i) => this.run.point(span.carriers[i], span.points[i], at, end, this.scratch));
      if (span.normal) touch(span, this.ends, this.#normal(span, at));
      stretch(mesh, this.ends[0], this.ends[1]);
    }
  }
}

/** Moves the ends of a part of a rope from the centres of its circles to the points of contact, in the plane normal to n. */
function touch(span, [from, to], n) {
  const flat = to.clone().sub(from).projectOnPlane(n);
  const [first, second] = span.radii;
  const w = first - second;
  const square = Math.max(flat.lengthSq(), 1e-300);
  const across = n.clone().cross(flat);
  const e = flat.multiplyScalar(Math.sqrt(Math.max(square - w * w, 0)) / square).addScaledVector(across, w / square);
  const aside = n.clone().cross(e);
  from.addScaledVector(aside, -first);
  to.addScaledVector(aside, -second);
}

/** Places an object of length 1 along z between two points. */
function stretch(object, from, to) {
  const along = to.clone().sub(from);
  const length = along.length();
  object.position.addVectors(from, to).multiplyScalar(0.5);
  object.quaternion.setFromUnitVectors(Z, length > 0 ? along.divideScalar(length) : Z);
  object.scale.set(1, 1, Math.max(length, 1e-12));
}

/** Arrows at `places` for forces (one head) or torques (two), from series of this kind and name. Their length is relative
 * to the largest size in the run. */
class Arrows {
  constructor(run, places, { kind, name, colour, heads, length, radius }) {
    this.run = run;
    this.root = new THREE.Group();
    this.scratch = new THREE.Object3D();
    this.from = new THREE.Vector3();
    this.group = run.groups.findIndex((group) => group.kind === kind && group.name === name);
    this.length = length;
    this.radius = radius;
    this.items = [];
    if (this.group < 0) return;
    const { owners } = run.groups[this.group];
    this.largest = this.#largest(owners.length);
    owners.forEach((owner, number) => {
      const place = places.find((each) => each.name === owner);
      if (place) this.items.push({ number, place, object: this.#arrow(colour, heads, owner, kind) });
    });
  }

  /** The size that is drawn at full length: nearly the largest, so that one peak does not hide the others. */
  #largest(count) {
    const block = this.run.series[this.group];
    const sizes = [];
    for (let row = 0; row < block.rows; row += Math.ceil(block.rows / 200)) {
      for (let owner = 0; owner < count; owner++) {
        const size = Math.hypot(...[0, 1, 2].map((i) => block.at(row, 3 * owner + i)));
        if (Number.isFinite(size)) sizes.push(size);
      }
    }
    sizes.sort((a, b) => a - b);
    return sizes[Math.floor(0.97 * (sizes.length - 1))] || 1;
  }

  #arrow(colour, heads, name, kind) {
    const material = new THREE.MeshPhongMaterial({ color: colour });
    const object = new THREE.Group();
    const shaft = new THREE.Mesh(rod(this.radius, 0, 1), material);
    object.add(shaft);
    for (let head = 0; head < heads; head++) {
      const cone = new THREE.ConeGeometry(2.6 * this.radius, 6 * this.radius, 16).rotateX(Math.PI / 2);
      const mesh = new THREE.Mesh(cone, material);
      mesh.userData = { head };
      object.add(mesh);
    }
    object.children.forEach((mesh) => Object.assign(mesh.userData, { kind, name }));
    this.root.add(object);
    return object;
  }

  move(at) {
    if (!this.root.visible) return;
    for (const { number, place, object } of this.items) {
      const force = new THREE.Vector3(...[0, 1, 2].map((i) => this.run.value(this.group, 3 * number + i, at)));
      const length = Math.min(1.6, force.length() / this.largest) * this.length;
      object.visible = length > 3 * this.radius;
      if (!object.visible) continue;
      this.run.point(place.body, place.point, at, this.from, this.scratch);
      object.position.copy(this.from);
      object.quaternion.setFromUnitVectors(Z, force.normalize());
      const [shaft, ...cones] = object.children;
      shaft.scale.z = Math.max(length - 3 * this.radius, 1e-12);
      cones.forEach((cone) => cone.position.set(0, 0, length - (3 + 6 * cone.userData.head) * this.radius));
    }
  }
}
