//! Pictures of a layer: from the incident side, cut open, in perspective; and a sheet of grain
//! shapes.

use super::figure::{Canvas, DrawResult, FONT, failed};
use super::raster::{
    BACKGROUND, BINDER, Camera, Frame, Raster, Rgb, drawn, framed, mix, pigment_colour, shade,
};
use crate::ink::Template;
use crate::ink::{Packing, Shape, Solid, Sphere};
use crate::numerics::vector::{dot, norm};
use plotters::prelude::*;

const WIDE: f64 = 860.0;
/// Pixels along the side of a grain's picture on a sheet of shapes.
const TILE: usize = 300;

/// The layer seen along +z, from the incident side: pigment dimmed with its depth below the
/// binder's surface.
pub fn top_picture(packing: &Packing) -> DrawResult<Vec<u8>> {
    let [lx, ly] = packing.period_um();
    let per_um = WIDE / lx.max(ly);
    let height = packing.thickness_um();
    let frame = Frame {
        x: 0.0..lx,
        y: 0.0..ly,
        y_label: "y, µm",
        caption: format!("From the incident side, H = {height:.3} µm; deeper grains are paler"),
        size: ((lx * per_um) as u32, (ly * per_um) as u32),
    };
    framed(frame, "top view", |w, h| paint_top(packing, w, h))
}

fn paint_top(packing: &Packing, w: usize, h: usize) -> Raster {
    let mut raster = Raster::new(w, h, BINDER);
    for (solid, material) in images(packing) {
        paint_top_solid(packing, &solid, pigment_colour(material), &mut raster);
    }
    raster
}

/// Convex bodies and spheres with their materials, and those periodic images that reach into the
/// cell; inner bodies follow those around them.
fn images(packing: &Packing) -> impl Iterator<Item = (Solid, usize)> + '_ {
    let period_um = packing.period_um();
    let nested = packing.grains().iter().flat_map(|g| packing.nested(g));
    let solids = nested.flat_map(|body| body.solids().into_iter().map(move |solid| (solid, body.material)));
    solids.flat_map(move |(solid, material)| {
        images_of(solid, period_um).into_iter().map(move |image| (image, material))
    })
}

/// Pixels within a range in µm, at `per_um` of them.
fn pixels([low, high]: [f64; 2], per_um: f64) -> std::ops::RangeInclusive<i64> {
    (low * per_um).floor() as i64..=(high * per_um).ceil() as i64
}

fn paint_top_solid(packing: &Packing, solid: &Solid, colour: Rgb, raster: &mut Raster) {
    let [lx, ly] = packing.period_um();
    let sx = raster.width as f64 / lx;
    let sy = raster.height as f64 / ly;
    let [[x0, x1], [y0, y1]] = [0, 1].map(|axis| solid.extent_um(axis));
    for j in pixels([ly - y1, ly - y0], sy) {
        for i in pixels([x0, x1], sx) {
            let x = (i as f64 + 0.5) / sx;
            let y = ly - (j as f64 + 0.5) / sy;
            if let Some([z, _]) = solid.chord([x, y, 0.0], [0.0, 0.0, 1.0]) {
                raster.set(i, j, z, || {
                    let lit = dot(solid.normal([x, y, z]), [-0.4, 0.4, -1.0]) / 1.15;
                    let below = (z - packing.filled_um(x, y)[0]).max(0.0) / packing.thickness_um();
                    mix(shade(colour, 0.45 + 0.55 * lit.max(0.0)), BINDER, 0.85 * below)
                });
            }
        }
    }
}

/// Paints the section of a body before all that is deeper than `depth`.
fn paint_cut_solid(packing: &Packing, solid: &Solid, depth: f64, colour: Rgb, raster: &mut Raster) {
    let [lx, ly] = packing.period_um();
    let sx = raster.width as f64 / lx;
    let sz = raster.height as f64 / packing.thickness_um();
    for j in pixels(solid.extent_um(2), sz) {
        // A hair beside the middle, where faces of voxels lie.
        let from = [0.0, (0.5 - 1e-9) * ly, (j as f64 + 0.5) / sz];
        let Some([x0, x1]) = solid.chord(from, [1.0, 0.0, 0.0]) else { continue };
        for i in (x0 * sx - 0.5).ceil() as i64..=(x1 * sx - 0.5).floor() as i64 {
            raster.set(i, j, depth, || colour);
        }
    }
}

