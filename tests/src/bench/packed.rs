//! The operators of this project as contestants.

use hmatrix::{HMatrix, SOLVE_SHARE, Solve, compress, one_bounce};
use radfile::{Kernel, Operator, Permutation, Quiet};
use rayon::prelude::*;
use relight::{TextureProduct, TextureWorkspace};

use super::{
    Product,
    case::{Case, Error},
};

/// Block-compressed textures, decoded by the processor.
pub struct Textures {
    operator: TextureProduct<'static>,
    /// The order that they are packed in, if it is not that of the case, and light in it.
    reordered: Option<(Permutation, [Vec<[f32; 3]>; 2])>,
    workspace: TextureWorkspace,
    /// Frobenius norm of the error of K relative to that of K.
    pub matrix_rms: f64,
}

impl Textures {
    /// By one of the presets of `dxt-pack`.
    ///
    /// # Errors
    ///
    /// Those of [`dxt_pack::pack`].
    pub fn pack(case: &Case, params: &dxt_pack::Params) -> Result<Textures, Error> {
        let (packed, report) = dxt_pack::pack(&case.operator, &case.patches, params, &Quiet)?;
        let operator = TextureProduct::new(packed);
        Ok(Textures {
            workspace: operator.workspace(),
            operator,
            reordered: None,
            matrix_rms: report.errors.ok_or("presets measure their errors")?.matrix_rms,
        })
    }

    /// The same in another order of patches; light still comes and goes in that of the case.
    ///
    /// # Errors
    ///
    /// As [`Textures::pack`].
    pub fn pack_in(order: Permutation, case: &Case, params: &dxt_pack::Params) -> Result<Textures, Error> {
        let textures = Textures::pack(&case.reordered(&order), params)?;
        let light = || vec![[0.0; 3]; case.len()];
        Ok(Textures { reordered: Some((order, [light(), light()])), ..textures })
    }

    /// RMS of the error of codes 0..1 over all entries: what the paper measures its orders by.
    pub fn code_rms(&self, operator: &Operator) -> f64 {
        let (n, packing, decoder) = (operator.n, &self.operator.packed().packing, self.operator.packed().decoder());
        let square = |channel: usize, group: usize| -> f64 {
            let mut rows = vec![0.0; 4 * n];
            decoder.rows(channel, group, &mut rows);
            let first = 4 * group * n;
            let exact = &operator.channel(channel)[first..(first + 4 * n).min(n * n)];
            let code = |value: f32| f64::from(packing.map.encode(value, packing.scale[channel]));
            rows.iter().zip(exact).map(|(found, exact)| (code(*found) - code(*exact)).powi(2)).sum()
        };
        let groups: Vec<f64> = (0..n.div_ceil(4))
            .into_par_iter()
            .map(|group| (0..operator.channels).map(|channel| square(channel, group)).sum())
            .collect();
        (groups.iter().sum::<f64>() / (operator.channels * n * n) as f64).sqrt()
    }

    /// Bytes as stored.
    pub fn bytes(&self) -> usize {
        self.operator.packed().size_in_bytes()
    }
}

impl Product for Textures {
    fn multiply(&mut self, x: &[[f32; 3]], y: &mut [[f32; 3]]) {
        let Textures { operator, reordered, workspace, .. } = self;
        let Some((order, [sent, received])) = reordered else {
            return operator.multiply(x, y, workspace);
        };
        sent.iter_mut().zip(order.new_to_old()).for_each(|(sent, old)| *sent = x[*old as usize]);
        operator.multiply(sent, received, workspace);
        received.iter().zip(order.new_to_old()).for_each(|(received, old)| y[*old as usize] = *received);
    }

    fn for_gpu(&self) -> Option<gpu_runtime::Packed<'_>> {
        Some(self.operator.packed().into())
    }
}

/// Hierarchical blocks of K, or of W and a solve.
pub struct Hierarchical<'a> {
    matrix: HMatrix,
    reflectance: &'a [[f32; 3]],
    workspace: hmatrix::Workspace,
    /// Of one bounce: what solves leave, and their memory.
    solve: Option<(f64, Solve)>,
}

impl<'a> Hierarchical<'a> {
    /// To an error of light.
    ///
    /// # Errors
    ///
    /// Those of [`compress`].
    pub fn pack(case: &'a Case, kernel: Kernel, error: f64) -> Result<Hierarchical<'a>, Error> {
        let params = hmatrix::Params { kernel, ..hmatrix::Params::error(error) };
        let pack = |operator| compress(operator, &case.patches, &params, &Quiet);
        let (matrix, _) = match kernel {
            Kernel::AllBounces => pack(&case.operator)?,
            Kernel::OneBounce => pack(&one_bounce(&case.factors, &case.patches)?)?,
        };
        let solve = (kernel == Kernel::OneBounce).then(|| (SOLVE_SHARE * error, Solve::new(case.len())));
        Ok(Hierarchical { workspace: matrix.workspace(), matrix, reflectance: &case.patches.reflectance, solve })
    }

    /// Bytes as stored.
    pub fn bytes(&self) -> usize {
        self.matrix.to_bytes().len()
    }
}

impl Product for Hierarchical<'_> {
    fn multiply(&mut self, x: &[[f32; 3]], y: &mut [[f32; 3]]) {
        let Hierarchical { matrix, reflectance, workspace, solve } = self;
        let mut once = |x: &[[f32; 3]], y: &mut [[f32; 3]]| matrix.multiply(x, y, workspace);
        match solve {
            None => once(x, y),
            Some((tolerance, solve)) => {
                solve.all_bounces(once, reflectance, *tolerance, x, y);
            }
        }
    }

    fn for_gpu(&self) -> Option<gpu_runtime::Packed<'_>> {
        self.solve.is_none().then_some((&self.matrix).into())
    }
}
