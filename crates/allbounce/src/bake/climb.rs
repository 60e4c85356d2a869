//! The search for as few patches as an error needs: trial bakes, each with more patches than the last, until one is good
//! enough. That one is finished; what the others cost is a part of it, as cost grows faster than the number of patches.

use anyhow::bail;

use super::{
    Args,
    jury::{self, Case, Jury},
    rung::{self, Rung},
};
use crate::{numbers::percent, session::Session};

/// Patches of the first trial.
const FIRST: u32 = 50;
/// Part of the wanted error at which a trial is good enough, as other lights may be harder, and the part that the next one aims at.
pub const ENOUGH: f64 = 0.9;
const AIM: f64 = 0.8;
/// The error is taken to fall with this power of the number of patches until two trials tell; then within these bounds.
const POWER: f64 = 0.9;
const POWERS: [f64; 2] = [0.5, 1.2];
/// Least and most growth from one trial to the next.
const GROWTH: [f64; 2] = [1.25, 2.2];
/// Adaptive patches are tried from so many patches on and below such an error, as a pilot that errs more misleads, and must be
/// better by so much.
const ADAPTIVE: u64 = 300;
const TELLING: f64 = 0.1;
const BETTER: f64 = 0.9;
/// Trials in a row that hardly got better, after which the error counts as out of reach, and what is hardly.
const STUCK: usize = 2;
const HARDLY: f64 = 0.95;

/// Errors below this one are not told from none.
const LEAST: f64 = 1e-6;
/// The largest error that can be asked for.
const LARGEST: f64 = 0.5;

/// How patches are made.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    Uniform,
    Adaptive,
}

/// What trials are judged by and what they found so far.
pub struct Climb<'a> {
    args: &'a Args,
    jury: &'a Jury<'a>,
    /// Rigs that steer.
    cases: &'a [Case],
    session: &'a Session,
    /// Patches and error of the trials of the kind that goes on, the coarsest first.
    path: Vec<(f64, f64)>,
    /// Settled when both were tried.
    kind: Option<Kind>,
    /// The finest trial of uniform patches by which adaptive ones can be made.
    pilot: Option<radfile::Container>,
}

impl<'a> Climb<'a> {
    pub fn new(args: &'a Args, jury: &'a Jury<'a>, cases: &'a [Case], session: &'a Session) -> Climb<'a> {
        Climb { args, jury, cases, session, path: vec![], kind: None, pilot: None }
    }

    /// Error of the last trial.
    pub fn reached(&self) -> f64 {
        self.path.last().map_or(f64::INFINITY, |p| p.1)
    }

    /// The first trial that is good enough for `error`, of more patches than those before.
    pub fn to(&mut self, error: f64) -> anyhow::Result<Rung> {
        loop {
            let patches = self.next(AIM * error);
            let rung = self.trial(patches, error).map_err(|cause| self.out_of_reach(cause, patches))?;
            if rung.error <= ENOUGH * error {
                return Ok(rung);
            }
            self.give_up_if_stuck()?;
        }
    }

    /// Bakes about so many patches, of both kinds where that is not settled and may pay.
    fn trial(&mut self, patches: u32, error: f64) -> anyhow::Result<Rung> {
        let mut rung = self.bake(patches, error, self.kind == Some(Kind::Adaptive))?;
        self.pilot = rung.pilot.take().or(self.pilot.take());
        let tells = rung.patches >= ADAPTIVE && rung.error < TELLING && self.pilot.is_some();
        if self.kind.is_none() && tells && rung.error > ENOUGH * error {
            let adaptive = self.bake(patches, error, true)?;
            let pays = adaptive.error < BETTER * rung.error;
            self.kind = Some(if pays { Kind::Adaptive } else { Kind::Uniform });
            if pays {
                self.path.clear();
                rung = adaptive;
            }
        }
        self.path.push((rung.patches as f64, rung.error.max(LEAST)));
        Ok(rung)
    }

    fn bake(&self, patches: u32, error: f64, adaptive: bool) -> anyhow::Result<Rung> {
        let pilot = self.pilot.as_ref().filter(|_| adaptive);
        let mut rung = rung::bake(self.args, patches, error, pilot, self.session)?;
        let scores = self.jury.ask(&rung.baked, self.cases, self.session, |lit| {
            Ok(jury::scores(&lit.gathered(&self.jury.points, jury::TRIAL_RAYS, self.session)?, self.cases))
        })?;
        rung.error = jury::median(&scores);
        let kind = if adaptive { "adaptive patches" } else { "patches" };
        let each: Vec<String> =
            scores.iter().zip(self.cases).map(|(s, case)| format!("{} {}", case.name, percent(s.rms))).collect();
        self.session.say(&format!(
            "trial: {} {kind}, error {} ({})",
            rung.patches,
            percent(rung.error),
            each.join(", ")
        ));
        Ok(rung)
    }

    /// Patches that should have this error.
    fn next(&self, error: f64) -> u32 {
        let Some(&(patches, found)) = self.path.last() else { return FIRST };
        let power = match self.path[..] {
            [.., (fewer, before), _] if patches > fewer => {
                ((before / found).ln() / (patches / fewer).ln()).clamp(POWERS[0], POWERS[1])
            }
            _ => POWER,
        };
        (patches * (found / error).powf(1.0 / power).clamp(GROWTH[0], GROWTH[1])).round() as u32
    }

    fn give_up_if_stuck(&self) -> anyhow::Result<()> {
        let hardly = |pair: &[(f64, f64)]| pair[1].1 > HARDLY * pair[0].1;
        let stuck = self.path.len() > STUCK && self.path[self.path.len() - STUCK - 1..].windows(2).all(hardly);
        if stuck {
            bail!("{}; more patches do not help", self.best());
        }
        Ok(())
    }

    fn out_of_reach(&self, cause: anyhow::Error, patches: u32) -> anyhow::Error {
        if self.path.is_empty() {
            return cause;
        }
        cause.context(format!("{}; about {patches} patches were next", self.best()))
    }

    /// What was reached, and what to ask for instead.
    fn best(&self) -> String {
        let best = self.path.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1));
        let (patches, error) = best.unwrap_or((0.0, f64::INFINITY));
        let reached = format!("the error is {} with {patches} patches", percent(error));
        match self.args.goal.error {
            Some(asked) if error / ENOUGH < LARGEST => format!(
                "an error of {} was not reached: {reached}; ask for --error {:.1}% or more",
                percent(asked),
                100.0 * error / ENOUGH
            ),
            Some(asked) => format!(
                "an error of {} was not reached: {reached}; bake by --patches instead of --error",
                percent(asked)
            ),
            None => reached,
        }
    }
}
