//! Who says how good a bake is: points of the scene's surfaces, and their path-traced light under some rigs.

use anyhow::{bail, ensure};
use glam::Vec3;
use radfile::{Container, Elements, Patches, Record};
use reference::{PathTracer, Sampling, Stop};
use relight::{Frame, Operator, PatchSamples, Receivers, Relighter};
use scene::{LightRig, Rays, Scene, SurfacePoint, Surfaces};
use transfer::{GatherParams, Senders};

use super::lights::{self, Trial};
use crate::{
    chart::{receivers, score, truth::Truth},
    csv_points::Points,
    runtime,
    session::Session,
};

/// Points of the surfaces, and those that are drawn so that enough are left.
const POINTS: usize = 800;
const DRAWN: u32 = 1200;
/// Places in the air that a point must see one of: what is seen from none of them lies in a gap or behind something, where
/// nobody looks.
const PLACES: u32 = 96;
/// Paths of a point: at first, and at most.
const PATHS: [u32; 2] = [256, 1 << 11];

/// A scene and where its light is asked for.
pub struct Jury<'a> {
    pub scene: &'a Scene,
    pub rays: &'a Rays,
    surfaces: Surfaces<'a>,
    place: Points,
    pub points: Vec<SurfacePoint>,
}

/// The least share of the surfaces that lights of a case must shine on, and how many are looked at for each case.
const LIT: f64 = 0.2;
const TRIES: u32 = 4;
/// Rays of a last gather, as `relight` has them, and in trials.
pub const RAYS: u32 = 8192;
pub const TRIAL_RAYS: u32 = 4096;

/// One rig and its truth.
pub struct Case {
    pub name: String,
    pub rig: LightRig,
    pub truth: Truth,
}

/// A bake under the rigs of some cases, ready to be asked at any point.
pub struct Lit<'b> {
    pub relighter: Relighter<'b>,
    pub senders: Senders<'b>,
    pub frames: Vec<Frame>,
}

impl<'a> Jury<'a> {
    pub fn new(scene: &'a Scene, rays: &'a Rays) -> anyhow::Result<Jury<'a>> {
        let drawn = receivers::by_area(scene, rays, DRAWN)?;
        let points = relight::surface_points(&scene.mesh, &drawn.position, &drawn.normal);
        let places = lights::places(&points, rays, PLACES);
        let seen = |at: &usize| {
            let SurfacePoint { position, normal, triangle } = points[*at];
            let origin = rays.off_surface(position, normal);
            places.iter().any(|&place| (place - origin).dot(normal) > 0.0 && rays.visible(origin, place, triangle))
        };
        let chosen: Vec<usize> = (0..points.len()).filter(seen).take(POINTS).collect();
        // Where there is no room for a lamp, every point counts.
        let chosen = if chosen.is_empty() { (0..points.len().min(POINTS)).collect() } else { chosen };
        let place = Points::new(
            chosen.iter().map(|&at| drawn.position[at]).collect(),
            chosen.iter().map(|&at| drawn.normal[at]).collect(),
        );
        let points = chosen.iter().map(|&at| points[at]).collect();
        Ok(Jury { scene, rays, surfaces: Surfaces::new(&scene.mesh, &scene.materials)?, place, points })
    }

    /// `count` rigs from number `first` on with their traced light, whose noise is no more than `noise` of its mean where a bounded
    /// number of paths gets there. Lights that hardly shine anywhere are passed over: nobody lights a scene so.
    pub fn cases(
        &self,
        first: u32,
        count: usize,
        noise: f64,
        seed: u32,
        session: &Session,
    ) -> anyhow::Result<Vec<Case>> {
        let rigs = (first..first + TRIES * count as u32).map(|n| lights::rig(self.scene, &self.points, self.rays, n));
        let tried = rigs.map(|trial| self.case(trial, LIT, noise, seed, session));
        let cases = tried.filter_map(anyhow::Result::transpose).take(count).collect::<anyhow::Result<Vec<_>>>()?;
        if cases.is_empty() {
            bail!("no lamp in the air of the scene lights much of it; bake by --patches instead of --error");
        }
        Ok(cases)
    }

    /// What the scene itself emits, if that lights anything, as [`Jury::cases`].
    pub fn own_light(&self, noise: f64, seed: u32, session: &Session) -> anyhow::Result<Option<Case>> {
        lights::own(self.scene).map_or(Ok(None), |own| self.case(own, 0.0, noise, seed, session))
    }

    /// A rig that lights more than a share of the surfaces.
    fn case(&self, trial: Trial, least: f64, noise: f64, seed: u32, session: &Session) -> anyhow::Result<Option<Case>> {
        let Trial { name, rig } = trial;
        let rough = self.trace(&rig, PATHS[0], seed, session)?;
        if lit_share(&rough) <= least {
            return Ok(None);
        }
        let truth = self.refine(rough, &rig, noise, seed, session)?;
        Ok(Some(Case { name, rig, truth }))
    }

    fn trace(&self, rig: &LightRig, paths: u32, seed: u32, session: &Session) -> anyhow::Result<Truth> {
        let tracer = PathTracer::new(self.scene, &self.surfaces, self.rays, rig);
        let sampling = Sampling { stop: Stop::Samples(paths), seed };
        let (light, _) = tracer.points(&self.place.position, &self.place.normal, &sampling, &session.progress());
        let truth = Truth::of(&light);
        ensure!(score::mean(&truth).is_finite(), "{}", runtime::TOO_BRIGHT);
        Ok(truth)
    }

    /// Traces with as many paths as the noise of few lets expect to be enough.
    fn refine(&self, rough: Truth, rig: &LightRig, noise: f64, seed: u32, session: &Session) -> anyhow::Result<Truth> {
        let wanted = f64::from(PATHS[0]) * (score::noise(&rough) / noise).powi(2);
        if wanted <= f64::from(PATHS[0]) {
            return Ok(rough);
        }
        self.trace(rig, (wanted.min(f64::from(PATHS[1])) as u32).next_power_of_two(), seed, session)
    }

    /// Puts a bake, finished or up to its packed operator, under the rigs of `cases` and asks it.
    pub fn ask<T>(
        &self,
        baked: &Container,
        cases: &[Case],
        session: &Session,
        question: impl FnOnce(&Lit) -> anyhow::Result<T>,
    ) -> anyhow::Result<T> {
        let (patches, progress) = (Patches::read(baked)?, session.progress());
        // A finished bake has elements, or none as its receivers interpolate; frames of it see no others.
        let elements = match baked.has("transfer.position") {
            true => Elements::read_or_whole(baked, &patches)?,
            false => transfer::subdivide(&patches, &self.surfaces, self.rays, &progress),
        };
        let (operator, sky) = (Operator::read(baked)?, radfile::read_sky(baked)?);
        let relighter = Relighter::new(self.scene, self.rays, &patches, &elements, &operator, sky)?;
        let frame = |case: &Case| {
            relighter.frame(&relighter.direct_light(&case.rig), &PatchSamples::default(), &session.progress())
        };
        let frames = cases.iter().map(frame).collect();
        let senders = Senders { patches: &patches, elements: &elements, rays: self.rays };
        question(&Lit { relighter, senders, frames })
    }
}

