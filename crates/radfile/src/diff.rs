//! The numeric difference of two containers, section by section.
//!
//! Two bakes of the same scene differ in the last bits for good reasons (another compiler, a changed order of
//! sums), so comparing bytes says too little. Floating-point sections are judged by two numbers, the largest
//! difference and the root mean square; everything else (indices, blocks, metadata) must be equal.
//! Provenance is shown but not judged: it says how a file was made, not what it holds.

use serde::Serialize;

use crate::{Container, ElementType, Provenance, Section};

/// How far floating-point sections may differ; both limits hold at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Largest absolute difference of one element, in the section's unit; infinite for no limit.
    pub abs: f64,
    /// Largest root mean square of the differences, relative to the root mean square of the first file's
    /// section; infinite for no limit.
    pub rms: f64,
}

impl Tolerance {
    /// Every element is equal.
    pub const EXACT: Tolerance = Tolerance { abs: 0.0, rms: 0.0 };

    /// The limits that are given; without any, every element has to be equal.
    pub fn new(abs: Option<f64>, rms: Option<f64>) -> Tolerance {
        match (abs, rms) {
            (None, None) => Tolerance::EXACT,
            _ => Tolerance { abs: abs.unwrap_or(f64::INFINITY), rms: rms.unwrap_or(f64::INFINITY) },
        }
    }
}

/// What became of one section.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Byte for byte.
    Same,
    /// Floating-point numbers within the tolerance.
    Within,
    /// Floating-point numbers beyond the tolerance, or other contents that are not equal.
    Beyond,
    /// Another element type, shape or flags.
    Shape,
    /// Only in the first file.
    Missing,
    /// Only in the second file.
    Extra,
    /// Provenance that is not equal, which counts for nothing.
    Unjudged,
}

/// Comparison of one section.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SectionDiff {
    /// Its name.
    pub name: String,
    /// The outcome.
    pub verdict: Verdict,
    /// Element type and shape in the first file.
    pub a: Option<String>,
    /// Element type and shape in the second file.
    pub b: Option<String>,
    /// Elements that are not equal.
    pub differing: u64,
    /// Index of the largest difference; of the first one where elements are no floating-point numbers.
    pub index: Option<Vec<u64>>,
    /// Largest absolute difference, in the section's unit; infinite where one of the two is no number.
    pub largest: f64,
    /// Root mean square of the differences over that of the first file; infinite if only the latter is zero.
    pub relative_rms: f64,
}

/// Comparison of two containers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Sections of the first file in its order, then those that only the second has.
    pub sections: Vec<SectionDiff>,
    /// Whether no section is missing, extra, misshapen or beyond the tolerance.
    pub equal: bool,
}

/// Compares two containers.
pub fn diff(a: &Container, b: &Container, tolerance: Tolerance) -> Report {
    let mut sections: Vec<SectionDiff> = a
        .sections()
        .iter()
        .map(|left| match b.sections().iter().find(|right| right.name == left.name) {
            Some(right) => compare(a, b, left, right, tolerance),
            None => SectionDiff { a: Some(left.describe()), ..outcome(&left.name, Verdict::Missing) },
        })
        .collect();
    let extra = b.sections().iter().filter(|right| !a.has(&right.name));
    sections.extend(extra.map(|s| SectionDiff { b: Some(s.describe()), ..outcome(&s.name, Verdict::Extra) }));
    let passes = |s: &SectionDiff| matches!(s.verdict, Verdict::Same | Verdict::Within | Verdict::Unjudged);
    Report { equal: sections.iter().all(passes), sections }
}

fn outcome(name: &str, verdict: Verdict) -> SectionDiff {
    SectionDiff {
        name: name.into(),
        verdict,
        a: None,
        b: None,
        differing: 0,
        index: None,
        largest: 0.0,
        relative_rms: 0.0,
    }
}

