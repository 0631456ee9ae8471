//! Canvas of pictures and plots: an RGB bitmap with a built-in font, written as PNG; and the errors
//! of making and writing outputs.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::register_font;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::path::PathBuf;
use std::sync::Once;

/// The font of all figures.
pub const FONT: &str = "sans-serif";

/// Registers DejaVu Sans for plotters, once per process: no system font is needed.
pub fn register_fonts() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        // the embedded font is valid; if plotters refused it, drawing would report the missing font
        let _ = register_font(FONT, FontStyle::Normal, dejavu::sans::regular());
        let _ = register_font(FONT, FontStyle::Bold, dejavu::sans::bold());
    });
}

/// Okabe–Ito colours, distinguishable with every common form of colour blindness; black first.
pub const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 0, 0),
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
];

/// What is drawn on.
pub(super) type Area<B> = DrawingArea<B, Shift>;
/// Drawing area of a bitmap.
pub(super) type Canvas<'a> = Area<BitMapBackend<'a>>;

/// An RGB bitmap, 8 bits, sRGB.
#[derive(Clone, Debug, PartialEq)]
pub struct Bitmap {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) rgb: Vec<u8>,
}

/// Where a text stands relative to its point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// Text begins at the anchor.
    Left,
    /// Text is centred on the anchor.
    Centre,
    /// Text ends at the anchor.
    Right,
    /// Text is centred on the anchor and reads upwards.
    Upwards,
}

/// Largest side of a bitmap, pixels.
const LARGEST_SIDE: usize = 20_000;

impl Bitmap {
    /// A white bitmap.
    ///
    /// # Errors
    /// A side of 0 or more than 20 000 pixels.
    pub fn white(width: usize, height: usize) -> DrawResult<Self> {
        for (field, value) in [("width", width), ("height", height)] {
            if !(1..=LARGEST_SIDE).contains(&value) {
                return Err(failed(format!("{field} = {value}: allowed 1 to {LARGEST_SIDE}")));
            }
        }
        Ok(Self { width, height, rgb: vec![255; 3 * width * height] })
    }

    /// Fills a rectangle; what lies outside is cut off.
    pub fn fill(&mut self, [x, y]: [usize; 2], [width, height]: [usize; 2], colour: [u8; 3]) {
        for row in y..(y + height).min(self.height) {
            for column in x..(x + width).min(self.width) {
                let first = 3 * (row * self.width + column);
                self.rgb[first..first + 3].copy_from_slice(&colour);
            }
        }
    }

    /// Writes a line of text, vertically centred on `y`.
    ///
    /// # Errors
    /// The font fails, which it cannot as it is embedded.
    pub fn text(&mut self, text: &str, [x, y]: [i32; 2], px: u32, anchor: Anchor) -> DrawResult {
        let horizontal = match anchor {
            Anchor::Left => HPos::Left,
            Anchor::Centre | Anchor::Upwards => HPos::Center,
            Anchor::Right => HPos::Right,
        };
        register_fonts(); // a font is looked up when its description is made
        let mut font = (FONT, px).into_font();
        if anchor == Anchor::Upwards {
            font = font.transform(FontTransform::Rotate270);
        }
        let style = TextStyle::from(font).color(&BLACK).pos(Pos::new(horizontal, VPos::Center));
        self.draw(|area| area.draw(&Text::new(text.to_string(), (x, y), style)).map_err(failed))
    }

    /// Draws with plotters.
    ///
    /// # Errors
    /// Whatever the drawing reports.
    pub(super) fn draw(&mut self, paint: impl FnOnce(&Canvas) -> DrawResult) -> DrawResult {
        register_fonts();
        let size = (self.width as u32, self.height as u32);
        let area = BitMapBackend::with_buffer(&mut self.rgb, size).into_drawing_area();
        paint(&area)?;
        area.present().map_err(failed)
    }

    /// Encodes the bitmap as PNG with the sRGB chunk and text chunks (keyword, text), e.g.
    /// provenance.
    ///
    /// # Errors
    /// A keyword is not 1–79 Latin-1 characters.
    pub fn png(&self, text: &[(&str, &str)]) -> DrawResult<Vec<u8>> {
        self.encode(text).map_err(failed)
    }

    fn encode(&self, text: &[(&str, &str)]) -> Result<Vec<u8>, png::EncodingError> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
        for (keyword, value) in text {
            encoder.add_itxt_chunk(keyword.to_string(), value.to_string())?;
        }
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.rgb)?;
        writer.finish()?;
        Ok(bytes)
    }
}

/// Why a results file, or a picture in one, was not made.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The file cannot be written.
    #[error("cannot write {}: {source}; check the folder and its permissions", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// The message of the system.
        source: std::io::Error,
    },
    /// The content cannot be made.
    #[error("cannot make {0}")]
    Make(String),
}

/// What drawing gives.
pub type DrawResult<T = ()> = Result<T, OutputError>;

impl OutputError {
    /// Maps any failure while `what` is made.
    pub fn making<E: std::fmt::Display>(what: &str) -> impl Fn(E) -> Self + '_ {
        move |reason| Self::Make(format!("{what}: {reason}"))
    }
}

/// A failure of the drawing library.
pub(super) fn failed(reason: impl std::fmt::Display) -> OutputError {
    OutputError::making("a drawing")(reason)
}
