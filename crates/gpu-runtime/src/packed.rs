//! The two forms of the operator behind one product.

use hmatrix::HMatrix;
use radfile::PackedOperator;

use crate::{
    Gpu, Result,
    hierarchical::Hierarchical,
    kernels::{self, Dispatch},
    operator::Operator,
};

/// An operator as it is stored.
#[derive(Clone, Copy)]
pub enum Packed<'a> {
    /// Block-compressed textures.
    Textures(&'a PackedOperator<'a>),
    /// Hierarchical blocks.
    Hierarchical(&'a HMatrix),
}

impl Packed<'_> {
    /// Patches of the operator.
    pub(crate) fn patches(&self) -> usize {
        match self {
            Packed::Textures(packed) => packed.packing.n as usize,
            Packed::Hierarchical(matrix) => matrix.patches(),
        }
    }
}

impl<'a> From<&'a PackedOperator<'a>> for Packed<'a> {
    fn from(packed: &'a PackedOperator<'a>) -> Packed<'a> {
        Packed::Textures(packed)
    }
}

impl<'a> From<&'a HMatrix> for Packed<'a> {
    fn from(matrix: &'a HMatrix) -> Packed<'a> {
        Packed::Hierarchical(matrix)
    }
}

/// H = A^{-1/2} K x on the device.
pub struct Product {
    dispatches: Vec<Dispatch>,
    /// What patches send, scaled; as long as the form wants it.
    pub x: wgpu::Buffer,
    /// Irradiance of the patches after one and more bounces.
    pub h: wgpu::Buffer,
    /// Bytes of the operator on the device.
    pub bytes: usize,
    /// Bytes of the operator that a product reads; what is read twice counts twice.
    pub bytes_read: usize,
}

impl Product {
    /// Uploads an operator. `factors` holds √A in its fourth component; `sampled` says who decodes textures.
    pub fn new(gpu: &Gpu, packed: Packed, sampled: bool, factors: &wgpu::Buffer, h: wgpu::Buffer) -> Result<Product> {
        match packed {
            Packed::Textures(packed) => {
                let operator = Operator::new(gpu, packed, sampled)?;
                let (x, bytes) = (operator.senders(gpu)?, packed.size_in_bytes());
                let dispatches = operator.prepare(gpu, factors, &x, &h);
                // Half of the matrix is read for rows and for columns.
                let again = if packed.half.is_some() { packed.blocks.len() } else { 0 };
                Ok(Product { dispatches, x, h, bytes, bytes_read: bytes + again })
            }
            Packed::Hierarchical(matrix) => {
                let Hierarchical { x, product, bytes, bytes_read, .. } =
                    Hierarchical::new(gpu, &matrix.layout(), factors, &h)?;
                Ok(Product { dispatches: product.into(), x, h, bytes, bytes_read })
            }
        }
    }

    /// One product.
    pub fn run(&self, encoder: &mut wgpu::CommandEncoder) {
        kernels::run(encoder, "product", &self.dispatches);
    }
}
