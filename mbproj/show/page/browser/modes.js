// Modes: the chosen one moves the bodies about their pose while its phase goes through one cycle.

const ROUND = 72; // frames of a cycle
const DEGREE = Math.PI / 180;
const AT_POSE = { row: 0, part: 0 };

/** A run whose time is the phase of a mode in degrees. */
class Shapes extends Run {
  constructor(data, bytes, origin) {
    super(data, bytes, origin);
    this.modes = data.modes;
    this.shape = new Block(bytes, data.blocks[data.modes.shape]);
    this.along = new Block(bytes, data.blocks[data.modes.along]);
    Object.assign(this, { frames: ROUND + 1, start: 0, end: 360, unit: "°", rate: 180, mode: 0, amplitude: data.modes.amplitude });
    this.turn = new THREE.Vector3();
    const { coordinates, units } = data.modes;
    if (!coordinates.length) return;
    this.groups.push({ name: "coordinate", kind: "coordinates", owners: coordinates, components: [""], units, logarithmic: false });
    this.series.push({ rows: this.frames, at: (row, column) => this.#part(this.along, column, this.time(row)) });
  }

  time(row) {
    return (360 * row) / ROUND;
  }

  /** Re(shape · exp(iφ)) of the mode that is chosen. */
  #part(block, column, phase) {
    const half = block.columns / 2;
    const [real, imaginary] = [block.at(this.mode, column), block.at(this.mode, half + column)];
    return this.amplitude * (real * Math.cos(phase * DEGREE) - imaginary * Math.sin(phase * DEGREE));
  }

  place(object, body, { row, part }) {
    super.place(object, body, AT_POSE);
    const phase = this.time(row + part);
    const part6 = (i) => this.#part(this.shape, 6 * body + i, phase);
    object.position.x += this.modes.size * part6(0);
    object.position.y += this.modes.size * part6(1);
    object.position.z += this.modes.size * part6(2);
    const angle = this.turn.set(part6(3), part6(4), part6(5)).length();
    if (angle > 0) object.quaternion.premultiply(this.other.setFromAxisAngle(this.turn.divideScalar(angle), angle));
  }

  /** Amplitude and phase of a coordinate: it swings as amplitude · cos(time + phase). */
  swing(column) {
    const [real, imaginary] = [this.along.at(this.mode, column), this.along.at(this.mode, this.along.columns / 2 + column)];
    const size = this.amplitude * Math.hypot(real, imaginary);
    return `${quantity(size, this.modes.units[column])} ∠ ${Math.round(Math.atan2(imaginary, real) / DEGREE) + 0}°`;
  }

  /** The largest turn and shift of a body in this mode, for a reader. */
  largest() {
    const sizes = [0, 0];
    const half = this.shape.columns / 2;
    for (let column = 0; column < half; column += 3) {
      const all = [0, 1, 2, half, half + 1, half + 2].map((i) => this.shape.at(this.mode, column + i));
      const kind = (column / 3) % 2;
      sizes[kind] = Math.max(sizes[kind], this.amplitude * Math.hypot(...all));
    }
    return `bodies shift by up to ${lengthText(sizes[0] * this.modes.size)} and turn by up to ${Number((sizes[1] / DEGREE).toPrecision(2))}°`;
  }
}

/** The menu of the modes and the slider of their amplitude. */
function connectModes(page) {
  const [run] = page.runs;
  if (!run.modes) return;
  const { list } = run.modes;
  by("mode").hidden = by("swing").hidden = by("shape").hidden = false;
  const change = () => {
    by("mode").value = String(run.mode);
    by("shape").textContent = `Mode ${run.mode + 1} of ${list.length}: ${list[run.mode].words}. ${list[run.mode].name}. Here ${run.largest()}.`;
    for (const each of page.shown) each.trails.trace();
    page.chart.resize();
    page.change();
  };
  const choose = (mode) => {
    run.mode = (mode + list.length) % list.length;
    change();
  };
  page.turnMode = (turn) => choose(run.mode + turn);
  fill(by("mode"), list.map(({ words }, mode) => [mode, `${mode + 1}: ${words.split(/[,:]/)[0]}`]), (value) => choose(Number(value)));
  by("amplitude").value = String(run.amplitude);
  by("amplitude").oninput = () => {
    run.amplitude = Number(by("amplitude").value);
    change();
  };
  page.player.playing = !window.matchMedia("(prefers-reduced-motion: reduce)").matches;
  change();
}
