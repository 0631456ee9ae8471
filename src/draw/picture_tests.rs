use super::*;
use crate::appearance::paper::{Coupling, MirroredSky};
use crate::appearance::tristimulus::Colorimeter;
use crate::contact_sheet::{ContactSheet, SHEET_LEFT, SHEET_TOP};
use inkwave_validation::fixtures::molecular_ink;
use ndarray::Array2;
use std::path::PathBuf;

fn angles(count: usize) -> Vec<f64> {
    (0..count).map(|i| 60.0 * i as f64 / (count - 1) as f64).collect()
}

/// Pictures to look at are kept when INKWAVE_PICTURES names a folder.
fn keep(bitmap: &Bitmap, name: &str) {
    if let Some(folder) = std::env::var_os("INKWAVE_PICTURES") {
        let png = bitmap.png(&[("Source", "test")]).unwrap();
        std::fs::write(PathBuf::from(folder).join(name), png).unwrap();
    }
}

/// Colour of a pixel, from the upper left corner.
fn pixel(bitmap: &Bitmap, x: usize, y: usize) -> [u8; 3] {
    assert!(x < bitmap.width);
    std::array::from_fn(|c| bitmap.rgb[3 * (y * bitmap.width + x) + c])
}

fn uniform(value: f64) -> InkPicture {
    let colour = Colorimeter::new(&[440.0, 550.0, 640.0]).unwrap().colour(&[value; 3]).unwrap();
    InkPicture { angles_deg: angles(4), strip: vec![colour; 4], square: Array2::from_elem((4, 4), colour) }
}

#[test]
fn a_white_lambertian_is_255_everywhere() {
    let bitmap = render(&uniform(1.0), &PictureStyle::default()).unwrap();
    assert!(bitmap.rgb.len() == 3 * bitmap.width * bitmap.height && bitmap.rgb.iter().all(|&c| c == 255));
}

#[test]
fn strip_and_square_are_where_figure_6_has_them() {
    let ink = molecular_ink("yellow", 0.3, Coupling::Gap);
    let picture = ink.picture(&angles(61), MirroredSky::Included).unwrap();
    let style = PictureStyle::default();
    let bitmap = render(&picture, &style).unwrap();
    assert_eq!((bitmap.width, bitmap.height), (90 + 12 + 366, 366));
    assert_eq!(pixel(&bitmap, 0, 0), picture.strip[0].srgb8);
    assert_eq!(pixel(&bitmap, 89, 365), picture.strip[60].srgb8);
    assert_eq!(pixel(&bitmap, 96, 100), [255; 3]);
    assert_eq!(pixel(&bitmap, 102, 365), picture.square[[60, 0]].srgb8);
    assert_eq!(pixel(&bitmap, 467, 0), picture.square[[0, 60]].srgb8);
    let [r, g, b] = picture.square[[0, 0]].srgb8;
    assert!(r > 180 && g > 160 && b < 130, "yellow: {r} {g} {b}");
    keep(&bitmap, "yellow.png");
    keep(&render(&picture, &PictureStyle { labels: true, ..style }).unwrap(), "yellow-labelled.png");
}

#[test]
fn a_written_png_has_its_colours_srgb_chunk_and_provenance() {
    let file = tempfile::NamedTempFile::new().unwrap();
    let bitmap = render(&uniform(0.5), &PictureStyle::default()).unwrap();
    std::fs::write(file.path(), bitmap.png(&[("Study", "λ, µm")]).unwrap()).unwrap();
    let mut reader = png::Decoder::new(std::io::BufReader::new(file.reopen().unwrap())).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    assert_eq!(pixels[..3], uniform(0.5).strip[0].srgb8);
    assert!(reader.info().srgb.is_some());
    let text = &reader.info().utf8_text[0];
    assert_eq!((text.keyword.as_str(), text.get_text().unwrap().as_str()), ("Study", "λ, µm"));
}

#[test]
fn a_contact_sheet_shows_what_is_there_and_marks_what_is_not() {
    let shares = [0.05, 0.15, 0.3];
    let mut cells: Vec<Vec<Result<ScreenPicture, String>>> = ["yellow", "red", "blue", "green"]
        .map(|pigment| {
            let picture = |share| {
                molecular_ink(pigment, share, Coupling::Gap).picture(&angles(13), MirroredSky::Excluded)
            };
            shares.map(|share| Ok(picture(share).unwrap().on_screen())).to_vec()
        })
        .to_vec();
    cells[2][2] = Err(String::new());
    let sheet = ContactSheet {
        title: "Molecular mixtures on paper 0.9 (synthetic pigments)".into(),
        row_axis: "pigment".into(),
        rows: ["yellow", "red", "blue", "green"].map(String::from).to_vec(),
        column_axis: "volume share of pigment".into(),
        columns: shares.map(|s| format!("{:.0} %", 100.0 * s)).to_vec(),
        cells,
    };
    let style = PictureStyle { side_px: 130, strip_px: 40, gap_px: 6, labels: false };
    let bitmap = sheet.render(&style).unwrap();
    let yellow = sheet.cells[0][0].as_ref().unwrap().strip[0];
    assert_eq!(pixel(&bitmap, SHEET_LEFT, SHEET_TOP), yellow);
    keep(&bitmap, "sheet.png");
    let ragged = ContactSheet { columns: vec!["one".into()], ..sheet };
    assert!(ragged.render(&style).is_err());
}

#[test]
fn impossible_pictures_are_refused() {
    let style = PictureStyle::default();
    let short = InkPicture { strip: Vec::new(), ..uniform(0.5) };
    assert!(render(&short, &style).unwrap_err().to_string().contains("colours along a side"));
    let empty = InkPicture {
        angles_deg: vec![],
        strip: vec![],
        square: Array2::from_elem((0, 0), uniform(0.1).strip[0]),
    };
    assert!(render(&empty, &style).is_err());
    let huge = PictureStyle { side_px: 30_000, ..style };
    assert!(render(&uniform(0.5), &huge).unwrap_err().to_string().contains("30102"));
}
