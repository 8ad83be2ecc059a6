// Playback: which clip, which time, seen from where.

// The figures of a clip at a time, and a camera that looks at them. `reference`: overlay | beside | off.
function compose(clip, camera, time, { reference, follow }) {
  const character = data.characters[clip.character];
  const main = clip.simulated || clip.reference;
  const root = follow ? main.calmRoot(time) : main.root(0);
  camera.target = [root[0] + camera.pan[0], root[1] + camera.pan[1], character.height * 0.46 + camera.pan[2]];
  const items = [];
  if (clip.simulated) items.push({ character, pose: clip.simulated.pose(time, [0, 0, 0]), ghost: false });
  let reach = character.height * 1.3;
  if (clip.reference && (reference !== "off" || !clip.simulated)) {
    const beside = clip.simulated && reference === "beside";
    const gap = beside ? character.height * 0.75 : 0;
    const offset = camera.right().map((c) => c * gap);
    if (beside) {
      reach *= 1.6;
      camera.target = camera.target.map((c, k) => c + offset[k] / 2);
    }
    const ghost = clip.simulated && !beside ? "glass" : "solid";
    items.push({ character: data.characters[clip.referenceCharacter], pose: clip.reference.pose(time, offset), ghost });
  }
  return { items, reach };
}

// Arrows: ground force in physics, half a robot's height for its weight. Pads: contacts of the reference.
function contactMarks(clip, time, items, colours) {
  const { height } = data.characters[clip.character];
  const frame = (clip.simulated || clip.reference).locate(time + 0.5 / clip.fps)[0];
  const figure = items[0];
  const robots = items.filter((item) => item.character === figure.character);
  const planned = robots[robots.length - 1];
  const at = ({ pose }, foot) => [0, 1, 2].map((r) => pose[foot.body][12 + r]
    + [0, 1, 2].reduce((sum, k) => sum + pose[foot.body][k * 4 + r] * foot.at[k], 0));
  const marks = [];
  for (const foot of clip.feet) {
    if (foot.down[frame]) {
      const [x, y, z] = at(planned, foot);
      marks.push({ kind: "pad", at: [x, y, Math.max(z, 0) + 0.003], size: [height * 0.075, 1], colour: colours.ghost, alpha: 0.5 });
    }
    const force = (foot.force[frame] || 0) / 100;
    if (force > 0.02) {
      marks.push({ kind: "arrow", at: at(figure, foot), size: [height * 0.02, force * height * 0.5], colour: colours.force, alpha: 0.9 });
    }
  }
  return marks;
}

const clock = (t) => `${t.toFixed(2)} s`;

class Viewer {
  constructor(root) {
    this.root = root;
    this.find = (name) => root.querySelector(`[data-is=${name}]`);
    this.stage = makeStage(this.find("canvas"));
    this.canvas = this.stage.canvas;
    this.scrub = this.find("scrub");
    this.playing = !query.has("t");
    this.time = Number(query.get("t")) || 0;
    this.speed = 1;
    this.reference = query.get("reference") || "overlay";
    this.follow = true;
    this.decoded = new Map();
    this.wire();
    this.list();
    const wanted = query.get("clip");
    const at = data.playbacks.findIndex((p, i) => p.name === wanted || String(i) === wanted);
    this.choose(Math.max(at, 0), this.time);
    this.before = performance.now();
    requestAnimationFrame((now) => this.tick(now));
  }

  choose(index, time = 0) {
    this.index = index;
    if (!this.decoded.has(index)) this.decoded.set(index, decodePlayback(data.playbacks[index]));
    this.clip = this.decoded.get(index);
    const character = data.characters[this.clip.character];
    if (character !== this.character) {
      this.character = character;
      this.camera = Object.assign(this.camera || new Camera(character.height), {});
      this.camera.home(character.height);
    }
    if (!this.attached) {
      this.camera.attach(this.canvas, () => { this.dirty = true; });
      this.attached = true;
    }
    this.time = time;
    this.find("select").value = String(index);
    for (const [i, item] of [...this.find("list").children].entries()) {
      item.setAttribute("aria-current", String(i === index));
    }
    for (const button of this.find("reference").children) button.disabled = !(this.clip.simulated && this.clip.reference);
    this.find("joints").disabled = !this.clip.jointNames.length;
    this.find("contacts").disabled = !this.clip.feet.length;
    if (!this.clip.own && this.reference === "overlay") this.reference = "beside";
    this.press("reference", this.reference);
    this.drawJoints();
    this.find("note").textContent = this.clip.note;
    this.find("shade").hidden = !this.clip.error;
    const [simulated, reference] = this.clip.labels;
    this.find("legend-physics").textContent = simulated;
    this.find("legend-reference").textContent = reference;
    this.find("reference").lastElementChild.textContent = `${simulated[0].toUpperCase()}${simulated.slice(1)} only`;
    this.find("legend-physics").hidden = !this.clip.simulated;
    this.find("legend-reference").hidden = !this.clip.reference;
    this.drawScrub();
    this.dirty = true;
  }

