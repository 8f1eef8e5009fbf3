// Buttons, menus and keys.

const VIEWS = [
  ["Front (from -y)", [0, -1, 0], [0, 0, 1]],
  ["Back (from +y)", [0, 1, 0], [0, 0, 1]],
  ["Left (from -x)", [-1, 0, 0], [0, 0, 1]],
  ["Right (from +x)", [1, 0, 0], [0, 0, 1]],
  ["Top (from +z)", [0, 0, 1], [0, 1, 0]],
  ["Bottom (from -z)", [0, 0, -1], [0, 1, 0]],
];
const MODES = [
  ["bodies", "Bodies"],
  ["violation", "Violation of joints"],
  ["trust", "Trust"],
];
const LAYERS = [
  ["bodies", "Bodies"],
  ["joints", "Joints"],
  ["ground", "Ground"],
  ["springs", "Springs and rods"],
  ["given", "Given forces and torques"],
  ["markers", "Markers"],
  ["paths", "Paths"],
  ["forces", "Reaction forces"],
  ["torques", "Reaction torques"],
  ["ghosts", "Ghosts"],
];

/** Connects buttons, menus and keys with their actions. */
function connect(page) {
  const { player, eye, runs } = page;
  by("title").textContent = page.data.title;
  by("play").onclick = () => player.toggle();
  by("back").onclick = () => player.step(-1);
  by("next").onclick = () => player.step(1);
  by("loop").onclick = () => (player.loop = !player.loop);
  by("fit").onclick = () => eye.fit();
  by("flat").onclick = () => (eye.flat = !eye.flat);
  fill(by("speed"), SPEEDS.map((speed) => [speed, `${speed}×`]), (value) => (player.speed = Number(value)));
  const views = [["", "View"], ["usual", "As at first"], ...VIEWS.map(([name], number) => [number, name])];
  fill(by("looks"), views, (value) => {
    if (value === "usual") eye.reset();
    else if (value !== "") eye.look(...VIEWS[value].slice(1));
    by("looks").value = "";
  });
  const modes = MODES.filter(([mode]) => usable(mode, runs[0]));
  fill(by("colour"), modes.map(([mode, name]) => [mode, `Colour: ${name}`]), (value) => (page.mode = value));
  const bodies = runs[0].look.bodies.map((body, number) => [number, `Follow ${body.name}`]);
  fill(by("follow"), [["", "Follow nothing"], ...bodies], (value) => {
    page.follow = value === "" ? null : Number(value);
    if (page.follow === null) eye.fit();
    else eye.fitted = false;
  });
  layers(page);
  charts(page);
  remarks(page);
  document.addEventListener("keydown", (event) => key(page, event));
  by("keys").onclick = () => by("help").showModal();
  by("close").onclick = () => by("help").close();
}

function usable(mode, run) {
  if (mode === "violation") return run.groups.some((group) => group.kind === "joints" && group.name === "violation");
  return mode !== "trust" || run.trust !== null;
}

/** Fills a menu with [value, text], and tells when one is chosen. */
function fill(select, options, choose) {
  select.replaceChildren(...options.map(([value, text]) => Object.assign(element("option", text), { value })));
  select.onchange = () => {
    choose(select.value);
    select.blur(); // so that keys go to the scene again
  };
}

function layers(page) {
  const shown = { forces: false, torques: false };
  for (const [layer, name] of LAYERS) {
    if (!present(page, layer)) continue;
    const label = element("label");
    const box = Object.assign(document.createElement("input"), { type: "checkbox", checked: shown[layer] ?? true });
    box.onchange = () => toggle(page, layer, box.checked);
    label.append(box, document.createTextNode(` ${name}`));
    by("layers").append(label);
  }
}

function present(page, layer) {
  const [first] = page.shown;
  const count = {
    ghosts: page.shown.length - 1, springs: first.spans.items.length || undefined, given: first.given.reduce((sum, arrows) => sum + (arrows ? arrows.items.length : 0), 0), markers: first.trails.items.length, paths: first.run.frames > 1 ? first.trails.items.length + first.trails.contacts.length : 0,
    forces: first.forces ? first.forces.items.length : 0, torques: first.torques ? first.torques.items.length : 0,
  };
  return count[layer] ?? first.figure.meshes.some((mesh) => mesh.userData.layer === layer);
}

function toggle(page, layer, visible) {
  for (const each of page.shown) {
    if (layer === "ghosts") page.ghosts = visible;
    else if (layer === "given") each.given.forEach((arrows) => arrows && (arrows.root.visible = visible));
    else if (layer === "markers") each.trails.items.forEach(({ mesh }) => (mesh.visible = visible));
    else if (layer === "paths") each.trails.paths.visible = visible;
    else if (layer === "forces" || layer === "torques") each[layer] && (each[layer].root.visible = visible);
    else each.figure.show(layer, visible);
    if (layer === "springs") each.spans.root.visible = visible;
  }
  page.change();
}

