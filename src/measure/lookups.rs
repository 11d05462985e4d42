//! Lookups alone: what the correspondence costs without rasterising, textures and light.
//!
//! In: an image drawn through an inverse texture. Out: the points of T3 that its covered pixels stand for, and the time
//! that looking all of them up takes, in one pass, as often as frames are timed.

use crate::Result;
use crate::asset::{BuiltMesh, Processor};
use crate::igt::Reference;
use crate::mesh::Mesh;
use crate::param::grid::{QUERY_MAX, QUERY_SHIFT};
use crate::render::{FrameBudget, Rendered, Taking};
use rayon::prelude::*;

use super::timing::TimeStatistics;

/// The T3 points of the reference under the covered pixels of `image`, query grid, row by row.
pub(super) fn points(mesh: &Mesh, built: &BuiltMesh, image: &Rendered) -> Result<Vec<[i32; 3]>> {
    let tables = &built.tables;
    let reference = Reference::new(mesh, &tables.primary, &built.triangle_layer, tables.layout)?;
    let known = image.triangle.iter().zip(&image.barycentric);
    let point = |(&triangle, b): (&u32, &[f32; 2])| -> [i32; 3] {
        let corners = reference.corners(triangle as usize);
        let b = [
            1.0 - f64::from(b[0]) - f64::from(b[1]),
            b[0].into(),
            b[1].into(),
        ];
        std::array::from_fn(|k| {
            let along = |v: usize| b[v] * f64::from(corners[v][k] << QUERY_SHIFT);
            ((along(0) + along(1) + along(2)).round() as i32).clamp(-QUERY_MAX, QUERY_MAX)
        })
    };
    Ok(known.filter(|(t, _)| **t != u32::MAX).map(point).collect())
}

/// For each number of triangles from 0 on the covered pixels of `image` whose lookup tests so many; `points` are theirs. The
/// processor's lookup counts what the shader's does.
pub(super) fn tests(built: &BuiltMesh, image: &Rendered, points: &[[i32; 3]]) -> Vec<u64> {
    let triangles: Vec<u32> = image
        .triangle
        .iter()
        .copied()
        .filter(|&t| t != u32::MAX)
        .collect();
    let count = |(&triangle, &point): (&u32, &[i32; 3])| {
        let layer = built.triangle_layer.get(triangle as usize).copied();
        built.tables.lookup_with_cost(point, layer, true).1.tests
    };
    let all: Vec<u32> = triangles.par_iter().zip(points).map(count).collect();
    let mut histogram = vec![0; all.iter().max().map_or(0, |&most| most as usize + 1)];
    all.iter().for_each(|&tests| histogram[tests as usize] += 1);
    histogram
}

/// What looking up all `points` takes; none where there are none.
pub(super) fn time(
    processor: Processor<'_>,
    built: &BuiltMesh,
    points: &[[i32; 3]],
    budget: &FrameBudget,
) -> Result<Option<TimeStatistics>> {
    if points.is_empty() {
        return Ok(None);
    }
    // Less happens than in a frame: a third of its time is enough.
    let budget = FrameBudget {
        seconds: budget.seconds.map(|s| s / 3.0),
        ..*budget
    };
    let (tables, mut taking) = (&built.tables, Taking::new(&budget));
    match processor {
        Processor::Cpu => loop {
            let found = points
                .par_iter()
                .filter_map(|&p| tables.lookup(p, None, true));
            std::hint::black_box(found.map(|f| u64::from(f.triangle)).sum::<u64>());
            if !taking.frame(0, Vec::new()) {
                break;
            }
        },
        #[cfg(feature = "gpu")]
        Processor::Device(context) | Processor::Preferably(context) => {
            crate::igt::gpu::repeat(context, tables, points, None, |t| taking.stamped(t))?;
        }
        #[cfg(not(feature = "gpu"))]
        Processor::Absent(never) => match *never {},
    }
    let totals: Vec<u64> = taking.done().frames.iter().map(|f| f.total).collect();
    Ok(TimeStatistics::of(&totals))
}
