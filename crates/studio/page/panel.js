// The panel: properties of what is chosen; of nothing, those of the scene.

const element = (tag, text, properties = {}) => Object.assign(document.createElement(tag), { textContent: text }, properties);

function field(name, input, words) {
  const label = element("label", "");
  label.append(element("span", name), input);
  if (words) {
    const out = element("output", words(input.value));
    input.addEventListener("input", () => { out.textContent = words(input.value); });
    label.append(out);
  }
  return label;
}

function range(low, high, step, value, change) {
  const input = element("input", "", { type: "range", min: low, max: high, step });
  input.value = value;
  input.addEventListener("change", () => change(Number(input.value)));
  return input;
}

function buttons(...all) {
  const row = element("div", "", { className: "row" });
  row.append(...all.filter(Boolean).map(([text, title, act]) => {
    const button = element("button", text, { title, type: "button" });
    button.addEventListener("click", act);
    return button;
  }));
  return row;
}

export class Panel {
  constructor(root, robot, actions) {
    Object.assign(this, { root, robot, actions });
  }

  show(view, id) {
    // Whoever types in the panel keeps the field.
    if (this.root.contains(document.activeElement) && document.activeElement.type === "text" && this.id === id) return;
    [this.id, this.view] = [id, view];
    const { scene } = view;
    const block = [...scene.motion, ...scene.over].find((b) => b.id === id);
    const push = scene.push.find((p) => p.id === id);
    const change = scene.switch.find((s) => s.id === id);
    const span = view.spans.find((s) => s.id === id);
    const parts = block ? this.block(block, span) : push ? this.push(push) : change ? this.change(change) : this.scene(view);
    this.root.replaceChildren(...parts.filter(Boolean));
  }

  remove(id) { return ["Remove", "Remove (Delete)", () => this.actions.operate({ do: "remove", id })]; }

  block(block, span) {
    const { operate } = this.actions;
    const id = block.id;
    const parts = [element("h2", block.sentence ?? block.clip.replace(/^builtin:/, ""))];
    if (span) parts.push(element("p", span.source));
    if (span?.changed) parts.push(element("p", span.changed));
    if (span?.doubt) parts.push(element("p", span.doubt, { className: "bad" }));
    if (block.sentence !== undefined) {
      const text = element("input", "", { type: "text", maxLength: 300 });
      text.value = block.sentence;
      text.addEventListener("change", () => { text.blur(); operate({ do: "sentence", id, text: text.value }); });
      parts.push(field("sentence", text));
    }
    const seconds = (v) => `${Number(v).toFixed(1)} s`;
    parts.push(
      field("speed", range(0.25, 3, 0.05, block.speed ?? 1, (value) => operate({ do: "speed", id, value })), (v) => `${Number(v).toFixed(2)}×`),
      field("fade", range(0, 1.5, 0.05, block.fade ?? span?.fade ?? 0.3, (v) => operate({ do: "fade", id, seconds: v })), seconds),
      block.at === undefined && field("stand first", range(0, 5, 0.1, block.wait ?? 0, (v) => operate({ do: "wait", id, seconds: v })), seconds),
      field("repeat", range(1, 12, 1, block.repeat ?? 1, (times) => operate({ do: "repeat", id, times })), (v) => `${v}×`),
      field("more, less", range(0.2, 2, 0.05, block.gain ?? 1, (gain) => operate({ do: "style", id, gain, smooth: block.smooth })), (v) => `${Number(v).toFixed(2)}×`),
      field("calm", range(0, 12, 0.5, block.smooth ? 12.5 - block.smooth : 0, (v) => operate({ do: "style", id, gain: block.gain, smooth: v > 0 ? 12.5 - v : undefined })),
        (v) => (v > 0 ? `${(12.5 - v).toFixed(1)} Hz` : "off")),
      this.robot.bends && field("curve here", range(0, 2.5, 0.05, this.point(block)?.gain ?? 1, (gain) => operate({ do: "point", id, at: this.point(block)?.at ?? this.actions.within(block), gain })),
        (v) => `${Number(v).toFixed(2)}×`),
      ...this.alike(block),
      buttons(
        [block.feasible ? "As it was" : "Make feasible", "Repair what cannot be tracked (G)", () => operate({ do: "feasible", id, value: !block.feasible })],
        (block.edits || block.points || block.gain || block.smooth || block.feasible) && ["Plain", "Remove style and changed points", () => operate({ do: "plain", id })],
      ),
      buttons(
        [block.mirror ? "Mirrored" : "Mirror", "Exchange left and right (M)", () => operate({ do: "mirror", id })],
        block.at === undefined && ["Split", "Split at the needle (S)", () => this.actions.split()],
        block.sentence !== undefined && ["Another take", "Another random seed (A)", () => operate({ do: "sentence", id, seed: (block.seed ?? 0) + 1 })],
        block.sentence !== undefined && ["Best of 8", "Choose the most feasible of eight (B)", () => operate({ do: "sentence", id, best_of: 8 })],
        this.remove(id),
      ),
    );
    return parts;
  }

