//! A built model written and read again is the same, bit by bit; what does not belong together is refused; the output is
//! valid glTF by the Khronos validator (where node and the validator are installed; tools/test sees to that).

use invertex::asset::{self, Built, BuiltMesh, Model};
use invertex::igt::{Asking, BuildOptions, Layout, Needs, Reference, build_cpu};
use invertex::lod::{LodInput, chains};
use invertex::param::{PrimaryRequest, choose, parts};
use invertex::scene::Scene;
use std::path::{Path, PathBuf};

/// Builds every mesh that a primary can be had for.
fn build(scene: Scene, layout: Layout) -> Built {
    let mut chosen = Vec::new();
    for (m, mesh) in scene.meshes.iter().enumerate() {
        if let Ok((primary, _)) = choose(mesh, &PrimaryRequest::Auto) {
            chosen.push((m, primary, parts(mesh, &primary)));
        }
    }
    let identity = std::array::from_fn(|c| std::array::from_fn(|r| f32::from(u8::from(r == c))));
    let inputs: Vec<LodInput> = chosen
        .iter()
        .map(|(m, primary, parts)| LodInput {
            mesh: &scene.meshes[*m],
            primary,
            parts,
            world: identity,
        })
        .collect();
    let lods = chains(&inputs, &[0.5, 0.1]).unwrap();
    let mut meshes = Vec::new();
    for ((m, primary, parts), lods) in chosen.iter().zip(lods) {
        let reference =
            Reference::new(&scene.meshes[*m], primary, &parts.triangle_layer, layout).unwrap();
        let options = BuildOptions { hash: 64, layout };
        let asking: Vec<Asking> = lods
            .iter()
            .map(|lod| Asking {
                t3: &lod.t3,
                triangles: &lod.triangles,
                layer: &lod.triangle_layer,
            })
            .collect();
        let needs = Needs::of(&reference, &asking, options.bits().unwrap());
        let tables = build_cpu(&reference, &needs, options).unwrap();
        meshes.push(BuiltMesh {
            mesh: *m,
            triangle_layer: parts.triangle_layer.clone(),
            tables,
            lods,
            prefiltered: None,
            hierarchy: None,
            report: serde_json::json!({ "build_ms": 0.1, "why": "test" }),
        });
    }
    Built { scene, meshes }
}

/// A small scene without files: a sphere with two materials, a child, a rotated instance.
fn sphere() -> Scene {
    let mesh = invertex::mesh::shapes::icosphere(3);
    let bytes: Vec<u8> = bytemuck::cast_slice(&mesh.positions)
        .iter()
        .chain(bytemuck::cast_slice::<_, u8>(&mesh.triangles))
        .copied()
        .collect();
    let positions = mesh.positions.len() * 12;
    use base64::Engine;
    let json = serde_json::json!({
        "asset": { "version": "2.0" },
        "scenes": [{ "nodes": [0, 2] }], "scene": 0,
        "nodes": [
            { "mesh": 0, "children": [1] },
            { "mesh": 0, "translation": [3.0, 0.1, 0.0], "rotation": [0.0, 0.6, 0.0, 0.8] },
            { "name": "nothing" }
        ],
        "meshes": [{ "name": "sphere", "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": mesh.positions.len(), "type": "VEC3",
              "min": [-1.0, -1.0, -1.0], "max": [1.0, 1.0, 1.0] },
            { "bufferView": 1, "componentType": 5125, "count": mesh.triangles.len() * 3, "type": "SCALAR" }
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": positions },
            { "buffer": 0, "byteOffset": positions, "byteLength": bytes.len() - positions }
        ],
        "buffers": [{
            "byteLength": bytes.len(),
            "uri": format!("data:application/octet-stream;base64,{}",
                base64::engine::general_purpose::STANDARD.encode(&bytes))
        }]
    });
    Scene::from_bytes("sphere", json.to_string().as_bytes(), None).unwrap()
}

fn assert_exact(built: &Built) -> Vec<u8> {
    let bytes = asset::to_bytes(built).unwrap();
    assert!(asset::is_built(&bytes));
    let back = asset::read(&built.scene.name, &bytes).unwrap();
    assert_eq!(
        back.scene.document, built.scene.document,
        "the original document comes back untouched"
    );
    assert!(back == *built, "what was read is not what was written");
    assert!(
        asset::to_bytes(&back).unwrap() == bytes,
        "written again, the bytes differ"
    );
    bytes
}

