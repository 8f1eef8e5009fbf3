// The text over the scene: the name under the mouse, the numbers of the selection, the scale of colours.
// Text from files is set as text, never as markup.

/** An element with text. */
function element(tag, text = "", className = "") {
  const made = document.createElement(tag);
  made.textContent = text;
  if (className) made.className = className;
  return made;
}

class Panel {
  constructor(runs) {
    this.runs = runs;
    this.selected = null;
    this.tip = document.getElementById("tip");
    this.box = document.getElementById("panel");
    this.rows = [];
  }

  hover(thing, event) {
    this.tip.hidden = !thing;
    if (!thing || !event) return;
    this.tip.textContent = this.title(thing);
    this.tip.style.left = `${Math.min(event.clientX + 14, window.innerWidth - 180)}px`;
    this.tip.style.top = `${event.clientY + 14}px`;
  }

  title({ kind, name, run }) {
    const joint = kind === "joints" && this.runs[run].look.joints.find((each) => each.name === name);
    const what = { bodies: "body", markers: "marker", forces: "force" }[kind] ?? "";
    const label = this.runs.length > 1 ? `, ${this.runs[run].label}` : "";
    return `${name} (${joint ? joint.type.replaceAll("_", " ") : what}${label})`;
  }

  select(thing) {
    this.selected = thing;
    this.box.hidden = !thing;
    this.box.replaceChildren();
    this.rows = [];
    if (!thing) return;
    const head = element("h2", this.title(thing));
    const close = element("button", "×");
    close.setAttribute("aria-label", "close the numbers");
    close.onclick = () => this.select(null);
    head.append(close);
    this.box.append(head);
    const list = element("dl");
    for (const [label, read] of this.#numbers(thing)) {
      const value = element("dd");
      list.append(element("dt", label), value);
      this.rows.push({ value, read });
    }
    this.box.append(list);
  }

  /** The rows [label, (at, time) -> text] on a thing. */
  *#numbers({ kind, name, run: number }) {
    const run = this.runs[number];
    if (kind === "bodies") {
      const body = run.look.bodies.findIndex((each) => each.name === name);
      yield ["position", (at) => vectorText(run.placed(body, at), "m")];
    }
    const marker = kind === "markers" && run.look.markers.find((each) => each.name === name);
    if (marker) yield ["position", (at) => vectorText(markerAt(run, marker, at), "m")];
    const of = [[kind, name], ...(kind === "joints" ? ownedBy(run, "coordinates", name) : kind === "forces" ? ownedBy(run, "forces", name) : [])];
    for (const [owner, its] of of) {
      const columns = run.columnsOf(owner, its);
      for (let i = 0; i < columns.length; i += columns[i].component ? 3 : 1) {
        const { label, unit, group, column, component } = columns[i];
        const short = its === name ? label : `${its.slice(name.length + 1)}${label === "coordinate" ? "" : `, ${label}`}`;
        yield [short, (at) => component
          ? vectorText([0, 1, 2].map((k) => run.value(group, column + k, at)), unit)
          : quantity(run.value(group, column, at), unit)];
        if (run.swing) yield [`${short}, amplitude ∠ phase`, () => run.swing(column)];
      }
    }
    for (const other of this.runs.slice(1)) {
      const twin = marker && number === 0 && other.look.markers.find((each) => each.name === name);
      if (twin) yield [`from ${other.label}`, (at, time) => quantity(distance(markerAt(run, marker, at), markerAt(other, twin, other.rowAt(time))), "m")];
    }
  }

  update(time) {
    if (!this.selected) return;
    const at = this.runs[this.selected.run].rowAt(time);
    for (const { value, read } of this.rows) value.textContent = read(at, time);
  }
}

/** The [kind, name] of all series of a kind whose names are OWNER.coordinate. */
function* ownedBy(run, kind, owner) {
  const owned = run.groups.filter((group) => group.kind === kind).flatMap((group) => group.owners);
  for (const name of new Set(owned)) if (name.slice(0, name.lastIndexOf(".")) === owner) yield [kind, name];
}

/** The global position of a marker in m. */
function markerAt(run, marker, at) {
  const place = new THREE.Vector3();
  run.point(marker.body, marker.point, at, place, new THREE.Object3D());
  return place.toArray().map((x, i) => x + run.ground[i]);
}

function distance(a, b) {
  return Math.hypot(...a.map((x, i) => x - b[i]));
}

function vectorText(values, unit) {
  if (!values.every(Number.isFinite)) return "–";
  const size = Math.hypot(...values);
  const digits = Math.max(0, Math.min(9, 4 - Math.floor(Math.log10(size || 1))));
  const wide = size !== 0 && (size >= 1e6 || size < 1e-4);
  return `[${values.map((x) => (wide ? x.toExponential(2) : Number(x.toFixed(digits)) || 0)).join(", ")}] ${unit}`;
}
