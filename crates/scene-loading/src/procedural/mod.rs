//! Scenes generated in code: the Standard Procedural Databases (SPD), and [`OURS`].
//!
//! Eric Haines published these eight scenes for comparing ray tracers: E. Haines, "A Proposal for
//! Standard Graphics Environments", IEEE CG&A 7(11), 1987. Geometry, views, lights and materials
//! follow release 3.14 (<https://github.com/erich666/StandardProceduralDatabases>, CC0); each
//! module names the file its figures are from. Arithmetic is done in `f64` in the same order as
//! there, so that a scene printed with six digits equals the files in use since.
//!
//! A scene is named by a spec: `balls` (default size) or `balls:5`.

mod balls;
pub mod counts;
pub(crate) mod gears;
pub(crate) mod hare;
mod lattice;
mod mount;
pub(crate) mod parts;
mod rings;
mod stadium;
mod sticks;
mod teapot;
mod tetra;
mod tree;

use glam::DVec3;

use crate::scene::Scene;

#[derive(Debug, Clone, Copy)]
pub struct SpdEntry {
    pub name: &'static str,
    /// Size factor of the published scene, or of ours as measured.
    pub default_size: u32,
    /// Largest size factor that [`generate`] accepts: about 20 million primitives.
    pub max_size: u32,
    /// What the scene shows and how it grows with the size factor `n`.
    pub summary: &'static str,
    /// The generator, for sizes from 1 to `max_size`; [`generate`] checks that and sets the name.
    pub generate: fn(u32) -> Scene,
    /// Primitive counts at a size.
    pub count: fn(u32) -> counts::ShapeCounts,
}

/// The generators of the SPD, by name.
#[rustfmt::skip]
pub static SPD: &[SpdEntry] = &[
    SpdEntry { name: "balls", default_size: 4, max_size: 7, summary: "sphereflake: (9^(n+1) - 1) / 8 mirroring spheres on a square", generate: balls::generate, count: counts::balls },
    SpdEntry { name: "gears", default_size: 4, max_size: 51, summary: "n^3 meshing gears, some of glass: 146 polygons each, faces with 144 vertices", generate: gears::generate, count: counts::gears },
    SpdEntry { name: "lattice", default_size: 12, max_size: 170, summary: "cubic lattice: (n+1)^3 mirroring spheres, 3 n (n+1)^2 cylinders", generate: lattice::generate, count: counts::lattice },
    SpdEntry { name: "mount", default_size: 6, max_size: 11, summary: "fractal mountain of 2 * 4^n triangles, 4 glass spheres", generate: mount::generate, count: counts::mount },
    SpdEntry { name: "rings", default_size: 7, max_size: 99, summary: "pyramid of ring clusters: 5 n (n+1) (2n+1) cylinders and as many spheres", generate: rings::generate, count: counts::rings },
    SpdEntry { name: "teapot", default_size: 12, max_size: 554, summary: "teapot of 64 n^2 - 8 n triangular patches on a board of n^2 squares", generate: teapot::generate, count: counts::teapot },
    SpdEntry { name: "tetra", default_size: 6, max_size: 12, summary: "tetrahedral pyramid (Sierpinski): 4^n triangles", generate: tetra::generate, count: counts::tetra },
    SpdEntry { name: "tree", default_size: 11, max_size: 22, summary: "branching tree: 2^(n+1) - 1 cones and as many spheres", generate: tree::generate, count: counts::tree },
];

/// Generators of our own, by name: scenes of kinds that the SPD lacks.
#[rustfmt::skip]
pub static OURS: &[SpdEntry] = &[
    SpdEntry { name: "hare", default_size: 93, max_size: 1581, summary: "a hare as a closed mesh of 8 n^2 small triangles", generate: hare::generate, count: counts::hare },
    SpdEntry { name: "stadium", default_size: 93, max_size: 1580, summary: "the hare in a stadium: 8 n^2 small triangles, 15,800 up to 800 times as large", generate: stadium::generate, count: counts::stadium },
    SpdEntry { name: "sticks", default_size: 91, max_size: 1290, summary: "a heap of n^2 long thin sticks in all directions, 12 triangles each", generate: sticks::generate, count: counts::sticks },
];

/// All generators: [`SPD`], then [`OURS`].
pub fn generators() -> impl Iterator<Item = &'static SpdEntry> {
    SPD.iter().chain(OURS)
}

