// Bodies as the data has them, made into triangles (for surfaces), strokes (edges that know the faces beside them),
// outlines (of round bodies: the hull of their places on the screen) and dots.

const AROUND = 48;
const RIM = 1.45;
const turned = (k) => [Math.cos((k * 2 * Math.PI) / AROUND), Math.sin((k * 2 * Math.PI) / AROUND)];

class Body {
  constructor(parts) {
    this.corners = []; // nine numbers a triangle's corner: place, normal, opacity
    this.strokes = []; // {p, q, n, m, weak}: from p to q, between faces with normals n and m
    this.outlines = []; // lists of places
    this.dots = [];
    this.places = [];
    for (const [kind, numbers, extra] of parts) {
      const v = [];
      for (let i = 0; i < numbers.length; i += 3) v.push(times(1e-4, numbers.slice(i, i + 3)));
      this[kind in PROFILES ? 'lathe' : kind](v, extra, kind);
    }
    this.surface = new Float32Array(this.corners.flat());
  }

  triangle(p, q, r, n, m = n, o = n, opacity = [1, 1, 1]) {
    this.corners.push([...p, ...n, opacity[0]], [...q, ...m, opacity[1]], [...r, ...o, opacity[2]]);
  }

  stroke(p, q, n, m, weak = 1) {
    this.strokes.push({ p, q, n, m, weak });
  }

  dot(v) {
    this.dots.push(v[0]);
    this.places.push(v[0]);
  }

  line(v) {
    this.stroke(v[0], v[1]);
    this.places.push(...v);
  }

  ray(v) {
    const way = unit(along(v[1], -1, v[0]));
    const side = across(way);
    this.line(v);
    for (const s of [0.035, -0.035]) this.stroke(along(along(v[1], -0.1, way), s, side), v[1]);
  }

  // A disc of the plane through v[0] that fades out, a grid on it, and strokes on the side of the solid.
  plane([foot, normal]) {
    const first = across(normal);
    const second = cross(normal, first);
    const radius = Math.sqrt(Math.max(0.3, RIM * RIM - dot(foot, foot)));
    const at = (x, y) => along(along(foot, x * radius, first), y * radius, second);
    const rim = (k, r) => at(...turned(k).map((x) => r * x));
    for (const n of [normal, times(-1, normal)]) {
      const step = n === normal ? 1 : -1;
      for (let k = 0; k < AROUND; k++) {
        const [p, q, P, Q] = [rim(step * k, 0.6), rim(step * (k + 1), 0.6), rim(step * k, 1), rim(step * (k + 1), 1)];
        this.triangle(foot, p, q, n, n, n, [0.75, 0.6, 0.6]);
        this.triangle(p, P, Q, n, n, n, [0.6, 0, 0]);
        this.triangle(p, Q, q, n, n, n, [0.6, 0, 0.6]);
      }
    }
    for (let k = -3; k <= 3; k++) {
      const reach = Math.sqrt(1 - (k * k) / 16) * 0.94;
      this.stroke(at(k / 4, -reach), at(k / 4, reach), null, null, 0.16);
      this.stroke(at(-reach, k / 4), at(reach, k / 4), null, null, 0.16);
      for (const start of [at(k / 4, 0), ...(k ? [at(0, k / 4)] : [])]) {
        this.stroke(start, along(along(start, -0.1, normal), -0.045, first), null, null, 0.75);
      }
    }
    this.places.push(foot);
  }

  mesh(v, faces) {
    this.places.push(...v);
    const sides = new Map();
    for (const face of faces) {
      if (face.length < 3) {
        if (face.length > 1) this.stroke(v[face[0]], v[face[1]]);
        else this.dots.push(v[face[0]]);
        continue;
      }
      let sum = [0, 0, 0];
      face.forEach((i, k) => { sum = along(sum, 1, cross(v[i], v[face[(k + 1) % face.length]])); });
      const normal = unit(sum);
      face.forEach((i, k) => {
        const j = face[(k + 1) % face.length];
        if (k && j !== face[0]) this.triangle(v[face[0]], v[i], v[j], normal);
        const key = i < j ? `${i} ${j}` : `${j} ${i}`;
        const side = sides.get(key);
        if (side) side.m = normal;
        else sides.set(key, { p: v[i], q: v[j], n: normal });
      });
    }
    for (const { p, q, n, m } of sides.values()) {
      const smooth = m ? dot(n, m) : -1;
      this.stroke(p, q, n, m || n, smooth > 0.9999 ? 0 : smooth > 0.9 ? 0.3 : 1);
    }
  }

  lathe(v, half, kind) {
    const [center, ...axes] = v;
    const place = (c, s, r, z) => axes.reduce((p, a, i) => along(p, [r * c, r * s, z][i], a), center);
    const facing = (c, s, r, z) =>
      unit(axes.reduce((p, a, i) => along(p, [r * c, r * s, z][i] / (dot(a, a) || 1), a), [0, 0, 0]));
    const rings = PROFILES[kind](half).map(([r, z, nr, nz]) => {
      const ring = [];
      for (let k = 0; k <= AROUND; k++) {
        const [c, s] = turned(k);
        ring.push([place(c, s, r, z), facing(c, s, nr, nz)]);
      }
      return ring;
    });
    const outline = [];
    rings.forEach((ring, i) => {
      outline.push(...ring.map((corner) => corner[0]));
      if (!i) return;
      for (let k = 0; k < AROUND; k++) {
        const [[p, n], [q, m], [P, N], [Q, M]] = [rings[i - 1][k], rings[i - 1][k + 1], ring[k], ring[k + 1]];
        this.triangle(p, q, Q, n, m, M);
        this.triangle(p, Q, P, n, M, N);
      }
    });
    this.outlines.push(outline);
    this.places.push(...outline);
    this.circles(kind, half, place, facing);
  }

  // Circles that make round bodies readable: rims of a can, seams of a rod, the three great circles of a ball.
  circles(kind, half, place, facing) {
    const [around, rod] = [[], kind === 'rod'];
    if (kind !== 'ball') {
      for (const end of [-1, 1]) {
        around.push([(c, s) => place(c, s, 1, end * (rod ? half : 1)), (c, s) => facing(c, s, 1, 0), rod ? null : end]);
      }
    } else {
      around.push([(c, s) => place(c, s, 1, 0), (c, s) => facing(c, s, 1, 0)]);
      around.push([(c, s) => place(1, 0, c, s), (c, s) => facing(1, 0, c, s)]);
      around.push([(c, s) => place(0, 1, c, s), (c, s) => facing(0, 1, c, s)]);
    }
    for (const [at, normal, end] of around) {
      for (let k = 0; k < AROUND; k++) {
        const n = normal(...turned(k + 0.5));
        this.stroke(at(...turned(k)), at(...turned(k + 1)), n, end ? facing(0, 0, 0, end) : n, end ? 1 : 0.3);
      }
    }
  }
}

// Profiles that are turned about z: radius, height, and the normal's share of each.
const quarter = (from, to, z = 0) =>
  Array.from({ length: 13 }, (_, i) => {
    const angle = (from + ((to - from) * i) / 12) * RADIANS;
    return [Math.cos(angle), Math.sin(angle) + z, Math.cos(angle), Math.sin(angle)];
  });
const PROFILES = {
  ball: () => [...quarter(-90, 0), ...quarter(0, 90)],
  rod: (half) => [...quarter(-90, 0, -half), ...quarter(0, 90, half)],
  can: () => [[0, -1, 0, -1], [1, -1, 0, -1], [1, -1, 1, 0], [1, 1, 1, 0], [1, 1, 0, 1], [0, 1, 0, 1]],
};
