// The controls of the page: two states, what they look like, and what is kept of them.
"use strict";
(() => {
  const $ = id => document.getElementById(id), MOST_POINTS = 600, COVERAGE = 1.96;
  const make = (tag, parts = {}, ...children) => {
    const node = document.createElement(tag);
    for (const [key, value] of Object.entries(parts)) {
      if (key.startsWith("on")) node.addEventListener(key.slice(2), value);
      else if (key === "style") node.style.cssText = value;
      else node.setAttribute(key, value);
    }
    node.append(...children);
    return node;
  };
  const shown = (value, error, digits = 2) => error === undefined || error === null ? `${value.toFixed(digits)} ± …` : `${value.toFixed(digits)} ± ${(COVERAGE * error).toFixed(digits)}`;
  const css = rgb => `rgb(${rgb.map(c => Math.round(255 * c)).join(",")})`;
  const PAPERS = { "white, 0.9": 0.9, "bright, 0.95": 0.95, "newsprint, 0.6": 0.6, "grey card, 0.2": 0.2, "black card, 0.04": 0.04 };
  // a usual brightener: it takes light about 365 nm, and emits about 440 nm
  const EXCITATION = [[330, 0], [345, 0.45], [365, 0.75], [385, 0.5], [400, 0.2], [420, 0]];
  const EMISSION = [[410, 0], [420, 0.35], [440, 1], [460, 0.75], [480, 0.4], [500, 0.15], [540, 0]];
  let library = null, swatches = new Map(), gamut = null, running = [0, 0], results = [null, null];
  let states = [];

  function fail(error) {
    $("error").hidden = !error;
    $("error").textContent = error ? (error instanceof inkwave.Refusal ? error.message : `this page failed: ${error.message}`) : "";
    if (error && !(error instanceof inkwave.Refusal)) console.error(error);
  }

  const usual = () => ({ layers: [], albedo: 0.9, contact: false, dots: false, coverage: 0.5, ruling: 60, spread: 40, brightener: 0, condition: "", illuminant: "D65", observer: "2", geometry: "45:0" });

  function composition(state) {
    const glows = state.brightener > 0, paper = { albedo: state.albedo, contact: state.contact };
    if (glows) paper.fluorescence = { excitation: EXCITATION, emission: EMISSION, yield: state.brightener };
    const screen = { ruling_per_cm: state.ruling, spread_um: state.spread };
    const dots = state.dots === "each" ? screen : state.dots ? { coverage: state.coverage, ...screen } : undefined;
    const placed = ({ plate, thickness_um, coverage }) => ({ plate, ...(thickness_um ? { thickness_um } : {}), ...(state.dots === "each" ? { coverage: coverage === undefined ? state.coverage : coverage } : {}) });
    return { layers: state.layers.map(placed), paper, ...(dots ? { dots } : {}), illuminant: state.illuminant, observer: state.observer, ...(glows && state.condition ? { condition: state.condition } : {}) };
  }
  /** Whether the library's light excites the brightener. */
  const excites = () => library.lights.length > 0 && library.nm[0] <= EXCITATION[0][0] + 5;
  const seen = state => state.geometry === "45:0" ? ["factors", "lab"] : ["natural_light", "lab_natural_light"];

  function load(content) {
    library = new inkwave.Library(content);
    if (!library.eyes.length) throw new inkwave.Refusal("the library's wavelengths carry no colour: allowed are three or more from 440 to 610 nm and beyond; gather plates of such");
    const names = [...library.plates.keys()];
    $("about").textContent = `${names.length} plates at ${library.nm.length} wavelengths, ${library.nm[0]} to ${library.nm.at(-1)} nm, between half-spaces of index ${library.index}; ${content.program}, method ${content.method}. Layers are composed here, not solved.`;
    swatches = new Map(names.map(name => {
      const found = library.compose({ layers: [{ plate: name }] });
      return [name, css(inkwave.screen(inkwave.xyzOf(library.eyes[0], found.factors), inkwave.whiteOf(library.eyes[0])))];
    }));
    gamut = null;
    states = fromLink() || [{ ...usual(), layers: [{ plate: names[0] }] }, { ...usual(), layers: [{ plate: names.at(-1) }] }];
    inks();
    draw();
  }

  function inks() {
    $("inks").replaceChildren(...[...library.plates.keys()].map(name => {
      const chip = make("button", { draggable: "true", title: plateInWords(name), onclick: () => put(target(), name) }, make("span", { class: "swatch", style: `background:${swatches.get(name)}` }), name);
      chip.addEventListener("dragstart", event => event.dataTransfer.setData("text/plain", JSON.stringify({ plate: name })));
      return chip;
    }));
  }
  const target = () => Number(document.querySelector("[name=target]:checked").value);
  const plateOf = name => library.content.plates[library.plates.get(name)];
  /** A number with six significant digits. */
  const brief = value => String(Number(value.toPrecision(6)));
  function plateInWords(name) {
    const { pigments, thickness_um, slabs, binder } = plateOf(name);
    const grains = pigments.map(p => `${p.name} ${(100 * p.volume_fraction).toFixed(0)} %, ${p.size_nm[0] === p.size_nm[1] ? p.size_nm[0] : p.size_nm.join(" to ")} nm`).join("; ");
    return `${grains}; binder ${binder}; ${slabs ? `slabs of ${brief(thickness_um)} µm` : `${brief(thickness_um)} µm`}`;
  }

  function put(k, plate, place = 0) {
    states[k].layers.splice(place, 0, { plate });
    draw();
  }

  /** The place among the layers of a list at a height on the screen. */
  const placeAt = (list, y) => [...list.children].filter(item => { const box = item.getBoundingClientRect(); return y > box.top + box.height / 2; }).length;

  function layerItem(k, i) {
    const state = states[k], layer = state.layers[i], plate = plateOf(layer.plate);
    const same = library.content.plates.filter(other => other.ink === plate.ink);
    let thickness;
    if (plate.slabs) {
      const value = layer.thickness_um || 2 * plate.thickness_um;
      thickness = make("input", { type: "number", value, min: 2 * plate.thickness_um, step: plate.thickness_um / 2, "aria-label": "Thickness in µm", onchange: event => { layer.thickness_um = Number(event.target.value); draw(); } });
    } else {
      thickness = make("select", { "aria-label": "Thickness", onchange: event => { layer.plate = event.target.value; delete layer.thickness_um; draw(); } },
        ...same.filter(other => !other.slabs).map(other => { const option = make("option", { value: other.name }, `${brief(other.thickness_um)} µm`); option.selected = other.name === layer.plate; return option; }));
    }
    const own = layer.coverage === undefined ? state.coverage : layer.coverage;
    const dots = state.dots === "each" ? [make("input", { type: "range", class: "coverage", min: 0, max: 1, step: 0.01, value: own, title: `${(100 * own).toFixed(0)} %`, "aria-label": `Coverage of ${layer.plate}`, oninput: event => { layer.coverage = Number(event.target.value); look(k); }, onchange: () => draw() })] : [];
    const move = by => { const to = i + by; if (to >= 0 && to < state.layers.length) { state.layers.splice(to, 0, state.layers.splice(i, 1)[0]); draw(); } };
    const item = make("li", { draggable: "true" },
      make("span", { class: "swatch", style: `background:${swatches.get(layer.plate)}` }), make("span", { class: "name", title: plateInWords(layer.plate) }, layer.plate), thickness, plate.slabs ? "µm" : "",
      make("button", { "aria-label": `${layer.plate} up`, onclick: () => move(-1) }, "↑"), make("button", { "aria-label": `${layer.plate} down`, onclick: () => move(1) }, "↓"),
      make("button", { "aria-label": `Remove ${layer.plate}`, onclick: () => { state.layers.splice(i, 1); draw(); } }, "×"), ...dots);
    item.addEventListener("dragstart", event => { item.classList.add("dragged"); event.dataTransfer.setData("text/plain", JSON.stringify({ from: k, place: i })); });
    item.addEventListener("dragend", () => item.classList.remove("dragged"));
    return item;
  }

  function stackList(k) {
    const list = make("ol", { class: "stack", "aria-label": `Layers of ${"AB"[k]}, the top one first` }, ...states[k].layers.map((_, i) => layerItem(k, i)));
    list.addEventListener("dragover", event => event.preventDefault());
    list.addEventListener("drop", event => {
      event.preventDefault();
      let what;
      try { what = JSON.parse(event.dataTransfer.getData("text/plain")); } catch { return; }
      let to = placeAt(list, event.clientY);
      if (what.plate && library.plates.has(what.plate)) return put(k, what.plate, to);
      if (!states[what.from] || !states[what.from].layers[what.place]) return;
      if (what.from === k && what.place < to) to -= 1;
      const [layer] = states[what.from].layers.splice(what.place, 1);
      states[k].layers.splice(to, 0, layer);
      draw();
    });
    return list;
  }

  function field(title, control, ...more) { return make("label", {}, title, make("br"), control, ...more); }
  function choice(options, value, change) {
    return make("select", { onchange: event => { change(event.target.value); draw(); } }, ...options.map(([key, text]) => { const o = make("option", { value: key }, text); o.selected = String(key) === String(value); return o; }));
  }
  function number(state, key, least, most, step) {
    return make("input", { type: "number", min: least, max: most, step, value: state[key], onchange: event => { state[key] = Number(event.target.value); draw(); } });
  }

  function controls(k) {
    const state = states[k], papers = Object.entries(PAPERS);
    const isListed = papers.some(([, albedo]) => albedo === state.albedo);
    const paper = choice([...papers.map(([name, albedo]) => [albedo, name]), ...(isListed ? [] : [["own", "own"]])], isListed ? state.albedo : "own", value => { if (value !== "own") state.albedo = Number(value); });
    const own = make("input", { type: "text", "aria-label": "Albedo, or rows of nm and albedo", value: typeof state.albedo === "number" ? state.albedo : state.albedo.map(row => row.join(" ")).join("; "), onchange: event => {
      const rows = event.target.value.split(";").map(row => row.trim().split(/[\s,]+/).map(Number));
      state.albedo = rows.length === 1 && rows[0].length === 1 ? rows[0][0] : rows;
      draw();
    } });
    const check = (key, title) => { const box = make("input", { type: "checkbox", onchange: event => { state[key] = event.target.checked; draw(); } }); box.checked = state[key]; return make("label", {}, box, ` ${title}`); };
    const coverage = make("input", { type: "range", min: 0, max: 1, step: 0.01, value: state.coverage, "aria-label": "Coverage", oninput: event => { state.coverage = Number(event.target.value); state.dots = state.dots || true; look(k); }, onchange: () => draw() });
    const brightener = make("input", { type: "range", min: 0, max: 1, step: 0.02, value: state.brightener, "aria-label": "Quanta that the brightener emits per quantum absorbed", oninput: event => { state.brightener = Number(event.target.value); look(k); }, onchange: () => draw() });
    if (!excites()) {
      brightener.disabled = true;
      brightener.title = `the library starts at ${library.nm[0]} nm, and a brightener is excited from ${EXCITATION[0][0]} nm on: solve its layers from there`;
    }
    const illuminants = [...new Set(library.eyes.map(eye => eye.illuminant))], observers = [...new Set(library.eyes.map(eye => eye.observer))];
    return make("div", { class: "fields" },
      field("Paper or card", paper), field("Albedo, or nm albedo; …", own), check("contact", "in optical contact"),
      field("Printed", choice([["", "solid"], ["whole", "in dots"], ["each", "each ink in dots"]], state.dots === true ? "whole" : state.dots || "", value => { state.dots = value === "whole" ? true : value; })),
      field(`Coverage ${(100 * state.coverage).toFixed(0)} %`, coverage), field("Dots per cm", number(state, "ruling", 1, 1000, 1)), field("Spread, µm", number(state, "spread", 0, 10000, 1)),
      field(excites() ? `Brightener ${(100 * state.brightener).toFixed(0)} %` : `Brightener: takes a library from ${EXCITATION[0][0]} nm on`, brightener),
      field("Its light", choice([["", "as the light"], ["M0", "M0, lamp"], ["M1", "M1, D50"], ["M2", "M2, no UV"]], state.condition, value => { state.condition = value; })),
      field("Light", choice(illuminants.map(x => [x, x]), state.illuminant, value => { state.illuminant = value; })),
      field("Observer", choice(observers.map(x => [x, `${x}°`]), state.observer, value => { state.observer = value; })),
      field("Seen", choice([["45:0", "lit at 45°"], ["natural", "under a sky"]], state.geometry, value => { state.geometry = value; })));
  }

  function draw() {
    fail(null);
    $("states").replaceChildren(...states.map((state, k) => make("section", { class: "state", id: `state-${k}`, style: `--own: var(--${"ab"[k]})` },
      make("h2", {}, "AB"[k]), make("div", { class: "patch", id: `patch-${k}`, role: "img" }), make("div", { class: "numbers", id: `numbers-${k}` }),
      ...scalarSurface(state), make("p", { class: "soft" }, "Top of the stack"), stackList(k), make("p", { class: "soft" }, "Paper; in dots, from bare to solid:"), make("div", { class: "strip", id: `strip-${k}`, title: "Coverage from 0 to 100 %" }),
      make("p", { class: "soft" }, "Solid under a sky, seen along the normal to 60° from it:"), make("div", { class: "strip", id: `angles-${k}`, role: "img" }), make("p", { class: "scale soft" }, ...[0, 15, 30, 45, 60].map(deg => make("span", {}, `${deg}°`))), controls(k))));
    states.forEach((_, k) => look(k));
    if (gamut) hull();
  }

  /** What the scalar wave makes of the surface of paper that is seen bare between dots. */
  function scalarSurface(state) {
    if (library.content.wave !== "scalar" || !state.dots || !state.contact || library.index === 1) return [];
    return [make("p", { class: "soft" }, "The scalar wave crosses the paper's surface as s light, and the paper between the dots is seen in unpolarised light: a clear layer does not look quite like bare paper. Plates solved with light.wave = \"unpolarised\" have both alike.")];
  }

  const xyzOf = (eye, found, name) => inkwave.xyzOf(eye, found[name], found.emitted[name]);

  /** What a state looks like: at once without bars, which follow. */
  async function look(k) {
    const state = states[k], run = ++running[k];
    results[k] = null;
    try {
      if (!state.layers.length) { $(`numbers-${k}`).textContent = "no layer: drag an ink here"; $(`patch-${k}`).style.background = "none"; $(`angles-${k}`).replaceChildren(); return summary(); }
      const wanted = composition(state), found = library.compose(wanted), eye = library.eye(wanted);
      results[k] = { state, found, errors: null };
      const xyz = xyzOf(eye, found, seen(state)[0]);
      $(`patch-${k}`).style.background = css(inkwave.screen(xyz, inkwave.whiteOf(eye)));
      strip(k, state, wanted, eye);
      angles(k, wanted, eye);
      summary();
      const errors = await library.errors(wanted, found, async () => { await new Promise(done => setTimeout(done)); return running[k] !== run; });
      if (errors) { results[k].errors = errors; summary(); }
    } catch (error) { fail(error); summary(); }
  }

  function strip(k, state, wanted, eye) {
    const steps = 11, dots = { ruling_per_cm: state.ruling, spread_um: state.spread };
    $(`strip-${k}`).replaceChildren(...Array.from({ length: steps }, (_, i) => {
      const found = library.compose({ ...wanted, layers: wanted.layers.map(({ coverage, ...layer }) => layer), dots: { ...dots, coverage: i / (steps - 1) } });
      return make("div", { style: `background:${css(inkwave.screen(xyzOf(eye, found, "factors"), inkwave.whiteOf(eye)))}` });
    }));
  }

  /** The strip of a run's picture, lying: the solid in natural light by viewing angle. */
  function angles(k, wanted, eye) {
    const all = library.overAngles(wanted), lab = ([, ...light]) => inkwave.labOf(inkwave.xyzOf(eye, ...light), inkwave.whiteOf(eye)).map(x => x.toFixed(1)).join(", ");
    $(`angles-${k}`).replaceChildren(...all.map(own => make("div", { title: `${own[0]}°: L*, a*, b* ${lab(own)}`, style: `background:${css(inkwave.screen(inkwave.xyzOf(eye, ...own.slice(1)), inkwave.whiteOf(eye)))}` })));
    $(`angles-${k}`).setAttribute("aria-label", `Colours of ${"AB"[k]} by viewing angle: ${lab(all[0])} at 0°, ${lab(all.at(-1))} at ${all.at(-1)[0]}°`);
  }

  function summary() {
    results.forEach((result, k) => {
      if (!result || !$(`numbers-${k}`)) return;
      const { state, found, errors } = result, [spectrum, name] = seen(state), lab = found[name], bars = errors ? errors[name] : [];
      const words = ["L*", "a*", "b*"].map((letter, c) => `${letter} ${shown(lab[c], bars[c])}`).join(", ");
      $(`numbers-${k}`).textContent = `${words}\ncontrast ratio ${shown(found.contrast_ratio, errors ? errors.contrast_ratio : null, 3)}`;
      $(`patch-${k}`).setAttribute("aria-label", `Colour of ${"AB"[k]}: ${words}, ${spectrum}`);
    });
    const [a, b] = results;
    $("difference").textContent = a && b ? `ΔE₀₀ between A and B: ${inkwave.deltaE(a.found[seen(a.state)[1]], b.found[seen(b.state)[1]]).toFixed(2)}` : "";
    chart();
  }

  const svg = (tag, parts, ...children) => { const node = document.createElementNS("http://www.w3.org/2000/svg", tag); for (const [key, value] of Object.entries(parts)) node.setAttribute(key, value); node.append(...children); return node; };
  function frame(width, height, [x0, x1], [y0, y1], titles) {
    const left = 40, bottom = 34, top = 10, right = 10, x = v => left + (v - x0) / (x1 - x0) * (width - left - right), y = v => height - bottom - (v - y0) / (y1 - y0) * (height - top - bottom);
    const node = svg("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": titles.join(" against ") });
    node.append(svg("rect", { class: "axis", x: left, y: top, width: width - left - right, height: height - top - bottom }));
    const ticks = (from, to) => { const raw = (to - from) / 5, power = 10 ** Math.floor(Math.log10(raw)), step = [1, 2, 5, 10].map(m => m * power).find(s => s >= raw), all = []; for (let v = Math.ceil(from / step) * step; v <= to + 1e-9; v += step) all.push(Number(v.toPrecision(6))); return all; };
    for (const v of ticks(x0, x1)) node.append(svg("path", { class: "axis", d: `M${x(v)} ${height - bottom}v4` }), svg("text", { x: x(v), y: height - bottom + 16, "text-anchor": "middle" }, `${v}`));
    for (const v of ticks(y0, y1)) node.append(svg("path", { class: "axis", d: `M${left} ${y(v)}h-4` }), svg("text", { x: left - 7, y: y(v) + 4, "text-anchor": "end" }, `${v}`));
    node.append(svg("text", { x: width - right, y: height - 4, "text-anchor": "end" }, titles[1]), svg("text", { x: 2, y: 9 }, titles[0]));
    return { node, x, y };
  }

  function chart() {
    const nm = library.nm, both = results.map((r, k) => r && { k, values: r.found[seen(r.state)[0]], errors: r.errors ? r.errors[seen(r.state)[0]] : null }).filter(Boolean);
    const most = Math.max(0.1, ...both.flatMap(r => r.values.map((v, i) => v + (r.errors ? COVERAGE * r.errors[i] : 0))));
    const { node, x, y } = frame(460, 260, [nm[0], nm.at(-1)], [0, Math.max(most * 1.05, 0.2)], ["factor", "nm"]);
    for (const { k, values, errors } of both) {
      const line = list => list.map((v, i) => `${i ? "L" : "M"}${x(nm[i]).toFixed(1)} ${y(Math.max(v, 0)).toFixed(1)}`).join("");
      if (errors) {
        const upper = values.map((v, i) => v + COVERAGE * errors[i]), lower = values.map((v, i) => Math.max(v - COVERAGE * errors[i], 0));
        node.append(svg("path", { d: `${line(upper)}L${lower.map((v, i) => `${x(nm[i]).toFixed(1)} ${y(v).toFixed(1)}`).reverse().join("L")}Z`, fill: `var(--${"ab"[k]})`, opacity: 0.25 }));
      }
      node.append(svg("path", { d: line(values), fill: "none", stroke: `var(--${"ab"[k]})`, "stroke-width": 2, ...(k ? { "stroke-dasharray": "6 3" } : {}) }));
      node.append(svg("text", { x: x(nm.at(-1)) - 12, y: y(values.at(-1)) - 5 }, "AB"[k]));
    }
    $("chart").replaceChildren(node);
  }

  /** All stacks of up to three plates, thinned out to a number that is quickly composed. */
  function stacks() {
    const names = [...library.plates.keys()], all = names.map(a => [a]);
    for (const a of names) for (const b of names) if (a !== b) all.push([a, b]);
    for (const a of names) for (const b of names) for (const c of names) if (a !== b && b !== c && a !== c) all.push([a, b, c]);
    const pairs = names.length ** 2;
    if (all.length <= MOST_POINTS) return all;
    const every = Math.ceil((all.length - pairs) / Math.max(MOST_POINTS - pairs, 60));
    return all.filter((_, i) => i < Math.min(pairs, MOST_POINTS) || (i - pairs) % every === 0);
  }
  async function composeAll(about) {
    const state = states[0], base = composition(state.dots === "each" ? { ...state, dots: true } : state), key = JSON.stringify([{ ...base, layers: 0 }, state.geometry]);
    if (gamut && gamut.key === key) return gamut;
    const points = [], all = stacks();
    for (let i = 0; i < all.length; i++) {
      const found = library.compose({ ...base, layers: all[i].map(plate => ({ plate })) }), eye = library.eye(base);
      points.push({ names: all[i], lab: found[seen(state)[1]], css: css(inkwave.screen(xyzOf(eye, found, seen(state)[0]), inkwave.whiteOf(eye))) });
      if (i % 10 === 9) { about.textContent = `${i + 1} of ${all.length} stacks`; await new Promise(done => setTimeout(done)); }
    }
    about.textContent = `${all.length} stacks of up to three layers on the paper of A`;
    return gamut = { key, points };
  }
  function hullOf(points) {
    const sorted = [...points].sort((p, q) => p[0] - q[0] || p[1] - q[1]), cross = (o, a, b) => (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
    const half = list => { const out = []; for (const p of list) { while (out.length > 1 && cross(out.at(-2), out.at(-1), p) <= 0) out.pop(); out.push(p); } return out.slice(0, -1); };
    return [...half(sorted), ...half(sorted.reverse())];
  }
  function hull() {
    const axes = $("projection").value.split(",").map(Number), titles = ["L*", "a*", "b*"], points = gamut.points.map(p => [p.lab[axes[0]], p.lab[axes[1]]]);
    const span = axis => { const all = points.map(p => p[axis]), pad = 0.05 * (Math.max(...all) - Math.min(...all)) + 1; return [Math.min(...all) - pad, Math.max(...all) + pad]; };
    const { node, x, y } = frame(460, 320, span(0), span(1), [titles[axes[1]], titles[axes[0]]]);
    node.append(svg("path", { d: `M${hullOf(points).map(p => `${x(p[0]).toFixed(1)} ${y(p[1]).toFixed(1)}`).join("L")}Z`, fill: "none", stroke: "var(--soft)" }));
    gamut.points.forEach((p, i) => {
      const dot = svg("circle", { cx: x(points[i][0]), cy: y(points[i][1]), r: 4, fill: p.css, stroke: "var(--line)" }, svg("title", {}, `${p.names.join(" on ")}: ${p.lab.map(v => v.toFixed(1)).join(", ")}`));
      dot.addEventListener("click", () => { states[0].layers = p.names.map(plate => ({ plate })); draw(); });
      node.append(dot);
    });
    results.forEach((r, k) => { if (r) { const lab = r.found[seen(r.state)[1]]; node.append(svg("text", { x: x(lab[axes[0]]), y: y(lab[axes[1]]), style: `fill: var(--${"ab"[k]}); font-size: 15px; font-weight: bold` }, "AB"[k])); } });
    $("hull").replaceChildren(node);
  }

  async function search() {
    const wanted = ["l", "a", "b"].map(c => Number($(`want-${c}`).value)), { points } = await composeAll($("search-about"));
    const best = points.map(p => ({ ...p, distance: inkwave.deltaE(p.lab, wanted) })).sort((p, q) => p.distance - q.distance).slice(0, 5);
    $("found").replaceChildren(make("tr", {}, ...["", "stack, top first", "L*, a*, b*", "ΔE₀₀", ""].map(title => make("th", {}, title))),
      ...best.map(p => make("tr", {}, make("td", {}, make("div", { class: "swatch", style: `background:${p.css}` })), make("td", {}, p.names.join(" on ")), make("td", {}, p.lab.map(v => v.toFixed(1)).join(", ")), make("td", {}, p.distance.toFixed(2)),
        make("td", {}, make("button", { onclick: () => { states[1].layers = p.names.map(plate => ({ plate })); for (const key of ["albedo", "contact", "dots", "coverage", "ruling", "spread", "brightener", "condition", "illuminant", "observer", "geometry"]) states[1][key] = states[0][key]; draw(); } }, "to B")))));
  }

  /** Rows of nm and factor of a measured spectrum: the first sample of a CGATS file, or lines of two numbers. */
  function spectrumOf(text) {
    const format = text.match(/BEGIN_DATA_FORMAT\s+([\s\S]*?)\s+END_DATA_FORMAT/), data = text.match(/BEGIN_DATA\s+([\s\S]*?)\s+END_DATA/);
    let rows;
    if (format && data) {
      const values = data[1].split("\n")[0].match(/"[^"]*"|\S+/g) || [];
      rows = format[1].split(/\s+/).map((field, k) => [field.match(/^SPECTRAL_(?:NM_?)?(\d+(?:\.\d+)?)$/i), Number(values[k])]).filter(([nm]) => nm).map(([nm, value]) => [Number(nm[1]), value]);
    } else rows = text.split("\n").map(line => line.trim().split(/[\s,;]+/).map(Number)).filter(([nm, value]) => nm > 200 && Number.isFinite(value)).map(([nm, value]) => [nm, value]);
    rows.sort((p, q) => p[0] - q[0]);
    const percent = rows.some(row => row[1] > 2);
    return percent ? rows.map(([nm, value]) => [nm, value / 100]) : rows;
  }
  async function measured(file) {
    const rows = spectrumOf(await file.text()), eye = library.eye(composition(states[0])), seen = library.nm.filter((_, w) => eye.weights[w].some(x => x !== 0));
    if (rows.length < 3 || rows[0][0] > seen[0] || rows.at(-1)[0] < seen.at(-1)) {
      const found = rows.length ? `${rows.length} wavelengths from ${rows[0][0]} to ${rows.at(-1)[0]} nm` : "no spectrum";
      throw new inkwave.Refusal(`${file.name}: found ${found}; allowed are lines of nm and factor, or CGATS with SPECTRAL_NM fields, from ${seen[0]} to ${seen.at(-1)} nm`);
    }
    const at = nm => { const k = Math.max(rows.findIndex(row => row[0] >= nm), 1), [[a, x], [b, y]] = [rows[k - 1], rows[k]]; return x + (nm - a) / (b - a) * (y - x); };
    const lab = inkwave.labOf(inkwave.xyzOf(eye, library.nm.map(nm => seen.includes(nm) ? at(nm) : 0)), inkwave.whiteOf(eye));
    ["l", "a", "b"].forEach((c, k) => { $(`want-${c}`).value = lab[k].toFixed(2); });
    await search();
  }

  function save(name, text) {
    const link = make("a", { href: URL.createObjectURL(new Blob([text], { type: "text/plain" })), download: name });
    document.body.append(link);
    link.click();
    link.remove();
  }
  function cgats() {
    const rows = results.map((r, k) => r && [`"${"AB"[k]} ${r.state.layers.map(l => l.plate).join(" on ").replaceAll('"', "'")}"`, ...r.found[seen(r.state)[1]].map(v => v.toFixed(3)), ...r.found[seen(r.state)[0]].map(v => v.toFixed(6))].join("\t")).filter(Boolean);
    const fields = ["SAMPLE_ID", "LAB_L", "LAB_A", "LAB_B", ...library.nm.map(nm => `SPECTRAL_NM_${nm}`)];
    return `CGATS.17\n\nORIGINATOR\t"${library.content.program}, composed of plates"\nNUMBER_OF_FIELDS\t${fields.length}\nBEGIN_DATA_FORMAT\n${fields.join("\t")}\nEND_DATA_FORMAT\n\nNUMBER_OF_SETS\t${rows.length}\nBEGIN_DATA\n${rows.join("\n")}\nEND_DATA\n`;
  }
  function file() {
    const { layers, paper, dots, ...seenBy } = composition(states[0]);
    const text = value => value && typeof value === "object" && !Array.isArray(value) ? `{ ${Object.entries(value).map(([key, part]) => `${key} = ${text(part)}`).join(", ")} }` : JSON.stringify(value);
    const table = parts => Object.entries(parts).map(([key, value]) => `${key} = ${text(value)}`).join("\n");
    return `# State A. inkwave compose composition.toml --library library.json\n${table(seenBy)}\n\n${layers.map(layer => `[[layers]]\n${table(layer)}\n`).join("\n")}\n[paper]\n${table(paper)}\n${dots ? `\n[dots]\n${table(dots)}\n` : ""}`;
  }
  const toLink = () => `#${encodeURIComponent(JSON.stringify(states))}`;
  function fromLink() {
    if (location.hash.length < 2) return null;
    try {
      const found = JSON.parse(decodeURIComponent(location.hash.slice(1)));
      const known = found.length === 2 && found.every(state => state.layers.every(layer => library.plates.has(layer.plate)));
      if (!known) throw new inkwave.Refusal("the link names plates that this library does not have; shown are others: open the page of the library that it was made with");
      return found.map(state => ({ ...usual(), ...state }));
    } catch (error) { setTimeout(() => fail(error instanceof inkwave.Refusal ? error : new inkwave.Refusal("the link is no state of this page; shown is the usual one: copy the link again"))); return null; }
  }

  $("copy").addEventListener("click", () => { states[1] = JSON.parse(JSON.stringify(states[0])); draw(); });
  $("gamut").addEventListener("click", async () => { try { await composeAll($("gamut-about")); hull(); } catch (error) { fail(error); } });
  $("projection").addEventListener("change", () => { if (gamut) hull(); });
  $("search").addEventListener("click", () => search().catch(fail));
  $("measured").addEventListener("change", event => { fail(null); measured(event.target.files[0]).catch(fail); });
  $("link").addEventListener("click", async () => {
    location.hash = toLink();
    try { await navigator.clipboard.writeText(location.href); $("kept").textContent = "The link is copied, and stands in the address bar."; } catch { $("kept").textContent = "The link stands in the address bar."; }
  });
  $("cgats").addEventListener("click", () => save("composition.cgats", cgats()));
  $("file").addEventListener("click", () => save("composition.toml", file()));
  $("open").addEventListener("change", async event => {
    try {
      let content;
      try { content = JSON.parse(await event.target.files[0].text()); } catch { throw new inkwave.Refusal(`${event.target.files[0].name}: found no JSON; allowed is a file that \`inkwave library\` has written`); }
      location.hash = "";
      load(content);
    } catch (error) { fail(error); }
  });
  window.inkwavePage = { state: () => states, cgats, file, results: () => results };
  try {
    const text = $("library") ? $("library").textContent.trim() : "";
    if (!text) throw new inkwave.Refusal("found no library in this page; allowed is a page that `inkwave library --page` has written: open a library below, or write the page again");
    load(JSON.parse(text));
  } catch (error) { fail(error instanceof SyntaxError ? new inkwave.Refusal("the library in this page is cut off: write the page again with `inkwave library --page`") : error); }
})();
