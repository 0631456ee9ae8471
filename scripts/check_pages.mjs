// Checks of the pages for exploring; called by scripts/check-pages.
import { chromium } from "playwright-core";
import { readFileSync, statSync, mkdirSync } from "node:fs";

const [, , sweep, packing, shots] = process.argv;
mkdirSync(shots, { recursive: true });
const failures = [];
function claim(name, holds, detail = "") {
  console.log(`${holds ? "ok     " : "FAILED "} ${name}${detail ? ": " + detail : ""}`);
  if (!holds) failures.push(name);
}

/** Rows of a CSV file by column; quotes keep commas. */
function table(path) {
  const lines = readFileSync(path, "utf8").trim().split("\n").map(line => {
    const cells = [];
    for (const match of line.matchAll(/("(?:[^"]|"")*"|[^,]*)(?:,|$)/g)) cells.push(match[1].replace(/^"|"$/g, "").replaceAll('""', '"'));
    return cells;
  });
  return lines.slice(1).map(cells => Object.fromEntries(lines[0].map((name, i) => [name, cells[i]])));
}

const browser = await chromium.launch({
  executablePath: "/usr/bin/chromium",
  args: ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic",
    "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"],
});

async function open(url, width, height) {
  const page = await browser.newPage({ viewport: { width, height } });
  const trouble = [];
  page.on("console", message => { if (message.type() === "error") trouble.push(message.text()); });
  page.on("pageerror", error => trouble.push(error.message));
  page.on("request", request => { if (!/^(file|data|blob):/.test(request.url())) trouble.push("network: " + request.url()); });
  await page.goto(url);
  await page.waitForTimeout(300);
  return { page, trouble };
}

const overflow = page => page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);

async function explore() {
  const url = `file://${sweep}/explore.html`;
  const megabytes = statSync(`${sweep}/explore.html`).size / 1e6;
  const { page, trouble } = await open(url, 1200, 1000);
  const rows = table(`${sweep}/sweep.csv`);
  const variants = await page.evaluate(() => solved.length), all = await page.evaluate(() => data.variants.length);
  claim("explore.html holds every variant", variants === rows.length, `${variants} of ${rows.length}`);
  claim("size for 260 variants", megabytes * 260 / Math.max(variants, 1) <= 2 || megabytes <= 2 && all >= 260, `${megabytes.toFixed(3)} MB for ${all}`);
  const rising = await page.evaluate(() => data.wavelengths_nm.every((nm, i, all) => i === 0 || nm > all[i - 1]));
  claim("every wavelength stands once", rising);
  const columns = ["L", "a", "b", "C", "h_deg", "delta_e_2000"].concat(["delta_e_2000_to_target", "contrast_ratio"].filter(name => name in rows[0]));
  let worst = 0, compared = 0;
  for (const row of rows) {
    const shown = await page.evaluate(name => {
      const target = data.variants.find(v => v.name === name);
      target.place.forEach((k, a) => {
        const input = document.getElementById("axis" + a);
        input.value = k;
        input.dispatchEvent(new Event("input"));
      });
      // all sliders are set one after the other: once more, now that every axis is in place
      target.place.forEach((k, a) => { document.getElementById("axis" + a).value = k; });
      target.place.forEach((k, a) => document.getElementById("axis" + a).dispatchEvent(new Event("input")));
      return { variant: document.body.dataset.variant, numbers: [...document.querySelectorAll("#numbers tr")].map(tr => [tr.dataset.value, tr.dataset.error]) };
    }, row.variant);
    if (shown.variant !== row.variant) { claim(`the sliders reach ${row.variant}`, false, shown.variant); continue; }
    columns.forEach((column, i) => [["", 0], ["_standard_error", 1]].forEach(([end, k]) => {
      const want = row[column + end], have = shown.numbers[i][k];
      if (want === "" || want === undefined || want === "NaN") return;
      worst = Math.max(worst, Math.abs(Number(want) - Number(have)));
      compared += 1;
    }));
  }
  claim("numbers are those of sweep.csv to a millionth", worst <= 5.01e-7 && compared > 0, `${compared} compared, largest difference ${worst}`);
  await page.evaluate(() => { const input = document.getElementById("axis0"); input.value = 0; input.dispatchEvent(new Event("input")); input.focus(); });
  const before = await page.evaluate(() => document.body.dataset.variant);
  await page.keyboard.press("ArrowRight");
  const after = await page.evaluate(() => document.body.dataset.variant);
  claim("an arrow key moves a slider", before !== after, `${before} → ${after}`);
  await between(page);
  await evaluated(page);
  await toTarget(page, rows);
  await page.click("#hold");
  await page.keyboard.press("Tab");
  await page.screenshot({ path: `${shots}/explore.png`, fullPage: true });
  claim("explore.html: no network, no error", trouble.length === 0, trouble.join("; "));
  const phone = await open(url, 390, 844);
  claim("explore.html fits a phone", await overflow(phone.page) <= 0);
  await phone.page.screenshot({ path: `${shots}/explore-phone.png`, fullPage: true });
}

