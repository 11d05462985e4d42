//! Buffers. In: a name, a size in bytes and what the buffer is for. Out: [`Buffer`], a cheap clone that frees itself.

use super::context::Context;
use super::failure;
use crate::{Error, Result};
use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::Allocation;
use std::sync::Arc;

/// Device memory for shaders or transfers. Clones share it; the last one frees it.
///
/// Work that our own [`Context::run`] submits is over when it returns, so dropping a buffer is always safe there. An
/// embedder who submits on its own keeps what [`Recorder::finish`](super::Recorder::finish) returns until the device is
/// done.
#[derive(Clone)]
pub struct Buffer(Arc<Inner>);

struct Inner {
    context: Context,
    raw: vk::Buffer,
    /// `None` only while dropping.
    allocation: Option<Allocation>,
    bytes: u64,
    name: String,
}

/// What a buffer is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BufferKind {
    /// In device memory, for shaders (storage or uniform), indirect commands and transfers.
    Storage,
    /// In host memory, source of transfers.
    Upload,
    /// In host memory, target of transfers.
    Readback,
}

/// The smallest buffer: an empty slice still needs something to bind.
const LEAST_BYTES: u64 = 16;

impl Context {
    /// A storage buffer of `bytes` with unspecified contents.
    ///
    /// [`Error::Capacity`] beyond the device's `maxStorageBufferRange`; [`Error::OutOfMemory`] when memory runs out.
    pub fn storage(&self, name: &str, bytes: u64) -> Result<Buffer> {
        self.buffer(name, bytes, BufferKind::Storage)
    }

    /// A buffer of any kind. As [`Context::storage`] for that kind; the others are bounded by memory only.
    pub fn buffer(&self, name: &str, bytes: u64, kind: BufferKind) -> Result<Buffer> {
        let limits = &self.info().limits;
        if kind == BufferKind::Storage && bytes > limits.storage_buffer_bytes {
            let what = format!("bytes of storage buffer \"{name}\"");
            return Err(Error::Capacity {
                what,
                need: bytes,
                have: limits.storage_buffer_bytes,
            });
        }
        if bytes > limits.buffer_bytes {
            return Err(failure::out_of_memory("device", name, bytes));
        }
        // Vulkan fills and copies whole words.
        let size = bytes.next_multiple_of(4).max(LEAST_BYTES);
        let info = vk::BufferCreateInfo::default()
            .size(size)
            .usage(usage(kind));
        let device = &self.0.device;
        // SAFETY: the size is positive and within the device's limit.
        let raw = unsafe { device.create_buffer(&info, None) }.map_err(failure::allocating(
            "vkCreateBuffer",
            name,
            bytes,
        ))?;
        // From here on the buffer frees itself when something fails.
        let mut buffer = Inner {
            context: self.clone(),
            raw,
            allocation: None,
            bytes,
            name: name.to_owned(),
        };
        // SAFETY: the buffer was just made.
        let requirements = unsafe { device.get_buffer_memory_requirements(raw) };
        let allocation = self
            .0
            .memory
            .allocate(name, requirements, location(kind), true)?;
        let (memory, offset) = {
            // SAFETY: the memory is only bound, and freed through the allocation.
            (unsafe { allocation.memory() }, allocation.offset())
        };
        buffer.allocation = Some(allocation);
        // SAFETY: the allocation meets the buffer's requirements and is bound to nothing else.
        unsafe { device.bind_buffer_memory(raw, memory, offset) }.map_err(failure::allocating(
            "vkBindBufferMemory",
            name,
            bytes,
        ))?;
        self.0.labels.name(raw, name);
        Ok(Buffer(Arc::new(buffer)))
    }

    /// A buffer in host memory that holds `contents`, to copy from.
    pub(super) fn staging(&self, name: &str, contents: &[u8]) -> Result<Buffer> {
        let mut buffer = self.buffer(name, contents.len() as u64, BufferKind::Upload)?;
        let inner = Arc::get_mut(&mut buffer.0).and_then(|inner| inner.allocation.as_mut());
        let mapped = inner.and_then(Allocation::mapped_slice_mut);
        match mapped {
            Some(mapped) => mapped[..contents.len()].copy_from_slice(contents),
            None => {
                return Err(Error::Vulkan {
                    call: "vkMapMemory",
                    code: "host memory is not mapped".to_owned(),
                });
            }
        }
        Ok(buffer)
    }
}

impl Buffer {
    /// The size that was asked for, in bytes; 0 for one made from an empty slice.
    pub fn bytes(&self) -> u64 {
        self.0.bytes
    }

    /// The name it was made with.
    pub fn name(&self) -> &str {
        &self.0.name
    }

    /// The Vulkan handle, for callers who record their own commands.
    pub fn handle(&self) -> vk::Buffer {
        self.0.raw
    }

    /// What a shader sees, in bytes: whole words, and 16 bytes when empty.
    pub fn bound_bytes(&self) -> u64 {
        self.0.bytes.next_multiple_of(4).max(LEAST_BYTES)
    }

    pub(super) fn context(&self) -> &Context {
        &self.0.context
    }

    /// The contents of a host buffer; `None` for a buffer in device memory.
    pub(super) fn mapped(&self) -> Option<&[u8]> {
        let mapped = self.0.allocation.as_ref()?.mapped_slice()?;
        mapped.get(..self.0.bytes as usize)
    }
}

impl std::fmt::Debug for Buffer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Buffer({:?}, {} bytes)", self.0.name, self.0.bytes)
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        // SAFETY: the device no longer uses the buffer (see `Buffer`), and it is destroyed once.
        unsafe { self.context.0.device.destroy_buffer(self.raw, None) };
        if let Some(allocation) = self.allocation.take() {
            self.context.0.memory.free(allocation);
        }
    }
}

fn usage(kind: BufferKind) -> vk::BufferUsageFlags {
    match kind {
        BufferKind::Storage => {
            vk::BufferUsageFlags::STORAGE_BUFFER
                | vk::BufferUsageFlags::UNIFORM_BUFFER
                | vk::BufferUsageFlags::INDIRECT_BUFFER
                | vk::BufferUsageFlags::TRANSFER_SRC
                | vk::BufferUsageFlags::TRANSFER_DST
        }
        BufferKind::Upload => vk::BufferUsageFlags::TRANSFER_SRC,
        BufferKind::Readback => vk::BufferUsageFlags::TRANSFER_DST,
    }
}

fn location(kind: BufferKind) -> MemoryLocation {
    match kind {
        BufferKind::Storage => MemoryLocation::GpuOnly,
        BufferKind::Upload => MemoryLocation::CpuToGpu,
        BufferKind::Readback => MemoryLocation::GpuToCpu,
    }
}
