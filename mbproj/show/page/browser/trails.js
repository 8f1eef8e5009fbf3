// Markers: a ball at each, its path so far, and faintly its path to come. For rolling bodies, the path of the contact.

class Trails {
  constructor(run, radius, ghost) {
    this.run = run;
    this.root = new THREE.Group();
    this.paths = new THREE.Group();
    this.root.add(this.paths);
    this.scratch = new THREE.Object3D();
    this.at = new THREE.Vector3();
    const ball = new THREE.SphereGeometry(radius, 20, 14);
    this.items = run.look.markers.map((marker, number) => {
      const colour = ghost ? GHOST_COLOUR : MARKER_COLOURS[number % MARKER_COLOURS.length];
      const mesh = new THREE.Mesh(ball, new THREE.MeshPhongMaterial({ color: colour }));
      mesh.userData = { kind: "markers", name: marker.name };
      this.root.add(mesh);
      return { marker, mesh, ...this.#path(colour) };
    });
    this.contacts = run.contacts.map((places) => ({ places, ...this.#path(ghost ? GHOST_COLOUR : CONTACT_COLOUR) }));
    this.trace();
  }

  /** The lines of a path, whose points `trace` sets. */
  #path(colour) {
    const points = new THREE.BufferAttribute(new Float32Array(3 * this.run.frames), 3);
    const [whole, line] = [0.22, 1].map((opacity) => {
      const geometry = new THREE.BufferGeometry().setAttribute("position", points);
      const drawn = new THREE.Line(geometry, new THREE.LineBasicMaterial({ color: colour, transparent: opacity < 1, opacity }));
      drawn.frustumCulled = false;
      return drawn;
    });
    this.paths.add(whole, line);
    return { points, line };
  }

  /** Finds the paths of the markers. */
  trace() {
    for (const { marker, points } of this.items) {
      for (let row = 0; row < this.run.frames; row++) {
        this.run.point(marker.body, marker.point, { row, part: 0 }, this.at, this.scratch);
        this.at.toArray(points.array, 3 * row);
      }
      points.needsUpdate = true;
    }
    for (const { places, points } of this.contacts) {
      for (let row = 0; row < this.run.frames; row++) {
        const place = [0, 1, 2].map((i) => places.at(row, i));
        this.run.point(-1, place, { row, part: 0 }, this.at, this.scratch).toArray(points.array, 3 * row);
      }
      points.needsUpdate = true;
    }
  }

  move(at) {
    for (const { marker, mesh, line } of this.items) {
      this.run.point(marker.body, marker.point, at, mesh.position, this.scratch);
      line.geometry.setDrawRange(0, at.row + 1);
    }
    for (const { line } of this.contacts) line.geometry.setDrawRange(0, at.row + 1);
  }
}

const CONTACT_COLOUR = "#333333";
const MARKER_COLOURS = ["#d55e00", "#7b3294", "#006d5b", "#b8860b", "#1f4e9c"];
