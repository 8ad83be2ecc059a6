// Triangles of the shapes that bodies are made of: flat arrays of position, normal, colour (9 numbers a vertex).

class MeshBuilder {
  constructor() { this.vertices = []; this.indices = []; }

  // A grid of (u, v) cells; `at` gives [position, normal] in the geom's frame.
  surface(nu, nv, at, place, colour) {
    const first = this.vertices.length / 9;
    for (let i = 0; i <= nu; i++) {
      for (let j = 0; j <= nv; j++) {
        const [p, n] = at(i / nu, j / nv);
        this.vertices.push(...place.point(p), ...place.turn(n), ...colour);
      }
    }
    for (let i = 0; i < nu; i++) {
      for (let j = 0; j < nv; j++) {
        const a = first + i * (nv + 1) + j;
        this.indices.push(a, a + nv + 1, a + 1, a + 1, a + nv + 1, a + nv + 2);
      }
    }
  }
}

// Triangles of a mesh with a normal for each corner: faces that meet at less than CREASE degrees are smooth.
const CREASE = Math.cos(38 * Math.PI / 180);

function bytesOf(base64) {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  return bytes.buffer;
}

// The normal of each corner of the faces.
function cornerNormals(points, faces) {
  const normals = new Float32Array(faces.length);
  const around = Array.from({ length: points.length / 3 }, () => []);
  for (let f = 0; f < faces.length; f += 3) {
    const [a, b, c] = [0, 1, 2].map((k) => points.subarray(faces[f + k] * 3, faces[f + k] * 3 + 3));
    const n = cross([b[0] - a[0], b[1] - a[1], b[2] - a[2]], [c[0] - a[0], c[1] - a[1], c[2] - a[2]]);
    normals.set(n, f);
    for (let k = 0; k < 3; k++) around[faces[f + k]].push(f);
  }
  const corners = new Float32Array(faces.length * 3);
  for (let f = 0; f < faces.length; f += 3) {
    const own = normals.subarray(f, f + 3);
    const size = Math.hypot(...own) || 1;
    for (let k = 0; k < 3; k++) {
      const sum = [0, 0, 0];
      for (const g of around[faces[f + k]]) {
        const n = normals.subarray(g, g + 3);
        if (dot(own, n) >= CREASE * size * Math.hypot(n[0], n[1], n[2])) for (let i = 0; i < 3; i++) sum[i] += n[i];
      }
      corners.set(normalize(sum), (f + k) * 3);
    }
  }
  return corners;
}

function decodeMesh(mesh) {
  if (mesh.corners) return mesh;
  const packed = new Int16Array(bytesOf(mesh.points));
  const faces = new Uint32Array(bytesOf(mesh.faces));
  const points = Float32Array.from(packed, (v, i) => v * mesh.unit + mesh.middle[i % 3]);
  return Object.assign(mesh, { decoded: points, index: faces, corners: cornerNormals(points, faces) });
}

function placement(position, [w, x, y, z]) {
  const turn = (v) => {
    const t = [2 * (y * v[2] - z * v[1]), 2 * (z * v[0] - x * v[2]), 2 * (x * v[1] - y * v[0])];
    return [
      v[0] + w * t[0] + y * t[2] - z * t[1],
      v[1] + w * t[1] + z * t[0] - x * t[2],
      v[2] + w * t[2] + x * t[1] - y * t[0],
    ];
  };
  return { turn, point: (v) => turn(v).map((c, k) => c + position[k]) };
}

const onSphere = (u, v) => {
  const [a, b] = [u * Math.PI, v * 2 * Math.PI];
  return [Math.sin(a) * Math.cos(b), Math.sin(a) * Math.sin(b), Math.cos(a)];
};

function addMesh(out, { decoded, index, corners }, place, colour) {
  for (let i = 0; i < index.length; i++) {
    const p = decoded.subarray(index[i] * 3, index[i] * 3 + 3);
    out.indices.push(out.vertices.length / 9);
    out.vertices.push(...place.point(p), ...place.turn(corners.subarray(i * 3, i * 3 + 3)), ...colour);
  }
}

