//! Instances of files become copies of a set.

use renderer::Geometry;
use scene_loading::{Scene, SceneCatalogue};

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