  // Clips that are like the motion at the needle; each joins the motion behind the block.
  alike(block) {
    const { view } = this;
    if (!this.robot.searches || block.at !== undefined) return [];
    const ask = buttons(["More like this", "Find clips that are like this moment (W)", () => this.actions.similar()]);
    const [at, found] = view.similar ?? [0, []];
    const span = view.spans.find((s) => s.id === block.id);
    if (!span || at < span.from || at >= span.to) return [ask];
    const index = view.scene.motion.indexOf(block) + 1;
    const hits = found.map(({ clip, time, similarity }) => {
      const name = clip.replace(/^builtin:/, "").replace(/^.*\//, "").replaceAll("_", " ");
      const hit = element("button", `${name}  ${time.toFixed(1)} s  ${similarity.toFixed(2)}`, { className: "hit", title: `Add ${clip} behind this block` });
      hit.addEventListener("click", () => this.actions.operate({ do: "add", clip, index }));
      return hit;
    });
    return [ask, ...hits];
  }

  // The changed control point near the needle.
  point(block) {
    const at = this.actions.within(block);
    return block.points?.find((point) => Math.abs(point.at - at) < 0.33);
  }

  push(push) {
    return [
      element("h2", `Push of ${Math.round(Math.hypot(...push.newtons))} N`),
      element("p", `${push.body} for ${push.seconds.toFixed(2)} s at ${push.at.toFixed(2)} s`),
      buttons(this.remove(push.id)),
    ];
  }

  change(change) {
    return [element("h2", "Switch"), element("p", `from ${change.at.toFixed(2)} s on`), buttons(this.remove(change.id))];
  }

  scene(view) {
    const { operate, time } = this.actions;
    const last = (key) => view.scene.switch.findLast((s) => s[key] !== undefined && s.at <= time() + 1e-6)?.[key];
    const at = () => Math.round(time() * 50) / 50;
    const set = (values) => operate({ do: "switch", at: at(), ...values });
    const torso = this.robot.heaviest;
    const joints = element("select", "");
    joints.append(...["motor", ...this.robot.joints].map((name) => element("option", name.replaceAll("_", " "), { value: name })));
    joints.addEventListener("change", () => { if (joints.selectedIndex) set({ joints: joints.value, strength: 0 }); });
    const policies = element("select", "");
    policies.append(element("option", "the best", { value: "" }), ...this.robot.policies.map((name) => element("option", name.replace(/\.controller\.safetensors$/, ""), { value: name })));
    policies.value = view.scene.policy ?? "";
    policies.addEventListener("change", () => this.actions.perform(policies.value));
    const parts = element("select", "");
    parts.append(...this.robot.parts.map((part) => element("option", part.replaceAll("_", " "), { value: part })));
    const clips = element("select", "");
    clips.append(element("option", "of ...", { value: "" }), ...this.robot.clips.map((clip) => element("option", clip.replace(/^builtin:/, ""), { value: clip })));
    clips.addEventListener("change", () => { if (clips.value) operate({ do: "lay", clip: clips.value, at: at(), parts: [parts.value] }); });
    const said = element("input", "", { type: "text", maxLength: 300, placeholder: "or of a sentence" });
    said.addEventListener("change", () => { if (said.value) operate({ do: "lay", text: said.value, at: at(), parts: [parts.value] }); said.blur(); });
    const falls = view.falls.slice(0, 12).map((fall) => {
      const button = element("button", `falls at ${fall.second.toFixed(2)} s, ${fall.cause}${fall.why ? `: ${fall.why}` : ""}`, { className: "fall" });
      button.addEventListener("click", () => this.actions.seek(Math.max(fall.second - 0.5, 0)));
      return button;
    });
    const verdict = view.falls.length ? `${view.falls.length} ${view.falls.length === 1 ? "fall" : "falls"}` : "stays on its feet";
    return [
      element("h2", this.robot.character.name), element("p", `${view.seconds.toFixed(1)} s, ${verdict}`), ...falls,
      this.robot.policies.length > 1 && field("policy", policies),
      element("hr", ""), element("p", "From the needle on:"),
      field("friction", range(0.05, 1.5, 0.05, last("friction") ?? 1, (friction) => set({ friction })), (v) => Number(v).toFixed(2)),
      field("load", range(0, 10, 0.25, last("load") ?? 0, (load) => set({ load, body: torso })), (v) => `${Number(v).toFixed(1)} kg`),
      field("fails", joints), field("lay over", parts), field("", clips), field("", said),
      buttons(["Push", "Push the trunk (P)", () => this.actions.push()]),
    ].filter(Boolean);
  }
}
