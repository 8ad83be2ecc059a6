// Small multiples of the metrics: one panel each, one crosshair through all of them.

const SVG = "http://www.w3.org/2000/svg";
const shape = (tag, attributes, parent) => {
  const element = document.createElementNS(SVG, tag);
  for (const [k, v] of Object.entries(attributes)) element.setAttribute(k, v);
  if (parent) parent.append(element);
  return element;
};

function short(v) {
  if (v === null || !Number.isFinite(v)) return "–";
  const size = Math.abs(v);
  if (size !== 0 && (size < 1e-3 || size >= 1e6)) return v.toExponential(2);
  return Number(v.toPrecision(size >= 1000 ? 5 : 4)).toLocaleString("en", { maximumFractionDigits: 6 });
}

// Exponential moving average with the start-up bias removed; gaps stay gaps.
function smooth(y, amount) {
  let [mean, weight] = [0, 0];
  return y.map((v) => {
    if (v === null) return null;
    mean = amount * mean + (1 - amount) * v;
    weight = amount * weight + (1 - amount);
    return mean / weight;
  });
}

class Panel {
  static W = 320;
  static H = 130;

  constructor(curve, hover) {
    this.curve = curve;
    this.root = document.createElement("figure");
    const head = document.createElement("figcaption");
    const name = document.createElement("b");
    name.textContent = curve.name.split("/").slice(1).join("/") || curve.name;
    this.value = document.createElement("span");
    head.append(name, this.value);
    this.svg = shape("svg", { viewBox: `0 0 ${Panel.W} ${Panel.H}`, preserveAspectRatio: "none", role: "img" });
    this.svg.setAttribute("aria-label", curve.name);
    this.axis = document.createElement("div");
    this.axis.className = "axis";
    this.root.append(head, this.svg, this.axis);
    this.svg.addEventListener("pointermove", (e) => {
      const box = this.svg.getBoundingClientRect();
      hover(this.x0 + (this.x1 - this.x0) * (e.clientX - box.left) / box.width);
    });
    this.svg.addEventListener("pointerleave", () => hover(null));
    [this.x0, this.x1] = [curve.x[0], curve.x[curve.x.length - 1]];
  }

  draw(amount) {
    const { x, y } = this.curve;
    this.smoothed = smooth(y, amount);
    // The middle 98% of the raw values decide the scale, so that one spike does not flatten the rest; the line that is
    // drawn boldly always fits.
    const sorted = y.filter((v) => v !== null).sort((a, b) => a - b);
    const quantile = (q) => sorted[Math.round(q * (sorted.length - 1))];
    const bold = this.smoothed.filter((v) => v !== null);
    let low = Math.min(quantile(0.01), ...bold);
    let high = Math.max(quantile(0.99), ...bold);
    if (!(high > low)) [low, high] = [low - 1, low + 1];
    const margin = (high - low) * 0.06;
    this.px = (v) => (v - this.x0) / (this.x1 - this.x0 || 1) * Panel.W;
    this.py = (v) => Panel.H - (v - low + margin) / (high - low + 2 * margin) * Panel.H;
    this.svg.replaceChildren();
    for (const part of [0, 0.5, 1]) {
      const at = this.py(low + (high - low) * part);
      shape("line", { x1: 0, x2: Panel.W, y1: at, y2: at, class: "rule" }, this.svg);
    }
    const path = (values) => {
      let [text, pen] = ["", "M"];
      values.forEach((v, i) => {
        if (v === null) { pen = "M"; return; }
        text += `${pen}${this.px(x[i]).toFixed(1)} ${this.py(v).toFixed(1)}`;
        pen = "L";
      });
      return text;
    };
    if (amount > 0) shape("path", { d: path(y), class: "raw" }, this.svg);
    shape("path", { d: path(this.smoothed), class: "bold" }, this.svg);
    this.cross = shape("line", { y1: 0, y2: Panel.H, class: "cross", visibility: "hidden" }, this.svg);
    this.axis.replaceChildren(...[`${short(low)} … ${short(high)}`, `${short(this.x0)} – ${short(this.x1)}`].map((t) => {
      const span = document.createElement("span");
      span.textContent = t;
      return span;
    }));
    this.hover(null);
  }

  hover(at) {
    const { x, y } = this.curve;
    this.cross.setAttribute("visibility", at === null ? "hidden" : "visible");
    if (at === null) {
      this.value.textContent = short(this.smoothed[x.length - 1]);
      return;
    }
    let nearest = 0;
    for (let i = 1; i < x.length; i++) if (Math.abs(x[i] - at) < Math.abs(x[nearest] - at)) nearest = i;
    this.cross.setAttribute("x1", this.px(x[nearest]));
    this.cross.setAttribute("x2", this.px(x[nearest]));
    this.value.textContent = `${short(y[nearest])} at ${short(x[nearest])}`;
  }
}

function drawCurves(root) {
  const groups = new Map();
  for (const curve of data.curves) {
    const group = curve.name.includes("/") ? curve.name.split("/")[0] : "";
    if (!groups.has(group)) groups.set(group, []);
    groups.get(group).push(curve);
  }
  const panels = [];
  const hover = (at) => panels.forEach((p) => p.hover(at));
  for (const [group, curves] of groups) {
    if (group) {
      const title = document.createElement("h3");
      title.textContent = group;
      root.append(title);
    }
    const grid = document.createElement("div");
    grid.className = "panels";
    for (const curve of curves) {
      const panel = new Panel(curve, hover);
      panels.push(panel);
      grid.append(panel.root);
    }
    root.append(grid);
  }
  const slider = document.querySelector("[data-is=smoothing]");
  const redraw = () => panels.forEach((p) => p.draw(Number(slider.value)));
  slider.addEventListener("input", redraw);
  redraw();
}
