// `?strip`: physics above reference at evenly spaced instants, as a picture for a document.
// clip=NAME|INDEX, n=FRAMES, from=SECONDS, to=SECONDS, azimuth=RADIANS, elevation=RADIANS, theme=light|dark.

function strip() {
  const number = (name, otherwise) => (query.has(name) ? Number(query.get(name)) : otherwise);
  const wanted = query.get("clip") || "0";
  const found = data.playbacks.findIndex((p, i) => p.name === wanted || String(i) === wanted);
  const clip = decodePlayback(data.playbacks[Math.max(found, 0)]);
  const character = data.characters[clip.character];
  const n = Math.max(number("n", 10), 2);
  const [from, to] = [number("from", 0), Math.min(number("to", clip.duration), clip.duration)];
  document.body.replaceChildren();
  document.body.className = "strip";
  const make = (tag, text, parent = document.body) => {
    const element = document.createElement(tag);
    element.textContent = text;
    parent.append(element);
    return element;
  };
  make("h1", clip.name);
  if (clip.note) make("p", clip.note);
  const [upper, lower] = clip.labels;
  const shadow = data.characters[clip.referenceCharacter];
  const rows = [[upper, clip.simulated, false, character], [lower, clip.reference, "solid", shadow]]
    .filter(([, track]) => track);
  const frame = make("div", "");
  const canvas = make("canvas", "", frame);
  canvas.style.aspectRatio = `${n} / ${1.5 * rows.length}`;
  rows.forEach(([name], row) => {
    const label = make("span", name, frame);
    label.style.top = `calc(${100 * row / rows.length}% + 6px)`;
  });
  const times = make("ol", "");
  const stage = makeStage(canvas);
  fit(stage.canvas);
  const { width, height } = stage.canvas;
  const camera = new Camera(character.height);
  camera.azimuth = number("azimuth", camera.azimuth);
  camera.elevation = number("elevation", 0.14);
  camera.angle = 0.42;
  camera.distance = character.height * 2.7;
  for (let i = 0; i < n; i++) {
    const time = from + (to - from) * i / (n - 1);
    const item = make("li", `${time.toFixed(2)} s`, times);
    if (clip.fall !== null && time >= clip.fall) item.className = "fell";
    rows.forEach(([, track, ghost, figure], row) => {
      const root = track.root(time);
      camera.target = [root[0], root[1], character.height * 0.5];
      const left = Math.round(width * i / n);
      const top = Math.round(height * row / rows.length);
      const bottom = Math.round(height * (row + 1) / rows.length);
      const view = { x: left, y: height - bottom, width: Math.round(width * (i + 1) / n) - left, height: bottom - top };
      stage.draw(view, camera, [{ character: figure, pose: track.pose(time, [0, 0, 0]), ghost }], stageColours(),
        character.height * 1.2);
    });
  }
}
