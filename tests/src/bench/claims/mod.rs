//! What A. Shcherbakov and V. Frolov say of their method (Light & Engineering 27(2), 2019), and what is measured of it here.
//!
//! The method as published: patches are the sides of voxels, the matrix is the sum of three bounces, rows and columns are in greedy
//! order, the largest entries stand apart and the others are a BC1 texture of logarithms. A [`Case`] is made of the first two;
//! the order is found here. Form factors and transfer are ours, and K stands for their sum (`docs/theory.md`): it holds the same light,
//! and a product with it costs the same.

pub mod page;

use std::path::Path;

use dxt_pack::{Outliers, Params};
use permute::{Order, order, random_order};
use probes::{probe_lights, sent_light};
use radfile::{Container, FormFactors, Operator, Patches, Permutation, Quiet, Record};
use rayon::prelude::*;
use scene::Scene;
use serde::Serialize;

use super::{
    Product,
    case::{Case, Error},
    classical::Classical,
    clock,
    judge::Judge,
    orders,
    packed::Textures,
    planes::Planes,
    record,
};

/// Bounces that one product stands for; the first are those of the paper's matrix.
const SERIES: [u32; 2] = [3, 8];
/// Entries apart in the authors' program: the n/15 largest of each row; and the share that `dxt-pack` takes.
const APART: [f64; 2] = [1.0 / 15.0, 0.01];
/// The paper's figures, which are all "up to": speed, memory, error of the texture.
const FASTER: f64 = 10.0;
const SMALLER: f64 = 3.0;
const BETTER: f64 = 5.0;
/// A figure this near to the claimed one is the same.
const SAME: f64 = 0.9;
/// Answers of two ways to compute the same light may differ by so much.
const ANSWERS: f64 = 1e-4;
/// Lights of the share that three bounces hold, and their seed.
const LIGHTS: (u32, u64) = (20, 2000);

/// A claim, held against one scene.
#[derive(Clone, Debug, Serialize)]
pub struct Claim {
    pub kind: Kind,
    pub scene: String,
    /// Patches.
    pub n: usize,
    /// What is compared.
    pub what: String,
    /// Without the method, or without this part of it, and with it.
    pub before: f64,
    pub after: f64,
    pub unit: &'static str,
    /// How many times better the paper has it, and how many times it is here.
    pub claimed: f64,
    pub measured: f64,
    pub holds: bool,
}

/// What a claim is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    Speed,
    Memory,
    Order,
    Bounces,
}

/// One scene and its claims.
pub struct Found {
    pub scene: String,
    pub n: usize,
    /// Largest part of the light that late bounces pass on.
    pub spectral_radius: f64,
    pub claims: Vec<Claim>,
}

/// Holds all claims against what `formfactor` wrote of a scene whose patches are sides of voxels.
///
/// # Errors
///
/// If a part is missing or cannot be packed, or if two products that should agree do not.
pub fn run(scene: &str, path: &Path) -> Result<Found, Error> {
    let container = Container::open(path)?;
    let (patches, factors) = (Patches::read(&container)?, FormFactors::read(&container)?);
    let sum = |params: &series::Params| series::all_bounces(&patches, &factors, params, &Quiet);
    let [few, more] =
        [sum(&series::Params::first_bounces(SERIES[0]))?.0, sum(&series::Params::first_bounces(SERIES[1]))?.0];
    let (all, report) = sum(&series::Params::default())?;
    let (greedy, _) = order(&patches, Some(&few), &permute::Params { order: Order::Greedy })?;
    let factors = FormFactors { values: factors.values.to_vec().into(), sky: factors.sky.to_vec().into() };
    let mesh = Scene::read(&container)?;
    let case = Case { scene: scene.to_owned(), operator: few, factors, mesh, patches };
    let mut ground = Ground { case: &case, more: &more, all: &all, greedy, claims: vec![] };
    ground.speed()?;
    ground.memory()?;
    ground.order()?;
    ground.bounces();
    let spectral_radius = report.channel.iter().map(|c| c.spectral_radius).fold(0.0, f64::max);
    Ok(Found { scene: case.scene.clone(), n: case.len(), spectral_radius, claims: ground.claims })
}

/// What the claims are held against.
struct Ground<'a> {
    /// With K of the fewest bounces of [`SERIES`], patches as they came.
    case: &'a Case,
    /// K of the most bounces of [`SERIES`], and of all.
    more: &'a Operator<'a>,
    all: &'a Operator<'a>,
    greedy: Permutation,
    claims: Vec<Claim>,
}

