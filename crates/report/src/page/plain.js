// The plain way to draw the scene, for machines without a graphics card: corners are moved and lit here, so that the
// software renderer only fills triangles.

const PLAIN_VERTEX = `#version 300 es
layout(location=0) in vec3 position; layout(location=1) in vec4 colour;
uniform mat4 camera;
uniform vec4 over;
out vec4 tint;
void main() {
  gl_Position = camera * vec4(position, 1.0);
  tint = vec4(mix(colour.rgb, over.rgb, over.a), colour.a);
}`;

const PLAIN_PIXEL = `#version 300 es
precision mediump float;
in vec4 tint;
out vec4 result;
void main() { result = tint; }`;

// Light from below, and of the sun; that of the sky is a colour of the theme.
const [BELOW, SUNLIGHT] = [[0.3, 0.28, 0.27], [1.02, 0.97, 0.9]];
// Bytes of linear intensities from 0 to 1.
const GAMMA = Uint8Array.from({ length: 4096 }, (_, i) => 255 * (i / 4095) ** (1 / 2.2));
const linear = (rgb) => rgb.map((c) => c ** 2.2);
// Bytes of a corner: position f32 [3], colour u8 [4].
const CORNER = 16;

// Throws points along the sun onto the ground.
const flatten = ([x, y, z]) => [1, 0, 0, 0, 0, 1, 0, 0, -x / z, -y / z, 0, 0, 0, 0, 0.002, 1];

// Triangles of a body's figure at most, and of ghosts and shadows; the first cell of a coarser one, in heights of the robot.
const [MANY, FEW, CELL] = [4500, 2600, 1 / 52];

// The same surface with one corner for each cell of a grid.
function coarse({ vertices, indices }, cell) {
  const [cells, sums, faces, known] = [new Map(), [], [], new Set()];
  const at = new Uint32Array(vertices.length / 9);
  for (let i = 0; i < at.length; i++) {
    let key = 0;
    for (let k = 0; k < 3; k++) key = key * 8192 + Math.round(vertices[9 * i + k] / cell) + 4096;
    if (!cells.has(key)) cells.set(key, sums.push([0, 0, 0, 0, 0, 0, 0]) - 1);
    at[i] = cells.get(key);
    const sum = sums[at[i]];
    for (let k = 0; k < 3; k++) {
      sum[k] += vertices[9 * i + k];
      sum[3 + k] += vertices[9 * i + 6 + k];
    }
    sum[6] += 1;
  }
  for (let i = 0; i < indices.length; i += 3) {
    let [a, b, c] = [at[indices[i]], at[indices[i + 1]], at[indices[i + 2]]];
    if (a === b || b === c || a === c) continue;
    while (a > b || a > c) [a, b, c] = [b, c, a];
    const name = (a * sums.length + b) * sums.length + c;
    if (known.has(name)) continue;
    known.add(name);
    faces.push(a, b, c);
  }
  const points = Float32Array.from(sums.flatMap((sum) => [0, 1, 2].map((k) => sum[k] / sum[6])));
  const [normals, found, out] = [cornerNormals(points, faces), new Map(), { vertices: [], indices: [] }];
  faces.forEach((point, i) => {
    const normal = normals.subarray(3 * i, 3 * i + 3);
    const name = `${point} ${Array.from(normal, (c) => Math.round(10 * c))}`;
    if (!found.has(name)) {
      found.set(name, out.vertices.length / 9);
      out.vertices.push(...points.subarray(3 * point, 3 * point + 3), ...normal, ...sums[point].slice(3, 6).map((c) => c / sums[point][6]));
    }
    out.indices.push(found.get(name));
  });
  return out;
}

function reduced(parts, height, most) {
  const triangles = () => parts.reduce((sum, part) => sum + part.indices.length / 3, 0);
  for (let cell = CELL * height; triangles() > most; cell *= 1.15) parts = parts.map((part) => coarse(part, cell));
  return parts;
}

// The meshes of a figure's bodies, and those of its ghost and shadow.
function figureMeshes(character) {
  const fine = reduced(bodyMeshes(character, PLAIN_BODY, 0.5), character.height, MANY);
  const round = !character.geoms.some((geom) => geom.shape === "mesh");
  return [fine, round ? bodyMeshes(character, PLAIN_BODY, 0.25) : reduced(fine, character.height, FEW)];
}

