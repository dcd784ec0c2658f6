// Unit meshes of the shapes, and bodies as instances of them: a vertex p of a mesh stands at
// size * p + side * shift * z in the body frame, so that one ball serves for every sphere and every capsule.
const Meshes = (() => {
  const circle = (n) => Array.from({ length: n + 1 }, (_, k) => [Math.cos((2 * Math.PI * k) / n), Math.sin((2 * Math.PI * k) / n)]);

  /** Triangles as [corner, corner, corner], a corner being {p, n, side}; edges as [{p, side}, {p, side}]. */
  const ball = (around, along) => {
    const rings = [];
    for (let k = 0; k <= along; k++) {
      const polar = (Math.PI * k) / along, side = 2 * k <= along ? 1 : -1;
      rings.push({ z: Math.cos(polar), r: Math.sin(polar), side });
      if (2 * k === along) rings.push({ z: 0, r: 1, side: -1 });
    }
    const at = (ring, [c, s]) => {
      const p = [ring.r * c, ring.r * s, ring.z];
      return { p, n: p, side: ring.side };
    };
    const turn = circle(around), triangles = [], edges = [];
    for (let k = 0; k + 1 < rings.length; k++) {
      for (let j = 0; j < around; j++) {
        const [a, b] = [at(rings[k], turn[j]), at(rings[k], turn[j + 1])];
        const [c, d] = [at(rings[k + 1], turn[j]), at(rings[k + 1], turn[j + 1])];
        if (rings[k].r > 1e-9) triangles.push([a, c, b]);
        if (rings[k + 1].r > 1e-9) triangles.push([b, c, d]);
      }
    }
    for (let k = 0; k + 1 < rings.length; k++) {
      for (const j of [0, 1, 2, 3]) {
        const way = turn[(j * around) / 4];
        edges.push([at(rings[k], way), at(rings[k + 1], way)]);
      }
    }
    for (const side of [1, -1]) {
      for (let j = 0; j < around; j++) edges.push([at({ z: 0, r: 1, side }, turn[j]), at({ z: 0, r: 1, side }, turn[j + 1])]);
    }
    return { triangles, edges, round: true };
  };

  const tube = (around) => {
    const turn = circle(around), triangles = [], edges = [];
    for (let j = 0; j < around; j++) {
      const [[c, s], [d, e]] = [turn[j], turn[j + 1]];
      const at = (x, y, z, n) => ({ p: [x, y, z], n, side: 0 });
      const wall = [at(c, s, 1, [c, s, 0]), at(c, s, -1, [c, s, 0]), at(d, e, 1, [d, e, 0]), at(d, e, -1, [d, e, 0])];
      triangles.push([wall[0], wall[1], wall[2]], [wall[2], wall[1], wall[3]]);
      for (const z of [1, -1]) {
        const lid = [at(0, 0, z, [0, 0, z]), at(c, s, z, [0, 0, z]), at(d, e, z, [0, 0, z])];
        triangles.push(z > 0 ? lid : [lid[0], lid[2], lid[1]]);
        edges.push([lid[1], lid[2]]);
      }
      if (j % (around / 4) === 0) edges.push([wall[0], wall[1]]);
    }
    return { triangles, edges, round: true };
  };

  /** A closed mesh with flat faces; edges where two faces meet at an angle. */
  const faceted = (vertices, triangles) => {
    const faces = triangles.map((t) => {
      const [a, b, c] = t.map((i) => vertices[i]);
      const n = unit(cross(minus(b, a), minus(c, a)));
      return { t, n, corners: [a, b, c].map((p) => ({ p, n, side: 0 })) };
    });
    const seen = new Map(), edges = [];
    for (const { t, n } of faces) {
      for (let k = 0; k < 3; k++) {
        const [i, j] = [t[k], t[(k + 1) % 3]], other = seen.get(`${j},${i}`);
        if (other && dot(n, other) < 0.999) edges.push([{ p: vertices[i], side: 0 }, { p: vertices[j], side: 0 }]);
        seen.set(`${i},${j}`, n);
      }
    }
    return { triangles: faces.map((f) => f.corners), edges, round: false };
  };

  const box = () => {
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((k) => [k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1]);
    return faceted(corners, [[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4], [2, 6, 3], [3, 6, 7],
      [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5]]);
  };

  /** A straight piece of unit length along z, for rods, strings and springs. */
  const stick = () => ({ triangles: [], edges: [[{ p: [0, 0, 0], side: 0 }, { p: [0, 0, 1], side: 0 }]], round: false });

  const minus = (a, b) => a.map((v, k) => v - b[k]);
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const unit = (a) => a.map((v) => v / (Math.hypot(...a) || 1));
  /** The vector v turned by the quaternion q = [w, x, y, z]. */
  const turned = (q, v) => {
    const u = [q[1], q[2], q[3]], c = cross(u, v), d = cross(u, [c[0] + q[0] * v[0], c[1] + q[0] * v[1], c[2] + q[0] * v[2]]);
    return [v[0] + 2 * d[0], v[1] + 2 * d[1], v[2] + 2 * d[2]];
  };

  /** What bodies are drawn as: name of a mesh, size, shift; half-spaces have none. */
  const drawnAs = (shape, k) => {
    switch (shape.kind) {
      case "Sphere": return { mesh: "ball", size: [shape.radius, shape.radius, shape.radius], shift: 0 };
      case "Capsule": return { mesh: "ball", size: [shape.radius, shape.radius, shape.radius], shift: shape.length / 2 };
      case "Cylinder": return { mesh: "tube", size: [shape.radius, shape.radius, shape.length / 2], shift: 0 };
      case "Box": return { mesh: "box", size: shape.size.map((s) => s / 2), shift: 0 };
      case "Mesh": return { mesh: `mesh${k}`, size: [1, 1, 1], shift: 0 };
      default: return null;
    }
  };

  /** Every mesh a scene needs; `fine` for a graphics processor, coarse for drawing by hand. */
  const ofScene = (scene, fine) => {
    const meshes = { ball: fine ? ball(32, 20) : ball(12, 8), tube: tube(fine ? 40 : 16), box: box(), stick: stick() };
    scene.bodies.forEach((body, k) => {
      if (body.shape.kind === "Mesh") meshes[`mesh${k}`] = faceted(body.shape.vertices, body.shape.triangles);
    });
    return meshes;
  };

  return { ofScene, drawnAs, turned, minus, dot, cross, unit };
})();
