// Curves beside the picture, each with a cursor at the time of the clock.
class Plots {
  constructor(holder, seek) {
    this.holder = holder;
    this.seek = seek;
    this.cursors = [];
  }

  load(scene) {
    this.cursors = [];
    this.holder.replaceChildren(...scene.figures.map(({ title, svg }) => {
      const figure = element("figure");
      figure.append(element("figcaption", "", title), this.plot(svg));
      return figure;
    }));
  }

  plot(svg) {
    const plot = element("div", "plot"), line = element("div", "cursor");
    const drawing = document.importNode(new DOMParser().parseFromString(svg, "text/html").querySelector("svg"), true);
    const span = drawing.dataset.span.split(" ").map(Number), { width, height } = drawing.viewBox.baseVal;
    const box = this.holder.clientWidth < 480 ? span[1] + 10 : width; // where it is narrow the tags name the curves
    drawing.setAttribute("viewBox", `0 0 ${box} ${height}`);
    plot.append(drawing, line);
    const [from, to, least, most] = span;
    const jump = (event) => {
      const { left, width: wide } = drawing.getBoundingClientRect();
      this.seek(least + ((((event.clientX - left) / wide) * box - from) / (to - from)) * (most - least));
    };
    plot.addEventListener("pointerdown", (event) => { if (event.button === 0) jump(event); });
    plot.addEventListener("pointermove", (event) => { if (event.buttons & 1) jump(event); });
    this.cursors.push({ plot, line, box, span, wide: 0 });
    return plot;
  }

  /** To be called when the page was laid out anew: a cursor moves without asking for the layout. */
  measure() {
    for (const cursor of this.cursors) cursor.wide = cursor.plot.clientWidth;
  }

  draw(time) {
    for (const { line, box, wide, span: [from, to, least, most] } of this.cursors) {
      const part = Math.min(Math.max((time - least) / (most - least), 0), 1);
      line.style.transform = `translateX(${((from + part * (to - from)) / box) * wide}px)`;
    }
  }
}
