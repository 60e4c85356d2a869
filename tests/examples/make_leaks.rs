//! Measures every scene of the leak suite and writes the table of `docs/leaks.md`, and the scores to `out/leaks.json`.

use allbounce_tests::{
    leaks::{all, measure::measure, table},
    root,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scenes = all();
    let mut scores = Vec::with_capacity(scenes.len());
    for (number, scene) in scenes.iter().enumerate() {
        println!("{} of {}: {}", number + 1, scenes.len(), scene.name);
        scores.push(measure(scene));
    }
    let page = root().join("docs/leaks.md");
    std::fs::write(&page, table::replaced(&std::fs::read_to_string(&page)?, &scores))?;
    std::fs::create_dir_all(root().join("out"))?;
    std::fs::write(root().join("out/leaks.json"), serde_json::to_string_pretty(&scores)?)?;
    Ok(())
}
