//! Runs the real binary, and makes small models for it.

#![allow(dead_code, reason = "each test binary uses its part")]

pub(crate) use crate::glb::container;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// What a run gave.
pub(crate) struct Run {
    pub(crate) code: i32,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Run {
    pub(crate) fn json(&self) -> serde_json::Value {
        serde_json::from_str(&self.stdout)
            .unwrap_or_else(|e| panic!("{e}: {}\n{}", self.stdout, self.stderr))
    }

    /// Asserts success and hands the run on.
    pub(crate) fn ok(self) -> Self {
        assert_eq!(self.code, 0, "{}", self.stderr);
        self
    }

    /// Asserts a typed error: this exit code, and one line on stderr that holds all of `words`.
    pub(crate) fn fails(self, code: i32, words: &[&str]) -> Self {
        assert_eq!(
            self.code, code,
            "stdout {} stderr {}",
            self.stdout, self.stderr
        );
        let line = self.stderr.lines().last().unwrap_or_default();
        assert!(line.starts_with("error: "), "{}", self.stderr);
        assert_eq!(
            self.stderr
                .lines()
                .filter(|l| l.starts_with("error"))
                .count(),
            1,
            "{}",
            self.stderr
        );
        for word in words {
            assert!(line.contains(word), "{word:?} is not in {line:?}");
        }
        assert!(
            !self.stderr.contains("panicked") && !self.stderr.contains("internal error"),
            "{}",
            self.stderr
        );
        self
    }
}

/// Runs `invertex` on the processor unless the arguments name a device.
pub(crate) fn invertex<S: AsRef<str>>(arguments: &[S]) -> Run {
    run(command(arguments))
}

pub(crate) fn command<S: AsRef<str>>(arguments: &[S]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_invertex"));
    command
        .args(arguments.iter().map(AsRef::as_ref))
        .env_remove("RUST_LOG");
    command
}

pub(crate) fn run(mut command: Command) -> Run {
    let Output {
        status,
        stdout,
        stderr,
    } = command.output().expect("the binary runs");
    let text = |bytes| String::from_utf8(bytes).expect("output is UTF-8");
    Run {
        code: status.code().unwrap_or(-1),
        stdout: text(stdout),
        stderr: text(stderr),
    }
}

/// A folder for one test.
pub(crate) struct Folder(tempfile::TempDir);

impl Folder {
    pub(crate) fn new() -> Self {
        Folder(tempfile::tempdir().expect("a temporary folder"))
    }

    pub(crate) fn path(&self) -> &Path {
        self.0.path()
    }

    /// The path of `name` in it.
    pub(crate) fn at(&self, name: &str) -> String {
        self.path().join(name).display().to_string()
    }

    pub(crate) fn write(&self, name: &str, bytes: &[u8]) -> String {
        std::fs::write(self.path().join(name), bytes).expect("the temporary folder can be written");
        self.at(name)
    }

    /// Names of the files in it, sorted.
    pub(crate) fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.path()).expect("the temporary folder can be read");
        let mut names: Vec<String> = entries
            .map(|e| e.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }
}

/// A small model: a bumpy sphere of `rings` rings, with normals and, if asked, a longitude-latitude uv set.
pub(crate) struct Ball {
    pub(crate) rings: u32,
    pub(crate) uv: bool,
    pub(crate) names: Vec<String>,
    pub(crate) poison: Option<f32>,
}

impl Default for Ball {
    fn default() -> Self {
        Ball {
            rings: 12,
            uv: true,
            names: vec!["ball".to_owned()],
            poison: None,
        }
    }
}

