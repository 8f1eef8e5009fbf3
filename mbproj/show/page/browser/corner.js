// The corner of the scene: the global axes as they are seen, gravity, and a length to compare with.

class Corner {
  constructor(canvas, eye, gravity) {
    Object.assign(this, { canvas, eye });
    const size = Math.hypot(...gravity);
    this.gravity = size > 0 ? { direction: gravity.map((x) => x / size), text: `g ${Number(size.toPrecision(3))} m/s²` } : null;
  }

  draw() {
    const ratio = window.devicePixelRatio || 1;
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (!width) return;
    Object.assign(this.canvas, { width: width * ratio, height: height * ratio });
    const pen = this.canvas.getContext("2d");
    pen.scale(ratio, ratio);
    pen.font = "600 11px system-ui, sans-serif";
    const axes = [
      { direction: [1, 0, 0], text: "x", colour: "#b3322c" },
      { direction: [0, 1, 0], text: "y", colour: "#2c7d3a" },
      { direction: [0, 0, 1], text: "z", colour: "#2a56a5" },
    ];
    for (const { direction, text, colour } of axes) this.#arrow(pen, [38, height - 62], 26, direction, text, colour);
    if (this.gravity) this.#arrow(pen, [92, height - 62], 22, this.gravity.direction, "g", "#555d68");
    this.#scale(pen, 14, height - 14);
  }

  #arrow(pen, [x, y], length, direction, text, colour) {
    const along = new THREE.Vector3(...direction);
    const [dx, dy] = [along.dot(this.eye.right), -along.dot(this.eye.up)];
    const size = Math.hypot(dx, dy);
    pen.lineWidth = 2;
    Object.assign(pen, { fillStyle: colour, strokeStyle: colour, textAlign: "center", textBaseline: "middle" });
    if (size < 0.12) {
      pen.beginPath();
      pen.arc(x, y, 3, 0, 2 * Math.PI);
      pen.fill();
      if (text === "g") pen.fillText(text, x + 10, y - 8);
      return;
    }
    const [endX, endY] = [x + length * dx, y + length * dy];
    pen.beginPath();
    pen.moveTo(x, y);
    pen.lineTo(endX, endY);
    pen.stroke();
    const [ux, uy] = [dx / size, dy / size];
    pen.beginPath();
    pen.moveTo(endX + 5 * ux, endY + 5 * uy);
    pen.lineTo(endX - 2 * ux - 3.5 * uy, endY - 2 * uy + 3.5 * ux);
    pen.lineTo(endX - 2 * ux + 3.5 * uy, endY - 2 * uy - 3.5 * ux);
    pen.fill();
    pen.fillText(text, endX + 12 * ux, endY + 12 * uy);
  }

  /** A round length, as long as it is at the target. */
  #scale(pen, x, y) {
    const perPixel = (2 * this.eye.half) / this.eye.pixels;
    const rough = 90 * perPixel;
    const power = 10 ** Math.floor(Math.log10(rough));
    const size = [1, 2, 5].map((part) => part * power).filter((each) => each <= rough).pop() ?? power;
    const end = x + size / perPixel;
    pen.strokeStyle = "#3c434d";
    pen.lineWidth = 1.5;
    pen.beginPath();
    pen.moveTo(x, y - 4);
    pen.lineTo(x, y);
    pen.lineTo(end, y);
    pen.lineTo(end, y - 4);
    pen.stroke();
    Object.assign(pen, { fillStyle: "#3c434d", textAlign: "left", textBaseline: "alphabetic" });
    pen.fillText(lengthText(size), x + 4, y - 6);
  }
}

function lengthText(metres) {
  if (metres >= 1000) return `${Number((metres / 1000).toPrecision(3))} km`;
  if (metres >= 1) return `${Number(metres.toPrecision(3))} m`;
  if (metres >= 1e-3) return `${Number((1000 * metres).toPrecision(3))} mm`;
  if (metres >= 1e-6) return `${Number((1e6 * metres).toPrecision(3))} µm`;
  return `${metres.toExponential(0)} m`;
}
