//! Helpers for wgpu descriptors that all passes share.

use std::ops::Range;

use shadow::MapSize;
use wgpu::util::{BufferInitDescriptor, DeviceExt, TextureDataOrder};
use wgpu::{
    BindGroupLayout, BindGroupLayoutEntry, BindingType, BlendState, Buffer, BufferBindingType, BufferUsages,
    ColorTargetState, ColorWrites, PipelineLayout, RenderPipeline, SamplerBindingType, ShaderModule, ShaderStages,
    TextureFormat, TextureSampleType, TextureViewDimension,
};

use crate::{Gpu, RenderError};

pub(crate) const UNIFORM: BindingType = buffer(BufferBindingType::Uniform);
/// A read-only storage buffer.
pub(crate) const STORAGE: BindingType = buffer(BufferBindingType::Storage { read_only: true });
/// A filtered texture.
pub(crate) const COLOR_TEXTURE: BindingType = texture(TextureSampleType::Float { filterable: true });
/// A texture that shaders only load or gather. Depth is bound like this, too: the GL backend cannot load depth
/// textures.
pub(crate) const RAW_TEXTURE: BindingType = texture(TextureSampleType::Float { filterable: false });
/// Layered texture that shaders only load or gather.
pub(crate) const RAW_TEXTURE_LAYERS: BindingType = BindingType::Texture {
    sample_type: TextureSampleType::Float { filterable: false },
    view_dimension: TextureViewDimension::D2Array,
    multisampled: false,
};
pub(crate) const UINT_TEXTURE: BindingType = texture(TextureSampleType::Uint);
pub(crate) const FILTERING: BindingType = BindingType::Sampler(SamplerBindingType::Filtering);
pub(crate) const NON_FILTERING: BindingType = BindingType::Sampler(SamplerBindingType::NonFiltering);

#[derive(Debug)]
pub(crate) struct MapTarget {
    pub size: MapSize,
    /// View of all layers, for reading.
    pub all: wgpu::TextureView,
    /// Views for drawing, one per layer.
    pub layers: Vec<wgpu::TextureView>,
}

/// Depth format of the G-buffer and of shadow maps.
pub(crate) const DEPTH_FORMAT: TextureFormat = TextureFormat::Depth32Float;

const fn buffer(ty: BufferBindingType) -> BindingType {
    BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None }
}

const fn texture(sample_type: TextureSampleType) -> BindingType {
    BindingType::Texture { sample_type, view_dimension: TextureViewDimension::D2, multisampled: false }
}

/// Pipeline that draws with two entry points of one module, without multisampling.
pub(crate) struct DrawPipeline<'a> {
    pub label: &'a str,
    /// `None` derives the layout from the module.
    pub layout: Option<&'a PipelineLayout>,
    pub module: &'a ShaderModule,
    pub vertex: &'a str,
    /// `None` draws depths alone.
    pub fragment: Option<&'a str>,
    /// Values of the overridable constants of the fragment stage.
    pub constants: &'a [(&'a str, f64)],
    pub vertex_buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
    pub cull_mode: Option<wgpu::Face>,
    pub depth_stencil: Option<wgpu::DepthStencilState>,
    pub targets: &'a [Option<ColorTargetState>],
}

impl<'a> DrawPipeline<'a> {
    /// Makes a pipeline of both sides of triangles without vertex buffers, depth test and targets.
    pub fn new(label: &'a str, module: &'a ShaderModule, vertex: &'a str, fragment: Option<&'a str>) -> Self {
        Self {
            label,
            layout: None,
            module,
            vertex,
            fragment,
            constants: &[],
            vertex_buffers: &[],
            cull_mode: None,
            depth_stencil: None,
            targets: &[],
        }
    }
}

