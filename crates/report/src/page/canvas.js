// A canvas to draw on: WebGL or flat, its size, and the colours of the theme.

function stageColours() {
  const style = getComputedStyle(document.documentElement);
  const rgb = (name) => {
    const hex = style.getPropertyValue(name).trim();
    return [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255);
  };
  const dark = style.getPropertyValue("--dark").trim() === "1";
  return {
    force: rgb("--force"), paper: rgb("--stage"), floor: rgb("--floor"), line: rgb("--grid"), ghost: rgb("--reference"),
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

function fit(canvas, scale = 1) {
  const ratio = Math.min(window.devicePixelRatio || 1, 2) * scale;
  const [w, h] = [Math.round(canvas.clientWidth * ratio), Math.round(canvas.clientHeight * ratio)];
  if (canvas.width !== w || canvas.height !== h) Object.assign(canvas, { width: w, height: h });
  return { x: 0, y: 0, width: w, height: h };
}
