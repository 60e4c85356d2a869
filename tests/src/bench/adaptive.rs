//! What uniform and adaptive patches are worth: errors of irradiance at points, against a fine bake.
//!
//! Points are spread over the surface by area. The truth at a point is gathered, by rays, from the patches of a fine bake;
//! the same rays gather from the patches under test, so noise of rays is in both. Lights are those of files and lamps
//! hung at random in lit air, all with shadows. Nobody who makes patches has seen them.

use std::path::Path;

use radfile::{Container, Elements, Operator, Patches, Quiet, Record, face_id, luma, read_sky};
use rayon::prelude::*;
use relight::{DirectLight, element_irradiance};
use scene::{
    ElementPoints, LightRig, PatchSampler, Rays, Scene, Sobol, SurfacePoint, Surfaces, cosine_direction, hash,
};
use serde::{Deserialize, Serialize};

use super::{case::Error, contest::Stamp, record::digits};

/// Points on the surface.
const POINTS: u32 = 4000;
/// Rays a point.
const RAYS: u32 = 1024;
/// Lamps that are hung.
const LAMPS: usize = 32;
/// Least way from a lamp's patch to what lies opposite, in diagonals of the scene.
const ROOM: f32 = 0.06;
/// Light that makes air lit, relative to the mean of the patches.
const LIT: f32 = 0.02;
/// Points of a patch that are tested for shadow, and rays of each to an area light.
const SAMPLES: [u32; 2] = [64, 8];

/// Patches of one kind under lights of one kind. Errors are fractions, RMS relative to the RMS of the truth, geometric
/// means over the lights.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Row {
    pub date: String,
    pub commit: String,
    pub machine: String,
    pub scene: String,
    /// `uniform` or `adaptive`.
    pub kind: String,
    /// Patches.
    pub n: usize,
    /// `files` or `lamps`, and how many.
    pub lights: String,
    pub count: usize,
    /// Of the irradiance of the patch that a point lies on.
    pub constant: f64,
    /// Of what a point gathers from all patches that it sees.
    pub gathered: f64,
}

/// A fine bake and points on its surface.
pub struct Judge<'a> {
    scene: &'a Scene,
    rays: &'a Rays,
    truth: &'a Container,
    points: Vec<(u32, SurfacePoint)>,
    /// Texts of lights files, those of files first.
    rigs: Vec<String>,
    files: usize,
}

/// Patches and their light, luma: a list a light.
struct Lit {
    patches: Patches,
    arriving: Vec<Vec<f32>>,
    leaving: Vec<Vec<f32>>,
}

