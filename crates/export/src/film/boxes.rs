//! Boxes of the ISO base media file format (ISO/IEC 14496-12): a length of 32 bits, four letters, content.

/// Builds nested boxes.
#[derive(Default)]
pub(super) struct Boxes {
    bytes: Vec<u8>,
}

impl Boxes {
    /// A box `name` with what `content` adds.
    pub fn nest(&mut self, name: &[u8; 4], content: impl FnOnce(&mut Self)) -> &mut Self {
        let start = self.bytes.len();
        self.u32(0).raw(name);
        content(self);
        let length = (self.bytes.len() - start) as u32;
        self.bytes[start..start + 4].copy_from_slice(&length.to_be_bytes());
        self
    }

    /// A box that begins with a version and flags.
    pub fn full(
        &mut self,
        name: &[u8; 4],
        version: u8,
        flags: u32,
        content: impl FnOnce(&mut Self),
    ) -> &mut Self {
        self.nest(name, |inner| {
            inner.u32(u32::from(version) << 24 | flags);
            content(inner);
        })
    }

    /// Bytes as they are.
    pub fn raw(&mut self, bytes: &[u8]) -> &mut Self {
        self.bytes.extend_from_slice(bytes);
        self
    }

    /// `count` bytes of zero.
    pub fn zeros(&mut self, count: usize) -> &mut Self {
        self.bytes.resize(self.bytes.len() + count, 0);
        self
    }

    /// One byte.
    pub fn u8(&mut self, value: u8) -> &mut Self {
        self.raw(&[value])
    }

    /// Big-endian, as all numbers here.
    pub fn u16(&mut self, value: u16) -> &mut Self {
        self.raw(&value.to_be_bytes())
    }

    /// Big-endian.
    pub fn u32(&mut self, value: u32) -> &mut Self {
        self.raw(&value.to_be_bytes())
    }

    /// One after the other.
    pub fn all_u32(&mut self, values: &[u32]) -> &mut Self {
        values.iter().fold(self, |boxes, value| boxes.u32(*value))
    }

    /// Big-endian.
    pub fn u64(&mut self, value: u64) -> &mut Self {
        self.raw(&value.to_be_bytes())
    }

    /// Bytes so far.
    pub fn length(&self) -> usize {
        self.bytes.len()
    }

    /// What was built.
    pub fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }
}
