// The page: reads its data, builds the scene, and draws it whenever something has changed.

const by = (id) => document.getElementById(id);

class Page {
  constructor(data, bytes) {
    this.data = data;
    const origin = data.view.middle;
    this.runs = data.runs.map((run) => Object.assign(new (run.modes ? Shapes : Run)(run, bytes, origin), { ground: origin }));
    if (!this.runs[0].modes) addDistances(this.runs);
    this.player = new Player(this.runs);
    this.eye = new Eye(data.view);
    this.renderer = new THREE.WebGLRenderer({ canvas: by("scene"), antialias: true, preserveDrawingBuffer: true });
    this.stage = this.#stage();
    this.ghosts = true;
    this.shown = this.runs.map((run, number) => this.#show(run, number > 0));
    this.timeline = new Timeline(this.player, this.runs);
    this.chart = new Chart(by("chart"), this.runs, this.player);
    this.corner = new Corner(by("corner"), this.eye, data.runs[0].look.gravity);
    this.panel = new Panel(this.runs);
    this.mode = "bodies";
    this.follow = null;
    this.changes = 0;
    this.rays = new THREE.Raycaster();
    this.pointer = new Pointer(by("scene"), this.eye, {
      pick: (x, y) => this.pick(x, y),
      hover: (thing, event) => this.panel.hover(thing, event),
      select: (thing) => this.select(thing),
    });
    connect(this);
    connectModes(this);
    new ResizeObserver(() => this.resize()).observe(by("view"));
    this.resize();
  }

  #stage() {
    const stage = new THREE.Scene();
    stage.background = new THREE.Color("#f7f8fa");
    stage.add(new THREE.HemisphereLight("#ffffff", "#b9c0ca", 0.78));
    this.sun = new THREE.DirectionalLight("#ffffff", 0.42);
    stage.add(this.sun, this.sun.target);
    return stage;
  }

  #show(run, ghost) {
    const { thickness } = run.look;
    const figure = new Figure(run, { ghost });
    const spans = new Spans(run, ghost);
    const trails = new Trails(run, 1.15 * thickness, ghost);
    const length = 0.3 * this.data.view.radius;
    const arrow = Math.min(0.5 * thickness, 0.02 * length);
    const joints = run.look.joints.map(({ name, bodies, point }) => ({ name, body: bodies[1], point }));
    const arrows = (places, kind, name, colour, heads) => (ghost ? null : new Arrows(run, places, { kind, name, colour, heads, length, radius: arrow }));
    const forces = arrows(joints, "joints", "reaction force", "#a3123a", 1);
    const torques = arrows(joints, "joints", "reaction torque", "#5b3aa8", 2);
    const given = [arrows(run.look.loads, "forces", "given force", "#b8860b", 1), arrows(run.look.loads, "forces", "given torque", "#7a6a00", 2)];
    const movers = [figure, spans, trails, forces, torques, ...given].filter(Boolean);
    const root = new THREE.Group().add(...movers.map((mover) => mover.root));
    this.stage.add(root);
    for (const reaction of [forces, torques]) if (reaction) reaction.root.visible = false;
    return { run, ghost, root, figure, spans, trails, forces, torques, given, movers, colours: ghost ? null : new Colours(run, figure, spans) };
  }

  /** Shows the numbers of a thing {kind, name, run}; null shows none. */
  select(thing) {
    this.panel.select(thing);
    this.change();
  }

  /** The thing {kind, name, run} at a place of the window; null where there is none. */
  pick(x, y) {
    const box = by("scene").getBoundingClientRect();
    const place = new THREE.Vector2((2 * (x - box.left)) / box.width - 1, 1 - (2 * (y - box.top)) / box.height);
    this.rays.setFromCamera(place, this.eye.camera);
    for (let run = 0; run < this.shown.length; run++) {
      const hits = this.rays.intersectObject(this.shown[run].root, true).filter((hit) => hit.object.isMesh && visible(hit.object));
      const markers = hits.find((hit) => hit.object.userData.kind === "markers");
      const hit = markers ?? hits[0];
      if (hit) return this.#thing(hit.object.userData, run);
    }
    return null;
  }

  #thing({ kind, name, item, layer }, run) {
    const { look } = this.runs[run];
    if (name) return { kind, name, run };
    return { kind, name: kind === "forces" ? look.forces[item] : look[kind][item].name, run };
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = by("view");
    if (!width || !height) return;
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    this.renderer.setSize(width, height, false);
    this.eye.pixels = height;
    this.eye.resize(width / height);
    this.chart.resize();
    this.change();
  }

  /** Moves everything to the time, and draws. */
  draw() {
    const { time } = this.player;
    for (const each of this.shown) {
      each.root.visible = !each.ghost || (this.ghosts && time >= (each.run.from ?? time));
      const at = each.run.rowAt(time);
      for (const mover of each.movers) mover.move(at);
      if (each.colours) each.colours.paint(this.mode, at, time);
    }
    if (this.follow !== null) this.eye.target.copy(this.shown[0].figure.bodies[this.follow].position);
    this.eye.update();
    this.sun.position.copy(this.eye.target).addScaledVector(this.eye.back, 1).addScaledVector(this.eye.up, 0.9).addScaledVector(this.eye.right, -0.6);
    this.sun.target.position.copy(this.eye.target);
    this.renderer.render(this.stage, this.eye.camera);
    this.corner.draw();
    this.chart.draw();
    this.timeline.update();
    this.panel.update(time);
    update(this);
  }

  /** All that the picture depends on. While it does not change, nothing is drawn again. */
  #state() {
    const { time, playing, loop, speed } = this.player;
    const { back, up, target, half, flat, aspect } = this.eye;
    const seen = [...back.toArray(), ...up.toArray(), ...target.toArray(), half, flat, aspect];
    return [time, playing, loop, speed, ...seen, this.mode, this.follow, this.changes].join(" ");
  }

  /** Notes that something else has changed: the parts shown, the selection, or the size. */
  change() {
    this.changes += 1;
  }

  run() {
    let [before, drawn] = [null, null];
    const turn = (now) => {
      if (before !== null) this.player.advance(Math.min((now - before) / 1000, 0.25));
      before = now;
      const state = this.#state();
      if (state !== drawn) {
        drawn = state;
        this.draw();
      }
      requestAnimationFrame(turn);
    };
    requestAnimationFrame(turn);
  }
}

function visible(object) {
  for (let each = object; each; each = each.parent) if (!each.visible) return false;
  return true;
}

/** Shows an error in place of the scene. */
function fail(message) {
  by("trouble").hidden = false;
  by("trouble").textContent = message;
}

async function open() {
  if (typeof DecompressionStream === "undefined") return fail("This page needs a browser of 2023 or later.");
  const data = JSON.parse(by("mechanism").textContent);
  let page;
  try {
    page = new Page(data, await bytesOf("motion"));
  } catch (error) {
    const no = /webgl/i.test(error.message);
    return fail(no ? "This browser shows no 3D graphics: WebGL is switched off or missing." : `The page is damaged: ${error.message}`);
  }
  window.mbproj = page; // for tests, and for whoever wants to drive the page from its console
  if (data.watched !== undefined) new Watch(page, data.watched);
  page.run();
  return page;
}

open();
