// A figure of the page, made interactive when it is first seen; figures out of sight hold no pixels.

const HELP = 'Drag or use the arrow keys to turn, plus and minus to zoom, Shift to move, 0 to reset.';
const NAMES = { a: 'A', b: 'B', given: 'before', proof: 'proof', truth: 'truth' };
const dark = matchMedia('(prefers-color-scheme: dark)');
const LARGEST = 2048;

class Figure {
  constructor(element) {
    const data = JSON.parse(element.dataset.scene);
    this.element = element;
    this.size = data.size;
    this.bodies = { a: new Body(data.a), b: new Body(data.b), ghost: new Body(data.ghost || []) };
    this.names = data.names;
    this.marks = data.marks;
    this.said = data.said;
    this.camera = new Camera(data.view);
    const drawn = new Set(['a', data.b.length || !data.names ? 'b' : 'a', data.ghost ? 'proof' : 'a', ...data.marks.map((mark) => mark[0])]);
    this.layers = ['a', 'b', ...LAYERS.slice().reverse()].filter((name) => drawn.has(name));
    this.shown = new Set(this.layers);
    this.canvas = document.createElement('canvas');
    const wording = { tabindex: 0, role: 'application', 'aria-roledescription': '3D picture' };
    for (const [name, value] of Object.entries({ ...wording, 'aria-label': `${element.querySelector('svg title').textContent} ${HELP}` })) {
      this.canvas.setAttribute(name, value);
    }
    this.canvas.title = HELP;
    element.querySelector('svg').before(this.canvas);
    this.canvas.after(this.tools(data.engine));
    element.classList.add('live');
    this.listen();
  }

  tools(engine) {
    const bar = document.createElement('div');
    bar.className = 'scene-tools';
    bar.setAttribute('role', 'group');
    bar.setAttribute('aria-label', 'What is drawn');
    const button = (text, action) => {
      const made = document.createElement('button');
      made.type = 'button';
      made.textContent = text;
      made.addEventListener('click', () => action(made));
      bar.append(made);
      return made;
    };
    for (const layer of this.layers) {
      const made = button(layer === 'engine' ? engine : { ...NAMES, ...this.names }[layer], () => {
        if (!this.shown.delete(layer)) this.shown.add(layer);
        made.setAttribute('aria-pressed', this.shown.has(layer));
        this.redraw();
      });
      made.setAttribute('aria-pressed', 'true');
      const swatch = document.createElement('i');
      swatch.className = layer;
      made.prepend(swatch);
    }
    button('reset', () => {
      this.camera.reset();
      this.redraw();
    }).className = 'scene-reset';
    return bar;
  }

