//! Posing done again, plainly: matrices as sixteen numbers, the textbook's formulas, nothing shared with the library but
//! the numbers that it read from the file.

use invertex::mesh::Mesh;
use invertex::scene::{Animation, Interpolation, Property, Scene, Track, Transform};

type Matrix = [[f64; 4]; 4];
type Vector = [f64; 3];

/// A node's translation, rotation (x, y, z, w) and scale.
#[derive(Clone, Copy)]
struct Parts(Vector, [f64; 4], Vector);

/// Positions and normals of skinned mesh `mesh`, `time` seconds into `animation`.
pub(crate) fn posed(scene: &Scene, animation: &Animation, time: f64) -> (Vec<Vector>, Vec<Vector>) {
    let node = scene.nodes.iter().position(|n| n.skin.is_some()).unwrap();
    let mesh = &scene.meshes[scene.nodes[node].mesh.unwrap()];
    let skin = &scene.skins[scene.nodes[node].skin.unwrap()];
    let (parts, weights) = sampled(scene, animation, time, node, mesh);
    let joints: Vec<Matrix> = skin
        .joints
        .iter()
        .zip(&skin.inverse_bind)
        .map(|(&joint, bind)| {
            let mut matrix = columns(bind);
            let mut at = Some(joint);
            while let Some(node) = at {
                matrix = product(&placed(&parts[node]), &matrix);
                at = scene.nodes[node].parent;
            }
            matrix
        })
        .collect();
    let vertex = |v: usize| {
        let (mut p, mut n) = (
            mesh.positions[v].map(f64::from),
            mesh.normals[v].map(f64::from),
        );
        for (target, weight) in mesh.targets.iter().zip(&weights) {
            for k in 0..3 {
                p[k] += weight * target.positions.get(v).map_or(0.0, |d| f64::from(d[k]));
                n[k] += weight * target.normals.get(v).map_or(0.0, |d| f64::from(d[k]));
            }
        }
        let mut blend = [[0.0; 4]; 4];
        let total: f64 = mesh.weights[v].iter().map(|&w| f64::from(w)).sum();
        for i in 0..4 {
            let share = f64::from(mesh.weights[v][i]) / total;
            let joint = &joints[usize::from(mesh.joints[v][i])];
            for (row, of) in blend.iter_mut().zip(joint) {
                (0..4).for_each(|k| row[k] += share * of[k]);
            }
        }
        let moved = [0, 1, 2].map(|r| dot(&[p[0], p[1], p[2], 1.0], &blend[r]));
        (moved, unit(turned(&blend, n)))
    };
    (0..mesh.positions.len()).map(vertex).unzip()
}

fn sampled(
    scene: &Scene,
    animation: &Animation,
    time: f64,
    skinned: usize,
    mesh: &Mesh,
) -> (Vec<Parts>, Vec<f64>) {
    let at_rest = |node: &invertex::scene::Node| match node.transform {
        Transform::Parts {
            translation,
            rotation,
            scale,
        } => Parts(
            translation.to_array(),
            rotation.to_array(),
            scale.to_array(),
        ),
        Transform::Matrix(matrix) => {
            assert_eq!(
                matrix,
                glam::DMat4::IDENTITY,
                "only the identity is expected here"
            );
            Parts([0.0; 3], [0.0, 0.0, 0.0, 1.0], [1.0; 3])
        }
    };
    let mut parts: Vec<Parts> = scene.nodes.iter().map(at_rest).collect();
    let mut weights: Vec<f64> = mesh.target_weights.iter().map(|&w| f64::from(w)).collect();
    for channel in &animation.channels {
        let node = channel.node.unwrap();
        let values = track(
            &animation.tracks[channel.track],
            time,
            channel.property == Property::Rotation,
        );
        let three = || [values[0], values[1], values[2]];
        match channel.property {
            Property::Translation => parts[node].0 = three(),
            Property::Rotation => parts[node].1 = [values[0], values[1], values[2], values[3]],
            Property::Scale => parts[node].2 = three(),
            Property::Weights if node == skinned => weights = values,
            Property::Weights | Property::Other => {}
        }
    }
    (parts, weights)
}

