//! What a container holds that can be drawn.

use anyhow::bail;
use radfile::{Container, FormFactors, Operator, Patches, Permutation, Record};

use crate::session::Session;

/// What brings the dense matrices.
pub const DENSE: &str = "bake, or pack, with --keep-dense to have them";

/// Records of a container.
pub struct Subject<'a> {
    pub container: &'a Container,
    pub session: &'a Session,
    pub patches: Patches,
    pub operator: Option<Operator<'a>>,
    pub factors: Option<FormFactors<'a>>,
    pub packed: Option<relight::Operator<'a>>,
    /// The order that `permute` found.
    pub order: Option<Permutation>,
}

/// A dense matrix over the patches.
pub struct Matrix<'a> {
    /// As docs/design.md §2 calls it.
    pub symbol: &'static str,
    pub n: usize,
    /// n × n each, row-major.
    pub channels: Vec<&'a [f32]>,
}

impl<'a> Subject<'a> {
    pub fn read(container: &'a Container, session: &'a Session) -> anyhow::Result<Subject<'a>> {
        let packed = relight::Operator::is_in(container);
        let (operator, factors) = (container.has("series.values"), container.has("formfactor.values"));
        if !packed && !operator && !factors {
            bail!("it holds neither an operator nor form factors to plot; bake the scene, or run formfactor first");
        }
        let subject = Subject {
            container,
            session,
            patches: Patches::read(container)?,
            operator: operator.then(|| Operator::read(container)).transpose()?,
            factors: factors.then(|| FormFactors::read(container)).transpose()?,
            packed: packed.then(|| relight::Operator::read(container)).transpose()?,
            order: container.has("permute.new_to_old").then(|| Permutation::read(container)).transpose()?,
        };
        if subject.patches.is_empty() {
            bail!("it has no patches, so there is nothing to plot (is the scene empty?)");
        }
        Ok(subject)
    }

    /// Refuses a picture that needs more bytes than are free.
    pub fn ask_memory(&self, bytes: u64) -> anyhow::Result<()> {
        self.session.ask_memory("this picture", bytes, "use fewer patches (--patches N)")
    }

    /// K if it is there, otherwise F.
    pub fn matrix(&self) -> Option<Matrix<'_>> {
        let n = self.patches.len();
        if let Some(k) = &self.operator {
            return Some(Matrix { symbol: "K", n, channels: (0..k.channels).map(|c| k.channel(c)).collect() });
        }
        self.factors.as_ref().map(|f| Matrix { symbol: "F", n, channels: vec![&f.values] })
    }

    /// The patches in the order of the hierarchical blocks, if the operator has such.
    pub fn clusters(&self) -> Option<Vec<u32>> {
        match &self.packed {
            Some(relight::Operator::Hierarchical(matrix, _)) => Some(matrix.layout().order.to_vec()),
            _ => None,
        }
    }

    /// The patches as they are numbered.
    pub fn numbered(&self) -> Vec<u32> {
        (0..self.patches.len() as u32).collect()
    }
}
