//! A bake, ready for frames.

use radfile::{Elements, FormFactors, Patches, Progress};
use scene::{ElementPoints, LightRig, Rays, Scene, Surfaces};

use crate::{
    DirectLight, Operator, PatchSamples, bounces, element_irradiance,
    error::{Error, Result},
    indirect,
};

/// The parts of a bake that a frame needs; they are known to fit together.
pub struct Relighter<'a> {
    scene: &'a Scene,
    surfaces: Surfaces<'a>,
    rays: &'a Rays,
    patches: &'a Patches,
    elements: &'a Elements,
    operator: &'a Operator<'a>,
    sky: &'a [f32],
    /// Those that the elements have; where they have none, each frame draws as many as it is asked for.
    points: Option<ElementPoints>,
}

/// Light of the patches in one frame, W/m².
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// Direct irradiance H⁰ of their elements.
    pub element_direct: Vec<[f32; 3]>,
    /// Direct irradiance H⁰.
    pub direct: Vec<[f32; 3]>,
    /// Irradiance after one and more bounces.
    pub indirect: Vec<[f32; 3]>,
}

impl<'a> Relighter<'a> {
    /// Ties a bake together. `rays` are over the triangles of `scene`, `sky` is [`radfile::read_sky`].
    ///
    /// # Errors
    ///
    /// [`Error::PatchCount`] if operator, elements or sky are of another number of patches,
    /// [`Error::Scene`] if a texture cannot be decoded.
    pub fn new(
        scene: &'a Scene,
        rays: &'a Rays,
        patches: &'a Patches,
        elements: &'a Elements,
        operator: &'a Operator<'a>,
        sky: &'a [f32],
    ) -> Result<Relighter<'a>> {
        same_count("the packed operator", operator.patches(), patches)?;
        same_count("the elements", elements.patches(), patches)?;
        same_count("the sky visibility", sky.len(), patches)?;
        let surfaces = Surfaces::new(&scene.mesh, &scene.materials)?;
        let points = (!elements.point.is_empty()).then(|| ElementPoints::new(&scene.mesh, patches, elements, 0));
        Ok(Relighter { scene, surfaces, rays, patches, elements, operator, sky, points })
    }

    /// The lights of a rig over the bake's scene.
    pub fn direct_light(&self, rig: &LightRig) -> DirectLight<'_> {
        DirectLight::new(self.scene, &self.surfaces, self.rays, rig)
    }

    /// Direct and indirect irradiance of the patches under the lights, all bounces of the operator.
    pub fn frame(&self, light: &DirectLight, samples: &PatchSamples, progress: &dyn Progress) -> Frame {
        let element_direct = self.element_light(light, samples, progress);
        let direct = self.elements.mean(&element_direct);
        let indirect = indirect(self.patches, self.operator, &direct);
        Frame { element_direct, direct, indirect }
    }

    /// As [`Relighter::frame`], with exactly the first `count` bounces.
    ///
    /// # Errors
    ///
    /// [`Error::PatchCount`] if the form factors are of another number of patches.
    pub fn frame_of_bounces(
        &self,
        light: &DirectLight,
        factors: &FormFactors,
        count: u32,
        samples: &PatchSamples,
        progress: &dyn Progress,
    ) -> Result<Frame> {
        same_count("the form-factor matrix", factors.len(), self.patches)?;
        let element_direct = self.element_light(light, samples, progress);
        let direct = self.elements.mean(&element_direct);
        let indirect = bounces(self.patches, factors, &direct, count);
        Ok(Frame { element_direct, direct, indirect })
    }

    /// Direct irradiance H⁰ of the elements, W/m².
    pub fn element_light(&self, light: &DirectLight, samples: &PatchSamples, progress: &dyn Progress) -> Vec<[f32; 3]> {
        let drawn = || ElementPoints::new(&self.scene.mesh, self.patches, self.elements, samples.points);
        let light_at =
            |points: &ElementPoints| element_irradiance(light, self.elements, points, self.sky, samples.area, progress);
        self.points.as_ref().map_or_else(|| light_at(&drawn()), light_at)
    }

    /// The scene of the bake.
    pub fn scene(&self) -> &Scene {
        self.scene
    }

    /// Reflectance and emission of the scene's surfaces.
    pub fn surfaces(&self) -> &Surfaces<'a> {
        &self.surfaces
    }

    /// Ray queries over the scene.
    pub fn rays(&self) -> &Rays {
        self.rays
    }

    /// What the patches of the bake are parted into.
    pub fn elements(&self) -> &Elements {
        self.elements
    }

    /// The patches of the bake.
    pub fn patches(&self) -> &Patches {
        self.patches
    }
}

fn same_count(part: &'static str, found: usize, patches: &Patches) -> Result<()> {
    if found == patches.len() { Ok(()) } else { Err(Error::PatchCount { part, found, expected: patches.len() }) }
}
