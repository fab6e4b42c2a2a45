//! `rtbench generate`: what the program says of itself, for other programs.
//!
//! The JSON schemas of what is written, and of scene files (draft 2020-12), stand in the folder
//! `schema/`. Those of the record and of scene files are made from their types and the descriptions
//! of these, and a test compares them with the files: `RTBENCH_WRITE_SCHEMA=1 cargo test -p rtbench
//! --lib generate` writes them anew. Those of the formats of others restate what these say of them.

use clap::CommandFactory;
use clap_mangen::Man;

use crate::args::{Cli, GeneratedText, ManArgs, SchemaOf};
use crate::context::Context;
use crate::error::{Error, SUCCESS};
use measurement::plan::error::PlanError;
use measurement::system::files::WriteError;

pub fn run(context: &mut Context<'_>, text: &GeneratedText) -> Result<u8, Error> {
    match text {
        GeneratedText::Schema { what } => context.out.write_all(schema(*what).as_bytes())?,
        GeneratedText::Completions { shell } => {
            // the library takes no error of its writer
            let mut text = Vec::new();
            clap_complete::generate(*shell, &mut Cli::command(), "rtbench", &mut text);
            context.out.write_all(&text)?;
        }
        GeneratedText::Man(args) => man(context, args)?,
    }
    Ok(SUCCESS)
}

fn schema(what: SchemaOf) -> &'static str {
    match what {
        SchemaOf::RunRecord => include_str!("../../schema/run-record.schema.json"),
        SchemaOf::GithubActionBenchmark => {
            include_str!("../../schema/github-action-benchmark.schema.json")
        }
        SchemaOf::BencherMetricFormat => {
            include_str!("../../schema/bencher-metric-format.schema.json")
        }
        SchemaOf::Scene => include_str!("../../schema/scene.schema.json"),
    }
}

/// The command line with all that follows from what is declared.
fn built() -> clap::Command {
    let mut cli = Cli::command().disable_help_subcommand(true).long_version(None::<&str>);
    cli.build();
    cli
}

/// The pages of a command and of those below it that are not hidden.
fn pages(command: &clap::Command) -> Vec<Man> {
    let shown = command.get_subcommands().filter(|below| !below.is_hide_set());
    let mut all: Vec<Man> = shown.flat_map(pages).collect();
    all.push(Man::new(command.clone()));
    all
}

/// The files that `generate man -o` writes.
pub fn page_names() -> Vec<String> {
    pages(&built()).iter().map(Man::get_filename).collect()
}

