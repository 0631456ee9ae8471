//! Layout of a plot: narrow enough to be legible on a phone, with the title above the axes and the
//! names of the curves below.

use super::figure::{Area, DrawResult, FONT, failed, register_fonts};
use plotters::prelude::*;

/// Width of all plots, pixels. A page on a phone has 358 of its 390 pixels, where letters of 13
/// pixels have 10.
const WIDTH: u32 = 480;
/// Height of the axes with their labels, pixels.
const AXES: u32 = 320;
/// Type size of labels; the library draws them 1.24 times smaller, in pixels.
pub(super) const WORDS: u32 = 16;
const TITLE: u32 = 18;
const TITLE_STEP: u32 = 24;
const NAME_STEP: u32 = 22;
const MARGIN: u32 = 12;
/// Space for a curve's line and marker before its name.
pub(super) const KEY: i32 = 32;

/// Title and legend of a plot, which determine its size.
pub(super) struct Leaf {
    title: Vec<String>,
    names: usize,
    columns: usize,
}

impl Leaf {
    /// Lays out a title, and names in as many columns as fit.
    pub fn new<'a>(title: &str, names: impl IntoIterator<Item = &'a str>) -> Leaf {
        let widths: Vec<u32> =
            names.into_iter().map(|name| KEY as u32 + MARGIN + width(name, WORDS)).collect();
        let widest = widths.iter().copied().max().unwrap_or(WIDTH);
        let columns = ((WIDTH - MARGIN) / widest.max(1)).max(1) as usize;
        let title = wrapped(title, |line| width(line, TITLE) <= WIDTH - 2 * MARGIN);
        Leaf { title, names: widths.len(), columns }
    }

    fn title_height(&self) -> u32 {
        MARGIN + self.title.len() as u32 * TITLE_STEP
    }

    /// Width and height, pixels.
    pub fn size(&self) -> (u32, u32) {
        let rows = self.names.div_ceil(self.columns) as u32;
        let names = if rows == 0 { 0 } else { rows * NAME_STEP + MARGIN };
        (WIDTH, self.title_height() + AXES + names)
    }

    /// Writes the title; returns the areas of the axes and of the names below.
    pub fn split<B: DrawingBackend>(&self, area: &Area<B>) -> DrawResult<(Area<B>, Area<B>)> {
        let (title, rest) = area.split_vertically(self.title_height());
        for (k, line) in self.title.iter().enumerate() {
            let left = (WIDTH.saturating_sub(width(line, TITLE)) / 2) as i32;
            let corner = (left, (MARGIN + k as u32 * TITLE_STEP) as i32);
            title.draw(&Text::new(line.clone(), corner, (FONT, TITLE).into_font())).map_err(failed)?;
        }
        Ok(rest.split_vertically(AXES))
    }

    /// Position of entry `k` in the area of the names: the left end of its line, and its middle.
    pub fn place(&self, k: usize) -> (i32, i32) {
        let step = (WIDTH - MARGIN) / self.columns as u32;
        let row = (k / self.columns) as u32;
        let column = (k % self.columns) as u32;
        ((MARGIN + column * step) as i32, (NAME_STEP / 2 + row * NAME_STEP) as i32)
    }
}

/// Largest type size at which words fit into `room` pixels, but no smaller than is legible.
pub(super) fn fitting(words: &str, room: u32) -> u32 {
    (11..=WORDS).rev().find(|&px| width(words, px) <= room).unwrap_or(11)
}

/// Width of a text, pixels.
pub(super) fn width(words: &str, px: u32) -> u32 {
    register_fonts(); // a font is looked up when its description is made
    (FONT, px).into_font().box_size(words).map_or(0, |size| size.0)
}

/// Breaks a text into lines that fit; words stay whole.
pub(super) fn wrapped(text: &str, fits: impl Fn(&str) -> bool) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        let longer = lines.last().map(|line| format!("{line} {word}")).filter(|line| fits(line));
        match (lines.last_mut(), longer) {
            (Some(line), Some(longer)) => *line = longer,
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

/// Draws as SVG, without redundant attributes.
pub fn svg_of(size: (u32, u32), paint: impl FnOnce(&Area<SVGBackend>) -> DrawResult) -> DrawResult<String> {
    register_fonts();
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, size).into_drawing_area();
        paint(&area)?;
        area.present().map_err(failed)?;
    }
    Ok(at_night(&text.replace(" opacity=\"1\"", "")))
}

/// Style rules for dark pages, with the colours of the pages' style sheet; print stays white.
const NIGHT: &str = "<style>@media screen and (prefers-color-scheme: dark) { \
    rect[fill=\"#FFFFFF\"] { fill: #211f1c; } text { fill: #e6e2da; } \
    [stroke=\"#000000\"] { stroke: #e6e2da; } polygon[fill=\"#000000\"] { fill: #e6e2da; } \
    [stroke=\"#DEDEDE\"] { stroke: #45413b; } \
    [stroke=\"#0072B2\"] { stroke: #3d9fdc; } polygon[fill=\"#0072B2\"] { fill: #3d9fdc; } }</style>";

/// Adds the rules for dark pages to a drawing.
fn at_night(svg: &str) -> String {
    match svg.find("<svg").and_then(|at| Some(at + svg[at..].find('>')? + 1)) {
        Some(end) => format!("{}\n{NIGHT}{}", &svg[..end], &svg[end..]),
        None => svg.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A page on a phone of 390 pixels has 358 for a plot.
    #[test]
    fn words_are_read_on_a_phone() {
        let shown = f64::from(WORDS) / 1.24 * 358.0 / f64::from(WIDTH);
        assert!(shown >= 9.5, "{shown}");
    }

    #[test]
    fn lines_hold_whole_words() {
        let wrapped = |text, letters| wrapped(text, |line| line.chars().count() <= letters);
        assert_eq!(wrapped("volume fraction 0.5 not reached", 16), ["volume fraction", "0.5 not reached"]);
        assert_eq!(wrapped("unbreakable", 4), ["unbreakable"]);
    }

    /// *Planted*: without the rules a dark page shows a white sheet.
    #[test]
    fn drawings_follow_the_page_at_night() {
        let svg = svg_of((20, 20), |area| area.fill(&WHITE).map_err(failed)).unwrap();
        assert_eq!(svg.matches("prefers-color-scheme: dark").count(), 1, "{svg}");
        assert!(svg.starts_with("<svg ") && svg.contains("fill=\"#FFFFFF\""), "{svg}");
        // The pages' own style has the colours that the rules name.
        let style = crate::page::STYLE;
        assert!(["#211f1c", "#e6e2da", "#45413b"].iter().all(|c| style.contains(c) && NIGHT.contains(c)));
    }

    #[test]
    fn titles_break_and_names_stand_in_columns_beneath() {
        let long =
            "yellow + blue · cylinders of 300 nm, standing · transmittance of the layer over the wavelength";
        let names = ["15 %", "30 %", "50 %", "60 %", "70 %"];
        let leaf = Leaf::new(long, names);
        assert!(leaf.title.len() == 2 && leaf.title.concat().len() + 1 == long.len(), "{:?}", leaf.title);
        assert!((2..=6).contains(&leaf.columns), "{}", leaf.columns);
        assert!(leaf.place(leaf.columns).1 > leaf.place(0).1 && leaf.place(1).0 > leaf.place(0).0);
        let one = Leaf::new("short", [long]);
        assert_eq!((one.columns, one.title.len()), (1, 1));
        assert_eq!(Leaf::new("", []).size(), (WIDTH, MARGIN + AXES));
    }
}
