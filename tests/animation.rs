//! Animated models: the posed reference is what glTF says; a point of a LoD asks for the same point of the reference in
//! every pose, and the LoD bends where the reference does.

mod glb;
mod moving;
mod render;

use invertex::asset::{self, Built};
use invertex::igt::Asker;
use invertex::lod::deviation::deviation;
use invertex::lod::{Lod, LodInput, chains};
use invertex::param::grid::QUERY_MAX;
use invertex::param::parts;
use invertex::render::{Camera, Correspond, Options, Output, Renderer, stage_posed};
use invertex::scene::{Pose, Scene};
use moving::{SECONDS, built, camera, draw, plain, scene};
use render::{differences, model};
use std::collections::{HashMap, HashSet};

/// Moments of the made model: keyframes, between them, the end, beyond it.
const MOMENTS: [f64; 6] = [0.0, 0.3, 0.75, 1.1, SECONDS, 7.0];

fn bend(scene: &Scene) -> usize {
    scene.animation_named("bend").unwrap()
}

#[test]
fn the_posed_reference_is_what_the_textbook_says() {
    let scene = scene();
    let instance = scene.instances()[0];
    for time in MOMENTS {
        let pose = scene.pose(bend(&scene), time).unwrap();
        let mesh = scene.posed_mesh(&instance, &pose).unwrap();
        let wanted = plain::posed(&scene, &scene.animations[1], time);
        let off = |a: &[[f32; 3]], b: &[[f64; 3]]| {
            let pairs = a.as_flattened().iter().zip(b.as_flattened());
            pairs
                .map(|(a, b)| (f64::from(*a) - b).abs())
                .fold(0.0, f64::max)
        };
        assert!(off(&mesh.positions, &wanted.0) < 1e-6, "{time}");
        assert!(off(&mesh.normals, &wanted.1) < 1e-6, "{time}");
        // Negative control: a hundredth of a second later is another pose.
        let (later, _) = plain::posed(&scene, &scene.animations[1], time + 0.01);
        assert!(
            off(&mesh.positions, &later) > 1e-4 || time >= SECONDS,
            "{time}"
        );
    }
}

/// What a LoD point asks for: T3 at rest over its triangle, as the renderer must interpolate it.
fn answer(built: &Built, t3: &[[i32; 3]], triangle: u32, [b1, b2]: [f32; 2]) -> (u32, [u32; 2]) {
    let (mesh, lod) = (&built.meshes[0], &built.meshes[0].lods[0]);
    let corners = lod.triangles[triangle as usize].map(|v| t3[v as usize]);
    let query: [i32; 3] = std::array::from_fn(|k| {
        let way = |v: usize| ((corners[v][k] - corners[0][k]) << 6) as f32;
        let steps = (b1 * way(1) + b2 * way(2) + 0.5).floor();
        ((corners[0][k] << 6) + steps as i32).clamp(-QUERY_MAX, QUERY_MAX)
    });
    let at_rest = lod.triangles[triangle as usize].map(|v| lod.t3[v as usize]);
    let layer = lod.triangle_layer.get(triangle as usize).copied();
    let asker = Asker::of(mesh.tables.primary.line(), &at_rest, layer);
    match mesh.tables.lookup(query, asker, true) {
        None => (u32::MAX, [0; 2]),
        Some(found) => {
            let [_, b1, b2] = found.barycentric.map(f32::to_bits);
            (found.triangle, [b1, b2])
        }
    }
}

