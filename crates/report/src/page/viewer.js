// Playback: which clip, which time, seen from where.

function stageColours() {
  const style = getComputedStyle(document.documentElement);
  const rgb = (name) => {
    const hex = style.getPropertyValue(name).trim();
    return [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255);
  };
  const dark = style.getPropertyValue("--dark").trim() === "1";
  return {
    paper: rgb("--stage"), floor: rgb("--floor"), line: rgb("--grid"), ghost: rgb("--reference"),
    sky: dark ? [0.5, 0.53, 0.6] : [0.74, 0.77, 0.82], shadow: dark ? 0.62 : 0.3,
  };
}

function makeStage(canvas) {
  try {
    if (query.has("flat")) throw new Error("asked for");
    return new Stage(canvas);
  } catch (error) {
    // A canvas that was asked for WebGL gives no 2D context any more.
    const fresh = canvas.cloneNode();
    canvas.replaceWith(fresh);
    return new FlatStage(fresh);
  }
}

function fit(canvas) {
  const ratio = Math.min(window.devicePixelRatio || 1, 2);
  const [w, h] = [Math.round(canvas.clientWidth * ratio), Math.round(canvas.clientHeight * ratio)];
  if (canvas.width !== w || canvas.height !== h) Object.assign(canvas, { width: w, height: h });
  return { x: 0, y: 0, width: w, height: h };
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
    this.find("note").textContent = this.clip.note;
    const [simulated, reference] = this.clip.labels;
    this.find("legend-physics").textContent = simulated;
    this.find("legend-reference").textContent = reference;
    this.find("reference").lastElementChild.textContent = `${simulated[0].toUpperCase()}${simulated.slice(1)} only`;
    this.find("legend-physics").hidden = !this.clip.simulated;
    this.find("legend-reference").hidden = !this.clip.reference;
    this.drawScrub();
    this.dirty = true;
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
      this.time = (this.time + passed * this.speed) % this.clip.duration;
      this.dirty = true;
    }
    if (this.dirty) this.draw();
    requestAnimationFrame((next) => this.tick(next));
  }

  draw() {
    this.dirty = false;
    const { clip, camera, character } = this;
    const main = clip.simulated || clip.reference;
    const root = this.follow ? main.calmRoot(this.time) : main.root(0);
    camera.target = [root[0] + camera.pan[0], root[1] + camera.pan[1], character.height * 0.46 + camera.pan[2]];
    const items = [];
    if (clip.simulated) items.push({ character, pose: clip.simulated.pose(this.time, [0, 0, 0]), ghost: false });
    let reach = character.height * 1.3;
    if (clip.reference && (this.reference !== "off" || !clip.simulated)) {
      const beside = clip.simulated && this.reference === "beside";
      const gap = beside ? character.height * 0.75 : 0;
      const offset = camera.right().map((c) => c * gap);
      if (beside) {
        reach *= 1.6;
        camera.target = camera.target.map((c, k) => c + offset[k] / 2);
      }
      const ghost = clip.simulated && !beside ? "glass" : "solid";
      items.push({ character, pose: clip.reference.pose(this.time, offset), ghost });
    }
    this.stage.draw(fit(this.canvas), camera, items, stageColours(), reach);
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
