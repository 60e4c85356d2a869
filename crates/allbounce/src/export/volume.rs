//! The irradiance volume of a bake: a texture for Bevy, and plain numbers.
//!
//! Bevy's `IrradianceVolume` is a texture of nx × 2 ny × 3 nz texels. Its shader (`bevy_pbr`, irradiance_volume.wgsl)
//! takes for a normal n the three faces that look along n, those of x from slab 0, of y from slab 1, of z from slab 2,
//! with rows 0 to ny − 1 where the component of n is not negative and ny to 2 ny − 1 where it is; weighs them with
//! n_x², n_y², n_z²; and multiplies with diffuse colour and intensity. So a texel is irradiance over π, what a white
//! surface reflects. The texture fills a cube of edge 1 around the origin, which the entity's transform brings to its
//! place.

use std::{f32::consts::PI, path::Path};

use exr::prelude::f16;
use radfile::{Gathered, Record, Volume};
use relight::Receivers;
use serde::Serialize;
use serde_json::{Value, json};

use super::{Lit, ktx2::ktx2, total};
use crate::files;

const TEXTURE: &str = FILES[0];
const DESCRIPTION: &str = FILES[1];
const CUBES: &str = FILES[2];
const HARMONICS: &str = FILES[3];
/// What [`write()`] writes.
pub const FILES: [&str; 4] = ["volume.ktx2", "volume.json", "volume.raw", "volume_sh.raw"];

/// Irradiance of planes that face +x, −x, +y, −y, +z and −z.
type Cube = [[f32; 3]; 6];

/// What was written, for people.
#[derive(Serialize)]
pub struct Report {
    cells: [u32; 3],
    probes: usize,
    mean_irradiance: [f64; 3],
    largest_irradiance: f32,
    /// The intensity that Bevy's component needs.
    intensity: f32,
}

pub fn write(lit: &Lit, folder: &Path) -> anyhow::Result<Report> {
    let volume = Volume::read(&lit.bake.container)?;
    let gathered = Gathered::read(&lit.bake.container, Volume::PREFIX, volume.receivers())?;
    let receivers = Receivers::gathered(&gathered, lit.bake.elements.senders())?;
    let irradiance = total(&lit.at(&transfer::probe_receivers(&volume), &receivers)?);
    let cubes = volume.fill(&irradiance);
    let largest = irradiance.as_flattened().iter().fold(0.0f32, |m, &e| m.max(e));
    let intensity = intensity(largest / PI);
    let texels = atlas(volume.count, &cubes, 1.0 / (PI * intensity));
    let write = |name: &str, bytes: &[u8]| files::write(&folder.join(name), bytes);
    write(TEXTURE, &ktx2(atlas_size(volume.count), &texels))?;
    write(CUBES, &bytes(&cubes))?;
    write(HARMONICS, &bytes(&cubes.iter().map(linear).collect::<Vec<_>>()))?;
    let mut description = serde_json::to_vec_pretty(&describe(&volume, lit.bake.scene.mesh.origin, intensity))?;
    description.push(b'\n');
    write(DESCRIPTION, &description)?;
    let mean = |c: usize| irradiance.iter().map(|e| f64::from(e[c])).sum::<f64>() / irradiance.len() as f64;
    Ok(Report {
        cells: volume.count,
        probes: volume.probes(),
        mean_irradiance: std::array::from_fn(mean),
        largest_irradiance: largest,
        intensity,
    })
}

/// 1, or the power of two that brings the largest value into half precision.
fn intensity(largest: f32) -> f32 {
    let limit = f16::MAX.to_f32();
    std::iter::successors(Some(1.0f32), |i| Some(2.0 * i)).find(|i| largest / i <= limit).unwrap_or(1.0)
}

fn atlas_size([x, y, z]: [u32; 3]) -> [u32; 3] {
    [x, 2 * y, 3 * z]
}

/// The texels of Bevy's texture, the first extent fastest.
fn atlas(count: [u32; 3], cubes: &[Cube], factor: f32) -> Vec<[f16; 4]> {
    let [nx, ny, nz] = count.map(|n| n as usize);
    let texel = |direction: usize, cell: usize| {
        let [r, g, b] = cubes[cell][direction].map(|e| f16::from_f32(e * factor));
        [r, g, b, f16::ONE]
    };
    let row = |direction: usize, y: usize, z: usize| (0..nx).map(move |x| texel(direction, x + nx * (y + ny * z)));
    let layer = |axis: usize, z: usize| {
        (0..2).flat_map(move |negative| (0..ny).flat_map(move |y| row(2 * axis + negative, y, z)))
    };
    (0..3).flat_map(|axis| (0..nz).flat_map(move |z| layer(axis, z))).collect()
}

