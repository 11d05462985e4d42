//! What the benches share: meshes made here, devices, where numbers are kept.
#![allow(dead_code, reason = "each bench uses a part")]

use invertex::gpu::{self, Context, ContextOptions, DeviceChoice};
use invertex::mesh::{Mesh, shapes};
use serde_json::{Value, json};

pub(crate) type Failure = Box<dyn std::error::Error>;

/// A repeatable number in [-1, 1] for each index.
pub(crate) fn jitter(index: usize, salt: u32) -> f32 {
    let mut h = (index as u32).wrapping_mul(0x9e37_79b9) ^ salt.wrapping_mul(0x85eb_ca6b);
    h = (h ^ (h >> 16)).wrapping_mul(0xc2b2_ae35);
    h ^= h >> 13;
    (h & 0xffff) as f32 / 32_767.5 - 1.0
}

/// A unit sheet of cells that are wide and low: slivers.
pub(crate) fn slivers(triangles: u32) -> Mesh {
    let columns = (((triangles / 2) as f64 / 256.0).sqrt().round() as u32).max(1);
    let rows = 256 * columns;
    let mut mesh = Mesh {
        name: "slivers".into(),
        uv_sets: vec![Vec::new()],
        ..Mesh::default()
    };
    for y in 0..=rows {
        for x in 0..=columns {
            let inner = x > 0 && x < columns;
            let moved = if inner {
                0.3 * jitter(mesh.positions.len(), 2)
            } else {
                0.0
            };
            let uv = [(x as f32 + moved) / columns as f32, y as f32 / rows as f32];
            mesh.positions.push([uv[0], uv[1], 0.0]);
            mesh.normals.push([0.0, 0.0, 1.0]);
            mesh.uv_sets[0].push(uv);
        }
    }
    for y in 0..rows {
        for x in 0..columns {
            let a = y * (columns + 1) + x;
            let c = a + columns + 1;
            mesh.triangles.extend([[a, a + 1, c + 1], [a, c + 1, c]]);
        }
    }
    mesh.triangle_material = vec![0; mesh.triangles.len()];
    mesh
}

/// A sheet, and one triangle that covers half of it.
pub(crate) fn with_giant(triangles: u32) -> Mesh {
    let mut mesh = sheet(triangles);
    let first = mesh.positions.len() as u32;
    for uv in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]] {
        mesh.positions.push([uv[0], uv[1], 0.5]);
        mesh.normals.push([0.0, 0.0, 1.0]);
        mesh.uv_sets[0].push(uv);
    }
    mesh.triangles.push([first, first + 1, first + 2]);
    mesh.triangle_material.push(0);
    mesh
}

/// A sheet in nine tenths of one texel, and a small triangle in a far corner that keeps it there.
pub(crate) fn in_one_texel(triangles: u32, hash: u32) -> Mesh {
    let mut mesh = sheet(triangles);
    let texel = 1.0 / hash as f32;
    for uv in &mut mesh.uv_sets[0] {
        *uv = uv.map(|c| (c * 0.9 + 0.05) * texel);
    }
    let first = mesh.positions.len() as u32;
    for uv in [[1.0, 1.0], [1.0 - texel, 1.0], [1.0, 1.0 - texel]] {
        mesh.positions.push([uv[0], uv[1], 0.5]);
        mesh.normals.push([0.0, 0.0, 1.0]);
        mesh.uv_sets[0].push(uv);
    }
    mesh.triangles.push([first, first + 1, first + 2]);
    mesh.triangle_material.push(0);
    mesh
}

/// A unit sheet whose inner uv are moved by up to a quarter of a cell: no two triangles alike.
pub(crate) fn sheet(triangles: u32) -> Mesh {
    let n = ((triangles / 2) as f64).sqrt().round() as u32;
    let mut mesh = shapes::grid(n);
    let cell = 0.25 / n as f32;
    for (i, uv) in mesh.uv_sets[0].iter_mut().enumerate() {
        for (axis, value) in uv.iter_mut().enumerate() {
            if *value > 0.0 && *value < 1.0 {
                *value += cell * jitter(i, axis as u32);
            }
        }
    }
    mesh
}

/// A sphere with bumps of a fifth of its radius.
pub(crate) fn bumpy_sphere(triangles: u32) -> Mesh {
    let rings = ((triangles / 4) as f64).sqrt().round() as u32;
    let mut mesh = shapes::uv_sphere(2 * rings, rings);
    for p in &mut mesh.positions {
        let wave = 0.1 * ((9.0 * p[0]).sin() * (7.0 * p[1]).cos() + (8.0 * p[2]).sin());
        *p = p.map(|c| c * (1.0 + wave));
    }
    mesh
}

/// Milliseconds that the processors have worked for this process so far; 0 where the system does not say.
pub(crate) fn processor_milliseconds() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // After the name in brackets: user and system time are the 12th and 13th, in hundredths of a second.
    let fields = text.rsplit(')').next().unwrap_or_default();
    let ticks = fields.split_whitespace().skip(11).take(2);
    ticks.filter_map(|t| t.parse::<f64>().ok()).sum::<f64>() * 10.0
}

