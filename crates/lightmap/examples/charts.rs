//! Draws the lightmap of a scene file as a PNG: charts in colours, hidden texels dark, what filters read around charts
//! pale, empty texels black. Prints what was made and how long that took.
//!
//! `cargo run --release -p lightmap --example charts -- SCENE OUT.png [texels=65536] [fast] [own]`

#[path = "../../scene/tests/disk/mod.rs"]
mod disk;

use std::{error::Error, path::Path, time::Instant};

use disk::Disk;
use lightmap::{Atlas, Size, UnwrapParams, texels, unwrap};
use radfile::{Lightmap, NO_RECEIVER, Quiet};
use scene::{ImportOptions, Rays, hash, import};

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [scene, out, options @ ..] = &args[..] else { return Err("give a scene and the name of a picture".into()) };
    let wanted = options.iter().find_map(|o| o.strip_prefix("texels=")?.parse().ok()).unwrap_or(65_536);
    let has = |word: &str| options.iter().any(|o| o == word);
    let scene = Path::new(scene);
    let folder = Disk(scene.parent().unwrap_or(Path::new("")).to_owned());
    let name = scene.file_name().and_then(|n| n.to_str()).ok_or("the scene has no name")?;
    let (scene, _) = import(name, &folder, ImportOptions::default())?;
    let mesh = &scene.mesh;
    let start = Instant::now();
    let atlas = match has("own") {
        true => Atlas::from_mesh(mesh, Size::Texels(wanted))?,
        false => {
            let params = UnwrapParams { size: Size::Texels(wanted), fast: has("fast"), ..UnwrapParams::default() };
            unwrap(mesh, &params, &Quiet)?
        }
    };
    let unwrapped = start.elapsed();
    let rays = Rays::new(mesh);
    let start = Instant::now();
    let (lightmap, report) = texels(mesh, &atlas, &rays, &Quiet);
    let placed = start.elapsed();
    let used = report.touched as f64 / f64::from(report.width * report.height);
    println!(
        "{} triangles; atlas {unwrapped:.2?}, receivers {placed:.2?}; in use {:.1} %",
        mesh.triangles.len(),
        100.0 * used
    );
    println!("{report:?}");
    draw(&lightmap, &atlas).save(out)?;
    Ok(())
}

fn draw(lightmap: &Lightmap, atlas: &Atlas) -> image::RgbImage {
    let mut own = vec![false; lightmap.receiver.len()];
    lightmap.texel.iter().for_each(|&x| own[x as usize] = true);
    let touched: Vec<bool> = touched(lightmap, atlas);
    image::RgbImage::from_fn(lightmap.width, lightmap.height, |x, y| {
        let at = (y * lightmap.width + x) as usize;
        let receiver = lightmap.receiver[at];
        if receiver == NO_RECEIVER {
            return image::Rgb([0; 3]);
        }
        let chart = atlas.chart[lightmap.triangle[receiver as usize] as usize];
        let colour = [0, 1, 2].map(|k| 80 + (hash(chart, k) % 160) as u8);
        image::Rgb(match (own[at], touched[at]) {
            (true, _) => colour,
            (false, true) => colour.map(|c| c / 4),
            (false, false) => colour.map(|c| 215 + c / 8),
        })
    })
}

/// Texels whose middle lies in a triangle.
fn touched(lightmap: &Lightmap, atlas: &Atlas) -> Vec<bool> {
    let size = [lightmap.width, lightmap.height].map(f64::from);
    let mut touched = vec![false; lightmap.receiver.len()];
    for corners in &atlas.corner_uv {
        let [a, b, c] = corners.map(|uv| [0, 1].map(|k| f64::from(uv[k]) * size[k]));
        let span = |k: usize| {
            let (low, high) = (a[k].min(b[k]).min(c[k]), a[k].max(b[k]).max(c[k]));
            low.floor() as u32..=(high.ceil() as u32).min(size[k] as u32 - 1)
        };
        let cross =
            |p: [f64; 2], q: [f64; 2], r: [f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
        for y in span(1) {
            for x in span(0) {
                let p = [f64::from(x) + 0.5, f64::from(y) + 0.5];
                let signs = [cross(a, b, p), cross(b, c, p), cross(c, a, p)];
                touched[(y * lightmap.width + x) as usize] |=
                    signs.iter().all(|s| *s >= 0.0) || signs.iter().all(|s| *s <= 0.0);
            }
        }
    }
    touched
}
