//! What a trial lacks to be a bake: receivers no better than its patches, and what it came to under lights that had no part
//! in any choice.

use std::time::Instant;

use radfile::{Accuracy, Builder, Container, ErrorParts, LightAccuracy, Record, Transfer};
use relight::{PatchSamples, Receivers};
use scene::{NO_TRIANGLE, SurfacePoint};

use super::{
    Args,
    chain::Log,
    climb::ENOUGH,
    jury::{self, Case, Jury, Lit},
    rung::{PACKABLE, Rung},
};
use crate::{chart::score, session::Session};

/// Parts of the error that rays of the receivers may cause, and packing of their rows.
const RAYS: f64 = 0.4;
const PACKING: f64 = 0.1;
/// Numbers of rays that are tried.
const FEWEST_RAYS: u32 = 64;
/// Vertices that are held to a last gather of many rays.
const CHECKED: usize = 512;
/// Frames that are timed.
const FRAMES: usize = 5;
/// Sections that a frame reads, by how their names begin: operator, rows of receivers, elements, tables of patches.
const FRAME: [&str; 17] = [
    "hmatrix.",
    "elements.start",
    "elements.area",
    "elements.reflectance",
    "elements.point",
    "patches.area",
    "patches.reflectance",
    "formfactor.sky",
    "transfer.gather",
    "transfer.sky",
    "transfer.row_start",
    "transfer.patch",
    "transfer.weight",
    "lightmap.gather",
    "lightmap.sky",
    "volume.gather",
    "volume.sky",
];

/// A bake, ready to be written.
pub struct Finished {
    pub baked: Container,
    pub log: Log,
    /// Whether receivers interpolate; or they gather.
    interpolates: bool,
    /// What a frame reads beside the scene.
    pub bytes: u64,
    /// Indirect light of all vertices, median.
    pub seconds_a_frame: f64,
    /// What vertices differ from a last gather of many rays.
    pub receivers: f64,
}

/// Adds receivers for an error: they interpolate if that is good enough, or gather by as few rays as are.
pub fn finish(
    args: &Args,
    jury: &Jury,
    rung: Rung,
    error: f64,
    cases: &[Case],
    session: &Session,
) -> anyhow::Result<Finished> {
    let (mut log, mut interpolating) = (rung.log.clone(), rung.log);
    let mut baked = interpolating.link(&args.transfer.interpolated(), &rung.baked, &session.brief())?;
    let interpolates = !args.transfer.asks_for_more()
        && jury.ask(&baked, cases, session, |lit| {
            let scores = jury::scores(&lit.interpolated(&jury.points, session), cases);
            Ok(jury::median(&scores) <= ENOUGH * error)
        })?;
    if interpolates {
        log = interpolating;
    } else {
        // Vertices are the same however light comes to them.
        let (vertices, _) = some_of(&Transfer::read(&baked)?);
        let rays = jury.ask(&rung.baked, cases, session, |lit| rays(lit, &vertices, error, session))?;
        let packing = (PACKING * error).clamp(PACKABLE[0], PACKABLE[1]);
        baked = log.link(&args.transfer.gathered(rays, packing), &rung.baked, &session.brief())?;
    }
    // Whole patches have no points of elements: frames draw theirs on the pieces.
    let drawn_on = |name: &str| interpolates && name.starts_with("patches.piece_");
    let of_frame = |name: &str| FRAME.iter().any(|prefix| name.starts_with(prefix)) || drawn_on(name);
    let bytes = baked.sections().iter().filter(|s| of_frame(&s.name)).map(|s| s.length).sum();
    let transfer = Transfer::read(&baked)?;
    let (seconds_a_frame, receivers) = jury.ask(&baked, cases, session, |lit| {
        let receivers = Receivers::new(&transfer.weights, lit.senders.elements.senders())?;
        Ok((time(lit, &receivers, cases, session), on_top(lit, &receivers, &transfer, session)?))
    })?;
    drop(transfer);
    Ok(Finished { baked, log, interpolates, bytes, seconds_a_frame, receivers })
}

