//! Hashes of files and of scenes.

use glam::DVec3;
use sha2::{Digest, Sha256};

use crate::scene::{Material, Scene, Shape};

/// SHA-256 of bytes, in hexadecimal.
pub fn sha256_of_bytes(bytes: &[u8]) -> String {
    hex(Sha256::digest(bytes).as_slice())
}

/// SHA-256 of what a scene looks like: camera, background, lights, materials, geometry and the
/// order of the primitives; of a rebased scene where its origin was, too. Names and warnings do not
/// count. Numbers enter as the little-endian
/// bits of their `f64`, each list after its length, so the hash is the same on every machine.
pub fn sha256_of_scene(scene: &Scene) -> String {
    let mut hash = CanonicalHasher(Sha256::new());
    hash.0.update(b"rtbench scene 1\n");
    let camera = &scene.camera;
    hash.vectors(&[camera.from, camera.at, camera.up]);
    hash.numbers(&[camera.angle, camera.hither]);
    hash.words(&camera.resolution);
    hash.numbers(&scene.background);
    hash.length(scene.lights.len());
    for light in &scene.lights {
        hash.vectors(&[light.position]);
        hash.words(&[u32::from(light.color.is_some())]);
        hash.numbers(&light.color.unwrap_or_default());
    }
    hash.length(scene.materials.len());
    for m in &scene.materials {
        hash.numbers(&m.color);
        hash.numbers(&[m.diffuse, m.specular, m.shine, m.transmittance, m.refraction_index]);
    }
    for vectors in [&scene.vertices, &scene.normals] {
        hash.length(vectors.len());
        hash.vectors(vectors);
    }
    hash.length(scene.spheres.len());
    for sphere in &scene.spheres {
        hash.vectors(&[sphere.center]);
        hash.numbers(&[sphere.radius]);
    }
    hash.length(scene.cones.len());
    for cone in &scene.cones {
        hash.vectors(&[cone.base, cone.apex]);
        hash.numbers(&[cone.base_radius, cone.apex_radius]);
    }
    hash.length(scene.primitives.len());
    for primitive in &scene.primitives {
        match primitive.shape {
            Shape::Sphere(i) => hash.words(&[1, i]),
            Shape::Cone(i) => hash.words(&[2, i]),
            Shape::Polygon { first, count } => hash.words(&[3, first, count]),
            Shape::Triangle { v: [a, b, c] } => hash.words(&[4, a, b, c]),
            Shape::Patch { v: [a, b, c], n: [d, e, f] } => hash.words(&[5, a, b, c, d, e, f]),
        }
        hash.words(&[primitive.material]);
    }
    hash_effects(scene, &mut hash);
    hash_textures(scene, &mut hash);
    if scene.origin != DVec3::ZERO {
        hash.0.update(b"origin 1\n");
        hash.vectors(&[scene.origin]);
    }
    hex(hash.0.finalize().as_slice())
}

/// Hashes effects only if there are any, so that the hashes of all other scenes stay.
fn hash_effects(scene: &Scene, hash: &mut CanonicalHasher) {
    let camera = &scene.camera;
    let mut numbers: Vec<f64> = scene.lights.iter().map(|light| light.radius).collect();
    numbers.extend(scene.materials.iter().map(|m| m.roughness));
    numbers.extend([camera.aperture, camera.shutter, camera.focal_distance.unwrap_or(0.0)]);
    numbers.push(f64::from(scene.samples.supersamples.unwrap_or(1)) - 1.0);
    if scene.velocities.is_empty() && numbers.iter().all(|&x| x == 0.0) {
        return;
    }
    hash.0.update(b"effects 1\n");
    hash.numbers(&numbers);
    hash.length(scene.velocities.len());
    hash.vectors(&scene.velocities);
}

/// As [`hash_effects`]: nothing where nothing is textured. Names of images do not count.
fn hash_textures(scene: &Scene, hash: &mut CanonicalHasher) {
    if scene.textures.is_empty() && scene.texcoords.is_empty() {
        return;
    }
    hash.0.update(b"textures 1\n");
    let number = |m: &Material| m.texture.map_or(0, |i| i.saturating_add(1));
    hash.words(&scene.materials.iter().map(number).collect::<Vec<u32>>());
    hash.length(scene.textures.len());
    for texture in &scene.textures {
        let [u, v] = texture.wrap.map(|wrap| wrap as u32);
        hash.words(&[texture.size[0], texture.size[1], u, v]);
        hash.0.update(texture.texels.as_flattened());
    }
    hash.length(scene.texcoords.len());
    for corners in &scene.texcoords {
        hash.words(&[u32::from(corners.is_some())]);
        let bits = corners.unwrap_or_default().map(|corner| corner.map(f32::to_bits));
        hash.words(bits.as_flattened());
    }
}

struct CanonicalHasher(Sha256);

impl CanonicalHasher {
    fn words(&mut self, words: &[u32]) {
        for word in words {
            self.0.update(word.to_le_bytes());
        }
    }

    fn length(&mut self, length: usize) {
        self.0.update((length as u64).to_le_bytes());
    }

    fn numbers(&mut self, numbers: &[f64]) {
        for number in numbers {
            self.0.update(number.to_bits().to_le_bytes());
        }
    }

    fn vectors(&mut self, vectors: &[DVec3]) {
        for vector in vectors {
            self.numbers(&vector.to_array());
        }
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Light;
    use crate::scene::{Texture, Wrap};

    #[test]
    fn known_hash_of_bytes() {
        let expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(sha256_of_bytes(b"abc"), expected);
    }

    #[test]
    fn the_hash_covers_everything_visible() {
        let mut scene = Scene::new("a");
        scene.push_material(Material::default());
        scene.push_sphere(0, DVec3::ZERO, 1.0);
        let before = sha256_of_scene(&scene);
        // Published results name this hash: it must not drift.
        assert_eq!(before, "92a30a3d8b208b51f1720ddf2f32c5f0a27fda9c8a3edace37c8c15922143bb3");
        scene.name = "b".into();
        scene.materials[0].name = "red".into();
        assert_eq!(sha256_of_scene(&scene), before);
        for change in [
            |s: &mut Scene| s.spheres[0].radius = 2.0,
            |s: &mut Scene| s.camera.angle = 44.0,
            |s: &mut Scene| s.materials[0].specular = 0.1,
            |s: &mut Scene| s.lights.push(Light::point(DVec3::X, None)),
            |s: &mut Scene| s.background[1] = 0.5,
            |s: &mut Scene| s.camera.aperture = 0.1,
            |s: &mut Scene| s.camera.shutter = 1.0,
            |s: &mut Scene| s.materials[0].roughness = 0.1,
            |s: &mut Scene| s.last_moves(DVec3::X),
            |s: &mut Scene| s.last_is_textured([[0.0; 2]; 3]),
            |s: &mut Scene| s.origin.y = 1024.0,
        ] {
            let mut other = scene.clone();
            change(&mut other);
            assert_ne!(sha256_of_scene(&other), before);
        }
        let texture = |texel: u8, wrap| Texture {
            name: "a.png".into(),
            size: [1, 1],
            wrap: [Wrap::Repeat, wrap],
            texels: vec![[texel; 3]].into(),
        };
        let textured = |texture| {
            let mut other = scene.clone();
            other.textures.push(texture);
            other.materials[0].texture = Some(0);
            sha256_of_scene(&other)
        };
        let hash = textured(texture(7, Wrap::Repeat));
        assert_ne!(hash, before);
        assert_ne!(textured(texture(8, Wrap::Repeat)), hash);
        assert_ne!(textured(texture(7, Wrap::Mirror)), hash);
    }
}
