//! A coarse bake of the same scene, and its light under trial lamps.

use radfile::{Container, Mesh, Operator, Patches, Record};
use rayon::prelude::*;
use scene::{Rays, Scene};

use crate::{
    Error,
    lamps::{Lamp, direct_light},
};

/// Fewest patches that tell where light changes.
const FEWEST: usize = 16;
/// Points of a patch that are tested for shadow, a lamp.
const POINTS: u32 = 16;

/// Patches and operator of a coarse bake.
pub struct Pilot<'a> {
    mesh: Mesh,
    /// Its patches.
    pub(crate) patches: Patches,
    operator: Operator<'a>,
}

impl<'a> Pilot<'a> {
    /// Reads mesh, patches and the dense operator of a container that `formfactor` and `series` were run on.
    ///
    /// # Errors
    ///
    /// [`Error::PilotUnsolved`] without a dense operator, [`Error::PilotBounces`] if it holds some bounces only,
    /// [`Error::PilotTooSmall`], or what the container refuses.
    pub fn read(container: &'a Container) -> Result<Pilot<'a>, Error> {
        if !container.has("series.values") {
            return Err(Error::PilotUnsolved);
        }
        let (mesh, patches) = (Mesh::read(container)?, Patches::read(container)?);
        let operator = Operator::read(container)?;
        operator.check(patches.len())?;
        if let Some(bounces) = operator.bounces {
            return Err(Error::PilotBounces { bounces });
        }
        match patches.len() {
            found if found < FEWEST => Err(Error::PilotTooSmall { found, least: FEWEST }),
            _ => Ok(Pilot { mesh, patches, operator }),
        }
    }

    /// Refuses a pilot of another scene.
    ///
    /// # Errors
    ///
    /// [`Error::PilotOfAnother`].
    pub(crate) fn check(&self, scene: &Scene) -> Result<(), Error> {
        let (found, expected) = (&self.mesh, &scene.mesh);
        let alike = found.one_sided == expected.one_sided
            && found.origin == expected.origin
            && found.triangles == expected.triangles
            && found.positions == expected.positions;
        let [found, expected] = [found, expected].map(|m| m.triangles.len());
        if alike { Ok(()) } else { Err(Error::PilotOfAnother { found, expected }) }
    }

    /// Irradiance of every patch under each lamp after one and more bounces: for every channel patches × lamps.
    pub(crate) fn indirect(&self, lamps: &[Lamp], rays: &Rays, seed: u32) -> [Vec<f32>; 3] {
        let direct = direct_light(&self.patches, lamps, POINTS, rays, seed);
        [0, 1, 2].map(|channel| self.received(&direct, lamps.len(), channel))
    }

    /// A^{-1/2} K A^{1/2} ρ H⁰ in one channel, patches × lamps.
    fn received(&self, direct: &[f32], count: usize, channel: usize) -> Vec<f32> {
        let n = self.patches.len();
        let root: Vec<f64> = self.patches.area.iter().map(|&a| f64::from(a).sqrt()).collect();
        let factor = |j: usize| root[j] * f64::from(self.patches.reflectance[j][channel]);
        let sent: Vec<f64> = (0..n * count).map(|at| factor(at / count) * f64::from(direct[at])).collect();
        let matrix = self.operator.channel(channel);
        let rows = (0..n).into_par_iter().flat_map_iter(|i| {
            let mut sum = vec![0.0; count];
            for (k, sent) in matrix[i * n..][..n].iter().zip(sent.chunks(count)) {
                sum.iter_mut().zip(sent).for_each(|(sum, sent)| *sum += f64::from(*k) * sent);
            }
            sum.into_iter().map(|s| (s / root[i]) as f32).collect::<Vec<_>>()
        });
        rows.collect()
    }
}
