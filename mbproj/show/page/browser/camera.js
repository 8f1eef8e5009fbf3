// The eye: it turns about a target, with perspective or without, and keeps the mechanism in the picture.

const FIELD = 28; // degrees

class Eye {
  /** `view` has the eye and up of the mechanism, and the outermost `points` of all that moves. */
  constructor(view) {
    this.view = view;
    this.lens = new THREE.PerspectiveCamera(FIELD, 1, 1, 10);
    this.flatLens = new THREE.OrthographicCamera(-1, 1, 1, -1, 1, 10);
    this.target = new THREE.Vector3();
    this.aspect = 1;
    this.reset();
  }

  get camera() {
    return this.flat ? this.flatLens : this.lens;
  }

  /** Returns to the view with which the page opened. */
  reset() {
    this.flat = this.view.flat;
    this.look(this.view.eye, this.view.up);
  }

  /** Looks from a direction at the whole mechanism. */
  look(eye, up) {
    this.back = new THREE.Vector3(...eye).normalize();
    this.up = new THREE.Vector3(...up);
    this.up.addScaledVector(this.back, -this.up.dot(this.back)).normalize();
    this.fit();
  }

  get right() {
    return new THREE.Vector3().crossVectors(this.up, this.back);
  }

  /** The smallest and the largest coordinate of all points along an axis. */
  #span(axis) {
    const along = this.view.points.map(([x, y, z]) => x * axis.x + y * axis.y + z * axis.z);
    return [Math.min(...along), Math.max(...along)];
  }

  /** Fits all points into the picture, seen from the current direction. */
  fit() {
    const axes = [this.right, this.up, this.back];
    const [across, upward, deep] = axes.map((axis) => this.#span(axis));
    this.target.set(0, 0, 0);
    [across, upward, deep].forEach(([low, high], i) => this.target.addScaledVector(axes[i], (low + high) / 2));
    const half = ([low, high]) => Math.max((high - low) / 2, 1e-9);
    this.half = 1.1 * Math.max(half(upward), half(across) / this.aspect); // of the picture's height, at the target
    if (!this.flat) this.half += 0.35 * half(deep) * Math.tan((FIELD * Math.PI) / 360);
    this.fitted = true;
  }

  turn(dx, dy) {
    const upward = new THREE.Vector3(...this.view.up);
    const aside = new THREE.Quaternion().setFromAxisAngle(upward, -dx);
    const over = new THREE.Quaternion().setFromAxisAngle(this.right.applyQuaternion(aside), -dy);
    const back = this.back.clone().applyQuaternion(aside).applyQuaternion(over);
    this.up.applyQuaternion(aside).applyQuaternion(over);
    this.back = back.normalize();
    this.up.addScaledVector(this.back, -this.up.dot(this.back)).normalize();
  }

  /** Shifts the picture by parts of its height. */
  pan(dx, dy) {
    this.target.addScaledVector(this.right, -2 * this.half * dx).addScaledVector(this.up, 2 * this.half * dy);
    this.fitted = false;
  }

  zoom(factor) {
    const { radius } = this.view;
    this.half = Math.min(Math.max(this.half * factor, 1e-3 * radius), 50 * radius);
    this.fitted = false;
  }

  resize(aspect) {
    this.aspect = aspect;
    if (this.fitted) this.fit();
  }

  /** Sets the camera up for the next picture. */
  update() {
    const distance = this.half / Math.tan((FIELD * Math.PI) / 360);
    const reach = distance + 4 * this.view.radius;
    for (const camera of [this.lens, this.flatLens]) {
      camera.position.copy(this.target).addScaledVector(this.back, this.flat && camera === this.flatLens ? reach : distance);
      camera.up.copy(this.up);
      camera.lookAt(this.target);
    }
    Object.assign(this.lens, { aspect: this.aspect, near: Math.max(distance / 100, distance - 6 * this.view.radius), far: reach + distance });
    const { half, aspect } = this;
    Object.assign(this.flatLens, { left: -half * aspect, right: half * aspect, top: half, bottom: -half, near: 0.01 * reach, far: 3 * reach });
    this.lens.updateProjectionMatrix();
    this.flatLens.updateProjectionMatrix();
  }
}
