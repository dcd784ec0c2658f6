// The replay: one clock for picture and plots, moved by hand, by key and by the address of the page.
class Replay {
  static LEAST = 2; // seconds that playing takes at least, at the speed that is proposed

  constructor(box) {
    this.box = box;
    const find = (selector) => box.querySelector(selector);
    [this.slider, this.clock, this.play, this.speed, this.picker, this.overlay, this.marks, this.told] =
      [".track input", ".clock", ".play", ".speed", ".picker", ".overlaid", ".marks", ".told"].map(find);
    this.blocks = new Map(Array.from(document.querySelectorAll("[data-scene]"), (b) => [b.dataset.scene, b]));
    this.state = {
      scene: null, time: 0, overlaid: false,
      shown: () => this.state.scene?.engines.filter((e) => !document.documentElement.classList.contains(`hide-${e.slug}`)) ?? [],
    };
    this.playing = false;
    this.touched = false; // the address is left alone until somebody acts
    this.stage = new Stage(find(".stage"), this.state, (t) => this.seek(t));
    this.plots = new Plots(find(".plots"), (t) => this.seek(t));
    this.listen();
    this.opened = this.linked().then((done) => done || this.open(this.picker.value));
  }

  /** The scene on show, once it is there: for scripts and tests. */
  async scene() {
    await this.opened;
    return this.state.scene;
  }

  // ---- a scene

  async open(name) {
    this.run(false);
    this.wanted = name;
    try {
      const scene = await Blocks.scene(this.blocks.get(name).textContent);
      if (this.wanted !== name) return; // another one was chosen meanwhile
      Object.assign(this.state, { scene, time: 0 });
    } catch (error) {
      this.told.textContent = `The recorded motion cannot be shown: ${error.message}. The charts below need nothing of the kind.`;
      document.documentElement.classList.add("no-player");
      return;
    }
    this.stage.load();
    this.plots.load(this.state.scene);
    this.label(name);
    requestAnimationFrame(() => { this.plots.measure(); this.draw(); });
    document.documentElement.dataset.replays = name;
  }

  /** Everything around the picture that says which scene it is. */
  label(name) {
    const { scene } = this.state, { larger } = this.stage, speeds = Array.from(this.speed.options, (o) => Number(o.value));
    this.picker.value = name;
    this.told.textContent = this.blocks.get(name).dataset.said
      + (larger > 1.05 ? ` Bodies are drawn ${larger.toPrecision(2)} times larger than they are.` : "");
    this.speed.value = Math.max(speeds[0], ...speeds.filter((s) => s <= 1 && scene.duration / s >= Replay.LEAST));
    this.slider.disabled = this.play.disabled = false;
    this.marks.replaceChildren(...this.failing(scene.engines).map((e) => {
      const mark = element("i", `eng-${e.slug}`);
      mark.style.left = `${(100 * e.moment) / scene.duration}%`;
      return mark;
    }));
  }

  failing(engines) {
    return engines.filter((e) => e.fails && e.moment !== null);
  }

  async choose(name) {
    await this.open(name);
    this.note();
  }

  next(way) {
    const names = Array.from(this.blocks.keys()), k = names.indexOf(this.picker.value);
    this.choose(names[(k + way + names.length) % names.length]);
  }

  arrange() {
    if (!this.state.scene) return;
    this.state.overlaid = this.overlay.checked;
    this.stage.arrange();
    this.plots.measure();
    this.draw();
    this.note();
  }

  // ---- the clock

  draw() {
    const { scene, time } = this.state;
    this.stage.redraw();
    this.plots.draw(time);
    this.slider.value = Math.round((1000 * time) / scene.duration);
    this.slider.setAttribute("aria-valuetext", seconds(time));
    this.clock.textContent = seconds(time);
  }

  seek(time) {
    this.run(false);
    this.state.time = Math.min(Math.max(time, 0), this.state.scene.duration);
    this.draw();
    this.note();
  }

  run(on) {
    if (this.playing === on) return;
    this.playing = on;
    this.play.setAttribute("aria-label", on ? "Pause" : "Play");
    this.play.textContent = on ? "❚❚" : "▶";
    if (!on) return this.note();
    if (this.state.time >= this.state.scene.duration) this.state.time = 0;
    this.last = performance.now();
    requestAnimationFrame((now) => this.tick(now));
  }

