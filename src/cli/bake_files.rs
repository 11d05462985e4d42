//! The files that a bake leaves: textures, masks, and the surface with what its material can have of them.

use std::path::PathBuf;

use super::bake_report::{MeshReport, Report, TextureReport};
use super::plain;
use invertex::Result;
use invertex::attribute::Attribute;
use invertex::output::{
    TexturePlace, TexturedMesh, encode_exr, encode_glb, encode_png, write_bytes,
};
use invertex::recover::{BakeAttribute, Baked};

/// Where files go, and in which formats.
pub(super) struct Files {
    pub(super) folder: PathBuf,
    /// Texels along a side.
    pub(super) size: u32,
    /// Whether linear floats are written beside 8 bits.
    pub(super) floats: bool,
}

/// A baked mesh, what it is called, and where it stands.
pub(super) struct Finished {
    pub(super) name: String,
    /// Begins the names of its files.
    pub(super) stem: String,
    pub(super) baked: Baked,
    pub(super) places: Vec<[[f32; 4]; 4]>,
}

/// The first texture, as PNG, for each place of a material.
pub(super) type Textures = Vec<(TexturePlace, Vec<u8>)>;

/// Stems for names, the number appended where two are alike.
pub(super) fn stems<'a>(names: impl Iterator<Item = (usize, &'a str)>) -> Vec<String> {
    let all: Vec<(usize, &str)> = names.collect();
    let alike = |name: &str| all.iter().filter(|(_, other)| *other == name).count();
    let stem = |(number, name): &(usize, &str)| match alike(name) {
        1 => plain(name),
        _ => format!("{}_{number}", plain(name)),
    };
    all.iter().map(stem).collect()
}

impl Files {
    /// Textures and mask of a mesh; what its material can have of them.
    pub(super) fn write_mesh(&self, mesh: &Finished, report: &mut Report) -> Result<Textures> {
        let (size, stem) = (self.size, &mesh.stem);
        let mut textures = Textures::new();
        for texture in &mesh.baked.textures {
            let attribute = texture.attribute.to_string();
            let stem = format!("{stem}_{}", plain(&attribute));
            let png = encode_png(size, size, &texture.rgba8)?;
            let free = |place: &TexturePlace| !textures.iter().any(|(p, _)| p == place);
            if let Some(place) = place(&texture.attribute).filter(free) {
                textures.push((place, png.clone()));
            }
            let mut files = vec![(format!("{stem}.png"), png)];
            if self.floats {
                let exr = encode_exr(size, size, &texture.values, None)?;
                files.push((format!("{stem}.exr"), exr));
            }
            for (file, bytes) in files {
                let path = self.folder.join(file);
                write_bytes(&path, &bytes)?;
                report
                    .textures
                    .push(TextureReport::new(&mesh.name, &attribute, &path, &bytes));
            }
        }
        let shade = |&m: &u8| [m, m, m, 255];
        let mask: Vec<u8> = mesh.baked.mask.iter().flat_map(shade).collect();
        report.file(
            &self.folder.join(format!("{stem}_mask.png")),
            &encode_png(size, size, &mask)?,
        )?;
        let triangles = mesh.baked.low.as_ref().map(|low| low.triangles.len());
        report.mesh(MeshReport::new(&mesh.name, triangles, &mesh.baked, size));
        Ok(textures)
    }

    /// The surfaces with their textures; the file's bytes.
    pub(super) fn write_glb(
        &self,
        all: &[Finished],
        textures: &[Textures],
        report: &mut Report,
    ) -> Result<Vec<u8>> {
        let mut meshes = Vec::new();
        for (mesh, textures) in all.iter().zip(textures) {
            let textures = textures.iter().map(|(place, png)| (*place, png.as_slice()));
            meshes.extend(mesh.baked.low.as_ref().map(|low| TexturedMesh {
                mesh: low,
                textures: textures.collect(),
                places: mesh.places.clone(),
            }));
        }
        let bytes = encode_glb(&meshes)?;
        report.file(&self.folder.join("baked.glb"), &bytes)?;
        Ok(bytes)
    }
}

/// Where a material has room for an attribute.
fn place(attribute: &BakeAttribute) -> Option<TexturePlace> {
    match attribute {
        BakeAttribute::Normal => Some(TexturePlace::Normal),
        BakeAttribute::ObjectNormal
        | BakeAttribute::Position
        | BakeAttribute::Height
        | BakeAttribute::Mapping => None,
        BakeAttribute::Shown(shown) => match shown.to_string().as_str() {
            "metallic-roughness" => Some(TexturePlace::MetallicRoughness),
            "occlusion" | "occlusion-map" => Some(TexturePlace::Occlusion),
            "emissive" => Some(TexturePlace::Emissive),
            _ => Some(shown)
                .filter(|s: &&Attribute| !s.is_data())
                .map(|_| TexturePlace::BaseColor),
        },
    }
}
