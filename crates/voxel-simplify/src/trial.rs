//! The patches of one voxel size.

use radfile::Progress;
use scene::Rays;

use crate::{
    Error, Mode, Params,
    assemble::assemble,
    clip::clip,
    draft::Draft,
    faces::faces,
    gather::{count_small, gather},
    grid::Grid,
    group::group,
    merge::merge,
    surface::Surface,
    visibility::seen,
};

/// What attempts have in common.
pub struct Bench<'a> {
    pub surface: &'a Surface<'a>,
    pub rays: Rays,
    pub params: &'a Params,
    pub progress: &'a dyn Progress,
}

/// Patches of one voxel size and which of them are kept.
pub struct Trial {
    pub voxel: f32,
    pub draft: Draft,
    /// For every drafted patch, the one that it is part of; `None` if it sees nothing.
    pub owner: Vec<Option<u32>>,
    /// Visibility rays cast.
    pub rays: u64,
    /// Small separate parts that have joined another.
    pub gathered: usize,
}

impl Bench<'_> {
    /// Makes the patches for voxels of `voxel` metres and drops those that see nothing.
    pub fn attempt(&self, voxel: f32, extra_layers: [u32; 3]) -> Result<Trial, Error> {
        let grid = Grid::new(self.surface, voxel, extra_layers)?;
        self.progress.begin(&format!("patches of voxels of {voxel:.4} m"), 1);
        let clips = clip(self.surface, &grid);
        let draft = match self.params.mode {
            Mode::Clusters => {
                let mut sheets = group(self.surface, &grid, &clips);
                let merged = merge(&mut sheets, &grid);
                assemble(self.surface, &grid, &clips, &sheets, &merged)
            }
            Mode::Faces => faces(self.surface, &grid, &clips),
        };
        self.progress.advance(1);
        let count = self.params.visibility_rays;
        let (seen, rays) = seen(&draft.patches, &self.rays, count, self.params.seed, self.progress);
        if !seen.contains(&true) {
            return Err(Error::NothingSeen { patches: seen.len(), rays: count });
        }
        let owner = (0..).zip(&seen).map(|(p, &seen)| seen.then_some(p)).collect();
        Ok(Trial { voxel, draft, owner, rays, gathered: 0 })
    }

    /// Lets small separate parts share patches.
    pub fn gather(&self, trial: &mut Trial) {
        if self.params.mode == Mode::Clusters {
            let before = trial.count();
            trial.owner = gather(&trial.draft.patches, self.surface, &self.rays, &trial.owner, self.params.seed);
            trial.gathered = before - trial.count();
        }
    }
}

impl Trial {
    /// Number of patches.
    pub fn count(&self) -> usize {
        self.owner.iter().zip(0..).filter(|&(&owner, p)| owner == Some(p)).count()
    }

    /// Small patches as a share of all.
    pub fn small_share(&self) -> f64 {
        count_small(&self.draft.patches, &self.owner) as f64 / self.count() as f64
    }
}
