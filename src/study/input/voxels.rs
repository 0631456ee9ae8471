//! Label arrays in other programs' files: NumPy arrays and stacks of TIFF pages.

use crate::numerics::files;
use ndarray::{Array3, ArrayD};
use ndarray_npy::{ReadNpyError, ReadNpyExt, ReadableElement};
use std::io::Cursor;
use std::path::Path;
use tiff::decoder::{Decoder, DecodingResult};

/// The labels of a file with axes x, y, z.
///
/// # Errors
/// In words: what is missing or wrong.
pub fn read_labels(path: &Path) -> Result<Array3<i64>, String> {
    let bytes = files::read_bytes(path, files::CASE).map_err(|e| e.to_string())?;
    let labels = match bytes.get(..4) {
        Some(b"\x93NUM") => from_npy(&bytes)?,
        Some(b"II*\0" | b"MM\0*" | b"II+\0" | b"MM\0+") => from_tiff(&bytes)?,
        _ => return Err("neither a NumPy array (.npy) nor TIFF".into()),
    };
    let shape = labels.shape().to_vec();
    if labels.is_empty() {
        return Err(format!("an empty array of {shape:?} voxels"));
    }
    labels.into_dimensionality().map_err(|_| format!("an array with axes {shape:?} where x, y, z are needed"))
}

/// Labels of a NumPy array of one kind of numbers.
type NpyLabels = Result<ArrayD<i64>, ReadNpyError>;

fn of<T: ReadableElement + Copy>(bytes: &[u8], number: fn(T) -> i64) -> NpyLabels {
    Ok(ArrayD::<T>::read_npy(bytes)?.mapv(number))
}

fn from_npy(bytes: &[u8]) -> Result<ArrayD<i64>, String> {
    let kinds: [fn(&[u8]) -> NpyLabels; 9] = [
        |b| of::<u8>(b, i64::from),
        |b| of::<u16>(b, i64::from),
        |b| of::<u32>(b, i64::from),
        // larger labels become negative, which none of the study's is
        |b| of::<u64>(b, |v| v as i64),
        |b| of::<i8>(b, i64::from),
        |b| of::<i16>(b, i64::from),
        |b| of::<i32>(b, i64::from),
        |b| of::<i64>(b, |v| v),
        |b| of::<bool>(b, i64::from),
    ];
    let other = |read: &NpyLabels| matches!(read, Err(ReadNpyError::WrongDescriptor(_)));
    match kinds.into_iter().map(|kind| kind(bytes)).find(|read| !other(read)) {
        Some(read) => read.map_err(|e| e.to_string()),
        None => Err("an array of other numbers than integers: write labels.astype('uint8')".into()),
    }
}

fn from_tiff(bytes: &[u8]) -> Result<ArrayD<i64>, String> {
    let mut pages = Decoder::new(Cursor::new(bytes)).map_err(|e| e.to_string())?;
    let size = pages.dimensions().map_err(|e| e.to_string())?;
    let (width, height) = (size.0 as usize, size.1 as usize);
    let mut labels: Vec<i64> = Vec::new();
    loop {
        let page = labels.len() / (width * height).max(1) + 1;
        let in_page = |e: tiff::TiffError| format!("page {page}: {e}");
        if pages.dimensions().map_err(in_page)? != size {
            return Err(format!("page {page} of another size than the first one"));
        }
        let found = integers(pages.read_image().map_err(in_page)?)
            .ok_or_else(|| format!("page {page}: other numbers than integers"))?;
        if found.len() != width * height {
            return Err(format!(
                "page {page}: {} numbers for {width} × {height} pixels: colours?",
                found.len()
            ));
        }
        labels.extend(found);
        if !pages.more_images() {
            break;
        }
        pages.next_image().map_err(in_page)?;
    }
    let depth = labels.len() / (width * height).max(1);
    let stack = Array3::from_shape_vec((depth, height, width), labels).map_err(|e| e.to_string())?;
    Ok(stack.reversed_axes().into_dyn())
}

fn integers(page: DecodingResult) -> Option<Vec<i64>> {
    fn wide<T: Into<i64>>(all: Vec<T>) -> Vec<i64> {
        all.into_iter().map(Into::into).collect()
    }
    Some(match page {
        DecodingResult::U8(all) => wide(all),
        DecodingResult::U16(all) => wide(all),
        DecodingResult::U32(all) => wide(all),
        DecodingResult::I8(all) => wide(all),
        DecodingResult::I16(all) => wide(all),
        DecodingResult::I32(all) => wide(all),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::{Array2, ShapeBuilder};
    use ndarray_npy::{WritableElement, WriteNpyExt};
    use tiff::encoder::{TiffEncoder, colortype::Gray16};

    fn read(bytes: &[u8]) -> Result<Array3<i64>, String> {
        let file = tempfile::NamedTempFile::new().expect("a file");
        std::fs::write(file.path(), bytes).expect("written");
        read_labels(file.path())
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
            assert_eq!(read(&bytes), Ok(expected.clone()));
        }
        let solid = read(&npy(&expected.mapv(|v| v > 11))).expect("booleans");
        assert_eq!((solid.sum(), solid[[1, 1, 1]], solid[[1, 1, 0]]), (12, 0, 0));
    }

    #[test]
    fn other_files_are_refused_with_the_reason() {
        let cut = npy(&Array3::<u8>::zeros((4, 3, 2)));
        for (bytes, says) in [
            (npy(&Array3::<f64>::zeros((4, 3, 2))), "other numbers than integers"),
            (npy(&Array2::<u8>::zeros((4, 3))), "axes [4, 3] where x, y, z"),
            (npy(&Array3::<u8>::zeros((4, 0, 2))), "empty array"),
            (cut[..cut.len() - 1].to_vec(), ""),
            (b"x,y,z\n".to_vec(), "neither"),
            (b"II*\0".to_vec(), ""),
        ] {
            let error = read(&bytes).expect_err(says);
            assert!(error.contains(says), "{error}");
        }
    }
}
