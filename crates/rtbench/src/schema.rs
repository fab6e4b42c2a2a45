//! The JSON schemas of what is written (draft 2020-12), as they stand in the folder `schema/`.
//!
//! That of the record is made from its types and their descriptions, and a test compares it with
//! the file: `RTBENCH_WRITE_SCHEMA=1 cargo test -p rtbench --lib schema` writes it anew. Those of
//! the formats of others restate what these say of them.

/// Of `results.json` and `--export-json`.
pub const RUN_RECORD: &str = include_str!("../schema/run-record.schema.json");
/// Of `--export-github-smaller` and `--export-github-bigger`.
pub const GITHUB_ACTION_BENCHMARK: &str =
    include_str!("../schema/github-action-benchmark.schema.json");
/// Of `--export-bencher`.
pub const BENCHER_METRIC_FORMAT: &str = include_str!("../schema/bencher-metric-format.schema.json");

#[cfg(test)]
mod tests {
    use schemars::generate::SchemaSettings;
    use serde_json::Value;

    use measurement::record::RunRecord;

    const PATH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/schema/run-record.schema.json");

    /// Of the types, as they are written.
    fn of_types() -> Value {
        let settings = SchemaSettings::draft2020_12().for_serialize();
        let mut schema = settings.into_generator().into_root_schema_for::<RunRecord>().to_value();
        schema["$id"] = "https://github.com/rtbench/rtbench/run-record.schema.json".into();
        schema["title"] = "Record of a run of rtbench".into();
        schema
    }

    /// The places of all properties that have no description, of their own or of their type.
    fn undescribed(place: &str, schema: &Value, found: &mut Vec<String>) {
        let Some(object) = schema.as_object() else { return };
        for (name, property) in
            object.get("properties").and_then(Value::as_object).into_iter().flatten()
        {
            let place = format!("{place}.{name}");
            if property.get("description").and_then(Value::as_str).is_none_or(str::is_empty) {
                found.push(place.clone());
            }
            undescribed(&place, property, found);
        }
        for (name, definition) in
            object.get("$defs").and_then(Value::as_object).into_iter().flatten()
        {
            undescribed(name, definition, found);
        }
    }

    #[test]
    fn the_file_is_that_of_the_types() {
        let mut expected = serde_json::to_string_pretty(&of_types()).unwrap();
        expected.push('\n');
        if std::env::var_os("RTBENCH_WRITE_SCHEMA").is_some() {
            std::fs::write(PATH, &expected).unwrap();
        }
        let found = std::fs::read_to_string(PATH).unwrap();
        let differing = expected.lines().zip(found.lines()).find(|(a, b)| a != b);
        assert!(
            expected == found,
            "schema/run-record.schema.json is not that of the types; the first difference: \
             {differing:?}; write it with RTBENCH_WRITE_SCHEMA=1 cargo test -p rtbench --lib schema"
        );
    }

    #[test]
    fn every_field_is_described() {
        let mut found = Vec::new();
        undescribed("RunRecord", &of_types(), &mut found);
        assert!(found.is_empty(), "fields without a description: {}", found.join(", "));
        // a planted one is found
        let mut schema = of_types();
        schema["$defs"]["Machine"]["properties"]["cpu"]
            .as_object_mut()
            .unwrap()
            .remove("description");
        undescribed("RunRecord", &schema, &mut found);
        assert_eq!(found, ["Machine.cpu"]);
    }
}
