//! Records of schema 1: a row of obvhs by its plain name had `adapter=robust`, and obvhs as its
//! authors use it, which has the plain name now, was `adapter=direct`.

use serde_json::Value;

use crate::record::{RunRecord, SCHEMA_VERSION, label};

/// The structures whose plain names have another meaning now.
const RENAMED: [&str; 2] = ["obvhs-cwbvh", "obvhs-bvh2"];

/// The same record with the names of today.
///
/// # Errors
/// That of serde, which no record that was read has.
pub(super) fn raised(record: &RunRecord) -> serde_json::Result<RunRecord> {
    let mut value = serde_json::to_value(record)?;
    rename(&mut value);
    let record: RunRecord = serde_json::from_value(value)?;
    Ok(RunRecord { schema_version: SCHEMA_VERSION, ..record })
}

fn rename(value: &mut Value) {
    match value {
        Value::Object(fields) => {
            let of_row = match (fields.get("structure"), fields.get("settings")) {
                (Some(Value::String(structure)), Some(Value::String(settings))) => {
                    renamed(structure, settings)
                }
                _ => None,
            };
            // what was typed stays
            let mut kept = vec!["command_line"];
            if let Some(settings) = of_row {
                fields.insert("settings".into(), settings.into());
                kept.extend(["structure", "settings"]);
            }
            let others = fields.iter_mut().filter(|(name, _)| !kept.contains(&&***name));
            others.for_each(|(_, value)| rename(value));
        }
        Value::Array(values) => values.iter_mut().for_each(rename),
        Value::String(text) => {
            let (structure, settings) = text.split_once(' ').unwrap_or((&**text, ""));
            let is_row = settings.split_whitespace().all(|setting| setting.contains('='));
            if let Some(settings) = renamed(structure, settings).filter(|_| is_row) {
                *text = label(structure, &settings);
            }
        }
        _ => {}
    }
}

/// The settings of today; `None` for a structure whose name means what it meant.
fn renamed(structure: &str, settings: &str) -> Option<String> {
    if !RENAMED.contains(&structure) {
        return None;
    }
    let mut settings: Vec<&str> = settings.split_whitespace().collect();
    if settings.contains(&"adapter=direct") {
        settings.retain(|setting| *setting != "adapter=direct");
    } else if !settings.iter().any(|setting| setting.starts_with("adapter=")) {
        // in the order of the structure's parameters
        let place = usize::from(settings.first().is_some_and(|s| s.starts_with("preset=")));
        settings.insert(place, "adapter=robust");
    }
    Some(settings.join(" "))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::record::file;
    use crate::record::made_up::run;

    #[test]
    fn rows_of_schema_1_have_the_names_of_today() {
        let names = [
            ("obvhs-cwbvh", "obvhs-cwbvh adapter=robust"),
            (
                "obvhs-cwbvh preset=fast kernel=scalar",
                "obvhs-cwbvh preset=fast adapter=robust kernel=scalar",
            ),
            ("obvhs-cwbvh preset=fast adapter=direct", "obvhs-cwbvh preset=fast"),
            ("obvhs-bvh2 adapter=direct", "obvhs-bvh2"),
            ("obvhs-bvh2 adapter=as-shipped", "obvhs-bvh2 adapter=as-shipped"),
            ("wide-bvh preset=morton", "wide-bvh preset=morton"),
        ];
        let rows = names.map(|(old, _)| (old, &[1.0][..]));
        let mut old = run(&[("tetra", &rows)]);
        old.settings.reference = "obvhs-cwbvh adapter=direct".into();
        old.scenes[0].oracle.refused = vec!["obvhs-bvh2: no hit".into()];
        old.command_line = vec!["rtbench".into(), "run".into(), "obvhs-cwbvh".into()];
        for (schema_version, is_old) in [(1, true), (SCHEMA_VERSION, false)] {
            let written = RunRecord { schema_version, ..old.clone() };
            let text = serde_json::to_vec(&written).unwrap();
            let read = file::record(Path::new("results.json"), &text).unwrap();
            let labels = read.scenes[0].rows.iter().map(|row| row.label());
            let expected = names.map(|(old, new)| if is_old { new } else { old });
            assert_eq!(labels.collect::<Vec<_>>(), expected);
            assert_eq!(read.schema_version, SCHEMA_VERSION);
            let reference = if is_old { "obvhs-cwbvh" } else { "obvhs-cwbvh adapter=direct" };
            assert_eq!(read.settings.reference, reference);
            let summary = read.summary.iter().map(|row| label(&row.structure, &row.settings));
            assert!(summary.zip(expected).all(|(label, expected)| label == expected));
            // what is no row's name stays
            assert_eq!(read.scenes[0].oracle.refused, old.scenes[0].oracle.refused);
            assert_eq!(read.command_line, old.command_line);
        }
    }
}
