//! Writes scenes as Wavefront OBJ text with materials (MTL).

use std::collections::HashSet;
use std::fmt;
use std::io::{self, BufWriter, Write};

use glam::DVec3;

use crate::scene::{Material, Scene, Shape};

/// Why a scene was not written.
#[allow(missing_docs, reason = "the message of a variant says what its fields are")]
#[derive(Debug, thiserror::Error)]
pub enum ObjExportError {
    /// OBJ has no such primitive.
    #[error(
        "OBJ files cannot hold spheres and cones, and primitive {primitive} is a {kind}; \
         tessellate the scene first"
    )]
    Curved { primitive: usize, kind: &'static str },
    #[error("cannot write the OBJ text: {0}")]
    Io(#[from] io::Error),
}

/// Writes the scene's polygons, triangles and patches as OBJ text, in their order.
///
/// With `mtl`, the materials go there as MTL text, and the OBJ text refers to them; the `&str` is
/// the MTL file's name as the OBJ file is to state it. Numbers have the fewest digits that read
/// back as the same `f64`. View and lights have no place in OBJ;
/// textures are not written. All vertices and normals are
/// written, in the scene's order, so indices agree (counting from 1).
///
/// Materials: `Kd` is colour times diffuse share, `Ks` the specular share in grey, `Ns` the
/// exponent, `Ni` the index of refraction, `d` 1 minus the transmitted share; names are the
/// scene's, made unique and free of blanks, or `material_0`, `material_1`, ... where it has none.
///
/// # Errors
/// [`ObjExportError::Curved`] for scenes with spheres or cones, before anything is written;
/// [`ObjExportError::Io`] if a writer fails.
pub fn write_obj(
    scene: &Scene,
    obj: &mut impl Write,
    mtl: Option<(&str, &mut dyn Write)>,
) -> Result<(), ObjExportError> {
    refuse_curved(scene)?;
    let mut obj = BufWriter::new(obj);
    let mut names = None;
    if let Some((file_name, mtl)) = mtl {
        let unique = unique_names(&scene.materials);
        write_mtl(&scene.materials, &unique, mtl)?;
        writeln!(obj, "mtllib {file_name}")?;
        names = Some(unique);
    }
    for &v in &scene.vertices {
        writeln!(obj, "v {}", SpacedVector(v))?;
    }
    for &n in &scene.normals {
        writeln!(obj, "vn {}", SpacedVector(n))?;
    }
    let mut current = None;
    for primitive in &scene.primitives {
        if current.replace(primitive.material) != Some(primitive.material)
            && let Some(name) = names.as_ref().and_then(|n| n.get(primitive.material as usize))
        {
            writeln!(obj, "usemtl {name}")?;
        }
        write!(obj, "f")?;
        match primitive.shape {
            Shape::Sphere(_) | Shape::Cone(_) => {}
            Shape::Polygon { first, count } => {
                for i in 0..u64::from(count) {
                    write!(obj, " {}", u64::from(first) + i + 1)?;
                }
            }
            Shape::Triangle { v } => {
                for i in v {
                    write!(obj, " {}", u64::from(i) + 1)?;
                }
            }
            Shape::Patch { v, n } => {
                for (v, n) in v.into_iter().zip(n) {
                    write!(obj, " {}//{}", u64::from(v) + 1, u64::from(n) + 1)?;
                }
            }
        }
        writeln!(obj)?;
    }
    obj.flush()?;
    Ok(())
}

fn refuse_curved(scene: &Scene) -> Result<(), ObjExportError> {
    for (i, primitive) in scene.primitives.iter().enumerate() {
        let kind = match primitive.shape {
            Shape::Sphere(_) => "sphere",
            Shape::Cone(_) => "cone",
            Shape::Polygon { .. } | Shape::Triangle { .. } | Shape::Patch { .. } => continue,
        };
        return Err(ObjExportError::Curved { primitive: i, kind });
    }
    Ok(())
}

/// Names that `usemtl` can state: unique, not empty, without blanks.
fn unique_names(materials: &[Material]) -> Vec<String> {
    let mut taken = HashSet::new();
    let mut names = Vec::with_capacity(materials.len());
    for (i, material) in materials.iter().enumerate() {
        let stem = material.name.split_whitespace().collect::<Vec<_>>().join("_");
        let mut name = if stem.is_empty() { format!("material_{i}") } else { stem };
        while !taken.insert(name.clone()) {
            name = format!("{name}_{i}");
        }
        names.push(name);
    }
    names
}

fn write_mtl(materials: &[Material], names: &[String], out: &mut dyn Write) -> io::Result<()> {
    let mut out = BufWriter::new(out);
    for (material, name) in materials.iter().zip(names) {
        let kd = DVec3::from_array(material.color) * material.diffuse;
        writeln!(out, "newmtl {name}")?;
        writeln!(out, "Kd {}", SpacedVector(kd))?;
        writeln!(out, "Ks {}", SpacedVector(DVec3::splat(material.specular)))?;
        writeln!(out, "Ns {}", Number(material.shine))?;
        writeln!(out, "Ni {}", Number(material.refraction_index))?;
        writeln!(out, "d {}", Number(1.0 - material.transmittance))?;
        writeln!(out)?;
    }
    out.flush()
}

/// Three numbers with blanks between them.
struct SpacedVector(DVec3);

impl fmt::Display for SpacedVector {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {} {}", Number(self.0.x), Number(self.0.y), Number(self.0.z))
    }
}

