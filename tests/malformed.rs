//! Every malformed or tricky file of the shared collection does what its class demands: an error that names the fault, a
//! repair that is reported, or a load. The table below says which, file by file, with the word that the message must hold.

use invertex::Error;
use invertex::scene::{Scene, TextureUse};
use std::path::{Path, PathBuf};

/// What must come of a file.
enum Want {
    /// An input error that contains this.
    Refused(&'static str),
    /// A scene with a warning that contains this.
    Warned(&'static str),
    /// A scene of so many triangles without a warning.
    Loads(usize),
}
use Want::{Loads, Refused, Warned};

const TABLE: &[(&str, Want)] = &[
    (
        "accessor/invalid_sparse_count_and_stride.gltf",
        Refused("buffers[0]"),
    ),
    ("accessor/small_stride.gltf", Refused("buffers[0]")),
    (
        "accessor/unresolved_bufferviews.gltf",
        Refused("bufferViews["),
    ),
    (
        "accessor_data/invalid_elements_float.gltf",
        Refused("is not finite"),
    ),
    (
        "animation/sampler_output_count_invalid.gltf",
        Refused("animations[0]"),
    ),
    (
        "asset_generator/Mesh_PrimitiveMode_02.gltf",
        Warned("points or lines"),
    ),
    ("asset_generator/Mesh_PrimitiveMode_06.gltf", Loads(2)),
    (
        "asset_generator/Mesh_PrimitiveMode_08.gltf",
        Warned("points or lines"),
    ),
    ("assimp/BoxWithInfinites.glb", Refused("is not finite")),
    ("assimp/IndexOutOfRange.gltf", Refused("index")),
    ("assimp/RecursiveNodes.gltf", Refused("nodes[")),
    ("assimp/texcoord_crash.gltf", Refused("TEXCOORD")),
    ("buffer/invalid_uri_data.gltf", Refused("buffers[0].uri")),
    ("buffer/no_bin_chunk.glb", Refused("BIN chunk")),
    ("buffer/not_found.gltf", Refused("cannot read")),
    ("buffer_view/invalid_length.gltf", Refused("bufferViews[0]")),
    ("glb/bom.glb", Refused("JSON")),
    ("glb/chunk_too_big.glb", Refused("GLB")),
    ("glb/empty_file.glb", Refused("empty")),
    ("glb/invalid_json_chunk.glb", Refused("JSON")),
    ("glb/invalid_magic.glb", Refused("is not glTF")),
    ("glb/length_mismatch.glb", Refused("claims")),
    ("glb/misplaced_bin_chunk.glb", Refused("chunk")),
    ("glb/only_header.glb", Refused("chunk")),
    ("glb/truncated_chunk_data.glb", Refused("chunk")),
    ("gltf_rs/box_sparse.glb", Loads(12)),
    (
        "gltf_transform/BoxMeshopt.glb",
        Refused("EXT_meshopt_compression"),
    ),
    ("image/invalid_image_data.gltf", Warned("images[0]")),
    ("json/invalid_syntax.gltf", Refused("JSON")),
    ("made/byte_offset_u64_max.glb", Refused("bufferViews[")),
    ("made/count_u32_max.glb", Refused("accessors[")),
    (
        "made/index_count_not_multiple_of_3.glb",
        Warned("multiple of 3"),
    ),
    ("made/jpeg_truncated.glb", Warned("cut off")),
    ("made/json_nesting_5000.gltf", Refused("nested deeper")),
    ("made/nan_inf_positions.glb", Refused("is not finite")),
    ("made/nan_uv.glb", Refused("is not finite")),
    ("made/node_chain_12000_deep.gltf", Loads(0)),
    ("made/nonmanifold_fan.glb", Loads(5)),
    ("made/png_claims_60000x60000.glb", Warned("images[0]")),
    ("made/truncated_half.glb", Refused("claims")),
    ("made/uv_all_one_point.glb", Loads(32)),
    ("made/uv_mirrored_overlap.glb", Loads(32)),
    ("made/zero_indices.glb", Refused("count 0")),
    ("mesh/accessor_unequal_count.gltf", Refused("POSITION has")),
    ("mesh/indices_invalid_format.gltf", Refused("unsigned")),
    ("mesh/primitive_no_position.gltf", Warned("no POSITION")),
    ("mesh_data/index_buffer_degenerate_triangle.gltf", Loads(3)),
    ("mesh_data/index_buffer_oob.gltf", Refused("index")),
    (
        "mesh_data/joints_weights_complex.gltf",
        Warned("points or lines"),
    ),
    ("meshoptimizer/fuzz.glb", Loads(12)),
    (
        "node/matrix_indecomposable.gltf",
        Refused("nodes[0].matrix"),
    ),
    ("node/node_loop.gltf", Refused("nodes[")),
    ("node/unresolved_child_node.gltf", Refused("does not exist")),
    ("skin/ibm_invalid_count.gltf", Refused("inverse bind")),
    ("skin/unresolved_joint.gltf", Refused("does not exist")),
    ("texture/unresolved_source.gltf", Refused("does not exist")),
    (
        "tinygltf/integer-out-of-bounds.gltf",
        Refused("bufferViews["),
    ),
    (
        "tinygltf/invalid-buffer-view-index.gltf",
        Refused("bufferViews"),
    ),
];

/// The collection's folder, if there is one.
fn collection() -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/malformed");
    let folder = std::env::var_os("INVERTEX_MALFORMED").map_or(beside, PathBuf::from);
    if !folder.is_dir() {
        eprintln!(
            "SKIPPED: no malformed files at {} (set INVERTEX_MALFORMED)",
            folder.display()
        );
        return None;
    }
    Some(folder)
}

/// What is wrong with what came of a file, if anything.
fn judge(want: &Want, got: &Result<Scene, Error>) -> Option<String> {
    match (want, got) {
        (Refused(word), Err(error @ (Error::Input { .. } | Error::Io { .. })))
            if error.exit_code() == 3 =>
        {
            let message = error.to_string();
            (!message.contains(word)).then(|| format!("message lacks \"{word}\": {message}"))
        }
        (Warned(word), Ok(scene)) if scene.warnings.iter().any(|w| w.contains(word)) => None,
        (Loads(triangles), Ok(scene)) if scene.warnings.is_empty() => {
            let have: usize = scene.meshes.iter().map(|m| m.triangles.len()).sum();
            (have != *triangles).then(|| format!("{have} triangles, {triangles} wanted"))
        }
        (_, Ok(scene)) => Some(format!("loaded, warnings {:?}", scene.warnings)),
        (_, Err(error)) => Some(format!("refused: {error}")),
    }
}

#[test]
fn every_file_does_what_its_class_demands() {
    let Some(folder) = collection() else { return };
    let mut faults = Vec::new();
    for (name, want) in TABLE {
        let got = Scene::load(&folder.join(name));
        if let Ok(scene) = &got {
            scene
                .meshes
                .iter()
                .for_each(|mesh| mesh.validate().unwrap());
        }
        faults.extend(judge(want, &got).map(|fault| format!("{name}: {fault}")));
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// The table misses no file of the collection.
#[test]
fn the_table_is_complete() {
    let Some(folder) = collection() else { return };
    let mut found = 0;
    for class in std::fs::read_dir(&folder)
        .unwrap()
        .flatten()
        .filter(|e| e.path().is_dir())
    {
        for file in std::fs::read_dir(class.path()).unwrap().flatten() {
            let name = format!(
                "{}/{}",
                class.file_name().display(),
                file.file_name().display()
            );
            if name.ends_with(".gltf") || name.ends_with(".glb") {
                assert!(
                    TABLE.iter().any(|(known, _)| *known == name),
                    "{name} is not in the table"
                );
                found += 1;
            }
        }
    }
    assert_eq!(found, TABLE.len());
}

/// Broken images are an error of the image alone, and a neutral texel stands in.
#[test]
fn broken_images_get_a_stand_in() {
    let Some(folder) = collection() else { return };
    for name in [
        "made/jpeg_truncated.glb",
        "made/png_claims_60000x60000.glb",
        "image/invalid_image_data.gltf",
    ] {
        let scene = Scene::load(&folder.join(name)).unwrap();
        let (image, warning) = scene.images[0].decode_or_neutral(TextureUse::Factor);
        assert!(
            warning.is_some(),
            "{name} decoded to {:?}",
            image.dimensions()
        );
        assert_eq!(image.get_pixel(0, 0).0, [255; 4], "{name}");
    }
}

/// Negative control: the judge refuses what is not wanted, in every direction.
#[test]
fn the_judge_can_fail() {
    let good = || Scene::from_bytes("x", br#"{"asset":{"version":"2.0"}}"#, None);
    let bad = || Scene::from_bytes("x", b"nonsense", None);
    assert!(judge(&Loads(0), &good()).is_none());
    assert!(judge(&Loads(1), &good()).is_some());
    assert!(judge(&Loads(0), &bad()).is_some());
    assert!(judge(&Refused("glTF"), &bad()).is_none());
    assert!(judge(&Refused("another word"), &bad()).is_some());
    assert!(judge(&Refused("glTF"), &good()).is_some());
    assert!(judge(&Warned("glTF"), &good()).is_some());
}