/// glTF 2.0, appendix C.
fn track(track: &Track, time: f64, rotation: bool) -> Vec<f64> {
    let times: Vec<f64> = track.times.iter().map(|&t| f64::from(t)).collect();
    let cubic = track.interpolation == Interpolation::Cubic;
    let groups = if cubic { 3 } else { 1 };
    let width = track.values.len() / times.len() / groups;
    let part = |i: usize, g: usize| -> Vec<f64> {
        let from = (i * groups + g) * width;
        track.values[from..from + width]
            .iter()
            .map(|&x| f64::from(x))
            .collect()
    };
    let key = |i: usize| part(i, usize::from(cubic));
    let last = times.len() - 1;
    if time <= times[0] {
        return key(0);
    }
    if time >= times[last] {
        return key(last);
    }
    let i = (0..last)
        .find(|&i| times[i] <= time && time < times[i + 1])
        .unwrap();
    let td = times[i + 1] - times[i];
    let t = (time - times[i]) / td;
    let (a, b) = (key(i), key(i + 1));
    let blended =
        |x: f64, y: f64| -> Vec<f64> { a.iter().zip(&b).map(|(p, q)| x * p + y * q).collect() };
    match track.interpolation {
        Interpolation::Step => a,
        Interpolation::Linear if rotation => {
            let cosine: f64 = a.iter().zip(&b).map(|(p, q)| p * q).sum();
            let angle = cosine.abs().min(1.0).acos();
            let (x, y) = if angle < 1e-9 {
                (1.0 - t, t)
            } else {
                (
                    ((1.0 - t) * angle).sin() / angle.sin(),
                    (t * angle).sin() / angle.sin(),
                )
            };
            blended(x, y * cosine.signum())
        }
        Interpolation::Linear => blended(1.0 - t, t),
        Interpolation::Cubic => {
            let (leaving, arriving) = (part(i, 2), part(i + 1, 0));
            let (t2, t3) = (t.powi(2), t.powi(3));
            let value = |k: usize| {
                (2.0 * t3 - 3.0 * t2 + 1.0) * a[k]
                    + td * (t3 - 2.0 * t2 + t) * leaving[k]
                    + (3.0 * t2 - 2.0 * t3) * b[k]
                    + td * (t3 - t2) * arriving[k]
            };
            let out: Vec<f64> = (0..width).map(value).collect();
            if !rotation {
                return out;
            }
            let length = out.iter().map(|x| x * x).sum::<f64>().sqrt();
            out.iter().map(|x| x / length).collect()
        }
    }
}

fn placed(&Parts(t, [x, y, z, w], s): &Parts) -> Matrix {
    let rotation = [
        [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y - z * w),
            2.0 * (x * z + y * w),
        ],
        [
            2.0 * (x * y + z * w),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z - x * w),
        ],
        [
            2.0 * (x * z - y * w),
            2.0 * (y * z + x * w),
            1.0 - 2.0 * (x * x + y * y),
        ],
    ];
    let row = |r: usize| {
        let q = rotation[r];
        [q[0] * s[0], q[1] * s[1], q[2] * s[2], t[r]]
    };
    [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
}

fn columns(m: &[f32; 16]) -> Matrix {
    std::array::from_fn(|r| std::array::from_fn(|c| f64::from(m[c * 4 + r])))
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|r| std::array::from_fn(|c| (0..4).map(|k| a[r][k] * b[k][c]).sum()))
}

fn dot(a: &[f64; 4], b: &[f64; 4]) -> f64 {
    (0..4).map(|k| a[k] * b[k]).sum()
}

/// By the cofactors of the upper left block, which is the inverse transpose but for a factor (positive here).
fn turned(m: &Matrix, n: Vector) -> Vector {
    let minor = |r: usize, c: usize| {
        let (r1, r2, c1, c2) = ((r + 1) % 3, (r + 2) % 3, (c + 1) % 3, (c + 2) % 3);
        m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1]
    };
    std::array::from_fn(|r| (0..3).map(|c| minor(r, c) * n[c]).sum())
}

fn unit(v: Vector) -> Vector {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    v.map(|x| x / length)
}
