//! Path tracing with as many paths as a frame has time for.

use radfile::Progress;
use reference::{PathTracer, Sampling, Stop, rivals::Rival};
use scene::LightRig;

use super::{
    ground::Ground,
    judge::{Choice, Judge},
};

/// Paths of a receiver in a frame.
const PATHS: [u32; 6] = [4, 16, 64, 256, 1024, 4096];
/// These are enough for a quick look.
const QUICK: [u32; 2] = [4, 64];

struct Paths<'a> {
    ground: &'a Ground<'a>,
    count: u32,
    normal: Vec<[f32; 3]>,
}

impl Rival for Paths<'_> {
    fn name(&self) -> String {
        format!("{} paths", self.count)
    }

    /// Their direct light is sampled as well: it is an end of each path.
    fn indirect(&mut self, rig: &LightRig, progress: &dyn Progress) -> Vec<[f32; 3]> {
        let setting = self.ground.setting;
        let tracer = PathTracer::new(setting.scene, setting.surfaces, setting.rays, rig);
        let sampling = Sampling { stop: Stop::Samples(self.count), seed: 1 };
        let (light, _) = tracer.points(self.ground.position, &self.normal, &sampling, progress);
        light.iter().map(|l| l.indirect.value.map(|v| v as f32)).collect()
    }

    fn bytes(&self) -> u64 {
        0
    }
}

/// Enters all numbers of paths.
pub fn compete(ground: &Ground, judge: &mut Judge) -> anyhow::Result<()> {
    let quick = judge.choice == Choice::First;
    let counts: &[u32] = if quick { &PATHS } else { judge.choice.of(&PATHS) };
    let normal: Vec<[f32; 3]> = ground.setting.receivers.iter().map(|r| r.normal.to_array()).collect();
    for &count in counts {
        if quick && !QUICK.contains(&count) {
            judge.pass_over();
            continue;
        }
        judge.make(|| Ok(Paths { ground, count, normal: normal.clone() }))?;
    }
    Ok(())
}
