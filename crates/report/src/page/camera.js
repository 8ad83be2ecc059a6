// A camera that orbits a target, z up, and the little linear algebra it needs (column-major 4x4).

const normalize = (v) => { const n = Math.hypot(...v) || 1; return v.map((c) => c / n); };
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

function multiply(a, b) {
  const out = new Float32Array(16);
  for (let c = 0; c < 4; c++) {
    for (let r = 0; r < 4; r++) {
      for (let k = 0; k < 4; k++) out[c * 4 + r] += a[k * 4 + r] * b[c * 4 + k];
    }
  }
  return out;
}

function lookAt(eye, target) {
  const back = normalize(eye.map((c, k) => c - target[k]));
  const right = normalize(cross([0, 0, 1], back));
  const up = cross(back, right);
  return new Float32Array([
    right[0], up[0], back[0], 0, right[1], up[1], back[1], 0, right[2], up[2], back[2], 0,
    -dot(right, eye), -dot(up, eye), -dot(back, eye), 1,
  ]);
}

function perspective(angle, aspect, near, far) {
  const f = 1 / Math.tan(angle / 2);
  return new Float32Array([f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / (near - far), -1,
    0, 0, (2 * far * near) / (near - far), 0]);
}

const orthographic = (half, depth) =>
  new Float32Array([1 / half, 0, 0, 0, 0, 1 / half, 0, 0, 0, 0, -2 / depth, 0, 0, 0, -1, 1]);

class Camera {
  constructor(height) {
    this.angle = 0.5;
    this.home(height);
    this.target = [0, 0, height / 2];
    this.pan = [0, 0, 0];
  }

  home(height) {
    this.azimuth = -0.9;
    this.elevation = 0.2;
    this.distance = height * 2.6;
    this.pan = [0, 0, 0];
  }

  eye() {
    const flat = Math.cos(this.elevation) * this.distance;
    return [
      this.target[0] + flat * Math.cos(this.azimuth),
      this.target[1] + flat * Math.sin(this.azimuth),
      Math.max(this.target[2] + Math.sin(this.elevation) * this.distance, 0.02),
    ];
  }

  right() { return [-Math.sin(this.azimuth), Math.cos(this.azimuth), 0]; }

  matrix(aspect) {
    const near = this.distance * 0.05;
    return multiply(perspective(this.angle, aspect, near, this.distance * 40), lookAt(this.eye(), this.target));
  }

  // Mouse, touch and wheel: drag to orbit, two fingers or shift to move, wheel or pinch to zoom.
  attach(element, changed) {
    const pointers = new Map();
    element.style.touchAction = "none";
    element.addEventListener("pointerdown", (e) => {
      element.setPointerCapture(e.pointerId);
      pointers.set(e.pointerId, [e.clientX, e.clientY]);
    });
    for (const end of ["pointerup", "pointercancel"]) element.addEventListener(end, (e) => pointers.delete(e.pointerId));
    element.addEventListener("contextmenu", (e) => e.preventDefault());
    element.addEventListener("pointermove", (e) => {
      const before = pointers.get(e.pointerId);
      if (!before) return;
      const [dx, dy] = [e.clientX - before[0], e.clientY - before[1]];
      const others = [...pointers].filter(([id]) => id !== e.pointerId).map(([, p]) => p);
      if (others.length) {
        const gap = (p) => Math.hypot(p[0] - others[0][0], p[1] - others[0][1]);
        this.zoom(gap(before) / (gap([e.clientX, e.clientY]) || 1));
        this.shift(dx / 2, dy / 2, element);
      } else if (e.shiftKey || e.buttons & 2) {
        this.shift(dx, dy, element);
      } else {
        this.azimuth -= dx * 0.008;
        this.elevation = Math.min(Math.max(this.elevation + dy * 0.006, -0.05), 1.5);
      }
      pointers.set(e.pointerId, [e.clientX, e.clientY]);
      changed();
    });
    element.addEventListener("wheel", (e) => {
      e.preventDefault();
      this.zoom(Math.exp(e.deltaY * 0.0012));
      changed();
    }, { passive: false });
  }

  zoom(factor) { this.distance = Math.min(Math.max(this.distance * factor, 0.2), 40); }

  shift(dx, dy, element) {
    const scale = (2 * Math.tan(this.angle / 2) * this.distance) / element.clientHeight;
    const right = this.right();
    this.pan = [this.pan[0] - right[0] * dx * scale, this.pan[1] - right[1] * dx * scale, this.pan[2] + dy * scale];
  }
}
