//! Writes `docs/charts/`. A test holds the committed numbers to what this writes.

use allbounce_tests::{
    charts::{Effort, all, page},
    root,
};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = root().join("docs/charts");
    std::fs::create_dir_all(&folder)?;
    let figures = all(Effort::Full);
    for figure in &figures {
        let file = |ending| folder.join(format!("{}.{ending}", figure.name));
        std::fs::write(file("csv"), figure.table.csv())?;
        std::fs::write(file("svg"), figure.chart.svg()?)?;
        std::fs::write(file("png"), figure.chart.png()?)?;
        println!("docs/charts/{}", figure.name);
        for claim in figure.claims.iter().filter(|claim| !claim.holds) {
            println!("  is not so: {} {:?}", claim.says, claim.measured);
        }
    }
    std::fs::write(folder.join("README.md"), page::text(&figures))?;
    Ok(())
}
