// The picture: panels side by side or one overlay, who is in them, and how they are turned.
class Stage {
  static MOST_OVERLAID = 4; // more engines than that cannot be told apart

  /** `state` has the scene, the engines shown, the time and whether they are overlaid. */
  constructor(holder, state, seek) {
    this.holder = holder;
    this.tags = holder.querySelector(".tags");
    this.state = state;
    this.seek = seek;
    this.waiting = false;
    this.paint(new URLSearchParams(location.search).has("canvas"));
  }

  /** A canvas and its painter; without WebGL, or if it is `forced`, the one that draws by hand. */
  paint(forced) {
    this.canvas?.remove();
    this.painter?.drop();
    const fresh = () => {
      const canvas = Object.assign(element("canvas"), { tabIndex: 0 });
      canvas.setAttribute("role", "img");
      return canvas;
    };
    this.canvas = fresh();
    try { this.painter = forced ? null : WebGL.painter(this.canvas); } catch { this.painter = null; }
    if (!this.painter) {
      this.canvas = fresh(); // a canvas that has tried WebGL draws nothing else
      this.painter = Canvas2D.painter(this.canvas);
    }
    this.holder.prepend(this.canvas);
    this.canvas.addEventListener("webglcontextlost", () => { this.paint(true); this.load(); });
    this.handle(this.canvas);
    document.documentElement.dataset.painter = this.painter.name;
  }

  /** Take the scene of the state. */
  load() {
    const { scene } = this.state;
    if (!scene) return;
    this.view = Views.camera(scene.planar);
    this.larger = Views.enlarged(scene);
    this.canvas.setAttribute("aria-label", `${scene.scenario}: ${scene.engines.map((e) => `${e.name} ${e.word}`).join(", ")}`);
    this.painter.load(scene);
    this.arrange();
  }

  /** Lay out anew: the size, the engines or the way of showing them have changed. */
  arrange() {
    const { holder, canvas, state } = this, { overlaid } = state, engines = state.shown();
    const wide = holder.clientWidth, narrow = wide < 560, count = overlaid ? 1 : Math.max(engines.length, 1);
    const columns = Math.min(count, Math.max(2, Math.floor(wide / 280))), rows = Math.ceil(count / columns);
    const height = rows > 1 ? rows * (narrow ? 200 : rows > 2 ? 220 : 260) : narrow ? 320 : 400;
    holder.style.height = `${height}px`;
    this.rooms = Stage.rooms(count, rows, wide, height);
    this.scale = devicePixelRatio || 1;
    [canvas.width, canvas.height] = [wide, height].map((v) => Math.round(v * this.scale));
    this.tags.classList.toggle("row", overlaid);
    this.tags.replaceChildren(...engines.map((e, k) => this.tag(e, k)));
    this.named = overlaid ? Math.max(0, ...Array.from(this.tags.children, (t) => t.offsetTop + t.offsetHeight)) : wide / columns < 330 ? 62 : 42;
    this.redraw();
  }

  /** Where panels stand in the picture [CSS pixels]. */
  static rooms(count, rows, wide, high) {
    const columns = Math.ceil(count / rows), width = wide / columns, height = high / rows;
    return Array.from({ length: count }, (_, k) => ({ x: (k % columns) * width, y: Math.floor(k / columns) * height, width, height }));
  }

  /** Name, verdict and moment of an engine, over its panel or in the row above the overlay. */
  tag(engine, k) {
    const { overlaid } = this.state, left = overlaid && k >= Stage.MOST_OVERLAID;
    const tag = element("div", `tag eng-${engine.slug}${left ? " left" : ""}`), name = element("span", "tag-name");
    if (!overlaid) {
      const { x, y, width, height } = this.rooms[k];
      Object.assign(tag.style, { left: `${x}px`, top: `${y}px`, width: `${width}px`, height: `${height}px` });
    }
    const icon = document.querySelector(`[data-engine="${engine.slug}"] + .icon`), [base, profile] = engine.name.split(":");
    name.append(...(icon ? [icon.cloneNode(true)] : []), element("b", "", base), ` ${profile || ""}`);
    const verdict = element("span", `verdict tone-${engine.tone}`, `${engine.glyph} ${engine.word}`);
    verdict.title = engine.why;
    tag.append(name, verdict, ...(engine.moment === null ? [] : [this.jump(engine)]));
    if (left) tag.append(element("small", "", `not overlaid: at most ${Stage.MOST_OVERLAID}`));
    if (engine.left) tag.append(element("small", "", "leaves the picture"));
    tag.append(element("small", "end", `ended at ${seconds(engine.t[engine.t.length - 1])}`));
    engine.tag = tag;
    return tag;
  }