  tick(now) {
    if (!this.playing) return;
    const { scene } = this.state;
    this.state.time += (Math.max(now - this.last, 0) / 1000) * Number(this.speed.value);
    this.last = now;
    if (this.state.time >= scene.duration) return this.seek(scene.duration);
    this.draw();
    requestAnimationFrame((later) => this.tick(later));
  }

  /** One kept sample of the first engine forward or back. */
  step(way) {
    const times = Array.from(this.state.shown()[0]?.t ?? []), { time } = this.state;
    const next = way > 0 ? times.find((t) => t > time + 1e-9) : times.reverse().find((t) => t < time - 1e-9);
    if (next !== undefined) this.seek(next);
  }

  /** To the next failing moment, after the last one to the first. */
  fail() {
    const moments = this.failing(this.state.shown()).map((e) => e.moment).sort((a, b) => a - b);
    const next = moments.find((m) => m > this.state.time + 1e-9) ?? moments[0];
    if (next !== undefined) this.seek(next);
  }

  // ---- the address

  /** Write what is shown into the address, when it has been so for a moment. */
  note() {
    clearTimeout(this.noting);
    this.noting = setTimeout(() => {
      const { scene, time, overlaid } = this.state, shown = this.state.shown();
      if (!scene || this.playing || !this.touched) return;
      const words = { scene: scene.scenario, t: time.toFixed(3) };
      if (shown.length < scene.engines.length) words.engines = shown.map((e) => e.name).join(",");
      if (overlaid) words.view = "overlay";
      try { history.replaceState(null, "", `#${new URLSearchParams(words)}`); } catch { /* some file: pages have no history */ }
    }, 300);
  }

  /** Show what the address asks for; whether it asks for a scene of this page. */
  async linked() {
    const words = new URLSearchParams(location.hash.slice(1)), time = Number(words.get("t") ?? NaN);
    if (!this.blocks.has(words.get("scene"))) return false;
    this.touched = true;
    this.state.overlaid = this.overlay.checked = words.get("view") === "overlay";
    const inputs = Array.from(document.querySelectorAll("[data-engine]")), wanted = (words.get("engines") ?? "").split(",");
    if (inputs.some((input) => wanted.includes(input.dataset.name))) { // else it is of another page
      for (const input of inputs) if (input.checked !== wanted.includes(input.dataset.name)) input.click();
    }
    await this.open(words.get("scene"));
    if (this.state.scene && Number.isFinite(time)) this.seek(time);
    this.box.closest("section").scrollIntoView();
    return true;
  }

  // ---- what moves it

  listen() {
    const { box } = this, find = (selector) => box.querySelector(selector);
    for (const kind of ["pointerdown", "keydown", "input"]) box.addEventListener(kind, () => { this.touched = true; }, true);
    box.addEventListener("keydown", (event) => this.key(event));
    this.play.addEventListener("click", () => this.run(!this.playing));
    this.slider.addEventListener("input", () => this.seek((this.slider.value * this.state.scene.duration) / 1000));
    this.picker.addEventListener("change", () => this.choose(this.picker.value));
    this.overlay.addEventListener("change", () => this.arrange());
    find(".next").addEventListener("click", () => this.next(1));
    find(".previous").addEventListener("click", () => this.next(-1));
    addEventListener("hashchange", () => this.linked());
    document.addEventListener("plumbline:engines", () => this.arrange());
    const theme = () => { Inks.forget(); this.stage.redraw(); };
    document.addEventListener("plumbline:theme", theme);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", theme);
    new ResizeObserver(() => this.arrange()).observe(find(".frame"));
  }

  key(event) {
    const { target } = event;
    if (!this.state.scene || event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey || target.tagName === "SELECT") return;
    const pressed = target.tagName === "BUTTON" || target.type === "checkbox"; // space presses what has the focus
    const act = {
      " ": pressed ? null : () => this.run(!this.playing), ",": () => this.step(-1), ".": () => this.step(1), f: () => this.fail(),
      o: () => this.overlay.click(), n: () => this.next(1), p: () => this.next(-1),
    }[event.key];
    if (!act) return;
    act();
    event.preventDefault();
  }
}

const player = document.getElementById("player") ? new Replay(document.getElementById("player")) : null;
