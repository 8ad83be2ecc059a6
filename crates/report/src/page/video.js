// Films of a canvas, recorded while it plays: mp4 where the browser can write it, else WebM; the ending says which.

const FILMS = ["video/mp4;codecs=avc1.640033", "video/mp4;codecs=vp9", "video/webm;codecs=vp9", "video/webm;codecs=vp8", "video/webm"];

// Begins to record; `done` gets the film and the ending of its name. Returns the recorder, and nothing without one.
function recordFilm(canvas, done) {
  const mimeType = window.MediaRecorder && FILMS.find((kind) => MediaRecorder.isTypeSupported(kind));
  if (!mimeType) return null;
  const recorder = new MediaRecorder(canvas.captureStream(60), { mimeType, videoBitsPerSecond: 12e6 });
  const parts = [];
  const type = mimeType.split(";")[0];
  recorder.ondataavailable = (e) => parts.push(e.data);
  recorder.onstop = () => done(new Blob(parts, { type }), type.replace("video/", ""));
  recorder.start();
  return recorder;
}