// Meshes in one: positions, normals and linear colours of corners, the end of each mesh's corners, and indices.
function joined(meshes) {
  const count = meshes.reduce((sum, part) => sum + part.vertices.length / 9, 0);
  const [places, normals, colours] = [0, 1, 2].map(() => new Float32Array(3 * count));
  const [ends, indices] = [[], []];
  let first = 0;
  for (const part of meshes) {
    part.vertices.forEach((value, i) => {
      const [corner, k] = [3 * (first + Math.floor(i / 9)), i % 9];
      if (k < 3) places[corner + k] = value;
      else if (k < 6) normals[corner + k - 3] = value;
      else colours[corner + k - 6] = value ** 2.2;
    });
    const [vector, last] = [(list, i) => list.subarray(3 * i, 3 * i + 3), indices.length];
    for (const i of part.indices) indices.push(first + i);
    // Corners in the order that their normals say, so that backs are not drawn.
    for (let i = last; i < indices.length; i += 3) {
      const [a, b, c] = indices.slice(i, i + 3);
      const [p, q, r] = [a, b, c].map((index) => vector(places, index));
      const across = cross([0, 1, 2].map((k) => q[k] - p[k]), [0, 1, 2].map((k) => r[k] - p[k]));
      if ([a, b, c].reduce((sum, index) => sum + dot(across, vector(normals, index)), 0) < 0) [indices[i + 1], indices[i + 2]] = [c, b];
    }
    first += part.vertices.length / 9;
    ends.push(first);
  }
  return { places, normals, colours, ends, indices };
}

// The ground: rings of radius 1 as triangles.
const [RINGS, SPOKES] = [6, 32];
function ringIndices() {
  const out = [];
  for (let ring = 1; ring <= RINGS; ring++) {
    for (let k = 0; k < SPOKES; k++) {
      const [here, next] = [1 + (ring - 1) * SPOKES + k, 1 + (ring - 1) * SPOKES + (k + 1) % SPOKES];
      if (ring === 1) out.push(0, here, next);
      else out.push(here - SPOKES, here, next, here - SPOKES, next, next - SPOKES);
    }
  }
  return out;
}

class PlainStage {
  constructor(gl, { program, uniforms }) {
    Object.assign(this, { gl, program, uniforms });
    this.meshes = new Map();
    [this.disc, this.lines] = [this.slot(ringIndices()), this.slot(null)];
  }

