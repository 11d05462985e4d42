//! A mesh with its primary and parts, ready to be simplified; points on triangles.
#![allow(dead_code, reason = "each test file uses a part")]

use invertex::lod::LodInput;
use invertex::mesh::Mesh;
use invertex::param::{Parts, Primary, PrimaryKind, PrimaryRequest, parameterize, parts};

pub(crate) const IDENTITY: [[f32; 4]; 4] = [
    [1.0, 0.0, 0.0, 0.0],
    [0.0, 1.0, 0.0, 0.0],
    [0.0, 0.0, 1.0, 0.0],
    [0.0, 0.0, 0.0, 1.0],
];

/// A mesh with its primary and parts.
pub(crate) struct Model {
    pub(crate) mesh: Mesh,
    pub(crate) primary: Primary,
    pub(crate) parts: Parts,
    pub(crate) world: [[f32; 4]; 4],
}

impl Model {
    pub(crate) fn new(mesh: Mesh, kind: PrimaryKind) -> Self {
        let primary = Primary::centred(kind, &mesh).unwrap();
        let parts = parts(&mesh, &primary);
        Model {
            mesh,
            primary,
            parts,
            world: IDENTITY,
        }
    }

    /// With the primary that `request` asks for, computed where it has to be.
    pub(crate) fn with(mesh: &Mesh, request: &PrimaryRequest) -> Self {
        let chosen = parameterize(mesh, request).unwrap();
        let open = chosen.computed.map(|c| c.embedding.cut_open(mesh));
        let mesh = open.unwrap_or_else(|| mesh.clone());
        let parts = parts(&mesh, &chosen.primary);
        Model {
            mesh,
            primary: chosen.primary,
            parts,
            world: IDENTITY,
        }
    }

    pub(crate) fn at(mut self, scale: f32, offset: [f32; 3]) -> Self {
        (0..3).for_each(|k| self.world[k][k] = scale);
        self.world[3] = [offset[0], offset[1], offset[2], 1.0];
        self
    }

    pub(crate) fn input(&self) -> LodInput<'_> {
        LodInput {
            mesh: &self.mesh,
            primary: &self.primary,
            parts: &self.parts,
            world: self.world,
        }
    }

    pub(crate) fn grid(&self, v: u32) -> [i32; 3] {
        let t3 = self.primary.t3_of(&self.mesh, v as usize);
        self.primary.to_grid(t3)
    }

    /// The point with barycentric coordinates `b` in a triangle of three vertices of the mesh.
    pub(crate) fn point(&self, corners: [u32; 3], b: [f64; 3]) -> glam::DVec3 {
        let at = |v: u32| glam::DVec3::from(self.mesh.positions[v as usize].map(f64::from));
        (0..3).map(|c| at(corners[c]) * b[c]).sum()
    }

    /// Likewise its place in T3, on the query grid.
    pub(crate) fn query(&self, corners: [u32; 3], b: [f64; 3]) -> [i32; 3] {
        let grid = corners.map(|v| self.grid(v).map(f64::from));
        let place = |k: usize| (0..3).map(|c| grid[c][k] * b[c]).sum::<f64>();
        [0, 1, 2].map(|k| (place(k) * 64.0).round() as i32)
    }
}

/// The barycentric coordinates of the `i`th of points that are spread over a triangle.
pub(crate) fn spread(i: u64) -> [f64; 3] {
    let number = |i: u64| {
        let mut h = i.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        h = (h ^ (h >> 31)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        (h >> 11) as f64 / (1u64 << 53) as f64
    };
    let (u, v) = (number(i * 2 + 1), number(i * 2 + 2).sqrt());
    [1.0 - v, v * (1.0 - u), v * u]
}