impl Ground<'_> {
    fn add(&mut self, kind: Kind, what: String, [before, after]: [f64; 2], unit: &'static str, claimed: f64) {
        let measured = gain(kind, [before, after]);
        let (scene, n, holds) = (self.case.scene.clone(), self.case.len(), holds(measured, claimed));
        self.claims.push(Claim { kind, scene, n, what, before, after, unit, claimed, measured, holds });
    }

    /// One product with the matrix of k bounces instead of k products.
    fn speed(&mut self) -> Result<(), Error> {
        let (case, x) = (self.case, Judge::new(self.case).a_lamp());
        let one_bounce = in_colour(&hmatrix::one_bounce(&case.factors, &case.patches)?, case.operator.channels);
        let mut dense = [Planes::single(&case.operator), Planes::single(self.more)];
        let mut apart = SERIES.map(|bounces| BounceByBounce::new(&one_bounce, &case.patches, bounces));
        let mut shared = SERIES.map(|bounces| Classical::with(case, bounces));
        let mut packed = Textures::pack_in(self.greedy.clone(), case, &paper(APART[1], 20))?;
        for k in 0..SERIES.len() {
            let answer = product(&mut dense[k], &x);
            for other in [product(&mut apart[k], &x), product(&mut shared[k], &x)] {
                let error = difference(&answer, &other);
                if error > ANSWERS {
                    return Err(format!("{} bounces: products differ by {error:e}", SERIES[k]).into());
                }
            }
        }
        let [few, _] = &mut dense;
        let mut products: Vec<&mut (dyn Product + Send)> = vec![few, &mut packed];
        products.extend(apart.iter_mut().map(|p| p as &mut (dyn Product + Send)));
        products.extend(shared.iter_mut().map(|p| p as &mut (dyn Product + Send)));
        let ms: Vec<f64> = clock::race(&mut products, &x).into_iter().map(|[one, _]| one).collect();
        let (dense, packed, ways) = (ms[0], ms[1], ["a matrix a colour", "one matrix for all colours"]);
        for (way, ms) in ways.iter().zip(ms[2..].chunks_exact(SERIES.len())) {
            for (bounces, ms) in SERIES.into_iter().zip(ms) {
                let classical = format!("{bounces} products with form factors, {way}");
                let claimed = f64::from(bounces);
                self.add(Kind::Speed, format!("{classical} → one with K, f32"), [*ms, dense], "ms", claimed);
                let texture = format!("{classical} → one with the texture, {} % apart", digits(100.0 * APART[1]));
                self.add(Kind::Speed, texture, [*ms, packed], "ms", FASTER);
            }
        }
        Ok(())
    }

    /// Bytes an element of the matrix.
    fn memory(&mut self) -> Result<(), Error> {
        let ordered = self.case.reordered(&self.greedy);
        for share in APART {
            let (_, report) = dxt_pack::pack(&ordered.operator, &ordered.patches, &paper(share, 0), &Quiet)?;
            let texture = report.texture_bytes as f64 / (self.case.len() as f64).powi(2);
            let colours = self.case.operator.channels as f64;
            let list = |bytes: usize| texture + share * colours * bytes as f64;
            let apart = format!("{} % apart", digits(100.0 * share));
            for (kept, bytes) in [
                ("ours: one index for three f32", report.bytes_per_entry),
                ("theirs: u32 and f32 a colour", list(size_of::<u32>() + size_of::<f32>())),
                ("theirs: u16 and f16 a colour", list(size_of::<u16>() + size_of::<half::f16>())),
            ] {
                for (matrix, dense) in [
                    ("form factors, f32", size_of::<f32>() as f64),
                    ("form factors, f16", size_of::<half::f16>() as f64),
                    ("K in colour, f32", colours * size_of::<f32>() as f64),
                ] {
                    let what = format!("{matrix} → texture, {apart} ({kept})");
                    self.add(Kind::Memory, what, [dense, bytes], "B an element", SMALLER);
                }
            }
        }
        Ok(())
    }

    /// Error of the texture before and after reordering.
    fn order(&mut self) -> Result<(), Error> {
        let n = self.case.len();
        let curve = order(&self.case.patches, None, &permute::Params { order: Order::NormalHilbert })?.0;
        let orders = [
            ("scene", Permutation::identity(n)),
            ("random", random_order(n)),
            ("greedy", self.greedy.clone()),
            ("curve", curve),
        ];
        for share in APART {
            let mut found = Vec::new();
            for (_, order) in &orders {
                let [matrix, light, _, code] = orders::errors(&self.case.reordered(order), &paper(share, 20))?;
                found.push([code, matrix, light]);
            }
            for (before, after) in [(0, 2), (1, 2), (0, 3)] {
                for (k, of) in ["of the codes (logarithm)", "of the entries", "of irradiance"].into_iter().enumerate() {
                    let [before_name, after_name] = [before, after].map(|at| orders[at].0);
                    let what = format!("{before_name} → {after_name}, RMS {of}, {} % apart", digits(100.0 * share));
                    let errors = [before, after].map(|at: usize| 100.0 * found[at][k]);
                    self.add(Kind::Order, what, errors, "%", BETTER);
                }
            }
        }
        Ok(())
    }

    /// What a few bounces hold of all.
    fn bounces(&mut self) {
        let (lights, seed) = LIGHTS;
        let lights = probe_lights(&self.case.patches, lights, seed);
        let [all, few, more] = [self.all, &self.case.operator, self.more].map(|k| flux(k, &self.case.patches, &lights));
        for (bounces, held) in SERIES.into_iter().zip([few, more]) {
            let percent = [100.0, 100.0 * held / all];
            let note = if bounces == SERIES[0] { "" } else { " (not claimed, for comparison)" };
            self.add(
                Kind::Bounces,
                format!("indirect light of all bounces → of the first {bounces}{note}"),
                percent,
                "%",
                1.0,
            );
        }
    }
}