impl Lit<'_> {
    /// Indirect irradiance at points under every rig, by a last gather of so many rays.
    pub fn gathered(
        &self,
        points: &[SurfacePoint],
        rays: u32,
        session: &Session,
    ) -> anyhow::Result<Vec<Vec<[f32; 3]>>> {
        let params = GatherParams { rays, ..GatherParams::default() };
        let need = transfer::gather_memory_needed(points.len(), self.senders.elements.senders(), &params);
        session.ask_memory("the last gather of the trial", need, "ask for a larger error")?;
        let rows = transfer::gather_for_points(&self.senders, points, &params, &session.progress());
        Ok(self.received(&Receivers::from(&rows)))
    }

    /// The same, interpolated between patches.
    pub fn interpolated(&self, points: &[SurfacePoint], session: &Session) -> Vec<Vec<[f32; 3]>> {
        let params = transfer::Params::default();
        let rows = transfer::interpolate_for_points(
            self.senders.patches,
            self.senders.rays,
            points,
            &params,
            &session.progress(),
        );
        self.received(&Receivers::Interpolated(&rows))
    }

    /// Indirect irradiance of receivers under every rig.
    pub fn received(&self, receivers: &Receivers) -> Vec<Vec<[f32; 3]>> {
        self.frames.iter().map(|frame| receivers.indirect(&self.relighter, frame)).collect()
    }
}

/// The share of the points that indirect light is spread over: (Σ E)² / (n Σ E²), 1 where all get the same.
fn lit_share(truth: &Truth) -> f64 {
    let light: Vec<f64> = truth.indirect.iter().map(|e| e.iter().sum::<f64>()).collect();
    let (sum, squares) = light.iter().fold((0.0, 0.0), |(sum, squares), e| (sum + e, squares + e * e));
    if squares == 0.0 { 0.0 } else { sum * sum / (light.len() as f64 * squares) }
}

/// Of the box around points, metres.
pub fn diagonal(points: &[SurfacePoint]) -> f32 {
    let fold = |f: fn(Vec3, Vec3) -> Vec3| points.iter().map(|p| p.position).reduce(f).unwrap_or_default();
    (fold(Vec3::max) - fold(Vec3::min)).length()
}

/// Error of each rig's answer.
pub fn scores(answers: &[Vec<[f32; 3]>], cases: &[Case]) -> Vec<score::Score> {
    answers.iter().zip(cases).map(|(answer, case)| score::score(answer, &case.truth)).collect()
}

/// One figure for all rigs: the mean of their RMS.
pub fn rms(scores: &[score::Score]) -> f64 {
    scores.iter().map(|s| s.rms).sum::<f64>() / scores.len().max(1) as f64
}

/// The same that one hard light does not decide: the median.
pub fn median(scores: &[score::Score]) -> f64 {
    let mut all: Vec<f64> = scores.iter().map(|s| s.rms).collect();
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).map_or(0.0, |upper| 0.5 * (upper + all[(all.len() - 1) / 2]))
}

/// RMS of the difference of two answers relative to the mean of the second, quadratic mean over rigs.
pub fn difference(answers: &[Vec<[f32; 3]>], of: &[Vec<[f32; 3]>]) -> f64 {
    let one = |(a, b): (&Vec<[f32; 3]>, &Vec<[f32; 3]>)| {
        let pairs = || a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| [f64::from(*a), f64::from(*b)]);
        let mean = pairs().map(|[_, b]| b).sum::<f64>() / pairs().count().max(1) as f64;
        let squares = score::quadratic_mean(pairs().map(|[a, b]| a - b));
        if squares == 0.0 { 0.0 } else { squares / mean }
    };
    score::quadratic_mean(answers.iter().zip(of).map(one))
}
