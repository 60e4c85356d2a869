//! How long a frame's bounces take on this machine: by the packed operator, and one after the other by dense form factors.

use std::{borrow::Cow, time::Instant};

use plot::{Bar, Content, Panel, Sheet};
use radfile::{Kernel, Patches};
use reference::rivals;
use serde::Serialize;

use super::{Plot, subject::Subject};
use crate::numbers;

const NAME: &str = "speeds";
/// Bounces of classical radiosity that are timed.
const BOUNCES: [u32; 3] = [1, 3, 8];
/// A time is the median of so many runs, or of more in so many seconds.
const RUNS: usize = 5;
const SECONDS: f64 = 0.3;
const MOST_RUNS: usize = 101;
/// The series of bounces ends where one brings less than this share of all before.
const LAST_BOUNCE: f64 = 1e-6;
const MOST_BOUNCES: u32 = 5000;
/// Disagreement of both answers that is no longer packing.
const SUSPICIOUS: f64 = 0.1;

#[derive(Serialize)]
struct Numbers {
    patches: usize,
    threads: usize,
    /// Median seconds of a frame's bounces by the packed operator.
    packed: f64,
    /// Median seconds of so many bounces by dense form factors in f32.
    dense: Vec<Bounces>,
    /// Whether the form factors were made up, as the container has none.
    made_up: bool,
    /// L2 over area between the light of both, bounce after bounce until no more comes, relative to the light.
    disagreement: Option<f64>,
}

#[derive(Serialize)]
struct Bounces {
    bounces: u32,
    seconds: f64,
}

pub fn draw(subject: &Subject) -> anyhow::Result<Plot> {
    let Some(packed) = &subject.packed else {
        return Ok(Plot::missing(NAME, "The container has no packed operator to time; run hmatrix or dxt-pack."));
    };
    let n = subject.patches.len();
    let mut frame = relight::Bounces::new(&subject.patches, packed);
    let even = vec![[1.0; 3]; n];
    let seconds = median(|| {
        frame.indirect(&even);
    });
    let factors: Cow<[f32]> = match &subject.factors {
        Some(factors) => Cow::Borrowed(&factors.values),
        None => {
            if let Err(reason) = subject.ask_memory(4 * (n as u64).pow(2)) {
                return Ok(Plot::missing(NAME, format!("{reason}.")));
            }
            // As even as those of a sphere, so that light stays finite.
            Cow::Owned(vec![1.0 / n as f32; n * n])
        }
    };
    let mut classical = Classical::new(&factors, &subject.patches);
    let timed = |bounces: u32| Bounces { bounces, seconds: median(|| classical.run(bounces)) };
    let dense: Vec<Bounces> = BOUNCES.into_iter().map(timed).collect();
    let disagreement = subject.factors.as_ref().map(|_| {
        classical.settle(packed.bounces());
        difference(&subject.patches, frame.indirect(&even), &classical.light)
    });
    if let Some(share) = disagreement.filter(|share| *share > SUSPICIOUS) {
        subject.session.warn(&format!(
            "the packed operator and the form factors disagree by {} of the light; pack it again from these form factors",
            numbers::percent(share)
        ));
    }
    let made_up = subject.factors.is_none();
    let threads = rayon::current_num_threads();
    let numbers = Numbers { patches: n, threads, packed: seconds, dense, made_up, disagreement };
    Plot::new(NAME, sheet(&numbers, packed), &numbers, sentence(&numbers))
}

