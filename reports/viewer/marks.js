// Everything that is drawn by lines: edges and outlines of bodies, points, arrows and planes, letters, axes, scale.

const LAYERS = ['given', 'proof', 'truth', 'engine'];
const DASHES = { engine: [6, 4], proof: [2, 4] };

class Pen {
  constructor(context, camera, colors, ratio) {
    Object.assign(this, { context, camera, colors, ratio, taken: [] });
    context.lineJoin = context.lineCap = 'round';
    context.textBaseline = 'middle';
    context.textAlign = 'center';
  }

  set(color, width, alpha = 1, dash = []) {
    const context = this.context;
    context.strokeStyle = context.fillStyle = color;
    context.lineWidth = width * this.ratio;
    context.globalAlpha = alpha;
    context.setLineDash(dash.map((x) => x * this.ratio));
  }

  font(size, weight = 400) {
    this.context.font = `${weight} ${size * this.ratio}px system-ui, sans-serif`;
    return this.context;
  }

  path(points, closed = false) {
    this.context.beginPath();
    for (const point of points) this.context.lineTo(...point);
    if (closed) this.context.closePath();
  }

  // Edges: those behind the body are faint; of a smooth body only those where it turns away are strong.
  edges(body, color, hidden) {
    const eye = this.camera.eye;
    for (const { p, q, n, m, weak } of body.strokes) {
      const [front, other] = n ? [dot(n, eye) > 0, dot(m, eye) > 0] : [true, true];
      if ((front || other) === hidden) continue;
      const strength = front === other ? weak : Math.max(weak, n === m ? 0 : 1);
      if (!strength) continue;
      this.set(color, 1.5, strength * (hidden ? 0.28 : 1), hidden ? [3, 4] : []);
      this.context.lineCap = weak < 1 ? 'butt' : 'round'; // caps would show as beads on faint circles
      this.path([this.camera.project(p), this.camera.project(q)]);
      this.context.stroke();
    }
    this.context.lineCap = 'round';
    if (hidden) return;
    this.set(color, 1.5);
    for (const outline of body.outlines) {
      this.path(hull(outline.map((p) => this.camera.project(p))), true);
      this.context.stroke();
    }
    for (const p of body.dots) this.disc(this.camera.project(p), 4, true);
  }

  disc([x, y], radius, filled) {
    this.context.beginPath();
    this.context.arc(x, y, radius * this.ratio, 0, 2 * Math.PI);
    if (filled) this.context.fill();
    else this.context.stroke();
  }

  mark([layer, kind, numbers, label]) {
    const [at, to] = [times(1e-4, numbers.slice(0, 3)), times(1e-4, numbers.slice(3))];
    const color = this.colors[layer === 'given' ? 'truth' : layer];
    const [start, end] = [this.camera.project(at), this.camera.project(to)];
    this.set(color, layer === 'engine' ? 2.5 : 2, layer === 'given' ? 0.55 : 1, DASHES[layer] || []);
    if (kind === 'plane') this.plane(at, to, color);
    else if (kind === 'dot') {
      this.context.setLineDash([]);
      this.disc(start, layer === 'engine' ? 5.5 : 3.5, layer !== 'engine');
    } else {
      this.path([start, end]);
      this.context.stroke();
      if (kind !== 'line') this.head(start, end);
      if (kind === 'spin') this.head(start, this.camera.project(along(at, 0.9, along(to, -1, at))));
    }
    const word = kind === 'plane' ? this.camera.project(along(at, 0.7, across(to))) : end;
    if (label) this.word(label, word, color, kind === 'dot' ? [0.7, -0.7] : unit2(start, end), 12.5);
  }

  head(start, end) {
    const [x, y] = unit2(start, end);
    const size = Math.min(10 * this.ratio, Math.hypot(end[0] - start[0], end[1] - start[1]) / 2);
    this.context.setLineDash([]);
    this.path([
      [end[0] - size * (x - 0.42 * y), end[1] - size * (y + 0.42 * x)],
      end,
      [end[0] - size * (x + 0.42 * y), end[1] - size * (y - 0.42 * x)],
    ]);
    this.context.stroke();
  }