/// Prints a manual page, or writes all of them.
fn man(context: &mut Context<'_>, args: &ManArgs) -> Result<(), Error> {
    let cli = built();
    if let Some(folder) = &args.output {
        let write = || {
            std::fs::create_dir_all(folder)?;
            pages(&cli).iter().try_for_each(|page| page.generate_to(folder).map(|_| ()))
        };
        return write().map_err(|source| WriteError { path: folder.clone(), source }.into());
    }
    let page = match &args.command {
        None => &cli,
        Some(name) => cli.find_subcommand(name).ok_or_else(|| {
            let names = cli.get_subcommands().map(clap::Command::get_name);
            PlanError::unknown("command", name, names)
        })?,
    };
    Ok(Man::new(page.clone()).render(context.out)?)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use scene_loading::scene_file::SceneFile;
    use schemars::JsonSchema;
    use schemars::generate::SchemaSettings;
    use serde_json::Value;

    use measurement::record::RunRecord;

    const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/schema/");
    /// The chapter on scenes.
    const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/scenes.md");

    fn schema<T: JsonSchema>(settings: SchemaSettings, file: &str, title: &str) -> Value {
        let mut schema = settings.into_generator().into_root_schema_for::<T>().to_value();
        schema["$id"] = format!("https://github.com/rtbench/rtbench/{file}").into();
        schema["title"] = title.into();
        schema
    }

    /// Of the types: file and schema.
    fn of_types() -> [(&'static str, Value); 2] {
        let settings = SchemaSettings::draft2020_12;
        let record = "run-record.schema.json";
        let title = "Record of a run of rtbench";
        let record = (record, schema::<RunRecord>(settings().for_serialize(), record, title));
        let scene = "scene.schema.json";
        let title = "Scene file of rtbench";
        let scene = (scene, schema::<SceneFile>(settings().for_deserialize(), scene, title));
        [record, scene]
    }

    /// Every property, with its place.
    fn properties<'s>(place: &str, schema: &'s Value, found: &mut Vec<(String, &'s Value)>) {
        let below = |key: &str| schema.get(key).and_then(Value::as_object).into_iter().flatten();
        for (name, property) in below("properties") {
            let place = format!("{place}.{name}");
            found.push((place.clone(), property));
            properties(&place, property, found);
        }
        for (name, definition) in below("$defs") {
            properties(name, definition, found);
        }
        for choice in ["oneOf", "anyOf"] {
            let choices = schema.get(choice).and_then(Value::as_array);
            choices.into_iter().flatten().for_each(|one| properties(place, one, found));
        }
    }

    /// The places of all properties that have no description, of their own or of their type.
    fn undescribed(schema: &Value) -> Vec<String> {
        let mut found = Vec::new();
        properties("root", schema, &mut found);
        let has_none = |property: &Value| {
            let described =
                |one: &Value| one["description"].as_str().is_some_and(|d| !d.is_empty());
            // a variant with a value is described as a whole, its type where it is defined
            !described(property)
                && property.get("$ref").is_none()
                && property.get("const").is_none()
        };
        let none = found.into_iter().filter(|(place, property)| {
            let is_variant =
                ["Source.", "ShapeEntry.", "Question."].iter().any(|of| place.starts_with(of));
            has_none(property) && !is_variant
        });
        none.map(|(place, _)| place).collect()
    }

    #[test]
    fn the_files_are_those_of_the_types() {
        for (file, schema) in of_types() {
            let path = format!("{FOLDER}{file}");
            let mut expected = serde_json::to_string_pretty(&schema).unwrap();
            expected.push('\n');
            if std::env::var_os("RTBENCH_WRITE_SCHEMA").is_some() {
                std::fs::write(&path, &expected).unwrap();
            }
            let found = std::fs::read_to_string(&path).unwrap();
            let differing = expected.lines().zip(found.lines()).find(|(a, b)| a != b);
            assert!(
                expected == found,
                "schema/{file} is not that of the types; the first difference: {differing:?}; \
                 write it with RTBENCH_WRITE_SCHEMA=1 cargo test -p rtbench --lib generate"
            );
        }
    }

    #[test]
    fn every_field_is_described() {
        for (file, schema) in of_types() {
            let found = undescribed(&schema);
            assert!(found.is_empty(), "{file}: fields without a description: {}", found.join(", "));
        }
        // planted ones are found
        for (i, definition, property) in [(0, "Machine", "cpu"), (1, "LightEntry", "position")] {
            let mut schema = of_types()[i].1.clone();
            schema["$defs"][definition]["properties"][property]
                .as_object_mut()
                .unwrap()
                .remove("description");
            assert_eq!(undescribed(&schema), [format!("{definition}.{property}")]);
        }
    }

    /// The properties of scene files that a page does not name in backticks.
    fn undocumented(page: &str) -> BTreeSet<String> {
        let [_, (_, schema)] = of_types();
        let mut found = Vec::new();
        properties("root", &schema, &mut found);
        let names = found.iter().filter_map(|(place, _)| place.rsplit('.').next());
        let is_missing = |name: &&str| !page.contains(&format!("`{name}`"));
        names.filter(is_missing).map(str::to_owned).collect()
    }

    #[test]
    fn the_page_on_scene_files_has_every_key() {
        let page = std::fs::read_to_string(PAGE).unwrap();
        assert_eq!(undocumented(&page), BTreeSet::new());
        // a planted gap is found
        let cut = page.replace("`focal_distance`", "");
        assert_eq!(undocumented(&cut), BTreeSet::from(["focal_distance".to_owned()]));
    }

    #[test]
    fn scene_files_of_the_repository_are_of_the_schema_and_broken_ones_are_not() {
        let validator = jsonschema::validator_for(&of_types()[1].1).unwrap();
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../scenes");
        let mut seen = 0;
        for folder in [folder.to_owned(), format!("{folder}/effects")] {
            for entry in std::fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.extension().is_none_or(|ending| ending != "json") {
                    continue;
                }
                let text = std::fs::read_to_string(&path).unwrap();
                let scene: Value = serde_json::from_str(&text).unwrap();
                let error = validator.validate(&scene).err().map(|error| error.to_string());
                assert_eq!(error, None, "{}", path.display());
                seen += 1;
            }
        }
        assert!(seen > 15, "{seen}");
        let scene = serde_json::json!({
            "name": "a", "title": "t", "why": "w", "source": {"file": "a.ply"},
            "camera": {"from": [0, 0, 1], "at": [0, 0, 0], "up": [0, 1, 0], "angle": 40},
            "lights": [{"position": [0, 9, 0], "radius": 1}], "effects": {"shadow": 4}
        });
        assert!(validator.is_valid(&scene));
        type Plant = fn(&mut Value);
        let plants: [Plant; 6] = [
            |scene| scene["lihgts"] = Value::Null,
            |scene| scene["lights"][0]["radius"] = (-1).into(),
            |scene| scene["effects"]["shadow"] = 0.into(),
            |scene| scene["camera"]["from"] = serde_json::json!([0, 1]),
            |scene| scene["source"] = serde_json::json!({"url": "a"}),
            |scene| drop(scene.as_object_mut().unwrap().remove("title")),
        ];
        for (i, plant) in plants.iter().enumerate() {
            let mut broken = scene.clone();
            plant(&mut broken);
            assert!(!validator.is_valid(&broken), "plant {i}");
        }
    }
}