/// A GLB of a mesh's positions, first uv set and triangles.
pub(crate) fn glb(mesh: &Mesh) -> Vec<u8> {
    let arrays: [&[u8]; 3] = [
        bytemuck::cast_slice(&mesh.positions),
        bytemuck::cast_slice(&mesh.uv_sets[0]),
        bytemuck::cast_slice(&mesh.triangles),
    ];
    let starts = [0, arrays[0].len(), arrays[0].len() + arrays[1].len()];
    let view =
        |i: usize| json!({ "buffer": 0, "byteOffset": starts[i], "byteLength": arrays[i].len() });
    let accessor = |i: usize, component: u32, count: usize, kind: &str| {
        let mut a =
            json!({ "bufferView": i, "componentType": component, "count": count, "type": kind });
        if i == 0 {
            a["min"] = json!([0.0, 0.0, -1.0]);
            a["max"] = json!([1.0, 1.0, 1.0]);
        }
        a
    };
    let vertices = mesh.positions.len();
    let binary = arrays.concat();
    let document = json!({
        "asset": { "version": "2.0" },
        "scenes": [{ "nodes": [0] }], "scene": 0, "nodes": [{ "mesh": 0 }],
        "meshes": [{ "name": mesh.name, "primitives": [{ "attributes": { "POSITION": 0, "TEXCOORD_0": 1 }, "indices": 2 }] }],
        "accessors": [accessor(0, 5126, vertices, "VEC3"), accessor(1, 5126, vertices, "VEC2"),
            accessor(2, 5125, mesh.triangles.len() * 3, "SCALAR")],
        "bufferViews": [view(0), view(1), view(2)],
        "buffers": [{ "byteLength": binary.len() }],
    });
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let word = |n: usize| (n as u32).to_le_bytes();
    let mut bytes = b"glTF".to_vec();
    bytes.extend(
        [
            word(2),
            word(28 + text.len() + binary.len()),
            word(text.len()),
        ]
        .concat(),
    );
    bytes.extend(b"JSON");
    bytes.extend(&text);
    bytes.extend(word(binary.len()));
    bytes.extend(b"BIN\0");
    bytes.extend(&binary);
    bytes
}

pub(crate) fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 2]
}

pub(crate) fn contexts(wanted: &str) -> Result<Vec<Context>, Failure> {
    let indices: Vec<DeviceChoice> = match wanted {
        "cpu" => Vec::new(),
        "all" => gpu::devices()
            .unwrap_or_default()
            .iter()
            .filter(|d| d.usable)
            .map(|d| DeviceChoice::Index(d.index))
            .collect(),
        other => vec![other.parse()?],
    };
    indices
        .into_iter()
        .map(|device| {
            Ok(Context::new(&ContextOptions {
                device,
                validation: false,
            })?)
        })
        .collect()
}

pub(crate) fn machine() -> Value {
    let first = |file: &str, key: &str| {
        let text = std::fs::read_to_string(file).unwrap_or_default();
        let found = text.lines().find(|l| l.starts_with(key));
        found
            .and_then(|l| l.split([':', '=']).nth(1))
            .unwrap_or("unknown")
            .trim()
            .trim_matches('"')
            .to_owned()
    };
    json!({
        "processor": first("/proc/cpuinfo", "model name"),
        "cores": std::thread::available_parallelism().map_or(0, usize::from),
        "system": first("/etc/os-release", "PRETTY_NAME"),
        // What else ran: the numbers of a busy machine are a lower bound.
        "load_average": std::fs::read_to_string("/proc/loadavg").unwrap_or_default().trim(),
    })
}

pub(crate) fn today() -> String {
    let output = std::process::Command::new("date")
        .args(["-u", "+%Y-%m-%d"])
        .output();
    output.map_or_else(
        |_| "undated".into(),
        |o| String::from_utf8_lossy(&o.stdout).trim().to_owned(),
    )
}

/// Keeps the numbers in benches/runs/ as `<date>-<name>.json` and the text beside them, as `.txt` or `.md`.
pub(crate) fn archive(
    name: &str,
    kind: &str,
    command: &str,
    text: &str,
    results: &[Value],
) -> Result<(), Failure> {
    let base = format!(
        "{}/benches/runs/{}-{name}",
        env!("CARGO_MANIFEST_DIR"),
        today()
    );
    let document =
        json!({ "command": command, "date": today(), "machine": machine(), "results": results });
    std::fs::write(
        format!("{base}.json"),
        serde_json::to_string_pretty(&document)? + "\n",
    )?;
    std::fs::write(
        format!("{base}.{kind}"),
        format!("{command}\n{}\n{}\n\n{text}", today(), machine()),
    )?;
    println!("archived in {base}.json and .{kind}");
    Ok(())
}