impl Ball {
    /// The model as GLB: one mesh with this shape for each name, side by side.
    pub(crate) fn glb(&self) -> Vec<u8> {
        let (n, m) = (self.rings, self.rings * 2);
        let (mut positions, mut uvs) = (Vec::new(), Vec::new());
        for i in 0..=n {
            for k in 0..=m {
                let (v, u) = (i as f32 / n as f32, k as f32 / m as f32);
                let (polar, turn) = (v * std::f32::consts::PI, (u % 1.0) * std::f32::consts::TAU);
                let radius = 1.0 + 0.05 * (5.0 * turn).sin() * (3.0 * polar).sin();
                let p = [
                    polar.sin() * turn.cos(),
                    polar.cos(),
                    polar.sin() * turn.sin(),
                ];
                positions.push(p.map(|c| c * radius));
                uvs.push([0.02 + u * 0.96, 0.02 + v * 0.96]);
            }
        }
        if let Some(value) = self.poison {
            positions[7][1] = value;
        }
        let mut indices: Vec<u32> = Vec::new();
        for i in 0..n {
            for k in 0..m {
                let a = i * (m + 1) + k;
                let (b, c, d) = (a + 1, a + m + 1, a + m + 2);
                if i > 0 {
                    indices.extend([a, b, d]);
                }
                if i + 1 < n {
                    indices.extend([a, d, c]);
                }
            }
        }
        glb(&positions, self.uv.then_some(&uvs), &indices, &self.names)
    }
}

fn glb(
    positions: &[[f32; 3]],
    uvs: Option<&Vec<[f32; 2]>>,
    indices: &[u32],
    names: &[String],
) -> Vec<u8> {
    let mut binary: Vec<u8> = positions
        .iter()
        .flatten()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let mut views =
        vec![serde_json::json!({"buffer": 0, "byteOffset": 0, "byteLength": binary.len()})];
    let bound = |pick: fn(f32, f32) -> f32, start: f32| {
        positions.iter().fold([start; 3], |b, p| {
            [pick(b[0], p[0]), pick(b[1], p[1]), pick(b[2], p[2])]
        })
    };
    let mut accessors = vec![serde_json::json!({
        "bufferView": 0, "componentType": 5126, "count": positions.len(), "type": "VEC3",
        "min": bound(f32::min, f32::MAX), "max": bound(f32::max, f32::MIN),
    })];
    let mut attributes = serde_json::json!({"POSITION": 0});
    let mut add = |bytes: Vec<u8>, component: u32, count: usize, kind: &str| {
        views.push(
            serde_json::json!({"buffer": 0, "byteOffset": binary.len(), "byteLength": bytes.len()}),
        );
        binary.extend(bytes);
        accessors.push(serde_json::json!({
            "bufferView": views.len() - 1, "componentType": component, "count": count, "type": kind,
        }));
        accessors.len() - 1
    };
    let index = add(
        indices.iter().flat_map(|i| i.to_le_bytes()).collect(),
        5125,
        indices.len(),
        "SCALAR",
    );
    if let Some(uvs) = uvs {
        let bytes = uvs.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        attributes["TEXCOORD_0"] = add(bytes, 5126, uvs.len(), "VEC2").into();
    }
    let primitive = serde_json::json!({"attributes": attributes, "indices": index});
    let meshes: Vec<_> = names
        .iter()
        .map(|n| serde_json::json!({"name": n, "primitives": [primitive]}))
        .collect();
    let node = |i: usize| serde_json::json!({"mesh": i, "translation": [i as f32 * 2.5, 0.0, 0.0]});
    let document = serde_json::json!({
        "asset": {"version": "2.0"}, "scene": 0,
        "scenes": [{"nodes": (0..names.len()).collect::<Vec<_>>()}],
        "nodes": (0..names.len()).map(node).collect::<Vec<_>>(),
        "meshes": meshes, "accessors": accessors, "bufferViews": views, "buffers": [{"byteLength": binary.len()}],
    });
    container(&document.to_string(), &binary)
}

/// The folder of shared models, if there is one.
pub(crate) fn models() -> Option<PathBuf> {
    let folder = std::env::var_os("INVERTEX_MODELS").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/models"),
        PathBuf::from,
    );
    folder.is_dir().then_some(folder)
}

/// A ball, built, in a folder of its own: the folder, the model, the built file.
pub(crate) fn built_ball() -> (Folder, String, String) {
    let folder = Folder::new();
    let model = folder.write("ball.glb", &Ball::default().glb());
    let out = folder.at("built.glb");
    invertex(&[
        "build", &model, "-o", &out, "--device", "cpu", "--lods", "0.5,0.2",
    ])
    .ok();
    (folder, model, out)
}
