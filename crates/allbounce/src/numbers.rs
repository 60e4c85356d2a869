//! Numbers on the command line: each with its range, so that a wrong one is a usage error; and in words.

/// A positive length with or without the unit `m`, `cm` or `mm`.
pub fn metres(text: &str) -> Result<f32, String> {
    let (number, factor) = [("mm", 1e-3), ("cm", 1e-2), ("m", 1.0)]
        .into_iter()
        .find_map(|(unit, factor)| text.strip_suffix(unit).map(|number| (number, factor)))
        .unwrap_or((text, 1.0));
    match number.trim().parse::<f32>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value * factor),
        _ => Err("expected a positive length such as 0.25m".into()),
    }
}

/// A share of a whole, 0 to 1.
pub fn share(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|v| (0.0..=1.0).contains(v)).ok_or_else(|| "expected a number from 0 to 1".into())
}

/// A positive factor.
pub fn positive(text: &str) -> Result<f32, String> {
    let fits = |v: &f32| *v > 0.0 && v.is_finite();
    text.parse().ok().filter(fits).ok_or_else(|| "expected a positive number".into())
}

/// Span of a logarithmic map; beyond 80 the smallest values underflow.
pub fn span(text: &str) -> Result<f32, String> {
    text.parse().ok().filter(|v| (0.1..=80.0).contains(v)).ok_or_else(|| "expected a number from 0.1 to 80".into())
}

/// A tolerance, 0 or more.
pub fn tolerance(text: &str) -> Result<f64, String> {
    let fits = |v: &f64| *v >= 0.0 && v.is_finite();
    text.parse().ok().filter(fits).ok_or_else(|| "expected a number that is not negative".into())
}

/// A relative error: `1%` or `0.01`, above 0 and at most 1.
pub fn relative_error(text: &str) -> Result<f64, String> {
    let (number, factor) = text.strip_suffix('%').map_or((text, 1.0), |number| (number, 0.01));
    let value = number.trim().parse::<f64>().map(|v| v * factor);
    value.ok().filter(|v| *v > 0.0 && *v <= 1.0).ok_or_else(|| "expected a relative error such as 1%".into())
}

/// A relative error that an operator can be packed with.
pub fn operator_error(text: &str) -> Result<f64, String> {
    let fits = |v: &f64| (0.0005..=0.5).contains(v);
    relative_error(text).ok().filter(fits).ok_or_else(|| "expected a relative error from 0.05% to 50%".into())
}

/// Pixels in a row and rows: `320x240`, each up to 16384.
pub fn pixels(text: &str) -> Result<[usize; 2], String> {
    let parse = |number: &str| number.parse().ok().filter(|n| (1..=16384).contains(n));
    let both = text.split_once('x').and_then(|(width, height)| Some([parse(width)?, parse(height)?]));
    both.ok_or_else(|| "expected a width and a height in pixels such as 320x240".into())
}

/// A relative error that a bake can be asked for.
pub fn goal_error(text: &str) -> Result<f64, String> {
    let fits = |v: &f64| (0.005..=0.5).contains(v);
    relative_error(text).ok().filter(fits).ok_or_else(|| "expected a relative error from 0.5% to 50%".into())
}

/// A positive time in seconds, with its unit `s`, `ms` or `us`.
pub fn seconds(text: &str) -> Result<f64, String> {
    let units = [("ms", 1e-3), ("us", 1e-6), ("s", 1.0)];
    let unit = units.into_iter().find_map(|(unit, factor)| text.strip_suffix(unit).map(|number| (number, factor)));
    let value = unit.and_then(|(number, factor)| number.trim().parse::<f64>().ok().map(|v| v * factor));
    value.filter(|v| *v > 0.0 && v.is_finite()).ok_or_else(|| "expected a positive time such as 5ms".into())
}

/// A share in percent, two digits.
pub fn percent(share: f64) -> String {
    let size = 100.0 * share.abs();
    let digits = if size > 0.0 { (1.0 - size.log10().floor()).clamp(0.0, 9.0) as usize } else { 0 };
    let number = format!("{size:.digits$}");
    let short = if number.contains('.') { number.trim_end_matches('0').trim_end_matches('.') } else { &number };
    format!("{}{short} %", if share < 0.0 { "−" } else { "" })
}