/// Why a spec names no scene.
#[allow(missing_docs, reason = "the message of a variant says what its fields are")]
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SpecError {
    /// There is no generator of that name.
    #[error("unknown procedural scene `{name}`; valid: {known}")]
    UnknownName { name: String, known: String },
    /// The size is not a number or not in the generator's range.
    #[error(
        "scene `{name}` has no size `{size}`: sizes are whole numbers from 1 to {max_size} \
         (default {default_size})"
    )]
    BadSize { name: &'static str, size: String, max_size: u32, default_size: u32 },
}

/// Name and size of `name` or `name:size`.
pub(crate) fn split_spec(spec: &str) -> (&str, Option<&str>) {
    spec.split_once(':').map_or((spec, None), |(name, size)| (name, Some(size)))
}

/// The size factor that a text says; without one the default.
pub(crate) fn size_of(
    name: &'static str,
    text: Option<&str>,
    default_size: u32,
    max_size: u32,
) -> Result<u32, SpecError> {
    let Some(text) = text else { return Ok(default_size) };
    let size = text.parse().ok().filter(|size| (1..=max_size).contains(size));
    size.ok_or_else(|| SpecError::BadSize { name, size: text.to_owned(), max_size, default_size })
}

/// The generator and the size factor that `spec` names: `name` or `name:size`.
///
/// # Errors
/// [`SpecError`] when the name is unknown or the size is not a number from 1 to the generator's
/// largest.
pub fn generator_of(spec: &str) -> Result<(&'static SpdEntry, u32), SpecError> {
    let (name, size) = split_spec(spec);
    let entry = generators().find(|entry| entry.name == name).ok_or_else(|| {
        let known = generators().map(|entry| entry.name).collect::<Vec<_>>().join(", ");
        SpecError::UnknownName { name: name.to_owned(), known }
    })?;
    Ok((entry, size_of(entry.name, size, entry.default_size, entry.max_size)?))
}

/// Generates the scene that `spec` names: `name` or `name:size`.
///
/// [`Scene::name`] is the spec in its shortest form: `balls` at the default size, else `balls:5`.
///
/// # Errors
/// As [`generator_of`].
pub fn generate(spec: &str) -> Result<Scene, SpecError> {
    let (entry, size) = generator_of(spec)?;
    let mut scene = (entry.generate)(size);
    scene.name = if size == entry.default_size {
        entry.name.to_owned()
    } else {
        format!("{}:{size}", entry.name)
    };
    Ok(scene)
}

/// [`generate`] with every number rounded to the six digits of the distributed files
/// ([`round_to_printed`]): what a reader of those files gets.
///
/// # Errors
/// As [`generate`].
pub fn generate_as_printed(spec: &str) -> Result<Scene, SpecError> {
    let mut scene = generate(spec)?;
    round_to_printed(&mut scene);
    Ok(scene)
}

/// Rounds every number of the scene - coordinates, radii, normals, colours, shares, exponents,
/// view - to what C's `printf("%g")` prints (six significant digits), as if it had been written to
/// an NFF file and read again.
pub fn round_to_printed(scene: &mut Scene) {
    let camera = &mut scene.camera;
    round_vectors([&mut camera.from, &mut camera.at, &mut camera.up]);
    round([&mut camera.angle, &mut camera.hither]);
    round(&mut scene.background);
    for light in &mut scene.lights {
        round_vectors([&mut light.position]);
        round(light.color.iter_mut().flatten());
    }
    for material in &mut scene.materials {
        round(&mut material.color);
        round([
            &mut material.diffuse,
            &mut material.specular,
            &mut material.shine,
            &mut material.transmittance,
            &mut material.refraction_index,
        ]);
    }
    round_vectors(scene.vertices.iter_mut().chain(&mut scene.normals));
    for sphere in &mut scene.spheres {
        round_vectors([&mut sphere.center]);
        round([&mut sphere.radius]);
    }
    for cone in &mut scene.cones {
        round_vectors([&mut cone.base, &mut cone.apex]);
        round([&mut cone.base_radius, &mut cone.apex_radius]);
    }
}

fn round_vectors<'a>(vectors: impl IntoIterator<Item = &'a mut DVec3>) {
    for vector in vectors {
        *vector = vector.map(printed);
    }
}

fn round<'a>(numbers: impl IntoIterator<Item = &'a mut f64>) {
    for number in numbers {
        *number = printed(*number);
    }
}

/// The number rounded to six significant decimal digits; negative zero becomes plain.
fn printed(x: f64) -> f64 {
    format!("{x:.5e}").parse().unwrap_or(x) + 0.0
}