/// Those of a body's nine nearest periodic images, itself among them, that reach into the cell.
fn images_of(solid: Solid, period_um: [f64; 2]) -> Vec<Solid> {
    let [x, y, z] = solid.center_um;
    let shifts = (-1..=1).flat_map(|i| (-1..=1).map(move |j| [f64::from(i), f64::from(j)]));
    let moved = shifts.map(|[i, j]| solid.placed([x + i * period_um[0], y + j * period_um[1], z]));
    let reaches = |image: &Solid, axis: usize| {
        let [low, high] = image.extent_um(axis);
        high > 0.0 && low < period_um[axis]
    };
    moved.filter(|image| (0..2).all(|axis| reaches(image, axis))).collect()
}

/// The plane y = Ly/2: pigment, binder and vacuum before the binder; z grows downwards to the exit
/// side.
pub fn cut_picture(packing: &Packing) -> DrawResult<Vec<u8>> {
    let [lx, ly] = packing.period_um();
    let height = packing.thickness_um();
    let wide = 1.6 * WIDE;
    let frame = Frame {
        x: 0.0..lx,
        y: height..0.0,
        y_label: "z, µm",
        caption: format!("Cut at y = {:.3} µm (incident side up, exit side down)", 0.5 * ly),
        size: (wide as u32, (wide * height / lx).clamp(90.0, 1200.0) as u32),
    };
    framed(frame, "cut", |w, h| paint_cut(packing, w, h))
}

fn paint_cut(packing: &Packing, w: usize, h: usize) -> Raster {
    let [lx, ly] = packing.period_um();
    let mut raster = Raster::new(w, h, BACKGROUND);
    let sx = w as f64 / lx;
    let sz = h as f64 / packing.thickness_um();
    for i in 0..w {
        let [from, to] = packing.filled_um((i as f64 + 0.5) / sx, 0.5 * ly);
        for j in 0..h {
            let z = (j as f64 + 0.5) / sz;
            if z > from && z <= to {
                raster.set(i as i64, j as i64, 1.0, || BINDER);
            }
        }
    }
    for (after, (solid, material)) in images(packing).enumerate() {
        paint_cut_solid(packing, &solid, -(after as f64), pigment_colour(material), &mut raster);
    }
    raster
}

/// The number of spheres in words, for grains made of them.
fn made_of(template: &Template) -> String {
    match template.spheres.len() {
        _ if template.form.is_some() => String::new(),
        1 => ", 1 sphere".into(),
        count => format!(", {count} spheres"),
    }
}

/// The cell with its edges, obliquely from the incident side; the face z = 0 is up.
pub fn perspective_picture(packing: &Packing) -> DrawResult<Vec<u8>> {
    let w = 1200u32;
    let h = 760u32;
    drawn((w, h + 40), |area| draw_perspective(area, packing, (w, h)))
}

/// The perspective picture of `size` pixels beneath its caption.
fn draw_perspective(canvas: &Canvas, packing: &Packing, size: (u32, u32)) -> DrawResult {
    let [lx, ly] = packing.period_um();
    let caption =
        format!("One period, {lx:.3} × {ly:.3} × {:.3} µm (x × y × thickness)", packing.thickness_um());
    let raster = paint_perspective(packing, 2 * size.0 as usize, 2 * size.1 as usize).halved();
    write_line(canvas, caption, (20, 12), 20)?;
    place(canvas, &raster, (0, 40), size)
}

/// Writes a line with its upper left `corner`, its letters `height` pixels high.
fn write_line(canvas: &Canvas, line: String, corner: (i32, i32), height: i32) -> DrawResult {
    canvas.draw(&Text::new(line, corner, (FONT, height).into_font())).map_err(failed)
}

/// Puts a picture with its upper left corner at `corner`.
fn place(canvas: &Canvas, raster: &Raster, corner: (i32, i32), size: (u32, u32)) -> DrawResult {
    let bits = BitMapElement::with_owned_buffer(corner, size, raster.rgb());
    bits.map_or(Ok(()), |b| canvas.draw(&b)).map_err(failed)
}

