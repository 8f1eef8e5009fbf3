// The solids of one run: a group for each body with the parts that it carries, and the parts on the ground.

const JOINT_COLOUR = "#363d47";
const GROUND_COLOUR = "#8a9099";
const SPRING_COLOUR = "#2f8f6b";
const COLOUR_OF = { joints: JOINT_COLOUR, ground: GROUND_COLOUR, springs: SPRING_COLOUR };
const GHOST_COLOUR = "#6f7f95";
/** Above this number of bodies, edges are not drawn and circles have fewer corners, because each body is small. */
const MOST_IN_DETAIL = 150;
const [MANY_CORNERS, FEW_CORNERS] = [32, 12];

class Figure {
  constructor(run, { ghost = false } = {}) {
    this.run = run;
    this.ghost = ghost;
    this.root = new THREE.Group();
    this.bodies = run.look.bodies.map((body) => this.#group(body.name));
    this.ground = this.#group("ground");
    this.ground.position.set(...run.ground).negate();
    this.meshes = [];
    const detailed = run.look.bodies.length <= MOST_IN_DETAIL;
    this.edges = detailed && !ghost;
    this.corners = detailed ? MANY_CORNERS : FEW_CORNERS;
    for (const piece of this.#pieces().values()) this.#add(piece);
  }

  #group(name) {
    const group = new THREE.Group();
    group.name = name;
    this.root.add(group);
    return group;
  }

  /** Groups the parts that move together and show one thing, by carrier, layer and item. */
  #pieces() {
    const pieces = new Map();
    for (const part of this.run.look.parts) {
      if (this.ghost && part.layer === "ground") continue;
      const key = `${part.carrier} ${part.layer} ${part.item}`;
      if (!pieces.has(key)) pieces.set(key, []);
      pieces.get(key).push(part);
    }
    return pieces;
  }

  #add(parts) {
    const [{ carrier, layer, item }] = parts;
    const { look } = this.run;
    const geometry = merged(parts.map((part) => geometryOf(part, this.run.meshes, this.corners)));
    const body = layer === "bodies" ? look.bodies[item] : null;
    const colour = this.ghost ? GHOST_COLOUR : body ? body.colour : COLOUR_OF[layer];
    const opacity = this.ghost ? 0.28 : body ? body.opacity : 1;
    const material = new THREE.MeshPhongMaterial({
      color: colour, shininess: 25, specular: "#333333", transparent: opacity < 1, opacity, depthWrite: opacity > 0.5,
      polygonOffset: true, polygonOffsetFactor: layer === "bodies" ? 1 : 0, polygonOffsetUnits: 1,
    });
    const mesh = new THREE.Mesh(geometry, material);
    mesh.userData = { layer, item, kind: { bodies: "bodies", springs: "forces" }[layer] ?? "joints", colour: new THREE.Color(colour), opacity };
    mesh.matrixAutoUpdate = false;
    const group = carrier < 0 ? this.ground : this.bodies[carrier];
    group.add(mesh);
    this.meshes.push(mesh);
    if (!this.edges) return;
    const line = new THREE.LineBasicMaterial({ color: "#11161d", transparent: true, opacity: 0.35 * opacity });
    const edges = new THREE.LineSegments(edgesOf(parts, this.run.meshes), line);
    edges.matrixAutoUpdate = false;
    mesh.add(edges);
  }

  /** Moves the bodies to where they are at a time. */
  move(at) {
    this.bodies.forEach((group, body) => this.run.place(group, body, at));
  }

  /** Shows or hides a layer. */
  show(layer, visible) {
    for (const mesh of this.meshes) if (mesh.userData.layer === layer) mesh.visible = visible;
  }
}
