//! From senders to receivers: an operator with other rows than columns.

use crate::{HMatrix, Layout, Result, Workspace, hmatrix::dense, stream::Parts};

/// The weights of all senders at all receivers, compressed. Row = receiver, column = sender, each in the order in which
/// they were given.
///
/// It is stored and multiplied with as a symmetric operator is; see [`HMatrix`].
pub struct Rectangle(pub(crate) HMatrix);

impl Rectangle {
    /// Reads what [`Rectangle::to_bytes`] wrote.
    ///
    /// # Errors
    ///
    /// [`crate::Error::Short`], [`crate::Error::Damaged`]. Memory stays within about a hundred times the bytes.
    pub fn from_bytes(bytes: &[u8]) -> Result<Rectangle> {
        Ok(Rectangle(HMatrix::new(&Parts::read(bytes, true)?, bytes.to_vec())))
    }

    /// The packed rows.
    pub fn to_bytes(&self) -> &[u8] {
        self.0.to_bytes()
    }

    /// Number of rows.
    pub fn receivers(&self) -> usize {
        self.0.receivers()
    }

    /// Number of columns.
    pub fn senders(&self) -> usize {
        self.0.patches()
    }

    /// Memory for [`Rectangle::multiply`].
    pub fn workspace(&self) -> Workspace {
        self.0.workspace()
    }

    /// Light of the receivers, `y`, from that of the senders, `x`, each in its order, red, green and blue. Of form factors
    /// it makes irradiance from radiosity. Takes no memory, and gives the same bits on any number of threads.
    ///
    /// # Panics
    ///
    /// If `x`, `y` or the workspace are of another size: a bug in the caller.
    pub fn multiply(&self, x: &[[f32; 3]], y: &mut [[f32; 3]], workspace: &mut Workspace) {
        self.0.multiply(x, y, workspace);
    }

    /// What the product reads.
    pub fn layout(&self) -> Layout<'_> {
        self.0.layout()
    }

    /// The dense matrix in the order of receivers and senders, row-major, from the packed bytes: what judges
    /// [`Rectangle::multiply`]. Takes 8 bytes an entry.
    ///
    /// # Errors
    ///
    /// None for bytes that were read once.
    pub fn decode(&self) -> Result<Vec<f64>> {
        Ok(dense(&Parts::read(self.to_bytes(), true)?, 0))
    }
}
