//! A bake that chooses its own settings.

use anyhow::{Context, bail};
use radfile::Accuracy;
use scene::Rays;
use serde::Serialize;
use serde_json::Value;

use super::{
    Args,
    climb::{Climb, Kind},
    finish::{Finished, certify, finish, with},
    jury::{Case, Jury},
};
use crate::{
    files::{self, DiskFolder},
    memory,
    numbers::percent,
    session::Session,
};

/// Rigs that steer, and rigs that judge what came out.
const STEERING: usize = 4;
const JUDGING: usize = 5;
/// Numbers of rigs that judge start here.
const FIRST_JUDGE: u32 = 100;
/// Noise of the truth where no error is asked for; else as much as that: it is known, and taken off.
const NOISE: f64 = 0.05;
/// How often a bake is made anew as judges find it worse than it should be.
const APPEALS: u32 = 2;
/// Where only memory or time is limited: the error to begin with, what it is multiplied with as long as there is room, and the
/// least.
const COARSE: f64 = 0.3;
const FINER: f64 = 0.75;
const FINEST: f64 = 0.005;
/// Seeds of the truths of those that steer; judges have others.
const SEED: u32 = 0x57ee;

/// What was chosen and what came out.
#[derive(Serialize)]
struct Report {
    patches: u64,
    kind: Kind,
    /// Bytes that frames read beside the scene.
    bytes_of_frames: u64,
    ms_a_frame: f64,
    accuracy: Accuracy,
    seconds: f64,
    bytes: u64,
    stages: Vec<Value>,
}

/// A finished bake and what it is of.
struct Made {
    patches: u64,
    kind: Kind,
    finished: Finished,
}

pub fn run(args: &Args, session: &Session) -> anyhow::Result<()> {
    let named = || args.scene.display().to_string();
    let (folder, name) = DiskFolder::of(&args.scene)?;
    let (scene, imported) = scene::import(&name, &folder, args.voxel_simplify.import()).with_context(named)?;
    imported.warnings.iter().for_each(|warning| session.warn(warning));
    let rays = Rays::new(&scene.mesh);
    let jury = Jury::new(&scene, &rays).with_context(named)?;
    let noise = args.goal.error.unwrap_or(NOISE);
    let mut cases = jury.cases(0, STEERING, noise, SEED, session).with_context(named)?;
    cases.extend(jury.own_light(noise, SEED, session).with_context(named)?);
    let mut climb = Climb::new(args, &jury, &cases, session);
    let judges = |round: u32| jury.cases(FIRST_JUDGE * (1 + round), JUDGING, noise, SEED + 1 + round, session);
    let (made, accuracy) = match args.goal.error {
        Some(error) => within_error(args, error, &jury, &cases, &mut climb, judges, session),
        None => within_budget(args, &jury, &cases, &mut climb, session)
            .and_then(|made| certify(&jury, &made.finished, None, &judges(0)?, session).map(|told| (made, told))),
    }
    .with_context(named)?;
    write(args, made, accuracy, session)
}

/// The coarsest bake whose error under lights that it was not steered by is no more than asked, or else the best.
fn within_error(
    args: &Args,
    error: f64,
    jury: &Jury,
    cases: &[Case],
    climb: &mut Climb,
    judges: impl Fn(u32) -> anyhow::Result<Vec<Case>>,
    session: &Session,
) -> anyhow::Result<(Made, Accuracy)> {
    let (mut steer, mut best) = (error, None::<(Made, Accuracy)>);
    for round in 0..=APPEALS {
        let made = match (make_within(args, error, steer, jury, cases, climb, session), &best) {
            (Ok(made), _) => made,
            (Err(cause), None) => return Err(cause),
            (Err(cause), Some(_)) => {
                session.say(&format!("no finer bake: {cause:#}"));
                break;
            }
        };
        let accuracy = certify(jury, &made.finished, Some(error), &judges(round)?, session)?;
        let rms = accuracy.rms;
        if best.as_ref().is_none_or(|(_, before)| rms < before.rms) {
            best = Some((made, accuracy));
        }
        if rms <= error {
            break;
        }
        session.say(&format!("under other lights the error is {}: a finer bake may be better", percent(rms)));
        steer *= error / rms;
    }
    best.context("no bake was made")
}

