// A page that `mbproj watch` serves: it hears of a newer one and loads it, with the time, the camera and all choices kept.

const KEPT = "mbproj watch";
/** Menus whose choice is kept by its text: another scene has other bodies, in another order. */
const MENUS = ["speed", "colour", "follow", "series"];

class Watch {
  /** `page` is null as long as there is none. */
  constructor(page, number) {
    this.page = page;
    this.number = number;
    if (page) this.#restore();
    const events = new EventSource("events");
    events.onmessage = ({ data }) => this.#hear(JSON.parse(data));
    events.onerror = () => tell("mbproj watch has ended, or does not answer: this page stays as it is.");
  }

  #hear({ number, problem }) {
    tell(problem);
    if (number === this.number) return;
    if (this.page) this.#keep();
    location.reload();
  }

  #keep() {
    const { player, eye, data } = this.page;
    const { time, playing, loop } = player;
    const camera = {
      back: eye.back.toArray(), up: eye.up.toArray(), half: eye.half, flat: eye.flat, fitted: eye.fitted,
      target: eye.target.toArray().map((x, axis) => x + data.view.middle[axis]),
    };
    const menus = MENUS.map((menu) => by(menu).selectedOptions[0]?.textContent);
    const layers = [...by("layers").children].map((label) => [label.textContent, label.firstChild.checked]);
    sessionStorage.setItem(KEPT, JSON.stringify({ time, playing, loop, camera, menus, layers }));
  }

  #restore() {
    const kept = JSON.parse(sessionStorage.getItem(KEPT));
    if (!kept) return;
    const { player, eye, data } = this.page;
    MENUS.forEach((menu, at) => {
      const option = [...by(menu).options].find(({ textContent }) => textContent === kept.menus[at]);
      if (!option || option.selected) return;
      by(menu).value = option.value;
      by(menu).onchange();
    });
    for (const label of by("layers").children) {
      const [, checked] = kept.layers.find(([name]) => name === label.textContent) ?? [];
      if (checked === undefined || checked === label.firstChild.checked) continue;
      label.firstChild.checked = checked;
      label.firstChild.onchange();
    }
    player.loop = kept.loop;
    player.playing = kept.playing;
    player.set(kept.time);
    const { back, up, target, half, flat, fitted } = kept.camera;
    Object.assign(eye, { back: new THREE.Vector3(...back), up: new THREE.Vector3(...up), flat });
    if (fitted) return eye.fit();
    eye.target.set(...target.map((x, axis) => x - data.view.middle[axis]));
    Object.assign(eye, { half, fitted });
  }
}

/** Shows the problem over the page. */
function tell(problem) {
  by("problem").hidden = !problem;
  by("problem").textContent = problem;
}
