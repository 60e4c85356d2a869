//! A glTF file as the `gltf` crate reads it, with what the crate leaves to its caller: the walk over the nodes, and
//! triangles of strips and fans.

use glam::{DMat4, DVec3};
use gltf::{
    Gltf, Node, Primitive, Semantic,
    accessor::{DataType, Item, Iter},
    mesh::Mode,
};

/// A triangle as the crate reads it.
pub struct Triangle<'a> {
    /// In the scene file's axes.
    pub corners: [DVec3; 3],
    /// Coordinates in the base colour's texture.
    pub uv: Option<[[f32; 2]; 3]>,
    pub material: gltf::Material<'a>,
}

/// A scene as the crate reads it: depth first, in the order of the file.
#[derive(Default)]
pub struct Reading<'a> {
    pub triangles: Vec<Triangle<'a>>,
    /// Lights and their transforms to the world.
    pub lights: Vec<(gltf::khr_lights_punctual::Light<'a>, DMat4)>,
}

impl<'a> Reading<'a> {
    /// The default scene, or else the first.
    pub fn of(file: &'a Gltf) -> Reading<'a> {
        let mut reading = Reading::default();
        let scene = file.default_scene().or_else(|| file.scenes().next()).expect("a scene");
        scene.nodes().for_each(|node| reading.add_node(node, DMat4::IDENTITY, file.blob.as_deref().unwrap_or(&[])));
        reading
    }

    fn add_node(&mut self, node: Node<'a>, parent: DMat4, blob: &[u8]) {
        let local = node.transform().matrix().map(|column| column.map(f64::from));
        let transform = parent * DMat4::from_cols_array_2d(&local);
        for primitive in node.mesh().iter().flat_map(|mesh| mesh.primitives()) {
            self.add_primitive(&primitive, transform, blob);
        }
        self.lights.extend(node.light().map(|light| (light, transform)));
        node.children().for_each(|child| self.add_node(child, transform, blob));
    }

    fn add_primitive(&mut self, primitive: &Primitive<'a>, transform: DMat4, blob: &[u8]) {
        let reader = primitive.reader(|_| Some(blob));
        let positions: Vec<DVec3> =
            positions(primitive, blob).into_iter().map(|p| transform.transform_point3(p)).collect();
        let material = primitive.material();
        let texture = material.pbr_metallic_roughness().base_color_texture();
        // Transforms of coordinates are not this crate's business but its caller's.
        let set = texture.filter(|t| t.texture_transform().is_none()).map(|t| t.tex_coord());
        let uv: Option<Vec<[f32; 2]>> =
            set.and_then(|set| reader.read_tex_coords(set)).map(|uv| uv.into_f32().collect());
        let all = || (0..positions.len() as u32).collect();
        let indices: Vec<u32> = reader.read_indices().map_or_else(all, |i| i.into_u32().collect());
        for [a, b, c] in corner_numbers(primitive.mode(), &indices) {
            let turned = transform.determinant() < 0.0;
            let numbers = if turned { [a, c, b] } else { [a, b, c] }.map(|i| i as usize);
            let uv = uv.as_ref().map(|uv| numbers.map(|i| uv[i]));
            self.triangles.push(Triangle { corners: numbers.map(|i| positions[i]), uv, material: material.clone() });
        }
    }
}

/// The crate's own reader takes all positions for floats; what it iterates over can be chosen, though.
fn positions(primitive: &Primitive, blob: &[u8]) -> Vec<DVec3> {
    fn numbers<T: Item + Copy + Into<f64>>(accessor: gltf::Accessor, blob: &[u8], one: f64) -> Vec<DVec3> {
        let one = if accessor.normalized() { one } else { 1.0 };
        let low = if accessor.normalized() { -1.0 } else { f64::MIN };
        let elements = Iter::<[T; 3]>::new(accessor, |_| Some(blob)).expect("positions");
        elements.map(|p| DVec3::from(p.map(|c| (c.into() / one).max(low)))).collect()
    }
    let accessor = primitive.get(&Semantic::Positions).expect("positions");
    match accessor.data_type() {
        DataType::I8 => numbers::<i8>(accessor, blob, 127.0),
        DataType::U8 => numbers::<u8>(accessor, blob, 255.0),
        DataType::I16 => numbers::<i16>(accessor, blob, 32767.0),
        DataType::U16 => numbers::<u16>(accessor, blob, 65535.0),
        DataType::U32 => numbers::<u32>(accessor, blob, 4_294_967_295.0),
        DataType::F32 => numbers::<f32>(accessor, blob, 1.0),
    }
}

fn corner_numbers(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    let n = indices.len();
    match mode {
        Mode::Triangles => indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
        Mode::TriangleStrip => (2..n).map(|i| [i - 2, i - 1 + i % 2, i - i % 2].map(|k| indices[k])).collect(),
        Mode::TriangleFan => (2..n).map(|i| [i - 1, i, 0].map(|k| indices[k])).collect(),
        _ => vec![],
    }
}
