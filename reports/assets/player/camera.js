// Where the scene is looked at from, and what is drawn in one panel.
const Views = (() => {
  // half the angle of view, and least size of a body over the picture
  const OPENING = Math.tan((15 * Math.PI) / 180), NARROW = 1 / 80;

  const camera = (planar) => ({ azimuth: planar ? -8 : -32, elevation: planar ? 9 : 20, zoom: 1 });

  /** Axes and distance from which the whole box is seen in a panel of that shape (width / height) below `top`, the
   *  share of its height that names take. */
  const placed = (scene, view, aspect, top) => {
    const [a, e] = [(view.azimuth * Math.PI) / 180, (view.elevation * Math.PI) / 180];
    const right = [Math.cos(a), Math.sin(a), 0];
    const ahead = [-Math.sin(a) * Math.cos(e), Math.cos(a) * Math.cos(e), -Math.sin(e)];
    const up = Meshes.cross(right, ahead);
    let distance = 0;
    for (let k = 0; k < 8; k++) {
      const corner = scene.size.map((s, axis) => (k & (1 << axis) ? s / 2 : -s / 2));
      const [x, y, z] = [right, up, ahead].map((axis) => Math.abs(Meshes.dot(axis, corner)));
      distance = Math.max(distance, x / (0.86 * OPENING * aspect) + z, y / (0.94 * (1 - top) * OPENING) + z);
    }
    distance /= view.zoom;
    const eye = scene.centre.map((c, k) => c - distance * ahead[k] + top * OPENING * distance * up[k]);
    return { right, up, ahead, eye, distance, aspect };
  };

  /** Column-major matrix from the world to clip space. */
  const matrix = (c, far) => {
    const near = Math.max(c.distance - far, 0.02 * c.distance), end = c.distance + 4 * far;
    const [fx, fy] = [1 / (OPENING * c.aspect), 1 / OPENING];
    const a = (end + near) / (end - near), b = (-2 * end * near) / (end - near);
    const rows = [c.right.map((v) => v * fx), c.up.map((v) => v * fy), c.ahead.map((v) => v * a), c.ahead];
    const shift = rows.map((row) => -Meshes.dot(row, c.eye));
    shift[2] += b;
    return Float32Array.from([0, 1, 2].flatMap((k) => rows.map((row) => row[k])).concat(shift));
  };

  /** Point of the world -> [x, y] in a panel of that size, and depth; null behind the eye. */
  const projected = (c, p, width, height) => {
    const away = Meshes.minus(p, c.eye), depth = Meshes.dot(c.ahead, away);
    if (depth < 1e-3 * c.distance) return null;
    const scale = height / (2 * OPENING * depth);
    return [width / 2 + scale * Meshes.dot(c.right, away), height / 2 - scale * Meshes.dot(c.up, away), depth];
  };

  /** How many times larger than they are small bodies are drawn, so that they can be seen at all. */
  const enlarged = (scene) => {
    const sizes = scene.animated.map((k) => Meshes.drawnAs(scene.bodies[k].shape, k)).filter(Boolean)
      .map((d) => (d.mesh.startsWith("mesh") ? Infinity : Math.max(...d.size) + d.shift));
    return Math.max(1, (NARROW * Math.max(...scene.size)) / Math.max(...sizes));
  };

  /** Instances to draw of one engine at a time: bodies and links, each with its place, size and colour. */
  const instances = (scene, engine, time, colours, larger) => {
    const poses = Blocks.poses(scene, engine, time), list = [];
    scene.bodies.forEach((body, k) => {
      const as = Meshes.drawnAs(body.shape, k);
      if (!as || poses[k].some(Number.isNaN)) return;
      const grown = scene.animated.includes(k) ? larger : 1;
      list.push({ mesh: as.mesh, pose: poses[k], size: as.size.map((s) => s * grown), shift: as.shift * grown,
        colour: body.fixed ? colours.fixed : colours.own, fixed: body.fixed });
    });
    for (const link of scene.links) list.push(stick(poses, link, colours));
    return list;
  };

  const stick = (poses, link, colours) => {
    const end = (k, anchor) => Meshes.turned(poses[k].slice(3), anchor).map((v, axis) => v + poses[k][axis]);
    const [a, b] = [end(link.a, link.p), end(link.b, link.q)];
    const along = Meshes.minus(b, a), length = Math.hypot(...along) || 1e-12, [x, y, z] = along.map((v) => v / length);
    // the turn that takes z to the direction: half-way quaternion; straight down it is half a turn about x
    const q = z > -0.999999 ? Meshes.unit([1 + z, -y, x, 0]) : [0, 1, 0, 0];
    const slack = link.kind === "Tether" && length < 0.999 * link.length;
    return { mesh: "stick", pose: [...a, ...q], size: [1, 1, length], shift: 0, colour: slack ? colours.fixed : colours.own, link: true };
  };

  /** Half-spaces as squares with a grid: middle, two axes along them, distance of the lines. */
  const floors = (scene) => {
    const reach = Math.max(...scene.size);
    const power = 10 ** Math.floor(Math.log10(reach / 4)), apart = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= reach / 6);
    return scene.bodies.filter((b) => b.shape.kind === "HalfSpace").map((body) => {
      const n = Meshes.turned(body.q, body.shape.normal);
      const off = Meshes.dot(n, Meshes.minus(scene.centre, body.x));
      const first = Meshes.unit(Math.abs(n[0]) < 0.9 ? Meshes.cross([0, 1, 0], n) : Meshes.cross(n, [0, 0, 1]));
      const second = Meshes.cross(n, first);
      const snapped = scene.centre.map((c, k) => c - off * n[k]);
      return { n, middle: snapped, first, second, apart, reach: 1.6 * reach };
    });
  };

  return { camera, placed, matrix, projected, enlarged, instances, floors };
})();
