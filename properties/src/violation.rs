//! The reasons for which a property does not hold.

/// A property that does not hold, or that could not be compared.
#[derive(Debug, thiserror::Error)]
pub enum Violation {
    /// A value is too far from what the property demands.
    #[error("{property}: {place}: {found}, expected {expected} within {bound:e}")]
    Differs {
        /// Name of the property.
        property: &'static str,
        /// Texel or face, and channel.
        place: String,
        /// Value of the solver.
        found: f64,
        /// Value that the property demands.
        expected: f64,
        /// Largest difference allowed.
        bound: f64,
    },
    /// The solver returned another number of values than the mesh has texels.
    #[error("the solver returned {values} values for {texels} texels")]
    Length {
        /// Number of texels.
        texels: usize,
        /// Number of values.
        values: usize,
    },
    /// The solver returned a value that is negative or not finite.
    #[error("the solver returned {value} for {place}")]
    Value {
        /// Texel and channel.
        place: String,
        /// The value.
        value: f32,
    },
    /// The solver returned 0 for all texels, although faces emit light.
    #[error("the solver returned 0 for all texels, although faces emit light")]
    Dark,
    /// A face has a texture, so that its emission cannot be changed.
    #[error("{0} has a texture: its emission cannot be changed")]
    Painted(String),
    /// Nothing was compared.
    #[error("{property}: nothing is compared: {reason}")]
    Nothing {
        /// Name of the property.
        property: &'static str,
        /// Why the scene or the tolerance does not suit the property.
        reason: String,
    },
    /// The scene cannot be meshed.
    #[error("the scene cannot be meshed: {0}")]
    Mesh(#[from] common::Error),
}

impl Violation {
    /// Makes [`Violation::Nothing`].
    pub(crate) fn nothing(property: &'static str, reason: impl Into<String>) -> Self {
        let reason = reason.into();
        Self::Nothing { property, reason }
    }
}