/// Pixels of the LoD in `pose`, and those whose reference point is not the one that their LoD point has at rest; then
/// the same with `t3` in place of the LoD's. The plain picture says which LoD point a pixel shows, bit for bit: it draws
/// the LoD's triangles as their own reference.
fn strays(built: &Built, pose: &Pose, camera: &Camera, t3: &[[i32; 3]]) -> [usize; 3] {
    let shown = draw(built, 1, Correspond::Plain, pose, camera, Output::Unlit);
    let asked = draw(built, 1, Correspond::Inverse, pose, camera, Output::Unlit);
    assert_eq!(
        differences(&shown, &asked)[3],
        0,
        "the same surface, depth by depth"
    );
    let rest = &built.meshes[0].lods[0].t3;
    let mut counts = [0; 3];
    for at in (0..shown.triangle.len()).filter(|&at| shown.draw[at] != u32::MAX) {
        let got = (asked.triangle[at], asked.barycentric[at].map(f32::to_bits));
        let point = |t3| answer(built, t3, shown.triangle[at], shown.barycentric[at]);
        counts[0] += 1;
        counts[1] += usize::from(got != point(rest));
        counts[2] += usize::from(got != point(t3));
    }
    counts
}

#[test]
fn a_point_of_the_lod_keeps_its_point_of_the_reference_in_every_pose() {
    let built = built(scene(), "cylinder:z", &[0.3]);
    let lod = &built.meshes[0].lods[0];
    let primary = built.meshes[0].tables.primary;
    for (k, time) in MOMENTS.into_iter().enumerate() {
        let pose = built.scene.pose(1, time).unwrap();
        let camera = camera(&built.scene, &pose, 50.0 * k as f64, 160);
        // Negative control: T3 taken from where the animation moved the vertices.
        let mut moved = built.scene.clone();
        moved.meshes[0].positions.clone_from(&lod.positions);
        moved.meshes[0].normals.clone_from(&lod.normals);
        moved.meshes[0].joints.clone_from(&lod.joints);
        moved.meshes[0].weights.clone_from(&lod.weights);
        moved.meshes[0].targets.clone_from(&lod.targets);
        moved.meshes[0].tangents.clear();
        let moved = moved
            .posed_mesh(&built.scene.instances()[0], &pose)
            .unwrap();
        let t3: Vec<[i32; 3]> = moved
            .positions
            .iter()
            .map(|p| primary.to_grid(primary.t3_of_position(p.map(f64::from))))
            .collect();
        let [pixels, strays, control] = strays(&built, &pose, &camera, &t3);
        assert!(pixels > 5_000, "{time}: {pixels}");
        assert_eq!(strays, 0, "{time}");
        // At the beginning nothing has moved; later the control must see that something has.
        let moved = if time == 0.0 {
            control == 0
        } else {
            control > pixels / 2
        };
        assert!(moved, "{time}: {control} of {pixels}");
    }
}

#[test]
fn the_fox_in_motion_keeps_its_points_too() {
    let Some(path) = model::path("fox/fox.glb") else {
        return;
    };
    let built = built(Scene::load(&path).unwrap(), "uv0", &[0.3]);
    let lod = &built.meshes[0].lods[0];
    // Negative control: every vertex with the T3 of the next one.
    let mut t3 = lod.t3.clone();
    t3.rotate_left(1);
    for (name, time) in [
        ("Survey", 1.3),
        ("Walk", 0.2),
        ("Walk", 0.5),
        ("Run", 0.25),
        ("Run", 0.9),
    ] {
        let animation = built.scene.animation_named(name).unwrap();
        let pose = built.scene.pose(animation, time).unwrap();
        let camera = camera(&built.scene, &pose, 75.0, 192);
        let [pixels, strays, control] = strays(&built, &pose, &camera, &t3);
        println!("{name} {time}: {pixels} pixels, {strays} strays, control {control}");
        assert!(pixels > 3_000 && strays == 0, "{name} {time}");
        assert!(control > pixels / 2, "{name} {time}");
    }
}

