//! Bakes a scene with the program and holds its dark places against the path tracer.
//!
//! A leak is what a bake has more than the path tracer, direct and indirect, in parts of the scene's mean irradiance. It
//! is measured at points, in both ways that light reaches them, at all receivers of the bake, and in a picture.

use std::{f64::consts::PI, path::Path};

use serde::Serialize;
use serde_json::Value;

use super::{Darkness, LeakScene, WALL};
use crate::{program::allbounce, reference::Table, text, workbench::Point};

/// Edge of a voxel, metres: some 500 patches a scene.
pub const VOXEL: f64 = 0.4;
/// As many adaptive patches.
const PATCHES: &str = "500";
/// Paths of the truth where it is exactly 0, and where it is not.
const PATHS: [&str; 2] = ["64", "8192"];
/// Most receivers that are held against the path tracer where the truth is not 0.
const FEW: usize = 150;

/// Light that should not be there, in parts of the mean irradiance.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Leak {
    /// Mean over the dark places.
    pub mean: f64,
    /// At the worst of them.
    pub worst: f64,
}

/// What a bake of a scene has where it is dark.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Scores {
    pub name: String,
    pub darkness: Darkness,
    /// Dark points and dark receivers.
    pub places: [usize; 2],
    /// Most that the path tracer found at any of them, in parts of the mean.
    pub truth: f64,
    /// Points, `--transfer gather`.
    pub gather: Leak,
    /// Points, `--transfer interpolate`.
    pub interpolate: Leak,
    /// Receivers of the bake.
    pub receivers: Leak,
    /// Mean of a picture taken in the dark.
    pub picture: Option<f64>,
}

/// Bakes, relights, path-traces and compares.
pub fn measure(scene: &LeakScene) -> Scores {
    let folder = tempfile::tempdir().expect("a folder");
    let work = Work { folder: folder.path(), scene };
    let (file, bake) = (work.write_scene(), work.path("bake.rad"));
    let voxel = format!("{VOXEL}m");
    let fine = if scene.adaptive { ["--adaptive", "--patches", PATCHES].as_slice() } else { &["--voxel", &voxel] };
    work.run(&[&["bake", &file, "-o", &bake, "--rays", "512"], fine].concat(), scene.one_sided);

    let world: Vec<Point> = scene.points.iter().map(|p| scene.placement.point(p)).collect();
    let relight = |options: &[&str]| {
        let output = work.path("light.csv");
        let args = ["relight", &bake, "--lights", &work.path("lights.json"), "-o", &output];
        work.run(&[&args[..], options].concat(), false);
        Table::read(Path::new(&output))
    };
    let points = work.write("points.csv", &csv(&world));
    let gathered = relight(&["--points", &points, "--gather-rays", "2048"]);
    let interpolated = relight(&["--points", &points, "--transfer", "interpolate"]);
    let received = relight(&[]);

    let receivers = points_of(&received);
    let mut dark_receivers = of_dark(scene, receivers.iter().map(|p| scene.placement.to_scene(p)));
    if scene.darkness == Darkness::Excess {
        dark_receivers = dark_receivers.iter().copied().step_by(dark_receivers.len().div_ceil(FEW).max(1)).collect();
    }
    let dark_points = of_dark(scene, scene.points.iter().copied());
    let asked: Vec<Point> = world.iter().copied().chain(dark_receivers.iter().map(|&r| receivers[r])).collect();
    let truth = total(&work.truth(&file, &asked));
    let (at_points, at_receivers) = truth.split_at(world.len());
    let lit: Vec<f64> = (0..world.len()).filter(|i| !dark_points.contains(i)).map(|i| at_points[i]).collect();
    let mean = lit.iter().sum::<f64>() / lit.len() as f64;

    let dark_truth: Vec<f64> = dark_points.iter().map(|&i| at_points[i]).collect();
    let leak = |found: &Table, places: &[usize], truth: &[f64]| {
        let found = total(found);
        let excess: Vec<f64> = places.iter().zip(truth).map(|(&i, t)| (found[i] - t).max(0.0) / mean).collect();
        Leak {
            mean: excess.iter().sum::<f64>() / excess.len().max(1) as f64,
            worst: excess.iter().fold(0.0, |a, &b| a.max(b)),
        }
    };
    Scores {
        name: scene.name.clone(),
        darkness: scene.darkness,
        places: [dark_points.len(), dark_receivers.len()],
        truth: dark_truth.iter().chain(at_receivers).fold(0.0, |a: f64, &b| a.max(b)) / mean,
        gather: leak(&gathered, &dark_points, &dark_truth),
        interpolate: leak(&interpolated, &dark_points, &dark_truth),
        receivers: leak(&received, &dark_receivers, at_receivers),
        picture: scene.camera().map(|camera| work.picture(&bake, &camera) / mean),
    }
}

