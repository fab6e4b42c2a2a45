//! Plugins as lines of the registry of structures.
//!
//! A line's builder is a plain function, which learns from its settings what it is to build. So the
//! plugins of this process stand in one table, by the names of their lines.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use accel_core::params::{ParamSpec, Params};
use accel_core::primitives::PrimsRef;
use accel_core::query::tracer::Origin;
use accel_core::structure::{BuildError, StructureInfo, no_defect};
use accel_core::structures::{COMMON, Entry, PreparedStructure};

use crate::description::{Description, leak};
use crate::instance::PluginScalar;
use crate::library::{Library, PluginError};
use crate::remote::Remote;
use crate::tracer::{Plugin, PluginTracer};
use crate::wire::{Launch, Options};

/// All of them, by name.
static PLUGINS: Mutex<BTreeMap<&'static str, Arc<Plugin>>> = Mutex::new(BTreeMap::new());

fn plugins() -> MutexGuard<'static, BTreeMap<&'static str, Arc<Plugin>>> {
    PLUGINS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Loads a plugin and makes a line of the registry of it. `sha256` is that of the file. A name that
/// is in `taken` is refused.
pub fn entry(
    file: &Path,
    sha256: String,
    options: &Options,
    taken: &[&str],
) -> Result<Entry, PluginError> {
    let file = &std::path::absolute(file)
        .map_err(|source| PluginError::Read { file: file.into(), source })?;
    let launch = Launch { file: file.clone(), options: options.clone() };
    let (description, library) = if options.in_process {
        let library = Arc::new(Library::load(file)?);
        (library.description.clone(), Some(library))
    } else if cfg!(unix) {
        (described(&launch)?, None)
    } else {
        return Err(PluginError::NoProcesses { file: file.clone() });
    };
    let name = description.name.as_str();
    if taken.contains(&name) {
        return Err(PluginError::NameTaken { file: file.clone(), name: name.into() });
    }
    let specs: Vec<ParamSpec> = description.settings.iter().map(|s| s.leaked()).collect();
    let invalid = |e: &dyn std::fmt::Display| PluginError::Invalid {
        file: file.clone(),
        what: format!("a default is not valid: {e}"),
    };
    let name = leak(name);
    let specs: &'static [ParamSpec] = Vec::leak(specs);
    for spec in specs {
        if specs.iter().chain(COMMON).filter(|s| s.name == spec.name).count() > 1 {
            return Err(invalid(&format_args!("the setting '{}' is declared twice", spec.name)));
        }
        Params::new(name, specs, [(spec.name, spec.default)]).map_err(|e| invalid(&e))?;
    }
    let info: &'static StructureInfo = Box::leak(Box::new(StructureInfo {
        name,
        summary: leak(&description.summary),
        paper: leak(&format!("plugin {} {}", file_name(file), description.version)),
        deviations: "not known: it is not of this program",
        params: specs,
        variants: &[""],
        also_tested: &[],
        known_defect: no_defect,
        sampled: false,
    }));
    let origin = Origin {
        file: file_name(file),
        sha256,
        version: description.version.clone(),
        has_own_test: description.has_own_test,
        own_process: !options.in_process,
        empty_call_s: 0.0,
    };
    let plugin = Plugin { info, description, origin, library, launch, waiting: Mutex::default() };
    plugins().insert(name, Arc::new(plugin));
    Ok(Entry::new(info, built::<f32>, built::<f64>))
}

/// Description that a plugin gives in a separate process, which then ends.
fn described(launch: &Launch) -> Result<Description, PluginError> {
    let file = || launch.file.clone();
    std::fs::metadata(&launch.file).map_err(|source| PluginError::Read { file: file(), source })?;
    let died = |how: String| PluginError::Invalid {
        file: file(),
        what: format!("{how} while describing itself"),
    };
    let mut remote = Remote::start(launch).map_err(died)?;
    remote.describe().map_err(|how| match remote.failure() {
        Some(_) => died(how),
        // what the child says of the file begins with its name
        None => PluginError::Child(how),
    })
}

/// The builder of every plugin's line, which builds anew whatever was before.
fn built<S: PluginScalar>(params: &Params) -> PreparedStructure<S> {
    let (structure, row, memory) = (params.structure(), params.to_string(), params.memory());
    let refused =
        move |message: &str| BuildError::Library { structure, message: message.to_owned() };
    let plugin = plugins().get(structure).cloned();
    let settings = plugin.iter().flat_map(|plugin| &plugin.description.settings);
    let values: Vec<String> = settings.map(|s| params.text(&s.name).to_owned()).collect();
    Box::new(move |prims, _| {
        let plugin = plugin.clone().ok_or_else(|| refused("no plugin has this name"))?;
        if S::NAME == "f64" && !plugin.description.has_f64 {
            return Err(refused(
                "supports f32 only (it lacks RTBENCH_TRIANGLES_F64); leave out --precision f64",
            ));
        }
        let PrimsRef::Watertight(set) = prims else {
            return Err(refused(
                "plugins support static triangles only; scenes named ...-tess are tessellated",
            ));
        };
        Ok(Box::new(PluginTracer::build(plugin, set, row.clone(), &values, memory)?))
    })
}

/// The name of a file without its folders.
fn file_name(file: &Path) -> String {
    file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}