#[test]
fn a_node_without_skin_or_targets_is_moved_as_it_is() {
    let rigid = |document: &mut serde_json::Value| {
        let primitive = document["meshes"][0]["primitives"][0]
            .as_object_mut()
            .unwrap();
        primitive.remove("targets");
        document["meshes"][0]
            .as_object_mut()
            .unwrap()
            .remove("weights");
        document["nodes"][3]["mesh"] = 0.into();
        document["nodes"][0]
            .as_object_mut()
            .unwrap()
            .retain(|key, _| key == "name");
        let channels = document["animations"][1]["channels"]
            .as_array_mut()
            .unwrap();
        channels.retain(|channel| channel["target"]["path"] != "weights");
    };
    let (mut document, binary) = moving::document();
    rigid(&mut document);
    let scene = Scene::from_bytes("rigid", &moving::glb(&document, &binary), None).unwrap();
    let pose = scene.pose(1, 1.3).unwrap();
    let camera = camera(&scene, &pose, 40.0, 96);
    let draw = |scene: &Scene, pose: &Pose| {
        let (picture, _) = stage_posed(scene, &[], Correspond::Reference, true, pose).unwrap();
        Renderer::cpu(picture)
            .draw(&camera, &Options::default())
            .unwrap()
    };
    let moved = draw(&scene, &pose);
    // The same, with the matrix of the moment in the file.
    document["nodes"][3] =
        serde_json::json!({ "mesh": 0, "matrix": pose.world_matrices()[3].to_cols_array() });
    document["nodes"][2]
        .as_object_mut()
        .unwrap()
        .remove("children");
    document["scenes"][0]["nodes"] = serde_json::json!([3]);
    let still = Scene::from_bytes("still", &moving::glb(&document, &binary), None).unwrap();
    assert_eq!(differences(&moved, &draw(&still, &still.rest())), [0; 6]);
    // Negative control.
    assert!(differences(&moved, &draw(&scene, &scene.rest()))[0] > 500);
}

/// A LoD of a tube that is straight at rest bends as the reference does, because it was made for its poses and its vertices
/// are moved by the reference's weights where they stand.
#[test]
fn the_lod_bends_with_its_reference() {
    let built = built(scene(), "cylinder:z", &[0.3]);
    let mesh = &built.scene.meshes[0];
    let instance = built.scene.instances()[0];
    // Negative controls: a LoD that is good at rest alone, and one that hangs on a single joint.
    let primary = &built.meshes[0].tables.primary;
    let parts = parts(mesh, primary);
    let world = glam::Mat4::IDENTITY.to_cols_array_2d();
    let input = LodInput {
        mesh,
        primary,
        parts: &parts,
        world,
    };
    let at_rest = chains(&[input], &[0.3]).unwrap().remove(0).remove(0);
    let mut stiff = built.meshes[0].lods[0].clone();
    stiff.joints.fill([0; 4]);
    let off = |lod: &Lod, time: f64| {
        let pose = built.scene.pose(1, time).unwrap();
        let reference = built.scene.posed_mesh(&instance, &pose).unwrap();
        let mut scene = built.scene.clone();
        let m = &mut scene.meshes[0];
        m.positions.clone_from(&lod.positions);
        m.normals.clone_from(&lod.normals);
        m.joints.clone_from(&lod.joints);
        m.weights.clone_from(&lod.weights);
        m.targets.clone_from(&lod.targets);
        m.tangents.clear();
        let posed = scene.posed_mesh(&instance, &pose).unwrap();
        let surface = (reference.positions.as_slice(), mesh.triangles.as_slice());
        deviation(
            surface,
            (posed.positions.as_slice(), lod.triangles.as_slice()),
        )
        .max
    };
    let mut worst = [0.0f32; 3];
    for time in [0.0, 0.4, 0.75, 1.1, 1.6, SECONDS] {
        for (worst, lod) in worst
            .iter_mut()
            .zip([&built.meshes[0].lods[0], &at_rest, &stiff])
        {
            *worst = worst.max(off(lod, time));
        }
    }
    println!(
        "farthest from a reference of diameter 2: {worst:?} (for its poses, for rest alone, on one joint)"
    );
    assert!(
        worst[0] < 0.1 && worst[1] > 0.5 && worst[2] > 0.5,
        "{worst:?}"
    );
}

