//! Line charts for the report, as SVG.

use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::register_font;
use std::fmt::Display;
use std::ops::Range;
use std::sync::Once;

/// One curve with its standard errors.
#[derive(Clone, Debug)]
pub struct Series {
    pub label: String,
    pub colour: [u8; 3],
    /// x, y and the standard error of y where it is known.
    pub points: Vec<(f64, f64, Option<f64>)>,
}

/// A chart of curves; a curve's standard errors are drawn as a pale band of ± 1.
#[derive(Clone, Debug)]
pub struct Chart {
    pub x_label: String,
    pub y_label: String,
    pub x: Range<f64>,
    pub y: Range<f64>,
    pub series: Vec<Series>,
}

/// The plotting library refused to draw.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("cannot draw a figure: {0}")]
pub struct FigureError(String);

impl FigureError {
    fn because(reason: impl Display) -> Self {
        Self(reason.to_string())
    }
}

const SIZE: (u32, u32) = (760, 400);
const INK: RGBColor = RGBColor(51, 51, 51);
const GRID: RGBColor = RGBColor(228, 228, 224);

impl Chart {
    /// The smallest range from zero that holds all values and errors, with some room above.
    pub fn range_from_zero(series: &[Series]) -> Range<f64> {
        let tops = series.iter().flat_map(|s| s.points.iter().map(|p| p.1 + p.2.unwrap_or(0.0)));
        let top = tops.fold(0.0_f64, f64::max);
        0.0..if top > 0.0 { 1.08 * top } else { 1.0 }
    }

    /// The chart as an SVG document.
    pub fn svg(&self) -> Result<String, FigureError> {
        register_fonts();
        let mut svg = String::new();
        {
            let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
            self.draw(&area).map_err(FigureError::because)?;
            area.present().map_err(FigureError::because)?;
        }
        Ok(svg)
    }

    fn draw<'a>(&self, area: &DrawingArea<SVGBackend<'a>, Shift>) -> Result<(), DrawingError<'a>> {
        let mut chart = ChartBuilder::on(area)
            .margin(12)
            .x_label_area_size(46)
            .y_label_area_size(64)
            .build_cartesian_2d(self.x.clone(), self.y.clone())?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(GRID)
            .axis_style(INK)
            .label_style(("sans-serif", 14).into_font().color(&INK))
            .axis_desc_style(("sans-serif", 15).into_font().color(&INK))
            .x_labels(8)
            .y_labels(6)
            .x_desc(&self.x_label)
            .y_desc(&self.y_label)
            .draw()?;
        for series in &self.series {
            draw_series(&mut chart, series)?;
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .label_font(("sans-serif", 14).into_font().color(&INK))
            .background_style(WHITE.mix(0.85))
            .border_style(TRANSPARENT)
            .draw()
    }
}

type DrawingError<'a> = DrawingAreaErrorKind<<SVGBackend<'a> as DrawingBackend>::ErrorType>;
type Plane<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

fn draw_series<'b>(chart: &mut Plane<'_, 'b>, series: &Series) -> Result<(), DrawingError<'b>> {
    let [r, g, b] = series.colour;
    let colour = RGBColor(r, g, b);
    let known = series.points.iter().filter_map(|&(x, y, error)| Some((x, y, error?)));
    let upper: Vec<_> = known.clone().map(|(x, y, error)| (x, y + error)).collect();
    let lower: Vec<_> = known.map(|(x, y, error)| (x, y - error)).collect();
    let band: Vec<_> = upper.into_iter().chain(lower.into_iter().rev()).collect();
    chart.draw_series(std::iter::once(Polygon::new(band, colour.mix(0.18))))?;
    let line = series.points.iter().map(|&(x, y, _)| (x, y));
    chart
        .draw_series(LineSeries::new(line.clone(), colour.stroke_width(2)))?
        .label(&series.label)
        .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(2)));
    chart.draw_series(line.map(|point| Circle::new(point, 3, colour.filled())))?;
    Ok(())
}

/// Metrics of the labels come from DejaVu Sans; a viewer may show another sans-serif face.
fn register_fonts() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let _ = register_font("sans-serif", FontStyle::Normal, dejavu::sans::regular());
        let _ = register_font("sans-serif", FontStyle::Bold, dejavu::sans::bold());
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chart_shows_its_labels_and_curves() {
        let points = vec![(400.0, 0.1, Some(0.01)), (550.0, 0.5, Some(0.02)), (700.0, 0.9, None)];
        let series = vec![Series { label: "reflected".into(), colour: [200, 30, 30], points }];
        let y = Chart::range_from_zero(&series);
        let (x_label, y_label) = ("wavelength, nm".into(), "share".into());
        let svg = Chart { x_label, y_label, x: 400.0..700.0, y, series }.svg().unwrap();
        assert!(svg.starts_with("<svg") && svg.contains("wavelength, nm") && svg.contains("reflected"));
    }
}
