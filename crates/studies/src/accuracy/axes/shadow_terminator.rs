//! Shadow rays from smoothly shaded meshes that their own mesh blocks.
//!
//! Where the shading normal faces a light and the facet does not, the ray to the light starts into
//! the mesh, and a black edge of facets stands out against the smooth shading: the shadow
//! terminator (P. Woo, A. Pearce, M. Ouellette, "It's Really Not a Rendering Bug, You See...", IEEE
//! CG&A 16(5), 1996). A rule of offsets may hide a part of it, and that of no offset adds acne.
//! Shadows that a mesh rightly throws on itself are counted, too: they are the same under each
//! rule.

use std::collections::HashMap;

use accel_core::Ray;
use glam::DVec3;
use measurement::rounds::scene_run::light_positions;
use renderer::ray_offset::OffsetRule;
use scene_loading::{Scene, Shape};

use super::secondary_rays::{Columns, Departure, RayPurpose, SecondaryRays, SecondaryWork, Ways};
use crate::accuracy::record::in_a_million;

/// Shadow rays of points that the shading says are lit.
#[derive(Default)]
pub struct LitPoints<'a> {
    meshes: Vec<usize>,
    ids: Vec<u32>,
    ways: Ways<'a>,
    /// True if the facet faces away from the light.
    turned_away: Vec<bool>,
}

impl<'a> LitPoints<'a> {
    /// Points on patches, each hit once, for each light.
    pub fn new(scene: &Scene, secondary: &SecondaryRays<'a>) -> Self {
        let mut lit = Self { meshes: meshes(scene), ..Self::default() };
        let lights = light_positions(scene);
        let is_smooth = |d: &&Departure| {
            let shape = scene.primitives.get(d.id as usize).map(|p| p.shape);
            matches!(shape, Some(Shape::Patch { .. }))
        };
        for departure in once(&secondary.departures).filter(is_smooth) {
            let point = secondary.point(departure);
            let facing = |n: DVec3| if n.dot(departure.incoming) > 0.0 { -n } else { n };
            for &light in &lights {
                let way = light - point.position;
                if facing(point.normal).dot(way) > 0.0 {
                    lit.ids.push(departure.id);
                    lit.ways.push((point, RayPurpose::To(light)));
                    lit.turned_away.push(facing(point.refined.normal).dot(way) <= 0.0);
                }
            }
        }
        lit
    }

    /// What a rule leaves blocked; nothing where the eye sees no smooth surface that faces a light.
    pub fn columns(&self, secondary: &SecondaryRays<'_>, rule: OffsetRule) -> Columns {
        if self.ids.is_empty() {
            return Vec::new();
        }
        let blocked = blocked(&self.meshes, &self.ids, &secondary.work(rule, self.ways.clone()));
        let part = |is: fn(FirstBlocker) -> bool| {
            let n = blocked.iter().filter(|b| is(**b)).count();
            in_a_million(n as u64, self.ids.len() as u64)
        };
        let by_mesh = part(|b| matches!(b, FirstBlocker::Itself | FirstBlocker::Mesh));
        vec![
            ("lit shadow rays blocked by their own mesh in 10^6", by_mesh),
            ("of these by the facet itself in 10^6", part(|b| b == FirstBlocker::Itself)),
        ]
    }

    pub fn words(&self) -> String {
        format!(
            "{} shadow rays from smooth surfaces whose shading faces the light, of which the facets of \
             {} face away",
            self.ids.len(),
            self.turned_away.iter().filter(|t| **t).count()
        )
    }
}

