//! Primitives of meshes to triangles, with the texture coordinates that their material asks for.

use glam::DAffine2;

use super::{
    accessor::Reader,
    document::Document,
    material::{MaterialTable, TextureUse},
    schema,
};
use crate::{
    Result,
    import::{
        assembly::{Assembly, Vertex},
        notes::Notes,
    },
};

/// The set of coordinates that a file's lightmap has by custom, as glTF has no word for it.
const LIGHTMAP: usize = 1;

/// Triangles of one primitive, in the mesh's own axes.
pub struct Primitive {
    pub vertices: Vec<Vertex>,
    pub triangles: Vec<[u32; 3]>,
    /// Number of the material in the palette.
    pub material: u32,
}

/// Reads the primitives of a mesh that are made of triangles.
pub fn read_mesh(
    document: &Document,
    index: usize,
    materials: &mut MaterialTable,
    assembly: &Assembly,
    notes: &mut Notes,
) -> Result<Vec<Primitive>> {
    let mesh = document.get(&document.root.meshes, index, "mesh")?;
    let mut primitives = vec![];
    for (i, primitive) in mesh.primitives.iter().enumerate() {
        let whole = Whole { document, primitive, place: format!("primitive {i} of mesh {index} ({:?})", mesh.name) };
        primitives.extend(whole.read(materials, assembly, notes)?);
    }
    Ok(primitives)
}

struct Whole<'a> {
    document: &'a Document<'a>,
    primitive: &'a schema::Primitive,
    /// For messages.
    place: String,
}

impl Whole<'_> {
    fn read(&self, materials: &mut MaterialTable, assembly: &Assembly, notes: &mut Notes) -> Result<Option<Primitive>> {
        let Some(shape) = self.shape(notes)? else { return Ok(None) };
        let Some(&accessor) = self.primitive.attributes.get("POSITION") else {
            notes.count("primitives without positions are ignored", 1);
            return Ok(None);
        };
        let has_view = |a: &schema::Accessor| a.buffer_view.is_some();
        if self.primitive.extensions.draco.is_some()
            && !self.document.root.accessors.get(accessor).is_some_and(has_view)
        {
            return Err(self.document.draco());
        }
        let positions = Reader::open(self.document, accessor, "VEC3")?;
        if !positions.has_data() {
            return Err(self.malformed("has positions without data"));
        }
        let indices = self.indices(&positions, shape, assembly)?;
        if shape == Shape::List && indices.len() % 3 != 0 {
            notes.count("primitives have indices left over after the last triangle", 1);
        }
        self.note_ignored(notes);
        let corners = shape.triangles(&indices);
        let mut used: Vec<u32> = corners.as_flattened().to_vec();
        used.sort_unstable();
        used.dedup();
        let material = materials.get(self.primitive.material, notes)?;
        let uv = [self.uv(&material.reflectance, notes)?, self.uv(&material.emission, notes)?];
        let lightmap = self.lightmap(notes);
        let vertex = |&i: &u32| {
            // Where a material has one texture only, both sets are the same and need to be kept once.
            let at = |k: usize| uv[k].as_ref().or(uv[1 - k].as_ref()).map_or([0.0; 2], |uv| uv.at(i as usize));
            let lightmap_uv = lightmap.as_ref().map(|uv| uv.at(i as usize));
            Vertex { position: positions.get(i as usize), uv: [at(0), at(1)], lightmap_uv }
        };
        let number = |i: u32| used.binary_search(&i).expect("every corner is in the list made of the corners") as u32;
        Ok(Some(Primitive {
            vertices: used.iter().map(vertex).collect(),
            triangles: corners.iter().map(|t| t.map(number)).collect(),
            material: material.number,
        }))
    }

    fn shape(&self, notes: &mut Notes) -> Result<Option<Shape>> {
        match self.primitive.mode.unwrap_or(4) {
            0..=3 => {
                notes.count("primitives of points and lines are ignored", 1);
                Ok(None)
            }
            4 => Ok(Some(Shape::List)),
            5 => Ok(Some(Shape::Strip)),
            6 => Ok(Some(Shape::Fan)),
            mode => Err(self.malformed(&format!("has the mode {mode}, expected 0 to 6"))),
        }
    }

    /// Indices of the primitive, or 0, 1, 2 … where it has none, all below the number of positions.
    fn indices(&self, positions: &Reader, shape: Shape, assembly: &Assembly) -> Result<Vec<u32>> {
        let reader = self.primitive.indices.map(|a| Reader::open(self.document, a, "SCALAR")).transpose()?;
        let count = reader.as_ref().map_or(positions.count(), Reader::count);
        assembly.room_for(shape.count(count))?;
        let Some(reader) = reader else { return Ok((0..positions.count() as u32).collect()) };
        if !reader.is_index() || !reader.has_data() {
            return Err(self.malformed("has indices that are no unsigned integers"));
        }
        let indices: Vec<u32> = (0..count).map(|i| reader.get::<1>(i)[0] as u32).collect();
        match indices.iter().position(|&i| i as usize >= positions.count()) {
            None => Ok(indices),
            Some(at) => Err(self.malformed(&format!(
                "has the index {} at place {at}, expected less than {}, the number of its vertices",
                indices[at],
                positions.count()
            ))),
        }
    }

    fn uv(&self, texture: &Option<TextureUse>, notes: &mut Notes) -> Result<Option<Uv<'_>>> {
        let Some(texture) = texture else { return Ok(None) };
        let reader = self.set(texture.set)?;
        if reader.is_none() {
            notes.count("textured primitives have no texture coordinates and take the first texel's colour", 1);
        }
        Ok(reader.map(|reader| Uv { reader, transform: texture.transform }))
    }

    /// Coordinates of the lightmap. Nothing but a lightmap needs them, so broken ones refuse no scene.
    fn lightmap(&self, notes: &mut Notes) -> Option<Uv<'_>> {
        let read = self.set(LIGHTMAP);
        let broken = usize::from(read.is_err());
        notes.count("coordinates of a lightmap (TEXCOORD_1) that cannot be read are ignored; primitives", broken);
        Some(Uv { reader: read.ok()??, transform: DAffine2::IDENTITY })
    }

    /// The texture coordinates `TEXCOORD_set`, if the primitive has them.
    fn set(&self, set: usize) -> Result<Option<Reader<'_>>> {
        let Some(&accessor) = self.primitive.attributes.get(&format!("TEXCOORD_{set}")) else { return Ok(None) };
        let reader = Reader::open(self.document, accessor, "VEC2")?;
        let positions = self.primitive.attributes.get("POSITION").map(|&a| self.document.root.accessors[a].count);
        match positions == Some(reader.count() as u64) {
            true => Ok(Some(reader)),
            false => Err(self.malformed("has another number of texture coordinates than of positions")),
        }
    }

    fn note_ignored(&self, notes: &mut Notes) {
        let targets = !self.primitive.targets.is_empty();
        notes.count("morph targets are ignored; primitives", usize::from(targets));
        let colours = self.primitive.attributes.keys().any(|name| name.starts_with("COLOR_"));
        notes.count("vertex colours are ignored; primitives", usize::from(colours));
    }

    fn malformed(&self, what: &str) -> crate::Error {
        self.document.malformed(format!("{} {what}; export it again", self.place))
    }
}

