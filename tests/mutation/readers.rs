//! What reads mutants, and what must hold of whatever it accepts.

use super::make::{Random, Seeds, glb, repair_png, spoil_bytes, spoil_json};
use invertex::asset::{self, Built};
use invertex::igt::Tables;
use invertex::param::{PrimaryRequest, choose, parts};
use invertex::scene::Scene;

/// Makes input `i` and reads it; whether it was accepted.
pub(crate) fn read(seeds: &Seeds, i: u64) -> bool {
    let mut random = Random::new(i);
    // Models 3, images 2, built models 2, tables 2 of 9.
    match random.below(9) {
        0 | 1 => {
            let seed = random.pick(&seeds.models).clone();
            read_scene(&spoiled(seed, &mut random), &mut random)
        }
        2 => {
            let seed = random.pick(&seeds.models);
            read_scene(&as_data_uri(seed, &mut random), &mut random)
        }
        3 | 8 => {
            let mut image = random.pick(&seeds.images).clone();
            spoil_bytes(&mut image, &mut random);
            if random.below(2) == 0 {
                repair_png(&mut image);
            }
            read_image(&image)
        }
        4 | 5 => {
            let seed = random.pick(&seeds.built_files).clone();
            read_built(&spoiled(seed, &mut random), &mut random)
        }
        6 => {
            let built = random.pick(&seeds.built);
            let triangles = built.scene.meshes[0].triangles.len();
            read_tables(
                spoil_tables(&built.meshes[0].tables, &mut random),
                triangles,
                &mut random,
            )
        }
        _ => {
            // Tables with a fault and the right checksum, through the file.
            let mut built: Built = random.pick(&seeds.built).clone();
            built.meshes[0].tables = spoil_tables(&built.meshes[0].tables, &mut random);
            match asset::to_bytes(&built) {
                Ok(bytes) => read_built(&bytes, &mut random),
                Err(_) => false,
            }
        }
    }
}

/// A container with a fault in its JSON, its binary, or anywhere.
fn spoiled((mut json, mut bin): (String, Vec<u8>), random: &mut Random) -> Vec<u8> {
    match random.below(4) {
        0 => {
            let mut bytes = glb(json.as_bytes(), &bin);
            spoil_bytes(&mut bytes, random);
            return bytes;
        }
        1 => spoil_bytes(&mut bin, random),
        2 => spoil_json(&mut json, random),
        _ => {
            spoil_json(&mut json, random);
            spoil_bytes(&mut bin, random);
        }
    }
    glb(json.as_bytes(), &bin)
}

/// The model as `.gltf` with its binary in a data URI, with a fault.
fn as_data_uri((json, bin): &(String, Vec<u8>), random: &mut Random) -> Vec<u8> {
    use base64::Engine;
    let data = base64::engine::general_purpose::STANDARD.encode(bin);
    let uri = format!("\"uri\":\"data:application/octet-stream;base64,{data}\",\"byteLength\"");
    let at = json.rfind("\"buffers\"").unwrap();
    let mut text = json[..at].to_owned() + &json[at..].replacen("\"byteLength\"", &uri, 1);
    if random.below(2) == 0 {
        spoil_json(&mut text, random);
        return text.into_bytes();
    }
    let mut bytes = text.into_bytes();
    spoil_bytes(&mut bytes, random);
    bytes
}

fn read_scene(bytes: &[u8], random: &mut Random) -> bool {
    match Scene::from_bytes("mutant", bytes, None) {
        Ok(scene) => {
            check_scene(&scene, random);
            true
        }
        Err(error) => {
            assert_eq!(error.exit_code(), 3, "{error}");
            false
        }
    }
}

