// One run: its look, the poses of its bodies at a time, its recorded series.

const ZERO_POWER = -18; // the power of ten that stands for zero on a logarithmic scale

class Run {
  constructor(data, bytes, origin) {
    const { label, look, groups, events, trust, remarks, ghost, from } = data;
    Object.assign(this, { label, look, groups, events, trust, remarks, ghost, from, unit: "s", rate: 1 });
    const block = (number) => new Block(bytes, data.blocks[number]);
    this.meshes = look.meshes.map(({ vertices, triangles }) => ({ vertices: block(vertices).rowsOf(), triangles: block(triangles).rowsOf() }));
    this.contacts = (data.contacts ?? []).map((contact) => block(contact.block)); // where what rolls touches
    this.times = block(data.time);
    this.position = block(data.position);
    this.orientation = block(data.orientation);
    this.frames = this.times.rows;
    this.start = this.times.at(0, 0);
    this.end = this.times.at(this.frames - 1, 0);
    this.series = data.groups.map((group) => block(group.block));
    this.shift = data.centre.map((x, i) => x - origin[i]); // of positions, to the page's origin
    this.other = new THREE.Quaternion();
    this.scratch = new THREE.Object3D();
  }

  time(row) {
    return this.times.at(row, 0);
  }

  /** The frame before a time, and the part (0 to 1) of the way to the next frame. */
  rowAt(time) {
    if (time <= this.start) return { row: 0, part: 0 };
    if (time >= this.end) return { row: this.frames - 1, part: 0 };
    let [low, high] = [0, this.frames - 1];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.time(middle) <= time) low = middle;
      else high = middle;
    }
    const span = this.time(low + 1) - this.time(low);
    return { row: low, part: span > 0 ? (time - this.time(low)) / span : 0 };
  }

  /** Writes the pose of a body into a three.js object. */
  place(object, body, { row, part }) {
    const next = part > 0 ? row + 1 : row;
    const mix = (block, column) => (1 - part) * block.at(row, column) + part * block.at(next, column);
    object.position.set(
      mix(this.position, 3 * body) + this.shift[0],
      mix(this.position, 3 * body + 1) + this.shift[1],
      mix(this.position, 3 * body + 2) + this.shift[2],
    );
    const turn = (at, into) => {
      const [w, x, y, z] = [0, 1, 2, 3].map((i) => this.orientation.at(at, 4 * body + i));
      return into.set(x, y, z, w);
    };
    turn(row, object.quaternion);
    if (part > 0) {
      turn(next, this.other);
      object.quaternion.slerp(this.other, part);
    }
    object.quaternion.normalize();
  }

  /** A point of a body (-1: the ground) in the page's axes, into `vector`. */
  point(body, local, at, vector, scratch) {
    vector.fromArray(local);
    if (body < 0) {
      return vector.set(vector.x - this.ground[0], vector.y - this.ground[1], vector.z - this.ground[2]);
    }
    this.place(scratch, body, at);
    return vector.applyQuaternion(scratch.quaternion).add(scratch.position);
  }

  /** The global position of a body's centre of mass in m. */
  placed(body, at) {
    this.place(this.scratch, body, at);
    return this.scratch.position.toArray().map((x, i) => x + this.ground[i]);
  }

  /** The value of a series between two frames; for a logarithmic series the value itself, not its logarithm. */
  value(group, column, { row, part }) {
    const block = this.series[group];
    const next = Math.min(row + 1, this.frames - 1);
    const here = block.at(row, column);
    const value = part > 0 ? (1 - part) * here + part * block.at(next, column) : here;
    if (!this.groups[group].logarithmic) return value;
    return value <= ZERO_POWER ? 0 : 10 ** value;
  }

  /** The columns of all series of the body, joint or marker with this name: {group, column, label, unit}. */
  columnsOf(kind, name) {
    const found = [];
    this.groups.forEach((group, number) => {
      const owner = group.owners.indexOf(name);
      if (group.kind === kind && owner >= 0) {
        const count = group.components.length;
        group.components.forEach((component, i) =>
          found.push({ group: number, column: owner * count + i, label: group.name, component, unit: group.units[owner] }),
        );
      }
    });
    return found;
  }
}
