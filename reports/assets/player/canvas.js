// Painter without a graphics processor: faces sorted by depth and filled, body by body.
const Canvas2D = (() => {
  const SUN = Meshes.unit([-0.35, -0.5, 0.95]);
  const css = (rgb, lit = 1) => `rgb(${rgb.map((c) => Math.round(255 * Math.min(c * lit, 1))).join(" ")})`;

  const painter = (canvas) => {
    const context = canvas.getContext("2d");
    let meshes = {}, floors = [];

    const load = (scene) => {
      meshes = Meshes.ofScene(scene, false);
      floors = Views.floors(scene);
    };

    const stood = (i, corner) => {
      const own = corner.p.map((v, k) => v * i.size[k]);
      own[2] += corner.side * i.shift;
      return Meshes.turned(i.pose.slice(3), own).map((v, k) => v + i.pose[k]);
    };

    const drawFloors = (p, colours) => {
      context.strokeStyle = css(colours.rule);
      context.lineWidth = p.scale;
      for (const f of floors) {
        const lines = Math.floor(f.reach / f.apart / 1.6);
        for (const [along, across] of [[f.first, f.second], [f.second, f.first]]) {
          for (let k = -lines; k <= lines; k++) {
            const ends = [-1, 1].map((s) => f.middle.map((m, a) => m + k * f.apart * across[a] + (s * f.reach * along[a]) / 1.6));
            stroke(p, ends);
          }
        }
      }
    };

    const stroke = (p, points) => {
      const [a, b] = points.map((point) => Views.projected(p.camera, point, p.width, p.height));
      if (!a || !b) return;
      context.beginPath();
      context.moveTo(a[0], a[1]);
      context.lineTo(b[0], b[1]);
      context.stroke();
    };

    const faces = (p, i, colours) => {
      const mesh = meshes[i.mesh], found = [];
      for (const corners of mesh.triangles) {
        const world = corners.map((c) => stood(i, c));
        const n = Meshes.unit(Meshes.cross(Meshes.minus(world[1], world[0]), Meshes.minus(world[2], world[0])));
        if (Meshes.dot(n, Meshes.minus(world[0], p.camera.eye)) >= 0) continue;
        const flat = world.map((w) => Views.projected(p.camera, w, p.width, p.height));
        if (flat.some((f) => !f)) continue;
        const middle = [0, 1, 2].map((k) => corners[0].p[k] + corners[1].p[k] + corners[2].p[k]);
        const other = mesh.round && middle[0] * middle[1] * middle[2] < 0 ? 0.42 : 0;
        const lit = 0.66 + 0.34 * Math.max(Meshes.dot(n, SUN), 0) + 0.1 * n[2];
        const ink = i.colour.map((c, k) => c + other * (colours.paper[k] - c));
        found.push({ flat, depth: (flat[0][2] + flat[1][2] + flat[2][2]) / 3, fill: css(ink, lit) });
      }
      return found.sort((a, b) => b.depth - a.depth);
    };

    const drawSolid = (p, i, colours) => {
      for (const { flat, fill } of faces(p, i, colours)) {
        context.fillStyle = context.strokeStyle = fill;
        context.lineWidth = 0.6;
        context.beginPath();
        flat.forEach(([x, y], k) => (k ? context.lineTo(x, y) : context.moveTo(x, y)));
        context.closePath();
        context.fill();
        context.stroke();
      }
      if (i.link) drawOutline(p, i, 2);
    };

    const drawOutline = (p, i, breadth) => {
      context.strokeStyle = css(i.colour);
      context.lineWidth = breadth * p.scale;
      for (const ends of meshes[i.mesh].edges) stroke(p, ends.map((c) => stood(i, c)));
    };

    const draw = (panels, colours) => {
      context.setTransform(1, 0, 0, 1, 0, 0);
      context.clearRect(0, 0, canvas.width, canvas.height);
      for (const p of panels) {
        context.save();
        context.beginPath();
        context.rect(p.x, p.y, p.width, p.height);
        context.clip();
        context.translate(p.x, p.y);
        drawFloors(p, colours);
        const depth = (i) => Meshes.dot(p.camera.ahead, Meshes.minus(i.pose.slice(0, 3), p.camera.eye));
        [...p.solids].sort((a, b) => depth(b) - depth(a)).forEach((i) => drawSolid(p, i, colours));
        p.outlines.forEach((i) => drawOutline(p, i, i.breadth));
        context.restore();
      }
    };

    return { name: "canvas", load, draw, drop: () => {} };
  };

  return { painter };
})();