  plane(at, normal, color) {
    const [first, radius] = [across(normal), Math.sqrt(Math.max(0.2, 0.6 - dot(at, at)))];
    const second = cross(normal, first);
    const corner = (x, y) => this.camera.project(along(along(at, x * radius, first), y * radius, second));
    this.path([corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1)], true);
    this.set(color, 1.2, 0.14);
    this.context.fill();
    this.set(color, 1.2, 0.9, [2, 4]);
    this.context.stroke();
  }

  // A word beside a place, on the side to which `way` points, or where nothing else is written.
  word(text, [x, y], color, way, size) {
    const wide = this.font(size, 700).measureText(text).width / 2 + 3 * this.ratio;
    const high = 8 * this.ratio;
    const start = Math.atan2(way[1], way[0]);
    const tries = Array.from({ length: 24 }, (_, k) => {
      const [angle, far] = [start + (k % 2 ? k + 1 : -k) * (Math.PI / 8), 1 + 0.5 * Math.floor(k / 8)];
      return [far * Math.cos(angle) * (wide + 7 * this.ratio), far * Math.sin(angle) * (high + 6 * this.ratio)];
    });
    const free = ([dx, dy]) =>
      this.taken.every(([u, v, w, h]) => Math.abs(x + dx - u) > wide + w || Math.abs(y + dy - v) > high + h);
    const [dx, dy] = tries.find(free) || tries[0];
    this.taken.push([x + dx, y + dy, wide, high]);
    this.ink(text, x + dx, y + dy, color);
  }

  // Text on a halo of the paper's colour.
  ink(text, x, y, color) {
    this.set(this.colors.paper, 4, 0.85);
    this.context.strokeText(text, x, y);
    this.set(color, 1);
    this.context.fillText(text, x, y);
  }

  // A line of text in the upper left corner.
  line(text, number, color) {
    const [x, y] = [12 * this.ratio, (18 + 18 * number) * this.ratio];
    const half = this.font(13, 600).measureText(text).width / 2;
    this.ink(text, x + half, y, color);
    this.taken.push([x + half, y, half, 9 * this.ratio]);
  }

  // The letter of a body, at its upper left (A) or upper right (B).
  letter(name, body, color) {
    const side = name === 'A' ? -0.6 : 0.6;
    const height = ([x, y]) => side * x - y;
    let best = null;
    for (const p of body.places) {
      const at = this.camera.project(p);
      if (!best || height(at) > height(best)) best = at;
    }
    const { width, height: high } = this.context.canvas;
    const room = 16 * this.ratio;
    if (!best) return;
    best = [Math.max(room, Math.min(width - room, best[0])), Math.max(2 * room, Math.min(high - room, best[1]))];
    this.word(name, best, color, [Math.sign(side) * 0.5, -1], 17);
  }

  axes(width, height) {
    const [x, y] = [width - 34 * this.ratio, height - 34 * this.ratio];
    const [right, up] = [this.camera.right, this.camera.up];
    ['x', 'y', 'z'].forEach((name, i) => {
      const [dx, dy] = [20 * this.ratio * right[i], -20 * this.ratio * up[i]];
      this.set(this.colors.truth, 1.2, 0.55);
      this.path([[x, y], [x + dx, y + dy]]);
      this.context.stroke();
      this.font(11).fillText(name, x + 1.4 * dx, y + 1.4 * dy);
    });
  }

  // A bar of 1, 2 or 5 times a power of ten of the scene's lengths.
  bar(size, height) {
    if (!size) return;
    const longest = (110 * this.ratio * size) / this.camera.scale;
    const power = Math.pow(10, Math.floor(Math.log10(longest)));
    const length = [5, 2, 1].map((k) => k * power).find((l) => l <= longest) || power;
    const pixels = (length / size) * this.camera.scale;
    if (!(pixels > 1 && pixels < 1e4)) return;
    const [x, y, tick] = [14 * this.ratio, height - 14 * this.ratio, 4 * this.ratio];
    this.set(this.colors.truth, 1.4, 0.7);
    this.path([[x, y - tick], [x, y], [x + pixels, y], [x + pixels, y - tick]]);
    this.context.stroke();
    this.font(11).fillText(length >= 1e5 || length < 1e-3 ? length.toExponential(0).replace('+', '') : +length.toPrecision(1), x + pixels / 2, y - 9 * this.ratio);
  }
}

const unit2 = ([x, y], [u, v]) => {
  const length = Math.hypot(u - x, v - y) || 1;
  return [(u - x) / length, (v - y) / length];
};

// Convex hull of points on the screen (Andrew's monotone chain).
function hull(points) {
  points.sort((p, q) => p[0] - q[0] || p[1] - q[1]);
  const half = (sorted) => {
    const chain = [];
    for (const p of sorted) {
      while (chain.length > 1) {
        const [[x, y], [u, v]] = chain.slice(-2);
        if ((u - x) * (p[1] - y) - (v - y) * (p[0] - x) > 0) break;
        chain.pop();
      }
      chain.push(p);
    }
    return chain.slice(0, -1);
  };
  return [...half(points), ...half(points.reverse())];
}
