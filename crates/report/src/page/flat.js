// The same scene where there is no WebGL: plain shapes, the farthest first.

class FlatStage {
  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
  }

  draw(view, camera, items, colours) {
    const c = this.context;
    const css = (rgb, alpha = 1) => `rgba(${rgb.map((x) => Math.round(Math.min(x, 1) * 255)).join(",")},${alpha})`;
    const top = this.canvas.height - view.y - view.height;
    c.save();
    c.beginPath();
    c.rect(view.x, top, view.width, view.height);
    c.clip();
    c.fillStyle = css(colours.paper);
    c.fillRect(view.x, top, view.width, view.height);
    const matrix = camera.matrix(view.width / view.height);
    const focal = view.height / 2 / Math.tan(camera.angle / 2);
    const project = (p) => {
      const at = (r) => matrix[r] * p[0] + matrix[4 + r] * p[1] + matrix[8 + r] * p[2] + matrix[12 + r];
      const w = at(3);
      if (w < camera.distance * 0.05) return null;
      return [view.x + (at(0) / w + 1) * view.width / 2, top + (1 - at(1) / w) * view.height / 2, w];
    };
    const stroke = (a, b, width, style) => {
      const [p, q] = [project(a), project(b)];
      if (!p || !q) return;
      c.strokeStyle = style;
      c.lineWidth = Math.max(width * focal * 2 / (p[2] + q[2]), 1);
      c.beginPath();
      c.moveTo(p[0], p[1]);
      c.lineTo(q[0], q[1]);
      c.stroke();
    };
    const [fx, fy] = camera.target.map(Math.round);
    for (let i = -4; i <= 4; i++) {
      stroke([fx + i, fy - 4, 0], [fx + i, fy + 4, 0], 0.004, css(colours.line));
      stroke([fx - 4, fy + i, 0], [fx + 4, fy + i, 0], 0.004, css(colours.line));
    }
    const shapes = [];
    for (const item of items) {
      for (const geom of item.character.geoms) {
        const m = item.pose[geom.body];
        const at = (p) => [0, 1, 2].map((k) => m[k] * p[0] + m[4 + k] * p[1] + m[8 + k] * p[2] + m[12 + k]);
        const place = placement(geom.position, geom.orientation);
        const middle = project(at(geom.position));
        if (middle) shapes.push({ depth: middle[2], geom, item, at: (p) => at(place.point(p)) });
      }
    }
    c.lineCap = "round";
    for (const { geom, item, at } of shapes.sort((a, b) => b.depth - a.depth)) {
      const s = geom.size;
      const [r, g, b, share] = item.heat ? item.heat[geom.body] : [0, 0, 0, 0];
      const own = geom.rgba.slice(0, 3).map((x, k) => x * (1 - share) + [r, g, b][k] * share);
      const style = item.ghost ? css(item.tint ?? colours.ghost, item.ghost === "glass" ? 0.35 : 1) : css(own);
      if (geom.shape === "capsule" || geom.shape === "cylinder") {
        stroke(at([0, 0, s[1]]), at([0, 0, -s[1]]), 2 * s[0], style);
      } else if (geom.shape === "mesh") {
        const { decoded } = decodeMesh(item.character.meshes[geom.mesh]);
        const step = Math.max(Math.floor(decoded.length / 3 / 80), 1) * 3;
        const points = [];
        for (let i = 0; i < decoded.length; i += step) points.push(project(at(decoded.subarray(i, i + 3))));
        if (points.some((p) => !p) || points.length < 3) continue;
        c.fillStyle = style;
        c.beginPath();
        for (const p of hull(points)) c.lineTo(p[0], p[1]);
        c.fill();
      } else if (geom.shape === "box") {
        const corners = [];
        for (let k = 0; k < 8; k++) corners.push(project(at(s.map((h, axis) => (k >> axis & 1 ? h : -h)))));
        if (corners.some((p) => !p)) continue;
        c.fillStyle = style;
        c.beginPath();
        for (const p of hull(corners)) c.lineTo(p[0], p[1]);
        c.fill();
      } else {
        stroke(at([0, 0, 0.001]), at([0, 0, -0.001]), 2 * s[0], style);
      }
    }
    c.restore();
  }
}

// Convex hull of points in the plane (Andrew's monotone chain).
function hull(points) {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const half = (list) => {
    const out = [];
    for (const p of list) {
      const turns = () => {
        const [a, b] = out.slice(-2);
        return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) <= 0;
      };
      while (out.length > 1 && turns()) out.pop();
      out.push(p);
    }
    return out.slice(0, -1);
  };
  return [...half(sorted), ...half(sorted.reverse())];
}
