// A robot whose joints are sliders.

const byHamilton = ([a, b, c, d], [e, f, g, h]) => [
  a * e - b * f - c * g - d * h, a * f + b * e + c * h - d * g, a * g - b * h + c * e + d * f, a * h + b * g - c * f + d * e,
];
const LEFT = [0.76, 0.3, 0.2];
const RIGHT = [0.18, 0.56, 0.34];

class RobotLook {
  constructor(root) {
    this.root = root;
    Object.assign(this, data.look);
    this.figure = data.characters[this.visual];
    this.touching = data.characters[this.contacts];
    this.values = this.joints.map((joint) => [...joint.value]);
    this.layers = new Set((query.get("layers") || "visual,sides").split(","));
    this.stage = makeStage(this.find("canvas"));
    this.canvas = this.stage.canvas;
    this.camera = new Camera(this.figure.height);
    this.matrices = this.bodies.map(() => new Float32Array(16));
    this.sideHeat = this.bodies.map(({ side }) => (side ? [...(side > 0 ? LEFT : RIGHT), 0.75] : [0, 0, 0, 0]));
    this.camera.attach(this.canvas, () => { this.dirty = true; });
    this.sliders();
    this.wire();
    this.move();
    const [x, y] = this.matrices[0].slice(12, 14);
    this.camera.target = [x, y, this.lowest() + this.figure.height / 2];
    requestAnimationFrame(() => this.tick());
  }

  find(name) { return this.root.querySelector(`[data-is=${name}]`); }

  // Positions of hinges and slides; what follows another joint has none of its own.
  value(index) {
    const joint = this.joints[index];
    if (!joint.follows) return this.values[index][0];
    const { leader, polynomial } = joint.follows;
    const moved = leader === null ? 0 : this.value(leader) - this.joints[leader].reference;
    return joint.reference + polynomial.reduceRight((sum, c) => sum * moved + c, 0);
  }

  move() {
    const poses = [];
    const axes = [];
    this.bodies.forEach((body, i) => {
      const parent = poses[body.parent] || { p: [0, 0, 0], q: [1, 0, 0, 0] };
      let p = placement(parent.p, parent.q).point(body.position);
      let q = byHamilton(parent.q, body.orientation);
      this.joints.forEach((joint, j) => {
        if (joint.body !== i) return;
        const v = this.values[j];
        if (joint.kind === "free") { p = v.slice(0, 3); q = v.slice(3); return; }
        const place = placement(p, q);
        const anchor = place.point(joint.position);
        axes[j] = { at: anchor, along: place.turn(joint.axis) };
        if (joint.kind === "slide") {
          const way = this.value(j) - joint.reference;
          p = p.map((c, k) => c + axes[j].along[k] * way);
          return;
        }
        const half = joint.kind === "hinge" ? (this.value(j) - joint.reference) / 2 : 0;
        q = byHamilton(q, joint.kind === "ball" ? v : [Math.cos(half), ...joint.axis.map((c) => c * Math.sin(half))]);
        const back = placement([0, 0, 0], q).turn(joint.position);
        p = anchor.map((c, k) => c - back[k]);
      });
      const norm = Math.hypot(...q) || 1;
      poses.push({ p, q: q.map((c) => c / norm) });
      const m = turn(this.matrices[i], poses[i].q);
      for (let k = 0; k < 3; k++) m[12 + k] = p[k];
    });
    this.axes = axes;
    this.dirty = true;
  }

  lowest() { return Math.min(...this.matrices.map((m) => m[14]), 0); }

  sliders() {
    this.rows = this.joints.map((joint, j) => {
      if (joint.kind !== "hinge" && joint.kind !== "slide") return null;
      const row = document.createElement("label");
      const [name, value, input] = ["b", "span", "input"].map((tag) => document.createElement(tag));
      name.textContent = joint.name;
      const [low, high] = joint.range || (joint.kind === "hinge" ? [-Math.PI, Math.PI] : [-1, 1]);
      Object.assign(input, { type: "range", min: low, max: high, step: (high - low) / 500 || 1 });
      input.disabled = Boolean(joint.follows);
      if (joint.follows) {
        const leader = this.joints[joint.follows.leader];
        row.title = leader ? `follows ${leader.name}` : "held by a constraint";
      }
      input.addEventListener("input", () => { this.values[j] = [Number(input.value)]; this.show(); this.point(j); });
      for (const [event, index] of [["pointerenter", j], ["focusin", j], ["pointerleave", null]]) {
        row.addEventListener(event, () => this.point(index));
      }
      row.append(name, value, input);
      this.find("joints").append(row);
      return { input, value };
    });
    this.show();
  }

