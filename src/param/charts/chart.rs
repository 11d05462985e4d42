//! A chart as a mesh of its own, cut open until it is a disk.
//!
//! In: triangles of a [`Surface`]. Out: [`Chart`]: local vertices, and the rim as one loop. Corners are one vertex where
//! edges of the chart join them, so a vertex at which two fans only touch becomes two. A chart that is no disk (a ring, a
//! handle, a closed surface) is cut ([`super::cut`]).

use super::cut::cut_to_disk;
use super::surface::Surface;
use crate::mesh::NONE;
use glam::DVec3;

/// A disk of triangles.
#[derive(Clone, Debug)]
pub(crate) struct Chart {
    /// Numbers of its triangles on the surface, growing.
    pub(crate) triangles: Vec<u32>,
    /// For each of them its local vertices.
    pub(crate) corners: Vec<[u32; 3]>,
    /// Where local vertices lie.
    pub(crate) places: Vec<DVec3>,
    /// Local vertices of the rim, in the direction of the triangles' half-edges.
    pub(crate) rim: Vec<u32>,
    /// Edges that were cut to make it a disk.
    pub(crate) cuts: usize,
}

impl Chart {
    /// The chart of `triangles` (growing numbers), which hang together over edges; `None` where no cut makes it a disk.
    pub(crate) fn new(surface: &Surface, triangles: Vec<u32>) -> Option<Chart> {
        Chart::opened(surface, triangles, &[])
    }

    /// The same, with `slits` in it: half-edges of the surface that are cut first.
    pub(crate) fn opened(surface: &Surface, triangles: Vec<u32>, slits: &[u32]) -> Option<Chart> {
        let mut across = inside(surface, &triangles);
        for slit in slits {
            let local = 3 * triangles.binary_search(&(slit / 3)).ok()? + *slit as usize % 3;
            let other = std::mem::replace(&mut across[local], NONE);
            if other != NONE {
                across[other as usize] = NONE;
            }
        }
        let whole = Vertices::new(&across);
        let edges = across.len() - across.iter().filter(|&&a| a != NONE).count() / 2;
        let euler = whole.count as isize - edges as isize + triangles.len() as isize;
        let cuts = if euler == 1 {
            0
        } else {
            cut_to_disk(&mut across, &whole, &lengths(surface, &triangles))
        };
        let vertices = if cuts == 0 {
            whole
        } else {
            Vertices::new(&across)
        };
        let corners: Vec<[u32; 3]> = vertices.of.as_chunks::<3>().0.to_vec();
        let mut places = vec![DVec3::ZERO; vertices.count];
        for (t, local) in triangles.iter().zip(&corners) {
            for (v, place) in local.iter().zip(surface.corners(*t as usize)) {
                places[*v as usize] = place;
            }
        }
        let rim = rim(&across, &corners, vertices.count)?;
        Some(Chart {
            triangles,
            corners,
            places,
            rim,
            cuts: cuts + slits.len(),
        })
    }

    /// Corners of local triangle `i`.
    pub(crate) fn triangle(&self, i: usize) -> [DVec3; 3] {
        self.corners[i].map(|v| self.places[v as usize])
    }
}

/// For each local half-edge the local one across, as far as it lies inside the chart.
fn inside(surface: &Surface, triangles: &[u32]) -> Vec<u32> {
    let local = |half_edge: u32| match triangles.binary_search(&(half_edge / 3)) {
        Ok(i) => 3 * i as u32 + half_edge % 3,
        Err(_) => NONE,
    };
    let across = |h: u32| match surface.across[h as usize] {
        NONE => NONE,
        other => local(other),
    };
    triangles
        .iter()
        .flat_map(|&t| [0, 1, 2].map(|k| across(3 * t + k)))
        .collect()
}

/// Length of each local half-edge.
fn lengths(surface: &Surface, triangles: &[u32]) -> Vec<f64> {
    let length = |h: u32| surface.length(h as usize);
    triangles
        .iter()
        .flat_map(|&t| [0, 1, 2].map(|k| length(3 * t + k)))
        .collect()
}

/// Which corners are one vertex.
pub(super) struct Vertices {
    /// For each corner its vertex, numbered by first appearance.
    pub(super) of: Vec<u32>,
    pub(super) count: usize,
}

impl Vertices {
    /// Walks round each vertex from corner to corner over the edges of `across`.
    fn new(across: &[u32]) -> Self {
        let mut of = vec![NONE; across.len()];
        let mut count = 0;
        for start in 0..across.len() as u32 {
            if of[start as usize] != NONE {
                continue;
            }
            // Back to the fan's first corner, or once round; then forward.
            let mut corner = start;
            while let Some(before) = turn_back(across, corner) {
                if before == start {
                    break;
                }
                corner = before;
            }
            let first = corner;
            loop {
                of[corner as usize] = count;
                match turn(across, corner) {
                    Some(next) if next != first => corner = next,
                    _ => break,
                }
            }
            count += 1;
        }
        Vertices {
            of,
            count: count as usize,
        }
    }
}

/// The next corner about the same vertex, over the edge that arrives at it.
fn turn(across: &[u32], corner: u32) -> Option<u32> {
    let arriving = previous(corner);
    let other = across[arriving as usize];
    (other != NONE).then_some(other)
}

/// The corner before, over the edge that leaves it.
fn turn_back(across: &[u32], corner: u32) -> Option<u32> {
    let other = across[corner as usize];
    (other != NONE).then(|| next(other))
}

pub(super) fn next(half_edge: u32) -> u32 {
    half_edge - half_edge % 3 + (half_edge + 1) % 3
}

fn previous(half_edge: u32) -> u32 {
    half_edge - half_edge % 3 + (half_edge + 2) % 3
}

/// The border as one loop of vertices, or none where it is not one simple loop.
fn rim(across: &[u32], corners: &[[u32; 3]], vertices: usize) -> Option<Vec<u32>> {
    let mut to = vec![NONE; vertices];
    let mut edges = 0;
    let mut start = NONE;
    for (h, _) in across.iter().enumerate().filter(|(_, a)| **a == NONE) {
        let (a, b) = (corners[h / 3][h % 3], corners[h / 3][(h % 3 + 1) % 3]);
        if to[a as usize] != NONE {
            return None;
        }
        to[a as usize] = b;
        edges += 1;
        start = start.min(a);
    }
    if start == NONE {
        return None;
    }
    let mut rim = Vec::with_capacity(edges);
    let mut v = start;
    loop {
        rim.push(v);
        v = to[v as usize];
        if v == start {
            break;
        }
        if v == NONE || rim.len() > edges {
            return None;
        }
    }
    let triangles = corners.len();
    let all = (3 * triangles + edges) / 2;
    // One loop of all border edges, and Euler's number of a disk.
    (rim.len() == edges && vertices + triangles == all + 1).then_some(rim)
}
