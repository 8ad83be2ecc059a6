// `?film`: one view of a clip without controls, frame by frame, for `lifelike render`.
// clip=NAME|INDEX, azimuth=RADIANS, elevation=RADIANS, distance=HEIGHTS, reference=overlay|beside|off, contacts=0|1, still.

const base64Of = (bytes) => {
  let text = "";
  for (let i = 0; i < bytes.length; i += 0x8000) text += String.fromCharCode(...bytes.subarray(i, i + 0x8000));
  return btoa(text);
};

function film() {
  const number = (name, otherwise) => (query.has(name) ? Number(query.get(name)) : otherwise);
  const clip = decodePlayback(data.playbacks[number("clip", 0)]);
  document.body.replaceChildren(document.createElement("canvas"));
  document.body.className = "film";
  const stage = makeStage(document.body.firstChild);
  const view = fit(stage.canvas);
  const camera = new Camera(data.characters[clip.character].height);
  camera.azimuth = number("azimuth", camera.azimuth);
  camera.elevation = number("elevation", camera.elevation);
  if (query.has("distance")) camera.distance = number("distance") * data.characters[clip.character].height;
  const options = { reference: query.get("reference") || "overlay", follow: !query.has("still") };
  const colours = stageColours();
  const draw = (time) => {
    const { items, reach } = compose(clip, camera, time, options);
    const marks = query.get("contacts") === "0" ? [] : contactMarks(clip, time, items, colours);
    stage.draw(view, camera, items, colours, reach, marks);
  };
  let encoder = null;
  let chunks = [];
  let broken = null;
  let description = null;
  const keep = (chunk, { decoderConfig } = {}) => {
    const bytes = new Uint8Array(chunk.byteLength);
    chunk.copyTo(bytes);
    chunks.push([chunk.type === "key", base64Of(bytes)]);
    if (decoderConfig?.description) description = base64Of(new Uint8Array(decoderConfig.description));
  };
  window.film = {
    png(time) {
      draw(time);
      return stage.canvas.toDataURL("image/png").split(",")[1];
    },
    // Begins a film in H.264; returns whether this browser can.
    async begin(fps, bitrate) {
      if (!window.VideoEncoder) return false;
      const { width, height } = view;
      // High profile, level 5.1: everything up to 4096 x 2304.
      const config = { codec: "avc1.640033", width, height, framerate: fps, bitrate, avc: { format: "avc" } };
      if (!(await VideoEncoder.isConfigSupported(config)).supported) return false;
      encoder = new VideoEncoder({ output: keep, error: (e) => { broken = e.message; } });
      encoder.configure(config);
      return true;
    },
    // Encodes frames at these times; returns the samples that are complete: [is key frame, base64].
    async add(first, times, fps) {
      for (const [i, time] of times.entries()) {
        draw(time);
        const frame = new VideoFrame(stage.canvas, { timestamp: Math.round((first + i) * 1e6 / fps) });
        encoder.encode(frame, { keyFrame: (first + i) % Math.round(2 * fps) === 0 });
        frame.close();
        if (encoder.encodeQueueSize > 8) await new Promise((next) => setTimeout(next, 5));
      }
      return this.taken();
    },
    // Ends the film; returns what `add` does.
    async end() {
      await encoder.flush();
      return this.taken();
    },
    taken() {
      if (broken) throw new Error(broken);
      const samples = chunks;
      chunks = [];
      return { samples, description };
    },
  };
}
