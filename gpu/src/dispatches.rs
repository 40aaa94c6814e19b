//! The workgroups that the device counts for the stages after it (`select.wgsl`): three words a stage.

/// A stage whose workgroups are counted on the device.
#[derive(Clone, Copy, Debug)]
pub enum Counted {
    Deposit,
    Escape,
    Power,
    Links,
    Received,
}

/// How many there are.
const STAGES: u32 = Counted::Received as u32 + 1;
/// Words of one stage: workgroups in x, y and z.
pub const DISPATCH_WORDS: u32 = 3;
/// Bytes of all.
pub const DISPATCH_BYTES: u64 = 4 * (DISPATCH_WORDS * STAGES) as u64;

impl Counted {
    /// Where its words begin, in bytes.
    pub fn offset(self) -> u64 {
        u64::from(4 * DISPATCH_WORDS * self as u32)
    }
}
