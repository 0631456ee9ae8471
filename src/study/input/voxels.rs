//! Label arrays in other programs' files: NumPy arrays and stacks of TIFF pages.
//!
//! Labels are handed over one by one, so that an image takes one byte per voxel whatever its
//! numbers; sizes are checked before anything is made for them.

use crate::numerics::files;
use ndarray::{Array3, ArrayD};
use ndarray_npy::npy::header::Header;
use ndarray_npy::{ReadNpyError, ReadNpyExt, ReadableElement};
use std::io::Cursor;
use std::path::Path;
use tiff::ColorType;
use tiff::decoder::{Decoder, DecodingResult};
use tiff::tags::Tag;

/// Largest number of voxels in one image, 512³: merged to boxes in seconds.
pub const MOST_VOXELS: usize = 1 << 27;

/// What a label of a file is to become.
pub type LabelReader<'a> = dyn FnMut(i64) -> u8 + 'a;

/// Labels of an image, as they were handed over.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LabelImage {
    /// Axes x, y, z.
    pub labels: Array3<u8>,
    /// Whether the file calls 0 white, so that other programs show its numbers the other way round.
    pub white_is_zero: bool,
}

/// The labels of a file, each as `take` makes it.
///
/// # Errors
/// In words: what is missing or wrong.
pub fn read_labels(path: &Path, take: &mut LabelReader) -> Result<LabelImage, String> {
    let bytes = files::read_bytes(path, files::CASE).map_err(|e| e.to_string())?;
    let (labels, white_is_zero) = match bytes.get(..4) {
        Some(b"\x93NUM") => (from_npy(&bytes, take)?, false),
        Some(b"II*\0" | b"MM\0*" | b"II+\0" | b"MM\0+") => from_tiff(&bytes, take)?,
        _ => return Err("neither a NumPy array (.npy) nor TIFF".into()),
    };
    let shape = labels.shape().to_vec();
    if labels.is_empty() {
        return Err(format!("an empty array of {shape:?} voxels"));
    }
    let labels = labels
        .into_dimensionality()
        .map_err(|_| format!("an array with axes {shape:?} where x, y, z are needed"))?;
    Ok(LabelImage { labels, white_is_zero })
}

/// Labels of a NumPy array of one kind of numbers.
type NpyLabels = Result<ArrayD<u8>, ReadNpyError>;

fn labels_of<T: ReadableElement + Copy>(
    bytes: &[u8],
    take: &mut LabelReader,
    number: fn(T) -> i64,
) -> NpyLabels {
    Ok(ArrayD::<T>::read_npy(bytes)?.mapv(|label| take(number(label))))
}

/// Longest header of a NumPy array, bytes: NumPy itself reads no longer ones.
const LONGEST_HEADER: usize = 10_000;
/// More brackets than the header of an array of numbers has.
const MOST_BRACKETS: usize = 50;

/// What is wrong with the header of a NumPy array or the amount of data after it: readers make room
/// for what a header says before they read.
fn check_header(bytes: &[u8]) -> Result<(), String> {
    let cut = || "fewer data than its header says: was it copied whole?".to_owned();
    let length = match bytes {
        [_, _, _, _, _, _, 1, _, a, b, ..] => 10 + usize::from(u16::from_le_bytes([*a, *b])),
        [_, _, _, _, _, _, _, _, a, b, c, d, ..] => 12 + u32::from_le_bytes([*a, *b, *c, *d]) as usize,
        _ => return Err(cut()),
    };
    let header = bytes.get(..length).ok_or_else(cut)?;
    let brackets = header.iter().filter(|byte| b"([{".contains(byte)).count();
    if length > LONGEST_HEADER || brackets > MOST_BRACKETS {
        return Err("a header that is not of an array of numbers".into());
    }
    let shape = Header::from_reader(&mut &bytes[..]).map_err(|e| e.to_string())?.shape;
    let voxels = shape.iter().try_fold(1_usize, |product, &length| product.checked_mul(length));
    let data = bytes.len() - length;
    match voxels.filter(|voxels| *voxels <= data) {
        Some(voxels) if voxels > MOST_VOXELS => Err(format!("{voxels} voxels; {}", at_most())),
        Some(_) => Ok(()),
        None => Err(format!("{} for {shape:?} voxels, but has {data} bytes of data", cut())),
    }
}

fn at_most() -> String {
    format!(
        "at most {} million voxels are read: crop the image, or take larger voxels",
        MOST_VOXELS / 1_000_000
    )
}