  // Corners that are written for every picture; without indices they are lines.
  slot(indices) {
    const gl = this.gl;
    const slot = { vao: gl.createVertexArray(), buffer: gl.createBuffer(), count: indices?.length ?? 0 };
    gl.bindVertexArray(slot.vao);
    gl.bindBuffer(gl.ARRAY_BUFFER, slot.buffer);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, CORNER, 0);
    gl.enableVertexAttribArray(1);
    gl.vertexAttribPointer(1, 4, gl.UNSIGNED_BYTE, true, CORNER, 12);
    if (indices) {
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(indices), gl.STATIC_DRAW);
    }
    gl.bindVertexArray(null);
    return slot;
  }

  room(slot, corners) {
    if ((slot.bytes?.byteLength ?? 0) >= corners * CORNER) return;
    slot.bytes = new ArrayBuffer(corners * CORNER);
    [slot.places, slot.colours] = [new Float32Array(slot.bytes), new Uint8Array(slot.bytes)];
  }

  send(slot, corners) {
    const gl = this.gl;
    gl.bindBuffer(gl.ARRAY_BUFFER, slot.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, new Uint8Array(slot.bytes, 0, corners * CORNER), gl.STREAM_DRAW);
  }

  draws(slot, kind) {
    const gl = this.gl;
    gl.bindVertexArray(slot.vao);
    if (kind === gl.LINES) gl.drawArrays(kind, 0, slot.count);
    else gl.drawElements(kind, slot.count, gl.UNSIGNED_INT, 0);
  }

  // Meshes by a name, each with a slot for each time that it is in the picture.
  mesh(name, make) {
    if (!this.meshes.has(name)) this.meshes.set(name, make().map((parts) => ({ ...joined(parts), slots: [], used: 0 })));
    return this.meshes.get(name);
  }

  // Moves and lights the corners of a mesh: one matrix for each of its bodies. A tint replaces colours and heat.
  lit(mesh, pose, { heat, tint, alpha = 1 }, { sun, sky }) {
    const { places: p, normals: n, colours: c, ends } = mesh;
    const slot = (mesh.slots[mesh.used++] ??= this.slot(mesh.indices));
    this.room(slot, p.length / 3);
    const [sx, sy, sz] = sun;
    const own = tint && linear(tint);
    let at = 0;
    ends.forEach((end, body) => {
      const m = pose[body];
      const share = own ? 1 : heat ? heat[body][3] : 0;
      const over = own ?? (share ? linear(heat[body].slice(0, 3)) : [0, 0, 0]);
      for (; at < end; at++) {
        const i = 3 * at;
        const [x, y, z, u, v, w] = [p[i], p[i + 1], p[i + 2], n[i], n[i + 1], n[i + 2]];
        slot.places[4 * at] = m[0] * x + m[4] * y + m[8] * z + m[12];
        slot.places[4 * at + 1] = m[1] * x + m[5] * y + m[9] * z + m[13];
        slot.places[4 * at + 2] = m[2] * x + m[6] * y + m[10] * z + m[14];
        const [nx, ny, nz] = [m[0] * u + m[4] * v + m[8] * w, m[1] * u + m[5] * v + m[9] * w, m[2] * u + m[6] * v + m[10] * w];
        const [up, direct] = [nz * 0.5 + 0.5, Math.max(nx * sx + ny * sy + nz * sz, 0)];
        for (let k = 0; k < 3; k++) {
          const light = BELOW[k] + (sky[k] - BELOW[k]) * up + SUNLIGHT[k] * direct;
          slot.colours[CORNER * at + 12 + k] = GAMMA[Math.min((c[i + k] + (over[k] - c[i + k]) * share) * light * 4095, 4095) | 0];
        }
        slot.colours[CORNER * at + 15] = 255 * alpha;
      }
    });
    this.send(slot, at);
    return slot;
  }

  drawGround({ floor, line, paper }, [x, y], reach) {
    const write = (slot, i, a, b, z, colour) => {
      const away = Math.min(Math.max((Math.hypot(a - x, b - y) / reach - 0.35) / 0.65, 0), 1);
      const fade = away * away * (3 - 2 * away);
      slot.places.set([a, b, z], 4 * i);
      slot.colours.set([...colour.map((c, k) => 255 * (c + (paper[k] - c) * fade)), 255], CORNER * i + 12);
    };
    const { disc, lines } = this;
    this.room(disc, 1 + RINGS * SPOKES);
    write(disc, 0, x, y, 0, floor);
    for (let i = 0; i < RINGS * SPOKES; i++) {
      const [r, a] = [(reach * (1 + Math.floor(i / SPOKES))) / RINGS, (2 * Math.PI * (i % SPOKES)) / SPOKES];
      write(disc, 1 + i, x + r * Math.cos(a), y + r * Math.sin(a), 0, floor);
    }
    this.send(disc, 1 + RINGS * SPOKES);
    this.draws(disc, this.gl.TRIANGLES);
    // Lines a metre apart, a metre long, as far as they are seen.
    const half = Math.min(Math.ceil(reach), 30);
    this.room(lines, 8 * half * (2 * half + 1));
    lines.count = 0;
    for (const turned of [false, true]) {
      const [u, v] = turned ? [y, x].map(Math.round) : [x, y].map(Math.round);
      for (let i = u - half; i <= u + half; i++) {
        for (let j = v - half; j < v + half; j++) {
          if (Math.hypot(i - u, j + 0.5 - v) > reach) continue;
          for (const k of [j, j + 1]) write(lines, lines.count++, turned ? k : i, turned ? i : k, 0.001, line);
        }
      }
    }
    this.send(lines, lines.count);
    this.draws(lines, this.gl.LINES);
  }

  // As `Stage.draw`.
  draw(view, camera, items, colours, sun, marks) {
    const gl = this.gl;
    const { uniforms: u } = this;
    const seen = camera.matrix(view.width / view.height);
    const light = { sun, sky: colours.sky };
    for (const mesh of [...this.meshes.values()].flat()) mesh.used = 0;
    const figures = items.map(({ character, pose, ghost, tint, heat }) => {
      const [fine, few] = this.mesh(character, () => figureMeshes(character));
      const look = { heat, tint: ghost ? tint ?? colours.ghost : null, alpha: ghost === "glass" ? GLASS : 1 };
      if (ghost === "glass") return { glass: this.lit(few, pose, look, light) };
      return { solid: this.lit(fine, pose, look, light), shadow: this.lit(few, pose, look, light) };
    });
    const drawAll = (kind) => figures.forEach((figure) => figure[kind] && this.draws(figure[kind], gl.TRIANGLES));
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(view.x, view.y, view.width, view.height);
    gl.viewport(view.x, view.y, view.width, view.height);
    gl.clearColor(...colours.paper, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.useProgram(this.program);
    gl.uniformMatrix4fv(u.camera, false, seen);
    gl.uniform4f(u.over, 0, 0, 0, 0);
    gl.disable(gl.DEPTH_TEST);
    this.drawGround(colours, camera.target, camera.distance * 2.6);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.CULL_FACE);
    drawAll("solid");
    // Figures flattened onto the ground are their shadow.
    gl.uniform4f(u.over, ...colours.floor.map((c) => c * (1 - 0.7 * (1 - colours.shadow))), 1);
    gl.uniformMatrix4fv(u.camera, false, multiply(seen, flatten(sun)));
    drawAll("shadow");
    gl.uniformMatrix4fv(u.camera, false, seen);
    gl.uniform4f(u.over, 0, 0, 0, 0);
    drawGlass(gl, figures.filter(({ glass }) => glass), ({ glass }) => this.draws(glass, gl.TRIANGLES));
    this.drawMarks(marks, light);
    gl.disable(gl.CULL_FACE);
    gl.bindVertexArray(null);
  }

  drawMarks(marks, light) {
    const gl = this.gl;
    gl.enable(gl.BLEND);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE);
    for (const mark of marks) {
      const [mesh] = this.mesh(mark.kind, () => [[markMeshes()[mark.kind]]]);
      if (mark.over) gl.disable(gl.DEPTH_TEST);
      this.draws(this.lit(mesh, [markMatrix(mark)], { tint: mark.colour, alpha: mark.alpha }, light), gl.TRIANGLES);
      gl.enable(gl.DEPTH_TEST);
    }
    gl.disable(gl.BLEND);
  }
}
