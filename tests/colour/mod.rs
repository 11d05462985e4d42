//! Models, pictures and samples for the tests of colour deviations: everything found another way than by what is tested.
#![allow(dead_code, reason = "each test file uses a part")]

use exact::Exact;
use glam::{DMat3, DVec3};
use invertex::igt::{Ambiguous, Asker, BuildOptions, Layout, Needs, Reference, Tables, build_cpu};
use invertex::lod::LodInput;
use invertex::lod::progressive::colour::{Colours, Picture, Shade, Wrap};
use invertex::lod::progressive::{Cost, Made, Progressive};
use invertex::mesh::{Mesh, Weld, components};
use invertex::param::projection::Line;
use invertex::param::{Parts, Primary, PrimaryKind, PrimaryRequest, parameterize, parts};
use std::borrow::Cow;
use std::collections::HashSet;

#[path = "../exact/mod.rs"]
mod exact;
pub(crate) mod found;
pub(crate) mod sampled;

/// A mesh and what answers for it.
pub(crate) struct Model {
    pub(crate) mesh: Mesh,
    primary: Primary,
    parts: Parts,
    tables: Tables,
    /// For each triangle the piece of the surface in T3 that it is part of.
    piece: Vec<u32>,
    /// Triangles behind which others lie.
    ambiguous: HashSet<u32>,
    exact: Exact,
}

impl Model {
    pub(crate) fn new(mesh: Mesh, kind: PrimaryKind) -> Self {
        let primary = Primary::centred(kind, &mesh).unwrap();
        Model::with(mesh, primary)
    }

    pub(crate) fn computed(mesh: &Mesh, request: &str) -> Self {
        let chosen = parameterize(mesh, &request.parse::<PrimaryRequest>().unwrap()).unwrap();
        let cut = |c: &invertex::param::Computed| c.embedding.cut_open(mesh);
        let mesh = chosen.computed.as_ref().map_or_else(|| mesh.clone(), cut);
        Model::with(mesh, chosen.primary)
    }

    /// A mesh, cut open where its primary asks for it.
    pub(crate) fn with(mesh: Mesh, primary: Primary) -> Self {
        let parts = parts(&mesh, &primary);
        let reference =
            Reference::new(&mesh, &primary, &parts.triangle_layer, Layout::Packed).unwrap();
        let options = BuildOptions {
            hash: invertex::asset::hash_for(mesh.triangles.len()).max(128),
            layout: Layout::Packed,
        };
        let tables = build_cpu(&reference, &Needs::default(), options).unwrap();
        let ambiguous = Ambiguous::of(&mesh, &primary, &parts.triangle_layer).unwrap();
        Model {
            piece: pieces(&mesh, &primary),
            exact: Exact::new(&mesh),
            mesh,
            primary,
            parts,
            tables,
            ambiguous: ambiguous.triangles.into_iter().collect(),
        }
    }

    pub(crate) fn input(&self) -> LodInput<'_> {
        LodInput {
            mesh: &self.mesh,
            primary: &self.primary,
            parts: &self.parts,
            world: glam::Mat4::IDENTITY.to_cols_array_2d(),
        }
    }

    pub(crate) fn progressive(&self, least: usize) -> Progressive {
        Progressive::new(&self.input(), Cost::Displacement, least)
    }

    fn position(&self, v: u32) -> DVec3 {
        DVec3::from(self.mesh.positions[v as usize].map(f64::from))
    }

    /// Barycentric coordinates in triangle `t` of a point of a simplified triangle's plane, those below zero taken as zero; none
    /// along a cylinder's lines.
    fn clamped(&self, made: &Made, b: [f64; 3], t: u32) -> Option<[f64; 3]> {
        let grid = |v: u32| {
            let t3 = self.primary.t3_of(&self.mesh, v as usize);
            let p = DVec3::from(self.primary.to_grid(t3).map(f64::from));
            match self.primary.line() {
                Line::Parallel => Some(p.with_z(1.0)),
                Line::Sphere => Some(p),
                Line::Cylinder => None,
            }
        };
        let [x, y, z] = made.corners.map(grid);
        let point = x? * b[0] + y? * b[1] + z? * b[2];
        let [x, y, z] = self.mesh.triangles[t as usize].map(grid);
        let shares = DMat3::from_cols(x?, y?, z?).inverse() * point;
        let shares = shares.max(DVec3::ZERO);
        Some((shares / shares.element_sum()).to_array())
    }

    /// The reference's triangle and barycentric coordinates at a point of a simplified triangle, or of its plane.
    pub(crate) fn shown(&self, made: &Made, b: [f64; 3]) -> Option<(u32, [f64; 3])> {
        let (t, shares) = self.found(made, b)?;
        (!self.ambiguous.contains(&t)).then_some((t, shares))
    }

    /// Whether others lie behind what is shown there.
    pub(crate) fn is_ambiguous(&self, made: &Made, b: [f64; 3]) -> bool {
        let found = self.found(made, b);
        found.is_some_and(|(t, _)| self.ambiguous.contains(&t))
    }

    fn found(&self, made: &Made, b: [f64; 3]) -> Option<(u32, [f64; 3])> {
        let corners = made.corners.map(|v| {
            let t3 = self.primary.t3_of(&self.mesh, v as usize);
            self.primary.to_grid(t3)
        });
        let t3 = [0, 1, 2].map(|k| (0..3).map(|c| f64::from(corners[c][k]) * b[c]).sum::<f64>());
        let query = t3.map(|x| (x * 64.0).round() as i32);
        let asker = Asker {
            grazed: false,
            ..Asker::of(self.primary.line(), &corners, Some(made.layer))
        };
        let found = self.tables.lookup(query, asker, false).filter(|f| f.hit)?;
        let of = (&self.mesh, &self.primary);
        self.exact.at(of, (query, asker.side), found.triangle)
    }
}