fn from_npy(bytes: &[u8], take: &mut LabelReader) -> Result<ArrayD<u8>, String> {
    check_header(bytes)?;
    let kinds: [fn(&[u8], &mut LabelReader) -> NpyLabels; 9] = [
        |b, take| labels_of::<u8>(b, take, i64::from),
        |b, take| labels_of::<u16>(b, take, i64::from),
        |b, take| labels_of::<u32>(b, take, i64::from),
        // larger labels become negative, which none of the study's is
        |b, take| labels_of::<u64>(b, take, |v| v as i64),
        |b, take| labels_of::<i8>(b, take, i64::from),
        |b, take| labels_of::<i16>(b, take, i64::from),
        |b, take| labels_of::<i32>(b, take, i64::from),
        |b, take| labels_of::<i64>(b, take, |v| v),
        |b, take| labels_of::<bool>(b, take, i64::from),
    ];
    for kind in kinds {
        match kind(bytes, take) {
            Err(ReadNpyError::WrongDescriptor(_)) => {}
            Err(other) => return Err(other.to_string()),
            Ok(labels) => return Ok(labels),
        }
    }
    Err("an array of other numbers than integers: write labels.astype('uint8')".into())
}

/// Labels of a stack of pages, and whether 0 is white in it.
fn from_tiff(bytes: &[u8], take: &mut LabelReader) -> Result<(ArrayD<u8>, bool), String> {
    let mut pages = Decoder::new(Cursor::new(bytes)).map_err(|e| e.to_string())?;
    let size = pages.dimensions().map_err(|e| e.to_string())?;
    let width = size.0 as usize;
    let height = size.1 as usize;
    let in_page = width.saturating_mul(height);
    if in_page == 0 {
        return Err(format!("pages of {width} × {height} pixels"));
    }
    let mut labels: Vec<u8> = Vec::new();
    let mut depth = 0;
    let mut white_is_zero = false;
    loop {
        depth += 1;
        let in_words = |e: tiff::TiffError| format!("page {depth}: {e}");
        if pages.dimensions().map_err(in_words)? != size {
            return Err(format!("page {depth} of another size than the first one"));
        }
        if in_page.saturating_mul(depth) > MOST_VOXELS {
            return Err(format!("{depth} pages or more of {width} × {height} voxels; {}", at_most()));
        }
        let photometric: Option<u16> =
            pages.find_tag_unsigned(Tag::PhotometricInterpretation).map_err(in_words)?;
        let inverted = photometric == Some(0);
        white_is_zero |= inverted;
        let bits = match pages.colortype().map_err(in_words)? {
            ColorType::Gray(bits) | ColorType::Palette(bits) => bits,
            _ => {
                return Err(format!(
                    "page {depth}: several numbers for each of {width} × {height} pixels: colours?"
                ));
            }
        };
        let decoded = pages.read_image().map_err(in_words)?;
        let found = PageNumbers { width, height, bits, inverted };
        labels.reserve(in_page);
        if !found.read(decoded, &mut |label| labels.push(take(label))) || labels.len() != depth * in_page {
            return Err(format!("page {depth}: other numbers than integers, of {bits} bits"));
        }
        if !pages.more_images() {
            break;
        }
        pages.next_image().map_err(in_words)?;
    }
    let stack = Array3::from_shape_vec((depth, height, width), labels).map_err(|e| e.to_string())?;
    // x, y, z in the order in which they are gone through
    let labels = stack.reversed_axes().as_standard_layout().into_owned();
    Ok((labels.into_dyn(), white_is_zero))
}

/// How the numbers of a page are stored.
struct PageNumbers {
    width: usize,
    height: usize,
    bits: u8,
    /// Whether the decoder has inverted them, as the file calls 0 white. Labels are numbers, not
    /// shades: they are taken as stored.
    inverted: bool,
}