  listen() {
    const canvas = this.canvas;
    const fingers = new Map();
    const ratio = () => canvas.width / canvas.clientWidth || 1;
    const centered = (x, y) => {
      const box = canvas.getBoundingClientRect();
      return [(x - box.left - box.width / 2) * ratio(), (y - box.top - box.height / 2) * ratio()];
    };
    canvas.addEventListener('pointerdown', (event) => {
      canvas.setPointerCapture(event.pointerId);
      fingers.set(event.pointerId, [event.clientX, event.clientY]);
    });
    canvas.addEventListener('pointermove', (event) => {
      const before = fingers.get(event.pointerId);
      if (!before) return;
      const now = [event.clientX, event.clientY];
      const [dx, dy] = [now[0] - before[0], now[1] - before[1]];
      const other = [...fingers].find(([id]) => id !== event.pointerId);
      if (other) {
        const spread = (p) => Math.hypot(p[0] - other[1][0], p[1] - other[1][1]) || 1;
        const middle = [(now[0] + other[1][0]) / 2, (now[1] + other[1][1]) / 2];
        this.camera.magnify(spread(now) / spread(before), ...centered(...middle));
        this.camera.move((dx / 2) * ratio(), (dy / 2) * ratio());
      } else if (event.shiftKey || event.buttons & 6) this.camera.move(dx * ratio(), dy * ratio());
      else this.camera.turn(-dx / 2, dy / 2);
      fingers.set(event.pointerId, now);
      this.redraw();
    });
    for (const name of ['pointerup', 'pointercancel']) {
      canvas.addEventListener(name, (event) => fingers.delete(event.pointerId));
    }
    canvas.addEventListener('contextmenu', (event) => event.preventDefault());
    canvas.addEventListener('dblclick', () => {
      this.camera.reset();
      this.redraw();
    });
    canvas.addEventListener('wheel', (event) => {
      if (!event.ctrlKey && document.activeElement !== canvas) return; // the page scrolls on
      event.preventDefault();
      this.camera.magnify(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0015)), ...centered(event.clientX, event.clientY));
      this.redraw();
    }, { passive: false });
    canvas.addEventListener('keydown', (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey || !this.key(event.key, event.shiftKey)) return;
      event.preventDefault();
      this.redraw();
    });
  }

  // Whether a key means something here.
  key(name, shift) {
    const ways = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
    const step = this.canvas.width / 20;
    if (name in ways && shift) this.camera.move(ways[name][0] * step, ways[name][1] * step);
    else if (name in ways) this.camera.turn(-6 * ways[name][0], 6 * ways[name][1]);
    else if (name === '+' || name === '=') this.camera.magnify(1.2);
    else if (name === '-' || name === '_') this.camera.magnify(1 / 1.2);
    else if (name === '0' || name === 'Home') this.camera.reset();
    else return false;
    return true;
  }

  see(visible) {
    this.visible = visible;
    if (visible) this.redraw();
    else this.canvas.width = this.canvas.height = 0;
  }

  // One picture at a time; what is asked for while one is being made is drawn after it.
  redraw() {
    this.wanted = true;
    if (this.busy || !this.visible) return;
    this.busy = true;
    requestAnimationFrame(async () => {
      this.wanted = false;
      await this.draw();
      this.busy = false;
      if (this.wanted) this.redraw();
    });
  }

  async draw() {
    const [wide, high] = [this.canvas.clientWidth, this.canvas.clientHeight];
    this.wide = wide;
    if (!wide || !high || !this.visible) return;
    const ratio = Math.min(window.devicePixelRatio || 1, 2, LARGEST / wide, LARGEST / high);
    const [width, height] = [Math.round(wide * ratio), Math.round(high * ratio)];
    this.camera.aim(width, height);
    const seen = (name) => (this.shown.has(name) ? this.bodies[name] : null);
    const colors = this.colors();
    const filled = { a: rgb(colors.a), b: rgb(colors.b) };
    const image = await surfaces(seen('a'), seen('b'), this.camera, width, height, filled);
    if (this.visible) this.compose(image, seen, colors, width, height, ratio);
  }

  compose(image, seen, colors, width, height, ratio) {
    const canvas = this.canvas;
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    const context = canvas.getContext('2d');
    context.globalAlpha = 1;
    context.clearRect(0, 0, width, height);
    const pen = new Pen(context, this.camera, colors, ratio);
    const each = (action) => ['b', 'a'].forEach((name) => seen(name) && action(name, seen(name)));
    each((name, body) => pen.edges(body, colors[name], true));
    context.globalAlpha = 1;
    context.drawImage(image, 0, 0);
    each((name, body) => pen.edges(body, colors[name], false));
    if (this.shown.has('proof')) pen.edges(this.bodies.ghost, colors.proof, false);
    this.said.forEach(([layer, words], i) => pen.line(words, i, colors[layer]));
    if (!this.names) each((name, body) => pen.letter(name.toUpperCase(), body, colors[name]));
    for (const layer of LAYERS.filter((name) => this.shown.has(name))) {
      for (const mark of this.marks) if (mark[0] === layer) pen.mark(mark);
    }
    pen.axes(width, height);
    pen.bar(this.size, height);
  }

  colors() {
    const style = getComputedStyle(this.element);
    const found = { paper: style.getPropertyValue('--paper').trim() || (dark.matches ? '#16181d' : '#fff') };
    for (const name of ['a', 'b', 'engine', 'truth', 'proof']) found[name] = style.getPropertyValue(`--${name}`).trim();
    return found;
  }
}

const mixer = document.createElement('canvas').getContext('2d');
function rgb(color) {
  mixer.fillStyle = color;
  const hex = parseInt(mixer.fillStyle.slice(1), 16) || 0;
  return [(hex >> 16) / 255, ((hex >> 8) & 255) / 255, (hex & 255) / 255];
}

const figures = new Map();
const redrawAll = () => figures.forEach((figure) => figure && figure.redraw());
const resized = new ResizeObserver((entries) => {
  for (const { target } of entries) {
    const figure = figures.get(target);
    if (figure.wide !== figure.canvas.clientWidth) figure.redraw();
  }
});
const watcher = new IntersectionObserver((entries) => {
  for (const { target, isIntersecting } of entries) {
    if (isIntersecting && !figures.has(target)) {
      try {
        figures.set(target, new Figure(target));
        resized.observe(target);
      } catch {
        figures.set(target, null); // the still picture stays
      }
    }
    if (figures.get(target)) figures.get(target).see(isIntersecting);
  }
}, { rootMargin: '200px' });
const start = () => document.querySelectorAll('figure.scene[data-scene]').forEach((figure) => watcher.observe(figure));
dark.addEventListener('change', redrawAll);
new MutationObserver(redrawAll).observe(document.documentElement, { attributes: true });
if (document.readyState === 'loading') document.addEventListener('DOMContentLoaded', start);
else start();
