//! From the f64 scene to the primitive sets that structures are built over, converted once.

use accel_core::primitives::{
    Cone, Instance, Instances, MixedSet, MixedSetBuilder, PrimitiveError, PrimsRef, TriangleSet,
};
use accel_core::registry::{Buildable, PerScalar, ScalarPair};
use accel_core::update;
use accel_core::{Vec3, Vector};
use glam::DVec3;
use scene_loading::{Primitive, Scene, Shape};

/// Why a scene's geometry cannot be used.
#[derive(Debug, Clone, thiserror::Error)]
#[error("scene {scene}: {source}")]
pub struct GeometryError {
    pub scene: String,
    pub source: PrimitiveError,
}

/// A scene's primitives in the precision `S`; ids are the positions in [`Scene::primitives`].
pub enum Geometry<S: Buildable> {
    /// Triangles alone, with the watertight test.
    Triangles(TriangleSet<S>),
    /// Primitives of several kinds.
    Mixed(MixedSet<S>),
}

impl<S: Buildable> Geometry<S> {
    /// A triangle set where every primitive is a triangle, patch or three-sided polygon and none
    /// moves while the shutter is open, else a mixed set.
    ///
    /// # Errors
    /// [`GeometryError`] for coordinates that are not finite in `S` and polygons with too few
    /// vertices.
    pub fn of(scene: &Scene) -> Result<Self, GeometryError> {
        S::of_both(&OF_SCENE)(scene)
    }

    fn of_scene(scene: &Scene) -> Result<Self, GeometryError> {
        let error = |source| GeometryError { scene: scene.name.clone(), source };
        let moves =
            scene.camera.shutter > 0.0 && scene.velocities.iter().any(|v| *v != DVec3::ZERO);
        let claim = |i: &scene_loading::Instance| Instance {
            object: i.object,
            first: i.first,
            count: i.count,
            placement: i.placement,
        };
        let claims: Vec<Instance> = scene.instances.iter().map(claim).collect();
        if !moves && scene.primitives.iter().all(|p| is_triangle(p.shape)) {
            let triangles = scene.primitives.iter().map(|p| triangle(scene, p.shape)).collect();
            let set =
                TriangleSet::new(triangles, |id| is_transmissive(scene, id)).map_err(error)?;
            Ok(Self::Triangles(set.with_instances(&claims)))
        } else {
            Ok(Self::Mixed(mixed(scene).map_err(error)?.with_instances(&claims)))
        }
    }

    /// The primitives that are others than in the frame `before`, ascending; none where the frames
    /// have not the same ones.
    pub fn moved_since(&self, before: &Self) -> Option<Vec<u32>> {
        match (before, self) {
            (Self::Triangles(before), Self::Triangles(now)) => update::moved(before, now),
            (Self::Mixed(before), Self::Mixed(now)) => update::moved(before, now),
            _ => None,
        }
    }

    /// Forgets those of its parts that are not where the transform since the frame `before` takes
    /// them.
    pub fn keep_rigid(&mut self, before: &Self) {
        match (before, self) {
            (Self::Triangles(before), Self::Triangles(now)) => now.keep_rigid(before),
            (Self::Mixed(before), Self::Mixed(now)) => now.keep_rigid(before),
            _ => {}
        }
    }

    pub fn prims(&self) -> PrimsRef<'_, S> {
        match self {
            Self::Triangles(set) => PrimsRef::Watertight(set),
            Self::Mixed(set) => PrimsRef::Mixed(set),
        }
    }

    /// Primitives that are copies of others.
    pub fn instances(&self) -> Option<&Instances> {
        self.prims().primitives().instances()
    }

    pub fn len(&self) -> usize {
        self.prims().primitives().len()
    }

    /// True when there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub fn bytes(&self) -> usize {
        self.prims().primitives().bytes()
    }
}

struct GeometryOfScene;

impl PerScalar for GeometryOfScene {
    type In<S: Buildable> = fn(&Scene) -> Result<Geometry<S>, GeometryError>;
}

static OF_SCENE: ScalarPair<GeometryOfScene> =
    ScalarPair { f32: Geometry::of_scene, f64: Geometry::of_scene };

fn is_triangle(shape: Shape) -> bool {
    matches!(shape, Shape::Triangle { .. } | Shape::Patch { .. } | Shape::Polygon { count: 3, .. })
}

fn is_transmissive(scene: &Scene, id: u32) -> bool {
    let material = |p: &Primitive| scene.materials.get(p.material as usize);
    let material = scene.primitives.get(id as usize).and_then(material);
    material.is_some_and(|m| m.transmittance > 0.0)
}

fn triangle<S: Buildable>(scene: &Scene, shape: Shape) -> [[S; 3]; 3] {
    let v = match shape {
        Shape::Triangle { v } | Shape::Patch { v, .. } => v,
        Shape::Polygon { first, .. } => [first, first + 1, first + 2],
        Shape::Sphere(_) | Shape::Cone(_) => [0; 3],
    };
    v.map(|i| Vec3::<S>::from_dvec3(scene.vertices[i as usize]).to_array())
}

fn mixed<S: Buildable>(scene: &Scene) -> Result<MixedSet<S>, PrimitiveError> {
    let mut set = MixedSetBuilder::<S>::default();
    for (id, primitive) in scene.primitives.iter().enumerate() {
        match primitive.shape {
            Shape::Sphere(i) => {
                let s = scene.spheres[i as usize];
                set.sphere(s.center, s.radius)?;
            }
            Shape::Cone(i) => {
                let c = scene.cones[i as usize];
                set.cone(Cone::new(c.base, c.base_radius, c.apex, c.apex_radius))?;
            }
            Shape::Triangle { v } | Shape::Patch { v, .. } => {
                set.triangle(v.map(|i| scene.vertices[i as usize]))?;
            }
            Shape::Polygon { first, count } => {
                set.polygon(&scene.vertices[first as usize..][..count as usize])?;
            }
        }
        let velocity = scene.velocity(id as u32);
        if velocity != DVec3::ZERO && scene.camera.shutter > 0.0 {
            set.last_moves(velocity, scene.camera.shutter)?;
        }
        if is_transmissive(scene, id as u32) {
            set.last_is_transmissive();
        }
    }
    Ok(set.finish())
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene_loading::SceneCatalogue;

    #[test]
    fn columns_of_the_pavilion_are_copies() {
        let scenes = SceneCatalogue::embedded().unwrap().resolve(&["pavilion".to_owned()]).unwrap();
        let mut scene = scenes[0].load().unwrap().scene;
        let copies = |scene: &Scene| {
            let geometry = Geometry::<f32>::of(scene).unwrap();
            let instances = geometry.instances().unwrap();
            (instances.objects(), instances.copies())
        };
        // ten columns, and two of another mesh
        assert_eq!(copies(&scene), (2, 12));
        // what a scene claims is not believed: a column of which a corner was moved is none
        let column = scene.instances.iter().filter(|i| i.object == 2).nth(3).unwrap();
        let moved = scene.outline(scene.primitives[column.first as usize].shape)[0];
        for vertex in scene.vertices.iter_mut().filter(|v| **v == moved) {
            vertex.x += 0.01;
        }
        assert_eq!(copies(&scene), (2, 11));
    }
}