impl PageNumbers {
    /// Hands over all numbers, row by row; false if they are no integers.
    fn read(&self, page: DecodingResult, take: &mut dyn FnMut(i64)) -> bool {
        let largest = u64::MAX >> 64_u32.saturating_sub(u32::from(self.bits));
        let stored = |shown: u64| if self.inverted { largest - shown } else { shown };
        match page {
            DecodingResult::U8(_) if !matches!(self.bits, 1 | 2 | 4 | 8) => return false,
            DecodingResult::U8(all) if self.bits < 8 => self.unpack(&all, &mut |v| take(stored(v) as i64)),
            DecodingResult::U8(all) => all.into_iter().for_each(|v| take(stored(v.into()) as i64)),
            DecodingResult::U16(all) => all.into_iter().for_each(|v| take(stored(v.into()) as i64)),
            DecodingResult::U32(all) => all.into_iter().for_each(|v| take(stored(v.into()) as i64)),
            DecodingResult::U64(all) => all.into_iter().for_each(|v| take(stored(v) as i64)),
            DecodingResult::I8(all) => all.into_iter().for_each(|v| take(v.into())),
            DecodingResult::I16(all) => all.into_iter().for_each(|v| take(v.into())),
            DecodingResult::I32(all) => all.into_iter().for_each(|v| take(v.into())),
            DecodingResult::I64(all) => all.into_iter().for_each(take),
            _ => return false,
        }
        true
    }

