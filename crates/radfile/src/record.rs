//! The list of sections that this version knows, and what a typed record is.

use crate::{
    Accuracy, Builder, Certificate, Container, Error, HierarchicalOperator, Operator, PackedOperator, Packing, Result,
};

/// Every section of this version and the stage that writes it.
/// The same list, with element types, shapes and meaning, stands in `formats/rad.md` §4; a test compares the two.
pub const SECTIONS: &[(&str, &str)] = &[
    ("provenance", "every stage"),
    ("mesh.meta", "voxel-simplify"),
    ("mesh.positions", "voxel-simplify"),
    ("mesh.triangles", "voxel-simplify"),
    ("mesh.material", "voxel-simplify"),
    ("mesh.uv", "voxel-simplify"),
    ("mesh.emission_uv", "voxel-simplify"),
    ("mesh.lightmap_uv", "voxel-simplify"),
    ("materials.meta", "voxel-simplify"),
    ("materials.textures", "voxel-simplify"),
    ("scene.extras", "voxel-simplify"),
    ("patches.meta", "voxel-simplify"),
    ("patches.position", "voxel-simplify"),
    ("patches.normal", "voxel-simplify"),
    ("patches.area", "voxel-simplify"),
    ("patches.reflectance", "voxel-simplify"),
    ("patches.emission", "voxel-simplify"),
    ("patches.piece_start", "voxel-simplify"),
    ("patches.piece_corners", "voxel-simplify"),
    ("patches.piece_face", "voxel-simplify"),
    ("patches.face_start", "voxel-simplify"),
    ("patches.cell_key", "voxel-simplify"),
    ("patches.cell_patch", "voxel-simplify"),
    ("patches.cut_plane", "voxel-simplify"),
    ("patches.cut_child", "voxel-simplify"),
    ("formfactor.values", "formfactor"),
    ("formfactor.sky", "formfactor"),
    ("series.meta", "series"),
    ("series.values", "series"),
    ("permute.new_to_old", "permute"),
    ("pack.meta", "dxt-pack"),
    ("pack.blocks", "dxt-pack"),
    ("pack.outlier_start", "dxt-pack"),
    ("pack.outlier_column", "dxt-pack"),
    ("pack.outlier_value", "dxt-pack"),
    ("pack.half", "dxt-pack"),
    ("pack.half_blocks", "dxt-pack"),
    ("pack.half_start", "dxt-pack"),
    ("pack.half_column", "dxt-pack"),
    ("pack.half_value", "dxt-pack"),
    ("pack.half_component", "dxt-pack"),
    ("pack.half_scale", "dxt-pack"),
    ("pack.half_codes", "dxt-pack"),
    ("pack.half_core", "dxt-pack"),
    ("hmatrix.meta", "hmatrix"),
    ("hmatrix.blocks", "hmatrix"),
    ("elements.start", "transfer"),
    ("elements.area", "transfer"),
    ("elements.reflectance", "transfer"),
    ("elements.point_start", "transfer"),
    ("elements.point", "transfer"),
    ("elements.point_face", "transfer"),
    ("elements.grid_origin", "transfer"),
    ("elements.edge", "transfer"),
    ("elements.cell_start", "transfer"),
    ("elements.cell_key", "transfer"),
    ("elements.cell_element", "transfer"),
    ("transfer.position", "transfer"),
    ("transfer.normal", "transfer"),
    ("transfer.row_start", "transfer"),
    ("transfer.patch", "transfer"),
    ("transfer.weight", "transfer"),
    ("transfer.gather_meta", "transfer"),
    ("transfer.gather", "transfer"),
    ("transfer.sky", "transfer"),
    ("transfer.fine_vertex", "transfer"),
    ("transfer.fine_triangle", "transfer"),
    ("transfer.fine_source", "transfer"),
    ("transfer.fine_receiver", "transfer"),
    ("lightmap.meta", "transfer"),
    ("lightmap.corner_uv", "transfer"),
    ("lightmap.texel", "transfer"),
    ("lightmap.position", "transfer"),
    ("lightmap.normal", "transfer"),
    ("lightmap.triangle", "transfer"),
    ("lightmap.receiver", "transfer"),
    ("lightmap.gather_meta", "transfer"),
    ("lightmap.gather", "transfer"),
    ("lightmap.sky", "transfer"),
    ("volume.meta", "transfer"),
    ("volume.cell", "transfer"),
    ("volume.position", "transfer"),
    ("volume.probe", "transfer"),
    ("volume.gather_meta", "transfer"),
    ("volume.gather", "transfer"),
    ("volume.sky", "transfer"),
    ("accuracy.meta", "bake"),
];

