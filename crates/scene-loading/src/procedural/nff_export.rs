//! Writes scenes as NFF text (E. Haines' Neutral File Format, `NFF.TXT` of SPD 3.14).

use std::fmt;
use std::io;

use glam::DVec3;

use super::printed::PrintfG;
use crate::scene::{Material, Primitive, Scene, Shape};

/// Writes the scene as NFF, numbers with six significant digits ([`PrintfG`]).
///
/// The order is background, view, lights, primitives; a primitive of another material than the
/// one before it is preceded by that material's `f` line. So the text of an SPD scene is that of
/// the distributed file (but for the sign of zero). Triangles are written as polygons of three
/// vertices. NFF has no place for names and warnings, nor for materials that nothing is made of.
pub fn write_nff(scene: &Scene, out: &mut impl io::Write) -> io::Result<()> {
    let mut out = io::BufWriter::new(out);
    write_head(scene, &mut out)?;
    let mut current = None;
    for primitive in &scene.primitives {
        if current.replace(primitive.material) != Some(primitive.material)
            && let Some(material) = scene.materials.get(primitive.material as usize)
        {
            write_material(material, &mut out)?;
        }
        write_primitive(scene, primitive, &mut out)?;
    }
    io::Write::flush(&mut out)
}

fn write_head(scene: &Scene, out: &mut impl io::Write) -> io::Result<()> {
    let camera = &scene.camera;
    writeln!(out, "b {}", Numbers(&scene.background))?;
    writeln!(out, "v")?;
    writeln!(out, "from {}", vector(&camera.from))?;
    writeln!(out, "at {}", vector(&camera.at))?;
    writeln!(out, "up {}", vector(&camera.up))?;
    writeln!(out, "angle {}", PrintfG(camera.angle))?;
    writeln!(out, "hither {}", PrintfG(camera.hither))?;
    writeln!(out, "resolution {} {}", camera.resolution[0], camera.resolution[1])?;
    // NFF knows neither extents nor lenses nor motion
    for light in &scene.lights {
        write!(out, "l {}", vector(&light.position()))?;
        if let Some(color) = light.color() {
            write!(out, " {}", Numbers(&color))?;
        }
        writeln!(out)?;
    }
    Ok(())
}

fn write_material(material: &Material, out: &mut impl io::Write) -> io::Result<()> {
    let shares = [
        material.diffuse,
        material.specular,
        material.shine,
        material.transmittance,
        material.refraction_index,
    ];
    writeln!(out, "f {} {}", Numbers(&material.color), Numbers(&shares))
}

fn write_primitive(
    scene: &Scene,
    primitive: &Primitive,
    out: &mut impl io::Write,
) -> io::Result<()> {
    match primitive.shape {
        Shape::Sphere(i) => {
            let sphere = scene.spheres[i as usize];
            writeln!(out, "s {} {}", vector(&sphere.center), PrintfG(sphere.radius))
        }
        Shape::Cone(i) => {
            let cone = scene.cones[i as usize];
            let (base, apex) = (vector(&cone.base), vector(&cone.apex));
            let radii = [cone.base_radius, cone.apex_radius].map(PrintfG);
            writeln!(out, "c {base} {} {apex} {}", radii[0], radii[1])
        }
        Shape::Polygon { first, count } => {
            let outline = &scene.vertices[first as usize..][..count as usize];
            writeln!(out, "p {count}")?;
            outline.iter().try_for_each(|p| writeln!(out, "{}", vector(p)))
        }
        Shape::Triangle { v } => {
            writeln!(out, "p 3")?;
            v.iter().try_for_each(|&i| writeln!(out, "{}", vector(&scene.vertices[i as usize])))
        }
        Shape::Patch { v, n } => {
            writeln!(out, "pp 3")?;
            v.iter().zip(n).try_for_each(|(&v, n)| {
                let (v, n) = (&scene.vertices[v as usize], &scene.normals[n as usize]);
                writeln!(out, "{} {}", vector(v), vector(n))
            })
        }
    }
}

fn vector(v: &DVec3) -> Numbers<'_> {
    Numbers(v.as_ref())
}

/// Numbers with blanks between them.
struct Numbers<'a>(&'a [f64]);

impl fmt::Display for Numbers<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, &x) in self.0.iter().enumerate() {
            let space = if i == 0 { "" } else { " " };
            write!(f, "{space}{}", PrintfG(x))?;
        }
        Ok(())
    }
}
