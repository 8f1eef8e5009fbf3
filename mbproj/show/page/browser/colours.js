// Colours: each body has its own, or they show how far joints are open, or whether the run can be trusted.

const PALE = new THREE.Color("#eceef1");
/** From closed to open: stops of a scale that colour-blind readers can follow too. */
const SCALE = ["#2c4a8a", "#2b8a8a", "#8fbf4d", "#f2c53d", "#e0642f", "#a3123a"].map((colour) => new THREE.Color(colour));
/** The powers of ten at the ends of the scale. */
const CLOSED = -16;
const OPEN = -6;

/** The colour of a violation. */
function violationColour(violation, into) {
  const power = Math.log10(Math.max(violation, 1e-300));
  const place = Math.min(Math.max((power - CLOSED) / (OPEN - CLOSED), 0), 1) * (SCALE.length - 1);
  const low = Math.min(Math.floor(place), SCALE.length - 2);
  return into.copy(SCALE[low]).lerp(SCALE[low + 1], place - low);
}

class Colours {
  constructor(run, figure, spans) {
    this.run = run;
    this.meshes = [...figure.meshes, ...spans.items.map((item) => item.mesh)];
    this.group = run.groups.findIndex((group) => group.kind === "joints" && group.name === "violation");
    const owners = this.group < 0 ? [] : run.groups[this.group].owners;
    this.columns = run.look.joints.map((joint) => owners.indexOf(joint.name));
    this.of = run.look.bodies.map(() => []); // the joints of each body
    run.look.joints.forEach((joint, number) =>
      joint.bodies.forEach((body) => body >= 0 && this.of[body].push(number)),
    );
    this.colour = new THREE.Color();
  }

  /** Colours everything for a time in one of the modes "bodies", "violation", "trust". */
  paint(mode, at, time) {
    const { trust } = this.run;
    const pale = mode !== "violation" && trust && trust.since !== null && time >= trust.since;
    for (const mesh of this.meshes) {
      const { colour, opacity } = mesh.userData;
      const { color } = mesh.material;
      if (mode === "violation") this.#violated(mesh, at, color);
      else if (mode === "trust" && trust) color.set(pale ? "#c8704a" : "#2c7a6b");
      else color.copy(colour);
      if (pale) color.lerp(PALE, 0.68);
      mesh.material.opacity = opacity;
    }
  }

  #violated(mesh, at, color) {
    const { layer, item } = mesh.userData;
    const joints = layer === "bodies" ? this.of[item] : layer === "joints" ? [item] : [];
    const violations = joints.map((joint) => this.columns[joint]).filter((column) => column >= 0)
      .map((column) => this.run.value(this.group, column, at)).filter(Number.isFinite);
    if (violations.length) violationColour(Math.max(...violations), color);
    else color.set("#9aa1ab");
  }
}
