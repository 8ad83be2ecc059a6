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

// Lines of one quantity over one axis.
class Panel {
  static W = 320;
  static H = 130;

  // `words` writes a value.
  constructor(curve, hover, words = short) {
    Object.assign(this, { lines: curve.lines, words });
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
    if (this.lines.length > 1) this.root.append(legend(this.lines));
    this.svg.addEventListener("pointermove", (e) => {
      const box = this.svg.getBoundingClientRect();
      hover(this.x0 + (this.x1 - this.x0) * (e.clientX - box.left) / box.width);
    });
    this.svg.addEventListener("pointerleave", () => hover(null));
    const x = this.lines.flatMap((line) => [line.x[0], line.x[line.x.length - 1]]);
    [this.x0, this.x1] = [Math.min(...x), Math.max(...x)];
  }

  draw(amount) {
    // The middle 98% of the raw values decide the scale, so that one spike does not flatten the rest; the lines that are
    // drawn boldly always fit.
    let [low, high] = [Infinity, -Infinity];
    for (const line of this.lines) {
      // A few points are no trend.
      line.smoothed = smooth(line.y, line.y.length < 20 ? 0 : amount);
      const sorted = line.y.filter((v) => v !== null).sort((a, b) => a - b);
      const quantile = (q) => sorted[Math.round(q * (sorted.length - 1))];
      for (const v of [quantile(0.01), quantile(0.99), ...line.smoothed]) {
        if (v === null || v === undefined) continue;
        [low, high] = [Math.min(low, v), Math.max(high, v)];
      }
    }
    if (!(high > low)) [low, high] = [low - 1, low + 1];
    const margin = (high - low) * 0.06;
    this.px = (v) => (v - this.x0) / (this.x1 - this.x0 || 1) * Panel.W;
    this.py = (v) => Panel.H - (v - low + margin) / (high - low + 2 * margin) * Panel.H;
    this.svg.replaceChildren();
    for (const part of [0, 0.5, 1]) {
      const at = this.py(low + (high - low) * part);
      shape("line", { x1: 0, x2: Panel.W, y1: at, y2: at, class: "rule" }, this.svg);
    }
    const path = (x, values) => {
      let [text, pen] = ["", "M"];
      values.forEach((v, i) => {
        if (v === null) { pen = "M"; return; }
        text += `${pen}${this.px(x[i]).toFixed(1)} ${this.py(v).toFixed(1)}`;
        pen = "L";
      });
      return text;
    };
    [...this.lines.entries()].reverse().forEach(([k, line]) => {
      if (amount > 0) shape("path", { d: path(line.x, line.y), class: "raw" }, this.svg);
      shape("path", { d: path(line.x, line.smoothed), class: `bold series-${k % 4}` }, this.svg);
    });
    this.cross = shape("line", { y1: 0, y2: Panel.H, class: "cross", visibility: "hidden" }, this.svg);
    this.axis.replaceChildren(...[`${this.words(low)} … ${this.words(high)}`, `${short(this.x0)} – ${short(this.x1)}`].map((t) => {
      const span = document.createElement("span");
      span.textContent = t;
      return span;
    }));
    this.hover(null);
  }

  hover(at) {
    this.cross.setAttribute("visibility", at === null ? "hidden" : "visible");
    if (at === null) {
      this.value.textContent = this.lines.map((line) => this.words(line.smoothed[line.x.length - 1])).join(" / ");
      return;
    }
    const near = this.lines.map(({ x }) => {
      let nearest = 0;
      for (let i = 1; i < x.length; i++) if (Math.abs(x[i] - at) < Math.abs(x[nearest] - at)) nearest = i;
      return nearest;
    });
    const place = this.lines[0].x[near[0]];
    this.cross.setAttribute("x1", this.px(place));
    this.cross.setAttribute("x2", this.px(place));
    const values = this.lines.map((line, k) => this.words(line.y[near[k]])).join(" / ");
    this.value.textContent = this.words === short ? `${values} at ${short(place)}` : values;
  }
}

function legend(lines) {
  const root = document.createElement("div");
  root.className = "axis key";
  lines.forEach((line, k) => {
    const item = document.createElement("span");
    const mark = document.createElement("i");
    mark.style.borderColor = `var(--${["accent", "reference", "force", "bad"][k % 4]})`;
    item.append(mark, line.label);
    root.append(item);
  });
  return root;
}

// Curves of one name share an axis; groups follow one another. Where some are headlines, the others are folded.
function drawCurves(root) {
  const named = new Map();
  for (const { name, series, x, y } of data.curves) {
    if (!named.has(name)) named.set(name, { name, lines: [] });
    named.get(name).lines.push({ label: series, x, y });
  }
  const panels = [];
  const hover = (at) => panels.forEach((p) => p.hover(at));
  const grid = (curves, parent, kind = "") => {
    const element = document.createElement("div");
    element.className = `panels ${kind}`;
    for (const curve of curves) {
      const panel = new Panel(curve, hover);
      panels.push(panel);
      element.append(panel.root);
    }
    parent.append(element);
  };
  const open = root.querySelector("details")?.open ?? false;
  root.replaceChildren();
  const first = data.headlines.map((name) => named.get(name)).filter((curve) => curve);
  let rest = root;
  if (first.length) {
    grid(first, root, "headline");
    first.forEach((curve) => named.delete(curve.name));
    rest = document.createElement("details");
    rest.open = open;
    const summary = document.createElement("summary");
    summary.textContent = `${named.size} more curves`;
    rest.append(summary);
    if (named.size) root.append(rest);
  }
  const groups = new Map();
  for (const curve of named.values()) {
    const group = curve.name.includes("/") ? curve.name.split("/")[0] : "";
    if (!groups.has(group)) groups.set(group, []);
    groups.get(group).push(curve);
  }
  for (const [group, curves] of groups) {
    if (group) {
      const title = document.createElement("h3");
      title.textContent = group;
      rest.append(title);
    }
    grid(curves, rest);
  }
  const slider = document.querySelector("[data-is=smoothing]");
  const redraw = () => panels.forEach((p) => p.draw(Number(slider.value)));
  slider.oninput = redraw;
  redraw();
}