#[test]
fn both_directions_are_exact() {
    for layout in [Layout::Packed, Layout::Classic] {
        let built = build(sphere(), layout);
        assert_eq!((built.meshes.len(), built.meshes[0].lods.len()), (1, 2));
        let bytes = assert_exact(&built);
        // Any other reader sees the original's nodes and meshes first, and nothing is required of it.
        let plain = Scene::from_bytes("plain", &bytes, None).unwrap();
        assert_eq!(plain.meshes[0], built.scene.meshes[0]);
        assert_eq!(plain.instances().len(), built.scene.instances().len());
        assert!(plain.document.json.get("extensionsRequired").is_none());
        // The node with a child keeps it: only the leaf names LoDs.
        let lods =
            |n: usize| plain.document.json["nodes"][n]["extensions"]["MSFT_lod"]["ids"].clone();
        assert!(lods(0).is_null());
        assert_eq!(lods(1), serde_json::json!([3, 4]));
    }
}

#[test]
fn a_model_without_anything_built_round_trips_too() {
    assert_exact(&Built {
        scene: sphere(),
        meshes: Vec::new(),
    });
    let empty = Scene::from_bytes("empty", br#"{"asset":{"version":"2.0"}}"#, None).unwrap();
    assert_exact(&Built {
        scene: empty,
        meshes: Vec::new(),
    });
}

/// Replaces JSON of a built file and reads it; the error.
fn spoiled(bytes: &[u8], spoil: impl Fn(&mut serde_json::Value)) -> String {
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let mut json: serde_json::Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    spoil(&mut json);
    let mut text = json.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut out = b"glTF\x02\0\0\0".to_vec();
    out.extend(((bytes.len() - length + text.len()) as u32).to_le_bytes());
    out.extend((text.len() as u32).to_le_bytes());
    out.extend(b"JSON");
    out.extend(&text);
    out.extend(&bytes[20 + length..]);
    match asset::read("spoiled", &out) {
        Err(error) => error.to_string(),
        Ok(_) => "it was read".into(),
    }
}

#[test]
fn what_does_not_fit_is_named() {
    const X: &str = asset::EXTENSION;
    let bytes = asset::to_bytes(&build(sphere(), Layout::Packed)).unwrap();
    assert_eq!(
        spoiled(&bytes, |_| ()),
        "it was read",
        "negative control: unspoiled JSON is read"
    );
    type Spoil = fn(&mut serde_json::Value);
    let cases: [(Spoil, &str); 12] = [
        (|j| j["extensions"][X]["version"] = 1.into(), "version"),
        (
            |j| j["extensions"][X]["original"]["nodes"] = 99.into(),
            "nodes",
        ),
        (
            |j| j["extensions"][X]["original"]["byteLength"] = 1_000_000_000u64.into(),
            "byteLength",
        ),
        (
            |j| j["extensions"][X]["original"]["accessors"] = 0.into(),
            "accessors[0]",
        ),
        (
            |j| j["meshes"][0]["extensions"][X]["hash"] = 0.into(),
            "hash",
        ),
        (
            |j| j["meshes"][0]["extensions"][X]["hashSize"] = serde_json::json!([64, 63]),
            "hash",
        ),
        (
            |j| j["meshes"][0]["extensions"][X]["tablesSha256"] = "00".into(),
            "tablesSha256",
        ),
        (
            |j| j["meshes"][0]["extensions"][X]["primary"]["frame"]["scale"] = 1.0.into(),
            "referenceSha256",
        ),
        (
            |j| j["meshes"][0]["extensions"][X]["lods"][1]["mesh"] = 77.into(),
            "lods[1]",
        ),
        (
            |j| j["meshes"][0]["extensions"][X]["lods"][0]["layer"] = 0.into(),
            "lods[0].layer",
        ),
        (
            |j| j["meshes"][0]["extensions"][X]["lods"][0]["mesh"] = 0.into(),
            "NORMAL",
        ),
        (
            |j| {
                j["meshes"][0]["extensions"][X]["primary"]["kind"] =
                    serde_json::json!({"uv-set": 0})
            },
            "uv set",
        ),
    ];
    for (spoil, word) in cases {
        let message = spoiled(&bytes, spoil);
        assert!(message.contains(word), "\"{word}\" is not in: {message}");
    }
}

/// Every bit of the tables counts: one flipped anywhere in what was appended is noticed or harmless, never a panic; one
/// in the tables' words is always noticed.
#[test]
fn a_flipped_bit_in_the_tables_is_noticed() {
    let built = build(sphere(), Layout::Packed);
    let bytes = asset::to_bytes(&built).unwrap();
    let words: Vec<u8> = built.meshes[0]
        .tables
        .hash
        .iter()
        .flat_map(|w| w.to_le_bytes())
        .collect();
    let start = bytes.windows(words.len()).position(|w| w == words).unwrap();
    for at in (start..start + words.len()).step_by(97) {
        let mut bad = bytes.clone();
        bad[at] ^= 1 << (at % 8);
        assert!(asset::read("bad", &bad).is_err(), "byte {at}");
    }
}

/// An empty list far outside of the table: a lookup takes its slice before it looks at the length.
#[test]
fn an_empty_list_outside_of_the_table_is_refused() {
    let built = build(sphere(), Layout::Classic);
    let triangles = built.scene.meshes[0].triangles.len();
    let mut tables = built.meshes[0].tables.clone();
    tables.validate(triangles).unwrap();
    tables.hash[0] = 0x0080_0001;
    assert!(tables.validate(triangles).is_err());
}

#[test]
fn files_are_whole_or_absent() {
    let folder = tempfile::tempdir().unwrap();
    let built = Built {
        scene: sphere(),
        meshes: Vec::new(),
    };
    let path = folder.path().join("out.glb");
    asset::write(&built, &path).unwrap();
    assert!(matches!(Model::load(&path).unwrap(), Model::Built(_)));
    asset::write(&built, &path).unwrap();
    let error = asset::write(&built, &folder.path().join("missing/out.glb")).unwrap_err();
    assert_eq!(error.exit_code(), 3);
    let left: Vec<_> = std::fs::read_dir(folder.path())
        .unwrap()
        .flatten()
        .map(|e| e.file_name())
        .collect();
    assert_eq!(left, ["out.glb"]);
    // A full disk: nothing is left where nothing could be written.
    if Path::new("/dev/full").exists() {
        assert!(asset::write(&built, Path::new("/dev/full/out.glb")).is_err());
    }
}

/// The shared models, or none.
fn models() -> Vec<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/models");
    let folder = std::env::var_os("INVERTEX_MODELS").map_or(beside, PathBuf::from);
    let Ok(entries) = std::fs::read_dir(&folder) else {
        eprintln!(
            "SKIPPED: no models at {} (set INVERTEX_MODELS)",
            folder.display()
        );
        return Vec::new();
    };
    let inside = |entry: std::fs::DirEntry| {
        std::fs::read_dir(entry.path())
            .into_iter()
            .flatten()
            .flatten()
    };
    let mut out: Vec<PathBuf> = entries
        .flatten()
        .flat_map(inside)
        .map(|e| e.path())
        .filter(|p| p.extension().is_some_and(|e| e == "glb"))
        .collect();
    out.sort();
    out
}

