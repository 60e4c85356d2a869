//! The orders that there are.

use std::str::FromStr;

use radfile::{Operator, Patches, Permutation};

use crate::{Error, Report, curve, direction, greedy, neighbours};

/// How patches are ordered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Order {
    /// By the direction they face (26 classes), then along Hilbert's curve: milliseconds, and nearly as good as
    /// `Greedy`, because patches that face alike and lie close see alike.
    #[default]
    NormalHilbert,
    /// Along Hilbert's curve through space.
    Hilbert,
    /// Along Morton's curve through space.
    Morton,
    /// The paper's: start with the row of most light, go on to the most similar one that is left. O(n²).
    Greedy,
    /// As they are.
    None,
}

impl Order {
    /// All of them.
    pub const ALL: [Order; 5] = [Order::NormalHilbert, Order::Hilbert, Order::Morton, Order::Greedy, Order::None];

    /// The name, as it is typed.
    pub fn name(self) -> &'static str {
        match self {
            Order::NormalHilbert => "normal-hilbert",
            Order::Hilbert => "hilbert",
            Order::Morton => "morton",
            Order::Greedy => "greedy",
            Order::None => "none",
        }
    }
}

impl FromStr for Order {
    type Err = Error;

    fn from_str(name: &str) -> Result<Order, Error> {
        let found = Order::ALL.into_iter().find(|order| order.name() == name);
        found.ok_or_else(|| Error::UnknownOrder { found: name.into() })
    }
}

/// What to do.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Params {
    /// The order.
    pub order: Order,
}

/// Finds an order; entry `k` of the permutation is the present number of the patch that becomes number `k`.
///
/// | argument | used for |
/// |---|---|
/// | `patches` | positions and normals, `n` |
/// | `operator` | [`Order::Greedy`], and the report's neighbour differences; `n` × `n` |
///
/// Patches that an order cannot tell apart keep their present sequence. The same input gives the same order
/// for any number of threads. The report's zero tiles need form factors: [`crate::zero_tiles`].
///
/// # Errors
///
/// [`Error::NeedsOperator`] for `Greedy` without one; [`Error::Count`] if it is about other patches.
///
/// # Panics
///
/// If positions or normals are needed and are not one a patch: a bug in the caller, [`Patches::check`] tells.
///
/// # Example
///
/// ```
/// use permute::{Order, Params, order};
/// let patches = radfile::Patches {
///     position: vec![[0.0; 3], [9.0, 0.0, 0.0], [1.0, 0.0, 0.0]],
///     area: vec![1.0; 3],
///     ..Default::default()
/// };
/// let (found, report) = order(&patches, None, &Params { order: Order::Morton })?;
/// assert_eq!(found.new_to_old(), [0, 2, 1]);
/// assert_eq!(report.moved, 2);
/// # Ok::<(), permute::Error>(())
/// ```
pub fn order(patches: &Patches, operator: Option<&Operator>, params: &Params) -> Result<(Permutation, Report), Error> {
    let n = patches.len();
    if let Some(k) = operator.filter(|k| k.n != n) {
        return Err(Error::Count { operator: k.n, patches: n });
    }
    let new_to_old = match params.order {
        Order::None => (0..n as u32).collect(),
        Order::Greedy => greedy::nearest_neighbour(operator.ok_or(Error::NeedsOperator)?),
        Order::Morton => sorted_by(&keys(patches, curve::morton)),
        Order::Hilbert => sorted_by(&keys(patches, curve::hilbert)),
        Order::NormalHilbert => {
            assert_eq!(patches.normal.len(), n, "one normal a patch");
            let classes = patches.normal.iter().map(|&normal| direction::class(normal));
            sorted_by(&classes.zip(keys(patches, curve::hilbert)).collect::<Vec<_>>())
        }
    };
    let permutation = Permutation::new(new_to_old)?;
    let report = Report {
        order: params.order.name(),
        patches: n,
        moved: permutation.new_to_old().iter().zip(0..).filter(|&(&old, new)| old != new).count(),
        neighbour_difference: operator.map(|k| neighbours::compare(k, &permutation)),
        zero_tiles: None,
        dropped: vec![],
    };
    Ok((permutation, report))
}

fn keys(patches: &Patches, curve: fn([u32; 3]) -> u64) -> Vec<u64> {
    assert_eq!(patches.position.len(), patches.len(), "one position a patch");
    curve::cells(&patches.position).into_iter().map(curve).collect()
}

/// Indices in the order of their keys; equal keys stay as they are.
fn sorted_by<K: Ord>(keys: &[K]) -> Vec<u32> {
    let mut order: Vec<u32> = (0..keys.len() as u32).collect();
    order.sort_by(|&a, &b| keys[a as usize].cmp(&keys[b as usize]));
    order
}
