//! Implementation choices of a row apart from its structure: setup and tests, triangle kernel,
//! query mode. Rows that differ only in these are the same structure.

use accel_core::params::{ParamKind, Params};

use measurement::plan::error::PlanError;
use measurement::plan::rows::Row;
use measurement::record::query::Query;
use measurement::record::{RowRecord, SceneRecord};

/// The settings that are code, in the order of names.
const SETTINGS: [&str; 3] = ["adapter", "kernel", "query"];
/// Libraries without a setting for it, as their authors use them.
const ALWAYS_DIRECT: [&str; 1] = ["obvhs-bvh2"];
/// Structures without a setting for it that always have their triangles in blocks.
const ALWAYS_BLOCKS: [&str; 2] = ["irregular-grid", "wide-bvh"];

/// A row of an explanation: a structure in a craft.
#[derive(Debug, Clone, PartialEq)]
pub struct Variant {
    /// The structure and those of its settings that are not code.
    pub structure: String,
    /// Code that sets up rays and tests primitives: [`DIRECT`], [`AS_SHIPPED`] or [`ROBUST`].
    pub adapter: &'static str,
    /// Triangles at a time: [`SCALAR`] or [`BLOCK`].
    pub kernel: &'static str,
    /// Rays in a call: [`ONE_RAY`], [`BATCH`] or [`PACKETS`].
    pub query: &'static str,
}

/// A library, as its authors use it.
pub const DIRECT: &str = "direct";
/// The same, with our tests of primitives that are not its triangles.
pub const AS_SHIPPED: &str = "as-shipped";
/// Our code, so that every answer is right.
pub const ROBUST: &str = "robust";

pub const SCALAR: &str = "scalar";
pub const BLOCK: &str = "block";

pub const ONE_RAY: &str = "one ray";
pub const BATCH: &str = "batch";
/// As in a batch, and rays that run alike share steps.
pub const PACKETS: &str = "packets";

impl Variant {
    /// As set, over triangles in f32.
    pub fn of(row: &Row<'_>) -> Self {
        let params = &row.params;
        let own = params.changed().filter(|(name, _)| !SETTINGS.contains(name));
        let settings: String = own.map(|(name, value)| format!(" {name}={value}")).collect();
        let structure = format!("{}{settings}", row.structure());
        let adapter = match params.get("adapter") {
            Some(DIRECT) => DIRECT,
            None if ALWAYS_DIRECT.contains(&params.structure()) => DIRECT,
            _ => ROBUST,
        };
        let has_blocks = match params.get("kernel") {
            Some(kernel) => kernel == BLOCK && adapter == ROBUST,
            None => ALWAYS_BLOCKS.contains(&params.structure()),
        };
        // what can be asked for scalar tests answers batches by blocks alone
        let query = match params.get("query") {
            _ if !has_blocks && params.get("kernel").is_some() => ONE_RAY,
            Some(BATCH) => BATCH,
            Some(PACKETS) => PACKETS,
            _ => ONE_RAY,
        };
        let is_block = has_blocks && !has_mailbox(params);
        let kernel = if is_block { BLOCK } else { SCALAR };
        Self { structure, adapter, kernel, query }
    }

    /// As it was in a scene: blocks serve triangles alone, a library's own triangles f32, too;
    /// whether batches were answered is recorded.
    pub fn in_scene(&self, scene: &SceneRecord, row: &RowRecord, precision: &str) -> Self {
        let only_triangles = scene.only_triangles.unwrap_or(true);
        let adapter = match self.adapter {
            DIRECT if !only_triangles || precision != "f32" => AS_SHIPPED,
            same => same,
        };
        let kernel = if only_triangles { self.kernel } else { SCALAR };
        let query = match (row.query, self.query) {
            (Query::OneRay, _) => ONE_RAY,
            (Query::Batch, PACKETS) => PACKETS,
            (Query::Batch, _) => BATCH,
        };
        Self { structure: self.structure.clone(), adapter, kernel, query }
    }

    /// Its craft: the column of tables, and what CSV files call it.
    pub fn name(&self) -> &'static str {
        match (self.adapter, self.kernel, self.query) {
            (DIRECT, ..) => DIRECT,
            (AS_SHIPPED, ..) => "as shipped",
            (_, kernel, ONE_RAY) => kernel,
            (_, SCALAR, BATCH) => "scalar, batch",
            (_, _, BATCH) => "block, batch",
            (_, SCALAR, _) => "scalar, packets",
            _ => "block, packets",
        }
    }

    /// Its properties, in the order of [`AXES`](crate::explain::steps::AXES).
    pub fn values(&self) -> [&str; 4] {
        [self.adapter, self.kernel, &self.structure, self.query]
    }
}