impl Gpu {
    /// Creates a buffer with `data`. Returns an error if this device cannot hold it; `what` names the data with its unit.
    pub fn upload<T: bytemuck::Pod>(
        &self,
        what: &'static str,
        data: &[T],
        usage: BufferUsages,
    ) -> Result<Buffer, RenderError> {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let limits = self.device.limits();
        let limit = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size);
        RenderError::check_size(what, bytes.len() as u64, limit)?;
        // An empty scene has buffers, too, because a binding must not be empty.
        let contents = if bytes.is_empty() { &[0; 16] } else { bytes };
        Ok(self.buffer_with(what, contents, usage))
    }

    /// Returns a layout with `bindings[i]` as binding `i`, visible to vertex and fragment shaders.
    pub(crate) fn bind_group_layout(&self, label: &str, bindings: &[BindingType]) -> BindGroupLayout {
        let entries: Vec<_> = (0..)
            .zip(bindings)
            .map(|(binding, &ty)| BindGroupLayoutEntry {
                binding,
                visibility: ShaderStages::VERTEX_FRAGMENT,
                ty,
                count: None,
            })
            .collect();
        self.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries: &entries })
    }

    /// Returns a bind group with `resources[i]` as binding `i`.
    pub(crate) fn bind_group(
        &self,
        label: &str,
        layout: &BindGroupLayout,
        resources: &[wgpu::BindingResource],
    ) -> wgpu::BindGroup {
        let entries: Vec<_> = (0..)
            .zip(resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource: resource.clone() })
            .collect();
        self.device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some(label), layout, entries: &entries })
    }

    pub(crate) fn pipeline_layout(&self, label: &str, groups: &[&BindGroupLayout]) -> PipelineLayout {
        let bind_group_layouts: Vec<_> = groups.iter().map(|&group| Some(group)).collect();
        self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(label),
            bind_group_layouts: &bind_group_layouts,
            immediate_size: 0,
        })
    }

    pub(crate) fn shader_module(&self, label: &str, wgsl: &str) -> ShaderModule {
        #[cfg(feature = "planted-faults")]
        let wgsl = &*self.faulty(wgsl);
        self.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(label),
            source: wgpu::ShaderSource::Wgsl(wgsl.into()),
        })
    }

    /// Returns a pipeline that draws `vs_fullscreen` with `entry_point`, and adds to or replaces the content of each
    /// target.
    pub(crate) fn fullscreen_pipeline(
        &self,
        layout: &PipelineLayout,
        module: &ShaderModule,
        entry_point: &str,
        formats: &[TextureFormat],
        blend: Option<BlendState>,
    ) -> RenderPipeline {
        let target = |&format| Some(ColorTargetState { format, blend, write_mask: ColorWrites::ALL });
        let targets: Vec<_> = formats.iter().map(target).collect();
        self.draw_pipeline(DrawPipeline {
            layout: Some(layout),
            targets: &targets,
            ..DrawPipeline::new(entry_point, module, "vs_fullscreen", Some(entry_point))
        })
    }

    pub(crate) fn draw_pipeline(&self, pipeline: DrawPipeline) -> RenderPipeline {
        let DrawPipeline { module, constants, .. } = pipeline;
        self.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(pipeline.label),
            layout: pipeline.layout,
            vertex: wgpu::VertexState {
                module,
                entry_point: Some(pipeline.vertex),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: pipeline.vertex_buffers,
            },
            primitive: wgpu::PrimitiveState { cull_mode: pipeline.cull_mode, ..Default::default() },
            depth_stencil: pipeline.depth_stencil,
            multisample: wgpu::MultisampleState::default(),
            fragment: pipeline.fragment.map(|entry_point| wgpu::FragmentState {
                module,
                entry_point: Some(entry_point),
                compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
                targets: pipeline.targets,
            }),
            multiview_mask: None,
            cache: None,
        })
    }

    /// Returns a compute pipeline whose layout follows from its module.
    pub(crate) fn compute_pipeline(&self, label: &str, wgsl: &str, entry_point: &str) -> wgpu::ComputePipeline {
        self.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(label),
            layout: None,
            module: &self.shader_module(label, wgsl),
            entry_point: Some(entry_point),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        })
    }

    /// Submits one compute pass of `pipeline` with these bind groups, by their indices, and this number of workgroups.
    pub(crate) fn dispatch(
        &self,
        pipeline: &wgpu::ComputePipeline,
        groups: &[(u32, wgpu::BindGroup)],
        workgroups: u32,
    ) {
        let mut encoder = self.encoder();
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(pipeline);
        for (index, group) in groups {
            pass.set_bind_group(*index, group, &[]);
        }
        pass.dispatch_workgroups(workgroups, 1, 1);
        drop(pass);
        self.queue.submit([encoder.finish()]);
    }

    /// Returns a buffer that holds `data`.
    pub(crate) fn buffer_with<T: bytemuck::Pod>(&self, label: &str, data: &[T], usage: BufferUsages) -> Buffer {
        let contents = bytemuck::cast_slice(data);
        self.device.create_buffer_init(&BufferInitDescriptor { label: Some(label), contents, usage })
    }

    /// Returns a uniform buffer that holds `data`.
    pub(crate) fn uniform_with<T: bytemuck::Pod>(&self, label: &str, data: &T) -> Buffer {
        self.buffer_with(label, std::slice::from_ref(data), BufferUsages::UNIFORM)
    }

    /// Returns a view of all of a texture with its mip levels, which are in `bytes` one after another.
    pub(crate) fn texture_with(
        &self,
        label: &str,
        [width, height]: [u32; 2],
        (format, mip_level_count): (TextureFormat, u32),
        bytes: &[u8],
    ) -> wgpu::TextureView {
        let texture = self.device.create_texture_with_data(
            &self.queue,
            &wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            },
            TextureDataOrder::MipMajor,
            bytes,
        );
        whole_view(&texture)
    }

    /// Returns an uninitialized uniform buffer for a `T`.
    pub(crate) fn uniform_buffer<T>(&self, label: &str) -> Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: size_of::<T>() as u64,
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    }

    /// Returns a texture to draw to, and then to read in shaders or copy.
    pub(crate) fn target(&self, label: &str, width: u32, height: u32, format: TextureFormat) -> wgpu::Texture {
        self.layered_target(label, wgpu::Extent3d { width, height, depth_or_array_layers: 1 }, format)
    }

    /// Creates the texture of a shadow map, with one view of all layers for reading, and a view of each layer for
    /// drawing.
    pub(crate) fn map_target(&self, label: &str, size: MapSize) -> MapTarget {
        let extent = wgpu::Extent3d { width: size.side, height: size.side, depth_or_array_layers: size.layers };
        let texture = self.layered_target(label, extent, DEPTH_FORMAT);
        let view = |dimension, base_array_layer, count| {
            texture.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(dimension),
                base_array_layer,
                array_layer_count: Some(count),
                ..Default::default()
            })
        };
        MapTarget {
            size,
            all: view(TextureViewDimension::D2Array, 0, size.layers),
            layers: (0..size.layers).map(|layer| view(TextureViewDimension::D2, layer, 1)).collect(),
        }
    }

    fn layered_target(&self, label: &str, size: wgpu::Extent3d, format: TextureFormat) -> wgpu::Texture {
        self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        })
    }
}