/// How many times better it is with the method; of bounces the share that is left.
fn gain(kind: Kind, [before, after]: [f64; 2]) -> f64 {
    if kind == Kind::Bounces { after / before } else { before / after }
}

fn holds(measured: f64, claimed: f64) -> bool {
    measured >= SAME * claimed
}

/// The paper's format with so many entries apart.
fn paper(share: f64, probes: u32) -> Params {
    Params { outliers: Outliers::Share(share), probes, ..Params::PAPER }
}

/// An operator without colour, once for each.
fn in_colour(operator: &Operator, channels: usize) -> Operator<'static> {
    let values = operator.channel(0).repeat(channels);
    Operator { n: operator.n, channels, bounces: operator.bounces, values: values.into() }
}

/// Radiosity bounce by bounce as the paper has it: F times colour, a matrix for each, here its symmetric form.
struct BounceByBounce<'a> {
    one: Planes<'a, f32>,
    reflectance: &'a [[f32; 3]],
    bounces: u32,
    sent: Vec<[f32; 3]>,
}

impl<'a> BounceByBounce<'a> {
    fn new(one: &'a Operator, patches: &'a Patches, bounces: u32) -> BounceByBounce<'a> {
        let (reflectance, sent) = (&patches.reflectance, vec![[0.0; 3]; patches.len()]);
        BounceByBounce { one: Planes::single(one), reflectance, bounces, sent }
    }
}

impl Product for BounceByBounce<'_> {
    /// y ← W (x + ρ y).
    fn multiply(&mut self, x: &[[f32; 3]], y: &mut [[f32; 3]]) {
        y.fill([0.0; 3]);
        for _ in 0..self.bounces {
            for (i, sent) in self.sent.iter_mut().enumerate() {
                *sent = std::array::from_fn(|c| x[i][c] + self.reflectance[i][c] * y[i][c]);
            }
            self.one.multiply(&self.sent, y);
        }
    }
}

fn product(of: &mut dyn Product, x: &[[f32; 3]]) -> Vec<[f32; 3]> {
    let mut y = vec![[0.0; 3]; x.len()];
    of.multiply(x, &mut y);
    y
}

/// L2 norm of the difference over that of `a`.
fn difference(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    let pairs = || a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| [a, b].map(|v| f64::from(*v)));
    let squares = pairs().map(|[a, b]| (a - b).powi(2)).sum::<f64>();
    (squares / pairs().map(|[a, _]| a * a).sum::<f64>()).sqrt()
}

/// Indirect flux of all patches, lights and colours together: Σ √A K √A ρ H⁰.
fn flux(operator: &Operator, patches: &Patches, lights: &[Vec<f32>]) -> f64 {
    let of_channel = |channel: usize| -> f64 {
        let sent: Vec<f64> =
            sent_light(patches, lights, channel).chunks_exact(lights.len()).map(|s| s.iter().sum()).collect();
        let rows = operator.channel(channel).par_chunks(operator.n).zip(&patches.area);
        let row = |(row, area): (&[f32], &f32)| {
            f64::from(*area).sqrt() * row.iter().zip(&sent).map(|(k, sent)| f64::from(*k) * sent).sum::<f64>()
        };
        rows.map(row).collect::<Vec<_>>().iter().sum()
    };
    (0..operator.channels).map(of_channel).sum()
}

/// Two significant digits, for people.
fn digits(value: f64) -> f64 {
    record::digits(value, 2)
}

#[cfg(test)]
mod tests {
    use super::{Kind, gain, holds};

    #[test]
    fn less_is_better_but_for_the_light_of_bounces() {
        for kind in [Kind::Speed, Kind::Memory, Kind::Order] {
            assert_eq!(gain(kind, [12.0, 4.0]), 3.0);
        }
        assert_eq!(gain(Kind::Bounces, [100.0, 80.0]), 0.8);
    }

    #[test]
    fn a_claim_may_fall_short_by_a_tenth() {
        assert!(holds(2.71, 3.0) && holds(4.0, 3.0) && !holds(2.69, 3.0) && !holds(f64::NAN, 3.0));
    }
}
