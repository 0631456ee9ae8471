// Stacks of a library's plates, composed: the formulas of the program (src/physics/appearance/composed, src/study/evaluate/composed).
// validation/data/library-golden.json judges this file, the program and inkwave.Library of Python.
"use strict";
const inkwave = (() => {
  const FAINT = 1e-9, NOTHING = 1e-9, PIECE = 8, PIECES = 16, MOST_FRINGES = 200, MOST_SLABS = 4096, BLACK = 0, WHITE = 0.8;
  const PENCIL = 1e-10, LEAST = 1e-12, SMALL = 1e-6, LOSSLESS = 1e-12, SAME_INDEX = 1e-9, FORM = 5, TAU = 2 * Math.PI, LIT = Math.sin(Math.PI / 4);
  const THINNED = 3, STEP_NM = 5, SHORTEST_NM = 300, CUT_NM = 420, LONGEST_NM = 780, MOST_INKS = 6;
  const NODES = [16, 11], MEAN_ERROR = 1e-7, FRINGES_OF_A_PIECE = 4, MOST_HALVINGS = 48, ROUNDS = 12, FURTHEST = 1, NARROWEST = 1e-3, LITTLE = 0.02;
  // what composing makes of a slab in which light decays
  const TURNED_BACK = { ra: 1, rb: 1, t: 0 };
  const sum = list => list.reduce((a, b) => a + b, 0);
  const range = n => Array.from({ length: n }, (_, k) => k);
  // viewing angles of a strip, as in the pictures of runs; the rule of their sines
  const VIEW_DEG = range(21).map(k => 3 * k), VIEWED = -1;

  // Matrices: { n: rows, m: columns, x: row by row }
  const zeros = (n, m) => ({ n, m, x: new Float64Array(n * m) });
  const identity = n => { const e = zeros(n, n); for (let i = 0; i < n; i++) e.x[i * n + i] = 1; return e; };
  function times(a, b) {
    const c = zeros(a.n, b.m);
    for (let i = 0; i < a.n; i++) for (let k = 0; k < a.m; k++) {
      const y = a.x[i * a.m + k];
      if (y !== 0) for (let j = 0; j < b.m; j++) c.x[i * b.m + j] += y * b.x[k * b.m + j];
    }
    return c;
  }
  const combine = (a, b, f) => ({ n: a.n, m: a.m, x: a.x.map((y, k) => f(y, b.x[k])) });
  const plus = (a, b) => combine(a, b, (y, z) => y + z);
  const scaled = (a, by) => ({ n: a.n, m: a.m, x: a.x.map(y => by * y) });
  const transposed = a => { const t = zeros(a.m, a.n); for (let i = 0; i < a.n; i++) for (let j = 0; j < a.m; j++) t.x[j * a.n + i] = a.x[i * a.m + j]; return t; };
  function columnSums(a) {
    const sums = new Float64Array(a.m);
    for (let i = 0; i < a.n; i++) for (let j = 0; j < a.m; j++) sums[j] += a.x[i * a.m + j];
    return sums;
  }
  /** (1 − A B)⁻¹ X. */
  function bounced(a, b, x) {
    const n = a.n, m = x.m, product = times(a, b), left = product.x.map((y, k) => (k % (n + 1) === 0 ? 1 : 0) - y), right = x.x.slice();
    for (let k = 0; k < n; k++) {
      let p = k;
      for (let i = k + 1; i < n; i++) if (Math.abs(left[i * n + k]) > Math.abs(left[p * n + k])) p = i;
      if (p !== k) {
        for (let j = 0; j < n; j++) [left[k * n + j], left[p * n + j]] = [left[p * n + j], left[k * n + j]];
        for (let j = 0; j < m; j++) [right[k * m + j], right[p * m + j]] = [right[p * m + j], right[k * m + j]];
      }
      for (let i = k + 1; i < n; i++) {
        const f = left[i * n + k] / left[k * n + k];
        if (f === 0) continue;
        for (let j = k; j < n; j++) left[i * n + j] -= f * left[k * n + j];
        for (let j = 0; j < m; j++) right[i * m + j] -= f * right[k * m + j];
      }
    }
    for (let k = n - 1; k >= 0; k--) for (let j = 0; j < m; j++) {
      let y = right[k * m + j];
      for (let i = k + 1; i < n; i++) y -= left[k * n + i] * right[i * m + j];
      right[k * m + j] = y / left[k * n + k];
    }
    return { n, m, x: right };
  }
  /** A function of a symmetric matrix, by Jacobi's rotations. */
  function functionOf(matrix, f) {
    const n = matrix.n, a = matrix.x.slice(), v = identity(n).x;
    for (let sweep = 0; sweep < 60; sweep++) {
      let off = 0;
      for (let i = 0; i < n; i++) for (let j = 0; j < i; j++) off += a[i * n + j] ** 2;
      if (off < 1e-34) break;
      for (let p = 0; p < n; p++) for (let q = p + 1; q < n; q++) {
        if (a[p * n + q] === 0) continue;
        const theta = (a[q * n + q] - a[p * n + p]) / (2 * a[p * n + q]);
        const t = Math.sign(theta || 1) / (Math.abs(theta) + Math.sqrt(theta * theta + 1)), c = 1 / Math.sqrt(t * t + 1), s = t * c;
        for (let k = 0; k < n; k++) { const x = a[k * n + p], y = a[k * n + q]; a[k * n + p] = c * x - s * y; a[k * n + q] = s * x + c * y; }
        for (let k = 0; k < n; k++) { const x = a[p * n + k], y = a[q * n + k]; a[p * n + k] = c * x - s * y; a[q * n + k] = s * x + c * y; }
        for (let k = 0; k < n; k++) { const x = v[k * n + p], y = v[k * n + q]; v[k * n + p] = c * x - s * y; v[k * n + q] = s * x + c * y; }
      }
    }
    const vectors = { n, m: n, x: v }, by = { n, m: n, x: v.map((y, k) => y * f(a[(k % n) * (n + 1)])) };
    return times(by, transposed(vectors));
  }

  // Plates: reflection from both sides, transmission onward and back
  function then(a, b) {
    const down = bounced(a.rb, b.ra, a.tab), up = bounced(b.ra, a.rb, b.tba);
    return { ra: plus(a.ra, times(a.tba, times(b.ra, down))), rb: plus(b.rb, times(b.tab, times(a.rb, up))), tab: times(b.tab, down), tba: times(a.tba, up) };
  }
  const turned = a => ({ ra: a.rb, rb: a.ra, tab: a.tba, tba: a.tab });
  /** With more of the light reflected and less transmitted. */
  function moved(plate, by) {
    if (by === 0) return plate;
    const pair = (r, t) => {
      const back = columnSums(r), onward = columnSums(t), moves = back.map((b, j) => b > by && onward[j] > by);
      return [{ ...r, x: r.x.map((y, k) => moves[k % r.m] ? y * (back[k % r.m] + by) / back[k % r.m] : y) },
        { ...t, x: t.x.map((y, k) => moves[k % t.m] ? y * (onward[k % t.m] - by) / onward[k % t.m] : y) }];
    };
    const [ra, tab] = pair(plate.ra, plate.tab), [rb, tba] = pair(plate.rb, plate.tba);
    return { ra, rb, tab, tba };
  }
  function repeated(plate, count, weights) {
    if (count === 1) return plate;
    const n = plate.ra.n;
    let all = { ra: zeros(n, n), rb: zeros(n, n), tab: identity(n), tba: identity(n) }, power = plate, whole = Math.floor(count);
    while (whole > 0) {
      if (whole % 2) all = then(all, power);
      whole = Math.floor(whole / 2);
      if (whole) power = then(power, power);
    }
    return count % 1 === 0 ? all : then(all, fraction(plate, count % 1, weights));
  }
  const shrunkFurther = (part, theta) => theta < SMALL ? part * (1 - part * part) / 3 : (shrunk(part, theta) - part) / Math.min(theta, 1);
  function shrunk(part, theta) {
    theta = Math.min(Math.max(theta, 0), 1 - LEAST);
    return theta < SMALL ? part + theta * part * (1 - part * part) / 3 : Math.tanh(part * Math.atanh(Math.sqrt(theta))) / Math.sqrt(theta);
  }
  /** A part of a slab that is alike from both sides. */
  function fraction(plate, part, weights) {
    const n = plate.ra.n, etendue = weights.map(w => w > 0 ? w : PENCIL);
    const even = m => {
      const s = (i, j) => m.x[i * n + j] * Math.sqrt(etendue[j] / etendue[i]), out = zeros(n, n);
      for (let i = 0; i < n; i++) for (let j = 0; j < n; j++) {
        const [a, b] = [weights[i] > 0, weights[j] > 0];
        out.x[i * n + j] = a && !b ? s(i, j) : !a && b ? s(j, i) : 0.5 * (s(i, j) + s(j, i));
      }
      return out;
    };
    const r = even(plate.ra), t = even(plate.tab);
    const y = functionOf(plus(r, t), c => Math.max((1 - c) / Math.max(1 + c, LEAST), 0));
    const x = functionOf(plus(r, scaled(t, -1)), c => Math.max((1 + c) / Math.max(1 - c, LEAST), 0));
    const root = functionOf(y, v => Math.sqrt(Math.max(v, 0))), product = times(times(root, x), root);
    const partY = times(times(root, functionOf(product, v => shrunk(part, v))), root);
    const further = times(times(root, functionOf(product, v => shrunkFurther(part, v))), root);
    const partX = plus(scaled(x, part), times(times(x, further), x));
    const alike = functionOf(partY, v => (1 - v) / (1 + Math.max(v, 0))), opposite = functionOf(partX, v => (v - 1) / (Math.max(v, 0) + 1));
    const flux = sign => {
      const out = zeros(n, n);
      for (let i = 0; i < n; i++) for (let j = 0; j < n; j++) {
        if (weights[i] === 0 && weights[j] > 0) continue;
        out.x[i * n + j] = 0.5 * (alike.x[i * n + j] + sign * opposite.x[i * n + j]) * Math.sqrt(etendue[i] / etendue[j]);
      }
      return out;
    };
    const back = flux(1), onward = flux(-1);
    return { ra: back, rb: back, tab: onward, tba: onward };
  }

  // Complex numbers: [re, im]
  const cm = (a, b) => [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]];
  const ca = (a, b) => [a[0] + b[0], a[1] + b[1]];
  const cs = (a, b) => [a[0] - b[0], a[1] - b[1]];
  const cd = (a, b) => { const d = b[0] * b[0] + b[1] * b[1]; return [(a[0] * b[0] + a[1] * b[1]) / d, (a[1] * b[0] - a[0] * b[1]) / d]; };
  const ce = a => { const r = Math.exp(a[0]); return [r * Math.cos(a[1]), r * Math.sin(a[1])]; };
  const cq = a => { // the root with a real part of 0 or more
    const r = Math.hypot(a[0], a[1]);
    if (r === 0) return [0, 0];
    const re = Math.sqrt((r + Math.abs(a[0])) / 2), im = Math.abs(a[1]) / (2 * re);
    return a[0] >= 0 ? [re, a[1] < 0 ? -im : im] : [im, a[1] < 0 ? -re : re];
  };
  const cn = a => a[0] * a[0] + a[1] * a[1];
  const conj = a => [a[0], -a[1]];

  // Films: amplitudes from in front, from behind, and through
  function filmThen(a, b) {
    const many = cd([1, 0], cs([1, 0], cm(a.rb, b.ra)));
    return { ra: ca(a.ra, cm(cm(cm(a.t, a.t), b.ra), many)), rb: ca(b.rb, cm(cm(cm(b.t, b.t), a.rb), many)), t: cm(cm(a.t, b.t), many) };
  }
  const powers = a => ({ ra: cn(a.ra), rb: cn(a.rb), t: cn(a.t) });
  function powersThen(a, b) {
    const many = 1 / Math.max(1 - a.rb * b.ra, FAINT);
    return { ra: a.ra + a.t * a.t * b.ra * many, rb: b.rb + b.t * b.t * a.rb * many, t: a.t * b.t * many };
  }
  /** Elements that are alike: of the whole ones doubled products, and behind them `part` of such a part of one. */
  function filmRepeated(a, count, part) {
    if (count === 1) return a;
    let all = { ra: [0, 0], rb: [0, 0], t: [1, 0] }, power = a, whole = Math.floor(count);
    while (whole > 0) {
      if (whole % 2) all = filmThen(all, power);
      whole = Math.floor(whole / 2);
      if (whole) power = filmThen(power, power);
    }
    return count % 1 ? filmThen(all, part(count % 1)) : all;
  }
  /** The same of powers, whatever the part (Stokes). */
  function powersRepeated(a, count) {
    if (count === 1) return a;
    const mirrored = 0.5 * (a.ra + a.rb);
    if (mirrored < LOSSLESS) return { ra: 0, rb: 0, t: a.t ** count };
    if (1 - mirrored - a.t < LOSSLESS) { const t = a.t / (a.t + count * mirrored); return { ra: 1 - t, rb: 1 - t, t }; }
    const half = (1 + mirrored * mirrored - a.t * a.t) / (2 * mirrored), own = 1 / (half + Math.sqrt(Math.max(half * half - 1, 0)));
    const onward = (a.t / (1 - own * mirrored)) ** count, back = onward * onward, many = 1 / (1 - own * own * back), r = own * (1 - back) * many;
    return { ra: r, rb: r, t: onward * (1 - own * own) * many };
  }
  /** From half-spaces of a real index to a medium of this permittivity, which may absorb. */
  function stepTo(index, squared, sine, p) {
    let a = normal(index, sine), b = cq([squared[0] - sine * sine, squared[1]]);
    if (b[1] < 0) b = scale(b, -1);
    if (p === 1) [a, b] = [scale(a, 1 / (index * index)), cd(b, squared)];
    const r = cd(cs(a, b), ca(a, b));
    return { ra: r, rb: scale(r, -1), t: cq(cs([1, 0], cm(r, r))) };
  }
  /** t of a slab between half-spaces of its own medium over the `through` that it has between those to which both faces have this step. */
  function ownPassage(step, through) {
    const steps = cm(step, step), passes = cs([1, 0], steps);
    return cd([2, 0], ca(passes, cq(ca(cm(passes, passes), scale(cm(steps, cm(through, through)), 4)))));
  }
  /** What a slab with this t between half-spaces mirrors, both of whose faces have this step. */
  function evenSlab(step, through) {
    const t = cm(through, ownPassage(step, through)), own = cm(t, t);
    return cd(cm(step, cs([1, 0], own)), cs([1, 0], cm(cm(step, step), own)));
  }
  /** Whether the medium of a portion ends at its front and at its back: within a layer too, between half-spaces of another index. */
  function mirrorsOf(position, [before, behind], within) {
    const stepped = position !== "whole" && Math.abs((position === "back" ? before : behind) - within) > SAME_INDEX;
    return [stepped || position === "front" || position === "whole", stepped || position === "back" || position === "whole"];
  }
  /** The depth at which the wave is mirrored, as a part of the thickness. */
  const depthOf = ([front, back]) => front === back ? 0.5 : front ? 0 : 1;
  /** n cos θ of a real index: real, or decaying. */
  const normal = (index, sine) => { const s = index * index - sine * sine; return s >= 0 ? [Math.sqrt(s), 0] : [0, Math.sqrt(-s)]; };
  function plane(before, behind, sine, p) {
    const of = n => p === 0 ? normal(n, sine) : normal(n, sine).map(x => x / (n * n));
    const a = of(before), b = of(behind), r = cd(cs(a, b), ca(a, b));
    return { ra: r, rb: [-r[0], -r[1]], t: cq(cs([1, 0], cm(r, r))) };
  }

  function lagrange(points, x) {
    return points.map((own, i) => points.reduce((w, other, j) => j === i ? w : w * (x - other) / (own - other), 1));
  }
  /** Nodes and weights of ∫ dx over 0 < x < 1. */
  function gaussLegendre(count) {
    const rule = [];
    for (let k = 0; k < count; k++) {
      let x = Math.cos(Math.PI * (k + 0.75) / (count + 0.5)), slope = 1;
      for (let step = 0; step < 60; step++) {
        let p0 = 1, p1 = x;
        for (let l = 2; l <= count; l++) [p0, p1] = [p1, ((2 * l - 1) * x * p1 - (l - 1) * p0) / l];
        slope = count * (x * p1 - p0) / (x * x - 1);
        const by = p1 / slope;
        x -= by;
        if (Math.abs(by) < 1e-16) break;
      }
      rule.push([0.5 * (1 + x), 1 / ((1 - x * x) * slope * slope)]);
    }
    return rule;
  }
  /** Weights of Gauss's rule for ∫ 2v f(v) dv over 0 < v < 1, from the largest node down. */
  function radau(count) {
    const legendre = (n, x) => { let p0 = 1, p1 = x; if (n === 0) return 1; for (let l = 2; l <= n; l++) [p0, p1] = [p1, ((2 * l - 1) * x * p1 - (l - 1) * p0) / l]; return p1; };
    const f = x => legendre(count, x) + legendre(count + 1, x), steps = 200 * Math.max(count, 1), found = [];
    const bound = k => -Math.cos(Math.PI * k / steps);
    for (let k = 1; k < steps && found.length < count; k++) {
      let a = bound(k), b = bound(k + 1);
      if (f(a) * f(b) > 0) continue;
      for (let i = 0; i < 60; i++) { const c = 0.5 * (a + b); if (f(a) * f(c) <= 0) b = c; else a = c; }
      const x = 0.5 * (a + b);
      found.push([0.5 * (1 + x), (1 - x) * (1 + x) / (2 * ((count + 1) * legendre(count, x)) ** 2)]);
    }
    return found.reverse();
  }
  /** Fluxes of a zone's nodes without the part orthogonal to polynomials of lower degree than the last. */
  function withoutHighestMoment(count) {
    const nodes = radau(count), filter = identity(count);
    if (count === 1) return filter;
    const p = nodes.map(([v, weight], i) => 1 / nodes.reduce((product, [other], j) => j === i ? product : product * (v - other), weight));
    const norm = sum(nodes.map(([, weight], i) => weight * p[i] ** 2));
    for (let i = 0; i < count; i++) for (let j = 0; j < count; j++) filter.x[i * count + j] -= nodes[i][1] * p[i] * p[j] / norm;
    return filter;
  }
  // Light beyond the critical angle of air: media by their squared, complex indices
  /** n cos θ: going on, or decaying. */
  function goingOn(squared, sine) {
    const root = cq([squared[0] - sine * sine, squared[1]]);
    return root[1] < 0 && root[0] < -root[1] ? [-root[0], -root[1]] : root;
  }
  function faceBetween(before, behind, sine, p) {
    const of = n => p === 0 ? goingOn(n, sine) : cd(goingOn(n, sine), n), a = of(before), b = of(behind), r = cd(cs(a, b), ca(a, b));
    return { ra: r, rb: [-r[0], -r[1]], t: cq(cs([1, 0], cm(r, r))) };
  }
  const scale = (a, by) => [a[0] * by, a[1] * by];
  const logOf = a => { const size = Math.hypot(...a); return size > FAINT ? [Math.log(size), Math.atan2(a[1], a[0])] : [Math.log(FAINT), 0]; };
  const ZONE_RULES = NODES.map(gaussLegendre);
  const PIECE_RULE = gaussLegendre(PIECE), HEMISPHERE_RULE = gaussLegendre(64);

  function besselOne(x) {
    if (x > 40) {
      const y = 1 / (8 * x), p = 1 + 7.5 * y * y - 590.625 * y ** 4, q = 3 * y - 52.5 * y ** 3, phase = x - 0.75 * Math.PI;
      return Math.sqrt(2 / (Math.PI * x)) * (p * Math.cos(phase) - q * Math.sin(phase));
    }
    const steps = 24 + 2 * Math.ceil(x);
    return sum(range(steps).map(i => { const tau = TAU * (i + 0.5) / steps; return Math.cos(tau - x * Math.sin(tau)); })) / steps;
  }
  /** Share of the light that a paper spreads over all areas alike, of round dots on a square lattice. */
  function spreadShare(coverage, rulingPerUm, spreadUm) {
    let area = Math.min(coverage, 1 - coverage);
    if (!(spreadUm > 0)) return 0;
    const length = spreadUm * rulingPerUm, radius = Math.sqrt(Math.max(area, 1e-6) / Math.PI);
    area = Math.PI * radius * radius;
    const reach = Math.min(Math.ceil(30 / (TAU * length)), 400);
    let same = 0;
    for (let m = 1; m <= reach; m++) for (let n = 0; n <= m; n++) {
      const images = n === 0 || n === m ? 4 : 8, order = Math.hypot(m, n), z = TAU * radius * order, c = area * 2 * besselOne(z) / z;
      same += images * c * c / (1 + (TAU * order * length) ** 2) ** 1.5;
    }
    return Math.min(Math.max(1 - same / (area * (1 - area)), 0), 1);
  }
  /** Bare paper at 45:0 behind a plane surface of a medium. */
  function bare(index) {
    if (index === 1) return { own: 0, entering: 1, leaving: 1, lost: 1 };
    const passed = cosine => {
      const inner = Math.sqrt(1 - (1 - cosine * cosine) / (index * index));
      const s = (cosine - index * inner) / (cosine + index * inner), p = (index * cosine - inner) / (index * cosine + inner);
      return 1 - 0.5 * (s * s + p * p);
    };
    const mean = sum(HEMISPHERE_RULE.map(([s, w]) => w * 4 * s ** 3 * passed(s * s)));
    return { own: 0, entering: passed(Math.cos(Math.PI / 4)), leaving: passed(1) / index ** 2, lost: mean / index ** 2 };
  }
  /** Light onto and from the paper below kinds of area with these shares, at one wavelength: [Φ_k, U_k]. */
  function fluxes(areas, { shares, spread }, albedo, power, emitted) {
    const divisor = a => (1 - albedo) + albedo * (a.lost + spread * (1 - a.lost)), lit = areas.map((a, k) => albedo * shares[k] * a.entering * power + (emitted[k] || 0));
    let given = 0, shared = 0;
    areas.forEach((a, k) => {
      given += lit[k] / divisor(a);
      shared += albedo * spread * shares[k] * (1 - a.lost) / divisor(a);
    });
    const all = given / (1 - shared);
    const up = areas.map((a, k) => (1 - spread) * (lit[k] + albedo * (1 - a.lost) * spread * shares[k] * all) / divisor(a) + spread * shares[k] * all);
    return [areas.map((a, k) => shares[k] * a.entering * power + (1 - a.lost) * up[k]), up];
  }
  /** Radiance factor of a print; `emitted` is what the paper emits below its kinds of area, of light of power 1. */
  function mixed(areas, mix, albedo, emitted) {
    const [, up] = fluxes(areas, mix, albedo, 1, emitted);
    return sum(areas.map((a, k) => mix.shares[k] * a.own + a.leaving * up[k]));
  }

  // Brighteners
  /** A value of rising rows, linear between them and nothing beyond. */
  function rowsAt(rows, nm) {
    for (let k = 1; k < rows.length; k++) {
      const [[a, x], [b, y]] = [rows[k - 1], rows[k]];
      if (nm >= a && nm <= b) return x + (nm - a) / (b - a) * (y - x);
    }
    return 0;
  }
  /** The kernel f(to, from) of a brightener in 1/nm, the share that it takes before the albedo acts, and the first wavelength that excites. */
  function brightener(given) {
    const rising = rows => Array.isArray(rows) && rows.length > 1 && rows.every(([nm, value], k) => value >= 0 && (!k || nm > rows[k - 1][0]));
    if (given.excitation) {
      const { excitation, emission, yield: quanta } = given;
      if (!rising(excitation) || !rising(emission) || excitation.some(row => row[1] > 1)) throw new Refusal("paper.fluorescence: found rows that are none; allowed are two or more rows [nm, value], rising, values from 0 (shares up to 1)");
      if (!(quanta >= 0 && quanta <= 1)) throw new Refusal(`paper.fluorescence.yield: found ${quanta}; allowed 0 to 1`);
      const area = sum(emission.slice(1).map(([nm, value], k) => 0.5 * (nm - emission[k][0]) * (value + emission[k][1]))), scale = area > 0 ? quanta / area : 0;
      const there = k => excitation[k] && excitation[k][1] > 0, first = excitation.find((_, k) => there(k) || there(k - 1) || there(k + 1));
      return { kernel: (to, from) => scale * rowsAt(emission, to) * rowsAt(excitation, from) * from / to, absorbed: nm => rowsAt(excitation, nm), first: first ? first[0] : null };
    }
    const { excitation_nm: light, emission_nm: sent, factors } = given, step = light && light[1] - light[0];
    const sound = light && sent && factors && light.length > 1 && sent.length > 1 && step > 0 && light.every((nm, k) => !k || Math.abs(nm - light[k - 1] - step) <= 1e-6 * step)
      && sent.every((nm, k) => !k || nm > sent[k - 1]) && factors.length === sent.length && factors.every(row => row.length === light.length && row.every(x => x >= 0));
    if (!sound) throw new Refusal("paper.fluorescence: found no brightener; allowed are excitation, emission and yield, or excitation_nm (equal steps), emission_nm and factors");
    const rows = factors.map((row, i) => row.map((factor, j) => [light[j], sent[i] > light[j] ? factor : 0]));
    const first = light.find((_, j) => rows.some(row => row[j][1] !== 0));
    return { kernel: (to, from) => rowsAt(rows.map((row, i) => [sent[i], rowsAt(row, from)]), to) / step, absorbed: () => 0, first: first === undefined ? null : first };
  }
  const matrixOf = (kernel, nm) => nm.map((to, i) => nm.slice(0, i).map(from => STEP_NM * kernel(to, from)));
  /** Share s of a list between its places k − 1 and k, constant beyond its ends. */
  function between(list, x) {
    let k = 1;
    while (k < list.length - 1 && list[k] < x) k++;
    return [k, Math.min(Math.max((x - list[k - 1]) / (list[k] - list[k - 1]), 0), 1)];
  }

  // Shares of the light: [reflected, transmitted]
  const withLoss = (l, s) => { const lost = 1 - l[0] - l[1]; return [l[0] + lost * s[0], l[1] + lost * s[1]]; };
  const minus = (a, b) => [a[0] - b[0], a[1] - b[1]];
  const add = (a, by, b) => [a[0] + by * b[0], a[1] + by * b[1]];
  const passive = (r, t) => { const whole = Math.max(r + t, 1); return [r / whole, t / whole]; };
  function changed(l, by) {
    const r = l[0] + by[0], whole = Math.min(Math.max(r + l[1] + by[1], 0), 1), reflected = Math.min(Math.max(r, 0), whole);
    return [reflected, whole - reflected];
  }
  function sharesOf(field, composed) {
    const lost = 1 - field[0] - field[1];
    if (lost < NOTHING) return composed;
    const together = Math.max((composed[0] + composed[1] - field[0] - field[1]) / lost, 0);
    const reflected = Math.min(Math.max((composed[0] - field[0]) / lost, 0), together);
    return [reflected, together - reflected];
  }
  const ratio = (a, b) => { const q = a / b; return Number.isFinite(q) ? q : 1; };

  class Refusal extends Error {}

  function bytesOf(text) {
    if (typeof Buffer !== "undefined") { const b = Buffer.from(text, "base64"); return new Uint8Array(b.buffer, b.byteOffset, b.length).slice(); }
    return Uint8Array.from(atob(text), c => c.charCodeAt(0));
  }

  class Library {
    constructor(content) {
      if (!content || !Number.isInteger(content.inkwave_library)) throw new Refusal("found no library; allowed is a file that `inkwave library` has written");
      if (content.inkwave_library > FORM) throw new Refusal(`inkwave_library: found form ${content.inkwave_library}; allowed up to ${FORM}: make the page with a newer program`);
      const { joint } = content;
      this.content = content;
      this.nm = content.wavelengths_nm;
      this.index = joint.index;
      this.p = joint.polarisations;
      this.sines = joint.sines;
      this.weights = joint.weights;
      this.directions = joint.directions;
      this.near = joint.directions[0];
      // files before form 3 keep amplitudes of the directions from which light reaches air alone
      this.kept = 1 + (content.inkwave_library >= 3 ? this.sines.length : this.near);
      this.shares = { scalar: [1], s: [1, 0], p: [0, 1] }[content.wave] || Array(this.p).fill(1 / this.p);
      this.known = [0, ...this.sines.slice(0, this.near)];
      this.places = this.known.map(s => Math.sqrt(1 - s * s));
      this.plates = new Map(content.plates.map((plate, k) => [plate.name, k]));
      this.eyes = content.eyes;
      this.lights = content.lights || [];
      const [from, to] = [Math.ceil(Math.max(this.nm[0], SHORTEST_NM) / STEP_NM), Math.floor(this.nm.at(-1) / STEP_NM)];
      this.summed = range(Math.max(to - from + 1, 0)).map(k => STEP_NM * (from + k));
      this.onto = this.summed.map(nm => between(this.nm, nm));
      this.matrices = new Map();
      this.unpackedStates = new Map();
      this.fluxes = new Map();
      this.films = new Map();
      this.turnedBack = new Map();
      this.front = this.face(true);
      this.back = turned(this.face(false));
      this.rules = new Map();
    }

    /** The plane face between air and the joint's medium. */
    face(oblique) {
      const { p, near, index } = this, n = 1 + p * this.sines.length, air = 1 + p * (near + (oblique ? 1 : 0));
      const plate = { ra: zeros(air, air), rb: identity(n), tab: zeros(n, air), tba: zeros(air, n) };
      const mirrored = (sine, pol) => {
        const [a, b] = [1, index].map(m => Math.sqrt(Math.max(m * m - sine * sine, 0)) / (pol === 0 ? 1 : m * m));
        return ((a - b) / (a + b)) ** 2;
      };
      this.known.forEach((sine, d) => {
        for (let pol = 0; pol < (d === 0 ? 1 : p); pol++) {
          const s = d === 0 ? 0 : 1 + (d - 1) * p + pol, m = mirrored(sine, pol);
          plate.ra.x[s * air + s] = plate.rb.x[s * n + s] = m;
          plate.tab.x[s * air + s] = plate.tba.x[s * n + s] = 1 - m;
        }
      });
      if (oblique) {
        const shares = lagrange(this.places.slice(1), Math.sqrt(1 - LIT * LIT));
        for (let pol = 0; pol < p; pol++) shares.forEach((share, node) => {
          const to = 1 + node * p + pol, from = 1 + near * p + pol, m = mirrored(LIT, pol);
          plate.ra.x[to * air + from] += share * m;
          plate.tab.x[to * air + from] += share * (1 - m);
        });
      }
      return plate;
    }

    /** Fluxes and amplitudes of a portion at a wavelength; cell −1 is the mean. */
    states(number, portion, w, cell) {
      const key = `${number}/${portion}/${w}/${cell}`;
      if (!this.unpackedStates.has(key)) {
        const at = this.content.plates[number].portions[portion].states[w], [m, n] = at.states;
        const x = new Float64Array(bytesOf(at.mean).buffer);
        const known = this.kept;
        if (x.length !== m * m + n * n + 2 * m * n + 8 * known * this.p) throw new Refusal(`plate "${this.content.plates[number].name}": its numbers are incomplete; gather the library again`);
        if (cell >= 0) {
          const { unit, differences } = at.replicates[cell], d = new Int16Array(bytesOf(differences).buffer);
          d.forEach((y, k) => { x[k] += unit * y; });
        }
        let from = 0;
        const matrix = (rows, columns) => ({ n: rows, m: columns, x: x.slice(from, from += rows * columns) });
        const flux = { ra: matrix(m, m), rb: matrix(n, n), tab: matrix(n, m), tba: matrix(m, n) };
        const amplitude = (side, d, pol, lobe) => { const at = from + 2 * (((side * known + d) * this.p + pol) * 2 + lobe); return [x[at], x[at + 1]]; };
        this.unpackedStates.set(key, { flux, amplitude, between: at.between });
      }
      return this.unpackedStates.get(key);
    }

    placesOf(count, change) {
      const many = change.halved ? 2 * count : count;
      return many <= 1 ? [["whole", 1]] : [["front", 1], ["inner", many - 2], ["back", 1]].filter(([, times]) => times > 0);
    }

    portionOf(number, position, change) {
      const k = this.content.plates[number].portions.findIndex(p => p.position === position && p.halved === !!change.halved);
      if (k < 0) throw new Refusal(`plate "${this.content.plates[number].name}": lacks a portion; gather the library again`);
      const out = change.leftOut;
      return [k, out && out[0] === number && out[1] === k ? out[2] : -1];
    }

    keyOf(number, change) {
      const out = change.leftOut && change.leftOut[0] === number ? change.leftOut.join() : "";
      return `${number}/${change.halved ? "h" : ""}${out}`;
    }

    etendues(index) {
      const ends = this.index < index - 1e-3 ? [1, this.index, index] : [1, index], all = [0];
      let start = 0;
      for (const end of ends) {
        for (const [, w] of radau(this.directions[start === 0 ? 0 : 1])) for (let k = 0; k < this.p; k++) all.push(w * (end * end - start * start));
        start = end;
      }
      return all;
    }

    /** Fluxes of the states of a medium without the highest moment of every zone. */
    filter(index, states) {
      const zones = [this.directions[0], ...range(this.index < index - 1e-3 ? 2 : 1).map(() => this.directions[1])], filter = identity(states);
      let first = 1;
      for (const count of zones) {
        const zone = withoutHighestMoment(count);
        for (let i = 0; i < count; i++) for (let j = 0; j < count; j++) for (let k = 0; k < this.p; k++) {
          filter.x[(first + i * this.p + k) * states + first + j * this.p + k] = zone.x[i * count + j];
        }
        first += count * this.p;
      }
      return filter;
    }

    /** A portion whose scattered light lacks the highest moment that its directions resolve; what goes straight on stays. */
    thinned({ ra, rb, tab, tba }, amplitude, between) {
      const filters = [this.filter(between[0], ra.n), this.filter(between[1], rb.n)], ends = between.map(index => Math.min(index, this.index));
      // where zones of the media end elsewhere, light of one is shared among the other's directions
      const shared = Math.abs(ends[0] - ends[1]) > SAME_INDEX ? 1 + this.near : this.kept;
      const of = (m, side, lobe) => {
        const straight = zeros(m.n, m.m);
        for (let d = 1; d < (lobe ? shared : this.kept); d++) for (let pol = 0; pol < this.p; pol++) {
          const state = 1 + (d - 1) * this.p + pol, [x, y] = amplitude(side, d, pol, lobe);
          if (state < Math.min(m.n, m.m)) straight.x[state * m.m + state] = Math.min(x * x + y * y, m.x[state * m.m + state]);
        }
        return plus(straight, times(filters[lobe ? 1 - side : side], combine(m, straight, (all, own) => all - own)));
      };
      return { ra: of(ra, 0, 0), rb: of(rb, 1, 0), tab: of(tab, 0, 1), tba: of(tba, 1, 1) };
    }

    layerFlux(number, count, change, w) {
      const key = `${this.keyOf(number, change)}/${change.grid ? "g" : change.thinned ? "t" : ""}/${count}/${w}`;
      if (!this.fluxes.has(key)) {
        let whole = null;
        for (const [position, times] of this.placesOf(count, change)) {
          const [k, cell] = this.portionOf(number, position, change), { flux, amplitude, between } = this.states(number, k, w, cell);
          let plate = moved(flux, change.grid ? this.content.plates[number].portions[k].grid_error : 0);
          if (change.thinned) plate = this.thinned(plate, amplitude, between);
          if (times !== 1) plate = repeated(plate, times, this.etendues(between[1]));
          whole = whole ? then(whole, plate) : plate;
        }
        this.fluxes.set(key, whole);
      }
      return this.fluxes.get(key);
    }

    /** A layer of a stack, with the face to air in front of the first one, and behind the last one over a gap. */
    faced(job, place, w) {
      const [number, count] = job.layers[place], { change } = job, first = place === 0, last = place === job.layers.length - 1 && !job.contact;
      const own = this.layerFlux(number, count, change, w);
      if (!first && !last) return own;
      const key = `${this.keyOf(number, change)}/${change.grid ? "g" : change.thinned ? "t" : ""}/${count}/${w}/${first ? "front" : ""}${last ? "back" : ""}`;
      if (!this.fluxes.has(key)) {
        const front = first ? then(this.front, own) : own;
        this.fluxes.set(key, last ? then(front, this.back) : front);
      }
      return this.fluxes.get(key);
    }

    /** One element as the mean wave meets it: waves and powers as functions of the sine. */
    element(number, position, times, change, w, pol) {
      const [k, cell] = this.portionOf(number, position, change), plate = this.content.plates[number];
      const { amplitude, between: [before, behind] } = this.states(number, k, w, cell);
      const um = plate.portions[k].thickness_um, index = plate.within[w], k0 = TAU / (1e-3 * this.nm[w]);
      const loss = (plate.loss || [])[w] || 0, squared = [index * index, loss];
      const mirrors = mirrorsOf(position, [before, behind], index), inner = !mirrors[0] && !mirrors[1], depth = depthOf(mirrors);
      const phase = (sine, part = 1) => normal(index, sine).map(x => x * k0 * um * part);
      const even = (sine, passed, part = 1) => {
        const f = phase(sine, part), through = { ra: [0, 0], rb: [0, 0], t: ce([passed[0] - f[1], passed[1] + f[0]]) };
        return inner ? through : filmThen(filmThen(plane(before, index, sine, pol), through), plane(index, behind, sine, pol));
      };
      const depths = (sine, passed, part = 1) => { const once = phase(sine, part)[0] + passed[1]; return [depth, 1 - depth].map(side => [Math.cos(2 * side * once), Math.sin(2 * side * once)]); };
      const passed = this.known.map((sine, d) => {
        const onward = amplitude(0, d, pol, 1);
        let root = cq(cm(onward, amplitude(1, d, pol, 1)));
        if (cm(conj(root), onward)[0] < 0) root = [-root[0], -root[1]];
        const q = cd(root, even(sine, [0, 0]).t), size = Math.hypot(...q);
        return size > FAINT ? [Math.log(size), Math.atan2(q[1], q[0])] : [Math.log(FAINT), 0];
      });
      for (let d = 1; d < passed.length; d++) passed[d][1] -= TAU * Math.round((passed[d][1] - passed[d - 1][1]) / TAU);
      const reflected = this.known.map((sine, d) => {
        const film = even(sine, passed[d]), phases = depths(sine, passed[d]);
        return [0, 1].map(side => cm(cs(amplitude(side, d, pol, 0), side ? film.rb : film.ra), conj(phases[side])));
      });
      const kept = range(this.known.length).filter(d => !(change.fewer && d === this.known.length >> 1));
      const clearest = Math.max(...kept.map(d => passed[d][0])), places = kept.map(d => this.places[d]);
      const at = (sine, weights) => {
        let here = [0, 0];
        const beyond = [[0, 0], [0, 0]];
        weights.forEach((weight, i) => {
          const d = kept[i];
          here = add(here, weight, passed[d]);
          for (const side of [0, 1]) beyond[side] = add(beyond[side], weight, reflected[d][side]);
        });
        here[0] = Math.min(here[0], clearest);
        const f = phase(sine), way = [here[0] - f[1], here[1] + f[0]];
        if (inner) {
          const step = loss ? stepTo(index, squared, sine, pol).ra : [0, 0], through = ce(way), more = ownPassage(step, through);
          const own = ca(way, [Math.log(Math.hypot(...more)), Math.atan2(more[1], more[0])]), mirrored = cn(evenSlab(step, through));
          return { film: { ra: [0, 0], rb: [0, 0], t: ce(scale(own, times)) }, own: powersRepeated({ ra: mirrored, rb: mirrored, t: cn(through) }, times) };
        }
        const slab = part => {
          const passed = scale(here, part), film = even(sine, passed, part), phases = depths(sine, passed, part).map(by => scale(by, part));
          return { ra: ca(film.ra, cm(beyond[0], phases[0])), rb: ca(film.rb, cm(beyond[1], phases[1])), t: cm(even(sine, [0, 0], part).t, ce(passed)) };
        };
        const one = slab(1);
        if (loss && mirrors[0] !== mirrors[1]) {
          const step = stepTo(index, squared, sine, pol);
          return { film: mirrors[0] ? filmThen(one, step) : filmThen({ ra: step.rb, rb: step.ra, t: step.t }, one), own: powers(one) };
        }
        return { film: filmRepeated(one, times, slab), own: powersRepeated(powers(one), times) };
      };
      const turns = 2 * (index - Math.sqrt(Math.max(index * index - 1, 0))) * um * times / (1e-3 * this.nm[w]);
      return { at: sine => at(sine, lagrange(places, Math.sqrt(Math.max(1 - sine * sine, 0)))), turns };
    }

    /** A layer at many sines: films with, and powers without interference between its elements. */
    layerFilm(number, count, change, w, pol, pieces) {
      const key = `${this.keyOf(number, change)}/${change.fewer ? "f" : ""}/${count}/${w}/${pol}/${pieces}`;
      if (!this.films.has(key)) {
        const elements = this.placesOf(count, change).map(([position, times]) => this.element(number, position, times, change, w, pol));
        const { sines } = this.rule(pieces), coherent = new Float64Array(6 * sines.length), without = new Float64Array(3 * sines.length);
        sines.forEach((sine, k) => {
          let whole = null, power = null;
          for (const element of elements) {
            const { film, own } = element.at(sine);
            whole = whole ? filmThen(whole, film) : film;
            power = power ? powersThen(power, own) : own;
          }
          coherent.set([...whole.ra, ...whole.rb, ...whole.t], 6 * k);
          without.set([power.ra, power.rb, power.t], 3 * k);
        });
        const turns = elements.map(element => [element.turns, cn(element.at(0).film.t)]);
        this.films.set(key, { coherent, without, turns });
      }
      return this.films.get(key);
    }

    /** Sines of the mean over the hemisphere, of 0 pieces those that are needed besides: known ones, then 45°; or those of a strip. */
    rule(pieces) {
      if (!this.rules.has(pieces)) {
        const sines = [], weights = [];
        if (pieces === 0) sines.push(...this.known, LIT);
        if (pieces === VIEWED) sines.push(...VIEW_DEG.map(deg => Math.sin(Math.PI / 180 * deg)));
        for (let k = 0; k < pieces; k++) for (const [x, weight] of PIECE_RULE) {
          const place = (k + x) / pieces;
          sines.push(Math.sqrt(Math.max(1 - place * place, 0)));
          weights.push(2 * place * weight / pieces);
        }
        const kept = fewer => range(this.places.length).filter(d => !(fewer && d === this.places.length >> 1));
        const lagranges = [false, true].map(fewer => sines.map(s => lagrange(kept(fewer).map(d => this.places[d]), Math.sqrt(Math.max(1 - s * s, 0)))));
        const listed = (before, behind) => range(this.p).map(pol => {
          const films = sines.map(s => plane(before, behind, s, pol));
          return { coherent: Float64Array.from(films.flatMap(f => [...f.ra, ...f.rb, ...f.t])), without: Float64Array.from(films.flatMap(f => { const own = powers(f); return [own.ra, own.rb, own.t]; })) };
        });
        const faces = listed(1, this.index), backs = listed(this.index, 1);
        this.rules.set(pieces, { sines, weights, lagranges, kept: [kept(false), kept(true)], faces, backs });
      }
      return this.rules.get(pieces);
    }

    /** The whole stack's lobes at the sines of a rule: [side][coherent or not][sine]. */
    fields(job, w, pol, pieces, exact) {
      const rule = this.rule(pieces), change = exact ? { ...job.change, fewer: false } : job.change;
      const films = [rule.faces[pol], ...job.layers.map(([number, count]) => this.layerFilm(number, count, change, w, pol, pieces))];
      if (!job.contact) films.push(rule.backs[pol]);
      const out = [[[], []], [[], []]];
      for (let k = 0; k < rule.sines.length; k++) {
        // star products as filmThen and powersThen, without their arrays
        let [ar, ai, br, bi, tr, ti, pa, pb, pt] = [0, 0, 0, 0, 1, 0, 0, 0, 1];
        for (const { coherent, without } of films) {
          const c = 6 * k, xr = coherent[c], xi = coherent[c + 1], yr = coherent[c + 2], yi = coherent[c + 3], sr = coherent[c + 4], si = coherent[c + 5];
          const dr = 1 - (br * xr - bi * xi), di = -(br * xi + bi * xr), d = dr * dr + di * di, mr = dr / d, mi = -di / d;
          const t2r = tr * tr - ti * ti, t2i = 2 * tr * ti, s2r = sr * sr - si * si, s2i = 2 * sr * si;
          const ur = xr * mr - xi * mi, ui = xr * mi + xi * mr, vr = br * mr - bi * mi, vi = br * mi + bi * mr;
          ar += t2r * ur - t2i * ui;
          ai += t2r * ui + t2i * ur;
          br = yr + s2r * vr - s2i * vi;
          bi = yi + s2r * vi + s2i * vr;
          const fr = tr * sr - ti * si, fi = tr * si + ti * sr;
          tr = fr * mr - fi * mi;
          ti = fr * mi + fi * mr;
          const x = without[3 * k], y = without[3 * k + 1], s = without[3 * k + 2], many = 1 / Math.max(1 - pb * x, FAINT);
          pa += pt * pt * x * many;
          pb = y + s * s * pb * many;
          pt *= s * many;
        }
        const through = tr * tr + ti * ti;
        out[0][0].push(passive(ar * ar + ai * ai, through));
        out[1][0].push(passive(br * br + bi * bi, through));
        out[0][1].push(passive(pa, pt));
        out[1][1].push(passive(pb, pt));
      }
      return out;
    }

    /**
     * R and T of diffuse light from both sides, [side] = [R, T, loss by known direction], with interference or without it: sums over
     * the sines of a rule, into which shares of the loss enter as weights of directions.
     */
    hemisphere(job, w, pol, pieces, interferes) {
      const rule = this.rule(pieces), { weights } = rule, kept = rule.lagranges[job.change.fewer ? 1 : 0], known = kept[0].length;
      const films = [rule.faces[pol], ...job.layers.map(([number, count]) => this.layerFilm(number, count, job.change, w, pol, pieces))];
      if (!job.contact) films.push(rule.backs[pol]);
      const out = [0, 1].map(() => new Float64Array(2 + known)), many = films.length;
      for (let k = 0; k < weights.length; k++) {
        let ar = 0, ai = 0, br = 0, bi = 0, tr = 1, ti = 0;
        if (interferes) for (let f = 0; f < many; f++) {
          const x = films[f].coherent, c = 6 * k, xr = x[c], xi = x[c + 1], sr = x[c + 4], si = x[c + 5];
          const dr = 1 - (br * xr - bi * xi), di = -(br * xi + bi * xr), d = 1 / (dr * dr + di * di), mr = dr * d, mi = -di * d;
          const t2r = tr * tr - ti * ti, t2i = 2 * tr * ti, s2r = sr * sr - si * si, s2i = 2 * sr * si;
          const ur = xr * mr - xi * mi, ui = xr * mi + xi * mr, vr = br * mr - bi * mi, vi = br * mi + bi * mr;
          ar += t2r * ur - t2i * ui;
          ai += t2r * ui + t2i * ur;
          br = x[c + 2] + s2r * vr - s2i * vi;
          bi = x[c + 3] + s2r * vi + s2i * vr;
          const fr = tr * sr - ti * si, fi = tr * si + ti * sr;
          tr = fr * mr - fi * mi;
          ti = fr * mi + fi * mr;
        } else for (let f = 0; f < many; f++) {
          const p = films[f].without, c = 3 * k, s = p[c + 2], times = 1 / Math.max(1 - br * p[c], FAINT);
          ar += tr * tr * p[c] * times;
          br = p[c + 1] + s * s * br * times;
          tr *= s * times;
        }
        const through = interferes ? tr * tr + ti * ti : tr;
        for (let s = 0; s < 2; s++) {
          const back = interferes ? (s ? br * br + bi * bi : ar * ar + ai * ai) : s ? br : ar, whole = Math.max(back + through, 1), r = back / whole, on = through / whole, sum = out[s];
          sum[0] += weights[k] * r;
          sum[1] += weights[k] * on;
          const lost = weights[k] * (1 - r - on), own = kept[k];
          for (let d = 0; d < known; d++) sum[2 + d] += lost * own[d];
        }
      }
      return out;
    }

    /**
     * A portion as light from the paper meets it beyond the critical angle of air, turned over: the even film of a complex index that has
     * its phase and its loss in every direction, and what is left over.
     */
    trappedSlab(number, position, change, w, pol) {
      const [k, cell] = this.portionOf(number, position, change), key = `${number}/${k}/${cell}/${w}/${pol}`;
      if (this.turnedBack.has(key)) return this.turnedBack.get(key);
      const plate = this.content.plates[number], { amplitude, between } = this.states(number, k, w, cell), um = plate.portions[k].thickness_um, index = plate.within[w];
      const k0 = TAU / (1e-3 * this.nm[w]), before = [between[1] ** 2, 0], behind = [between[0] ** 2, 0];
      const faces = mirrorsOf(position, between, index).reverse(), inner = !faces[0] && !faces[1], depth = depthOf(faces);
      const squaredOf = further => [index * index + further[0], further[1]];
      const phase = (further, sine, part = 1) => { const n = goingOn(squaredOf(further), sine), way = k0 * um * part; return [-n[1] * way, n[0] * way]; };
      const film = (further, sine, [first, last], part = 1) => {
        const squared = squaredOf(further);
        let found = { ra: [0, 0], rb: [0, 0], t: ce(phase(further, sine, part)) };
        if (first) found = filmThen(faceBetween(before, squared, sine, pol), found);
        return last ? filmThen(found, faceBetween(squared, behind, sine, pol)) : found;
      };
      const depths = (further, sine, part = 1) => { const once = phase(further, sine, part)[1]; return [depth, 1 - depth].map(side => [Math.cos(2 * side * once), Math.sin(2 * side * once)]); };
      const logarithm = (measured, further, sine, near) => {
        const beside = cd(film(further, sine, [true, true]).t, ce(phase(further, sine))), log = logOf(cd(measured, cm(beside, ce(phase([0, 0], sine)))));
        return [log[0], log[1] - TAU * Math.round((log[1] - near) / TAU)];
      };
      const sound = x => Number.isFinite(x[0]) && Number.isFinite(x[1]) && Math.hypot(...x) < FURTHEST;
      const evenOf = (measured, sine, near) => {
        const first = logarithm(measured, [0, 0], sine, near), plain = phase([0, 0], sine);
        let log = first, squared = [0, 0];
        for (let round = 0; round < ROUNDS; round++) {
          const n = cd(ca(plain, log), [0, k0 * um]);
          squared = ca(cm(n, n), [sine * sine - index * index, 0]);
          if (!sound(squared)) break;
          log = logarithm(measured, squared, sine, log[1]);
        }
        if (sound(squared)) {
          const left = logOf(cd(measured, film(squared, sine, [true, true]).t));
          if (Math.hypot(...left) < 0.1 * Math.hypot(...first) + FAINT) return [squared, left, log[1]];
        }
        return [[0, 0], first, first[1]];
      };
      // of a slab whose medium goes on, the steps to the half-spaces of its solve, without what noise mirrors
      const stepsAlone = (solved, even) => ({ ra: Math.min(solved.ra, even.ra), rb: Math.min(solved.rb, even.rb), t: solved.t });
      const goesOn = Math.min(...between, index) > this.index - NARROWEST, known = [];
      let near = 0, normal = [0, 0];
      [0, ...this.sines].forEach((sine, d) => {
        const onward = amplitude(1, d, pol, 1);
        let measured = cq(cm(onward, amplitude(0, d, pol, 1)));
        if (cm(conj(measured), onward)[0] < 0) measured = [-measured[0], -measured[1]];
        if (d === 0) [normal] = evenOf(measured, 0, 0);
        if (d <= this.near) { near = logarithm(measured, [0, 0], sine, near)[1]; return; }
        if (!goesOn) {
          const even = powers(film(normal, sine, [true, true])), [behindIt, inFront] = between.map(n => n > sine);
          const turned = inFront && behindIt ? even : { ra: inFront ? Math.min(even.ra, 1) : 1, rb: 1, t: 0 };
          const solved = inner ? stepsAlone(turned, even) : turned;
          known.push({ squared: normal, further: [0, 0], solved, reflected: [[0, 0], [0, 0]] });
          return;
        }
        const [squared, further, last] = evenOf(measured, sine, near), own = film(squared, sine, [true, true]), phases = depths(squared, sine);
        near = last;
        const [ra, rb] = [1, 0].map(side => cn(amplitude(side, d, pol, 0))), mirrored = { ra, rb, t: cn(measured) };
        known.push({ squared, further, solved: inner ? stepsAlone(mirrored, powers(own)) : mirrored, reflected: [0, 1].map(side => cm(cs(amplitude(1 - side, d, pol, 0), side ? own.rb : own.ra), conj(phases[side]))) });
      });
      const at = (weights, kept, sine, times) => {
        let squared = [0, 0], further = [0, 0];
        const reflected = [[0, 0], [0, 0]];
        kept.forEach((d, i) => {
          squared = add(squared, weights[i], known[d].squared);
          further = add(further, weights[i], known[d].further);
          for (const side of [0, 1]) reflected[side] = add(reflected[side], weights[i], known[d].reflected[side]);
        });
        squared[1] = Math.max(squared[1], Math.min(...kept.map(d => known[d].squared[1])), 0);
        further[0] = Math.min(further[0], Math.max(...kept.map(d => known[d].further[0])));
        if (inner) return { ra: [0, 0], rb: [0, 0], t: ce(scale(ca(phase(squared, sine), further), times)) };
        const slab = part => {
          const own = film(squared, sine, faces, part), phases = depths(squared, sine, part).map(by => scale(by, part));
          return { ra: ca(own.ra, cm(reflected[0], phases[0])), rb: ca(own.rb, cm(reflected[1], phases[1])), t: cm(own.t, ce(scale(further, part))) };
        };
        return filmRepeated(slab(1), times, slab);
      };
      const turns = 2 * (goingOn([index * index, 0], 1)[0] - goingOn([index * index, 0], this.index)[0]) * um * k0 / TAU;
      const solved = (d, times) => powersRepeated(known[d].solved, times);
      this.turnedBack.set(key, { at, solved, goesOn, turns, decays: sine => Math.min(...between, index) <= sine });
      return this.turnedBack.get(key);
    }

    /**
     * What interference changes of R and T of light from a paper in contact beyond the critical angle of air, as ∫ 2s ds: it is turned back
     * at the air. Columns are R and T as composed in its directions.
     */
    ofTrapped(job, w, pol, columns) {
      const { change } = job, joint = this.index, slabs = [...job.layers].reverse().flatMap(([number, count]) =>
        this.placesOf(count, change).reverse().map(([position, times]) => [this.trappedSlab(number, position, change, w, pol), times]));
      const sines = this.sines.slice(this.near), place = s => Math.sqrt(Math.max(joint * joint - s * s, 0)), places = sines.map(place), every = range(sines.length);
      const kept = change.fewer && every.length > 1 ? every.filter(d => d !== every.length >> 1) : every;
      const weightsAt = (sine, known) => lagrange(known.map(d => places[d]), place(sine));
      const share = r => Number.isFinite(r) ? Math.min(r, 1) : 1;
      const field = (sine, known) => {
        const weights = weightsAt(sine, known);
        const films = slabs.map(([slab, times]) => slab.at(weights, known, sine, times)), face = faceBetween([joint * joint, 0], [1, 0], sine, pol);
        const all = [...films.map((own, k) => slabs[k][0].decays(sine) ? TURNED_BACK : powers(own)), powers(face)];
        return [share(cn([...films, face].reduce(filmThen).ra)), share(all.reduce(powersThen).ra)];
      };
      const solved = (sine, d) => [...slabs.map(([slab, times]) => slab.solved(d, times)), powers(faceBetween([joint * joint, 0], [1, 0], sine, pol))].reduce(powersThen).ra;
      const shares = sines.map((sine, d) => {
        const mirrored = Math.min(solved(sine, d), 1), decays = slabs.some(([slab]) => slab.decays(sine));
        return decays && 1 - mirrored < LITTLE ? [0, 0] : sharesOf([mirrored, 0], columns[d]);
      });
      const atEdge = weightsAt(1, kept), fringes = sum(slabs.map(([slab, times]) => slab.turns * times));
      const seen = slabs.filter(([slab]) => slab.goesOn).reduce((product, [slab, times]) => product * cn(slab.at(atEdge, kept, 1, times).t), 1);
      const interferes = seen >= FAINT && fringes <= MOST_FRINGES, begun = interferes ? Math.max(Math.ceil(fringes / FRINGES_OF_A_PIECE), 1) : 1, width = Math.sqrt(joint * joint - 1);
      const at = x => {
        const t = 0.5 * Math.PI * x, v = width * Math.cos(t), sine = Math.sqrt(Math.max(joint * joint - v * v, 0)), weights = weightsAt(sine, kept);
        const own = kept.reduce((l, d, i) => add(l, weights[i], shares[d]), [0, 0]), back = Math.min(Math.max(own[0], 0), 1), on = Math.min(Math.max(own[1], 0), 1 - back);
        return scale(withLoss([field(sine, kept)[interferes ? 0 : 1], 0], [back, on]), 0.5 * Math.PI * width * width * Math.sin(2 * t));
      };
      const pieces = range(begun).map(k => [k / begun, 1 / begun]);
      let total = [0, 0], count = begun;
      while (pieces.length) {
        const [from, size] = pieces.shift(), [mean, check] = ZONE_RULES.map(rule => rule.reduce((l, [x, weight]) => add(l, size * weight, at(from + size * x)), [0, 0]));
        if (Math.max(Math.abs(mean[0] - check[0]), Math.abs(mean[1] - check[1])) > MEAN_ERROR && count < begun + MOST_HALVINGS) {
          count++;
          pieces.push([from, size / 2], [from + size / 2, size / 2]);
        } else total = add(total, 1, mean);
      }
      return columns.reduce((l, own, d) => add(l, -this.weights[this.near + d], own), total);
    }

    fringes(job, w, pol, turnedOver) {
      const all = job.layers.flatMap(([number, count]) => this.layerFilm(number, count, job.change, w, pol, 0).turns);
      const face = 1 - ((1 - this.index) / (1 + this.index)) ** 2;
      let seen = turnedOver && job.contact ? 1 : face, fringes = 0;
      for (const [turns, passed] of turnedOver ? all.reverse() : all) {
        if (seen < FAINT) break;
        fringes += turns;
        seen *= passed;
      }
      return fringes;
    }

    /** All numbers of a stack at one wavelength. */
    spectral(job, w) {
      const { p, near, shares } = this;
      const plate = job.layers.map((_, place) => this.faced(job, place, w)).reduce(then);
      const sums = { ra: columnSums(plate.ra), rb: columnSums(plate.rb), tab: columnSums(plate.tab), tba: columnSums(plate.tba) };
      const index = job.contact ? this.index : 1, rule0 = this.rule(0), fewer = job.change.fewer ? 1 : 0;
      const states = pol => [0, ...range(near).map(node => 1 + node * p + pol)];
      const tables = range(p).map(pol => {
        const exact = this.fields(job, w, pol, 0, true), between = fewer ? this.fields(job, w, pol, 0, false) : exact;
        const side = s => {
          const columns = states(pol).map(k => s ? [sums.rb[k], sums.tba[k]] : [sums.ra[k], sums.tab[k]]);
          const lost = columns.map((c, d) => sharesOf(exact[s][1][d], c));
          return { lost, incoherent: columns.map((_, d) => withLoss(exact[s][1][d], lost[d])) };
        };
        return { between, sides: [side(0), side(1)] };
      });
      const shareAt = (pol, s, rule, k) => rule.lagranges[fewer][k].reduce((l, weight, i) => add(l, weight, tables[pol].sides[s].lost[rule.kept[fewer][i]]), [0, 0]);
      const hemispheres = new Map(), ofDiffuse = (pol, s) => {
        const fringes = this.fringes(job, w, pol, s === 1), interferes = fringes <= MOST_FRINGES;
        const pieces = PIECES * (1 + (interferes ? Math.ceil(2 * fringes / PIECES) : 0)), rule = this.rule(pieces);
        const key = `${pol}/${pieces}/${interferes}`;
        if (!hemispheres.has(key)) hemispheres.set(key, this.hemisphere(job, w, pol, pieces, interferes));
        const [r, on, ...losses] = hemispheres.get(key)[s];
        let change = [r, on];
        losses.forEach((loss, i) => { change = add(change, loss, tables[pol].sides[s].lost[rule.kept[fewer][i]]); });
        range(near).forEach(node => { change = add(change, -this.weights[node], tables[pol].sides[s].incoherent[node + 1]); });
        if (s && job.contact && this.kept > 1 + near && this.sines.length > near) {
          const columns = range(this.sines.length - near).map(k => 1 + (near + k) * p + pol).map(k => [sums.rb[k], sums.tba[k]]);
          change = add(change, 1, this.ofTrapped(job, w, pol, columns));
        }
        return s ? change.map(x => x / index ** 2) : change;
      };
      const nodeShares = lagrange(this.places.slice(1), Math.sqrt(1 - LIT * LIT)), at45Place = near + 1;
      const facePowers = (pol, k) => ({ ra: rule0.faces[pol].without[3 * k], t: rule0.faces[pol].without[3 * k + 2] });
      let normalChange = [0, 0], slantedChange = [0, 0], byNodes = 0, diffuse = [0, 0], diffuseLit = [0, 0], fromBehind = [0, 0], slantedLight = [0, 0];
      for (let pol = 0; pol < p; pol++) {
        const part = shares[pol], ofSky = ofDiffuse(pol, 0);
        diffuse = add(diffuse, 1 / p, ofSky);
        diffuseLit = add(diffuseLit, part, ofSky);
        fromBehind = add(fromBehind, 1 / p, ofDiffuse(pol, 1));
        if (part === 0) continue;
        const [coherent, without] = tables[pol].between[0], at0 = shareAt(pol, 0, rule0, 0);
        normalChange = add(normalChange, part, minus(withLoss(coherent[0], at0), withLoss(without[0], at0)));
        const at45 = shareAt(pol, 0, rule0, at45Place), face = facePowers(pol, at45Place);
        let within = [0, 0];
        nodeShares.forEach((share, node) => {
          const own = facePowers(pol, node + 1);
          within = add(within, share / Math.max(own.t, FAINT), minus(without[node + 1], [own.ra, 0]));
        });
        slantedChange = add(slantedChange, part, minus(withLoss(coherent[at45Place], at45), withLoss(add([face.ra, 0], face.t, within), at45)));
        nodeShares.forEach((share, node) => { byNodes += part * share * sums.tab[1 + node * p + pol]; });
        const column = 1 + near * p + pol;
        slantedLight = add(slantedLight, part, [sums.ra[column], sums.tab[column]]);
      }
      const light = [sums.ra[0], sums.tab[0]], changedLight = changed(light, normalChange), slanted = changed(slantedLight, slantedChange);
      const throughNormal = ratio(changedLight[1], light[1]), through45 = ratio(slanted[1], byNodes);
      const spread = (weights, extra) => [0, ...weights.flatMap(x => Array(p).fill(x)), ...Array(extra).fill(0)];
      const front = spread(this.weights.slice(0, near), p), behind = spread(job.contact ? this.weights : this.weights.slice(0, near), 0);
      const mean = (of, weights) => sum(weights.map((x, k) => x * of[k])) / sum(weights);
      const onto = [mean(sums.ra, front), mean(sums.tab, front)], back = [mean(sums.rb, behind), mean(sums.tba, behind)];
      const lit = [0, ...this.weights.slice(0, near).flatMap(x => shares.map(share => share * x)), ...Array(p).fill(0)];
      const ontoLit = [mean(sums.ra, lit), mean(sums.tab, lit)], leaving = ratio(changed(onto, diffuse)[1], onto[1]);
      const reflected = Math.min(Math.max(Math.min(back[0] + back[1] + fromBehind[0] + fromBehind[1], 1) - back[1] * leaving, 0), 1);
      const total = sum(behind), up = times(plate.tba, { n: behind.length, m: 1, x: Float64Array.from(behind, x => x / total) }).x;
      const towards = column => sum(range(p).flatMap(pol => range(near).map(node => p * shares[pol] * nodeShares[node] / this.weights[node] * column(1 + node * p + pol))));
      const alone = towards(k => plate.ra.x[k * plate.ra.m]), outwards = towards(k => up[k]);
      const returns = albedo => ratio(1 - albedo * back[0], 1 - albedo * reflected) * albedo / (1 - albedo * back[0]);
      const on = (albedo, seen) => returns(albedo) * seen * light[1];
      const litAt = albedo => alone + throughNormal * through45 * on(albedo, outwards);
      const albedo = job.albedo[w], solid = litAt(albedo), lost = 1 - reflected, out = changedLight[1] / index ** 2;
      const series = slanted[1] * out * albedo / ((1 - albedo) + albedo * lost);
      const area = { own: alone, entering: slanted[1], leaving: out * ratio(solid - alone, series), lost };
      const viewed = () => this.viewed(job, w, tables.map(table => table.sides[0]), sums, returns(albedo) * sum([...up]) * leaving);
      return {
        area, viewed, sky: changed(ontoLit, diffuseLit)[1],
        numbers: {
          reflectance_normal: changedLight[0], transmittance_normal: changedLight[1],
          natural_light: changedLight[0] + throughNormal * leaving * on(albedo, sum([...up])),
          lit_at_45: solid, over_black: litAt(BLACK), over_white: litAt(WHITE),
        },
      };
    }

    /**
     * A uniform sky's light that is seen at the angles of a strip, and what of the paper's light passes there: R and T are polynomials
     * between 0° and the nodes, with what interference changes of them. `returned` of the light that passes comes back from the paper.
     */
    viewed(job, w, sides, sums, returned) {
      const { p, shares } = this, rule = this.rule(VIEWED), nowhere = () => VIEW_DEG.map(() => [0, 0]), alone = nowhere(), change = nowhere();
      shares.forEach((part, pol) => {
        if (part === 0) return;
        const coherent = this.fields(job, w, pol, VIEWED, false)[0][0], { lost, incoherent } = sides[pol];
        const columns = this.known.map((_, d) => d === 0 ? 0 : 1 + (d - 1) * p + pol).map(k => [sums.ra[k], sums.tab[k]]);
        VIEW_DEG.forEach((_, k) => {
          const mean = of => rule.lagranges[0][k].reduce((l, weight, d) => add(l, weight, of[d]), [0, 0]);
          alone[k] = add(alone[k], part, mean(columns));
          change[k] = add(change[k], part, minus(withLoss(coherent[k], mean(lost)), mean(incoherent)));
        });
      });
      return alone.map((own, k) => {
        const [back, through] = changed(own, change[k]);
        return { factor: back + ratio(through, own[1]) * own[1] * returned, through };
      });
    }

    /** Factors of a solid under a uniform sky by viewing angle, as the strip of a run's picture has them: [angle in degrees, [wavelength], the parts that the paper emits under a lamp with lines]. */
    overAngles(composition) {
      const job = { ...this.job(composition), areas: null }, glow = job.light ? this.evaluated(job, null).natural_light : null;
      const rows = this.nm.map((_, w) => {
        const { viewed, numbers } = this.spectral(job, w), all = viewed(), emitted = glow ? glow[w] - numbers.natural_light : 0;
        return all.map(({ factor, through }) => [factor, emitted ? emitted * through / all[0].through : 0]);
      });
      const isOfLines = job.light && job.light.seen;
      return VIEW_DEG.map((deg, k) => [deg, rows.map(row => row[k][0] + row[k][1]), isOfLines ? rows.map(row => row[k][1]) : undefined]);
    }

    /** What the paper emits below kinds of area, of light of power 1, at every wavelength; `kinds` are their optics by wavelength. */
    emitted(light, mix, kinds) {
      const below = [], all = [];
      this.summed.forEach((_, i) => {
        const [k, s] = this.onto[i], at = (kind, name) => kind[k - 1][name] + s * (kind[k][name] - kind[k - 1][name]);
        const areas = kinds.map(kind => ({ own: at(kind, "own"), entering: at(kind, "entering"), leaving: at(kind, "leaving"), lost: at(kind, "lost") }));
        const sent = kinds.map((_, kind) => light.matrix[i].reduce((total, factor, j) => total + factor * below[j][kind], 0));
        below.push(fluxes(areas, mix, light.albedo[i], light.power[i], sent)[0]);
        all.push(sent);
      });
      return this.nm.map((nm, w) => {
        const [k, s] = between(this.summed, nm), at = list => list[k - 1] + s * (list[k] - list[k - 1]), power = light.seen ? light.seen[w] : at(light.power);
        return kinds.map((_, kind) => power > 0 ? at(all.map(row => row[kind])) / power : 0);
      });
    }

    /** What a composition asks: plates by number, albedos, dots. */
    job(composition) {
      const { layers, paper = {}, dots = null } = composition;
      if (!Array.isArray(layers) || !layers.length) throw new Refusal("layers: found none; allowed is one or more: name a plate of the library");
      const placed = layers.map((layer, k) => {
        const number = this.plates.get(layer.plate);
        if (number === undefined) throw new Refusal(`layers[${k}].plate: found "${layer.plate}"; allowed are ${[...this.plates.keys()].join(", ")}`);
        return [number, this.count(number, layer.thickness_um, k)];
      });
      const given = paper.albedo === undefined ? 0.9 : paper.albedo, albedo = this.nm.map(nm => albedoAt(given, nm));
      if (!albedo.every(x => x >= 0 && x <= 1)) throw new Refusal(`paper.albedo: found ${JSON.stringify(given)}; allowed 0 to 1 at all wavelengths of the library`);
      const job = { layers: placed, albedo, contact: !!paper.contact, areas: this.areas(composition), light: null, change: {} };
      if (!paper.fluorescence) return job;
      const { kernel, absorbed, first } = brightener(paper.fluorescence);
      if (first !== null && this.nm[0] > Math.max(first, SHORTEST_NM) + STEP_NM) throw new Refusal(`paper.fluorescence: found excitation from ${first} nm, a library from ${this.nm[0]} nm; allowed is a library that holds the light that excites: solve its layers again with light.from_nm = ${Math.max(first, SHORTEST_NM)}`);
      const key = JSON.stringify([paper.fluorescence, given]);
      if (!this.matrices.has(key)) {
        const nm = [...this.summed];
        while (nm.at(-1) + STEP_NM <= LONGEST_NM) nm.push(nm.at(-1) + STEP_NM);
        const all = matrixOf(kernel, nm), elastic = this.summed.map(at => albedoAt(given, at) * (1 - absorbed(at)));
        const most = Math.max(...elastic.map((x, j) => x + sum(nm.slice(j + 1).map((to, i) => all[j + 1 + i][j] * to / nm[j]))));
        if (paper.fluorescence.yield > 0 && first !== null && all.slice(0, this.summed.length).every(row => row.slice(0, this.summed.length).every(factor => factor === 0))) throw new Refusal(`paper.fluorescence.emission: found a yield of ${paper.fluorescence.yield}, and nothing emitted from ${this.nm[0]} to ${this.nm.at(-1)} nm; allowed is emission at longer waves than the excitation, within the library's: correct the rows; yield = 0 only absorbs`);
        if (most > 1 + 1e-9) throw new Refusal(`paper.fluorescence: found ${most.toFixed(3)} quanta reflected and emitted for each that comes in; allowed at most 1: lower yield or excitation, or the albedo at the wavelengths that excite`);
        this.matrices.set(key, { matrix: all.slice(0, this.summed.length), albedo: elastic });
      }
      return { ...job, albedo: albedo.map((x, w) => x * (1 - absorbed(this.nm[w]))), light: { ...this.matrices.get(key), ...this.power(composition) } };
    }

    /** Power of the light that excites a brightener, at the wavelengths of the sum; of a lamp with lines also that of all light about each of the library's. */
    power({ illuminant = "D65", condition = null }) {
      const lamp = condition ? { M0: "A", M1: "D50", M2: "D50" }[condition] : illuminant;
      if (!lamp) throw new Refusal(`condition: found ${condition}; allowed are M0, M1, M2, or none for the illuminant's light`);
      const found = this.lights.find(light => light.illuminant === lamp);
      if (!found) throw new Refusal(`found no power of ${lamp}, which excites; allowed are ${this.lights.map(light => light.illuminant).join(", ") || "none: gather the library again"}`);
      return { power: found.powers.map((x, i) => condition === "M2" && this.summed[i] < CUT_NM ? 0 : x), seen: found.seen_powers || null };
    }

    /** Kinds of area of a print in dots: numbers of the layers on each, their shares, the spread of the light; null of a solid. */
    areas({ layers, dots = null }) {
      const inks = layers.map((layer, k) => [k, layer.coverage]).filter(([, coverage]) => coverage !== undefined && coverage !== null);
      const judge = (name, value, least, most) => { if (!(value >= least && value <= most)) throw new Refusal(`${name}: found ${value}; allowed ${least} to ${most}`); };
      if (!dots) {
        if (inks.length) throw new Refusal(`layers[${inks[0][0]}].coverage: found one without a screen; allowed beside dots`);
        return null;
      }
      judge("dots.ruling_per_cm", dots.ruling_per_cm, 1, 1000);
      judge("dots.spread_um", dots.spread_um, 0, 10000);
      for (const [k, coverage] of inks) judge(`layers[${k}].coverage`, coverage, 0, 1);
      const spread = coverage => spreadShare(coverage, dots.ruling_per_cm / 1e4, dots.spread_um), every = range(layers.length);
      if (dots.coverage !== undefined && dots.coverage !== null) {
        judge("dots.coverage", dots.coverage, 0, 1);
        if (inks.length) throw new Refusal(`dots.coverage: found one beside layers[${inks[0][0]}].coverage; allowed is that of the stack or those of its layers: remove one of them`);
        return { kinds: [[], every], shares: [1 - dots.coverage, dots.coverage], spread: spread(dots.coverage) };
      }
      if (!inks.length || inks.length > MOST_INKS) throw new Refusal(`dots.coverage: found ${inks.length} coverages; allowed is that of the stack, or layers[…].coverage of 1 to ${MOST_INKS} layers`);
      const sets = range(1 << inks.length), varying = inks.map(([, c]) => c).filter(c => c > 0 && c < 1);
      return {
        kinds: sets.map(set => every.filter(k => { const ink = inks.findIndex(([own]) => own === k); return ink < 0 || set >> ink & 1; })),
        shares: sets.map(set => inks.reduce((share, [, c], ink) => share * (set >> ink & 1 ? c : 1 - c), 1)),
        spread: varying.length ? sum(varying.map(c => c * (1 - c) * spread(c))) / sum(varying.map(c => c * (1 - c))) : 1,
      };
    }

    count(number, um, k) {
      const plate = this.content.plates[number], own = plate.thickness_um;
      if (um === undefined || um === null) return plate.slabs ? 2 : 1;
      if (!plate.slabs) {
        if (!(Math.abs(um - own) <= 1e-6 * own)) throw new Refusal(`layers[${k}].thickness_um: found ${um} µm of "${plate.name}"; allowed ${Number(own.toPrecision(6))}, as which it was solved whole`);
        return 1;
      }
      let count = um / own;
      if (Math.abs(count - Math.round(count)) < 1e-9 * count) count = Math.round(count);
      if (!(count >= 2 && count <= MOST_SLABS)) throw new Refusal(`layers[${k}].thickness_um: found ${um} µm of "${plate.name}"; allowed from ${Number((2 * own).toPrecision(6))} µm, two slabs`);
      return count;
    }

    eye(composition) {
      const { illuminant = "D65", observer = "2" } = composition;
      const eye = this.eyes.find(e => e.illuminant === illuminant && e.observer === observer);
      if (!eye) throw new Refusal(`illuminant, observer: found ${illuminant}, ${observer}; allowed are those of the library: ${this.eyes.map(e => `${e.illuminant}/${e.observer}`).join(", ") || "none, its wavelengths carry no colour"}`);
      return eye;
    }

    /** Numbers of a composition; `emitted` are the parts of its factors that the paper emits under a lamp with lines. */
    evaluated(job, eye) {
      const emitted = {}, rows = this.nm.map((_, w) => this.spectral(job, w)), found = { emitted }, solid = rows.map(row => row.area);
      for (const name of Object.keys(rows[0].numbers)) found[name] = rows.map(row => row.numbers[name]);
      if (job.light) {
        const mix = { shares: [1], spread: 1 }, leaving = solid.map((a, w) => a.leaving / ((1 - job.albedo[w]) + job.albedo[w] * a.lost));
        const add = (name, kind) => {
          const sent = this.emitted(job.light, mix, [kind]), part = leaving.map((x, w) => x * sent[w][0]);
          found[name] = found[name].map((x, w) => x + part[w]);
          if (job.light.seen) emitted[name] = part;
        };
        add("lit_at_45", solid);
        add("natural_light", rows.map(({ area, sky }) => ({ ...area, entering: sky })));
      }
      found.factors = found.lit_at_45;
      emitted.factors = emitted.lit_at_45;
      if (job.areas) [found.factors, emitted.factors] = this.printed(job, solid);
      if (!eye) return found;
      const seen = name => xyzOf(eye, found[name], emitted[name]);
      found.xyz = seen("factors");
      found.lab_natural_light = labOf(seen("natural_light"), whiteOf(eye));
      found.lab_lit_at_45 = labOf(seen("lit_at_45"), whiteOf(eye));
      found.contrast_ratio = xyzOf(eye, found.over_black)[1] / xyzOf(eye, found.over_white)[1];
      found.lab = labOf(found.xyz, whiteOf(eye));
      return found;
    }

    /** Radiance factors of a print in dots at 45:0, and the parts of them that the paper emits under a lamp with lines. */
    printed(job, solid) {
      const { kinds, ...mix } = job.areas, optics = kinds.map(kind => {
        if (!kind.length) return solid.map(() => bare(job.contact ? this.index : 1));
        if (kind.length === job.layers.length) return solid;
        const own = { ...job, layers: kind.map(k => job.layers[k]) };
        return this.nm.map((_, w) => this.spectral(own, w).area);
      });
      const emitted = job.light ? this.emitted(job.light, mix, optics) : null;
      const factors = sent => this.nm.map((_, w) => mixed(optics.map(kind => kind[w]), mix, job.albedo[w], sent ? sent[w] : []));
      const lit = factors(emitted), dark = emitted && job.light.seen ? factors(null) : null;
      return [lit, dark ? lit.map((x, w) => x - dark[w]) : undefined];
    }

    /** A composition's numbers without bars. */
    compose(composition) {
      const eye = this.eyes.length ? this.eye(composition) : null;
      return this.evaluated(this.job(composition), eye);
    }

    /** Changes of the ensembles that the bars are made of. */
    changes(job) {
      const plates = [...new Set(job.layers.map(([number]) => number))].sort((a, b) => a - b), cells = [[], []];
      for (const number of plates) this.content.plates[number].portions.forEach((portion, k) => {
        cells[portion.halved ? 1 : 0].push([number, k, Math.min(...portion.states.map(at => at.replicates.length))]);
      });
      const all = [{ halved: true }, { grid: true }, { fewer: true }, { thinned: true }];
      cells.forEach((portions, halved) => portions.forEach(([number, k, count]) => {
        if (count > 1) for (let r = 0; r < count; r++) all.push({ halved: halved === 1, leftOut: [number, k, r] });
      }));
      return { all, cells };
    }

    /** Standard errors of all numbers, by chance, halves of layers, grid and directions. `pause` is awaited between evaluations. */
    async errors(composition, base, pause = null) {
      const job = this.job(composition), eye = this.eyes.length ? this.eye(composition) : null, { all, cells } = this.changes(job), many = [];
      for (const change of all) {
        many.push(this.evaluated({ ...job, change }, eye));
        if (pause && await pause()) return null;
      }
      const known = cells.flat().every(([, , count]) => count > 1), errors = {};
      for (const [name, value] of Object.entries(base)) {
        if (name === "xyz" || name === "emitted") continue;
        const list = Array.isArray(value), values = list ? value : [value], at = (k, i) => list ? many[k][name][i] : many[k][name];
        const variances = values.map((_, i) => {
          let place = 4;
          return cells.map(portions => sum(portions.map(([, , count]) => {
            if (count < 2) return 0;
            const x = range(count).map(r => at(place + r, i)), mean = sum(x) / count;
            place += count;
            return (count - 1) / count * sum(x.map(y => (y - mean) ** 2));
          })));
        });
        let beyond = values.map((v, i) => (at(0, i) - v) ** 2 - (known ? variances[i][0] + variances[i][1] : 0));
        const by = (k, i) => at(k, i) - values[i];
        let directions = values.map((_, i) => by(2, i) ** 2 + (by(3, i) / THINNED) ** 2);
        if (list && !name.startsWith("lab") && name !== "factors") {
          const near = all => all.map((_, i) => { const some = all.slice(Math.max(i - 2, 0), i + 3); return sum(some) / some.length; });
          beyond = near(beyond);
          // at single wavelengths fringes change nothing by accident
          directions = near(directions).map((mean, i) => Math.max(mean, directions[i]));
        }
        const found = values.map((_, i) => Math.sqrt(variances[i][0] + Math.max(beyond[i], 0) / 4 + by(1, i) ** 2 + directions[i]));
        errors[name] = list ? found : found[0];
      }
      return errors;
    }
  }

  function albedoAt(given, nm) {
    if (typeof given === "number") return given;
    for (let k = 1; k < given.length; k++) {
      const [[a, x], [b, y]] = [given[k - 1], given[k]];
      if (nm >= a && nm <= b) return x + (nm - a) / (b - a) * (y - x);
    }
    return NaN;
  }
  /** X, Y, Z of factors; `emitted` are the parts of them that a paper emits under a lamp with lines, which weigh otherwise. */
  function xyzOf(eye, spectrum, emitted = null) {
    const own = emitted && eye.emitted && eye.emitted.length ? eye.emitted : null;
    return [0, 1, 2].map(c => sum(eye.weights.map((weight, w) => weight[c] * spectrum[w] + (own ? (own[w][c] - weight[c]) * emitted[w] : 0))));
  }
  const whiteOf = eye => [0, 1, 2].map(c => sum(eye.weights.map(weight => weight[c])));
  function labOf(xyz, white) {
    const [x, y, z] = xyz.map((v, c) => { const t = v / white[c]; return t > 216 / 24389 ? Math.cbrt(t) : 841 / 108 * t + 16 / 116; });
    return [116 * y - 16, 500 * (x - y), 200 * (y - z)];
  }
  /** CIEDE2000 (Sharma, Wu and Dalal, 2005). */
  function deltaE(first, second) {
    const [l1, a1, b1] = first, [l2, a2, b2] = second, rad = Math.PI / 180, cut = c => Math.sqrt(c ** 7 / (c ** 7 + 25 ** 7));
    const stretch = 1 + 0.5 * (1 - cut((Math.hypot(a1, b1) + Math.hypot(a2, b2)) / 2));
    const c1 = Math.hypot(a1 * stretch, b1), c2 = Math.hypot(a2 * stretch, b2), hue = (a, b) => { const h = Math.atan2(b, a); return h < 0 ? h + TAU : h; };
    const h1 = hue(a1 * stretch, b1), h2 = hue(a2 * stretch, b2);
    let between = h2 - h1;
    if (between > Math.PI) between -= TAU; else if (between < -Math.PI) between += TAU;
    const dh = 2 * Math.sqrt(c1 * c2) * Math.sin(between / 2), l = (l1 + l2) / 2, c = (c1 + c2) / 2;
    let h = h1 + h2;
    if (c1 * c2 !== 0) h = Math.abs(h1 - h2) <= Math.PI ? h / 2 : h < TAU ? (h + TAU) / 2 : (h - TAU) / 2;
    const t = 1 - 0.17 * Math.cos(h - 30 * rad) + 0.24 * Math.cos(2 * h) + 0.32 * Math.cos(3 * h + 6 * rad) - 0.2 * Math.cos(4 * h - 63 * rad);
    const sl = 1 + 0.015 * (l - 50) ** 2 / Math.sqrt(20 + (l - 50) ** 2), sc = 1 + 0.045 * c, sh = 1 + 0.015 * c * t;
    const rt = -Math.sin(60 * rad * Math.exp(-(((h / rad - 275) / 25) ** 2))) * 2 * cut(c);
    const [x, y, z] = [(l2 - l1) / sl, (c2 - c1) / sc, dh / sh];
    return Math.sqrt(Math.max(x * x + y * y + z * z + rt * y * z, 0));
  }
  const BRADFORD = [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];
  const BACK = [[0.9869929, -0.1470543, 0.1599627], [0.4323053, 0.5183603, 0.0492912], [-0.0085287, 0.0400428, 0.9684867]];
  const RGB = [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]];
  const by = (m, v) => m.map(row => sum(row.map((x, k) => x * v[k])));
  /** sRGB from 0 to 1, adapted to the screen's white; clipped. */
  function screen(xyz, white) {
    const here = by(BRADFORD, white), there = by(BRADFORD, [95.047, 100, 108.883]);
    const adapt = v => by(BACK, by(BRADFORD, v).map((x, k) => x * there[k] / here[k]));
    const w = by(RGB, adapt(white));
    return by(RGB, adapt(xyz)).map((c, k) => Math.min(Math.max(c / w[k], 0), 1)).map(c => c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055);
  }
  return { Library, Refusal, deltaE, labOf, whiteOf, xyzOf, screen, spreadShare, plates: { then, turned, repeated, identity, zeros } };
})();
if (typeof module !== "undefined") module.exports = inkwave;
