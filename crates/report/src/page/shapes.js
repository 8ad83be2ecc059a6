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

function addShape(mesh, geom, colour) {
  const place = placement(geom.position, geom.orientation);
  const s = geom.size;
  if (geom.shape === "sphere") {
    mesh.surface(14, 24, (u, v) => { const n = onSphere(u, v); return [n.map((c) => c * s[0]), n]; }, place, colour);
  } else if (geom.shape === "ellipsoid") {
    mesh.surface(16, 28, (u, v) => {
      const e = onSphere(u, v);
      const n = e.map((c, k) => c / s[k]);
      const norm = Math.hypot(...n);
      return [e.map((c, k) => c * s[k]), n.map((c) => c / norm)];
    }, place, colour);
  } else if (geom.shape === "capsule") {
    mesh.surface(17, 24, (u, v) => {
      // The middle row of cells is the tube between the two caps.
      const row = Math.round(u * 17);
      const n = onSphere((row <= 8 ? row : row - 1) / 16, v);
      return [[n[0] * s[0], n[1] * s[0], n[2] * s[0] + (row <= 8 ? s[1] : -s[1])], n];
    }, place, colour);
  } else if (geom.shape === "cylinder") {
    const rim = (v) => [Math.cos(v * 2 * Math.PI), Math.sin(v * 2 * Math.PI)];
    mesh.surface(1, 28, (u, v) => {
      const [c, d] = rim(v);
      return [[c * s[0], d * s[0], s[1] * (1 - 2 * u)], [c, d, 0]];
    }, place, colour);
    for (const side of [1, -1]) {
      mesh.surface(1, 28, (u, v) => {
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
function bodyMeshes(character, plain) {
  const meshes = character.bodies.map(() => new MeshBuilder());
  for (const geom of character.geoms) {
    const grey = geom.rgba.slice(0, 3).every((c) => Math.abs(c - 0.5) < 1e-3);
    addShape(meshes[geom.body], geom, grey ? plain : geom.rgba.slice(0, 3));
  }
  return meshes;
}
