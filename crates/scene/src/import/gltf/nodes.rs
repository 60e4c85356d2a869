//! The nodes of the scene, placed in the world, in double precision.

use std::slice;

use glam::{DMat4, DQuat, DVec3};

use super::{accessor::Reader, document::Document, schema::Node};
use crate::Result;

/// A node and its transform to the world.
pub struct Placed<'a> {
    pub node: &'a Node,
    pub transform: DMat4,
}

/// Nodes of the default scene, of all scenes if none is the default, or of the whole file if there are no scenes;
/// depth first, in the order of the file.
pub fn walk<'a>(document: &'a Document) -> Result<Vec<Placed<'a>>> {
    let nodes = &document.root.nodes;
    let mut visited = vec![false; nodes.len()];
    let mut placed = vec![];
    for root in roots(document)? {
        document.get(nodes, root, "node")?;
        if visited[root] {
            continue; // scenes may share their roots
        }
        // A stack of our own: files may be nested deeper than the program's.
        let mut stack = vec![(root, DMat4::IDENTITY)];
        while let Some((index, parent)) = stack.pop() {
            let node = document.get(nodes, index, "node")?;
            if std::mem::replace(&mut visited[index], true) {
                return Err(document.malformed(format!(
                    "node {index} ({:?}) is reached twice, expected a tree: nodes form a cycle or share a child; export it again",
                    node.name
                )));
            }
            let transform = parent * local(node);
            stack.extend(node.children.iter().rev().map(|&child| (child, transform)));
            placed.push(Placed { node, transform });
        }
    }
    Ok(placed)
}

fn roots(document: &Document) -> Result<Vec<usize>> {
    let root = &document.root;
    if root.scenes.is_empty() {
        let mut is_child = vec![false; root.nodes.len()];
        for &child in root.nodes.iter().flat_map(|n| &n.children) {
            document.get(&root.nodes, child, "node")?;
            is_child[child] = true;
        }
        return Ok((0..root.nodes.len()).filter(|&i| !is_child[i]).collect());
    }
    let scenes = match root.scene {
        Some(index) => slice::from_ref(document.get(&root.scenes, index, "scene")?),
        None => &root.scenes[..],
    };
    Ok(scenes.iter().flat_map(|s| s.nodes.iter().copied()).collect())
}

fn local(node: &Node) -> DMat4 {
    match &node.matrix {
        Some(matrix) => DMat4::from_cols_array(matrix),
        None => placement(
            node.translation.unwrap_or([0.0; 3]),
            node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]),
            node.scale.unwrap_or([1.0; 3]),
        ),
    }
}

/// Scale, then rotation, then translation. A rotation of length 0 is none.
fn placement(translation: [f64; 3], rotation: [f64; 4], scale: [f64; 3]) -> DMat4 {
    let length = glam::DVec4::from(rotation).length();
    let rotation = match length > 0.0 && length.is_finite() {
        true => DQuat::from_array(rotation.map(|c| c / length)),
        false => DQuat::IDENTITY,
    };
    DMat4::from_scale_rotation_translation(scale.into(), rotation, DVec3::from(translation))
}

/// Transforms to the world of a node's mesh: one, or as many as `EXT_mesh_gpu_instancing` says.
pub struct Instances<'a> {
    node: DMat4,
    /// Translation, rotation, scale.
    attributes: [Option<Reader<'a>>; 3],
    count: usize,
}

impl Instances<'_> {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Transform `i`.
    pub fn get(&self, i: usize) -> DMat4 {
        let [translation, rotation, scale] = &self.attributes;
        let t = translation.as_ref().map_or([0.0; 3], |r| r.get(i));
        let r = rotation.as_ref().map_or([0.0, 0.0, 0.0, 1.0], |r| r.get(i));
        let s = scale.as_ref().map_or([1.0; 3], |r| r.get(i));
        self.node * placement(t, r, s)
    }
}

/// The instances of a node.
pub fn instances<'a>(document: &'a Document, placed: &Placed) -> Result<Instances<'a>> {
    let single = Instances { node: placed.transform, attributes: [None, None, None], count: 1 };
    let Some(instancing) = &placed.node.extensions.instancing else { return Ok(single) };
    let open = |accessor: Option<usize>, kind| accessor.map(|a| Reader::open(document, a, kind)).transpose();
    let attributes = [
        open(instancing.attributes.translation, "VEC3")?,
        open(instancing.attributes.rotation, "VEC4")?,
        open(instancing.attributes.scale, "VEC3")?,
    ];
    let readers = || attributes.iter().flatten();
    let Some(count) = readers().map(Reader::count).max() else { return Ok(single) };
    if let Some(other) = readers().find(|r| r.count() != count || !r.has_data()) {
        return Err(document.malformed(format!(
            "the instances of node {:?} have {count} of one attribute and {} of another, or no data; export it again",
            placed.node.name,
            other.count()
        )));
    }
    Ok(Instances { attributes, count, ..single })
}
