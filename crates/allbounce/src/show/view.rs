//! The patches of a container as a camera sees them.

use std::path::{Path, PathBuf};

use anyhow::Context;
use radfile::{Container, Patches, Record};
use relight::{SeenPatch, seen_patches};
use scene::{Rays, Scene};

use crate::{files, runtime, session::Session};

/// Places along each side of a pixel.
const FINER: usize = 3;
/// What is seen at its places, and its colour.
const BYTES_A_PIXEL: u64 = (FINER * FINER * size_of::<Option<SeenPatch>>() + 32) as u64;

/// What is looked at, and from where.
#[derive(clap::Args)]
pub struct Eye {
    /// Container of any stage that has patches
    #[arg(value_name = "CONTAINER.rad")]
    container: PathBuf,
    /// Camera, JSON; `scene` takes the first camera of the scene file
    #[arg(long, value_name = "C.json")]
    camera: PathBuf,
    /// Pixels in a row
    #[arg(long, default_value_t = 512, value_parser = clap::value_parser!(u16).range(1..=16384))]
    width: u16,
    /// Rows
    #[arg(long, default_value_t = 512, value_parser = clap::value_parser!(u16).range(1..=16384))]
    height: u16,
}

/// A container, and which of its patches is seen where.
pub struct View {
    pub container: Container,
    pub scene: Scene,
    pub rays: Rays,
    pub patches: Patches,
    pub width: usize,
    pub height: usize,
    /// On a grid [`FINER`] than the picture.
    seen: Vec<Option<SeenPatch>>,
}

impl Eye {
    /// Opens the container and looks at it. `others` are what is read besides, `output` is where the picture goes.
    pub fn look(&self, others: &[(&str, &Path)], output: &Path, session: &Session) -> anyhow::Result<View> {
        let inputs = [&[("the container", self.container.as_path()), ("the camera", &self.camera)], others].concat();
        files::check_outputs(&session.outputs(output), &inputs)?;
        let [width, height] = [self.width, self.height].map(usize::from);
        let bytes = (width * height) as u64 * BYTES_A_PIXEL;
        session.ask_memory("the picture", bytes, "make it smaller (--width, --height)")?;
        let container = files::open(&self.container)?;
        let scene = Scene::read(&container).with_context(|| self.name())?;
        let patches = Patches::read(&container).with_context(|| self.name())?;
        let camera = runtime::camera(&self.camera, &scene)?;
        let rays = Rays::new(&scene.mesh);
        let seen = seen_patches(&scene, &rays, &patches.locator, &camera, [FINER * width, FINER * height]);
        Ok(View { container, scene, rays, patches, width, height, seen })
    }

    /// The container's name, for errors.
    pub fn name(&self) -> String {
        self.container.display().to_string()
    }
}

impl View {
    /// The patch in the middle of a pixel.
    pub fn patch_at(&self, [x, y]: [usize; 2]) -> Option<u32> {
        self.seen[self.place([x, y], FINER / 2, FINER / 2)].map(|seen| seen.patch)
    }

    /// How many different patches are seen.
    pub fn count_seen(&self) -> usize {
        let mut seen = vec![false; self.patches.len()];
        self.seen.iter().flatten().for_each(|s| seen[s.patch as usize] = true);
        seen.iter().filter(|s| **s).count()
    }

    /// The picture: means over the places of each pixel. `colour` is told what is seen at a place, and whether the place
    /// is at the border of its patch.
    pub fn picture(&self, colour: impl Fn(Option<SeenPatch>, bool) -> [f32; 3]) -> Vec<[f32; 3]> {
        let pixel = |x: usize, y: usize| {
            let places = (0..FINER * FINER).map(|k| self.place([x, y], k % FINER, k / FINER));
            let sum = places.fold([0.0; 3], |sum: [f32; 3], place| {
                let colour = colour(self.seen[place], self.is_border(place));
                std::array::from_fn(|c| sum[c] + colour[c])
            });
            sum.map(|s| s / (FINER * FINER) as f32)
        };
        (0..self.height).flat_map(|y| (0..self.width).map(move |x| pixel(x, y))).collect()
    }

    fn place(&self, [x, y]: [usize; 2], dx: usize, dy: usize) -> usize {
        (y * FINER + dy) * self.width * FINER + x * FINER + dx
    }

    /// Whether another patch is seen next to a place.
    fn is_border(&self, place: usize) -> bool {
        let (width, patch) = (self.width * FINER, |at: usize| self.seen[at].map(|s| s.patch));
        let (x, own) = (place % width, patch(place));
        (x > 0 && patch(place - 1) != own)
            || (x + 1 < width && patch(place + 1) != own)
            || (place >= width && patch(place - width) != own)
            || (place + width < self.seen.len() && patch(place + width) != own)
    }
}
