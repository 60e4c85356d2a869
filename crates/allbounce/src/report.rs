//! Reports for people: a few aligned lines from the same numbers that `--report` writes.

use serde_json::Value;

/// A title and one line a number; nested objects are indented, long lists are cut.
pub fn table(title: &str, numbers: &Value) -> String {
    let mut text = format!("{title}\n");
    append(&mut text, numbers, 1);
    text
}

fn append(text: &mut String, value: &Value, depth: usize) {
    let Value::Object(fields) = value else { return };
    let indent = "  ".repeat(depth);
    for (name, value) in fields {
        let name = name.replace('_', " ");
        match value {
            Value::Null => {}
            Value::Object(_) => {
                text.push_str(&format!("{indent}{name}\n"));
                append(text, value, depth + 1);
            }
            Value::Array(items) if items.is_empty() => {}
            Value::Array(items) if items.iter().any(|item| item.is_string() || item.is_object()) => {
                for item in items {
                    text.push_str(&format!("{indent}{name}: {}\n", scalar(item)));
                }
            }
            _ => text.push_str(&format!("{indent}{name:<32} {}\n", scalar(value))),
        }
    }
}

fn scalar(value: &Value) -> String {
    match value {
        Value::String(s) => s.clone(),
        Value::Number(n) => n.as_u64().map_or_else(|| number(n.as_f64().unwrap_or(f64::NAN)), |i| i.to_string()),
        Value::Array(items) => {
            let shown: Vec<String> = items.iter().take(6).map(scalar).collect();
            format!("{}{}", shown.join(" "), if items.len() > 6 { " …" } else { "" })
        }
        Value::Object(fields) => {
            let shown: Vec<String> = fields.iter().map(|(k, v)| format!("{k} {}", scalar(v))).collect();
            format!("({})", shown.join(", "))
        }
        other => other.to_string(),
    }
}

/// Four significant digits.
fn number(x: f64) -> String {
    if x == 0.0 || (1e-3..1e6).contains(&x.abs()) {
        let digits = (3 - x.abs().max(1e-3).log10().floor() as i32).clamp(0, 6) as usize;
        format!("{x:.digits$}")
    } else {
        format!("{x:.3e}")
    }
}
