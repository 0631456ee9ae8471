// Judges the page's engine by the numbers of NumPy: node scripts/check_library.mjs
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";

const root = new URL("..", import.meta.url), read = path => readFileSync(new URL(path, root), "utf8");
const inkwave = createRequire(import.meta.url)(new URL("src/library/compose.js", root).pathname);
const library = new inkwave.Library(JSON.parse(read("validation/data/library.json")));
let worst = 0, widest = 0, failed = 0;
const claim = (name, holds, detail) => { console.log(`${holds ? "ok     " : "FAILED "} ${name}: ${detail}`); if (!holds) failed += 1; };
const golden = JSON.parse(read("validation/data/library-golden.json"));
for (const [place, { composition, numbers }] of golden.entries()) {
  // bars take all replicates, a second a stack
  const found = library.compose(composition), bars = place % 3 ? null : await library.errors(composition, found);
  for (const [name, { value, bar }] of Object.entries(numbers)) value.forEach((v, k) => {
    const off = Math.abs([].concat(found[name])[k] - v);
    const far = bars ? Math.abs([].concat(bars[name])[k] - bar[k]) / (1e-6 + bar[k]) : 0;
    if (!(off <= worst)) worst = off;
    if (!(far <= widest)) widest = far;
  });
}
// a promise: values to 1e-6; bars to 1 %, of which two digits are read
claim("48 stacks as NumPy composes them", worst < 1e-6, `largest difference ${worst.toExponential(1)}`);
claim("bars of every third", widest < 1e-2, `largest relative difference ${widest.toExponential(1)}`);
const refused = [
  [{ layers: [] }, "layers: found none"], [{ layers: [{ plate: "gold" }] }, "allowed are red, light, white, pale, foam"],
  [{ layers: [{ plate: "red", thickness_um: 0.7 }] }, "allowed 0.5"], [{ layers: [{ plate: "white", thickness_um: 0.6 }] }, "two slabs"],
  [{ layers: [{ plate: "red" }], paper: { albedo: 1.2 } }, "paper.albedo"], [{ layers: [{ plate: "red" }], illuminant: "F9" }, "F9"],
  [{ layers: [{ plate: "red" }], dots: { coverage: 2, ruling_per_cm: 60, spread_um: 0 } }, "dots.coverage"],
];
const message = make => { try { make(); return "nothing"; } catch (error) { return error.message; } };
for (const [composition, words] of refused) {
  const said = message(() => library.compose(composition));
  claim(`refused: ${words}`, said.includes(words), said);
}
const newer = message(() => new inkwave.Library({ inkwave_library: 6 }));
claim("a newer form is refused", newer.includes("allowed up to 5"), newer);
const { then, turned } = inkwave.plates, flux = library.layerFlux(0, 1, {}, 0), twice = turned(turned(flux));
claim("a plate turned over twice is itself", ["ra", "rb", "tab", "tba"].every(k => twice[k].x.every((v, i) => v === flux[k].x[i])), "identity");
const both = then(flux, turned(flux)), apart = Math.max(...both.ra.x.map((v, i) => Math.abs(v - both.rb.x[i])));
claim("a plate in front of itself turned over is alike from both sides", apart < 1e-12, apart.toExponential(1));
process.exit(failed ? 1 : 0);
