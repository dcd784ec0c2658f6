// The replay: all engines on one clock, panels and plots that follow it.
const Player = (() => {
  const root = document.documentElement, MOST_OVERLAID = 4, LEAST = 2; // seconds that playing takes at least, at the speed that is proposed
  const element = (tag, kind = "", text = "") => Object.assign(document.createElement(tag), { className: kind, textContent: text });
  const seconds = (t) => `${t.toFixed(2)} s`;

  const start = (box) => {
    const find = (selector) => box.querySelector(selector);
    const [stage, tags, slider, clock] = [".stage", ".tags", "input[type=range]", ".clock"].map(find);
    const [play, speed, picker, overlay, plots, marks, said] =
      [".play", ".speed", ".picker", ".overlaid", ".plots", ".marks", ".told"].map(find);
    const blocks = new Map(Array.from(document.querySelectorAll("[data-scene]"), (b) => [b.dataset.scene, b]));
    let scene = null, painter = null, canvas = null, time = 0, playing = false, last = 0, view = null, larger = 1;
    let cursors = [], dirty = false, loading = null, touched = false; // the address is left alone until somebody acts

    // ---- what is drawn

    const shown = () => scene.engines.filter((e) => !root.classList.contains(`hide-${e.slug}`));
    const overlaid = () => overlay.checked;

    const inks = new Map(); // of the theme: asking the style sheet for each frame would cost more than the frame
    const colour = (name) => {
      if (!inks.has(name)) {
        const text = getComputedStyle(root).getPropertyValue(name).trim();
        inks.set(name, [1, 3, 5].map((k) => parseInt(text.slice(k, k + 2), 16) / 255));
      }
      return inks.get(name);
    };
    const repaint = () => { inks.clear(); redraw(); };
    const mixed = (a, b, part) => a.map((v, k) => v + part * (b[k] - v));
    /** Black and white show no light and shade: a little grey does. */
    const lit = (rgb) => (Math.max(...rgb) < 0.1 || Math.min(...rgb) > 0.9 ? mixed(rgb, [0.5, 0.5, 0.5], 0.36) : rgb);
    const palette = () => {
      const [paper, rule, strong, ink] = ["--panel", "--rule", "--strong-rule", "--ink"].map(colour);
      return { paper, rule, ink, fixed: mixed(paper, strong, 0.55), shade: mixed(paper, strong, 0.3) };
    };

    const panels = () => {
      const engines = shown(), colours = palette(), scale = devicePixelRatio || 1, rooms = places();
      const instances = (e, own) => Views.instances(scene, e, time, { ...colours, own }, larger);
      const solid = (e) => instances(e, lit(colour(`--eng-${e.slug}`)));
      const frame = (place) => {
        const device = Object.fromEntries(Object.entries(place).map(([k, v]) => [k, Math.round(v * scale)]));
        return { ...device, scale, camera: Views.placed(scene, view, place.width / place.height, named(place) / place.height) };
      };
      if (!overlaid()) return engines.map((e, k) => ({ ...frame(rooms[k]), solids: solid(e), outlines: [] }));
      const [first, ...others] = engines.slice(0, MOST_OVERLAID);
      // the first outline is the broadest, so that equal motions show as layers
      const outlines = others.flatMap((e, k) => instances(e, colour(`--eng-${e.slug}`)).filter((i) => !i.fixed).map((i) => ({ ...i, breadth: 1 + 1.2 * (others.length - k) })));
      return first ? [{ ...frame(rooms[0]), solids: solid(first), outlines }] : [];
    };

    /** Height that the names of the engines take in a panel [CSS pixels]. */
    const named = (place) => {
      if (overlaid()) return Math.min(Math.max(...Array.from(tags.children, (t) => t.offsetTop + t.offsetHeight), 0), 0.4 * place.height);
      return place.width < 330 ? 62 : 42;
    };

    /** Where the panels stand in the stage [CSS pixels]. */
    const places = () => {
      const count = overlaid() ? 1 : Math.max(shown().length, 1), wide = stage.clientWidth;
      const columns = Math.min(count, Math.max(2, Math.floor(wide / 280)));
      const rows = Math.ceil(count / columns), even = Math.ceil(count / rows);
      const width = wide / even, height = stage.clientHeight / rows;
      return Array.from({ length: count }, (_, k) => ({ x: (k % even) * width, y: Math.floor(k / even) * height, width, height }));
    };

    const draw = () => {
      dirty = false;
      if (!scene) return;
      painter.draw(panels(), palette());
      for (const { line, span, figure } of cursors) {
        const [from, to, least, most] = span, part = Math.min(Math.max((time - least) / (most - least), 0), 1);
        line.style.transform = `translateX(${((from + part * (to - from)) / figure.box) * figure.wide}px)`;
      }
      slider.value = Math.round((1000 * time) / scene.duration);
      slider.setAttribute("aria-valuetext", seconds(time));
      clock.textContent = seconds(time);
      for (const e of scene.engines) e.tag?.classList.toggle("ended", time > e.t[e.t.length - 1] + 1e-9);
    };
    const redraw = () => {
      if (!dirty) requestAnimationFrame(draw);
      dirty = true;
    };

    /** Lay out anew: the size, the engines or the way of showing them have changed. */
    const arrange = () => {
      if (!scene) return;
      const engines = shown(), count = overlaid() ? 1 : engines.length, narrow = stage.clientWidth < 560;
      const rows = Math.ceil(count / Math.max(2, Math.floor(stage.clientWidth / 280)));
      stage.style.height = `${overlaid() || rows < 2 ? (narrow ? 320 : 400) : rows * (narrow ? 200 : rows > 2 ? 220 : 260)}px`;
      const scale = devicePixelRatio || 1;
      canvas.width = Math.round(stage.clientWidth * scale);
      canvas.height = Math.round(stage.clientHeight * scale);
      const rooms = places();
      tags.replaceChildren(...engines.map((e, k) => tagged(e, overlaid() ? null : rooms[k], overlaid() && k >= MOST_OVERLAID, k)));
      tags.classList.toggle("row", overlaid());
      for (const cursor of cursors) cursor.figure.wide = cursor.figure.clientWidth;
      redraw();
    };

    const tagged = (e, place, left, k) => {
      const tag = element("div", `tag eng-${e.slug}${left ? " left" : ""}${overlaid() && k ? " outlined" : ""}`);
      if (place) Object.assign(tag.style, { left: `${place.x}px`, top: `${place.y}px`, width: `${place.width}px`, height: `${place.height}px` });
      const name = element("span", "tag-name");
      const icon = document.querySelector(`[data-engine="${e.slug}"] + .icon`);
      name.append(...(icon ? [icon.cloneNode(true)] : []), element("b", "", e.name.split(":")[0]), ` ${e.name.split(":")[1] || ""}`);
      const verdict = element("span", `verdict tone-${e.tone}`, `${e.glyph} ${e.word}`);
      verdict.title = e.why;
      tag.append(name, verdict);
      if (e.moment !== null) tag.append(jump(e));
      if (left) tag.append(element("small", "", "not overlaid: at most four"));
      if (e.left) tag.append(element("small", "", "leaves the picture"));
      tag.append(element("small", "end", `ended at ${seconds(e.t[e.t.length - 1])}`));
      e.tag = tag;
      return tag;
    };

    const jump = (e) => {
      const button = element("button", e.fails ? "jump" : "jump calm", `${e.fails ? "fails" : "worst"} at ${seconds(e.moment)}`);
      button.type = "button";
      button.title = `${e.name}: ${e.why}`;
      button.addEventListener("click", () => seek(e.moment));
      return button;
    };

    // ---- the clock

    const seek = (t) => {
      time = Math.min(Math.max(t, 0), scene.duration);
      redraw();
      noted();
    };
    const run = (on) => {
      playing = on && scene !== null;
      play.setAttribute("aria-label", playing ? "Pause" : "Play");
      play.textContent = playing ? "❚❚" : "▶";
      if (playing && time >= scene.duration) time = 0;
      last = performance.now();
      if (playing) requestAnimationFrame(tick); else noted();
    };
    const tick = (now) => {
      if (!playing) return;
      time += ((now - last) / 1000) * Number(speed.value);
      last = now;
      if (time >= scene.duration) { time = scene.duration; run(false); }
      draw();
      if (playing) requestAnimationFrame(tick);
    };
    /** One kept sample of the first engine forward or back. */
    const step = (way) => {
      const times = shown()[0]?.t ?? [];
      const next = way > 0 ? times.find((t) => t > time + 1e-9) : Array.from(times).reverse().find((t) => t < time - 1e-9);
      run(false);
      if (next !== undefined) seek(next);
    };
    const fail = () => {
      const moments = shown().filter((e) => e.fails && e.moment !== null).map((e) => e.moment).sort((a, b) => a - b);
      const next = moments.find((m) => m > time + 1e-9) ?? moments[0];
      if (next !== undefined) seek(next);
    };

    // ---- links to a moment

    let waiting = 0;
    const noted = () => {
      clearTimeout(waiting);
      waiting = setTimeout(() => {
        if (!scene || playing || !touched) return;
        const words = { scene: scene.scenario, t: time.toFixed(3) };
        if (shown().length < scene.engines.length) words.engines = shown().map((e) => e.name).join(",");
        if (overlaid()) words.view = "overlay";
        try { history.replaceState(null, "", `#${new URLSearchParams(words)}`); } catch { /* some file: pages have no history */ }
      }, 300);
    };
    const linked = async () => {
      const words = new URLSearchParams(location.hash.slice(1));
      if (!blocks.has(words.get("scene"))) return false;
      touched = true;
      overlay.checked = words.get("view") === "overlay";
      if (words.get("engines")) {
        const wanted = words.get("engines").split(",");
        for (const input of document.querySelectorAll("[data-engine]")) {
          const on = wanted.includes(input.dataset.name);
          if (input.checked !== on) { input.checked = on; input.dispatchEvent(new Event("change")); }
        }
      }
      await open(words.get("scene"));
      if (words.get("t") !== null && Number.isFinite(Number(words.get("t")))) seek(Number(words.get("t")));
      box.closest("section").scrollIntoView();
      return true;
    };

    // ---- a scene

    const open = async (name) => {
      run(false);
      loading = name;
      try {
        const next = await Blocks.scene(blocks.get(name).textContent);
        if (loading !== name) return; // another one was chosen meanwhile
        scene = next;
      } catch (error) {
        said.textContent = `The recorded motion cannot be shown: ${error.message}. The charts below need nothing of the kind.`;
        root.classList.add("no-player");
        return;
      }
      picker.value = name;
      const slow = Array.from(speed.options, (o) => Number(o.value)).filter((s) => s <= 1 && scene.duration / s >= LEAST);
      speed.value = Math.max(...slow, Number(speed.options[0].value));
      [time, view, larger] = [0, Views.camera(scene.planar), Views.enlarged(scene)];
      said.textContent = [blocks.get(name).dataset.said, larger > 1.05 ? `Bodies are drawn ${larger.toPrecision(2)} times larger than they are.` : ""].join(" ");
      canvas.setAttribute("aria-label", `${name}: ${scene.engines.map((e) => `${e.name} ${e.word}`).join(", ")}`);
      painter.load(scene);
      charts();
      slider.disabled = play.disabled = false;
      marks.replaceChildren(...scene.engines.filter((e) => e.fails && e.moment !== null).map((e) => {
        const mark = element("i", `eng-${e.slug}`);
        mark.style.left = `${(100 * e.moment) / scene.duration}%`;
        return mark;
      }));
      arrange();
      root.dataset.replays = name;
    };

    const charts = () => {
      cursors = [];
      plots.replaceChildren(...scene.figures.map(({ title, svg }) => {
        const figure = element("figure"), line = element("div", "cursor"), holder = element("div", "plot");
        const drawing = document.importNode(new DOMParser().parseFromString(svg, "text/html").querySelector("svg"), true);
        holder.append(drawing, line);
        figure.append(element("figcaption", "", title), holder);
        const span = drawing.dataset.span.split(" ").map(Number), { width, height } = drawing.viewBox.baseVal;
        holder.box = plots.clientWidth < 480 ? span[1] + 10 : width; // where it is narrow the tags name the curves
        drawing.setAttribute("viewBox", `0 0 ${holder.box} ${height}`);
        cursors.push({ line, span, figure: holder });
        const at = (event) => {
          const x = ((event.clientX - drawing.getBoundingClientRect().left) / drawing.clientWidth) * holder.box;
          const [from, to, least, most] = span;
          run(false);
          seek(least + ((x - from) / (to - from)) * (most - least));
        };
        holder.addEventListener("pointerdown", (event) => { if (event.button === 0) at(event); });
        holder.addEventListener("pointermove", (event) => { if (event.buttons & 1) at(event); });
        return figure;
      }));
      requestAnimationFrame(() => { for (const c of cursors) c.figure.wide = c.figure.clientWidth; draw(); });
    };

    // ---- the picture and the hand

    const paint = (forced) => {
      canvas?.remove();
      painter?.drop();
      canvas = element("canvas");
      canvas.tabIndex = 0;
      canvas.setAttribute("role", "img");
      stage.prepend(canvas);
      try { painter = forced ? null : WebGL.painter(canvas); } catch { painter = null; }
      if (!painter) {
        const plain = canvas.cloneNode(); // a canvas that has tried WebGL draws nothing else
        canvas.replaceWith(plain);
        canvas = plain;
        painter = Canvas2D.painter(canvas);
      }
      canvas.addEventListener("webglcontextlost", (event) => { event.preventDefault(); paint(true); painter.load(scene); arrange(); });
      root.dataset.painter = painter.name;
      handle();
    };

    const turn = (dx, dy) => {
      view.azimuth -= dx;
      view.elevation = Math.min(Math.max(view.elevation + dy, -10), 89);
      redraw();
    };
    const zoom = (factor) => { view.zoom = Math.min(Math.max(view.zoom * factor, 0.2), 20); redraw(); };

    const handle = () => {
      canvas.addEventListener("pointermove", (event) => { if (event.buttons & 1 && scene) turn(0.4 * event.movementX, 0.3 * event.movementY); });
      canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
      canvas.addEventListener("dblclick", () => { view = Views.camera(scene.planar); redraw(); });
      canvas.addEventListener("wheel", (event) => {
        if (!event.ctrlKey && !event.shiftKey) return; // the wheel belongs to the page
        event.preventDefault();
        zoom(Math.exp(-0.002 * (event.deltaY || event.deltaX)));
      }, { passive: false });
      canvas.addEventListener("keydown", (event) => {
        const act = { ArrowLeft: () => turn(-6, 0), ArrowRight: () => turn(6, 0), ArrowUp: () => turn(0, 4), ArrowDown: () => turn(0, -4),
          "+": () => zoom(1.2), "-": () => zoom(1 / 1.2), 0: () => { view = Views.camera(scene.planar); redraw(); } }[event.key];
        if (act) { act(); event.preventDefault(); event.stopPropagation(); }
      });
    };

    for (const kind of ["pointerdown", "keydown", "input"]) box.addEventListener(kind, () => { touched = true; }, true);
    box.addEventListener("keydown", (event) => {
      if (!scene || event.ctrlKey || event.metaKey || event.altKey || event.target.tagName === "SELECT") return;
      const button = event.target.tagName === "BUTTON" || event.target.type === "checkbox";
      const act = { " ": button ? null : () => run(!playing), ",": () => step(-1), ".": () => step(1), f: fail,
        o: () => overlay.click(), n: () => turnTo(1), p: () => turnTo(-1) }[event.key];
      if (act) { act(); event.preventDefault(); }
    });
    const turnTo = (way) => {
      const names = Array.from(blocks.keys()), k = names.indexOf(scene.scenario);
      chosen(names[(k + way + names.length) % names.length]);
    };
    const chosen = async (name) => { await open(name); noted(); };

    play.addEventListener("click", () => run(!playing));
    slider.addEventListener("input", () => { run(false); seek((slider.value * scene.duration) / 1000); });
    picker.addEventListener("change", () => chosen(picker.value));
    overlay.addEventListener("change", () => { arrange(); noted(); });
    find(".next").addEventListener("click", () => turnTo(1));
    find(".previous").addEventListener("click", () => turnTo(-1));
    addEventListener("hashchange", linked);
    document.addEventListener("plumbline:engines", arrange);
    document.addEventListener("plumbline:theme", repaint);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", repaint);
    new ResizeObserver(arrange).observe(stage.parentElement);

    paint(new URLSearchParams(location.search).has("canvas"));
    const opened = linked().then((done) => done || open(picker.value));
    return { scene: () => opened.then(() => scene), seek, time: () => time };
  };

  const box = document.getElementById("player");
  return box ? start(box) : null;
})();
