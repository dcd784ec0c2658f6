// Blocks of numbers as reports/packing.py writes them, and the motions in them.
const Blocks = (() => {
  const VERSION = 1, MISSING = -32768;

  const bytes = (text) => Uint8Array.fromBase64
    ? Uint8Array.fromBase64(text)
    : Uint8Array.from(atob(text), (c) => c.charCodeAt(0));

  const inflated = async (data) => {
    const stream = new Blob([data]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  };

  /** Header and integer arrays of a block; each array is a list of rows. */
  const read = async (text) => {
    const data = await inflated(bytes(text.trim()));
    let start = 4 + new DataView(data.buffer).getUint32(0, true);
    const header = JSON.parse(new TextDecoder().decode(data.subarray(4, start)));
    if (header.version !== VERSION) throw new Error(`replay of version ${header.version}; this page reads ${VERSION}`);
    const arrays = header.arrays.map(([rows, columns, width]) => {
      const whole = summed(data.subarray(start, start + rows * columns * width), rows, columns, width);
      start += rows * columns * width;
      return whole;
    });
    return { header, arrays };
  };

  /** Rows of integers from byte planes of their differences; sums wrap as the differences did. */
  const summed = (planes, rows, columns, width) => {
    const count = rows * columns, list = [];
    for (let row = 0; row < rows; row++) {
      const out = width === 2 ? new Int16Array(columns) : new Int32Array(columns);
      let sum = 0;
      for (let k = 0; k < columns; k++) {
        let step = 0;
        for (let b = 0; b < width; b++) step |= planes[b * count + row * columns + k] << (8 * b);
        sum = (sum + step) | 0;
        out[k] = sum;
      }
      list.push(out);
    }
    return list;
  };

  /** A scene to show: its header, and the motion of every engine at the times that were kept. */
  const scene = async (text) => {
    const { header, arrays } = await read(text);
    const engines = header.engines.map((told, k) => {
      const [ticks, x, q] = arrays.slice(3 * k, 3 * k + 3);
      return { ...told, ...motion(header, ticks[0], x, q) };
    });
    return { ...header, engines };
  };

  /** Times [s], positions x[body][axis][frame] [m] and unit quaternions q[body][component][frame] of the bodies
   *  that move; a body without a place has NaN there. */
  const motion = (header, ticks, x, q) => {
    const times = Float64Array.from(ticks, (n) => n * header.tick);
    const length = (n, axis) => (n === MISSING ? NaN : header.centre[axis] + n * header.quantum);
    const places = header.animated.map((_, k) => [0, 1, 2].map((a) => Float64Array.from(x[3 * k + a], (n) => length(n, a))));
    const turns = header.animated.map((body) => {
      const row = header.turning.indexOf(body);
      return row < 0
        ? header.bodies[body].q.map((c) => new Float64Array(times.length).fill(c))
        : [0, 1, 2, 3].map((c) => Float64Array.from(q[4 * row + c], (n) => n * header.turn));
    });
    const left = places.some((axes) => axes.some((path, a) => edge(path, header, a)));
    return { t: times, x: places, q: turns, left };
  };

  /** Whether a body goes beyond what the quanta can say: it is drawn at the edge. */
  const edge = (path, header, axis) => path.some((v) => Math.abs(v - header.centre[axis]) > 32766.5 * header.quantum);

  /** Poses of all bodies at a time: [x, y, z, w, i, j, k] each.  Straight lines between frames; beyond the last
   *  frame the last. */
  const poses = (scene, engine, time) => {
    const t = engine.t;
    let low = 0, high = t.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (t[middle] <= time) low = middle; else high = middle;
    }
    const part = high === low ? 0 : Math.min(Math.max((time - t[low]) / (t[high] - t[low]), 0), 1);
    const all = scene.bodies.map((b) => [...b.x, ...b.q]);
    scene.animated.forEach((body, k) => {
      const out = all[body];
      for (let a = 0; a < 3; a++) out[a] = (1 - part) * engine.x[k][a][low] + part * engine.x[k][a][high];
      let size = 0;
      for (let c = 0; c < 4; c++) {
        out[3 + c] = (1 - part) * engine.q[k][c][low] + part * engine.q[k][c][high];
        size += out[3 + c] ** 2;
      }
      for (let c = 3; c < 7; c++) out[c] /= Math.sqrt(size);
    });
    return all;
  };

  return { read, scene, poses };
})();
