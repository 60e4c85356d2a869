//! Why an operator was not packed or read.

/// Result of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Why an operator was not packed or read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An option has a value that makes no sense.
    #[error("option {option} is {found}, expected {expected}")]
    Option {
        /// Name of the option.
        option: &'static str,
        /// Its value.
        found: String,
        /// What it may be.
        expected: &'static str,
    },
    /// There is nothing to pack.
    #[error("the operator has no patches; nothing can be packed (is the scene empty?)")]
    Empty,
    /// The operator is no square matrix a channel.
    #[error("the operator has {values} values, expected {channels} × {n} × {n} with 1 or 3 channels; solve it again")]
    Shape {
        /// Values there are.
        values: usize,
        /// Channels it says it has.
        channels: usize,
        /// Patches it says it has.
        n: usize,
    },
    /// One bounce has no colour.
    #[error("the operator of one bounce has 3 channels, expected 1; take it from the form factors")]
    Coloured,
    /// Operator and patches belong to different bakes.
    #[error("the operator has {operator} patches, the patch list {patches}; take both from the same bake")]
    PatchCount {
        /// Patches of the operator.
        operator: usize,
        /// Patches in the list.
        patches: usize,
    },
    /// Nobody sends.
    #[error("there are no senders; no rows can be packed (is the scene empty?)")]
    NoSenders,
    /// What is known of senders disagrees.
    #[error(
        "positions, normals, areas and reflectances of senders are {counts:?}, expected as many of each; take all from one bake"
    )]
    SenderCount {
        /// How many there are of each.
        counts: [usize; 4],
    },
    /// Nobody receives.
    #[error("there are no receivers; no rows can be packed (does the mesh have faces?)")]
    NoReceivers,
    /// Receivers and what is known of them disagree.
    #[error("there are {positions} positions of receivers, {normals} normals and {rows} rows; take all from one bake")]
    ReceiverCount {
        /// Positions.
        positions: usize,
        /// Normals.
        normals: usize,
        /// Rows.
        rows: usize,
    },
    /// A weight of a receiver is negative or no number.
    #[error("receiver {receiver} has weight {value} of sender {sender}, expected 0 to 1; gather the receivers again")]
    Weight {
        /// Row.
        receiver: usize,
        /// Column.
        sender: usize,
        /// The weight.
        value: f32,
    },
    /// A receiver would get more light than there is.
    #[error("the weights of receiver {receiver} sum to {sum}, expected at most 1; gather the receivers again")]
    RowSum {
        /// Row.
        receiver: usize,
        /// Sum of its weights.
        sum: f64,
    },
    /// A row names a sender that there is not.
    #[error(
        "receiver {receiver} has a weight of sender {sender}, there are {senders}; take rows and senders from one bake"
    )]
    Sender {
        /// Row.
        receiver: usize,
        /// Column.
        sender: usize,
        /// Number of senders.
        senders: usize,
    },
    /// The packed operator and what is said of it disagree.
    #[error("the stream is of {found}, its certificate of {expected}; pack the operator again")]
    Certificate {
        /// Patches and channels of the stream.
        found: String,
        /// Those of the certificate.
        expected: String,
    },
    /// A section is missing or broken, or a container was not written.
    #[error(transparent)]
    Container(#[from] radfile::Error),
    /// Packed bytes end too early.
    #[error("the packed operator ends within {what} at byte {at}; it is cut off, pack it again")]
    Short {
        /// What was being read.
        what: &'static str,
        /// Where it ends.
        at: usize,
    },
    /// Packed bytes break a rule.
    #[error(
        "the packed operator has {found} as {what} at byte {at}, expected {expected}; it is damaged, pack it again"
    )]
    Damaged {
        /// What was being read.
        what: &'static str,
        /// Its value.
        found: String,
        /// What it may be.
        expected: &'static str,
        /// Where it stands.
        at: usize,
    },
}
