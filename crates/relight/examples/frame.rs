//! What a frame of a bake takes on the CPU, part by part, as CSV: medians of repeated frames, milliseconds.
//!
//! `cargo run --release -p relight --example frame -- BAKE.rad LIGHTS.json [FRAMES]`
//!
//! The direct light of all elements, all bounces between the patches, what patches and elements send, and the gather of each
//! set of receivers that the bake has. The light of the last frame is checked to be finite and not dark.

use std::{hint::black_box, time::Instant};

use radfile::{Container, Elements, Gathered, Lightmap, Patches, Quiet, Record, Transfer, Weights};
use relight::{Bounces, DirectLight, Frame, Operator, PatchSamples, Receivers, element_irradiance, radiosity};
use scene::{ElementPoints, LightRig, Rays, Scene, Surfaces};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let mut argument = || arguments.next().ok_or("usage: frame BAKE.rad LIGHTS.json [FRAMES]");
    let (path, lights) = (argument()?, argument()?);
    let frames: usize = argument().map_or(Ok(21), |n| n.parse())?;
    let container = Container::open(path.as_ref())?;
    let (scene, patches) = (Scene::read(&container)?, Patches::read(&container)?);
    let elements = Elements::read_or_whole(&container, &patches)?;
    let rig = LightRig::from_json(&std::fs::read_to_string(&lights)?)?;
    let (rays, surfaces) = (Rays::new(&scene.mesh), Surfaces::new(&scene.mesh, &scene.materials)?);
    let (light, sky) = (DirectLight::new(&scene, &surfaces, &rays, &rig), radfile::read_sky(&container)?);
    let (samples, operator) = (PatchSamples::default(), Operator::read(&container)?);
    let points = ElementPoints::new(&scene.mesh, &patches, &elements, samples.points);
    let mut bounces = Bounces::new(&patches, &operator);

    println!("part,number,ms,ms_a_light");
    let row =
        |part: &str, number: usize, ms: f64| println!("{part},{number},{ms:.3},{:.3}", ms / rig.lights.len() as f64);
    let mut direct_of_elements = Vec::new();
    let ms = median(frames, || {
        direct_of_elements = element_irradiance(&light, &elements, &points, sky, samples.area, &Quiet);
    });
    row("direct light of elements", points.points.len(), ms);
    let direct = elements.mean(&direct_of_elements);
    let ms = median(frames, || {
        black_box(bounces.indirect(&direct));
    });
    row("all bounces", patches.len(), ms);
    let frame = Frame { indirect: bounces.indirect(&direct).to_vec(), element_direct: direct_of_elements, direct };
    let mut sent = Vec::new();
    let ms = median(frames, || sent = radiosity(&elements, &frame));
    row("what is sent", sent.len(), ms);

    let gathered = |gathered: &Gathered, name: &str| -> Result<(), Box<dyn std::error::Error>> {
        let Receivers::Gathered { rows, .. } = Receivers::gathered(gathered, elements.senders())? else {
            return Err("gathered receivers are gathered".into());
        };
        let (mut workspace, mut received) = (rows.workspace(), vec![[0.0; 3]; rows.receivers()]);
        row(name, received.len(), median(frames, || rows.multiply(&sent, &mut received, &mut workspace)));
        let mean = received.iter().flatten().map(|&v| f64::from(v)).sum::<f64>() / received.len() as f64;
        if mean.is_finite() && mean > 0.0 { Ok(()) } else { Err(format!("{name}: the mean light is {mean}").into()) }
    };
    if let Weights::Gathered(rows) = &Transfer::read(&container)?.weights {
        gathered(rows, "gather of vertices")?;
    }
    if container.has("lightmap.meta") {
        let lightmap = Lightmap::read(&container)?;
        gathered(&Gathered::read(&container, Lightmap::PREFIX, lightmap.texel.len())?, "gather of texels")?;
    }
    Ok(())
}

/// Milliseconds.
fn median(count: usize, mut run: impl FnMut()) -> f64 {
    let mut times: Vec<f64> = (0..count.max(1))
        .map(|_| {
            let start = Instant::now();
            run();
            1e3 * start.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
