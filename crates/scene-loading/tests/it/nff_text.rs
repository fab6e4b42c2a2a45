//! Scenes as NFF text (E. Haines' Neutral File Format, `NFF.TXT` of SPD 3.14), numbers as C's
//! `printf("%g")` prints them: six significant digits.

use std::fmt::{self, Write as _};
use std::io;

use glam::DVec3;
use scene_loading::procedural::round_to_printed;
use scene_loading::{Material, Primitive, Scene, Shape};

/// Writes the scene as NFF, numbers with six significant digits ([`PrintfG`]).
///
/// The order is background, view, lights, primitives; a primitive of another material than the
/// one before it is preceded by that material's `f` line. So the text of an SPD scene is that of
/// the distributed file (but for the sign of zero). Triangles are written as polygons of three
/// vertices. NFF has no place for names and warnings, nor for materials that nothing is made of.
pub(crate) fn write_nff(scene: &Scene, out: &mut impl io::Write) -> io::Result<()> {
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
        write!(out, "l {}", vector(&light.position))?;
        if let Some(color) = light.color {
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

/// Displays a number as C's `printf("%g")` does, except that negative zero is `0`.
struct PrintfG(f64);

impl fmt::Display for PrintfG {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0 == 0.0 {
            return f.write_char('0');
        }
        let text = format!("{:.5e}", self.0);
        let Some((mantissa, exponent)) = text.split_once('e') else {
            return write!(f, "{}", self.0);
        };
        let exponent: i32 = exponent.parse().map_err(|_| fmt::Error)?;
        let (sign, mantissa) = match mantissa.strip_prefix('-') {
            Some(rest) => ("-", rest),
            None => ("", mantissa),
        };
        f.write_str(sign)?;
        let (lead, rest) = mantissa.split_at(1);
        let rest = rest.trim_end_matches('0').trim_start_matches('.');
        match exponent {
            0..6 => {
                // The point moves right, past digits or past zeros that stand for them.
                let whole = exponent as usize;
                let (before, after) = rest.split_at(whole.min(rest.len()));
                write!(f, "{lead}{before:0<whole$}")?;
                if after.is_empty() { Ok(()) } else { write!(f, ".{after}") }
            }
            -4..0 => {
                let zeros = (-exponent - 1) as usize;
                write!(f, "0.{:0<zeros$}{lead}{rest}", "")
            }
            _ => {
                let point = if rest.is_empty() { "" } else { "." };
                let sign = if exponent < 0 { '-' } else { '+' };
                write!(f, "{lead}{point}{rest}e{sign}{:02}", exponent.unsigned_abs())
            }
        }
    }
}

#[test]
fn prints_and_rounds_as_c_does() {
    let rounded = |x: f64| {
        let mut scene = Scene { background: [x; 3], ..Scene::default() };
        round_to_printed(&mut scene);
        scene.background[0]
    };
    // Right-hand sides are what glibc's printf("%g") gives.
    for (x, text) in [
        (0.0, "0"),
        (-0.0, "0"),
        (1.0, "1"),
        (-12.5, "-12.5"),
        (100_000.0, "100000"),
        (999_999.5, "1e+06"),
        (999_999.4, "999999"),
        (1_234_567.0, "1.23457e+06"),
        (120.0, "120"),
        (0.1 + 0.2, "0.3"),
        (0.0001, "0.0001"),
        (0.000123456789, "0.000123457"),
        (0.00001, "1e-05"),
        (-1.110223e-16, "-1.11022e-16"),
        (2.5e-300, "2.5e-300"),
        (1.0 / 3.0, "0.333333"),
        (20.905, "20.905"),
        (f64::INFINITY, "inf"),
    ] {
        assert_eq!(PrintfG(x).to_string(), text, "{x:?}");
        assert_eq!(rounded(x), text.parse::<f64>().unwrap(), "{x:?}");
    }
    assert!(rounded(f64::NAN).is_nan());
    assert!(rounded(-0.0).is_sign_positive());
}
