//! How much memory a step may take: asked before it is allocated.

use anyhow::bail;

/// Parses sizes such as `512MiB`, `6GiB` or `8000000`.
pub fn parse(text: &str) -> Result<u64, String> {
    let digits = text.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(text.len());
    let (number, unit) = text.split_at(digits);
    let factor = match unit.trim() {
        "" | "B" => 1.0,
        "KiB" => 1024.0,
        "MiB" => 1024.0 * 1024.0,
        "GiB" => 1024.0 * 1024.0 * 1024.0,
        other => return Err(format!("unit {other:?}, expected B, KiB, MiB or GiB")),
    };
    match number.parse::<f64>() {
        Ok(value) if value * factor >= 1.0 => Ok((value * factor) as u64),
        _ => Err(format!("{text:?} is no size, expected something like 6GiB")),
    }
}

/// Refuses a step that needs more than `limit`, or than what is free.
pub fn ask(step: &str, need: u64, limit: Option<u64>, remedy: &str) -> anyhow::Result<()> {
    let free = limit.unwrap_or_else(available);
    if need > free {
        let whose = if limit.is_some() { "the limit is" } else { "free are" };
        bail!("{step} needs {} of memory, {whose} {}; {remedy}", size(need), size(free));
    }
    Ok(())
}

/// Free memory of this machine or container, bytes.
fn available() -> u64 {
    let mut system = sysinfo::System::new();
    system.refresh_memory();
    let free = system.available_memory();
    system.cgroup_limits().map_or(free, |group| free.min(group.free_memory))
}

/// Bytes for people.
pub fn size(bytes: u64) -> String {
    let value = bytes as f64;
    match bytes {
        0..1024 => format!("{bytes} B"),
        1024..0x10_0000 => format!("{:.1} KiB", value / 1024.0),
        0x10_0000..0x4000_0000 => format!("{:.1} MiB", value / f64::from(1 << 20)),
        _ => format!("{:.2} GiB", value / f64::from(1 << 30)),
    }
}
