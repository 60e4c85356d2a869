//! The packed operator of a bake, whatever it is packed as, behind one product.

use hmatrix::{HMatrix, SOLVE_SHARE, Solve};
use radfile::{Certificate, Container, Kernel, PackedOperator, Record};

use crate::{Result, TextureProduct, TextureWorkspace};

/// Section that says a container has hierarchical blocks.
const HIERARCHICAL: &str = "hmatrix.meta";

/// A packed operator, ready for products.
#[allow(clippy::large_enum_variant, reason = "there is one of it")]
pub enum Operator<'a> {
    /// Block-compressed textures.
    Textures(TextureProduct<'a>),
    /// Hierarchical blocks of K or of W.
    Hierarchical(HMatrix, Certificate),
}

/// Memory of a product.
pub enum Workspace {
    /// With textures.
    Textures(TextureWorkspace),
    /// With hierarchical blocks; with those of one bounce, a solve as well.
    Hierarchical(hmatrix::Workspace, Option<Solve>),
}

impl<'a> Operator<'a> {
    /// Reads the operator that a bake was packed with.
    ///
    /// # Errors
    ///
    /// [`crate::Error::Container`] if there is none or it is broken, [`crate::Error::Hierarchical`] for broken blocks.
    pub fn read(container: &'a Container) -> Result<Operator<'a>> {
        if container.has(HIERARCHICAL) {
            let (matrix, certificate) = hmatrix::read(container)?;
            return Ok(Operator::Hierarchical(matrix, certificate));
        }
        Ok(PackedOperator::read(container)?.into())
    }

    /// Whether a container has one.
    pub fn is_in(container: &Container) -> bool {
        container.has(HIERARCHICAL) || PackedOperator::is_in(container)
    }

    /// Number of patches.
    pub fn patches(&self) -> usize {
        match self {
            Operator::Textures(product) => product.packed().packing.n as usize,
            Operator::Hierarchical(matrix, _) => matrix.patches(),
        }
    }

    /// Highest bounce that a frame has; `None` is all.
    pub fn bounces(&self) -> Option<u32> {
        match self {
            Operator::Textures(product) => product.packed().packing.bounces,
            Operator::Hierarchical(_, certificate) => certificate.bounces,
        }
    }

    /// Bytes of the packed operator.
    pub fn size_in_bytes(&self) -> usize {
        match self {
            Operator::Textures(product) => product.packed().size_in_bytes(),
            Operator::Hierarchical(matrix, _) => matrix.to_bytes().len(),
        }
    }

    /// Memory for [`Operator::multiply`].
    pub fn workspace(&self) -> Workspace {
        match self {
            Operator::Textures(product) => Workspace::Textures(product.workspace()),
            Operator::Hierarchical(matrix, certificate) => {
                let solve = (certificate.kernel == Kernel::OneBounce).then(|| Solve::new(matrix.patches()));
                Workspace::Hierarchical(matrix.workspace(), solve)
            }
        }
    }

    /// y = K x in three colours, in the order of patches. Only an operator of one bounce asks for `reflectance`, that of
    /// the patches or another: surfaces may be repainted.
    ///
    /// # Panics
    ///
    /// If anything is of another number of patches, or the workspace of another operator: a bug in the caller.
    pub fn multiply(&self, reflectance: &[[f32; 3]], x: &[[f32; 3]], y: &mut [[f32; 3]], workspace: &mut Workspace) {
        match (self, workspace) {
            (Operator::Textures(product), Workspace::Textures(workspace)) => product.multiply(x, y, workspace),
            (Operator::Hierarchical(matrix, _), Workspace::Hierarchical(workspace, None)) => {
                matrix.multiply(x, y, workspace)
            }
            (Operator::Hierarchical(matrix, certificate), Workspace::Hierarchical(workspace, Some(solve))) => {
                let one_bounce = |x: &[[f32; 3]], y: &mut [[f32; 3]]| matrix.multiply(x, y, workspace);
                solve.all_bounces(one_bounce, reflectance, SOLVE_SHARE * certificate.error_wanted, x, y);
            }
            _ => panic!("the workspace of another operator"),
        }
    }
}

impl<'a> From<PackedOperator<'a>> for Operator<'a> {
    fn from(packed: PackedOperator<'a>) -> Operator<'a> {
        Operator::Textures(TextureProduct::new(packed))
    }
}