/// What later stages rely on; sometimes they are run.
fn check_scene(scene: &Scene, random: &mut Random) {
    for mesh in &scene.meshes {
        mesh.validate().unwrap();
        assert!(
            mesh.triangle_material
                .iter()
                .all(|&m| (m as usize) < scene.materials.len())
        );
    }
    for material in &scene.materials {
        for texture in material.textures() {
            let texture = scene.textures[texture.texture];
            scene.sampler_of(&texture);
            if let Some(image) = texture.image {
                let _ = scene.images[image].decode();
            }
        }
    }
    for instance in scene.instances() {
        assert!(
            instance
                .world_columns()
                .iter()
                .flatten()
                .all(|x| x.is_finite())
        );
        let joints = instance
            .skin
            .map_or(0, |skin| scene.skins[skin].joints.len());
        let mesh = &scene.meshes[instance.mesh];
        let used = mesh
            .joints
            .iter()
            .zip(&mesh.weights)
            .flat_map(|(j, w)| (0..4).map(|k| (j[k], w[k])));
        assert!(
            instance.skin.is_none()
                || used
                    .into_iter()
                    .all(|(j, w)| w == 0.0 || usize::from(j) < joints)
        );
    }
    check_poses(scene, random);
    if random.below(1024) == 0 {
        for mesh in scene
            .meshes
            .iter()
            .filter(|mesh| !mesh.triangles.is_empty())
        {
            if let Ok((primary, _)) = choose(mesh, &PrimaryRequest::Auto) {
                parts(mesh, &primary);
            }
        }
    }
}

/// Any moment of any animation is a pose or an error; what it moves stays finite.
fn check_poses(scene: &Scene, random: &mut Random) {
    for animation in 0..scene.animations.len() {
        let time = scene.animations[animation].duration() * random.below(5) as f64 / 4.0;
        let Ok(pose) = scene.pose(animation, time) else {
            continue;
        };
        for instance in scene.instances_in(&pose) {
            if let Ok(mesh) = scene.posed_mesh(&instance, &pose) {
                mesh.validate().unwrap();
            }
        }
    }
}

fn read_image(image: &[u8]) -> bool {
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":{0}}}],"bufferViews":[{{"buffer":0,"byteLength":{0}}}],
        "images":[{{"bufferView":0}}]}}"#,
        image.len()
    );
    let Ok(scene) = Scene::from_bytes("mutant", &glb(json.as_bytes(), image), None) else {
        return false;
    };
    scene.images[0].decode().is_ok()
}

fn read_built(bytes: &[u8], random: &mut Random) -> bool {
    asset::is_built(bytes);
    match asset::read("mutant", bytes) {
        Ok(built) => {
            check_scene(&built.scene, random);
            for mesh in &built.meshes {
                look_up(
                    &mesh.tables,
                    built.scene.meshes[mesh.mesh].triangles.len(),
                    random,
                );
                for lod in &mesh.lods {
                    assert!(
                        lod.triangles
                            .iter()
                            .flatten()
                            .all(|&v| (v as usize) < lod.positions.len())
                    );
                }
            }
            // What has been read can be written.
            asset::to_bytes(&built).unwrap();
            true
        }
        Err(error) => {
            assert_eq!(error.exit_code(), 3, "{error}");
            false
        }
    }
}

fn spoil_tables(tables: &Tables, random: &mut Random) -> Tables {
    let mut tables = tables.clone();
    for _ in 0..1 + random.below(3) {
        let words = match random.below(3) {
            0 => &mut tables.hash,
            1 => &mut tables.list,
            _ => &mut tables.triangle,
        };
        if words.is_empty() {
            continue;
        }
        let at = random.below(words.len());
        match random.below(6) {
            0..3 => words[at] ^= 1 << random.below(32),
            3 => words[at] = *random.pick(&[0, 1, u32::MAX, 1 << 31, 0xff, 0xff00_0000]),
            4 => words[at] = *random.pick(words),
            _ => words.to_mut().truncate(at),
        }
    }
    tables
}

fn read_tables(tables: Tables, triangles: usize, random: &mut Random) -> bool {
    let valid = tables.validate(triangles).is_ok();
    if valid {
        look_up(&tables, triangles, random);
    }
    valid
}

/// Whatever valid tables are asked, the answer is a triangle of the mesh.
fn look_up(tables: &Tables, triangles: usize, random: &mut Random) {
    for n in 0..24 {
        let reach = [1 << 10, 1 << 20, 1 << 29][n % 3];
        let query = std::array::from_fn(|_| random.below(2 * reach) as i32 - reach as i32);
        let layer = (n % 2 == 0).then(|| random.below(4) as u8);
        if let Some(found) = tables.lookup(query, layer, n % 4 < 2) {
            assert!((found.triangle as usize) < triangles);
            assert!(found.barycentric.iter().all(|b| b.is_finite()));
        }
    }
}
