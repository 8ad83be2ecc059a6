// The scene in WebGL 2: lit bodies, their soft shadow, the ground; and a plain way to draw it where pixels are slow.

const VERTEX = `#version 300 es
layout(location=0) in vec3 position; layout(location=1) in vec3 normal; layout(location=2) in vec3 colour;
uniform mat4 model, camera, light;
out vec3 world, across, tint; out vec4 lit;
void main() {
  vec4 w = model * vec4(position, 1.0);
  world = w.xyz; across = mat3(model) * normal; tint = colour;
  lit = light * vec4(w.xyz + normalize(across) * 0.006, 1.0);
  gl_Position = camera * w;
}`;

const SHADE = `#version 300 es
precision highp float; precision highp sampler2DShadow;
in vec3 world, across, tint; in vec4 lit;
uniform vec3 eye, sun, sky, floorTint, paper, ghost, focus;
uniform float ghostly, alpha, ground, reach, depthOfShadow;
uniform vec3 line;
uniform vec4 heat;
uniform int taps;
uniform sampler2DShadow shadow;
out vec4 result;

float sunlight() {
  vec3 p = lit.xyz / lit.w * 0.5 + 0.5;
  if (p.z > 1.0 || any(lessThan(p.xy, vec2(0.0))) || any(greaterThan(p.xy, vec2(1.0)))) return 1.0;
  float spread = ground > 0.5 ? 2.6 : 1.3, sum = 0.0;
  float turn = fract(52.9829 * fract(dot(gl_FragCoord.xy, vec2(0.06711, 0.00584)))) * 6.2832;
  for (int i = 0; i < taps; i++) {
    float r = sqrt((float(i) + 0.5) / float(taps)), a = float(i) * 2.39996 + turn;
    sum += texture(shadow, vec3(p.xy + vec2(cos(a), sin(a)) * r * spread / 1024.0 * 2.0, p.z - 0.0012));
  }
  return sum / float(taps);
}
float grid(vec2 p, float cell, float width) {
  vec2 w = fwidth(p), d = abs(fract(p / cell - 0.5) - 0.5) * cell;
  vec2 l = 1.0 - smoothstep(vec2(width), vec2(width) + w * 1.2, d);
  return max(l.x, l.y) * clamp(cell * 0.22 / max(w.x, w.y), 0.0, 1.0);
}
void main() {
  if (ground > 0.5) {
    float away = distance(world.xy, focus.xy), fade = 1.0 - smoothstep(reach * 0.35, reach, away);
    vec3 c = mix(floorTint, line, 0.5 * grid(world.xy, 0.25, 0.001) * (1.0 - smoothstep(0.0, reach * 0.45, away)));
    c = mix(c, line, grid(world.xy, 1.0, 0.003));
    c *= mix(1.0, sunlight(), depthOfShadow);
    result = vec4(mix(paper, c, fade), 1.0);
    return;
  }
  vec3 base = pow(ghostly > 0.5 ? ghost : mix(tint, heat.rgb, heat.a), vec3(2.2));
  vec3 n = normalize(across), v = normalize(eye - world), h = normalize(sun + v);
  float direct = max(dot(n, sun), 0.0) * (ghostly > 0.5 && alpha < 0.99 ? 1.0 : sunlight());
  float grounded = mix(0.62, 1.0, smoothstep(-0.02, 0.25, world.z));
  vec3 c = base * (mix(vec3(0.30, 0.28, 0.27), sky, n.z * 0.5 + 0.5) * grounded + direct * vec3(1.02, 0.97, 0.9));
  c += vec3(0.16) * pow(max(dot(n, h), 0.0), 42.0) * direct;
  float rim = pow(1.0 - max(dot(n, v), 0.0), 3.0);
  c += base * rim * 0.35;
  result = vec4(pow(c, vec3(1.0 / 2.2)), alpha < 0.99 ? alpha + rim * 0.35 : 1.0);
}`;

const DEPTH_ONLY = `#version 300 es
precision mediump float;
void main() {}`;

// Colour of bodies that have none of their own.
const PLAIN_BODY = [0.86, 0.52, 0.33];
// No colour over a body's own.
const COLD = [0, 0, 0, 0];

// Opacity of a ghost of glass.
const GLASS = 0.32;

// Draws figures of glass: depth first, then colour, so that only the front of the whole figure is seen. Half a centimetre
// farther away, so that two figures in one place do not flicker into each other.
function drawGlass(gl, figures, draw) {
  gl.enable(gl.POLYGON_OFFSET_FILL);
  gl.polygonOffset(1, 2000);
  gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE);
  for (const figure of figures) {
    gl.colorMask(false, false, false, false);
    draw(figure);
    gl.colorMask(true, true, true, true);
    gl.enable(gl.BLEND);
    gl.depthFunc(gl.LEQUAL);
    draw(figure);
    gl.depthFunc(gl.LESS);
    gl.disable(gl.BLEND);
  }
  gl.disable(gl.POLYGON_OFFSET_FILL);
}

