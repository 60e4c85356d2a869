//! A scene with everything that the contestants start from, in one order of patches.

use std::path::Path;

use permute::{Order, Params, order};
use radfile::{Container, FormFactors, Operator, Patches, Permutation, Record};
use scene::Scene;

/// Why a case cannot be read.
pub type Error = Box<dyn std::error::Error>;

/// A scene after the `series` stage.
pub struct Case {
    /// Name in the record.
    pub scene: String,
    pub patches: Patches,
    /// K, dense.
    pub operator: Operator<'static>,
    /// F and what the patches see of the sky.
    pub factors: FormFactors<'static>,
    /// Mesh and materials, which a GPU asks for.
    pub mesh: Scene,
}

impl Case {
    /// Reads a container that `series` wrote, patches in the order that the chain gives them before it packs.
    ///
    /// # Errors
    ///
    /// If a part is missing or broken.
    pub fn read(scene: &str, path: &Path) -> Result<Case, Error> {
        let case = Case::as_it_came(scene, path)?;
        let (found, _) = order(&case.patches, None, &Params { order: Order::NormalHilbert })?;
        Ok(case.reordered(&found))
    }

    /// The same in the order of the file.
    ///
    /// # Errors
    ///
    /// As [`Case::read`].
    pub fn as_it_came(scene: &str, path: &Path) -> Result<Case, Error> {
        let container = Container::open(path)?;
        let (operator, factors) = (Operator::read(&container)?, FormFactors::read(&container)?);
        Ok(Case {
            scene: scene.to_owned(),
            patches: Patches::read(&container)?,
            operator: Operator { values: operator.values.into_owned().into(), ..operator },
            factors: FormFactors { values: factors.values.into_owned().into(), sky: factors.sky.into_owned().into() },
            mesh: Scene::read(&container)?,
        })
    }

    /// Rows, columns and patches in another order.
    pub fn reordered(&self, order: &Permutation) -> Case {
        let operator = &self.operator;
        let mut values = Vec::with_capacity(operator.values.len());
        for channel in 0..operator.channels {
            values.append(&mut order.apply_to_matrix(operator.channel(channel)));
        }
        Case {
            scene: self.scene.clone(),
            patches: self.patches.permuted(order),
            operator: Operator { values: values.into(), ..*operator },
            factors: FormFactors {
                values: order.apply_to_matrix(&self.factors.values).into(),
                sky: order.apply(&self.factors.sky).into(),
            },
            mesh: self.mesh.clone(),
        }
    }

    /// Number of patches.
    pub fn len(&self) -> usize {
        self.patches.len()
    }

    /// Whether there are no patches.
    pub fn is_empty(&self) -> bool {
        self.patches.is_empty()
    }
}
