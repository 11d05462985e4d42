//! The files that a bake leaves: textures, masks, and the surface with what its material can have of them.

use std::path::PathBuf;
use std::time::Instant;

use super::bake_report::{MeshReport, Report, TextureReport};
use super::plain;
use invertex::Result;
use invertex::attribute::Attribute;
use invertex::mesh::Mesh;
use invertex::output::{
    TexturePlace, TexturedMesh, encode_exr, encode_exr_half, encode_exr_mapping, encode_glb,
    encode_grey, encode_texture, encode_texture16, make_folder, write_bytes,
};
use invertex::recover::{BakeAttribute, Baked, BakedTexture};

/// Where files go, and in which formats.
pub(super) struct Files {
    pub(super) folder: PathBuf,
    /// Texels along a side.
    pub(super) size: u32,
    /// Bits of a channel of PNG: 8 or 16.
    pub(super) bits: u8,
    /// Whether linear floats are written beside it, of how many bits: 16 or 32.
    pub(super) floats: Option<u8>,
}

/// A mesh that is baked for: what it is called, and where it stands.
pub(super) struct Target {
    pub(super) name: String,
    /// Begins the names of its files.
    pub(super) stem: String,
    /// The UDIM number of its tile, where its mesh has several.
    pub(super) tile: Option<u32>,
    pub(super) places: Vec<[[f32; 4]; 4]>,
}

/// What its surface takes along.
pub(super) struct Finished {
    pub(super) target: Target,
    /// None over the primary.
    pub(super) low: Option<Mesh>,
    /// The first texture, as PNG of 8 bits, for each place of a material.
    pub(super) textures: Vec<(TexturePlace, Vec<u8>)>,
}

/// Stems for the names of numbered meshes, the number appended where several meshes have one name.
pub(super) fn stems<'a>(names: impl Iterator<Item = (usize, &'a str)>) -> Vec<String> {
    let all: Vec<(usize, &str)> = names.collect();
    let stem = |(number, name): &(usize, &str)| {
        let other = |(n, other): &(usize, &str)| other == name && n != number;
        match all.iter().any(other) {
            false => plain(name),
            true => format!("{}_{number}", plain(name)),
        }
    };
    all.iter().map(stem).collect()
}

impl Target {
    /// The name of one of its files.
    fn file(&self, what: &str, ending: &str) -> String {
        let tile = self.tile.map_or(String::new(), |tile| format!(".{tile}"));
        format!("{}_{what}{tile}.{ending}", self.stem)
    }
}

impl Files {
    /// Bakes a mesh by `bake`, which hands textures over, and writes each as soon as it is finished: what comes later can
    /// lose none of them.
    pub(super) fn bake(
        &self,
        target: Target,
        report: &mut Report,
        bake: impl FnOnce(&mut dyn FnMut(BakedTexture) -> Result<()>) -> Result<Baked>,
    ) -> Result<Finished> {
        let mut textures = Vec::new();
        let baked = bake(&mut |texture| {
            let start = Instant::now();
            let attribute = texture.attribute.clone();
            let png = self.write(&target, &texture, report)?;
            let taken = |place: &TexturePlace| textures.iter().any(|(p, _)| p == place);
            if let Some(place) = place(&attribute).filter(|place| !taken(place)) {
                let eight = match self.bits {
                    8 => png,
                    _ => encode_texture(self.size, self.size, &texture.rgba8())?,
                };
                textures.push((place, eight));
            }
            report.writing += start.elapsed();
            Ok(())
        })?;
        self.write_mask(&target, &baked.mask, report)?;
        report.mesh(MeshReport::new(
            (&target.name, target.tile),
            &baked,
            self.size,
        ));
        let mut low = baked.low;
        if let (Some(low), Some(tile)) = (&mut low, target.tile) {
            low.name = format!("{}.{tile}", low.name);
        }
        Ok(Finished {
            target,
            low,
            textures,
        })
    }

    /// The files of a texture; the bytes of its PNG.
    fn write(
        &self,
        target: &Target,
        texture: &BakedTexture,
        report: &mut Report,
    ) -> Result<Vec<u8>> {
        make_folder(&self.folder)?;
        let side = self.size;
        let attribute = texture.attribute.to_string();
        let mut write = |ending: &str, bytes: &[u8]| {
            let path = self.folder.join(target.file(&plain(&attribute), ending));
            write_bytes(&path, bytes)?;
            let told = TextureReport::new(&target.name, &attribute, &path, bytes);
            report.textures.push(told);
            Ok(())
        };
        let png = match self.bits {
            8 => encode_texture(side, side, &texture.rgba8())?,
            _ => encode_texture16(side, side, &texture.rgba16())?,
        };
        write("png", &png)?;
        let exr = match (self.floats, texture.triangles()) {
            (None, _) => return Ok(png),
            // Numbers and places within triangles are never cut short.
            (_, Some(triangles)) => {
                let rest = |v: &[f32; 4]| match v[0] {
                    x if x < 0.0 => [0.0; 3],
                    _ => [1.0 - v[1] - v[2], v[1], v[2]],
                };
                let b: Vec<[f32; 3]> = texture.values.iter().map(rest).collect();
                encode_exr_mapping(side, side, &triangles, &b)?
            }
            (Some(16), None) => encode_exr_half(side, side, &texture.values)?,
            _ => encode_exr(side, side, &texture.values, None)?,
        };
        write("exr", &exr)?;
        Ok(png)
    }

    fn write_mask(&self, target: &Target, mask: &[u8], report: &mut Report) -> Result<()> {
        let start = Instant::now();
        let path = self.folder.join(target.file("mask", "png"));
        report.file(&path, &encode_grey(self.size, self.size, mask)?)?;
        report.writing += start.elapsed();
        Ok(())
    }

    /// The surfaces with their textures; the file's bytes.
    pub(super) fn write_glb(&self, all: &[Finished], report: &mut Report) -> Result<Vec<u8>> {
        let start = Instant::now();
        let mut meshes = Vec::new();
        for mesh in all {
            let textures = mesh.textures.iter();
            meshes.extend(mesh.low.as_ref().map(|low| {
                TexturedMesh {
                    mesh: low,
                    textures: textures
                        .map(|(place, png)| (*place, png.as_slice()))
                        .collect(),
                    places: mesh.target.places.clone(),
                }
            }));
        }
        let bytes = encode_glb(&meshes)?;
        report.file(&self.folder.join("baked.glb"), &bytes)?;
        report.writing += start.elapsed();
        Ok(bytes)
    }
}

/// Where a material has room for an attribute.
fn place(attribute: &BakeAttribute) -> Option<TexturePlace> {
    match attribute {
        BakeAttribute::Normal => Some(TexturePlace::Normal),
        BakeAttribute::Shown(shown) => match shown.to_string().as_str() {
            "metallic-roughness" => Some(TexturePlace::MetallicRoughness),
            "occlusion" | "occlusion-map" => Some(TexturePlace::Occlusion),
            "emissive" => Some(TexturePlace::Emissive),
            _ => Some(shown)
                .filter(|s: &&Attribute| !s.is_data())
                .map(|_| TexturePlace::BaseColor),
        },
        _ => None,
    }
}
