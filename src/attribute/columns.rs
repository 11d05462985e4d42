//! Numbers that vertices carry for what is shown: one column for each factor that needs some.
//!
//! In: a scene, a factor. Out: [`Column`], for every mesh a fixed count of numbers for each vertex, of the model at rest.

use super::named::{Factor, VertexAttribute};
use super::occlusion;
use super::shown::ShownOptions;
use crate::Result;
use crate::mesh::{self, Mesh, Weld};
use crate::scene::Scene;

/// Numbers of one factor.
pub(super) struct Column {
    /// Of each vertex.
    pub(super) width: usize,
    /// Of each mesh, vertex after vertex.
    pub(super) meshes: Vec<Vec<f32>>,
}

/// The numbers of a factor that are not among the vertices' words already.
pub(super) fn column(
    scene: &Scene,
    factor: &Factor,
    options: &ShownOptions,
    progress: &dyn Fn(usize, usize),
) -> Result<Option<Column>> {
    let one = |meshes| Some(Column { width: 1, meshes });
    Ok(match factor {
        Factor::Part => one(parts(scene)),
        Factor::Solid(_) | Factor::Volume => Some(units(scene, options.scale)),
        Factor::Procedural => Some(at_rest(scene)),
        Factor::Vertex { of, .. } => match of {
            VertexAttribute::Color => None,
            VertexAttribute::Occlusion => {
                one(occlusion::cast(scene, &options.occlusion, progress)?)
            }
            VertexAttribute::Custom { name, range } => Some(custom(scene, name, *range)),
        },
        _ => None,
    })
}

/// For each vertex the number of its connected part, parts of all meshes counted in one run.
fn parts(scene: &Scene) -> Vec<Vec<f32>> {
    let mut before = 0;
    let mut of_mesh = |mesh: &Mesh| {
        let weld = Weld::by_position(&mesh.positions);
        let parts = mesh::components(&weld.triangles(&mesh.triangles), mesh.positions.len());
        let mut number = vec![0.0; mesh.positions.len()];
        for (triangle, part) in mesh.triangles.iter().zip(&parts.of) {
            triangle
                .iter()
                .for_each(|&v| number[v as usize] = (before + *part as usize) as f32);
        }
        before += parts.count;
        number
    };
    scene.meshes.iter().map(&mut of_mesh).collect()
}

/// Positions as solid textures see them: from the middle of the box round all meshes, its longest side as unit.
fn units(scene: &Scene, scale: f32) -> Column {
    let bounds = scene.meshes.iter().filter_map(Mesh::bounds);
    let joint = bounds.reduce(|(a, b), (low, high)| {
        let each = |k: usize| (a[k].min(low[k]), b[k].max(high[k]));
        ([0, 1, 2].map(|k| each(k).0), [0, 1, 2].map(|k| each(k).1))
    });
    let (low, high) = joint.unwrap_or_default();
    let (low, high) = (low.map(f64::from), high.map(f64::from));
    let longest = (0..3).map(|k| high[k] - low[k]).fold(0.0, f64::max);
    let factor = if longest > 0.0 {
        f64::from(scale) / longest
    } else {
        0.0
    };
    let middle = [0, 1, 2].map(|k| (low[k] + high[k]) / 2.0);
    let unit = |p: &[f32; 3]| [0, 1, 2].map(|k| ((f64::from(p[k]) - middle[k]) * factor) as f32);
    let of_mesh = |m: &Mesh| m.positions.iter().flat_map(unit).collect();
    Column {
        width: 3,
        meshes: scene.meshes.iter().map(of_mesh).collect(),
    }
}

/// Positions and normals as they are.
fn at_rest(scene: &Scene) -> Column {
    let of_mesh = |m: &Mesh| {
        let both = m.positions.iter().zip(&m.normals);
        both.flat_map(|(p, n)| [p[0], p[1], p[2], n[0], n[1], n[2]])
            .collect()
    };
    Column {
        width: 6,
        meshes: scene.meshes.iter().map(of_mesh).collect(),
    }
}

/// A custom attribute; 0 where a mesh lacks it.
fn custom(scene: &Scene, name: &str, range: Option<[f32; 2]>) -> Column {
    let named = |m: &'_ Mesh| m.custom.iter().find(|c| c.name == name).map(|c| c.width);
    let width = scene.meshes.iter().filter_map(named).max().unwrap_or(1);
    let scaled = |x: f32| range.map_or(x, |[low, high]| (x - low) / (high - low));
    let of_mesh = |mesh: &Mesh| {
        let own = mesh.custom.iter().find(|c| c.name == name);
        let number = |i: usize| match own {
            Some(own) if i % width < own.width => own.values[i / width * own.width + i % width],
            _ => 0.0,
        };
        (0..mesh.positions.len() * width)
            .map(number)
            .map(scaled)
            .collect()
    };
    Column {
        width,
        meshes: scene.meshes.iter().map(of_mesh).collect(),
    }
}
