//! Curves with error bars, and the frame in which pictures of the layer are set.

use super::OutputError;
use super::raster::Raster;
use super::ticks;
use crate::ink::statistics::Curve;
use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};
use std::ops::Range;
use std::sync::Once;

const LABEL: u32 = 17;
const CAPTION: u32 = 20;
/// Blue of Okabe and Ito: distinct from the grey band for every reader.
const LINE: RGBColor = RGBColor(0, 114, 178);

/// The font is part of the program, so that pictures do not depend on the machine.
pub(crate) fn font() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        // Fails only if the embedded file were damaged; plots then say that the font is missing.
        let _ = register_font("sans-serif", FontStyle::Normal, dejavu::sans::regular());
    });
}

/// An SVG of a curve; the bars are one standard error.
pub fn curve_plot(curve: &Curve) -> Result<String, OutputError> {
    font();
    let mut text = String::new();
    let area = SVGBackend::with_string(&mut text, (super::leaf::WIDTH, 340)).into_drawing_area();
    draw_curve(&area, curve).map_err(|e| OutputError::making(&curve.name)(e.to_string()))?;
    drop(area);
    Ok(super::leaf::at_night(&text.replace(" opacity=\"1\"", "")))
}

type DrawFault<DB> = DrawingAreaErrorKind<<DB as DrawingBackend>::ErrorType>;

fn draw_curve<DB: DrawingBackend>(area: &DrawingArea<DB, Shift>, curve: &Curve) -> Result<(), DrawFault<DB>> {
    area.fill(&WHITE)?;
    let bar = |i: usize| curve.y[i].standard_error.unwrap_or(0.0);
    let shown: Vec<usize> = (0..curve.x.len()).filter(|i| curve.y[*i].value.is_finite()).collect();
    let x = span(shown.iter().map(|i| curve.x[*i]), 0.0);
    let y = span(
        shown.iter().flat_map(|i| [curve.y[*i].value - bar(*i), curve.y[*i].value + bar(*i)]).chain([0.0]),
        0.05,
    );
    let spans = [&x, &y].map(|range| range.end - range.start);
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .margin_right(20)
        .x_label_area_size(50)
        .y_label_area_size(68)
        .build_cartesian_2d(x, y)?;
    axes(&mut chart, curve, spans)?;
    for part in shown.chunk_by(|i, j| i + 1 == *j) {
        let means = part.iter().map(|i| (curve.x[*i], curve.y[*i].value));
        chart.draw_series(LineSeries::new(means, LINE.stroke_width(2)))?;
    }
    let bars = shown.iter().filter(|i| bar(**i) > 0.0).map(|i| {
        let (x, m, e) = (curve.x[*i], curve.y[*i].value, bar(*i));
        ErrorBar::new_vertical(x, m - e, m, m + e, LINE.filled(), 5)
    });
    chart.draw_series(bars)?;
    area.present()
}

fn span(values: impl Iterator<Item = f64>, margin: f64) -> Range<f64> {
    let (low, high) = values.fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
    if high <= low {
        return if low < f64::MAX { low - 0.5..low + 0.5 } else { 0.0..1.0 };
    }
    let extra = margin * (high - low);
    (if low == 0.0 { low } else { low - extra })..high + extra
}

type CurveChart<'a, DB> = ChartContext<'a, DB, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

fn axes<DB: DrawingBackend>(
    chart: &mut CurveChart<DB>,
    curve: &Curve,
    spans: [f64; 2],
) -> Result<(), DrawFault<DB>> {
    chart
        .configure_mesh()
        .x_desc(&curve.x_label)
        .y_desc(&curve.y_label)
        .x_label_formatter(&|v| ticks::label(*v, false, spans[0]))
        .y_label_formatter(&|v| ticks::label(*v, false, spans[1]))
        .x_labels(7)
        .y_labels(8)
        .axis_desc_style(("sans-serif", LABEL))
        .label_style(("sans-serif", LABEL))
        .max_light_lines(0)
        .bold_line_style(RGBColor(222, 222, 222))
        .draw()
}

/// Draws on a bitmap and encodes it as PNG.
pub(crate) fn bitmap(
    width: u32,
    height: u32,
    what: &str,
    draw: impl FnOnce(DrawingArea<BitMapBackend, Shift>) -> Result<(), String>,
) -> Result<Vec<u8>, OutputError> {
    font();
    let mut pixels = vec![255u8; 3 * width as usize * height as usize];
    let area = BitMapBackend::with_buffer(&mut pixels, (width, height)).into_drawing_area();
    draw(area).map_err(OutputError::making(what))?;
    png_bytes(width, height, &pixels).map_err(|e| OutputError::making(what)(e.to_string()))
}

fn png_bytes(width: u32, height: u32, pixels: &[u8]) -> Result<Vec<u8>, png::EncodingError> {
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.write_header()?.write_image_data(pixels)?;
    Ok(out)
}

/// Sides of the picture inside its frame, axes and a caption.
pub(crate) struct Frame {
    pub x: Range<f64>,
    pub y: Range<f64>,
    pub x_label: String,
    pub y_label: String,
    pub caption: String,
    /// Pixels of the picture itself.
    pub size: (u32, u32),
}

const LEFT: u32 = 78;
const BELOW: u32 = 56;
const MARGIN: u32 = 18;
const ABOVE: u32 = 34;

/// A raster with axes around it, as PNG.
pub(crate) fn framed(
    frame: Frame,
    what: &str,
    paint: impl FnOnce(usize, usize) -> Raster,
) -> Result<Vec<u8>, OutputError> {
    let (width, height) = (frame.size.0 + LEFT + 2 * MARGIN, frame.size.1 + BELOW + ABOVE + 2 * MARGIN);
    bitmap(width, height, what, |area| draw_framed(&area, frame, paint).map_err(|e| e.to_string()))
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
        .caption(&frame.caption, ("sans-serif", CAPTION))
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
        .x_desc(frame.x_label)
        .y_desc(frame.y_label)
        .y_labels(rows)
        .axis_desc_style(("sans-serif", LABEL))
        .label_style(("sans-serif", LABEL))
        .draw()?;
    area.present()?;
    Ok(())
}
