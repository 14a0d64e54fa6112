//! The graphics device, without a window.

use std::sync::{Arc, Mutex, PoisonError};

use wgpu::{
    Adapter, Backends, CommandEncoder, CommandEncoderDescriptor, Device, DeviceType, ErrorFilter, Features, Limits,
    PollType, Queue,
};

use crate::frame::stages::FrameStage;
use crate::wgpu::driver;
use crate::{Host, RenderError};

/// Features that every pass needs: blending in f32, to add up lights, and the index of a fragment's triangle.
const FEATURES: Features = Features::FLOAT32_BLENDABLE.union(Features::PRIMITIVE_INDEX);
/// Features that are used if present: 16-bit formats for decoded colors, and branches that a software driver takes only
/// if some pixel of a subgroup does.
const OPTIONAL_FEATURES: Features = Features::TEXTURE_FORMAT_16BIT_NORM.union(Features::SUBGROUP);

/// An open graphics device.
#[derive(Debug)]
pub struct Gpu {
    pub(crate) device: Device,
    pub(crate) queue: Queue,
    pub(crate) host: Host,
    /// True if the device is a CPU with a software driver.
    is_cpu: bool,
    adapter_name: String,
    advice: Option<String>,
    driver: String,
    /// Reason for the loss of the device; `None` while it works.
    lost: Arc<Mutex<Option<String>>>,
    /// Deliberate fault for tests: text to replace in every shader, and its replacement.
    #[cfg(feature = "planted-faults")]
    fault: Option<[&'static str; 2]>,
}

impl Gpu {
    /// Opens the best device: Vulkan before GL, a GPU before a CPU.
    pub fn open(host: Host) -> Result<Self, RenderError> {
        Self::on(&choose_adapter()?, host)
    }

    /// Returns the best GPU; `None` if there is none but CPUs with software drivers.
    pub(crate) fn best_adapter() -> Option<Adapter> {
        choose_adapter().ok().filter(|adapter| adapter.get_info().device_type != DeviceType::Cpu)
    }

    /// Opens the device of `adapter`.
    pub(crate) fn on(adapter: &Adapter, host: Host) -> Result<Self, RenderError> {
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("render"),
            required_features: FEATURES | (adapter.features() & OPTIONAL_FEATURES),
            required_limits: limits(&adapter.limits()),
            // Returns freed memory to the system instead of a pool with blocks of 256 MiB.
            memory_hints: wgpu::MemoryHints::MemoryUsage,
            ..Default::default()
        }))
        .map_err(|e| RenderError::NoAdapter(one_line(&e)))?;

        let lost = Arc::new(Mutex::new(None));
        let record = |lost: &Mutex<Option<String>>, why: String| {
            lost.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(why);
        };
        let by_driver = Arc::clone(&lost);
        device.set_device_lost_callback(move |_, why| record(&by_driver, why));
        // Errors inside `with_error_scopes` do not get here. Others leave the device in an unknown state.
        let by_error = Arc::clone(&lost);
        device.on_uncaptured_error(Arc::new(move |e: wgpu::Error| record(&by_error, one_line(&e))));

        let info = adapter.get_info();
        let (adapter_name, advice) = (driver::adapter_name(&info), driver::advice(&info));
        let driver = format!("{} {}", info.driver, info.driver_info).trim().to_owned();
        Ok(Self {
            device,
            queue,
            host,
            is_cpu: info.device_type == DeviceType::Cpu,
            adapter_name,
            advice,
            driver,
            lost,
            #[cfg(feature = "planted-faults")]
            fault: None,
        })
    }

    /// Returns the device with a deliberate fault in its shaders, which tests must detect: `text` is replaced wherever
    /// it occurs in WGSL. Pipelines that were compiled before stay unchanged.
    #[cfg(feature = "planted-faults")]
    #[must_use]
    pub fn with_fault(mut self, text: &'static str, replacement: &'static str) -> Self {
        self.fault = Some([text, replacement]);
        self
    }

    /// Returns WGSL with the deliberate fault, if its text occurs there.
    #[cfg(feature = "planted-faults")]
    pub(crate) fn faulty<'a>(&self, wgsl: &'a str) -> std::borrow::Cow<'a, str> {
        match self.fault {
            Some([text, replacement]) if wgsl.contains(text) => wgsl.replace(text, replacement).into(),
            _ => wgsl.into(),
        }
    }

    /// Returns the name of the device, with the graphics interface and the driver's version.
    pub fn adapter_name(&self) -> &str {
        &self.adapter_name
    }

    /// Returns a sentence of advice if another version of the driver would draw much faster.
    pub fn advice(&self) -> Option<&str> {
        self.advice.as_deref()
    }

    /// Returns the name and version that the driver reports.
    pub fn driver(&self) -> &str {
        &self.driver
    }

    pub(crate) fn has_subgroups(&self) -> bool {
        self.device.features().contains(Features::SUBGROUP)
    }

    /// True if the device is a CPU with a software driver.
    pub(crate) fn is_cpu(&self) -> bool {
        self.is_cpu
    }

    /// Frees the memory of dropped resources that no submitted work uses.
    pub(crate) fn free_dropped_memory(&self) {
        // Polling without waiting cannot fail.
        let _ = self.device.poll(PollType::Poll);
    }

    pub(crate) fn encoder(&self) -> CommandEncoder {
        self.device.create_command_encoder(&CommandEncoderDescriptor::default())
    }

    /// Submits the encoded work, waits for it, and leaves a new encoder.
    pub(crate) fn submit_and_wait(&self, encoder: &mut CommandEncoder) -> Result<(), RenderError> {
        self.queue.submit([std::mem::replace(encoder, self.encoder()).finish()]);
        self.wait()
    }

    /// Ends a stage. While stages are recorded, submits it and waits; otherwise does nothing.
    pub(crate) fn end_stage(&self, encoder: &mut CommandEncoder, stage: FrameStage) -> Result<(), RenderError> {
        if self.host.stages.is_recording() {
            self.submit_and_wait(encoder)?;
            self.host.stages.record_stage(stage);
        }
        Ok(())
    }

    /// Waits for all submitted work.
    pub(crate) fn wait(&self) -> Result<(), RenderError> {
        match self.device.poll(PollType::wait_indefinitely()) {
            Ok(_) => Ok(()),
            Err(why) => Err(RenderError::Gpu(one_line(&why))),
        }
    }

    /// Runs `work` on this thread and returns driver errors as a `RenderError`.
    pub(crate) fn with_error_scopes<T>(&self, work: impl FnOnce() -> Result<T, RenderError>) -> Result<T, RenderError> {
        let scopes = [ErrorFilter::OutOfMemory, ErrorFilter::Internal, ErrorFilter::Validation]
            .map(|filter| self.device.push_error_scope(filter));
        let result = work();
        // Scopes are a stack: the last one pushed is popped first.
        let mut error = None;
        for scope in scopes.into_iter().rev() {
            error = pollster::block_on(scope.pop()).or(error);
        }
        if let Some(why) = self.lost.lock().unwrap_or_else(PoisonError::into_inner).clone() {
            return Err(RenderError::DeviceLost(why));
        }
        error.map_or(result, |e| Err(RenderError::Gpu(one_line(&e))))
    }
}