/** With a target, a button and a key go to the variant that sweep.csv has as the nearest; without one there is neither. */
async function toTarget(page, rows) {
  const column = "delta_e_2000_to_target", shown = await page.isVisible("#nearest");
  if (!(column in rows[0])) { claim("without a target there is no way to it", !shown); return; }
  const nearest = rows.filter(row => row[column] !== "").sort((a, b) => Number(a[column]) - Number(b[column]))[0].variant;
  const here = () => page.evaluate(() => document.body.dataset.variant);
  await page.click("#nearest");
  claim("the button goes to the variant nearest to the target", await here() === nearest, nearest);
  await page.evaluate(() => { const input = document.getElementById("axis0"); input.value = input.value === "0" ? 1 : 0; input.dispatchEvent(new Event("input")); });
  const away = await here();
  await page.keyboard.press("t");
  claim("so does the key T", away !== nearest && await here() === nearest, `${away} → ${nearest}`);
}

/** Sliders of axes of numbers stop between solved variants and say how good that is; the page's formulas give the errors it states. */
async function between(page) {
  const axis = await page.evaluate(() => data.axes.findIndex(axis => axis.between));
  if (axis < 0) { claim("without axes of numbers nothing is interpolated", !await page.isVisible("#certainty")); return; }
  const seen = place => page.evaluate(([a, p]) => {
    const input = $("axis" + a);
    input.value = p;
    input.dispatchEvent(new Event("input"));
    const [L] = [...document.querySelectorAll("#numbers tr")].map(tr => Number(tr.dataset.value));
    return { number: parseFloat($("label" + a).textContent), words: $("certainty").firstChild.textContent, colour: $("chip").style.background, L };
  }, [axis, place]);
  const [low, half, high] = [await seen(0), await seen(0.5), await seen(1)];
  const inside = key => (half[key] - low[key]) * (high[key] - half[key]) > 0;
  claim("half-way a slider says how good the interpolation is", inside("number") && /^interpolated, ± ΔE₀₀ \d+\.\d\d$/.test(half.words), `${half.number}: ${half.words}, L* ${half.L}`);
  claim("half-way the colour is another", half.colour !== low.colour && half.colour !== high.colour, [low, half, high].map(s => s.colour).join(" "));
  claim("at solved values the variant is solved", low.words === "solved" && high.words === "solved");
  await seen(0.5);
  await page.screenshot({ path: `${shots}/explore-between.png`, fullPage: true });
  const worst = await page.evaluate(() => Math.max(...data.axes.flatMap((axis, a) => !axis.between ? [] : solved.map((v, i) => {
    const k = v.place[a], stated = axis.between.left_out[i], xs = coordinates(axis), others = xs.filter((_, j) => j !== k);
    if (stated === null) return 0;
    const line = solved.filter(o => o !== v && o.place.every((j, b) => b === a || j === v.place[b])).sort((o, p) => o.place[a] - p.place[a]);
    const w = weights(others, k - 1, (xs[k] - xs[k - 1]) / (xs[k + 1] - xs[k - 1]));
    return Math.abs(ciede2000([0, 1, 2].map(c => line.reduce((sum, o, j) => sum + w[j] * o.numbers[c][0], 0)), lab(v)) - stated);
  }))));
  claim("leaving one out on the page gives the errors it states", worst < 1e-4, `largest difference ${worst}`);
  await seen(0);
}

