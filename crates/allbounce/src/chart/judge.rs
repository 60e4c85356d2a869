//! Times an entry and holds it to the truth.

use std::time::Instant;

use anyhow::{Context, ensure};
use radfile::Quiet;
use rayon::prelude::*;
use reference::rivals::Rival;
use scene::LightRig;
use serde::Serialize;

use super::{
    contestants::Contestant,
    ground::Ground,
    score::{self, Score},
    truth::Truth,
};
use crate::{numbers::percent, runtime};

/// Frames of a light at most.
const FRAMES: usize = 9;
/// Seconds after which no further frame of a light is begun.
const ENOUGH: f64 = 1.5;
/// Pairs of rays from a receiver to area lights for the direct light of a frame.
const DIRECT_SAMPLES: u32 = 4;

/// One setting of one method.
#[derive(Debug, Serialize)]
pub struct Entry {
    pub method: &'static str,
    pub settings: String,
    /// Which of the method's settings it is.
    #[serde(skip)]
    pub number: usize,
    /// Indirect light of all receivers after the lights changed, ms: median of the frames of a light, mean over lights.
    pub change_ms: f64,
    /// The same and their direct light, ms.
    pub frame_ms: f64,
    /// What it keeps from one change to the next beside the scene.
    pub bytes: u64,
    pub bake_seconds: f64,
    #[serde(flatten)]
    pub score: Score,
    /// Whether the RMS is but a bound: the truth is not sure enough to tell a smaller one.
    pub rms_is_bound: bool,
}

impl Entry {
    /// For people.
    pub fn rms(&self) -> String {
        format!("{}{}", if self.rms_is_bound { "< " } else { "" }, percent(self.score.rms))
    }
}

/// A setting of a method that has no entry.
#[derive(Debug, Serialize)]
pub struct LeftOut {
    pub method: &'static str,
    pub settings: String,
    pub why: String,
}

/// Which settings of a method are entered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Choice {
    All,
    First,
    One(usize),
}

impl Choice {
    /// Of these.
    pub fn of<T>(self, settings: &[T]) -> &[T] {
        match self {
            Choice::All => settings,
            Choice::First => &settings[..1],
            Choice::One(at) => &settings[at..=at],
        }
    }
}

/// Lights, truths and the entries so far.
pub struct Judge<'a> {
    rigs: &'a [LightRig],
    truths: &'a [Truth],
    ground: &'a Ground<'a>,
    /// Method of the entries to come.
    label: &'static str,
    /// Which of its settings are entered.
    pub choice: Choice,
    pub entries: Vec<Entry>,
    pub left_out: Vec<LeftOut>,
    /// How many settings of the method came before.
    tried: usize,
    /// Indirect irradiance that the last entry found under the last of the lights, W/m².
    pub light: Vec<[f32; 3]>,
    /// Direct light of the receivers, mean over lights.
    pub direct_seconds: f64,
}

impl<'a> Judge<'a> {
    pub fn new(ground: &'a Ground<'a>, rigs: &'a [LightRig], truths: &'a [Truth]) -> Judge<'a> {
        let direct_seconds = mean(rigs.iter().map(|rig| median(|| direct(ground, rig)).1));
        let (choice, entries, left_out, light) = (Choice::All, vec![], vec![], vec![]);
        Judge { rigs, truths, ground, label: "", choice, entries, left_out, tried: 0, light, direct_seconds }
    }

    /// Enters settings of a method.
    pub fn run(&mut self, contestant: &Contestant, choice: Choice) -> anyhow::Result<()> {
        (self.label, self.choice) = (contestant.label, choice);
        self.tried = if let Choice::One(at) = choice { at } else { 0 };
        (contestant.compete)(self.ground, self).with_context(|| contestant.name)
    }

    /// Says that a setting is not entered, and why.
    pub fn leave_out(&mut self, settings: String, why: String) {
        self.ground.session.warn(&format!("{}, {settings}: left out; {why}", self.label));
        self.left_out.push(LeftOut { method: self.label, settings, why });
        self.tried += 1;
    }

    /// Passes over a setting that nobody asked for.
    pub fn pass_over(&mut self) {
        self.tried += 1;
    }

    /// Makes a rival, which is its bake, and enters it.
    pub fn make<R: Rival>(&mut self, rival: impl FnOnce() -> anyhow::Result<R>) -> anyhow::Result<()> {
        let start = Instant::now();
        let mut rival = rival()?;
        self.enter(start.elapsed().as_secs_f64(), &mut rival)
    }

    /// Times a rival that took so many seconds to make, and scores it.
    pub fn enter(&mut self, bake_seconds: f64, rival: &mut dyn Rival) -> anyhow::Result<()> {
        let (mut scores, mut seconds) = (Vec::new(), Vec::new());
        for (rig, truth) in self.rigs.iter().zip(self.truths) {
            let (light, median) = median(|| rival.indirect(rig, &Quiet));
            ensure!(
                light.as_flattened().iter().all(|v| v.is_finite()),
                "{}: light that is not finite; leave the method out (--methods), or, if all fail, {}",
                rival.name(),
                runtime::TOO_BRIGHT
            );
            scores.push(score::score(&light, truth));
            seconds.push(median);
            self.light = light;
        }
        let (change, name) = (mean(seconds.into_iter()), rival.name());
        let (score, least) = (score::of_all(&scores), score::least_rms(self.truths));
        let entry = Entry {
            method: self.label,
            settings: settings(self.label, &name).to_owned(),
            number: self.tried,
            change_ms: 1e3 * change,
            frame_ms: 1e3 * (change + self.direct_seconds),
            bytes: rival.bytes(),
            bake_seconds,
            rms_is_bound: score.rms < least,
            score: Score { rms: score.rms.max(least), ..score },
        };
        self.ground.session.say(&format!(
            "{}, {}: {:.2} ms, RMS {}, bias {}",
            entry.method,
            entry.settings,
            entry.change_ms,
            entry.rms(),
            percent(entry.score.bias)
        ));
        self.entries.push(entry);
        self.tried += 1;
        Ok(())
    }
}

/// What a name says beside the family that the label starts with: `1024 paths` of `instant radiosity, 1024 paths`.
fn settings<'b>(label: &str, name: &'b str) -> &'b str {
    let family = label.split(", ").next().unwrap_or(label);
    name.strip_prefix(family).and_then(|rest| rest.strip_prefix(", ")).unwrap_or(name)
}

/// Direct irradiance of the receivers.
fn direct(ground: &Ground, rig: &LightRig) -> Vec<[f32; 3]> {
    let lights = ground.setting.lights(rig);
    let at = |(i, point)| lights.irradiance(point, DIRECT_SAMPLES, i as u32).to_array();
    ground.setting.receivers.par_iter().enumerate().map(at).collect()
}

/// The answer of a frame and the median of the times of several; the first warms up and is not timed unless it takes too
/// long to be repeated.
fn median<T>(mut frame: impl FnMut() -> T) -> (T, f64) {
    let begin = Instant::now();
    let mut timed = || {
        let start = Instant::now();
        let answer = frame();
        (answer, start.elapsed().as_secs_f64())
    };
    let (answer, first) = timed();
    let mut seconds = Vec::new();
    while seconds.len() < FRAMES && begin.elapsed().as_secs_f64() < ENOUGH {
        seconds.push(timed().1);
    }
    seconds.sort_by(f64::total_cmp);
    (answer, seconds.get(seconds.len() / 2).copied().unwrap_or(first))
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}
