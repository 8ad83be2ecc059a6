// The timeline: blocks that are dragged, trimmed and chosen; pushes and switches; a ruler and a needle.

import { fit } from "./renderer.js";

const clamp = (v, low, high) => Math.min(Math.max(v, low), high);
const round = (v) => Math.round(v * 100) / 100;

export class Timeline {
  constructor(find, robot, actions) {
    Object.assign(this, { find, robot, actions, zoom: 1, selected: null, view: null });
    this.lanes = find("lanes");
    const seek = (e) => {
      const box = this.lanes.getBoundingClientRect();
      actions.seek(clamp((e.clientX - box.left) / box.width, 0, 1) * this.view.seconds);
    };
    for (const canvas of [find("ruler"), find("strips")]) {
      canvas.addEventListener("pointerdown", (e) => { canvas.setPointerCapture(e.pointerId); this.held = true; seek(e); });
      canvas.addEventListener("pointermove", (e) => { if (this.held) seek(e); });
      canvas.addEventListener("pointerup", () => { this.held = false; });
    }
    find("timeline").addEventListener("wheel", (e) => {
      if (!e.ctrlKey) return;
      e.preventDefault();
      this.scale(this.zoom * Math.exp(-e.deltaY * 0.003));
    }, { passive: false });
    [this.width, this.needlePart] = [1000, find("needle")];
    new ResizeObserver(([{ contentRect }]) => { this.width = contentRect.width || 1000; this.drawRuler(); }).observe(find("ruler"));
  }

  scale(zoom) {
    this.zoom = clamp(zoom, 1, 200);
    this.lanes.style.width = `${100 * this.zoom}%`;
    this.drawRuler();
  }

  // Seconds of one pixel.
  get pace() { return this.view.seconds / (this.lanes.clientWidth || 1); }

  show(view) {
    this.view = view;
    const known = new Map(view.spans.map((span) => [span.id, span]));
    const at = (from, to) => `left:${(100 * from) / view.seconds}%;width:${(100 * Math.max(to - from, 0)) / view.seconds}%`;
    const lane = (name, items) => this.find(name).replaceChildren(...items.filter(Boolean));
    lane("motion", view.scene.motion.map((block) => this.block(block, known.get(block.id), at, false)));
    lane("over", view.scene.over.map((block) => this.block(block, known.get(block.id), at, true)));
    const event = (item, kind, seconds, words) => {
      const part = document.createElement("div");
      part.className = `event ${kind}`;
      part.style.cssText = at(item.at, item.at + seconds);
      part.title = words;
      this.movable(part, item.id, (time) => ({ do: "move", id: item.id, at: round(Math.max(item.at + time, 0)) }));
      return part;
    };
    const force = (push) => `${push.body}: ${Math.round(Math.hypot(...push.newtons))} N for ${round(push.seconds)} s`;
    const change = (s) => [
      s.friction !== undefined && `friction ${s.friction}`, s.load !== undefined && `${s.load} kg on ${s.body}`,
      s.strength !== undefined && `${s.joints} at ${Math.round(100 * s.strength)}%`,
    ].filter(Boolean).join(", ");
    lane("events", [
      ...view.scene.push.map((push) => event(push, "push", push.seconds, force(push))),
      ...view.scene.switch.map((s) => event(s, "switch", 0, change(s))),
    ]);
    this.drawRuler();
    this.mark();
  }