/** Sliders of axes that need no other solves stop at variants of their own, whose numbers the page shows as they are, beside axes that are interpolated too. */
async function evaluated(page) {
  const axis = await page.evaluate(() => data.axes.findIndex(axis => axis.steps > 1));
  if (axis < 0) return;
  const move = (a, p) => page.evaluate(([a, p]) => {
    const input = $("axis" + a);
    input.value = p;
    input.dispatchEvent(new Event("input"));
    const v = at(place);
    return { words: $("certainty").firstChild.textContent, shown: Number(document.querySelector("#numbers tr").dataset.value), own: v ? v.numbers[0][0] : null };
  }, [a, p]);
  const half = await move(axis, 0.5);
  claim("between solved papers or slabs a variant of its own is shown", half.words === "evaluated, not interpolated" && half.shown === half.own, JSON.stringify(half));
  await page.screenshot({ path: `${shots}/explore-evaluated.png`, fullPage: true });
  const other = await page.evaluate(() => data.axes.findIndex(axis => axis.between));
  if (other >= 0) {
    const both = await move(other, 0.5);
    const ends = await page.evaluate(([a, b]) => [0, 1].map(k => data.variants.find(v => v.place.every((x, c) => x === (c === a ? 0.5 : c === b ? k : place[c]))).numbers[0][0]), [axis, other]);
    claim("beside an interpolated axis too", both.words.startsWith("interpolated") && both.own === null && Math.abs(both.shown - (ends[0] + ends[1]) / 2) < Math.abs(ends[1] - ends[0]), `${ends[0]} ${both.shown} ${ends[1]}`);
    await move(other, 0);
  }
  await move(axis, 0);
}

/** Share of the canvas that is not background. */
const drawn = page => page.evaluate(() => {
  const canvas = document.getElementById("view"), gl = canvas.getContext("webgl2"), n = 4 * canvas.width * canvas.height, p = new Uint8Array(n);
  gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, p);
  let other = 0;
  for (let i = 0; i < n; i += 4) if (Math.abs(p[i] - p[0]) + Math.abs(p[i + 1] - p[1]) + Math.abs(p[i + 2] - p[2]) > 12) other += 1;
  return other / (n / 4);
});

async function view() {
  const { page, trouble } = await open(`file://${packing}`, 1100, 760);
  const whole = await drawn(page);
  await page.screenshot({ path: `${shots}/packing.png` });
  await page.fill("#cut", "500");
  await page.waitForTimeout(300);
  const half = await drawn(page);
  await page.screenshot({ path: `${shots}/packing-cut.png` });
  claim("the packing is drawn, and the cut takes part of it away", whole > 0.05 && half > 0.02 && half < whole, `${whole.toFixed(3)} → ${half.toFixed(3)} of the canvas`);
  await page.fill("#cut", "0");
  await page.waitForTimeout(300);
  claim("a cut through everything leaves nothing", await drawn(page) === 0);
  claim("packing.html: no network, no error", trouble.length === 0, trouble.join("; "));
  const phone = await open(`file://${packing}`, 390, 844);
  claim("packing.html fits a phone", await overflow(phone.page) <= 0);
  await phone.page.screenshot({ path: `${shots}/packing-phone.png` });
}

await explore();
await view();
await browser.close();
console.log(failures.length ? `${failures.length} checks failed` : "all checks hold");
process.exit(failures.length ? 1 : 0);
