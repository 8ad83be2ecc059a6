// Recorded motion: decoding, and where every body is at a time between two frames.

// Writes the rotation of a unit quaternion into a column-major 4x4 matrix.
function turn(m, [w, x, y, z]) {
  m[0] = 1 - 2 * (y * y + z * z); m[1] = 2 * (x * y + w * z); m[2] = 2 * (x * z - w * y); m[3] = 0;
  m[4] = 2 * (x * y - w * z); m[5] = 1 - 2 * (x * x + z * z); m[6] = 2 * (y * z + w * x); m[7] = 0;
  m[8] = 2 * (x * z + w * y); m[9] = 2 * (y * z - w * x); m[10] = 1 - 2 * (x * x + y * y); m[11] = 0;
  m[15] = 1;
  return m;
}

// Matrices of one packed frame: root f32 [3] and unit f32 at `at`, then i16 [bodies, 7]. Returns the root.
function unpackPose(view, at, matrices) {
  const root = [0, 4, 8].map((k) => view.getFloat32(at + k, true));
  const unit = view.getFloat32(at + 12, true);
  matrices.forEach((m, body) => {
    const from = at + 16 + body * 14;
    const value = (k) => view.getInt16(from + 2 * k, true);
    const q = [3, 4, 5, 6].map(value);
    const norm = Math.hypot(...q) || 1;
    turn(m, q.map((c) => c / norm));
    for (let k = 0; k < 3; k++) m[12 + k] = root[k] + value(k) * unit;
  });
  return root;
}

class Track {
  // `base64` holds little-endian numbers: roots f32 [frames, 3]; then i16 [frames, bodies, 7]: position less root in
  // units of `unit` metres, and the quaternion wxyz in units of 1/32767.
  constructor(base64, frames, bodies, fps, unit) {
    const bytes = bytesOf(base64);
    this.roots = new Float32Array(bytes, 0, frames * 3);
    this.poses = new Int16Array(bytes, frames * 12, frames * bodies * 7);
    Object.assign(this, { frames, bodies, fps, unit });
    this.matrices = Array.from({ length: bodies }, () => new Float32Array(16));
  }

  locate(time) {
    const at = Math.min(Math.max(time * this.fps, 0), this.frames - 1);
    const a = Math.floor(at);
    return [a, Math.min(a + 1, this.frames - 1), at - a];
  }

  root(time) {
    const [a, b, s] = this.locate(time);
    return [0, 1, 2].map((k) => this.roots[a * 3 + k] * (1 - s) + this.roots[b * 3 + k] * s);
  }

  // The root's way without its sway: what a camera can follow without making anyone sick.
  calmRoot(time) {
    const sum = [0, 0, 0];
    const n = 9;
    for (let i = 0; i < n; i++) {
      const r = this.root(time + (i / (n - 1) - 0.5) * 0.9);
      for (let k = 0; k < 3; k++) sum[k] += r[k] / n;
    }
    return sum;
  }

  // Column-major 4x4 matrices of all bodies, shifted by `offset` (m).
  pose(time, offset) {
    const [a, b, s] = this.locate(time);
    const root = this.root(time);
    const p = this.poses;
    for (let body = 0; body < this.bodies; body++) {
      const i = (a * this.bodies + body) * 7;
      const j = (b * this.bodies + body) * 7;
      const q = [0, 0, 0, 0];
      let dot = 0;
      for (let k = 3; k < 7; k++) dot += p[i + k] * p[j + k];
      const sign = dot < 0 ? -1 : 1;
      let norm = 0;
      for (let k = 0; k < 4; k++) {
        q[k] = p[i + 3 + k] * (1 - s) + sign * p[j + 3 + k] * s;
        norm += q[k] * q[k];
      }
      norm = 1 / Math.sqrt(norm || 1);
      const m = turn(this.matrices[body], q.map((c) => c * norm));
      for (let k = 0; k < 3; k++) {
        m[12 + k] = root[k] + offset[k] + (p[i + k] * (1 - s) + p[j + k] * s) * this.unit;
      }
    }
    return this.matrices;
  }
}

// Mean distance of corresponding bodies (m), each relative to its own root, frame by frame.
function bodyError(a, b) {
  const out = new Float32Array(Math.min(a.frames, b.frames));
  for (let f = 0; f < out.length; f++) {
    let sum = 0;
    for (let body = 0; body < a.bodies; body++) {
      const i = (f * a.bodies + body) * 7;
      sum += Math.hypot(...[0, 1, 2].map((k) => a.poses[i + k] * a.unit - b.poses[i + k] * b.unit));
    }
    out[f] = sum / a.bodies;
  }
  return out;
}

function decodePlayback(p) {
  const track = (t, character) => t && new Track(t.data, p.frames, data.characters[character].bodies.length, p.fps, t.unit);
  const simulated = track(p.simulated, p.character);
  const reference = track(p.reference, p.referenceCharacter);
  const own = p.character === p.referenceCharacter;
  return {
    ...p, simulated, reference, own,
    duration: (p.frames - 1) / p.fps,
    error: simulated && reference && own ? bodyError(simulated, reference) : null,
    feet: p.feet.map((f) => ({ ...f, down: new Uint8Array(bytesOf(f.down)), force: new Uint8Array(bytesOf(f.force)) })),
    joints: p.joints.map((j) => new Int16Array(bytesOf(j))),
  };
}
