//! Animations far from the origin of their coordinates: all frames are moved by what the first one
//! needs.

use glam::DVec3;

use crate::animation::frames::Animation;
use crate::error::LoadError;
use crate::scene::Scene;
use crate::scene::origin::origin_for;

pub(super) struct Rebased {
    frames: Box<dyn Animation>,
    /// Known once the first frame was made.
    origin: Option<DVec3>,
}

impl Rebased {
    pub fn boxed(frames: Box<dyn Animation>) -> Box<dyn Animation> {
        Box::new(Self { frames, origin: None })
    }
}

impl Animation for Rebased {
    fn name(&self) -> &str {
        self.frames.name()
    }

    fn frames(&self) -> u32 {
        self.frames.frames()
    }

    fn frame(&mut self, index: u32) -> Result<Scene, LoadError> {
        let mut scene = self.frames.frame(index)?;
        let origin = match self.origin {
            Some(origin) => origin,
            None if index == 0 => origin_for(&scene.bounds()),
            None => origin_for(&self.frames.frame(0)?.bounds()),
        };
        self.origin = Some(origin);
        scene.bring_to(origin);
        Ok(scene)
    }
}