    /// Numbers of less than a byte: the first one in the highest bits, every row from a byte on.
    fn unpack(&self, bytes: &[u8], take: &mut dyn FnMut(u64)) {
        let bits = usize::from(self.bits);
        let in_row = (self.width * bits).div_ceil(8);
        for row in bytes.chunks_exact(in_row).take(self.height) {
            for first in (0..self.width).map(|i| i * bits) {
                let byte = row[first / 8] >> (8 - bits - first % 8);
                take(u64::from(byte) & ((1 << bits) - 1));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::{Array2, ShapeBuilder};
    use ndarray_npy::{WritableElement, WriteNpyExt};
    use tiff::encoder::{TiffEncoder, colortype::Gray16};

    /// The labels as they are in the file, and whether 0 is white.
    fn read(bytes: &[u8]) -> Result<(Array3<i64>, bool), String> {
        let file = tempfile::NamedTempFile::new().expect("a file");
        std::fs::write(file.path(), bytes).expect("written");
        let mut all: Vec<i64> = Vec::new();
        let image = read_labels(file.path(), &mut |label| {
            all.push(label);
            0
        })?;
        // pages, rows and columns of TIFF come one after the other, and arrays in their own order
        let mut labels = image.labels.map(|_| 0);
        if bytes.starts_with(b"II") || bytes.starts_with(b"MM") {
            labels.view_mut().reversed_axes().iter_mut().zip(all).for_each(|(to, label)| *to = label);
        } else {
            labels.as_slice_memory_order_mut().expect("contiguous").copy_from_slice(&all);
        }
        Ok((labels, image.white_is_zero))
    }

    /// One page of `bits` per pixel whose rows are given as bytes, by hand.
    fn page(size: [u16; 2], bits: u16, photometric: u16, rows: &[u8]) -> Vec<u8> {
        let entries: [[u16; 4]; 8] = [
            [256, 3, 1, size[0]],
            [257, 3, 1, size[1]],
            [258, 3, 1, bits],
            [259, 3, 1, 1],
            [262, 3, 1, photometric],
            [273, 3, 1, 8],
            [278, 3, 1, size[1]],
            [279, 3, 1, rows.len() as u16],
        ];
        let mut bytes = b"II*\0".to_vec();
        bytes.extend((8 + rows.len() as u32).to_le_bytes());
        bytes.extend(rows);
        bytes.extend((entries.len() as u16).to_le_bytes());
        for [tag, kind, count, value] in entries {
            bytes.extend([tag, kind, count, 0, value, 0].iter().flat_map(|word| word.to_le_bytes()));
        }
        bytes.extend([0; 4]);
        bytes
    }

    /// Numbers are those stored, whichever way round they are shown and however few bits they have.
    /// *Planted*: white shown as 0 inverts a mask of 0 and 255.
    #[test]
    fn numbers_of_pictures_are_those_stored() {
        let eight = [0, 255, 255, 0, 0, 255];
        for (photometric, white) in [(0, true), (1, false)] {
            let mask = read(&page([3, 2], 8, photometric, &eight)).expect("a mask");
            let expected = Array3::from_shape_fn((3, 2, 1), |(x, y, _)| i64::from(eight[3 * y + x]));
            assert_eq!(mask, (expected, white));
            // 10 pixels a row: 1010 0000 01, then 0000 0000 11
            let bits = read(&page([10, 2], 1, photometric, &[0b1010_0000, 0b0100_0000, 0, 0b1100_0000]));
            let on = [[1, 0, 1, 0, 0, 0, 0, 0, 0, 1], [0, 0, 0, 0, 0, 0, 0, 0, 1, 1]];
            let expected = Array3::from_shape_fn((10, 2, 1), |(x, y, _)| on[y][x]);
            assert_eq!(bits.expect("bits"), (expected, white));
            let four = read(&page([3, 1], 4, photometric, &[0x12, 0xf0])).expect("half bytes");
            assert_eq!(four.0.into_raw_vec_and_offset().0, [1, 2, 15]);
        }
    }

    /// Files of some hundred bytes that claim to be large. *Planted*: room made before the check.
    #[test]
    fn claimed_sizes_are_checked_before_anything_is_made() {
        let claim = |shape: &str, version: u8| {
            let header = format!("{{'descr': '|u1', 'fortran_order': False, 'shape': {shape}}}\n");
            let mut bytes = b"\x93NUMPY".to_vec();
            bytes.extend([version, 0]);
            let length = (header.len() as u32).to_le_bytes();
            bytes.extend(if version == 1 { &length[..2] } else { &length[..] });
            bytes.extend(header.as_bytes());
            bytes
        };
        for shape in [
            "(1000000000, 1000000, 8)",
            "(18446744073709551615, 2, 1)",
            "(4294967296, 4294967296, 4294967296)",
            "(10**9, 10**6, 8)",
        ] {
            for version in [1, 2] {
                assert!(read(&claim(shape, version)).is_err(), "{shape}");
            }
        }
        assert!(read(&claim(&"(".repeat(60), 1)).unwrap_err().contains("header"));
        let mut endless = claim("(1, 1, 1)", 2);
        endless[8..12].fill(255);
        assert!(read(&endless).unwrap_err().contains("fewer data"));
        let error = read(&page([65_535, 65_535], 1, 1, &[0; 4])).unwrap_err();
        assert!(error.contains("at most 134 million"), "{error}");
    }

    fn npy<T: WritableElement, D: ndarray::Dimension>(array: &ndarray::Array<T, D>) -> Vec<u8> {
        let mut bytes = Vec::new();
        array.write_npy(&mut bytes).expect("an array");
        bytes
    }

    /// 4 × 3 × 2 different labels.
    fn label((x, y, z): (usize, usize, usize)) -> u16 {
        (100 * x + 10 * y + z) as u16
    }

    #[test]
    fn every_kind_of_integer_order_and_file_is_one_array() {
        let expected = Array3::from_shape_fn((4, 3, 2), |place| i64::from(label(place)));
        let wide = expected.mapv(|v| v as i32);
        let columns = Array3::from_shape_fn((4, 3, 2).f(), label);
        let mut stack = Cursor::new(Vec::new());
        let mut tiff = TiffEncoder::new(&mut stack).expect("a stack");
        for z in 0..2 {
            let page: Vec<u16> = (0..3).flat_map(|y| (0..4).map(move |x| label((x, y, z)))).collect();
            tiff.write_image::<Gray16>(4, 3, &page).expect("a page");
        }
        for bytes in [npy(&expected), npy(&wide), npy(&columns), stack.into_inner()] {
            assert_eq!(read(&bytes), Ok((expected.clone(), false)));
        }
        let solid = read(&npy(&expected.mapv(|v| v > 110))).expect("booleans").0;
        assert_eq!((solid.sum(), solid[[1, 1, 1]], solid[[1, 1, 0]]), (15, 1, 0));
    }

    #[test]
    fn other_files_are_refused_with_the_reason() {
        let cut = npy(&Array3::<u8>::zeros((4, 3, 2)));
        for (bytes, says) in [
            (npy(&Array3::<f64>::zeros((4, 3, 2))), "other numbers than integers"),
            (npy(&Array2::<u8>::zeros((4, 3))), "axes [4, 3] where x, y, z"),
            (npy(&Array3::<u8>::zeros((4, 0, 2))), "empty array"),
            (cut[..cut.len() - 1].to_vec(), ""),
            (b"\x93NUMPY\x01\0\x46\0{'descr': '|u1', 'fortran_order': False, 'shape': (99999999, 99999999, 9)}".to_vec(), ""),
            (b"x,y,z\n".to_vec(), "neither"),
            (b"II*\0".to_vec(), ""),
        ] {
            let error = read(&bytes).expect_err(says);
            assert!(error.contains(says), "{error}");
        }
    }
}
