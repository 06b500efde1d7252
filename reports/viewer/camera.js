// Vectors, and the orthographic camera that orbits the middle of the picture; z is up.

const dot = (u, v) => u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
const cross = (u, v) => [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
const along = (p, s, v) => [p[0] + s * v[0], p[1] + s * v[1], p[2] + s * v[2]];
const times = (s, v) => [s * v[0], s * v[1], s * v[2]];
const unit = (v) => times(1 / (Math.hypot(...v) || 1), v);
const across = (n) => unit(cross(n, Math.abs(n[0]) < 0.6 ? [1, 0, 0] : [0, 1, 0]));

const FILL = 0.87; // share of the canvas that the picture's radius takes
const RADIANS = Math.PI / 180;

class Camera {
  constructor([azimuth, elevation]) {
    this.home = [azimuth, elevation];
    this.reset();
  }

  reset() {
    [this.azimuth, this.elevation] = this.home;
    this.zoom = 1;
    this.shift = [0, 0];
  }

  // Angles in degrees; never over the poles, so that up stays up.
  turn(left, up) {
    this.azimuth += left;
    this.elevation = Math.max(-89, Math.min(89, this.elevation + up));
  }

  // Zoom by a factor, keeping what is at (x, y), in pixels from the middle, where it is.
  magnify(factor, x = 0, y = 0) {
    const zoom = Math.max(0.3, Math.min(40, this.zoom * factor));
    const by = zoom / this.zoom;
    this.shift = [x - by * (x - this.shift[0]), y - by * (y - this.shift[1])];
    this.zoom = zoom;
  }

  move(x, y) {
    this.shift = [this.shift[0] + x, this.shift[1] + y];
  }

  // Fix the axes for a canvas of this many pixels.
  aim(width, height) {
    const [turn, rise] = [this.azimuth * RADIANS, this.elevation * RADIANS];
    this.right = [-Math.sin(turn), Math.cos(turn), 0];
    this.eye = [Math.cos(rise) * Math.cos(turn), Math.cos(rise) * Math.sin(turn), Math.sin(rise)];
    this.up = cross(this.eye, this.right);
    this.scale = (FILL * this.zoom * Math.min(width, height)) / 2;
    this.middle = [width / 2 + this.shift[0], height / 2 + this.shift[1]];
  }

  project(p) {
    return [this.middle[0] + this.scale * dot(p, this.right), this.middle[1] - this.scale * dot(p, this.up)];
  }
}
