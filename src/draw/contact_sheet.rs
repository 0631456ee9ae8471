//! Many pictures of inks in rows and columns with captions.

use super::figure::{Anchor, Bitmap, FigureError};
use super::picture::{LABEL_PX, PictureStyle, TITLE_PX};
use crate::appearance::picture::InkPicture;

/// Many pictures in rows and columns with captions.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactSheet {
    /// Title over the sheet.
    pub title: String,
    /// Name of the axis that runs down, and its captions.
    pub row_axis: String,
    /// Labels of the rows, from the top.
    pub rows: Vec<String>,
    /// Name of the axis that runs to the right, and its captions.
    pub column_axis: String,
    /// Labels of the columns, from the left.
    pub columns: Vec<String>,
    /// \[row\]\[column\]
    pub pictures: Vec<Vec<Option<InkPicture>>>,
    /// \[row\]\[column\]: why there is no picture, in a few words.
    pub blanks: Vec<Vec<String>>,
}

/// Sheet layout, pixels: space for captions, and between pictures.
pub(super) const SHEET_LEFT: usize = 150;
pub(super) const SHEET_TOP: usize = 104;
const SHEET_GAP: usize = 22;

impl ContactSheet {
    /// The sheet as a bitmap; labels of the single pictures are left out.
    ///
    /// # Errors
    /// No pictures; captions and pictures that differ in number; a sheet larger than 20 000 pixels.
    pub fn render(&self, style: &PictureStyle) -> Result<Bitmap, FigureError> {
        self.check()?;
        let cell = [style.strip_px + style.gap_px + style.side_px + SHEET_GAP, style.side_px + SHEET_GAP];
        let width = SHEET_LEFT + self.columns.len() * cell[0];
        let mut bitmap = Bitmap::white(width, SHEET_TOP + self.rows.len() * cell[1])?;
        bitmap.text(&self.title, [SHEET_GAP as i32, 26], TITLE_PX + 4, Anchor::Left, false)?;
        self.captions(&mut bitmap, cell)?;
        for (r, row) in self.pictures.iter().enumerate() {
            for (c, picture) in row.iter().enumerate() {
                let at = [SHEET_LEFT + c * cell[0], SHEET_TOP + r * cell[1]];
                match picture {
                    Some(picture) => picture.paint(&mut bitmap, at, style),
                    None => self.blank(&mut bitmap, at, cell, [r, c])?,
                }
            }
        }
        Ok(bitmap)
    }

    fn blank(
        &self,
        bitmap: &mut Bitmap,
        [x, y]: [usize; 2],
        cell: [usize; 2],
        [r, c]: [usize; 2],
    ) -> Result<(), FigureError> {
        let Some(reason) = self.blanks.get(r).and_then(|row| row.get(c)) else { return Ok(()) };
        let middle = [(x + (cell[0] - SHEET_GAP) / 2) as i32, (y + (cell[1] - SHEET_GAP) / 2) as i32];
        bitmap.text(reason, middle, LABEL_PX, Anchor::Centre, false)
    }

    fn check(&self) -> Result<(), FigureError> {
        if self.rows.is_empty() || self.columns.is_empty() {
            return Err(FigureError::Empty { field: "rows or columns" });
        }
        let wrong = |field, count, expected| Err(FigureError::Count { field, count, expected });
        if self.pictures.len() != self.rows.len() {
            return wrong("pictures", self.pictures.len(), self.rows.len());
        }
        if let Some(row) = self.pictures.iter().find(|r| r.len() != self.columns.len()) {
            return wrong("a row of pictures", row.len(), self.columns.len());
        }
        self.pictures.iter().flatten().flatten().try_for_each(InkPicture::check)
    }

    fn captions(&self, bitmap: &mut Bitmap, cell: [usize; 2]) -> Result<(), FigureError> {
        let middle = |k: usize, step: usize, from: usize| (from + k * step + (step - SHEET_GAP) / 2) as i32;
        bitmap.text(&self.column_axis, [SHEET_LEFT as i32, 58], LABEL_PX, Anchor::Left, false)?;
        bitmap.text(&self.row_axis, [SHEET_GAP as i32, 84], LABEL_PX, Anchor::Left, false)?;
        for (c, name) in self.columns.iter().enumerate() {
            bitmap.text(name, [middle(c, cell[0], SHEET_LEFT), 84], LABEL_PX, Anchor::Centre, false)?;
        }
        for (r, name) in self.rows.iter().enumerate() {
            let at = [SHEET_LEFT as i32 - 14, middle(r, cell[1], SHEET_TOP)];
            bitmap.text(name, at, LABEL_PX, Anchor::Right, false)?;
        }
        Ok(())
    }
}
