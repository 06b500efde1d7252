// Surfaces, translucent: by one WebGL context that all figures share, or where there is none, by sorted triangles.
// Both promise an image to lay over the picture. The GPU's is read back once it is done, so that nothing waits for it.

const VERTEX = `
attribute vec3 place, normal; attribute float opacity;
uniform vec3 right, up, eye; uniform vec2 shift, scale;
varying vec3 facing; varying float shown;
void main() {
  gl_Position = vec4(vec2(dot(place, right), dot(place, up)) * scale + shift, -dot(place, eye) / 9.0, 1.0);
  facing = vec3(dot(normal, right), dot(normal, up), dot(normal, eye)); shown = opacity;
}`;
const FRAGMENT = `
precision mediump float;
uniform vec3 color; varying vec3 facing; varying float shown;
void main() {
  vec3 n = normalize(facing);
  float light = 0.7 + 0.38 * max(dot(n, vec3(-0.42, 0.62, 0.66)), 0.0);
  float alpha = shown * (0.42 + 0.3 * pow(1.0 - abs(n.z), 3.0));
  gl_FragColor = vec4(min(color * light, 1.0) * alpha, alpha);
}`;

class Gpu {
  // Throws where there is no WebGL.
  constructor() {
    this.canvas = document.createElement('canvas');
    this.image = document.createElement('canvas');
    const gl = this.canvas.getContext('webgl2', { antialias: true });
    if (!gl) throw new Error('no WebGL');
    this.gl = gl;
    const program = gl.createProgram();
    for (const [type, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error('no shaders');
    gl.useProgram(program);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    ['place', 'normal', 'opacity'].forEach((name, i) => {
      const at = gl.getAttribLocation(program, name);
      gl.enableVertexAttribArray(at);
      gl.vertexAttribPointer(at, [3, 3, 1][i], gl.FLOAT, false, 28, [0, 12, 24][i]);
    });
    const names = ['right', 'up', 'eye', 'scale', 'shift', 'color'];
    this.uniform = Object.fromEntries(names.map((name) => [name, gl.getUniformLocation(program, name)]));
    gl.enable(gl.CULL_FACE);
    gl.frontFace(gl.CW); // as pixels are read from below, the picture stands on its head
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  }

  get lost() {
    return this.gl.isContextLost();
  }

  // Of each body only the side towards the eye is seen. Where both are, the farther is painted first: B where it is
  // behind A, then A, then B where it is before A. So convex bodies that overlap are right in every pixel.
  async paint(a, b, camera, width, height, colors) {
    const gl = this.gl;
    if (this.canvas.width !== width || this.canvas.height !== height) {
      [this.canvas.width, this.canvas.height] = [width, height];
    }
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.colorMask(true, true, true, true);
    gl.depthMask(true);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    for (const name of ['right', 'up', 'eye']) gl.uniform3fv(this.uniform[name], camera[name]);
    const [x, y] = camera.middle;
    gl.uniform2f(this.uniform.scale, (2 * camera.scale) / width, (-2 * camera.scale) / height);
    gl.uniform2f(this.uniform.shift, (2 * x) / width - 1, (2 * y) / height - 1);
    const draw = (body, color, compare, writes) => {
      if (!body || !body.surface.length) return;
      gl.bufferData(gl.ARRAY_BUFFER, body.surface, gl.STREAM_DRAW);
      gl.uniform3fv(this.uniform.color, color);
      gl.depthFunc(compare);
      gl.depthMask(writes);
      gl.colorMask(!writes, !writes, !writes, !writes);
      gl.drawArrays(gl.TRIANGLES, 0, body.surface.length / 7);
    };
    draw(a, colors.a, gl.LESS, true);
    gl.enable(gl.POLYGON_OFFSET_FILL); // faces in one plane: A's is the nearer
    gl.polygonOffset(1, 2);
    draw(b, colors.b, gl.GREATER, false);
    gl.disable(gl.POLYGON_OFFSET_FILL);
    draw(a, colors.a, gl.LEQUAL, false);
    gl.enable(gl.POLYGON_OFFSET_FILL);
    draw(b, colors.b, gl.LEQUAL, false);
    gl.disable(gl.POLYGON_OFFSET_FILL);
    return this.read(width, height);
  }

  async read(width, height) {
    const gl = this.gl;
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, buffer);
    gl.bufferData(gl.PIXEL_PACK_BUFFER, 4 * width * height, gl.STREAM_READ);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, 0);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
    const fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    let state = gl.TIMEOUT_EXPIRED;
    while (state === gl.TIMEOUT_EXPIRED) {
      await new Promise((done) => setTimeout(done, 2));
      state = gl.clientWaitSync(fence, 0, 0);
    }
    const pixels = new Uint8ClampedArray(4 * width * height);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, buffer);
    gl.getBufferSubData(gl.PIXEL_PACK_BUFFER, 0, pixels);
    gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
    gl.deleteBuffer(buffer);
    gl.deleteSync(fence);
    if (this.lost) throw new Error('WebGL is gone');
    for (let i = 0; i < pixels.length; i += 4) {
      const alpha = pixels[i + 3];
      if (alpha && alpha < 255) for (let k = i; k < i + 3; k++) pixels[k] = (255 * pixels[k]) / alpha;
    }
    [this.image.width, this.image.height] = [width, height];
    this.image.getContext('2d').putImageData(new ImageData(pixels, width, height), 0, 0);
    return this.image;
  }
}

class Painter {
  constructor() {
    this.canvas = document.createElement('canvas');
    this.image = document.createElement('canvas');
    this.lost = false;
  }

  // All triangles towards the eye, the farthest first, painted opaque and then laid over the picture as one.
  async paint(a, b, camera, width, height, colors) {
    this.canvas.width = width;
    this.canvas.height = height;
    const own = this.canvas.getContext('2d');
    const found = [];
    for (const [body, color] of [[a, colors.a], [b, colors.b]]) {
      const corners = body ? body.corners : [];
      for (let i = 0; i < corners.length; i += 3) {
        const three = corners.slice(i, i + 3);
        const normal = three.reduce((sum, corner) => along(sum, 1 / 3, corner.slice(3, 6)), [0, 0, 0]);
        if (dot(normal, camera.eye) <= 0) continue;
        const depth = three.reduce((sum, corner) => sum + dot(corner, camera.eye), 0);
        const faded = Math.min(...three.map((corner) => corner[6])) < 0.1;
        const turned = [dot(normal, camera.right), dot(normal, camera.up), dot(normal, camera.eye)];
        const light = 0.7 + 0.38 * Math.max(0, dot(turned, [-0.42, 0.62, 0.66]));
        if (!faded) found.push([depth, three, color.map((c) => Math.min(255, Math.round(255 * c * light)))]);
      }
    }
    found.sort((one, other) => one[0] - other[0]);
    own.lineJoin = 'round';
    for (const [, three, color] of found) {
      own.fillStyle = own.strokeStyle = `rgb(${color})`;
      own.beginPath();
      for (const corner of three) own.lineTo(...camera.project(corner));
      own.closePath();
      own.fill();
      own.stroke();
    }
    [this.image.width, this.image.height] = [width, height];
    const faded = this.image.getContext('2d');
    faded.globalAlpha = 0.55;
    faded.drawImage(this.canvas, 0, 0);
    return this.image;
  }
}

let painter = null;
function surfaces(...wanted) {
  if (!painter || painter.lost) {
    try {
      painter = new Gpu();
    } catch {
      painter = new Painter();
    }
  }
  return painter.paint(...wanted).catch(() => (painter = new Painter()).paint(...wanted));
}