/// A number with the fewest digits that read back as the same `f64`.
struct Number(f64);

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.0.abs();
        if size == 0.0 || (1e-5..1e16).contains(&size) {
            write!(f, "{}", self.0)
        } else {
            write!(f, "{:e}", self.0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Cone, Primitive};

    fn sample() -> Scene {
        let mut scene = Scene::new("sample");
        let red = Material { name: "my red".into(), color: [1.0, 0.25, 0.0], ..Default::default() };
        let glass = Material {
            color: [0.5, 0.5, 1.0],
            diffuse: 0.5,
            specular: 0.25,
            shine: 12.5,
            transmittance: 0.75,
            refraction_index: 1.5,
            ..Default::default()
        };
        let red = scene.push_material(red);
        let glass = scene.push_material(glass);
        let p = |x: f64, y: f64| DVec3::new(x, y, 1.0 / 3.0);
        scene.push_polygon(red, &[p(0.0, 0.0), p(4.0, 0.0), p(4.0, 4.0), p(1.0, 1.0), p(0.0, 4.0)]);
        scene.push_triangle(glass, [p(0.1, 1e-17), p(1.0, 0.0), p(0.0, 1e20)]);
        scene.push_patch(glass, [p(0.0, 0.0), p(1.0, 0.0), p(0.0, 1.0)], [DVec3::Z; 3]);
        scene
    }

    #[test]
    fn tobj_reads_the_same_back() {
        let scene = sample();
        let (mut obj, mut mtl) = (Vec::new(), Vec::new());
        write_obj(&scene, &mut obj, Some(("sample.mtl", &mut mtl))).unwrap();
        let (models, materials) =
            tobj::load_obj_buf(&mut obj.as_slice(), &tobj::LoadOptions::default(), |path| {
                assert_eq!(path.to_str(), Some("sample.mtl"));
                tobj::load_mtl_buf(&mut mtl.as_slice())
            })
            .unwrap();
        let materials = materials.unwrap();
        let names: Vec<_> = materials.iter().map(|m| m.name.as_str()).collect();
        assert_eq!(names, ["my_red", "material_1"]);
        assert_eq!(materials[0].diffuse, Some([1.0, 0.25, 0.0]));
        assert_eq!(materials[0].dissolve, Some(1.0));
        assert_eq!(materials[1].diffuse, Some([0.25, 0.25, 0.5]));
        assert_eq!(materials[1].specular, Some([0.25; 3]));
        assert_eq!(materials[1].shininess, Some(12.5));
        assert_eq!(materials[1].dissolve, Some(0.25));
        assert_eq!(materials[1].optical_density, Some(1.5));

        // tobj makes one model per material; each has its vertices in order of use.
        let (mut outlines, mut used) = (Vec::new(), Vec::new());
        for model in &models {
            let mesh = &model.mesh;
            let mut arities = mesh.face_arities.clone();
            if arities.is_empty() {
                arities = vec![3; mesh.indices.len() / 3];
            }
            let mut indices = mesh.indices.iter();
            for arity in arities {
                let outline: Vec<[f64; 3]> = indices
                    .by_ref()
                    .take(arity as usize)
                    .map(|&i| std::array::from_fn(|k| mesh.positions[3 * i as usize + k]))
                    .collect();
                outlines.push(outline);
                used.push(mesh.material_id.unwrap() as u32);
            }
        }
        let outline = |p: &Primitive| scene.outline(p.shape).iter().map(|v| v.to_array()).collect();
        let expected: Vec<Vec<[f64; 3]>> = scene.primitives.iter().map(outline).collect();
        assert_eq!(outlines, expected);
        assert_eq!(used, [0, 1, 1]);
        assert!(models.iter().any(|m| m.mesh.normals.ends_with(&[0.0, 0.0, 1.0])));
    }

    #[test]
    fn coordinates_read_back_exactly() {
        let scene = sample();
        let mut obj = Vec::new();
        write_obj(&scene, &mut obj, None).unwrap();
        let text = String::from_utf8(obj).unwrap();
        assert!(!text.contains("mtllib") && !text.contains("usemtl"));
        let vertex = |line: &str| {
            let xyz: Vec<f64> = line.split(' ').map(|x| x.parse().unwrap()).collect();
            DVec3::from_slice(&xyz)
        };
        let lines = text.lines().filter_map(|line| line.strip_prefix("v "));
        let vertices: Vec<DVec3> = lines.map(vertex).collect();
        assert_eq!(vertices, scene.vertices);
    }

    #[test]
    fn curved_primitives_are_refused() {
        let mut scene = sample();
        let cone = Cone { base: DVec3::ZERO, base_radius: 1.0, apex: DVec3::Z, apex_radius: 0.5 };
        scene.push_cone(0, cone);
        let mut obj = Vec::new();
        let error = write_obj(&scene, &mut obj, None).unwrap_err();
        assert!(error.to_string().contains("primitive 3 is a cone"), "{error}");
        assert!(error.to_string().contains("tessellate"), "{error}");
        assert!(obj.is_empty());
    }

    #[test]
    fn material_names_are_unique() {
        let named = |name: &str| Material { name: name.into(), ..Default::default() };
        let names = unique_names(&["a", "a b", "a", "", "a_2", " "].map(named));
        assert_eq!(names, ["a", "a_b", "a_2", "material_3", "a_2_4", "material_5"]);
    }
}
