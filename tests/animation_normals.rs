//! Normals of the reference on LoDs in motion: they turn with the LoD, mirrors and nodes without skin included.

mod glb;
mod moving;

use invertex::render::{Camera, Correspond, Options, Output, Rendered, Renderer, stage_posed};
use invertex::scene::Scene;
use moving::{SECONDS, built, camera, draw, scene, subjects};

/// Mean angle between two pictures of normals, in degrees, over the pixels that both cover.
fn apart(a: &Rendered, b: &Rendered) -> f64 {
    let both = (0..a.linear.len()).filter(|&i| a.draw[i] != u32::MAX && b.draw[i] != u32::MAX);
    let normal = |image: &Rendered, i: usize| {
        let [x, y, z, _] = image.linear[i].map(|c| f64::from(c) * 2.0 - 1.0);
        glam::DVec3::new(x, y, z).normalize()
    };
    let (sum, count) = both.fold((0.0, 0), |(sum, count), i| {
        (sum + normal(a, i).angle_between(normal(b, i)), count + 1)
    });
    (sum / f64::from(count)).to_degrees()
}

#[test]
fn normals_of_the_reference_turn_with_the_lod() {
    let built = built(scene(), "cylinder:z", &[0.3]);
    let rest = built.scene.rest();
    for time in [0.4, 0.75, 1.5, SECONDS] {
        let pose = built.scene.pose(1, time).unwrap();
        let camera = camera(&built.scene, &pose, 40.0, 160);
        let normals =
            |level, correspond| draw(&built, level, correspond, &pose, &camera, Output::Normals);
        let reference = normals(0, Correspond::Reference);
        let own = apart(&normals(0, Correspond::Inverse), &reference);
        let coarse = apart(&normals(1, Correspond::Inverse), &reference);
        let coarse_plain = apart(&normals(1, Correspond::Plain), &reference);
        // Negative control: the same LoD with the reference's normals as they are at rest.
        let still = {
            let subjects = subjects(&built, 1);
            let mut scene = built.scene.clone();
            let posed = scene.posed_mesh(&scene.instances()[0], &pose).unwrap();
            scene.meshes[0].positions = posed.positions;
            scene.meshes[0].joints.clear();
            scene.meshes[0].targets.clear();
            let (picture, _) =
                stage_posed(&scene, &subjects[..0], Correspond::Reference, true, &rest).unwrap();
            let options = Options {
                output: Output::Normals,
                ..Options::default()
            };
            // The node that names a skinned mesh has no say; here it would.
            let camera = Camera::new(
                camera.view * glam::DMat4::from_translation(glam::DVec3::splat(-9.0)),
                camera.projection,
                camera.width,
                camera.height,
            )
            .unwrap();
            apart(
                &Renderer::cpu(picture).draw(&camera, &options).unwrap(),
                &reference,
            )
        };
        println!(
            "{time}: level 0 {own:.4}, LoD {coarse:.3}, plain {coarse_plain:.3}, unturned {still:.2} degrees"
        );
        assert!(own < 0.3, "{time}: {own}");
        assert!(
            coarse < 3.0 && coarse_plain < 6.0,
            "{time}: {coarse} {coarse_plain}"
        );
        assert!(
            still > 5.0 && still > 4.0 * coarse,
            "{time}: {still} {coarse}"
        );
    }
}

/// The made model changed, and how far the normals of its own geometry through the tables are from the reference's at a
/// moment, in degrees; and the mean of how much the reference's face the camera.
fn changed(time: f64, change: impl Fn(&mut serde_json::Value)) -> (f64, f64) {
    let (mut document, binary) = moving::document();
    change(&mut document);
    let scene = Scene::from_bytes("changed", &moving::glb(&document, &binary), None).unwrap();
    let built = built(scene, "cylinder:z", &[0.5]);
    let pose = built.scene.pose(1, time).unwrap();
    let camera = camera(&built.scene, &pose, 40.0, 128);
    let normals = |correspond| draw(&built, 0, correspond, &pose, &camera, Output::Normals);
    let reference = normals(Correspond::Reference);
    let toward = camera.view.inverse().transform_vector3(glam::DVec3::Z);
    let covered = (0..reference.linear.len()).filter(|&i| reference.draw[i] != u32::MAX);
    let facing: Vec<f64> = covered
        .map(|i| {
            let [x, y, z, _] = reference.linear[i].map(|c| f64::from(c) * 2.0 - 1.0);
            glam::DVec3::new(x, y, z).dot(toward)
        })
        .collect();
    let mean = facing.iter().sum::<f64>() / facing.len() as f64;
    (apart(&normals(Correspond::Inverse), &reference), mean)
}

#[test]
fn mirrors_and_nodes_without_skin_turn_normals_as_the_reference_does() {
    let unskinned = |document: &mut serde_json::Value| {
        let attributes = &mut document["meshes"][0]["primitives"][0]["attributes"];
        let attributes = attributes.as_object_mut().unwrap();
        attributes.remove("JOINTS_0");
        attributes.remove("WEIGHTS_0");
        document["nodes"][0] = serde_json::json!({ "mesh": 0, "scale": [-1.0, 2.0, 0.5],
            "rotation": [0.0, 0.6, 0.0, 0.8] });
    };
    for time in [0.0, 0.9, SECONDS] {
        let (plain, facing) = changed(time, |_| ());
        assert!(plain < 0.3 && facing > 0.4, "{time}: {plain} {facing}");
        let (morphed, facing) = changed(time, unskinned);
        assert!(morphed < 0.3 && facing > 0.4, "{time}: {morphed} {facing}");
        // A skin turned inside out by its first joint.
        let (mirrored, facing) = changed(time, |document| {
            document["nodes"][1]["scale"] = serde_json::json!([-1.0, 1.0, 1.0]);
        });
        assert!(
            mirrored < 0.3 && facing > 0.4,
            "{time}: {mirrored} {facing}"
        );
    }
}