/// A folder and what is measured in it.
struct Work<'a> {
    folder: &'a Path,
    scene: &'a LeakScene,
}

impl Work<'_> {
    /// The truth at points.
    fn truth(&self, file: &str, points: &[Point]) -> Table {
        let (points, output) = (self.write("asked.csv", &csv(points)), self.path("truth.csv"));
        let paths = PATHS[usize::from(self.scene.darkness == Darkness::Excess)];
        let args = ["reference", file, "--lights", &self.path("lights.json"), "--points", &points, "-o", &output];
        self.run(&[&args[..], &["--samples", paths]].concat(), self.scene.one_sided);
        Table::read(Path::new(&output))
    }

    /// Mean irradiance in a picture, W/m².
    fn picture(&self, bake: &str, camera: &Value) -> f64 {
        let (camera, report) = (self.write("camera.json", &camera.to_string()), self.path("picture.json"));
        let (lights, output) = (self.path("lights.json"), self.path("picture.exr"));
        let args = ["render", bake, "--lights", &lights, "--camera", &camera, "-o", &output, "--report", &report];
        self.run(&[&args[..], &["--width", "64", "--height", "48", "--samples", "2"]].concat(), false);
        let report: Value = serde_json::from_str(&std::fs::read_to_string(report).expect("a report")).expect("JSON");
        let radiance = |c: usize| report["mean_radiance"][c].as_f64().expect("a number");
        (0..3).map(|c| PI * radiance(c) / WALL.reflectance[c] / 3.0).sum()
    }

    /// Writes scene and lights; the path of the scene.
    fn write_scene(&self) -> String {
        self.write("lights.json", &self.scene.lights().to_string());
        let mesh = self.scene.mesh();
        if self.scene.smooth {
            let (gltf, buffer) = mesh.smooth_gltf("scene.bin");
            std::fs::write(self.path("scene.bin"), buffer).expect("a file");
            return self.write("scene.gltf", &gltf);
        }
        self.write("scene.mtl", &mesh.mtl());
        self.write("scene.obj", &mesh.obj("scene.mtl"))
    }

    fn run(&self, args: &[&str], one_sided: bool) {
        let further = ["--quiet", "--one-sided"];
        allbounce(args.iter().chain(&further[..1 + usize::from(one_sided)])).done();
    }

    fn path(&self, name: &str) -> String {
        text(&self.folder.join(name))
    }

    fn write(&self, name: &str, contents: &str) -> String {
        std::fs::write(self.folder.join(name), contents).expect(name);
        self.path(name)
    }
}

fn csv(points: &[Point]) -> String {
    let mut csv = String::from("px,py,pz,nx,ny,nz\n");
    for p in points {
        let numbers: Vec<String> = p.position.iter().chain(&p.normal).map(f64::to_string).collect();
        csv += &(numbers.join(",") + "\n");
    }
    csv
}

fn points_of(table: &Table) -> Vec<Point> {
    let columns = ["px", "py", "pz", "nx", "ny", "nz"].map(|name| table.column(name));
    let [x, y, z, nx, ny, nz] = &columns;
    (0..x.len()).map(|i| Point { position: [x[i], y[i], z[i]], normal: [nx[i], ny[i], nz[i]] }).collect()
}

/// Which of the points, in axes of the scene, are dark.
fn of_dark(scene: &LeakScene, points: impl Iterator<Item = Point>) -> Vec<usize> {
    points.enumerate().filter(|(_, p)| scene.is_dark(p)).map(|(i, _)| i).collect()
}

/// Direct and indirect irradiance, mean of the colours.
fn total(table: &Table) -> Vec<f64> {
    table.grey("direct").iter().zip(table.grey("indirect")).map(|(d, i)| d + i).collect()
}