/// The hits, without those that repeat them.
fn once(departures: &[Departure]) -> impl Iterator<Item = &Departure> {
    let first = departures.first().map(|d| (d.id, d.position));
    let is_again = move |d: &Departure| Some((d.id, d.position)) == first;
    let again = departures.iter().skip(1).position(is_again).map_or(departures.len(), |i| i + 1);
    departures.iter().take(again)
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum FirstBlocker {
    No,
    /// The facet that it leaves.
    Itself,
    /// Another one of the mesh.
    Mesh,
    Another,
}

fn blocked(meshes: &[usize], ids: &[u32], work: &SecondaryWork<'_>) -> Vec<FirstBlocker> {
    let mesh = |id: u32| meshes.get(id as usize);
    let of = |(id, (_, _, hit)): (&u32, (_, &Ray<f32>, &accel_core::Hit<f32>))| match hit.id {
        _ if !hit.is_hit() => FirstBlocker::No,
        by if by == *id => FirstBlocker::Itself,
        by if mesh(by) == mesh(*id) => FirstBlocker::Mesh,
        _ => FirstBlocker::Another,
    };
    ids.iter().zip(work.outcomes()).map(of).collect()
}

/// The mesh of each primitive: those that share a corner are of one (disjoint sets with path
/// halving, R. Tarjan and J. van Leeuwen, JACM 31(2), 1984).
fn meshes(scene: &Scene) -> Vec<usize> {
    let mut parent: Vec<usize> = (0..scene.primitives.len()).collect();
    fn root(parent: &mut [usize], mut id: usize) -> usize {
        while parent[id] != id {
            parent[id] = parent[parent[id]];
            id = parent[id];
        }
        id
    }
    let mut at_corner: HashMap<[u64; 3], usize> = HashMap::new();
    for (id, primitive) in scene.primitives.iter().enumerate() {
        for corner in scene.outline(primitive.shape) {
            // one zero for both signs
            let key = corner.to_array().map(|x| (x + 0.0).to_bits());
            let other = *at_corner.entry(key).or_insert(id);
            let (a, b) = (root(&mut parent, id), root(&mut parent, other));
            parent[a] = b;
        }
    }
    (0..parent.len()).map(|id| root(&mut parent, id)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::stage::{Limits, PreparedScene, Stage};
    use crate::verify::meshes::icosphere;
    use accel_core::occluders;
    use accel_core::structures::REGISTRY;
    use glam::dvec3;
    use measurement::system::clock::SystemClock;
    use renderer::RaySettings;
    use scene_loading::{Camera, Light};

    /// A coarse ball, smoothly shaded, lit from the side: what of its lit shading is blocked, and
    /// what faces away.
    fn on_a_ball(rule: OffsetRule) -> (Vec<FirstBlocker>, Vec<bool>) {
        let (mut scene, material) = Scene::of_one_material("coarse ball");
        for corners in icosphere(2, DVec3::ZERO) {
            scene.push_patch(material, corners, corners.map(DVec3::normalize));
        }
        scene.lights = vec![Light::point(dvec3(50.0, 3.0, 8.0), None)];
        scene.camera = Camera { from: dvec3(1.0, 2.0, 6.0), at: DVec3::ZERO, ..Camera::default() };
        let settings = RaySettings { resolution: [96; 2], ..RaySettings::default() };
        let prepared = PreparedScene::new(scene, REGISTRY, &settings).unwrap();
        let stage = Stage {
            axis: "ray-offset",
            name: "coarse ball",
            prepared: &prepared,
            registry: REGISTRY,
            occluders: occluders::REGISTRY,
            clock: &SystemClock::default(),
            limits: Limits {
                seed: 1,
                rounds: 1,
                timed_rays: 10_000,
                aims: 20_000,
                quick: true,
                only_times: false,
            },
        };
        let secondary = SecondaryRays::new(&stage, &prepared.scene, &prepared.geometry).unwrap();
        let lit = LitPoints::new(&prepared.scene, &secondary);
        assert!(lit.ids.len() > 500 && lit.ids.len() < 10_000, "{}", lit.ids.len());
        let work = secondary.work(rule, lit.ways);
        (blocked(&lit.meshes, &lit.ids, &work), lit.turned_away)
    }

    #[test]
    fn a_convex_mesh_blocks_exactly_where_its_facets_face_away() {
        let (blocked, turned_away) = on_a_ball(OffsetRule::default());
        assert!(turned_away.iter().filter(|t| **t).count() > 20);
        for (blocked, turned_away) in blocked.iter().zip(&turned_away) {
            let expected = if *turned_away { FirstBlocker::Mesh } else { FirstBlocker::No };
            assert_eq!(*blocked, expected);
        }
    }

    #[test]
    fn rules_that_are_wrong_show() {
        // planted: no offset blocks what faces the light, one as large as the ball nothing
        let (blocked, turned_away) = on_a_ball(OffsetRule::None);
        let acne = blocked.iter().zip(&turned_away);
        assert!(acne.filter(|(b, t)| **b == FirstBlocker::Itself && !**t).count() > 100);
        let (blocked, _) = on_a_ball(OffsetRule::Fixed(3.0));
        assert!(blocked.iter().all(|b| *b == FirstBlocker::No));
    }

    #[test]
    fn meshes_are_what_shares_corners() {
        let (mut scene, material) = Scene::of_one_material("two meshes and a ball");
        scene.push_triangle(material, [DVec3::ZERO, DVec3::X, DVec3::Y]);
        scene.push_triangle(material, [DVec3::X * 2.0, DVec3::X * 3.0, DVec3::Y * 2.0]);
        scene.push_sphere(material, DVec3::ZERO, 1.0);
        scene.push_triangle(material, [DVec3::Y, DVec3::Z, -DVec3::X * 0.0]);
        let found = meshes(&scene);
        assert_eq!(found[0], found[3]);
        assert!(found[0] != found[1] && found[2] != found[0] && found[2] != found[1]);
    }
}
