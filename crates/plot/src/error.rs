//! Why a chart was not drawn.

/// Errors of this crate.
#[derive(Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Nothing to draw.
    #[error("the chart \"{title}\" has no finite point inside its axes; give it data, or wider axes")]
    Empty {
        /// Title of the chart.
        title: String,
    },
    /// An axis from nowhere to nowhere.
    #[error("the axis \"{label}\" goes from {from} to {to}, expected a rising range{of}; choose another range")]
    Range {
        /// Label of the axis.
        label: String,
        /// Its first value.
        from: f64,
        /// Its last value.
        to: f64,
        /// What a logarithm asks for besides.
        of: &'static str,
    },
    /// The drawing library failed.
    #[error("the chart \"{title}\" could not be painted: {reason}")]
    Painting {
        /// Title of the chart.
        title: String,
        /// What the library says.
        reason: String,
    },
}
