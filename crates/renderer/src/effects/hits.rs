//! The stages that correct hits: colours from images (the colour of a material times the image at
//! the hit), and surfaces of what moves.
//!
//! Papers: R. Cook, T. Porter, L. Carpenter, "Distributed Ray Tracing", SIGGRAPH 1984 (motion blur:
//! every eye ray has a time within the exposure, and its path sees moving primitives where they are
//! then); E. Catmull, "A Subdivision Algorithm for Computer Display of Curved Surfaces", thesis,
//! University of Utah, 1974.
//! Deviations: primitives move in a straight line at constant speed; eye and lights are at rest.
//! Hits are points, so the image is interpolated between the four nearest texels (bilinear) and not
//! averaged over the area that a pixel covers: no mip maps, far texels alias (supersampling helps).
//! Texel centres are at (i + 1/2) / size.

use glam::{DVec2, DVec3};
use scene_loading::{Rgb, Scene, Shape, Texture};

use super::stages::{HitStage, SurfaceHit};
use crate::surface::{Surfaces, barycentric};

/// Looks up the surfaces of moving primitives where they are at rest.
pub struct MovedSurfaces<'a> {
    scene: &'a Scene,
    surfaces: Surfaces<'a>,
}

impl<'a> MovedSurfaces<'a> {
    pub fn new(scene: &'a Scene) -> Self {
        Self { scene, surfaces: Surfaces::new(scene, false) }
    }
}

impl HitStage for MovedSurfaces<'_> {
    fn apply(&self, hits: &mut [SurfaceHit<'_>]) {
        for hit in hits {
            let velocity = self.scene.velocity(hit.id);
            if velocity != DVec3::ZERO {
                let way = velocity * hit.origin.time;
                let at_rest = self.surfaces.at(hit.id, hit.point.position - way);
                hit.point.normal = at_rest.normal;
                hit.point.refined = at_rest.refined.moved_by(way);
            }
        }
    }
}

/// Colours hits on textured triangles.
pub struct ImageColors<'a>(pub &'a Scene);

impl HitStage for ImageColors<'_> {
    fn apply(&self, hits: &mut [SurfaceHit<'_>]) {
        for hit in hits {
            let Some(texture) = hit.point.material.texture else { continue };
            // images stay on what moves
            let way = self.0.velocity(hit.id) * hit.origin.time;
            let place = texture_place(self.0, hit.id, hit.point.position - way);
            if let (Some(texture), Some(place)) = (self.0.textures.get(texture as usize), place) {
                let [r, g, b] = bilinear(texture, place);
                let [own_r, own_g, own_b] = hit.point.material.color;
                hit.point.color = [own_r * r, own_g * g, own_b * b];
            }
        }
    }
}

/// Texture coordinates at a point of a triangle; `None` where it has none.
fn texture_place(scene: &Scene, id: u32, position: DVec3) -> Option<DVec2> {
    let corners = scene.texcoords_of(id)?;
    let (Shape::Triangle { v } | Shape::Patch { v, .. }) = scene.primitives.get(id as usize)?.shape
    else {
        return None;
    };
    let weights = barycentric(v.map(|i| scene.vertices[i as usize]), position)?;
    let weighted = |([u, v], weight): ([f32; 2], f64)| DVec2::new(u.into(), v.into()) * weight;
    Some(corners.into_iter().zip(weights).map(weighted).sum())
}