fn has_mailbox(params: &Params) -> bool {
    params.get("mailbox").is_some_and(|mailbox| mailbox != "none")
}

/// The row, and the same structure in its other crafts: adapters that are a library's own or give
/// right answers, kernels, ways of asking. One with a mailbox, which excludes blocks and batches,
/// stays alone.
pub fn crafts_of<'r>(row: &Row<'r>) -> Result<Vec<Row<'r>>, PlanError> {
    let mut rows = vec![row.clone()];
    if has_mailbox(&row.params) {
        return Ok(rows);
    }
    // a structure without the setting has one word that sets nothing
    let words = |name: &'static str| {
        let spec = row.entry.info.params.iter().find(|spec| spec.name == name);
        match spec.map(|spec| spec.kind) {
            Some(ParamKind::Choice(words)) => {
                words.iter().map(|word| Some((name, *word))).collect()
            }
            _ => vec![None],
        }
    };
    let is_other = |(name, _): &(&str, &str)| !SETTINGS.contains(name);
    let [adapters, kernels, queries] = SETTINGS.map(words);
    for adapter in adapters {
        let is_direct = adapter.is_some_and(|(_, word)| word == DIRECT);
        // a library's own test reads no kernel
        for kernel in if is_direct { &[None][..] } else { &kernels } {
            for query in &queries {
                let mut settings: Vec<(&str, &str)> =
                    row.params.changed().filter(is_other).collect();
                settings.extend([adapter, *kernel, *query].into_iter().flatten());
                let other = Row::of(row.entry, &settings)?;
                if rows.iter().all(|known| Variant::of(known) != Variant::of(&other)) {
                    rows.push(other);
                }
            }
        }
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use accel_core::structures::REGISTRY;

    use super::*;

    fn crafts(text: &str) -> Vec<&'static str> {
        let row = Row::parse(REGISTRY, text).unwrap();
        let rows = crafts_of(&row).unwrap();
        assert_eq!(rows[0], row);
        let variants: Vec<Variant> = rows.iter().map(Variant::of).collect();
        assert!(variants.iter().all(|v| v.structure == variants[0].structure), "{variants:?}");
        variants.iter().map(Variant::name).collect()
    }

    #[test]
    fn code_differences_follow_the_settings() {
        assert_eq!(crafts("uniform-grid"), ["block", "scalar", "block, batch"]);
        assert_eq!(crafts("kd-tree:max-leaf=4"), ["scalar", "block"]);
        assert_eq!(crafts("wide-bvh"), ["block", "block, batch", "block, packets"]);
        assert_eq!(crafts("irregular-grid:query=batch"), ["block, batch", "block"]);
        assert_eq!(crafts("brute-force"), ["scalar"]);
        assert_eq!(crafts("recursive-grid"), ["scalar", "block"]);
        assert_eq!(crafts("uniform-grid:mailbox=hash"), ["scalar"]);
        assert_eq!(crafts("irregular-grid:mailbox=hash"), ["scalar"]);
        assert_eq!(crafts("obvhs-cwbvh"), ["direct", "scalar", "block"]);
        let robust = "obvhs-cwbvh:preset=fastest:adapter=robust";
        assert_eq!(crafts(robust), ["block", "direct", "scalar"]);
        assert_eq!(crafts("obvhs-bvh2:preset=fastest"), ["direct"]);
        // a setting that this adapter does not read is no other craft
        assert_eq!(crafts("obvhs-cwbvh:kernel=scalar").len(), 3);
    }

    #[test]
    fn structures_that_always_use_blocks_have_no_kernel_parameter() {
        for name in ALWAYS_BLOCKS {
            let entry = REGISTRY.iter().find(|entry| entry.info.name == name).unwrap();
            assert!(entry.info.params.iter().all(|spec| spec.name != "kernel"), "{name}");
        }
    }

    #[test]
    fn settings_without_code_differences_count_as_structure() {
        let of = |text| Variant::of(&Row::parse(REGISTRY, text).unwrap()).structure;
        assert_eq!(of("uniform-grid:kernel=scalar:density=4"), "uniform-grid density=4");
        assert_eq!(of("obvhs-cwbvh:adapter=robust:preset=fast"), "obvhs-cwbvh preset=fast");
    }
}