/// Triangles that hang together in space and in T3.
fn pieces(mesh: &Mesh, primary: &Primary) -> Vec<u32> {
    let place = Weld::by_position(&mesh.positions).of;
    let key = |v: usize| (place[v], primary.t3_of(mesh, v).map(f64::to_bits));
    let weld = Weld::by_key((0..mesh.positions.len()).map(key));
    components(&weld.triangles(&mesh.triangles), mesh.positions.len()).of
}

/// A picture in the making.
pub(crate) struct Paint {
    size: [u32; 2],
    texels: Vec<[u8; 4]>,
}

impl Paint {
    pub(crate) fn new(size: [u32; 2], texel: impl Fn(u32, u32) -> [u8; 4]) -> Self {
        let texels = (0..size[0] * size[1]).map(|i| texel(i % size[0], i / size[0]));
        Paint {
            size,
            texels: texels.collect(),
        }
    }

    /// Texels that have nothing to do with each other, but for a few darker regions.
    pub(crate) fn noise(size: [u32; 2]) -> Self {
        Paint::new(size, |x, y| {
            let h = spread(u64::from(x) * 7919 + u64::from(y) * 104_729 + 1);
            let g = spread(u64::from(x / 16) * 31 + u64::from(y / 16) * 17 + 5);
            let one = |k: f64| ((h * k).fract() * (40.0 + 215.0 * g)) as u8;
            [one(1.0), one(97.0), one(9973.0), 255]
        })
    }

    fn mips(&self) -> Vec<Cow<'static, [[u8; 4]]>> {
        let mut mips = vec![self.texels.clone()];
        let mut size = self.size;
        while size != [1, 1] {
            let next = size.map(|n| (n / 2).max(1));
            let last = mips.last().unwrap();
            let at =
                |x: u32, y: u32| last[(y.min(size[1] - 1) * size[0] + x.min(size[0] - 1)) as usize];
            let texel = |i: u32| {
                let (x, y) = (2 * (i % next[0]), 2 * (i / next[0]));
                let four = [at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)];
                [0, 1, 2, 3].map(|k| (four.iter().map(|c| u32::from(c[k])).sum::<u32>() / 4) as u8)
            };
            let mip = (0..next[0] * next[1]).map(texel).collect();
            mips.push(mip);
            size = next;
        }
        mips.into_iter().map(Cow::Owned).collect()
    }
}

/// Long waves of colour.
pub(crate) fn smooth(x: u32, y: u32) -> [u8; 4] {
    let (x, y) = (f64::from(x) / 11.0, f64::from(y) / 9.0);
    let wave = |a: f64| (127.0 + 120.0 * a.sin()) as u8;
    [
        wave(x + 0.3 * y),
        wave(y - 0.5 * x),
        wave(x * 0.7 + y * 0.4),
        255,
    ]
}

/// A picture over a mesh, laid out by the vertices' uv.
pub(crate) fn painted(
    mesh: &Mesh,
    paint: &Paint,
    wrap: Wrap,
    uv: impl Fn(u32) -> [f32; 2],
) -> Colours<'static> {
    let shade = |t: &[u32; 3]| Shade::Picture {
        picture: 0,
        uv: t.map(&uv),
    };
    with_shades(paint, wrap, mesh.triangles.iter().map(shade).collect())
}

fn with_shades(paint: &Paint, wrap: Wrap, shades: Vec<Shade>) -> Colours<'static> {
    Colours {
        pictures: vec![Picture {
            size: paint.size,
            mips: paint.mips(),
            wrap: [wrap; 2],
            srgb: true,
            nearest: false,
            factor: [1.0; 4],
            opacity_matters: false,
        }],
        shades,
        opacity_matters: false,
    }
}

/// A picture round a ball by longitude and latitude, repeated along u; triangles on the seam reach over it.
pub(crate) fn globe(mesh: &Mesh, paint: &Paint) -> Colours<'static> {
    let turn = std::f32::consts::TAU;
    let shade = |t: &[u32; 3]| {
        let corners = t.map(|v| glam::Vec3::from(mesh.positions[v as usize]).normalize());
        let first = corners[0].y.atan2(corners[0].x) / turn;
        let uv = corners.map(|p| {
            let u = p.y.atan2(p.x) / turn;
            [u - (u - first).round(), p.z.acos() / turn * 2.0]
        });
        Shade::Picture { picture: 0, uv }
    };
    with_shades(
        paint,
        Wrap::Repeat,
        mesh.triangles.iter().map(shade).collect(),
    )
}

/// Colours of vertices.
pub(crate) fn at_vertices(mesh: &Mesh) -> Colours<'static> {
    let colour = |v: u32| {
        let wave = |k: usize| 0.5 + 0.5 * (mesh.positions[v as usize][k] * 6.0).sin();
        [wave(0), wave(1), wave(2), 1.0]
    };
    Colours {
        shades: mesh
            .triangles
            .iter()
            .map(|t| Shade::Corners(t.map(colour)))
            .collect(),
        ..Colours::default()
    }
}

/// A number in 0..1 for each index.
pub(crate) fn spread(i: u64) -> f64 {
    let mut h = i.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    h = (h ^ (h >> 31)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    (h >> 11) as f64 / (1u64 << 53) as f64
}
