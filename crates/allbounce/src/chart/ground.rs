//! What contestants are given: the setting, and dense bakes that several of them share.

use std::{cell::RefCell, collections::BTreeMap, rc::Rc};

use glam::Vec3;
use reference::rivals::Setting;

use super::baked::{self, Dense, Recipe};
use crate::session::Session;

/// One scene, its receivers and the bakes of it so far.
pub struct Ground<'a> {
    pub setting: Setting<'a>,
    /// The receivers in the axes of the scene file, metres.
    pub position: &'a [[f64; 3]],
    pub session: &'a Session,
    baked: RefCell<BTreeMap<u32, Rc<Dense>>>,
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
        if let Some(dense) = self.baked.borrow().get(&patches) {
            return Ok(dense.clone());
        }
        let dense = Rc::new(baked::bake(&Recipe::all_bounces(patches), &self.setting, self.session)?);
        self.baked.borrow_mut().insert(patches, dense.clone());
        Ok(dense)
    }
}
