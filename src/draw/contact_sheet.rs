//! Many pictures of inks in rows and columns with captions.

use super::figure::{Anchor, Bitmap, DrawResult, failed};
use super::leaf::wrapped;
use super::picture::{LABEL_PX, PictureStyle, TITLE_PX, check, paint};
use crate::appearance::picture::ScreenPicture;

/// Many pictures in rows and columns with captions.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactSheet<T = Result<ScreenPicture, String>> {
    /// Title over the sheet.
    pub title: String,
    /// Name of the axis that runs down the sheet.
    pub row_axis: String,
    /// Labels of the rows, from the top.
    pub rows: Vec<String>,
    /// Name of the axis that runs to the right.
    pub column_axis: String,
    /// Labels of the columns, from the left.
    pub columns: Vec<String>,
    /// \[row\]\[column\]: the picture, or why there is none, in a few words.
    pub cells: Vec<Vec<T>>,
}

/// Sheet layout, pixels: least space for captions, and between pictures.
pub(super) const SHEET_LEFT: usize = 150;
pub(super) const SHEET_TOP: usize = 104;
const SHEET_GAP: usize = 22;
/// Upper limit on the mean width of a letter, over the type size.
const LETTER: f64 = 0.6;

impl<T> ContactSheet<T> {
    /// A sheet along these axes, with another title and other cells.
    pub fn map<U>(&self, title: String, cell: impl Fn(&T) -> U) -> ContactSheet<U> {
        let cells = self.cells.iter().map(|row| row.iter().map(&cell).collect()).collect();
        let row_axis = self.row_axis.clone();
        let column_axis = self.column_axis.clone();
        let rows = self.rows.clone();
        let columns = self.columns.clone();
        ContactSheet { title, row_axis, rows, column_axis, columns, cells }
    }
}

impl ContactSheet {
    /// The sheet as a bitmap; labels of the single pictures are left out.
    ///
    /// # Errors
    /// No pictures; captions and pictures that differ in number; a sheet larger than 20 000 pixels.
    pub fn render(&self, style: &PictureStyle) -> DrawResult<Bitmap> {
        self.check()?;
        let cell = [style.strip_px + style.gap_px + style.side_px + SHEET_GAP, style.side_px + SHEET_GAP];
        let left = self.left();
        let width = left + self.columns.len() * cell[0];
        let mut bitmap = Bitmap::white(width, SHEET_TOP + self.rows.len() * cell[1])?;
        bitmap.text(&self.title, [SHEET_GAP as i32, 26], TITLE_PX + 4, Anchor::Left)?;
        self.captions(&mut bitmap, cell)?;
        for (r, row) in self.cells.iter().enumerate() {
            for (c, picture) in row.iter().enumerate() {
                let corner = [left + c * cell[0], SHEET_TOP + r * cell[1]];
                match picture {
                    Ok(picture) => paint(picture, &mut bitmap, corner, style),
                    Err(reason) => blank(&mut bitmap, corner, cell, reason)?,
                }
            }
        }
        Ok(bitmap)
    }

    /// Space for the longest caption of a row.
    fn left(&self) -> usize {
        let longest = self.rows.iter().map(|name| name.chars().count()).max().unwrap_or(0);
        SHEET_LEFT.max(SHEET_GAP + (longest as f64 * LETTER * LABEL_PX as f64) as usize + 14)
    }

    fn check(&self) -> DrawResult {
        let rows = self.rows.len();
        let columns = self.columns.len();
        let whole = self.cells.len() == rows && self.cells.iter().all(|row| row.len() == columns);
        if rows * columns == 0 || !whole {
            return Err(failed(format!(
                "a contact sheet without a picture in each of {rows} × {columns} places"
            )));
        }
        self.cells.iter().flatten().flatten().try_for_each(check)
    }

    fn captions(&self, bitmap: &mut Bitmap, cell: [usize; 2]) -> DrawResult {
        let middle = |k: usize, step: usize, from: usize| (from + k * step + (step - SHEET_GAP) / 2) as i32;
        let left = self.left();
        bitmap.text(&self.column_axis, [left as i32, 58], LABEL_PX, Anchor::Left)?;
        bitmap.text(&self.row_axis, [SHEET_GAP as i32, 84], LABEL_PX, Anchor::Left)?;
        for (c, name) in self.columns.iter().enumerate() {
            bitmap.text(name, [middle(c, cell[0], left), 84], LABEL_PX, Anchor::Centre)?;
        }
        for (r, name) in self.rows.iter().enumerate() {
            bitmap.text(name, [left as i32 - 14, middle(r, cell[1], SHEET_TOP)], LABEL_PX, Anchor::Right)?;
        }
        Ok(())
    }
}

/// Writes why there is no picture, in lines that fit into the cell.
fn blank(bitmap: &mut Bitmap, [x, y]: [usize; 2], cell: [usize; 2], reason: &str) -> DrawResult {
    let size = LABEL_PX - 2;
    let letters = ((cell[0] - SHEET_GAP) as f64 / (LETTER * size as f64)) as usize;
    let lines = wrapped(reason, |line| line.chars().count() <= letters);
    let middle_x = (x + (cell[0] - SHEET_GAP) / 2) as i32;
    let middle_y = (y + (cell[1] - SHEET_GAP) / 2) as i32;
    for (k, line) in lines.iter().enumerate() {
        let down = (2 * k as i32 - lines.len() as i32 + 1) * (size as i32 + 5) / 2;
        bitmap.text(line, [middle_x, middle_y + down], size, Anchor::Centre)?;
    }
    Ok(())
}