impl<'a> Judge<'a> {
    /// `files` are texts of lights files; lamps are hung where these shine.
    ///
    /// # Errors
    ///
    /// If the bake holds no dense operator or a light is broken.
    pub fn new(truth: &'a Container, scene: &'a Scene, rays: &'a Rays, files: Vec<String>) -> Result<Judge<'a>, Error> {
        let mut judge = Judge { scene, rays, truth, points: vec![], files: files.len(), rigs: files };
        let lit = judge.light(truth)?;
        judge.points = points(&lit.patches);
        judge.hang_lamps(&lit);
        Ok(judge)
    }

    /// Rows of some bakes, each with its kind.
    ///
    /// # Errors
    ///
    /// As [`Judge::new`].
    pub fn rows(&self, name: &str, bakes: &[(String, Container)], stamp: &Stamp) -> Result<Vec<Row>, Error> {
        let mut lit = vec![self.light(self.truth)?];
        for (_, bake) in bakes {
            lit.push(self.light(bake)?);
        }
        let answers: Vec<Vec<[Vec<f32>; 2]>> =
            self.points.par_iter().enumerate().map(|(k, (face, point))| self.ask(k, *face, point, &lit)).collect();
        let mut rows = Vec::new();
        for (b, (kind, _)) in bakes.iter().enumerate() {
            for (lights, range) in [("files", 0..self.files), ("lamps", self.files..self.rigs.len())] {
                let [constant, gathered] = [0, 1].map(|way| digits(mean_error(&answers, b + 1, way, range.clone()), 4));
                let (count, n) = (range.len(), lit[b + 1].patches.len());
                let Stamp { date, commit, machine } = stamp.clone();
                let (scene, kind, lights) = (name.to_owned(), kind.clone(), lights.to_owned());
                rows.push(Row { date, commit, machine, scene, kind, n, lights, count, constant, gathered });
            }
        }
        Ok(rows)
    }

    /// Light of the patches of a bake, by its dense operator.
    fn light(&self, bake: &Container) -> Result<Lit, Error> {
        let (patches, operator, sky) = (Patches::read(bake)?, Operator::read(bake)?, read_sky(bake)?);
        let surfaces = Surfaces::new(&self.scene.mesh, &self.scene.materials)?;
        let elements = Elements::whole(&patches);
        let points = ElementPoints::new(&self.scene.mesh, &patches, &elements, SAMPLES[0]);
        let mut lit = Lit { arriving: vec![], leaving: vec![], patches };
        for rig in &self.rigs {
            let light = DirectLight::new(self.scene, &surfaces, self.rays, &LightRig::from_json(rig)?);
            let direct = element_irradiance(&light, &elements, &points, sky, SAMPLES[1], &Quiet);
            let further = [0, 1, 2].map(|c| received(&lit.patches, &operator, &direct, c));
            let n = lit.patches.len();
            let rho = &lit.patches.reflectance;
            lit.arriving.push((0..n).map(|i| luma([0, 1, 2].map(|c| further[c][i]))).collect());
            lit.leaving
                .push((0..n).map(|i| luma([0, 1, 2].map(|c| rho[i][c] * (direct[i][c] + further[c][i])))).collect());
        }
        Ok(lit)
    }

    /// Lamps about half way between patches that are lit and what lies opposite.
    fn hang_lamps(&mut self, lit: &Lit) {
        let n = lit.patches.len();
        let light: Vec<f32> = (0..n).map(|i| lit.arriving.iter().map(|h| h[i]).sum()).collect();
        let mean = light.iter().sum::<f32>() / n as f32;
        let sampler = PatchSampler::new(&lit.patches);
        let extent = |a: usize| {
            let along = || lit.patches.position.iter().map(|p| p[a]);
            along().fold(f32::MIN, f32::max) - along().fold(f32::MAX, f32::min)
        };
        let diagonal = (0..3).map(|a| extent(a).powi(2)).sum::<f32>().sqrt();
        let sobol = Sobol::new(4711);
        for k in 0..100 * LAMPS as u32 {
            let [x, y, z, w] = sobol.sample(k);
            let patch = ((x * n as f32) as usize).min(n - 1);
            let point = sampler.point(patch, y, z);
            let origin = self.rays.off_surface(point.position, point.normal);
            let hit = self.rays.closest(origin, point.normal, f32::INFINITY, point.triangle);
            let free = hit.map_or(0.4 * diagonal, |hit| hit.t);
            if light[patch] > LIT * mean && free > ROOM * diagonal && self.rigs.len() < self.files + LAMPS {
                let at = (origin + (0.3 + 0.4 * w) * free * point.normal).to_array();
                let [x, y, z]: [f64; 3] = std::array::from_fn(|a| f64::from(at[a]) + self.scene.mesh.origin[a]);
                self.rigs
                    .push(format!(r#"{{"lights":[{{"type":"point","position":[{x},{y},{z}],"intensity":[1,1,1]}}]}}"#));
            }
        }
    }

    /// What every bake says of a point: the light of its patch, and what it gathers, one number a light.
    fn ask(&self, number: usize, face: u32, point: &SurfacePoint, lit: &[Lit]) -> Vec<[Vec<f32>; 2]> {
        let origin = self.rays.off_surface(point.position, point.normal);
        let sobol = Sobol::new(hash(5, number as u32));
        let mut gathered = vec![vec![0.0f32; self.rigs.len()]; lit.len()];
        for ray in 0..RAYS {
            let [u, v, ..] = sobol.sample(ray);
            let direction = cosine_direction(point.normal, u, v);
            let Some(hit) = self.rays.closest(origin, direction, f32::INFINITY, point.triangle) else { continue };
            let place = (origin + hit.t * direction).to_array();
            for (lit, sums) in lit.iter().zip(&mut gathered) {
                let met = lit.patches.locator.patch_at(face_id(hit.triangle, hit.side), place);
                if let Some(met) = met {
                    sums.iter_mut().zip(&lit.leaving).for_each(|(s, b)| *s += b[met as usize] / RAYS as f32);
                }
            }
        }
        let own = |lit: &Lit| {
            let patch = lit.patches.locator.patch_at(face, point.position.to_array());
            lit.arriving.iter().map(|h| patch.map_or(0.0, |p| h[p as usize])).collect()
        };
        lit.iter().zip(gathered).map(|(lit, gathered)| [own(lit), gathered]).collect()
    }
}

/// A^{-1/2} K A^{1/2} ρ H⁰ in one channel.
fn received(patches: &Patches, operator: &Operator, direct: &[[f32; 3]], channel: usize) -> Vec<f32> {
    let root: Vec<f64> = patches.area.iter().map(|&a| f64::from(a).sqrt()).collect();
    let sent: Vec<f64> = (0..patches.len())
        .map(|j| root[j] * f64::from(patches.reflectance[j][channel]) * f64::from(direct[j][channel]))
        .collect();
    let row = |i: usize| &operator.channel(channel)[i * operator.n..][..operator.n];
    let sum = |i: usize| row(i).iter().zip(&sent).map(|(k, s)| f64::from(*k) * s).sum::<f64>();
    (0..patches.len()).into_par_iter().map(|i| (sum(i) / root[i]) as f32).collect()
}

/// Points uniform by area, with their faces.
fn points(patches: &Patches) -> Vec<(u32, SurfacePoint)> {
    let mut sum = 0.0;
    let upto: Vec<f64> = patches
        .area
        .iter()
        .map(|&a| {
            sum += f64::from(a);
            sum
        })
        .collect();
    let (sampler, sobol) = (PatchSampler::new(patches), Sobol::new(99));
    (0..POINTS)
        .map(|k| {
            let [x, y, z, _] = sobol.sample(k);
            let patch = upto.partition_point(|&u| u <= f64::from(x) * sum).min(upto.len() - 1);
            let point = sampler.point(patch, y, z);
            let piece = patches.pieces_of(patch).iter().find(|p| p.face / 2 == point.triangle);
            (piece.expect("the point lies on a piece").face, point)
        })
        .collect()
}

/// Geometric mean over lights of the error of one bake; the truth is what the first gathers.
fn mean_error(answers: &[Vec<[Vec<f32>; 2]>], bake: usize, way: usize, lights: std::ops::Range<usize>) -> f64 {
    let error = |light: usize| {
        let pairs = answers.iter().map(|of| [of[bake][way][light], of[0][1][light]].map(f64::from));
        let sums = pairs.fold([0.0, 0.0], |s, [a, t]| [s[0] + (a - t).powi(2), s[1] + t * t]);
        (sums[0] / sums[1]).sqrt()
    };
    let count = lights.len() as f64;
    (lights.map(|light| error(light).ln()).sum::<f64>() / count).exp()
}

/// Opens a bake.
///
/// # Errors
///
/// If it cannot be read.
pub fn open(path: &str) -> Result<Container, Error> {
    Ok(Container::open(Path::new(path))?)
}
