//! Small pictures of shaded bodies: a depth buffer, one light, flat colours; and a frame with axes
//! around pictures of the layer.

use super::figure::{Bitmap, Canvas, DrawResult, FONT, OutputError};
use crate::ink::Solid;
use crate::numerics::vector::{V3, add, cross, dot, norm, scale, sub, unit};
use plotters::prelude::*;
use std::ops::Range;

pub type Rgb = [u8; 3];

/// Okabe and Ito's colours, distinct for colour-blind readers; pigments take them in turn.
pub const COLOURS: [Rgb; 7] = [
    [230, 159, 0],
    [0, 114, 178],
    [0, 158, 115],
    [204, 121, 167],
    [213, 94, 0],
    [86, 180, 233],
    [240, 228, 66],
];

pub const BACKGROUND: Rgb = [255, 255, 255];
/// The transparent binder.
pub const BINDER: Rgb = [228, 232, 236];

pub fn pigment_colour(pigment: usize) -> Rgb {
    COLOURS[pigment % COLOURS.len()]
}

/// Colour times brightness.
pub fn shade(colour: Rgb, brightness: f64) -> Rgb {
    colour.map(|c| (f64::from(c) * brightness).clamp(0.0, 255.0) as u8)
}

pub fn mix(a: Rgb, b: Rgb, share_of_b: f64) -> Rgb {
    std::array::from_fn(|i| (f64::from(a[i]) * (1.0 - share_of_b) + f64::from(b[i]) * share_of_b) as u8)
}

/// Pixels in rows from the top, with the depth of what each shows.
pub struct Raster {
    pub width: usize,
    pub height: usize,
    pub pixels: Vec<Rgb>,
    depth: Vec<f64>,
}

impl Raster {
    pub fn new(width: usize, height: usize, background: Rgb) -> Self {
        let n = width * height;
        Self { width, height, pixels: vec![background; n], depth: vec![f64::INFINITY; n] }
    }

    /// Paints a pixel if nothing nearer is there; only then is its colour worked out.
    pub fn set(&mut self, x: i64, y: i64, depth: f64, colour: impl FnOnce() -> Rgb) {
        if x < 0 || y < 0 || x >= self.width as i64 || y >= self.height as i64 {
            return;
        }
        let k = y as usize * self.width + x as usize;
        if depth < self.depth[k] {
            self.depth[k] = depth;
            self.pixels[k] = colour();
        }
    }

    pub fn rgb(&self) -> Vec<u8> {
        self.pixels.iter().flatten().copied().collect()
    }

    /// Averages 2 × 2 pixels: smooth edges for pictures drawn at twice the size.
    pub fn halved(&self) -> Self {
        let mut half = Self::new(self.width / 2, self.height / 2, BACKGROUND);
        for y in 0..half.height {
            for x in 0..half.width {
                let pixel = |i: usize, j: usize| self.pixels[(2 * y + j) * self.width + 2 * x + i];
                let four = [pixel(0, 0), pixel(1, 0), pixel(0, 1), pixel(1, 1)];
                let mean = |c: usize| (four.iter().map(|p| u32::from(p[c])).sum::<u32>() / 4) as u8;
                half.pixels[y * half.width + x] = [mean(0), mean(1), mean(2)];
            }
        }
        half
    }
}

/// Pixels of a side that a range about its middle touches.
fn pixels(middle: f64, [low, high]: [f64; 2], side: usize) -> std::ops::Range<i64> {
    ((middle + low).floor() as i64).max(0)..((middle + high).ceil() as i64 + 1).min(side as i64)
}

/// A pinhole camera.
pub struct Camera {
    eye: V3,
    forward: V3,
    right: V3,
    up: V3,
    /// Pixels per unit of tangent.
    focal: f64,
}

impl Camera {
    /// Looks from `eye` at `target`; `up_hint` is drawn upwards.
    pub fn new(eye: V3, target: V3, up_hint: V3, focal: f64) -> Self {
        let forward = unit(sub(target, eye));
        let right = unit(cross(forward, up_hint));
        Self { eye, forward, right, up: cross(right, forward), focal }
    }

    /// Pixel (from the centre, y downwards) and distance along the view.
    pub fn project(&self, p: V3) -> (f64, f64, f64) {
        let d = sub(p, self.eye);
        let ahead = dot(d, self.forward);
        (self.focal * dot(d, self.right) / ahead, -self.focal * dot(d, self.up) / ahead, ahead)
    }

    fn ray(&self, x: f64, y: f64) -> V3 {
        unit(add(self.forward, add(scale(self.right, x / self.focal), scale(self.up, -y / self.focal))))
    }