/// The fewest rays of a last gather that change the light of vertices by little.
fn rays(lit: &Lit, vertices: &[SurfacePoint], error: f64, session: &Session) -> anyhow::Result<u32> {
    let best = lit.gathered(vertices, jury::RAYS, session)?;
    let mut rays = FEWEST_RAYS;
    while rays < jury::RAYS && jury::difference(&lit.gathered(vertices, rays, session)?, &best) > RAYS * error {
        rays *= 2;
    }
    Ok(rays)
}

/// Some of the vertices, every so many.
fn some_of(transfer: &Transfer) -> (Vec<SurfacePoint>, usize) {
    let step = transfer.receivers().div_ceil(CHECKED).max(1);
    let point = |at: usize| SurfacePoint {
        position: transfer.position[at].into(),
        normal: transfer.normal[at].into(),
        triangle: NO_TRIANGLE,
    };
    ((0..transfer.receivers()).step_by(step).map(point).collect(), step)
}

/// RMS by which vertices differ from a last gather of many rays at the same places.
fn on_top(lit: &Lit, receivers: &Receivers, transfer: &Transfer, session: &Session) -> anyhow::Result<f64> {
    let (points, step) = some_of(transfer);
    let best = lit.gathered(&points, jury::RAYS, session)?;
    let theirs: Vec<Vec<[f32; 3]>> =
        lit.received(receivers).iter().map(|all| all.iter().step_by(step).copied().collect()).collect();
    Ok(jury::difference(&theirs, &best))
}

/// Median time of the indirect light of all vertices under the first rig, seconds.
fn time(lit: &Lit, receivers: &Receivers, cases: &[Case], session: &Session) -> f64 {
    let light = lit.relighter.direct_light(&cases[0].rig);
    let frame = || {
        let start = Instant::now();
        let frame = lit.relighter.frame(&light, &PatchSamples::default(), &session.progress());
        std::hint::black_box(receivers.indirect(&lit.relighter, &frame));
        start.elapsed().as_secs_f64()
    };
    let mut seconds: Vec<f64> = (0..FRAMES).map(|_| frame()).collect();
    seconds.sort_by(f64::total_cmp);
    seconds[FRAMES / 2]
}

/// Holds a bake to the truth of `cases`, at points whose light comes as its receivers' does.
pub fn certify(
    jury: &Jury,
    made: &Finished,
    wanted: Option<f64>,
    cases: &[Case],
    session: &Session,
) -> anyhow::Result<Accuracy> {
    let answers = jury.ask(&made.baked, cases, session, |lit| match made.interpolates {
        true => Ok(lit.interpolated(&jury.points, session)),
        false => lit.gathered(&jury.points, jury::RAYS, session),
    })?;
    let scores = jury::scores(&answers, cases);
    let (all, rms) = (score::of_all(&scores), jury::rms(&scores));
    let (form_factors, packing) =
        (made.log.number("formfactor", "irradiance_error")?, made.log.number("hmatrix", "l2_mean")?);
    let solver = made.log.largest("series", "channel", "residual")?;
    let interpolation = if made.interpolates { made.receivers } else { 0.0 };
    let known = [form_factors, packing, solver, interpolation].iter().map(|e| e * e).sum::<f64>();
    let light = |(case, score): (&Case, &score::Score)| {
        Ok(LightAccuracy {
            name: case.name.clone(),
            rig: serde_json::to_string(&case.rig)?,
            rms: score.rms,
            bias: score.bias,
            vis99: score.vis99,
            noise: score::noise(&case.truth),
        })
    };
    Ok(Accuracy {
        error_wanted: wanted,
        points: jury.points.len() as u32,
        rms,
        bias: all.bias,
        vis99: all.vis99,
        lights: cases.iter().zip(&scores).map(light).collect::<anyhow::Result<_>>()?,
        parts: ErrorParts {
            discretisation: (rms * rms - known).max(0.0).sqrt(),
            form_factors,
            solver,
            packing,
            receivers: made.receivers,
        },
    })
}

/// The bake with what it came to.
pub fn with(accuracy: &Accuracy, baked: &Container) -> radfile::Result<Container> {
    let mut builder = Builder::from_input(baked, |_| true);
    accuracy.write(&mut builder);
    builder.finish()
}