  // Other clips in place of those there are; the view stays.
  replace() {
    const { name } = this.clip;
    this.decoded.clear();
    this.find("select").replaceChildren();
    this.find("list").replaceChildren();
    this.list();
    const index = Math.max(data.playbacks.findIndex((p) => p.name === name), 0);
    this.choose(index, Math.min(this.time, (data.playbacks[index].frames - 1) / data.playbacks[index].fps));
  }

  list() {
    data.playbacks.forEach((p, i) => {
      const option = document.createElement("option");
      option.value = String(i);
      option.textContent = p.note ? `${p.name}: ${p.note}` : p.name;
      this.find("select").append(option);
      const item = document.createElement("button");
      const [name, note] = [document.createElement("b"), document.createElement("span")];
      name.textContent = p.name;
      note.textContent = p.note;
      if (p.fall !== null) item.classList.add("fell");
      item.append(name, note);
      item.addEventListener("click", () => this.choose(i));
      this.find("list").append(item);
    });
  }

  wire() {
    const segment = (name, apply) => {
      for (const button of this.find(name).children) {
        button.addEventListener("click", () => { apply(button.value); this.press(name, button.value); });
      }
    };
    segment("speed", (v) => { this.speed = Number(v); });
    segment("reference", (v) => { this.reference = v; });
    this.press("speed", "1");
    this.press("reference", this.reference);
    this.find("play").addEventListener("click", () => this.toggle());
    this.find("follow").addEventListener("click", () => {
      this.follow = !this.follow;
      this.camera.pan = [0, 0, 0];
      this.find("follow").setAttribute("aria-pressed", String(this.follow));
      this.dirty = true;
    });
    const toggle = (name, apply) => this.find(name).addEventListener("click", () => {
      this[name] = !this[name];
      this.find(name).setAttribute("aria-pressed", String(this[name]));
      apply();
      this.dirty = true;
    });
    this.contacts = true;
    toggle("contacts", () => {});
    this.joints = query.has("joints");
    this.find("joints").setAttribute("aria-pressed", String(this.joints));
    toggle("joints", () => this.drawJoints());
    this.find("picture").addEventListener("click", () => savePicture(this));
    this.find("video").addEventListener("click", () => saveVideo(this));
    this.find("home").addEventListener("click", () => { this.camera.home(this.character.height); this.dirty = true; });
    this.find("select").addEventListener("change", (e) => this.choose(Number(e.target.value)));
    const seek = (e) => {
      const box = this.scrub.getBoundingClientRect();
      this.time = Math.min(Math.max((e.clientX - box.left) / box.width, 0), 1) * this.clip.duration;
      this.dirty = true;
    };
    this.scrub.addEventListener("pointerdown", (e) => {
      this.scrub.setPointerCapture(e.pointerId);
      this.held = true;
      seek(e);
    });
    this.scrub.addEventListener("pointermove", (e) => { if (this.held) seek(e); });
    for (const end of ["pointerup", "pointercancel"]) this.scrub.addEventListener(end, () => { this.held = false; });
    this.root.addEventListener("keydown", (e) => {
      if (e.target.tagName === "SELECT") return;
      const step = { ArrowLeft: -1, ArrowRight: 1 }[e.key];
      if (e.key === " ") this.toggle();
      else if (step) {
        this.playing = false;
        this.time = Math.min(Math.max(this.time + step / this.clip.fps, 0), this.clip.duration);
      } else return;
      e.preventDefault();
      this.dirty = true;
    });
    new ResizeObserver(() => { this.drawScrub(); this.dirty = true; }).observe(this.root);
    themeChanged.push(() => { this.drawScrub(); this.dirty = true; });
  }

  press(name, value) {
    for (const button of this.find(name).children) button.setAttribute("aria-pressed", String(button.value === value));
    this.dirty = true;
  }

  toggle() {
    this.playing = !this.playing;
    if (this.playing && this.time >= this.clip.duration) this.time = 0;
    this.dirty = true;
  }

  tick(now) {
    // The first frame may carry a time before the viewer was made.
    const passed = Math.min(Math.max((now - this.before) / 1000, 0), 0.1);
    this.before = now;
    if (this.playing && !this.held && this.clip.duration > 0) {
      const time = this.time + passed * this.speed;
      if (this.recorder && time >= this.clip.duration) this.recorder.stop();
      this.time = time % this.clip.duration;
      this.dirty = true;
    }
    if (this.dirty) this.draw();
    requestAnimationFrame((next) => this.tick(next));
  }