fn paint_perspective(packing: &Packing, w: usize, h: usize) -> Raster {
    let [lx, ly] = packing.period_um();
    let height = packing.thickness_um();
    let camera = camera_of_cell([lx, ly, height], w as f64, h as f64);
    let mut raster = Raster::new(w, h, BACKGROUND);
    for grain in packing.grains() {
        let outermost = &packing.nested(grain)[0];
        for solid in outermost.solids() {
            camera.solid(&mut raster, &solid, height, pigment_colour(outermost.material));
        }
    }
    let corner = |k: usize| corner_of([lx, ly, height], k);
    for k in 0..8usize {
        for bit in [1, 2, 4].into_iter().filter(|bit| k & bit == 0) {
            camera.line(&mut raster, corner(k), corner(k | bit), [70, 70, 70]);
        }
    }
    raster
}

/// Corner `k` of a cell with these sides; heights are above the paper, so that up is up.
fn corner_of([lx, ly, height]: [f64; 3], k: usize) -> [f64; 3] {
    [(k & 1) as f64 * lx, (k >> 1 & 1) as f64 * ly, (k >> 2 & 1) as f64 * height]
}

/// Looks obliquely at a cell, from so far away that all of it is in a picture of `w` by `h` pixels.
fn camera_of_cell([lx, ly, height]: [f64; 3], w: f64, h: f64) -> Camera {
    let size = lx.max(ly).max(height);
    let middle = [0.5 * lx, 0.5 * ly, 0.5 * height];
    let from = |farther: f64| {
        let eye = [
            middle[0] - farther * 0.75 * size,
            middle[1] - farther * 1.6 * size,
            middle[2] + farther * 1.35 * size,
        ];
        Camera::new(eye, middle, [0.0, 0.0, 1.0], 1.02 * w)
    };
    let holds = |camera: &Camera| {
        (0..8)
            .map(|k| camera.project(corner_of([lx, ly, height], k)))
            .all(|(across, down, ahead)| ahead > 0.0 && across.abs() < 0.48 * w && down.abs() < 0.48 * h)
    };
    // a cube fits from 1.3 times as far as a flat layer
    let distances = (0..20).map(|step| 1.0 + 0.05 * f64::from(step));
    distances.map(from).find(holds).unwrap_or_else(|| from(2.0))
}

/// One grain of each pigment side by side, at the same scale, with its name and dimensions.
pub fn shape_sheet(shapes: &[(String, Shape)]) -> DrawResult<Vec<u8>> {
    let n = shapes.len().max(1);
    drawn(((n * TILE) as u32, 400), |area| {
        shapes.iter().enumerate().try_for_each(|(k, shape)| draw_shape(area, k, shape))
    })
}

/// The grain of pigment `k` in its place on the sheet, with its name and figures beneath.
fn draw_shape(canvas: &Canvas, k: usize, (name, shape): &(String, Shape)) -> DrawResult {
    let template = shape.template();
    let left = (k * TILE) as i32;
    place(canvas, &paint_shape(&template, k, 2 * TILE).halved(), (left, 0), (TILE as u32, TILE as u32))?;
    let lines = [
        format!("{name}: {}{}", shape.name(), made_of(&template)),
        format!("length {:.2} R", template.length),
        format!("effective diameter {:.3} R", template.effective_diameter()),
    ];
    let mut lines = lines.into_iter().zip((TILE as i32..).step_by(26));
    lines.try_for_each(|(line, y)| write_line(canvas, line, (left + 12, y), 16))
}

fn paint_shape(template: &Template, colour: usize, side: usize) -> Raster {
    let spheres = &template.spheres;
    let mut raster = Raster::new(side, side, BACKGROUND);
    let reach = spheres.iter().map(|s| norm(s.center_um) + s.radius_um).fold(0.0, f64::max);
    let away = 6.0 * reach;
    let camera = Camera::new([away, 0.35 * away, 0.3 * away], [0.0; 3], [0.0, 0.0, 1.0], 2.6 * side as f64);
    let body = match &template.form {
        Some(form) => vec![Solid::upright(form.clone(), [0.0; 3])],
        None => spheres.iter().map(Sphere::solid).collect(),
    };
    // Spheres are given with z upwards.
    for solid in body {
        let [x, y, z] = solid.center_um;
        camera.solid(&mut raster, &solid.placed([x, y, -z]), 0.0, pigment_colour(colour));
    }
    raster
}