  show() {
    this.joints.forEach((joint, j) => {
      if (!this.rows[j]) return;
      const number = this.value(j);
      this.rows[j].input.value = number;
      this.rows[j].value.textContent =
        joint.kind === "hinge" ? `${(number * 180 / Math.PI).toFixed(1)}°` : `${number.toFixed(3)} m`;
    });
    this.move();
  }

  point(index) {
    this.pointed = index;
    const joint = this.joints[index];
    this.find("pointed").textContent = joint ? `${joint.name} moves ${this.bodies[joint.body].name}` : "";
    this.dirty = true;
  }

  wire() {
    for (const button of this.find("layers").children) {
      const press = () => button.setAttribute("aria-pressed", this.layers.has(button.value));
      press();
      button.addEventListener("click", () => {
        if (!this.layers.delete(button.value)) this.layers.add(button.value);
        press();
        this.dirty = true;
      });
    }
    const pose = (of) => () => {
      this.joints.forEach((joint, j) => {
        if (joint.kind === "hinge" || joint.kind === "slide") this.values[j] = [of(joint)];
      });
      this.show();
    };
    this.find("default").addEventListener("click", pose((joint) => joint.value[0]));
    this.find("zero").addEventListener("click", pose(() => 0));
    this.find("home").addEventListener("click", () => { this.camera.home(this.figure.height); this.dirty = true; });
    addEventListener("resize", () => { this.dirty = true; });
    themeChanged.push(() => { this.dirty = true; });
  }

  marks() {
    const marks = [];
    const size = this.figure.height;
    const arrow = (at, along, colour, length) =>
      marks.push({ kind: "arrow", at, along, size: [length * 0.07, length], colour, alpha: 1 });
    this.bodies.forEach((body, i) => {
      const m = this.matrices[i];
      const column = (k) => [m[4 * k], m[4 * k + 1], m[4 * k + 2]];
      const at = [m[12], m[13], m[14]];
      if (this.layers.has("frames")) {
        [[0.85, 0.2, 0.2], [0.2, 0.7, 0.25], [0.2, 0.4, 0.9]].forEach((colour, k) => arrow(at, column(k), colour, size * 0.06));
      }
      if (this.layers.has("masses") && body.mass > 0) {
        const com = at.map((c, k) => c + body.com.reduce((sum, x, axis) => sum + x * m[4 * axis + k], 0));
        const radius = Math.cbrt(body.mass * 3 / 4000 / Math.PI);
        marks.push({ kind: "ball", at: com, size: [radius, radius], colour: [0.35, 0.45, 0.8], alpha: 0.85 });
      }
    });
    const axis = this.axes[this.pointed];
    if (axis) arrow(axis.at, axis.along, [0.95, 0.7, 0.1], size * 0.22);
    return marks;
  }

  items() {
    const marked = ["masses", "frames"].some((layer) => this.layers.has(layer)) || this.axes[this.pointed];
    const pose = this.matrices;
    const items = [];
    const touches = this.layers.has("contacts");
    if (touches) items.push({ character: this.touching, pose, ghost: "solid" });
    if (this.layers.has("visual")) {
      const heat = this.layers.has("sides") ? this.sideHeat : null;
      items.push({ character: this.figure, pose, heat, ghost: marked || touches ? "glass" : false });
    }
    return items;
  }

  tick() {
    const view = fit(this.canvas);
    if (this.dirty || view.width !== this.width || view.height !== this.height) {
      Object.assign(this, { width: view.width, height: view.height, dirty: false });
      this.stage.draw(view, this.camera, this.items(), stageColours(), this.figure.height * 1.2, this.marks());
    }
    requestAnimationFrame(() => this.tick());
  }
}
