// The strip under the scene: one series of each run over time, with a cursor at the time that is shown.

const CHART_COLOURS = ["#1f5fa8", "#c4551d", "#2d7d46", "#7b3294", "#7a6a00"];
const [LEFT, RIGHT, TOP, BOTTOM] = [62, 22, 18, 20];

class Chart {
  constructor(canvas, runs, player) {
    Object.assign(this, { canvas, runs, player });
    this.choices = this.#choices();
    this.chosen = null;
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      this.#scrub(event);
    });
    canvas.addEventListener("pointermove", (event) => event.buttons && this.#scrub(event));
  }

  /** All series by name, each with its unit and a line {run, group, column} for every run that has it. */
  #choices() {
    const found = new Map();
    this.runs.forEach((run, number) =>
      run.groups.forEach((group, at) => {
        const owners = group.owners.length ? group.owners : [""];
        owners.forEach((owner, o) =>
          group.components.forEach((component, c) => {
            const name = [owner, group.name === "coordinate" ? "" : group.name, component].filter(Boolean).join(" ");
            const column = o * group.components.length + c;
            const entry = { run: number, group: at, column };
            if (!found.has(name)) found.set(name, { name, kind: group.kind, unit: group.units[owner ? o : 0], logarithmic: group.logarithmic, lines: [] });
            found.get(name).lines.push(entry);
          }),
        );
      }),
    );
    return found;
  }

  choose(name) {
    this.chosen = this.choices.get(name) ?? null;
    this.back = null;
  }

  #scrub(event) {
    const box = this.canvas.getBoundingClientRect();
    const part = (event.clientX - box.left - LEFT) / Math.max(box.width - LEFT - RIGHT, 1);
    this.player.playing = false;
    this.player.set(this.player.start + part * (this.player.end - this.player.start));
  }

  resize() {
    this.back = null;
  }

  draw() {
    if (!this.chosen || !this.canvas.clientWidth) return;
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    if (!this.back || this.width !== width || this.height !== height) {
      Object.assign(this, { width, height });
      this.back = document.createElement("canvas");
      for (const canvas of [this.canvas, this.back]) Object.assign(canvas, { width: width * ratio, height: height * ratio });
      const pen = this.back.getContext("2d");
      pen.scale(ratio, ratio);
      this.#lines(pen, width, height);
    }
    const pen = this.canvas.getContext("2d");
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.clearRect(0, 0, this.canvas.width, this.canvas.height);
    pen.drawImage(this.back, 0, 0);
    pen.scale(ratio, ratio);
    this.#cursor(pen, width, height);
  }

  #x(time) {
    const { start, end } = this.player;
    return LEFT + ((time - start) / (end - start || 1)) * (this.width - LEFT - RIGHT);
  }

  #y(value) {
    const [low, high] = this.range;
    const part = Math.min(Math.max((value - low) / (high - low), 0), 1);
    return this.height - BOTTOM - part * (this.height - TOP - BOTTOM);
  }

  /** The range of the stored numbers of all lines; for a logarithmic series these are powers of ten. */
  #range() {
    let [low, high] = [Infinity, -Infinity];
    for (const { run, group, column } of this.chosen.lines) {
      const block = this.runs[run].series[group];
      for (let row = 0; row < block.rows; row++) {
        const value = block.at(row, column);
        if (value < low) low = value;
        if (value > high) high = value;
      }
    }
    if (!(low <= high)) return [0, 1];
    if (this.chosen.logarithmic) low = Math.max(low, Math.min(high - 1, ZERO_POWER + 1));
    const room = this.chosen.logarithmic ? 0.5 : high - low > 1e-12 * Math.max(Math.abs(low), Math.abs(high)) ? 0.06 * (high - low) : 0.5 * (Math.abs(high) || 1);
    return [low - room, high + room];
  }

  #lines(pen, width, height) {
    this.range = this.#range();
    pen.font = "11px system-ui, sans-serif";
    pen.lineWidth = 1;
    const ticks = ticksOf(...this.range, 4, this.chosen.logarithmic);
    for (const tick of ticks) {
      const y = Math.round(this.#y(tick)) + 0.5;
      line(pen, "#dfe3e8", [LEFT, y], [width - RIGHT, y]);
      label(pen, this.chosen.logarithmic ? powerOfTen(tick) : short(tick, this.range), LEFT - 6, y, "right", "middle");
    }
    for (const tick of ticksOf(this.player.start, this.player.end, Math.max(2, width / 110))) {
      const x = Math.round(this.#x(tick)) + 0.5;
      line(pen, "#eceff2", [x, TOP], [x, height - BOTTOM]);
      label(pen, `${short(tick, [this.player.start, this.player.end])} ${this.runs[0].unit}`, x, height - 5, "center", "alphabetic");
    }
    this.chosen.lines.forEach((entry, number) => this.#curve(pen, entry, CHART_COLOURS[number % CHART_COLOURS.length]));
  }

  #curve(pen, { run, group, column }, colour) {
    const block = this.runs[run].series[group];
    pen.strokeStyle = colour;
    pen.lineWidth = 1.5;
    pen.beginPath();
    let lifted = true;
    for (let row = 0; row < block.rows; row++) {
      const value = block.at(row, column);
      if (!Number.isFinite(value)) lifted = true;
      else if (lifted) pen.moveTo(this.#x(this.runs[run].time(row)), this.#y(value));
      else pen.lineTo(this.#x(this.runs[run].time(row)), this.#y(value));
      if (Number.isFinite(value)) lifted = false;
    }
    pen.stroke();
  }

  #cursor(pen, width, height) {
    const { time } = this.player;
    const x = this.#x(time);
    line(pen, "#30363f", [x, TOP], [x, height - BOTTOM]);
    const values = this.chosen.lines.map(({ run, group, column }, number) => {
      const value = this.runs[run].value(group, column, this.runs[run].rowAt(time));
      const stored = this.chosen.logarithmic ? Math.log10(value) : value;
      pen.fillStyle = CHART_COLOURS[number % CHART_COLOURS.length];
      pen.beginPath();
      if (Number.isFinite(stored)) pen.arc(x, this.#y(stored), 3.5, 0, 2 * Math.PI);
      pen.fill();
      return quantity(value, this.chosen.unit);
    });
    pen.font = "600 11px system-ui, sans-serif";
    label(pen, `${this.chosen.name}: ${values.join("  |  ")}`, LEFT, 11, "left", "alphabetic", "#30363f");
  }
}

function line(pen, colour, from, to) {
  pen.strokeStyle = colour;
  pen.lineWidth = 1;
  pen.beginPath();
  pen.moveTo(...from);
  pen.lineTo(...to);
  pen.stroke();
}

function label(pen, text, x, y, align, baseline, colour = "#667080") {
  Object.assign(pen, { fillStyle: colour, textAlign: align, textBaseline: baseline });
  pen.fillText(text, x, y);
}

/** Round numbers in a range, about so many. */
function ticksOf(low, high, count, whole = false) {
  const rough = (high - low) / count;
  if (!(rough > 0)) return [low];
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = Math.max([1, 2, 5, 10].map((part) => part * power).find((each) => each >= rough), whole ? 1 : 0);
  const found = [];
  for (let at = Math.ceil(low / step) * step; at <= high + 1e-9 * step; at += step) found.push(Math.abs(at) < 1e-9 * step ? 0 : at);
  return found;
}

/** A tick's number with as many digits as its range asks for. */
function short(value, [low, high]) {
  const size = Math.max(Math.abs(low), Math.abs(high));
  if (value !== 0 && (size >= 1e5 || size < 1e-3)) return value.toExponential(1).replace("e", "·10^");
  const digits = Math.max(0, Math.min(6, 2 - Math.floor(Math.log10((high - low) || 1))));
  return String(Number(value.toFixed(digits)));
}

function powerOfTen(power) {
  const digits = [...String(Math.round(power))].map((digit) => (digit === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[digit])).join("");
  return `10${digits}`;
}

/** A number with its unit, for a reader. */
function quantity(value, unit) {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  const text = size !== 0 && (size >= 1e5 || size < 1e-3) ? value.toExponential(3) : String(Number(value.toPrecision(5)));
  return unit ? `${text} ${unit}` : text;
}