fn sheet(numbers: &Numbers, packed: &relight::Operator) -> Sheet {
    let name = match packed {
        relight::Operator::Textures(_) => "all bounces: one product with textures",
        relight::Operator::Hierarchical(_, k) if k.kernel == Kernel::OneBounce => "all bounces: solve with packed W",
        relight::Operator::Hierarchical(..) => "all bounces: one product with blocks",
    };
    let bar = |name: String, seconds: f64, beside: bool| Bar { name, length: seconds, number: time(seconds), beside };
    let mut bars = vec![bar(name.into(), numbers.packed, false)];
    bars.extend(numbers.dense.iter().map(|Bounces { bounces, seconds }| {
        let several = if *bounces == 1 { "" } else { "s" };
        bar(format!("{bounces} bounce{several} by dense form factors in f32"), *seconds, true)
    }));
    let source = if numbers.made_up {
        "The form factors were dropped, so that made-up ones of the same number are timed".into()
    } else {
        let share = numbers.disagreement.map_or(String::new(), numbers::percent);
        format!("Under even direct light, what both find differs by {share}")
    };
    Sheet {
        title: "Time of a frame's bounces".into(),
        subtitle: format!(
            "{} patches, three colours, on this machine's CPU with {} thread(s), median of {RUNS} runs or more. {source}.",
            numbers.patches, numbers.threads
        ),
        panels: vec![Panel { title: String::new(), content: Content::Bars(bars) }],
    }
}

fn sentence(numbers: &Numbers) -> String {
    let (packed, one) = (numbers.packed, numbers.dense[0].seconds);
    let made_up =
        if numbers.made_up { ", which were made up, as the container has none (--keep-dense keeps them)" } else { "" };
    format!(
        "All bounces by the packed operator take {} here, one bounce by dense form factors in f32 {}{made_up}: {:.2} times as long.",
        time(packed),
        time(one),
        one / packed
    )
}

fn time(seconds: f64) -> String {
    format!("{:.3} ms", 1e3 * seconds)
}

/// Median of the seconds that a task takes once it is warm.
fn median(mut task: impl FnMut()) -> f64 {
    task();
    let (start, mut seconds) = (Instant::now(), Vec::new());
    while seconds.len() < RUNS || (start.elapsed().as_secs_f64() < SECONDS && seconds.len() < MOST_RUNS) {
        let start = Instant::now();
        task();
        seconds.push(start.elapsed().as_secs_f64());
    }
    seconds.sort_by(f64::total_cmp);
    seconds[seconds.len() / 2]
}

/// Bounce after bounce, H ← F ρ (1 + H), under direct irradiance of 1 W/m² everywhere.
struct Classical<'a> {
    factors: &'a [f32],
    patches: &'a Patches,
    sent: [Vec<f32>; 3],
    light: Vec<[f32; 3]>,
}

impl<'a> Classical<'a> {
    fn new(factors: &'a [f32], patches: &'a Patches) -> Classical<'a> {
        let n = patches.len();
        Classical { factors, patches, sent: std::array::from_fn(|_| vec![0.0; n]), light: vec![[0.0; 3]; n] }
    }

    fn run(&mut self, bounces: u32) {
        self.light.fill([0.0; 3]);
        (0..bounces).for_each(|_| self.bounce());
    }

    fn bounce(&mut self) {
        for (c, sent) in self.sent.iter_mut().enumerate() {
            let of_patches = self.patches.reflectance.iter().zip(&self.light);
            sent.iter_mut().zip(of_patches).for_each(|(sent, (rho, light))| *sent = rho[c] * (1.0 + light[c]));
        }
        let [r, g, b] = &self.sent;
        rivals::product(self.factors, [r, g, b], &mut self.light);
    }

    /// All bounces, or as many as the packed operator has.
    fn settle(&mut self, bounces: Option<u32>) {
        self.run(0);
        let mut before = 0.0;
        for _ in 0..bounces.unwrap_or(MOST_BOUNCES) {
            self.bounce();
            let sum: f64 = self.light.as_flattened().iter().map(|v| f64::from(*v)).sum();
            if bounces.is_none() && sum - before <= LAST_BOUNCE * sum {
                break;
            }
            before = sum;
        }
    }
}

/// L2 over area of a − b relative to that of b; 0 where both are dark.
fn difference(patches: &Patches, a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    let [mut apart, mut whole] = [0.0; 2];
    for ((a, b), area) in a.iter().zip(b).zip(&patches.area) {
        for c in 0..3 {
            apart += f64::from(*area) * (f64::from(a[c]) - f64::from(b[c])).powi(2);
            whole += f64::from(*area) * f64::from(b[c]).powi(2);
        }
    }
    if whole > 0.0 { (apart / whole).sqrt() } else { 0.0 }
}
