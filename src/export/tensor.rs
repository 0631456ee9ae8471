//! The tensor file of measured materials (`.bsdf`) that Mitsuba 3 reads.
//!
//! ```text
//! "tensor_file\0"  version 1.0 (2 × u8)  number of fields (u32)
//! for each field:  length of name (u16)  name  number of dimensions (u16)  type (u8)  offset (u64)  sizes (u64 each)
//! the data of all fields, each at its offset; everything little-endian
//! ```
//! The layout was derived from existing files and is checked with Mitsuba itself
//! (`scripts/check-exports`).

/// A named array, last axis fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct TensorField {
    /// The name that the reader looks for.
    pub name: &'static str,
    /// Sizes along every axis; their product is the number of values.
    pub shape: Vec<usize>,
    kind: ValueKind,
    bytes: Vec<u8>,
}

/// What a field holds, with the format's number for it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum ValueKind {
    Byte = 1,
    Float = 10,
}

const MAGIC: &[u8; 12] = b"tensor_file\0";
const VERSION: [u8; 2] = [1, 0];
/// Data starts at multiples of this.
const ALIGNMENT: usize = 8;

impl TensorField {
    /// An array of numbers in single precision.
    pub fn floats(name: &'static str, shape: &[usize], values: Vec<f32>) -> Self {
        let bytes = values.iter().flat_map(|x| x.to_le_bytes()).collect();
        Self { name, shape: shape.to_vec(), kind: ValueKind::Float, bytes }
    }

    /// A list of bytes.
    pub fn bytes(name: &'static str, bytes: Vec<u8>) -> Self {
        Self { name, shape: vec![bytes.len()], kind: ValueKind::Byte, bytes }
    }

    /// What the file says of the field, whose data begin at `offset`.
    fn header(&self, offset: usize) -> Vec<u8> {
        let mut header = (self.name.len() as u16).to_le_bytes().to_vec();
        header.extend(self.name.as_bytes());
        header.extend((self.shape.len() as u16).to_le_bytes());
        header.push(self.kind as u8);
        header.extend(std::iter::once(&offset).chain(&self.shape).flat_map(|&n| (n as u64).to_le_bytes()));
        header
    }
}

/// The complete file.
pub fn tensor_file(fields: &[TensorField]) -> Vec<u8> {
    let headers: usize = fields.iter().map(|field| field.header(0).len()).sum();
    let mut out = [MAGIC.as_slice(), &VERSION, &(fields.len() as u32).to_le_bytes()].concat();
    let mut data = vec![0; out.len() + headers];
    for field in fields {
        data.resize(data.len().next_multiple_of(ALIGNMENT), 0);
        out.extend(field.header(data.len()));
        data.extend(&field.bytes);
    }
    data[..out.len()].copy_from_slice(&out);
    data
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_is_where_its_header_says() {
        let numbers = TensorField::floats("theta_i", &[3], vec![0.0, 0.5, 1.25]);
        let file = tensor_file(&[TensorField::bytes("description", b"ink".to_vec()), numbers]);
        assert_eq!(&file[..12], MAGIC);
        assert_eq!(u32::from_le_bytes(file[14..18].try_into().unwrap()), 2);
        // second header: after 18 bytes and the first one (2 + 11 + 2 + 1 + 8 + 8)
        let second = 18 + 32;
        assert_eq!(&file[second + 2..second + 9], b"theta_i");
        assert_eq!((file[second + 9], file[second + 11]), (1, 10));
        let offset = u64::from_le_bytes(file[second + 12..second + 20].try_into().unwrap()) as usize;
        let at = |i: usize| f32::from_le_bytes(file[offset + 4 * i..offset + 4 * i + 4].try_into().unwrap());
        assert_eq!([at(0), at(1), at(2)], [0.0, 0.5, 1.25]);
        assert_eq!(file.len(), offset + 12);
    }
}
