//! Packs the operator of a case in every way, times them side by side and judges each.

use std::time::Instant;

use gpu_runtime::Gpu;
use permute::Order;
use radfile::Kernel;

use super::{
    Product,
    case::{Case, Error},
    classical::{BOUNCES, Classical},
    clock, device,
    judge::Judge,
    packed::{Hierarchical, Textures},
    planes::Planes,
    record::{Row, digits},
};

/// Errors of light that hierarchical operators are packed to, as the record names them.
const ERRORS: [(&str, f64); 3] = [("3%", 0.03), ("1%", 0.01), ("0.3%", 0.003)];
/// The hierarchical operator at the error that the paper's format has.
pub const AS_PAPER: &str = "as paper";
const PAPER: &str = "paper";
const BLOCKS: &str = "hmatrix";

/// Where and when.
#[derive(Clone, Debug)]
pub struct Stamp {
    pub date: String,
    pub commit: String,
    pub machine: String,
}

/// A packed operator before it is timed.
struct Contestant<'a> {
    format: &'static str,
    setting: String,
    bytes: usize,
    pack_s: Option<f64>,
    product: Box<dyn Product + Send + 'a>,
}

/// A row for every operator whose format and setting `wanted` takes.
///
/// # Errors
///
/// If one cannot be packed. A GPU that cannot hold an operator leaves its columns empty.
pub fn run(
    case: &Case,
    stamp: &Stamp,
    gpu: Option<&Gpu>,
    wanted: &dyn Fn(&str, &str) -> bool,
    say: &mut dyn FnMut(&str),
) -> Result<Vec<Row>, Error> {
    let judge = Judge::new(case);
    let mut all = rivals(case);
    all.append(&mut textures(case, wanted, say)?);
    let of_paper = paper_error(&judge, &mut all);
    all.append(&mut blocks(case, of_paper, wanted, say)?);
    all.retain(|contestant| wanted(contestant.format, &contestant.setting));
    say("timing");
    let mut products: Vec<_> = all.iter_mut().map(|c| &mut *c.product).collect();
    let times = clock::race(&mut products, &judge.a_lamp());
    say("judging");
    let mut rows = Vec::new();
    for (contestant, [one, two]) in all.iter_mut().zip(times) {
        let score = judge.score(&mut *contestant.product);
        let on_gpu = gpu.zip(contestant.product.for_gpu()).map(|(gpu, packed)| device::milliseconds(gpu, case, packed));
        if let Some(Err(error)) = &on_gpu {
            say(&format!("{} {} is not timed on the GPU: {error}", contestant.format, contestant.setting));
        }
        let gpu_ms = on_gpu.and_then(Result::ok);
        let n = case.len();
        rows.push(Row {
            date: stamp.date.clone(),
            commit: stamp.commit.clone(),
            machine: stamp.machine.clone(),
            scene: case.scene.clone(),
            n,
            format: contestant.format.into(),
            setting: contestant.setting.clone(),
            bytes: contestant.bytes,
            bytes_per_n2: digits(contestant.bytes as f64 / (n as f64).powi(2), 5),
            pack_s: contestant.pack_s.map(|s| digits(s, 3)),
            cpu1_ms: Some(digits(one, 4)),
            cpu2_ms: Some(digits(two, 4)),
            gpu: gpu_ms.and(gpu).map(|gpu| gpu.adapter().to_string().replace(',', ";")),
            gpu_ms: gpu_ms.map(|ms| digits(ms, 4)),
            l2: Some(digits(score.l2, 4)),
            vis99: Some(digits(score.vis99, 4)),
            furnace: Some(digits(score.furnace, 4)),
        });
    }
    Ok(rows)
}

/// What keeps dense matrices.
fn rivals(case: &Case) -> Vec<Contestant<'_>> {
    let classical = Classical::new(case);
    let single = Planes::single(&case.operator);
    let half = Planes::half(&case.operator);
    let logarithm = Planes::logarithm(&case.operator);
    let dense = |setting: &str, bytes, product| Contestant {
        format: "dense-s",
        setting: setting.into(),
        bytes,
        pack_s: None,
        product,
    };
    vec![
        Contestant {
            format: "dense-f",
            setting: format!("bounces={BOUNCES}"),
            bytes: classical.bytes(),
            pack_s: None,
            product: Box::new(classical),
        },
        dense("f32", single.bytes(), Box::new(single)),
        dense("f16", half.bytes(), Box::new(half)),
        dense("u8-log", logarithm.bytes(), Box::new(logarithm)),
    ]
}

/// Block-compressed textures. The paper's are packed in the paper's order, too. Blocks are held to their error, so
/// that whoever wants those needs these.
fn textures(
    case: &Case,
    wanted: &dyn Fn(&str, &str) -> bool,
    say: &mut dyn FnMut(&str),
) -> Result<Vec<Contestant<'static>>, Error> {
    let mut all = Vec::new();
    let presets = dxt_pack::Params::PRESETS.into_iter().map(|(name, params)| (name, params, Order::NormalHilbert));
    for (name, params, order) in presets.chain([(PAPER, dxt_pack::Params::PAPER, Order::Greedy)]) {
        if wanted(name, order.name()) || name == PAPER && wanted(BLOCKS, AS_PAPER) {
            say(&format!("{name}, {}", order.name()));
            let start = Instant::now();
            let packed = match order {
                Order::Greedy => {
                    let found = permute::order(&case.patches, Some(&case.operator), &permute::Params { order })?.0;
                    Textures::pack_in(found, case, &params)?
                }
                _ => Textures::pack(case, &params)?,
            };
            let pack_s = Some(start.elapsed().as_secs_f64());
            let (bytes, setting) = (packed.bytes(), order.name().into());
            all.push(Contestant { format: name, setting, bytes, pack_s, product: Box::new(packed) });
        }
    }
    Ok(all)
}

/// The lower of the errors that the paper's format has.
fn paper_error(judge: &Judge, all: &mut [Contestant]) -> Option<f64> {
    let papers = all.iter_mut().filter(|contestant| contestant.format == PAPER);
    papers.map(|contestant| judge.score(&mut *contestant.product).l2).reduce(f64::min)
}

/// Hierarchical blocks of all bounces and of one.
fn blocks<'a>(
    case: &'a Case,
    paper_error: Option<f64>,
    wanted: &dyn Fn(&str, &str) -> bool,
    say: &mut dyn FnMut(&str),
) -> Result<Vec<Contestant<'a>>, Error> {
    let mut all = Vec::new();
    let as_paper = paper_error.map(|error| (AS_PAPER, error));
    let of_all_bounces = ERRORS.into_iter().chain(as_paper).map(|(s, e)| (BLOCKS, s, Kernel::AllBounces, e));
    let of_one = ("g-cg", "1%", Kernel::OneBounce, 0.01);
    for (format, setting, kernel, error) in of_all_bounces.chain([of_one]).filter(|(f, s, ..)| wanted(f, s)) {
        say(&format!("{format} {setting}"));
        let start = Instant::now();
        let blocks = Hierarchical::pack(case, kernel, error)?;
        let pack_s = Some(start.elapsed().as_secs_f64());
        let (bytes, setting) = (blocks.bytes(), setting.to_owned());
        all.push(Contestant { format, setting, bytes, pack_s, product: Box::new(blocks) });
    }
    Ok(all)
}
