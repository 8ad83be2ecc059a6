// Strips below the timeline: joint error, torque, feet, falls.

import { fit } from "./renderer.js";

export class Strips {
  constructor(canvas) {
    this.canvas = canvas;
    this.rows = null;
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  // Kind, 3 bytes of padding, columns, simulated frames, frames of the scene, then rows of bytes.
  take(view) {
    const columns = view.getUint32(4, true);
    this.share = view.getUint32(8, true) / view.getUint32(12, true);
    this.rows = [0, 1, 2, 3, 4].map((row) => new Uint8Array(view.buffer, 16 + row * columns, columns));
    this.draw();
  }

  draw() {
    if (!this.rows || !this.canvas.clientWidth) return;
    const { width, height } = fit(this.canvas);
    const c = this.canvas.getContext("2d");
    const style = getComputedStyle(document.documentElement);
    const colour = (name) => style.getPropertyValue(name).trim();
    c.clearRect(0, 0, width, height);
    const [error, torque, left, right, falls] = this.rows;
    const n = error.length;
    const x = (i) => (i / Math.max(n, 1)) * width * Math.min(this.share, 1);
    const area = (row, top, bottom, full, fill) => {
      c.fillStyle = colour(fill);
      c.beginPath();
      c.moveTo(0, bottom);
      row.forEach((v, i) => c.lineTo(x(i + 0.5), bottom - (bottom - top) * Math.min(v / full, 1)));
      c.lineTo(x(n), bottom);
      c.fill();
    };
    // 80 eighths of a degree; the whole torque.
    area(error, height * 0.03, height * 0.4, 80, "--error");
    area(torque, height * 0.44, height * 0.74, 255, "--torque");
    c.fillStyle = colour("--foot");
    [left, right].forEach((row, k) => {
      const y = height * (0.79 + 0.1 * k);
      for (let i = 0; i < n; i++) if (row[i] > 2) c.fillRect(Math.floor(x(i)), y, Math.ceil(x(i + 1)) - Math.floor(x(i)), height * 0.07);
    });
    c.fillStyle = colour("--bad");
    for (let i = 0; i < n; i++) if (falls[i]) c.fillRect(x(i) - 1, 0, 3, height);
    c.fillStyle = colour("--soft");
    c.font = `${Math.round(height * 0.2)}px system-ui`;
    c.fillText("error", 5, height * 0.2);
    c.fillText("torque", 5, height * 0.6);
  }
}