/// Cuts the index ranges of draws into about `parts` parts of equal numbers of triangles, between which work can yield.
/// Each piece has true if a part ends with it.
pub(crate) fn cut_into_parts<T: Copy>(
    draws: impl Iterator<Item = (T, Range<u32>)> + Clone,
    parts: u32,
) -> Vec<(T, Range<u32>, bool)> {
    let index_count: u32 = draws.clone().map(|(_, indices)| indices.end - indices.start).sum();
    let most = if parts == 1 { u32::MAX } else { 3 * (index_count / 3 / parts).max(1) };
    let (mut pieces, mut left) = (Vec::new(), most);
    for (draw, mut indices) in draws {
        while !indices.is_empty() {
            let end = indices.end.min(indices.start.saturating_add(left));
            left -= end - indices.start;
            pieces.push((draw, indices.start..end, left == 0));
            indices.start = end;
            if left == 0 {
                left = most;
            }
        }
    }
    pieces
}

/// Returns the buffers as bindings, each as a whole.
pub(crate) fn entire<'a>(buffers: &[&'a Buffer]) -> Vec<wgpu::BindingResource<'a>> {
    buffers.iter().map(|buffer| buffer.as_entire_binding()).collect()
}

pub(crate) fn whole_view(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// Returns the depth test with reversed z: nearer points have greater depths.
pub(crate) fn reversed_depth_test() -> wgpu::DepthStencilState {
    depth_test(wgpu::CompareFunction::Greater)
}

/// Returns the depth test of bent shadow maps, whose depth increases along the light.
pub(crate) fn least_depth_test() -> wgpu::DepthStencilState {
    depth_test(wgpu::CompareFunction::Less)
}

pub(crate) fn depth_test(passes: wgpu::CompareFunction) -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format: DEPTH_FORMAT,
        depth_write_enabled: Some(true),
        depth_compare: Some(passes),
        stencil: wgpu::StencilState::default(),
        bias: wgpu::DepthBiasState::default(),
    }
}

/// Depth of an infinite distance with reversed z.
pub(crate) const INFINITELY_FAR: f32 = 0.0;
/// Depth of the end of a light in its bent map.
pub(crate) const END_OF_LIGHT: f32 = 1.0;

/// Returns a depth attachment that is cleared to a depth, or loaded.
pub(crate) fn depth_attachment(
    view: &wgpu::TextureView,
    clear_to: Option<f32>,
) -> wgpu::RenderPassDepthStencilAttachment<'_> {
    let load = clear_to.map_or(wgpu::LoadOp::Load, wgpu::LoadOp::Clear);
    wgpu::RenderPassDepthStencilAttachment {
        view,
        depth_ops: Some(wgpu::Operations { load, store: wgpu::StoreOp::Store }),
        stencil_ops: None,
    }
}

/// Returns a color attachment that is cleared to zero, or loaded.
pub(crate) fn color_attachment(view: &wgpu::TextureView, clear: bool) -> wgpu::RenderPassColorAttachment<'_> {
    let load = if clear { wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT) } else { wgpu::LoadOp::Load };
    let ops = wgpu::Operations { load, store: wgpu::StoreOp::Store };
    wgpu::RenderPassColorAttachment { view, depth_slice: None, resolve_target: None, ops }
}

/// Returns the vertex buffers: positions alone, and the other attributes.
pub(crate) fn vertex_buffers() -> [Option<wgpu::VertexBufferLayout<'static>>; 2] {
    const POSITION: &[wgpu::VertexAttribute] = &wgpu::vertex_attr_array![0 => Float32x3];
    const REST: &[wgpu::VertexAttribute] = &wgpu::vertex_attr_array![1 => Float32x3, 2 => Float32x2, 3 => Float32x4];
    [(12, POSITION), (size_of::<crate::frame::geometry::Attributes>() as u64, REST)].map(
        |(array_stride, attributes)| {
            Some(wgpu::VertexBufferLayout { array_stride, step_mode: wgpu::VertexStepMode::Vertex, attributes })
        },
    )
}
