//! The page that says which claims hold.

use std::fmt::Write;

use super::{Claim, Found, Kind};
use crate::bench::{contest::Stamp, record::digits};

/// A part of the page: what is claimed, and what stands in the way or helps.
struct Section {
    kind: Kind,
    title: &'static str,
    claim: &'static str,
    why: &'static str,
}

const SECTIONS: [Section; 4] = [
    Section {
        kind: Kind::Speed,
        title: "One product instead of several",
        claim: "One product with the matrix of k bounces takes the place of k products with form factors: k times faster, and up to 10 \
                times faster than the classical method with the texture.",
        why: "Milliseconds of a frame's product in three colours on one thread, medians of turns taken side by side; answers agree (f32) or \
              are off by the error of the texture. With a matrix for each colour on both sides, as the paper counts, the gain is that of \
              the reads saved. But form factors have no colour, so that classical radiosity reads one matrix for three colours where K \
              needs three, and that takes much of the gain away. The texture is decoded here by the processor, which costs more \
              than reading what it saves; a texture unit decodes for nothing, which is not measured here.",
    },
    Section {
        kind: Kind::Memory,
        title: "Bytes",
        claim: "The texture with its list takes up to 3 times less memory than the classical method's matrix.",
        why: "Bytes an element of the n × n matrix, all colours together. The list takes more than the texture where 1/15 of the entries is \
              apart, as in the authors' program, and how its entries are stored decides. K in colour is what the texture replaces, \
              but the classical method keeps form factors, which have no colour and may be stored in half precision, too.",
    },
    Section {
        kind: Kind::Order,
        title: "Order of rows and columns",
        claim: "Reordering makes the error of the texture up to 5 times smaller.",
        why: "Scene is the order in which the sides of voxels are made, plane after plane, random is the yardstick \
              that large gains are found against. Curve is `normal-hilbert`. The error of irradiance (L2 under probe lights) is what is \
              seen. Not every scene gains alike: what an order can save is what neighbours do not have in common without it.",
    },
    Section {
        kind: Kind::Bounces,
        title: "Three bounces for all",
        claim: "The sum of the first three bounces stands for all of them.",
        why: "Indirect flux of all patches under 20 probe lights. What is left out fades by the spectral radius from bounce to bounce; the \
              solution of all bounces costs a frame no more.",
    },
];

/// `docs/charts/claims.md`.
pub fn text(found: &[Found], stamp: &Stamp) -> String {
    let mut page = String::from(
        "# The published method: what is claimed, what is measured\n\n\
         The method of A. Shcherbakov and V. Frolov (Light & Engineering 27(2), 2019) made of our stages: sides of voxels, three bounces, greedy \
         order, BC1 with the largest entries apart. `make claims` measures it and writes this page. A cell has the figure without and with \
         the method, and how many times better that is (of bounces: the share). A claim counts as held where it is reached but for a \
         tenth. The paper says \"up to\" and has other scenes and processors: a row that falls short says that this is not to be \
         expected here, not that it was not measured there.\n\n",
    );
    writeln!(page, "Measured on {}, {}, commit {}.\n", stamp.machine, stamp.date, stamp.commit).expect("a string");
    for scene in found {
        let (name, n, radius) = (&scene.scene, scene.n, digits(scene.spectral_radius, 3));
        writeln!(page, "- {name}: {n} patches, spectral radius {radius}").expect("a string");
    }
    for section in &SECTIONS {
        write!(page, "\n## {}\n\n{}\n\n", section.title, section.claim).expect("a string");
        page += &table(found, section.kind);
        writeln!(page, "\n{}", section.why).expect("a string");
    }
    page + "\n[numbers](claims.csv)\n"
}

/// A row a comparison, a column a scene.
fn table(found: &[Found], kind: Kind) -> String {
    let scenes = || found.iter().map(|f| f.claims.iter().filter(|c| c.kind == kind).collect::<Vec<_>>());
    let Some(first) = scenes().next() else { return String::new() };
    let mut table = format!("| {} | claimed |", first.first().map_or("", |c| c.unit));
    found.iter().for_each(|f| write!(table, " {} {} |", f.scene, f.n).expect("a string"));
    table += " holds |\n|---|--:|";
    table += &"--:|".repeat(found.len());
    table += "---|\n";
    for (row, claim) in first.iter().enumerate() {
        let cells: Vec<&Claim> = scenes().map(|claims| claims[row]).collect();
        write!(table, "| {} | {}× |", claim.what, digits(claim.claimed, 3)).expect("a string");
        for c in &cells {
            let [before, after, measured] = [c.before, c.after, c.measured].map(|v| digits(v, 3));
            write!(table, " {before} → {after}: {measured}× |").expect("a string");
        }
        writeln!(table, " {} |", verdict(&cells)).expect("a string");
    }
    table
}

fn verdict(cells: &[&Claim]) -> String {
    match cells.iter().filter(|c| c.holds).count() {
        0 => "**no**".into(),
        all if all == cells.len() => "yes".into(),
        some => format!("in {some} of {}", cells.len()),
    }
}

#[cfg(test)]
mod tests {
    use super::{Claim, Kind, verdict};

    fn claim(holds: bool) -> Claim {
        let (scene, what) = (String::new(), String::new());
        Claim {
            kind: Kind::Speed,
            scene,
            n: 1,
            what,
            before: 1.0,
            after: 1.0,
            unit: "ms",
            claimed: 1.0,
            measured: 1.0,
            holds,
        }
    }

    #[test]
    fn a_verdict_counts_the_scenes_in_which_a_claim_holds() {
        let (yes, no) = (claim(true), claim(false));
        assert_eq!(verdict(&[&yes, &yes]), "yes");
        assert_eq!(verdict(&[&no, &no]), "**no**");
        assert_eq!(verdict(&[&no, &yes, &no]), "in 1 of 3");
    }
}