  jump(engine) {
    const button = element("button", engine.fails ? "jump" : "jump calm");
    button.type = "button";
    button.textContent = `${engine.fails ? "fails" : "worst"} at ${seconds(engine.moment)}`;
    button.title = `${engine.name}: ${engine.why}`;
    button.addEventListener("click", () => this.seek(engine.moment));
    return button;
  }

  redraw() {
    if (!this.waiting) requestAnimationFrame(() => this.draw());
    this.waiting = true;
  }

  draw() {
    this.waiting = false;
    const { scene, time } = this.state;
    if (!scene) return;
    this.painter.draw(this.panels(), Inks.common());
    for (const e of scene.engines) e.tag?.classList.toggle("ended", time > e.t[e.t.length - 1] + 1e-9);
  }

  panels() {
    const engines = this.state.shown();
    if (!this.state.overlaid) return engines.map((e, k) => this.panel(this.rooms[k], this.instances(e, Inks.solid(e)), []));
    const [first, ...others] = engines.slice(0, Stage.MOST_OVERLAID);
    // the first outline is the broadest, so that equal motions show as layers
    const outlines = others.flatMap((e, k) => this.instances(e, Inks.line(e)).filter((i) => !i.fixed)
      .map((i) => ({ ...i, breadth: 0.6 + 1.6 * (others.length - k) })));
    return first ? [this.panel(this.rooms[0], this.instances(first, Inks.solid(first)), outlines)] : [];
  }

  /** A panel for the painter, in pixels of the device. */
  panel(room, solids, outlines) {
    const place = Object.fromEntries(Object.entries(room).map(([name, v]) => [name, Math.round(v * this.scale)]));
    const top = Math.min(this.named / room.height, 0.4);
    const camera = Views.placed(this.state.scene, this.view, room.width / room.height, top);
    return { ...place, scale: this.scale, camera, solids, outlines };
  }

  instances(engine, own) {
    return Views.instances(this.state.scene, engine, this.state.time, { ...Inks.common(), own }, this.larger);
  }

  turn(across, up) {
    this.view.azimuth -= across;
    this.view.elevation = Math.min(Math.max(this.view.elevation + up, -10), 89);
    this.redraw();
  }

  zoom(factor) {
    this.view.zoom = Math.min(Math.max(this.view.zoom * factor, 0.2), 20);
    this.redraw();
  }

  back() {
    this.view = Views.camera(this.state.scene.planar);
    this.redraw();
  }

  handle(canvas) {
    const when = (act) => (event) => { if (this.state.scene) act(event); };
    canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
    canvas.addEventListener("pointermove", when((event) => { if (event.buttons & 1) this.turn(0.4 * event.movementX, 0.3 * event.movementY); }));
    canvas.addEventListener("dblclick", when(() => this.back()));
    canvas.addEventListener("wheel", when((event) => {
      if (!event.ctrlKey && !event.shiftKey) return; // the wheel belongs to the page
      event.preventDefault();
      this.zoom(Math.exp(-0.002 * (event.deltaY || event.deltaX)));
    }), { passive: false });
    canvas.addEventListener("keydown", when((event) => {
      const act = {
        ArrowLeft: () => this.turn(-6, 0), ArrowRight: () => this.turn(6, 0), ArrowUp: () => this.turn(0, 4), ArrowDown: () => this.turn(0, -4),
        "+": () => this.zoom(1.2), "-": () => this.zoom(1 / 1.2), 0: () => this.back(),
      }[event.key];
      if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
      act();
      event.preventDefault();
    }));
  }
}