/// Sections that later minor versions brought, from 1.1 on; all others are those of 1.0.
const SINCE: [&[&str]; 4] = [
    &["patches.cut_plane", "patches.cut_child"],
    &[
        "pack.half",
        "pack.half_blocks",
        "pack.half_start",
        "pack.half_column",
        "pack.half_value",
        "pack.half_component",
        "pack.half_scale",
        "pack.half_codes",
        "pack.half_core",
        "hmatrix.meta",
        "hmatrix.blocks",
    ],
    &[
        "mesh.lightmap_uv",
        "lightmap.meta",
        "lightmap.corner_uv",
        "lightmap.texel",
        "lightmap.position",
        "lightmap.normal",
        "lightmap.triangle",
        "lightmap.receiver",
        "lightmap.gather_meta",
        "lightmap.gather",
        "lightmap.sky",
        "volume.meta",
        "volume.cell",
        "volume.position",
        "volume.probe",
        "volume.gather_meta",
        "volume.gather",
        "volume.sky",
        "elements.start",
        "elements.area",
        "elements.reflectance",
        "elements.point_start",
        "elements.point",
        "elements.point_face",
        "elements.grid_origin",
        "elements.edge",
        "elements.cell_start",
        "elements.cell_key",
        "elements.cell_element",
        "transfer.gather_meta",
        "transfer.gather",
        "transfer.sky",
    ],
    &["accuracy.meta"],
];

/// The minor version that brought a section; 0 for those that no version knows.
pub fn minor_of(section: &str) -> u16 {
    SINCE.iter().position(|brought| brought.contains(&section)).map_or(0, |at| at as u16 + 1)
}

/// Whether a section holds the operator packed in some way, or tells what it is worth: whoever packs it anew, or changes
/// what was packed, drops it.
pub fn rests_on_operator(section: &str) -> bool {
    let prefixes = [PackedOperator::PREFIX, HierarchicalOperator::PREFIX, Accuracy::PREFIX];
    prefixes.iter().any(|prefix| section.starts_with(prefix))
}

/// Whether a section is handed on by who packs the operator: what [`rests_on_operator`] is not, and the dense operator and
/// the form factors only if `keep_dense`.
pub fn outlasts_packing(section: &str, keep_dense: bool) -> bool {
    let dense = section.starts_with(Operator::PREFIX) || section == "formfactor.values";
    !rests_on_operator(section) && (keep_dense || !dense)
}

/// The highest bounce of a container's operator, packed or dense; `None` if it holds all, or there is no operator.
///
/// # Errors
///
/// Metadata that cannot be read.
pub fn bounces_held(container: &Container) -> Result<Option<u32>> {
    if container.has("hmatrix.meta") {
        return Ok(container.meta::<Certificate>("hmatrix.meta")?.bounces);
    }
    if container.has("pack.meta") {
        return Ok(container.meta::<Packing>("pack.meta")?.bounces);
    }
    Ok(if container.has("series.meta") { Operator::read(container)?.bounces } else { None })
}

/// The stage that writes a section, if this version knows it.
pub fn stage_of(section: &str) -> Option<&'static str> {
    SECTIONS.iter().find(|(name, _)| *name == section).map(|(_, stage)| *stage)
}

/// Typed values that are read from and written to the sections of a container.
///
/// `read` establishes the invariants once, so the rest of the program may trust them.
pub trait Record<'a>: Sized {
    /// First part of the names of its sections, such as `patches.`.
    const PREFIX: &'static str;

    /// Reads and checks the record. Large arrays stay views into the container.
    ///
    /// # Errors
    ///
    /// A missing or misshapen section, or the first broken invariant.
    fn read(container: &'a Container) -> Result<Self>;

    /// Adds the record's sections to a container being built.
    fn write<'b>(&'b self, builder: &mut Builder<'b>);
}

/// Checks that a record over `n` patches and the patches of the same container, if there are any, agree.
pub(crate) fn check_patch_count(container: &Container, record: &'static str, n: usize) -> Result<()> {
    const AREA: &str = "patches.area";
    if !container.has(AREA) {
        return Ok(());
    }
    let patches = container.array_of::<f32>(AREA, &[None])?.len();
    if patches == n {
        return Ok(());
    }
    Err(Error::invariant(record, format!("made for {n} patches, the file holds {patches}; run its stage again")))
}
