//! Reads LoDs: plain meshes of the file, untrusted like the rest.
//!
//! In: what the extension says of a LoD. Out: a [`Lod`] in which every index exists, or an error that names the element.

use super::decode::Reading;
use super::extension::LodExtension;
use super::morph;
use crate::Result;
use crate::lod::Lod;
use crate::param::grid::VERTEX_MAX;

impl Reading<'_> {
    /// The LoD that the extension speaks of.
    pub(super) fn lod(&self, k: usize, extension: &LodExtension) -> Result<Lod> {
        let what = format!("lods[{k}]");
        let mesh = &self.full.document.json["meshes"][extension.mesh];
        let Some([primitive]) = mesh["primitives"].as_array().map(Vec::as_slice) else {
            return Err(self.fault(
                &what,
                format!(
                    "meshes[{}] is not there or not one primitive",
                    extension.mesh
                ),
            ));
        };
        let accessor = |name: &str| {
            primitive["attributes"][name]
                .as_u64()
                .map(|index| index as usize)
        };
        let needed =
            |name: &str| accessor(name).ok_or_else(|| self.fault(&what, format!("has no {name}")));
        let user = || format!("{}.{what}", self.element);
        let Some(indices) = primitive["indices"].as_u64() else {
            return Err(self.fault(&what, "has no indices"));
        };
        let positions = self.reader.floats::<3>(needed("POSITION")?, user)?;
        let normals = self.reader.floats::<3>(needed("NORMAL")?, user)?;
        let t3 = self.reader.floats::<3>(needed("_IGT_T3")?, user)?;
        let corners = self
            .reader
            .unsigned::<1>(indices as usize, user)?
            .into_flattened();
        let (joints, weights) = match accessor("JOINTS_0") {
            Some(joints) => (
                self.joints(&what, joints)?,
                self.reader.floats::<4>(needed("WEIGHTS_0")?, user)?,
            ),
            None => (Vec::new(), Vec::new()),
        };
        let (triangles, []) = corners.as_chunks::<3>() else {
            return Err(self.fault(
                &what,
                format!("{} indices are not whole triangles", corners.len()),
            ));
        };
        let vertices = positions.len();
        if let Some(v) = corners.iter().find(|&&v| v as usize >= vertices) {
            return Err(self.fault(
                &what,
                format!("vertex {v} does not exist ({vertices} vertices)"),
            ));
        }
        if normals.len() != vertices
            || t3.len() != vertices
            || joints.len() != weights.len()
            || (!joints.is_empty() && joints.len() != vertices)
        {
            return Err(self.fault(&what, "has attributes of different lengths"));
        }
        let targets = morph::read(primitive, |index| self.reader.floats::<3>(index, user))?;
        if !morph::fit(&targets, self.mesh().targets.len(), vertices) {
            return Err(self.fault(&what, "has other morph targets than the mesh"));
        }
        if !extension.error.is_finite() {
            return Err(self.fault(&what, "error is not finite"));
        }
        Ok(Lod {
            t3: self.grid_points(&what, &t3)?,
            triangle_layer: self.layers(
                &format!("{what}.layer"),
                extension.layer,
                triangles.len(),
            )?,
            triangles: triangles.to_vec(),
            positions,
            normals,
            joints,
            weights,
            targets,
            error: extension.error,
            bounded: extension.bounded,
            turned: extension.turned,
            reached: extension.reached,
        })
    }

    /// Joints that exist in every skin the mesh is used with.
    fn joints(&self, what: &str, accessor: usize) -> Result<Vec<[u16; 4]>> {
        let joints = self
            .reader
            .unsigned::<4>(accessor, || format!("{}.{what}", self.element))?;
        let skins = self
            .scene
            .nodes
            .iter()
            .filter(|node| node.mesh == Some(self.mesh))
            .filter_map(|node| node.skin);
        let limit = skins
            .map(|skin| self.scene.skins[skin].joints.len())
            .min()
            .unwrap_or(1 << 16)
            .min(1 << 16);
        if let Some(v) = joints
            .iter()
            .position(|j| j.iter().any(|&j| j as usize >= limit))
        {
            return Err(self.fault(
                what,
                format!("vertex {v} names joints {:?} of {limit}", joints[v]),
            ));
        }
        Ok(joints.iter().map(|j| j.map(|j| j as u16)).collect())
    }

    /// Points of the vertex grid: whole numbers of 24 bits.
    fn grid_points(&self, what: &str, t3: &[[f32; 3]]) -> Result<Vec<[i32; 3]>> {
        let inside = |c: &f32| c.fract() == 0.0 && c.abs() <= VERTEX_MAX as f32;
        match t3.iter().position(|p| !p.iter().all(inside)) {
            Some(v) => Err(self.fault(
                what,
                format!("_IGT_T3 of vertex {v} is not on the grid: {:?}", t3[v]),
            )),
            None => Ok(t3.iter().map(|p| p.map(|c| c as i32)).collect()),
        }
    }
}
