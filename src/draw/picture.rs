//! Paints the picture of P1 Fig. 6: strip and square, with or without axes.

use super::figure::{Anchor, Bitmap, DrawResult, failed};
use crate::appearance::picture::{InkPicture, ScreenPicture};

/// Sizes in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PictureStyle {
    /// Side of the square; each angle gets an equal share of it.
    pub side_px: usize,
    /// Width of the strip, pixels.
    pub strip_px: usize,
    /// Width of the gap between strip and square, pixels.
    pub gap_px: usize,
    /// Axes and captions around the picture.
    pub labels: bool,
}

impl Default for PictureStyle {
    fn default() -> Self {
        Self { side_px: 366, strip_px: 90, gap_px: 12, labels: false }
    }
}

/// Margins of the labelled picture: left, top, right, bottom.
const MARGINS: [usize; 4] = [74, 64, 20, 62];
pub(super) const LABEL_PX: u32 = 15;
pub(super) const TITLE_PX: u32 = 18;
const TICKS_DEG: f64 = 20.0;

/// Renders the picture as a bitmap.
///
/// # Errors
/// No angles, a strip or square that does not have their number, sides of 0 or more than 20 000
/// pixels.
pub fn render(picture: &InkPicture, style: &PictureStyle) -> DrawResult<Bitmap> {
    let picture = &picture.on_screen();
    check(picture)?;
    let [left, top, right, bottom] = if style.labels { MARGINS } else { [0; 4] };
    let width = left + style.strip_px + style.gap_px + style.side_px + right;
    let mut bitmap = Bitmap::white(width, top + style.side_px + bottom)?;
    paint(picture, &mut bitmap, [left, top], style);
    if style.labels {
        label(picture, &mut bitmap, [left, top], style)?;
    }
    Ok(bitmap)
}

pub(super) fn check(picture: &ScreenPicture) -> DrawResult {
    let count = picture.angles_deg.len();
    let columns = picture.square.iter().map(Vec::len);
    let sides = Vec::from_iter([picture.strip.len(), picture.square.len()].into_iter().chain(columns));
    match sides.iter().find(|&&side| side != count) {
        _ if count == 0 => Err(failed("a picture without angles")),
        None => Ok(()),
        Some(side) => Err(failed(format!("{side} colours along a side of a picture of {count} angles"))),
    }
}

pub(super) fn paint(picture: &ScreenPicture, bitmap: &mut Bitmap, [x, y]: [usize; 2], style: &PictureStyle) {
    let edge = |k: usize| k * style.side_px / picture.angles_deg.len();
    let extent = |k: usize| edge(k + 1) - edge(k);
    for (row, &colour) in picture.strip.iter().enumerate() {
        bitmap.fill([x, y + edge(row)], [style.strip_px, extent(row)], colour);
    }
    let x = x + style.strip_px + style.gap_px;
    for (row, colours) in picture.square.iter().enumerate() {
        for (column, &colour) in colours.iter().enumerate() {
            bitmap.fill([x + edge(column), y + edge(row)], [extent(column), extent(row)], colour);
        }
    }
}

fn label(
    picture: &ScreenPicture,
    bitmap: &mut Bitmap,
    [x, y]: [usize; 2],
    style: &PictureStyle,
) -> DrawResult {
    let square = x + style.strip_px + style.gap_px;
    let bottom = (y + style.side_px) as i32;
    let side = style.side_px as i32;
    let above = y as i32 - 14;
    let across = square as i32 + side / 2;
    bitmap.text("natural light", [(x + style.strip_px / 2) as i32, above], LABEL_PX, Anchor::Centre)?;
    bitmap.text("π × diffuse BRDF", [across, above], LABEL_PX, Anchor::Centre)?;
    bitmap.text("illumination angle, °", [across, bottom + 44], LABEL_PX, Anchor::Centre)?;
    bitmap.text("viewing angle, °", [16, y as i32 + side / 2], LABEL_PX, Anchor::Upwards)?;
    for (name, at) in ticks(picture, style.side_px) {
        bitmap.fill([x - 6, y + at], [5, 1], [0; 3]);
        bitmap.text(&name, [x as i32 - 10, (y + at) as i32], LABEL_PX, Anchor::Right)?;
        bitmap.fill([square + at, y + style.side_px + 1], [1, 5], [0; 3]);
        bitmap.text(&name, [(square + at) as i32, bottom + 18], LABEL_PX, Anchor::Centre)?;
    }
    Ok(())
}

/// Every 20° inside the range of angles: label and offset of the cell's centre.
fn ticks(picture: &ScreenPicture, side_px: usize) -> Vec<(String, usize)> {
    let first = picture.angles_deg[0];
    let last = picture.angles_deg[picture.angles_deg.len() - 1];
    let cell = side_px as f64 / picture.angles_deg.len() as f64;
    let reach = (picture.angles_deg.len() - 1) as f64 * cell;
    let offset = |deg: f64| {
        let share = if last > first { (deg - first) / (last - first) } else { 0.0 };
        (cell / 2.0 + share * reach) as usize
    };
    let inside = (0..=4).map(|k| TICKS_DEG * f64::from(k)).filter(|deg| (first..=last).contains(deg));
    inside.map(|deg| (format!("{deg:.0}"), offset(deg))).collect()
}

#[cfg(test)]
#[path = "picture_tests.rs"]
mod tests;
