//! The graphics device, without a window.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use relight::{Workers, YieldPolicy};
use wgpu::{
    Adapter, Backends, CommandEncoder, CommandEncoderDescriptor, Device, DeviceType, ErrorFilter, Features,
    Limits, PollType, Queue,
};

use crate::stages::{FrameStage, StageRecorder};
use crate::{Aov, Backend, MemoryBudget, RenderError, driver};

/// What every pass relies on: lights add up in f32, and a pixel knows its triangle.
const FEATURES: Features = Features::FLOAT32_BLENDABLE.union(Features::PRIMITIVE_INDEX);
/// What is used where the device has it: colours of 16 bits as they are decoded, and branches that a software driver takes only
/// where some pixel of those drawn together does.
const OPTIONAL_FEATURES: Features = Features::TEXTURE_FORMAT_16BIT_NORM.union(Features::SUBGROUP);

/// An open graphics device. Share one in an `Arc`: opening it and compiling for it is slow.
#[derive(Debug)]
pub struct Gpu {
    pub(crate) device: Device,
    pub(crate) queue: Queue,
    pub(crate) memory: MemoryBudget,
    pub(crate) stages: StageRecorder,
    backend: Backend,
    /// Whether the device is the processor itself, by a software driver.
    is_cpu: bool,
    /// When work that may take long gives way to others.
    yielding: YieldPolicy,
    /// Made when the processor first draws something.
    workers: OnceLock<Workers>,
    adapter_name: String,
    advice: Option<String>,
    driver: String,
    /// Why the device is gone, once it is.
    lost: Arc<Mutex<Option<String>>>,
    /// A text of shaders, and what it is replaced by.
    #[cfg(feature = "planted-faults")]
    fault: Option<[&'static str; 2]>,
}

impl Gpu {
    /// Opens the best device: Vulkan before GL, a GPU before a processor.
    pub fn new() -> Result<Self, RenderError> {
        Self::open(MemoryBudget::default(), None)
    }

    /// The same, with what is kept counted against `memory`.
    pub fn with_memory_budget(memory: MemoryBudget) -> Result<Self, RenderError> {
        Self::open(memory, None)
    }

    /// The same, with shadows and lights drawn by `backend`; by what the device is where nobody says.
    pub fn open(memory: MemoryBudget, backend: Option<Backend>) -> Result<Self, RenderError> {
        let adapter = choose_adapter()?;
        let backend = backend.unwrap_or_else(|| Backend::of(&adapter));
        if !backend.works_with(&adapter) {
            let (name, backend) = (driver::adapter_name(&adapter.get_info()), backend.name());
            let why = format!("{name} gives no depths back, which the backend {backend} starts from");
            return Err(RenderError::NoAdapter(why));
        }
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("render"),
            required_features: FEATURES | (adapter.features() & OPTIONAL_FEATURES),
            required_limits: limits(&adapter.limits()),
            // What is dropped is to go back to the system, not to a pool of blocks of 256 MiB.
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
        // Errors inside `checked` never get here; one outside of it leaves the device in an unknown state.
        let by_error = Arc::clone(&lost);
        device.on_uncaptured_error(Arc::new(move |e: wgpu::Error| record(&by_error, one_line(&e))));

        let info = adapter.get_info();
        let (adapter_name, advice) = (driver::adapter_name(&info), driver::advice(&info));
        let driver = format!("{} {}", info.driver, info.driver_info).trim().to_owned();
        let stages = StageRecorder::default();
        let workers = OnceLock::new();
        Ok(Self {
            device,
            queue,
            memory,
            stages,
            backend,
            is_cpu: info.device_type == DeviceType::Cpu,
            yielding: YieldPolicy::default(),
            workers,
            adapter_name,
            advice,
            driver,
            lost,
            #[cfg(feature = "planted-faults")]
            fault: None,
        })
    }

    /// The same device with a fault in its shaders, for tests that have to see it: each `text` in WGSL is replaced. What has
    /// been compiled before keeps it.
    #[cfg(feature = "planted-faults")]
    #[must_use]
    pub fn with_fault(mut self, text: &'static str, replacement: &'static str) -> Self {
        self.fault = Some([text, replacement]);
        self
    }

