//! Dispatch arguments that `select.wgsl` writes for the stages of the next shot: three words a stage.

/// A stage whose workgroups the device counts.
#[derive(Clone, Copy, Debug)]
pub enum CountedStage {
    Deposit,
    Escape,
    Power,
    Links,
    Transfer,
}

/// Number of such stages.
const STAGE_COUNT: u32 = CountedStage::Transfer as u32 + 1;
/// Words of one stage: workgroups in x, y and z.
pub const DISPATCH_WORDS: u32 = 3;
/// Bytes of all.
pub const DISPATCH_BYTES: u64 = 4 * (DISPATCH_WORDS * STAGE_COUNT) as u64;

impl CountedStage {
    /// Returns the offset of its words, in bytes.
    pub fn byte_offset(self) -> u64 {
        u64::from(4 * DISPATCH_WORDS * self as u32)
    }
}
