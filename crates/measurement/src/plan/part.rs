//! The part of a plan that one shard measures; see [`crate::settings::shard`].

use accel_core::occluders;
use accel_core::structures::Entry;

use crate::plan::Plan;
use crate::plan::error::PlanError;
use crate::plan::measured_row::MeasuredRow;
use crate::scenes::SceneSource;
use crate::settings::RunSettings;
use crate::settings::shard::{PlannedPart, Shard, ShardRecord};

impl<'r> Plan<'r> {
    /// [`Plan::new`], or the part of it that the settings name.
    pub fn of_run(
        settings: &RunSettings,
        registry: &'r [Entry],
        occluders: &'r [occluders::Entry],
        scenes: &dyn SceneSource,
    ) -> Result<Self, PlanError> {
        let plan = Self::new(settings, registry, occluders, scenes)?;
        match settings.shard {
            Some(shard) => plan.part_of(shard),
            None => Ok(plan),
        }
    }

    pub fn part_of(mut self, shard: Shard) -> Result<Self, PlanError> {
        let record = ShardRecord {
            index: shard.index,
            count: shard.count,
            scenes: self.scenes.iter().map(|scene| scene.name().to_owned()).collect(),
            rows: self.rows.iter().map(MeasuredRow::label).collect(),
            reference: self.baseline,
            rounds: format!("{:?}", self.rounds),
        };
        let cells = record.cells();
        if shard.count as usize > cells {
            return Err(PlanError::Invalid(format!(
                "--shard {shard}: this run has {cells} cells (scenes times rows, without the \
                 reference); use at most {cells} shards"
            )));
        }
        let mut rows: Vec<Vec<usize>> =
            (0..record.scenes.len()).map(|scene| record.rows_of(scene)).collect();
        let mut of_scenes = rows.iter();
        self.scenes.retain(|_| of_scenes.next().is_some_and(|rows| !rows.is_empty()));
        rows.retain(|rows| !rows.is_empty());
        self.part = Some(PlannedPart { record, rows });
        self.keeps_baseline = true;
        Ok(self)
    }

    /// Number of rows measured in the scene at this place.
    pub fn rows_in(&self, scene: usize) -> usize {
        let part = self.part.as_ref().and_then(|part| part.rows.get(scene));
        part.map_or(self.rows.len(), Vec::len)
    }

    /// The plan of the scene at that place alone, where it has not all rows.
    pub fn of_scene(&self, scene: usize) -> Option<Plan<'r>> {
        let places = self.part.as_ref()?.rows.get(scene)?;
        Some(Plan {
            scenes: Vec::new(),
            rows: places.iter().filter_map(|&row| self.rows.get(row).cloned()).collect(),
            baseline: places.iter().position(|&row| row == self.baseline).unwrap_or(0),
            answers: self.answers.clone(),
            kinds: self.kinds.clone(),
            strides: self.strides.clone(),
            part: None,
            ..*self
        })
    }
}