  draw() {
    this.dirty = false;
    const { clip, camera } = this;
    const { items, reach } = compose(clip, camera, this.time, this);
    const colours = stageColours();
    this.stage.draw(fit(this.canvas), camera, items, colours, reach, this.contacts ? contactMarks(clip, this.time, items, colours) : []);
    if (this.joints) this.panels.forEach((p) => p.hover(this.time));
    this.find("play").setAttribute("aria-label", this.playing ? "Pause" : "Play");
    this.find("play").classList.toggle("playing", this.playing);
    this.find("time").textContent = `${clock(this.time)} / ${clock(clip.duration)}`;
    this.find("needle").style.left = `${100 * this.time / (clip.duration || 1)}%`;
    this.find("error").textContent = clip.error
      ? `body error ${(100 * clip.error[clip.simulated.locate(this.time)[0]]).toFixed(1)} cm` : "";
    const fallen = clip.fall !== null && this.time >= clip.fall;
    this.find("fallen").hidden = !fallen;
    if (fallen) this.find("fallen").textContent = `fell at ${clip.fall.toFixed(2)} s`;
  }

  // Joints over time, those that are farthest off first.
  drawJoints() {
    const root = this.find("plots");
    root.hidden = !this.joints || !this.clip.jointNames.length;
    this.panels = [];
    root.replaceChildren();
    if (root.hidden) return;
    const { clip } = this;
    const n = clip.jointNames.length;
    const column = (values, j) => Array.from({ length: values.length / n }, (_, f) => values[f * n + j] * 1e-4 * 180 / Math.PI);
    const x = Array.from({ length: clip.frames }, (_, f) => f / clip.fps);
    const curves = clip.jointNames.map((name, j) => {
      const lines = clip.joints.map((values, k) => ({ label: clip.labels[k], x, y: column(values, j) })).filter((l) => l.y.length);
      const off = lines.length > 1 ? lines[0].y.reduce((sum, y, f) => sum + Math.abs(y - lines[1].y[f]), 0) : 0;
      return { name: name.replaceAll("_", " ").replace(/ joint$/, ""), lines, off };
    });
    const degrees = (v) => `${v.toFixed(1)}°`;
    const seek = (t) => { if (t !== null) { this.playing = false; this.time = t; this.dirty = true; } };
    this.panels = curves.sort((a, b) => b.off - a.off).map((curve) => new Panel(curve, seek, degrees));
    root.append(...this.panels.map((p) => p.root));
    this.panels.forEach((p) => p.draw(0));
  }

  // The body error over time, behind the scrubber; where the fall happened.
  drawScrub() {
    const canvas = this.find("spark");
    const view = fit(canvas);
    const c = canvas.getContext("2d");
    const style = getComputedStyle(document.documentElement);
    c.clearRect(0, 0, view.width, view.height);
    const { error, fall, duration } = this.clip;
    if (error) {
      const top = Math.max(0.1, ...error);
      c.fillStyle = style.getPropertyValue("--spark");
      c.beginPath();
      c.moveTo(0, view.height);
      error.forEach((e, i) => {
        c.lineTo(i / Math.max(error.length - 1, 1) * view.width, view.height * (1 - 0.86 * e / top));
      });
      c.lineTo(view.width, view.height);
      c.fill();
    }
    if (fall !== null) {
      c.fillStyle = style.getPropertyValue("--bad");
      c.fillRect(fall / duration * view.width - 1, 0, 2, view.height);
    }
  }
}

// Files from the page itself.
function download(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}

const fileName = (viewer, ending) => `${viewer.clip.name.replace(/[^\w.-]+/g, "_")}.${ending}`;

function savePicture(viewer) {
  viewer.draw();
  viewer.canvas.toBlob((blob) => download(blob, fileName(viewer, "png")), "image/png");
}

// The clip once, from its beginning, at 60 frames a second and in the time that it takes.
function saveVideo(viewer) {
  if (viewer.recorder) return viewer.recorder.stop();
  const button = viewer.find("video");
  const recorder = recordFilm(viewer.canvas, (film, ending) => {
    [viewer.recorder, viewer.playing, button.textContent] = [null, false, "Video"];
    download(film, fileName(viewer, ending));
  });
  if (!recorder) return alert("This browser cannot record video.");
  [viewer.recorder, viewer.time, viewer.playing, button.textContent] = [recorder, 0, true, "Stop"];
}
