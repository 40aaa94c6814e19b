//! Numbers out of the bytes of an input.

/// Bytes that are not taken yet.
pub struct Numbers<'a>(pub &'a [u8]);

impl Numbers<'_> {
    /// Takes `N` bytes; 0 stands for those that are missing.
    pub fn take<const N: usize>(&mut self) -> [u8; N] {
        let count = N.min(self.0.len());
        let (taken, rest) = self.0.split_at(count);
        self.0 = rest;
        let mut bytes = [0; N];
        bytes[..count].copy_from_slice(taken);
        bytes
    }

    /// Takes a byte.
    pub fn byte(&mut self) -> u8 {
        self.take::<1>()[0]
    }

    /// Takes a number of 64 bits: any, also an infinite one or none.
    pub fn real(&mut self) -> f64 {
        f64::from_le_bytes(self.take())
    }

    /// Takes one of these values.
    pub fn choice<T: Copy>(&mut self, values: &[T]) -> T {
        values[usize::from(self.byte()) % values.len()]
    }
}
