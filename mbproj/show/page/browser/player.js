// Time: it runs, stops, steps, and can be set; whoever listens is told.

const SPEEDS = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.25, 0.5, 1, 2, 5, 10, 20, 50, 100];
/** The least and the most seconds that a run takes to watch at its first speed. */
const LEAST = 5;
const MOST = 90;

class Player {
  constructor(runs) {
    this.runs = runs;
    this.start = Math.min(...runs.map((run) => run.start));
    this.end = Math.max(...runs.map((run) => run.end));
    this.rate = runs[0].rate; // of time, in seconds or degrees, to the watcher's seconds at speed 1
    this.time = this.start;
    this.playing = false;
    this.loop = true;
    this.speed = this.#usual();
  }

  #usual() {
    const span = (this.end - this.start) / this.rate;
    if (this.rate !== 1) return 1;
    const slow = SPEEDS.filter((speed) => speed <= 1 && span / speed >= LEAST);
    const quick = SPEEDS.find((speed) => speed >= 1 && span / speed <= MOST) ?? SPEEDS[SPEEDS.length - 1];
    return span > MOST ? quick : slow.length ? slow[slow.length - 1] : SPEEDS[0];
  }

  /** Goes on by `seconds` of the watcher's time. */
  advance(seconds) {
    if (!this.playing) return;
    const time = this.time + seconds * this.speed * this.rate;
    if (time < this.end) this.time = time;
    else if (this.loop && this.end > this.start) this.time = this.start + ((time - this.start) % (this.end - this.start));
    else {
      this.time = this.end;
      this.playing = false;
    }
  }

  toggle() {
    if (!this.playing && this.time >= this.end) this.time = this.start;
    this.playing = !this.playing && this.end > this.start;
  }

  set(time) {
    this.time = Math.min(Math.max(time, this.start), this.end);
  }

  /** Goes forward, or back, by so many frames of the first run. */
  step(frames) {
    this.playing = false;
    const [run] = this.runs;
    const { row, part } = run.rowAt(this.time);
    const from = frames < 0 && part > 1e-9 ? row + 1 : row;
    this.set(run.time(Math.min(Math.max(from + frames, 0), run.frames - 1)));
  }

  faster(turns) {
    const at = SPEEDS.indexOf(this.speed);
    this.speed = SPEEDS[Math.min(Math.max(at + turns, 0), SPEEDS.length - 1)];
  }
}
