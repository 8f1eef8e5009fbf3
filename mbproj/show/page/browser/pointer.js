// Mouse and touch on the scene: turn, pan, zoom; hover names a thing, a click selects it.

const CLICK = 5; // pixels that a click may move

class Pointer {
  /** `canvas` is watched; `eye` moves; `pick(x, y)` finds what is there; `hover` and `select` are told. */
  constructor(canvas, eye, { pick, hover, select }) {
    Object.assign(this, { canvas, eye, pick, hover, select });
    this.down = new Map(); // pointers that are down, by id
    this.moved = 0;
    const on = (name, handle) => canvas.addEventListener(name, handle, { passive: false });
    on("pointerdown", (event) => this.#press(event));
    on("pointermove", (event) => this.#move(event));
    on("pointerup", (event) => this.#release(event));
    on("pointercancel", (event) => this.down.delete(event.pointerId));
    on("pointerleave", () => this.hover(null));
    on("contextmenu", (event) => event.preventDefault());
    on("wheel", (event) => {
      event.preventDefault();
      this.eye.zoom(Math.exp(0.0012 * event.deltaY));
    });
  }

  #press(event) {
    this.canvas.setPointerCapture(event.pointerId);
    if (!this.down.size) this.moved = 0;
    this.down.set(event.pointerId, { x: event.clientX, y: event.clientY });
  }

  #move(event) {
    const before = this.down.get(event.pointerId);
    if (!before) {
      this.hover(event.pointerType === "mouse" ? this.pick(event.clientX, event.clientY) : null, event);
      return;
    }
    const [dx, dy] = [event.clientX - before.x, event.clientY - before.y];
    this.moved += Math.hypot(dx, dy);
    if (this.down.size > 1) this.#pinch(event, dx, dy);
    else if (event.buttons & 6 || event.shiftKey) this.eye.pan(dx / this.#height(), dy / this.#height());
    else if (this.moved > CLICK) this.eye.turn(0.008 * dx, 0.008 * dy);
    Object.assign(before, { x: event.clientX, y: event.clientY });
  }

  /** Two fingers: their middle pans, their distance zooms. */
  #pinch(event, dx, dy) {
    const [other] = [...this.down].filter(([id]) => id !== event.pointerId).map(([, place]) => place);
    const before = Math.hypot(event.clientX - dx - other.x, event.clientY - dy - other.y);
    const after = Math.hypot(event.clientX - other.x, event.clientY - other.y);
    if (before > 0 && after > 0) this.eye.zoom(before / after);
    this.eye.pan(dx / 2 / this.#height(), dy / 2 / this.#height());
  }

  #release(event) {
    this.down.delete(event.pointerId);
    if (this.moved <= CLICK && !this.down.size) this.select(this.pick(event.clientX, event.clientY));
  }

  #height() {
    return this.canvas.clientHeight || 1;
  }
}
