//! What a binary says about itself. In: SPIR-V with names. Out: an [`Interface`] per pipeline: its stages, descriptor
//! slots, push constants, specialization constants and workgroup.

use crate::source::Source;
use spirq::prelude::*;
use spirq::ty::StructType;

/// The largest workgroup that every device in use has.
const WORKGROUP_MOST: u32 = 256;

/// A pipeline's view of its resources.
pub(crate) struct Interface {
    /// `<stage>_<pass>`.
    pub name: String,
    /// (extension, source path, binary path) of each stage.
    pub stages: Vec<(String, String, String)>,
    /// Sorted by binding.
    pub slots: Vec<Slot>,
    /// The push-constant block and the extensions of the stages that see it.
    pub push: Option<(StructType, Vec<String>)>,
    /// (name, id).
    pub(crate) constants: Vec<(String, u32)>,
    /// Invocations per workgroup; ones for graphics.
    pub workgroup: [u32; 3],
}

/// One descriptor.
pub(crate) struct Slot {
    pub name: String,
    pub binding: u32,
    /// A variant of `gpu::SlotKind`.
    pub kind: &'static str,
    /// The block behind a buffer.
    pub block: Option<StructType>,
    /// Extensions of the stages that use it.
    pub stages: Vec<String>,
}

/// The interface of one binary.
pub(crate) fn stage(source: &Source, binary: &[u8]) -> Result<Interface, String> {
    let entries = ReflectConfig::new()
        .spv(binary)
        .reflect()
        .map_err(|error| error.to_string())?;
    let [entry] = entries.as_slice() else {
        return Err(format!("{} entry points instead of one", entries.len()));
    };
    let mut interface = Interface {
        name: source.name.clone(),
        stages: vec![(
            source.extension.clone(),
            source.path.clone(),
            source.binary_path(),
        )],
        slots: Vec::new(),
        push: None,
        constants: Vec::new(),
        workgroup: workgroup(entry),
    };
    for variable in &entry.vars {
        match variable {
            Variable::Descriptor {
                name,
                desc_bind,
                desc_ty,
                ty,
                nbind,
            } => {
                let name = name.as_deref().filter(|name| !name.is_empty());
                let name =
                    name.ok_or(format!("binding {} has no instance name", desc_bind.bind()))?;
                if desc_bind.set() != 0 || *nbind != 1 {
                    return Err(format!(
                        "{name}: only single descriptors of set 0 are used here"
                    ));
                }
                interface.slots.push(Slot {
                    name: name.to_owned(),
                    binding: desc_bind.bind(),
                    kind: kind(desc_ty).ok_or(format!("{name}: {desc_ty:?} is not used here"))?,
                    block: ty.as_struct().cloned(),
                    stages: vec![source.extension.clone()],
                });
            }
            Variable::PushConstant { ty, .. } => {
                let block = ty.as_struct().ok_or("push constants outside a block")?;
                interface.push = Some((block.clone(), vec![source.extension.clone()]));
            }
            Variable::SpecConstant { name, spec_id, .. } => {
                let name = name
                    .clone()
                    .ok_or(format!("constant {spec_id} has no name"))?;
                interface.constants.push((name, *spec_id));
            }
            Variable::Input { .. } | Variable::Output { .. } => {}
        }
    }
    let invocations: u32 = interface.workgroup.iter().product();
    if invocations > WORKGROUP_MOST {
        return Err(format!(
            "{invocations} invocations in a workgroup; {WORKGROUP_MOST} run everywhere"
        ));
    }
    interface.check_slots()?;
    Ok(interface)
}

/// The most storage buffers that one stage of one pipeline uses: what a device must offer.
pub(crate) fn most_storage_buffers(pipelines: &[Interface]) -> usize {
    let storage = |pipeline: &Interface, extension: &String| {
        let used = pipeline
            .slots
            .iter()
            .filter(|slot| slot.kind == "StorageBuffer");
        used.filter(|slot| slot.stages.contains(extension)).count()
    };
    let counts = pipelines.iter().flat_map(|pipeline| {
        pipeline
            .stages
            .iter()
            .map(move |(extension, ..)| storage(pipeline, extension))
    });
    counts.max().unwrap_or(0)
}

fn kind(ty: &DescriptorType) -> Option<&'static str> {
    match ty {
        DescriptorType::StorageBuffer(_) => Some("StorageBuffer"),
        DescriptorType::UniformBuffer() => Some("UniformBuffer"),
        DescriptorType::StorageImage(_) => Some("StorageImage"),
        DescriptorType::SampledImage() => Some("SampledImage"),
        DescriptorType::Sampler() => Some("Sampler"),
        DescriptorType::CombinedImageSampler() => Some("CombinedImageSampler"),
        _ => None,
    }
}

fn workgroup(entry: &EntryPoint) -> [u32; 3] {
    let mut size = [1; 3];
    for mode in &entry.exec_modes {
        if mode.exec_mode == spirq::spirv::ExecutionMode::LocalSize {
            for (axis, operand) in mode.operands.iter().enumerate().take(3) {
                match operand.value {
                    ConstantValue::U32(value) => size[axis] = value,
                    ConstantValue::S32(value) => size[axis] = value.unsigned_abs(),
                    _ => {}
                }
            }
        }
    }
    size
}

/// Joins each vertex shader with the fragment shader of its name.
pub(crate) fn pair_stages(stages: Vec<Interface>) -> Result<Vec<Interface>, String> {
    let mut pipelines: Vec<Interface> = Vec::new();
    for stage in stages {
        match pipelines
            .iter_mut()
            .find(|pipeline| pipeline.name == stage.name)
        {
            Some(pipeline) => pipeline.join(stage)?,
            None => pipelines.push(stage),
        }
    }
    for pipeline in &pipelines {
        let extensions: Vec<&str> = pipeline
            .stages
            .iter()
            .map(|stage| stage.0.as_str())
            .collect();
        if !matches!(extensions.as_slice(), ["comp"] | ["frag", "vert"]) {
            return Err(format!(
                "{}: has {extensions:?}; a pass is one .comp, or a .vert with its .frag",
                pipeline.name
            ));
        }
    }
    Ok(pipelines)
}

impl Interface {
    fn join(&mut self, other: Interface) -> Result<(), String> {
        self.stages.extend(other.stages);
        for slot in other.slots {
            match self
                .slots
                .iter_mut()
                .find(|present| present.name == slot.name && present.binding == slot.binding)
            {
                Some(present) if present.kind == slot.kind => present.stages.extend(slot.stages),
                _ => self.slots.push(slot),
            }
        }
        self.push = match (self.push.take(), other.push) {
            (Some((a, stages)), Some((b, more))) => {
                if a != b {
                    return Err(format!(
                        "{}: the two stages have different push-constant blocks",
                        self.name
                    ));
                }
                Some((a, [stages, more].concat()))
            }
            (a, b) => a.or(b),
        };
        for constant in other.constants {
            if !self.constants.contains(&constant) {
                self.constants.push(constant);
            }
        }
        self.check_slots()
    }

    /// Sorts the slots; one binding is one name, and one name one binding.
    fn check_slots(&mut self) -> Result<(), String> {
        self.slots.sort_by_key(|slot| slot.binding);
        self.constants.sort();
        for (at, slot) in self.slots.iter().enumerate() {
            if let Some(other) = self.slots[..at]
                .iter()
                .find(|other| other.binding == slot.binding || other.name == slot.name)
            {
                return Err(format!(
                    "{} (binding {}) and {} (binding {}) collide",
                    other.name, other.binding, slot.name, slot.binding
                ));
            }
        }
        Ok(())
    }
}
