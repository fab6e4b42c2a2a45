//! What was asked for where a journal is kept.

use serde::{Deserialize, Serialize};

use crate::settings::RunSettings;
use crate::settings::scale::ScaleSettings;

/// What was asked for: by this a run that was broken off is gone on with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Asked {
    /// A run.
    Run(RunSettings),
    /// A run over the sizes of a scene.
    Scale(ScaleSettings),
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::rays::order::Orders;
    use crate::settings::shard::Shard;
    use crate::settings::sizes::Sizes;
    use crate::settings::{Lights, MeasuringSettings, Precision};

    fn measuring() -> MeasuringSettings {
        MeasuringSettings {
            rays: vec!["shadow".into()],
            order: Orders::Both,
            lights: Lights::First,
            pass_limit: Some(Duration::from_millis(100)),
            rounds: Some(7),
            precision: Precision::F64,
            max_memory: Some(u64::MAX),
            ..MeasuringSettings::default()
        }
    }

    fn run() -> Asked {
        Asked::Run(RunSettings {
            scenes: vec!["balls:4".into()],
            overrides: vec!["uniform-grid.density=4".into()],
            measuring: measuring(),
            shard: Some(Shard { index: 2, count: 8 }),
            ..RunSettings::default()
        })
    }

    #[test]
    fn what_is_written_is_read() {
        let scale = |sizes: &str| {
            Asked::Scale(ScaleSettings {
                scene: "hare".into(),
                sizes: Sizes::parse(sizes).unwrap(),
                per_decade: 2,
                structures: Vec::new(),
                overrides: Vec::new(),
                measuring: measuring(),
                time_limit: Duration::from_secs(60),
                max_memory: 1,
            })
        };
        for asked in [run(), scale("1e3..1e7"), scale("20k,1k")] {
            let text = serde_json::to_string(&asked).unwrap();
            assert_eq!(serde_json::from_str::<Asked>(&text).unwrap(), asked, "{text}");
        }
    }

    #[test]
    fn what_cannot_be_typed_cannot_be_read() {
        let text = serde_json::to_string(&run()).unwrap();
        for (from, to, said) in [
            ("2/8", "0/0", "expected I/N"),
            ("\"both\"", "\"none\"", "'none' is no value"),
            ("\"run\"", "\"sweep\"", "unknown variant"),
            ("\"seed\":1", "\"seed\":-1", "expected u64"),
        ] {
            let error = serde_json::from_str::<Asked>(&text.replace(from, to)).unwrap_err();
            assert!(error.to_string().contains(said), "{said}: {error}");
        }
    }
}
