//! What the bytes of the file are, and what dense matrices would take.

use plot::{Bar, Content, Panel, Sheet};
use serde::Serialize;

use super::{Plot, subject::Subject};
use crate::memory;

const NAME: &str = "sizes";

#[derive(Serialize)]
struct Numbers {
    /// Of the file.
    bytes: u64,
    /// They add up to that.
    parts: Vec<Part>,
    /// n² numbers in f32.
    dense_form_factors: u64,
    /// As many for each channel.
    dense_operator: u64,
}

#[derive(Serialize)]
struct Part {
    part: &'static str,
    bytes: u64,
}

/// What sections belong to, by how their names start; the first that fits counts.
const PARTS: [(&str, &[&str]); 6] = [
    ("packed operator", &["hmatrix.", "pack."]),
    ("dense form factors, kept", &["formfactor.values"]),
    ("dense operator K, kept", &["series."]),
    ("receivers, their rows and elements", &["transfer.", "lightmap.", "volume.", "elements."]),
    ("patches", &["patches.", "formfactor.sky", "permute."]),
    ("scene", &["mesh.", "materials.", "scene."]),
];
/// Sections of nobody above, and what is between sections.
const REST: &str = "everything else";

pub fn draw(subject: &Subject) -> anyhow::Result<Plot> {
    let container = subject.container;
    let bytes = container.as_bytes().len() as u64;
    let mut parts: Vec<Part> = PARTS.iter().map(|(part, _)| Part { part, bytes: 0 }).collect();
    for section in container.sections() {
        let owner = PARTS.iter().position(|(_, starts)| starts.iter().any(|start| section.name.starts_with(start)));
        if let Some(owner) = owner {
            parts[owner].bytes += section.length;
        }
    }
    let known: u64 = parts.iter().map(|part| part.bytes).sum();
    parts.push(Part { part: REST, bytes: bytes - known });
    parts.retain(|part| part.bytes > 0);
    let (n, channels) = (subject.patches.len() as u64, channels(subject));
    let dense = 4 * n * n;
    let numbers = Numbers { bytes, parts, dense_form_factors: dense, dense_operator: channels * dense };
    let bar = |name: &str, bytes: u64, beside: bool| Bar {
        name: name.into(),
        length: bytes as f64,
        number: memory::size(bytes),
        beside,
    };
    let mut bars = vec![
        bar("for comparison: form factors in f32", numbers.dense_form_factors, true),
        bar(&format!("for comparison: K in f32, {channels} channel(s)"), numbers.dense_operator, true),
    ];
    bars.extend(numbers.parts.iter().map(|part| bar(part.part, part.bytes, false)));
    let whole = memory::size(bytes);
    let sheet = Sheet {
        title: "Sizes".into(),
        subtitle: format!("{n} patches; the blue bars add up to the file, {whole}."),
        panels: vec![Panel { title: String::new(), content: Content::Bars(bars) }],
    };
    let packed = subject.packed.as_ref().map(|packed| packed.size_in_bytes() as f64);
    let smaller = packed.map_or(String::new(), |packed| {
        format!("; the packed operator is {:.0} times smaller than form factors in f32", dense as f64 / packed)
    });
    Plot::new(NAME, sheet, &numbers, format!("What the {whole} of the file are{smaller}."))
}

/// Of the operator: the dense one's, or the packed one's, or 3.
fn channels(subject: &Subject) -> u64 {
    match (&subject.operator, &subject.packed) {
        (Some(k), _) => k.channels as u64,
        (None, Some(relight::Operator::Hierarchical(_, certificate))) => certificate.channels.into(),
        (None, Some(relight::Operator::Textures(product))) => product.packed().packing.channels.into(),
        (None, None) => 3,
    }
}