// The matrix of a mark.
function markMatrix({ at, size: [radius, length], along }) {
  const up = along || [0, 0, 1];
  const across = normalize(cross(Math.abs(up[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0], up));
  const axes = [[cross(up, across), radius], [across, radius], [up, length]];
  return [...axes.flatMap(([axis, size]) => [...axis.map((c) => c * size), 0]), ...at, 1];
}

class Stage {
  static SHADOW = 1024;

  constructor(canvas) {
    const gl = canvas.getContext("webgl2", { antialias: false, preserveDrawingBuffer: true });
    if (!gl) throw new Error("no WebGL 2");
    this.canvas = canvas;
    this.gl = gl;
    // Samples of the shadow at each pixel: fewer are coarser and faster.
    this.taps = 20;
    this.plain = null;
    this.shade = this.program(VERTEX, SHADE);
    this.depth = this.program(VERTEX, DEPTH_ONLY);
    this.meshes = new Map();
    const n = 40;
    this.floor = this.upload([-n, -n, 0, 0, 0, 1, 1, 1, 1, n, -n, 0, 0, 0, 1, 1, 1, 1, n, n, 0, 0, 0, 1, 1, 1, 1,
      -n, n, 0, 0, 0, 1, 1, 1, 1], [0, 1, 2, 0, 2, 3]);
    this.shadow = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.shadow);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.DEPTH_COMPONENT24, Stage.SHADOW, Stage.SHADOW);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_COMPARE_MODE, gl.COMPARE_REF_TO_TEXTURE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    this.target = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.target);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, this.shadow, 0);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.enable(gl.DEPTH_TEST);
    this.smooth = { frame: gl.createFramebuffer(), colour: gl.createRenderbuffer(), depth: gl.createRenderbuffer(), size: [] };
  }

  // Binds a picture of four samples a pixel; a canvas of its own samples could not go without them later.
  bindSmooth() {
    const gl = this.gl;
    const { frame, colour, depth, size } = this.smooth;
    const { width, height } = this.canvas;
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    if (size[0] === width && size[1] === height) return;
    this.smooth.size = [width, height];
    for (const [buffer, format, place] of [[colour, gl.RGBA8, gl.COLOR_ATTACHMENT0], [depth, gl.DEPTH_COMPONENT24, gl.DEPTH_ATTACHMENT]]) {
      gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
      gl.renderbufferStorageMultisample(gl.RENDERBUFFER, Math.min(4, gl.getParameter(gl.MAX_SAMPLES)), format, width, height);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, place, gl.RENDERBUFFER, buffer);
    }
  }

  showSmooth({ x, y, width, height }) {
    const gl = this.gl;
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, this.smooth.frame);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, null);
    const box = [x, y, x + width, y + height];
    gl.blitFramebuffer(...box, ...box, gl.COLOR_BUFFER_BIT, gl.NEAREST);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }

  drawShadowMap(items, light) {
    const gl = this.gl;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.target);
    gl.viewport(0, 0, Stage.SHADOW, Stage.SHADOW);
    gl.disable(gl.SCISSOR_TEST);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    gl.useProgram(this.depth.program);
    gl.uniformMatrix4fv(this.depth.uniforms.camera, false, light);
    for (const item of items) if (item.ghost !== "glass") this.drawBodies(this.depth.uniforms, item);
  }

  program(vertex, fragment) {
    const gl = this.gl;
    const program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
    const uniforms = {};
    for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); i++) {
      const { name } = gl.getActiveUniform(program, i);
      uniforms[name] = gl.getUniformLocation(program, name);
    }
    return { program, uniforms };
  }

  upload(vertices, indices) {
    const gl = this.gl;
    const vao = gl.createVertexArray();
    gl.bindVertexArray(vao);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(vertices), gl.STATIC_DRAW);
    for (let k = 0; k < 3; k++) {
      gl.enableVertexAttribArray(k);
      gl.vertexAttribPointer(k, 3, gl.FLOAT, false, 36, k * 12);
    }
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(indices), gl.STATIC_DRAW);
    gl.bindVertexArray(null);
    return { vao, count: indices.length };
  }

  bodies(character) {
    if (!this.meshes.has(character)) {
      this.meshes.set(character, bodyMeshes(character, PLAIN_BODY).map((m) => this.upload(m.vertices, m.indices)));
    }
    return this.meshes.get(character);
  }

  // Draws in the plain way from now on.
  goPlain() {
    this.plain ??= new PlainStage(this.gl, this.program(PLAIN_VERTEX, PLAIN_PIXEL));
  }

  drawBodies(uniforms, item) {
    const gl = this.gl;
    this.bodies(item.character).forEach((mesh, body) => {
      if (!mesh.count) return;
      if (uniforms.heat) gl.uniform4fv(uniforms.heat, item.heat ? item.heat[body] : COLD);
      gl.uniformMatrix4fv(uniforms.model, false, item.pose[body]);
      gl.bindVertexArray(mesh.vao);
      gl.drawElements(gl.TRIANGLES, mesh.count, gl.UNSIGNED_INT, 0);
    });
  }

  // Contacts and forces: [{kind: "arrow" | "pad" | "ball", at, size: [radius, length], colour, alpha, along: unit vector, else up, over: seen through bodies}].
  drawMarks(u, marks) {
    const gl = this.gl;
    this.marks ??= Object.fromEntries(Object.entries(markMeshes()).map(([k, m]) => [k, this.upload(m.vertices, m.indices)]));
    gl.uniform1f(u.ghostly, 1);
    gl.enable(gl.BLEND);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE);
    for (const mark of marks) {
      const { kind, colour, alpha, over } = mark;
      if (over) gl.disable(gl.DEPTH_TEST);
      gl.uniform3fv(u.ghost, colour);
      gl.uniform1f(u.alpha, alpha);
      gl.uniformMatrix4fv(u.model, false, markMatrix(mark));
      gl.bindVertexArray(this.marks[kind].vao);
      gl.drawElements(gl.TRIANGLES, this.marks[kind].count, gl.UNSIGNED_INT, 0);
      gl.enable(gl.DEPTH_TEST);
    }
    gl.disable(gl.BLEND);
  }

  // Draws one view. `view`: {x, y, width, height} in device pixels from the lower left; `camera`: Camera;
  // `items`: [{character, pose, ghost: false | "solid" | "glass", tint: colour of a ghost, heat: colour and share over each body's own}]; `reach`: size of what must be in the shadow (m).
  draw(view, camera, items, colours, reach, marks = []) {
    const gl = this.gl;
    const sun = normalize([0.42, -0.28, 0.86]);
    if (this.plain) return this.plain.draw(view, camera, items, colours, sun, marks);
    const focus = camera.target;
    const light = multiply(orthographic(reach, reach * 5),
      lookAt(focus.map((c, k) => c + sun[k] * reach * 2.5), focus));

    this.drawShadowMap(items, light);
    this.bindSmooth();

    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(view.x, view.y, view.width, view.height);
    gl.viewport(view.x, view.y, view.width, view.height);
    gl.clearColor(...colours.paper, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const { program, uniforms: u } = this.shade;
    gl.useProgram(program);
    gl.bindTexture(gl.TEXTURE_2D, this.shadow);
    gl.uniformMatrix4fv(u.camera, false, camera.matrix(view.width / view.height));
    gl.uniformMatrix4fv(u.light, false, light);
    gl.uniform3fv(u.eye, camera.eye());
    gl.uniform3fv(u.sun, sun);
    gl.uniform3fv(u.sky, colours.sky);
    gl.uniform3fv(u.floorTint, colours.floor);
    gl.uniform3fv(u.paper, colours.paper);
    gl.uniform3fv(u.line, colours.line);
    gl.uniform3fv(u.ghost, colours.ghost);
    gl.uniform3fv(u.focus, focus);
    gl.uniform1f(u.reach, camera.distance * 2.6);
    gl.uniform1f(u.depthOfShadow, colours.shadow);
    gl.uniform1i(u.taps, this.taps);
    gl.uniform1f(u.ghostly, 0);
    gl.uniform1f(u.alpha, 1);

    gl.uniform1f(u.ground, 1);
    gl.uniformMatrix4fv(u.model, false, [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, focus[0], focus[1], 0, 1]);
    gl.bindVertexArray(this.floor.vao);
    gl.drawElements(gl.TRIANGLES, this.floor.count, gl.UNSIGNED_INT, 0);
    gl.uniform1f(u.ground, 0);

    for (const item of items.filter((i) => i.ghost !== "glass")) {
      gl.uniform1f(u.ghostly, item.ghost ? 1 : 0);
      this.drawBodies(u, item);
    }
    drawGlass(gl, items.filter((i) => i.ghost === "glass"), (item) => {
      gl.uniform1f(u.ghostly, 1);
      gl.uniform3fv(u.ghost, item.tint ?? colours.ghost);
      gl.uniform1f(u.alpha, GLASS);
      this.drawBodies(u, item);
    });
    this.drawMarks(u, marks);
    gl.bindVertexArray(null);
    this.showSmooth(view);
  }
}