function charts(page) {
  const names = [...page.chart.choices.keys()];
  const kinds = { "": "Whole run", coordinates: "Joint coordinates", joints: "Joints", forces: "Forces", motions: "Motions", markers: "Markers", bodies: "Bodies", pairs: "Distances" };
  const groups = Object.entries(kinds).map(([kind, label]) => {
    const own = names.filter((name) => page.chart.choices.get(name).kind === kind);
    const group = Object.assign(document.createElement("optgroup"), { label });
    group.append(...own.map((name) => Object.assign(element("option", name), { value: name })));
    return own.length ? group : null;
  });
  const none = Object.assign(element("option", "No chart"), { value: "" });
  by("series").replaceChildren(none, ...groups.filter(Boolean));
  by("series").onchange = () => choose(by("series").value);
  const choose = (name) => {
    page.chart.choose(name);
    by("chart").hidden = !page.chart.chosen;
    by("series").value = name;
    by("series").blur();
    page.change();
  };
  const usual = ["coordinates", "markers", "bodies", ""]; // the series that tell most about a motion first
  const first = usual.map((kind) => names.find((name) => page.chart.choices.get(name).kind === kind)).find(Boolean) ?? "";
  choose(page.player.end > page.player.start ? first : "");
  if (page.player.end <= page.player.start) document.body.classList.add("still");
}

/** Shows notes for the reader: the status of the run, frames left out, trust. */
function remarks(page) {
  for (const run of page.runs) {
    const label = page.runs.filter((each) => !each.ghost).length > 1 ? `${run.label}: ` : "";
    for (const remark of run.remarks) by("remarks").append(element("p", `${label}${remark}`));
  }
}

const KEYS = {
  " ": (page) => page.player.toggle(),
  k: (page) => page.player.toggle(),
  ArrowLeft: (page, event) => page.player.step(event.shiftKey ? -10 : -1),
  ArrowRight: (page, event) => page.player.step(event.shiftKey ? 10 : 1),
  Home: (page) => page.player.set(page.player.start),
  End: (page) => page.player.set(page.player.end),
  "+": (page) => page.player.faster(1),
  "-": (page) => page.player.faster(-1),
  l: (page) => (page.player.loop = !page.player.loop),
  f: (page) => page.eye.fit(),
  o: (page) => (page.eye.flat = !page.eye.flat),
  0: (page) => page.eye.reset(),
  "[": (page) => jump(page, -1),
  "]": (page) => jump(page, 1),
  c: (page) => {
    const usable = [...by("colour").options].map((option) => option.value);
    page.mode = usable[(usable.indexOf(page.mode) + 1) % usable.length];
  },
  n: (page) => page.turnMode && page.turnMode(1),
  p: (page) => page.turnMode && page.turnMode(-1),
  Escape: (page) => page.select(null),
  "?": () => by("help").showModal(),
};
VIEWS.forEach(([, eye, up], number) => (KEYS[number + 1] = (page) => page.eye.look(eye, up)));

/** Goes to the event before or after the time. */
function jump(page, turn) {
  const times = page.runs.flatMap((run) => run.events.map((event) => event.time)).sort((a, b) => a - b);
  const ahead = turn > 0 ? times.find((time) => time > page.player.time + 1e-12) : times.filter((time) => time < page.player.time - 1e-12).pop();
  page.player.playing = false;
  if (ahead !== undefined) page.player.set(ahead);
}

function key(page, event) {
  if (event.ctrlKey || event.metaKey || event.altKey || /^(SELECT|DIALOG)$/.test(event.target.tagName)) return;
  if (event.target.tagName === "BUTTON" && event.key === " ") return;
  if (event.target.type === "range" && event.key.startsWith("Arrow") === false && event.key === " ") event.target.blur();
  const act = KEYS[event.key];
  if (!act) return;
  event.preventDefault();
  act(page, event);
}

/** Updates the controls whose state can change without a click on them. */
function update(page) {
  const { player, eye } = page;
  const mark = (id, pressed) => by(id).setAttribute("aria-pressed", String(pressed));
  by("play").textContent = player.playing ? "❚❚" : "▶";
  by("play").setAttribute("aria-label", player.playing ? "pause" : "play");
  mark("loop", player.loop);
  mark("flat", eye.flat);
  by("speed").value = String(player.speed);
  by("colour").value = page.mode;
  by("scale").hidden = page.mode !== "violation";
  const { trust } = page.runs[0];
  const late = trust && trust.since !== null && player.time >= trust.since;
  by("warning").hidden = !late;
  if (late) by("warning").textContent = trust.text;
}
