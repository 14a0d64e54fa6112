//! Readback of textures and buffers to CPU memory.

use wgpu::{Buffer, BufferUsages, BufferView, COPY_BYTES_PER_ROW_ALIGNMENT, CommandEncoder, MapMode, Texture};

use crate::{Gpu, RenderError};

/// Reads back texels of the upper left corner of `texture`, rows from the top without gaps. Waits for all submitted
/// work.
pub(crate) fn read<T: bytemuck::Pod>(
    gpu: &Gpu,
    texture: &Texture,
    [width, height]: [u32; 2],
) -> Result<Vec<T>, RenderError> {
    let extent = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
    let (width, height) = (width as usize, height as usize);
    let row = width * size_of::<T>();
    let padded_row = padded(row);
    let size = (padded_row * height) as u64;
    RenderError::check_size("the picture in bytes", size, gpu.device.limits().max_buffer_size)?;
    let buffer = readback_buffer(gpu, size);
    let mut encoder = gpu.encoder();
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(padded_row as u32), rows_per_image: None };
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        wgpu::TexelCopyBufferInfo { buffer: &buffer, layout },
        extent,
    );
    gpu.queue.submit([encoder.finish()]);
    let bytes = map(gpu, &buffer)?;
    let mut texels = Vec::with_capacity(width * height);
    for padded in bytes.chunks_exact(padded_row) {
        // Mapped memory is aligned to 8 bytes, and so are its rows.
        texels.extend_from_slice(bytemuck::cast_slice(&padded[..row]));
    }
    Ok(texels)
}

/// Returns the bytes from one row of a copied texture to the next.
fn padded(row: usize) -> usize {
    row.next_multiple_of(COPY_BYTES_PER_ROW_ALIGNMENT as usize)
}

fn readback_buffer(gpu: &Gpu, size: u64) -> Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("readback"),
        size,
        usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
        mapped_at_creation: false,
    })
}

/// Reads back `buffer`, which must permit copies. Waits for all submitted work.
pub(crate) fn read_buffer<T: bytemuck::Pod>(gpu: &Gpu, buffer: &Buffer) -> Result<Vec<T>, RenderError> {
    let mut encoder = gpu.encoder();
    let copy = copy_for_readback(gpu, &mut encoder, buffer);
    gpu.queue.submit([encoder.finish()]);
    read_copy(gpu, &copy)
}

/// Copies `buffer`, for [`read_copy`].
pub(crate) fn copy_for_readback(gpu: &Gpu, encoder: &mut CommandEncoder, buffer: &Buffer) -> Buffer {
    let copy = readback_buffer(gpu, buffer.size());
    encoder.copy_buffer_to_buffer(buffer, 0, &copy, 0, buffer.size());
    copy
}

/// Reads back the buffer from [`copy_for_readback`]. Waits for all submitted work.
pub(crate) fn read_copy<T: bytemuck::Pod>(gpu: &Gpu, copy: &Buffer) -> Result<Vec<T>, RenderError> {
    Ok(bytemuck::pod_collect_to_vec(&map(gpu, copy)?))
}

/// Maps a buffer and returns its bytes.
fn map(gpu: &Gpu, buffer: &Buffer) -> Result<BufferView, RenderError> {
    let failed = |why: &dyn std::fmt::Display| RenderError::Gpu(format!("reading results back: {why}"));
    let (sender, receiver) = std::sync::mpsc::sync_channel(1);
    // The receiver lives until the callback has run.
    buffer.map_async(MapMode::Read, .., move |result| sender.send(result).unwrap_or_default());
    gpu.wait()?;
    receiver.recv().map_err(|e| failed(&e))?.map_err(|e| failed(&e))?;
    buffer.get_mapped_range(..).map_err(|e| failed(&e))
}
