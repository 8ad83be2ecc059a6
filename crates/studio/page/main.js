// The studio: puts the parts of the page together, and names every action once.

import { keys } from "./keys.js";
import { Link } from "./link.js";
import { recordFilm } from "./renderer.js";
import { Panel } from "./panel.js";
import { Scene } from "./scene.js";
import { Strips } from "./strips.js";
import { Timeline } from "./timeline.js";
import { tour } from "./tour.js";

const find = (name) => document.querySelector(`[data-is=${name}]`);
const RATES = [0.25, 0.5, 1, 2, 4, 8];
const query = new URLSearchParams(location.search);

let view = null;
let head = null;
let selected = null;
let [shown, showing] = [0, 0];
const time = () => (head && view ? head.frame / view.hz : 0);

function theme(dark) {
  document.documentElement.dataset.theme = dark ? "dark" : "light";
  [scene.colours, scene.dirty] = [null, true];
  strips.draw();
  timeline.drawRuler();
}

// A text that is equal is not written again: each write makes the browser lay the page out.
function write(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

const playButton = document.querySelector("[data-do=play]");
let fading = 0;
function tell(text, bad = false) {
  const told = find("told");
  told.textContent = text;
  told.className = text ? `told shown${bad ? " bad" : ""}` : "told";
  clearTimeout(fading);
  fading = setTimeout(() => told.classList.remove("shown"), bad ? 9000 : 5000);
}

const robot = await (await fetch("robot.json")).json();
const operate = (operation) => link.operate(operation);
const chosen = () => view && [...view.scene.motion, ...view.scene.over].find((block) => block.id === selected);
const spanOf = (id) => view?.spans.find((span) => span.id === id);

// The time within a block's own clip at the needle.
function within(block) {
  const span = spanOf(block.id);
  // Two blocks share a fade; the place of the second begins in its middle.
  const shared = span && view.scene.motion.indexOf(block) > 0 ? span.fade / 2 : 0;
  return span ? Math.round((span.start + (time() + shared - span.from) * (block.speed ?? 1)) * 100) / 100 : 0;
}

function under() {
  const span = view?.spans.find((s) => view.scene.motion.some((b) => b.id === s.id) && s.from <= time() && time() < s.to);
  return view?.scene.motion.find((b) => b.id === span?.id);
}

function select(id) {
  selected = id;
  timeline.select(id);
  if (view) panel.show(view, id);
}

function push() {
  const azimuth = scene.camera.azimuth;
  const newtons = [-Math.cos(azimuth), -Math.sin(azimuth), 0].map((c) => Math.round(c * robot.weight * 0.4));
  operate({ do: "push", at: Math.round(time() * view.hz) / view.hz, seconds: 0.2, body: robot.heaviest, newtons });
}

// Plays the scene from its start, and records the picture.
let recorder = null;
function film() {
  if (recorder) return recorder.stop();
  [scene.filmed, scene.scale] = [true, 1];
  scene.draw();
  recorder = recordFilm(scene.canvas, (video, ending) => {
    [recorder, scene.filmed] = [null, false];
    tell(`Recorded ${view.name}.${ending}, ${(video.size / 1e6).toFixed(1)} MB.`);
    download(URL.createObjectURL(video), `${view.name}.${ending}`);
    window.studio.video = { type: video.type, size: video.size };
  });
  if (!recorder) return tell("This browser cannot record video.", true);
  tell("Recording; it ends with the scene, or with V.");
  link.send({ seek: 0 });
  link.send({ play: true });
}

function save(what) {
  if (what === "video") film();
  else if (what === "picture") {
    scene.draw();
    scene.canvas.toBlob((blob) => download(URL.createObjectURL(blob), `${view.name}.png`));
  } else {
    tell("Playing the scene from its start for the export ...");
    download(`export/${what}`);
  }
}

// Saves the scene, and shows the command that runs it: the studio itself drives no robot.
async function onRobot() {
  const answer = await fetch("run", { method: "POST" });
  const text = await answer.text();
  if (!answer.ok) return tell(text, true);
  find("command").textContent = text;
  find("simulate").textContent = `lifelike simulate-robot ${view.scene.robot} --once`;
  if (!find("robot").open) find("robot").showModal();
}

function copyCommand() {
  const text = find("command").textContent;
  if (!text) return;
  navigator.clipboard.writeText(text).then(() => tell("Copied."), () => getSelection().selectAllChildren(find("command")));
}

function download(address, name = "") {
  const link = Object.assign(document.createElement("a"), { href: address, download: name });
  link.click();
}

const split = () => {
  const block = chosen() ?? under();
  if (block) operate({ do: "split", id: block.id, at: within(block) });
};
const press = (name, on) => document.querySelector(`[data-do=${name}]`)?.setAttribute("aria-pressed", String(on));
function toggle(name) {
  scene.shows[name] = !scene.shows[name];
  press(name, scene.shows[name]);
  scene.dirty = true;
}

const onBlock = (make) => () => {
  const block = chosen() ?? under();
  const operation = block && make(block);
  if (operation) operate(operation);
};
const rate = (by) => {
  const at = RATES.findIndex((r) => r >= (view?.rate ?? 1) - 1e-6);
  link.send({ rate: RATES[Math.min(Math.max(at + by, 0), RATES.length - 1)] });
};
const neighbour = (by) => {
  const ids = view.spans.map((span) => span.id);
  const at = ids.indexOf(selected);
  select(ids[at < 0 ? 0 : (at + by + ids.length) % ids.length] ?? null);
};
const move = (by) => onBlock((block) => {
  const at = view.scene.motion.indexOf(block);
  const index = at + by;
  return at >= 0 && index >= 0 && index < view.scene.motion.length ? { do: "move", id: block.id, index } : null;
})();
const tilt = (by) => {
  scene.camera.elevation = Math.min(Math.max(scene.camera.elevation + by, -0.05), 1.5);
  scene.dirty = true;
  operate({ do: "camera", ...scene.seen() });
};

// Another policy performs; what the one before did stays beside it as a ghost.
const perform = (name) => {
  link.send({ keep: true });
  operate({ do: "policy", name: name || undefined });
};
const similar = () => {
  const block = chosen() ?? under();
  if (!block) return;
  select(block.id);
  tell("Looking for clips that are like this ...");
  link.send({ similar: time() });
};

const ACTIONS = {
  play: () => link.send({ play: !head?.playing }),
  type: () => find("sentence").focus(),
  back: () => link.send({ step: -1 }), on: () => link.send({ step: 1 }),
  secondBack: () => link.send({ step: -view.hz }), secondOn: () => link.send({ step: view.hz }),
  start: () => link.send({ seek: 0 }), end: () => link.send({ seek: view.seconds }),
  slower: () => rate(-1), faster: () => rate(1),
  previous: () => neighbour(-1), next: () => neighbour(1), nothing: () => select(null),
  earlier: () => move(-1), later: () => move(1),
  trimStart: onBlock((block) => ({ do: "trim", id: block.id, start: within(block), end: block.end })),
  trimEnd: onBlock((block) => ({ do: "trim", id: block.id, start: block.start, end: within(block) })),
  split, push,
  mirror: onBlock((block) => ({ do: "mirror", id: block.id })),
  loop: onBlock((block) => ({ do: "repeat", id: block.id, times: (block.repeat ?? 1) + 1 })),
  unloop: onBlock((block) => ({ do: "repeat", id: block.id, times: Math.max((block.repeat ?? 1) - 1, 1) })),
  blockSlower: onBlock((block) => ({ do: "speed", id: block.id, value: Math.round((block.speed ?? 1) * 90) / 100 })),
  blockFaster: onBlock((block) => ({ do: "speed", id: block.id, value: Math.round((block.speed ?? 1) * 110) / 100 })),
  remove: () => { if (selected) operate({ do: "remove", id: selected }); },
  take: onBlock((block) => block.sentence && { do: "sentence", id: block.id, seed: (block.seed ?? 0) + 1 }),
  best: onBlock((block) => block.sentence && { do: "sentence", id: block.id, best_of: 8 }),
  slippery: () => operate({ do: "switch", at: Math.round(time() * 50) / 50, friction: 0.15 }),
  reference: () => toggle("reference"), errors: () => toggle("errors"),
  handles: () => { toggle("handles"); if (scene.shows.handles) link.send({ play: false }); },
  keep: () => link.send({ keep: !view.kept }),
  similar,
  feasible: onBlock((block) => ({ do: "feasible", id: block.id, value: !block.feasible })),
  video: () => save("video"),
  follow: () => { toggle("follow"); operate({ do: "camera", ...scene.seen() }); },
  higher: () => tilt(0.1), lower: () => tilt(-0.1),
  theme: () => theme(document.documentElement.dataset.theme !== "dark"),
  page: () => save("page"),
  robot: onRobot, copy: copyCommand,
  undo: () => link.send("undo"), redo: () => link.send("redo"),
  help: () => find("keys").showModal(),
};
const act = (name) => { if (view) ACTIONS[name]?.(); };

const strips = new Strips(find("strips"));
const timeline = new Timeline(find, robot, { seek: (t) => link.send({ seek: t }), operate, select });
const panel = new Panel(find("panel"), robot, { operate, time, within, push, split, perform, similar, seek: (t) => link.send({ seek: t }) });
const scene = new Scene(find("canvas"), robot, {
  pull: (body, newtons) => link.send({ pull: { body, newtons } }),
  release: () => link.send("release"),
  pulling: () => { if (!head?.playing) link.send({ play: true }); },
  moved: (body, by) => {
    const block = under();
    if (!block) return tell("Move the needle into a block first: handles change its clip.", true);
    link.send({ keep: true });
    operate({ do: "edit", id: block.id, body, at: within(block), by });
  },
  force: (text, x, y) => {
    const label = find("force");
    label.hidden = text === null;
    if (text === null) return;
    const box = scene.canvas.getBoundingClientRect();
    label.textContent = text;
    Object.assign(label.style, { left: `${x - box.left}px`, top: `${y - box.top}px` });
  },
  looked: (camera) => { if (robot.mayEdit && view && JSON.stringify(camera) !== JSON.stringify(view.scene.camera)) operate({ do: "camera", ...camera }); },
});

const link = new Link({
  connected: (on) => { if (!on) tell("The studio does not answer; trying again ...", true); else if (view) tell("Connected again."); },
  refused: (text) => tell(text, true),
  view: (next) => {
    const first = !view;
    view = next;
    if (first) scene.look({ azimuth: -0.9, elevation: 0.2, distance: 2.6, follow: true, ...view.scene.camera });
    document.title = `${view.name} · lifelike studio`;
    find("name").textContent = view.name;
    find("rate").value = String(view.rate);
    press("keep", view.kept);
    for (const [name, steps] of [["undo", view.steps[0]], ["redo", view.steps[1]]]) {
      document.querySelector(`[data-do=${name}]`).disabled = !steps || !robot.mayEdit;
    }
    for (const list of ["motion", "over", "push", "switch"]) view.scene[list] ??= [];
    if (selected && ![...view.scene.motion, ...view.scene.over, ...view.scene.push, ...view.scene.switch].some((b) => b.id === selected)) selected = null;
    timeline.selected = selected;
    timeline.show(view);
    panel.show(view, selected);
    if (view.problem) tell(view.problem, true);
    document.documentElement.dataset.version = view.version;
  },
  strips: (bytes) => strips.take(bytes),
  frame: (bytes) => {
    const was = head?.fallen;
    head = scene.frame(bytes);
    if (!view) return;
    if (recorder?.state === "recording" && head.frame + 1 >= head.frames) recorder.stop();
    const now = time();
    // Conditions in the panel are those of the needle.
    if (!head.playing && head.frame !== shown) {
      shown = head.frame;
      clearTimeout(showing);
      showing = setTimeout(() => panel.show(view, selected), 120);
    }
    scene.pushes = view.scene.push.filter((p) => p.at <= now && now < p.at + p.seconds)
      .map((p) => ({ body: robot.character.bodies.indexOf(p.body), newtons: p.newtons })).filter((p) => p.body >= 0);
    timeline.needle(now);
    // Figures that run are read ten times a second at most.
    const figures = head.playing ? Math.floor(now * 10) / 10 : now;
    write(find("clock"), `${figures.toFixed(head.playing ? 1 : 2)} / ${view.seconds.toFixed(1)} s`);
    playButton.classList.toggle("playing", head.playing);
    if (head.fallen && !was) {
      const fall = view.falls.findLast((f) => f.second <= now + 0.02);
      tell(fall ? `It fell: ${fall.cause}${fall.why ? `; ${fall.why}` : ""}` : "It fell.", true);
    }
  },
});

document.querySelectorAll("[data-do]").forEach((button) => button.addEventListener("click", () => { act(button.dataset.do); button.blur(); }));
keys(find("keys"), act);
find("say").addEventListener("submit", (e) => {
  e.preventDefault();
  const input = find("sentence");
  if (input.value.trim()) operate({ do: "say", text: input.value.trim() });
  input.value = "";
});
find("rate").addEventListener("change", (e) => { link.send({ rate: Number(e.target.value) }); e.target.blur(); });
find("clips").append(...robot.clips.map((clip) => new Option(clip.replace(/^builtin:/, ""), clip)));
find("clips").addEventListener("change", (e) => {
  if (e.target.value) operate({ do: "add", clip: e.target.value });
  e.target.value = "";
  e.target.blur();
});
find("export").addEventListener("change", (e) => {
  if (e.target.value) save(e.target.value);
  e.target.value = "";
  e.target.blur();
});

// Files that are dropped are read once by the studio, which says what they are, and join the motion.
async function take(file) {
  tell(`Reading ${file.name} ...`);
  const answer = await fetch(`drop/${encodeURIComponent(file.name)}`, { method: "PUT", body: file });
  const text = await answer.text();
  if (!answer.ok) return tell(text, true);
  const { clip, told } = JSON.parse(text);
  tell(told);
  operate({ do: "add", clip });
}
let inside = 0;
const carries = (e) => e.dataTransfer?.types.includes("Files");
addEventListener("dragenter", (e) => { if (carries(e)) find("drop").hidden = !(inside += 1); });
addEventListener("dragleave", (e) => { if (carries(e)) find("drop").hidden = (inside -= 1) <= 0; });
addEventListener("dragover", (e) => e.preventDefault());
addEventListener("drop", async (e) => {
  e.preventDefault();
  inside = 0;
  find("drop").hidden = true;
  for (const file of e.dataTransfer.files) await take(file);
});

theme(query.has("theme") ? query.get("theme") === "dark" : matchMedia("(prefers-color-scheme: dark)").matches);
if (!robot.mayEdit) for (const part of document.querySelectorAll(".say input, .say button, .say select, [data-do=robot]")) part.disabled = true;
if (!query.has("no-tour") && robot.mayEdit) tour(find("tour"));
// For tests and for the curious.
window.studio = { scene, link, act, actions: ACTIONS, get view() { return view; }, get head() { return head; } };
document.documentElement.dataset.ready = "1";
