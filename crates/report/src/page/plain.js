// A plain way to draw the scene, for machines without a graphics card: shaders, ground and coarse figures.

// The plain way, for machines without a graphics card: colours of corners only, and a figure in one call.
const plainVertex = (bodies) => `#version 300 es
layout(location=0) in vec3 position; layout(location=1) in vec3 normal; layout(location=2) in vec3 colour;
layout(location=3) in float body;
uniform mat4 camera, models[${bodies}];
uniform vec4 heats[${bodies}];
uniform vec3 sun, sky, floorTint, paper, line, ghost, focus;
uniform float ghostly, ground, reach;
out vec3 tint;
void main() {
  mat4 model = models[int(body)];
  vec4 heat = heats[int(body)], w = model * vec4(position, 1.0);
  gl_Position = camera * w;
  if (ground > 0.5) {
    float away = distance(w.xy, focus.xy);
    tint = mix(mix(floorTint, line, colour.r), paper, smoothstep(reach * 0.35, reach, away));
    return;
  }
  vec3 n = normalize(mat3(model) * normal);
  vec3 base = pow(ghostly > 0.5 ? ghost : mix(colour, heat.rgb, heat.a), vec3(2.2));
  vec3 c = base * (mix(vec3(0.30, 0.28, 0.27), sky, n.z * 0.5 + 0.5) + max(dot(n, sun), 0.0) * vec3(1.02, 0.97, 0.9));
  tint = ghostly > 1.5 ? ghost : pow(c, vec3(1.0 / 2.2));
}`;

const PLAIN = `#version 300 es
precision mediump float;
in vec3 tint;
uniform float alpha;
out vec4 result;
void main() { result = vec4(tint, alpha); }`;

// The ground of the plain way: rings of radius 1, and lines a metre apart.
function plainGround() {
  const [rings, corners, lines] = [6, 32, 12];
  const out = { vertices: [0, 0, 0, 0, 0, 1, 0, 0, 0], indices: [], lines: { vertices: [], indices: [] } };
  for (let ring = 1; ring <= rings; ring++) {
    for (let k = 0; k < corners; k++) {
      const [r, a] = [ring / rings, (2 * Math.PI * k) / corners];
      out.vertices.push(r * Math.cos(a), r * Math.sin(a), 0, 0, 0, 1, 0, 0, 0);
      const [here, next] = [1 + (ring - 1) * corners + k, 1 + (ring - 1) * corners + (k + 1) % corners];
      if (ring === 1) out.indices.push(0, here, next);
      else out.indices.push(here - corners, here, next, here - corners, next, next - corners);
    }
  }
  const { vertices, indices } = out.lines;
  for (let i = -lines; i <= lines; i++) {
    for (let j = -lines; j < lines; j++) {
      for (const [x, y] of [[i, j], [i, j + 1], [j, i], [j + 1, i]]) {
        indices.push(vertices.length / 9);
        vertices.push(x, y, 0.001, 0, 0, 1, 1, 1, 1);
      }
    }
  }
  return out;
}

// Throws points along the sun onto the ground.
const flatten = ([x, y, z]) => [1, 0, 0, 0, 0, 1, 0, 0, -x / z, -y / z, 0, 0, 0, 0, 0.002, 1];

// Bodies of more indices than this are coarser in the plain way: cells of the robot's height.
const [MANY, COARSE] = [3000, 55];

// The same mesh with one corner for each cell of a grid and each side that corners look to: for machines without a graphics card.
function coarse({ vertices, indices }, cell) {
  const [places, sums, out] = [new Map(), [], { vertices: [], indices: [] }];
  const at = Array.from({ length: vertices.length / 9 }, (_, i) => {
    const v = vertices.slice(i * 9, i * 9 + 9);
    const side = [0, 1, 2].reduce((best, k) => (Math.abs(v[3 + k]) > Math.abs(v[3 + best]) ? k : best), 0);
    const key = `${v.slice(0, 3).map((c) => Math.round(c / cell))},${side}${v[3 + side] < 0}`;
    if (!places.has(key)) places.set(key, sums.push(new Array(10).fill(0)) - 1);
    const sum = sums[places.get(key)];
    v.forEach((c, k) => { sum[k] += c; });
    sum[9] += 1;
    return places.get(key);
  });
  for (const sum of sums) out.vertices.push(...sum.slice(0, 9).map((c) => c / sum[9]));
  const known = new Set();
  for (let i = 0; i < indices.length; i += 3) {
    const corners = indices.slice(i, i + 3).map((index) => at[index]);
    const name = [...corners].sort((a, b) => a - b).join();
    if (new Set(corners).size < 3 || known.has(name)) continue;
    known.add(name);
    out.indices.push(...corners);
  }
  return out;
}

// A figure in one mesh, with a body's number at each corner.
function figureMesh(meshes, height) {
  const [vertices, indices, bodies] = [[], [], []];
  meshes.map((part) => (part.indices.length > MANY ? coarse(part, height / COARSE) : part)).forEach((part, body) => {
    for (const i of part.indices) indices.push(i + bodies.length);
    for (const value of part.vertices) vertices.push(value);
    for (let i = 0; i < part.vertices.length; i += 9) bodies.push(body);
  });
  return { vertices, indices, bodies };
}
