//! HUG's five settings of 1999: HNG size classes, gap HCN, historical boxes.

use super::{PublishedScene, ReproduceError, Work, registered};

/// Builds HUG with the published setting, like `HNG=2 HCN=0`, and counts.
pub(super) fn count(scene: &PublishedScene, params: &str) -> Result<Work, ReproduceError> {
    let entry = registered("hug")?;
    let mut settings = vec![("boxes", "historical")];
    for part in params.split_whitespace() {
        match part.split_once('=') {
            Some(("HNG", classes)) => settings.push(("size-classes", classes)),
            Some(("HCN", gap)) => settings.push(("gap", gap)),
            _ => return Err(ReproduceError::UnknownSetting(params.to_owned())),
        }
    }
    let tracer = entry.build(scene.geometry.prims(), &entry.params(settings)?)?;
    Ok(scene.count(tracer.as_ref()))
}
