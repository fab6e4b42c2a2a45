//! How the nodes of a glTF scene stand at a moment: what an animation says instead of the file.

use std::collections::BTreeMap;

use glam::{DQuat, DVec3};

/// Animated values by node.
#[derive(Debug, Default)]
pub(crate) struct Pose {
    pub nodes: BTreeMap<usize, NodePose>,
}

/// Animated values of a node; `None` where the file's own values apply.
#[derive(Debug, Default)]
pub(crate) struct NodePose {
    pub translation: Option<DVec3>,
    pub rotation: Option<DQuat>,
    pub scale: Option<DVec3>,
    pub weights: Option<Vec<f64>>,
    /// Its scale gets through zero somewhere in the animation, or may.
    pub is_unsteady: bool,
}

impl Pose {
    pub fn of(&self, node: usize) -> Option<&NodePose> {
        self.nodes.get(&node)
    }

    pub fn is_steady(&self, node: usize) -> bool {
        self.of(node).is_none_or(|pose| !pose.is_unsteady)
    }
}

impl NodePose {
    /// True when its transform is animated.
    pub fn is_placed(&self) -> bool {
        self.translation.is_some() || self.rotation.is_some() || self.scale.is_some()
    }
}
