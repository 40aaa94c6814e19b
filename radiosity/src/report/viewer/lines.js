// Lines in the scene, such as a patch's outline: ribbons of a width in pixels. Parts behind faces are drawn faintly.

const LINE_VERTEX = `#version 300 es
  in vec3 from; in vec3 to; in vec2 corner; in vec4 tint;
  uniform mat4 camera; uniform vec2 size; uniform float width;
  out vec4 colour;
  const float NEAR = 1e-3;
  void main() {
    vec4 a = camera * vec4(from, 1.0), b = camera * vec4(to, 1.0);
    if (a.w < NEAR && b.w < NEAR) { gl_Position = vec4(2.0, 2.0, 2.0, 1.0); return; }
    if (a.w < NEAR) a = mix(a, b, (NEAR - a.w) / (b.w - a.w));
    if (b.w < NEAR) b = mix(b, a, (NEAR - b.w) / (a.w - b.w));
    vec2 along = normalize((b.xy / b.w - a.xy / a.w) * size + vec2(1e-9, 0.0));
    vec4 p = corner.x < 0.5 ? a : b;
    // Ends overlap by half a width, so that outlines are closed.
    vec2 shift = vec2(-along.y, along.x) * corner.y + along * (corner.x < 0.5 ? -1.0 : 1.0);
    p.xy += shift * width / size * p.w;
    // Nearer than the face on which the line lies.
    p.z -= 4e-4 * p.w;
    gl_Position = p; colour = tint;
  }`;

const LINE_FRAGMENT = `#version 300 es
  precision highp float;
  in vec4 colour; uniform vec4 shade;
  out vec4 pixel;
  void main() { pixel = vec4(colour.rgb * shade.rgb, colour.a * shade.a); }`;

// Opacity of a part that is hidden behind faces.
const HIDDEN_OPACITY = 0.3;

class LineDrawer {
  constructor() {
    this.segments = [];
  }

  // Makes the program and the buffer; without lines nothing is made.
  open(gl) {
    this.program = null;
    this.set(gl, this.segments);
  }

  // Sets the lines: start, end and colour of each.
  set(gl, segments) {
    this.segments = segments;
    if (!gl || segments.length === 0) return;
    if (!this.program) {
      this.program = link_program(gl, LINE_VERTEX, LINE_FRAGMENT, console.error);
      this.arrays = gl.createVertexArray();
      this.buffer = gl.createBuffer();
    }
    if (!this.program) return;
    const corners = [[0, -1], [0, 1], [1, -1], [1, -1], [0, 1], [1, 1]];
    const vertices = segments.flatMap(([from, to, tint]) => corners.flatMap((corner) => [...from, ...to, ...corner, ...tint]));
    gl.bindVertexArray(this.arrays);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffer);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(vertices), gl.DYNAMIC_DRAW);
    let at = 0;
    for (const [name, size] of [["from", 3], ["to", 3], ["corner", 2], ["tint", 4]]) {
      const own = gl.getAttribLocation(this.program, name);
      gl.enableVertexAttribArray(own);
      gl.vertexAttribPointer(own, size, gl.FLOAT, false, 48, at);
      at += 4 * size;
    }
  }

  // Draws the lines with a dark border on a picture of this size; `scale` is the pixels of the screen per CSS pixel.
  draw(gl, camera, size, scale) {
    if (!this.program || this.segments.length === 0) return;
    gl.useProgram(this.program);
    gl.bindVertexArray(this.arrays);
    const uniform = (name) => gl.getUniformLocation(this.program, name);
    gl.uniformMatrix4fv(uniform("camera"), false, camera);
    gl.uniform2f(uniform("size"), ...size);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.disable(gl.CULL_FACE);
    gl.depthMask(false);
    for (const [depth, width, shade] of [
      [gl.ALWAYS, 3, [1, 1, 1, HIDDEN_OPACITY]], [gl.LEQUAL, 5, [0, 0, 0, 0.8]], [gl.LEQUAL, 3, [1, 1, 1, 1]],
    ]) {
      gl.depthFunc(depth);
      gl.uniform1f(uniform("width"), width * scale);
      gl.uniform4f(uniform("shade"), ...shade);
      gl.drawArrays(gl.TRIANGLES, 0, 6 * this.segments.length);
    }
    gl.depthMask(true);
    gl.depthFunc(gl.LESS);
    gl.enable(gl.CULL_FACE);
    gl.disable(gl.BLEND);
  }
}