/// Makes a bake that keeps memory and time as well.
fn make_within(
    args: &Args,
    error: f64,
    steer: f64,
    jury: &Jury,
    cases: &[Case],
    climb: &mut Climb,
    session: &Session,
) -> anyhow::Result<Made> {
    let made = make(args, steer, jury, cases, climb, session)?;
    match excess(args, &made.finished) {
        Some(excess) => {
            bail!("an error of {} takes {excess}; allow more, or ask for a larger --error", percent(error))
        }
        None => Ok(made),
    }
}

/// The finest bake within memory and time.
fn within_budget(
    args: &Args,
    jury: &Jury,
    cases: &[Case],
    climb: &mut Climb,
    session: &Session,
) -> anyhow::Result<Made> {
    let (mut best, mut error) = (None, COARSE);
    while error > FINEST {
        let made = match make(args, error, jury, cases, climb, session) {
            Ok(made) => made,
            Err(cause) if best.is_none() => return Err(cause),
            Err(cause) => {
                // What is finer does not help, or does not fit into this machine.
                session.say(&format!("no finer bake: {cause:#}"));
                break;
            }
        };
        if let Some(excess) = excess(args, &made.finished) {
            if best.is_none() {
                bail!("the coarsest bake takes {excess}; allow more");
            }
            break;
        }
        error = FINER * climb.reached().min(error);
        best = Some(made);
    }
    best.context("no bake was made")
}

/// Climbs until `error` is met and adds receivers for it.
fn make(
    args: &Args,
    error: f64,
    jury: &Jury,
    cases: &[Case],
    climb: &mut Climb,
    session: &Session,
) -> anyhow::Result<Made> {
    let rung = climb.to(error)?;
    let (patches, kind) = (rung.patches, rung.kind);
    Ok(Made { patches, kind, finished: finish(args, jury, rung, error, cases, session)? })
}

/// What a bake takes more than it may, in words.
fn excess(args: &Args, made: &Finished) -> Option<String> {
    let of_memory = args.goal.memory.filter(|&most| made.bytes > most);
    let of_time = args.goal.time.filter(|&most| made.seconds_a_frame > most);
    let time = |seconds: f64| match seconds < 1e-4 {
        true => format!("{:.2} µs", 1e6 * seconds),
        false => format!("{:.2} ms", 1e3 * seconds),
    };
    of_memory.map(|most| format!("{}, more than {} (--memory)", memory::size(made.bytes), memory::size(most))).or_else(
        || {
            of_time.map(|most| {
                format!("{} a frame, more than {} (--time-per-frame)", time(made.seconds_a_frame), time(most))
            })
        },
    )
}

fn write(args: &Args, made: Made, accuracy: Accuracy, session: &Session) -> anyhow::Result<()> {
    let Made { patches, kind, finished } = made;
    let file = with(&accuracy, &finished.baked)?;
    let bytes = file.as_bytes().len() as u64;
    files::write(&args.output, file.as_bytes())?;
    finished.log.print(session)?;
    for light in &accuracy.lights {
        session.say(&format!("under {}: error {}, bias {}", light.name, percent(light.rms), percent(light.bias)));
    }
    if accuracy.error_wanted.is_some_and(|wanted| accuracy.rms > wanted) {
        let wanted = percent(accuracy.error_wanted.unwrap_or_default());
        session.warn(&format!(
            "the error is {} under lights that had no part in the choice, {wanted} was asked; ask for a smaller --error",
            percent(accuracy.rms)
        ));
    }
    session.say(&format!(
        "baked {} in {:.1} s, {}: {patches} patches, error {}, frames {} and {:.2} ms for all vertices",
        args.output.display(),
        session.seconds(),
        memory::size(bytes),
        percent(accuracy.rms),
        memory::size(finished.bytes),
        1e3 * finished.seconds_a_frame
    ));
    session.finish(&Report {
        patches,
        kind,
        bytes_of_frames: finished.bytes,
        ms_a_frame: 1e3 * finished.seconds_a_frame,
        accuracy,
        seconds: session.seconds(),
        bytes,
        stages: finished.log.into_reports(),
    })
}
