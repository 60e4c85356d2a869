//! A folder for one physics test: a scene goes in as a file, what the program makes of it comes out.

use std::path::{Path, PathBuf};

use radfile::{Builder, Container, Patches, Record};
use serde_json::Value;
use tempfile::TempDir;

use crate::{mesh_text::MeshText, program::allbounce, reference::Table, text};

/// A point of a surface that is asked for its light.
#[derive(Clone, Copy, Debug, serde::Deserialize)]
pub struct Point {
    /// In the axes of the scene, metres.
    pub position: [f64; 3],
    /// Of the side that is meant.
    pub normal: [f64; 3],
}

/// Irradiance in one colour, W/m², a number a point.
pub struct Light {
    pub direct: Vec<f64>,
    pub indirect: Vec<f64>,
}

/// Error that packing may add: little, as physics is what is tested.
const PACKING: &str = "0.1%";

/// The scene file and what was made of it.
pub struct Workbench {
    folder: TempDir,
}

impl Workbench {
    /// Writes the scene.
    pub fn new(mesh: &MeshText) -> Workbench {
        let bench = Workbench { folder: tempfile::tempdir().expect("a folder") };
        bench.write("room.obj", &mesh.obj("room.mtl"));
        bench.write("room.mtl", &mesh.mtl());
        bench
    }

    /// Form factors: the first two stages. `patches` is `--patches N` or `--voxel L`.
    pub fn form_factors(&self, patches: [&str; 2], rays: u32) -> Container {
        let (simple, factors) = (self.file("patches.rad"), self.file("factors.rad"));
        let [size, value] = patches;
        allbounce(["voxel-simplify", &text(&self.file("room.obj")), "-o", &text(&simple), size, value, "-q"]).done();
        allbounce(["formfactor", &text(&simple), "-o", &text(&factors), "--rays", &rays.to_string(), "-q"]).done();
        open(&factors)
    }

    /// A bake; keeps the dense matrices.
    pub fn bake(&self, options: &[&str]) -> Container {
        let output = self.baked();
        let (scene, bake) = (text(&self.file("room.obj")), text(&output));
        let fine = ["--operator-error", PACKING];
        allbounce(
            ["bake", &scene, "-o", &bake, "--keep-dense", "--transfer", "interpolate", "-q"]
                .iter()
                .chain(&fine)
                .chain(options),
        )
        .done();
        open(&output)
    }

    /// Where a bake lies.
    pub fn baked(&self) -> PathBuf {
        self.file("bake.rad")
    }

    /// A bake stage by stage, the patches altered by `change` before anything is computed from them.
    ///
    /// Leaves a report of every stage; see [`Workbench::report`].
    pub fn bake_in_stages(
        &self,
        simplify: &[&str],
        formfactor: &[&str],
        change: impl FnOnce(&mut Patches),
    ) -> Container {
        let stage = |stage: &str, input: &Path, options: &[&str]| {
            let output = self.file(&format!("{stage}.rad"));
            let (from, to) = (text(input), text(&output));
            let report = text(&self.file(&format!("{stage}.json")));
            allbounce([stage, &from, "-o", &to, "--report", &report, "-q"].iter().chain(options)).done();
            output
        };
        let simple = stage("voxel-simplify", &self.file("room.obj"), simplify);
        let altered = self.file("altered.rad");
        let container = open(&simple);
        let mut patches = Patches::read(&container).expect("patches");
        change(&mut patches);
        let mut builder = Builder::from_input(&container, |section| !section.name.starts_with(Patches::PREFIX));
        patches.write(&mut builder);
        builder.write_file(&altered).expect("a file");
        let solved = stage("series", &stage("formfactor", &altered, formfactor), &[]);
        let fine = ["--operator-error", PACKING, "--keep-dense"];
        let packed = stage("hmatrix", &stage("permute", &solved, &[]), &fine);
        let bake = self.baked();
        std::fs::rename(stage("transfer", &packed, &[]), &bake).expect("the bake");
        open(&bake)
    }

    /// What a stage of [`Workbench::bake_in_stages`] reported.
    pub fn report(&self, stage: &str) -> Value {
        let file = self.file(&format!("{stage}.json"));
        serde_json::from_str(&std::fs::read_to_string(&file).expect("a report")).expect("JSON")
    }

    /// Light at points through the program, one entry a colour.
    pub fn relight(&self, lights: &Value, points: &[Point], options: &[&str]) -> [Light; 3] {
        let mut csv = String::from("px,py,pz,nx,ny,nz\n");
        for p in points {
            let numbers: Vec<String> = p.position.iter().chain(&p.normal).map(|x| x.to_string()).collect();
            csv += &(numbers.join(",") + "\n");
        }
        let (bake, output) = (text(&self.baked()), self.file("light.csv"));
        let (lights, points) = (self.write("lights.json", &lights.to_string()), self.write("points.csv", &csv));
        let args = ["relight", &bake, "--lights", &lights, "--points", &points, "-o", &text(&output), "-q"];
        allbounce(args.iter().chain(options)).done();
        let table = Table::read(&output);
        ["r", "g", "b"].map(|c| Light {
            direct: table.column(&format!("direct_{c}")),
            indirect: table.column(&format!("indirect_{c}")),
        })
    }

    /// Holds the bake against the identities of transport.
    pub fn verify(&self) {
        allbounce(["verify", &text(&self.baked())]).done();
    }

    fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes a file and returns its path.
    fn write(&self, name: &str, contents: &str) -> String {
        std::fs::write(self.file(name), contents).expect(name);
        text(&self.file(name))
    }
}

fn open(path: &Path) -> Container {
    Container::open(path).expect("a container")
}