/// Joins the several lines of a wgpu error, so that it can end a sentence.
fn one_line(error: &dyn std::fmt::Display) -> String {
    error.to_string().split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Returns the best adapter of the first interface that has one. GL counts only if Vulkan has none.
fn choose_adapter() -> Result<Adapter, RenderError> {
    let mut unfit = Vec::new();
    for backends in [Backends::VULKAN, Backends::GL] {
        let mut description = wgpu::InstanceDescriptor::new_without_display_handle();
        description.backends = backends;
        // wgpu validates by itself; Vulkan's validation layer only adds false alarms and time.
        description.flags = wgpu::InstanceFlags::empty();
        let adapters = pollster::block_on(wgpu::Instance::new(description).enumerate_adapters(backends));
        let (fit, rest): (Vec<_>, Vec<_>) =
            adapters.into_iter().partition(|adapter| adapter.features().contains(FEATURES));
        unfit.extend(rest.iter().map(|adapter| adapter.get_info().name));
        if let Some(best) = fit.into_iter().min_by_key(preference) {
            return Ok(best);
        }
    }
    Err(RenderError::NoAdapter(if unfit.is_empty() {
        "there is none".into()
    } else {
        format!("{} cannot add f32 colours or number triangles", unfit.join(", "))
    }))
}

/// Returns the rank of an adapter; the smallest is best.
fn preference(adapter: &Adapter) -> u8 {
    match adapter.get_info().device_type {
        DeviceType::DiscreteGpu => 0,
        DeviceType::IntegratedGpu => 1,
        DeviceType::VirtualGpu => 2,
        DeviceType::Other => 3,
        DeviceType::Cpu => 4,
    }
}

/// Returns WebGPU's default limits as far as the adapter has them, and the adapter's own for sizes.
fn limits(adapter: &Limits) -> Limits {
    Limits {
        max_texture_dimension_2d: adapter.max_texture_dimension_2d,
        max_buffer_size: adapter.max_buffer_size,
        max_storage_buffer_binding_size: adapter.max_storage_buffer_binding_size,
        ..Limits::defaults().or_worse_values_from(adapter)
    }
}
