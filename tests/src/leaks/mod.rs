//! The leak suite: scenes with places that no light reaches, or hardly any, and how much a bake puts there.
//!
//! A scene is built in axes of its own (metres, +Y up) and then placed in the world, off the grid of voxels or turned.
//! One file a family of scenes; `measure.rs` bakes them with the program and scores them against its path tracer.

pub mod adaptive;
pub mod back_faces;
pub mod boxes;
pub mod corners;
pub mod curtain;
pub mod measure;
pub mod place;
pub mod sealed;
pub mod solids;
pub mod table;
mod volume;

use serde::Serialize;
use serde_json::{Value, json};

use crate::{
    mesh_text::{MeshText, Paint},
    shapes::Plate,
    workbench::Point,
};
pub use place::Placement;
pub use volume::Volume;

/// All surfaces of all scenes; grey, so that there is one operator to solve.
pub const WALL: Paint = Paint::matt("wall", [0.8; 3]);
/// Places on a plate, to within a millimetre of its edges.
pub const EDGES: [f64; 5] = [0.0004, 0.03, 0.5, 0.97, 0.9996];
/// Places on a plate, evenly.
pub const EVEN: [f64; 4] = [0.125, 0.375, 0.625, 0.875];

/// What is asked of the dark places of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub enum Darkness {
    /// No light reaches the dark places: every one of them must have exactly 0.
    Exact,
    /// Some light goes round: what a bake has more than the path tracer is the leak.
    Excess,
}

/// A scene with dark places.
pub struct LeakScene {
    /// Says what is special, in words of a table.
    pub name: String,
    pub placement: Placement,
    /// Corners of faces, counter-clockwise seen from the front, in axes of the scene.
    pub faces: Vec<Vec<[f64; 3]>>,
    /// As glTF whose vertices are shared and have the mean normal of their faces; OBJ without normals otherwise.
    pub smooth: bool,
    pub one_sided: bool,
    /// Baked with adaptive patches, with uniform ones otherwise.
    pub adaptive: bool,
    /// A bulb, in axes of the scene.
    pub lamp: Option<[f64; 3]>,
    pub sky: bool,
    /// Where it is dark.
    pub dark: Vec<Volume>,
    pub darkness: Darkness,
    /// Places that are asked for their light; the mean of the scene is that of those that are not dark.
    pub points: Vec<Point>,
    /// An eye in the dark and what it looks at.
    pub eye: Option<[[f64; 3]; 2]>,
}

impl LeakScene {
    /// Without anything, exact, lit by a bulb.
    pub fn new(name: String, placement: Placement, lamp: [f64; 3]) -> LeakScene {
        LeakScene {
            name,
            placement,
            faces: Vec::new(),
            smooth: false,
            one_sided: false,
            adaptive: false,
            lamp: Some(lamp),
            sky: false,
            dark: Vec::new(),
            darkness: Darkness::Exact,
            points: Vec::new(),
            eye: None,
        }
    }

    /// Adds plates.
    pub fn plates<'a>(&mut self, plates: impl IntoIterator<Item = &'a Plate>) {
        let corners = |p: &Plate| [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(s, t)| p.at(s, t)).to_vec();
        self.faces.extend(plates.into_iter().map(corners));
    }

    /// Asks for the light of the fronts of plates.
    pub fn ask<'a>(&mut self, plates: impl IntoIterator<Item = &'a Plate>, steps: &[f64]) {
        for plate in plates {
            let normal = plate.normal();
            let at = |&s: &f64| steps.iter().map(move |&t| Point { position: plate.at(s, t), normal });
            self.points.extend(steps.iter().flat_map(at));
        }
    }

    /// Whether a place, in axes of the scene, is one of the dark ones.
    pub fn is_dark(&self, point: &Point) -> bool {
        self.dark.iter().any(|v| v.holds(point))
    }

    /// Its faces in the world.
    pub fn mesh(&self) -> MeshText {
        let mut mesh = MeshText::default();
        for face in &self.faces {
            let corners: Vec<[f64; 3]> = face.iter().map(|&c| self.placement.to_world(c)).collect();
            mesh.polygon(WALL, &corners);
        }
        mesh
    }

    /// Its lights file.
    pub fn lights(&self) -> Value {
        let bulb = |p| json!({ "type": "point", "position": self.placement.to_world(p), "intensity": [10, 10, 10] });
        let sky = self.sky.then(|| json!({ "type": "sky", "radiance": [1, 1, 1] }));
        json!({ "lights": self.lamp.map(bulb).into_iter().chain(sky).collect::<Vec<_>>() })
    }

    /// The camera of its eye.
    pub fn camera(&self) -> Option<Value> {
        let [origin, target] = self.eye?.map(|p| self.placement.to_world(p));
        Some(json!({ "origin": origin, "target": target, "up": [0, 1, 0], "fov_x_deg": 100 }))
    }
}

/// The scenes that are cut open for pictures and bundled with the repository: folder, scene, camera.
pub fn sections() -> [(&'static str, LeakScene, Value); 3] {
    let camera = |origin: [f64; 3], target: [f64; 3], fov: f64| json!({ "origin": origin, "target": target, "up": [0, 1, 0], "fov_x_deg": fov });
    [
        ("rooms", sealed::section(), camera([2.4, 1.1, 7.5], [2.4, 0.95, 0.0], 54.0)),
        ("boxes", boxes::section(), camera([2.2, 1.8, 7.4], [2.2, 0.9, 2.0], 60.0)),
        ("curtain", curtain::section(), camera([2.6, 1.3, 6.6], [2.0, 0.95, 0.0], 50.0)),
    ]
}

/// Every scene of the suite.
pub fn all() -> Vec<LeakScene> {
    let families = [
        sealed::scenes(),
        boxes::scenes(),
        curtain::scenes(),
        corners::scenes(),
        solids::scenes(),
        back_faces::scenes(),
        adaptive::scenes(),
    ];
    families.into_iter().flatten().chain(sections().map(|(_, scene, _)| scene)).collect()
}