  block(block, span, at, over) {
    if (!span) return null;
    const part = document.createElement("div");
    part.className = "block";
    part.classList.toggle("doubt", span.doubt !== "");
    part.style.cssText = at(span.from, span.to);
    part.textContent = (block.sentence ?? block.clip ?? "").replace(/^builtin:/, "").replace(/^.*\//, "");
    part.title = [span.source, span.doubt].filter(Boolean).join("\n");
    const handle = (side) => {
      const grip = document.createElement("i");
      this.trim(grip, block, span, side);
      return grip;
    };
    part.prepend(handle("start"));
    part.append(handle("end"));
    part.points = () => this.points(block, span, over);
    const drop = over
      ? (time) => ({ do: "move", id: block.id, at: round(Math.max(block.at + time, 0)) })
      : (time) => this.moved(block, span, time);
    this.movable(part, block.id, drop);
    return part;
  }

  // Control points of the motion spline: dragged up they exaggerate the motion there, down they tone it down.
  points(block, span, over) {
    const [start, stop, speed] = [block.start ?? 0, block.end ?? span.whole, block.speed ?? 1];
    const shared = !over && this.view.scene.motion.indexOf(block) > 0 ? span.fade / 2 : 0;
    const dots = [];
    for (let at = start + this.robot.bends; at < stop - 0.1; at += this.robot.bends) {
      const place = span.from - shared + (at - start) / speed;
      if (place <= span.from || place >= span.to) continue;
      const near = block.points?.find((point) => Math.abs(point.at - at) < this.robot.bends / 2);
      const gain = near?.gain ?? 1;
      const dot = document.createElement("b");
      dot.className = "point";
      dot.classList.toggle("changed", near !== undefined);
      dot.style.left = `${(100 * (place - span.from)) / (span.to - span.from)}%`;
      dot.style.top = `${100 * (1 - gain / 2.5) * 0.9 + 5}%`;
      dot.title = `curve at ${round(at)} s: ${gain.toFixed(2)}×; drag up for more, down for less`;
      this.bend(dot, block.id, round(near?.at ?? at), gain);
      dots.push(dot);
    }
    return dots;
  }

  bend(dot, id, at, gain) {
    dot.addEventListener("pointerdown", (e) => {
      e.stopPropagation();
      dot.setPointerCapture(e.pointerId);
      const height = dot.parentElement.clientHeight || 1;
      const value = (m) => round(clamp(gain - (2.5 * (m.clientY - e.clientY)) / (3 * height), 0, 2.5));
      const move = (m) => { dot.style.top = `${100 * (1 - value(m) / 2.5) * 0.9 + 5}%`; };
      const end = (m) => {
        dot.removeEventListener("pointermove", move);
        if (Math.abs(m.clientY - e.clientY) > 2) this.actions.operate({ do: "point", id, at, gain: value(m) });
      };
      dot.addEventListener("pointermove", move);
      dot.addEventListener("pointerup", end, { once: true });
    });
  }

  // Where a block is dropped: before the first whose middle is behind its own.
  moved(block, span, time) {
    const middle = (span.from + span.to) / 2 + time;
    const order = this.view.scene.motion.map((b) => b.id);
    const middles = new Map(this.view.spans.map((s) => [s.id, (s.from + s.to) / 2]));
    const index = order.filter((id) => id !== block.id && middles.get(id) < middle).length;
    return index === order.indexOf(block.id) ? null : { do: "move", id: block.id, index };
  }

  movable(part, id, drop) {
    part.dataset.id = id;
    part.addEventListener("pointerdown", (e) => {
      if (e.target !== part) return;
      part.setPointerCapture(e.pointerId);
      this.actions.select(id);
      const from = e.clientX;
      const move = (m) => {
        part.classList.add("dragged");
        part.style.transform = `translateX(${m.clientX - from}px)`;
      };
      const end = (m) => {
        part.removeEventListener("pointermove", move);
        part.classList.remove("dragged");
        part.style.transform = "";
        const operation = Math.abs(m.clientX - from) > 4 ? drop((m.clientX - from) * this.pace) : null;
        if (operation) this.actions.operate(operation);
      };
      part.addEventListener("pointermove", move);
      part.addEventListener("pointerup", end, { once: true });
    });
  }

  trim(grip, block, span, side) {
    grip.addEventListener("pointerdown", (e) => {
      e.stopPropagation();
      grip.setPointerCapture(e.pointerId);
      this.actions.select(block.id);
      const from = e.clientX;
      const end = (m) => {
        const time = (m.clientX - from) * this.pace * (block.speed ?? 1);
        if (Math.abs(m.clientX - from) < 3) return;
        const [start, stop] = [block.start ?? 0, block.end ?? span.whole];
        const operation = { do: "trim", id: block.id, start: block.start, end: block.end };
        if (side === "start") operation.start = round(clamp(start + time, 0, stop - 0.2));
        else operation.end = round(clamp(stop + time, start + 0.2, span.whole));
        this.actions.operate(operation);
      };
      grip.addEventListener("pointerup", end, { once: true });
    });
  }

  select(id) {
    this.selected = id;
    this.mark();
  }

  mark() {
    for (const part of this.lanes.querySelectorAll("[data-id]")) {
      const chosen = part.dataset.id === this.selected;
      part.classList.toggle("selected", chosen);
      part.querySelectorAll(".point").forEach((dot) => dot.remove());
      if (chosen && part.points && this.robot.bends) part.append(...part.points());
    }
  }

  needle(time) {
    // Whole pixels: a needle that did not move is not drawn again.
    const share = Math.round((this.width * time) / (this.view?.seconds || 1)) / this.width;
    if (share === this.share) return;
    this.share = share;
    this.needlePart.style.left = `${100 * share}%`;
  }

  drawRuler() {
    const canvas = this.find("ruler");
    if (!this.view || !canvas.clientWidth) return;
    const { width, height } = fit(canvas);
    const c = canvas.getContext("2d");
    const style = getComputedStyle(document.documentElement);
    c.clearRect(0, 0, width, height);
    c.fillStyle = style.getPropertyValue("--soft");
    const ratio = width / canvas.clientWidth;
    c.font = `${10.5 * ratio}px system-ui`;
    const perSecond = width / this.view.seconds;
    const step = [0.1, 0.2, 0.5, 1, 2, 5, 10, 30, 60, 120, 300].find((s) => s * perSecond > 62 * ratio) ?? 600;
    for (let t = 0; t <= this.view.seconds; t += step) {
      c.fillRect(t * perSecond, height * 0.7, ratio, height * 0.3);
      c.fillText(`${Number(t.toFixed(1))} s`, t * perSecond + 4 * ratio, height * 0.72);
    }
  }
}
