// SPDX-License-Identifier: MIT OR Apache-2.0
//
// colour.wgsl: what the three steps of colour of low rank share. Joined before colour_gather.wgsl, colour_core.wgsl
// and colour_scatter.wgsl; holds no entry point.
//
// twin       ColourBlock in crates/radfile/src/half.rs, its product in crates/relight/src/textures.rs
// units      1
// layout     columns of U of all components, one component after the other; a word holds four codes of a column,
//            signed bytes, and every column starts with a word

struct Column {
    // Word of its first code.
    codes: u32,
    // Its component: first member, number of members, first column, number of columns, first entry of the cores.
    members: u32,
    count: u32,
    first: u32,
    rank: u32,
    core: u32,
}

struct Member {
    patch_number: u32,
    // What a code of 1 is worth.
    scale: f32,
    // First column of its component.
    first: u32,
}
