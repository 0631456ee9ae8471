//! The tensor file of measured materials (`.bsdf`) that Mitsuba 3 reads.
//!
//! ```text
//! "tensor_file\0"  version 1.0 (2 × u8)  number of fields (u32)
//! for each field:  length of name (u16)  name  number of dimensions (u16)  type (u8)  offset (u64)  sizes (u64 each)
//! the data of all fields, each at its offset; everything little-endian
//! ```
//! Layout as the reader expects it: found by reading such files and checked with the real one (`scripts/check-exports`).

/// What a field holds.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Unsigned bytes.
    Bytes(Vec<u8>),
    /// Single precision numbers.
    Floats(Vec<f32>),
}

/// A named array, last axis fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct TensorField {
    /// The name that the reader looks for.
    pub name: &'static str,
    /// Sizes along every axis; their product is the number of values.
    pub shape: Vec<usize>,
    /// The values themselves.
    pub values: Values,
}

const MAGIC: &[u8; 12] = b"tensor_file\0";
const VERSION: [u8; 2] = [1, 0];
/// Data starts at multiples of this.
const ALIGNMENT: usize = 8;

impl TensorField {
    /// An array of numbers.
    pub fn floats(name: &'static str, shape: &[usize], values: Vec<f32>) -> Self {
        Self { name, shape: shape.to_vec(), values: Values::Floats(values) }
    }

    /// A list of bytes.
    pub fn bytes(name: &'static str, values: Vec<u8>) -> Self {
        Self { name, shape: vec![values.len()], values: Values::Bytes(values) }
    }

    fn type_code(&self) -> u8 {
        match self.values {
            Values::Bytes(_) => 1,
            Values::Floats(_) => 10,
        }
    }

    fn size(&self) -> usize {
        match &self.values {
            Values::Bytes(values) => values.len(),
            Values::Floats(values) => 4 * values.len(),
        }
    }

    fn header_size(&self) -> usize {
        2 + self.name.len() + 2 + 1 + 8 + 8 * self.shape.len()
    }

    fn write_header(&self, out: &mut Vec<u8>, offset: usize) {
        out.extend((self.name.len() as u16).to_le_bytes());
        out.extend(self.name.as_bytes());
        out.extend((self.shape.len() as u16).to_le_bytes());
        out.push(self.type_code());
        out.extend((offset as u64).to_le_bytes());
        self.shape.iter().for_each(|&n| out.extend((n as u64).to_le_bytes()));
    }
}

/// The whole file.
pub fn tensor_file(fields: &[TensorField]) -> Vec<u8> {
    let headers: usize = fields.iter().map(TensorField::header_size).sum();
    let mut offset = MAGIC.len() + VERSION.len() + 4 + headers;
    let mut out = [MAGIC.as_slice(), &VERSION, &(fields.len() as u32).to_le_bytes()].concat();
    let mut offsets = Vec::new();
    for field in fields {
        offset = offset.next_multiple_of(ALIGNMENT);
        field.write_header(&mut out, offset);
        offsets.push(offset);
        offset += field.size();
    }
    for (field, offset) in fields.iter().zip(offsets) {
        out.resize(offset, 0);
        match &field.values {
            Values::Bytes(values) => out.extend(values),
            Values::Floats(values) => out.extend(values.iter().flat_map(|x| x.to_le_bytes())),
        }
    }
    out
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
