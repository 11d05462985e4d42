//! What a scene's mesh shows, as colour deviations are measured on it: base colour as the renderer finds it.
//!
//! In: a scene and one of its meshes (cut open or not). Out: [`Colours`], whose pictures have the mips that the renderer samples; or
//! none, and a reason in words, where colour says nothing: deviations are then bounded by geometry alone.
//!
//! | a material has | its triangles show |
//! |---|---|
//! | a base colour texture | texels times factor; colours of vertices, which would be blended with them, are left out |
//! | none, or no uv for it | colours of vertices times factor |
//! | neither | its factor |

use crate::attribute::{Pixels, append_chain};
use crate::lod::progressive::colour::{Colours, Picture, Shade, Wrap};
use crate::mesh::Mesh;
use crate::scene::{self, AlphaMode, Material, Mipmap, Scene, TextureRef};
use std::borrow::Cow;
use std::collections::HashMap;

/// A mesh's colours; none where only geometry counts. What was found on the way, in words, comes along.
pub fn colours_of(scene: &Scene, mesh: &Mesh) -> (Option<Colours<'static>>, Vec<String>) {
    let mut reading = Reading {
        scene,
        mesh,
        colours: Colours::default(),
        known: HashMap::new(),
        default: Material::default(),
    };
    let geometry_only = |reason: String| {
        let words = format!("mesh \"{}\": {reason}: only geometry counts", mesh.name);
        (None, vec![words])
    };
    for t in 0..mesh.triangles.len() {
        match reading.shade(t) {
            Ok(shade) => reading.colours.shades.push(shade),
            Err(reason) => return geometry_only(reason),
        }
    }
    if reading.is_one_colour() {
        return geometry_only("it is of one colour".into());
    }
    let mut words = Vec::new();
    if !reading.colours.pictures.is_empty() && reading.has_vertex_colours() {
        words.push(format!(
            "mesh \"{}\": colours of vertices that are multiplied with a texture are left out of colour deviations",
            mesh.name
        ));
    }
    (Some(reading.colours), words)
}

struct Reading<'a> {
    scene: &'a Scene,
    mesh: &'a Mesh,
    colours: Colours<'static>,
    /// The pictures of materials.
    known: HashMap<usize, u32>,
    default: Material,
}

impl<'a> Reading<'a> {
    fn material(&self, t: usize) -> (usize, &Material) {
        let m = self
            .mesh
            .triangle_material
            .get(t)
            .map_or(0, |m| *m as usize);
        (m, self.scene.materials.get(m).unwrap_or(&self.default))
    }

    fn shade(&mut self, t: usize) -> Result<Shade, String> {
        let triangle = self.mesh.triangles[t];
        let (m, material) = self.material(t);
        let texture = material.base_color_texture;
        if let Some(texture) = texture
            && let Some(uv) = self.mesh.uv_sets.get(texture.uv_set)
        {
            let rows = texture.transform.rows();
            let at = |v: u32| {
                let [x, y] = uv[v as usize];
                rows.map(|r| r[0] * x + r[1] * y + r[2])
            };
            return Ok(Shade::Picture {
                picture: self.picture(m, &texture)?,
                uv: triangle.map(at),
            });
        }
        let factor = material.base_color;
        self.colours.opacity_matters |= material.alpha != AlphaMode::Opaque;
        let corner = |v: u32| {
            let own = self.mesh.colors.get(v as usize).copied();
            let own = own.unwrap_or([1.0; 4]);
            [0, 1, 2, 3].map(|k| own[k] * factor[k])
        };
        Ok(Shade::Corners(triangle.map(corner)))
    }

    /// The picture of a material.
    fn picture(&mut self, m: usize, texture: &TextureRef) -> Result<u32, String> {
        if let Some(&known) = self.known.get(&m) {
            return Ok(known);
        }
        let (scene, material) = (self.scene, self.scene.materials.get(m));
        let texture = &scene.textures[texture.texture];
        let sampler = scene.sampler_of(texture);
        let (size, mips) = match texture.image {
            Some(image) => mips(scene, image, sampler.mipmap != Mipmap::None)?,
            None => ([1, 1], vec![Cow::Owned(vec![[255; 4]])]),
        };
        let wrap = |w| match w {
            scene::Wrap::Repeat => Wrap::Repeat,
            scene::Wrap::Mirror => Wrap::Mirror,
            scene::Wrap::Clamp => Wrap::Clamp,
        };
        self.colours.pictures.push(Picture {
            size,
            mips,
            wrap: [wrap(sampler.wrap_u), wrap(sampler.wrap_v)],
            srgb: true,
            nearest: !sampler.magnify_linear && !sampler.minify_linear,
            factor: material.map_or([1.0; 4], |m| m.base_color),
            opacity_matters: material.is_some_and(|m| m.alpha != AlphaMode::Opaque),
        });
        let picture = self.colours.pictures.len() as u32 - 1;
        self.known.insert(m, picture);
        Ok(picture)
    }

    fn is_one_colour(&self) -> bool {
        let mut first = None;
        self.colours.shades.iter().all(|shade| match shade {
            Shade::Picture { .. } => false,
            Shade::Corners(corners) => {
                let first = *first.get_or_insert(corners[0]);
                corners.iter().all(|c| *c == first)
            }
        })
    }

    fn has_vertex_colours(&self) -> bool {
        self.mesh.colors.iter().any(|c| *c != [1.0; 4])
    }
}

/// A picture's size and mips: as the renderer makes them.
type Mips = ([u32; 2], Vec<Cow<'static, [[u8; 4]]>>);

fn mips(scene: &Scene, image: usize, all: bool) -> Result<Mips, String> {
    let pixels = scene.images[image]
        .decode()
        .map_err(|e| format!("images[{image}] cannot be read ({e})"))?;
    let (width, height) = pixels.dimensions();
    let mut words = Vec::new();
    let pixels = Pixels {
        width,
        height,
        rgba: pixels.as_raw(),
    };
    let begins = append_chain(&mut words, pixels, true);
    let ends = begins.iter().skip(1).map(|b| *b as usize);
    let ends = ends.chain([words.len()]);
    let mips = begins.iter().zip(ends).map(|(begin, end)| {
        let texels = words[*begin as usize..end].iter();
        Cow::Owned(texels.map(|w| w.to_le_bytes()).collect())
    });
    let count = if all { usize::MAX } else { 1 };
    Ok(([width, height], mips.take(count).collect()))
}
