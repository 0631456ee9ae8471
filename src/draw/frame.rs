//! A frame with axes around pictures of the layer.

use super::error::OutputError;
use super::figure::{Bitmap, FONT};
use super::raster::Raster;
use plotters::coord::Shift;
use plotters::prelude::*;
use std::ops::Range;

const LABEL: u32 = 17;
const CAPTION: u32 = 20;

/// Drawing area of a bitmap.
pub(super) type Canvas<'a> = DrawingArea<BitMapBackend<'a>, Shift>;

/// Draws a picture of some width and height, pixels, as PNG.
pub(super) fn drawn(
    (width, height): (u32, u32),
    paint: impl FnOnce(&Canvas) -> Result<(), OutputError>,
) -> Result<Vec<u8>, OutputError> {
    let mut bitmap = Bitmap::white(width as usize, height as usize)?;
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
pub(super) fn framed(
    frame: Frame,
    what: &str,
    paint: impl FnOnce(usize, usize) -> Raster,
) -> Result<Vec<u8>, OutputError> {
    let (width, height) = (frame.size.0 + LEFT + 2 * MARGIN, frame.size.1 + BELOW + ABOVE + 2 * MARGIN);
    drawn((width, height), |area| draw_framed(area, frame, paint).map_err(OutputError::making(what)))
}

fn draw_framed(
    area: &DrawingArea<BitMapBackend, Shift>,
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
    let bits = BitMapElement::with_owned_buffer(
        corner,
        (picture.width as u32, picture.height as u32),
        picture.rgb(),
    );
    if let Some(element) = bits {
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
