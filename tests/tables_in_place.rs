//! The tables of a built file where they lie: the same as those that are read, checked like those, harmless when damaged.

use invertex::asset::{self, BuildSettings, Built, Processor, open_tables};
use invertex::igt::{Layout, Tables};
use invertex::scene::Scene;
use std::path::{Path, PathBuf};

/// The bundled model, built.
fn file(folder: &tempfile::TempDir, layout: Layout) -> (PathBuf, Built) {
    let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/amphora.glb");
    let settings = BuildSettings {
        layout,
        hash: Some(64),
        lods: vec![0.3],
        ..BuildSettings::default()
    };
    let scene = Scene::load(&model).unwrap();
    let built = asset::build(scene, &settings, Processor::Cpu, &()).unwrap();
    let path = folder.path().join("built.glb");
    asset::write(&built.built, &path).unwrap();
    (path, built.built)
}

struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % n
    }
}

/// Asks all over the domain: nothing but triangles of the reference may come back.
fn ask(tables: &Tables, triangles: usize, random: &mut Random) {
    for n in 0..40 {
        let reach = [1 << 16, 1 << 25, 1 << 29][n % 3];
        let point = std::array::from_fn(|_| random.below(2 * reach) as i32 - reach as i32);
        if let Some(found) = tables.lookup(point, None, n % 2 == 0) {
            assert!((found.triangle as usize) < triangles);
        }
    }
}

#[test]
fn tables_in_place_are_those_that_are_read() {
    for layout in [Layout::Packed, Layout::Classic] {
        let folder = tempfile::tempdir().unwrap();
        let (path, built) = file(&folder, layout);
        let opened = open_tables(&path).unwrap();
        assert_eq!(opened.meshes.len(), built.meshes.len());
        for (own, read) in opened.meshes.iter().zip(&built.meshes) {
            assert_eq!(own.mesh, read.mesh);
            assert_eq!(own.name, built.scene.meshes[read.mesh].name);
            assert_eq!(own.triangles, built.scene.meshes[read.mesh].triangles.len());
            assert!(own.tables == read.tables);
            assert!(own.verify());
            // On this processor nothing is copied.
            assert_eq!(
                own.tables.hash.is_mapped() && own.tables.list.is_mapped(),
                cfg!(target_endian = "little")
            );
        }
        // A file that takes its place leaves what is open as it was.
        let other = folder.path().join("other");
        std::fs::write(&other, b"nothing").unwrap();
        std::fs::rename(&other, &path).unwrap();
        assert!(opened.meshes.iter().all(|mesh| mesh.verify()));
        assert_eq!(open_tables(&path).unwrap_err().exit_code(), 3);
    }
}

/// Bits turned anywhere: refused, or every answer is a triangle of the reference; and the checksum tells the tables' own.
#[test]
fn damage_is_refused_or_harmless() {
    let (mut refused, mut told, mut random) = (0, 0, Random(3));
    for layout in [Layout::Packed, Layout::Classic] {
        let folder = tempfile::tempdir().unwrap();
        let (path, built) = file(&folder, layout);
        let bytes = std::fs::read(&path).unwrap();
        // Where the tables' words lie, all bytes of the file else.
        let hash: Vec<u8> = built.meshes[0].tables.hash[..64]
            .iter()
            .flat_map(|w| w.to_le_bytes())
            .collect();
        let tables = bytes.windows(hash.len()).position(|w| w == hash).unwrap();
        for round in 0..300 {
            let mut bad = bytes.clone();
            for _ in 0..1 + round % 3 {
                let at = match round % 2 {
                    0 => tables + random.below(bytes.len() - tables),
                    _ => random.below(bytes.len()),
                };
                bad[at] ^= 1 << random.below(8);
            }
            let path = folder.path().join("bad.glb");
            std::fs::write(&path, &bad).unwrap();
            match open_tables(&path) {
                Err(error) => {
                    assert_eq!(error.exit_code(), 3, "{error}");
                    refused += 1;
                }
                Ok(opened) => {
                    for mesh in opened.meshes {
                        ask(&mesh.tables, mesh.triangles, &mut random);
                        told += i32::from(!mesh.verify());
                    }
                }
            }
        }
        for length in [0, 1, 11, 12, 40, bytes.len() / 2, bytes.len() - 1] {
            let path = folder.path().join("short.glb");
            std::fs::write(&path, &bytes[..length]).unwrap();
            assert_eq!(open_tables(&path).unwrap_err().exit_code(), 3, "{length}");
        }
    }
    assert!(refused > 20 && told > 20, "{refused} {told}");
}

#[test]
fn a_file_without_tables_says_so() {
    let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/amphora.glb");
    let error = open_tables(&model).unwrap_err();
    assert_eq!(error.exit_code(), 3);
    assert!(error.to_string().contains("run build first"), "{error}");
}