/// The image at a place, from black 0 to white 1, interpolated between the four nearest texels.
pub fn bilinear(texture: &Texture, place: DVec2) -> Rgb {
    let [width, height] = texture.size;
    let x = place.x * f64::from(width) - 0.5;
    let y = place.y * f64::from(height) - 0.5;
    let (left, upper) = (x.floor(), y.floor());
    let (right_share, lower_share) = (x - left, y - upper);
    // far out, where there are no fractions, the cast saturates: any texel will do
    let columns = [left as i64, (left as i64).saturating_add(1)];
    let rows = [upper as i64, (upper as i64).saturating_add(1)];
    let [columns, rows] = [(columns, texture.wrap[0], width), (rows, texture.wrap[1], height)]
        .map(|(indices, wrap, size)| indices.map(|i| wrap.texel(i, size)));
    let texel = |column: u32, row: u32| {
        let at = row as usize * width as usize + column as usize;
        texture.texels.get(at).map_or([0.0; 3], |texel| texel.map(|x| f64::from(x) / 255.0))
    };
    let mix =
        |a: Rgb, b: Rgb, share: f64| std::array::from_fn(|k| a[k] * (1.0 - share) + b[k] * share);
    let [upper, lower] =
        rows.map(|row| mix(texel(columns[0], row), texel(columns[1], row), right_share));
    mix(upper, lower, lower_share)
}

#[cfg(test)]
mod tests {
    use super::super::effect::{EFFECTS, Effect, RenderSettings};
    use super::*;
    use scene_loading::{Material, Wrap};

    /// Black, red / green, white.
    fn image(wrap: Wrap) -> Texture {
        let texels = vec![[0, 0, 0], [255, 0, 0], [0, 255, 0], [255, 255, 255]].into();
        Texture { name: "test".into(), size: [2, 2], wrap: [wrap; 2], texels }
    }

    #[test]
    fn texel_centres_and_between_them() {
        let at = |u, v| bilinear(&image(Wrap::Repeat), DVec2::new(u, v));
        assert_eq!(at(0.25, 0.25), [0.0, 0.0, 0.0]);
        assert_eq!(at(0.75, 0.25), [1.0, 0.0, 0.0]);
        assert_eq!(at(0.25, 0.75), [0.0, 1.0, 0.0]);
        assert_eq!(at(0.75, 0.75), [1.0, 1.0, 1.0]);
        assert_eq!(at(0.5, 0.25), [0.5, 0.0, 0.0]);
        assert_eq!(at(0.25, 0.375), [0.0, 0.25, 0.0]);
        assert_eq!(at(0.5, 0.5), [0.5, 0.5, 0.25]);
    }

    #[test]
    fn beyond_the_edges() {
        let at = |wrap, u| bilinear(&image(wrap), DVec2::new(u, 0.25))[0];
        // the right neighbour of the last texel: the first one, itself mirrored, itself
        assert_eq!([Wrap::Repeat, Wrap::Mirror, Wrap::Clamp].map(|w| at(w, 1.0)), [0.5, 1.0, 1.0]);
        let next = [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp].map(|w| at(w, 1.75));
        assert_eq!(next, [1.0, 0.0, 1.0]);
        assert_eq!(at(Wrap::Repeat, -1.25), at(Wrap::Repeat, 0.75));
        for u in [f64::from(f32::MAX), -1e300, 1e18] {
            for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
                assert!((0.0..=1.0).contains(&at(wrap, u)), "{wrap:?} {u}");
            }
        }
    }

    #[test]
    fn the_colour_of_the_material_times_that_of_the_image() {
        let mut scene = Scene::new("a");
        let (color, texture) = ([0.5, 1.0, 1.0], Some(0));
        scene.push_material(Material { color, texture, ..Material::default() });
        scene.textures.push(image(Wrap::Clamp));
        scene.push_triangle(0, [DVec3::ZERO, DVec3::X * 4.0, DVec3::Y * 4.0]);
        let textures = &EFFECTS[Effect::Textures as usize];
        let called_by = |scene: &Scene| (textures.called_by)(scene, &RenderSettings::default());
        assert_eq!(called_by(&scene), None);
        scene.last_is_textured([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
        let called = called_by(&scene);
        assert_eq!(called.as_deref(), Some("1 material with a texture"));
        let place = texture_place(&scene, 0, DVec3::new(3.0, 1.0, 0.0)).unwrap();
        assert_eq!(place, DVec2::new(0.75, 0.25));
        assert_eq!(texture_place(&scene, 1, DVec3::ZERO), None);
    }
}