/// a, b_x, b_y and b_z of E(n) ≈ a + b · n: the least squares of the six irradiances.
fn linear(cube: &Cube) -> [[f32; 3]; 4] {
    let a = std::array::from_fn(|c| cube.iter().map(|e| e[c]).sum::<f32>() / 6.0);
    let b = |axis: usize| std::array::from_fn(|c| 0.5 * (cube[2 * axis][c] - cube[2 * axis + 1][c]));
    [a, b(0), b(1), b(2)]
}

fn bytes<const N: usize>(values: &[[[f32; 3]; N]]) -> Vec<u8> {
    values.as_flattened().as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// What the files hold and where it lies, in the axes of the scene file.
fn describe(volume: &Volume, origin: [f64; 3], intensity: f32) -> Value {
    let axes = |f: &dyn Fn(usize) -> f64| [0, 1, 2].map(f);
    let edge = |a: usize| f64::from(volume.spacing[a]);
    let low = |a: usize| origin[a] + f64::from(volume.origin[a]);
    let extent = |a: usize| f64::from(volume.count[a]) * edge(a);
    let own = |cell: &usize| volume.cell.binary_search(&(*cell as u32)).is_ok();
    let filled: Vec<usize> = (0..volume.cells()).filter(|cell| !own(cell)).collect();
    json!({
        "axes": "those of the scene file, metres",
        "cells": volume.count,
        "spacing": axes(&edge),
        "lower_corner": axes(&low),
        "first_probe": axes(&|a| low(a) + 0.5 * edge(a)),
        "cell_number": "x + nx * (y + ny * z); its probe lies in the middle of the cell",
        "filled_cells": filled,
        "filled_cells_note": "their middles lie inside or behind geometry; they hold the values of a probe nearby",
        (CUBES): {
            "type": "f32 little-endian", "shape": [volume.cells(), 6, 3],
            "directions": ["+x", "-x", "+y", "-y", "+z", "-z"], "channels": "linear RGB", "unit": "W/m^2",
            "meaning": "irradiance of a plane that faces the direction; of a normal n: the sum over axes of n_axis^2 times the \
                        value of the direction with the sign of n_axis",
        },
        (HARMONICS): {
            "type": "f32 little-endian", "shape": [volume.cells(), 4, 3],
            "coefficients": ["a", "b_x", "b_y", "b_z"], "channels": "linear RGB", "unit": "W/m^2",
            "meaning": "irradiance of a plane with normal n is about a + b_x n_x + b_y n_y + b_z n_z, not below 0; least \
                        squares of the six directions: a is their mean, b half the difference of opposite ones",
        },
        (TEXTURE): {
            "format": "R16G16B16A16_SFLOAT", "size": atlas_size(volume.count),
            "meaning": "irradiance over pi and over the intensity below, W/(m^2 sr): the texture of Bevy's IrradianceVolume; \
                        +x, +y, +z in rows 0 to ny - 1 and -x, -y, -z in rows ny to 2 ny - 1 of layers 0, nz and 2 nz on",
            "bevy": {
                "translation": axes(&|a| low(a) + 0.5 * extent(a)),
                "rotation": [0.0, 0.0, 0.0, 1.0],
                "scale": axes(&extent),
                "intensity": intensity,
            },
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A plane's values are linear in its normal where light is; the fit finds them again.
    #[test]
    fn the_linear_part_of_a_cube_is_found() {
        let (a, b) = ([3.0, 1.0, 0.5], [[1.0, 0.0, 0.25], [-2.0, 0.5, 0.0], [0.5, -0.25, 0.0]]);
        let cube = Volume::NORMALS.map(|n| std::array::from_fn(|c| a[c] + (0..3).map(|k| n[k] * b[k][c]).sum::<f32>()));
        assert_eq!(linear(&cube), [a, b[0], b[1], b[2]]);
    }

    #[test]
    fn light_beyond_half_precision_is_left_to_the_intensity() {
        assert_eq!([0.0, 1e-3, 65504.0].map(intensity), [1.0; 3]);
        assert_eq!(intensity(65505.0), 2.0);
        assert_eq!(intensity(1e9), 16384.0);
    }
}