/// Every shared model round-trips, and the Khronos validator finds no error in what is written.
#[test]
fn shared_models_round_trip_and_validate() {
    let folder = tempfile::tempdir().unwrap();
    let mut written = Vec::new();
    for path in models() {
        let scene = Scene::load(&path).unwrap();
        assert!(
            scene.warnings.is_empty(),
            "{}: {:?}",
            path.display(),
            scene.warnings
        );
        scene
            .meshes
            .iter()
            .for_each(|mesh| mesh.validate().unwrap());
        let bytes = assert_exact(&build(scene, Layout::Packed));
        let out = folder.path().join(path.file_name().unwrap());
        std::fs::write(&out, &bytes).unwrap();
        written.push(out);
    }
    if !written.is_empty() {
        validate(&written);
    }
}

/// Runs `tools/validate-gltf` over files; skipped loudly where it says that it cannot.
fn validate(files: &[PathBuf]) {
    let tool = Path::new(env!("CARGO_MANIFEST_DIR")).join("tools/validate-gltf");
    let output = match std::process::Command::new(&tool).args(files).output() {
        Ok(output) => output,
        Err(error) => {
            eprintln!("SKIPPED: {}: {error}", tool.display());
            return;
        }
    };
    let text = String::from_utf8_lossy(&output.stdout).into_owned()
        + &String::from_utf8_lossy(&output.stderr);
    match output.status.code() {
        Some(0) => println!("{text}"),
        // 77: no validator; 127: no node to run it with.
        Some(77 | 127) => eprintln!("SKIPPED: {text}"),
        code => panic!("validator: {code:?}\n{text}"),
    }
}
