//! The textures as a DDS file, for other tools.

use ddsfile::{AlphaMode, D3D10ResourceDimension, Dds, DxgiFormat, NewDxgiParams};
use radfile::{BlockFormat, PackedOperator};

use crate::{Error, Result};

/// Layers of a texture array that Direct3D 11 and 12 promise.
const MAX_LAYERS: usize = 2048;

/// A DDS file (DX10 header, BC1_UNORM or BC4_UNORM) of all blocks as one texture array
/// ([`PackedOperator::texture_size`]).
///
/// Blocks lie in the order of the container. A DDS file has no place for the rest of the operator (map, scale,
/// outliers, colour): those stay in the `.rad` file.
///
/// # Errors
///
/// [`Error::DdsSize`].
pub fn dds(packed: &PackedOperator) -> Result<Vec<u8>> {
    let [width, height, layers] = packed.texture_size();
    let bytes = [width, height, layers].map(|e| e as usize).iter().product::<usize>() / 2;
    if layers as usize > MAX_LAYERS || u32::try_from(bytes).is_err() {
        return Err(Error::DdsSize { layers: layers as usize, bytes });
    }
    let mut dds = Dds::new_dxgi(NewDxgiParams {
        height,
        width,
        depth: None,
        format: match packed.packing.format {
            BlockFormat::Bc1 => DxgiFormat::BC1_UNorm,
            BlockFormat::Bc4 => DxgiFormat::BC4_UNorm,
        },
        mipmap_levels: None,
        array_layers: Some(layers),
        caps2: None,
        is_cubemap: false,
        resource_dimension: D3D10ResourceDimension::Texture2D,
        alpha_mode: AlphaMode::Unknown,
    })
    .expect("block formats have known sizes");
    dds.data.copy_from_slice(&packed.texture_blocks());
    let mut file = Vec::with_capacity(bytes + 148);
    dds.write(&mut file).expect("writing to memory does not fail");
    Ok(file)
}