// `detail`: share of the corners of round shapes.
function addShape(mesh, geom, colour, meshes, detail) {
  const some = (cells) => Math.max(Math.round(cells * detail), 3);
  const place = placement(geom.position, geom.orientation);
  if (geom.shape === "mesh") return addMesh(mesh, decodeMesh(meshes[geom.mesh]), place, colour);
  const s = geom.size;
  if (geom.shape === "sphere") {
    mesh.surface(some(14), some(24), (u, v) => { const n = onSphere(u, v); return [n.map((c) => c * s[0]), n]; }, place, colour);
  } else if (geom.shape === "ellipsoid") {
    mesh.surface(some(16), some(28), (u, v) => {
      const e = onSphere(u, v);
      const n = e.map((c, k) => c / s[k]);
      const norm = Math.hypot(...n);
      return [e.map((c, k) => c * s[k]), n.map((c) => c / norm)];
    }, place, colour);
  } else if (geom.shape === "capsule") {
    const cap = some(8);
    mesh.surface(2 * cap + 1, some(24), (u, v) => {
      // The middle row of cells is the tube between the two caps.
      const row = Math.round(u * (2 * cap + 1));
      const n = onSphere((row <= cap ? row : row - 1) / (2 * cap), v);
      return [[n[0] * s[0], n[1] * s[0], n[2] * s[0] + (row <= cap ? s[1] : -s[1])], n];
    }, place, colour);
  } else if (geom.shape === "cylinder") {
    const rim = (v) => [Math.cos(v * 2 * Math.PI), Math.sin(v * 2 * Math.PI)];
    mesh.surface(1, some(28), (u, v) => {
      const [c, d] = rim(v);
      return [[c * s[0], d * s[0], s[1] * (1 - 2 * u)], [c, d, 0]];
    }, place, colour);
    for (const side of [1, -1]) {
      mesh.surface(1, some(28), (u, v) => {
        const [c, d] = rim(v);
        return [[c * s[0] * u, d * s[0] * u, s[1] * side], [0, 0, side]];
      }, place, colour);
    }
  } else if (geom.shape === "box") {
    // Edges rounded a little: they catch the light.
    const bevel = Math.min(0.35 * Math.min(...s), 0.012);
    for (let axis = 0; axis < 3; axis++) {
      for (const side of [1, -1]) {
        const [i, j] = [(axis + 1) % 3, (axis + 2) % 3];
        const steps = [-1, -0.92, -0.5, 0.5, 0.92, 1];
        const snap = (u, k) => {
          const t = steps[Math.round(u * 5)];
          if (Math.abs(t) === 1) return t * s[k];
          return Math.abs(t) === 0.92 ? Math.sign(t) * (s[k] - bevel * 0.4) : Math.sign(t) * (s[k] - bevel);
        };
        mesh.surface(5, 5, (u, v) => {
          const p = [0, 0, 0];
          p[axis] = side * s[axis];
          p[i] = snap(u, i);
          p[j] = snap(v, j);
          const inner = p.map((c, k) => Math.min(Math.max(c, bevel - s[k]), s[k] - bevel));
          const out = p.map((c, k) => c - inner[k]);
          const norm = Math.hypot(...out) || 1;
          const n = out.map((c) => c / norm);
          return [inner.map((c, k) => c + n[k] * bevel), n];
        }, place, colour);
      }
    }
  }
}

// One mesh per body. The model's own colours are kept, unless it has MuJoCo's plain grey: then `plain` is used.
function bodyMeshes(character, plain, detail = 1) {
  const meshes = character.bodies.map(() => new MeshBuilder());
  for (const geom of character.geoms) {
    const grey = geom.rgba.slice(0, 3).every((c) => Math.abs(c - 0.5) < 1e-3);
    addShape(meshes[geom.body], geom, grey ? plain : geom.rgba.slice(0, 3), character.meshes, detail);
  }
  return meshes;
}

// An arrow of length 1 along z, a disc and a ball of radius 1: marks of contacts, frames and masses.
function markMeshes() {
  const place = placement([0, 0, 0], [1, 0, 0, 0]);
  const [arrow, pad] = [new MeshBuilder(), new MeshBuilder()];
  const ring = (v) => [Math.cos(v * 2 * Math.PI), Math.sin(v * 2 * Math.PI)];
  const cone = (low, high, from, to) => arrow.surface(1, 18, (u, v) => {
    const [c, d] = ring(v);
    const r = low + (high - low) * u;
    return [[c * r, d * r, from + (to - from) * u], normalize([c, d, low - high])];
  }, place, [1, 1, 1]);
  cone(0.35, 0.35, 0, 0.8);
  cone(1, 0.0001, 0.8, 1);
  cone(0.35, 1, 0.8, 0.8);
  pad.surface(1, 28, (u, v) => { const [c, d] = ring(v); return [[c * (1 - u), d * (1 - u), 0], [0, 0, 1]]; }, place, [1, 1, 1]);
  const ball = new MeshBuilder();
  ball.surface(12, 18, (u, v) => { const n = onSphere(u, v); return [n, n]; }, place, [1, 1, 1]);
  return { arrow, pad, ball };
}
