// The robot in the browser: physics over its reference, forces, and the mouse that pulls.

import { Camera, cross, dot, fit, makeStage, normalize, stageColours, unpackPose } from "./renderer.js";

// Joint error at which a body is coloured wholly (degrees).
const HOT = 20;
// Pull in weights of the robot for a drag of 100 pixels.
const PULL = 0.3;
const FORCE_STEP = 5;
// Time between pictures at which they are drawn in the plain way, and the one of a picture that is late (ms).
const [SLOW, LATE] = [30, 20];
// Share of late pictures at which fewer pixels are drawn, and the share of the width at least.
const [MANY_LATE, LEAST_SCALE] = [0.12, 0.5];
// Frames between two packets from which on the robot is not moved, but put.
const JUMP = 10;
// Time after which a picture that stays is drawn with every pixel (ms).
const STILL = 300;
// Longest time for which the picture waits for the answer of a push (ms).
const ANSWER = 60;
// Colour of a kept take.
const KEPT = [0.36, 0.5, 0.93];
// Handles: radius in heights of the robot, and pixels around the middle that take hold of it.
const [HANDLE, GRASP] = [0.022, 14];

const matrices = (n) => Array.from({ length: n }, () => new Float32Array(16));

export class Scene {
  constructor(canvas, robot, actions) {
    this.robot = robot;
    this.actions = actions;
    this.character = robot.character;
    const n = this.character.bodies.length;
    // Poses on the screen, those that they come from, and those that they are moved to.
    [this.simulated, this.reference] = [matrices(n), matrices(n)];
    this.kept = null;
    [this.from, this.to] = [0, 1].map(() => [0, 1, 2].map(() => matrices(n)));
    this.due = null;
    this.heat = Array.from({ length: n }, () => [0, 0, 0, 0]);
    this.shows = { reference: true, errors: true, follow: true, handles: false };
    this.drawn = 0;
    this.head = null;
    this.pushes = [];
    this.stage = makeStage(canvas);
    this.canvas = this.stage.canvas;
    this.camera = new Camera(this.character.height);
    this.wire();
    this.camera.attach(this.canvas, () => { this.dirty = true; });
    new ResizeObserver(() => { this.dirty = true; }).observe(this.canvas);
    this.scale = 1;
    this.asked = -ANSWER;
    this.patience = 120;
    const tick = (now) => {
      if (this.due) this.move(performance.now());
      // A picture without the push that was asked for would only delay the one with it.
      const waits = this.stage.plain && performance.now() - this.asked < ANSWER;
      if (this.dirty && !waits) {
        this.pace(now);
        this.draw();
      } else if (!waits) {
        this.last = null;
        // What does not move is drawn with every pixel.
        if (!this.fine && now - this.before > STILL) this.draw(1);
      }
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  // Reads a packet; the layout is that of `packet.rs`.
  frame(view) {
    const n = view.getUint16(2, true);
    const [joints, feet] = [view.getUint16(4, true), view.getUint16(6, true)];
    const flags = view.getUint8(1);
    const before = this.head;
    this.head = {
      playing: (flags & 1) > 0, fallen: (flags & 2) > 0, building: (flags & 4) > 0,
      frame: view.getUint32(8, true), known: view.getUint32(12, true), frames: view.getUint32(16, true),
      version: view.getUint32(20, true), rate: view.getFloat32(24, true), force: view.getFloat32(28, true),
    };
    const second = 32 + 16 + 14 * n;
    unpackPose(view, 32, this.to[0]);
    unpackPose(view, second, this.to[1]);
    const errors = second + 16 + 14 * n;
    this.heat.forEach((h) => { h[3] = 0; });
    for (let j = 0; j < joints; j++) {
      const share = Math.min(view.getUint8(errors + j) / 2 / HOT, 1);
      const h = this.heat[this.robot.jointBodies[j]];
      if (share > h[3]) [h[0], h[1], h[2], h[3]] = [0.86, 0.16, 0.2, share];
    }
    if (this.head.force > 0) this.asked = -ANSWER;
    this.feet = Array.from({ length: feet }, (_, f) => view.getUint8(errors + 2 * joints + f) / 50);
    // A take that is kept: its physics in the same frame.
    if (flags & 8) unpackPose(view, errors + 2 * joints + feet, this.to[2]);
    this.kept = flags & 8 ? this.kept ?? matrices(n) : null;
    this.aim(before);
    return this.head;
  }

  poses() { return [this.simulated, this.reference, this.kept].filter(Boolean); }

  // Begins to move to the packet's poses, which are those of the next frame while the clock runs; else they are shown.
  aim(before) {
    const { head } = this;
    const now = performance.now();
    const same = before?.playing && before.frame === head.frame && this.due;
    const moves = head.playing && before?.playing && Math.abs(head.frame - before.frame) < JUMP;
    if (moves) this.poses().forEach((pose, k) => pose.forEach((m, body) => this.from[k][body].set(m)));
    const until = same ? this.due.until : now + 1000 / (this.robot.hz * head.rate);
    this.due = moves ? { since: now, until } : { since: now, until: now };
    if (!moves) this.move(now);
    this.dirty = true;
  }

  // Poses at a time. Two frames are near each other, so that turns are mixed as matrices.
  move(now) {
    const { since, until } = this.due;
    const share = until > since ? Math.min((now - since) / (until - since), 1) : 1;
    this.poses().forEach((pose, k) => pose.forEach((m, body) => {
      const [from, to] = [this.from[k][body], this.to[k][body]];
      for (let i = 0; i < 16; i++) m[i] = share < 1 ? from[i] + (to[i] - from[i]) * share : to[i];
    }));
    if (share === 1) this.due = null;
    this.dirty = true;
  }

  look({ azimuth, elevation, distance, follow }) {
    Object.assign(this.camera, { azimuth, elevation, distance: distance * this.character.height });
    this.shows.follow = follow;
    this.dirty = true;
  }

  seen() {
    const { azimuth, elevation, distance } = this.camera;
    const round = (v) => Math.round(v * 1000) / 1000;
    return { azimuth: round(azimuth), elevation: round(elevation), distance: round(distance / this.character.height), follow: this.shows.follow };
  }

  draw(scale = this.scale) {
    this.dirty = false;
    this.fine = scale === 1;
    this.drawn++;
    const { camera, character } = this;
    if (this.shows.follow) {
      // A camera that is as restless as the robot makes people sick.
      const root = this.place(0);
      const calm = (this.calm ??= root.slice(0, 2));
      const passed = Math.min((performance.now() - (this.before ?? 0)) / 1000, 0.2);
      const share = 1 - Math.exp(-passed * 4);
      calm.forEach((c, k) => { calm[k] = Math.abs(root[k] - c) > 1.5 ? root[k] : c + (root[k] - c) * share; });
      if (calm.some((c, k) => Math.abs(root[k] - c) > 0.004)) this.dirty = true;
    }
    this.before = performance.now();
    const at = this.calm ?? [0, 0];
    camera.target = [at[0] + camera.pan[0], at[1] + camera.pan[1], character.height * 0.46 + camera.pan[2]];
    const items = [{ character, pose: this.simulated, ghost: false, heat: this.shows.errors ? this.heat : null }];
    if (this.shows.reference) items.push({ character, pose: this.reference, ghost: "glass" });
    if (this.kept) items.push({ character, pose: this.kept, ghost: "glass", tint: KEPT });
    const colours = (this.colours ??= stageColours());
    this.stage.draw(fit(this.canvas, scale), camera, items, colours, character.height * 1.4, this.marks(colours));
  }

  // Draws in the plain way, and then fewer pixels, where pictures come late, as without a graphics card.
  pace(now) {
    // The pixels of a film stay as many.
    if (this.filmed) return;
    const passed = this.last ? Math.min(now - this.last, 100) : null;
    this.last = now;
    if (passed === null) return;
    this.mean = (this.mean ?? 17) * 0.85 + passed * 0.15;
    this.late = (this.late ?? 0) * 0.98 + (passed > LATE ? 0.02 : 0);
    if (this.mean > SLOW && this.stage.goPlain && !this.stage.plain) {
      this.stage.goPlain();
      [this.mean, this.late] = [17, 0];
    } else if (this.mean > SLOW || (this.stage.plain && this.late > MANY_LATE)) {
      this.scale = Math.max(this.scale * 0.84, LEAST_SCALE);
      // More pixels are tried later each time.
      [this.mean, this.late, this.calmFor, this.patience] = [17, 0, 0, Math.min(2 * this.patience, 4000)];
    } else if (this.scale < 1 && (this.calmFor = (this.calmFor ?? 0) + 1) > this.patience) {
      [this.scale, this.calmFor] = [Math.min(this.scale * 1.1, 1), 0];
    }
  }

  place(body) { return [...this.simulated[body].slice(12, 15)]; }

  // Arrows of pushes: half a robot's height for its weight.
  marks(colours) {
    const { character: { height }, robot: { weight } } = this;
    const active = this.pull?.newtons ? [{ body: this.pull.body, newtons: this.pull.newtons }] : this.pushes;
    return this.handleMarks(colours).concat(active.filter(({ newtons }) => Math.hypot(...newtons) > 1).map(({ body, newtons }) => {
      const force = Math.hypot(...newtons);
      const length = Math.min(Math.max(force / weight, 0.15), 2) * height * 0.5;
      const along = newtons.map((f) => f / force);
      const at = this.place(body).map((c, k) => c + along[k] * height * 0.09);
      return { kind: "arrow", at, along, size: [height * 0.022, length], colour: colours.force, alpha: 0.95 };
    }));
  }

  // A handle's place on the reference, and the way that it is dragged (m, world).
  handlePlace({ body, point }) {
    const m = this.reference[body];
    return [0, 1, 2].map((r) => m[12 + r] + m[r] * point[0] + m[4 + r] * point[1] + m[8 + r] * point[2]);
  }

  handleMarks(colours) {
    if (!this.shows.handles || this.head?.playing) return [];
    const size = this.character.height * HANDLE;
    return this.robot.handles.map((handle) => {
      const held = this.held?.handle === handle;
      const at = this.handlePlace(handle).map((c, k) => c + (held ? this.held.way[k] : 0));
      return { kind: "ball", at, size: [size, size], colour: held ? colours.force : colours.ghost, alpha: 0.8, over: true };
    });
  }

  // The pixel of a point, and the metres of a pixel there.
  project(p) {
    const box = this.canvas.getBoundingClientRect();
    const { forward, right, up, eye } = this.ray(box.left + box.width / 2, box.top + box.height / 2);
    const to = p.map((c, k) => c - eye[k]);
    const depth = dot(to, forward);
    const metres = (2 * Math.tan(this.camera.angle / 2) * depth) / box.height;
    return { x: box.left + box.width / 2 + dot(to, right) / metres, y: box.top + box.height / 2 - dot(to, up) / metres, metres };
  }

  handleAt(x, y) {
    if (!this.shows.handles || this.head?.playing) return null;
    const near = this.robot.handles.map((handle) => {
      const at = this.project(this.handlePlace(handle));
      return { handle, metres: at.metres, far: Math.hypot(at.x - x, at.y - y) };
    });
    const best = near.sort((a, b) => a.far - b.far)[0];
    return best && best.far < GRASP ? best : null;
  }

  // The way of the held handle in the robot's own directions: forward, left, up (m).
  heldWay() {
    const [, , w] = this.held.way;
    const root = this.reference[0];
    const yaw = Math.atan2(root[1], root[0]);
    const [dx, dy] = this.held.way;
    const [c, s] = [Math.cos(yaw), Math.sin(yaw)];
    return [dx * c + dy * s, dy * c - dx * s, w].map((v) => Math.round(v * 1000) / 1000);
  }

  // The ray through a pixel: its start and unit direction.
  ray(x, y) {
    const box = this.canvas.getBoundingClientRect();
    const [u, v] = [(2 * (x - box.left)) / box.width - 1, 1 - (2 * (y - box.top)) / box.height];
    const eye = this.camera.eye();
    const forward = normalize(this.camera.target.map((c, k) => c - eye[k]));
    const right = normalize(cross(forward, [0, 0, 1]));
    const up = cross(right, forward);
    const tan = Math.tan(this.camera.angle / 2);
    const along = forward.map((c, k) => c + right[k] * u * tan * (box.width / box.height) + up[k] * v * tan);
    return { eye, along: normalize(along), forward, right, up };
  }

  // The body under a pixel, by the spheres that fill its shapes.
  pick(x, y) {
    const { eye, along } = this.ray(x, y);
    let best = null;
    for (const geom of this.character.geoms) {
      const m = this.simulated[geom.body];
      const [w, qx, qy, qz] = geom.orientation;
      const axis = [2 * (qx * qz + w * qy), 2 * (qy * qz - w * qx), 1 - 2 * (qx * qx + qy * qy)];
      const long = ["capsule", "cylinder"].includes(geom.shape);
      const radius = geom.shape === "mesh" ? this.character.height * 0.06 : long ? geom.size[0] : Math.max(...geom.size) * 0.8;
      for (const step of long ? [-1, -0.5, 0, 0.5, 1] : [0]) {
        const p = geom.position.map((c, k) => c + axis[k] * step * (geom.size[1] ?? 0));
        const world = [0, 1, 2].map((r) => m[12 + r] + m[r] * p[0] + m[4 + r] * p[1] + m[8 + r] * p[2]);
        const to = world.map((c, k) => c - eye[k]);
        const depth = dot(to, along);
        const miss = Math.hypot(...to.map((c, k) => c - along[k] * depth));
        if (miss < Math.max(radius, 0.02) * 1.15 && (!best || depth < best.depth)) best = { body: geom.body, depth };
      }
    }
    return best?.body ?? null;
  }

  wire() {
    const canvas = this.canvas;
    canvas.addEventListener("pointerdown", (e) => {
      const grasp = this.robot.mayEdit && e.button === 0 ? this.handleAt(e.clientX, e.clientY) : null;
      if (grasp) {
        e.stopImmediatePropagation();
        canvas.setPointerCapture(e.pointerId);
        this.held = { ...grasp, from: [e.clientX, e.clientY], way: [0, 0, 0] };
        return;
      }
      const body = this.robot.mayEdit && e.button === 0 && !e.shiftKey ? this.pick(e.clientX, e.clientY) : null;
      if (body === null) return;
      e.stopImmediatePropagation();
      e.preventDefault();
      canvas.setPointerCapture(e.pointerId);
      this.pull = { body, from: [e.clientX, e.clientY], sent: 0, newtons: null };
      this.actions.pulling(true);
    });
    canvas.addEventListener("pointermove", (e) => {
      if (this.held) {
        e.stopImmediatePropagation();
        this.dragHandle(e.clientX, e.clientY);
      } else if (this.pull) {
        e.stopImmediatePropagation();
        this.drag(e.clientX, e.clientY);
      } else if (!e.buttons) {
        canvas.classList.toggle("over-robot", this.robot.mayEdit && this.pick(e.clientX, e.clientY) !== null);
      }
    });
    for (const end of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(end, (e) => {
        if (this.held) {
          e.stopImmediatePropagation();
          const [name, by] = [this.held.handle.name, this.heldWay()];
          this.held = null;
          this.dirty = true;
          this.actions.force(null);
          if (by.some((way) => Math.abs(way) > 0.003)) this.actions.moved(name, by);
          return;
        }
        if (!this.pull) {
          this.actions.looked(this.seen());
          return;
        }
        e.stopImmediatePropagation();
        const pulled = this.pull.newtons;
        this.pull = null;
        this.dirty = true;
        this.actions.force(null);
        if (pulled) this.actions.release();
      });
    }
    canvas.addEventListener("wheel", () => {
      clearTimeout(this.wheel);
      this.wheel = setTimeout(() => this.actions.looked(this.seen()), 400);
    }, { passive: true });
  }

  dragHandle(x, y) {
    const { from, metres, handle } = this.held;
    const { right, up } = this.ray(x, y);
    const [dx, dy] = [(x - from[0]) * metres, (from[1] - y) * metres];
    this.held.way = right.map((c, k) => c * dx + up[k] * dy);
    this.actions.force(`${handle.name.replaceAll("_", " ")} ${Math.round(100 * Math.hypot(dx, dy))} cm`, x, y);
    this.dirty = true;
  }

  drag(x, y) {
    const { from, body } = this.pull;
    const { right, up } = this.ray(x, y);
    const scale = (PULL * this.robot.weight) / 100;
    const [dx, dy] = [(x - from[0]) * scale, (from[1] - y) * scale];
    const newtons = right.map((c, k) => Math.round((c * dx + up[k] * dy) / FORCE_STEP) * FORCE_STEP);
    this.actions.force(`${Math.round(Math.hypot(...newtons))} N`, x, y);
    const changed = !this.pull.newtons || newtons.some((f, k) => Math.abs(f - this.pull.newtons[k]) >= FORCE_STEP);
    // Ten changes a second are enough for a hand, and keep the scene readable.
    if (!changed || (!this.pull.newtons && !newtons.some((f) => f)) || performance.now() - this.pull.sent < 90) return;
    this.pull.sent = performance.now();
    this.pull.newtons = newtons;
    this.dirty = true;
    this.push(this.character.bodies[body], newtons);
  }

  // Pushes a body (N), and shows nothing else until the answer is here.
  push(body, newtons) {
    if (!(this.head?.force > 0)) this.asked = performance.now();
    this.actions.pull(body, newtons);
  }
}
