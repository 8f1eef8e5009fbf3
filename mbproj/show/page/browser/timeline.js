// The slider of the time, with marks where something happened: events, the end of trust, a failure.

class Timeline {
  constructor(player, runs) {
    this.player = player;
    this.slider = document.getElementById("time");
    this.clock = document.getElementById("clock");
    this.marks = document.getElementById("marks");
    Object.assign(this.slider, { min: 0, max: 10000, step: 1 });
    this.slider.addEventListener("input", () => {
      player.playing = false;
      player.set(player.start + (this.slider.value / 10000) * (player.end - player.start));
    });
    const whole = { event: 0 };
    for (const run of runs) {
      const label = runs.length > 1 ? ` (${run.label})` : "";
      for (const { time, text, kind } of run.events) this.#mark(time, `${text}${label}`, kind, whole);
      if (run.trust && run.trust.since !== null) this.#untrusted(run.trust, label);
    }
  }

  #part(time) {
    const { start, end } = this.player;
    return (100 * (time - start)) / (end - start || 1);
  }

  #mark(time, text, kind, whole) {
    const mark = element("button", "", `mark ${kind}`);
    mark.style.left = `${this.#part(time)}%`;
    mark.title = `${quantity(time, "s")}: ${text}`;
    mark.setAttribute("aria-label", `go to ${mark.title}`);
    mark.tabIndex = -1; // there may be many; the keys [ and ] go through them
    mark.onclick = () => {
      this.player.playing = false;
      this.player.set(time);
    };
    whole.event += 1;
    this.marks.append(mark);
  }

  #untrusted(trust, label) {
    const band = element("div", "", "untrusted");
    band.style.left = `${this.#part(trust.since)}%`;
    band.title = `${trust.text}${label}`;
    this.marks.append(band);
  }

  update() {
    const { time, start, end } = this.player;
    const digits = Math.max(0, Math.min(6, 3 - Math.floor(Math.log10((end - start) || 1))));
    this.slider.value = Math.round((10000 * (time - start)) / (end - start || 1));
    const { unit } = this.player.runs[0];
    const text = `${time.toFixed(digits)} ${unit}`;
    this.slider.setAttribute("aria-valuetext", text);
    this.clock.textContent = `${text} / ${end.toFixed(digits)} ${unit}`;
  }
}
