//! `allbounce inspect --plot`: the operator of a container in pictures, as in the figures of A. Shcherbakov, V. Frolov,
//! "Matrix transformations for efficient implementation of the radiosity algorithm on GPUs", Light & Engineering 27(2), 2019.
//!
//! - `subject.rs`: what there is to draw. `entries.rs`: matrices of any size as pictures, without a copy of them.
//! - One file a picture: `matrix.rs` (their figure 2), `values.rs` (1), `blocks.rs`, `error.rs` (4), `sizes.rs` (5),
//!   `speeds.rs` (6).

mod blocks;
mod entries;
mod error;
mod matrix;
mod sizes;
mod speeds;
mod subject;
mod values;

use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use plot::Sheet;
use radfile::Container;
use serde::Serialize;
use serde_json::Value;

use crate::{files, session::Session};
use subject::Subject;

/// Names of the pictures, in the order of the page.
const NAMES: [&str; 6] = ["matrix", "values", "blocks", "error", "sizes", "speeds"];
const PAGE: &str = "index.md";

/// A picture, or why there is none.
#[derive(Serialize)]
pub struct Plot {
    name: &'static str,
    drawn: bool,
    /// What is seen, or what is missing.
    sentence: String,
    numbers: Value,
    #[serde(skip)]
    sheet: Option<Sheet>,
}

impl Plot {
    fn new<N: Serialize>(name: &'static str, sheet: Sheet, numbers: &N, sentence: String) -> anyhow::Result<Plot> {
        Ok(Plot { name, drawn: true, sentence, numbers: serde_json::to_value(numbers)?, sheet: Some(sheet) })
    }

    /// `reason` is a sentence that says what is missing and how to get it.
    fn missing(name: &'static str, reason: impl Into<String>) -> Plot {
        Plot { name, drawn: false, sentence: reason.into(), numbers: Value::Null, sheet: None }
    }
}

/// Draws what the container of `file` holds into `folder`, and writes a page about it.
pub fn draw(container: &Container, file: &Path, folder: &Path, session: &Session) -> anyhow::Result<Vec<Plot>> {
    let about = || file.display().to_string();
    let subject = Subject::read(container, session).with_context(about)?;
    prepare(file, folder, session)?;
    let drawers = [matrix::draw, values::draw, blocks::draw, error::draw, sizes::draw, speeds::draw];
    let plots = drawers.iter().map(|draw| draw(&subject)).collect::<anyhow::Result<Vec<Plot>>>().with_context(about)?;
    for plot in &plots {
        match &plot.sheet {
            Some(sheet) => {
                files::write(&folder.join(format!("{}.svg", plot.name)), sheet.svg()?.as_bytes())?;
                files::write(&folder.join(format!("{}.png", plot.name)), &sheet.png()?)?;
            }
            None => session.say(&format!("no picture {}: {}", plot.name, plot.sentence)),
        }
    }
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    files::write(&folder.join(PAGE), page(&name, &plots).as_bytes())?;
    Ok(plots)
}

/// Makes the folder and refuses one that could not be written to.
fn prepare(file: &Path, folder: &Path, session: &Session) -> anyhow::Result<()> {
    if folder.exists() && !folder.is_dir() {
        bail!("{}: --plot names a file, expected a folder; choose another name", folder.display());
    }
    if !folder.is_dir() {
        std::fs::create_dir(folder).with_context(|| folder.display().to_string())?;
    }
    let kinds = ["svg", "png"];
    let pictures = NAMES.iter().flat_map(|name| kinds.map(|kind| folder.join(format!("{name}.{kind}"))));
    let paths: Vec<PathBuf> = std::iter::once(folder.join(PAGE)).chain(pictures).collect();
    let mut outputs: Vec<(&str, &Path)> = paths.iter().map(|path| ("--plot", path.as_path())).collect();
    outputs.extend(session.outputs(&paths[0]).into_iter().skip(1));
    files::check_outputs(&outputs, &[("the container", file)])
}

/// The pictures with a sentence each, as Markdown.
fn page(name: &str, plots: &[Plot]) -> String {
    let mut page = format!("# {name}\n");
    for Plot { name, sentence, drawn, .. } in plots {
        page += &format!("\n## {name}\n\n");
        if *drawn {
            page += &format!("[![{name}]({name}.png)]({name}.svg)\n\n");
        }
        page += &format!("{sentence}\n");
    }
    page
}
