//! `allbounce relight`: a bake and lights in, irradiance at points or vertices out.

use std::path::PathBuf;

use anyhow::{Context, bail};
use radfile::{FormFactors, PointRows, Record};
use relight::{DirectLight, Frame, Operator, PatchSamples, PointLight, Receivers, Relighter, Samples};
use scene::{LightRig, Rays, SurfacePoint};
use serde::Serialize;
use transfer::GatherParams;

use crate::{
    csv_points::{ANSWERS, Points},
    files,
    runtime::{self, Backend, Bake, LightOptions},
    session::Session,
};

/// Irradiance of one frame, W/m²: direct light and all further bounces.
///
/// Writes px,py,pz,nx,ny,nz and direct_r,g,b, indirect_r,g,b: incident irradiance, not multiplied by
/// reflectance nor divided by π. Exit: 0 done, 1 input refused, 2 usage, 3 I/O.
#[derive(clap::Args)]
pub struct Args {
    /// Bake of `allbounce bake`, or the last container of the chain
    #[arg(value_name = "BAKE.rad")]
    bake: PathBuf,
    #[command(flatten)]
    light: LightOptions,
    /// Points with px,py,pz,nx,ny,nz in the scene file's axes, metres [default: the receivers of the bake,
    /// each side of each vertex of the finer mesh]
    #[arg(long, value_name = "P.csv")]
    points: Option<PathBuf>,
    /// Where the answers go
    #[arg(short, long, value_name = "E.csv")]
    output: PathBuf,
    /// How light reaches the points [default: gather; interpolate where the bake's operator holds some bounces only]
    #[arg(long, value_enum, requires = "points")]
    transfer: Option<Transfer>,
    /// Rays a point of the last gather [default: 8192]
    #[arg(long, value_name = "N", requires = "points", value_parser = clap::value_parser!(u32).range(16..=1 << 20))]
    gather_rays: Option<u32>,
    /// Exactly the first k bounces; the bake must keep its form factors (--keep-dense)
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u32).range(1..=65536))]
    bounces: Option<u32>,
}

/// How light gets from patches to points.
#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum Transfer {
    /// The last bounce by rays from each point to all patches that it sees: the most accurate
    Gather,
    /// Between the irradiances of patches around each point, as for the vertices of a picture: the fastest
    Interpolate,
}

#[derive(Serialize)]
struct Report {
    backend: String,
    bounces: String,
    transfer: &'static str,
    points: usize,
    points_without_patches: usize,
    mean_direct: [f64; 3],
    mean_indirect: [f64; 3],
    seconds: f64,
}

pub fn run(args: &Args, session: &Session) -> anyhow::Result<()> {
    let mut inputs = vec![("the bake", args.bake.as_path()), ("the lights", args.light.chosen.path())];
    inputs.extend(args.points.iter().map(|p| ("the points", p.as_path())));
    files::check_outputs(&session.outputs(&args.output), &inputs)?;
    let bake = Bake::open(&args.bake)?;
    let rig = args.light.rig(&bake, session)?;
    let named = || args.bake.display().to_string();
    if args.bounces.is_some() && !bake.container.has("formfactor.values") {
        bail!(
            "{}: --bounces needs the form factors, which this bake has dropped; bake with --keep-dense, \
             or bake the operator itself with --bounces",
            named()
        );
    }
    let operator = bake.operator().with_context(named)?;
    let rays = Rays::new(&bake.scene.mesh);
    let transfer = transfer_of(args, &operator).with_context(named)?;
    let (points, rows) = points(args, transfer, &bake, &rays, session)?;
    let receivers = rows.as_ref().map_or_else(|| bake.receivers(), |rows| Ok(rows.into())).with_context(named)?;
    let surface = relight::surface_points(&bake.scene.mesh, &points.position, &points.normal);
    let (mut light, backend) = match args.light.backend {
        Backend::Cpu => {
            let light = on_cpu(args, &bake, &operator, &rig, &rays, &surface, &receivers, session);
            (light.with_context(named)?, "cpu".into())
        }
        Backend::Gpu => {
            crate::gpu::relight(args.bounces, &bake, &operator, &rig, &surface, rows.as_ref()).with_context(named)?
        }
    };
    args.light.chosen.blank(&mut light.direct, &mut light.indirect);
    if !light.direct.iter().chain(&light.indirect).flatten().all(|v| v.is_finite()) {
        bail!("{}", runtime::TOO_BRIGHT);
    }
    let row = |i: usize| light.direct[i].iter().chain(&light.indirect[i]).map(f32::to_string).collect();
    points.write(&args.output, &ANSWERS, row)?;
    let lost = rows.as_ref().map_or(0, points_without_patches);
    if lost > 0 {
        session.warn(&format!(
            "{lost} of {} points lie on no patch or see none; their indirect light is 0",
            surface.len()
        ));
    }
    let report = Report {
        backend,
        bounces: runtime::bounces_in_words(args.bounces.or(operator.bounces())),
        transfer: if receivers.bounces() == 0 { "interpolated" } else { "gathered" },
        points: surface.len(),
        points_without_patches: lost,
        mean_direct: mean(&light.direct),
        mean_indirect: mean(&light.indirect),
        seconds: session.seconds(),
    };
    session.print("relight", &report)?;
    session.finish(&report)
}