    /// Draws a convex body given with z downwards from `top`, lit from over the left shoulder.
    pub fn solid(&self, raster: &mut Raster, solid: &Solid, top: f64, colour: Rgb) {
        let flip = |v: V3| [v[0], v[1], -v[2]];
        let [x, y, z] = solid.center_um;
        let radius = solid.form.reach_um();
        let (u, v, ahead) = self.project([x, y, top - z]);
        if ahead <= 2.0 * radius {
            return;
        }
        let cx = 0.5 * raster.width as f64;
        let cy = 0.5 * raster.height as f64;
        let reach = 1.3 * self.focal * radius / (ahead - radius);
        let eye = [self.eye[0], self.eye[1], top - self.eye[2]];
        let light = self.light();
        let [across, down] = self.bounds(solid, top);
        for y in pixels(cy, [down[0].max(v - reach), down[1].min(v + reach)], raster.height) {
            for x in pixels(cx, [across[0].max(u - reach), across[1].min(u + reach)], raster.width) {
                let ray = flip(self.ray(x as f64 + 0.5 - cx, y as f64 + 0.5 - cy));
                if let Some([t, _]) = solid.chord(eye, ray) {
                    raster.set(x, y, t, || {
                        let normal = flip(solid.normal(add(eye, scale(ray, t))));
                        shade(colour, 0.35 + 0.7 * dot(normal, light).max(0.0))
                    });
                }
            }
        }
    }

    /// Ranges of [`Self::project`] that a body's corners span, which hold all of it.
    fn bounds(&self, solid: &Solid, top: f64) -> [[f64; 2]; 2] {
        let x = solid.extent_um(0);
        let y = solid.extent_um(1);
        let z = solid.extent_um(2);
        let mut bounds = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for k in 0..8 {
            let (u, v, _) = self.project([x[k & 1], y[k >> 1 & 1], top - z[k >> 2]]);
            for ([low, high], at) in bounds.iter_mut().zip([u, v]) {
                (*low, *high) = (low.min(at), high.max(at));
            }
        }
        bounds
    }

    /// Direction towards the light, over the left shoulder.
    fn light(&self) -> V3 {
        unit(add(scale(self.forward, -1.0), add(scale(self.up, 0.9), scale(self.right, -0.5))))
    }

    /// Draws a line as a row of points, hidden behind what is nearer.
    pub fn line(&self, raster: &mut Raster, a: V3, b: V3, colour: Rgb) {
        let cx = 0.5 * raster.width as f64;
        let cy = 0.5 * raster.height as f64;
        let steps = 4 * raster.width.max(raster.height);
        for k in 0..=steps {
            let p = add(a, scale(sub(b, a), k as f64 / steps as f64));
            let (u, v, _) = self.project(p);
            let far = norm(sub(p, self.eye));
            for (dx, dy) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)] {
                raster.set((cx + u + dx).floor() as i64, (cy + v + dy).floor() as i64, far, || colour);
            }
        }
    }
}

const LABEL: u32 = 17;
const CAPTION: u32 = 20;

/// Draws a picture of some width and height, pixels, as PNG.
pub fn drawn(size: (u32, u32), paint: impl FnOnce(&Canvas) -> DrawResult) -> DrawResult<Vec<u8>> {
    let mut bitmap = Bitmap::white(size.0 as usize, size.1 as usize)?;
    bitmap.draw(paint)?;
    bitmap.png(&[])
}

/// Sides of the picture inside its frame, axes and a caption.
pub(super) struct Frame {
    pub x: Range<f64>,
    pub y: Range<f64>,
    /// Along x it is always "x, µm".
    pub y_label: &'static str,
    pub caption: String,
    /// Pixels of the picture itself.
    pub size: (u32, u32),
}

const LEFT: u32 = 78;
const BELOW: u32 = 56;
const MARGIN: u32 = 18;
const ABOVE: u32 = 34;

/// Draws a raster with axes around it, as PNG.
pub fn framed(frame: Frame, what: &str, paint: impl FnOnce(usize, usize) -> Raster) -> DrawResult<Vec<u8>> {
    let size = (frame.size.0 + LEFT + 2 * MARGIN, frame.size.1 + BELOW + ABOVE + 2 * MARGIN);
    drawn(size, |area| draw_framed(area, frame, paint).map_err(OutputError::making(what)))
}

fn draw_framed(
    area: &Canvas,
    frame: Frame,
    paint: impl FnOnce(usize, usize) -> Raster,
) -> Result<(), Box<dyn std::error::Error>> {
    area.fill(&WHITE)?;
    let corner = (frame.x.start, frame.y.end);
    let rows = if frame.size.1 < 200 { 3 } else { 8 };
    let mut chart = ChartBuilder::on(area)
        .margin(MARGIN)
        .caption(&frame.caption, (FONT, CAPTION))
        .x_label_area_size(BELOW)
        .y_label_area_size(LEFT)
        .build_cartesian_2d(frame.x, frame.y)?;
    let (w, h) = chart.plotting_area().dim_in_pixel();
    let picture = paint(2 * w as usize, 2 * h as usize).halved();
    let size = (picture.width as u32, picture.height as u32);
    if let Some(element) = BitMapElement::with_owned_buffer(corner, size, picture.rgb()) {
        chart.plotting_area().draw(&element)?;
    }
    chart
        .configure_mesh()
        .disable_mesh()
        .x_desc("x, µm")
        .y_desc(frame.y_label)
        .y_labels(rows)
        .axis_desc_style((FONT, LABEL))
        .label_style((FONT, LABEL))
        .draw()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_nearer_hides_what_is_drawn_later() {
        let mut raster = Raster::new(1, 1, BACKGROUND);
        for (depth, colour) in [(2.0, COLOURS[0]), (1.0, COLOURS[1]), (3.0, COLOURS[2])] {
            raster.set(0, 0, depth, || colour);
        }
        assert_eq!(raster.pixels, [COLOURS[1]]);
    }
}