/// Two instances of a skinned mesh share the reference and its tables, not the way they are deformed.
#[test]
fn instances_share_what_they_fetch() {
    let (mut document, binary) = moving::document();
    let twice = document["nodes"][0].clone();
    document["nodes"].as_array_mut().unwrap().push(twice);
    document["scenes"][0]["nodes"] = serde_json::json!([0, 1, 4]);
    let two = Scene::from_bytes("twice", &moving::glb(&document, &binary), None).unwrap();
    let both = [scene(), two].map(|scene| built(scene, "cylinder:z", &[0.3]));
    let camera = camera(&both[0].scene, &both[0].scene.rest(), 40.0, 96);
    let at = |pose: fn(&Scene) -> Pose| {
        let drawn = both.each_ref().map(|built| {
            let pose = pose(&built.scene);
            draw(built, 1, Correspond::Inverse, &pose, &camera, Output::Lit)
        });
        differences(&drawn[0], &drawn[1])
    };
    assert_eq!(at(Scene::rest), [0; 6], "one lies exactly in the other");
    // The animation morphs the first one alone.
    let bent = |scene: &Scene| scene.pose(1, 0.4).unwrap();
    assert!(at(bent)[0] > 100, "negative control");
}

/// Vertices of the fox's LoD that lie at one place, on two sides of a chart's border, are moved as one: no crack opens.
#[test]
fn borders_of_charts_stay_closed() {
    let Some(path) = model::path("fox/fox.glb") else {
        return;
    };
    let built = built(Scene::load(&path).unwrap(), "uv0", &[0.3]);
    let lod = &built.meshes[0].lods[0];
    let mut at: HashMap<[u32; 3], Vec<usize>> = HashMap::new();
    for (v, p) in lod.positions.iter().enumerate() {
        at.entry(p.map(f32::to_bits)).or_default().push(v);
    }
    let borders: Vec<&Vec<usize>> = at.values().filter(|v| v.len() > 1).collect();
    let moves = |v: usize| (lod.joints[v], lod.weights[v].map(f32::to_bits));
    let open = borders
        .iter()
        .filter(|b| b.iter().any(|&v| moves(v) != moves(b[0])));
    assert_eq!(open.count(), 0);
    // Negative control: there are borders, and vertices that the simplifier moved among them.
    let reference: HashSet<[u32; 3]> = built.scene.meshes[0]
        .positions
        .iter()
        .map(|p| p.map(f32::to_bits))
        .collect();
    let moved = at
        .iter()
        .filter(|(p, v)| v.len() > 1 && !reference.contains(*p))
        .count();
    assert!(
        borders.len() > 40 && moved > 10,
        "{} {moved}",
        borders.len()
    );
}

#[test]
fn a_moving_model_is_written_and_read_again() {
    let built = built(scene(), "cylinder:z", &[0.5, 0.3]);
    let mesh = &built.scene.meshes[0];
    assert_eq!(
        (mesh.targets.len(), mesh.target_weights.as_slice()),
        (2, &[0.25, 0.0][..])
    );
    assert_eq!(mesh.targets[1].positions[41], [0.05, 0.0, 0.0], "sparse");
    let bytes = asset::to_bytes(&built).unwrap();
    let read = asset::read("bend.glb", &bytes).unwrap();
    assert!(read == built);
    assert!(asset::to_bytes(&read).unwrap() == bytes);
    // Another viewer sees LoDs that have the skin, the targets, and whatever moves the node.
    let seen = Scene::from_bytes("bend.glb", &bytes, None).unwrap();
    assert_eq!(seen.nodes.len(), 6);
    for node in &seen.nodes[4..] {
        let lod = &seen.meshes[node.mesh.unwrap()];
        assert_eq!((node.skin, lod.targets.len()), (Some(0), 2));
        assert_eq!(lod.target_weights, mesh.target_weights);
        assert_eq!(lod.joints.len(), lod.positions.len());
    }
    let moved = seen.animations[1].channels.iter().filter_map(|c| c.node);
    assert_eq!(
        moved.filter(|&n| n >= 4).count(),
        2,
        "weights, once for each LoD"
    );
    // A LoD with other targets than its mesh is not written.
    let mut wrong = built.clone();
    wrong.meshes[0].lods[1].targets.pop();
    assert!(
        asset::to_bytes(&wrong)
            .unwrap_err()
            .to_string()
            .contains("morph targets")
    );
}
