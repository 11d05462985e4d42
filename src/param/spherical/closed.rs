//! A mesh as closed surfaces of genus 0, or why it is none.
//!
//! In: a mesh. Out: for each connected part a [`Closed`]: triangles that are two at every edge and one fan about every
//! vertex, holes closed by a fan about a point of their own. Triangles without area count, as they hold their neighbours
//! together; only those that name a vertex twice are left out.

use crate::error::{Error, Result};
use crate::mesh::{Mesh, Union, components};
use crate::param::Map;
use crate::param::weld::by_place;
use glam::DVec3;

/// A closed surface.
#[derive(Clone)]
pub(in crate::param) struct Closed {
    /// For each vertex the mesh's welded vertex; the middles of holes have none.
    pub(in crate::param) vertex: Vec<Option<u32>>,
    pub(in crate::param) places: Vec<DVec3>,
    /// Triangles, the mesh's own first, in its order.
    pub(in crate::param) triangles: Vec<[u32; 3]>,
    /// How many of them are the mesh's own.
    pub(in crate::param) own: usize,
}

/// The parts of a mesh, and for each of its vertices the one it is welded to, for a `map` that wants them so.
pub(in crate::param) fn parts(mesh: &Mesh, map: Map) -> Result<(Vec<Closed>, Vec<u32>)> {
    let weld = by_place(&mesh.positions, &mesh.triangles);
    let mut triangles = weld.triangles(&mesh.triangles);
    triangles.retain(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
    let found = components(&triangles, mesh.positions.len());
    let mut groups = vec![vec![]; found.count];
    for (t, &part) in triangles.iter().zip(&found.of) {
        groups[part as usize].push(*t);
    }
    if groups.is_empty() {
        return Err(refuse(mesh, map, "none of its triangles has area"));
    }
    let closed = groups
        .into_iter()
        .map(|group| Closed::new(mesh, &group).map_err(|reason| refuse(mesh, map, &reason)));
    Ok((closed.collect::<Result<_>>()?, weld.of))
}

fn refuse(mesh: &Mesh, map: Map, reason: &str) -> Error {
    Error::Parameterization {
        mesh: mesh.name.clone(),
        reason: format!("{map} cannot be had: {reason}; charts can, such as --primary lscm"),
    }
}

impl Closed {
    /// The surface of connected triangles, its holes closed; or the reason why it is no sphere.
    fn new(mesh: &Mesh, group: &[[u32; 3]]) -> Result<Closed, String> {
        let mut used: Vec<u32> = group.as_flattened().to_vec();
        used.sort_unstable();
        used.dedup();
        let local = |v: u32| used.binary_search(&v).unwrap_or(0) as u32;
        let mut closed = Closed {
            places: used
                .iter()
                .map(|&v| DVec3::from(mesh.positions[v as usize].map(f64::from)))
                .collect(),
            vertex: used.iter().map(|&v| Some(v)).collect(),
            triangles: group.iter().map(|t| t.map(local)).collect(),
            own: group.len(),
        };
        let open = open_edges(&closed.triangles)?;
        let fans = fans(&closed.triangles, closed.places.len());
        if fans > 0 {
            return Err(format!("at {fans} of its vertices two surfaces touch"));
        }
        let holes = closed.close(open)?;
        let (v, f) = (closed.places.len() as i64, closed.triangles.len() as i64);
        let genus = (2 - (v - f / 2)) / 2;
        if genus != 0 {
            return Err(format!(
                "a part of it has {genus} handles ({holes} holes), neither a sphere nor a tube has any"
            ));
        }
        Ok(closed)
    }

    /// Closes every loop of `open` edges (from, to) by a fan; returns how many.
    fn close(&mut self, open: Vec<(u32, u32)>) -> Result<usize, String> {
        let mut to = vec![u32::MAX; self.places.len()];
        open.iter().for_each(|&(a, b)| to[a as usize] = b);
        let mut holes = 0;
        for &(start, _) in &open {
            if to[start as usize] == u32::MAX {
                continue;
            }
            let mut rim = vec![];
            let mut v = start;
            while to[v as usize] != u32::MAX {
                rim.push(v);
                v = std::mem::replace(&mut to[v as usize], u32::MAX);
            }
            if v != start || rim.len() < 3 {
                return Err("the rim of a hole is no loop".into());
            }
            let middle = self.places.len() as u32;
            let sum: DVec3 = rim.iter().map(|&v| self.places[v as usize]).sum();
            self.places.push(sum / rim.len() as f64);
            self.vertex.push(None);
            // The fan runs along the rim the other way round.
            self.triangles
                .extend((0..rim.len()).map(|k| [rim[(k + 1) % rim.len()], rim[k], middle]));
            holes += 1;
        }
        Ok(holes)
    }
}

/// Edges with one triangle, in its direction. An error where an edge has three, or two that run the same way.
fn open_edges(triangles: &[[u32; 3]]) -> Result<Vec<(u32, u32)>, String> {
    let mut edges: Vec<(u32, u32, bool)> = triangles
        .iter()
        .flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])])
        .map(|(a, b)| (a.min(b), a.max(b), a < b))
        .collect();
    edges.sort_unstable();
    let (mut open, mut many, mut alike) = (vec![], 0, 0);
    for same in edges.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
        match same {
            [(a, b, true)] => open.push((*a, *b)),
            [(a, b, false)] => open.push((*b, *a)),
            [x, y] if x.2 != y.2 => {}
            [_, _] => alike += 1,
            _ => many += 1,
        }
    }
    match (many, alike) {
        (0, 0) => Ok(open),
        (0, _) => Err(format!("at {alike} of its edges the winding turns over")),
        _ => Err(format!("{many} of its edges have more than two triangles")),
    }
}

/// Vertices about which triangles make more than one fan.
fn fans(triangles: &[[u32; 3]], vertices: usize) -> usize {
    // Corners at a vertex are joined where their triangles share an edge at it.
    let mut at: Vec<(u32, u32, u32)> = vec![];
    for (t, corners) in triangles.iter().enumerate() {
        for k in 0..3 {
            let corner = (3 * t + k) as u32;
            at.push((corners[k], corners[(k + 1) % 3], corner));
            at.push((corners[k], corners[(k + 2) % 3], corner));
        }
    }
    at.sort_unstable();
    let mut joined = Union::new(triangles.len() * 3);
    for pair in at.windows(2) {
        if (pair[0].0, pair[0].1) == (pair[1].0, pair[1].1) {
            joined.join(pair[0].2, pair[1].2);
        }
    }
    let mut first = vec![u32::MAX; vertices];
    let mut torn = vec![false; vertices];
    for (v, _, corner) in at {
        let root = joined.root(corner);
        let known = &mut first[v as usize];
        torn[v as usize] |= *known != u32::MAX && *known != root;
        *known = root;
    }
    torn.into_iter().filter(|torn| *torn).count()
}
