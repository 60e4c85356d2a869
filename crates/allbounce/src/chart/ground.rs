//! What contestants are given: the setting, and dense bakes that several of them share.

use std::{cell::RefCell, collections::BTreeMap, rc::Rc};

use glam::Vec3;
use reference::rivals::Setting;

use super::baked::{self, Dense, Recipe};
use crate::session::Session;

type Bakes = BTreeMap<(u32, Option<u32>), Rc<Dense>>;

/// One scene, its receivers and the bakes of it so far.
pub struct Ground<'a> {
    pub setting: Setting<'a>,
    /// The receivers in the axes of the scene file, metres.
    pub position: &'a [[f64; 3]],
    pub session: &'a Session,
    /// By their patches and those of the bake that made them adaptive.
    baked: RefCell<Bakes>,
}

impl<'a> Ground<'a> {
    pub fn new(setting: Setting<'a>, position: &'a [[f64; 3]], session: &'a Session) -> Ground<'a> {
        Ground { setting, position, session, baked: RefCell::default() }
    }

    /// Diagonal of the box around the scene, metres.
    pub fn diagonal(&self) -> f32 {
        let positions = self.setting.scene.mesh.positions.iter().map(|&p| Vec3::from(p));
        let [low, high] = positions.fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[a, b], p| [a.min(p), b.max(p)]);
        (high - low).length()
    }

    /// The bake of about so many patches with all bounces, made once.
    pub fn all_bounces(&self, patches: u32) -> anyhow::Result<Rc<Dense>> {
        self.made_once(patches, None)
    }

    /// The same of adaptive patches, by a bake of `pilot` uniform ones.
    pub fn adaptive(&self, patches: u32, pilot: u32) -> anyhow::Result<Rc<Dense>> {
        self.made_once(patches, Some(pilot))
    }

    fn made_once(&self, patches: u32, pilot: Option<u32>) -> anyhow::Result<Rc<Dense>> {
        let key = (patches, pilot);
        if let Some(dense) = self.baked.borrow().get(&key) {
            return Ok(dense.clone());
        }
        let pilot = pilot.map(|patches| self.all_bounces(patches)).transpose()?;
        let dense = baked::bake(&Recipe::all_bounces(patches), pilot.as_deref(), &self.setting, self.session)?;
        let dense = Rc::new(dense);
        self.baked.borrow_mut().insert(key, dense.clone());
        Ok(dense)
    }
}