/// Coordinates of one texture.
struct Uv<'a> {
    reader: Reader<'a>,
    /// `KHR_texture_transform`.
    transform: DAffine2,
}

impl Uv<'_> {
    /// What the transform makes of vertex `i`; 0 where that is no number.
    fn at(&self, i: usize) -> [f32; 2] {
        let uv = self.transform.transform_point2(self.reader.get::<2>(i).into());
        [uv.x, uv.y].map(|c| c as f32).map(|c| if c.is_finite() { c } else { 0.0 })
    }
}

/// How indices make triangles.
#[derive(Clone, Copy, PartialEq)]
enum Shape {
    List,
    Strip,
    Fan,
}

impl Shape {
    /// How many triangles `n` indices make.
    fn count(self, n: usize) -> usize {
        if self == Shape::List { n / 3 } else { n.saturating_sub(2) }
    }

    /// Source: glTF 2.0 Specification, section 3.7.2.1.
    fn triangles(self, indices: &[u32]) -> Vec<[u32; 3]> {
        match self {
            Shape::List => indices.as_chunks().0.to_vec(),
            Shape::Strip => {
                // Every other triangle is turned, so that all face the same way.
                let turned = |(i, w): (usize, &[u32])| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] };
                indices.windows(3).enumerate().map(turned).collect()
            }
            Shape::Fan => {
                let (first, rest) = indices.split_first().map_or((0, indices), |(&f, r)| (f, r));
                rest.windows(2).map(|w| [w[0], w[1], first]).collect()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_strips_and_fans_make_the_triangles_of_the_specification() {
        let five = [0, 1, 2, 3, 4];
        assert_eq!(Shape::List.triangles(&five), [[0, 1, 2]]);
        assert_eq!(Shape::Strip.triangles(&five), [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
        assert_eq!(Shape::Fan.triangles(&five), [[1, 2, 0], [2, 3, 0], [3, 4, 0]]);
        for shape in [Shape::List, Shape::Strip, Shape::Fan] {
            for n in 0..6 {
                assert_eq!(shape.triangles(&five[..n.min(5)]).len(), shape.count(n.min(5)));
            }
        }
    }
}