    /// WGSL with the fault that is planted.
    #[cfg(feature = "planted-faults")]
    pub(crate) fn faulty<'a>(&self, wgsl: &'a str) -> std::borrow::Cow<'a, str> {
        match self.fault {
            Some([text, replacement]) if wgsl.contains(text) => wgsl.replace(text, replacement).into(),
            _ => wgsl.into(),
        }
    }

    /// The same device with work that gives way to others in the middle of a piece that takes long: those others are not to draw
    /// with the same [`crate::Renderer`]. A picture that is cancelled there is a [`RenderError::Cancelled`].
    #[must_use]
    pub fn with_yield_policy(self, yielding: YieldPolicy) -> Self {
        Self { yielding, ..self }
    }

    /// Gives way to others where that is due.
    pub(crate) fn yield_point(&self) -> Result<(), RenderError> {
        Ok(self.yielding.yield_point()?)
    }

    /// Does what takes the processor long while others have their turn.
    pub(crate) fn run_in_background<T: Send>(
        &self,
        work: impl FnOnce() -> T + Send,
    ) -> Result<T, RenderError> {
        Ok(self.yielding.run_in_background(work)?)
    }

    /// Name of the driver's device, and of the interface and the driver's version that it is used by.
    pub fn adapter_name(&self) -> &str {
        &self.adapter_name
    }

    /// What to do, as a sentence, where another version of this driver would draw much faster.
    pub fn advice(&self) -> Option<&str> {
        self.advice.as_deref()
    }

    /// Name and version of the driver, as it says them.
    pub fn driver(&self) -> &str {
        &self.driver
    }

    /// Whether pixels that are drawn together can be asked at once.
    pub(crate) fn has_subgroups(&self) -> bool {
        self.device.features().contains(Features::SUBGROUP)
    }

    /// Whether the device is the processor itself, by a software driver.
    pub(crate) fn is_cpu(&self) -> bool {
        self.is_cpu
    }

    /// Who draws shadows and lights of the beauty.
    pub fn backend(&self) -> Backend {
        self.backend
    }

    /// Who draws those of `aov`: what hangs on no shadow map the device draws in any case.
    pub(crate) fn backend_of(&self, aov: Aov) -> Backend {
        if matches!(aov, Aov::Beauty | Aov::Visibility) { self.backend } else { Backend::Wgpu }
    }

    /// What lights that the processor draws need in memory, where it draws.
    pub(crate) fn if_native<T>(&self, make: impl FnOnce() -> T) -> Option<T> {
        (self.backend == Backend::Native).then(make)
    }

    /// The threads that draw where the processor does.
    pub(crate) fn workers(&self) -> &Workers {
        self.workers.get_or_init(|| Workers::new().with_yield_policy(self.yielding.clone()))
    }

    /// The account of what is kept.
    pub fn memory(&self) -> &MemoryBudget {
        &self.memory
    }

    /// Gives back the memory of what has been dropped and is in no work under way.
    pub(crate) fn free_dropped_memory(&self) {
        // Without waiting there is nothing that could go wrong.
        let _ = self.device.poll(PollType::Poll);
    }

    /// As [`MemoryBudget::make_room`], with the memory given back.
    pub(crate) fn make_room(&self, bytes: u64) -> bool {
        let before = self.memory.total();
        let room = self.memory.make_room(bytes);
        if self.memory.total() < before {
            self.free_dropped_memory();
        }
        room
    }

    pub(crate) fn encoder(&self) -> CommandEncoder {
        self.device.create_command_encoder(&CommandEncoderDescriptor::default())
    }

    /// Submits what has been encoded, waits for it, and leaves a new encoder.
    pub(crate) fn submit_and_wait(&self, encoder: &mut CommandEncoder) -> Result<(), RenderError> {
        self.queue.submit([std::mem::replace(encoder, self.encoder()).finish()]);
        self.wait()
    }

    /// A stage has been encoded: where stages are taken down it is submitted and waited for, else nothing happens.
    pub(crate) fn end_stage(
        &self,
        encoder: &mut CommandEncoder,
        stage: FrameStage,
    ) -> Result<(), RenderError> {
        if self.stages.is_recording() {
            self.submit_and_wait(encoder)?;
            self.stages.record_stage(stage);
        }
        Ok(())
    }

    /// Waits for everything submitted before.
    pub(crate) fn wait(&self) -> Result<(), RenderError> {
        match self.device.poll(PollType::wait_indefinitely()) {
            Ok(_) => Ok(()),
            Err(why) => Err(RenderError::Gpu(one_line(&why))),
        }
    }

    /// Runs `work` on this thread and turns what the driver reports meanwhile into an error.
    pub(crate) fn with_error_scopes<T>(
        &self,
        work: impl FnOnce() -> Result<T, RenderError>,
    ) -> Result<T, RenderError> {
        let scopes = [ErrorFilter::OutOfMemory, ErrorFilter::Internal, ErrorFilter::Validation]
            .map(|filter| self.device.push_error_scope(filter));
        let result = work();
        // Scopes are a stack: the last one pushed is the first to go.
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

/// wgpu explains over several lines; ours is the last part of one sentence.
fn one_line(error: &dyn std::fmt::Display) -> String {
    error.to_string().split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The best adapter of the first interface that has one; GL is only asked where Vulkan has none.
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

/// Smaller is better.
fn preference(adapter: &Adapter) -> u8 {
    match adapter.get_info().device_type {
        DeviceType::DiscreteGpu => 0,
        DeviceType::IntegratedGpu => 1,
        DeviceType::VirtualGpu => 2,
        DeviceType::Other => 3,
        DeviceType::Cpu => 4,
    }
}

/// WebGPU's defaults where the adapter has them, and all it has where size matters.
fn limits(adapter: &Limits) -> Limits {
    Limits {
        max_texture_dimension_2d: adapter.max_texture_dimension_2d,
        max_buffer_size: adapter.max_buffer_size,
        max_storage_buffer_binding_size: adapter.max_storage_buffer_binding_size,
        ..Limits::defaults().or_worse_values_from(adapter)
    }
}