/// How light gets to the points. A last gather is a bounce of its own, so it must know how many come before it.
fn transfer_of(args: &Args, operator: &Operator) -> anyhow::Result<Transfer> {
    let held = if args.bounces.is_none() { operator.bounces() } else { None };
    match (args.transfer, held) {
        (Some(Transfer::Gather), Some(k)) => bail!(
            "the operator holds the first {k} bounces and a last gather would add one; use --transfer interpolate"
        ),
        (Some(Transfer::Gather), None) | (None, None) => Ok(Transfer::Gather),
        _ if args.gather_rays.is_some() => {
            bail!("--gather-rays was given, but the points are interpolated; leave it out or use --transfer gather")
        }
        _ => Ok(Transfer::Interpolate),
    }
}

/// The points to evaluate and their rows over elements or patches; those of the bake's receivers are in the bake.
fn points(
    args: &Args,
    transfer: Transfer,
    bake: &Bake,
    rays: &Rays,
    session: &Session,
) -> anyhow::Result<(Points, Option<PointRows>)> {
    let mesh = &bake.scene.mesh;
    let Some(path) = &args.points else {
        let t = &bake.transfer;
        let in_file_axes = |p: &[f32; 3]| std::array::from_fn(|a| f64::from(p[a]) + mesh.origin[a]);
        return Ok((Points::new(t.position.iter().map(in_file_axes).collect(), t.normal.clone()), None));
    };
    let points = Points::read(path, &ANSWERS)?;
    let surface = relight::surface_points(mesh, &points.position, &points.normal);
    let (patches, elements, progress) = (&bake.patches, &bake.elements, session.progress());
    let rows = match transfer {
        Transfer::Gather => {
            let default = GatherParams::default();
            let params = GatherParams { rays: args.gather_rays.unwrap_or(default.rays), ..default };
            let need = transfer::gather_memory_needed(surface.len(), elements.senders(), &params);
            session.ask_memory("the last gather", need, "take the points in parts, or --transfer interpolate")?;
            let senders = transfer::Senders { patches, elements, rays };
            transfer::gather_for_points(&senders, &surface, &params, &progress)
        }
        Transfer::Interpolate => {
            let params = transfer::Params::default();
            let rows = transfer::interpolate_for_points(patches, rays, &surface, &params, &progress);
            PointRows::Interpolated(rows)
        }
    };
    Ok((points, Some(rows)))
}

/// Points whose rows are empty and that see no sky.
fn points_without_patches(rows: &PointRows) -> usize {
    let sees_sky = |point: usize| match rows {
        PointRows::Interpolated(_) => false,
        PointRows::Gathered { sky, .. } => sky[point] > 0.0,
    };
    let empty = |&point: &usize| rows.rows().row(point).next().is_none() && !sees_sky(point);
    (0..rows.rows().len()).filter(empty).count()
}

#[allow(clippy::too_many_arguments, reason = "a frame is made of all of them")]
fn on_cpu(
    args: &Args,
    bake: &Bake,
    operator: &Operator,
    rig: &LightRig,
    rays: &Rays,
    points: &[SurfacePoint],
    receivers: &Receivers,
    session: &Session,
) -> anyhow::Result<PointLight> {
    let relighter = Relighter::new(&bake.scene, rays, &bake.patches, &bake.elements, operator, bake.sky()?)?;
    let light = relighter.direct_light(rig);
    // A last gather is the last of the bounces.
    let frame = frame(args.bounces.map(|k| k - receivers.bounces()), bake, &relighter, &light, session)?;
    let progress = session.progress();
    Ok(relight::light_at_points(&relighter, &light, points, receivers, &frame, &Samples::default(), &progress))
}

/// Light of the patches, all bounces or the first `bounces`, which may be none.
fn frame(
    bounces: Option<u32>,
    bake: &Bake,
    relighter: &Relighter,
    light: &DirectLight,
    session: &Session,
) -> anyhow::Result<Frame> {
    let (samples, progress) = (PatchSamples::default(), session.progress());
    Ok(match bounces {
        None => relighter.frame(light, &samples, &progress),
        Some(count) => {
            let factors = FormFactors::read(&bake.container)?;
            relighter.frame_of_bounces(light, &factors, count, &samples, &progress)?
        }
    })
}

fn mean(values: &[[f32; 3]]) -> [f64; 3] {
    let n = values.len().max(1) as f64;
    std::array::from_fn(|c| values.iter().fold(0.0, |sum, v| sum + f64::from(v[c])) / n)
}
