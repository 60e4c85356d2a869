//! What a camera sees by the light of each method, beside the traced truth, as in figures 7 to 10 of the paper.
//!
//! Receivers are what the middle of each pixel shows. Shown is indirect light as it is reflected to the eye, ρ H / π: direct
//! light is alike for all and would only hide what differs. All pictures have the exposure of the truth.

use std::{f32::consts::PI, path::Path};

use anyhow::bail;
use glam::{DVec3, Vec3};
use radfile::Side;
use rayon::prelude::*;
use reference::rivals::Setting;
use relight::{Image, View};
use scene::{LightRig, NO_TRIANGLE, SurfacePoint};

use super::{
    contestants::Contestant,
    ground::Ground,
    judge::{Choice, Entry, Judge},
    score,
    sheet::short,
    truth::Truth,
};
use crate::{csv_points::Points, numbers::percent, pictures::Srgb, runtime, session::Session};

/// Files that are written: the pictures, and the truth of the pixels.
pub const FILES: [&str; 2] = ["side-by-side.png", "side-by-side-truth.csv"];
/// Least standard error of a pixel of the truth: less is hardly seen, and pixels are many.
const TRUTH_ERROR: f64 = 0.05;
/// Pictures in a row.
const COLUMNS: usize = 5;
/// Letters that fit below one.
const LETTERS: usize = 30;

/// Time of a light change that a picture of [`PIXELS`] may take, ms: a few pictures a second.
const CHANGE_MS: f64 = 500.0;
/// What its bake may take, s.
const BAKE_SECONDS: f64 = 300.0;
const PIXELS: f64 = 40_000.0;

/// Who looks, and how closely.
pub struct Eye<'a> {
    /// The camera file, or `scene`.
    pub camera: &'a Path,
    /// Pixels in a row, and rows.
    pub size: [usize; 2],
    /// Standard error of the truth, if that is more than a picture needs.
    pub truth_error: f64,
}

/// What is seen: receivers, and for each its reflectance and the number of its pixel.
struct Seen {
    points: Points,
    reflectance: Vec<[f32; 3]>,
    pixel: Vec<usize>,
}

/// What a camera sees, and how it is lit.
pub struct Sight<'a> {
    eye: Eye<'a>,
    seen: Seen,
    receivers: Vec<SurfacePoint>,
    rig: &'a LightRig,
    truth: Truth,
}

impl<'a> Sight<'a> {
    /// Looks, and traces the light of what is seen, which is written into `folder`.
    pub fn new(
        eye: Eye<'a>,
        scene: &Setting,
        rig: &'a LightRig,
        folder: &Path,
        session: &Session,
    ) -> anyhow::Result<Sight<'a>> {
        let seen = see(&eye, scene)?;
        let receivers = relight::surface_points(&scene.scene.mesh, &seen.points.position, &seen.points.normal);
        let setting = Setting { receivers: &receivers, ..*scene };
        let error = eye.truth_error.max(TRUTH_ERROR);
        let truth = Truth::trace(&seen.points, &setting, rig, error, &folder.join(FILES[1]), session)?;
        if score::mean(&truth) <= 0.0 {
            bail!("{}: no indirect light reaches what the camera sees; take another camera", eye.camera.display());
        }
        Ok(Sight { eye, seen, receivers, rig, truth })
    }

    /// Draws one setting of each of these methods into `folder`, chosen by what was `charted` at so many `receivers`, and
    /// tells how each did.
    pub fn draw(
        &self,
        contestants: &[&'static Contestant],
        (charted, receivers): (&[Entry], usize),
        scene: &Setting,
        folder: &Path,
        session: &Session,
    ) -> anyhow::Result<Vec<Entry>> {
        let (eye, seen, truths) = (&self.eye, &self.seen, std::slice::from_ref(&self.truth));
        let setting = Setting { receivers: &self.receivers, ..*scene };
        let light: Vec<[f32; 3]> = self.truth.indirect.iter().map(|h| h.map(|h| h as f32)).collect();
        let caption = told(["path-traced".into(), format!("noise {}", percent(score::noise(&self.truth)))], "");
        let (truth, exposure) = Srgb::of(&image(eye, seen, &light), None);
        let mut tiles = vec![truth.with_caption(&caption)?];
        let ground = Ground::new(setting, &seen.points.position, session);
        let mut judge = Judge::new(&ground, std::slice::from_ref(self.rig), truths);
        for contestant in contestants {
            let of_method: Vec<&Entry> = charted.iter().filter(|e| e.method == contestant.label).collect();
            let before = judge.entries.len();
            if let Some(best) = chosen(&of_method, PIXELS / receivers as f64) {
                judge.run(contestant, Choice::One(best.number))?;
            }
            let Some(entry) = judge.entries.get(before) else {
                session.warn(&format!("{}: no picture, for it entered nothing", contestant.name));
                continue;
            };
            let (picture, _) = Srgb::of(&image(eye, seen, &judge.light), Some(exposure));
            let numbers = format!("{} ms, RMS {}", short(entry.change_ms), entry.rms());
            tiles.push(picture.with_caption(&told([entry.method.into(), numbers], &entry.settings))?);
        }
        Srgb::grid(&tiles, COLUMNS).write(&folder.join(FILES[0]))?;
        Ok(judge.entries)
    }
}

