// Painter on a graphics processor: one canvas, one viewport for each panel, one call for each mesh.
const WebGL = (() => {
  const INSTANCE = `
    layout(location=4) in vec3 place; layout(location=5) in vec4 turn; layout(location=6) in vec4 size;
    layout(location=7) in vec4 colour;
    uniform mat4 view;
    vec3 turned(vec3 v){ return v + 2.0*cross(turn.yzw, cross(turn.yzw, v) + turn.x*v); }
    vec3 stood(vec3 p, float side){ return place + turned(p*size.xyz + vec3(0.0, 0.0, side*size.w)); }`;
  const SOLID = [`#version 300 es
    layout(location=0) in vec3 p; layout(location=1) in vec3 n; layout(location=2) in float side;${INSTANCE}
    uniform vec4 ground; uniform float shadow;
    out vec3 normal; out vec3 own; out vec4 ink;
    void main(){
      vec3 at = stood(p, side);
      normal = turned(n/size.xyz); own = p; ink = colour;
      if (shadow > 0.0) {
        float height = dot(ground.xyz, at) - ground.w;
        at -= ground.xyz*(height - shadow);
      }
      gl_Position = view*vec4(at, 1.0);
    }`, `#version 300 es
    precision highp float; in vec3 normal; in vec3 own; in vec4 ink; out vec4 result;
    uniform vec3 sun; uniform float shadow; uniform vec4 shade; uniform vec3 paper;
    void main(){
      if (shadow > 0.0) { result = shade; return; }
      float lit = 0.66 + 0.34*max(dot(normalize(normal), sun), 0.0) + 0.1*normal.z/length(normal);
      float other = ink.a > 0.5 && own.x*own.y*own.z < 0.0 ? 0.42 : 0.0;
      result = vec4(min(mix(ink.rgb, paper, other)*lit, 1.0), 1.0);
    }`];
  const LINE = [`#version 300 es
    layout(location=0) in vec4 a; layout(location=1) in vec4 b; layout(location=2) in vec2 corner;${INSTANCE}
    uniform vec2 panel; uniform float breadth; uniform float before;
    out vec4 ink;
    void main(){
      vec4 s = view*vec4(stood(a.xyz, a.w), 1.0), e = view*vec4(stood(b.xyz, b.w), 1.0);
      vec2 way = (e.xy/e.w - s.xy/s.w)*panel;
      way = length(way) > 1e-6 ? normalize(way) : vec2(1.0, 0.0);
      vec4 at = corner.x < 0.5 ? s : e;
      at.xy += (vec2(-way.y, way.x)*corner.y + way*(corner.x*2.0 - 1.0)*0.5)*breadth/panel*at.w;
      at.z -= before*at.w;
      gl_Position = at; ink = colour;
    }`, `#version 300 es
    precision highp float; in vec4 ink; out vec4 result;
    void main(){ result = vec4(ink.rgb, 1.0); }`];
  const FLOOR = [`#version 300 es
    layout(location=0) in vec2 p;
    uniform mat4 view; uniform vec3 middle; uniform vec3 first; uniform vec3 second; uniform float reach;
    out vec2 at; out vec2 part;
    void main(){
      vec3 w = middle + reach*(p.x*first + p.y*second);
      at = vec2(dot(w, first), dot(w, second)); part = p;
      gl_Position = view*vec4(w, 1.0);
    }`, `#version 300 es
    precision highp float; in vec2 at; in vec2 part; out vec4 result;
    uniform float apart; uniform vec3 rule;
    void main(){
      vec2 cell = at/apart, near = abs(fract(cell - 0.5) - 0.5)/max(fwidth(cell), 1e-6);
      float line = 1.0 - min(min(near.x, near.y), 1.0), fade = 1.0 - smoothstep(0.55, 1.0, length(part));
      result = vec4(rule, (0.16 + 0.84*line)*fade);
    }`];
  const SUN = Meshes.unit([-0.35, -0.5, 0.95]);

  const program = (gl, [vertex, fragment]) => {
    const made = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(made, shader);
    }
    gl.linkProgram(made);
    if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(`shader: ${gl.getProgramInfoLog(made)}`);
    return { made, at: new Proxy({}, { get: (_, name) => gl.getUniformLocation(made, name) }) };
  };

  /** Vertex array of one mesh: numbers of each vertex in groups of `parts`, and the instances of `own`. */
  const vertices = (gl, numbers, parts, own) => {
    const array = gl.createVertexArray(), buffer = gl.createBuffer(), stride = parts.reduce((a, b) => a + b, 0);
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(numbers), gl.STATIC_DRAW);
    attributes(gl, 0, parts, stride, 0);
    if (own) {
      gl.bindBuffer(gl.ARRAY_BUFFER, own);
      attributes(gl, 4, [3, 4, 4, 4], 15, 1);
    }
    return { array, count: numbers.length / stride };
  };

  const attributes = (gl, start, parts, stride, divisor) => {
    let offset = 0;
    parts.forEach((size, k) => {
      gl.enableVertexAttribArray(start + k);
      gl.vertexAttribPointer(start + k, size, gl.FLOAT, false, 4 * stride, 4 * offset);
      gl.vertexAttribDivisor(start + k, divisor);
      offset += size;
    });
  };

  const quads = (edges) => edges.flatMap(([a, b]) =>
    [[0, -1], [1, -1], [0, 1], [0, 1], [1, -1], [1, 1]].flatMap((corner) => [...a.p, a.side, ...b.p, b.side, ...corner]));

  /** Painter of a canvas, or null where there is no WebGL2. */
  const painter = (canvas) => {
    const gl = canvas.getContext("webgl2", { antialias: true, alpha: true, premultipliedAlpha: true });
    if (!gl) return null;
    const solid = program(gl, SOLID), line = program(gl, LINE), ground = program(gl, FLOOR);
    const own = gl.createBuffer(), square = vertices(gl, [-1, -1, 1, -1, -1, 1, -1, 1, 1, -1, 1, 1], [2]);
    let meshes = {}, floors = [], scene = null;

    const load = (next) => {
      scene = next;
      floors = Views.floors(scene);
      for (const { faces, lines } of Object.values(meshes)) [faces, lines].forEach((v) => gl.deleteVertexArray(v.array));
      meshes = Object.fromEntries(Object.entries(Meshes.ofScene(scene, true)).map(([name, mesh]) => [name, {
        round: mesh.round,
        faces: vertices(gl, mesh.triangles.flat().flatMap((c) => [...c.p, ...c.n, c.side]), [3, 3, 1], own),
        lines: vertices(gl, quads(mesh.edges), [4, 4, 2], own),
      }]));
    };

    const drawFloors = (view, colours) => {
      gl.useProgram(ground.made);
      gl.uniformMatrix4fv(ground.at.view, false, view);
      gl.uniform3fv(ground.at.rule, colours.rule);
      gl.depthMask(false);
      gl.bindVertexArray(square.array);
      for (const floor of floors) {
        for (const name of ["middle", "first", "second"]) gl.uniform3fv(ground.at[name], floor[name]);
        gl.uniform1f(ground.at.reach, floor.reach);
        gl.uniform1f(ground.at.apart, floor.apart);
        gl.drawArrays(gl.TRIANGLES, 0, 6);
      }
      gl.depthMask(true);
    };

    /** Draw instances mesh by mesh; `parts` says which vertices, `ink` what colour. */
    const drawAll = (list, parts, ink) => {
      const names = new Set(list.map((i) => i.mesh));
      for (const name of names) {
        const chosen = list.filter((i) => i.mesh === name), shape = meshes[name][parts];
        if (!shape.count) continue;
        const numbers = chosen.flatMap((i) => [...i.pose, ...i.size, i.shift, ...ink(i), meshes[name].round ? 1 : 0]);
        gl.bindVertexArray(shape.array);
        gl.bindBuffer(gl.ARRAY_BUFFER, own);
        gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(numbers), gl.DYNAMIC_DRAW);
        gl.drawArraysInstanced(gl.TRIANGLES, 0, shape.count, chosen.length);
      }
    };

    const drawSolids = (view, list, colours) => {
      gl.useProgram(solid.made);
      gl.uniformMatrix4fv(solid.at.view, false, view);
      gl.uniform3fv(solid.at.sun, SUN);
      gl.uniform3fv(solid.at.paper, colours.paper);
      const level = floors.find((f) => f.n[2] > 0.9);
      if (level) {
        gl.uniform4f(solid.at.ground, ...level.n, Meshes.dot(level.n, level.middle));
        gl.uniform1f(solid.at.shadow, 5e-4 * level.reach);
        gl.uniform4f(solid.at.shade, ...colours.shade, 1);
        drawAll(list, "faces", (i) => i.colour);
      }
      gl.uniform1f(solid.at.shadow, 0);
      drawAll(list, "faces", (i) => i.colour);
    };

    const drawOutlines = (view, list, panel) => {
      for (const breadth of new Set(list.map((i) => i.breadth))) {
        const own = list.filter((i) => i.breadth === breadth);
        drawLines(view, own, panel, breadth * panel.scale, 4e-4 - 1e-5 * breadth, (i) => i.colour);
      }
    };

    const drawLines = (view, list, panel, breadth, before, ink) => {
      gl.useProgram(line.made);
      gl.uniformMatrix4fv(line.at.view, false, view);
      gl.uniform2f(line.at.panel, panel.width, panel.height);
      gl.uniform1f(line.at.breadth, breadth);
      gl.uniform1f(line.at.before, before);
      drawAll(list, "lines", ink);
    };

    /** Panels {x, y, width, height, camera, solids, outlines} in device pixels from the upper left corner. */
    const draw = (panels, colours) => {
      gl.disable(gl.SCISSOR_TEST);
      gl.clearColor(0, 0, 0, 0);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      gl.enable(gl.DEPTH_TEST);
      gl.enable(gl.SCISSOR_TEST);
      gl.enable(gl.BLEND);
      gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
      for (const p of panels) {
        const lower = canvas.height - p.y - p.height, view = Views.matrix(p.camera, 2 * Math.max(...scene.size));
        gl.viewport(p.x, lower, p.width, p.height);
        gl.scissor(p.x, lower, p.width, p.height);
        drawFloors(view, colours);
        drawSolids(view, p.solids, colours);
        const dark = (i) => (i.link ? i.colour : i.colour.map((c, k) => 0.45 * c + 0.55 * colours.ink[k]));
        drawLines(view, p.solids.filter((i) => i.link || !meshes[i.mesh].round), p, 1.6 * p.scale, 2e-4, dark);
        drawOutlines(view, p.outlines, p);
      }
    };

    const drop = () => gl.getExtension("WEBGL_lose_context")?.loseContext();
    return { name: "webgl", load, draw, drop };
  };

  return { painter };
})();
