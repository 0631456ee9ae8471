//! The seal of a record, which shows that it is intact, of the current method and stored under its
//! own key.

use super::build::build;
use super::damage::RecordFault;
use super::identity::METHOD_VERSION;

/// Length of a seal: 128 bits of BLAKE3.
const SEAL_BYTES: usize = 16;

/// A record as stored.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sealed {
    /// Kind, such as `point`.
    pub kind: String,
    /// Content hash of what the record depends on.
    pub key: String,
    /// [`METHOD_VERSION`] of the program that computed it.
    pub method: u32,
    /// The program that computed it: name, version, commit.
    pub program: String,
    /// Checksum of the record's kind, key, method, program and content.
    pub seal: Vec<u8>,
    /// The record itself (MessagePack).
    pub content: Vec<u8>,
}

impl Sealed {
    /// Seals `content` as the record `key` of `kind`.
    pub fn new(kind: &str, key: &str, content: Vec<u8>) -> Self {
        let [kind, key, program] = [kind, key, build()].map(str::to_owned);
        let mut record = Self { kind, key, method: METHOD_VERSION, program, seal: Vec::new(), content };
        record.seal = record.expected_seal().to_vec();
        record
    }

    /// Checks that the record is unchanged.
    ///
    /// # Errors
    /// The seal does not match (a changed byte, another record under this key), or the method
    /// differs.
    pub fn check(&self) -> Result<(), RecordFault> {
        if self.seal != self.expected_seal() {
            Err(RecordFault::Seal)
        } else if self.method != METHOD_VERSION {
            Err(RecordFault::Method(self.method))
        } else {
            Ok(())
        }
    }

    fn expected_seal(&self) -> [u8; SEAL_BYTES] {
        let Self { kind, key, method, program, content, .. } = self;
        let mut hasher = blake3::Hasher::new();
        hasher.update(format!("inkwave record/{kind}/{key}/{method}/{program}/").as_bytes()).update(content);
        let mut seal = [0; SEAL_BYTES];
        hasher.finalize_xof().fill(&mut seal);
        seal
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_seal_breaks_with_name_kind_method_program_and_every_bit() {
        let whole = Sealed::new("point", "a", vec![1, 2, 3]);
        assert_eq!(whole.check(), Ok(()));
        for forged in [
            Sealed { key: "b".into(), ..whole.clone() },
            Sealed { kind: "grid".into(), ..whole.clone() },
            Sealed { method: METHOD_VERSION + 1, ..whole.clone() },
            Sealed { program: "another".into(), ..whole.clone() },
        ] {
            assert_eq!(forged.check(), Err(RecordFault::Seal));
        }
        for bit in 0..24 {
            let mut damaged = whole.clone();
            damaged.content[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(damaged.check(), Err(RecordFault::Seal));
        }
    }

    #[test]
    fn a_record_of_another_method_is_recognised() {
        let other = METHOD_VERSION + 1;
        let mut record = Sealed { method: other, ..Sealed::new("point", "a", vec![1]) };
        record.seal = record.expected_seal().to_vec();
        assert_eq!(record.check(), Err(RecordFault::Method(other)));
    }
}