/// The entry of a method that is drawn: of those whose light change and bake are quick enough, if they grow with the receivers
/// up to the `more` times as many of a picture, the one nearest to the truth; the quickest where none is.
fn chosen<'a>(entries: &[&'a Entry], more: f64) -> Option<&'a Entry> {
    let quick = |e: &&Entry| more * e.change_ms <= CHANGE_MS && more * e.bake_seconds <= BAKE_SECONDS;
    let all = || entries.iter().copied();
    all()
        .filter(quick)
        .min_by(|a, b| a.score.rms.total_cmp(&b.score.rms))
        .or_else(|| all().min_by(|a, b| a.change_ms.total_cmp(&b.change_ms)))
}

/// What the page says of the choice.
pub fn how_chosen() -> String {
    format!(
        "Shown is the charted setting of least RMS of those whose light change would take up to {} s and bake up to {} min for \
         {PIXELS} pixels if both grew with their number, or else the quickest.",
        CHANGE_MS / 1e3,
        BAKE_SECONDS / 60.0
    )
}

/// First hits of the camera.
fn see(eye: &Eye, setting: &Setting) -> anyhow::Result<Seen> {
    let mesh = &setting.scene.mesh;
    let [width, height] = eye.size;
    let camera = runtime::camera(eye.camera, setting.scene)?;
    let view = View::new(&camera, mesh.origin, width, height);
    let at = |pixel: usize| {
        let direction = view.direction((pixel % width) as f64 + 0.5, (pixel / width) as f64 + 0.5);
        let hit = setting.rays.closest(view.origin, direction, f32::INFINITY, NO_TRIANGLE)?;
        if mesh.one_sided && hit.side == Side::Back {
            return None;
        }
        let [a, b, c] = mesh.corners(hit.triangle as usize).map(|p| Vec3::from(p).as_dvec3());
        let position = a + f64::from(hit.u) * (b - a) + f64::from(hit.v) * (c - a) + DVec3::from(mesh.origin);
        let front = (b - a).cross(c - a).normalize_or_zero().as_vec3();
        let normal = if hit.side == Side::Front { front } else { -front };
        let reflectance = setting.surfaces.reflectance(hit.triangle, hit.u, hit.v);
        Some((position.to_array(), normal.to_array(), reflectance, pixel))
    };
    let all: Vec<_> = (0..width * height).into_par_iter().filter_map(at).collect();
    if all.is_empty() {
        bail!("{}: the camera sees no surface; turn it to the scene", eye.camera.display());
    }
    Ok(Seen {
        points: Points::new(all.iter().map(|s| s.0).collect(), all.iter().map(|s| s.1).collect()),
        reflectance: all.iter().map(|s| s.2).collect(),
        pixel: all.iter().map(|s| s.3).collect(),
    })
}

/// Reflected radiance; black where nothing is seen.
fn image(eye: &Eye, seen: &Seen, irradiance: &[[f32; 3]]) -> Image {
    let [width, height] = eye.size;
    let mut pixels = vec![[0.0; 3]; width * height];
    for ((&pixel, rho), light) in seen.pixel.iter().zip(&seen.reflectance).zip(irradiance) {
        pixels[pixel] = std::array::from_fn(|c| rho[c] * light[c] / PI);
    }
    Image { width, height, pixels }
}

/// What stands below a picture; long settings take two lines.
fn told([title, numbers]: [String; 2], settings: &str) -> [String; 4] {
    let breaks = settings.match_indices(", ").map(|(at, _)| at + 1);
    let all = if settings.chars().count() <= LETTERS { Some(settings.len()) } else { None };
    let end = all.or(breaks.filter(|at| *at <= LETTERS).last()).unwrap_or(settings.len());
    let (first, rest) = settings.split_at(end);
    [title, numbers, first.into(), rest.trim_start().into()]
}

#[cfg(test)]
mod tests {
    use super::{Entry, chosen};
    use crate::chart::score::Score;

    fn entry(change_ms: f64, bake_seconds: f64, rms: f64) -> Entry {
        let score = Score { rms, bias: 0.0, vis99: rms };
        let (settings, number) = (String::new(), 0);
        Entry {
            method: "",
            settings,
            number,
            change_ms,
            frame_ms: change_ms,
            bytes: 0,
            bake_seconds,
            score,
            rms_is_bound: false,
        }
    }

    #[test]
    fn the_nearest_of_the_quick_is_drawn_or_else_the_quickest() {
        let [rough, good] = [entry(1.0, 0.0, 0.5), entry(20.0, 10.0, 0.1)];
        let [slow, baked] = [entry(30.0, 0.0, 0.01), entry(1.0, 20.0, 0.01)];
        // Twenty times as many pixels: 25 ms and 15 s are just quick enough.
        let rms = |entries: &[&Entry]| chosen(entries, 20.0).map(|e| e.score.rms);
        assert_eq!(rms(&[&rough, &good, &slow, &baked]), Some(0.1));
        assert_eq!(rms(&[&entry(40.0, 0.0, 0.005), &slow]), Some(0.01));
        assert_eq!(rms(&[]), None);
    }
}
