//! What indirect light is: path-traced to a stated standard error, or read from a file.

use std::path::Path;

use anyhow::{Context, bail};
use reference::{Measured, PathTracer, PointEstimate, Sampling, Stop, rivals::Setting};
use scene::LightRig;

use crate::{
    csv_points::{ANSWERS, Points},
    reference as traced, runtime,
    session::Session,
};

/// Paths of a receiver at most.
const MAX_PATHS: u32 = 1 << 18;
/// Paths of the truth: others than those of any contestant.
const SEED: u32 = 0x7a11;

/// Irradiance of the receivers under one light, W/m².
pub struct Truth {
    pub direct: Vec<[f64; 3]>,
    pub indirect: Vec<[f64; 3]>,
    /// Standard error of the indirect irradiance.
    pub noise: Vec<[f64; 3]>,
}

impl Truth {
    /// Traces it to a relative standard error, and writes it as `allbounce reference` does.
    pub fn trace(
        points: &Points,
        setting: &Setting,
        rig: &LightRig,
        error: f64,
        output: &Path,
        session: &Session,
    ) -> anyhow::Result<Truth> {
        let need = points.position.len() as u64 * traced::BYTES_A_POINT;
        session.ask_memory("the truth", need, "take fewer receivers (--receivers)")?;
        let tracer = PathTracer::new(setting.scene, setting.surfaces, setting.rays, rig);
        let sampling = Sampling { stop: Stop::RelativeError { error, max_samples: MAX_PATHS }, seed: SEED };
        let start = session.seconds();
        let (light, report) = tracer.points(&points.position, &points.normal, &sampling, &session.progress());
        if !light.iter().all(traced::is_finite) {
            bail!("{}", runtime::TOO_BRIGHT);
        }
        if report.points_short_of_error > 0 {
            session.warn(&format!(
                "{} of {} receivers are less sure than asked after {MAX_PATHS} paths each",
                report.points_short_of_error, report.points
            ));
        }
        session.say(&format!("truth: {} paths, {:.1} s", report.paths, session.seconds() - start));
        let answers: Vec<&str> = ANSWERS.into_iter().chain(traced::FURTHER).collect();
        points.write(output, &answers, |i| traced::row(&light[i]))?;
        Ok(Truth::of(&light))
    }

    /// What a path tracer says of points.
    pub fn of(light: &[PointEstimate]) -> Truth {
        let colours = |part: fn(&PointEstimate) -> Measured| light.iter().map(part).collect::<Vec<_>>();
        let (direct, indirect) = (colours(|l| l.direct), colours(|l| l.indirect));
        Truth {
            direct: direct.iter().map(|m| m.value).collect(),
            indirect: indirect.iter().map(|m| m.value).collect(),
            noise: indirect.iter().map(|m| m.error).collect(),
        }
    }

    /// Reads it; it must be of the receivers.
    pub fn read(path: &Path, receivers: &Points) -> anyhow::Result<Truth> {
        let read = || -> anyhow::Result<Truth> {
            let points = Points::read(path, &[])?;
            if points.position != receivers.position || points.normal != receivers.normal {
                bail!("other points than in the first file of --truth; trace all lights at the same points");
            }
            let [direct, indirect, noise] =
                [points.colours("direct")?, points.colours("indirect")?, points.colours("se_indirect")?];
            Ok(Truth { direct, indirect, noise })
        };
        read().with_context(|| path.display().to_string())
    }
}
