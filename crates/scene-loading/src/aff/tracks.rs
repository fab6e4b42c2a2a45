//! Animated triangles (`tpa`): corners and normals at times, straight lines between them.

use glam::DVec3;

use crate::scene::Scene;

/// A triangle and its keys.
pub(super) struct AnimatedPatch {
    /// The first of its three vertices, and of its three normals.
    pub first: [usize; 2],
    /// Times, ascending, with corners and normals.
    pub keys: Vec<(f64, [[DVec3; 2]; 3])>,
}

impl AnimatedPatch {
    /// Sets its corners and normals as at a time; before the first key and behind the last as
    /// there.
    pub fn set(&self, time: f64, scene: &mut Scene) {
        let next = self.keys.partition_point(|(at, _)| *at <= time);
        let (Some(before), Some(behind)) =
            (self.keys.get(next.saturating_sub(1)), self.keys.get(next).or(self.keys.last()))
        else {
            return;
        };
        let length = behind.0 - before.0;
        let share = if length > 0.0 { ((time - before.0) / length).clamp(0.0, 1.0) } else { 0.0 };
        for (i, (a, b)) in before.1.iter().zip(&behind.1).enumerate() {
            let lists = [&mut scene.vertices, &mut scene.normals];
            for ((list, first), (a, b)) in lists.into_iter().zip(self.first).zip(a.iter().zip(b)) {
                if let Some(slot) = list.get_mut(first + i) {
                    *slot = *a + (*b - *a) * share;
                }
            }
        }
    }
}