fn compare(a: &Container, b: &Container, left: &Section, right: &Section, tolerance: Tolerance) -> SectionDiff {
    let (x, y) = (a.data(left), b.data(right));
    let verdict =
        |verdict| SectionDiff { a: Some(left.describe()), b: Some(right.describe()), ..outcome(&left.name, verdict) };
    let alike = left.element == right.element && left.flags == right.flags;
    // Metadata has its own length; two encodings are unequal, not misshapen.
    if !alike || (left.shape != right.shape && left.element != ElementType::Meta) {
        return verdict(if left.name == Provenance::SECTION { Verdict::Unjudged } else { Verdict::Shape });
    }
    if x == y {
        return verdict(Verdict::Same);
    }
    let found = match left.element {
        ElementType::F32 => measure(numbers::<f32>(x, y).map(|(p, q)| (f64::from(p), f64::from(q)))),
        ElementType::F64 => measure(numbers::<f64>(x, y)),
        other => count_unequal(x, y, other.size() as usize),
    };
    let is_number = matches!(left.element, ElementType::F32 | ElementType::F64);
    let fits = is_number && found.largest <= tolerance.abs && found.relative_rms <= tolerance.rms;
    let outcome = match (left.name == Provenance::SECTION, fits) {
        (true, _) => Verdict::Unjudged,
        (false, true) => Verdict::Within,
        (false, false) => Verdict::Beyond,
    };
    SectionDiff {
        differing: found.differing,
        index: found.at.map(|at| index_of(at, &left.shape)),
        largest: found.largest,
        relative_rms: found.relative_rms,
        ..verdict(outcome)
    }
}

fn numbers<'a, T: bytemuck::Pod>(x: &'a [u8], y: &'a [u8]) -> impl Iterator<Item = (T, T)> + 'a {
    bytemuck::cast_slice::<u8, T>(x).iter().copied().zip(bytemuck::cast_slice(y).iter().copied())
}

#[derive(Default)]
struct Found {
    differing: u64,
    at: Option<usize>,
    largest: f64,
    relative_rms: f64,
}

fn measure(pairs: impl Iterator<Item = (f64, f64)>) -> Found {
    let mut found = Found::default();
    let (mut squares, mut reference) = (0.0, 0.0);
    for (at, (p, q)) in pairs.enumerate() {
        let equal = p == q || (p.is_nan() && q.is_nan());
        let difference = match (p - q).abs() {
            _ if equal => 0.0,
            d if d.is_nan() => f64::INFINITY,
            d => d,
        };
        found.differing += u64::from(!equal);
        if difference > found.largest {
            (found.largest, found.at) = (difference, Some(at));
        }
        squares += difference * difference;
        reference += if p.is_finite() { p * p } else { 0.0 };
    }
    found.relative_rms = if squares == 0.0 { 0.0 } else { (squares / reference).sqrt() };
    found
}

/// Elements of `size` bytes; metadata may differ in length.
fn count_unequal(x: &[u8], y: &[u8], size: usize) -> Found {
    let (p, q) = (x.chunks(size), y.chunks(size));
    let longer = p.len().abs_diff(q.len());
    let shorter = p.len().min(q.len());
    let mut unequal = p.zip(q).enumerate().filter(|(_, (p, q))| p != q).map(|(at, _)| at);
    let first = unequal.next();
    Found {
        differing: (usize::from(first.is_some()) + unequal.count() + longer) as u64,
        at: Some(first.unwrap_or(shorter)),
        ..Found::default()
    }
}

/// Row-major position to one index a dimension.
fn index_of(at: usize, shape: &[u64]) -> Vec<u64> {
    let mut rest = at as u64;
    let mut index: Vec<u64> = shape
        .iter()
        .skip(1)
        .rev()
        .map(|&extent| {
            let i = rest % extent;
            rest /= extent;
            i
        })
        .collect();
    if !shape.is_empty() {
        index.push(rest);
    }
    index.reverse();
    index
}
